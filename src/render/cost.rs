//! [`shadow_cost`]: memory and draw calls of one camera's sun shadows, for measurements.

use bevy::{
    pbr::{Shadow, ShadowView, ViewLightEntities, ViewShadowBindings},
    prelude::*,
    render::{
        render_phase::ViewBinnedRenderPhases,
        render_resource::{Texture, TextureAspect},
        sync_world::MainEntity,
        view::ExtractedView,
    },
};

use super::{
    atlas::{ShadowAtlas, ShadowResult},
    blur::BlurTarget,
    caster::{CasterStatistics, prepare::CasterViews},
    history::HistoryTargets,
    transparent::TransparentSurfaces,
    virtual_map::report::VirtualMapReports,
};

/// Memory in bytes and draw calls of the frame just drawn. Everything is 0 for cameras without shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowCost {
    /// Bevy's array of directional shadow maps: cascades, or the fallback map and the mask layer of the full path.
    pub bevy_maps: u64,
    /// [`ShadowAtlas`], both where there are two; of a virtual map the tile textures alive at once and its other buffers.
    pub atlas: u64,
    /// [`ShadowResult`], the texture that its blur goes to and fro between, its history, and the layers of transparent surfaces.
    pub result: u64,
    /// Indirect draws of the caster phase and their counts.
    pub caster_buffers: u64,
    /// Draw calls into Bevy's maps: one per multi-draw of a batch set, per batch, and per mesh that cannot be batched.
    pub bevy_draw_calls: u64,
    /// Draw calls into the atlases: one multi-draw per light view or tile, and bin.
    pub atlas_draw_calls: u64,
}

impl ShadowCost {
    /// All memory.
    pub fn bytes(&self) -> u64 {
        self.bevy_maps + self.atlas + self.result + self.caster_buffers
    }

    /// All draw calls.
    pub fn draw_calls(&self) -> u64 {
        self.bevy_draw_calls + self.atlas_draw_calls
    }
}

/// What the sun shadows of a camera cost, from its entity in the render world.
pub fn shadow_cost(render_world: &World, camera_render_entity: Entity) -> ShadowCost {
    let Ok(camera) = render_world.get_entity(camera_render_entity) else {
        return ShadowCost::default();
    };
    let counts = render_world
        .get_resource::<CasterStatistics>()
        .and_then(|statistics| statistics.0.get(&camera_render_entity))
        .copied()
        .unwrap_or_default();
    let lights = camera.get::<ViewLightEntities>();
    let passes = camera.get::<ShadowAtlas>().map_or(1, |atlas| {
        1 + u64::from(atlas.second.is_some()) + u64::from(atlas.fades)
    });
    ShadowCost {
        bevy_maps: camera
            .get::<ViewShadowBindings>()
            .map_or(0, |bindings| texture_bytes(&bindings.directional_light_depth_texture)),
        atlas: camera
            .get::<ShadowAtlas>()
            .map_or(0, |atlas| atlas.textures().map(texture_bytes).sum())
            + virtual_map_bytes(render_world, &camera),
        result: camera
            .get::<ShadowResult>()
            .map_or(0, |result| texture_bytes(&result.texture))
            + camera
                .get::<BlurTarget>()
                .map_or(0, |target| texture_bytes(&target.texture))
            + camera
                .get::<HistoryTargets>()
                .map_or(0, |targets| targets.textures.iter().map(texture_bytes).sum())
            + camera.get::<TransparentSurfaces>().map_or(0, |surfaces| {
                let layers = surfaces.layers.iter().flat_map(|layer| [&layer.depth, &layer.result]);
                let textures = layers.chain(&surfaces.depth_test);
                textures.map(|(texture, _)| texture_bytes(texture)).sum()
            }),
        caster_buffers: counts.buffer_bytes,
        bevy_draw_calls: lights.map_or(0, |lights| bevy_draw_calls(render_world, lights)),
        atlas_draw_calls: u64::from(counts.light_views) * u64::from(counts.bins) * passes,
    }
}

/// Whether the last frame drew Bevy's fallback map for a camera on the full path: only where something reads it.
#[must_use]
pub fn draws_fallback_map(render_world: &World, camera: Entity) -> bool {
    let views = render_world.get::<CasterViews>(camera);
    views.is_some_and(|views| render_world.get::<ShadowView>(views.cascade).is_some())
}

/// Tile textures and other buffers of a camera's virtual map; 0 without.
fn virtual_map_bytes(render_world: &World, camera: &EntityRef) -> u64 {
    let reports = render_world.get_resource::<VirtualMapReports>();
    let report = reports
        .zip(camera.get::<MainEntity>())
        .and_then(|(reports, main)| reports.get(**main));
    report.map_or(0, |report| report.texture_bytes + report.buffer_bytes)
}

/// Draw calls of the shadow phases that Bevy draws for a camera.
fn bevy_draw_calls(render_world: &World, lights: &ViewLightEntities) -> u64 {
    let Some(phases) = render_world.get_resource::<ViewBinnedRenderPhases<Shadow>>() else {
        return 0;
    };
    let drawn = lights.lights.iter().filter_map(|entity| {
        let light_view = render_world.get_entity(*entity).ok()?;
        light_view.get::<ShadowView>()?;
        phases.get(&light_view.get::<ExtractedView>()?.retained_view_entity)
    });
    let draw_calls = drawn.map(|phase| {
        let unbatched: usize = phase.unbatchable_meshes.values().map(|bin| bin.entities.len()).sum();
        phase.multidrawable_meshes.len() + phase.batchable_meshes.len() + unbatched
    });
    draw_calls.sum::<usize>() as u64
}

/// Bytes of mip 0 of all layers.
fn texture_bytes(texture: &Texture) -> u64 {
    let format = texture.format();
    let aspect = if format.is_depth_stencil_format() {
        TextureAspect::DepthOnly
    } else {
        TextureAspect::All
    };
    let texel_bytes = format.block_copy_size(Some(aspect)).unwrap_or(0);
    [
        texture.width(),
        texture.height(),
        texture.depth_or_array_layers(),
        texel_bytes,
    ]
    .map(u64::from)
    .iter()
    .product()
}
