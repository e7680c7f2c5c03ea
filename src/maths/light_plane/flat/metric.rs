//! Badness and the metrics over it.

use super::{Degenerate, Tilt};

/// What one pixel asks of a film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// l: where its ray meets the film, −1..=1 over the hull.
    pub place: f64,
    /// d = |dp/dl|: pixels per unit of place. Not negative; infinite where the light sees the surface edge-on.
    pub badness: f64,
}

impl Sample {
    /// The same pixel on a tilted film: dp/dl' = dp/dl · dl/dl' (Chong 3.1).
    #[must_use]
    pub fn tilted(self, tilt: Tilt) -> Self {
        Self {
            place: tilt.place(self.place),
            badness: self.badness * tilt.stretch(self.place),
        }
    }

    /// The same pixel on the part `low..=high` of the film, which then is −1..=1 (Chong 3.2).
    #[must_use]
    pub fn rescaled(self, low: f64, high: f64) -> Self {
        let width = high - low;
        Self {
            place: (2.0 * self.place - low - high) / width,
            badness: self.badness * width / 2.0,
        }
    }
}

/// Which sum of badness a film is to keep small (Chong 2.1.1). The number of pixels does not depend on the film, so these
/// are the mean and the mean square.
///
/// Over a hull without gaps in which every light ray meets one surface, constant badness is best by both
/// ([`smallest_mean_badness`]); then both choose the same film. Otherwise L2 gives away some mean for less spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Metric {
    /// Σ d.
    L1,
    /// Σ d².
    L2,
}

impl Metric {
    /// p of Lp.
    pub fn power(self) -> i32 {
        match self {
            Self::L1 => 1,
            Self::L2 => 2,
        }
    }
}

/// Σ dᵖ over the pixels of a tilted film.
pub fn total_badness(samples: &[Sample], tilt: Tilt, metric: Metric) -> f64 {
    let powers = samples
        .iter()
        .map(|sample| sample.tilted(tilt).badness.powi(metric.power()));
    powers.sum()
}

/// L∞: the largest badness on a tilted film, 0 without pixels.
pub fn largest_badness(samples: &[Sample], tilt: Tilt) -> f64 {
    samples
        .iter()
        .map(|sample| sample.tilted(tilt).badness)
        .fold(0.0, f64::max)
}

/// Texel footprints as the source tabulates them, in pixels per texel. They are means over *pixels*: over texels the mean
/// is pixels ÷ texels for every film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprints {
    /// The largest.
    pub worst: f64,
    /// The mean.
    pub average: f64,
    /// The standard deviation.
    pub deviation: f64,
}

impl Footprints {
    /// Of a tilted film with a number of texels; `None` without pixels.
    pub fn of(samples: &[Sample], tilt: Tilt, texels: f64) -> Option<Self> {
        if samples.is_empty() {
            return None;
        }
        let count = samples.len() as f64;
        let per_texel = 2.0 / texels;
        let average = total_badness(samples, tilt, Metric::L1) / count * per_texel;
        let squares = samples
            .iter()
            .map(|sample| (sample.tilted(tilt).badness * per_texel - average).powi(2));
        Some(Self {
            worst: largest_badness(samples, tilt) * per_texel,
            average,
            deviation: (squares.sum::<f64>() / count).sqrt(),
        })
    }

    /// Of a tilt away from a film with the same badness everywhere: pixels spread evenly over the places of the best film,
    /// one pixel per texel there. In closed form, max = (1 + k) ÷ (1 − k), mean = (1 + k² ÷ 3) ÷ (1 − k²), mean square =
    /// (1 + 2 k² + k⁴ ÷ 5) ÷ (1 − k²)²: integrals of (1 + k l)² and (1 + k l)⁴.
    pub fn of_even_pixels(tilt: Tilt) -> Self {
        let strength = tilt.strength().abs();
        let square = strength * strength;
        let average = (1.0 + square / 3.0) / (1.0 - square);
        let mean_square = (1.0 + 2.0 * square + square * square / 5.0) / (1.0 - square).powi(2);
        Self {
            worst: (2.0 * tilt.parameter.abs()).exp(),
            average,
            deviation: (mean_square - average * average).max(0.0).sqrt(),
        }
    }

    /// The source's last column: mean plus one standard deviation.
    pub fn average_and_deviation(&self) -> f64 {
        self.average + self.deviation
    }
}

/// Pixels ÷ texels: no film has a smaller mean of pixels per texel if every light ray meets one surface (by Jensen's
/// inequality, since ∫ d dp = ∫ d² dl and ∫ d dl = |Ω| for all films; Chong 2.1.2, who leaves the condition unsaid). A film
/// that reaches it wastes no texel and has constant badness. In L2 the same number squared.
pub fn smallest_mean_badness(pixels: usize, texels: f64) -> f64 {
    pixels as f64 / texels
}

/// The share of a tilted film that serves no pixel, each pixel taken half a pixel wide to both sides (lost texels,
/// Chong 3). 0..=1.
///
/// # Errors
/// [`Degenerate::NotFinite`] for NaN or an infinite tilt.
pub fn lost_share(samples: &[Sample], tilt: Tilt) -> Result<f64, Degenerate> {
    let has_nan = |sample: &Sample| sample.place.is_nan() || sample.badness.is_nan();
    if samples.iter().any(has_nan) || !tilt.parameter.is_finite() {
        return Err(Degenerate::NotFinite);
    }
    let spans = samples.iter().map(|sample| {
        let (low, high) = pixel_span(*sample);
        (tilt.place(low), tilt.place(high))
    });
    let mut spans: Vec<(f64, f64)> = spans.collect();
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut used, mut end) = (0.0, -1.0_f64);
    for (low, high) in spans {
        used += (high - low.max(end)).max(0.0);
        end = end.max(high);
    }
    Ok((1.0 - used / 2.0).clamp(0.0, 1.0))
}

/// What of the film a pixel covers: 1 ÷ (2 d) to both sides, without what lies outside.
pub(super) fn pixel_span(sample: Sample) -> (f64, f64) {
    let half = 0.5 / sample.badness;
    ((sample.place - half).max(-1.0), (sample.place + half).min(1.0))
}
