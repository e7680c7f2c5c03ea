//! One camera, one sun, what was seen → films → light views: [`compute_light_plane_views`].

use bevy::math::{DMat4, DVec3, UVec2, UVec4, Vec4Swizzles};

use super::{FilmReport, LightPlaneState, LightPlanes, NoFilms, layout::FilmLayout};
use crate::{
    maths::{
        fit::LightFit,
        light_plane::space::{
            FilmDivision, FilmError, FilmFitInput, FilmFrustum, FilmPlan, FilmPlanInput, SeenPicture, fit_film,
            plan_films,
        },
        view::ViewVolume,
        warp::Warp,
    },
    shadow::{
        compute::{Fitter, GUARD_TEXELS, Memory, compute_camera_views, light_view, split_range, visible_depths},
        drop_in,
        measured::DepthPlan,
        parts::{Cutter, Part},
        scene_bounds::SceneBounds,
        settings::{Partitions, ShadowPath, SunShadows},
        stable::HeldMap,
        views::{CameraSunViews, LightView, PartitionView},
    },
};

/// What [`compute_light_plane_views`] works from.
#[derive(Clone, Copy, Debug)]
pub struct LightPlaneInput<'a> {
    /// The part of the view volume that gets shadows.
    pub view: &'a ViewVolume,
    /// Receivers and casters.
    pub scene: &'a SceneBounds,
    /// Direction in which light travels.
    pub light_travel: DVec3,
    /// The settings of the sun, in range.
    pub settings: &'a SunShadows,
    /// Those of its light planes, in range.
    pub planes: &'a LightPlanes,
    /// What is known of the depths in the picture.
    pub plan: &'a DepthPlan,
    /// What the camera saw last.
    pub seen: Option<&'a SeenPicture>,
    /// The camera's matrix now.
    pub clip_from_world: DMat4,
    /// Seconds since the last time.
    pub seconds: f64,
}

/// The light views of one camera from films; from one uniform map where there are none. `None` when there is nothing to
/// shadow: everything is lit.
///
/// Of `memory` only the maps held are used: the uniform map has the first of them, the coarse map around films the second.
pub fn compute_light_plane_views(
    input: &LightPlaneInput,
    memory: Memory,
    state: &mut LightPlaneState,
) -> Option<CameraSunViews> {
    let (near, far) = visible_depths(input.view, input.scene)?;
    let settings = input.settings;
    let cut_view = input.plan.cut_view(input.view);
    let cutter = Cutter {
        view: &cut_view,
        plan: input.plan,
        receivers: input.scene.receivers?,
        scene: input.scene.scene?,
        light_travel: input.light_travel,
        settings,
        depths: &[],
    };
    let whole = cutter.whole(near, far);
    let fitter = Fitter {
        scene: input.scene.scene?,
        light_travel: input.light_travel,
        settings,
        far,
    };
    let films = Films { input, fitter, whole };
    let held = memory.held;
    let mut coarse = held.get(1).copied().flatten();
    let planned = films.plan(state).and_then(|plan| {
        let layout = FilmLayout::new(settings, input.planes, &plan.partition, state.layout.as_ref());
        Ok((films.partitions(&plan, &layout.atlas.rects, &mut coarse)?, layout, plan))
    });
    match planned {
        Ok((partitions, layout, plan)) => {
            let sizes = layout
                .atlas
                .rects
                .iter()
                .map(|rect| f64::from(rect.z) * f64::from(rect.w));
            let texels: Vec<f64> = sizes.take(plan.partition.frusta.len()).collect();
            *held = vec![None, coarse];
            let square = UVec4::new(0, 0, settings.map_size, settings.map_size);
            *state = LightPlaneState {
                unbent: films.light_view(&plan, &plan.unbent, square).ok(),
                films: Some(Ok(FilmReport {
                    count: texels.len(),
                    mean_error: plan.partition.mean_error_of(&texels),
                    gain: plan.gain,
                    damping_cost: plan.damping_cost,
                })),
                memory: plan.memory,
                layout: layout.films,
            };
            let master = films.fitter.fit(&films.whole, square.zw())?;
            Some(CameraSunViews {
                near_depth: near as f32,
                far_depth: far as f32,
                end_depth: input.view.far() as f32,
                partitions,
                master: light_view(&master, &films.whole, square),
                layout: layout.atlas,
                face_set: None,
            })
        }
        Err(reason) => {
            *state = LightPlaneState {
                films: Some(Err(reason)),
                ..LightPlaneState::default()
            };
            let uniform = SunShadows {
                partitions: Partitions::slices(1),
                warp: Warp::Uniform,
                light_planes: None,
                ..settings.clone()
            };
            let (start, end) = split_range(input.view, &uniform, input.plan, (near, far));
            compute_camera_views(
                input.view,
                input.scene,
                input.light_travel,
                &uniform,
                &[start, end],
                input.plan,
                Memory { previous: None, held },
            )
        }
    }
}

