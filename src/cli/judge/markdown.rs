//! The report as a table for terminals and as report.md.

use std::fmt::Write as _;

use super::report::Report;

impl Report {
    /// For a terminal: means over shots.
    pub(super) fn table(&self) -> String {
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

    /// report.md.
    pub(super) fn markdown(&self) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{cli::judge::report::Row, render::reference::accuracy::Counts};

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
}
