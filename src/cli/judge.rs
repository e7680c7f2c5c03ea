//! `umbrage judge`: shadow masks against ray-traced truth.

use std::{fmt::Write as _, path::Path};

use bevy::{
    math::{DVec3, UVec2},
    prelude::*,
};
use image::ColorType;
use indicatif::ProgressBar;
use serde::Serialize;

use super::{
    Failure,
    args::{NamedTechnique, Shoot},
    pass::Pass,
    pictures, say, shoot,
};
use crate::{
    level::shot::Shot,
    render::{
        capture::Texels,
        reference::{
            accuracy::{self, Accuracy, Counts, LIT_ABOVE},
            extract::truth_scene,
            pixels::{self, PixelRays, PixelTruth},
        },
    },
};

/// The passes that judging needs.
const NEEDED: [Pass; 2] = [Pass::Mask, Pass::Depth];

const FALSE_SHADOW: [u8; 3] = [220, 30, 30];
const FALSE_LIT: [u8; 3] = [255, 160, 0];
const NOT_VALID: [u8; 3] = [40, 50, 90];

/// Judges all techniques on all shots that the arguments ask for.
pub(super) fn run(assets: Option<&Path>, args: &Shoot) -> Result<(), Failure> {
    let mut args = args.clone();
    for pass in NEEDED {
        if !args.passes.contains(&pass) {
            args.passes.push(pass);
        }
    }
    let report = shoot::run_judging(assets, &args)?;
    say(report.table());
    Ok(())
}

/// One technique on one shot.
#[derive(Clone, Debug, Serialize)]
struct Row {
    scene: String,
    shot: String,
    technique: String,
    pixels: u32,
    overall: Errors,
    /// Within three pixels of true shadow edges.
    band: Errors,
    truth: String,
    difference: String,
}

/// Counts with their shares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
struct Errors {
    valid: u32,
    false_shadow: u32,
    false_lit: u32,
    wrong_percent: f64,
    false_shadow_percent: f64,
    false_lit_percent: f64,
}

impl From<Counts> for Errors {
    fn from(counts: Counts) -> Self {
        Self {
            valid: counts.valid,
            false_shadow: counts.false_shadow,
            false_lit: counts.false_lit,
            wrong_percent: 100.0 * counts.wrong_share(),
            false_shadow_percent: 100.0 * counts.share(counts.false_shadow),
            false_lit_percent: 100.0 * counts.share(counts.false_lit),
        }
    }
}

/// What was judged so far.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Report {
    rows: Vec<Row>,
    #[serde(skip)]
    truth: Vec<PixelTruth>,
}

impl Report {
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
        let truth_name = pictures::file_name(scene, &shot.name, "truth", "mask");
        let difference_name = pictures::file_name(scene, &shot.name, &technique.text, "difference");
        for (name, picture) in [
            (&truth_name, truth_picture(&self.truth)),
            (&difference_name, difference_picture(&mask.bytes, &self.truth)),
        ] {
            pictures::write_pixels(&out.join(name), size, &picture, ColorType::Rgb8).map_err(Failure::failed)?;
        }
        let Accuracy { pixels, overall, band } = accuracy::compare(size, &mask.bytes, &self.truth);
        self.rows.push(Row {
            scene: scene.to_owned(),
            shot: shot.name.clone(),
            technique: technique.text.clone(),
            pixels,
            overall: overall.into(),
            band: band.into(),
            truth: truth_name,
            difference: difference_name,
        });
        Ok(())
    }

    /// Writes report.json and report.md.
    pub(super) fn write(&self, out: &Path) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(self).map_err(Failure::failed)?;
        pictures::write_whole(&out.join("report.json"), json.as_bytes()).map_err(Failure::failed)?;
        pictures::write_whole(&out.join("report.md"), self.markdown().as_bytes()).map_err(Failure::failed)
    }

    /// The mean over all shots of each technique in each scene, in the order of their first appearance.
    fn means(&self) -> Vec<(String, String, [f64; 5])> {
        let mut keys: Vec<(String, String)> = Vec::new();
        for row in &self.rows {
            let key = (row.scene.clone(), row.technique.clone());
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
        keys.into_iter()
            .map(|(scene, technique)| {
                let rows: Vec<&Row> = self
                    .rows
                    .iter()
                    .filter(|row| row.scene == scene && row.technique == technique)
                    .collect();
                let mean = |of: &dyn Fn(&Row) -> f64| rows.iter().map(|row| of(row)).sum::<f64>() / rows.len() as f64;
                let numbers = [
                    mean(&|row| row.overall.wrong_percent),
                    mean(&|row| row.overall.false_shadow_percent),
                    mean(&|row| row.overall.false_lit_percent),
                    mean(&|row| row.band.wrong_percent),
                    mean(&|row| 100.0 * f64::from(row.overall.valid) / f64::from(row.pixels.max(1))),
                ];
                (scene, technique, numbers)
            })
            .collect()
    }

    /// For a terminal: means over shots.
    fn table(&self) -> String {
        let mut text = format!(
            "{:<12} {:<34} {:>8} {:>13} {:>10} {:>10} {:>8}",
            "scene", "technique", "wrong %", "false shadow", "false lit", "in band", "valid %"
        );
        for (scene, technique, [wrong, shadow, lit, band, valid]) in self.means() {
            let _ = write!(
                text,
                "\n{scene:<12} {technique:<34} {wrong:>8.3} {shadow:>13.3} {lit:>10.3} {band:>10.2} {valid:>8.1}"
            );
        }
        text
    }

    fn markdown(&self) -> String {
        let mut text = String::from(
            "# Shadow masks against ray-traced truth\n\nShares of valid pixels in percent, means over shots. False shadow \
             is red in the pictures, false lit orange, pixels that do not count blue: sky, surfaces that face away from the \
             light or nearly (N·L at most 0.15), edges of surfaces with their neighbours, and places where truth itself \
             changes within two millimetres.\n\n\
             | scene | technique | wrong | false shadow | false lit | wrong in the edge band | valid pixels |\n\
             |---|---|---|---|---|---|---|\n",
        );
        for (scene, technique, [wrong, shadow, lit, band, valid]) in self.means() {
            let _ = writeln!(
                text,
                "| {scene} | `{technique}` | {wrong:.3} | {shadow:.3} | {lit:.3} | {band:.2} | {valid:.1} |"
            );
        }
        for row in &self.rows {
            let _ = write!(
                text,
                "\n## {} {}, `{}`: {:.3} % wrong\n\n![truth]({}) ![difference]({})\n",
                row.scene, row.shot, row.technique, row.overall.wrong_percent, row.truth, row.difference
            );
        }
        text
    }
}

