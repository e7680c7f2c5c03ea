//! Which level is drawn at which distance (Giegl 2007, section 6.1).

use std::ops::Range;

/// What the borders of a chain mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum LodMetric {
    /// Metres from the eye, whatever the field of view.
    Distance,
    /// The size in the picture: borders are metres at which an eye with a vertical field of view of 60 degrees sees the
    /// same size. A narrower view sees finer levels.
    #[default]
    ProjectedSize,
}

/// Tangent of half the vertical field of view that borders are meant for: 60 degrees.
pub const REFERENCE_HALF_VIEW: f64 = 0.577_350_269_189_625_8;

/// How a view looks at levels of detail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LodEye {
    /// Tangent of half the vertical field of view.
    pub half_view: f64,
    /// Factor on every distance: above 1 coarser, below 1 finer.
    pub bias: f64,
}

impl Default for LodEye {
    fn default() -> Self {
        Self {
            half_view: REFERENCE_HALF_VIEW,
            bias: 1.0,
        }
    }
}

impl LodEye {
    /// Factor from metres to the distance that borders are compared with. Wrong values (not positive, NaN) count as 1.
    #[must_use]
    pub fn factor(&self, metric: LodMetric) -> f64 {
        let view = match metric {
            LodMetric::Distance => 1.0,
            LodMetric::ProjectedSize => self.half_view / REFERENCE_HALF_VIEW,
        };
        let factor = view * self.bias;
        if factor > 0.0 && factor.is_finite() {
            factor
        } else {
            1.0
        }
    }
}

/// Distance in metres at which a thing covers a share of the height of a picture of 60 degrees (`MSFT_screencoverage`):
/// height ÷ (2 tan 30° share). Infinite for shares that are not positive.
#[must_use]
pub fn distance_of_share(height: f64, share: f64) -> f64 {
    if share > 0.0 {
        height / (2.0 * REFERENCE_HALF_VIEW * share)
    } else {
        f64::INFINITY
    }
}

/// Borders of levels: level 0, the finest, up to the first border, level i from border i − 1 up to border i. A chain of
/// n levels has n − 1 borders, or n if the last level ends and nothing follows: then n is the level "nothing".
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LodBorders {
    /// Metres, rising.
    borders: Vec<f64>,
}

impl LodBorders {
    /// Borders in metres; those that fall, and those that are not numbers, are raised to the one before.
    #[must_use]
    pub fn new(borders: impl IntoIterator<Item = f64>) -> Self {
        let mut last = 0.0;
        let raised = borders.into_iter().map(|border| {
            last = border.max(last);
            last
        });
        Self {
            borders: raised.collect(),
        }
    }

    /// The borders.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.borders
    }

    /// Levels between them, "nothing" included where it follows.
    #[must_use]
    pub fn level_count(&self) -> usize {
        self.borders.len() + 1
    }

    /// The level at a distance, without memory.
    #[must_use]
    pub fn level_at(&self, distance: f64) -> usize {
        self.borders.partition_point(|border| *border <= distance)
    }

    /// Where a level is drawn, in metres.
    #[must_use]
    pub fn range(&self, level: usize) -> Range<f64> {
        let from = level.checked_sub(1).and_then(|i| self.borders.get(i));
        let to = self.borders.get(level);
        from.copied().unwrap_or(0.0)..to.copied().unwrap_or(f64::INFINITY)
    }

    /// The level at a distance, given the one before: finer levels come back only within (1 − `hysteresis`) of a border,
    /// so that an eye that sways around a border does not switch to and fro.
    #[must_use]
    pub fn held_level(&self, before: usize, distance: f64, hysteresis: f64) -> usize {
        let now = self.level_at(distance);
        if now >= before {
            return now;
        }
        // The finest level that has no border in between which still holds.
        let hold = 1.0 - hysteresis.clamp(0.0, 0.9);
        let held = self.borders[..before.min(self.borders.len())].partition_point(|border| *border * hold <= distance);
        held.max(now).min(before)
    }

    /// How far the distance may change before [`held_level`](Self::held_level) can give another level than `level`:
    /// until the eye has moved so far, nothing needs to be asked. Metres, 0 if it would change now.
    #[must_use]
    pub fn slack(&self, level: usize, distance: f64, hysteresis: f64) -> f64 {
        let hold = 1.0 - hysteresis.clamp(0.0, 0.9);
        let outward = self
            .borders
            .get(level)
            .map_or(f64::INFINITY, |border| border - distance);
        let inner = level.checked_sub(1).and_then(|i| self.borders.get(i));
        let inward = inner.map_or(f64::INFINITY, |border| distance - border * hold);
        outward.min(inward).max(0.0)
    }

    /// What is drawn where transitions follow the distance: a level, and where a border is near the next one and how far
    /// the crossing to it is (0 to 1, exclusive). The crossing of a border ends there, and begins `band` metres nearer,
    /// but not before the crossing of the border before has ended.
    #[must_use]
    pub fn blend_at(&self, distance: f64, band: f64) -> (usize, Option<f64>) {
        let level = self.level_at(distance);
        let Some(border) = self.borders.get(level) else {
            return (level, None);
        };
        let start = (border - band.max(0.0)).max(self.range(level).start);
        if distance <= start || *border <= start {
            return (level, None);
        }
        (level, Some((distance - start) / (border - start)))
    }
}
