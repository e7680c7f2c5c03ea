// Shadow result of every pixel: selects a light view, compares depths, filters.
//
// 1 lit, 0 in shadow; sky and everything beyond the shadow distance is lit. Surfaces that face away from the light are
// looked up like all others: a solid's back lies in its own shadow, a leaf's does not and lets light through.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput
#import umbrage::filter::pixel_angle
#import umbrage::selection::{Selected, next_view, parameters, range_fade, select_view, view_share}
#import umbrage::surface::{Surface, load_depth, surface_at}
#import umbrage::visibility::{texels_of_cell, visibility}

@group(0) @binding(4) var atlas: texture_depth_2d;
@group(0) @binding(5) var fading_atlas: texture_depth_2d;

// As many as `ApplyParameters` holds.
const MAX_LIGHT_VIEWS: u32 = 16u;

@fragment
fn fragment(in: FullscreenVertexOutput) -> @location(0) f32 {
    let depth_ndc = load_depth(vec2<i32>(in.position.xy));
    if depth_ndc <= 0.0 {
        return 1.0;
    }
    let surface = surface_at(in.position.xy, depth_ndc, parameters.direction_to_light);
    let lit = blended_visibility(surface, pixel_angle(in.position.xy));
    if parameters.fade_length > 0.0 {
        return mix(1.0, lit, range_fade(surface.view_depth));
    }
    return lit;
}

// Every view takes its share, the last one that holds the point all that is left: v1 + l1 (v2 - v1) + l2 (v3 - v2) with what
// the views before leave, l1 and l2; where all agree the sum is exact. Without seams the first takes all.
fn blended_visibility(surface: Surface, angle: f32) -> f32 {
    var selected = select_view(surface);
    if !selected.is_found {
        return 1.0;
    }
    var lit = 0.0;
    var left = 1.0;
    var before = 0.0;
    // Every view at most once: a bound that no driver can miss.
    for (var step = 0u; step < MAX_LIGHT_VIEWS; step += 1u) {
        let visible = visibility_in(selected, surface, angle);
        lit += left * (visible - before);
        before = visible;
        if parameters.has_seams == 0u {
            break;
        }
        left *= 1.0 - view_share(selected, surface);
        if left <= 0.0 {
            break;
        }
        selected = next_view(surface, selected);
        if !selected.is_found {
            break;
        }
    }
    return lit;
}

fn visibility_in(selected: Selected, surface: Surface, angle: f32) -> f32 {
    let texels = texels_of_cell(parameters.light_views[selected.index].atlas_rect);
    let clip_from_world = parameters.light_views[selected.index].clip_from_world;
    let has_fading = parameters.has_fading != 0u;
    return visibility(atlas, fading_atlas, has_fading, texels, clip_from_world, selected.plane, surface, angle);
}
