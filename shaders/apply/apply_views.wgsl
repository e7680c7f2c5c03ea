// Shadow result of every pixel: selects a light view, compares depths, filters.
//
// 1 lit, 0 in shadow; sky and everything beyond the shadow distance is lit.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import bevy_render::view::View
#import umbrage::bias::{ReceiverPlane, receiver_plane}
#import umbrage::spaces::{distance_along_view, position_from_depth}
#import umbrage::types::{
    ApplyParameters, BIAS_CONSTANT, BIAS_FOOTPRINT, BIAS_NONE, FILTER_HARD, SELECTION_DEPTH,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> parameters: ApplyParameters;
@group(0) @binding(2) var depth_prepass: texture_depth_2d;
@group(0) @binding(3) var atlas: texture_depth_2d;

// Floating point noise of a reconstructed position: a fixed part and a part that grows with distance, metres.
const NOISE_METRES: f32 = 0.001;
const NOISE_PER_METRE: f32 = 0.00002;
// Share of the texel's depth span on the receiver's plane that is added on top of the exact plane depth, for normals
// that are slightly off.
const FOOTPRINT_SHARE: f32 = 0.5;

struct Surface {
    position: vec3<f32>,
    // Geometric normal towards the viewer.
    normal: vec3<f32>,
    // False where no two neighbours lie on the pixel's own surface (thinner than a few pixels).
    has_normal: bool,
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
    return noise + parameters.bias_value * FOOTPRINT_SHARE * span;
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

// NDC depth of a plane is affine over the screen: the side on which two neighbours extrapolate best to the pixel's own
// depth is on the pixel's own surface.
fn read_surface(pixel: vec2<f32>, depth_ndc: f32) -> Surface {
    var surface: Surface;
    surface.position = position_from_depth(view, pixel, depth_ndc);
    surface.view_depth = distance_along_view(view, surface.position);
    let across = plane_step(pixel, depth_ndc, vec2<f32>(1.0, 0.0), surface.position);
    let down = plane_step(pixel, depth_ndc, vec2<f32>(0.0, 1.0), surface.position);
    surface.has_normal = across.w + down.w < 0.5;
    let normal = cross(down.xyz, across.xyz);
    let normal_length = length(normal);
    if !surface.has_normal || normal_length < 1e-12 {
        surface.has_normal = false;
        surface.normal = parameters.direction_to_light;
        return surface;
    }
    surface.normal = normal / normal_length;
    return surface;
}

// World space step to the neighbour pixel on the pixel's own surface along `axis`; w is 1 when neither side fits.
fn plane_step(pixel: vec2<f32>, depth_ndc: f32, axis: vec2<f32>, position: vec3<f32>) -> vec4<f32> {
    let before = vec2<f32>(load_depth(vec2<i32>(pixel - axis)), load_depth(vec2<i32>(pixel - 2.0 * axis)));
    let after = vec2<f32>(load_depth(vec2<i32>(pixel + axis)), load_depth(vec2<i32>(pixel + 2.0 * axis)));
    let error_before = abs(2.0 * before.x - before.y - depth_ndc);
    let error_after = abs(2.0 * after.x - after.y - depth_ndc);
    let misfit = select(0.0, 1.0, min(error_before, error_after) > 0.02 * depth_ndc);
    if error_before < error_after {
        return vec4<f32>(position - position_from_depth(view, pixel - axis, before.x), misfit);
    }
    return vec4<f32>(position_from_depth(view, pixel + axis, after.x) - position, misfit);
}
