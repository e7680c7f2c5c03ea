//! The report as a table for terminals and as report.md.

use std::fmt::Write as _;

use super::{
    MOST_UNMATCHED, plots,
    report::{Floor, Report, Row, percent},
};

impl Report {
    /// For a terminal: means over shots.
    pub(super) fn table(&self) -> String {
        let mut text = format!(
            "{:<12} {:<34} {:>8} {:>8} {:>8} {:>8} {:>8} {:>25} {:>8} {:>15}",
            "", "", "", "false", "false", "in", "valid", "texel ÷ pixel", "texels", "fine: differ %"
        );
        let _ = write!(
            text,
            "\n{:<12} {:<34} {:>8} {:>8} {:>8} {:>8} {:>8} {:>7} {:>8} {:>8} {:>8} {:>8} {:>6}",
            "scene",
            "technique",
            "wrong %",
            "shadow",
            "lit",
            "band",
            "%",
            "50 %",
            "95 %",
            "99 %",
            "used %",
            "of %",
            "pixels"
        );
        for mean in self.means() {
            let (size, fine) = (mean.texel_pixel, mean.confirmed);
            let _ = write!(
                text,
                "\n{:<12} {:<34} {:>8.3} {:>8.3} {:>8.3} {:>8.2} {:>8.1} {:>7.3} {:>8.3} {:>8.3} {:>8.2} {:>8.3} {:>6.2}",
                mean.scene,
                mean.technique,
                mean.wrong,
                mean.false_shadow,
                mean.false_lit,
                mean.band,
                mean.valid,
                size.median,
                size.p95,
                size.p99,
                mean.over_receivers,
                fine.wrong_percent,
                fine.pixels_percent,
            );
        }
        text
    }

    /// report.md.
    pub(super) fn markdown(&self) -> String {
        let mut text = String::from("# Shadow masks against ray-traced truth\n\n");
        self.accuracy(&mut text);
        self.sampling(&mut text);
        self.floors(&mut text);
        self.kinds(&mut text);
        self.levels(&mut text);
        if self.is_complete {
            text.push_str("\n## Plots\n\n");
            for name in plots::names(self) {
                let _ = writeln!(text, "![{}]({name})\n", name.trim_end_matches(".png"));
            }
        }
        self.shots(&mut text);
        text
    }

    fn accuracy(&self, text: &mut String) {
        text.push_str(
            "Shares of valid pixels in percent, means over shots. The edge band holds valid pixels within 3 px of a true \
             shadow edge.\n\n\
             | scene | technique | wrong | false shadow | false lit | wrong in the edge band | valid pixels |\n\
             |---|---|---|---|---|---|---|\n",
        );
        for mean in self.means() {
            let _ = writeln!(
                text,
                "| {} | `{}` | {:.3} | {:.3} | {:.3} | {:.2} | {:.1} |",
                mean.scene, mean.technique, mean.wrong, mean.false_shadow, mean.false_lit, mean.band, mean.valid
            );
        }
    }

    fn sampling(&self, text: &mut String) {
        text.push_str(
            "\n## Texel ÷ pixel\n\nThe size of a texel of the map that a valid pixel reads, in pixels, on the pixel's \
             surface: the root of the areas' ratio (perspective × projection). Quantiles over the valid pixels of a shot, \
             means over shots, the largest of all. *Used*: texels that a visible surface facing the light covers, of all \
             texels drawn; *in view*: those that the visible part of the scene's box projects to. *Fine*: valid pixels outside the edge band whose texels are at most a quarter of a pixel long; \
             they confirm truth where the mask agrees with it.\n\n\
             | scene | technique | median | 95 % | 99 % | largest | texels used, % | in view, % | fine pixels, % | of them differ, % |\n\
             |---|---|---|---|---|---|---|---|---|---|\n",
        );
        for mean in self.means() {
            let (size, fine) = (mean.texel_pixel, mean.confirmed);
            let _ = writeln!(
                text,
                "| {} | `{}` | {:.3} | {:.3} | {:.3} | {:.2} | {:.2} | {:.2} | {:.2} | {:.3} ({}) |",
                mean.scene,
                mean.technique,
                size.median,
                size.p95,
                size.p99,
                size.max,
                mean.over_receivers,
                mean.in_view,
                fine.pixels_percent,
                fine.wrong_percent,
                fine.wrong
            );
        }
        for row in &self.rows {
            if let Some(found) = row.texel_pixel.as_ref().filter(|found| found.without_map > 0) {
                let _ = writeln!(
                    text,
                    "\n{} {}, `{}`: {} valid pixels lie in no map and are lit.",
                    row.scene, row.shot, row.technique, found.without_map
                );
            }
            if let Some(percent) = row.capped_percent.filter(|percent| *percent > 0.0) {
                let _ = writeln!(
                    text,
                    "\n{} {}, `{}`: {percent:.3} % of the pixels need more than the finest tiles.",
                    row.scene, row.shot, row.technique
                );
            }
        }
    }

