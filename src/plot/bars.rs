//! [`Bars`]: a value per row and series, as horizontal bars.

use bevy_math::UVec2;
use plotters::{
    prelude::{BLACK, ChartBuilder, Color, Rectangle, Text},
    style::text_anchor::{HPos, Pos, VPos},
    style::{IntoFont, IntoTextStyle},
};

use super::{
    axis::number,
    canvas::{Area, FONT, Pixels, PlotError, TEXT_PX, color, draw, drawing},
    key::{Mark, head},
};

/// One row of bars.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// To the left of the bars.
    pub label: String,
    /// One per series; `None` or not finite: no bar.
    pub values: Vec<Option<f64>>,
}

/// Horizontal bars, the first row on top, with their values written beside them.
#[derive(Clone, Debug, PartialEq)]
pub struct Bars {
    /// Above the figure.
    pub title: String,
    /// Quantity and unit of the values, which begin at zero.
    pub label: String,
    /// Names of the series, in the order of their colors.
    pub series: Vec<String>,
    /// From top to bottom.
    pub rows: Vec<Row>,
}

/// Share of a row that its bars fill.
const FILLED: f64 = 0.8;

impl Bars {
    /// Draws the figure.
    ///
    /// # Errors
    /// The size is too small, or there is no value to show.
    pub fn draw(&self, size: UVec2) -> Result<Pixels, PlotError> {
        draw(size, |area| self.draw_on(area))
    }

    pub(super) fn draw_on(&self, area: &Area) -> Result<(), PlotError> {
        let values = self.rows.iter().flat_map(|row| row.values.iter().flatten().copied());
        let largest = values.filter(|value| value.is_finite()).reduce(f64::max);
        let largest = largest.ok_or_else(|| PlotError::Empty(self.title.clone()))?;
        let largest = if largest > 0.0 { largest } else { 1.0 };
        let area = &head(area, &self.title, Mark::Box, &self.series)?;
        let count = self.rows.len() as f64;
        let longest = self.rows.iter().map(|row| row.label.chars().count()).max().unwrap_or(0);
        let mut chart = ChartBuilder::on(area)
            .margin(14)
            .x_label_area_size(46)
            // Labels of rows stand in their own column; the mean letter is half as wide as it is high.
            .margin_left(14 + (longest as u32 * TEXT_PX).div_ceil(2))
            .build_cartesian_2d(0.0..largest * 1.15, 0.0..count)
            .map_err(drawing)?;
        chart
            .configure_mesh()
            .disable_y_mesh()
            .light_line_style(BLACK.mix(0.05))
            .bold_line_style(BLACK.mix(0.15))
            .x_desc(&self.label)
            .x_label_formatter(&|value| number(*value))
            .label_style((FONT, TEXT_PX))
            .axis_desc_style((FONT, TEXT_PX))
            .draw()
            .map_err(drawing)?;
        let height = FILLED / self.series.len().max(1) as f64;
        let text = (FONT, TEXT_PX).into_font().into_text_style(area);
        let value_text = text.pos(Pos::new(HPos::Left, VPos::Center));
        for index in 0..self.series.len() {
            let bars = self.rows.iter().enumerate().filter_map(|(row, of_row)| {
                let value = of_row
                    .values
                    .get(index)
                    .copied()
                    .flatten()
                    .filter(|value| value.is_finite())?;
                let top = count - row as f64 - (1.0 - FILLED) * 0.5 - index as f64 * height;
                Some((value, top))
            });
            let style = color(index).filled();
            chart
                .draw_series(
                    bars.clone()
                        .map(|(value, top)| Rectangle::new([(0.0, top), (value, top - height)], style)),
                )
                .map_err(drawing)?;
            chart
                .draw_series(bars.map(|(value, top)| {
                    let place = (value + largest * 0.008, top - height * 0.5);
                    Text::new(number(value), place, value_text.clone())
                }))
                .map_err(drawing)?;
        }
        let label_text = (FONT, TEXT_PX).into_font().into_text_style(area);
        let label_text = label_text.pos(Pos::new(HPos::Right, VPos::Center));
        // Places of the chart count from the corner of the whole picture, those of the area from its own.
        let corner = area.get_base_pixel();
        for (row, of_row) in self.rows.iter().enumerate() {
            let (x, y) = chart.backend_coord(&(0.0, count - row as f64 - 0.5));
            area.draw(&Text::new(
                of_row.label.clone(),
                (x - corner.0 - 8, y - corner.1),
                label_text.clone(),
            ))
            .map_err(drawing)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(values: &[Option<f64>]) -> Bars {
        Bars {
            title: "bars".to_owned(),
            label: "%".to_owned(),
            series: vec!["forest".to_owned()],
            rows: values
                .iter()
                .map(|value| Row {
                    label: "a technique".to_owned(),
                    values: vec![*value],
                })
                .collect(),
        }
    }

    #[test]
    fn bars_are_as_long_as_their_values() {
        let size = UVec2::new(600, 300);
        let pixels = figure(&[Some(4.0), Some(2.0)]).draw(size).expect("drawn");
        let (colors, _) = pixels.bytes.as_chunks::<3>();
        let length = |y: usize| {
            colors[y * 600..(y + 1) * 600]
                .iter()
                .filter(|color| **color == [31, 119, 180])
                .count()
        };
        // The rows of the first and of the second bar, below title and key.
        let (first, second) = (length(120), length(200));
        assert!(
            first > 200 && (first as f64 / second as f64 - 2.0).abs() < 0.05,
            "{first} and {second}"
        );
    }

    /// The dark pixels to the left of the axis are centred on the bars.
    #[test]
    fn labels_stand_beside_their_bars() {
        let pixels = figure(&[Some(4.0)]).draw(UVec2::new(600, 300)).expect("drawn");
        let (colors, _) = pixels.bytes.as_chunks::<3>();
        let middle = |is_part: &dyn Fn(usize, &[u8; 3]) -> bool| {
            let rows = (60..250).filter(|y| (0..600).any(|x| is_part(x, &colors[y * 600 + x])));
            let rows: Vec<usize> = rows.collect();
            rows.iter().sum::<usize>() as f64 / rows.len() as f64
        };
        let bar = middle(&|x, color| x > 150 && *color == [31, 119, 180]);
        let label = middle(&|x, color| x < 90 && color[0] < 100);
        assert!((bar - label).abs() < 8.0, "bar at {bar}, label at {label}");
    }

    /// The key has its own place: bars as long as the axis are all there to see.
    #[test]
    fn the_key_covers_no_bar() {
        let mut figure = figure(&[Some(4.0), Some(4.0), Some(4.0)]);
        figure.series[0] = "a series with a long name that would lie over the ends of the bars".to_owned();
        let pixels = figure.draw(UVec2::new(600, 300)).expect("drawn");
        let (colors, _) = pixels.bytes.as_chunks::<3>();
        let longest = (60..300).map(|y| {
            let row = &colors[y * 600..(y + 1) * 600];
            row.iter().filter(|color| **color == [31, 119, 180]).count()
        });
        let rows = longest.filter(|length| *length > 200).count();
        assert!(rows > 100, "{rows} rows of pixels with whole bars");
    }

    #[test]
    fn nothing_is_a_sentence_and_zero_is_a_figure() {
        let size = UVec2::new(600, 300);
        assert_eq!(figure(&[]).draw(size), Err(PlotError::Empty("bars".to_owned())));
        assert!(figure(&[None, Some(f64::NAN)]).draw(size).is_err());
        assert!(figure(&[Some(0.0), None]).draw(size).is_ok());
    }
}
