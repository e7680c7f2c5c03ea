//! What was measured of stability: a table and stability.json.

use std::{fmt::Write as _, path::Path};

use serde::Serialize;

use super::along::Along;
use crate::{
    cli::{Failure, pictures},
    render::reference::{
        accuracy::Counts,
        pictures::NOT_VALID,
        stability::{Change, Crawl},
    },
};

/// One technique along one motion of one shot.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) scene: String,
    pub(super) shot: String,
    pub(super) along: String,
    pub(super) technique: String,
    /// Frames of the sequence; there is one step less.
    pub(super) frames: usize,
    /// Share of the pixels of all steps that could be compared, in percent.
    pub(super) compared_percent: f64,
    /// Mean squared change of compared pixels per step; masks are 0..=1.
    pub(super) crawl_energy: f64,
    /// The part of it that resampling cannot explain.
    pub(super) certain_energy: f64,
    /// The frame, from 0, that the worst step leads to, and its crawl energy.
    pub(super) peak_frame: usize,
    pub(super) peak_energy: f64,
    /// Share of valid pixels of all frames that are wrong.
    pub(super) wrong_percent: f64,
    /// Crawl energy of every step.
    pub(super) steps: Vec<f64>,
    /// The picture of where it crawls.
    pub(super) picture: String,
}

/// Sums over the frames of one sequence.
#[derive(Clone, Debug, Default)]
pub(super) struct Sequence {
    crawl: Crawl,
    steps: Vec<f64>,
    wrong: u64,
    valid: u64,
    /// Sum of squared changes at every pixel; `None` where none could be compared.
    heat: Vec<Option<f64>>,
}

impl Sequence {
    /// Adds the accuracy of one frame.
    pub(super) fn add_frame(&mut self, counts: Counts) {
        self.wrong += u64::from(counts.false_shadow) + u64::from(counts.false_lit);
        self.valid += u64::from(counts.valid);
    }

    /// Adds the changes of one step.
    pub(super) fn add_step(&mut self, changes: &[Option<Change>]) {
        let step = Crawl::of(changes);
        self.crawl += step;
        self.steps.push(step.energy());
        self.heat.resize(changes.len(), None);
        for (heat, change) in self.heat.iter_mut().zip(changes) {
            if let Some(change) = change {
                *heat = Some(heat.unwrap_or(0.0) + change.squared);
            }
        }
    }

    /// Where it crawls: the root of the mean squared change per step, black none, white all; blue where no pixel could
    /// be compared.
    pub(super) fn picture(&self) -> Vec<u8> {
        let steps = self.steps.len().max(1) as f64;
        let color = |heat: &Option<f64>| match heat {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..=255")]
            Some(sum) => [((sum / steps).sqrt().min(1.0) * 255.0).round() as u8; 3],
            None => NOT_VALID,
        };
        self.heat.iter().flat_map(color).collect()
    }

    /// The row of the table.
    pub(super) fn row(self, (scene, shot, along, technique): (&str, &str, Along, &str), picture: String) -> Row {
        let peak = self.steps.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let (peak_frame, peak_energy) = peak.map_or((0, 0.0), |(step, energy)| (step + 1, *energy));
        Row {
            scene: scene.to_owned(),
            shot: shot.to_owned(),
            along: along.to_string(),
            technique: technique.to_owned(),
            frames: self.steps.len() + 1,
            compared_percent: 100.0 * self.crawl.compared_share(),
            crawl_energy: self.crawl.energy(),
            certain_energy: self.crawl.certain_energy(),
            peak_frame,
            peak_energy,
            wrong_percent: 100.0 * self.wrong as f64 / self.valid.max(1) as f64,
            steps: self.steps,
            picture,
        }
    }
}

/// What was measured so far.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct Report {
    pub(super) rows: Vec<Row>,
}

impl Report {
    /// Writes the JSON file.
    pub(super) fn write(&self, file: &Path) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(self).map_err(Failure::failed)?;
        pictures::write_whole(file, json.as_bytes()).map_err(Failure::failed)
    }

    /// For a terminal. Energies are per thousand: of a picture of 0s and 1s, pixels per thousand that flip in a step.
    pub(super) fn table(&self) -> String {
        let mut text = format!(
            "{:<12} {:<12} {:<7} {:<24} {:>6} {:>8} {:>9} {:>8} {:>8} {:>10}",
            "scene", "shot", "along", "technique", "frames", "crawl ‰", "certain ‰", "peak ‰", "wrong %", "compared %"
        );
        for row in &self.rows {
            let _ = write!(
                text,
                "\n{:<12} {:<12} {:<7} {:<24} {:>6} {:>8.3} {:>9.3} {:>8.3} {:>8.3} {:>10.1}",
                row.scene,
                row.shot,
                row.along,
                row.technique,
                row.frames,
                1000.0 * row.crawl_energy,
                1000.0 * row.certain_energy,
                1000.0 * row.peak_energy,
                row.wrong_percent,
                row.compared_percent,
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sequences_add_up() {
        let mut sequence = Sequence::default();
        let change = |squared| Some(Change { squared, certain: 0.0 });
        sequence.add_step(&[change(0.25), change(0.0), None, None]);
        sequence.add_step(&[change(0.25), None, change(1.0), None]);
        sequence.add_frame(Counts {
            valid: 3,
            false_shadow: 1,
            false_lit: 0,
        });
        sequence.add_frame(Counts {
            valid: 5,
            false_shadow: 0,
            false_lit: 1,
        });
        let picture = sequence.picture();
        assert_eq!((picture[0], picture[3], picture[6]), (128, 0, 180));
        assert_eq!(picture[9..], NOT_VALID);
        let row = sequence.row(("forest", "path", Along::Sun, "bevy"), "p.png".to_owned());
        assert_eq!((row.frames, row.peak_frame, row.peak_energy), (3, 2, 0.625));
        assert_eq!(
            (row.crawl_energy, row.compared_percent, row.wrong_percent),
            (0.375, 50.0, 25.0)
        );
        let report = Report { rows: vec![row] };
        let table = report.table();
        assert_eq!(table.lines().count(), 2);
        assert!(table.contains("375.000") && table.contains("625.000"), "{table}");
    }
}
