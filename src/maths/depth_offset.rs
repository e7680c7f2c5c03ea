//! The kinds of bias against self-shadowing: what a caster pass stores ([`StoredDepth`]) and what a lookup adds
//! ([`DepthOffset`], the CPU twin of `shaders/depth_offset.wgsl` in the same single precision).
//!
//! Self-shadowing comes from comparing a pixel with a texel's centre, where the receiver itself has another depth, and
//! from finite depth steps (Scherzer 2005, sections 3.1 and 4.2). Depth here is reverse z: 1 nearest to the light, so
//! an offset moves the receiver *up*, towards the light.
//!
//! | kind | where it acts |
//! |---|---|
//! | constant, slope-scaled (map or world), receiver plane, local footprint | lookup: [`DepthOffset`] |
//! | back faces | caster pass: it culls front faces; [`StoredDepth::BackFaces`] |
//! | second depth, midpoint, dual | caster pass into two maps; [`StoredDepth`] combines them |
//! | linear depth | caster pass: it writes [`linear_depth`]; the lookup compares with the same |
//!
//! # Hyperbolic and linear depth under a warp
//!
//! The warp's w is constant along every light ray, so depth is affine in the distance along the ray: one metre is
//! 1 ÷ (H w) of depth, H being the height range of the map (Scherzer, section 4.2). A constant offset of depth
//! therefore grows with w in metres, by the whole f' ÷ n' from the near end to the far end of the map;
//! [`DepthOffset::Constant`] takes metres instead and is the same everywhere. Planes stay planes under the warp:
//! offsets by slope are exact. Linear depth that a vertex shader writes is not: see [`vertex_depth_error`].

use bevy_math::Vec2;

use super::bias::{MIN_COS_LIGHT, ReceiverPlane};

/// How a shadow map holds depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthFormat {
    /// 16 bits, equal steps.
    Unorm16,
    /// 24 bits, equal steps.
    Unorm24,
    /// Single precision: steps grow with depth.
    Float32,
}

impl DepthFormat {
    /// r: the smallest step that can be told apart at a depth in 0..=1 (Scherzer, section 4.2; the unit of a polygon
    /// offset).
    pub fn step(self, depth: f32) -> f32 {
        match self {
            Self::Unorm16 => 1.0 / 65_536.0,
            Self::Unorm24 => 1.0 / 16_777_216.0,
            Self::Float32 => float_step(depth),
        }
    }
}

/// Distance of neighbouring single-precision numbers: 2^(exponent − 23).
fn float_step(depth: f32) -> f32 {
    (depth.max(SMALLEST_DEPTH).log2().floor() - 23.0).exp2()
}

/// Depths below this have the steps of this depth.
const SMALLEST_DEPTH: f32 = 1.0e-6;

/// What a lookup adds to the receiver's depth before it compares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthOffset {
    /// Nothing: moiré on every lit surface (Scherzer, figure 6, first column).
    None,
    /// The same distance towards the light everywhere. Enough for one slope; displaces all shadows by as much.
    Constant {
        /// Metres.
        metres: f32,
    },
    /// factor · max(|∂z ÷ ∂x|, |∂z ÷ ∂y|) + units · r, with x and y in texels: the polygon offset of graphics hardware
    /// (Scherzer, section 4.2), from the plane of the receiver instead of the caster's. The paper's values are 2 and 4;
    /// 1 and 0 suffice for a planar receiver and a lookup of one texel.
    SlopeScaled {
        /// Depth spans of a texel.
        factor: f32,
        /// Smallest steps.
        units: f32,
        /// Of the map.
        format: DepthFormat,
    },
    /// factor · tan θ_l · the side of a texel, in metres in the light plane, and that as depth: the slope-scaled bias
    /// of world space that is taken to the space behind the warp (Kozlov 2004, after Scherzer, section 4.2). As
    /// slope-scaled where texels are square.
    WorldSlope {
        /// Sides of a texel.
        factor: f32,
    },
    /// The depth of the receiver's plane at the centre of every texel that is read. Exact for planar receivers at any
    /// kernel size; the constant covers rounding.
    ReceiverPlane {
        /// Metres.
        metres: f32,
    },
    /// As [`DepthOffset::ReceiverPlane`], and on top a share of the plane's depth span over one texel, for normals that
    /// are slightly off.
    Footprint {
        /// Metres.
        metres: f32,
        /// Share of a texel's depth span.
        share: f32,
    },
}

/// The result of [`DepthOffset::at`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Offset {
    /// To be added to the receiver's depth.
    pub depth: f32,
    /// Whether every tap compares with the receiver's plane at its own texel.
    pub follows_plane: bool,
}

