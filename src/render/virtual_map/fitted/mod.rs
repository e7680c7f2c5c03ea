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
//!
//! With z-partitions all that happens once per partition, for the pixels of its interval of view depth; all partitions are
//! measured before the one read-back.

pub mod cells;
pub mod measure;
pub mod overlay;
pub mod parameters;
pub mod pipeline;
pub mod plan;

use std::time::{Duration, Instant};

use bevy::{
    log::warn_once,
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
    measure::{Measurement, NeedBuffers},
    parameters::PictureCamera,
    plan::{FittedFrame, FittedFrames, FittedRequest},
};
use super::{
    TileFrame,
    tiles::{TileDraw, margin},
};
use crate::{
    render::{
        atlas::prepare_atlas,
        caster::prepare::prepare_caster_views,
        extract::ExtractedSun,
        read_back::{ReadBack, submit_now},
        receivers::receivers,
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
                    take_earlier_light_views
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
    /// What the contents of `read_back` were measured for, by z-partition, if this frame uses them.
    earlier: Option<Vec<FittedRequest>>,
    /// The light views of this frame, where the tiles are cut from earlier ones.
    own_light_views: Option<Vec<LightView>>,
}

/// Where the tiles will come from the needs of the frame before, the whole frame takes the light views of that frame.
fn take_earlier_light_views(
    mut cameras: Query<(
        &mut ExtractedSun,
        &ExtractedView,
        Option<&TemporalJitter>,
        &mut FittedState,
    )>,
) {
    for (mut sun, view, jitter, mut state) in &mut cameras {
        state.own_light_views = None;
        let Some(earlier) = state.earlier.take() else {
            continue;
        };
        let ShadowMaps::Fitted(settings) = &sun.settings.maps else {
            continue;
        };
        let camera = picture_camera(view, jitter);
        let is_served = |(partition, earlier): (usize, &FittedRequest)| {
            let now = FittedRequest {
                settings: settings.clone(),
                light_view: sun.light_views[partition].clone(),
                camera,
                // Margins may follow the light view, so the earlier map says how large tiles are, and which pixels are its.
                ..earlier.clone()
            };
            now.is_served_by(earlier)
        };
        if earlier.len() == sun.light_views.len() && earlier.iter().enumerate().all(is_served) {
            let earlier_views = earlier.iter().map(|request| request.light_view.clone()).collect();
            state.own_light_views = Some(std::mem::replace(&mut sun.light_views, earlier_views));
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
                .remove::<(FittedFrames, FittedState, NeedBuffers)>();
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

/// Draws a fitted map, or one per z-partition.
pub(super) fn draw(frame: &mut TileFrame, settings: &FittedMaps) {
    let camera = frame.camera;
    let mut state = frame.world.entity_mut(camera).take::<FittedState>().unwrap_or_default();
    let planned = requests(frame, settings, &mut state).and_then(|requests| planned(frame, requests, &mut state));
    frame.world.entity_mut(camera).insert(state);
    let Some(planned) = planned else {
        frame.world.entity_mut(camera).remove::<FittedFrames>();
        return;
    };
    let tiles: Vec<TileDraw> = planned.0.iter().flat_map(FittedFrame::tile_draws).collect();
    let sizes: Vec<UVec2> = planned.0.iter().flat_map(FittedFrame::texture_sizes).collect();
    frame.prepare_textures(&sizes);
    frame.draw(&tiles);
    let counts = planned.counts();
    frame.report.buffer_bytes = counts.buffer_bytes;
    frame.report.fitted = Some(counts);
    frame.world.entity_mut(camera).insert(planned);
}

/// What the camera's sun asks for, by z-partition. `None` when there is nothing to look at, or not even the smallest tile
/// fits the memory.
fn requests(frame: &TileFrame, settings: &FittedMaps, state: &mut FittedState) -> Option<Vec<FittedRequest>> {
    let view = frame.world.get::<ExtractedView>(frame.camera)?;
    let camera = picture_camera(view, frame.world.get::<TemporalJitter>(frame.camera));
    if camera.size.min_element() == 0 {
        return None;
    }
    let own = state.own_light_views.take();
    let light_views = own.unwrap_or_else(|| frame.sun.light_views.clone());
    let ends: Vec<f32> = light_views.iter().map(|light_view| light_view.far_depth).collect();
    let depths = depth_intervals(&ends, frame.sun.shadow_distance);
    let has_more_pictures = receivers(frame.world, frame.camera).len() > 1;
    let largest_buffer = frame
        .world
        .resource::<RenderDevice>()
        .limits()
        .max_storage_buffer_binding_size;
    let request = |(partition, (light_view, depths)): (u32, (LightView, [f32; 2]))| {
        let margin = margin(
            frame.sun.settings.filter,
            &light_view.clip_from_world.as_dmat4(),
            f64::from(settings.texels_per_axis()),
            settings.tile_size_max,
        );
        // Where not even the smallest tile fits with its margins, filters are cut at its borders.
        let mut margins = std::iter::successors(Some(margin), |margin| (*margin > 0).then_some(margin / 2));
        let mut request = FittedRequest {
            settings: settings.clone(),
            map: margins.find_map(|margin| settings.map(margin, frame.texture_budget()))?,
            light_view,
            partition,
            depths,
            camera,
            has_more_pictures,
        };
        if request
            .measurement()
            .sizes()
            .iter()
            .any(|bytes| *bytes > largest_buffer)
        {
            warn_once!(
                "a fitted map of {} cells per axis has no room for histograms on this device: `discard` is ignored",
                request.map.grid_tiles_per_axis()
            );
            request.settings.discard = 0.0;
        }
        Some(request)
    };
    (0..).zip(light_views.into_iter().zip(depths)).map(request).collect()
}

/// The view depths in metres of the pixels that look into the map of each z-partition, from where the partitions end: as
/// `view_of_depth` in `selection.wgsl` decides, and a little more. The measurement is another shader, and may round a
/// pixel's depth to the other side.
fn depth_intervals(ends: &[f32], shadow_distance: f32) -> Vec<[f32; 2]> {
    let slack = |depth: f32| 1.0e-3 + 1.0e-5 * depth;
    let Some((_, inner)) = ends.split_last() else {
        return Vec::new();
    };
    let starts = std::iter::once(f32::MIN).chain(inner.iter().map(|end| end - slack(*end)));
    let ends = inner.iter().map(|end| (end + slack(*end)).min(shadow_distance));
    starts
        .zip(ends.chain([shadow_distance]))
        .map(|(start, end)| [start, end])
        .collect()
}

/// Measures, and plans from this measurement or the earlier one. All maps are measured and read back together.
fn planned(frame: &mut TileFrame, requests: Vec<FittedRequest>, state: &mut FittedState) -> Option<FittedFrames> {
    let (world, camera) = (&mut *frame.world, frame.camera);
    let device = world.resource::<RenderDevice>().clone();
    let measurements: Vec<_> = requests.iter().map(FittedRequest::measurement).collect();
    let sizes: Vec<Vec<u64>> = measurements.iter().map(Measurement::sizes).collect();
    let all_sizes = sizes.concat();
    let started = Instant::now();
    // The frame before was submitted at its end: this waits only if the GPU is not through with it.
    let earlier = state
        .earlier
        .take()
        .and_then(|earlier| Some((earlier, state.read_back.as_ref()?.read(&device)?)));
    let waited = started.elapsed();
    let known = world.entity_mut(camera).take::<NeedBuffers>();
    let buffers = known
        .filter(|buffers| buffers.is_for(&sizes))
        .unwrap_or_else(|| NeedBuffers::new(&device, &sizes));
    if !state.read_back.as_ref().is_some_and(|memory| memory.is_for(&all_sizes)) {
        state.read_back = Some(ReadBack::new(&device, &all_sizes));
    }
    let memory = state.read_back.as_ref()?;
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor {
        label: Some("umbrage_fitted"),
    });
    let pictures = receivers(world, camera);
    let depths: Vec<_> = pictures.iter().map(|receiver| receiver.depth).collect();
    let are_recorded = (requests.iter().zip(&measurements))
        .zip(&buffers.0)
        .all(|((request, measurement), buffers)| {
            measure::record(
                world,
                camera,
                &depths,
                measurement,
                &request.parameters(),
                buffers,
                &mut encoder,
            )
        });
    memory.copy(&mut encoder, &buffers.outputs());
    let buffer_bytes = buffers.bytes() + memory.bytes();
    world.entity_mut(camera).insert(buffers);
    if !are_recorded {
        return None;
    }
    let is_next = matches!(requests[0].settings.feedback, NeedFeedback::NextFrame { .. });
    let frames = if let Some((earlier, contents)) = earlier {
        world.resource_mut::<PendingCommandBuffers>().push([encoder.finish()]);
        plan_all(&earlier, contents, waited)
    } else {
        let started = Instant::now();
        submit_now(world, encoder);
        frame.report.read_backs += 1;
        let contents = memory.read(&device)?;
        plan_all(&requests, contents, waited + started.elapsed())
    };
    state.earlier = is_next.then_some(requests);
    let mut frames = FittedFrames(frames?);
    if let Some(first) = frames.0.first_mut() {
        first.counts.buffer_bytes = buffer_bytes;
    }
    Some(frames)
}

/// The frames for what was measured, which lies behind each other in the order of the requests.
fn plan_all(requests: &[FittedRequest], contents: Vec<Vec<u8>>, read_back: Duration) -> Option<Vec<FittedFrame>> {
    let mut contents = contents.into_iter();
    let plan = |request: &FittedRequest| {
        let own: Vec<_> = contents.by_ref().take(request.measurement().sizes().len()).collect();
        request.plan(&own, read_back)
    };
    requests.iter().map(plan).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn partitions_share_the_pixels_between_them() {
        let depths = depth_intervals(&[10.0, 40.0, 90.0], 80.0);
        let holds =
            |depth: f32| -> Vec<bool> { depths.iter().map(|[from, to]| (*from..*to).contains(&depth)).collect() };
        assert_eq!(holds(0.01), [true, false, false]);
        assert_eq!(holds(9.9), [true, false, false]);
        assert_eq!(holds(10.0), [true, true, false], "within rounding of both");
        assert_eq!(holds(79.9), [false, false, true]);
        assert_eq!(
            holds(80.0),
            [false, false, false],
            "everything is lit from the shadow distance on"
        );
        assert_eq!(depth_intervals(&[90.0], 7.0), [[f32::MIN, 7.0]], "one map has all");
    }
}
