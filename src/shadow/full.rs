//! What the full path asks of Bevy's cascades: a master view and a mask layer.
//!
//! The light has two cascades for every camera. The first is the *master view*: one uniform map over the whole range,
//! the fallback for transparent surfaces; its frustum contains every caster of every partition, so Bevy's culling of it
//! yields the set of casters. The second, the *mask layer*, contains nothing: the render room writes the shadow result
//! into its depth texture, and finds it by its far bound. Where the settings ask for it, a third one of the same kind
//! carries transparent surfaces, layer by layer.

use bevy::{
    light::{CascadeShadowConfig, Cascades, cascade::Cascade},
    math::{Mat4, UVec2, Vec3},
};

use super::{drop_in::cascade, views::SunViews};

/// The far bound of the mask layer, in metres: no other cascade reaches that far, so shaders know the layer by it.
pub const MASK_BOUND: f32 = 1.0e9;

/// Far below every world, in metres.
const MASK_HEIGHT: f32 = -1.0e6;

/// Side of the mask layer's box in metres.
const MASK_BOX: f32 = 0.001;

/// The largest map that is asked for to hold a picture's shadow result, in texels.
const LARGEST_MASK: u32 = 8192;

/// The cascade of the mask layer: a box of a millimetre far below the world, which sees no caster.
pub fn mask_cascade() -> Cascade {
    let world_from_cascade = Mat4::from_translation(Vec3::Y * MASK_HEIGHT);
    let clip_from_cascade = Mat4::from_scale(Vec3::new(2.0 / MASK_BOX, 2.0 / MASK_BOX, 1.0 / MASK_BOX));
    Cascade {
        world_from_cascade,
        clip_from_cascade,
        clip_from_world: clip_from_cascade * Mat4::from_translation(Vec3::Y * -MASK_HEIGHT),
        texel_size: MASK_BOX,
    }
}

/// Side of the mask layer in texels that holds the shadow result of a picture: the power of two that Bevy's shadow maps
/// demand.
pub fn mask_size(picture: UVec2) -> usize {
    picture.max_element().clamp(1, LARGEST_MASK).next_power_of_two() as usize
}

/// Overwrites the cascades of every camera with master view, mask layer and that of transparent surfaces. Cameras that see nothing get an empty master
/// view.
pub(super) fn write(
    views: &SunViews,
    has_transparent_layer: bool,
    config: &mut CascadeShadowConfig,
    cascades: &mut Cascades,
) {
    let layers = if has_transparent_layer { 2 } else { 1 };
    for (camera, camera_cascades) in &mut cascades.cascades {
        let master = views
            .cameras
            .get(camera)
            .map_or_else(mask_cascade, |views| cascade(&views.master));
        *camera_cascades = std::iter::once(master)
            .chain(std::iter::repeat_n(mask_cascade(), layers))
            .collect();
    }
    let range = views
        .cameras
        .values()
        .map(|views| (views.near_depth, views.far_depth))
        .reduce(|(near, far), (other_near, other_far)| (near.min(other_near), far.max(other_far)));
    let (near, far) = range.unwrap_or((0.0, 1.0));
    config.overlap_proportion = 0.0;
    config.minimum_distance = near.max(0.0);
    config.bounds.clear();
    // The farthest receiver itself is in front of the bound.
    config.bounds.extend([
        (far + far.abs() * 1.0e-4).min(0.5 * MASK_BOUND),
        MASK_BOUND,
        2.0 * MASK_BOUND,
    ]);
    config.bounds.truncate(1 + layers);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mask_layer_contains_nothing() {
        let mask = mask_cascade();
        for point in [Vec3::ZERO, Vec3::splat(1.0e4), Vec3::NEG_Y * 9.0e5, Vec3::X * 0.0004] {
            let ndc = mask.clip_from_world.project_point3(point);
            assert!(ndc.is_finite() && ndc.abs().max_element() > 1.0, "{point}: {ndc}");
        }
        let own = mask.clip_from_cascade * mask.world_from_cascade.inverse();
        assert!(own.abs_diff_eq(mask.clip_from_world, 1.0e-3), "the matrices compose");
    }

    #[test]
    fn masks_hold_pictures() {
        assert_eq!(mask_size(UVec2::new(1920, 1080)), 2048);
        assert_eq!(mask_size(UVec2::new(300, 512)), 512);
        assert_eq!(mask_size(UVec2::ZERO), 1);
        assert_eq!(mask_size(UVec2::splat(u32::MAX)), 8192);
    }
}
