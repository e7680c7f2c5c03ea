//! The apply pass: one full-screen draw turns the atlas and the depth prepass into the shadow result; where levels of
//! detail fade, one per layer does the same for their nearest surfaces, and one per layer of transparent ones.

use bevy::{
    core_pipeline::{FullscreenShader, schedule::Core3d},
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId,
            ColorTargetState, ColorWrites, FragmentState, LoadOp, Operations, PipelineCache, RenderPassColorAttachment,
            RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages, StorageBuffer, StoreOp, TextureSampleType,
            binding_types::{storage_buffer_read_only, texture_2d, texture_depth_2d, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        view::{ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    SunShadowPasses,
    atlas::{RESULT_FORMAT, ShadowAtlas},
    extract::ExtractedSun,
    gpu_types::{ApplyParameters, GpuLightView, MAX_LIGHT_VIEWS},
    receivers::{Receiver, receivers},
    shaders,
};
use crate::shadow::{
    settings::{Faces, PartitionSelection, SeamWidth, ShadowBias, ShadowFilter},
    timing::SystemTimes,
};

/// The apply pass.
pub struct ApplyPlugin;

impl Plugin for ApplyPlugin {
    fn build(&self, app: &mut App) {
        let times = SystemTimes::of(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .add_systems(RenderStartup, init_apply_pipeline)
            .add_systems(Render, prepare_parameters.in_set(RenderSystems::PrepareResources))
            .add_systems(
                Core3d,
                times.clock("apply_views", apply_views).in_set(SunShadowPasses::Apply),
            );
    }
}

#[derive(Resource)]
struct ApplyPipeline {
    layout: BindGroupLayoutDescriptor,
    id: CachedRenderPipelineId,
}

/// On a camera's render entity: what its apply pass reads.
#[derive(Component)]
pub struct ApplyBuffer(pub StorageBuffer<ApplyParameters>);

fn init_apply_pipeline(
    mut commands: Commands,
    cache: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
    server: Res<AssetServer>,
) {
    let layout = BindGroupLayoutDescriptor::new(
        "umbrage_apply_views",
        &BindGroupLayoutEntries::sequential(
            ShaderStages::FRAGMENT,
            (
                uniform_buffer::<ViewUniform>(true),
                texture_depth_2d(),
                texture_2d(TextureSampleType::Float { filterable: false }),
                storage_buffer_read_only::<ApplyParameters>(false),
                texture_depth_2d(),
                texture_depth_2d(),
            ),
        ),
    );
    let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
        label: Some("umbrage_apply_views".into()),
        layout: vec![layout.clone()],
        vertex: fullscreen.to_vertex_state(),
        fragment: Some(FragmentState {
            shader: shaders::load(&server, "apply/apply_views.wgsl"),
            targets: vec![Some(ColorTargetState {
                format: RESULT_FORMAT,
                blend: None,
                write_mask: ColorWrites::ALL,
            })],
            ..default()
        }),
        ..default()
    });
    commands.insert_resource(ApplyPipeline { layout, id });
}

/// What the shader reads, from the extracted sun and the atlas.
pub fn apply_parameters(sun: &ExtractedSun, atlas: &ShadowAtlas) -> ApplyParameters {
    let mut light_views = [GpuLightView::default(); MAX_LIGHT_VIEWS];
    for (index, (target, light_view)) in light_views.iter_mut().zip(&sun.light_views).enumerate() {
        *target = GpuLightView {
            clip_from_world: light_view.clip_from_world,
            atlas_rect: match sun.settings.maps.texels_per_axis() {
                Some(texels) => Vec4::new(0.0, 0.0, texels as f32, texels as f32),
                None => atlas.rect(index).as_vec4(),
            },
            depth_range: Vec2::new(light_view.near_depth, light_view.far_depth),
            seam_depth: light_view.seam_depth,
            stands_in: u32::from(light_view.stands_in),
        };
    }
    let (bias_kind, bias_value, bias_units) = match sun.settings.bias {
        ShadowBias::None => (0, 0.0, 0.0),
        ShadowBias::Constant { metres } => (1, metres, 0.0),
        ShadowBias::Footprint { scale } => (2, scale, 0.0),
        ShadowBias::Slope { factor, units } => (3, factor, units),
        ShadowBias::WorldSlope { factor } => (4, factor, 0.0),
        ShadowBias::ReceiverPlane { metres } => (5, metres, 0.0),
    };
    let (filter_kind, filter_taps, sun_diameter) = match sun.settings.filter {
        ShadowFilter::Hard => (0, 0, 0.0),
        ShadowFilter::Pcf2 => (1, 0, 0.0),
        ShadowFilter::Poisson { taps, .. } => (2, taps, 0.0),
        ShadowFilter::Pcss { taps, sun_diameter, .. } => (3, taps, sun_diameter),
    };
    let seams = sun.settings.seams;
    let (has_seams, seam_share, seam_metres) = match seams.width {
        SeamWidth::None => (false, 0.0, 0.0),
        SeamWidth::Share(share) => (share > 0.0, share, 0.0),
        SeamWidth::Metres(metres) => (metres > 0.0, 0.0, metres),
    };
    // An endless range has no end to fade at.
    let fade_length = if sun.end_depth.is_finite() {
        sun.end_depth * seams.fade
    } else {
        0.0
    };
    ApplyParameters {
        light_views,
        direction_to_light: sun.direction_to_light,
        light_view_count: sun.light_views.len().min(MAX_LIGHT_VIEWS) as u32,
        shadow_distance: sun.shadow_distance,
        selection: match (sun.settings.partitions.faces, sun.settings.selection) {
            _ if sun.settings.light_planes.is_some() => 3,
            (Faces::Apart { .. }, _) => 3,
            (Faces::Together, PartitionSelection::Depth) => 0,
            (Faces::Together, PartitionSelection::BestResolution) => 1,
            (Faces::Together, PartitionSelection::Finest) => 3,
        },
        filter_kind,
        bias_kind,
        bias_value,
        bias_units,
        filter_taps,
        filter_radius: sun.settings.filter.world_radius(),
        search_taps: filter_taps,
        sun_tangent: (sun_diameter.to_radians() * 0.5).tan(),
        seam_share,
        seam_metres,
        has_seams: u32::from(has_seams),
        fade_end: sun.end_depth,
        fade_length,
        has_fading: u32::from(atlas.fades),
        ..default()
    }
}

fn prepare_parameters(
    mut commands: Commands,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    mut cameras: Query<(Entity, &ExtractedSun, &ShadowAtlas, Option<&mut ApplyBuffer>)>,
) {
    for (entity, sun, atlas, known) in &mut cameras {
        let parameters = apply_parameters(sun, atlas);
        if let Some(mut known) = known {
            known.0.set(parameters);
            known.0.write_buffer(&device, &queue);
        } else {
            let mut buffer = StorageBuffer::from(parameters);
            buffer.write_buffer(&device, &queue);
            commands.entity(entity).insert(ApplyBuffer(buffer));
        }
    }
}

fn apply_views(
    world: &World,
    view: ViewQuery<(
        &ExtractedCamera,
        &ShadowAtlas,
        &ApplyBuffer,
        &ViewUniformOffset,
        &ExtractedSun,
    )>,
    pipeline: Res<ApplyPipeline>,
    cache: Res<PipelineCache>,
    view_uniforms: Res<ViewUniforms>,
    mut ctx: RenderContext,
) {
    let view_entity = view.entity();
    let (camera, atlas, buffer, view_offset, sun) = view.into_inner();
    if sun.settings.maps.is_virtual() {
        return;
    }
    let (Some(render_pipeline), Some(view_binding), Some(parameters)) = (
        cache.get_render_pipeline(pipeline.id),
        view_uniforms.uniforms.binding(),
        buffer.0.binding(),
    ) else {
        return;
    };
    // Spans of one name are samples of each other: those of all receivers are one.
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), "umbrage_apply_views");
    for receiver in receivers(world, view_entity) {
        let Receiver {
            depth, normals, result, ..
        } = receiver;
        let bind_group = ctx.render_device().create_bind_group(
            "umbrage_apply_views",
            &cache.get_bind_group_layout(&pipeline.layout),
            &BindGroupEntries::sequential((
                view_binding.clone(),
                depth,
                normals,
                parameters.clone(),
                atlas.lookup_view(),
                atlas.fading_view(),
            )),
        );
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some("umbrage_apply_views"),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: result,
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load: LoadOp::Clear(LinearRgba::WHITE.into()),
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
        pass.set_render_pipeline(render_pipeline);
        pass.set_bind_group(0, &bind_group, &[view_offset.offset]);
        pass.draw(0..3, 0..1);
    }
    span.end(ctx.command_encoder());
}
