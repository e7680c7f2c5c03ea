//! Render views of the caster phase.

use bevy::{
    camera::{primitives::Frustum, visibility::RenderLayers},
    core_pipeline::core_3d::Transparent3d,
    ecs::entity::EntityHashMap,
    math::primitives::ViewFrustum,
    pbr::{LightEntity, ShadowView, Transmissive3d, ViewLightEntities},
    platform::collections::HashSet,
    prelude::*,
    render::{
        batching::gpu_preprocessing::GpuPreprocessingMode,
        render_phase::{ViewBinnedRenderPhases, ViewSortedRenderPhases},
        view::{ExtractedView, NoIndirectDrawing, RetainedViewEntity},
    },
};

use super::{
    CasterStatistics,
    layers::{CasterLayer, FadingApart},
    phase::{Caster, CollectBins},
};
use crate::{
    render::{
        atlas::{ATLAS_FORMAT, ShadowAtlas},
        extract::ExtractedSun,
        unpop::{draw::FadingItems, surfaces::FadingSurfaces},
    },
    shadow::views::LightView,
};

/// Subview number of the master view; Bevy's own cascades count from 0.
const MASTER_SUBVIEW: u32 = 1000;

/// Subview number of the first view of the second atlas.
const SECOND_SUBVIEW: u32 = 1500;

/// Subview number of the first view of fading casters.
const FADING_SUBVIEW: u32 = 1750;

/// Render views of a virtual map, which its tiles use in turn. Each has room for a draw of every caster.
pub const TILE_SLOTS: usize = 16;

/// On a camera's render entity: the views of its caster phase.
#[derive(Component, Clone, Debug)]
pub struct CasterViews {
    /// Carries the phase.
    pub master: Entity,
    /// Key of the phase.
    pub retained_master: RetainedViewEntity,
    /// Key of Bevy's first cascade, whose caster set and pipelines the phase shares.
    pub retained_cascade: RetainedViewEntity,
    /// Render entity of Bevy's first cascade, whose map transparent surfaces read.
    pub cascade: Entity,
    /// Render entity of the light.
    pub light: Entity,
    /// One render view per light view; for virtual maps [`TILE_SLOTS`] for all tiles.
    pub light_views: Vec<Entity>,
    /// The same again for the second atlas, if there is one.
    pub second_views: Vec<Entity>,
    /// The same again for the atlas of fading casters, while some fade.
    pub fading_views: Vec<Entity>,
    /// The phase was made in this frame: every visible caster has to be queued, not only new ones.
    pub fresh: bool,
}

/// Keeps one master view and one render view per light view for every camera with a full-path sun.
pub fn prepare_caster_views(
    mut commands: Commands,
    mut phases: ResMut<ViewBinnedRenderPhases<Caster>>,
    mut cameras: Query<(
        Entity,
        &ExtractedSun,
        &ShadowAtlas,
        &mut ViewLightEntities,
        Option<&CasterViews>,
    )>,
    cascades: Query<(&ExtractedView, &LightEntity, &RenderLayers)>,
    mut statistics: ResMut<CasterStatistics>,
    mut owned: Local<EntityHashMap<CasterViews>>,
) {
    let mut live = HashSet::new();
    let mut seen: Vec<Entity> = Vec::new();
    for (camera, sun, atlas, mut lights, known) in &mut cameras {
        let Some((cascade_entity, cascade, layers)) = find_cascade(&lights, &cascades, sun.light, 0) else {
            continue;
        };
        let mut retained_master = cascade.retained_view_entity;
        retained_master.subview_index = MASTER_SUBVIEW;
        let mut views = match known {
            Some(views) => views.clone(),
            None => CasterViews {
                master: commands.spawn_empty().id(),
                retained_master,
                retained_cascade: cascade.retained_view_entity,
                cascade: cascade_entity,
                light: sun.light,
                light_views: Vec::new(),
                second_views: Vec::new(),
                fading_views: Vec::new(),
                fresh: true,
            },
        };
        views.retained_master = retained_master;
        views.retained_cascade = cascade.retained_view_entity;
        views.cascade = cascade_entity;
        views.light = sun.light;
        views.fresh = !phases.contains_key(&retained_master);
        let (first_layer, second_layer) = CasterLayer::of(sun.settings.store);
        let count = if sun.settings.maps.is_virtual() {
            sun.light_views.len().min(1) * TILE_SLOTS
        } else {
            sun.light_views.len()
        };
        resize(&mut commands, &mut views.light_views, count);
        let second_count = if second_layer.is_some() { count } else { 0 };
        resize(&mut commands, &mut views.second_views, second_count);
        let fading_count = if atlas.fades { count } else { 0 };
        resize(&mut commands, &mut views.fading_views, fading_count);

        commands.entity(views.master).insert((
            ExtractedView {
                retained_view_entity: retained_master,
                viewport: cascade.viewport,
                world_from_view: cascade.world_from_view,
                clip_from_view: cascade.clip_from_view,
                clip_from_world: cascade.clip_from_world,
                target_format: ATLAS_FORMAT,
                color_grading: default(),
                invert_culling: false,
            },
            Frustum(ViewFrustum::from_clip_from_world(
                &cascade.clip_from_world.unwrap_or_default(),
            )),
            layers.clone(),
            LightEntity::Directional {
                light_entity: sun.light,
                cascade_index: MASTER_SUBVIEW as usize,
            },
            NoIndirectDrawing,
            CollectBins::default(),
        ));
        for (entities, layer, first_number) in [
            (&views.light_views, first_layer, MASTER_SUBVIEW + 1),
            (&views.second_views, second_layer, SECOND_SUBVIEW),
            (&views.fading_views, Some(CasterLayer::Fading), FADING_SUBVIEW),
        ] {
            // Slots of tiles get their matrices when they are drawn.
            let light_views = sun.light_views.iter().enumerate().cycle();
            for (number, (entity, (index, light_view))) in (0..).zip(entities.iter().zip(light_views)) {
                let mut retained = retained_master;
                retained.subview_index = first_number + number;
                let mut entity = commands.entity(*entity);
                entity.insert(render_view(light_view, atlas.rect(index), retained));
                match layer {
                    Some(layer) => entity.insert(layer),
                    None => entity.remove::<CasterLayer>(),
                };
                if atlas.fades && layer != Some(CasterLayer::Fading) {
                    entity.insert(FadingApart);
                } else {
                    entity.remove::<FadingApart>();
                }
            }
        }
        // Bevy's preprocessing fills the mesh uniforms of all directional views in this list.
        lights.lights.push(views.master);
        phases.prepare_for_new_frame(retained_master, GpuPreprocessingMode::PreprocessingOnly);
        live.insert(retained_master);
        if !sun.settings.fallback_map {
            commands.entity(cascade_entity).remove::<ShadowView>();
        }
        seen.push(camera);
        owned.insert(camera, views.clone());
        commands.entity(camera).insert(views);
    }
    let gone: Vec<Entity> = owned.keys().copied().filter(|camera| !seen.contains(camera)).collect();
    for camera in gone {
        statistics.0.remove(&camera);
        if let Some(views) = owned.remove(&camera) {
            for entity in (views.light_views.into_iter())
                .chain(views.second_views)
                .chain(views.fading_views)
                .chain([views.master])
            {
                commands.entity(entity).despawn();
            }
        }
        if let Ok(mut entity) = commands.get_entity(camera) {
            entity.remove::<CasterViews>();
        }
    }
    phases.retain(|view, _| live.contains(view));
}

