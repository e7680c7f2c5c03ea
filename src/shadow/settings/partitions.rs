//! [`Partitions`]: what the view frustum is cut into, and how many texels each part gets.

use bevy::prelude::*;

use super::ShadowPath;
use crate::maths::split::SplitScheme;

/// How the view frustum is cut, one map for each part.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub struct Partitions {
    /// z-partitions: slices of the view frustum, 1..=16 (drop-in: 1..=4; faces: 1..=4); other values are clamped with a
    /// warning.
    pub count: u32,
    /// Where the view frustum is sliced.
    pub scheme: SplitScheme,
    /// Whether every slice is cut again, into one part per face of the view frustum. Not on the drop-in path.
    pub faces: Faces,
    /// Strengths of [`Warp::Free`](crate::maths::warp::Warp::Free) in each slice, near to far, each −1..=1 (Stingl, section
    /// 3.4). Slices without one take the warp's own. Usually empty: one strength for all is the thesis' other way, one value
    /// that follows the split scheme, since with logarithmic splits under light from overhead it makes n'_i = n'_0 C_i ÷ C_0.
    pub etas: Vec<f32>,
    /// How the texels are divided among the maps. Not on the drop-in path.
    pub resolution: MapResolution,
}

/// Face partitions (Lloyd, section 5.1; [`maths::face`](crate::maths::face)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum Faces {
    /// None: every slice has one map.
    #[default]
    Together,
    /// Every slice has one map for each side of the view frustum that carries the narrowest pixels: one to four, which
    /// depends on the light. Their error is nearly the same for all directions of light, also along the view, where one
    /// warped map is as bad as an unwarped one. Costs up to 4 maps per slice, and one more.
    Apart {
        /// A map of its own for the near face. Without it the sides stretch over its place, at the cost of some texels
        /// in the first slice. Four slices leave no room for it: 16 maps are the most.
        near_map: bool,
    },
}

impl Faces {
    /// The most maps that so many slices need.
    #[must_use]
    pub fn maps(self, slices: u32) -> u32 {
        match self {
            Self::Together => slices,
            Self::Apart { near_map } => 4 * slices + u32::from(near_map),
        }
    }
}

/// How the texels of a technique are divided among its maps (Lloyd, sections 4.2 and 6.1;
/// [`maths::storage`](crate::maths::storage)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum MapResolution {
    /// Squares of equal size.
    #[default]
    Equal,
    /// Rectangles that give all maps the same largest error, in a square as large as that of [`MapResolution::Equal`].
    /// They change only when the need has changed by a quarter, and then all shadow edges move.
    Balanced,
}

impl Default for Partitions {
    fn default() -> Self {
        Self::slices(4)
    }
}

impl Partitions {
    /// The default split of the full path. Measured with four warped maps on the tuning shots of forest and city (far plane 500 m, 480x270;
    /// wrong pixels in percent): lambda 0.8 0.386 and 1.654, 0.9 0.390 and 0.905, 0.94 0.375 and 0.968, 0.97 0.345 and
    /// 1.073, 0.99 0.337 and 1.107.
    pub const SCHEME: SplitScheme = SplitScheme::Practical { lambda: 0.9 };

    /// The default split of a path. The drop-in path splits logarithmically, which keeps the largest texel ÷ pixel of all
    /// slices alike: Bevy's lookup reads the map of the slice and no finer one, and a pseudo-near plane takes the place of
    /// the share of uniform splits that keeps the first slice long enough ([`maths::drop_in`](crate::maths::drop_in)).
    #[must_use]
    pub const fn scheme_of(path: ShadowPath) -> SplitScheme {
        match path {
            ShadowPath::Full => Self::SCHEME,
            ShadowPath::DropIn => SplitScheme::Logarithmic,
        }
    }

    /// So many z-partitions of the full path.
    #[must_use]
    pub const fn slices(count: u32) -> Self {
        Self::slices_of(ShadowPath::Full, count)
    }

    /// So many z-partitions with the default split of a path.
    #[must_use]
    pub const fn slices_of(path: ShadowPath, count: u32) -> Self {
        Self {
            count,
            scheme: Self::scheme_of(path),
            faces: Faces::Together,
            etas: Vec::new(),
            resolution: MapResolution::Equal,
        }
    }

    /// The most maps that there can be.
    #[must_use]
    pub fn maps(&self) -> u32 {
        self.faces.maps(self.count)
    }
}
