//! One lookup: comparing a receiver with one texel or four.

use bevy_math::{IVec2, Vec2, Vec4, Vec4Swizzles};

use super::fading::{depth_without_share, fading_share};
use crate::maths::bias::ReceiverPlane;

/// The texels of the maps of one atlas; a function from texels to depths has no casters that fade.
pub trait MapTexels {
    /// Depth of the nearest opaque caster.
    fn depth(&self, texel: IVec2) -> f32;
    /// Depth and share of the nearest caster that fades ([`fading`](super::fading)).
    fn fading(&self, _: IVec2) -> Option<f32> {
        None
    }
}

impl<F: Fn(IVec2) -> f32> MapTexels for F {
    fn depth(&self, texel: IVec2) -> f32 {
        self(texel)
    }
}

/// Functions from texels to depths: of opaque casters, and of those that fade.
#[derive(Clone, Copy, Debug)]
pub struct WithFading<A, F> {
    /// Of opaque casters.
    pub atlas: A,
    /// Of casters that fade, with their shares.
    pub fading: F,
}

impl<A: Fn(IVec2) -> f32, F: Fn(IVec2) -> f32> MapTexels for WithFading<A, F> {
    fn depth(&self, texel: IVec2) -> f32 {
        (self.atlas)(texel)
    }

    fn fading(&self, texel: IVec2) -> Option<f32> {
        Some((self.fading)(texel))
    }
}

/// A receiver that is looked up in one map of an atlas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookup {
    /// The receiver's plane in the map.
    pub plane: ReceiverPlane,
    /// The map's cell of the atlas in texels: x, y, width, height.
    pub rect: Vec4,
    /// First and last texel of the map that taps may read: x, y each.
    pub bounds: Vec4,
    /// How much nearer to the light than the receiver a caster must be, in depth.
    pub offset: f32,
    /// Whether every tap compares with the receiver's plane at its own texel, or all with the receiver's own depth.
    pub follows_plane: bool,
}

/// Texel coordinates of the receiver in its map.
pub fn receiver_texel(lookup: &Lookup) -> Vec2 {
    lookup.plane.uv * lookup.rect.zw()
}

/// The depth that the centre of a texel is compared with. `tap`: the texel's corner, whole numbers.
pub fn receiver_depth(lookup: &Lookup, tap: Vec2) -> f32 {
    let mut receiver = lookup.plane.depth_ndc + lookup.offset;
    if lookup.follows_plane {
        receiver += lookup
            .plane
            .depth_per_uv
            .dot((tap + 0.5 - receiver_texel(lookup)) / lookup.rect.zw());
    }
    receiver
}

/// The texel of the atlas that a tap reads. Taps beside the map's bounds read their border, never a neighbour's cell.
pub fn read_texel(lookup: &Lookup, tap: Vec2) -> IVec2 {
    (lookup.rect.xy() + tap.clamp(lookup.bounds.xy(), lookup.bounds.zw())).as_ivec2()
}

/// One comparison: 1 lit, 0 in shadow, between both in that of a caster that fades. Reverse z: larger is nearer to the light.
pub fn compare(maps: &impl MapTexels, lookup: &Lookup, tap: Vec2) -> f32 {
    let texel = read_texel(lookup, tap);
    let receiver = receiver_depth(lookup, tap);
    if maps.depth(texel) > receiver {
        return 0.0;
    }
    match maps.fading(texel) {
        Some(stored) if depth_without_share(stored) > receiver => 1.0 - fading_share(stored),
        _ => 1.0,
    }
}

/// No filter: the texel that holds the receiver.
pub fn hard(maps: &impl MapTexels, lookup: &Lookup) -> f32 {
    compare(maps, lookup, receiver_texel(lookup).floor())
}

/// The four texels around a place in the map with equal weights: 0, ¼, ½, ¾ or 1 (Scherzer 2005, section 5).
pub fn four_taps(maps: &impl MapTexels, lookup: &Lookup, texel: Vec2) -> f32 {
    let base = (texel - 0.5).floor();
    let taps = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
    taps.map(|tap| compare(maps, lookup, base + tap)).iter().sum::<f32>() * 0.25
}

/// The four texels around a place in the map, weighted by how near they are, as comparison samplers do: continuous in
/// the place.
pub fn bilinear(maps: &impl MapTexels, lookup: &Lookup, texel: Vec2) -> f32 {
    let base = (texel - 0.5).floor();
    let weight = texel - 0.5 - base;
    let mix = |a: f32, b: f32, weight: f32| a * (1.0 - weight) + b * weight;
    let top = mix(
        compare(maps, lookup, base),
        compare(maps, lookup, base + Vec2::X),
        weight.x,
    );
    let bottom = mix(
        compare(maps, lookup, base + Vec2::Y),
        compare(maps, lookup, base + 1.0),
        weight.x,
    );
    mix(top, bottom, weight.y)
}
