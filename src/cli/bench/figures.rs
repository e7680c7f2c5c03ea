//! frame_times.png and pass_times.png.

use std::path::Path;

use bevy::math::UVec2;
use image::ColorType;

use super::report::{Report, TechniqueReport, is_of_shadows};
use crate::{
    cli::{Failure, pictures},
    plot::{Axis, Bars, Curve, Curves, Pixels, PlotError, Row, Scale},
};

/// Pixels of a figure.
const SIZE: UVec2 = UVec2::new(960, 540);
/// Pixels that a bar adds to a figure.
const BAR_HEIGHT: u32 = 20;

/// Writes both figures; one without values is left out.
pub(super) fn write(report: &Report, out: &Path) -> Result<(), Failure> {
    let passes = pass_times(report);
    let bars = passes.rows.len() * passes.series.len();
    let height = SIZE.y.max(140 + bars as u32 * BAR_HEIGHT);
    for (name, figure) in [
        ("frame_times.png", frame_times(report).draw(SIZE)),
        ("pass_times.png", passes.draw(UVec2::new(SIZE.x, height))),
    ] {
        match figure {
            Ok(Pixels { size, bytes }) => {
                pictures::write_pixels(&out.join(name), size, &bytes, ColorType::Rgb8).map_err(Failure::failed)?;
            }
            Err(PlotError::Empty(_)) => {}
            Err(error) => return Err(Failure::failed(error)),
        }
    }
    Ok(())
}

/// Time of every frame over the path.
fn frame_times(report: &Report) -> Curves {
    let axis = |label: &str, range| Axis {
        label: label.to_owned(),
        scale: Scale::Linear,
        range,
    };
    let curves = report.techniques.iter().map(|technique| Curve {
        label: technique.technique.clone(),
        points: technique
            .all
            .iter()
            .map(|row| (f64::from(row.path_s), row.ms))
            .collect(),
    });
    let slowest = report.techniques.iter().map(|technique| technique.frame_ms.slowest);
    Curves {
        title: report.title(),
        x: axis("seconds on the path", None),
        y: axis(
            "frame time, ms",
            slowest.reduce(f64::max).map(|slowest| 0.0..slowest * 1.05),
        ),
        curves: curves.collect(),
    }
}

/// Medians of the passes that draw and apply shadows, by technique.
fn pass_times(report: &Report) -> Bars {
    let mut passes: Vec<&String> = report
        .techniques
        .iter()
        .flat_map(|technique| technique.pass_ms.keys())
        .filter(|pass| is_of_shadows(pass))
        .collect();
    passes.sort();
    passes.dedup();
    let time = |technique: &TechniqueReport, pass: &String| {
        let times = technique.pass_ms.get(pass)?;
        if report.has_gpu_times { times.gpu } else { times.cpu }
    };
    let processor = if report.has_gpu_times { "GPU" } else { "CPU" };
    Bars {
        title: format!("{}: passes of shadows", report.title()),
        label: format!("{processor} time, ms, median"),
        series: passes.iter().map(|pass| (*pass).clone()).collect(),
        rows: report
            .techniques
            .iter()
            .map(|technique| Row {
                label: technique.technique.clone(),
                values: passes.iter().map(|pass| time(technique, pass)).collect(),
            })
            .collect(),
    }
}
