
// Added by Umbrage. The lookup above keeps its body under the name `fetch_directional_shadow_bevy`; this one takes its
// place for lights whose last cascade is the layer of the shadow result: its far bound is exactly 1e9 m and its texels
// are of a millimetre, which no stock cascade can be (`shadow::full` writes both).
fn fetch_directional_shadow(
    light_id: u32,
    frag_position: vec4<f32>,
    surface_normal: vec3<f32>,
    view_z: f32,
    frag_coord_xy: vec2<f32>,
) -> f32 {
#ifdef DEPTH_PREPASS
#ifndef MULTISAMPLED
    let light = &view_bindings::lights.directional_lights[light_id];
    let last = max((*light).num_cascades, 1u) - 1u;
    let is_result = ((*light).cascades[last].far_bound == 1.0e9) & ((*light).cascades[last].texel_size < 0.0011);
    let pixel = vec2<i32>(frag_coord_xy);
    let prepass_ndc = textureLoad(view_bindings::depth_prepass_texture, pixel, 0);
    let prepass_view_z = view_transformations::depth_ndc_to_view_z(prepass_ndc);
    // Fragments that are not the surface of the depth prepass (transparent ones) have no shadow result.
    //
    // NOTE: one branch, which depends on the pixel. Of branches on uniform values alone a software driver compiles a
    // shader for every value of the buffer that it meets and keeps them all (155 in 15 s of a walk through the city).
    let tolerance = select(-1.0, 0.01 * abs(prepass_view_z), is_result);
    if abs(prepass_view_z - view_z) <= tolerance {
        let layer = i32((*light).depth_texture_base_index + last);
        return textureLoad(view_bindings::directional_shadow_textures, pixel, layer, 0);
    }
#endif
#endif
    return fetch_directional_shadow_bevy(light_id, frag_position, surface_normal, view_z, frag_coord_xy);
}
