// What the sun's shadow lookup sees at every pixel of the prepass: visibility, view depth and normal.
//
// It calls the same function as Bevy's lighting does, with the position and the normal of the prepass, so that it shows
// whatever technique is behind that function.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import bevy_pbr::{
    mesh_view_bindings::{lights, view},
    mesh_view_types::DIRECTIONAL_LIGHT_FLAGS_SHADOWS_ENABLED_BIT,
    prepass_utils,
    shadows::fetch_directional_shadow,
    view_transformations::{depth_ndc_to_view_z, frag_coord_to_ndc, position_ndc_to_world},
}

struct MaskSettings {
    // World space, unit length.
    direction_to_sun: vec3<f32>,
}

@group(2) @binding(0) var<uniform> settings: MaskSettings;

struct MaskOutput {
    // 1 lit, 0 in shadow or facing away; sky 1.
    @location(0) visibility: f32,
    // Metres along the view direction; sky 0.
    @location(1) view_depth: f32,
    // World space, 0..1 for -1..1; sky 0.
    @location(2) normal: vec4<f32>,
}

// Bevy sorts its lights; the sun is the one that shines from where the sun is.
fn sun_index() -> u32 {
    var best = 0u;
    var best_cosine = -2.0;
    for (var index = 0u; index < lights.n_directional_lights; index += 1u) {
        let cosine = dot(lights.directional_lights[index].direction_to_light, settings.direction_to_sun);
        if (cosine > best_cosine) {
            best = index;
            best_cosine = cosine;
        }
    }
    return best;
}

fn position_at(pixel: vec2<f32>, depth: f32) -> vec3<f32> {
    return position_ndc_to_world(frag_coord_to_ndc(vec4(pixel, depth, 1.0)));
}

// To the neighbour on an axis whose depth differs less: it is on the pixel's own surface.
fn step_along(axis: vec2<f32>, pixel: vec2<f32>, depth: f32, position: vec3<f32>) -> vec3<f32> {
    let before = prepass_utils::prepass_depth(vec4(pixel - axis, 0.0, 1.0), 0u);
    let after = prepass_utils::prepass_depth(vec4(pixel + axis, 0.0, 1.0), 0u);
    if (abs(after - depth) < abs(before - depth)) {
        return position_at(pixel + axis, after) - position;
    }
    return position - position_at(pixel - axis, before);
}

// Whether both the normal and the plane of a surface, turned to the viewer, face away from the sun. The normals of rounded
// foliage do where its leaves do not: their lighting is dark, but what lies in the sun is not in shadow.
fn faces_away(normal: vec3<f32>, pixel: vec2<f32>, depth: f32, position: vec3<f32>) -> bool {
    if (dot(normal, settings.direction_to_sun) > 0.0) {
        return false;
    }
    let right = step_along(vec2(1.0, 0.0), pixel, depth, position);
    let down = step_along(vec2(0.0, 1.0), pixel, depth, position);
    let plane = cross(down, right);
    let is_orthographic = view.clip_from_view[3][3] == 1.0;
    let from_viewer = select(position - view.world_position, -view.world_from_view[2].xyz, is_orthographic);
    let side = select(1.0, -1.0, dot(plane, from_viewer) > 0.0);
    return dot(plane, settings.direction_to_sun) * side <= 0.0;
}

@fragment
fn fragment(in: FullscreenVertexOutput) -> MaskOutput {
    let depth = prepass_utils::prepass_depth(in.position, 0u);
    // Reverse z: nothing was drawn.
    if (depth == 0.0) {
        return MaskOutput(1.0, 0.0, vec4(0.0));
    }
    let normal = prepass_utils::prepass_normal(in.position, 0u);
    let view_z = depth_ndc_to_view_z(depth);
    let encoded_normal = vec4(normal * 0.5 + 0.5, 1.0);
    let position = position_at(in.position.xy, depth);
    if (faces_away(normal, in.position.xy, depth, position)) {
        return MaskOutput(0.0, -view_z, encoded_normal);
    }
    let index = sun_index();
    let flags = lights.directional_lights[index].flags;
    var visibility = 1.0;
    if ((flags & DIRECTIONAL_LIGHT_FLAGS_SHADOWS_ENABLED_BIT) != 0u) {
        visibility = fetch_directional_shadow(index, vec4(position, 1.0), normal, view_z, in.position.xy);
    }
    return MaskOutput(visibility, -view_z, encoded_normal);
}
