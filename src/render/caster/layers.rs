//! Other surfaces than the nearest in the maps: variants of Bevy's shadow pipelines, and a second atlas.
//!
//! Bevy's pipelines draw the faces that the material does not cull. A variant is the same pipeline with other culling, or
//! with a fragment shader that lets the second surface through only. It is made from the descriptor of the first, so it
//! follows every material that has no fragment shader in the shadow pass; those that do have one (they discard pixels)
//! keep it, and store their nearest surface.
//!
//! Fading levels of detail ([`unpop`](crate::render::unpop)) take a share of the light only. Their own pipelines dither them
//! into any map; the full path gives them an atlas of their own, in which a variant stores the share beside the depth, and
//! leaves them out of the others.

use std::collections::HashMap;

use bevy::{
    ecs::{
        query::ROQueryItem,
        system::{
            SystemParamItem,
            lifetimeless::{Read, SRes},
        },
    },
    pbr::SetPrepassViewEmptyBindGroup,
    prelude::*,
    render::{
        render_phase::{
            CachedRenderPipelinePhaseItem, PhaseItem, RenderCommand, RenderCommandResult, TrackedRenderPass,
            ViewBinnedRenderPhases,
        },
        render_resource::{
            BindGroup, BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId,
            Face, FragmentState, PipelineCache, RenderPipelineDescriptor, ShaderStages,
            binding_types::texture_depth_2d,
        },
        renderer::RenderDevice,
    },
};

use super::{phase::Caster, prepare::CasterViews};
use crate::{
    render::{atlas::ShadowAtlas, shaders, unpop::material::CASTS_SHARE},
    shadow::settings::ShadowStore,
};

/// On the render view of a light view that stores something else than the nearest surface.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CasterLayer {
    /// Faces that look away from the light; both of two-sided materials.
    BackFaces,
    /// What lies behind the first atlas.
    Second,
    /// The middle between that and the first atlas.
    Midpoint,
    /// Casters that fade, with their shares, and no others.
    Fading,
}

impl CasterLayer {
    /// Of the views that draw the first atlas, and of those that draw the second, if there is one.
    pub fn of(store: ShadowStore) -> (Option<Self>, Option<Self>) {
        match store {
            ShadowStore::Nearest => (None, None),
            ShadowStore::BackFaces => (Some(Self::BackFaces), None),
            ShadowStore::SecondDepth => (None, Some(Self::Second)),
            ShadowStore::Midpoint => (None, Some(Self::Midpoint)),
        }
    }
}

/// On the render view of a light view whose fading casters are drawn into an atlas of their own.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct FadingApart;

/// Render world: whether casters fade.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct FadingCasters {
    /// Some do in this frame.
    pub now: bool,
    /// Some may in another frame: there are levels of detail that fade. Who plans with bounded memory leaves room for them
    /// from the start, so that nothing is seen to change when they begin.
    pub sometimes: bool,
}

/// On the render view of a light view that draws the second atlas: the first one.
#[derive(Component, Clone, Debug)]
pub struct FirstAtlas(BindGroup);

/// A pipeline of Bevy's in another variant.
#[derive(Clone, Copy, Debug)]
struct Variant {
    id: CachedRenderPipelineId,
    /// Reads the first atlas from group 1.
    peels: bool,
}

/// Variants of Bevy's shadow pipelines, by pipeline and layer; `None` where the layer leaves out what the pipeline draws.
#[derive(Resource)]
pub struct CasterVariants {
    known: HashMap<(CachedRenderPipelineId, CasterLayer), Option<Variant>>,
    first_atlas_layout: BindGroupLayoutDescriptor,
    peel_shader: Handle<Shader>,
}

/// Makes [`CasterVariants`].
pub fn init_caster_variants(mut commands: Commands, server: Res<AssetServer>) {
    commands.insert_resource(CasterVariants {
        known: HashMap::new(),
        first_atlas_layout: BindGroupLayoutDescriptor::new(
            "umbrage_first_atlas",
            &BindGroupLayoutEntries::single(ShaderStages::FRAGMENT, texture_depth_2d()),
        ),
        peel_shader: shaders::load(&server, "caster/peel.wgsl"),
    });
}