impl DepthOffset {
    /// The offset for a receiver in a map with `size` texels. `cosine`: between the receiver's normal and the light.
    pub fn at(self, plane: &ReceiverPlane, size: Vec2, cosine: f32) -> Offset {
        let (depth, follows_plane) = match self {
            Self::None => (0.0, false),
            Self::Constant { metres } => (constant_offset(plane, metres), false),
            Self::SlopeScaled { factor, units, format } => (
                slope_scaled_offset(plane, size, factor, units * format.step(plane.depth_ndc)),
                false,
            ),
            Self::WorldSlope { factor } => (world_slope_offset(plane, size, cosine, factor), false),
            Self::ReceiverPlane { metres } => (constant_offset(plane, metres), true),
            Self::Footprint { metres, share } => {
                (constant_offset(plane, metres) + share * texel_span(plane, size), true)
            }
        };
        Offset { depth, follows_plane }
    }
}

/// Depth of a distance towards the light.
pub fn constant_offset(plane: &ReceiverPlane, metres: f32) -> f32 {
    metres * plane.depth_per_metre
}

/// Metres towards the light of a depth: b H w (Scherzer, section 4.2).
pub fn metres_of_offset(plane: &ReceiverPlane, depth: f32) -> f32 {
    depth / plane.depth_per_metre
}

/// factor · slope + a constant, where the slope is the larger change of depth over one texel along the map's axes.
pub fn slope_scaled_offset(plane: &ReceiverPlane, size: Vec2, factor: f32, constant: f32) -> f32 {
    factor * (plane.depth_per_uv.abs() / size).max_element() + constant
}

/// The root of a texel's area in the light plane, which is that on the receiver times cos θ_l, in metres.
pub fn texel_side(plane: &ReceiverPlane, size: Vec2, cosine: f32) -> f32 {
    (cosine / (plane.uv_area_per_square_metre * size.element_product())).sqrt()
}

/// factor · tan θ_l · texel side in the light plane, as depth.
pub fn world_slope_offset(plane: &ReceiverPlane, size: Vec2, cosine: f32, factor: f32) -> f32 {
    let cosine = cosine.clamp(MIN_COS_LIGHT, 1.0);
    let tangent = (1.0 - cosine * cosine).sqrt() / cosine;
    factor * tangent * texel_side(plane, size, cosine) * plane.depth_per_metre
}

/// Change of depth of the receiver's plane over a whole texel, along both axes together.
pub fn texel_span(plane: &ReceiverPlane, size: Vec2) -> f32 {
    (plane.depth_per_uv.abs() / size).element_sum()
}

/// What a caster pass leaves in the map, from two depths of the same texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StoredDepth {
    /// The nearest surface.
    Nearest,
    /// The nearest face that looks away from the light: the pass culls front faces. No moiré on what lies open to the
    /// light; needs closed meshes, and light leaks where they touch the ground or are thin (Scherzer, section 4.2).
    BackFaces,
    /// The second surface from the light (Wang and Molnar 1994): as back faces, without relying on winding.
    SecondDepth,
    /// The middle between both (Woo 1992). As the pass draws second surfaces, nothing is stored where there is none: a
    /// single sheet shades nothing but what is itself in the map.
    Midpoint,
    /// The middle, but at most so far behind the nearest surface (after Weiskopf and Ertl 2003); so far where there is no
    /// second one.
    Dual {
        /// Largest distance from the nearest surface, in depth.
        largest: f32,
    },
}

impl StoredDepth {
    /// The stored depth from that of the nearest surface and that of the second one (of the nearest back face for
    /// [`StoredDepth::BackFaces`]); 0 where there is no second one, as in a cleared map.
    pub fn combine(self, nearest: f32, second: f32) -> f32 {
        match self {
            Self::Nearest => nearest,
            Self::BackFaces | Self::SecondDepth => second,
            Self::Midpoint if second <= 0.0 => 0.0,
            Self::Midpoint => (nearest + second) * 0.5,
            Self::Dual { largest } => nearest - ((nearest - second) * 0.5).min(largest),
        }
    }
}

/// Depth that is linear in the height along the light: 0 at `lowest`, 1 at `highest`, in metres towards the light
/// (Scherzer, section 4.2). A vertex shader writes it times w.
pub fn linear_depth(height: f64, lowest: f64, highest: f64) -> f64 {
    (height - lowest) / (highest - lowest)
}

/// By how much linear depth from a vertex shader is off inside a warped triangle, in metres per unit of slope.
///
/// The triangle rises with slope 1 between distances `start` and `end` from the warp's projection centre. Rasterisation
/// interpolates depth over the map, where distance y lies at a share t with 1 ÷ y = (1 − t) ÷ start + t ÷ end. It draws
/// (end − start) t where y − start is true. In the middle of the map (t = ½) that is too much by
/// (end − start)² ÷ (2 (end + start)): 32 m for the whole range of the paper's example. Exact at vertices; a fragment
/// shader that writes the interpolated height has no error.
pub fn vertex_depth_error(start: f64, end: f64, share: f64) -> f64 {
    let distance = 1.0 / ((1.0 - share) / start + share / end);
    (end - start) * share - (distance - start)
}
