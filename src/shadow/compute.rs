//! One camera, one sun, one scene → light views: [`compute_camera_views`], the pure heart of the room.

use bevy::math::{DVec3, Mat4, UVec2, UVec4, Vec3, Vec4Swizzles};

use super::{
    drop_in, full,
    layout::{AtlasLayout, cells_per_side},
    measured::DepthPlan,
    parts::{Cutter, Part},
    scene_bounds::SceneBounds,
    settings::{MapResolution, ShadowPath, SunShadows},
    stable::{HeldMap, Stability, stable_fit},
    views::{CameraSunViews, LightView, PartitionView},
};
use crate::maths::{
    body::{adjusted_depths, light_visible},
    bounds::Bounds,
    drop_in::slice_depths,
    error::{LargestErrors, LightSample, largest_errors},
    fit::{FitInput, LightFit, fit_light_view},
    split::{PseudoPlanes, SplitScheme, pseudo_split_depths},
    view::ViewVolume,
};

/// Texels that the full path leaves free at the border of a map: filters read one texel beyond a point or a tap. Filters
/// with a size in the world get their radius on top ([`world_radius`](super::settings::ShadowFilter::world_radius)).
pub(super) const GUARD_TEXELS: f64 = 2.0;

/// View depths between which a camera sees receivers (Stingl, section 3.3.1). `None` when there is nothing to shadow:
/// no receiver in view, or no caster in the scene.
pub fn visible_depths(view: &ViewVolume, scene: &SceneBounds) -> Option<(f64, f64)> {
    scene.casters?;
    adjusted_depths(&light_visible(view, &scene.receivers?), view)
}

/// The range of view depths that is split: what a cut leaves of `visible`, the depths between which the camera sees
/// receivers; for bounding spheres all of the view's own depths, which do not change with what is seen.
pub fn split_range(view: &ViewVolume, settings: &SunShadows, plan: &DepthPlan, visible: (f64, f64)) -> (f64, f64) {
    if settings.stable == Stability::Sphere && view.far().is_finite() {
        return (view.near(), view.far());
    }
    let (near, far) = visible;
    let cut = plan.cut_view(view);
    let (cut_near, cut_far) = (near.max(cut.near()), far.min(cut.far()));
    if cut_near < cut_far {
        (cut_near, cut_far)
    } else {
        visible
    }
}

/// Split distances for a range of view depth, evaluated between two measured planes of it if some are given, else between
/// the pseudo planes of the settings. Orthographic cameras see everything at one scale: they split uniformly, unless the
/// distances are set by hand. On the drop-in path several logarithmic splits have a pseudo-near plane
/// ([`maths::drop_in`](crate::maths::drop_in)).
pub fn partition_depths(
    settings: &SunShadows,
    orthographic: bool,
    (near, far): (f64, f64),
    measured: Option<PseudoPlanes>,
) -> Vec<f64> {
    let scheme = match &settings.partitions.scheme {
        manual @ SplitScheme::Manual(_) => manual,
        _ if orthographic => &SplitScheme::Uniform,
        scheme => scheme,
    };
    let planes = measured.unwrap_or_else(|| settings.fit.pseudo_planes());
    let count = settings.partitions.count as usize;
    if settings.path == ShadowPath::DropIn && count > 1 && !orthographic {
        return slice_depths(scheme, near, far, planes, count);
    }
    pseudo_split_depths(scheme, near, far, planes, count)
}

/// What the frame before leaves to a camera's light views.
pub struct Memory<'a> {
    /// Its light views: some choices keep to them so that nothing flickers.
    pub previous: Option<&'a CameraSunViews>,
    /// What its maps hold, by slot; brought up to date.
    pub held: &'a mut Vec<Option<HeldMap>>,
}

