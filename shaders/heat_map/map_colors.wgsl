// The map in which the shadow of each pixel is looked up, in color: red, yellow, green, blue and again (Stingl, equation
// 5.1), as the gizmos have it.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::selection::{parameters, select_view}
#import umbrage::surface::{load_depth, surface_at}

const COLORS: array<vec3<f32>, 4> = array<vec3<f32>, 4>(
    vec3<f32>(1.0, 0.0, 0.0), vec3<f32>(1.0, 1.0, 0.0), vec3<f32>(0.0, 1.0, 0.0), vec3<f32>(0.0, 0.0, 1.0),
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
    var colors = COLORS;
    return vec4<f32>(colors[selected.index % 4u], parameters.opacity);
}
