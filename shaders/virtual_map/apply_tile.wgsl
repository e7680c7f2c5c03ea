// Applies one tile of a virtual map: overwrites the shadow result of the pixels that lie in it, and of no others.
//
// With COUNT: only of those whose result changes, and counts them. `old_result` is the result before any tile of the level
// was applied; tiles of one level are disjoint, so for their own pixels it is the result before the tile too.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::filter::pixel_angle
#import umbrage::selection::{parameters, range_fade, view_at, view_of_depth}
#import umbrage::spaces::{position_from_depth, uv_from_ndc}
#import umbrage::surface::{load_depth, surface_at, view}
#import umbrage::types::{ShadowTile, TileReport}
#import umbrage::visibility::{MapTexels, visibility}

@group(0) @binding(4) var tile_depths: texture_depth_2d;
@group(0) @binding(5) var fading_depths: texture_depth_2d;
// Storage, not uniform: it differs from tile to tile (see cull_casters.wgsl).
@group(0) @binding(6) var<storage, read> tile: ShadowTile;
#ifdef COUNT
@group(0) @binding(7) var old_result: texture_2d<f32>;
@group(0) @binding(8) var<storage, read_write> reports: array<TileReport>;
#endif

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) f32 {
    let pixel = vec2<i32>(in.position.xy);
    let depth_ndc = load_depth(pixel);
    // Most pixels leave here, before the costly part.
    if depth_ndc <= 0.0 || !is_in_tile(position_from_depth(view, in.position.xy, depth_ndc)) {
        discard;
    }
    let surface = surface_at(in.position.xy, depth_ndc, parameters.direction_to_light);
    let selected = view_at(surface, tile.light_view);
    if !selected.is_found || view_of_depth(surface.view_depth) != tile.light_view {
        discard;
    }
    let clip_from_world = parameters.light_views[tile.light_view].clip_from_world;
    let texels = MapTexels(tile.rect, tile.bounds);
    let angle = pixel_angle(in.position.xy);
    var lit = visibility(
        tile_depths,
        fading_depths,
        parameters.has_fading != 0u,
        texels,
        clip_from_world,
        selected.plane,
        surface,
        angle,
    );
    if parameters.fade_length > 0.0 {
        lit = mix(1.0, lit, range_fade(surface.view_depth));
    }
    let result = stored(lit);
#ifdef COUNT
    let is_changed = abs(result - textureLoad(old_result, pixel, 0).x) > tile.tolerance;
    count(vec2<u32>(pixel), is_changed);
    if !is_changed {
        discard;
    }
#endif
    return result;
}

// Half open, so that each place in the map is in one tile; a coordinate of 1 is in the last.
fn is_in_tile(position: vec3<f32>) -> bool {
    let clip = parameters.light_views[tile.light_view].clip_from_world * vec4<f32>(position, 1.0);
    let place = floor(uv_from_ndc(clip.xy / clip.w) * tile.counts);
    return clip.w > 0.0 && all(min(place, tile.counts - 1.0) == tile.place);
}

// As the texture will hold it: 16 bits, rounded to the nearest.
fn stored(value: f32) -> f32 {
    return unpack2x16float(pack2x16float(vec2<f32>(value, 0.0))).x;
}

#ifdef COUNT
fn count(pixel: vec2<u32>, is_changed: bool) {
    let report = &reports[tile.report];
    atomicAdd(&(*report).inside, 1u);
    if is_changed {
        atomicAdd(&(*report).changed, 1u);
    }
    // Reading is cheaper than an atomic minimum, which few pixels need.
    if pixel.x < atomicLoad(&(*report).min_x) {
        atomicMin(&(*report).min_x, pixel.x);
    }
    if pixel.y < atomicLoad(&(*report).min_y) {
        atomicMin(&(*report).min_y, pixel.y);
    }
    if pixel.x > atomicLoad(&(*report).max_x) {
        atomicMax(&(*report).max_x, pixel.x);
    }
    if pixel.y > atomicLoad(&(*report).max_y) {
        atomicMax(&(*report).max_y, pixel.y);
    }
}
#endif
