// Where a pixel of the picture looks into a map, and how finely: the CPU twin is `src/maths/virtual_map/mapping.rs`, which
// derives the formulas.
#define_import_path umbrage::needs

#import umbrage::spaces::{distance_along_view, position_from_depth, uv_from_ndc}
#import umbrage::surface::{load_depth, view}
#import umbrage::types::{MEASURE_BOX, MEASURE_EXTENT, NeedParameters, PICK_SMALLER}

// Storage, not uniform: software drivers compile a shader anew for values of uniforms that decide branches.
@group(0) @binding(3) var<storage, read> parameters: NeedParameters;

// More than any level: the need of patches that are edge-on to the light, or that the camera may touch.
const UNBOUNDED_NEED: f32 = 3e38;
const MAX_LEVEL: u32 = 31u;

// One pixel's surface in the map.
struct Patch {
    // Texture coordinates of the map, v down.
    uv: vec2<f32>,
    // Their change for one pixel to the right and one down.
    right: vec2<f32>,
    down: vec2<f32>,
    // Clip-space place in the picture and depth.
    place: vec2<f32>,
    depth: f32,
    // Change of the depth for one pixel to the right and one down.
    slopes: vec2<f32>,
    // False: behind the map's projection centre.
    is_found: bool,
}

// Depth of a pixel of the picture, 0 outside of it and where there is nothing.
fn depth_at(pixel: vec2<i32>) -> f32 {
    let size = vec2<i32>(parameters.picture_size);
    if any(pixel < vec2<i32>(0)) || any(pixel >= size) {
        return 0.0;
    }
    return load_depth(pixel + vec2<i32>(parameters.picture_origin));
}

// Whether the shadow of a pixel is looked up in this map.
fn is_shadowed(pixel: vec2<i32>, depth: f32) -> bool {
    let view_depth = distance_along_view(view, world_position(pixel, depth));
    return depth > 0.0 && view_depth >= parameters.depth_range.x && view_depth < parameters.depth_range.y;
}

fn world_position(pixel: vec2<i32>, depth: f32) -> vec3<f32> {
    let center = vec2<f32>(pixel + vec2<i32>(parameters.picture_origin)) + 0.5;
    return position_from_depth(view, center, depth);
}

