//! Culls the casters per light view and draws all light views into the atlas.

use std::any::TypeId;

use bevy::{
    pbr::{MeshInputUniform, MeshUniform},
    prelude::*,
    render::{
        batching::gpu_preprocessing::BatchedInstanceBuffers,
        diagnostic::RecordDiagnostics,
        render_phase::ViewBinnedRenderPhases,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, BufferInitDescriptor, BufferUsages,
            CachedComputePipelineId, ComputePassDescriptor, ComputePipelineDescriptor, LoadOp, Operations,
            PipelineCache, RenderPassDepthStencilAttachment, RenderPassDescriptor, ShaderStages, ShaderType, StoreOp,
            binding_types::{storage_buffer_read_only_sized, storage_buffer_sized},
            encase,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
    },
};

use super::{phase::Caster, plan::CasterPlan, prepare::CasterViews};
use crate::render::{atlas::ShadowAtlas, extract::ExtractedSun, gpu_types::CullParameters, shaders};

/// Invocations of one workgroup of the culling shader.
const WORKGROUP_SIZE: u32 = 64;

/// The culling pipeline.
#[derive(Resource)]
pub struct CullPipeline {
    layout: BindGroupLayoutDescriptor,
    id: CachedComputePipelineId,
}

/// Queues the culling pipeline for compilation.
pub fn init_cull_pipeline(mut commands: Commands, cache: Res<PipelineCache>, server: Res<AssetServer>) {
    let layout = BindGroupLayoutDescriptor::new(
        "umbrage_cull_casters",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::COMPUTE,
            (
                storage_buffer_read_only_sized(false, None),
                storage_buffer_read_only_sized(false, None),
                storage_buffer_read_only_sized(false, None),
                storage_buffer_sized(false, None),
                storage_buffer_sized(false, None),
                storage_buffer_read_only_sized(false, None),
            ),
        ),
    );
    let id = cache.queue_compute_pipeline(ComputePipelineDescriptor {
        label: Some("umbrage_cull_casters".into()),
        layout: vec![layout.clone()],
        shader: shaders::load(&server, "caster/cull_casters.wgsl"),
        entry_point: Some("cull_casters".into()),
        ..default()
    });
    commands.insert_resource(CullPipeline { layout, id });
}

/// Culls and draws the light views of the current camera, into one atlas or two.
pub fn draw_casters(
    world: &World,
    view: ViewQuery<(&CasterViews, &CasterPlan, &ShadowAtlas, &ExtractedSun)>,
    phases: Res<ViewBinnedRenderPhases<Caster>>,
    pipeline: Res<CullPipeline>,
    cache: Res<PipelineCache>,
    instance_buffers: Res<BatchedInstanceBuffers<MeshUniform, MeshInputUniform>>,
    mut ctx: RenderContext,
) {
    let (views, plan, atlas, sun) = view.into_inner();
    let Some(phase) = phases.get(&views.retained_master) else {
        return;
    };
    let mut ready = true;
    if let Some((arguments, counts)) = &plan.indirect {
        let meshes = instance_buffers
            .phase_instance_buffers
            .get(&TypeId::of::<Caster>())
            .and_then(|buffers| buffers.data_buffer.buffer());
        // Until both exist (the first frames) the atlas is only cleared.
        ready = false;
        if let (Some(meshes), Some(compute)) = (meshes, cache.get_compute_pipeline(pipeline.id)) {
            ready = true;
            let device = ctx.render_device().clone();
            let matrices: Vec<Mat4> = sun
                .light_views
                .iter()
                .map(|light_view| light_view.clip_from_world)
                .collect();
            let bins = storage_bytes(&plan.bins);
            let parameters = storage_bytes(&CullParameters {
                instance_total: plan.instance_total,
                bin_count: plan.bins.len() as u32,
                light_view_count: matrices.len() as u32,
                padding: 0,
            });
            let bins = create_buffer(&device, "umbrage_caster_bins", &bins, BufferUsages::STORAGE);
            let matrices_buffer = create_buffer(
                &device,
                "umbrage_light_view_matrices",
                &storage_bytes(&matrices),
                BufferUsages::STORAGE,
            );
            let parameters = create_buffer(&device, "umbrage_cull_parameters", &parameters, BufferUsages::STORAGE);
            let bind_group = device.create_bind_group(
                "umbrage_cull_casters",
                &cache.get_bind_group_layout(&pipeline.layout),
                &BindGroupEntries::sequential((
                    meshes.as_entire_binding(),
                    bins.as_entire_binding(),
                    matrices_buffer.as_entire_binding(),
                    arguments.as_entire_binding(),
                    counts.as_entire_binding(),
                    parameters.as_entire_binding(),
                )),
            );
            ctx.command_encoder().clear_buffer(counts, 0, None);
            let diagnostics = ctx.diagnostic_recorder();
            let diagnostics = diagnostics.as_deref();
            let mut pass = ctx.command_encoder().begin_compute_pass(&ComputePassDescriptor {
                label: Some("umbrage_cull_casters"),
                timestamp_writes: None,
            });
            let span = diagnostics.pass_span(&mut pass, "umbrage_cull_casters");
            pass.set_pipeline(compute);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(plan.instance_total.div_ceil(WORKGROUP_SIZE), matrices.len() as u32, 1);
            span.end(&mut pass);
        }
    }

    let targets = [(&atlas.view, &views.light_views, "umbrage_draw_casters")];
    let second = atlas.second.as_ref();
    let second = second.map(|(_, view)| (view, &views.second_views, "umbrage_draw_second_casters"));
    for (target, light_views, label) in targets.into_iter().chain(second) {
        let diagnostics = ctx.diagnostic_recorder();
        let diagnostics = diagnostics.as_deref();
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: target,
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
        let span = diagnostics.pass_span(&mut pass, label);
        if ready {
            for (index, light_view) in light_views.iter().enumerate() {
                let rect = atlas.rect(index);
                pass.set_viewport(rect.x as f32, rect.y as f32, rect.z as f32, rect.w as f32, 0.0, 1.0);
                pass.set_scissor_rect(rect.x, rect.y, rect.z, rect.w);
                if let Err(error) = phase.render(&mut pass, world, *light_view) {
                    error!("a light view could not be drawn: {error}");
                }
            }
        }
        span.end(&mut pass);
    }
}

fn create_buffer(
    device: &RenderDevice,
    label: &str,
    contents: &[u8],
    usage: BufferUsages,
) -> bevy::render::render_resource::Buffer {
    device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some(label),
        contents,
        usage,
    })
}

fn storage_bytes<T: ShaderType + encase::internal::WriteInto + ?Sized>(value: &T) -> Vec<u8> {
    let mut buffer = encase::StorageBuffer::new(Vec::new());
    // Writing into a vector cannot fail: it grows.
    let _ = buffer.write(value);
    buffer.into_inner()
}
