//! [`Curves`]: lines over two axes.

use bevy_math::UVec2;
use plotters::prelude::{BLACK, ChartBuilder, Color, PathElement};

use super::{
    axis::{Axis, number},
    canvas::{Area, FONT, Pixels, PlotError, TEXT_PX, color, draw, drawing},
    key::{Mark, head},
};

/// One line with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// For the key.
    pub label: String,
    /// In the order in which they are joined; values that are not finite or that the axes do not show are left out.
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
        draw(size, |area| self.draw_on(area))
    }

    fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        let points = self.curves.iter().flat_map(|curve| curve.points.iter().copied());
        points.filter(|point| self.shows(*point))
    }

    fn shows(&self, (x, y): (f64, f64)) -> bool {
        self.x.shows(x) && self.y.shows(y)
    }

    pub(super) fn draw_on(&self, area: &Area) -> Result<(), PlotError> {
        let empty = || PlotError::Empty(self.title.clone());
        let x = self.x.coordinate(self.points().map(|(x, _)| x)).ok_or_else(empty)?;
        let y = self.y.coordinate(self.points().map(|(_, y)| y)).ok_or_else(empty)?;
        let labels: Vec<String> = self.curves.iter().map(|curve| curve.label.clone()).collect();
        let area = head(area, &self.title, Mark::Line, &labels)?;
        let mut chart = ChartBuilder::on(&area)
            .margin(14)
            // The last number of the axis stands half outside.
            .margin_right(28)
            .x_label_area_size(46)
            .y_label_area_size(74)
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
            let points: Vec<_> = curve
                .points
                .iter()
                .copied()
                .filter(|point| self.shows(*point))
                .collect();
            let style = color(index).stroke_width(2);
            // One by one: joined, pieces of steep steps get lost.
            let pieces = points.windows(2).map(|ends| PathElement::new(ends.to_vec(), style));
            chart.draw_series(pieces).map_err(drawing)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Scale;

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
}