/// The rays of a shot's camera.
fn rays(shot: &Shot, size: UVec2) -> PixelRays {
    let camera = shot.camera();
    let axis = |axis: Dir3| -> DVec3 { axis.as_dvec3().normalize() };
    PixelRays {
        size,
        eye: camera.translation.as_dvec3(),
        right: axis(camera.right()),
        up: axis(camera.up()),
        forward: axis(camera.forward()),
        tan_half_fov_y: (f64::from(shot.fov_y_deg).to_radians() / 2.0).tan(),
    }
}

fn truth_picture(truth: &[PixelTruth]) -> Vec<u8> {
    let color = |pixel: &PixelTruth| match pixel {
        PixelTruth::Lit => [255; 3],
        PixelTruth::Shadow => [0; 3],
        _ => NOT_VALID,
    };
    truth.iter().flat_map(color).collect()
}

fn difference_picture(mask: &[u8], truth: &[PixelTruth]) -> Vec<u8> {
    let color = |(value, pixel): (&u8, &PixelTruth)| match (pixel, *value > LIT_ABOVE) {
        (PixelTruth::Lit, false) => FALSE_SHADOW,
        (PixelTruth::Shadow, true) => FALSE_LIT,
        (PixelTruth::Lit, true) => [200; 3],
        (PixelTruth::Shadow, false) => [60; 3],
        _ => NOT_VALID,
    };
    mask.iter().zip(truth).flat_map(color).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(technique: &str, shot: &str, wrong: u32) -> Row {
        let counts = Counts {
            valid: 200,
            false_shadow: wrong,
            false_lit: 0,
        };
        Row {
            scene: "forest".to_owned(),
            shot: shot.to_owned(),
            technique: technique.to_owned(),
            pixels: 400,
            overall: counts.into(),
            band: Counts::default().into(),
            truth: "t.png".to_owned(),
            difference: "d.png".to_owned(),
        }
    }

    #[test]
    fn tables_hold_means_over_shots() {
        let report = Report {
            rows: vec![row("bevy", "a", 2), row("lispsm", "a", 0), row("bevy", "b", 4)],
            truth: Vec::new(),
        };
        let means = report.means();
        assert_eq!(means.len(), 2);
        assert_eq!((means[0].1.as_str(), means[0].2), ("bevy", [1.5, 1.5, 0.0, 0.0, 50.0]));
        assert_eq!(means[1].2[0], 0.0);
        assert_eq!(report.table().lines().count(), 3);
        assert!(
            report
                .markdown()
                .contains("| forest | `bevy` | 1.500 | 1.500 | 0.000 | 0.00 | 50.0 |")
        );
    }

    #[test]
    fn differences_have_their_colors() {
        use PixelTruth::{Edge, Lit, Shadow};
        let picture = difference_picture(&[0, 255, 255, 0, 0], &[Lit, Shadow, Lit, Shadow, Edge]);
        let (colors, _) = picture.as_chunks::<3>();
        assert_eq!(colors, [FALSE_SHADOW, FALSE_LIT, [200; 3], [60; 3], NOT_VALID]);
    }
}
