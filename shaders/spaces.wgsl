// Conversions between screen, world and light spaces.
//
// Conventions: NDC x right, y up, z 1 near to 0 far (reverse); pixel coordinates with the origin at the top left
// corner of the top left pixel; texel coordinates likewise; view depth is positive in front of the camera.
#define_import_path umbrage::spaces

#import bevy_render::view::View

// World position of the surface that the depth prepass holds at a pixel. `pixel`: centre of the pixel in the target.
fn position_from_depth(view: View, pixel: vec2<f32>, depth_ndc: f32) -> vec3<f32> {
    let uv = (pixel - view.viewport.xy) / view.viewport.zw;
    let ndc = vec4<f32>(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, depth_ndc, 1.0);
    let world = view.world_from_clip * ndc;
    return world.xyz / world.w;
}

// Distance along the view direction, metres.
fn distance_along_view(view: View, position: vec3<f32>) -> f32 {
    return -(view.view_from_world * vec4<f32>(position, 1.0)).z;
}

// Clip space of a light view to its own texture coordinates.
fn uv_from_ndc(ndc: vec2<f32>) -> vec2<f32> {
    return ndc * vec2<f32>(0.5, -0.5) + 0.5;
}
