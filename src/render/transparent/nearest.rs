//! Draws the depths of transparent things into layers, the nearest first.

use bevy::{
    core_pipeline::{core_3d::Transparent3d, prepass::ViewPrepassTextures},
    prelude::*,
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_phase::ViewSortedRenderPhases,
        render_resource::{
            BindGroupEntries, LoadOp, Operations, PipelineCache, RenderPassDepthStencilAttachment,
            RenderPassDescriptor, StoreOp,
        },
        renderer::{RenderContext, ViewQuery},
        view::ExtractedView,
    },
};

use super::{
    TransparentSurfaces,
    items::{MaterialFunctions, draw_variants},
    pipelines::TransparentPipelines,
};

/// Draws the nearest transparent surfaces of the current camera, layer by layer: in each the nearest ones behind those of
/// the layer before.
pub(super) fn draw_nearest(
    world: &World,
    view: ViewQuery<(
        &ExtractedView,
        &ExtractedCamera,
        &TransparentSurfaces,
        Option<&ViewPrepassTextures>,
    )>,
    phases: Res<ViewSortedRenderPhases<Transparent3d>>,
    functions: MaterialFunctions,
    (pipelines, cache): (Res<TransparentPipelines>, Res<PipelineCache>),
    mut ctx: RenderContext,
) {
    let view_entity = view.entity();
    let (view, camera, surfaces, prepass) = view.into_inner();
    let (Some(phase), Some((bevys, in_layers))) = (phases.get(&view.retained_view_entity), functions.get()) else {
        return;
    };
    let opaque = prepass.and_then(|prepass| prepass.depth_view());
    let peels = surfaces.depth_test.is_some();
    // Spans of one name are samples of each other: those of all layers are one.
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), "umbrage_draw_nearest_transparent");
    for (index, layer) in surfaces.layers.iter().enumerate() {
        // The first one is behind no other.
        let before = index.checked_sub(1).map(|before| &surfaces.layers[before].depth.1);
        let bounds = opaque.filter(|_| peels).map(|opaque| {
            ctx.render_device().create_bind_group(
                "umbrage_peel_transparent",
                &cache.get_bind_group_layout(&pipelines.two_depths),
                &BindGroupEntries::sequential((opaque, before.unwrap_or(opaque))),
            )
        });
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
        if let Some(viewport) = &camera.viewport {
            pass.set_camera_viewport(viewport);
        }
        if let Some(bounds) = &bounds {
            pass.set_bind_group(4, bounds, &[]);
        }
        draw_variants(phase, functions.all(), (world, view_entity), &mut pass, |item| {
            if !peels {
                return pipelines.depth_only(item.pipeline).map(|id| (id, item.draw_function));
            }
            let is_layered = bounds.is_some() && item.draw_function == in_layers;
            let variant = pipelines.peel(item.pipeline, index).filter(|_| is_layered);
            variant.map(|id| (id, bevys))
        });
    }
    span.end(ctx.command_encoder());
}
