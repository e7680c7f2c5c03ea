//! The pass of [`ShadowMask`] in the render world.

use bevy::{
    core_pipeline::FullscreenShader,
    pbr::{ExtractedDirectionalLight, MeshPipeline, MeshPipelineKey, MeshViewBindGroup, ViewKeyCache},
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_asset::RenderAssets,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId,
            ColorTargetState, ColorWrites, FragmentState, LoadOp, Operations, PipelineCache, RenderPassColorAttachment,
            RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages, ShaderType, SpecializedRenderPipeline,
            SpecializedRenderPipelines, StoreOp, UniformBuffer, binding_types::uniform_buffer,
        },
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        sync_world::MainEntity,
        texture::GpuImage,
        view::ExtractedView,
    },
};

use super::ShadowMask;

/// Where the shader is in the embedded asset source.
pub(super) const SHADER: &str = "shaders/mask/mask.wgsl";

/// Twin of `MaskSettings` in `mask.wgsl`.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub(super) struct MaskSettings {
    /// World space, unit length.
    direction_to_sun: Vec3,
}

/// What does not depend on the view.
#[derive(Resource)]
pub(super) struct MaskPipeline {
    mesh_pipeline: MeshPipeline,
    settings_layout: BindGroupLayoutDescriptor,
    fullscreen: FullscreenShader,
    shader: Handle<Shader>,
}

/// What one view needs to be drawn.
#[derive(Component)]
pub(super) struct MaskView {
    pipeline: CachedRenderPipelineId,
    settings: UniformBuffer<MaskSettings>,
}

pub(super) fn init_pipeline(
    mut commands: Commands,
    mesh_pipeline: Res<MeshPipeline>,
    fullscreen: Res<FullscreenShader>,
    asset_server: Res<AssetServer>,
) {
    commands.insert_resource(MaskPipeline {
        mesh_pipeline: mesh_pipeline.clone(),
        settings_layout: BindGroupLayoutDescriptor::new(
            "shadow_mask_settings_layout",
            &BindGroupLayoutEntries::single(ShaderStages::FRAGMENT, uniform_buffer::<MaskSettings>(false)),
        ),
        fullscreen: fullscreen.clone(),
        shader: asset_server.load(format!("embedded://{SHADER}")),
    });
}

impl SpecializedRenderPipeline for MaskPipeline {
    type Key = MeshPipelineKey;

    fn specialize(&self, key: MeshPipelineKey) -> RenderPipelineDescriptor {
        let layout = self.mesh_pipeline.get_view_layout(key.into());
        let filter = key.intersection(MeshPipelineKey::SHADOW_FILTER_METHOD_RESERVED_BITS);
        let mut shader_defs = vec!["DEPTH_PREPASS".into(), "NORMAL_PREPASS".into()];
        for (method, name) in [
            (
                MeshPipelineKey::SHADOW_FILTER_METHOD_HARDWARE_2X2,
                "SHADOW_FILTER_METHOD_HARDWARE_2X2",
            ),
            (
                MeshPipelineKey::SHADOW_FILTER_METHOD_GAUSSIAN,
                "SHADOW_FILTER_METHOD_GAUSSIAN",
            ),
            (
                MeshPipelineKey::SHADOW_FILTER_METHOD_TEMPORAL,
                "SHADOW_FILTER_METHOD_TEMPORAL",
            ),
        ] {
            if filter == method {
                shader_defs.push(name.into());
            }
        }
        let target = |format| {
            Some(ColorTargetState {
                format,
                blend: None,
                write_mask: ColorWrites::ALL,
            })
        };
        RenderPipelineDescriptor {
            label: Some("shadow_mask_pipeline".into()),
            layout: vec![
                layout.main_layout,
                layout.binding_array_layout,
                self.settings_layout.clone(),
            ],
            vertex: self.fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: self.shader.clone(),
                shader_defs,
                targets: vec![
                    target(ShadowMask::MASK_FORMAT),
                    target(ShadowMask::DEPTH_FORMAT),
                    target(ShadowMask::NORMAL_FORMAT),
                ],
                ..default()
            }),
            ..default()
        }
    }
}

