// Shadow result of every pixel: selects a light view, compares depths, filters.
//
// 1 lit, 0 in shadow; sky and everything beyond the shadow distance is lit.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import bevy_render::view::View
#import umbrage::bias::{MIN_COS_LIGHT, ReceiverPlane, receiver_plane}
#import umbrage::spaces::{distance_along_view, position_from_depth}
#import umbrage::types::{
    ApplyParameters, BIAS_CONSTANT, BIAS_FOOTPRINT, BIAS_NONE, FILTER_HARD, SELECTION_DEPTH,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> parameters: ApplyParameters;
@group(0) @binding(2) var depth_prepass: texture_depth_2d;
@group(0) @binding(3) var atlas: texture_depth_2d;
// World space, 0..1 for -1..1; anything of another length than 1 where the camera has no normal prepass.
@group(0) @binding(4) var normal_prepass: texture_2d<f32>;

// Floating point noise of a reconstructed position: a fixed part and a part that grows with distance, metres.
const NOISE_METRES: f32 = 0.001;
const NOISE_PER_METRE: f32 = 0.00002;
// Share of the texel's depth span on the receiver's plane that is added on top of the exact plane depth, for normals
// that are slightly off.
const FOOTPRINT_SHARE: f32 = 0.5;
// Pixels that are farther off the line through two neighbours, as a share of their depth, have no normal.
const LARGEST_MISFIT: f32 = 0.02;
// Misfit of three pixels on one plane: rounding of depths, share of their depth.
const EXACT_MISFIT: f32 = 1e-5;
// Façades with fins or reveals as wide as a pixel hold no plane at all: the normal counts as off by up to 14 degrees.
// More costs shadows beside edges: against 64 samples per pixel (city, avenue) the root mean square error of the mask is
// 0.093 at 0, 0.095 at 14 and 0.100 at 29 degrees, while speckled pixels in 550 of such a façade are 159, 27 and 20.
const LARGEST_NORMAL_ERROR: f32 = 0.25;
// Cosine between the plane of the depths and the shading normal from which the plane is believed: 18 degrees. Depths of
// fins as wide as a pixel can lie on one false plane exactly; shading normals cannot, but they are rounded off.
const SAME_NORMAL_COSINE: f32 = 0.95;

struct Surface {
    position: vec3<f32>,
    // Of the surface's plane, towards the viewer.
    normal: vec3<f32>,
    // False: no normal prepass, and no two neighbours lie on the pixel's own surface (thinner than a few pixels).
    has_normal: bool,
    // How far the normal may be off, radians.
    normal_error: f32,
    view_depth: f32,
}

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) f32 {
    let depth_ndc = load_depth(vec2<i32>(in.position.xy));
    if depth_ndc <= 0.0 {
        return 1.0;
    }
    let surface = read_surface(in.position.xy, depth_ndc);
    if surface.view_depth >= parameters.shadow_distance {
        return 1.0;
    }
    for (var i = 0u; i < parameters.light_view_count; i += 1u) {
        if parameters.selection == SELECTION_DEPTH {
            let range = parameters.light_views[i].depth_range;
            let last = i + 1u == parameters.light_view_count;
            if surface.view_depth >= range.y && !last {
                continue;
            }
        }
        let plane = receiver_plane(
            parameters.light_views[i].clip_from_world, surface.position, surface.normal, parameters.direction_to_light);
        if contains(plane, i) {
            return visibility(plane, i, surface);
        }
    }
    return 1.0;
}

// Whether the map holds the point with all texels that the filter reads.
fn contains(plane: ReceiverPlane, index: u32) -> bool {
    let margin = 1.0 / parameters.light_views[index].atlas_rect.zw;
    return plane.w > 0.0
        && all(plane.uv >= margin) && all(plane.uv <= 1.0 - margin)
        && plane.depth_ndc >= 0.0 && plane.depth_ndc <= 1.0;
}

fn visibility(plane: ReceiverPlane, index: u32, surface: Surface) -> f32 {
    let rect = parameters.light_views[index].atlas_rect;
    let texel = plane.uv * rect.zw;
    let offset = depth_offset(plane, rect.zw, surface);
    if parameters.filter_kind == FILTER_HARD {
        return compare(plane, rect, texel, floor(texel), offset);
    }
    let base = floor(texel - 0.5);
    let weight = texel - 0.5 - base;
    let top = mix(
        compare(plane, rect, texel, base, offset), compare(plane, rect, texel, base + vec2<f32>(1.0, 0.0), offset), weight.x);
    let bottom = mix(
        compare(plane, rect, texel, base + vec2<f32>(0.0, 1.0), offset), compare(plane, rect, texel, base + 1.0, offset), weight.x);
    return mix(top, bottom, weight.y);
}

// How much nearer to the light than the receiver's plane a caster must be, NDC depth.
fn depth_offset(plane: ReceiverPlane, size: vec2<f32>, surface: Surface) -> f32 {
    if parameters.bias_kind == BIAS_NONE {
        return 0.0;
    }
    if parameters.bias_kind == BIAS_CONSTANT {
        return parameters.bias_value * plane.depth_per_metre;
    }
    let noise = (NOISE_METRES + NOISE_PER_METRE * surface.view_depth) * plane.depth_per_metre;
    var span = dot(abs(plane.depth_per_uv), 1.0 / size);
    if !surface.has_normal {
        // Unknown plane: as if it met the light at 45 degrees.
        span = 2.0 * plane.depth_per_metre / sqrt(plane.uv_area_per_square_metre * size.x * size.y);
    }
    // What the plane rises above its taps, up to a texel away, if it is tilted by the error of the normal.
    let cosine = max(dot(surface.normal, parameters.direction_to_light), MIN_COS_LIGHT);
    let texel_metres = 1.0 / sqrt(plane.uv_area_per_square_metre * size.x * size.y);
    let tilt = surface.normal_error * texel_metres / cosine * plane.depth_per_metre;
    return noise + parameters.bias_value * (FOOTPRINT_SHARE * span + tilt);
}

