//! `umbrage judge`: shadow masks against ray-traced truth.
//!
//! 1. [`measure`]: all numbers of one mask, from the truth of its shot.
//! 2. [`report`]: rows of numbers, and report.json.
//! 3. [`markdown`], [`plots`]: what people look at.
//! 4. [`merge`]: reports of shards become one.

mod markdown;
mod measure;
mod merge;
mod plots;
mod report;

use std::path::Path;

use bevy::{math::UVec2, prelude::*};
use image::ColorType;
use indicatif::ProgressBar;

use super::{
    Failure,
    args::{self, NamedTechnique},
    pass::Pass,
    pictures::{file_name, write_pixels},
    remark, say, shoot,
};
use crate::{
    level::shot::Shot,
    render::{
        capture::Texels,
        light_maps::LightMaps,
        reference::{
            accuracy::Kinds,
            extract::truth_scene,
            pictures::{difference_picture, truth_picture},
        },
    },
};
use measure::ShotTruth;
use report::{Part, Report, Row, Scene, Settings, percent};

/// The passes that judging needs.
const NEEDED: [Pass; 2] = [Pass::Mask, Pass::Depth];

/// Unmatched pixels in percent above which the picture and the rays do not show the same scene.
const MOST_UNMATCHED: f64 = 1.0;

/// Judges all techniques on all shots that the arguments ask for, or merges what shards have found.
pub(super) fn run(assets: Option<&Path>, args: &args::Judge) -> Result<(), Failure> {
    if !args.merge.is_empty() {
        let report = merge::merge(&args.merge)?;
        say(report.table());
        return Ok(());
    }
    let mut shoot = args.shoot.clone();
    for pass in NEEDED {
        if !shoot.passes.contains(&pass) {
            shoot.passes.push(pass);
        }
    }
    let mut judge = shoot::run_judging(assets, &shoot, Judge::new(args))?;
    judge.report.finish(&shoot.out)?;
    say(judge.report.table());
    if judge.report.part != Part::default() {
        merge::merge_if_complete(&shoot.out, judge.report.part)?;
    }
    Ok(())
}

/// Judges takes as they are made.
pub(super) struct Judge {
    report: Report,
    place: usize,
    /// Truth of the shot that is being taken; `None`: not yet known.
    truth: Option<ShotTruth>,
}

/// One technique on one shot, as it stands in a running app.
pub(super) struct Judged<'a> {
    /// The scene's name.
    pub(super) scene: &'a str,
    /// The shot.
    pub(super) shot: &'a Shot,
    /// The technique.
    pub(super) technique: &'a NamedTechnique,
    /// The sun's entity.
    pub(super) sun: Entity,
    /// The camera's entity.
    pub(super) camera: Entity,
    /// The passes of [`NEEDED`] and others.
    pub(super) texels: &'a [(Pass, Texels)],
    /// Texels of all maps that were drawn.
    pub(super) texels_drawn: u64,
}

impl Judge {
    /// Without rows.
    pub(super) fn new(args: &args::Judge) -> Self {
        let shoot = &args.shoot;
        Self {
            report: Report {
                umbrage: env!("CARGO_PKG_VERSION").to_owned(),
                settings: Settings {
                    scenes: shoot.scenes.iter().map(ToString::to_string).collect(),
                    techniques: shoot.techniques.iter().map(|named| named.text.clone()).collect(),
                    size: shoot.size.map(|size| format!("{}x{}", size.width, size.height)),
                    shots: shoot.shot.clone(),
                    shots_file: shoot.shots.as_ref().map(|file| file.display().to_string()),
                    floor: args.floor,
                },
                part: shoot.shard.into(),
                ..Report::default()
            },
            place: 0,
            truth: None,
        }
    }

    /// Forgets the truth of the shot before. `place` counts the shots of all shards.
    pub(super) fn begin_shot(&mut self, place: usize) {
        self.place = place;
        self.truth = None;
    }

    /// Judges one take, and writes the report so far.
    pub(super) fn judge(
        &mut self,
        app: &mut App,
        judged: &Judged,
        out: &Path,
        bar: &ProgressBar,
    ) -> Result<(), Failure> {
        let Judged {
            scene, shot, technique, ..
        } = judged;
        let find = |wanted| {
            let mut texels = judged.texels.iter();
            texels.find(|(pass, _)| *pass == wanted).map(|(_, texels)| texels)
        };
        let (Some(mask), Some(depth)) = (find(Pass::Mask), find(Pass::Depth)) else {
            return Err(Failure::Failed("judging needs the passes mask and depth".to_owned()));
        };
        let size = UVec2::new(mask.width, mask.height);
        let truth = match self.truth.take() {
            Some(truth) => truth,
            None => {
                bar.set_message(format!("{scene} {}: truth", shot.name));
                let truth = truth_scene(app.world_mut(), Some(judged.camera)).map_err(Failure::failed)?;
                let progress = |rows: usize| bar.set_message(format!("{scene} {}: truth {rows}/{}", shot.name, size.y));
                let with_floor = self.report.settings.floor;
                let truth = ShotTruth::new(truth, shot, size, &depth.to_f32(), with_floor, progress);
                let unmatched = percent(Kinds::of(&truth.traced.truth).unmatched, size.x * size.y);
                if unmatched > MOST_UNMATCHED {
                    remark(format!(
                        "{scene}, shot {}: {unmatched:.1} % of the pixels show what the rays do not find; they do not count",
                        shot.name
                    ));
                }
                truth
            }
        };
        if !self.report.scenes.iter().any(|known| known.scene == **scene) {
            self.report.scenes.push(Scene {
                scene: (*scene).to_owned(),
                statistics: truth.scene().statistics(),
            });
        }
        let maps = LightMaps::of(app.world(), judged.sun, judged.camera);
        let row = Row {
            place: self.place,
            scene: (*scene).to_owned(),
            shot: shot.name.clone(),
            technique: technique.text.clone(),
            capped_percent: shoot::virtual_map::report_of(app, judged.camera)
                .and_then(|report| report.fitted)
                .map(|counts| counts.capped_percent()),
            truth: file_name(scene, &shot.name, "truth", "mask"),
            difference: file_name(scene, &shot.name, &technique.text, "difference"),
            ..truth.row(&mask.bytes, &maps, judged.texels_drawn)
        };
        for (name, picture) in [
            (&row.truth, truth_picture(&truth.traced.truth)),
            (&row.difference, difference_picture(&mask.bytes, &truth.traced.truth)),
        ] {
            write_pixels(&out.join(name), size, picture.as_flattened(), ColorType::Rgb8).map_err(Failure::failed)?;
        }
        self.report.rows.push(row);
        self.truth = Some(truth);
        self.report.write(out)
    }
}