/// The light views of one camera: H and adjusted depths of the whole view, then per part H, B, warp and focus.
///
/// `view` is the part of the view volume that gets shadows, `light_travel` the direction in which light travels,
/// `settings` must be in range (see [`checked`](super::checked::checked)), and `depths` are the split distances, usually
/// from [`partition_depths`]. `plan` says what is known of the depths in the picture, `memory` what the frame before leaves.
/// `None` when there is nothing to shadow: everything is lit.
pub fn compute_camera_views(
    view: &ViewVolume,
    scene: &SceneBounds,
    light_travel: DVec3,
    settings: &SunShadows,
    depths: &[f64],
    plan: &DepthPlan,
    memory: Memory,
) -> Option<CameraSunViews> {
    let (near, far) = visible_depths(view, scene)?;
    let Memory { previous, held } = memory;
    let cut_view = plan.cut_view(view);
    let cutter = Cutter {
        view: &cut_view,
        plan,
        receivers: scene.receivers?,
        scene: scene.scene?,
        light_travel,
        settings,
        depths,
    };
    let fitter = Fitter {
        scene: scene.scene?,
        light_travel,
        settings,
        far,
    };
    let whole = cutter.whole(near, far);
    let square = UVec2::splat(settings.map_size);
    let master = fitter.fit(&whole, square)?;
    let (parts, face_set) = cutter.parts(previous.and_then(|previous| previous.face_set));
    let layout = fitter.layout(&parts, previous.map(|previous| &previous.layout));
    held.resize(settings.partitions.maps() as usize, None);
    let partitions = (parts.into_iter().zip(&layout.rects))
        .map(|(part, rect)| {
            let mut nothing = None;
            let held = held.get_mut(part.slot as usize).unwrap_or(&mut nothing);
            fitter.partition(part, *rect, held)
        })
        .collect();
    Some(CameraSunViews {
        near_depth: near as f32,
        far_depth: far as f32,
        end_depth: view.far() as f32,
        partitions,
        master: light_view(&master, &whole, UVec4::new(0, 0, square.x, square.y)),
        layout,
        face_set,
    })
}

/// Fits the light views of one sun.
pub(super) struct Fitter<'a> {
    /// Bounds of the scene.
    pub(super) scene: Bounds,
    /// Direction in which light travels.
    pub(super) light_travel: DVec3,
    /// Settings in range.
    pub(super) settings: &'a SunShadows,
    /// View depth where what is seen ends, in metres.
    pub(super) far: f64,
}

