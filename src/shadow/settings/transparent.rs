//! [`TransparentLayers`]: which transparent surfaces have shadow results of their own.

use std::ops::RangeInclusive;

use bevy::prelude::*;

/// Which transparent surfaces have shadow results of their own, as sharp as those of opaque ones, on the full path (Giegl
/// 2007, section 5.13). The others, and what is transmissive, read the fallback map. How they are drawn, and limits:
/// [`render::transparent`](crate::render::transparent). The films of [light planes](crate::shadow::light_plane) are laid for
/// opaque surfaces: glass beside those finds its shadows there only as far as films reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum TransparentLayers {
    /// None. The default: most pictures show little glass, and errors fade with its transparency.
    #[default]
    Off,
    /// The nearest of every pixel. Costs a depth pass of transparent things, one more apply pass, and one more layer of
    /// Bevy's shadow maps.
    Nearest,
    /// The nearest so many of every pixel, blended from far to near whatever the order of their objects; what is transparent
    /// behind them is not drawn. Costs as much as [`Nearest`](Self::Nearest) for each, and transparent things are drawn
    /// into the picture once for each. Cameras with order-independent transparency have the nearest.
    All {
        /// Layers, 1..=8; default 4.
        count: u32,
    },
}

impl TransparentLayers {
    /// Layers when nothing else is said.
    pub const COUNT: u32 = 4;
    /// Layers that there can be.
    pub const COUNTS: RangeInclusive<u32> = 1..=8;
}
