//! Writes the shadow result into the sun's extra shadow layer.

use bevy::{
    core_pipeline::FullscreenShader,
    log::warn_once,
    pbr::{LightEntity, ShadowView, ViewLightEntities},
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId,
            CompareFunction, DepthStencilState, FragmentState, LoadOp, Operations, PipelineCache,
            RenderPassDepthStencilAttachment, RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages, StoreOp,
            TextureFormat, TextureSampleType, binding_types::texture_2d,
        },
        renderer::{RenderContext, ViewQuery},
        view::ExtractedView,
    },
};

use crate::render::{atlas::ShadowResult, extract::ExtractedSun, shaders};

/// Index of the sun's cascade that carries the shadow result; the main world's [`crate::shadow::full`] makes it.
const MASK_LAYER: usize = 1;

#[derive(Resource)]
pub(super) struct LayerPipeline {
    layout: BindGroupLayoutDescriptor,
    id: CachedRenderPipelineId,
}

pub(super) fn init_layer_pipeline(
    mut commands: Commands,
    cache: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
    server: Res<AssetServer>,
) {
    let layout = BindGroupLayoutDescriptor::new(
        "umbrage_write_layer",
        &BindGroupLayoutEntries::single(
            ShaderStages::FRAGMENT,
            texture_2d(TextureSampleType::Float { filterable: false }),
        ),
    );
    let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
        label: Some("umbrage_write_layer".into()),
        layout: vec![layout.clone()],
        vertex: fullscreen.to_vertex_state(),
        fragment: Some(FragmentState {
            shader: shaders::load(&server, "bridge/write_layer.wgsl"),
            ..default()
        }),
        depth_stencil: Some(DepthStencilState {
            format: TextureFormat::Depth32Float,
            depth_write_enabled: Some(true),
            depth_compare: Some(CompareFunction::Always),
            stencil: default(),
            bias: default(),
        }),
        ..default()
    });
    commands.insert_resource(LayerPipeline { layout, id });
}

pub(super) fn write_layer(
    view: ViewQuery<(&ShadowResult, &ExtractedSun, &ViewLightEntities)>,
    shadow_views: Query<(&ShadowView, &LightEntity, &ExtractedView)>,
    pipeline: Res<LayerPipeline>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (result, sun, lights) = view.into_inner();
    let Some(render_pipeline) = cache.get_render_pipeline(pipeline.id) else {
        return;
    };
    let layer = lights.lights.iter().find_map(|entity| {
        let (shadow_view, kind, view) = shadow_views.get(*entity).ok()?;
        let LightEntity::Directional {
            light_entity,
            cascade_index,
        } = kind
        else {
            return None;
        };
        (*light_entity == sun.light && *cascade_index == MASK_LAYER).then_some((shadow_view, view.viewport.zw()))
    });
    let Some((shadow_view, layer_size)) = layer else {
        return;
    };
    if result.size.cmpgt(layer_size).any() {
        warn_once!(
            "a camera of {} pixels does not fit the shadow layer of {}: its borders stay unshadowed; raise DirectionalLightShadowMap::size",
            result.size,
            layer_size
        );
    }
    let size = result.size.min(layer_size);
    let bind_group = ctx.render_device().create_bind_group(
        "umbrage_write_layer",
        &cache.get_bind_group_layout(&pipeline.layout),
        &BindGroupEntries::single(&result.view),
    );
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("umbrage_write_layer"),
        color_attachments: &[],
        depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
            view: &shadow_view.depth_attachment.view,
            depth_ops: Some(Operations {
                load: LoadOp::Clear(1.0),
                store: StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    let span = diagnostics.pass_span(&mut pass, "umbrage_write_layer");
    pass.set_viewport(0.0, 0.0, size.x as f32, size.y as f32, 0.0, 1.0);
    pass.set_render_pipeline(render_pipeline);
    pass.set_bind_group(0, &bind_group, &[]);
    pass.draw(0..3, 0..1);
    span.end(&mut pass);
}