impl Fitter<'_> {
    /// A part and its light view, with a map in a rectangle of the atlas.
    pub(super) fn partition(&self, part: Part, rect: UVec4, held: &mut Option<HeldMap>) -> PartitionView {
        let slice = &part.slice;
        let size = match self.settings.maps.texels_per_axis() {
            Some(texels) => UVec2::splat(texels),
            None => rect.zw(),
        };
        let light_view = match self.stable_fit(&part, size, held) {
            Some(fit) => LightView {
                caster_depth_bias: self.caster_depth_bias(&fit),
                ..light_view(&fit, &part, rect)
            },
            None => empty_light_view(&part, rect),
        };
        PartitionView {
            split_frustum: slice.corners(slice.near(), slice.far()).map(|corner| corner.as_vec3()),
            visible: part.visible,
            body: part.body,
            light_view,
        }
    }

    /// [`LightView::caster_depth_bias`] of a fit, on the path of the settings.
    pub(super) fn caster_depth_bias(&self, fit: &LightFit) -> f32 {
        match self.settings.path {
            ShadowPath::Full => 0.0,
            ShadowPath::DropIn => drop_in::caster_depth_bias(fit, self.settings.bias, self.light_travel) as f32,
        }
    }

    /// The fresh fit of a part, which is missing when the part sees nothing.
    pub(super) fn fit(&self, part: &Part, map_size: UVec2) -> Option<LightFit> {
        let input = self.input(part, map_size);
        match self.settings.path {
            ShadowPath::Full => fit_light_view(&input).fitted(),
            ShadowPath::DropIn => drop_in::fit(&input, self.settings, self.far),
        }
    }

    /// The fit of a part that keeps to the frame before as the settings say.
    fn stable_fit(&self, part: &Part, map_size: UVec2, held: &mut Option<HeldMap>) -> Option<LightFit> {
        match self.settings.path {
            ShadowPath::Full => stable_fit(&self.input(part, map_size), self.settings.stable, &self.scene, held),
            ShadowPath::DropIn => self.fit(part, map_size),
        }
    }

    fn input<'a>(&self, part: &'a Part, map_size: UVec2) -> FitInput<'a> {
        FitInput {
            view: &part.slice,
            visible: &part.visible,
            body: &part.body,
            light_travel: self.light_travel,
            warp: part.warp,
            map_size,
            guard_texels: GUARD_TEXELS,
            guard_metres: f64::from(self.settings.filter.world_radius()),
            options: part.options,
        }
    }

    /// Where the maps lie. Those of the drop-in path are layers of Bevy's own texture: each is alone.
    fn layout(&self, parts: &[Part], previous: Option<&AtlasLayout>) -> AtlasLayout {
        let size = self.settings.map_size;
        let most = self.settings.partitions.maps();
        let slots: Vec<u32> = parts.iter().map(|part| part.slot).collect();
        let in_use = || slots.iter().copied();
        if self.settings.maps.is_virtual() {
            // Tiles have textures of their own.
            return AtlasLayout::equal(1, 1, in_use().map(|_| 0));
        }
        match (self.settings.path, self.settings.partitions.resolution) {
            (ShadowPath::DropIn, _) => AtlasLayout::equal(size, 1, in_use().map(|_| 0)),
            (ShadowPath::Full, MapResolution::Equal) => AtlasLayout::equal(size, most, in_use()),
            (ShadowPath::Full, MapResolution::Balanced) => {
                let square = UVec2::splat(size);
                let mut needs = vec![LargestErrors::NONE; most as usize];
                for part in parts {
                    needs[part.slot as usize] = self.needs(part, square);
                }
                AtlasLayout::balanced(needs, &slots, size * cells_per_side(most), previous)
                    .unwrap_or_else(|| AtlasLayout::equal(size, most, in_use()))
            }
        }
    }

    /// The largest errors of a part's map (Lloyd, section 4.4): relative to pixels of one camera, whose opening is left out.
    /// Zero where there is nothing to see. What lies before the pseudo-near plane counts as if it were as far as this plane.
    fn needs(&self, part: &Part, map_size: UVec2) -> LargestErrors {
        let Some(fit) = self.fit(part, map_size) else {
            return LargestErrors::NONE;
        };
        let light_from_world = fit.world_from_light.inverse();
        let nearest = part.depths[0].max(part.options.pseudo_near.unwrap_or(0.0));
        let sample = |vertex: &DVec3| {
            let point = light_from_world.transform_point3(*vertex);
            LightSample {
                across: point.x,
                along: point.y,
                depth: if part.slice.is_orthographic() {
                    1.0
                } else {
                    part.slice.depth(*vertex).max(nearest)
                },
            }
        };
        let samples: Vec<LightSample> = part.visible.vertices().iter().map(sample).collect();
        largest_errors(&samples, fit.warp_near, 1.0)
    }
}

pub(super) fn light_view(fit: &LightFit, part: &Part, atlas_rect: UVec4) -> LightView {
    LightView {
        clip_from_world: fit.clip_from_world_f32(),
        world_from_light: fit.world_from_light_f32(),
        clip_from_light: fit.clip_from_light_f32(),
        texel_size: fit.texel_size as f32,
        near_texel_size: fit.near_texel_size as f32,
        caster_depth_bias: 0.0,
        near_depth: part.depths[0] as f32,
        far_depth: part.depths[1] as f32,
        seam_depth: part.seam as f32,
        stands_in: false,
        atlas_rect,
    }
}

/// A light view that contains nothing of the world, so that everything that would read it is lit.
fn empty_light_view(part: &Part, atlas_rect: UVec4) -> LightView {
    let nowhere = full::mask_cascade();
    LightView {
        clip_from_world: nowhere.clip_from_world,
        world_from_light: nowhere.world_from_cascade,
        clip_from_light: nowhere.clip_from_cascade,
        texel_size: nowhere.texel_size,
        near_texel_size: nowhere.texel_size,
        caster_depth_bias: 0.0,
        near_depth: part.depths[0] as f32,
        far_depth: part.depths[1] as f32,
        seam_depth: 0.0,
        stands_in: false,
        atlas_rect,
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
