// The shadow result blended with that of the frame before, carried along with the surfaces.
//
// The frame before counts where it saw the same surface: four pixels around the place, bilinear, whose 1/depth (exact on
// planes) agrees. It is limited to what the new result holds nearby, so that a shadow that has really moved leaves no
// trail.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::spaces::{distance_along_view, position_from_depth}
#import umbrage::surface::{load_depth, view}
#import umbrage::types::HistoryFrame

@group(0) @binding(3) var<uniform> frame: HistoryFrame;
@group(0) @binding(4) var visibility: texture_2d<f32>;
// Visibility and view depth of the frame before; depth 0 for sky.
@group(0) @binding(5) var history: texture_2d<f32>;

// Depths that differ at most by this share are one surface.
const DEPTH_TOLERANCE: f32 = 0.005;
// Pixels to each side in which the new result limits the history: as far as a refitted map moves an edge.
const REACH: i32 = 2;
// Weights below this do not count.
const SMALLEST_WEIGHT: f32 = 1e-5;

@fragment
fn blend(in: FullscreenVertexOutput) -> @location(0) vec2<f32> {
    let pixel = vec2<i32>(in.position.xy);
    let depth_ndc = load_depth(pixel);
    if depth_ndc <= 0.0 {
        return vec2<f32>(1.0, 0.0);
    }
    let own = textureLoad(visibility, pixel, 0).x;
    let position = position_from_depth(view, in.position.xy, depth_ndc);
    var blended = own;
    let before = visibility_before(position);
    if frame.is_valid == 1u && before >= 0.0 {
        let limits = nearby(pixel);
        blended = mix(clamp(before, limits.x, limits.y), own, frame.new_share);
    }
    return vec2<f32>(nearest_half(blended), distance_along_view(view, position));
}

// For the result that Bevy's lighting reads.
@fragment
fn resolve(in: FullscreenVertexOutput) -> @location(0) f32 {
    return textureLoad(history, vec2<i32>(in.position.xy), 0).x;
}

// What the frame before held at a point of the world; negative where it did not see it.
fn visibility_before(position: vec3<f32>) -> f32 {
    let clip = frame.clip_from_world * vec4<f32>(position, 1.0);
    if clip.w <= 0.0 {
        return -1.0;
    }
    let uv = clip.xy / clip.w * vec2<f32>(0.5, -0.5) + 0.5;
    let place = view.viewport.xy + uv * view.viewport.zw - 0.5;
    let corner = floor(place);
    let share = place - corner;
    var sum = 0.0;
    var inverse_depth = 0.0;
    for (var i = 0; i < 4; i += 1) {
        let step = vec2<f32>(f32(i % 2), f32(i / 2));
        let weights = select(1.0 - share, share, step == vec2<f32>(1.0));
        let weight = weights.x * weights.y;
        if weight < SMALLEST_WEIGHT {
            continue;
        }
        let tap = corner + step;
        if any(tap < view.viewport.xy) || any(tap >= view.viewport.xy + view.viewport.zw) {
            return -1.0;
        }
        let texel = textureLoad(history, vec2<i32>(tap), 0).xy;
        if texel.y <= 0.0 {
            return -1.0;
        }
        sum += weight * texel.x;
        inverse_depth += weight / texel.y;
    }
    let expected = dot(frame.view_depth_from_world, vec4<f32>(position, 1.0));
    return select(-1.0, sum, abs(inverse_depth * expected - 1.0) <= DEPTH_TOLERANCE);
}

// Least and greatest of the new result nearby.
fn nearby(pixel: vec2<i32>) -> vec2<f32> {
    let first = vec2<i32>(view.viewport.xy);
    let last = first + vec2<i32>(view.viewport.zw) - 1;
    var limits = vec2<f32>(1.0, 0.0);
    for (var y = -REACH; y <= REACH; y += 1) {
        for (var x = -REACH; x <= REACH; x += 1) {
            let value = textureLoad(visibility, clamp(pixel + vec2<i32>(x, y), first, last), 0).x;
            limits = vec2<f32>(min(limits.x, value), max(limits.y, value));
        }
    }
    return limits;
}

// The textures hold 16 bits, and some adapters cut the rest off: it would add up from frame to frame.
fn nearest_half(value: f32) -> f32 {
    return unpack2x16float(pack2x16float(vec2<f32>(value, 0.0))).x;
}