struct Films<'a> {
    input: &'a LightPlaneInput<'a>,
    fitter: Fitter<'a>,
    /// All that the camera may see.
    whole: Part,
}

impl Films<'_> {
    fn plan(&self, state: &LightPlaneState) -> Result<FilmPlan, NoFilms> {
        let input = self.input;
        if input.view.is_orthographic() {
            return Err(NoFilms::Orthographic);
        }
        let picture = input.seen.ok_or(NoFilms::NoPicture)?;
        let receivers = input.scene.receivers.ok_or(FilmError::NothingVisible)?;
        let plan = plan_films(&FilmPlanInput {
            view: &self.whole.slice,
            receivers: &receivers,
            light_travel: input.light_travel,
            picture,
            clip_from_world: input.clip_from_world,
            margin: f64::from(input.settings.filter.world_radius()),
            options: &input.planes.plan_options(),
            last: &state.memory,
            seconds: input.seconds,
        })?;
        Ok(plan)
    }

    /// The films in their order, and a coarse map over everything where they cover only what was seen.
    /// The latter stands still as the settings say.
    fn partitions(
        &self,
        plan: &FilmPlan,
        rects: &[UVec4],
        coarse: &mut Option<HeldMap>,
    ) -> Result<Vec<PartitionView>, NoFilms> {
        let films = plan.partition.frusta.iter().zip(rects);
        let mut partitions = films
            .map(|(frustum, rect)| self.partition(plan, frustum, *rect))
            .collect::<Result<Vec<_>, _>>()?;
        if let Some(rest) = rects.get(partitions.len()) {
            let part = Part {
                warp: Warp::Lispsm,
                ..self.whole.clone()
            };
            let mut partition = self.fitter.partition(part, *rest, coarse);
            partition.light_view.stands_in = true;
            partitions.push(partition);
        }
        Ok(partitions)
    }

    fn partition(&self, plan: &FilmPlan, frustum: &FilmFrustum, rect: UVec4) -> Result<PartitionView, NoFilms> {
        let [near, far] = self.depths(frustum);
        let corners = self.whole.slice.corners(near, far);
        Ok(PartitionView {
            split_frustum: corners.map(|corner| corner.as_vec3()),
            visible: self.whole.visible.clone(),
            body: self.whole.body.clone(),
            light_view: self.light_view(plan, frustum, rect)?,
        })
    }

    /// View depths that a film is meant for.
    fn depths(&self, frustum: &FilmFrustum) -> [f64; 2] {
        let whole = self.whole.depths;
        match self.input.planes.division {
            FilmDivision::Depth => [frustum.depths[0].max(whole[0]), frustum.depths[1].min(whole[1])],
            FilmDivision::Tiles => whole,
        }
    }

    fn light_view(&self, plan: &FilmPlan, frustum: &FilmFrustum, rect: UVec4) -> Result<LightView, NoFilms> {
        let fit = self.fit(plan, frustum, rect.zw())?;
        let [near, far] = self.depths(frustum);
        Ok(LightView {
            caster_depth_bias: self.fitter.caster_depth_bias(&fit),
            near_depth: near as f32,
            far_depth: far as f32,
            ..light_view(&fit, &self.whole, rect)
        })
    }

    /// The matrices of a film: with the casters of all that the camera may see.
    fn fit(&self, plan: &FilmPlan, frustum: &FilmFrustum, map_size: UVec2) -> Result<LightFit, FilmError> {
        fit_film(&FilmFitInput {
            view: &self.whole.slice,
            visible: &self.whole.visible,
            body: &self.whole.body,
            base: &plan.base,
            film: &frustum.film,
            hull: &frustum.hull,
            map_size,
            guard_texels: match self.input.settings.path {
                ShadowPath::Full => GUARD_TEXELS,
                ShadowPath::DropIn => drop_in::GUARD_TEXELS,
            },
        })
    }
}
