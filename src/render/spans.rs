//! [`ShadowPassSpan`]: a time span around Bevy's own pass of directional shadow maps, which has none.
//!
//! Stock cascades, the drop-in path and the fallback map of the full path are drawn by that pass. With Bevy's
//! [`RenderDiagnosticsPlugin`](bevy::render::diagnostic::RenderDiagnosticsPlugin) their times appear as
//! `render/bevy_shadow_pass/elapsed_gpu` and `…/elapsed_cpu`.
//!
//! Two exclusive systems write the timestamps, because Bevy's recorder ends a span on the thread that began it, and
//! exclusive systems of a schedule run on one thread. Each hands in all commands recorded so far before its own, so that
//! the timestamps lie around the pass on the GPU too. That costs some parallel recording: the plugin is for measurements.
//!
//! # Limits
//! Bevy's second pass after occlusion culling, which only views with `OcclusionCulling` have, is not in the span; the deferred prepass of
//! deferred cameras can be.

use bevy::{
    core_pipeline::{
        mip_generation::experimental::depth::early_downsample_depth, prepass::node::early_prepass, schedule::Core3d,
    },
    ecs::schedule::ApplyDeferred,
    pbr::{EARLY_SHADOW_PASS, ViewLightEntities, early_prepass_build_indirect_parameters, per_view_shadow_pass},
    prelude::*,
    render::{
        RenderApp,
        diagnostic::{DiagnosticsRecorder, RecordDiagnostics},
        render_resource::{CommandEncoder, CommandEncoderDescriptor},
        renderer::{CurrentView, PendingCommandBuffers, RenderDevice},
    },
};

/// The name of the span.
pub const BEVY_SHADOW_PASS: &str = "bevy_shadow_pass";

/// Adds the span. Does nothing without `RenderDiagnosticsPlugin`.
pub struct ShadowPassSpan;

impl Plugin for ShadowPassSpan {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        let pass = per_view_shadow_pass::<EARLY_SHADOW_PASS>;
        render_app.add_systems(
            Core3d,
            (
                // Nothing but the pass is left between the two: the prepass is before, the pass's successors are after.
                (ApplyDeferred, begin_span)
                    .chain()
                    .after(early_prepass_build_indirect_parameters)
                    .after(early_prepass)
                    .before(pass),
                (ApplyDeferred, end_span)
                    .chain()
                    .after(pass)
                    .before(early_downsample_depth),
            ),
        );
    }
}

fn begin_span(world: &mut World) {
    record(world, |recorder, encoder| {
        recorder.begin_time_span(encoder, BEVY_SHADOW_PASS.into());
    });
}

fn end_span(world: &mut World) {
    record(world, |recorder, encoder| recorder.end_time_span(encoder));
}

/// Records into commands of their own, for views of cameras only: point and spot lights run the same schedule.
fn record(world: &mut World, write: impl FnOnce(&DiagnosticsRecorder, &mut CommandEncoder)) {
    let is_camera = world
        .get_resource::<CurrentView>()
        .is_some_and(|view| world.get::<ViewLightEntities>(view.0).is_some());
    let (true, Some(recorder), Some(device)) = (
        is_camera,
        world.get_resource::<DiagnosticsRecorder>(),
        world.get_resource::<RenderDevice>(),
    ) else {
        return;
    };
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor {
        label: Some(BEVY_SHADOW_PASS),
    });
    write(recorder, &mut encoder);
    let commands = encoder.finish();
    if let Some(mut pending) = world.get_resource_mut::<PendingCommandBuffers>() {
        pending.push([commands]);
    }
}
