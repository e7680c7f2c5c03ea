//! Draws transparent things into the picture, layer by layer.

use bevy::{
    core_pipeline::core_3d::Transparent3d,
    pbr::ViewLightEntities,
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
        view::{ExtractedView, ViewDepthTexture, ViewTarget},
    },
};

use super::{
    TransparentSurfaces,
    items::{MaterialFunctions, draw_variants},
    pipelines::TransparentPipelines,
};
use crate::render::{bridge::layer::SunLayers, extract::ExtractedSun};

/// Draws what Bevy's own pass has left out for the current camera: from the farthest layer to the nearest, with the layer's
/// shadow result.
pub(super) fn draw_layers(
    world: &World,
    view: ViewQuery<(
        (&ExtractedView, &ExtractedCamera),
        (&ViewTarget, &ViewDepthTexture),
        &TransparentSurfaces,
        (&ExtractedSun, &ViewLightEntities),
    )>,
    phases: Res<ViewSortedRenderPhases<Transparent3d>>,
    functions: MaterialFunctions,
    (pipelines, cache): (Res<TransparentPipelines>, Res<PipelineCache>),
    sun_layers: SunLayers,
    mut ctx: RenderContext,
) {
    let view_entity = view.entity();
    let ((view, camera), (target, opaque), surfaces, (sun, lights)) = view.into_inner();
    let select = pipelines.select(view.target_format);
    let (Some(phase), Some((bevys, in_layers)), Some((_, depth_test)), Some(select)) = (
        phases.get(&view.retained_view_entity),
        functions.get(),
        &surfaces.depth_test,
        select.and_then(|id| cache.get_render_pipeline(id)),
    ) else {
        return;
    };
    // Spans of one name are samples of each other: those of all layers are one. It is no span of shadows, so it has not their
    // prefix: materials are drawn in it.
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), "draw_transparent_layers");
    for layer in surfaces.layers.iter().rev() {
        sun_layers.write_transparent(&mut ctx, (lights, sun.light), layer, surfaces.size);
        let depths = ctx.render_device().create_bind_group(
            "umbrage_select_layer",
            &cache.get_bind_group_layout(&pipelines.two_depths),
            &BindGroupEntries::sequential((opaque.view(), &layer.depth.1)),
        );
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("umbrage_draw_transparent_layer"),
            color_attachments: &[Some(target.get_color_attachment())],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: depth_test,
                depth_ops: Some(Operations {
                    load: LoadOp::Clear(0.0),
                    store: StoreOp::Discard,
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
        pass.set_render_pipeline(select);
        pass.set_bind_group(0, &depths, &[]);
        pass.draw(0..3, 0..1);
        draw_variants(phase, functions.all(), (world, view_entity), &mut pass, |item| {
            let variant = pipelines
                .draw(item.pipeline)
                .filter(|_| item.draw_function == in_layers);
            variant.map(|id| (id, bevys))
        });
    }
    span.end(ctx.command_encoder());
}
