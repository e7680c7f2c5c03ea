//! [`Axis`]: how values become places, and where its numbers stand.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

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

impl Axis {
    pub(super) fn shows(&self, value: f64) -> bool {
        let is_inside = self
            .range
            .as_ref()
            .is_none_or(|range| range.is_empty() || (range.start..=range.end).contains(&value));
        value.is_finite() && (self.scale == Scale::Linear || value > 0.0) && is_inside
    }

    /// What is shown: never without a length.
    pub(super) fn coordinate(&self, values: impl Iterator<Item = f64>) -> Option<Coordinate> {
        let (low, high) = values
            .map(|value| (value, value))
            .reduce(|(low, high), (value, _)| (low.min(value), high.max(value)))?;
        let wanted = self.range.clone().unwrap_or(low..high);
        let is_wide = wanted.end > wanted.start;
        let range = match self.scale {
            _ if is_wide => wanted,
            Scale::Linear => wanted.start - 0.5..wanted.start + 0.5,
            Scale::Logarithmic => wanted.start * 0.5..wanted.start * 2.0,
        };
        Some(Coordinate {
            range,
            scale: self.scale,
        })
    }
}

/// An axis with the range that it shows.
#[derive(Clone, Debug)]
pub(super) struct Coordinate {
    range: Range<f64>,
    scale: Scale,
}

impl Coordinate {
    /// Steps of 1, 2 or 5 times a power of ten, at most `most` of them.
    fn linear_ticks(&self, most: usize) -> Vec<f64> {
        let length = self.range.end - self.range.start;
        let rough = length / most.max(1) as f64;
        let power = 10.0_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .map(|factor| factor * power)
            .into_iter()
            .find(|step| *step >= rough * (1.0 - 1.0e-9))
            .unwrap_or(length);
        let first = (self.range.start / step - 1.0e-9).ceil();
        let count = ((self.range.end / step + 1.0e-9).floor() - first).max(0.0);
        (0..=count as usize)
            .map(|index| (first + index as f64) * step)
            .collect()
    }

    /// Powers of ten, thinned out when there are more than `most`; with 2 and 5 between them when there are few.
    fn logarithmic_ticks(&self, most: usize) -> Vec<f64> {
        let decades = |value: f64| value.log10();
        let (first, last) = (
            decades(self.range.start).floor() as i32,
            decades(self.range.end).ceil() as i32,
        );
        let inside = |factors: &[f64], stride: usize| -> Vec<f64> {
            let powers = (first..=last).filter(|power| power.rem_euclid(stride as i32) == 0);
            let all = powers.flat_map(|power| factors.iter().map(move |factor| factor * 10.0_f64.powi(power)));
            let slack = 1.0 + 1.0e-9;
            all.filter(|value| *value * slack >= self.range.start && *value <= self.range.end * slack)
                .collect()
        };
        for factors in [
            &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0][..],
            &[1.0, 2.0, 5.0],
            &[1.0],
        ] {
            let ticks = inside(factors, 1);
            if ticks.len() <= most {
                return ticks;
            }
        }
        (2..)
            .map(|stride| inside(&[1.0], stride))
            .find(|ticks| ticks.len() <= most.max(2))
            .unwrap_or_default()
    }
}

impl Ranged for Coordinate {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let place = |value: f64| match self.scale {
            Scale::Linear => value,
            Scale::Logarithmic => value.ln(),
        };
        let (start, end) = (place(self.range.start), place(self.range.end));
        let share = (place(*value) - start) / (end - start);
        // Far outside values are cut by the drawing area; they must not overflow here.
        let share = share.clamp(-10.0, 10.0);
        limit.0 + (f64::from(limit.1 - limit.0) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let most = hint.max_num_points();
        match self.scale {
            Scale::Linear => self.linear_ticks(most),
            // Lines without numbers may be close, numbers not.
            Scale::Logarithmic if hint.weight().allow_light_points() => self.logarithmic_ticks(most),
            Scale::Logarithmic => self.logarithmic_ticks(most.min(MOST_NUMBERS)),
        }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

/// Numbers on a logarithmic axis.
const MOST_NUMBERS: usize = 9;

impl ValueFormatter<f64> for Coordinate {
    fn format(value: &f64) -> String {
        number(*value)
    }
}

/// At most three digits that mean something; powers of ten for very large and very small values.
pub(super) fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude >= 99_999.5 || (magnitude > 0.0 && magnitude < 0.000_999_5) {
        let exponent = magnitude.log10().floor();
        let mantissa = number((value / 10.0_f64.powf(exponent) * 1000.0).round() / 1000.0);
        let power: String = format!("{exponent}").chars().map(superscript).collect();
        return match mantissa.as_str() {
            "1" => format!("10{power}"),
            _ => format!("{mantissa}·10{power}"),
        };
    }
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

fn superscript(digit: char) -> char {
    match digit {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinate(scale: Scale, range: Range<f64>) -> Coordinate {
        Coordinate { range, scale }
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
            (10_000.0, "10000"),
            (1.0e5, "10⁵"),
            (1.94e6, "1.94·10⁶"),
            (0.001, "0.001"),
            (2.0e-4, "2·10⁻⁴"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(
            coordinate(Scale::Linear, 1.0..40.0).linear_ticks(5),
            [10.0, 20.0, 30.0, 40.0]
        );
        assert_eq!(
            coordinate(Scale::Linear, -1.0..1.0).linear_ticks(4),
            [-1.0, -0.5, 0.0, 0.5, 1.0]
        );
        let ticks = |range, most| coordinate(Scale::Logarithmic, range).logarithmic_ticks(most);
        assert_eq!(ticks(1.0..40.0, 9), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(ticks(1.0..1.0e6, 9), [1.0, 10.0, 100.0, 1.0e3, 1.0e4, 1.0e5, 1.0e6]);
        assert_eq!(ticks(1.0..1.0e12, 9), [1.0, 1.0e2, 1.0e4, 1.0e6, 1.0e8, 1.0e10, 1.0e12]);
        assert_eq!(ticks(2.5..7.0, 9), [3.0, 4.0, 5.0, 6.0, 7.0]);
    }

    #[test]
    fn places_are_shares_of_the_axis() {
        let place = |scale, value: f64| coordinate(scale, 1.0..100.0).map(&value, (0, 200));
        assert_eq!(place(Scale::Logarithmic, 10.0), 100);
        assert_eq!(place(Scale::Linear, 50.5), 100);
        assert_eq!(place(Scale::Linear, 1.0e300), 2000);
    }
}
