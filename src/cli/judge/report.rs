//! [`Report`]: what judging found, as report.json has it.

use std::path::Path;

use serde::Serialize;

use crate::{
    cli::{Failure, pictures},
    render::reference::accuracy::Counts,
};

/// One technique on one shot.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) scene: String,
    pub(super) shot: String,
    pub(super) technique: String,
    pub(super) pixels: u32,
    pub(super) overall: Errors,
    /// Within three pixels of true shadow edges.
    pub(super) band: Errors,
    pub(super) truth: String,
    pub(super) difference: String,
}

/// Counts with their shares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
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

/// What was judged so far.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Report {
    pub(super) rows: Vec<Row>,
}

impl Report {
    /// Writes report.json and report.md.
    pub(super) fn write(&self, out: &Path) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(self).map_err(Failure::failed)?;
        pictures::write_whole(&out.join("report.json"), json.as_bytes()).map_err(Failure::failed)?;
        pictures::write_whole(&out.join("report.md"), self.markdown().as_bytes()).map_err(Failure::failed)
    }

    /// The mean over all shots of each technique in each scene, in the order of their first appearance.
    pub(super) fn means(&self) -> Vec<(String, String, [f64; 5])> {
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
}
