// Filters of shadow lookups, one function per step; the CPU twins are in `src/maths/filter/`, by the same names.
//
// Depths are never filtered, only the outcomes of comparisons: 1 lit, 0 in shadow. Every tap compares with the depth of
// the receiver's plane at its own texel.
//
// `atlas`: opaque casters; `fading`: in the same places the nearest of those that take a share of the light only.
#define_import_path umbrage::filter

#import umbrage::bias::{ReceiverPlane, ndc_step}
#import umbrage::fading::{depth_without_share, fading_share}

// A receiver that is looked up in one map of an atlas.
struct Lookup {
    plane: ReceiverPlane,
    // The map's cell of the atlas in texels: x, y, width, height.
    rect: vec4<f32>,
    // First and last texel of the map that taps may read: x, y each.
    bounds: vec4<f32>,
    // How much nearer to the light than the receiver a caster must be, NDC depth.
    offset: f32,
    // Whether every tap compares with the receiver's plane at its own texel.
    follows_plane: bool,
    // Whether `fading` holds casters; else it is not read.
    has_fading: bool,
}

// The image in a map of a disc across the light: its two axes in texture coordinates.
struct Kernel {
    across: vec2<f32>,
    along: vec2<f32>,
}

struct Blockers {
    // Taps that hit one, fading ones by their share.
    weight: f32,
    // Mean distance from the receiver's plane along the light, metres; 0 without any.
    distance: f32,
}

struct Soft {
    // Tangent of half the sun's angular diameter.
    sun_tangent: f32,
    // Radius of the search, and of the widest penumbra, metres.
    largest_radius: f32,
    // Radius of the narrowest penumbra, metres.
    smallest_radius: f32,
    search_taps: u32,
    filter_taps: u32,
}

// pi (3 - sqrt 5): the turn from tap to tap on Vogel's spiral.
const GOLDEN_ANGLE: f32 = 2.3999632;
const TAU: f32 = 6.2831855;

// Texel coordinates of the receiver in its map.
fn receiver_texel(lookup: Lookup) -> vec2<f32> {
    return lookup.plane.uv * lookup.rect.zw;
}

// The depth that the centre of a texel is compared with. `tap`: the texel's corner, whole numbers.
fn receiver_depth(lookup: Lookup, tap: vec2<f32>) -> f32 {
    var receiver = lookup.plane.depth_ndc + lookup.offset;
    if lookup.follows_plane {
        receiver += dot(lookup.plane.depth_per_uv, (tap + 0.5 - receiver_texel(lookup)) / lookup.rect.zw);
    }
    return receiver;
}

// The texel of the atlas that a tap reads. Taps beside the map's bounds read their border, never a neighbour's cell.
fn read_texel(lookup: Lookup, tap: vec2<f32>) -> vec2<i32> {
    return vec2<i32>(lookup.rect.xy + clamp(tap, lookup.bounds.xy, lookup.bounds.zw));
}

// One comparison. Reverse z: larger is nearer to the light.
fn compare(atlas: texture_depth_2d, fading: texture_depth_2d, lookup: Lookup, tap: vec2<f32>) -> f32 {
    let texel = read_texel(lookup, tap);
    let receiver = receiver_depth(lookup, tap);
    if textureLoad(atlas, texel, 0) > receiver {
        return 0.0;
    }
    if !lookup.has_fading {
        return 1.0;
    }
    let stored = textureLoad(fading, texel, 0);
    return select(1.0, 1.0 - fading_share(stored), depth_without_share(stored) > receiver);
}

// No filter: the texel that holds the receiver.
fn hard(atlas: texture_depth_2d, fading: texture_depth_2d, lookup: Lookup) -> f32 {
    return compare(atlas, fading, lookup, floor(receiver_texel(lookup)));
}

// The four texels around a place in the map with equal weights.
fn four_taps(atlas: texture_depth_2d, fading: texture_depth_2d, lookup: Lookup, texel: vec2<f32>) -> f32 {
    let base = floor(texel - 0.5);
    return 0.25 * (compare(atlas, fading, lookup, base) + compare(atlas, fading, lookup, base + vec2<f32>(1.0, 0.0))
        + compare(atlas, fading, lookup, base + vec2<f32>(0.0, 1.0)) + compare(atlas, fading, lookup, base + 1.0));
}

// The four texels around a place in the map, weighted by how near they are.
fn bilinear(atlas: texture_depth_2d, fading: texture_depth_2d, lookup: Lookup, texel: vec2<f32>) -> f32 {
    let base = floor(texel - 0.5);
    let weight = texel - 0.5 - base;
    let top = mix(
        compare(atlas, fading, lookup, base), compare(atlas, fading, lookup, base + vec2<f32>(1.0, 0.0)), weight.x);
    let bottom = mix(
        compare(atlas, fading, lookup, base + vec2<f32>(0.0, 1.0)), compare(atlas, fading, lookup, base + 1.0), weight.x);
    return mix(top, bottom, weight.y);
}

