// The light views in which a pixel's shadow is looked up; the CPU twin is `src/maths/selection.rs`.
#define_import_path umbrage::selection

#import umbrage::bias::{ReceiverPlane, receiver_plane}
#import umbrage::filter::kernel_per_metre
#import umbrage::surface::Surface
#import umbrage::types::{
    ApplyParameters,
    SELECTION_BEST_RESOLUTION,
    SELECTION_CASCADES,
    SELECTION_DEPTH,
    SELECTION_FINEST,
}

// No uniform: software drivers compile a shader for every tile from uniforms that decide branches, and keep them all.
@group(0) @binding(3) var<storage, read> parameters: ApplyParameters;

struct Selected {
    plane: ReceiverPlane,
    index: u32,
    // Texels per square metre of the receiver's plane; for SELECTION_FINEST.
    density: f32,
    // False: beyond the shadow distance, or in no map.
    is_found: bool,
}

fn select_view(surface: Surface) -> Selected {
    var none: Selected;
    if surface.view_depth >= parameters.shadow_distance {
        return none;
    }
    if parameters.selection == SELECTION_FINEST {
        return finest_view(surface, none);
    }
    return first_view(surface, 0u);
}

// The view of an index: what the parts of a virtual map are looked up in.
fn view_at(surface: Surface, index: u32) -> Selected {
    var selected: Selected;
    selected.index = index;
    selected.plane = plane_in_view(surface, index);
    selected.is_found = surface.view_depth < parameters.shadow_distance && contains(selected.plane, index);
    return selected;
}

// The view that a view depth belongs to: the first that ends behind it, else the last.
fn view_of_depth(view_depth: f32) -> u32 {
    var index = 0u;
    while index + 1u < parameters.light_view_count && view_depth >= parameters.light_views[index].depth_range.y {
        index += 1u;
    }
    return index;
}

// The view that takes over where another one ends.
fn next_view(surface: Surface, before: Selected) -> Selected {
    if parameters.selection == SELECTION_FINEST {
        return finest_view(surface, before);
    }
    return first_view(surface, before.index + 1u);
}

fn first_view(surface: Surface, start: u32) -> Selected {
    var selected: Selected;
    // Said again: where this is called in a loop, a software driver keeps what the call before left.
    selected.is_found = false;
    for (var i = start; i < parameters.light_view_count; i += 1u) {
        let is_last = i + 1u == parameters.light_view_count;
        let is_behind = surface.view_depth >= parameters.light_views[i].depth_range.y && !is_last;
        if parameters.selection != SELECTION_BEST_RESOLUTION && is_behind {
            continue;
        }
        selected.index = i;
        selected.plane = plane_in_view(surface, i);
        selected.is_found = contains(selected.plane, i);
        if selected.is_found || parameters.selection == SELECTION_CASCADES {
            return selected;
        }
    }
    return selected;
}

// The finest of all maps that hold the point, or of those that are coarser than a found one: seams lead into no map that
// only stands in.
fn finest_view(surface: Surface, before: Selected) -> Selected {
    var finest: Selected;
    finest.density = 0.0;
    finest.is_found = false;
    for (var i = 0u; i < parameters.light_view_count; i += 1u) {
        let plane = plane_in_view(surface, i);
        let is_refused = before.is_found && parameters.light_views[i].stands_in == 1u;
        if is_refused || !contains(plane, i) {
            continue;
        }
        let size = parameters.light_views[i].atlas_rect.zw;
        let density = plane.uv_area_per_square_metre * size.x * size.y;
        let is_coarser = density < before.density || (density == before.density && i > before.index);
        if (is_coarser || !before.is_found) && (density > finest.density || !finest.is_found) {
            finest.plane = plane;
            finest.index = i;
            finest.density = density;
            finest.is_found = true;
        }
    }
    return finest;
}

fn plane_in_view(surface: Surface, index: u32) -> ReceiverPlane {
    return receiver_plane(
        parameters.light_views[index].clip_from_world, surface.position, surface.normal, parameters.direction_to_light);
}

// Whether the map holds the point with all texels that the filter reads.
fn contains(plane: ReceiverPlane, index: u32) -> bool {
    let margin = filter_margin(plane, index);
    return plane.w > 0.0
        && all(plane.uv >= margin) && all(plane.uv <= 1.0 - margin)
        && plane.depth_ndc >= 0.0 && plane.depth_ndc <= 1.0;
}

// Texture coordinates that the filter reads beyond a point.
fn filter_margin(plane: ReceiverPlane, index: u32) -> vec2<f32> {
    let texel = 1.0 / parameters.light_views[index].atlas_rect.zw;
    if parameters.filter_radius > 0.0 && plane.w > 0.0 {
        return texel + parameters.filter_radius * uv_per_metre(plane, index);
    }
    return texel;
}

// Half the box around the image of a disc of one metre radius across the light.
fn uv_per_metre(plane: ReceiverPlane, index: u32) -> vec2<f32> {
    let kernel = kernel_per_metre(
        parameters.light_views[index].clip_from_world, plane, parameters.direction_to_light);
    return sqrt(kernel.across * kernel.across + kernel.along * kernel.along);
}

// How much of a pixel the view takes; the next one gets the rest.
fn view_share(selected: Selected, surface: Surface) -> f32 {
    let light_view = parameters.light_views[selected.index];
    let is_last = selected.index + 1u == parameters.light_view_count;
    if is_last && parameters.selection != SELECTION_FINEST {
        return 1.0;
    }
    if parameters.selection == SELECTION_DEPTH {
        return fade_out(surface.view_depth, light_view.depth_range.y, light_view.seam_depth);
    }
    var band = vec2<f32>(parameters.seam_share);
    if parameters.seam_metres > 0.0 {
        band = parameters.seam_metres * uv_per_metre(selected.plane, selected.index);
    }
    let room = min(selected.plane.uv, 1.0 - selected.plane.uv) - filter_margin(selected.plane, selected.index);
    return min(fade_out(-room.x, 0.0, band.x), fade_out(-room.y, 0.0, band.y));
}

// How much of a shadow is left near the end of the range.
fn range_fade(view_depth: f32) -> f32 {
    return fade_out(view_depth, parameters.fade_end, parameters.fade_length);
}

// 1 up to `end - length`, 0 from `end` on, smooth between.
fn fade_out(value: f32, end: f32, length: f32) -> f32 {
    let left = end - value;
    if left <= 0.0 {
        return 0.0;
    }
    if left >= length {
        return 1.0;
    }
    let t = left / length;
    return t * t * (3.0 - 2.0 * t);
}
