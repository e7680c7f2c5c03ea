//! The reduction: one compute dispatch over the prepasses, a workgroup per block.

use bevy::{
    core_pipeline::prepass::ViewPrepassTextures,
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedComputePipelineId,
            ComputePassDescriptor, ComputePipelineDescriptor, PipelineCache, ShaderStages, TextureSampleType,
            binding_types::{
                storage_buffer_read_only_sized, storage_buffer_sized, texture_2d, texture_depth_2d, uniform_buffer,
            },
        },
        renderer::{RenderContext, ViewQuery},
        texture::FallbackImage,
        view::{ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use super::{SEE_BLOCKS, prepare::BlockBuffers};
use crate::render::shaders;

#[derive(Resource)]
pub(super) struct BlockPipeline {
    layout: BindGroupLayoutDescriptor,
    id: CachedComputePipelineId,
}

pub(super) fn init_pipeline(mut commands: Commands, cache: Res<PipelineCache>, server: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        SEE_BLOCKS,
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                uniform_buffer::<ViewUniform>(true),
                texture_depth_2d(),
                texture_2d(TextureSampleType::Float { filterable: false }),
                storage_buffer_read_only_sized(false, None),
                storage_buffer_sized(false, None),
            ),
        ),
    );
    let id = cache.queue_compute_pipeline(ComputePipelineDescriptor {
        label: Some(SEE_BLOCKS.into()),
        layout: vec![layout.clone()],
        shader: shaders::load(&server, "light_plane/see_blocks.wgsl"),
        entry_point: Some("see_blocks".into()),
        ..default()
    });
    commands.insert_resource(BlockPipeline { layout, id });
}

/// Reduces the prepasses of the current camera and copies the blocks into a buffer that is free.
pub(super) fn see_blocks(
    view: ViewQuery<(&mut BlockBuffers, &ViewPrepassTextures, &ViewUniformOffset)>,
    pipeline: Res<BlockPipeline>,
    cache: Res<PipelineCache>,
    (view_uniforms, fallback): (Res<ViewUniforms>, Res<FallbackImage>),
    mut ctx: RenderContext,
) {
    let (mut buffers, prepass, view_offset) = view.into_inner();
    let (Some(compute), Some(depth), Some(view_binding), Some(grid), true) = (
        cache.get_compute_pipeline(pipeline.id),
        prepass.depth_view(),
        view_uniforms.uniforms.binding(),
        buffers.grid.binding(),
        buffers.read_backs.has_room(),
    ) else {
        return;
    };
    let normals = prepass.normal_view().unwrap_or(&fallback.d2.texture_view);
    let bind_group = ctx.render_device().create_bind_group(
        SEE_BLOCKS,
        &cache.get_bind_group_layout(&pipeline.layout),
        &BindGroupEntries::sequential((view_binding, depth, normals, grid, buffers.blocks.as_entire_binding())),
    );
    let count = buffers.grid.get().block_count;
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let encoder = ctx.command_encoder();
    {
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some(SEE_BLOCKS),
            timestamp_writes: None,
        });
        let span = diagnostics.pass_span(&mut pass, SEE_BLOCKS);
        pass.set_pipeline(compute);
        pass.set_bind_group(0, &bind_group, &[view_offset.offset]);
        pass.dispatch_workgroups(count.x, count.y, 1);
        span.end(&mut pass);
    }
    let buffers = &mut *buffers;
    buffers.read_backs.copy(encoder, &buffers.blocks);
}
