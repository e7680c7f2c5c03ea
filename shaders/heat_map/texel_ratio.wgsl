// Texel ÷ pixel in color over the picture: the root of the area of a texel over that of a pixel, both on the receiver.
//
// The CPU twins are `src/render/reference/sampling.rs` (the number) and `src/render/heat_map/color.rs` (its color).

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::bias::receiver_plane
#import umbrage::selection::{parameters, select_view}
#import umbrage::surface::{load_depth, surface_at, view}

// Colors of 1/8, 1/4, 1/2, 1, 2, 4 and 8 texels per pixel, linear.
const STOPS: array<vec3<f32>, 7> = array<vec3<f32>, 7>(
    vec3<f32>(0.01, 0.01, 0.12), vec3<f32>(0.01, 0.06, 0.6), vec3<f32>(0.01, 0.4, 0.7), vec3<f32>(0.03, 0.5, 0.05),
    vec3<f32>(0.85, 0.65, 0.03), vec3<f32>(0.85, 0.2, 0.01), vec3<f32>(0.5, 0.01, 0.02),
);

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) vec4<f32> {
    let depth_ndc = load_depth(vec2<i32>(in.position.xy));
    if depth_ndc <= 0.0 {
        return vec4<f32>(0.0);
    }
    let surface = surface_at(in.position.xy, depth_ndc, parameters.direction_to_light);
    let selected = select_view(surface);
    if !selected.is_found {
        return vec4<f32>(0.0);
    }
    let to_viewer = normalize(view.world_position - surface.position);
    let pixel_plane = receiver_plane(view.clip_from_world, surface.position, surface.normal, to_viewer);
    let map_size = parameters.light_views[selected.index].atlas_rect.zw;
    let pixels_per_area = pixel_plane.uv_area_per_square_metre * view.viewport.z * view.viewport.w;
    let texels_per_area = selected.plane.uv_area_per_square_metre * map_size.x * map_size.y;
    return vec4<f32>(heat_color(sqrt(pixels_per_area / texels_per_area)), parameters.opacity);
}

fn heat_color(ratio: f32) -> vec3<f32> {
    let place = clamp(log2(ratio) + 3.0, 0.0, 5.9999);
    let stop = u32(place);
    var stops = STOPS;
    return mix(stops[stop], stops[stop + 1u], fract(place));
}
