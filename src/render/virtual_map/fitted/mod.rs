//! Fitted maps: the picture says what it needs before anything is drawn (Giegl, chapter 5;
//! [`maths::virtual_map::fitted`](crate::maths::virtual_map::fitted)).
//!
//! ```text
//! depth prepass ──► measure    one compute pass: needs of all pixels by atomics into a grid over the map
//!                              (or a mapping map of one pixel in many, the thesis's way)
//!               ──► read_back  the grid: in the same frame (waits), or in the next one (does not)
//!               ──► plan       pyramid and traversal on the CPU ──► FittedFrame: tiles, their sizes and rectangles
//!               ──► TileFrame  draws and applies them
//! ```

pub mod cells;
pub mod measure;
pub mod overlay;
pub mod parameters;
pub mod pipeline;
pub mod plan;
pub use std::time::Instant;

use bevy::{
    math::Vec4Swizzles,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        camera::TemporalJitter,
        render_resource::CommandEncoderDescriptor,
        renderer::{PendingCommandBuffers, RenderDevice},
        view::ExtractedView,
    },
};

use self::{
    measure::NeedBuffers,
    parameters::PictureCamera,
    plan::{FittedFrame, FittedRequest},
};
use super::{TileFrame, tiles::margin};
use crate::{
    render::{
        atlas::prepare_atlas,
        caster::prepare::prepare_caster_views,
        extract::ExtractedSun,
        read_back::{ReadBack, submit_now},
    },
    shadow::{
        fitted::{FittedMaps, NeedFeedback},
        views::LightView,
        virtual_maps::ShadowMaps,
    },
};

/// What fitted maps need besides the tiles' own passes.
pub struct FittedPlugin;

impl Plugin for FittedPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(overlay::NeedOverlayPlugin);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .add_systems(RenderStartup, pipeline::init_need_pipelines)
            .add_systems(
                Render,
                (
                    take_earlier_light_view
                        .in_set(RenderSystems::PrepareViews)
                        .before(prepare_atlas)
                        .before(prepare_caster_views),
                    drop_fitted_maps.in_set(RenderSystems::PrepareResources),
                ),
            );
    }
}

/// On a camera's render entity: what comes back from the GPU.
#[derive(Component, Default)]
pub(super) struct FittedState {
    read_back: Option<ReadBack>,
    /// What the contents of `read_back` were measured for, if this frame uses them.
    earlier: Option<FittedRequest>,
    /// The light view of this frame, where the tiles are cut from an earlier one.
    own_light_view: Option<LightView>,
}

/// Where the tiles will come from the needs of the frame before, the whole frame takes the light view of that frame.
fn take_earlier_light_view(
    mut cameras: Query<(
        &mut ExtractedSun,
        &ExtractedView,
        Option<&TemporalJitter>,
        &mut FittedState,
    )>,
) {
    for (mut sun, view, jitter, mut state) in &mut cameras {
        let earlier = state.earlier.take();
        state.own_light_view = None;
        let (Some(earlier), Some(light_view)) = (earlier, sun.light_views.first()) else {
            continue;
        };
        let ShadowMaps::Fitted(settings) = &sun.settings.maps else {
            continue;
        };
        // Margins may follow the light view, so the earlier map says how large tiles are.
        let now = FittedRequest {
            settings: settings.clone(),
            map: earlier.map,
            light_view: light_view.clone(),
            shadow_distance: sun.shadow_distance,
            camera: picture_camera(view, jitter),
        };
        if now.is_served_by(&earlier) {
            sun.light_views[0] = earlier.light_view.clone();
            state.own_light_view = Some(now.light_view);
            state.earlier = Some(earlier);
        }
    }
}

/// Drops what cameras without a fitted map no longer need.
fn drop_fitted_maps(mut commands: Commands, cameras: Query<(Entity, Option<&ExtractedSun>), With<FittedState>>) {
    for (camera, sun) in &cameras {
        if !sun.is_some_and(|sun| matches!(sun.settings.maps, ShadowMaps::Fitted(_))) {
            commands
                .entity(camera)
                .remove::<(FittedFrame, FittedState, NeedBuffers)>();
        }
    }
}

