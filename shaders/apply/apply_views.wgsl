// Shadow result of every pixel: selects a light view, compares depths, filters.
//
// 1 lit, 0 in shadow; sky and everything beyond the shadow distance is lit. Surfaces that face away from the light are
// looked up like all others: a solid's back lies in its own shadow, a leaf's does not and lets light through.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::bias::{MIN_COS_LIGHT, ReceiverPlane}
#import umbrage::depth_offset::{
    constant_offset,
    float_step,
    slope_scaled_offset,
    texel_side,
    texel_span,
    world_slope_offset,
}
#import umbrage::filter::{
    Lookup,
    Soft,
    bilinear,
    disc,
    hard,
    kernel_per_metre,
    pixel_angle,
    receiver_texel,
    scaled,
    soft,
}
#import umbrage::selection::{Selected, next_view, parameters, range_fade, select_view, view_share}
#import umbrage::surface::{Surface, load_depth, surface_at}
#import umbrage::types::{
    BIAS_CONSTANT,
    BIAS_FOOTPRINT,
    BIAS_RECEIVER,
    BIAS_SLOPE,
    BIAS_WORLD_SLOPE,
    FILTER_HARD,
    FILTER_PCF2,
    FILTER_POISSON,
}

@group(0) @binding(4) var atlas: texture_depth_2d;

// Floating point noise of a reconstructed position: a fixed part and a part that grows with distance, metres.
const NOISE_METRES: f32 = 0.001;
const NOISE_PER_METRE: f32 = 0.00002;
// Share of the texel's depth span on the receiver's plane that is added on top of the exact plane depth, for normals
// that are slightly off.
const FOOTPRINT_SHARE: f32 = 0.5;
// As many as `ApplyParameters` holds.
const MAX_LIGHT_VIEWS: u32 = 16u;

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) f32 {
    let depth_ndc = load_depth(vec2<i32>(in.position.xy));
    if depth_ndc <= 0.0 {
        return 1.0;
    }
    let surface = surface_at(in.position.xy, depth_ndc, parameters.direction_to_light);
    let lit = blended_visibility(surface, pixel_angle(in.position.xy));
    if parameters.fade_length > 0.0 {
        return mix(1.0, lit, range_fade(surface.view_depth));
    }
    return lit;
}

// Every view takes its share, the last one that holds the point all that is left: v1 + l1 (v2 - v1) + l2 (v3 - v2) with what
// the views before leave, l1 and l2; where all agree the sum is exact. Without seams the first takes all.
fn blended_visibility(surface: Surface, angle: f32) -> f32 {
    var selected = select_view(surface);
    if !selected.is_found {
        return 1.0;
    }
    var lit = 0.0;
    var left = 1.0;
    var before = 0.0;
    // Every view at most once: a bound that no driver can miss.
    for (var step = 0u; step < MAX_LIGHT_VIEWS; step += 1u) {
        let visible = visibility(selected, surface, angle);
        lit += left * (visible - before);
        before = visible;
        if parameters.has_seams == 0u {
            break;
        }
        left *= 1.0 - view_share(selected, surface);
        if left <= 0.0 {
            break;
        }
        selected = next_view(surface, selected);
        if !selected.is_found {
            break;
        }
    }
    return lit;
}

// `angle`: by which this pixel turns its disc of taps.
fn visibility(selected: Selected, surface: Surface, angle: f32) -> f32 {
    var lookup: Lookup;
    lookup.plane = selected.plane;
    lookup.rect = parameters.light_views[selected.index].atlas_rect;
    let size = lookup.rect.zw;
    // A plane has no side.
    let cosine = max(abs(dot(surface.normal, parameters.direction_to_light)), MIN_COS_LIGHT);
    lookup.offset = depth_offset(lookup.plane, size, surface, cosine);
    lookup.follows_plane = parameters.bias_kind == BIAS_FOOTPRINT || parameters.bias_kind == BIAS_RECEIVER;
    if parameters.filter_kind == FILTER_HARD {
        return hard(atlas, lookup);
    }
    if parameters.filter_kind == FILTER_PCF2 {
        return bilinear(atlas, lookup, receiver_texel(lookup));
    }
    let kernel = kernel_per_metre(
        parameters.light_views[selected.index].clip_from_world, lookup.plane, parameters.direction_to_light);
    if parameters.filter_kind == FILTER_POISSON {
        return disc(
            atlas, lookup, scaled(kernel, parameters.filter_radius), parameters.filter_taps, angle, true);
    }
    var settings: Soft;
    settings.sun_tangent = parameters.sun_tangent;
    settings.largest_radius = parameters.filter_radius;
    settings.smallest_radius = texel_side(lookup.plane, size, cosine);
    settings.search_taps = parameters.search_taps;
    settings.filter_taps = parameters.filter_taps;
    return soft(atlas, lookup, kernel, settings, angle);
}

// How much nearer to the light than the receiver (or its plane) a caster must be, NDC depth.
fn depth_offset(plane: ReceiverPlane, size: vec2<f32>, surface: Surface, cosine: f32) -> f32 {
    switch parameters.bias_kind {
        case BIAS_CONSTANT, BIAS_RECEIVER: {
            return constant_offset(plane, parameters.bias_value);
        }
        case BIAS_SLOPE: {
            let units = parameters.bias_units * float_step(plane.depth_ndc);
            return slope_scaled_offset(plane, size, parameters.bias_value, units);
        }
        case BIAS_WORLD_SLOPE: {
            return world_slope_offset(plane, size, cosine, parameters.bias_value);
        }
        case BIAS_FOOTPRINT: {
            return footprint_offset(plane, size, surface, cosine);
        }
        default: {
            return 0.0;
        }
    }
}

fn footprint_offset(plane: ReceiverPlane, size: vec2<f32>, surface: Surface, cosine: f32) -> f32 {
    let noise = (NOISE_METRES + NOISE_PER_METRE * surface.view_depth) * plane.depth_per_metre;
    var span = texel_span(plane, size);
    if !surface.has_normal {
        // Unknown plane: as if it met the light at 45 degrees.
        span = 2.0 * plane.depth_per_metre / sqrt(plane.uv_area_per_square_metre * size.x * size.y);
    }
    // What the plane rises above its taps, up to a texel away, if it is tilted by the error of the normal.
    let texel_metres = 1.0 / sqrt(plane.uv_area_per_square_metre * size.x * size.y);
    let tilt = surface.normal_error * texel_metres / cosine * plane.depth_per_metre;
    return noise + parameters.bias_value * (FOOTPRINT_SHARE * span + tilt);
}
