//! The caster phase: one binned phase for all light views of a camera, culled per view on the GPU.
//!
//! Why one phase: a phase of Bevy's own per light view would need casters × views mesh uniforms and CPU time for every
//! view; here the casters are queued once, with Bevy's own shadow pipelines, materials and bins, and every light view
//! draws the instances that a compute pass found in it. Techniques only produce light views.
//!
//! 1. [`prepare`]: a *master* view carries the phase; one render view per light view gives the matrices.
//! 2. [`queue`]: the casters of Bevy's first cascade (the master light view) into bins.
//! 3. [`plan`]: a dry run of the phase lists the bins and sizes the buffers.
//! 4. [`pass`]: a compute pass writes one indirect draw per (light view, caster); then all light views are drawn, and
//!    drawn again where the maps store more than the nearest surface ([`layers`]).

pub mod bounds;
pub mod drawn;
pub mod layers;
pub mod pass;
pub mod phase;
pub mod plan;
pub mod prepare;
pub mod queue;

use bevy::{
    core_pipeline::schedule::Core3d,
    ecs::schedule::ApplyDeferred,
    pbr::MeshPipeline,
    prelude::*,
    render::{
        ExtractSchedule, Render, RenderApp, RenderDebugFlags, RenderStartup, RenderSystems,
        render_phase::{AddRenderCommand, BinnedRenderPhasePlugin, DrawFunctions},
    },
};

use super::SunShadowPasses;
use crate::shadow::timing::SystemTimes;
use phase::{Caster, DrawCaster, DrawCasterDepthOnly};

/// Whether casters are culled per light view on the GPU. Off: every caster is drawn into every light view; for tests,
/// the maps are bit-identical.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct CasterCulling(pub bool);

impl Default for CasterCulling {
    fn default() -> Self {
        Self(true)
    }
}

/// What the caster phase did in the last frame, by camera render entity.
#[derive(Resource, Clone, Debug, Default)]
pub struct CasterStatistics(pub bevy::ecs::entity::EntityHashMap<CasterCounts>);

/// Counts of one camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CasterCounts {
    /// Light views drawn; tiles of a virtual map.
    pub light_views: u32,
    /// Bins: combinations of mesh, material and pipeline.
    pub bins: u32,
    /// Casters in the phase, before culling per light view.
    pub casters: u32,
    /// Bytes of the indirect draw buffers.
    pub buffer_bytes: u64,
}

/// The caster phase.
pub struct CasterPlugin;

impl Plugin for CasterPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(BinnedRenderPhasePlugin::<Caster, MeshPipeline>::new(
            RenderDebugFlags::default(),
        ));
        let times = SystemTimes::of(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<CasterCulling>()
            .init_resource::<layers::FadingCasters>()
            .init_resource::<CasterStatistics>()
            .init_resource::<bounds::MeshBounds>()
            .init_resource::<queue::PendingCasters>()
            .init_resource::<DrawFunctions<Caster>>()
            .add_render_command::<Caster, DrawCaster>()
            .add_render_command::<Caster, DrawCasterDepthOnly>()
            .add_systems(RenderStartup, (pass::init_cull_pipeline, layers::init_caster_variants))
            .add_systems(
                ExtractSchedule,
                times.clock("extract_mesh_bounds", bounds::extract_mesh_bounds),
            )
            .add_systems(
                Render,
                (
                    times
                        .clock("prepare_caster_views", prepare::prepare_caster_views)
                        .in_set(RenderSystems::PrepareViews),
                    times
                        .clock("queue_casters", queue::queue_casters)
                        .in_set(RenderSystems::QueueMeshes),
                    prepare::skip_idle_fallback.in_set(RenderSystems::PhaseSort),
                ),
            )
            .add_systems(
                Core3d,
                (
                    (ApplyDeferred, times.clock("plan_casters", plan::plan_casters))
                        .chain()
                        .in_set(SunShadowPasses::Plan),
                    times
                        .clock("draw_casters", pass::draw_casters)
                        .in_set(SunShadowPasses::DrawCasters),
                ),
            );
    }
}
