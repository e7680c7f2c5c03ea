//! [`Seams`]: where shadows pass from one map to the next, and where they end.

use bevy::prelude::*;

/// Where shadows pass from one map to the next, and where they end ([`maths::selection`](crate::maths::selection)). Means
/// nothing on the drop-in path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[reflect(Default)]
pub struct Seams {
    /// Width of the blend between two maps. Pixels in it cost two lookups.
    pub width: SeamWidth,
    /// Share 0..=1 of the shadow distance over which shadows fade out at its end; 0: they end at once. Useful 0..=0.2, and
    /// only where [`SunShadows::distance`](super::SunShadows::distance) cuts shadows off before the scene ends.
    pub fade: f32,
}

/// Width of the blend between two maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
pub enum SeamWidth {
    /// No blend: the size of texels jumps.
    #[default]
    None,
    /// A share 0..=0.5: of the depth range of a partition where maps are selected by depth, else of the side of a map.
    Share(f32),
    /// Metres: of view depth where maps are selected by depth, else across the light.
    Metres(f32),
}

impl SeamWidth {
    /// The largest share.
    pub const LARGEST_SHARE: f32 = 0.5;
}

impl Seams {
    /// No blends: the default, so that every pixel has one lookup.
    pub const NONE: Self = Self {
        width: SeamWidth::None,
        fade: 0.0,
    };
}
