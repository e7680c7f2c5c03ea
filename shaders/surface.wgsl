// The surface that a camera's prepass holds at a pixel: position and plane.
#define_import_path umbrage::surface

#import bevy_render::view::View
#import umbrage::spaces::{distance_along_view, position_from_depth}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var depth_prepass: texture_depth_2d;
// World space, 0..1 for -1..1; white where the camera has no normal prepass.
@group(0) @binding(2) var normal_prepass: texture_2d<f32>;

// Pixels that are farther off the line through two neighbours, as a share of their depth, have no normal.
const LARGEST_MISFIT: f32 = 0.02;
// Misfit of three pixels on one plane: rounding of depths, share of their depth.
const EXACT_MISFIT: f32 = 1e-5;
// Façades with fins or reveals as wide as a pixel hold no plane at all: the normal counts as off by up to 14 degrees.
// More costs shadows beside edges: against 64 samples per pixel (city, avenue) the root mean square error of the mask is
// 0.093 at 0, 0.095 at 14 and 0.100 at 29 degrees, while speckled pixels in 550 of such a façade are 159, 27 and 20.
const LARGEST_NORMAL_ERROR: f32 = 0.25;
// Cosine between the plane of the depths and the shading normal from which the plane is believed: 18 degrees. Depths of
// fins as wide as a pixel can lie on one false plane exactly; shading normals cannot, but they are rounded off.
const SAME_NORMAL_COSINE: f32 = 0.95;
// Lengths of normals. Between vertex normals that differ much, as on coarse foliage, the prepass holds short ones: 0.7 halfway
// between two that are 90 degrees apart. What it is cleared to, and white, which stands for no prepass, have 1.73.
const LEAST_LENGTH: f32 = 0.1;
const MOST_LENGTH: f32 = 1.1;

struct Surface {
    position: vec3<f32>,
    // Of the surface's plane, towards the viewer.
    normal: vec3<f32>,
    // False: no normal prepass, and no two neighbours lie on the pixel's own surface (thinner than a few pixels).
    has_normal: bool,
    // How far the normal may be off, radians.
    normal_error: f32,
    view_depth: f32,
}

fn load_depth(pixel: vec2<i32>) -> f32 {
    return textureLoad(depth_prepass, pixel, 0);
}

// The plane of the depths where the shading normal agrees with it, else the plane that the shading normal gives.
// `fallback_normal`: where there is neither.
fn surface_at(pixel: vec2<f32>, depth_ndc: f32, fallback_normal: vec3<f32>) -> Surface {
    var surface: Surface;
    surface.position = position_from_depth(view, pixel, depth_ndc);
    surface.view_depth = distance_along_view(view, surface.position);
    fit_plane(&surface, pixel, depth_ndc, fallback_normal);
    let shading_normal = load_normal(pixel, surface.position);
    let is_plane = surface.has_normal && dot(surface.normal, shading_normal) > SAME_NORMAL_COSINE;
    if !is_plane && any(shading_normal != vec3<f32>(0.0)) {
        surface.normal = shading_normal;
        surface.has_normal = true;
        surface.normal_error = LARGEST_NORMAL_ERROR;
    }
    return surface;
}

// The normal of the prepass, turned to the viewer; zero without one.
fn load_normal(pixel: vec2<f32>, position: vec3<f32>) -> vec3<f32> {
    let normal = textureLoad(normal_prepass, vec2<i32>(pixel), 0).xyz * 2.0 - 1.0;
    let normal_length = length(normal);
    if normal_length < LEAST_LENGTH || normal_length > MOST_LENGTH {
        return vec3<f32>(0.0);
    }
    let is_orthographic = view.clip_from_view[3][3] == 1.0;
    let from_viewer = select(position - view.world_position, -view.world_from_view[2].xyz, is_orthographic);
    return normal / normal_length * select(1.0, -1.0, dot(normal, from_viewer) > 0.0);
}

// NDC depth of a plane is affine over the screen: the side on which two neighbours extrapolate best to the pixel's own
// depth is on the pixel's own surface.
fn fit_plane(
    surface: ptr<function, Surface>,
    pixel: vec2<f32>,
    depth_ndc: f32,
    fallback_normal: vec3<f32>,
) {
    let across = plane_step(pixel, depth_ndc, vec2<f32>(1.0, 0.0), surface.position);
    let down = plane_step(pixel, depth_ndc, vec2<f32>(0.0, 1.0), surface.position);
    let misfit = vec2<f32>(across.misfit, down.misfit);
    surface.has_normal = all(vec2<f32>(across.least_misfit, down.least_misfit) < vec2<f32>(LARGEST_MISFIT));
    let off_plane = misfit * surface.view_depth / vec2<f32>(length(across.world), length(down.world));
    surface.normal_error = min(length(off_plane), LARGEST_NORMAL_ERROR);
    let normal = cross(down.world, across.world);
    let normal_length = length(normal);
    surface.has_normal &= normal_length >= 1e-12;
    surface.normal = select(fallback_normal, normal / normal_length, surface.has_normal);
}

struct PlaneStep {
    // To the neighbour pixel on the pixel's own surface, metres.
    world: vec3<f32>,
    // How far the pixel is off the line through two neighbours, on the better side, as a share of its depth.
    least_misfit: f32,
    // The same, but on the worse side where even the better one is not exact: then the surface is no plane.
    misfit: f32,
}

fn plane_step(pixel: vec2<f32>, depth_ndc: f32, axis: vec2<f32>, position: vec3<f32>) -> PlaneStep {
    let before = vec2<f32>(load_depth(vec2<i32>(pixel - axis)), load_depth(vec2<i32>(pixel - 2.0 * axis)));
    let after = vec2<f32>(load_depth(vec2<i32>(pixel + axis)), load_depth(vec2<i32>(pixel + 2.0 * axis)));
    let misfit_before = abs(2.0 * before.x - before.y - depth_ndc) / depth_ndc;
    let misfit_after = abs(2.0 * after.x - after.y - depth_ndc) / depth_ndc;
    var step: PlaneStep;
    step.least_misfit = min(misfit_before, misfit_after);
    step.misfit = select(
        step.least_misfit, max(misfit_before, misfit_after), step.least_misfit > EXACT_MISFIT);
    if misfit_before < misfit_after {
        step.world = position - position_from_depth(view, pixel - axis, before.x);
    } else {
        step.world = position_from_depth(view, pixel + axis, after.x) - position;
    }
    return step;
}
