//! Plots of a report, from its numbers alone, so that merged reports have the same.

use std::path::Path;

use bevy::math::UVec2;
use image::ColorType;

use super::{measure::bin_end, report::Report};
use crate::{
    cli::{
        Failure,
        pictures::{file_name, write_pixels},
    },
    plot::{Axis, Bars, Curve, Curves, Pixels, PlotError, Row, Scale},
};

/// Pixels of a plot.
const SIZE: UVec2 = UVec2::new(960, 540);

/// Pixels that a row of bars adds to a plot.
const ROW_HEIGHT: u32 = 26;

/// View depths with fewer valid pixels than this, in all shots of a scene, are left out: their share is noise.
const FEWEST: u32 = 200;

/// Writes all plots.
pub(super) fn write(report: &Report, out: &Path) -> Result<(), Failure> {
    for (name, plot) in all(report) {
        match plot {
            Ok(Pixels { size, bytes }) => {
                write_pixels(&out.join(name), size, &bytes, ColorType::Rgb8).map_err(Failure::failed)?;
            }
            // A report without valid pixels has nothing to show.
            Err(PlotError::Empty(_)) => {}
            Err(error) => return Err(Failure::failed(error)),
        }
    }
    Ok(())
}

/// File names of the plots that a report has.
pub(super) fn names(report: &Report) -> Vec<String> {
    let drawn = all(report).into_iter().filter(|(_, plot)| plot.is_ok());
    drawn.map(|(name, _)| name).collect()
}

fn all(report: &Report) -> Vec<(String, Result<Pixels, PlotError>)> {
    let (scenes, techniques) = (scenes(report), techniques(report));
    let bars = scenes.len() * techniques.len();
    let height = SIZE.y.max(140 + bars as u32 * ROW_HEIGHT);
    let wrong = wrong(report, &scenes, &techniques).draw(UVec2::new(SIZE.x, height));
    let mut plots = vec![(file_name("plot", "all", "wrong", "bars"), wrong)];
    for scene in scenes {
        let (sizes, distances) = (texel_pixel(report, scene), distances(report, scene));
        plots.push((file_name("plot", scene, "texel-pixel", "curves"), sizes.draw(SIZE)));
        plots.push((file_name("plot", scene, "distance", "curves"), distances.draw(SIZE)));
    }
    plots
}

fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut distinct = Vec::new();
    for name in names {
        if !distinct.contains(&name) {
            distinct.push(name);
        }
    }
    distinct
}

fn scenes(report: &Report) -> Vec<&str> {
    distinct(report.rows.iter().map(|row| row.scene.as_str()))
}

fn techniques(report: &Report) -> Vec<&str> {
    distinct(report.rows.iter().map(|row| row.technique.as_str()))
}

fn wrong(report: &Report, scenes: &[&str], techniques: &[&str]) -> Bars {
    let means = report.means();
    let mean = |scene: &str, technique: &str| {
        let mut means = means.iter();
        let found = means.find(|mean| mean.scene == scene && mean.technique == technique);
        found.map(|mean| mean.wrong)
    };
    Bars {
        title: "Wrong against ray-traced truth, mean over shots".to_owned(),
        label: "wrong pixels, % of the valid ones".to_owned(),
        series: scenes.iter().copied().map(str::to_owned).collect(),
        rows: techniques
            .iter()
            .map(|technique| Row {
                label: (*technique).to_owned(),
                values: scenes.iter().map(|scene| mean(scene, technique)).collect(),
            })
            .collect(),
    }
}

