//! [`Report`]: what judging found, as report.json has it.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::plots;
use crate::{
    cli::{Failure, pictures, shots::Shard},
    render::reference::{
        accuracy::{Counts, Kinds},
        sampling::Quantiles,
        scene::SceneStatistics,
    },
};

/// What was judged so far. Shares are in percent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Report {
    /// Version of Umbrage.
    pub(super) umbrage: String,
    /// What was asked for: parts of one report agree in it.
    pub(super) settings: Settings,
    /// Which part of the shots this is.
    pub(super) part: Part,
    /// Whether all shots of the part are in it.
    pub(super) is_complete: bool,
    pub(super) scenes: Vec<Scene>,
    pub(super) rows: Vec<Row>,
}

/// What was asked for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Settings {
    pub(super) scenes: Vec<String>,
    pub(super) techniques: Vec<String>,
    /// `WxH`; absent: the shots' own.
    pub(super) size: Option<String>,
    /// Names of the shots asked for; empty: all.
    pub(super) shots: Vec<String>,
    /// The file of shots.
    pub(super) shots_file: Option<String>,
    pub(super) floor: bool,
}

/// One of several parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Part {
    /// From 1.
    pub(super) index: usize,
    /// How many there are.
    pub(super) count: usize,
}

impl Default for Part {
    fn default() -> Self {
        Shard::ALL.into()
    }
}

impl From<Shard> for Part {
    fn from(Shard { index, count }: Shard) -> Self {
        Self { index, count }
    }
}

/// One scene with what is in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Scene {
    pub(super) scene: String,
    #[serde(flatten)]
    pub(super) statistics: SceneStatistics,
}

/// One technique on one shot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    /// Place of the shot among all shots of the whole report, from 0.
    pub(super) place: usize,
    pub(super) scene: String,
    pub(super) shot: String,
    pub(super) technique: String,
    pub(super) pixels: u32,
    /// Pixels of every kind; only `lit` and `shadow` are valid.
    pub(super) kinds: Kinds,
    pub(super) overall: Errors,
    /// Within three pixels of true shadow edges.
    pub(super) band: Errors,
    /// Absent where no valid pixel has a map.
    pub(super) texel_pixel: Option<TexelPixel>,
    /// Pixels that need more than the finest tiles of a fitted map; absent for other maps.
    pub(super) capped_percent: Option<f64>,
    pub(super) texels: Texels,
    pub(super) confirmation: Confirmation,
    /// What perfectly spread texels would get wrong; empty unless asked for.
    pub(super) floor: Vec<Floor>,
    /// Errors by view depth.
    pub(super) distances: Vec<Distance>,
    pub(super) truth: String,
    pub(super) difference: String,
}

/// Counts with their shares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Errors {
    pub(super) valid: u32,
    pub(super) false_shadow: u32,
    pub(super) false_lit: u32,
    pub(super) wrong_percent: f64,
    pub(super) false_shadow_percent: f64,
    pub(super) false_lit_percent: f64,
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

/// Texel ÷ pixel of the valid pixels; ratios of lengths, see [`sampling`](crate::render::reference::sampling).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct TexelPixel {
    /// Valid pixels with a map.
    pub(super) pixels: u32,
    /// Valid pixels that are lit without looking into a map.
    pub(super) without_map: u32,
    /// The root of texel area ÷ pixel area, the product of both parts below.
    pub(super) mean_size: Quantiles,
    /// The longest extent of a texel in pixels.
    pub(super) largest: Quantiles,
    pub(super) perspective: Quantiles,
    pub(super) projection: Quantiles,
    /// Pixels by mean size: number i counts those above `2^((i − 25) / 4)` and up to `2^((i − 24) / 4)`; the first has no
    /// lower end, the last no upper one.
    pub(super) histogram: Vec<u32>,
}

/// How many texels visible receivers need.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Texels {
    /// Texels of all maps that are drawn, those of a fallback map included.
    pub(super) drawn: u64,
    /// Texels that the footprint of at least one pixel with a surface that faces the light touches.
    pub(super) over_receivers: u64,
    pub(super) over_receivers_percent: f64,
    /// Texels in the projection of the visible part of the scene's box, each map with the slice of the view that it is
    /// meant for.
    pub(super) in_view: f64,
    pub(super) in_view_percent: f64,
}

/// Valid pixels outside the edge band whose texels are much smaller than pixels: a map has no excuse there, so that they
/// confirm truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Confirmation {
    /// The longest extent of a texel in pixels, at most.
    pub(super) largest: f64,
    pub(super) pixels: u32,
    /// Of the valid ones.
    pub(super) pixels_percent: f64,
    /// Those that disagree with truth.
    pub(super) wrong: u32,
    pub(super) wrong_percent: f64,
}

/// The sampling floor at one texel ÷ pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Floor {
    pub(super) texel_pixel: f64,
    /// Whether `texel_pixel` is the technique's median.
    pub(super) is_median: bool,
    pub(super) nearest_percent: f64,
    pub(super) bilinear_percent: f64,
}

