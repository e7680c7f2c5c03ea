//! `umbrage judge`: shadow masks against ray-traced truth.

mod markdown;
mod pictures;
mod report;

use std::path::Path;

use bevy::{math::UVec2, prelude::*};
use image::ColorType;
use indicatif::ProgressBar;

use super::{
    Failure,
    args::{NamedTechnique, Shoot},
    pass::Pass,
    pictures::{file_name, write_pixels},
    say, shoot,
};
use crate::{
    level::shot::Shot,
    render::{
        capture::Texels,
        reference::{
            accuracy::{self, Accuracy},
            extract::truth_scene,
            pixels::{self, PixelRays, PixelTruth},
        },
    },
};
use report::{Report, Row};

/// The passes that judging needs.
const NEEDED: [Pass; 2] = [Pass::Mask, Pass::Depth];

/// Judges all techniques on all shots that the arguments ask for.
pub(super) fn run(assets: Option<&Path>, args: &Shoot) -> Result<(), Failure> {
    let mut args = args.clone();
    for pass in NEEDED {
        if !args.passes.contains(&pass) {
            args.passes.push(pass);
        }
    }
    let judge = shoot::run_judging(assets, &args)?;
    say(judge.report.table());
    Ok(())
}

/// Judges takes as they are made.
#[derive(Default)]
pub(super) struct Judge {
    report: Report,
    /// Truth of the shot that is being taken; empty: not yet known.
    truth: Vec<PixelTruth>,
}

impl Judge {
    /// Forgets the truth of the shot before.
    pub(super) fn begin_shot(&mut self) {
        self.truth.clear();
    }

    /// Judges one take: the passes are those of [`NEEDED`] and others.
    pub(super) fn judge(
        &mut self,
        app: &mut App,
        take: (&str, &Shot, &NamedTechnique),
        texels: &[(Pass, Texels)],
        out: &Path,
        bar: &ProgressBar,
    ) -> Result<(), Failure> {
        let (scene, shot, technique) = take;
        let find = |wanted| {
            texels
                .iter()
                .find(|(pass, _)| *pass == wanted)
                .map(|(_, texels)| texels)
        };
        let (Some(mask), Some(depth)) = (find(Pass::Mask), find(Pass::Depth)) else {
            return Err(Failure::Failed("judging needs the passes mask and depth".to_owned()));
        };
        let size = UVec2::new(mask.width, mask.height);
        if self.truth.is_empty() {
            bar.set_message(format!("{scene} {}: truth", shot.name));
            let truth = truth_scene(app.world_mut()).map_err(Failure::failed)?;
            let to_light = -Vec3::from(shot.light_dir).as_dvec3();
            let progress = |rows: usize| bar.set_message(format!("{scene} {}: truth {rows}/{}", shot.name, size.y));
            let far = f64::from(shot.far);
            self.truth = pixels::trace(&truth, &rays(shot, size), &depth.to_f32(), far, to_light, progress);
        }
        let truth_name = file_name(scene, &shot.name, "truth", "mask");
        let difference_name = file_name(scene, &shot.name, &technique.text, "difference");
        for (name, picture) in [
            (&truth_name, pictures::truth(&self.truth)),
            (&difference_name, pictures::difference(&mask.bytes, &self.truth)),
        ] {
            write_pixels(&out.join(name), size, &picture, ColorType::Rgb8).map_err(Failure::failed)?;
        }
        let Accuracy { pixels, overall, band } = accuracy::compare(size, &mask.bytes, &self.truth);
        self.report.rows.push(Row {
            scene: scene.to_owned(),
            shot: shot.name.clone(),
            technique: technique.text.clone(),
            pixels,
            overall: overall.into(),
            band: band.into(),
            truth: truth_name,
            difference: difference_name,
        });
        self.report.write(out)
    }
}

/// The rays of a shot's camera.
pub(super) fn rays(shot: &Shot, size: UVec2) -> PixelRays {
    PixelRays::of_camera(size, &shot.camera(), f64::from(shot.fov_y_deg).to_radians())
}
