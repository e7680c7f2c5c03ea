// Offsets of depth against self-shadowing that a lookup adds; the CPU twin is `src/maths/depth_offset.rs`.
//
// Reverse z: an offset moves the receiver towards the light.
#define_import_path umbrage::depth_offset

#import umbrage::bias::{MIN_COS_LIGHT, ReceiverPlane}

// Depths below this have the steps of this depth.
const SMALLEST_DEPTH: f32 = 1e-6;

// Depth of a distance towards the light.
fn constant_offset(plane: ReceiverPlane, metres: f32) -> f32 {
    return metres * plane.depth_per_metre;
}

// factor * slope + a constant, where the slope is the larger change of depth over one texel along the map's axes.
fn slope_scaled_offset(plane: ReceiverPlane, size: vec2<f32>, factor: f32, constant: f32) -> f32 {
    let slope = abs(plane.depth_per_uv) / size;
    return factor * max(slope.x, slope.y) + constant;
}

// The root of a texel's area in the light plane, which is that on the receiver times the cosine, metres.
fn texel_side(plane: ReceiverPlane, size: vec2<f32>, cosine: f32) -> f32 {
    return sqrt(cosine / (plane.uv_area_per_square_metre * size.x * size.y));
}

// factor * tan * texel side in the light plane, as depth; tan of the angle between normal and light.
fn world_slope_offset(plane: ReceiverPlane, size: vec2<f32>, cosine: f32, factor: f32) -> f32 {
    let limited = clamp(cosine, MIN_COS_LIGHT, 1.0);
    let tangent = sqrt(1.0 - limited * limited) / limited;
    return factor * tangent * texel_side(plane, size, limited) * plane.depth_per_metre;
}

// Change of depth of the receiver's plane over a whole texel, along both axes together.
fn texel_span(plane: ReceiverPlane, size: vec2<f32>) -> f32 {
    let slope = abs(plane.depth_per_uv) / size;
    return slope.x + slope.y;
}

// Distance of neighbouring single-precision numbers: the unit of a polygon offset for maps of 32-bit floats.
fn float_step(depth: f32) -> f32 {
    return exp2(floor(log2(max(depth, SMALLEST_DEPTH))) - 23.0);
}
