//! [`HeatMap`]: a value for every direction above a viewer, as colors on a disc.

use std::{f64::consts::TAU, ops::Range};

use bevy_math::UVec2;
use plotters::{
    prelude::{BLACK, Color, PathElement, RGBColor, Text},
    style::text_anchor::{HPos, Pos, VPos},
    style::{IntoFont, IntoTextStyle},
};

use super::{
    axis::number,
    canvas::{Area, FONT, Pixels, PlotError, TEXT_PX, TITLE_PX, draw, drawing},
    key::titled,
};

/// Values over the directions of a hemisphere, as colors on a logarithmic scale: overhead in the middle, the horizon
/// around it, with five lines of equal values per power of ten; ahead on the right, behind on the left; the distance from the middle is the angle from overhead.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatMap {
    /// Above the figure.
    pub title: String,
    /// Quantity and unit of the values.
    pub label: String,
    /// From the middle to the horizon: rings of values in equal steps of the angle, each from ahead round in equal steps.
    /// Rings may have different numbers of values; the middle has one.
    pub rings: Vec<Vec<f64>>,
    /// What the colors show; `None`: all values. Values must be above zero.
    pub range: Option<Range<f64>>,
}

/// From low to high, each lighter than the one before.
const COLORS: [[f64; 3]; 6] = [
    [38.0, 16.0, 78.0],
    [48.0, 70.0, 140.0],
    [34.0, 124.0, 142.0],
    [60.0, 174.0, 110.0],
    [160.0, 212.0, 64.0],
    [252.0, 230.0, 60.0],
];

/// Lines of equal values per power of ten.
const LINES_PER_DECADE: f64 = 5.0;

/// Pixels for the color scale and its numbers, on the right.
const SCALE_WIDTH: i32 = 110;
/// Pixels of the color scale itself.
const SCALE_BAR: i32 = 20;

impl HeatMap {
    /// Draws the figure.
    ///
    /// # Errors
    /// The size is too small, or there is no value to show.
    pub fn draw(&self, size: UVec2) -> Result<Pixels, PlotError> {
        draw(size, |area| self.draw_on(area))
    }

    pub(super) fn draw_on(&self, area: &Area) -> Result<(), PlotError> {
        let range = self.decades().ok_or_else(|| PlotError::Empty(self.title.clone()))?;
        let area = titled(&titled(area, &self.title, TITLE_PX)?, &self.label, TEXT_PX)?;
        let (width, height) = area.dim_in_pixel();
        let (width, height) = (width as i32 - SCALE_WIDTH, height as i32);
        let radius = (width.min(height) / 2 - 26).max(1);
        let middle = (width / 2, height / 2);
        for y in -radius..=radius {
            for x in -radius..=radius {
                let value = |x: i32, y: i32| {
                    let value = self.value(f64::from(x) / f64::from(radius), f64::from(-y) / f64::from(radius));
                    value.map(f64::log10)
                };
                let Some(here) = value(x, y) else { continue };
                // A line where the value passes a step, against the neighbours to the right and below.
                let step = |value: f64| (value * LINES_PER_DECADE).floor();
                let neighbours = [value(x + 1, y), value(x, y + 1)];
                let is_line = neighbours.into_iter().flatten().any(|value| step(value) != step(here));
                let RGBColor(red, green, blue) = color_of((here - range.start) / (range.end - range.start));
                let color = if is_line {
                    [red, green, blue].map(|channel| channel / 2 + 96)
                } else {
                    [red, green, blue]
                };
                let place = (middle.0 + x, middle.1 + y);
                let color = RGBColor(color[0], color[1], color[2]);
                area.draw_pixel(place, &color).map_err(drawing)?;
            }
        }
        let text = (FONT, TEXT_PX).into_font().into_text_style(&area);
        let text = |at, down| text.pos(Pos::new(at, down));
        for (word, place, at, down) in [
            (
                "behind",
                (middle.0 - radius, middle.1 - radius),
                HPos::Left,
                VPos::Center,
            ),
            (
                "ahead",
                (middle.0 + radius, middle.1 - radius),
                HPos::Right,
                VPos::Center,
            ),
        ] {
            area.draw(&Text::new(word, place, text(at, down))).map_err(drawing)?;
        }
        for (from, to) in [(-radius - 12, -radius - 2), (radius + 2, radius + 12)] {
            let line = PathElement::new([(middle.0 + from, middle.1), (middle.0 + to, middle.1)], BLACK.mix(0.6));
            area.draw(&line).map_err(drawing)?;
        }
        // The scale: high values on top.
        let (left, top, bottom) = (width + 4, middle.1 - radius, middle.1 + radius);
        for y in top..=bottom {
            let share = f64::from(bottom - y) / f64::from(bottom - top);
            let row = PathElement::new([(left, y), (left + SCALE_BAR, y)], color_of(share));
            area.draw(&row).map_err(drawing)?;
        }
        for value in ticks(&range) {
            let share = (value.log10() - range.start) / (range.end - range.start);
            let y = bottom - (f64::from(bottom - top) * share).round() as i32;
            let tick = PathElement::new([(left + SCALE_BAR, y), (left + SCALE_BAR + 5, y)], BLACK);
            area.draw(&tick).map_err(drawing)?;
            let place = (left + SCALE_BAR + 9, y);
            area.draw(&Text::new(number(value), place, text(HPos::Left, VPos::Center)))
                .map_err(drawing)?;
        }
        Ok(())
    }