// Clip-space place, -1..1 with y up, of a place in pixels from the top left.
fn clip_place(pixels: vec2<f32>) -> vec2<f32> {
    let uv = pixels / vec2<f32>(parameters.picture_size);
    return vec2<f32>(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
}

fn center_place(pixel: vec2<i32>) -> vec2<f32> {
    return clip_place(vec2<f32>(pixel) + 0.5);
}

// The slope towards + of a value from its neighbours one step away; a neighbour that is missing leaves the choice to the
// other, and without both the patch counts as facing the camera.
fn picked_slope(center: f32, before: f32, has_before: bool, after: f32, has_after: bool) -> f32 {
    let slope_before = center - before;
    let slope_after = after - center;
    if has_before && has_after {
        let is_before_smaller = abs(slope_before) < abs(slope_after);
        return select(slope_after, slope_before, is_before_smaller == (parameters.pick == PICK_SMALLER));
    }
    return select(select(0.0, slope_after, has_after), slope_before, has_before);
}

fn depth_slope(pixel: vec2<i32>, depth: f32, step: vec2<i32>) -> f32 {
    let before = depth_at(pixel - step);
    let after = depth_at(pixel + step);
    return picked_slope(depth, before, before > 0.0, after, after > 0.0);
}

// The plane through a pixel, in the map. `step`: pixels to the neighbours.
fn patch_at(pixel: vec2<i32>, depth: f32, step: vec2<i32>) -> Patch {
    var found: Patch;
    found.place = center_place(pixel);
    found.depth = depth;
    found.slopes = vec2<f32>(
        depth_slope(pixel, depth, vec2<i32>(step.x, 0)),
        depth_slope(pixel, depth, vec2<i32>(0, step.y)),
    ) / vec2<f32>(step);
    let looked_up = parameters.clip_from_world * vec4<f32>(world_position(pixel, depth), 1.0);
    found.uv = uv_from_ndc(looked_up.xy / looked_up.w);
    let clip = parameters.map_from_picture * vec4<f32>(found.place, depth, 1.0);
    let pixel_size = 2.0 / vec2<f32>(parameters.picture_size);
    found.right = uv_step(clip, vec4<f32>(pixel_size.x, 0.0, found.slopes.x, 0.0));
    found.down = uv_step(clip, vec4<f32>(0.0, -pixel_size.y, found.slopes.y, 0.0));
    found.is_found = looked_up.w > 0.0 && clip.w > 0.0;
    return found;
}

// Change of texture coordinates for a step in the picture's clip space, by the quotient rule.
fn uv_step(clip: vec4<f32>, step: vec4<f32>) -> vec2<f32> {
    let change = parameters.map_from_picture * step;
    return (change.xy - clip.xy / clip.w * change.w) / clip.w * vec2<f32>(0.5, -0.5);
}

fn is_in_map(found: Patch) -> bool {
    return found.is_found && all(found.uv >= vec2<f32>(0.0)) && all(found.uv <= vec2<f32>(1.0));
}

// Texels per axis of the whole map that a pixel needs.
fn need_at(pixel: vec2<i32>, found: Patch, step: vec2<i32>) -> vec2<f32> {
    let facing = found.right.x * found.down.y - found.right.y * found.down.x;
    if facing == 0.0 {
        return vec2<f32>(UNBOUNDED_NEED);
    }
    let along_u = vec2<f32>(found.down.y, -found.right.y) / facing;
    let along_v = vec2<f32>(-found.down.x, found.right.x) / facing;
    var need = vec2<f32>(length(along_u), length(along_v));
    if parameters.measure == MEASURE_BOX {
        need = f32(max(step.x, step.y)) / listed_extent(pixel, found.depth, step);
    } else if parameters.measure == MEASURE_EXTENT {
        need *= sqrt(1.0 + abs(dot(along_u, along_v)) / (need.x * need.y));
    }
    if parameters.motion_step < 0.0 {
        return need;
    }
    return dilated_need(need, found, along_u, along_v);
}

// For every camera within the motion: inequalities 2 and 3 of `src/maths/virtual_map/feedback.rs`.
fn dilated_need(need: vec2<f32>, found: Patch, along_u: vec2<f32>, along_v: vec2<f32>) -> vec2<f32> {
    let depth = 1.0 / dot(parameters.inverse_depth, vec4<f32>(found.place, found.depth, 1.0));
    let rest = depth - parameters.motion_step;
    if rest <= 0.0 {
        return vec2<f32>(UNBOUNDED_NEED);
    }
    let pixel_size = 2.0 / vec2<f32>(parameters.picture_size);
    let row = parameters.inverse_depth.xyz;
    let per_pixel = -depth * depth * vec2<f32>(
        dot(row, vec3<f32>(pixel_size.x, 0.0, found.slopes.x)),
        dot(row, vec3<f32>(0.0, -pixel_size.y, found.slopes.y)),
    );
    let depth_steps = abs(vec2<f32>(dot(per_pixel, along_u), dot(per_pixel, along_v)));
    let reach = parameters.motion_corner * min(max(abs(found.place.x), abs(found.place.y)), 1.0);
    let gain = parameters.motion_focal * parameters.motion_step * sqrt(1.0 + reach * reach) / (rest * rest);
    return (need * (depth / rest) + depth_steps * gain) * parameters.motion_turn_factor;
}

// The listing of the thesis: half the box, in the map, of four points one step to each side, with linear depths.
fn listed_extent(pixel: vec2<i32>, depth: f32, step: vec2<i32>) -> vec2<f32> {
    let linear = linear_depth(center_place(pixel), depth);
    var low = vec2<f32>(UNBOUNDED_NEED);
    var high = vec2<f32>(-UNBOUNDED_NEED);
    for (var axis = 0; axis < 2; axis += 1) {
        let along = select(vec2<i32>(step.x, 0), vec2<i32>(0, step.y), axis == 1);
        let before = depth_at(pixel - along);
        let after = depth_at(pixel + along);
        let slope = picked_slope(
            linear,
            linear_depth(center_place(pixel - along), before), before > 0.0,
            linear_depth(center_place(pixel + along), after), after > 0.0,
        );
        for (var side = -1; side <= 1; side += 2) {
            let place = center_place(pixel + along * side);
            let listed_depth = depth_of_linear(place, linear + slope * f32(side));
            let clip = parameters.map_from_picture * vec4<f32>(place, listed_depth, 1.0);
            let uv = clip.xy / clip.w * 0.5;
            low = min(low, uv);
            high = max(high, uv);
        }
    }
    return 0.5 * (high - low);
}

// View depth for perspective cameras, depth itself for parallel ones.
fn linear_depth(place: vec2<f32>, depth: f32) -> f32 {
    if is_parallel() {
        return depth;
    }
    return 1.0 / dot(parameters.inverse_depth, vec4<f32>(place, depth, 1.0));
}

fn depth_of_linear(place: vec2<f32>, linear: f32) -> f32 {
    if is_parallel() {
        return linear;
    }
    let row = parameters.inverse_depth;
    return (1.0 / linear - row.x * place.x - row.y * place.y - row.w) / row.z;
}

fn is_parallel() -> bool {
    return all(parameters.inverse_depth.xyz == vec3<f32>(0.0));
}

// log2 of a need in whole levels, rounded up, 0 to 31. From the bits of the number: exact on every driver.
fn need_level(need: f32) -> u32 {
    let scaled = need * parameters.need_scale;
    if !(scaled < 2147483648.0) {
        return MAX_LEVEL;
    }
    let bits = bitcast<u32>(max(scaled, 1.0));
    return (bits >> 23u) - 127u + select(0u, 1u, (bits & 0x7fffffu) != 0u);
}
