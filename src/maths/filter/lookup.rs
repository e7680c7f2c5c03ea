//! One lookup: comparing a receiver with one texel or four.

use bevy_math::{IVec2, Vec2, Vec4, Vec4Swizzles};

use crate::maths::bias::ReceiverPlane;

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

/// The depth that a texel of the map holds. Taps beside its bounds read their border, never a neighbour's cell.
pub fn stored_depth(atlas: &impl Fn(IVec2) -> f32, lookup: &Lookup, tap: Vec2) -> f32 {
    atlas((lookup.rect.xy() + tap.clamp(lookup.bounds.xy(), lookup.bounds.zw())).as_ivec2())
}

/// One comparison: 1 lit, 0 in shadow. Reverse z: larger is nearer to the light.
pub fn compare(atlas: &impl Fn(IVec2) -> f32, lookup: &Lookup, tap: Vec2) -> f32 {
    if stored_depth(atlas, lookup, tap) > receiver_depth(lookup, tap) {
        0.0
    } else {
        1.0
    }
}

/// No filter: the texel that holds the receiver.
pub fn hard(atlas: &impl Fn(IVec2) -> f32, lookup: &Lookup) -> f32 {
    compare(atlas, lookup, receiver_texel(lookup).floor())
}

/// The four texels around a place in the map with equal weights: 0, ¼, ½, ¾ or 1 (Scherzer 2005, section 5).
pub fn four_taps(atlas: &impl Fn(IVec2) -> f32, lookup: &Lookup, texel: Vec2) -> f32 {
    let base = (texel - 0.5).floor();
    let taps = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE];
    taps.map(|tap| compare(atlas, lookup, base + tap)).iter().sum::<f32>() * 0.25
}

/// The four texels around a place in the map, weighted by how near they are, as comparison samplers do: continuous in
/// the place.
pub fn bilinear(atlas: &impl Fn(IVec2) -> f32, lookup: &Lookup, texel: Vec2) -> f32 {
    let base = (texel - 0.5).floor();
    let weight = texel - 0.5 - base;
    let mix = |a: f32, b: f32, weight: f32| a * (1.0 - weight) + b * weight;
    let top = mix(
        compare(atlas, lookup, base),
        compare(atlas, lookup, base + Vec2::X),
        weight.x,
    );
    let bottom = mix(
        compare(atlas, lookup, base + Vec2::Y),
        compare(atlas, lookup, base + 1.0),
        weight.x,
    );
    mix(top, bottom, weight.y)
}