    fn floors(&self, text: &mut String) {
        if self.rows.iter().all(|row| row.floor.is_empty()) {
            return;
        }
        text.push_str(
            "\n## Sampling floor\n\nWrong pixels in percent that perfectly spread texels leave, means over shots: with one \
             comparison, and with four. Texels are shaped like pixels here; those of a map may be finer along one axis, \
             and its median says little about where edges are.\n\n\
             | scene | texel ÷ pixel | | nearest | 2 x 2 | the technique itself |\n|---|---|---|---|---|---|\n",
        );
        let mut scenes_done = Vec::new();
        for mean in self.means() {
            let rows: Vec<&Row> = self.rows_of(&mean.scene, &mean.technique).collect();
            let places = rows.iter().map(|row| row.floor.len()).min().unwrap_or(0);
            // Every technique has the same floors at given sizes, and one of its own.
            let is_first = !scenes_done.contains(&mean.scene);
            scenes_done.push(mean.scene.clone());
            for place in (0..places).filter(|place| is_first || rows[0].floor[*place].is_median) {
                let average = |of: fn(&Floor) -> f64| {
                    rows.iter().map(|row| of(&row.floor[place])).sum::<f64>() / rows.len() as f64
                };
                let (technique, wrong) = if rows[0].floor[place].is_median {
                    (format!("median of `{}`", mean.technique), format!("{:.3}", mean.wrong))
                } else {
                    (String::new(), String::new())
                };
                let _ = writeln!(
                    text,
                    "| {} | {:.3} | {technique} | {:.3} | {:.3} | {wrong} |",
                    mean.scene,
                    average(|floor| floor.texel_pixel),
                    average(|floor| floor.nearest_percent),
                    average(|floor| floor.bilinear_percent),
                );
            }
        }
    }

    fn kinds(&self, text: &mut String) {
        text.push_str(
            "\n## Pixels\n\nShares of all pixels in percent. Only lit and shadow are valid. Sky: no surface before the far \
             plane; unmatched: the rays find no surface where the picture has one; faces away: N·L at most 0.15; edge: of a \
             surface, with its neighbours; unsure: truth itself changes within two millimetres.\n\n\
             | scene | shot | lit | shadow | sky | unmatched | faces away | edge | unsure |\n\
             |---|---|---|---|---|---|---|---|---|\n",
        );
        let mut seen = Vec::new();
        for row in &self.rows {
            let key = (&row.scene, &row.shot);
            if seen.contains(&key) {
                continue;
            }
            seen.push(key);
            let share = |count: u32| percent(count, row.pixels);
            let kinds = row.kinds;
            let _ = writeln!(
                text,
                "| {} | {} | {:.1} | {:.1} | {:.1} | {:.2}{} | {:.1} | {:.1} | {:.2} |",
                row.scene,
                row.shot,
                share(kinds.lit),
                share(kinds.shadow),
                share(kinds.sky),
                share(kinds.unmatched),
                if share(kinds.unmatched) > MOST_UNMATCHED {
                    " (!)"
                } else {
                    ""
                },
                share(kinds.faces_away),
                share(kinds.edge),
                share(kinds.unsure)
            );
        }
        if self
            .rows
            .iter()
            .any(|row| percent(row.kinds.unmatched, row.pixels) > MOST_UNMATCHED)
        {
            let _ = writeln!(
                text,
                "\n(!) More than {MOST_UNMATCHED} % of the pixels are unmatched: picture and rays do not show the same scene."
            );
        }
    }