// One comparison: the depth of the receiver's plane at the texel's centre against the stored depth.
fn compare(plane: ReceiverPlane, rect: vec4<f32>, texel: vec2<f32>, tap: vec2<f32>, offset: f32) -> f32 {
    var receiver = plane.depth_ndc + offset;
    if parameters.bias_kind == BIAS_FOOTPRINT {
        receiver += dot(plane.depth_per_uv, (tap + 0.5 - texel) / rect.zw);
    }
    let stored = textureLoad(atlas, vec2<i32>(rect.xy + clamp(tap, vec2<f32>(0.0), rect.zw - 1.0)), 0);
    // Reverse z: larger is nearer to the light.
    return select(1.0, 0.0, stored > receiver);
}

fn load_depth(pixel: vec2<i32>) -> f32 {
    return textureLoad(depth_prepass, pixel, 0);
}

// The plane of the depths where the shading normal agrees with it, else the plane that the shading normal gives.
fn read_surface(pixel: vec2<f32>, depth_ndc: f32) -> Surface {
    var surface: Surface;
    surface.position = position_from_depth(view, pixel, depth_ndc);
    surface.view_depth = distance_along_view(view, surface.position);
    fit_plane(&surface, pixel, depth_ndc);
    let shading_normal = load_normal(pixel, surface.position);
    let is_plane = surface.has_normal && dot(surface.normal, shading_normal) > SAME_NORMAL_COSINE;
    if !is_plane && any(shading_normal != vec3<f32>(0.0)) {
        surface.normal = shading_normal;
        surface.has_normal = true;
        surface.normal_error = LARGEST_NORMAL_ERROR;
    }
    return surface;
}

// The normal of the prepass, turned to the viewer; zero without one.
fn load_normal(pixel: vec2<f32>, position: vec3<f32>) -> vec3<f32> {
    let normal = textureLoad(normal_prepass, vec2<i32>(pixel), 0).xyz * 2.0 - 1.0;
    let normal_length = length(normal);
    if abs(normal_length - 1.0) > 0.1 {
        return vec3<f32>(0.0);
    }
    let is_orthographic = view.clip_from_view[3][3] == 1.0;
    let from_viewer = select(position - view.world_position, -view.world_from_view[2].xyz, is_orthographic);
    return normal / normal_length * select(1.0, -1.0, dot(normal, from_viewer) > 0.0);
}

// NDC depth of a plane is affine over the screen: the side on which two neighbours extrapolate best to the pixel's own
// depth is on the pixel's own surface.
fn fit_plane(surface: ptr<function, Surface>, pixel: vec2<f32>, depth_ndc: f32) {
    let across = plane_step(pixel, depth_ndc, vec2<f32>(1.0, 0.0), surface.position);
    let down = plane_step(pixel, depth_ndc, vec2<f32>(0.0, 1.0), surface.position);
    let misfit = vec2<f32>(across.misfit, down.misfit);
    surface.has_normal = all(vec2<f32>(across.least_misfit, down.least_misfit) < vec2<f32>(LARGEST_MISFIT));
    let off_plane = misfit * surface.view_depth / vec2<f32>(length(across.world), length(down.world));
    surface.normal_error = min(length(off_plane), LARGEST_NORMAL_ERROR);
    let normal = cross(down.world, across.world);
    let normal_length = length(normal);
    surface.has_normal &= normal_length >= 1e-12;
    surface.normal = select(parameters.direction_to_light, normal / normal_length, surface.has_normal);
}

struct PlaneStep {
    // To the neighbour pixel on the pixel's own surface, metres.
    world: vec3<f32>,
    // How far the pixel is off the line through two neighbours, on the better side, as a share of its depth.
    least_misfit: f32,
    // The same, but on the worse side where even the better one is not exact: then the surface is no plane.
    misfit: f32,
}

fn plane_step(pixel: vec2<f32>, depth_ndc: f32, axis: vec2<f32>, position: vec3<f32>) -> PlaneStep {
    let before = vec2<f32>(load_depth(vec2<i32>(pixel - axis)), load_depth(vec2<i32>(pixel - 2.0 * axis)));
    let after = vec2<f32>(load_depth(vec2<i32>(pixel + axis)), load_depth(vec2<i32>(pixel + 2.0 * axis)));
    let misfit_before = abs(2.0 * before.x - before.y - depth_ndc) / depth_ndc;
    let misfit_after = abs(2.0 * after.x - after.y - depth_ndc) / depth_ndc;
    var step: PlaneStep;
    step.least_misfit = min(misfit_before, misfit_after);
    step.misfit = select(
        step.least_misfit, max(misfit_before, misfit_after), step.least_misfit > EXACT_MISFIT);
    if misfit_before < misfit_after {
        step.world = position - position_from_depth(view, pixel - axis, before.x);
    } else {
        step.world = position_from_depth(view, pixel + axis, after.x) - position;
    }
    return step;
}