fn picture_camera(view: &ExtractedView, jitter: Option<&TemporalJitter>) -> PictureCamera {
    let mut clip_from_view = view.clip_from_view;
    if let Some(jitter) = jitter {
        jitter.jitter_projection(&mut clip_from_view, view.viewport.zw().as_vec2());
    }
    PictureCamera {
        world_from_view: view.world_from_view.to_matrix().as_dmat4(),
        clip_from_view: clip_from_view.as_dmat4(),
        size: view.viewport.zw(),
        origin: view.viewport.xy(),
    }
}

/// Draws a fitted map.
pub(super) fn draw(frame: &mut TileFrame, settings: &FittedMaps) {
    let camera = frame.camera;
    let mut state = frame.world.entity_mut(camera).take::<FittedState>().unwrap_or_default();
    let planned = request(frame, settings, &mut state).and_then(|request| planned(frame, request, &mut state));
    frame.world.entity_mut(camera).insert(state);
    let Some(planned) = planned else {
        frame.world.entity_mut(camera).remove::<FittedFrame>();
        return;
    };
    frame.prepare_textures(&planned.texture_sizes());
    frame.draw(&planned.tile_draws());
    frame.report.buffer_bytes = planned.counts.buffer_bytes;
    frame.report.fitted = Some(planned.counts);
    frame.world.entity_mut(camera).insert(planned);
}

/// What the camera's sun asks for. `None` when there is nothing to look at, or not even the smallest tile fits the memory.
fn request(frame: &TileFrame, settings: &FittedMaps, state: &mut FittedState) -> Option<FittedRequest> {
    let view = frame.world.get::<ExtractedView>(frame.camera)?;
    let camera = picture_camera(view, frame.world.get::<TemporalJitter>(frame.camera));
    let own = state.own_light_view.take();
    let light_view = own.or_else(|| frame.sun.light_views.first().cloned())?;
    let margin = margin(
        frame.sun.settings.filter,
        &light_view.clip_from_world.as_dmat4(),
        f64::from(settings.texels_per_axis()),
        settings.tile_size_max,
    );
    let map = settings.map(margin, frame.texture_budget())?;
    (camera.size.min_element() > 0).then(|| FittedRequest {
        settings: settings.clone(),
        map,
        light_view,
        shadow_distance: frame.sun.shadow_distance,
        camera,
    })
}

/// Measures, and plans from this measurement or the earlier one.
fn planned(frame: &mut TileFrame, request: FittedRequest, state: &mut FittedState) -> Option<FittedFrame> {
    let (world, camera) = (&mut *frame.world, frame.camera);
    let device = world.resource::<RenderDevice>().clone();
    let measurement = request.measurement();
    let sizes = measurement.sizes();
    let started = Instant::now();
    // The frame before was submitted at its end: this waits only if the GPU is not through with it.
    let earlier = state
        .earlier
        .take()
        .and_then(|earlier| Some((earlier, state.read_back.as_ref()?.read(&device)?)));
    let waited = started.elapsed();
    let known = world
        .get::<NeedBuffers>(camera)
        .filter(|buffers| buffers.is_for(&sizes));
    let buffers = known.cloned().unwrap_or_else(|| NeedBuffers::new(&device, &sizes));
    world.entity_mut(camera).insert(buffers.clone());
    if !state.read_back.as_ref().is_some_and(|memory| memory.is_for(&sizes)) {
        state.read_back = Some(ReadBack::new(&device, &sizes));
    }
    let memory = state.read_back.as_ref()?;
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor {
        label: Some("umbrage_fitted"),
    });
    if !measure::record(
        world,
        camera,
        &measurement,
        &request.parameters(),
        &buffers,
        &mut encoder,
    ) {
        return None;
    }
    memory.copy(&mut encoder, &buffers.outputs);
    let is_next = matches!(request.settings.feedback, NeedFeedback::NextFrame { .. });
    let mut planned = if let Some((earlier, contents)) = earlier {
        world.resource_mut::<PendingCommandBuffers>().push([encoder.finish()]);
        earlier.plan(&contents, waited)
    } else {
        let started = Instant::now();
        submit_now(world, encoder);
        frame.report.read_backs += 1;
        let contents = memory.read(&device)?;
        request.plan(&contents, waited + started.elapsed())
    }?;
    state.earlier = is_next.then_some(request);
    planned.counts.buffer_bytes = buffers.bytes() + memory.bytes();
    Some(planned)
}