    fn levels(&self, text: &mut String) {
        text.push_str(
            "\n## Scenes\n\n| scene | instances | casters | meshes | triangles | bounds, m | area, m² |\n\
             |---|---|---|---|---|---|---|\n",
        );
        for scene in &self.scenes {
            let of = &scene.statistics;
            let [x, y, z] = std::array::from_fn(|axis| of.bounds_max_m[axis] - of.bounds_min_m[axis]);
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {x:.1} x {y:.1} x {z:.1} | {:.0} |",
                scene.scene, of.instances, of.casters, of.meshes, of.triangles, of.area_m2
            );
        }
    }

    fn shots(&self, text: &mut String) {
        text.push_str("\nFalse shadow is red, false lit orange, pixels that do not count blue.\n");
        for row in &self.rows {
            let _ = write!(
                text,
                "\n## {} {}, `{}`: {:.3} % wrong\n\n![truth]({}) ![difference]({})\n",
                row.scene, row.shot, row.technique, row.overall.wrong_percent, row.truth, row.difference
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        cli::judge::report::TexelPixel,
        render::reference::{
            accuracy::{Counts, Kinds},
            sampling::Quantiles,
        },
    };

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
            kinds: Kinds {
                unmatched: 4 * wrong,
                ..Kinds::default()
            },
            overall: counts.into(),
            texel_pixel: Some(TexelPixel {
                mean_size: Quantiles {
                    median: f64::from(wrong),
                    max: f64::from(wrong) * 10.0,
                    ..Quantiles::default()
                },
                without_map: wrong,
                ..TexelPixel::default()
            }),
            ..Row::default()
        }
    }

    #[test]
    fn tables_hold_means_over_shots() {
        let report = Report {
            rows: vec![row("bevy", "a", 2), row("lispsm", "a", 0), row("bevy", "b", 4)],
            ..Report::default()
        };
        let means = report.means();
        assert_eq!(means.len(), 2);
        let [bevy, lispsm] = [&means[0], &means[1]];
        assert_eq!(
            (
                bevy.technique.as_str(),
                bevy.wrong,
                bevy.false_shadow,
                bevy.false_lit,
                bevy.band,
                bevy.valid
            ),
            ("bevy", 1.5, 1.5, 0.0, 0.0, 50.0)
        );
        assert_eq!((bevy.texel_pixel.median, bevy.texel_pixel.max), (3.0, 40.0));
        assert_eq!(lispsm.wrong, 0.0);
        assert_eq!(report.table().lines().count(), 4);
        let markdown = report.markdown();
        for line in [
            "| forest | `bevy` | 1.500 | 1.500 | 0.000 | 0.00 | 50.0 |",
            "| forest | a | 0.0 | 0.0 | 0.0 | 2.00 (!) |",
            "forest a, `bevy`: 2 valid pixels lie in no map",
        ] {
            assert!(markdown.contains(line), "{line} is not in\n{markdown}");
        }
        assert!(!markdown.contains("Sampling floor"), "it was not asked for");
        let mut with_floors = report;
        for row in &mut with_floors.rows {
            let at = |texel_pixel, is_median| Floor {
                texel_pixel,
                is_median,
                nearest_percent: texel_pixel * 2.0,
                bilinear_percent: texel_pixel,
            };
            row.floor = vec![at(1.0, false), at(row.overall.wrong_percent, true)];
        }
        let markdown = with_floors.markdown();
        let given = markdown.matches("| forest | 1.000 |  | 2.000 | 1.000 |  |").count();
        assert_eq!(given, 1, "once for all techniques: {markdown}");
        let own = "| forest | 1.500 | median of `bevy` | 3.000 | 1.500 | 1.500 |";
        assert!(markdown.contains(own), "{markdown}");
    }
}
