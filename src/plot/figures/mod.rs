//! The papers' plots of error and storage, from the formulas of [`analysis`](crate::maths::analysis).
//!
//! Every figure names its source and the parameters that the source leaves open, and says where theory ends. Pictures of
//! renderings and timings of the papers' machines are no such plots and are not here.

mod chong;
mod data;
mod lloyd;
mod scherzer;
mod stingl;

use std::fmt::Write;

use bevy_math::UVec2;

use super::{
    Bars, Curves, HeatMap, Pixels, PlotError,
    canvas::{TITLE_PX, draw},
    key::{noted, titled},
};

/// A plot of a paper.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// As the command line names it.
    pub name: &'static str,
    /// Above the picture.
    pub title: &'static str,
    /// Paper and figure, section or table.
    pub source: &'static str,
    /// Parameters that the source leaves open, and where theory ends: below the picture.
    pub notes: &'static [&'static str],
    panels: fn() -> Panels,
}

/// The plots of a figure, side by side.
#[derive(Clone, Debug, PartialEq)]
pub enum Panels {
    /// Lines.
    Curves(Vec<Curves>),
    /// Values over light directions.
    HeatMaps(Vec<HeatMap>),
    /// Tables.
    Bars(Vec<Bars>),
}

/// All figures, in the order of the papers.
pub fn figures() -> impl Iterator<Item = &'static Figure> {
    [lloyd::FIGURES, stingl::FIGURES, scherzer::FIGURES, chong::FIGURES]
        .into_iter()
        .flatten()
}

impl Figure {
    /// The numbers of the figure.
    pub fn panels(&self) -> Panels {
        (self.panels)()
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// The drawing library refused.
    pub fn draw(&self) -> Result<Pixels, PlotError> {
        let panels = self.panels();
        let (count, width, height) = match &panels {
            Panels::Curves(curves) => (curves.len(), 760, 680),
            Panels::HeatMaps(maps) => (maps.len(), 600, 660),
            Panels::Bars(bars) => (bars.len(), 700, 900),
        };
        let size = UVec2::new((width * count as u32).max(900), height);
        draw(size, |area| {
            let notes: Vec<String> = [self.source]
                .iter()
                .chain(self.notes)
                .map(ToString::to_string)
                .collect();
            let area = titled(&noted(area, &notes)?, self.title, TITLE_PX + 4)?;
            let parts = area.split_evenly((1, count.max(1)));
            match &panels {
                Panels::Curves(curves) => parts
                    .iter()
                    .zip(curves)
                    .try_for_each(|(part, curves)| curves.draw_on(part)),
                Panels::HeatMaps(maps) => parts.iter().zip(maps).try_for_each(|(part, map)| map.draw_on(part)),
                Panels::Bars(bars) => parts.iter().zip(bars).try_for_each(|(part, bars)| bars.draw_on(part)),
            }
        })
    }

    /// The numbers as comma-separated values, one point per line; title, source and notes stand on top behind `#`.
    pub fn csv(&self) -> String {
        let mut text = String::new();
        let mut line = |cells: &[String]| {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}", cells.join(","));
        };
        for comment in [self.title, self.source].iter().chain(self.notes) {
            line(&[format!("# {comment}")]);
        }
        match self.panels() {
            Panels::Curves(panels) => {
                let axes = |curves: &Curves| [cell(&curves.x.label), cell(&curves.y.label)];
                let [x, y] = panels.first().map(axes).unwrap_or_default();
                line(&["panel".to_owned(), "curve".to_owned(), x, y]);
                for panel in &panels {
                    for curve in &panel.curves {
                        for (x, y) in curve.points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
                            line(&[cell(&panel.title), cell(&curve.label), x.to_string(), y.to_string()]);
                        }
                    }
                }
            }
            Panels::Bars(panels) => {
                let label = panels.first().map(|bars| cell(&bars.label)).unwrap_or_default();
                line(&["panel,row,series".to_owned(), label]);
                for panel in &panels {
                    for row in &panel.rows {
                        for (series, value) in panel.series.iter().zip(&row.values) {
                            let value = value.map_or_else(String::new, |value| value.to_string());
                            line(&[cell(&panel.title), cell(&row.label), cell(series), value]);
                        }
                    }
                }
            }
            Panels::HeatMaps(panels) => {
                let label = panels.first().map(|map| cell(&map.label)).unwrap_or_default();
                line(&["panel,degrees from overhead,degrees from ahead".to_owned(), label]);
                for panel in &panels {
                    let steps = panel.rings.len().saturating_sub(1).max(1) as f64;
                    for (ring, values) in panel.rings.iter().enumerate() {
                        for (sector, value) in values.iter().enumerate() {
                            let polar = 90.0 * ring as f64 / steps;
                            let azimuth = 360.0 * sector as f64 / values.len() as f64;
                            line(&[
                                cell(&panel.title),
                                polar.to_string(),
                                azimuth.to_string(),
                                value.to_string(),
                            ]);
                        }
                    }
                }
            }
        }
        text
    }
}

/// A cell of a table, quoted where it must be.
fn cell(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_has_a_name_a_picture_and_numbers() {
        let mut names: Vec<&str> = figures().map(|figure| figure.name).collect();
        assert!(names.len() >= 20, "{} figures", names.len());
        for figure in figures() {
            let is_plain = |letter: char| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '-';
            assert!(figure.name.chars().all(is_plain), "{}", figure.name);
            let png = figure.draw().and_then(|pixels| pixels.png()).expect(figure.name);
            assert!(image::load_from_memory(&png).is_ok(), "{}", figure.name);
            let csv = figure.csv();
            let comments = csv.lines().take_while(|line| line.starts_with("# ")).count();
            assert_eq!(comments, 2 + figure.notes.len());
            // Commas inside quotes separate nothing.
            let columns = |line: &str| {
                let outside = line.split('"').step_by(2);
                outside.map(|part| part.matches(',').count()).sum::<usize>()
            };
            let header = csv.lines().nth(comments).expect("a header");
            for line in csv.lines().skip(comments) {
                assert_eq!(columns(line), columns(header), "{}: {line}", figure.name);
            }
            assert!(csv.lines().count() > comments + 5, "{}", figure.name);
        }
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), figures().count(), "names are unique");
    }

    #[test]
    fn the_same_figure_is_the_same_picture() {
        let figure = figures().next().expect("some");
        assert_eq!(figure.draw(), figure.draw());
        assert_eq!(figure.csv(), figure.csv());
    }

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(cell("a b"), "a b");
        assert_eq!(cell("a, \"b\""), "\"a, \"\"b\"\"\"");
    }
}
