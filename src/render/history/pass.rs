//! The two draws of the history.

use bevy::{
    core_pipeline::{FullscreenShader, prepass::ViewPrepassTextures},
    prelude::*,
    render::{
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId,
            ColorTargetState, ColorWrites, FragmentState, LoadOp, Operations, PipelineCache, RenderPassColorAttachment,
            RenderPassDescriptor, RenderPipeline, RenderPipelineDescriptor, ShaderStages, StoreOp, TextureFormat,
            TextureSampleType, TextureView,
            binding_types::{texture_2d, texture_depth_2d, uniform_buffer},
        },
        renderer::{RenderContext, ViewQuery},
        view::{ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    BLEND_HISTORY,
    prepare::{HISTORY_FORMAT, HistoryTargets},
};
use crate::render::{
    atlas::{RESULT_FORMAT, ShadowResult},
    gpu_types::GpuHistoryFrame,
    shaders,
};

#[derive(Resource)]
pub(super) struct HistoryPipelines {
    blend_layout: BindGroupLayoutDescriptor,
    blend: CachedRenderPipelineId,
    resolve_layout: BindGroupLayoutDescriptor,
    resolve: CachedRenderPipelineId,
}

pub(super) fn init_pipelines(
    mut commands: Commands,
    cache: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
    server: Res<AssetServer>,
) {
    let unfiltered = || texture_2d(TextureSampleType::Float { filterable: false });
    let blend_layout = BindGroupLayoutDescriptor::new(
        BLEND_HISTORY,
        &BindGroupLayoutEntries::with_indices(
            ShaderStages::FRAGMENT,
            (
                (0, uniform_buffer::<ViewUniform>(true)),
                (1, texture_depth_2d()),
                (3, uniform_buffer::<GpuHistoryFrame>(false)),
                (4, unfiltered()),
                (5, unfiltered()),
            ),
        ),
    );
    let resolve_layout = BindGroupLayoutDescriptor::new(
        "umbrage_resolve_history",
        &BindGroupLayoutEntries::with_indices(ShaderStages::FRAGMENT, ((5, unfiltered()),)),
    );
    let queue = |layout: &BindGroupLayoutDescriptor, entry_point: &'static str, format: TextureFormat| {
        cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some(BLEND_HISTORY.into()),
            layout: vec![layout.clone()],
            vertex: fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: shaders::load(&server, "history/blend_history.wgsl"),
                entry_point: Some(entry_point.into()),
                targets: vec![Some(ColorTargetState {
                    format,
                    blend: None,
                    write_mask: ColorWrites::ALL,
                })],
                ..default()
            }),
            ..default()
        })
    };
    let blend = queue(&blend_layout, "blend", HISTORY_FORMAT);
    let resolve = queue(&resolve_layout, "resolve", RESULT_FORMAT);
    commands.insert_resource(HistoryPipelines {
        blend_layout,
        blend,
        resolve_layout,
        resolve,
    });
}

/// Blends the shadow result of the current camera with the frame before.
pub(super) fn blend_history(
    view: ViewQuery<(
        &ExtractedCamera,
        &ShadowResult,
        &mut HistoryTargets,
        &ViewPrepassTextures,
        &ViewUniformOffset,
    )>,
    pipelines: Res<HistoryPipelines>,
    cache: Res<PipelineCache>,
    view_uniforms: Res<ViewUniforms>,
    mut ctx: RenderContext,
) {
    let (camera, result, mut targets, prepass, view_offset) = view.into_inner();
    let (Some(blend), Some(resolve), Some(depth), Some(view_binding), Some(frame)) = (
        cache.get_render_pipeline(pipelines.blend),
        cache.get_render_pipeline(pipelines.resolve),
        prepass.depth_view(),
        view_uniforms.uniforms.binding(),
        targets.frame.binding(),
    ) else {
        return;
    };
    let (written, before) = (&targets.views[targets.current], &targets.views[1 - targets.current]);
    let blend_group = ctx.render_device().create_bind_group(
        BLEND_HISTORY,
        &cache.get_bind_group_layout(&pipelines.blend_layout),
        &BindGroupEntries::with_indices((
            (0, view_binding),
            (1, depth),
            (3, frame),
            (4, &result.view),
            (5, before),
        )),
    );
    let resolve_group = ctx.render_device().create_bind_group(
        BLEND_HISTORY,
        &cache.get_bind_group_layout(&pipelines.resolve_layout),
        &BindGroupEntries::with_indices(((5, written),)),
    );
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), BLEND_HISTORY);
    draw(&mut ctx, camera, written, blend, &blend_group, &[view_offset.offset]);
    draw(&mut ctx, camera, &result.view, resolve, &resolve_group, &[]);
    span.end(ctx.command_encoder());
    targets.is_valid = true;
}

/// Draws the whole picture of a camera.
fn draw(
    ctx: &mut RenderContext,
    camera: &ExtractedCamera,
    written: &TextureView,
    pipeline: &RenderPipeline,
    bind_group: &BindGroup,
    offsets: &[u32],
) {
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some(BLEND_HISTORY),
        color_attachments: &[Some(RenderPassColorAttachment {
            view: written,
            depth_slice: None,
            resolve_target: None,
            ops: Operations {
                // Visible, and nothing that a depth could agree with.
                load: LoadOp::Clear(LinearRgba::new(1.0, 0.0, 0.0, 0.0).into()),
                store: StoreOp::Store,
            },
        })],
        depth_stencil_attachment: None,
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    if let Some(viewport) = &camera.viewport {
        pass.set_camera_viewport(viewport);
    }
    pass.set_render_pipeline(pipeline);
    pass.set_bind_group(0, bind_group, offsets);
    pass.draw(0..3, 0..1);
}
