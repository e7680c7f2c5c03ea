// Ground of up to four tiles, mixed by the weights in the vertex colours.
//
// Tiles lie flat on the world's x and z; their normals are relative to x, -z and up. Weights need not sum to one: their
// sum is the brightness.

#import bevy_pbr::{
    forward_io::{FragmentOutput, VertexOutput},
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
}

@group(#{MATERIAL_BIND_GROUP}) @binding(100) var tile_colors: texture_2d_array<f32>;
@group(#{MATERIAL_BIND_GROUP}) @binding(101) var tile_sampler: sampler;
@group(#{MATERIAL_BIND_GROUP}) @binding(102) var tile_normals: texture_2d_array<f32>;
/// One over the width of each tile in metres.
@group(#{MATERIAL_BIND_GROUP}) @binding(103) var<uniform> tiles_per_metre: vec4<f32>;

/// How much the lighter texels of a tile win where two tiles meet.
const EDGE: f32 = 2.5;
/// Weights below this do not count.
const LEAST: f32 = 0.01;

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var surface = pbr_input_from_standard_material(in, is_front);
    let plan = in.world_position.xz;
    let plan_dx = dpdx(plan);
    let plan_dy = dpdy(plan);
    let brightness = dot(in.color, vec4(1.0));
    var color = vec3(0.0);
    var lean = vec2(0.0);
    var total = 0.0;
    for (var tile = 0; tile < 4; tile++) {
        let weight = in.color[tile] / max(brightness, 1e-4);
        if weight < LEAST {
            continue;
        }
        let scale = tiles_per_metre[tile];
        let own_color =
            textureSampleGrad(tile_colors, tile_sampler, plan * scale, tile, plan_dx * scale, plan_dy * scale).rgb;
        let own_normal =
            textureSampleGrad(tile_normals, tile_sampler, plan * scale, tile, plan_dx * scale, plan_dy * scale).xy;
        // Stones and blades come through first where tiles meet.
        let share = weight * weight * exp(EDGE * (sqrt(own_color.g) - 0.5));
        color += share * own_color;
        lean += share * (own_normal * 2.0 - 1.0);
        total += share;
    }
    color *= brightness / max(total, 1e-4);
    lean /= max(total, 1e-4);
    surface.material.base_color = vec4(color, 1.0);
    let normal = surface.world_normal;
    let east = normalize(vec3(1.0, 0.0, 0.0) - normal * normal.x);
    let north = normalize(vec3(0.0, 0.0, -1.0) + normal * normal.z);
    let up = sqrt(max(1.0 - dot(lean, lean), 0.01));
    surface.N = normalize(normal * up + east * lean.x + north * lean.y);
    var out: FragmentOutput;
    out.color = apply_pbr_lighting(surface);
    out.color = main_pass_post_lighting_processing(surface, out.color);
    return out;
}