/// Spawns or despawns entities until there are so many.
fn resize(commands: &mut Commands, entities: &mut Vec<Entity>, count: usize) {
    for surplus in entities.drain(count.min(entities.len())..) {
        commands.entity(surplus).despawn();
    }
    while entities.len() < count {
        entities.push(commands.spawn_empty().id());
    }
}

/// Leaves out the fallback map where the camera draws nothing that reads it: no transparent and no transmissive surface.
/// Fading levels of detail have a shadow result of their own.
pub fn skip_idle_fallback(
    mut commands: Commands,
    cameras: Query<(&ExtractedView, &CasterViews, Option<&FadingSurfaces>)>,
    transparent: Res<ViewSortedRenderPhases<Transparent3d>>,
    transmissive: Option<Res<ViewSortedRenderPhases<Transmissive3d>>>,
    fading: FadingItems,
) {
    for (view, views, surfaces) in &cameras {
        let have_result = surfaces.is_some_and(|surfaces| surfaces.is_current);
        let key = view.retained_view_entity;
        let has_transparent = transparent
            .get(&key)
            .is_some_and(|phase| phase.items.values().any(|item| !have_result || !fading.has(item)));
        let has_transmissive = transmissive
            .as_ref()
            .and_then(|phases| phases.get(&key))
            .is_some_and(|phase| !phase.items.is_empty());
        if !has_transparent && !has_transmissive {
            commands.entity(views.cascade).remove::<ShadowView>();
        }
    }
}

/// Bevy's view of one cascade of a light, among the views of a camera.
pub fn find_cascade<'a>(
    lights: &ViewLightEntities,
    cascades: &'a Query<(&ExtractedView, &LightEntity, &RenderLayers)>,
    light: Entity,
    index: usize,
) -> Option<(Entity, &'a ExtractedView, &'a RenderLayers)> {
    lights.lights.iter().find_map(|entity| {
        let (view, kind, layers) = cascades.get(*entity).ok()?;
        let LightEntity::Directional {
            light_entity,
            cascade_index,
        } = kind
        else {
            return None;
        };
        (*light_entity == light && *cascade_index == index).then_some((*entity, view, layers))
    })
}

fn render_view(light_view: &LightView, viewport: UVec4, retained: RetainedViewEntity) -> ExtractedView {
    ExtractedView {
        retained_view_entity: retained,
        viewport,
        world_from_view: GlobalTransform::from(light_view.world_from_light),
        clip_from_view: light_view.clip_from_light,
        clip_from_world: Some(light_view.clip_from_world),
        target_format: ATLAS_FORMAT,
        color_grading: default(),
        invert_culling: false,
    }
}
