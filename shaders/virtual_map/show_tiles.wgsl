// Tiles of a virtual map in color over the picture: each pixel has the color of the last tile that contains it, dark lines
// between them.
//
// Which color a tile has is decided on the CPU (`src/render/virtual_map/overlay.rs`).

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::selection::{parameters, view_of_depth}
#import umbrage::spaces::{distance_along_view, position_from_depth, uv_from_ndc}
#import umbrage::surface::{load_depth, view}
#import umbrage::types::TileMark

@group(0) @binding(4) var<storage, read> tiles: array<TileMark>;

// Width of the lines in pixels.
const LINE: f32 = 1.5;

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) vec4<f32> {
    let depth_ndc = load_depth(vec2<i32>(in.position.xy));
    let position = position_from_depth(view, in.position.xy, max(depth_ndc, 1e-9));
    let light_view = view_of_depth(distance_along_view(view, position));
    let clip = parameters.light_views[light_view].clip_from_world * vec4<f32>(position, 1.0);
    let uv = uv_from_ndc(clip.xy / clip.w);
    let pixel = fwidth(uv);
    if depth_ndc <= 0.0 || clip.w <= 0.0 || any(uv < vec2<f32>(0.0)) || any(uv > vec2<f32>(1.0)) {
        return vec4<f32>(0.0);
    }
    for (var index = i32(arrayLength(&tiles)) - 1; index >= 0; index -= 1) {
        let tile = tiles[index];
        let place = uv * tile.counts - tile.place;
        let is_inside = all(floor(min(uv * tile.counts, tile.counts - 0.5)) == tile.place);
        if !is_inside || tile.light_view != light_view {
            continue;
        }
        let to_border = min(place, 1.0 - place) / max(pixel * tile.counts, vec2<f32>(1e-9));
        let is_line = min(to_border.x, to_border.y) < 0.5 * LINE;
        return vec4<f32>(select(tile.color.rgb, vec3<f32>(0.0), is_line), tile.color.a);
    }
    return vec4<f32>(0.0);
}
