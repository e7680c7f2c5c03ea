//! Writes shadow results into the sun's extra shadow layers.

use bevy::{
    core_pipeline::FullscreenShader,
    ecs::system::SystemParam,
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

use crate::render::{
    atlas::ShadowResult,
    extract::ExtractedSun,
    shaders,
    transparent::{TransparentLayer, TransparentSurfaces},
};

/// Index of the sun's cascade that carries the shadow result; the main world's [`crate::shadow::full`] makes it.
const MASK_LAYER: usize = 1;

/// Index of the one that carries transparent surfaces: the nearest, or one layer of them after another.
const TRANSPARENT_LAYER: usize = 2;

/// The pipelines of both layers.
#[derive(Resource)]
pub(in crate::render) struct LayerPipelines {
    result: LayerPipeline,
    transparent: LayerPipeline,
}

struct LayerPipeline {
    label: &'static str,
    layout: BindGroupLayoutDescriptor,
    id: CachedRenderPipelineId,
    /// What the layer holds beyond the picture.
    empty: f32,
}

pub(super) fn init_layer_pipelines(
    mut commands: Commands,
    cache: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
    server: Res<AssetServer>,
) {
    let pipeline = |label: &'static str, entries: &[_], file: &str, empty: f32| {
        let layout = BindGroupLayoutDescriptor::new(label, entries);
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
        LayerPipeline {
            label,
            layout,
            id,
            empty,
        }
    };
    let result = || texture_2d(TextureSampleType::Float { filterable: false });
    let one = BindGroupLayoutEntries::single(ShaderStages::FRAGMENT, result());
    let two = BindGroupLayoutEntries::sequential(ShaderStages::FRAGMENT, (result(), texture_depth_2d()));
    commands.insert_resource(LayerPipelines {
        result: pipeline("umbrage_write_layer", &one, "bridge/write_layer.wgsl", 1.0),
        transparent: pipeline(
            "umbrage_write_second_layer",
            &two,
            "bridge/write_second_layer.wgsl",
            0.0,
        ),
    });
}

/// The sun's extra layers in a camera's shadow maps, and what writes into them.
#[derive(SystemParam)]
pub(in crate::render) struct SunLayers<'w, 's> {
    views: Query<'w, 's, (&'static ShadowView, &'static LightEntity, &'static ExtractedView)>,
    pipelines: Res<'w, LayerPipelines>,
    cache: Res<'w, PipelineCache>,
}

impl SunLayers<'_, '_> {
    /// The view of a layer of a sun, by index of its cascade, and its size in texels.
    fn find(&self, (lights, sun): (&ViewLightEntities, Entity), index: usize) -> Option<(&ShadowView, UVec2)> {
        lights.lights.iter().find_map(|entity| {
            let (shadow_view, kind, view) = self.views.get(*entity).ok()?;
            let LightEntity::Directional {
                light_entity,
                cascade_index,
            } = kind
            else {
                return None;
            };
            (*light_entity == sun && *cascade_index == index).then_some((shadow_view, view.viewport.zw()))
        })
    }

    /// Writes a transparent layer of a camera's picture into that of the sun, if it has one.
    pub(in crate::render) fn write_transparent(
        &self,
        ctx: &mut RenderContext,
        sun: (&ViewLightEntities, Entity),
        layer: &TransparentLayer,
        size: UVec2,
    ) {
        let pipeline = &self.pipelines.transparent;
        let bind_group = ctx.render_device().create_bind_group(
            "umbrage_write_second_layer",
            &self.cache.get_bind_group_layout(&pipeline.layout),
            &BindGroupEntries::sequential((&layer.result.1, &layer.depth.1)),
        );
        if let Some(target) = self.find(sun, TRANSPARENT_LAYER) {
            self.write(ctx, target, size, pipeline, &bind_group);
        }
    }

    fn write(
        &self,
        ctx: &mut RenderContext,
        (shadow_view, layer_size): (&ShadowView, UVec2),
        size: UVec2,
        pipeline: &LayerPipeline,
        bind_group: &BindGroup,
    ) {
        let Some(render_pipeline) = self.cache.get_render_pipeline(pipeline.id) else {
            return;
        };
        let size = size.min(layer_size);
        let diagnostics = ctx.diagnostic_recorder();
        let diagnostics = diagnostics.as_deref();
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some(pipeline.label),
            color_attachments: &[],
            depth_stencil_attachment: Some(RenderPassDepthStencilAttachment {
                view: &shadow_view.depth_attachment.view,
                depth_ops: Some(Operations {
                    load: LoadOp::Clear(pipeline.empty),
                    store: StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        let span = diagnostics.pass_span(&mut pass, pipeline.label);
        pass.set_viewport(0.0, 0.0, size.x as f32, size.y as f32, 0.0, 1.0);
        pass.set_render_pipeline(render_pipeline);
        pass.set_bind_group(0, bind_group, &[]);
        pass.draw(0..3, 0..1);
        span.end(&mut pass);
    }
}

/// Writes the shadow result of the current camera, and its nearest transparent surfaces if the sun has a layer for them.
pub(super) fn write_layers(
    view: ViewQuery<(
        &ShadowResult,
        &ExtractedSun,
        &ViewLightEntities,
        Option<&TransparentSurfaces>,
    )>,
    layers: SunLayers,
    mut ctx: RenderContext,
) {
    let (result, sun, lights, transparent) = view.into_inner();
    let sun = (lights, sun.light);
    if let Some(target) = layers.find(sun, MASK_LAYER) {
        let (_, layer_size) = target;
        if result.size.cmpgt(layer_size).any() {
            warn_once!(
                "a camera of {} pixels does not fit the shadow layer of {}: its borders stay unshadowed; raise DirectionalLightShadowMap::size",
                result.size,
                layer_size
            );
        }
        let pipeline = &layers.pipelines.result;
        let bind_group = ctx.render_device().create_bind_group(
            "umbrage_write_layer",
            &layers.cache.get_bind_group_layout(&pipeline.layout),
            &BindGroupEntries::single(&result.view),
        );
        layers.write(&mut ctx, target, result.size, pipeline, &bind_group);
    }
    // Without transparent surfaces their layer stays as Bevy clears it: depth 0.
    if let Some(nearest) = transparent.and_then(|surfaces| surfaces.layers.first()) {
        layers.write_transparent(&mut ctx, sun, nearest, result.size);
    }
}
