// The mapping map of the thesis: needs and places of one pixel in many, read back whole.
//
// The CPU twin is `TileMappingMap::new` in `src/maths/virtual_map/mapping.rs`.

#import umbrage::needs::{depth_at, is_in_map, is_shadowed, need_at, need_level, parameters, patch_at}
#import umbrage::types::{FOUND_NOTHING, FOUND_OUTSIDE, FOUND_SURFACE, MappingTexel}

#ifdef BYTES
// Place along u, v and need along u, v in a byte each; BYTES_* where there is none.
@group(0) @binding(4) var<storage, read_write> texels: array<u32>;

// No encoded need is so large.
const BYTES_NOTHING: u32 = 0xffffffffu;
const BYTES_OUTSIDE: u32 = 0xfeffffffu;
// 2^-30: patches that are edge-on to the light have no extent.
const SMALLEST_EXTENT: f32 = 9.313226e-10;
#else
@group(0) @binding(4) var<storage, read_write> texels: array<MappingTexel>;
#endif

@compute @workgroup_size(8, 8, 1)
fn map_needs(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = parameters.map_size;
    if any(id.xy >= size) {
        return;
    }
    // The middle one of the texel's pixels.
    let pixel = vec2<i32>((2u * id.xy + 1u) * parameters.picture_size / (2u * size));
    let ratio = vec2<f32>(parameters.picture_size) / vec2<f32>(size);
    // Halves go up; `round` would take them to even numbers.
    let wide_step = vec2<i32>(max(floor(ratio + 0.5), vec2<f32>(1.0)));
    let step = select(vec2<i32>(1), wide_step, parameters.wide_steps == 1u);
    texels[id.y * size.x + id.x] = texel_at(pixel, step, ratio);
}

#ifdef BYTES
fn texel_at(pixel: vec2<i32>, step: vec2<i32>, ratio: vec2<f32>) -> u32 {
    let depth = depth_at(pixel);
    if !is_shadowed(pixel, depth) {
        return BYTES_NOTHING;
    }
    let found = patch_at(pixel, depth, step);
    if !is_in_map(found) {
        return BYTES_OUTSIDE;
    }
    let steps = select(1.0, max(ratio.x, ratio.y), parameters.wide_steps == 1u);
    let extent = steps / need_at(pixel, found, step);
    let place = vec2<u32>(floor(found.uv * 255.0 + 0.5));
    return place.x | (place.y << 8u) | (byte_need(extent.x) << 16u) | (byte_need(extent.y) << 24u);
}

// R = - exponent(frexp(√2 Δ)), from the bits of the number.
fn byte_need(extent: f32) -> u32 {
    let bits = bitcast<u32>(sqrt(2.0) * max(extent, SMALLEST_EXTENT));
    return u32(max(126 - i32(bits >> 23u), 0));
}
#else
fn texel_at(pixel: vec2<i32>, step: vec2<i32>, ratio: vec2<f32>) -> MappingTexel {
    var texel: MappingTexel;
    texel.levels = FOUND_NOTHING << 16u;
    let depth = depth_at(pixel);
    if !is_shadowed(pixel, depth) {
        return texel;
    }
    let found = patch_at(pixel, depth, step);
    if !is_in_map(found) {
        texel.levels = FOUND_OUTSIDE << 16u;
        return texel;
    }
    let need = need_at(pixel, found, step);
    texel.uv = found.uv;
    if any(ratio != vec2<f32>(1.0)) {
        texel.reach = abs(found.right) * 0.5 * ratio.x + abs(found.down) * 0.5 * ratio.y;
    }
    texel.levels = need_level(need.x) | (need_level(need.y) << 8u) | (FOUND_SURFACE << 16u);
    return texel;
}
#endif
