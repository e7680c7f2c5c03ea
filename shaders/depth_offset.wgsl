// Offsets of depth against self-shadowing that a lookup adds; the CPU twin is `src/maths/depth_offset.rs`.
//
// Reverse z: an offset moves the receiver towards the light.
#define_import_path umbrage::depth_offset

#import umbrage::bias::ReceiverPlane

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

// Change of depth of the receiver's plane over a whole texel, along both axes together.
fn texel_span(plane: ReceiverPlane, size: vec2<f32>) -> f32 {
    let slope = abs(plane.depth_per_uv) / size;
    return slope.x + slope.y;
}

// Distance of neighbouring single-precision numbers: the unit of a polygon offset for maps of 32-bit floats.
fn float_step(depth: f32) -> f32 {
    return exp2(floor(log2(max(depth, SMALLEST_DEPTH))) - 23.0);
}
