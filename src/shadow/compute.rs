//! One camera, one sun, one scene → light views: [`compute_camera_views`], the pure heart of the room.

use bevy::math::{DVec3, Mat4, Vec3};

use super::{
    drop_in, full,
    scene_bounds::SceneBounds,
    settings::{ShadowPath, SunShadows},
    views::{CameraSunViews, LightView, PartitionView},
};
use crate::maths::{
    body::{adjusted_depths, intersection_body, light_visible},
    bounds::Bounds,
    fit::{FitInput, FitOptions, LightFit, fit_light_view},
    polytope::Polytope,
    split::{SplitScheme, split_depths},
    view::ViewVolume,
    warp::Warp,
};

/// Texels that the full path leaves free at the border of a map: filters read one texel beyond a point or a tap. Filters
/// with a size in the world get their radius on top ([`world_radius`](super::settings::ShadowFilter::world_radius)).
const GUARD_TEXELS: f64 = 2.0;

/// View depths between which a camera sees receivers (Stingl, section 3.3.1). `None` when there is nothing to shadow:
/// no receiver in view, or no caster in the scene.
pub fn visible_depths(view: &ViewVolume, scene: &SceneBounds) -> Option<(f64, f64)> {
    scene.casters?;
    adjusted_depths(&light_visible(view, &scene.receivers?), view)
}

/// Split distances for a range of view depth. Orthographic cameras see everything at one scale: they split uniformly,
/// unless the distances are set by hand.
pub fn partition_depths(settings: &SunShadows, orthographic: bool, (near, far): (f64, f64)) -> Vec<f64> {
    let scheme = match &settings.partitions.scheme {
        manual @ SplitScheme::Manual(_) => manual,
        _ if orthographic => &SplitScheme::Uniform,
        scheme => scheme,
    };
    split_depths(scheme, near, far, settings.partitions.count as usize)
}

/// The light views of one camera: H and adjusted depths of the whole view, then per slice H, B, warp and focus.
///
/// `view` is the part of the view volume that gets shadows, `light_travel` the direction in which light travels,
/// `settings` must be in range (see [`checked`](super::checked::checked)), and `depths` are the split distances, usually
/// from [`partition_depths`]. `None` when there is nothing to shadow: everything is lit.
pub fn compute_camera_views(
    view: &ViewVolume,
    scene: &SceneBounds,
    light_travel: DVec3,
    settings: &SunShadows,
    depths: &[f64],
) -> Option<CameraSunViews> {
    let (near, far) = visible_depths(view, scene)?;
    let fitter = Fitter {
        receivers: scene.receivers?,
        scene: scene.scene?,
        light_travel,
        settings,
    };
    let whole = view.split(near, far);
    let (_, master) = fitter.fit(&whole, Warp::Uniform);
    Some(CameraSunViews {
        near_depth: near as f32,
        far_depth: far as f32,
        partitions: depths
            .windows(2)
            .map(|range| fitter.partition(&view.split(range[0], range[1])))
            .collect(),
        master: light_view(&master?, &whole),
    })
}

struct Fitter<'a> {
    receivers: Bounds,
    scene: Bounds,
    light_travel: DVec3,
    settings: &'a SunShadows,
}

impl Fitter<'_> {
    fn partition(&self, slice: &ViewVolume) -> PartitionView {
        let (body, fit) = self.fit(slice, self.settings.warp);
        PartitionView {
            split_frustum: slice.corners(slice.near(), slice.far()).map(|corner| corner.as_vec3()),
            body,
            light_view: match fit {
                Some(fit) => LightView {
                    caster_depth_bias: self.caster_depth_bias(&fit),
                    ..light_view(&fit, slice)
                },
                None => empty_light_view(slice),
            },
        }
    }

    fn caster_depth_bias(&self, fit: &LightFit) -> f32 {
        match self.settings.path {
            ShadowPath::Full => 0.0,
            ShadowPath::DropIn => drop_in::caster_depth_bias(fit, self.settings.bias, self.light_travel) as f32,
        }
    }

    /// B of a slice and its light view, which is missing when the slice sees nothing.
    fn fit(&self, slice: &ViewVolume, warp: Warp) -> (Polytope, Option<LightFit>) {
        let visible = light_visible(slice, &self.receivers);
        let body = intersection_body(&visible, &self.scene, self.light_travel);
        let input = FitInput {
            view: slice,
            visible: &visible,
            body: &body,
            light_travel: self.light_travel,
            warp,
            map_size: self.settings.map_size,
            guard_texels: GUARD_TEXELS,
            guard_metres: f64::from(self.settings.filter.world_radius()),
            options: FitOptions::default(),
        };
        let fit = match self.settings.path {
            ShadowPath::Full => fit_light_view(&input).fitted(),
            ShadowPath::DropIn => drop_in::fit(input, self.settings.bias),
        };
        (body, fit)
    }
}

fn light_view(fit: &LightFit, slice: &ViewVolume) -> LightView {
    LightView {
        clip_from_world: fit.clip_from_world_f32(),
        world_from_light: fit.world_from_light_f32(),
        clip_from_light: fit.clip_from_light_f32(),
        texel_size: fit.texel_size as f32,
        near_texel_size: fit.near_texel_size as f32,
        caster_depth_bias: 0.0,
        near_depth: slice.near() as f32,
        far_depth: slice.far() as f32,
    }
}

/// A light view that contains nothing of the world, so that everything that would read it is lit.
fn empty_light_view(slice: &ViewVolume) -> LightView {
    let nowhere = full::mask_cascade();
    LightView {
        clip_from_world: nowhere.clip_from_world,
        world_from_light: nowhere.world_from_cascade,
        clip_from_light: nowhere.clip_from_cascade,
        texel_size: nowhere.texel_size,
        near_texel_size: nowhere.texel_size,
        caster_depth_bias: 0.0,
        near_depth: slice.near() as f32,
        far_depth: slice.far() as f32,
    }
}

/// The corners of a light view's clip box in the world, indexed by the bits x, y, z.
pub fn light_view_corners(light_view: &LightView) -> [Vec3; 8] {
    let world_from_clip: Mat4 = light_view.clip_from_world.as_dmat4().inverse().as_mat4();
    std::array::from_fn(|index| {
        let bit = |position: usize| (index >> position & 1) as f32;
        world_from_clip.project_point3(Vec3::new(bit(0) * 2.0 - 1.0, bit(1) * 2.0 - 1.0, bit(2)))
    })
}
