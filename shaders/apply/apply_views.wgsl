// Shadow result of every pixel: selects a light view, compares depths, filters.
//
// 1 lit, 0 in shadow; sky and everything beyond the shadow distance is lit. Surfaces that face away from the light are
// looked up like all others: a solid's back lies in its own shadow, a leaf's does not and lets light through.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::bias::{MIN_COS_LIGHT, ReceiverPlane}
#import umbrage::selection::{parameters, select_view}
#import umbrage::surface::{Surface, load_depth, surface_at}
#import umbrage::types::{BIAS_CONSTANT, BIAS_FOOTPRINT, BIAS_NONE, FILTER_HARD}

@group(0) @binding(4) var atlas: texture_depth_2d;

// Floating point noise of a reconstructed position: a fixed part and a part that grows with distance, metres.
const NOISE_METRES: f32 = 0.001;
const NOISE_PER_METRE: f32 = 0.00002;
// Share of the texel's depth span on the receiver's plane that is added on top of the exact plane depth, for normals
// that are slightly off.
const FOOTPRINT_SHARE: f32 = 0.5;
@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) f32 {
    let depth_ndc = load_depth(vec2<i32>(in.position.xy));
    if depth_ndc <= 0.0 {
        return 1.0;
    }
    let surface = surface_at(in.position.xy, depth_ndc, parameters.direction_to_light);
    let selected = select_view(surface);
    if !selected.is_found {
        return 1.0;
    }
    return visibility(selected.plane, selected.index, surface);
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
    let cosine = max(abs(dot(surface.normal, parameters.direction_to_light)), MIN_COS_LIGHT);
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
