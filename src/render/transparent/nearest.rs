//! Draws transparent things into a depth texture.

use bevy::{
    core_pipeline::core_3d::Transparent3d,
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_phase::{DrawFunctions, ViewSortedRenderPhases},
        render_resource::{
            CachedRenderPipelineId, CompareFunction, DepthStencilState, LoadOp, Operations, PipelineCache,
            RenderPassDepthStencilAttachment, RenderPassDescriptor, RenderPipelineDescriptor, StoreOp,
        },
        renderer::{RenderContext, ViewQuery},
        view::ExtractedView,
    },
};

use super::{DEPTH_FORMAT, TransparentLayer, items::draw_variants};
use crate::render::unpop::draw::FadingItems;

/// Variants of transparent pipelines that write depth only.
#[derive(Resource, Default)]
pub(super) struct DepthPipelines(HashMap<CachedRenderPipelineId, CachedRenderPipelineId>);

/// Queues variants of the pipelines of this frame; things whose variant is not compiled yet are missing in the layer, and
/// read the fallback map.
pub(super) fn build_pipelines(
    phases: Res<ViewSortedRenderPhases<Transparent3d>>,
    cameras: Query<&ExtractedView, With<TransparentLayer>>,
    items: FadingItems,
    cache: Res<PipelineCache>,
    mut variants: ResMut<DepthPipelines>,
) {
    let seen = cameras.iter().filter_map(|view| phases.get(&view.retained_view_entity));
    for item in seen.flat_map(|phase| phase.items.values()) {
        // A pipeline is known to the cache one frame after it was queued.
        let is_known = cache.get_render_pipeline(item.pipeline).is_some();
        if is_known && !items.has(item) && !variants.0.contains_key(&item.pipeline) {
            let variant = depth_only(cache.get_render_pipeline_descriptor(item.pipeline));
            variants.0.insert(item.pipeline, cache.queue_render_pipeline(variant));
        }
    }
}

fn depth_only(transparent: &RenderPipelineDescriptor) -> RenderPipelineDescriptor {
    RenderPipelineDescriptor {
        label: Some("umbrage_nearest_transparent".into()),
        fragment: None,
        depth_stencil: Some(DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::GreaterEqual),
            stencil: default(),
            bias: default(),
        }),
        ..transparent.clone()
    }
}

/// Draws the nearest transparent surfaces of the current camera.
pub(super) fn draw_nearest_transparent(
    world: &World,
    view: ViewQuery<(&ExtractedView, &ExtractedCamera, &TransparentLayer)>,
    phases: Res<ViewSortedRenderPhases<Transparent3d>>,
    functions: Res<DrawFunctions<Transparent3d>>,
    variants: Res<DepthPipelines>,
    mut ctx: RenderContext,
) {
    let view_entity = view.entity();
    let (view, camera, layer) = view.into_inner();
    let Some(phase) = phases.get(&view.retained_view_entity) else {
        return;
    };
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("umbrage_draw_nearest_transparent"),
        color_attachments: &[],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: &layer.depth.1,
            depth_ops: Some(Operations {
                load: LoadOp::Clear(0.0),
                store: StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    let span = diagnostics.pass_span(&mut pass, "umbrage_draw_nearest_transparent");
    if let Some(viewport) = &camera.viewport {
        pass.set_camera_viewport(viewport);
    }
    draw_variants(phase, &functions, (world, view_entity), &mut pass, |item| {
        let variant = variants.0.get(&item.pipeline);
        variant.map(|pipeline| (*pipeline, item.draw_function))
    });
    span.end(&mut pass);
}
