//! What was measured of pops: a table and pop.json.

use std::{fmt::Write as _, path::Path};

use serde::Serialize;

use super::strip::Watched;
use crate::cli::{Failure, args::Pop, pictures};

/// One kind at one place.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    kind: String,
    /// Largest energy of a frame.
    peak_energy: f64,
    /// The frame, from 1.
    peak_frame: usize,
    /// Sum over all frames.
    total_energy: f64,
    /// Most objects that showed two levels at once.
    most_crossings: u32,
    /// Most parts that were drawn beside those of levels at rest.
    most_fading_parts: u32,
    /// Energy of every frame.
    energies: Vec<f64>,
}

impl Row {
    pub(super) fn of(watched: &Watched) -> Self {
        let (peak_frame, peak_energy) = watched.peak();
        Self {
            kind: watched.kind.name().to_owned(),
            peak_energy,
            peak_frame,
            total_energy: watched.energies.iter().sum(),
            most_crossings: watched.most_crossings,
            most_fading_parts: watched.most_fading_parts,
            energies: watched.energies.clone(),
        }
    }
}

/// What was measured so far.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Report {
    scene: String,
    path: String,
    technique: String,
    shadows: String,
    frames: u32,
    /// One list of kinds per place.
    stops: Vec<Vec<Row>>,
}

impl Report {
    pub(super) fn new(scene: &str, path: &str, args: &Pop) -> Self {
        Self {
            scene: scene.to_owned(),
            path: path.to_owned(),
            technique: args.technique.text.clone(),
            shadows: format!("{:?}", args.shadows).to_lowercase(),
            frames: args.frames,
            stops: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, rows: impl Iterator<Item = Row>) {
        self.stops.push(rows.collect());
    }

    pub(super) fn write(&self, folder: &Path) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(self).map_err(Failure::failed)?;
        pictures::write_whole(&folder.join("pop.json"), json.as_bytes()).map_err(Failure::failed)
    }

    /// One line per kind, over all places: largest energy of a frame, and in parts of the first kind's.
    pub(super) fn table(&self) -> String {
        let mut table = format!(
            "{:<10} {:>12} {:>10} {:>12} {:>10} {:>8}",
            "kind", "peak energy", "of first", "total energy", "crossings", "fading"
        );
        let Some(first_stop) = self.stops.first() else {
            return table;
        };
        let peak = |kind: usize| self.stops.iter().map(|rows| rows[kind].peak_energy).fold(0.0, f64::max);
        for (index, row) in first_stop.iter().enumerate() {
            let all = || self.stops.iter().map(|rows| &rows[index]);
            let share = if peak(0) > 0.0 {
                100.0 * peak(index) / peak(0)
            } else {
                0.0
            };
            // Writing into a string cannot fail.
            let _ = write!(
                table,
                "\n{:<10} {:>12.3} {:>8.2} % {:>12.3} {:>10} {:>8}",
                row.kind,
                peak(index),
                share,
                all().map(|row| row.total_energy).sum::<f64>(),
                all().map(|row| row.most_crossings).max().unwrap_or(0),
                all().map(|row| row.most_fading_parts).max().unwrap_or(0),
            );
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_are_compared_over_all_places() {
        let row = |kind: &str, peak_energy| Row {
            kind: kind.to_owned(),
            peak_energy,
            peak_frame: 1,
            total_energy: 2.0 * peak_energy,
            most_crossings: 3,
            most_fading_parts: 6,
            energies: vec![peak_energy],
        };
        let report = Report {
            scene: "forest".to_owned(),
            path: "walk".to_owned(),
            technique: "zp4".to_owned(),
            shadows: "fading".to_owned(),
            frames: 1,
            stops: vec![
                vec![row("hard", 10.0), row("unpopping", 0.2)],
                vec![row("hard", 40.0), row("unpopping", 0.1)],
            ],
        };
        let table = report.table();
        assert!(
            table.lines().count() == 3 && table.contains("100.00 %") && table.contains("0.50 %"),
            "{table}"
        );
        assert!(table.contains("0.600"), "{table}");
    }
}