/// Share of pixels up to a texel ÷ pixel.
fn texel_pixel(report: &Report, scene: &str) -> Curves {
    let curve = |technique: &str| {
        let mut bins: Vec<u32> = Vec::new();
        for found in report
            .rows_of(scene, technique)
            .filter_map(|row| row.texel_pixel.as_ref())
        {
            bins.resize(bins.len().max(found.histogram.len()), 0);
            bins.iter_mut()
                .zip(&found.histogram)
                .for_each(|(bin, count)| *bin += count);
        }
        let total: u32 = bins.iter().sum();
        let mut below = 0;
        let points = bins.iter().enumerate().map(|(bin, count)| {
            below += count;
            (bin_end(bin), 100.0 * f64::from(below) / f64::from(total))
        });
        // From the last bin without pixels to the first with all.
        let first = bins.iter().take_while(|count| **count == 0).count().saturating_sub(1);
        let last = bins.iter().rposition(|count| *count > 0).unwrap_or(0);
        let points = points.take(last + 1).skip(first);
        Curve {
            label: technique.to_owned(),
            points: points.collect(),
        }
    };
    Curves {
        title: format!("{scene}: texel ÷ pixel"),
        x: Axis {
            label: "texel ÷ pixel (root of the areas' ratio)".to_owned(),
            scale: Scale::Logarithmic,
            range: None,
        },
        y: Axis {
            label: "valid pixels up to it, %".to_owned(),
            scale: Scale::Linear,
            range: Some(0.0..100.0),
        },
        curves: techniques(report).into_iter().map(curve).collect(),
    }
}

/// Share of wrong pixels at a view depth.
fn distances(report: &Report, scene: &str) -> Curves {
    let curve = |technique: &str| {
        let mut bins: Vec<(f64, u32, u32)> = Vec::new();
        for found in report.rows_of(scene, technique).flat_map(|row| &row.distances) {
            let middle = (found.from_m * found.to_m).sqrt();
            match bins.iter_mut().find(|(other, ..)| *other == middle) {
                Some((_, valid, wrong)) => {
                    *valid += found.valid;
                    *wrong += found.wrong;
                }
                None => bins.push((middle, found.valid, found.wrong)),
            }
        }
        bins.sort_by(|a, b| a.0.total_cmp(&b.0));
        let points = bins.into_iter().filter(|(_, valid, _)| *valid >= FEWEST);
        Curve {
            label: technique.to_owned(),
            points: points
                .map(|(middle, valid, wrong)| (middle, 100.0 * f64::from(wrong) / f64::from(valid)))
                .collect(),
        }
    };
    let curves: Vec<Curve> = techniques(report).into_iter().map(curve).collect();
    let shares = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1));
    let most = shares.fold(0.0, f64::max) * 1.05;
    Curves {
        title: format!("{scene}: wrong by view depth"),
        x: Axis {
            label: "view depth, m".to_owned(),
            scale: Scale::Logarithmic,
            range: None,
        },
        y: Axis {
            label: "wrong pixels, % of the valid ones".to_owned(),
            scale: Scale::Linear,
            range: Some(0.0..most),
        },
        curves,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::judge::report::{self, Distance, TexelPixel};

    fn row(shot: &str, histogram: Vec<u32>, distances: &[(f64, u32, u32)]) -> report::Row {
        let distances = distances.iter().map(|(from_m, valid, wrong)| Distance {
            from_m: *from_m,
            to_m: from_m * 4.0,
            valid: *valid,
            wrong: *wrong,
        });
        report::Row {
            scene: "forest".to_owned(),
            shot: shot.to_owned(),
            technique: "lispsm".to_owned(),
            texel_pixel: Some(TexelPixel {
                histogram,
                ..TexelPixel::default()
            }),
            distances: distances.collect(),
            ..report::Row::default()
        }
    }

    #[test]
    fn plots_add_the_pixels_of_all_shots() {
        let report = Report {
            rows: vec![
                row("a", vec![0, 30], &[(1.0, 300, 30), (4.0, 100, 50)]),
                row("b", vec![10, 60], &[(1.0, 100, 10), (16.0, 150, 1)]),
            ],
            ..Report::default()
        };
        let sizes = texel_pixel(&report, "forest");
        assert_eq!(sizes.curves[0].points, [(bin_end(0), 10.0), (bin_end(1), 100.0)]);
        let far = distances(&report, "forest");
        assert_eq!(far.curves[0].points, [(2.0, 10.0)], "bins with few pixels are left out");
        let names = names(&report);
        assert_eq!(names.len(), 3, "{names:?}");
        assert_eq!(names[1], "plot_forest_texel-pixel_curves.png");
        assert!(super::names(&Report::default()).is_empty());
    }
}
