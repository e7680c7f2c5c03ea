// Blur of the shadow result on the screen: half an iteration, along the rows or along the columns.
//
// The CPU twin is `src/maths/filter/eye_blur.rs`, which says why. Run it for every iteration with both axes, to and fro
// between two textures; 8 bits round too much for more than 8 iterations.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::surface::{load_depth, surface_at, view}
#import umbrage::types::EyeBlur

@group(0) @binding(3) var<uniform> blur: EyeBlur;
@group(0) @binding(4) var visibility: texture_2d<f32>;

const MAX_ITERATIONS: u32 = 16u;
// Cosine of the largest angle between normals of one surface: 25 degrees.
const SAME_SURFACE_COSINE: f32 = 0.9;
// Distance of a neighbour from the pixel's plane up to which both are on one surface, as a share of view depth.
const LARGEST_STEP: f32 = 0.002;
// Shares of an iteration below this are none.
const LEAST_SHARE: f32 = 0.05;

struct EyePixel {
    position: vec3<f32>,
    normal: vec3<f32>,
    // 0 for sky.
    view_depth: f32,
}

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) f32 {
    let own = load_visibility(in.position.xy);
    let pixel = eye_pixel(in.position.xy);
    if strength(pixel.view_depth) == 0.0 {
        return own;
    }
    let step = select(vec2<f32>(1.0, 0.0), vec2<f32>(0.0, 1.0), blur.axis == 1u);
    return nearest_half(own + taken(in.position.xy - step, pixel, own) + taken(in.position.xy + step, pixel, own));
}

// The textures hold 16 bits, and some adapters cut the rest off: over 32 passes that is more than 1 of 255.
fn nearest_half(value: f32) -> f32 {
    return unpack2x16float(pack2x16float(vec2<f32>(value, 0.0))).x;
}

fn load_visibility(place: vec2<f32>) -> f32 {
    return textureLoad(visibility, vec2<i32>(place), 0).x;
}

// What a pixel takes from a neighbour; nothing from beside the picture.
fn taken(place: vec2<f32>, pixel: EyePixel, own: f32) -> f32 {
    let begin = view.viewport.xy;
    if any(place < begin) || any(place >= begin + view.viewport.zw) {
        return 0.0;
    }
    return exchange(pixel, eye_pixel(place)) * (load_visibility(place) - own);
}

fn eye_pixel(place: vec2<f32>) -> EyePixel {
    var pixel: EyePixel;
    let depth_ndc = load_depth(vec2<i32>(place));
    if depth_ndc > 0.0 {
        let surface = surface_at(place, depth_ndc, vec3<f32>(0.0));
        pixel.position = surface.position;
        pixel.normal = surface.normal;
        pixel.view_depth = surface.view_depth;
    }
    return pixel;
}

// Iterations in which a pixel takes part, a fraction included.
fn iterations_at(view_depth: f32) -> f32 {
    if view_depth <= 0.0 {
        return 0.0;
    }
    let nearness = min(blur.full_depth / view_depth, 1.0);
    let iterations = f32(min(blur.iterations, MAX_ITERATIONS)) * nearness * nearness;
    return select(iterations, 0.0, iterations < LEAST_SHARE);
}

// Strength of this iteration at a pixel.
fn strength(view_depth: f32) -> f32 {
    return clamp(iterations_at(view_depth) - f32(blur.iteration), 0.0, 1.0);
}

// Whether two neighbouring pixels show one surface: similar normals, and each near the plane of the other.
fn is_same_surface(a: EyePixel, b: EyePixel) -> bool {
    let step = b.position - a.position;
    let off_plane = max(abs(dot(a.normal, step)), abs(dot(b.normal, step)));
    return a.view_depth > 0.0 && b.view_depth > 0.0
        && dot(a.normal, b.normal) >= SAME_SURFACE_COSINE
        && off_plane <= LARGEST_STEP * min(a.view_depth, b.view_depth);
}

// Weight with which a pixel takes the value of a neighbour.
fn exchange(pixel: EyePixel, neighbour: EyePixel) -> f32 {
    let weight = 0.25 * min(strength(pixel.view_depth), strength(neighbour.view_depth));
    return select(0.0, weight, is_same_surface(pixel, neighbour));
}
