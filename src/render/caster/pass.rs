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
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, Buffer, BufferInitDescriptor,
            BufferUsages, CachedComputePipelineId, ComputePassDescriptor, ComputePipelineDescriptor, LoadOp,
            Operations, PipelineCache, RenderPassDepthStencilAttachment, RenderPassDescriptor, ShaderStages,
            ShaderType, StoreOp,
            binding_types::{storage_buffer_read_only_sized, storage_buffer_sized},
            encase,
        },
        renderer::{RenderContext, RenderDevice, ViewQuery},
    },
};

use super::{phase::Caster, plan::CasterPlan, prepare::CasterViews};
use crate::{
    render::{atlas::ShadowAtlas, extract::ExtractedSun, gpu_types::CullParameters, shaders},
    shadow::settings::CasterPasses,
};

/// Invocations of one workgroup of the culling shader.
const WORKGROUP_SIZE: u32 = 64;

/// The name of the time span around all passes of [`CasterPasses::PerMap`], culling included.
const DRAW_APART: &str = "umbrage_draw_casters_apart";

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
                storage_buffer_sized(false, None),
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

/// Culls the casters of a camera for some light views: fills the indirect draws of as many slots of its plan, from the
/// first. Returns whether the slots can be drawn: not until pipeline and mesh uniforms exist, in the first frames.
///
/// `matrices`: `clip_from_world` of each, in a storage buffer. `first_counter`: where [`CasterPlan::drawn`] counts the
/// first of them.
pub(in crate::render) fn cull_casters(
    world: &World,
    ctx: &mut RenderContext,
    plan: &CasterPlan,
    matrices: &Buffer,
    light_view_count: u32,
    first_counter: u32,
) -> bool {
    let (Some((arguments, counts)), Some(drawn)) = (&plan.indirect, &plan.drawn) else {
        return true;
    };
    let pipeline = world.resource::<CullPipeline>();
    let cache = world.resource::<PipelineCache>();
    let meshes = world
        .resource::<BatchedInstanceBuffers<MeshUniform, MeshInputUniform>>()
        .phase_instance_buffers
        .get(&TypeId::of::<Caster>())
        .and_then(|buffers| buffers.data_buffer.buffer());
    let (Some(meshes), Some(compute)) = (meshes, cache.get_compute_pipeline(pipeline.id)) else {
        return false;
    };
    let device = ctx.render_device().clone();
    let parameters = CullParameters {
        instance_total: plan.instance_total,
        bin_count: plan.bins.len() as u32,
        light_view_count,
        first_counter,
    };
    let bins = storage_buffer(&device, "umbrage_caster_bins", &plan.bins);
    let parameters = storage_buffer(&device, "umbrage_cull_parameters", &parameters);
    let bind_group = device.create_bind_group(
        "umbrage_cull_casters",
        &cache.get_bind_group_layout(&pipeline.layout),
        &BindGroupEntries::sequential((
            meshes.as_entire_binding(),
            bins.as_entire_binding(),
            matrices.as_entire_binding(),
            arguments.as_entire_binding(),
            counts.as_entire_binding(),
            parameters.as_entire_binding(),
            drawn.as_entire_binding(),
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
    pass.dispatch_workgroups(plan.instance_total.div_ceil(WORKGROUP_SIZE), light_view_count, 1);
    span.end(&mut pass);
    true
}

/// Culls and draws the light views of the current camera, into one atlas or two, together or one after the other. Virtual
/// maps draw their tiles themselves.
pub fn draw_casters(
    world: &World,
    view: ViewQuery<(&CasterViews, &CasterPlan, &ShadowAtlas, &ExtractedSun)>,
    phases: Res<ViewBinnedRenderPhases<Caster>>,
    mut ctx: RenderContext,
) {
    let (views, plan, atlas, sun) = view.into_inner();
    let Some(phase) = phases.get(&views.retained_master) else {
        return;
    };
    if sun.settings.maps.is_virtual() {
        return;
    }
    if let Some(drawn) = &plan.drawn {
        ctx.command_encoder().clear_buffer(drawn, 0, None);
    }
    let matrices = sun.light_views.iter().map(|light_view| light_view.clip_from_world);
    let matrices: Vec<Mat4> = matrices.collect();
    let together = match sun.settings.caster_passes {
        CasterPasses::Shared => matrices.len().max(1),
        CasterPasses::PerMap => 1,
    };
    let first = (&atlas.view, &views.light_views, "umbrage_draw_casters");
    let second = atlas.second.as_ref();
    let second = second.map(|(_, view)| (view, &views.second_views, "umbrage_draw_second_casters"));
    let fading = atlas.fading.as_ref().filter(|_| atlas.fades);
    let fading = fading.map(|(_, view)| (view, &views.fading_views, "umbrage_draw_fading_casters"));
    // Spans of one name are samples of each other: those of all passes are one.
    let is_apart = together < matrices.len();
    if is_apart && let Some(recorder) = ctx.diagnostic_recorder() {
        recorder.begin_time_span(ctx.command_encoder(), DRAW_APART.into());
    }
    // An atlas without maps is cleared all the same.
    for start in (0..matrices.len().max(1)).step_by(together) {
        let maps = start..(start + together).min(matrices.len());
        let buffer = storage_buffer(
            ctx.render_device(),
            "umbrage_light_view_matrices",
            &matrices[maps.clone()].to_vec(),
        );
        // Until the draws exist (the first frames) the atlas is only cleared.
        let ready = cull_casters(world, &mut ctx, plan, &buffer, maps.len() as u32, start as u32);
        for (target, light_views, label) in std::iter::once(first).chain(second).chain(fading) {
            let diagnostics = ctx.diagnostic_recorder();
            let diagnostics = diagnostics.as_deref();
            let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
                label: Some(label),
                color_attachments: &[],
                depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                    view: target,
                    depth_ops: Some(Operations {
                        load: if start == 0 { LoadOp::Clear(0.0) } else { LoadOp::Load },
                        store: StoreOp::Store,
                    }),
                    stencil_ops: None,
                }),
                timestamp_writes: None,
                occlusion_query_set: None,
                multiview_mask: None,
            });
            let span = diagnostics.pass_span(&mut pass, label);
            let drawn = light_views
                .iter()
                .enumerate()
                .filter(|(index, _)| ready && maps.contains(index));
            for (index, light_view) in drawn {
                let rect = atlas.rect(index);
                pass.set_viewport(rect.x as f32, rect.y as f32, rect.z as f32, rect.w as f32, 0.0, 1.0);
                pass.set_scissor_rect(rect.x, rect.y, rect.z, rect.w);
                if let Err(error) = phase.render(&mut pass, world, *light_view) {
                    error!("a light view could not be drawn: {error}");
                }
            }
            span.end(&mut pass);
        }
    }
    if is_apart && let Some(recorder) = ctx.diagnostic_recorder() {
        recorder.end_time_span(ctx.command_encoder());
    }
}

/// A buffer that shaders read and commands copy from.
pub(in crate::render) fn storage_buffer<T>(device: &RenderDevice, label: &str, value: &T) -> Buffer
where
    T: ShaderType + encase::internal::WriteInto + ?Sized,
{
    let mut contents = encase::StorageBuffer::new(Vec::<u8>::new());
    // Writing into a vector cannot fail: it grows.
    let _ = contents.write(value);
    device.create_buffer_with_data(&BufferInitDescriptor {
        label: Some(label),
        contents: &contents.into_inner(),
        usage: BufferUsages::STORAGE | BufferUsages::COPY_SRC,
    })
}