pub(super) fn prepare_views(
    mut commands: Commands,
    views: Query<(Entity, &ShadowMask, &ExtractedView)>,
    lights: Query<(&MainEntity, &ExtractedDirectionalLight)>,
    mask_pipeline: Res<MaskPipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<MaskPipeline>>,
    (pipeline_cache, view_keys): (Res<PipelineCache>, Res<ViewKeyCache>),
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
) {
    for (entity, mask, view) in &views {
        let light = lights.iter().find(|(light, _)| light.id() == mask.light);
        let key = view_keys.get(&view.retained_view_entity).copied();
        let (Some((_, light)), Some(key)) = (light, key) else {
            commands.entity(entity).remove::<MaskView>();
            continue;
        };
        if key.msaa_samples() > 1 {
            warn_once!("A camera with ShadowMask needs Msaa::Off; its mask is not drawn.");
            commands.entity(entity).remove::<MaskView>();
            continue;
        }
        let mut settings = UniformBuffer::from(MaskSettings {
            direction_to_sun: light.transform.back().into(),
        });
        settings.write_buffer(&device, &queue);
        commands.entity(entity).insert(MaskView {
            pipeline: pipelines.specialize(&pipeline_cache, &mask_pipeline, key),
            settings,
        });
    }
}

pub(super) fn draw_mask(
    view: ViewQuery<(&ExtractedCamera, &ShadowMask, &MaskView, &MeshViewBindGroup)>,
    images: Res<RenderAssets<GpuImage>>,
    mask_pipeline: Res<MaskPipeline>,
    pipeline_cache: Res<PipelineCache>,
    mut context: RenderContext,
) {
    let (camera, mask, mask_view, view_bind_group) = view.into_inner();
    let (Some(pipeline), Some(settings), Some(mask_image), Some(depth_image), Some(normal_image)) = (
        pipeline_cache.get_render_pipeline(mask_view.pipeline),
        mask_view.settings.binding(),
        images.get(&mask.mask),
        images.get(&mask.depth),
        images.get(&mask.normal),
    ) else {
        return;
    };
    let targets = [
        (mask_image, ShadowMask::MASK_FORMAT),
        (depth_image, ShadowMask::DEPTH_FORMAT),
        (normal_image, ShadowMask::NORMAL_FORMAT),
    ];
    let fits = |(image, format): &(&GpuImage, _)| {
        Some(image.texture_descriptor.size.width) == camera.physical_target_size.map(|size| size.x)
            && Some(image.texture_descriptor.size.height) == camera.physical_target_size.map(|size| size.y)
            && image.texture_descriptor.format == *format
    };
    if !targets.iter().all(fits) {
        warn_once!("The images of a ShadowMask have another size than its camera, or other formats; it is not drawn.");
        return;
    }
    let bind_group = context.render_device().create_bind_group(
        "shadow_mask_settings",
        &pipeline_cache.get_bind_group_layout(&mask_pipeline.settings_layout),
        &BindGroupEntries::single(settings),
    );
    let attachments = targets.map(|(image, _)| {
        Some(RenderPassColorAttachment {
            view: &image.texture_view,
            depth_slice: None,
            resolve_target: None,
            ops: Operations {
                load: LoadOp::Clear(LinearRgba::BLACK.into()),
                store: StoreOp::Store,
            },
        })
    });
    let mut pass = context.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("shadow_mask"),
        color_attachments: &attachments,
        depth_stencil_attachment: None,
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    pass.set_render_pipeline(pipeline);
    pass.set_bind_group(0, &view_bind_group.main, &view_bind_group.main_offsets);
    pass.set_bind_group(1, &view_bind_group.binding_array, &[]);
    pass.set_bind_group(2, &bind_group, &[]);
    pass.draw(0..3, 0..1);
}
