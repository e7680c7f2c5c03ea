// The light view in which a pixel's shadow is looked up.
#define_import_path umbrage::selection

#import umbrage::bias::{ReceiverPlane, receiver_plane}
#import umbrage::filter::kernel_per_metre
#import umbrage::surface::Surface
#import umbrage::types::{ApplyParameters, SELECTION_BEST_RESOLUTION, SELECTION_CASCADES}

@group(0) @binding(3) var<uniform> parameters: ApplyParameters;

struct Selected {
    plane: ReceiverPlane,
    index: u32,
    // False: beyond the shadow distance, or in no map.
    is_found: bool,
}

fn select_view(surface: Surface) -> Selected {
    var selected: Selected;
    if surface.view_depth >= parameters.shadow_distance {
        return selected;
    }
    for (var i = 0u; i < parameters.light_view_count; i += 1u) {
        let is_last = i + 1u == parameters.light_view_count;
        let is_behind = surface.view_depth >= parameters.light_views[i].depth_range.y && !is_last;
        if parameters.selection != SELECTION_BEST_RESOLUTION && is_behind {
            continue;
        }
        selected.index = i;
        selected.plane = receiver_plane(
            parameters.light_views[i].clip_from_world, surface.position, surface.normal, parameters.direction_to_light);
        selected.is_found = contains(selected.plane, i);
        if selected.is_found || parameters.selection == SELECTION_CASCADES {
            return selected;
        }
    }
    return selected;
}

// Whether the map holds the point with all texels that the filter reads.
fn contains(plane: ReceiverPlane, index: u32) -> bool {
    var margin = 1.0 / parameters.light_views[index].atlas_rect.zw;
    if parameters.filter_radius > 0.0 && plane.w > 0.0 {
        let kernel = kernel_per_metre(
            parameters.light_views[index].clip_from_world, plane, parameters.direction_to_light);
        // Half the box around the ellipse.
        margin += parameters.filter_radius * sqrt(kernel.across * kernel.across + kernel.along * kernel.along);
    }
    return plane.w > 0.0
        && all(plane.uv >= margin) && all(plane.uv <= 1.0 - margin)
        && plane.depth_ndc >= 0.0 && plane.depth_ndc <= 1.0;
}