/// Queues the variants that the phase of a camera needs, and binds the first atlas for the views of the second.
pub fn prepare_layers(world: &mut World, camera: Entity, views: &CasterViews, store: ShadowStore) {
    let (first, second) = CasterLayer::of(store);
    let fading = (!views.fading_views.is_empty()).then_some(CasterLayer::Fading);
    let layers: Vec<_> = [first, second, fading].into_iter().flatten().collect();
    if layers.is_empty() {
        return;
    }
    let pipelines = phase_pipelines(world, views);
    world.resource_scope(|world, mut variants: Mut<CasterVariants>| {
        let cache = world.resource::<PipelineCache>();
        for id in pipelines {
            for layer in &layers {
                variants.add(cache, id, *layer);
            }
        }
        let bind_group = world.get::<ShadowAtlas>(camera).map(|atlas| {
            world.resource::<RenderDevice>().create_bind_group(
                "umbrage_first_atlas",
                &cache.get_bind_group_layout(&variants.first_atlas_layout),
                &BindGroupEntries::single(&atlas.view),
            )
        });
        if let (Some(bind_group), Some(_)) = (bind_group, second) {
            for view in &views.second_views {
                world.entity_mut(*view).insert(FirstAtlas(bind_group.clone()));
            }
        }
    });
}

/// The pipelines of a phase's bins.
fn phase_pipelines(world: &World, views: &CasterViews) -> Vec<CachedRenderPipelineId> {
    let phases = world.resource::<ViewBinnedRenderPhases<Caster>>();
    let Some(phase) = phases.get(&views.retained_master) else {
        return Vec::new();
    };
    let sets = phase.multidrawable_meshes.keys();
    let bins = phase.batchable_meshes.keys().chain(phase.unbatchable_meshes.keys());
    sets.chain(bins.map(|(set, _)| set)).map(|set| set.pipeline).collect()
}

impl CasterVariants {
    fn add(&mut self, cache: &PipelineCache, original_id: CachedRenderPipelineId, layer: CasterLayer) {
        // The descriptor of a pipeline is kept from the frame after it was asked for; before, nothing is drawn with it.
        if self.known.contains_key(&(original_id, layer)) || cache.get_render_pipeline(original_id).is_none() {
            return;
        }
        let original = cache.get_render_pipeline_descriptor(original_id);
        let queue = |descriptor| cache.queue_render_pipeline(descriptor);
        let (descriptor, peels) = match layer {
            CasterLayer::BackFaces => (back_faces(original), false),
            CasterLayer::Second => (self.peeled(original, false), true),
            CasterLayer::Midpoint => (self.peeled(original, true), true),
            CasterLayer::Fading => {
                let id = with_share(original).map(queue);
                self.known
                    .insert((original_id, layer), id.map(|id| Variant { id, peels: false }));
                return;
            }
        };
        let variant = match descriptor.map(queue) {
            Some(id) => Variant { id, peels },
            None => Variant {
                id: original_id,
                peels: false,
            },
        };
        self.known.insert((original_id, layer), Some(variant));
    }

    /// What draws a pipeline's casters in a layer.
    fn variant(&self, original: CachedRenderPipelineId, layer: CasterLayer) -> Option<Variant> {
        self.known.get(&(original, layer)).copied().flatten()
    }

    /// Both sides of what has no fragment shader, behind the first atlas.
    fn peeled(&self, original: &RenderPipelineDescriptor, is_midpoint: bool) -> Option<RenderPipelineDescriptor> {
        if original.fragment.is_some() {
            return None;
        }
        let mut descriptor = original.clone();
        descriptor.label = Some("umbrage_peel_casters".into());
        descriptor.primitive.cull_mode = None;
        *descriptor.layout.get_mut(1)? = self.first_atlas_layout.clone();
        descriptor.fragment = Some(FragmentState {
            shader: self.peel_shader.clone(),
            shader_defs: if is_midpoint {
                vec!["MIDPOINT".into()]
            } else {
                Vec::new()
            },
            ..default()
        });
        Some(descriptor)
    }
}

