//! Nearly stable uniform maps: focused, with a scale from 64 levels ("reduce swimming", Stingl 2011, section 3.5, after
//! Zhang et al. 2009).
//!
//! The thesis gives no formula. Derivation: a focused map shows a half extent h that varies with the camera, below a
//! reference r that does not (the light-space extent of the scene S). The scale r ÷ h must come from a fixed set, so h
//! is rounded *up* to the next of 64 levels h_1 < … < h_64 = r; then the middle is snapped to that level's texels
//! ([`SnappedMap`]). Between changes of level the grid stands still.
//!
//! - [`Spacing::Equal`]: h_k = r k ÷ 64. The step is the same in metres, so texels are too large by a factor of up to
//!   1 + r ÷ (64 h): nothing for h near r, twice for h = r ÷ 64.
//! - [`Spacing::Geometric`]: h_k = r q^(k − 64) with q = (r ÷ h_1)^(1 ÷ 63). The factor is at most q everywhere: 1.076
//!   for r ÷ h_1 = 100. Better whenever the focus varies by more than a few times.
//!
//! A level that a jitter crosses would flicker each frame; [`ScaleLevels::held`] lowers the level only when two steps
//! are won.

use bevy_math::DVec2;

use super::sphere::SnappedMap;

/// Number of levels (Stingl, section 3.5).
pub const LEVEL_COUNT: u32 = 64;

/// How levels are spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spacing {
    /// Equal steps in metres.
    Equal,
    /// Equal ratios from this half extent on, in metres.
    Geometric {
        /// The half extent of the lowest level; smaller ones use it.
        smallest: f64,
    },
}

/// The half extents that maps may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScaleLevels {
    /// The largest half extent, metres: that of the scene in the light plane.
    pub reference: f64,
    /// How levels are spread below it.
    pub spacing: Spacing,
}

impl ScaleLevels {
    /// Half extent of a level in 1..=64, metres.
    pub fn half_extent(&self, level: u32) -> f64 {
        let level = f64::from(level.clamp(1, LEVEL_COUNT));
        let count = f64::from(LEVEL_COUNT);
        match self.spacing {
            Spacing::Equal => self.reference * level / count,
            Spacing::Geometric { smallest } => {
                self.reference * (smallest / self.reference).powf((count - level) / (count - 1.0))
            }
        }
    }

    /// The lowest level that shows a half extent. `None` if none does: it exceeds the reference, or is NaN.
    pub fn level(&self, half_extent: f64) -> Option<u32> {
        (1..=LEVEL_COUNT).find(|level| half_extent <= self.half_extent(*level) * (1.0 + 1.0e-12))
    }

    /// The level to use after `previous`: the lowest that shows the half extent, unless the previous one is just above.
    pub fn held(&self, previous: Option<u32>, half_extent: f64) -> Option<u32> {
        let lowest = self.level(half_extent)?;
        Some(previous.filter(|level| *level == lowest + 1).unwrap_or(lowest))
    }

    /// The stable map of a focus rectangle in the light plane (fixed axes), and its levels, which are the next frame's
    /// `previous`. Each axis has its own level. `None` if a side exceeds the reference.
    pub fn stabilised(
        &self,
        previous: Option<[u32; 2]>,
        min: DVec2,
        max: DVec2,
        map_size: u32,
    ) -> Option<(SnappedMap, [u32; 2])> {
        let half = (max - min) * 0.5;
        let levels = [
            self.held(previous.map(|levels| levels[0]), half.x)?,
            self.held(previous.map(|levels| levels[1]), half.y)?,
        ];
        let half_extent = DVec2::from_array(levels.map(|level| self.half_extent(level)));
        Some((SnappedMap::new((min + max) * 0.5, half_extent, map_size), levels))
    }
}