    /// Logarithms of the smallest and the largest color; never without a length.
    fn decades(&self) -> Option<Range<f64>> {
        let values = self.rings.iter().flatten().copied();
        let shown = values.filter(|value| value.is_finite() && *value > 0.0);
        let (low, high) = shown
            .map(|value| (value, value))
            .reduce(|(low, high), (value, _)| (low.min(value), high.max(value)))?;
        let range = self.range.clone().unwrap_or(low..high);
        let (low, high) = (range.start.log10(), range.end.log10());
        let is_sound = low.is_finite() && high.is_finite();
        let is_long = high - low > 1.0e-6;
        let range = if is_long { low..high } else { low - 0.5..low + 0.5 };
        is_sound.then_some(range)
    }

    /// The value at a place of the unit disc, right and up, between the four around it. `None` outside and where there is
    /// none above zero.
    fn value(&self, right: f64, up: f64) -> Option<f64> {
        let radius = right.hypot(up);
        let last = self.rings.len().checked_sub(1)?;
        if radius > 1.0 {
            return None;
        }
        let ring = radius * last as f64;
        let turn = up.atan2(right).rem_euclid(TAU) / TAU;
        let on_ring = |index: usize| -> Option<f64> {
            let values = &self.rings[index.min(last)];
            let place = turn * values.len() as f64;
            let (before, share) = (place.floor(), place.fract());
            let value = |step: usize| values.get((before as usize + step) % values.len().max(1));
            Some(value(0)?.ln() * (1.0 - share) + value(1)?.ln() * share)
        };
        let (inner, outer) = (on_ring(ring.floor() as usize)?, on_ring(ring.floor() as usize + 1)?);
        let value = (inner * (1.0 - ring.fract()) + outer * ring.fract()).exp();
        (value.is_finite() && value > 0.0).then_some(value)
    }
}

/// Powers of ten inside; their 2 and 5 times too where there are few.
fn ticks(range: &Range<f64>) -> Vec<f64> {
    let factors: &[f64] = if range.end - range.start > 3.0 {
        &[1.0]
    } else {
        &[1.0, 2.0, 5.0]
    };
    let powers = range.start.floor() as i32..=range.end.ceil() as i32;
    let all = powers.flat_map(|power| factors.iter().map(move |factor| factor * 10.0_f64.powi(power)));
    let inside = range.start - 1.0e-9..=range.end + 1.0e-9;
    all.filter(|value| inside.contains(&value.log10())).collect()
}

/// The color at a share of the scale.
fn color_of(share: f64) -> RGBColor {
    let place = share.clamp(0.0, 1.0) * (COLORS.len() - 1) as f64;
    let index = (place as usize).min(COLORS.len() - 2);
    let between = place - index as f64;
    let [red, green, blue] = [0, 1, 2].map(|channel| {
        let (low, high) = (COLORS[index][channel], COLORS[index + 1][channel]);
        (low + (high - low) * between).round() as u8
    });
    RGBColor(red, green, blue)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(rings: Vec<Vec<f64>>) -> HeatMap {
        HeatMap {
            title: "a map".to_owned(),
            label: "storage factor".to_owned(),
            rings,
            range: None,
        }
    }

    #[test]
    fn values_lie_between_their_neighbours() {
        let map = figure(vec![vec![1.0], vec![100.0, 100.0, 100.0, 100.0]]);
        let value = |right, up| map.value(right, up).expect("inside");
        assert!((value(0.0, 0.0) - 1.0).abs() < 1.0e-9);
        assert!((value(0.0, -0.5) - 10.0).abs() < 1.0e-9);
        assert!((value(1.0, 0.0) - 100.0).abs() < 1.0e-9);
        assert_eq!(map.value(0.8, 0.8), None);
        // Ahead is on the right, behind on the left; azimuths turn towards the top.
        let map = figure(vec![vec![1.0], vec![10.0, 20.0, 30.0, 40.0]]);
        for (right, up, expected) in [(1.0, 0.0, 10.0), (0.0, 1.0, 20.0), (-1.0, 0.0, 30.0), (0.0, -1.0, 40.0)] {
            let value = map.value(right, up).expect("inside");
            assert!((value / expected - 1.0).abs() < 1.0e-6, "{right}, {up}: {value}");
        }
    }

    #[test]
    fn colors_get_lighter() {
        let lightness = |share: f64| {
            let RGBColor(red, green, blue) = color_of(share);
            0.3 * f64::from(red) + 0.6 * f64::from(green) + 0.1 * f64::from(blue)
        };
        let all: Vec<f64> = (0..=50).map(|step| lightness(f64::from(step) / 50.0)).collect();
        assert!(all.is_sorted_by(|a, b| a < b));
        assert_eq!(color_of(-3.0), color_of(0.0));
    }

    #[test]
    fn a_map_is_drawn_or_a_sentence() {
        let size = UVec2::new(400, 300);
        let pixels = figure(vec![vec![1.0], vec![10.0; 8]]).draw(size).expect("drawn");
        let (colors, _) = pixels.bytes.as_chunks::<3>();
        assert!(colors.contains(&[38, 16, 78]) && colors.contains(&[252, 230, 60]));
        // The scale beside it has all colors.
        let scale = colors
            .chunks(400)
            .map(|row| row[310])
            .filter(|color| *color != [255; 3])
            .count();
        assert!(scale > 100, "{scale} rows of the scale");
        assert!(figure(vec![vec![5.0], vec![5.0]]).draw(size).is_ok(), "one value");
        for rings in [vec![], vec![vec![]], vec![vec![f64::NAN], vec![0.0, -1.0]]] {
            assert_eq!(figure(rings).draw(size), Err(PlotError::Empty("a map".to_owned())));
        }
    }
}
