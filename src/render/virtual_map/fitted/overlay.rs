//! [`NeedOverlay`]: how finely a camera's picture needs its fitted map, in color.

use bevy::{
    core_pipeline::{
        FullscreenShader,
        prepass::ViewPrepassTextures,
        schedule::{Core3d, Core3dSystems},
        tonemapping::tonemapping,
    },
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId,
            PipelineCache, RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages, SpecializedRenderPipeline,
            SpecializedRenderPipelines, StorageBuffer, TextureFormat,
            binding_types::{storage_buffer_read_only_sized, texture_depth_2d, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        view::{ViewTarget, ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    measure::{NeedBuffers, PassBuffers},
    plan::{FittedFrame, FittedFrames},
};
use crate::{
    maths::virtual_map::fitted::FittedTile,
    render::{gpu_types::GpuNeedOverlay, overlay_pass::overlay_pipeline, shaders},
};

/// On a camera whose sun has a fitted map: the need of every pixel in color, blue for 256 texels across the whole map, green
/// 16 thousand, red 256 thousand, pink beyond the finest tiles; and the tiles' rectangles on the screen in white. Sky and what
/// is beside the map stay as they are.
#[derive(Component, Clone, Copy, Debug, PartialEq, ExtractComponent)]
pub struct NeedOverlay {
    /// 0 shows the picture only, 1 the colors only.
    pub opacity: f32,
}

/// Makes [`NeedOverlay`] work; costs nothing without one.
pub struct NeedOverlayPlugin;

impl Plugin for NeedOverlayPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ExtractComponentPlugin::<NeedOverlay>::default());
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_gpu_resource::<SpecializedRenderPipelines<OverlayPipeline>>()
            .add_systems(RenderStartup, init_pipeline)
            .add_systems(Render, prepare.in_set(RenderSystems::PrepareResources))
            .add_systems(Core3d, draw.in_set(Core3dSystems::PostProcess).after(tonemapping));
    }
}

#[derive(Resource)]
struct OverlayPipeline {
    layout: BindGroupLayoutDescriptor,
    fullscreen: FullscreenShader,
    shader: Handle<Shader>,
}

/// What one camera needs to be drawn.
#[derive(Component)]
struct PreparedOverlay(CachedRenderPipelineId);

fn init_pipeline(mut commands: Commands, fullscreen: Res<FullscreenShader>, server: Res<AssetServer>) {
    let entries = BindGroupLayoutEntries::with_indices(
        ShaderStages::FRAGMENT,
        (
            (0, uniform_buffer::<ViewUniform>(true)),
            (1, texture_depth_2d()),
            (3, storage_buffer_read_only_sized(false, None)),
            (4, storage_buffer_read_only_sized(false, None)),
            (5, storage_buffer_read_only_sized(false, None)),
        ),
    );
    commands.insert_resource(OverlayPipeline {
        layout: BindGroupLayoutDescriptor::new("umbrage_show_needs", &entries),
        fullscreen: fullscreen.clone(),
        shader: shaders::load(&server, "virtual_map/show_needs.wgsl"),
    });
}

impl SpecializedRenderPipeline for OverlayPipeline {
    type Key = TextureFormat;

    fn specialize(&self, format: TextureFormat) -> RenderPipelineDescriptor {
        overlay_pipeline(
            "umbrage_show_needs",
            &self.layout,
            &self.fullscreen,
            (&self.shader, Vec::new()),
            format,
        )
    }
}

fn prepare(
    mut commands: Commands,
    cameras: Query<(Entity, &ViewTarget), With<NeedOverlay>>,
    left: Query<Entity, (With<PreparedOverlay>, Without<NeedOverlay>)>,
    overlay_pipeline: Res<OverlayPipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<OverlayPipeline>>,
    cache: Res<PipelineCache>,
) {
    for entity in &left {
        commands.entity(entity).remove::<PreparedOverlay>();
    }
    for (entity, target) in &cameras {
        let id = pipelines.specialize(&cache, &overlay_pipeline, target.main_texture_format());
        commands.entity(entity).insert(PreparedOverlay(id));
    }
}

fn draw(
    view: ViewQuery<(
        &ExtractedCamera,
        &ViewTarget,
        &NeedOverlay,
        &PreparedOverlay,
        &FittedFrames,
        &NeedBuffers,
        &ViewPrepassTextures,
        &ViewUniformOffset,
    )>,
    overlay_pipeline: Res<OverlayPipeline>,
    cache: Res<PipelineCache>,
    view_uniforms: Res<ViewUniforms>,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
    mut ctx: RenderContext,
) {
    let (camera, target, overlay, prepared, frames, buffers, prepass, view_offset) = view.into_inner();
    let (Some(pipeline), Some(depth), Some(view_binding)) = (
        cache.get_render_pipeline(prepared.0),
        prepass.depth_view(),
        view_uniforms.uniforms.binding(),
    ) else {
        return;
    };
    let layout = cache.get_bind_group_layout(&overlay_pipeline.layout);
    let bind_group = |(frame, buffers): (&FittedFrame, &PassBuffers)| {
        let (parameters, rectangles) = shown(frame, overlay.opacity);
        let (mut parameters, mut rectangles) = (StorageBuffer::from(parameters), StorageBuffer::from(rectangles));
        parameters.write_buffer(&device, &queue);
        rectangles.write_buffer(&device, &queue);
        let entries = BindGroupEntries::with_indices((
            (0, view_binding.clone()),
            (1, depth),
            (3, buffers.parameters.as_entire_binding()),
            (4, parameters.binding()?),
            (5, rectangles.binding()?),
        ));
        Some(device.create_bind_group("umbrage_show_needs", &layout, &entries))
    };
    let bind_groups: Vec<BindGroup> = frames.0.iter().zip(&buffers.0).filter_map(bind_group).collect();
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("umbrage_show_needs"),
        color_attachments: &[Some(target.get_unsampled_color_attachment())],
        depth_stencil_attachment: None,
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    if let Some(viewport) = &camera.viewport {
        pass.set_camera_viewport(viewport);
    }
    pass.set_render_pipeline(pipeline);
    for bind_group in &bind_groups {
        pass.set_bind_group(0, bind_group, &[view_offset.offset]);
        pass.draw(0..3, 0..1);
    }
}

/// What the shader reads of a map.
fn shown(frame: &FittedFrame, opacity: f32) -> (GpuNeedOverlay, Vec<UVec4>) {
    let rect = |tile: &FittedTile| UVec4::new(tile.rect.min.x, tile.rect.min.y, tile.rect.max.x, tile.rect.max.y);
    let mut rectangles: Vec<UVec4> = frame.plan.tiles.iter().map(rect).collect();
    let parameters = GpuNeedOverlay {
        rectangle_count: rectangles.len() as u32,
        cap: frame.plan.cap as f32,
        opacity,
        padding: 0.0,
    };
    // Bindings must not be empty.
    rectangles.push(UVec4::ZERO);
    (parameters, rectangles)
}
