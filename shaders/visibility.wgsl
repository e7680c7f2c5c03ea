// The shadow of a surface in one map: bias and filter by the settings of the sun. The passes that apply maps share it.
#define_import_path umbrage::visibility

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
    receiver_texel,
    scaled,
    soft,
}
#import umbrage::selection::parameters
#import umbrage::surface::Surface
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

// Floating point noise of a reconstructed position: a fixed part and a part that grows with distance, metres.
const NOISE_METRES: f32 = 0.001;
const NOISE_PER_METRE: f32 = 0.00002;
// Share of the texel's depth span on the receiver's plane that is added on top of the exact plane depth, for normals
// that are slightly off.
const FOOTPRINT_SHARE: f32 = 0.5;

// Where the texels of a map lie in a texture.
struct MapTexels {
    // x, y: texel of the texture that holds the map's first one (negative where the texture shows a later part of the map);
    // width, height: texels of the whole map.
    rect: vec4<f32>,
    // First and last texel of the map that the texture holds.
    bounds: vec4<f32>,
}

// A map that fills a cell.
fn texels_of_cell(rect: vec4<f32>) -> MapTexels {
    return MapTexels(rect, vec4<f32>(0.0, 0.0, rect.zw - 1.0));
}

// 1 lit, 0 in shadow. `fading`: the casters that fade, in the same texels; read only where there are some. `plane`: the surface in the map that `clip_from_world` draws; `angle`: by which this pixel turns its
// disc of taps.
fn visibility(
    depths: texture_depth_2d,
    fading: texture_depth_2d,
    has_fading: bool,
    texels: MapTexels,
    clip_from_world: mat4x4<f32>,
    plane: ReceiverPlane,
    surface: Surface,
    angle: f32,
) -> f32 {
    var lookup: Lookup;
    lookup.plane = plane;
    lookup.rect = texels.rect;
    lookup.bounds = texels.bounds;
    lookup.has_fading = has_fading;
    let size = lookup.rect.zw;
    // A plane has no side.
    let cosine = max(abs(dot(surface.normal, parameters.direction_to_light)), MIN_COS_LIGHT);
    lookup.offset = depth_offset(lookup.plane, size, surface, cosine);
    lookup.follows_plane = parameters.bias_kind == BIAS_FOOTPRINT || parameters.bias_kind == BIAS_RECEIVER;
    if parameters.filter_kind == FILTER_HARD {
        return hard(depths, fading, lookup);
    }
    if parameters.filter_kind == FILTER_PCF2 {
        return bilinear(depths, fading, lookup, receiver_texel(lookup));
    }
    let kernel = kernel_per_metre(clip_from_world, lookup.plane, parameters.direction_to_light);
    if parameters.filter_kind == FILTER_POISSON {
        return disc(
            depths,
            fading,
            lookup,
            scaled(kernel, parameters.filter_radius),
            parameters.filter_taps,
            angle,
            true,
        );
    }
    var settings: Soft;
    settings.sun_tangent = parameters.sun_tangent;
    settings.largest_radius = parameters.filter_radius;
    settings.smallest_radius = texel_side(lookup.plane, size, cosine);
    settings.search_taps = parameters.search_taps;
    settings.filter_taps = parameters.filter_taps;
    return soft(depths, fading, lookup, kernel, settings, angle);
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
