// A fading level of detail: a standard material with the coat's alpha on top.
//
// Two variants. UMBRAGE_NEAREST writes normal and level of the nearest fading surface of every pixel, beside its depth, for
// the levels of one layer. The other one, drawn among transparent things, is blended over the scene; of its own layers it draws the
// nearest only, so that the picture at alpha 1 is that of the opaque level.

#import bevy_pbr::{
    decal::clustered::apply_decals,
    forward_io::VertexOutput,
    mesh_functions::get_tag,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{alpha_discard, apply_pbr_lighting, main_pass_post_lighting_processing},
    pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT,
}
#import umbrage::coat::{coat_alpha, coat_layer, coat_level}

#ifdef UMBRAGE_NEAREST

struct Nearest {
    // World space, 0..1 for -1..1.
    @location(0) normal: vec4<f32>,
    @location(1) level: u32,
}

// The layer that is drawn.
@group(4) @binding(0) var<uniform> layer: vec4<u32>;

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> Nearest {
    let tag = get_tag(in.instance_index);
    if coat_layer(tag) != layer.x {
        discard;
    }
    let surface = pbr_input_from_standard_material(in, is_front);
    alpha_discard(surface.material, surface.material.base_color);
    var nearest: Nearest;
    nearest.normal = vec4<f32>(surface.N * 0.5 + 0.5, 1.0);
    nearest.level = coat_level(tag);
    return nearest;
}

#else // UMBRAGE_NEAREST

@group(4) @binding(0) var nearest_depth: texture_depth_2d_array;
@group(4) @binding(1) var nearest_level: texture_2d_array<u32>;

// Depths nearer to the nearest one than this share of it are the nearest one, drawn again. A fragment's depth has the bias
// that decides ties in it, up to two millionths; the nearest depth has none.
const SAME_SHARE: f32 = 1e-5;

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> @location(0) vec4<f32> {
    let tag = get_tag(in.instance_index);
    let pixel = vec2<i32>(in.position.xy);
    let layer = coat_layer(tag);
    let is_own = textureLoad(nearest_level, pixel, layer, 0).r == coat_level(tag);
    if is_own && in.position.z < textureLoad(nearest_depth, pixel, layer, 0) * (1.0 - SAME_SHARE) {
        discard;
    }
    var surface = pbr_input_from_standard_material(in, is_front);
    surface.material.base_color = alpha_discard(surface.material, surface.material.base_color);
    apply_decals(&surface);
    var color = surface.material.base_color;
    if (surface.material.flags & STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u {
        color = apply_pbr_lighting(surface);
    }
    color = main_pass_post_lighting_processing(surface, color);
    color.a *= coat_alpha(tag);
    return color;
}

#endif // UMBRAGE_NEAREST