/// The other side of what culls one.
fn back_faces(original: &RenderPipelineDescriptor) -> Option<RenderPipelineDescriptor> {
    let other_side = match original.primitive.cull_mode? {
        Face::Front => Face::Back,
        Face::Back => Face::Front,
    };
    let mut descriptor = original.clone();
    descriptor.label = Some("umbrage_back_faces".into());
    descriptor.primitive.cull_mode = Some(other_side);
    Some(descriptor)
}

/// Casters that fade, with their shares; of others nothing.
fn with_share(original: &RenderPipelineDescriptor) -> Option<RenderPipelineDescriptor> {
    let fades = |fragment: &FragmentState| fragment.shader_defs.contains(&CASTS_SHARE.into());
    if !original.fragment.as_ref().is_some_and(fades) {
        return None;
    }
    let mut descriptor = original.clone();
    descriptor.label = Some("umbrage_fading_casters".into());
    descriptor
        .fragment
        .as_mut()?
        .shader_defs
        .push("UMBRAGE_FADING_MAP".into());
    Some(descriptor)
}

/// Sets the pipeline of an item, in the variant of the view.
pub struct SetCasterPipeline;

impl<P: CachedRenderPipelinePhaseItem> RenderCommand<P> for SetCasterPipeline {
    type Param = (SRes<PipelineCache>, SRes<CasterVariants>);
    type ViewQuery = (Option<Read<CasterLayer>>, Has<FadingApart>);
    type ItemQuery = ();

    fn render<'w>(
        item: &P,
        (layer, fading_is_apart): ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        (cache, variants): SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let cache = cache.into_inner();
        let own = item.cached_pipeline();
        // Until its variant is compiled, a fading caster is dithered into the maps of all.
        let is_drawn_apart = || {
            let variant = variants.variant(own, CasterLayer::Fading);
            variant.is_some_and(|variant| cache.get_render_pipeline(variant.id).is_some())
        };
        if fading_is_apart && is_drawn_apart() {
            return RenderCommandResult::Skip;
        }
        let id = match layer {
            None => Some(own),
            Some(layer) => variants.variant(own, *layer).map(|variant| variant.id),
        };
        match id.and_then(|id| cache.get_render_pipeline(id)) {
            Some(pipeline) => {
                pass.set_render_pipeline(pipeline);
                RenderCommandResult::Success
            }
            None => RenderCommandResult::Skip,
        }
    }
}

/// Binds the first atlas as group 1 where the pipeline reads it, else Bevy's empty group.
pub struct SetCasterLayerBindGroup;

impl<P: PhaseItem + CachedRenderPipelinePhaseItem> RenderCommand<P> for SetCasterLayerBindGroup {
    type Param = (
        SRes<CasterVariants>,
        <SetPrepassViewEmptyBindGroup<1> as RenderCommand<P>>::Param,
    );
    type ViewQuery = (Option<Read<CasterLayer>>, Option<Read<FirstAtlas>>);
    type ItemQuery = ();

    fn render<'w>(
        item: &P,
        (layer, first_atlas): ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        (variants, empty): SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let key = layer.map(|layer| (item.cached_pipeline(), *layer));
        let peels = key.is_some_and(|(own, layer)| variants.variant(own, layer).is_some_and(|variant| variant.peels));
        match (peels, first_atlas) {
            (false, _) => SetPrepassViewEmptyBindGroup::<1>::render(item, (), None, empty, pass),
            (true, Some(first_atlas)) => {
                pass.set_bind_group(1, &first_atlas.0, &[]);
                RenderCommandResult::Success
            }
            (true, None) => RenderCommandResult::Skip,
        }
    }
}
