//! Writes shadow results into the sun's extra shadow layers.

use bevy::{
    core_pipeline::FullscreenShader,
    log::warn_once,
    pbr::{LightEntity, ShadowView, ViewLightEntities},
    prelude::*,
    render::{
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId,
            CompareFunction, DepthStencilState, FragmentState, LoadOp, Operations, PipelineCache,
            RenderPassDepthStencilAttachment, RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages, StoreOp,
            TextureFormat, TextureSampleType,
            binding_types::{texture_2d, texture_depth_2d},
        },
        renderer::{RenderContext, ViewQuery},
        view::ExtractedView,
    },
};

use crate::render::{atlas::ShadowResult, extract::ExtractedSun, shaders, transparent::TransparentLayer};

/// Index of the sun's cascade that carries the shadow result; the main world's [`crate::shadow::full`] makes it.
const MASK_LAYER: usize = 1;

/// Index of the one that carries the nearest transparent surfaces.
const TRANSPARENT_LAYER: usize = 2;

/// The pipelines of both layers.
#[derive(Resource)]
pub(super) struct LayerPipelines {
    result: LayerPipeline,
    transparent: LayerPipeline,
}

struct LayerPipeline {
    layout: BindGroupLayoutDescriptor,
    id: CachedRenderPipelineId,
}

pub(super) fn init_layer_pipelines(
    mut commands: Commands,
    cache: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
    server: Res<AssetServer>,
) {
    let pipeline = |label: &'static str, layout: BindGroupLayoutDescriptor, file: &str| {
        let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some(label.into()),
            layout: vec![layout.clone()],
            vertex: fullscreen.to_vertex_state(),
            fragment: Some(FragmentState {
                shader: shaders::load(&server, file),
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
        LayerPipeline { layout, id }
    };
    let result = || texture_2d(TextureSampleType::Float { filterable: false });
    let one = BindGroupLayoutEntries::single(ShaderStages::FRAGMENT, result());
    let two = BindGroupLayoutEntries::sequential(ShaderStages::FRAGMENT, (result(), texture_depth_2d()));
    commands.insert_resource(LayerPipelines {
        result: pipeline(
            "umbrage_write_layer",
            BindGroupLayoutDescriptor::new("umbrage_write_layer", &one),
            "bridge/write_layer.wgsl",
        ),
        transparent: pipeline(
            "umbrage_write_second_layer",
            BindGroupLayoutDescriptor::new("umbrage_write_second_layer", &two),
            "bridge/write_second_layer.wgsl",
        ),
    });
}

/// Writes the shadow result of the current camera, and its nearest transparent surfaces if the sun has a layer for them.
pub(super) fn write_layers(
    view: ViewQuery<(
        &ShadowResult,
        &ExtractedSun,
        &ViewLightEntities,
        Option<&TransparentLayer>,
    )>,
    shadow_views: Query<(&ShadowView, &LightEntity, &ExtractedView)>,
    pipelines: Res<LayerPipelines>,
    cache: Res<PipelineCache>,
    mut ctx: RenderContext,
) {
    let (result, sun, lights, transparent) = view.into_inner();
    let layer_of = |index: usize| {
        lights.lights.iter().find_map(|entity| {
            let (shadow_view, kind, view) = shadow_views.get(*entity).ok()?;
            let LightEntity::Directional {
                light_entity,
                cascade_index,
            } = kind
            else {
                return None;
            };
            (*light_entity == sun.light && *cascade_index == index).then_some((shadow_view, view.viewport.zw()))
        })
    };
    if let Some((_, layer_size)) = layer_of(MASK_LAYER)
        && result.size.cmpgt(layer_size).any()
    {
        warn_once!(
            "a camera of {} pixels does not fit the shadow layer of {}: its borders stay unshadowed; raise DirectionalLightShadowMap::size",
            result.size,
            layer_size
        );
    }
    let layout = |pipeline: &LayerPipeline| cache.get_bind_group_layout(&pipeline.layout);
    let device = ctx.render_device();
    let own = device.create_bind_group(
        "umbrage_write_layer",
        &layout(&pipelines.result),
        &BindGroupEntries::single(&result.view),
    );
    let transparent = transparent.map(|layer| {
        device.create_bind_group(
            "umbrage_write_second_layer",
            &layout(&pipelines.transparent),
            &BindGroupEntries::sequential((&layer.result.1, &layer.depth.1)),
        )
    });
    // Without transparent surfaces their layer stays as Bevy clears it: depth 0.
    let writes: [(usize, &LayerPipeline, Option<BindGroup>, f32, &'static str); 2] = [
        (MASK_LAYER, &pipelines.result, Some(own), 1.0, "umbrage_write_layer"),
        (
            TRANSPARENT_LAYER,
            &pipelines.transparent,
            transparent,
            0.0,
            "umbrage_write_second_layer",
        ),
    ];
    for (index, pipeline, bind_group, empty, label) in writes {
        let (Some((shadow_view, layer_size)), Some(bind_group), Some(render_pipeline)) =
            (layer_of(index), bind_group, cache.get_render_pipeline(pipeline.id))
        else {
            continue;
        };
        let size = result.size.min(layer_size);
        let diagnostics = ctx.diagnostic_recorder();
        let diagnostics = diagnostics.as_deref();
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &shadow_view.depth_attachment.view,
                depth_ops: Some(Operations {
                    load: LoadOp::Clear(empty),
                    store: StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        let span = diagnostics.pass_span(&mut pass, label);
        pass.set_viewport(0.0, 0.0, size.x as f32, size.y as f32, 0.0, 1.0);
        pass.set_render_pipeline(render_pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.draw(0..3, 0..1);
        span.end(&mut pass);
    }
}
