//! Shadows on semitransparent surfaces, which the depth picture does not show (Giegl, section 5.13): the strategies of the
//! thesis and what they cost. How they are drawn, in the render room's `transparent`, differs from that in the last one.

use super::{fitted::FittedPlan, picture::PixelRect};

/// How semitransparent surfaces are shadowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum TransparentShadows {
    /// Drawn afterwards, lit: they glow a little in the shade.
    Unshadowed,
    /// Drawn afterwards with one ordinary map of the whole view. They receive only, so there is no self-shadowing to
    /// get wrong, and errors fade with their opacity. The default.
    #[default]
    SingleMap,
    /// The nearest semitransparent surface is a second picture with its own depths and shadow result; both pictures
    /// count in the needs.
    SecondLayer,
    /// Drawn once per tile within the tile's rectangle, while the tile is alive: exact for any number of layers. What is
    /// drawn is that once per layer of depth, so that surfaces are blended in order for maps of any kind.
    MultiPass,
}

/// What a strategy costs in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TransparentWork {
    /// Depth pictures whose needs are collected.
    pub need_layers: u32,
    /// Shadow results of the picture's size.
    pub results: u32,
    /// Ordinary maps beside the tiles.
    pub single_maps: u32,
    /// Times that an object is drawn into the picture.
    pub draws: usize,
}

impl TransparentShadows {
    /// The work for an object with a rectangle on the screen.
    pub fn work(self, plan: &FittedPlan, object: PixelRect) -> TransparentWork {
        let once = TransparentWork {
            need_layers: 1,
            results: 1,
            single_maps: 0,
            draws: 1,
        };
        match self {
            Self::Unshadowed => once,
            Self::SingleMap => TransparentWork { single_maps: 1, ..once },
            Self::SecondLayer => TransparentWork {
                need_layers: 2,
                results: 2,
                ..once
            },
            Self::MultiPass => TransparentWork {
                draws: self.passes(plan, object).count(),
                ..once
            },
        }
    }

    /// The tiles while which an object is drawn: those whose rectangle meets its own with [`Self::MultiPass`], none
    /// otherwise.
    ///
    /// A tile's rectangle is that of the pixels whose *needs* were collected. Transparent surfaces at other places of
    /// the map are missed unless their needs are collected too, so multi-pass wants the object's own depths in the
    /// needs, or [`floor_level`](super::grid::GridOptions::floor_level).
    pub fn passes(self, plan: &FittedPlan, object: PixelRect) -> impl Iterator<Item = usize> + '_ {
        let meets = move |rect: PixelRect| !rect.intersection(object).is_empty();
        (plan.tiles.iter().enumerate())
            .filter(move |(_, tile)| self == Self::MultiPass && meets(tile.rect))
            .map(|(index, _)| index)
    }
}

/// Where the shadow of a fragment comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShadowSource {
    /// Nowhere: lit.
    Lit,
    /// The result of the opaque picture.
    Opaque,
    /// The result of the nearest semitransparent surface.
    SecondLayer,
    /// A lookup in the single map.
    SingleMap,
    /// A lookup in the tile that is alive.
    LiveTile,
}

/// Chooses the source for a fragment with a reverse depth, in front of the opaque surface's and against that of the
/// nearest semitransparent one (0: none). Depths that agree within `tolerance`, relative, are the same surface; NaN
/// agrees with nothing.
///
/// A fragment on the opaque surface itself (a decal, a fading level of detail) has the opaque result, whatever the
/// strategy. Under the second layer, fragments behind the nearest one fall back to the single map.
///
/// The shader (`bridge/fetch_shadow.wgsl`) has a tolerance for each: what is within 10⁻⁴ of the opaque surface is that,
/// then 10⁻³ of the nearest, whose depth has lost eight bits, then 10⁻² of the opaque one.
pub fn shadow_source(
    strategy: TransparentShadows,
    depth: f64,
    opaque_depth: f64,
    nearest_depth: f64,
    tolerance: f64,
) -> ShadowSource {
    let agrees = |other: f64| other > 0.0 && (depth - other).abs() <= tolerance * other;
    if agrees(opaque_depth) {
        return ShadowSource::Opaque;
    }
    match strategy {
        TransparentShadows::Unshadowed => ShadowSource::Lit,
        TransparentShadows::SecondLayer if agrees(nearest_depth) => ShadowSource::SecondLayer,
        TransparentShadows::SingleMap | TransparentShadows::SecondLayer => ShadowSource::SingleMap,
        TransparentShadows::MultiPass => ShadowSource::LiveTile,
    }
}
