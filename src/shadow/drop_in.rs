//! The drop-in path: Bevy's own shadow passes and lookup, with better matrices.
//!
//! Bevy picks a cascade by view depth, so slices and cascades coincide without overlap. The whole warp is put into
//! `clip_from_cascade`; `world_from_cascade` stays rigid, as Bevy's code demands.
//!
//! **Bias.** Bevy moves a receiver along its normal by a multiple of one texel size per cascade before it looks it up,
//! but the texels of a warped map grow from its near end to its far end. The largest texel is what a cascade reports:
//! then the far end has no acne, and nearer receivers are moved by as much as the far ones, more than they need. So that
//! this does not eat the shadows near the eye, the warp is limited: texels at the far end are at most two and a half
//! times as wide as at the near end. Bevy's constant bias, which would detach shadows near the eye, is set to a
//! millimetre. The maps are fitted with that much room around the receivers, so that a moved receiver never leaves its
//! map. The full path has none of these limits.

use bevy::light::{CascadeShadowConfig, Cascades, cascade::Cascade};

use super::{
    full::mask_cascade,
    settings::{ShadowBias, SunShadows},
    views::{LightView, SunViews},
};
use crate::maths::fit::{FitInput, LightFit, fit_light_view};

/// Texels that Bevy's widest filter (a Gaussian over 5×5) reads beyond a point, and one for rounding.
const GUARD_TEXELS: f64 = 4.0;

/// Normal bias in texels before Bevy multiplies it by √2: less than Bevy's default, because the texel size that is
/// reported is the largest.
const NORMAL_BIAS: f32 = 1.3;

/// Limit of the warp where there is a normal bias: texels at the far end over texels at the near end.
const LARGEST_TEXEL_RATIO: f64 = 2.5;

/// Constant bias in metres: covers rounding of depths.
const DEPTH_BIAS: f32 = 0.001;

/// Bevy's `shadow_depth_bias` (metres) and `shadow_normal_bias` (texels) for a setting.
pub fn biases(bias: ShadowBias) -> (f32, f32) {
    match bias {
        ShadowBias::None => (0.0, 0.0),
        ShadowBias::Constant { metres } => (metres, 0.0),
        ShadowBias::Footprint { scale } => (DEPTH_BIAS * scale, NORMAL_BIAS * scale),
    }
}

/// Fits a light view with room for Bevy's filter and normal bias.
pub(super) fn fit(input: FitInput, bias: ShadowBias) -> Option<LightFit> {
    let (_, normal_bias) = biases(bias);
    let input = FitInput {
        guard_texels: GUARD_TEXELS,
        ..input
    };
    if normal_bias == 0.0 {
        return fit_light_view(&input).fitted();
    }
    let limited = FitInput {
        largest_texel_ratio: LARGEST_TEXEL_RATIO,
        ..input
    };
    let first = fit_light_view(&limited).fitted()?;
    let moved_by = f64::from(normal_bias) * std::f64::consts::SQRT_2 * first.largest_texel_size;
    // The room itself makes texels a little larger.
    let guard_metres = moved_by * 1.1;
    fit_light_view(&FitInput {
        guard_metres,
        ..limited
    })
    .fitted()
}

/// A light view as one of Bevy's cascades.
pub fn cascade(light_view: &LightView) -> Cascade {
    Cascade {
        world_from_cascade: light_view.world_from_light,
        clip_from_cascade: light_view.clip_from_light,
        clip_from_world: light_view.clip_from_world,
        texel_size: light_view.largest_texel_size,
    }
}

/// Overwrites the cascades of every camera with its partitions, and the split distances with the common ones.
///
/// Cameras that see nothing get cascades that contain nothing: everything in their view is lit.
pub(super) fn write(
    settings: &SunShadows,
    views: &SunViews,
    config: &mut CascadeShadowConfig,
    cascades: &mut Cascades,
) {
    let count = settings.partitions.count as usize;
    for (camera, camera_cascades) in &mut cascades.cascades {
        *camera_cascades = match views.cameras.get(camera) {
            Some(views) => views
                .partitions
                .iter()
                .map(|partition| cascade(&partition.light_view))
                .collect(),
            None => vec![mask_cascade(); count],
        };
    }
    config.overlap_proportion = 0.0;
    match views.cameras.values().next() {
        Some(views) => {
            config.minimum_distance = views.partitions[0].light_view.near_depth.max(0.0);
            config.bounds.clear();
            config
                .bounds
                .extend(views.partitions.iter().map(|partition| partition.light_view.far_depth));
            // The farthest receiver itself is in front of the last bound.
            if let Some(last) = config.bounds.last_mut() {
                *last += last.abs() * 1.0e-4;
            }
        }
        None => config.bounds = (1..=count).map(|bound| bound as f32).collect(),
    }
}
