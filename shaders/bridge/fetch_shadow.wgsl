
// Added by Umbrage. The lookup above keeps its body under the name `fetch_directional_shadow_bevy`; this one takes its
// place for lights whose second cascade is the layer of the shadow result: its far bound is exactly 1e9 m and its texels
// are of a millimetre, which no stock cascade can be (`shadow::full` writes both). A third one is that of transparent
// surfaces, packed by `write_second_layer.wgsl`.
#ifdef UMBRAGE_FADING
@group(4) @binding(3) var umbrage_fading_depth: texture_depth_2d_array;
@group(4) @binding(2) var umbrage_fading_result: texture_2d_array<f32>;
// Those that are the nearest in no layer take the result of what is opaque nearby, mostly their own object.
const UMBRAGE_SAME_SURFACE: f32 = 0.1;
#else
const UMBRAGE_SAME_SURFACE: f32 = 0.01;
#endif

// Share of the depth. Eight bits less leave it to 1.5e-5.
const UMBRAGE_SAME_TRANSPARENT: f32 = 0.001;
// What is nearer to the opaque surface than this share is that surface, also where something transparent is as near.
const UMBRAGE_SURELY_SAME: f32 = 0.0001;

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
    let own = min(last, 1u);
    let is_result = ((*light).cascades[own].far_bound == 1.0e9) & ((*light).cascades[own].texel_size < 0.0011);
    let first_layer = i32((*light).depth_texture_base_index);
    let pixel = vec2<i32>(frag_coord_xy);
    let prepass_ndc = textureLoad(view_bindings::depth_prepass_texture, pixel, 0);
    let prepass_view_z = view_transformations::depth_ndc_to_view_z(prepass_ndc);
    // Fragments that are neither the surface of the depth prepass nor the transparent one of the layer have no shadow
    // result.
    //
    // NOTE: one branch, which depends on the pixel. Of branches on uniform values alone a software driver compiles a
    // shader for every value of the buffer that it meets and keeps them all (155 in 15 s of a walk through the city).
#ifdef UMBRAGE_FADING
    // Fading levels of detail have a shadow result of their own, for the nearest of every layer.
    for (var layer = 0u; layer < textureNumLayers(umbrage_fading_depth); layer += 1u) {
        let fading_ndc = textureLoad(umbrage_fading_depth, pixel, layer, 0);
        let fading_view_z = view_transformations::depth_ndc_to_view_z(fading_ndc);
        let fading_tolerance = select(-1.0, 0.001 * abs(fading_view_z), is_result & (fading_ndc > 0.0));
        if abs(fading_view_z - view_z) <= fading_tolerance {
            return textureLoad(umbrage_fading_result, pixel, layer, 0).r;
        }
    }
#endif
    // Where nothing is opaque, its depth is 0 and its distance infinite, to which no share is too large.
    let has_opaque = is_result & (prepass_ndc > 0.0);
    let off = select(1.0, abs(prepass_view_z - view_z) / abs(prepass_view_z), has_opaque);
    if off <= UMBRAGE_SURELY_SAME {
        return textureLoad(view_bindings::directional_shadow_textures, pixel, first_layer + i32(own), 0);
    }
    let packed = bitcast<u32>(textureLoad(view_bindings::directional_shadow_textures, pixel, first_layer + i32(last), 0));
    let second_ndc = bitcast<f32>(packed & 0xffffff00u);
    let second_view_z = view_transformations::depth_ndc_to_view_z(second_ndc);
    let second_tolerance =
        select(-1.0, UMBRAGE_SAME_TRANSPARENT * abs(second_view_z), is_result & (last == 2u) & (second_ndc > 0.0));
    if abs(second_view_z - view_z) <= second_tolerance {
        return f32(packed & 0xffu) / 255.0;
    }
    if off <= UMBRAGE_SAME_SURFACE {
        return textureLoad(view_bindings::directional_shadow_textures, pixel, first_layer + i32(own), 0);
    }
#endif
#endif
    return fetch_directional_shadow_bevy(light_id, frag_position, surface_normal, view_z, frag_coord_xy);
}
