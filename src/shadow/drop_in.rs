//! The drop-in path: Bevy's own shadow passes and lookup, with better matrices.
//!
//! Bevy picks a cascade by view depth, so slices and cascades coincide without overlap. The whole warp is put into
//! `clip_from_cascade`; `world_from_cascade` stays rigid, as Bevy's code demands.
//!
//! **Bias.** Bevy's lookup moves a receiver along its normal and towards the light by lengths that are the same for a
//! whole cascade, but the texels of a warped map grow from its near end to its far end: lengths that suffice at the far
//! end eat the shadows near the eye. So most of the bias sits on the other side of the comparison. Casters are drawn with
//! a matrix that takes a constant from their depth *after* the division by w; a metre along the light is
//! `depth_per_metre ÷ w` of depth and a texel is about `relative_texel_size · w` metres wide, so this constant is about
//! the same number of local texels everywhere in the map ([`LightView::caster_depth_bias`]; the render room puts it into
//! the views of Bevy's shadow passes, [`render::drop_in`](crate::render::drop_in)).
//!
//! On a surface whose normal is at the angle θ to the light, a filter that reads r texels around a point needs a bias of
//! r · tan θ texels along the light. The number of texels is chosen for level ground, where tan θ is the cotangent of the
//! sun's elevation, and limited. Steeper surfaces are helped by Bevy's normal bias n, which is worth n ÷ cos θ: it is
//! measured in the smallest texels of the map, so near the eye it is small too. The numbers below are the best of a scan
//! over forest, city and room/fence against a dense reference (false shadow against false lit), not derived.
//!
//! Along the warp axis a texel is `w²` times as long as at the near end. `relative_texel_size` takes it at the geometric
//! mean of both ends, where w = √R; at the far end, where w = R, texels are √R times as long as the bias assumes. With
//! `LiSPSM` the pictures show no acne from it; `PSM`, whose R is far larger, shows it everywhere, so warps stronger than
//! `LiSPSM` are refused. The full path has none of these limits.

use bevy::{
    light::{CascadeShadowConfig, Cascades, cascade::Cascade},
    math::DVec3,
};

use super::{
    full::mask_cascade,
    settings::{ShadowBias, SunShadows},
    views::{LightView, SunViews},
};
use crate::maths::{
    drop_in::{LookupRoom, fit_slice_with_room, fit_with_room},
    fit::{FitInput, LightFit},
};

/// Texels that Bevy's widest filter (a Gaussian over 5×5) reads beyond a point, and one for rounding.
pub(super) const GUARD_TEXELS: f64 = 4.0;

/// Normal bias in near texels, before Bevy multiplies it by √2.
const NORMAL_BIAS: f32 = 0.4;

/// Constant bias in metres: covers rounding of depths.
const DEPTH_BIAS: f32 = 0.001;

/// Bias of casters in local texels under a sun overhead.
const CASTER_TEXELS: f64 = 5.5;

/// What is added per unit of the cotangent of the sun's elevation.
const CASTER_TEXELS_PER_COTANGENT: f64 = 0.75;

/// Limit of the sum: beyond it, shadows would leave what casts them.
const MOST_CASTER_TEXELS: f64 = 9.0;

/// Bevy's `shadow_depth_bias` (metres) and `shadow_normal_bias` (texels) for a setting.
pub fn biases(bias: ShadowBias) -> (f32, f32) {
    match bias {
        ShadowBias::None => (0.0, 0.0),
        ShadowBias::Constant { metres } => (metres, 0.0),
        ShadowBias::Footprint { scale } => (DEPTH_BIAS * scale, NORMAL_BIAS * scale),
        // Replaced before ([`checked`](super::checked::checked)).
        ShadowBias::Slope { .. } | ShadowBias::WorldSlope { .. } | ShadowBias::ReceiverPlane { .. } => {
            biases(ShadowBias::default())
        }
    }
}

/// How far casters are moved away from the light, in local texels, for a direction in which light travels.
pub fn caster_texels(bias: ShadowBias, light_travel: DVec3) -> f64 {
    let ShadowBias::Footprint { scale } = bias else {
        return 0.0;
    };
    let cotangent = light_travel.with_y(0.0).length() / light_travel.y.abs();
    let texels = CASTER_TEXELS + CASTER_TEXELS_PER_COTANGENT * cotangent;
    // A sun on the horizon has an infinite cotangent.
    texels.min(MOST_CASTER_TEXELS) * f64::from(scale)
}

/// [`LightView::caster_depth_bias`] of a fit.
pub(super) fn caster_depth_bias(fit: &LightFit, bias: ShadowBias, light_travel: DVec3) -> f64 {
    caster_texels(bias, light_travel) * fit.relative_texel_size * fit.depth_per_metre
}

/// Fits a light view with room for Bevy's filter and normal bias; `view_far` is where the whole view ends. Slices are fitted
/// for their largest error; a single map, whose near end has most of the pixels, is not.
pub(super) fn fit(input: &FitInput, settings: &SunShadows, view_far: f64) -> Option<LightFit> {
    let (_, normal_bias) = biases(settings.bias);
    let room = LookupRoom {
        filter_texels: GUARD_TEXELS,
        normal_texels: f64::from(normal_bias) * std::f64::consts::SQRT_2,
    };
    if settings.partitions.count > 1 {
        fit_slice_with_room(input, &room, view_far).fitted()
    } else {
        fit_with_room(input, &room).fitted()
    }
}

/// A light view as one of Bevy's cascades.
pub fn cascade(light_view: &LightView) -> Cascade {
    Cascade {
        world_from_cascade: light_view.world_from_light,
        clip_from_cascade: light_view.clip_from_light,
        clip_from_world: light_view.clip_from_world,
        texel_size: light_view.near_texel_size,
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
    let known = views.cameras.values().next();
    let count = known.map_or(settings.partitions.count as usize, |views| views.partitions.len());
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