/// Valid pixels in a range of view depth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Distance {
    pub(super) from_m: f64,
    pub(super) to_m: f64,
    pub(super) valid: u32,
    pub(super) wrong: u32,
}

/// Means over the shots of one technique in one scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mean {
    pub(super) scene: String,
    pub(super) technique: String,
    pub(super) wrong: f64,
    pub(super) false_shadow: f64,
    pub(super) false_lit: f64,
    pub(super) band: f64,
    pub(super) valid: f64,
    /// Texel ÷ pixel: means of the shots' quantiles, but the largest maximum.
    pub(super) texel_pixel: Quantiles,
    pub(super) over_receivers: f64,
    pub(super) in_view: f64,
    /// Of all shots together.
    pub(super) confirmed: Confirmation,
}

impl Report {
    /// Writes report.json and report.md, or the file of a part.
    pub(super) fn write(&self, out: &Path) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(self).map_err(Failure::failed)?;
        let name = part_name(self.part);
        pictures::write_whole(&out.join(name), json.as_bytes()).map_err(Failure::failed)?;
        if self.part == Part::default() {
            pictures::write_whole(&out.join("report.md"), self.markdown().as_bytes()).map_err(Failure::failed)?;
        }
        Ok(())
    }

    /// Marks the report as complete, and writes it with its plots.
    pub(super) fn finish(&mut self, out: &Path) -> Result<(), Failure> {
        self.is_complete = true;
        if self.part == Part::default() {
            plots::write(self, out)?;
        }
        self.write(out)
    }

    /// Scenes and techniques that were judged together, in the order of their first appearance.
    pub(super) fn pairs(&self) -> Vec<(&str, &str)> {
        let mut pairs = Vec::new();
        for row in &self.rows {
            let pair = (row.scene.as_str(), row.technique.as_str());
            if !pairs.contains(&pair) {
                pairs.push(pair);
            }
        }
        pairs
    }

    /// The rows of a technique in a scene.
    pub(super) fn rows_of<'a>(&'a self, scene: &'a str, technique: &'a str) -> impl Iterator<Item = &'a Row> + Clone {
        let rows = self.rows.iter();
        rows.filter(move |row| row.scene == scene && row.technique == technique)
    }

    /// The mean over all shots of each technique in each scene.
    pub(super) fn means(&self) -> Vec<Mean> {
        let pairs = self.pairs().into_iter();
        pairs.map(|(scene, technique)| self.mean(scene, technique)).collect()
    }

    fn mean(&self, scene: &str, technique: &str) -> Mean {
        let rows: Vec<&Row> = self.rows_of(scene, technique).collect();
        let mean = |of: &dyn Fn(&Row) -> f64| rows.iter().map(|row| of(row)).sum::<f64>() / rows.len() as f64;
        let with_map: Vec<&TexelPixel> = rows.iter().filter_map(|row| row.texel_pixel.as_ref()).collect();
        let quantile = |of: &dyn Fn(&Quantiles) -> f64| {
            let sum: f64 = with_map.iter().map(|found| of(&found.mean_size)).sum();
            sum / with_map.len().max(1) as f64
        };
        let count = |of: &dyn Fn(&Row) -> u32| rows.iter().map(|row| of(row)).sum::<u32>();
        let (fine, wrong) = (
            count(&|row| row.confirmation.pixels),
            count(&|row| row.confirmation.wrong),
        );
        Mean {
            scene: scene.to_owned(),
            technique: technique.to_owned(),
            wrong: mean(&|row| row.overall.wrong_percent),
            false_shadow: mean(&|row| row.overall.false_shadow_percent),
            false_lit: mean(&|row| row.overall.false_lit_percent),
            band: mean(&|row| row.band.wrong_percent),
            valid: mean(&|row| percent(row.overall.valid, row.pixels)),
            texel_pixel: Quantiles {
                median: quantile(&|found| found.median),
                p95: quantile(&|found| found.p95),
                p99: quantile(&|found| found.p99),
                max: with_map.iter().map(|found| found.mean_size.max).fold(0.0, f64::max),
            },
            over_receivers: mean(&|row| row.texels.over_receivers_percent),
            in_view: mean(&|row| row.texels.in_view_percent),
            confirmed: Confirmation {
                largest: rows.first().map_or(0.0, |row| row.confirmation.largest),
                pixels: fine,
                pixels_percent: percent(fine, count(&|row| row.overall.valid)),
                wrong,
                wrong_percent: percent(wrong, fine),
            },
        }
    }
}

/// The file of a part; the whole report for the only one.
pub(super) fn part_name(part: Part) -> String {
    if part == Part::default() {
        "report.json".to_owned()
    } else {
        format!("report.{}-of-{}.json", part.index, part.count)
    }
}

/// A share in percent; 0 of nothing.
pub(super) fn percent(part: u32, whole: u32) -> f64 {
    100.0 * f64::from(part) / f64::from(whole.max(1))
}
