//! The pass that finds the nearest fading surfaces of every pixel, one per layer, before the scene is drawn.
//!
//! Why: blended layers end as the last one drawn, not as the nearest. A level with several layers (leaves, hollows) would
//! change at once when it becomes opaque. And shadows of fading surfaces come from here: the depth prepass holds the opaque
//! level's. The depth buffer of the scene stays untouched, as the states of Unpopping ask for.
//!
//! Fading objects that may cover the same pixel are found in layers of their own ([`layers`](super::layers)), a pass each.
//!
//! Limits: where more of them stand before each other than there are layers
//! ([`fading_layers`](crate::lod::settings::LodSettings::fading_layers)), the nearest one of a layer has all of this; of those
//! behind, all surfaces are blended, and their shadows are those of opaque surfaces nearby. Their result has neither blur nor
//! history.

use bevy::{
    core_pipeline::{core_3d::Transparent3d, prepass::NORMAL_PREPASS_FORMAT},
    pbr::DrawMaterial,
    platform::collections::HashMap,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_phase::{DrawFunctions, ViewSortedRenderPhases},
        render_resource::{
            CachedRenderPipelineId, ColorTargetState, ColorWrites, CompareFunction, LoadOp, Operations, PipelineCache,
            RenderPassColorAttachment, RenderPassDepthStencilAttachment, RenderPassDescriptor,
            RenderPipelineDescriptor, StoreOp, TextureFormat, TextureView,
        },
        renderer::{RenderContext, ViewQuery},
        view::ExtractedView,
    },
};

use super::{
    draw::FadingItems,
    layers::{self, ExtractedLayers, LayerBindGroups},
    surfaces::{DEPTH_FORMAT, FadingSurfaces, LEVEL_FORMAT},
};
use crate::render::transparent::items::draw_variants;

/// Variants of fading pipelines that write the nearest surface.
#[derive(Resource, Default)]
pub struct NearestPipelines(HashMap<CachedRenderPipelineId, CachedRenderPipelineId>);

/// Builds the fading pipelines that are new in this frame, and their variants. Waits for them: the level that begins to
/// fade in the middle of a crossing has alpha 1, and would be seen to vanish, or to end as its last layer, until they are
/// there.
pub(super) fn build_pipelines(
    phases: Res<ViewSortedRenderPhases<Transparent3d>>,
    items: FadingItems,
    mut cache: ResMut<PipelineCache>,
    mut variants: ResMut<NearestPipelines>,
) {
    for item in phases.values().flat_map(|phase| phase.items.values()) {
        if !items.has(item) || variants.0.contains_key(&item.pipeline) {
            continue;
        }
        cache.block_on_render_pipeline(item.pipeline);
        // Its shaders may not be loaded yet.
        if cache.get_render_pipeline(item.pipeline).is_some() {
            let variant = nearest(cache.get_render_pipeline_descriptor(item.pipeline));
            let id = cache.queue_render_pipeline(variant);
            cache.block_on_render_pipeline(id);
            variants.0.insert(item.pipeline, id);
        }
    }
}

fn nearest(fading: &RenderPipelineDescriptor) -> RenderPipelineDescriptor {
    let mut descriptor = fading.clone();
    descriptor.label = Some("umbrage_nearest_fading".into());
    // Bevy's draw function binds its own groups only; the pass binds the last one.
    descriptor.layout.truncate(4);
    descriptor.layout.push(layers::bind_group_layout());
    if let Some(depth) = &mut descriptor.depth_stencil {
        depth.format = DEPTH_FORMAT;
        depth.depth_write_enabled = Some(true);
        depth.depth_compare = Some(CompareFunction::GreaterEqual);
        // Layers are compared with unbiased depths.
        depth.bias = default();
    }
    if let Some(fragment) = &mut descriptor.fragment {
        fragment.shader_defs.push("UMBRAGE_NEAREST".into());
        let target = |format: TextureFormat| {
            Some(ColorTargetState {
                format,
                blend: None,
                write_mask: ColorWrites::ALL,
            })
        };
        fragment.targets = vec![target(NORMAL_PREPASS_FORMAT), target(LEVEL_FORMAT)];
    }
    descriptor
}

/// Draws the nearest fading surfaces of the current camera, layer by layer.
pub(super) fn draw_nearest(
    world: &World,
    view: ViewQuery<(&ExtractedView, &ExtractedCamera, &FadingSurfaces)>,
    phases: Res<ViewSortedRenderPhases<Transparent3d>>,
    functions: Res<DrawFunctions<Transparent3d>>,
    (items, variants): (FadingItems, Res<NearestPipelines>),
    (in_use, bind_groups): (Res<ExtractedLayers>, Res<LayerBindGroups>),
    mut ctx: RenderContext,
) {
    let view_entity = view.entity();
    let (view, camera, surfaces) = view.into_inner();
    let Some(phase) = phases.get(&view.retained_view_entity).filter(|_| surfaces.is_current) else {
        return;
    };
    let (Some(fading), Some(bevys)) = (items.function(), functions.read().get_id::<DrawMaterial>()) else {
        return;
    };
    // Spans of one name are samples of each other: those of all layers are one.
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), "umbrage_draw_nearest_fading");
    for (layer, depth) in surfaces.depth.each.iter().enumerate() {
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("umbrage_draw_nearest_fading"),
            color_attachments: &[
                cleared(&surfaces.normal.each[layer]),
                cleared(&surfaces.level.each[layer]),
            ],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: depth,
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
        // What is not in use is left empty.
        let (true, Some(bind_group)) = (layer < in_use.0 as usize, bind_groups.0.get(layer)) else {
            continue;
        };
        if let Some(viewport) = &camera.viewport {
            pass.set_camera_viewport(viewport);
        }
        pass.set_bind_group(4, bind_group, &[]);
        draw_variants(phase, &functions, (world, view_entity), &mut pass, |item| {
            let variant = variants.0.get(&item.pipeline).filter(|_| item.draw_function == fading);
            variant.map(|pipeline| (*pipeline, bevys))
        });
    }
    span.end(ctx.command_encoder());
}

fn cleared(view: &TextureView) -> Option<RenderPassColorAttachment<'_>> {
    Some(RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: Operations {
            load: LoadOp::Clear(default()),
            store: StoreOp::Store,
        },
    })
}