// A tap of the unit disc, on Vogel's spiral.
fn disc_tap(index: u32, count: u32, angle: f32) -> vec2<f32> {
    let radius = sqrt((f32(index) + 0.5) / f32(count));
    let turn = f32(index) * GOLDEN_ANGLE + angle;
    return vec2<f32>(cos(turn), sin(turn)) * radius;
}

// The angle by which a pixel turns its disc, radians: interleaved gradient noise (Jimenez 2014).
fn pixel_angle(pixel: vec2<f32>) -> f32 {
    return TAU * fract(52.98292 * fract(dot(pixel, vec2<f32>(0.06711056, 0.00583715))));
}

// The image of a disc of one metre radius around the receiver, in the plane across the light.
fn kernel_per_metre(clip_from_world: mat4x4<f32>, plane: ReceiverPlane, to_light: vec3<f32>) -> Kernel {
    let ndc = vec3<f32>((plane.uv - 0.5) * vec2<f32>(2.0, -2.0), plane.depth_ndc);
    let helper = select(vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), abs(to_light.x) > 0.7);
    let right = normalize(cross(to_light, helper));
    let up = cross(to_light, right);
    let to_uv = vec2<f32>(0.5, -0.5);
    var kernel: Kernel;
    kernel.across = ndc_step(clip_from_world, ndc, plane.w, right).xy * to_uv;
    kernel.along = ndc_step(clip_from_world, ndc, plane.w, up).xy * to_uv;
    return kernel;
}

// A kernel for another radius.
fn scaled(kernel: Kernel, factor: f32) -> Kernel {
    var larger: Kernel;
    larger.across = kernel.across * factor;
    larger.along = kernel.along * factor;
    return larger;
}

// Texel coordinates of a tap.
fn tap_texel(lookup: Lookup, kernel: Kernel, tap: vec2<f32>) -> vec2<f32> {
    return receiver_texel(lookup) + (kernel.across * tap.x + kernel.along * tap.y) * lookup.rect.zw;
}

// The share of taps that are lit. `smooth_taps`: every tap is a bilinear lookup.
fn disc(
    atlas: texture_depth_2d,
    fading: texture_depth_2d,
    lookup: Lookup,
    kernel: Kernel,
    count: u32,
    angle: f32,
    smooth_taps: bool,
) -> f32 {
    var lit = 0.0;
    for (var index = 0u; index < count; index += 1u) {
        let texel = tap_texel(lookup, kernel, disc_tap(index, count, angle));
        if smooth_taps {
            lit += bilinear(atlas, fading, lookup, texel);
        } else {
            lit += compare(atlas, fading, lookup, floor(texel));
        }
    }
    return lit / f32(count);
}

// Looks for blockers on a disc of taps.
fn search_blockers(
    atlas: texture_depth_2d,
    fading: texture_depth_2d,
    lookup: Lookup,
    kernel: Kernel,
    count: u32,
    angle: f32,
) -> Blockers {
    var blockers: Blockers;
    for (var index = 0u; index < count; index += 1u) {
        let tap = floor(tap_texel(lookup, kernel, disc_tap(index, count, angle)));
        let texel = read_texel(lookup, tap);
        let receiver = receiver_depth(lookup, tap);
        var above = textureLoad(atlas, texel, 0) - receiver;
        var weight = select(0.0, 1.0, above > 0.0);
        if lookup.has_fading && weight == 0.0 {
            let stored = textureLoad(fading, texel, 0);
            above = depth_without_share(stored) - receiver;
            weight = select(0.0, fading_share(stored), above > 0.0);
        }
        if weight > 0.0 {
            blockers.weight += weight;
            blockers.distance += weight * above / lookup.plane.depth_per_metre;
        }
    }
    if blockers.weight > 0.0 {
        blockers.distance /= blockers.weight;
    }
    return blockers;
}

// Radius of the penumbra in metres across the light, at a distance behind its edge.
fn penumbra_radius(distance: f32, sun_tangent: f32) -> f32 {
    return distance * sun_tangent;
}

// The share of the sun that is seen. `kernel`: of one metre.
fn soft(
    atlas: texture_depth_2d,
    fading: texture_depth_2d,
    lookup: Lookup,
    kernel: Kernel,
    settings: Soft,
    angle: f32,
) -> f32 {
    let search = scaled(kernel, settings.largest_radius);
    let blockers = search_blockers(atlas, fading, lookup, search, settings.search_taps, angle);
    if blockers.weight == 0.0 {
        return bilinear(atlas, fading, lookup, receiver_texel(lookup));
    }
    let radius = penumbra_radius(blockers.distance, settings.sun_tangent);
    let limited = min(max(radius, settings.smallest_radius), settings.largest_radius);
    return disc(atlas, fading, lookup, scaled(kernel, limited), settings.filter_taps, angle, true);
}
