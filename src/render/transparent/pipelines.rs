//! Variants of the pipelines of transparent things.

use bevy::{
    core_pipeline::{FullscreenShader, core_3d::Transparent3d},
    platform::collections::HashMap,
    prelude::*,
    render::{
        render_phase::ViewSortedRenderPhases,
        render_resource::{
            BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId, ColorTargetState, ColorWrites,
            CompareFunction, DepthStencilState, FragmentState, PipelineCache, RenderPipelineDescriptor, ShaderStages,
            TextureFormat, VertexState, binding_types::texture_depth_2d,
        },
        renderer::RenderDevice,
    },
    shader::Shader,
};

use super::{DEPTH_FORMAT, GROUPS, TransparentCamera, items::MaterialFunctions};
use crate::{
    render::{bridge::patch::UMBRAGE_INVARIANT_POSITION, shaders, unpop::draw::FadingItems},
    shadow::settings::TransparentLayers,
};

/// Variants by pipeline, and what they share.
#[derive(Resource)]
pub(super) struct TransparentPipelines {
    /// Write depth only.
    depth_only: HashMap<CachedRenderPipelineId, CachedRenderPipelineId>,
    layered: HashMap<CachedRenderPipelineId, LayeredPipelines>,
    /// Fill the depth test, by format of the picture.
    select: HashMap<TextureFormat, CachedRenderPipelineId>,
    /// Two depths: of group 4 of pipelines that peel, and of those that select a layer.
    pub(super) two_depths: BindGroupLayoutDescriptor,
    peel_shader: Handle<Shader>,
    select_shader: Handle<Shader>,
    fullscreen: VertexState,
}

/// Variants for things that are drawn layer by layer.
#[derive(Clone, Copy)]
struct LayeredPipelines {
    /// Write the depth of the first layer, and of one behind another.
    peel: [CachedRenderPipelineId; 2],
    /// Draws one layer into the picture.
    draw: CachedRenderPipelineId,
}

pub(super) fn init_pipelines(mut commands: Commands, server: Res<AssetServer>, fullscreen: Res<FullscreenShader>) {
    commands.insert_resource(TransparentPipelines {
        depth_only: HashMap::new(),
        layered: HashMap::new(),
        select: HashMap::new(),
        two_depths: BindGroupLayoutDescriptor::new(
            "umbrage_two_depths",
            &BindGroupLayoutEntries::sequential(ShaderStages::FRAGMENT, (texture_depth_2d(), texture_depth_2d())),
        ),
        peel_shader: shaders::load(&server, "transparent/peel.wgsl"),
        select_shader: shaders::load(&server, "transparent/select_layer.wgsl"),
        fullscreen: fullscreen.to_vertex_state(),
    });
}

/// Queues variants of the pipelines of this frame. Until they are compiled things are missing in the layers, and are drawn in
/// Bevy's own pass.
pub(super) fn build_pipelines(
    phases: Res<ViewSortedRenderPhases<Transparent3d>>,
    cameras: Query<TransparentCamera>,
    (fading, functions): (FadingItems, MaterialFunctions),
    (device, cache): (Res<RenderDevice>, Res<PipelineCache>),
    mut pipelines: ResMut<TransparentPipelines>,
) {
    for camera in &cameras {
        let layers = camera.layers(&device);
        let (Some(phase), Some((bevys, in_layers))) = (phases.get(&camera.view.retained_view_entity), functions.get())
        else {
            continue;
        };
        if phase.items.is_empty() {
            continue;
        }
        for item in phase.items.values() {
            // A pipeline is known to the cache one frame after it was queued.
            if cache.get_render_pipeline(item.pipeline).is_none() {
                continue;
            }
            match layers {
                TransparentLayers::Off => {}
                TransparentLayers::Nearest if fading.has(item) => {}
                TransparentLayers::Nearest => pipelines.add_depth_only(&cache, item.pipeline),
                TransparentLayers::All { .. } if item.draw_function == bevys || item.draw_function == in_layers => {
                    pipelines.add_layered(&cache, item.pipeline);
                    pipelines.add_select(&cache, camera.view.target_format);
                }
                TransparentLayers::All { .. } => {}
            }
        }
    }
}

impl TransparentPipelines {
    /// The variant that writes depth only.
    pub(super) fn depth_only(&self, pipeline: CachedRenderPipelineId) -> Option<CachedRenderPipelineId> {
        self.depth_only.get(&pipeline).copied()
    }

    /// The variant that writes the depth of a layer.
    pub(super) fn peel(&self, pipeline: CachedRenderPipelineId, layer: usize) -> Option<CachedRenderPipelineId> {
        let variants = self.layered.get(&pipeline)?;
        Some(variants.peel[layer.min(1)])
    }

    /// The variant that draws a layer into the picture.
    pub(super) fn draw(&self, pipeline: CachedRenderPipelineId) -> Option<CachedRenderPipelineId> {
        self.layered.get(&pipeline).map(|variants| variants.draw)
    }

