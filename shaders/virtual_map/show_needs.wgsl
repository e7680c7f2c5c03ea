// How finely the pixels of a picture need the map of a fitted sun, in color, and the screen rectangles of the tiles that are
// drawn for them.
//
// Colors are log2 of texels per axis of the whole map, from LOWEST (blue) to LOWEST + 10 (red).

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::needs::{depth_at, is_in_map, is_shadowed, need_at, parameters, patch_at}
#import umbrage::types::NeedOverlay

@group(0) @binding(4) var<storage, read> overlay: NeedOverlay;
// First pixel and one after the last.
@group(0) @binding(5) var<storage, read> rectangles: array<vec4<u32>>;

// log2 of the texels that are shown in the first color.
const LOWEST: f32 = 8.0;
const STOPS: array<vec3<f32>, 6> = array<vec3<f32>, 6>(
    vec3<f32>(0.01, 0.01, 0.2), vec3<f32>(0.01, 0.1, 0.8), vec3<f32>(0.01, 0.5, 0.5), vec3<f32>(0.1, 0.6, 0.05),
    vec3<f32>(0.9, 0.6, 0.02), vec3<f32>(0.8, 0.05, 0.01),
);
// Needs that no tile can meet.
const CAPPED: vec3<f32> = vec3<f32>(0.9, 0.05, 0.7);
const RECTANGLE: vec4<f32> = vec4<f32>(1.0, 1.0, 1.0, 0.7);

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.position.xy) - vec2<i32>(parameters.picture_origin);
    if is_on_rectangle(vec2<u32>(pixel)) {
        return RECTANGLE;
    }
    let depth = depth_at(pixel);
    if !is_shadowed(pixel, depth) {
        return vec4<f32>(0.0);
    }
    let found = patch_at(pixel, depth, vec2<i32>(1));
    if !is_in_map(found) {
        return vec4<f32>(0.0);
    }
    let need = need_at(pixel, found, vec2<i32>(1));
    let level = ceil(log2(max(need.x, need.y)));
    return vec4<f32>(select(level_color(level), CAPPED, level > overlay.cap), overlay.opacity);
}

fn level_color(level: f32) -> vec3<f32> {
    let place = clamp((level - LOWEST) * 0.5, 0.0, 4.9999);
    let stop = u32(place);
    var stops = STOPS;
    return mix(stops[stop], stops[stop + 1u], fract(place));
}

// Whether a pixel is on the outline of a tile's screen rectangle.
fn is_on_rectangle(pixel: vec2<u32>) -> bool {
    for (var i = 0u; i < overlay.rectangle_count; i += 1u) {
        let rect = rectangles[i];
        let is_inside = all(pixel >= rect.xy) && all(pixel < rect.zw);
        if is_inside && (any(pixel == rect.xy) || any(pixel + 1u == rect.zw)) {
            return true;
        }
    }
    return false;
}
