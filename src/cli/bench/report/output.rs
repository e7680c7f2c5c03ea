//! bench.json, bench.csv and the table.

use std::{fmt::Write as _, path::Path};

use super::{Report, TechniqueReport};
use crate::cli::{Failure, pictures};

impl Report {
    /// Writes bench.json and bench.csv.
    pub(in crate::cli::bench) fn write(&self, out: &Path) -> Result<(), Failure> {
        let json = serde_json::to_string_pretty(self).map_err(Failure::failed)?;
        pictures::write_whole(&out.join("bench.json"), json.as_bytes()).map_err(Failure::failed)?;
        pictures::write_whole(&out.join("bench.csv"), self.csv().as_bytes()).map_err(Failure::failed)
    }

    /// One line per technique and frame.
    fn csv(&self) -> String {
        let mut text = String::from(
            "technique,frame,path_s,frame_ms,main_world_ms,extract_ms,render_world_ms,submit_ms,gpu_wait_ms,casters_drawn\n",
        );
        for report in &self.techniques {
            for row in &report.all {
                // Techniques contain commas, but no quotation marks.
                let _ = writeln!(
                    text,
                    "\"{}\",{},{:.3},{:.4},{:.4},{:.4},{:.4},{:.4},{:.4},{}",
                    report.technique,
                    row.frame,
                    row.path_s,
                    row.ms,
                    row.main_world_ms,
                    row.extract_ms,
                    row.render_world_ms,
                    row.submit_ms,
                    row.gpu_wait_ms,
                    row.casters_drawn
                );
            }
        }
        text
    }

    /// For a terminal.
    pub(in crate::cli::bench) fn table(&self) -> String {
        let mut text = format!("{} ({})", self.adapter.name, self.adapter.backend);
        if self.adapter.is_software {
            text.push_str(", software: the CPU draws, times say nothing about GPUs");
        }
        let _ = write!(
            text,
            "\n{}: medians of {} frames; CPU without submission; shadows: GPU time of their passes, ms",
            self.title(),
            self.frames
        );
        if !self.has_gpu_times {
            text.push_str("; the adapter has no timestamps, so that no time of the GPU is known");
        }
        let _ = write!(
            text,
            "\n{:<30} {:>8} {:>8} {:>7} {:>8} {:>10} {:>7} {:>7} {:>6} {:>6}",
            "technique", "frame ms", "1 % low", "CPU ms", "shadows", "Mtexels", "casters", "draws", "MiB", "fps"
        );
        if let Some(against) = &self.against {
            let _ = write!(text, "  frame ÷ {against} (95 %)   shadows ÷ {against}");
        }
        for report in &self.techniques {
            let _ = write!(text, "\n{}", report.table_line());
        }
        if let Some(memory) = self.process_memory {
            let [resident, peak] = [memory.resident, memory.peak].map(|bytes| bytes >> 20);
            let _ = write!(text, "\nthe process held {resident} MiB, at most {peak} MiB");
        }
        text
    }
}

impl TechniqueReport {
    fn table_line(&self) -> String {
        let or_dash = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
        let mut line = format!(
            "{:<30} {:>8.2} {:>8.2} {:>7.2} {:>8} {:>10.1} {:>7.0} {:>7.0} {:>6.0} {:>6.1}",
            self.technique,
            self.frame_ms.median,
            self.frame_ms.low_1_percent,
            self.cpu_ms,
            or_dash(self.shadow_gpu_ms.map(|ms| format!("{ms:.2}"))),
            self.maps.texels as f64 / 1e6,
            self.casters_drawn.all,
            self.draw_calls.all,
            self.memory.all as f64 / f64::from(1 << 20),
            self.frames_per_second.median,
        );
        if let Some(ratio) = &self.ratio {
            let frame = ratio
                .frame
                .map(|frame| format!("{:.2} ({:.2} to {:.2})", frame.of_medians, frame.low, frame.high));
            let shadows = ratio.shadow_gpu.map(|shadows| format!("{shadows:.2}"));
            let _ = write!(line, "  {:>21} {:>12}", or_dash(frame), or_dash(shadows));
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use crate::cli::bench::report::tests::{report, whole};

    #[test]
    fn the_table_has_a_line_per_technique() {
        let mut whole = whole(vec![report("lispsm", &[6, 8, 10]), report("bevy", &[3, 4, 5])]);
        assert!(!whole.table().contains('÷'), "{}", whole.table());
        whole.compare("bevy");
        let table = whole.table();
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!(lines.len(), 5, "adapter, run, head, two techniques: {table}");
        assert!(lines[2].contains("frame ÷ bevy"), "{table}");
        assert!(
            lines[3].starts_with("lispsm ") && lines[3].contains(" 2.00 ("),
            "{table}"
        );
    }

    #[test]
    fn the_table_says_what_is_missing() {
        let mut whole = whole(vec![report("lispsm", &[4])]);
        whole.adapter.is_software = true;
        whole.has_gpu_times = false;
        whole.techniques[0].shadow_gpu_ms = None;
        let table = whole.table();
        for part in ["software", "no timestamps", " - "] {
            assert!(table.contains(part), "{table} lacks {part:?}");
        }
    }

    #[test]
    fn every_technique_and_frame_has_a_line() {
        let whole = whole(vec![
            report("zp4:size=512,filter=hard", &[4, 6]),
            report("bevy", &[3, 4]),
        ]);
        let csv = whole.csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines.len(), 5);
        assert_eq!(
            lines[2],
            "\"zp4:size=512,filter=hard\",1,0.500,6.0000,1.0000,0.0000,0.0000,2.0000,3.0000,12"
        );
    }
}
