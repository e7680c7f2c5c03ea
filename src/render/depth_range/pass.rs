//! The reduction: one compute dispatch over the depth prepass.

use bevy::{
    core_pipeline::prepass::ViewPrepassTextures,
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedComputePipelineId,
            ComputePassDescriptor, ComputePipelineDescriptor, PipelineCache, ShaderStages,
            binding_types::{storage_buffer_sized, texture_depth_2d},
        },
        renderer::{RenderContext, ViewQuery},
    },
};

use super::{REDUCE_DEPTHS, prepare::DepthRangeBuffers};
use crate::render::shaders;

/// Pixels per side that one workgroup of the shader reads.
const TILE: u32 = 32;

#[derive(Resource)]
pub(super) struct ReducePipeline {
    layout: BindGroupLayoutDescriptor,
    id: CachedComputePipelineId,
}

pub(super) fn init_pipeline(mut commands: Commands, cache: Res<PipelineCache>, server: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        REDUCE_DEPTHS,
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (texture_depth_2d(), storage_buffer_sized(false, None)),
        ),
    );
    let id = cache.queue_compute_pipeline(ComputePipelineDescriptor {
        label: Some(REDUCE_DEPTHS.into()),
        layout: vec![layout.clone()],
        shader: shaders::load(&server, "depth_range/reduce_depths.wgsl"),
        entry_point: Some("reduce_depths".into()),
        zero_initialize_workgroup_memory: true,
        ..default()
    });
    commands.insert_resource(ReducePipeline { layout, id });
}

/// Reduces the depth prepass of the current camera and copies the range into a buffer that is free.
pub(super) fn reduce_depths(
    view: ViewQuery<(&mut DepthRangeBuffers, &ViewPrepassTextures)>,
    pipeline: Res<ReducePipeline>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (mut buffers, prepass) = view.into_inner();
    let (Some(compute), Some(depth), true) = (
        cache.get_compute_pipeline(pipeline.id),
        prepass.depth.as_ref(),
        buffers.read_backs.has_room(),
    ) else {
        return;
    };
    let bind_group = ctx.render_device().create_bind_group(
        REDUCE_DEPTHS,
        &cache.get_bind_group_layout(&pipeline.layout),
        &BindGroupEntries::sequential((&depth.texture.default_view, buffers.range.as_entire_binding())),
    );
    let size = depth.texture.texture.size();
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let encoder = ctx.command_encoder();
    encoder.clear_buffer(&buffers.range, 0, None);
    {
        let mut pass = encoder.begin_compute_pass(&ComputePassDescriptor {
            label: Some(REDUCE_DEPTHS),
            timestamp_writes: None,
        });
        let span = diagnostics.pass_span(&mut pass, REDUCE_DEPTHS);
        pass.set_pipeline(compute);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.dispatch_workgroups(size.width.div_ceil(TILE), size.height.div_ceil(TILE), 1);
        span.end(&mut pass);
    }
    let buffers = &mut *buffers;
    buffers.read_backs.copy(encoder, &buffers.range);
}
