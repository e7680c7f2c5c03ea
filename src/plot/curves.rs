//! [`Curves`]: lines over two axes.

use std::ops::Range;

use bevy::math::UVec2;
use plotters::{
    coord::{
        Shift,
        ranged1d::{AsRangedCoord, ValueFormatter},
    },
    prelude::{
        BLACK, BitMapBackend, ChartBuilder, Color, DrawingArea, IntoLogRange, LineSeries, PathElement,
        SeriesLabelPosition, WHITE,
    },
};

use super::canvas::{FONT, Pixels, PlotError, TEXT_PX, TITLE_PX, color, draw, drawing};

/// How values become places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps.
    Linear,
    /// Equal ratios; values that are not above zero are left out.
    Logarithmic,
}

/// One axis of a figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// How values become places.
    pub scale: Scale,
    /// What is shown; `None`: all values.
    pub range: Option<Range<f64>>,
}

/// One line with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// For the key.
    pub label: String,
    /// In the order in which they are joined; values that are not finite are left out.
    pub points: Vec<(f64, f64)>,
}

/// Lines over two axes, with a key.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Above the figure.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// In the order of their colors.
    pub curves: Vec<Curve>,
}

impl Curves {
    /// Draws the figure.
    ///
    /// # Errors
    /// The size is too small, or there is no value to show.
    pub fn draw(&self, size: UVec2) -> Result<Pixels, PlotError> {
        let empty = || PlotError::Empty(self.title.clone());
        let x = self.x.extent(self.points().map(|(x, _)| x)).ok_or_else(empty)?;
        let y = self.y.extent(self.points().map(|(_, y)| y)).ok_or_else(empty)?;
        draw(size, |area| match (self.x.scale, self.y.scale) {
            (Scale::Linear, Scale::Linear) => self.draw_on(area, x, y),
            (Scale::Linear, Scale::Logarithmic) => self.draw_on(area, x, y.log_scale()),
            (Scale::Logarithmic, Scale::Linear) => self.draw_on(area, x.log_scale(), y),
            (Scale::Logarithmic, Scale::Logarithmic) => self.draw_on(area, x.log_scale(), y.log_scale()),
        })
    }

    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let points = self.curves.iter().flat_map(|curve| curve.points.iter().copied());
        points.filter(|point| self.shows(*point))
    }

    fn shows(&self, (x, y): (f64, f64)) -> bool {
        self.x.shows(x) && self.y.shows(y)
    }

    fn draw_on<X, Y>(&self, area: &DrawingArea<BitMapBackend, Shift>, x: X, y: Y) -> Result<(), PlotError>
    where
        X: AsRangedCoord<Value = f64, CoordDescType: ValueFormatter<f64>>,
        Y: AsRangedCoord<Value = f64, CoordDescType: ValueFormatter<f64>>,
    {
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, (FONT, TITLE_PX))
            .margin(14)
            .x_label_area_size(46)
            .y_label_area_size(66)
            .build_cartesian_2d(x, y)
            .map_err(drawing)?;
        chart
            .configure_mesh()
            .light_line_style(BLACK.mix(0.05))
            .bold_line_style(BLACK.mix(0.15))
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .x_label_formatter(&|value| number(*value))
            .y_label_formatter(&|value| number(*value))
            .label_style((FONT, TEXT_PX))
            .axis_desc_style((FONT, TEXT_PX))
            .draw()
            .map_err(drawing)?;
        for (index, curve) in self.curves.iter().enumerate() {
            let points = curve.points.iter().copied().filter(|point| self.shows(*point));
            let style = color(index).stroke_width(2);
            chart
                .draw_series(LineSeries::new(points, style))
                .map_err(drawing)?
                .label(&curve.label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 22, y)], style));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .label_font((FONT, TEXT_PX))
            .draw()
            .map_err(drawing)
    }
}

impl Axis {
    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0)
    }

    /// What is shown: never without a length.
    fn extent(&self, values: impl Iterator<Item = f64>) -> Option<Range<f64>> {
        let (low, high) = values
            .map(|value| (value, value))
            .reduce(|(low, high), (value, _)| (low.min(value), high.max(value)))?;
        let wanted = self.range.clone().unwrap_or(low..high);
        let is_wide = wanted.end > wanted.start;
        Some(match self.scale {
            _ if is_wide => wanted,
            Scale::Linear => wanted.start - 0.5..wanted.start + 0.5,
            Scale::Logarithmic => wanted.start * 0.5..wanted.start * 2.0,
        })
    }
}

/// At most three digits that mean something.
pub(super) fn number(value: f64) -> String {
    let magnitude = value.abs();
    let decimals = match magnitude {
        _ if magnitude >= 100.0 || magnitude == 0.0 => 0,
        _ if magnitude >= 10.0 => 1,
        _ if magnitude >= 1.0 => 2,
        _ => 3,
    };
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(scale: Scale) -> Axis {
        Axis {
            label: "metres".to_owned(),
            scale,
            range: None,
        }
    }

    fn figure(scale: Scale, points: &[(f64, f64)]) -> Curves {
        Curves {
            title: "a figure".to_owned(),
            x: axis(scale),
            y: axis(Scale::Linear),
            curves: vec![Curve {
                label: "a curve".to_owned(),
                points: points.to_vec(),
            }],
        }
    }

    #[test]
    fn a_figure_has_text_and_its_curve() {
        let size = UVec2::new(400, 300);
        let pixels = figure(Scale::Linear, &[(0.0, 0.0), (1.0, 1.0)])
            .draw(size)
            .expect("drawn");
        assert_eq!(pixels.bytes.len(), 400 * 300 * 3);
        let (colors, _) = pixels.bytes.as_chunks::<3>();
        let blue = colors.iter().filter(|color| **color == [31, 119, 180]).count();
        assert!(blue > 250, "{blue} pixels of the curve");
        let title = colors[..400 * 40].iter().filter(|color| color[0] < 100).count();
        assert!(title > 40, "{title} dark pixels of the title");
        let again = figure(Scale::Linear, &[(0.0, 0.0), (1.0, 1.0)]).draw(size);
        assert_eq!(again, Ok(pixels), "deterministic");
    }

    #[test]
    fn nonsense_is_a_sentence() {
        let size = UVec2::new(400, 300);
        assert_eq!(
            figure(Scale::Linear, &[]).draw(size),
            Err(PlotError::Empty("a figure".to_owned()))
        );
        assert!(
            figure(Scale::Logarithmic, &[(0.0, 1.0), (f64::NAN, 1.0)])
                .draw(size)
                .is_err()
        );
        assert_eq!(
            figure(Scale::Linear, &[(0.0, 0.0)]).draw(UVec2::new(5, 300)),
            Err(PlotError::TooSmall(UVec2::new(5, 300)))
        );
        for scale in [Scale::Linear, Scale::Logarithmic] {
            assert!(figure(scale, &[(3.0, 2.0)]).draw(size).is_ok(), "one point");
        }
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (0.125, "0.125"),
            (2.5, "2.5"),
            (100.0, "100"),
            (64.0, "64"),
            (1000.0, "1000"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
