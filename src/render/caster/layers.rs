//! Other surfaces than the nearest in the maps: variants of Bevy's shadow pipelines, and a second atlas.
//!
//! Bevy's pipelines draw the faces that the material does not cull. A variant is the same pipeline with other culling, or
//! with a fragment shader that lets the second surface through only. It is made from the descriptor of the first, so it
//! follows every material that has no fragment shader in the shadow pass; those that do have one (they discard pixels)
//! keep it, and store their nearest surface.

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
    render::{atlas::ShadowAtlas, shaders},
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

/// Variants of Bevy's shadow pipelines, by pipeline and layer.
#[derive(Resource)]
pub struct CasterVariants {
    known: HashMap<(CachedRenderPipelineId, CasterLayer), Variant>,
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
    let Some(layer) = first.or(second) else {
        return;
    };
    let pipelines = phase_pipelines(world, views);
    world.resource_scope(|world, mut variants: Mut<CasterVariants>| {
        let cache = world.resource::<PipelineCache>();
        for id in pipelines {
            variants.add(cache, id, layer);
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
    fn add(&mut self, cache: &PipelineCache, id: CachedRenderPipelineId, layer: CasterLayer) {
        // The descriptor of a pipeline is kept from the frame after it was asked for; before, nothing is drawn with it.
        if self.known.contains_key(&(id, layer)) || cache.get_render_pipeline(id).is_none() {
            return;
        }
        let original = cache.get_render_pipeline_descriptor(id);
        let variant = match layer {
            CasterLayer::BackFaces => back_faces(original).map(|descriptor| (descriptor, false)),
            CasterLayer::Second => self.peeled(original, false).map(|descriptor| (descriptor, true)),
            CasterLayer::Midpoint => self.peeled(original, true).map(|descriptor| (descriptor, true)),
        };
        let variant = match variant {
            Some((descriptor, peels)) => Variant {
                id: cache.queue_render_pipeline(descriptor),
                peels,
            },
            None => Variant { id, peels: false },
        };
        self.known.insert((id, layer), variant);
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

/// Sets the pipeline of an item, in the variant of the view.
pub struct SetCasterPipeline;

impl<P: CachedRenderPipelinePhaseItem> RenderCommand<P> for SetCasterPipeline {
    type Param = (SRes<PipelineCache>, SRes<CasterVariants>);
    type ViewQuery = Option<Read<CasterLayer>>;
    type ItemQuery = ();

    fn render<'w>(
        item: &P,
        layer: ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        (cache, variants): SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let own = item.cached_pipeline();
        let id = match layer {
            None => Some(own),
            Some(layer) => variants.known.get(&(own, *layer)).map(|variant| variant.id),
        };
        match id.and_then(|id| cache.into_inner().get_render_pipeline(id)) {
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
        let peels = key.is_some_and(|key| variants.known.get(&key).is_some_and(|variant| variant.peels));
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