    /// The pipeline that fills the depth test, for a picture's format.
    pub(super) fn select(&self, format: TextureFormat) -> Option<CachedRenderPipelineId> {
        self.select.get(&format).copied()
    }

    /// Whether all variants for drawing things layer by layer are compiled.
    pub(super) fn draws_layers_of(&self, cache: &PipelineCache, pipeline: CachedRenderPipelineId) -> bool {
        let variants = self.layered.get(&pipeline);
        variants.is_some_and(|variants| {
            let [first, next] = variants.peel;
            [first, next, variants.draw]
                .into_iter()
                .all(|id| cache.get_render_pipeline(id).is_some())
        })
    }

    /// Whether the depth test can be filled for a picture of this format.
    pub(super) fn can_select(&self, cache: &PipelineCache, format: TextureFormat) -> bool {
        self.select(format)
            .is_some_and(|id| cache.get_render_pipeline(id).is_some())
    }

    fn add_depth_only(&mut self, cache: &PipelineCache, pipeline: CachedRenderPipelineId) {
        self.depth_only.entry(pipeline).or_insert_with(|| {
            cache.queue_render_pipeline(RenderPipelineDescriptor {
                label: Some("umbrage_nearest_transparent".into()),
                fragment: None,
                depth_stencil: Some(writes(CompareFunction::GreaterEqual)),
                ..cache.get_render_pipeline_descriptor(pipeline).clone()
            })
        });
    }

    fn add_layered(&mut self, cache: &PipelineCache, pipeline: CachedRenderPipelineId) {
        if self.layered.contains_key(&pipeline) {
            return;
        }
        let original = cache.get_render_pipeline_descriptor(pipeline);
        // What has a depth test of its own, as Bevy's forward decals have, stays in Bevy's pass.
        let depth_test = original.depth_stencil.as_ref().and_then(|depth| depth.depth_compare);
        if depth_test != Some(CompareFunction::GreaterEqual) {
            return;
        }
        let variants = LayeredPipelines {
            peel: [true, false].map(|is_first| cache.queue_render_pipeline(self.peeled(original, is_first))),
            draw: cache.queue_render_pipeline(at_layer(original)),
        };
        self.layered.insert(pipeline, variants);
    }

    /// Writes the nearest depth behind that of another layer.
    fn peeled(&self, original: &RenderPipelineDescriptor, is_first: bool) -> RenderPipelineDescriptor {
        let mut descriptor = with_invariant_position(original);
        descriptor.label = Some("umbrage_peel_transparent".into());
        descriptor.layout.truncate(GROUPS as usize - 1);
        descriptor.layout.push(self.two_depths.clone());
        descriptor.fragment = Some(FragmentState {
            shader: self.peel_shader.clone(),
            shader_defs: if is_first { vec!["FIRST".into()] } else { Vec::new() },
            ..default()
        });
        if let Some(depth) = &mut descriptor.depth_stencil {
            depth.format = DEPTH_FORMAT;
            depth.depth_write_enabled = Some(true);
            depth.depth_compare = Some(CompareFunction::GreaterEqual);
        }
        descriptor
    }

    fn add_select(&mut self, cache: &PipelineCache, format: TextureFormat) {
        if self.select.contains_key(&format) {
            return;
        }
        let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
            label: Some("umbrage_select_layer".into()),
            layout: vec![self.two_depths.clone()],
            vertex: self.fullscreen.clone(),
            fragment: Some(FragmentState {
                shader: self.select_shader.clone(),
                // In the pass of the picture, whose colour it leaves as it is.
                targets: vec![Some(ColorTargetState {
                    format,
                    blend: None,
                    write_mask: ColorWrites::empty(),
                })],
                ..default()
            }),
            depth_stencil: Some(writes(CompareFunction::Always)),
            ..default()
        });
        self.select.insert(format, id);
    }
}

/// Draws what is at the depth of a layer, in all else as the picture has it.
fn at_layer(original: &RenderPipelineDescriptor) -> RenderPipelineDescriptor {
    let mut descriptor = with_invariant_position(original);
    descriptor.label = Some("umbrage_draw_transparent_layer".into());
    if let Some(depth) = &mut descriptor.depth_stencil {
        depth.format = DEPTH_FORMAT;
        depth.depth_write_enabled = Some(false);
        depth.depth_compare = Some(CompareFunction::Equal);
    }
    descriptor
}

/// With a vertex shader that puts vertices at the same depths as in every other such pipeline.
fn with_invariant_position(original: &RenderPipelineDescriptor) -> RenderPipelineDescriptor {
    let mut descriptor = original.clone();
    descriptor.vertex.shader_defs.push(UMBRAGE_INVARIANT_POSITION.into());
    descriptor
}

fn writes(depth_compare: CompareFunction) -> DepthStencilState {
    DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(true),
        depth_compare: Some(depth_compare),
        stencil: default(),
        bias: default(),
    }
}
