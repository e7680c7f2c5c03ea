//! `stats.json`: what was drawn, with what, and how long it took.

use std::collections::BTreeMap;

use bevy::{
    camera::visibility::CascadesVisibleEntities,
    diagnostic::{Diagnostic, DiagnosticsStore},
    light::{CascadeShadowConfig, Cascades, DirectionalLightShadowMap, NotShadowCaster},
    prelude::*,
    reflect::serde::TypedReflectSerializer,
    render::{RenderApp, renderer::RenderAdapterInfo, sync_world::RenderEntity},
};
use serde::Serialize;
use wgpu::DeviceType;

use super::{
    films::FilmStats,
    virtual_map::{self, VirtualMapStats},
};

use crate::{
    level::shot::Shot,
    render::{caster::drawn, cost::draws_fallback_map},
    shadow::{
        checked::checked,
        layout::cells_per_side,
        settings::{MapResolution, ShadowPath},
        technique::Technique,
        views::SunViews,
    },
};

/// The file.
#[derive(Clone, Debug, Serialize)]
pub(in crate::cli) struct Stats {
    /// Version of Umbrage.
    umbrage: &'static str,
    /// What drew.
    adapter: Adapter,
    /// One per scene, shot and technique.
    pub(in crate::cli) takes: Vec<Take>,
}

/// The graphics adapter.
#[derive(Clone, Debug, Default, Serialize)]
pub(in crate::cli) struct Adapter {
    pub(in crate::cli) name: String,
    pub(in crate::cli) backend: String,
    driver: String,
    driver_info: String,
    device_type: String,
    /// The CPU draws: times say nothing about GPUs.
    pub(in crate::cli) is_software: bool,
}

impl Adapter {
    /// That of an app.
    pub(in crate::cli) fn of(app: &App) -> Self {
        let info = app.world().get_resource::<RenderAdapterInfo>();
        info.map_or_else(Self::default, |info| Self {
            name: info.name.clone(),
            backend: info.backend.to_string(),
            driver: info.driver.clone(),
            driver_info: info.driver_info.clone(),
            device_type: format!("{:?}", info.device_type),
            is_software: info.device_type == DeviceType::Cpu,
        })
    }
}

/// One scene, shot and technique.
#[derive(Clone, Debug, Serialize)]
pub(in crate::cli) struct Take {
    /// The scene's name.
    pub(in crate::cli) scene: String,
    /// The shot that was taken.
    pub(in crate::cli) shot: Shot,
    /// As it was given.
    pub(in crate::cli) technique: String,
    /// The shortest text that means the same.
    pub(in crate::cli) canonical_technique: String,
    /// Every setting of the technique; null for stock cascades.
    pub(in crate::cli) settings: serde_json::Value,
    /// Pass to file name.
    pub(in crate::cli) files: BTreeMap<&'static str, String>,
    /// Whether the picture stood still, bit for bit.
    pub(in crate::cli) is_still: bool,
    /// Whole frames in milliseconds, both worlds and the GPU, from the warm-up on; with the passes that were asked for.
    pub(in crate::cli) frame_ms: FrameTimes,
    /// Pass to milliseconds: medians over the same frames, on the GPU where it has timestamps and on the CPU that records
    /// them.
    pub(in crate::cli) pass_ms: BTreeMap<String, PassTimes>,
    /// Entities that cast shadows.
    pub(in crate::cli) casters: usize,
    /// Shadow maps.
    pub(in crate::cli) maps: Maps,
    /// Light views, near to far.
    pub(in crate::cli) light_views: Vec<View>,
    /// The tiles of a virtual map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) virtual_map: Option<VirtualMapStats>,
    /// The films of light planes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) films: Option<FilmStats>,
}

/// Times of whole frames.
#[derive(Clone, Debug, Default, Serialize)]
pub(in crate::cli) struct FrameTimes {
    median: f64,
    all: Vec<f64>,
}

impl FrameTimes {
    /// From seconds.
    pub(in crate::cli) fn new(seconds: &[f64]) -> Self {
        let all: Vec<f64> = seconds.iter().map(|seconds| seconds * 1e3).collect();
        Self {
            median: median(all.clone()),
            all,
        }
    }
}

/// The upper one of two; 0 for none.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// Times of one pass.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(in crate::cli) struct PassTimes {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) gpu: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::cli) cpu: Option<f64>,
}

/// Forgets the times of passes so far.
pub(in crate::cli) fn forget_pass_times(app: &mut App) {
    if let Some(mut store) = app.world_mut().get_resource_mut::<DiagnosticsStore>() {
        store.iter_mut().for_each(Diagnostic::clear_history);
    }
}

/// The times of passes since they were last forgotten.
pub(in crate::cli) fn pass_times(app: &App) -> BTreeMap<String, PassTimes> {
    let mut passes: BTreeMap<String, PassTimes> = BTreeMap::new();
    for (name, processor, values) in pass_samples(app) {
        let times = passes.entry(name).or_default();
        let median = Some(median(values));
        match processor {
            Processor::Gpu => times.gpu = median,
            Processor::Cpu => times.cpu = median,
        }
    }
    passes
}

/// What a time was taken on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::cli) enum Processor {
    /// The GPU that draws a pass.
    Gpu,
    /// The CPU that records it.
    Cpu,
}

/// Every pass's times in milliseconds since they were last forgotten.
pub(in crate::cli) fn pass_samples(app: &App) -> Vec<(String, Processor, Vec<f64>)> {
    let store = app.world().get_resource::<DiagnosticsStore>();
    let sample = |diagnostic: &Diagnostic| {
        let components: Vec<&str> = diagnostic.path().components().collect();
        let ["render", names @ .., of] = components.as_slice() else {
            return None;
        };
        let processor = match *of {
            "elapsed_gpu" => Processor::Gpu,
            "elapsed_cpu" => Processor::Cpu,
            _ => return None,
        };
        let values: Vec<f64> = diagnostic.values().copied().collect();
        (!values.is_empty()).then(|| (names.join("/"), processor, values))
    };
    let diagnostics = store.into_iter().flat_map(DiagnosticsStore::iter);
    diagnostics.filter_map(sample).collect()
}

/// Memory of shadow maps: 32-bit depth.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(in crate::cli) struct Maps {
    /// Maps of the technique; of face partitions as many as the light may need, of a virtual map its tiles.
    pub(super) count: u32,
    /// Texels per side of each; on average, where they are balanced; of a virtual map as a whole at its finest tile.
    pub(super) size: u32,
    /// Texels per side of the fallback map; 0: none.
    pub(super) fallback_size: u32,
    /// Texels of all of them: what a frame clears and draws into.
    pub(in crate::cli) texels: u64,
    /// Bytes of all of them that are alive at once.
    pub(super) bytes: u64,
}

impl Maps {
    fn new(count: u32, size: u32, fallback_size: u32) -> Self {
        let square = |side: u32| u64::from(side) * u64::from(side);
        let texels = u64::from(count) * square(size) + square(fallback_size);
        Self {
            count,
            size,
            fallback_size,
            texels,
            bytes: texels * size_of::<f32>() as u64,
        }
    }

    /// Texels of all maps.
    pub(super) fn texels(&self) -> u64 {
        self.texels
    }
}

/// One light view.
#[derive(Clone, Debug, Serialize)]
pub(in crate::cli) struct View {
    /// View depths in metres.
    near_depth: f32,
    far_depth: f32,
    /// Mean side of a texel in metres.
    texel_size: f32,
    /// Taken from the depth of casters on the drop-in path, in units of the depth range.
    caster_depth_bias: f32,
    /// Casters that were drawn into it.
    pub(in crate::cli) casters_drawn: usize,
    /// Texels across and along the map's axes.
    map_size: [u32; 2],
    /// Column by column.
    clip_from_world: [f32; 16],
}

impl Stats {
    /// Without takes.
    pub(in crate::cli) fn new(app: &App) -> Self {
        Self {
            umbrage: env!("CARGO_PKG_VERSION"),
            adapter: Adapter::of(app),
            takes: Vec::new(),
        }
    }
}

/// Every field of the settings, by its name in the code.
pub(in crate::cli) fn settings_of(app: &App, technique: &Technique) -> serde_json::Value {
    let Technique::Umbrage(settings) = technique else {
        return serde_json::Value::Null;
    };
    let registry = app.world().resource::<AppTypeRegistry>().read();
    serde_json::to_value(TypedReflectSerializer::new(settings, &registry)).unwrap_or_default()
}

/// Entities with a mesh that casts shadows.
pub(in crate::cli) fn count_casters(app: &mut App) -> usize {
    let world = app.world_mut();
    world
        .query_filtered::<(), (With<Mesh3d>, Without<NotShadowCaster>)>()
        .iter(world)
        .count()
}

/// Texels per side of Bevy's own maps.
fn bevy_map_size(world: &World) -> u32 {
    let map = world.get_resource::<DirectionalLightShadowMap>();
    map.map_or(0, |map| u32::try_from(map.size).unwrap_or(u32::MAX))
}

/// The maps of a technique.
pub(in crate::cli) fn maps_of(app: &App, sun: Entity, camera: Entity, technique: &Technique) -> Maps {
    let bevy_size = bevy_map_size(app.world());
    match technique {
        Technique::Bevy(_) => {
            let config = app.world().get::<CascadeShadowConfig>(sun);
            let count = config.map_or(0, |config| u32::try_from(config.bounds.len()).unwrap_or(u32::MAX));
            Maps::new(count, bevy_size, 0)
        }
        Technique::Umbrage(settings) => {
            let (settings, _) = checked(settings);
            let has_fallback = settings.path == ShadowPath::Full && draws_fallback(app, camera);
            let fallback_size = if has_fallback { bevy_size } else { 0 };
            if let Some(report) = virtual_map::report_of(app, camera) {
                return virtual_map::maps_of(&report, fallback_size);
            }
            let count = match &settings.light_planes {
                // All films lie in one square.
                Some(_) if settings.path == ShadowPath::Full => 1,
                Some(planes) => planes.frusta,
                None => settings.partitions.maps(),
            };
            let maps = match settings.partitions.resolution {
                MapResolution::Equal => Maps::new(count, settings.map_size, fallback_size),
                // All cells of the grid, whoever uses them.
                MapResolution::Balanced => Maps::new(cells_per_side(count).pow(2), settings.map_size, fallback_size),
            };
            Maps { count, ..maps }
        }
    }
}

/// Whether the frame just drawn has Bevy's fallback map besides.
pub(in crate::cli) fn draws_fallback(app: &App, camera: Entity) -> bool {
    let render_camera = app.get_sub_app(RenderApp).zip(render_entity(app, camera));
    render_camera.is_some_and(|(render_app, camera)| draws_fallback_map(render_app.world(), camera))
}

/// Casters drawn into each light view of a camera in the frame just drawn.
fn casters_drawn(app: &App, sun: Entity, camera: Entity, technique: &Technique) -> Vec<usize> {
    let world = app.world();
    match technique {
        Technique::Umbrage(settings) if settings.path == ShadowPath::Full => {
            let (Some(render_app), Some(camera)) = (app.get_sub_app(RenderApp), render_entity(app, camera)) else {
                return Vec::new();
            };
            drawn::casters_drawn(render_app.world(), camera)
                .map(|counts| counts.into_iter().map(|count| count as usize).collect())
                .unwrap_or_default()
        }
        _ => bevy_casters(world, sun, camera),
    }
}

/// Casters that Bevy drew into each cascade for a camera: those that it finds visible in it.
pub(in crate::cli) fn bevy_casters(world: &World, sun: Entity, camera: Entity) -> Vec<usize> {
    world
        .get::<CascadesVisibleEntities>(sun)
        .and_then(|visible| visible.entities.get(&camera))
        .map(|cascades| cascades.iter().map(|cascade| cascade.entities.len()).collect())
        .unwrap_or_default()
}

/// An entity's twin in the render world.
pub(in crate::cli) fn render_entity(app: &App, entity: Entity) -> Option<Entity> {
    app.world().get::<RenderEntity>(entity).map(RenderEntity::id)
}

/// The light views of a camera in the frame just drawn.
pub(in crate::cli) fn views_of(app: &App, sun: Entity, camera: Entity, technique: &Technique) -> Vec<View> {
    let world = app.world();
    let mut views = matrices_of(world, sun, camera, technique);
    let counts = casters_drawn(app, sun, camera, technique);
    match &mut views[..] {
        // All tiles are of one light view.
        [view] => view.casters_drawn = counts.iter().sum(),
        views => {
            for (view, count) in views.iter_mut().zip(counts) {
                view.casters_drawn = count;
            }
        }
    }
    views
}

fn matrices_of(world: &World, sun: Entity, camera: Entity, technique: &Technique) -> Vec<View> {
    match technique {
        Technique::Bevy(_) => {
            let (Some(cascades), Some(config)) = (
                world
                    .get::<Cascades>(sun)
                    .and_then(|cascades| cascades.cascades.get(&camera)),
                world.get::<CascadeShadowConfig>(sun),
            ) else {
                return Vec::new();
            };
            let nears = std::iter::once(config.minimum_distance).chain(
                config
                    .bounds
                    .iter()
                    .map(|bound| bound * (1.0 - config.overlap_proportion)),
            );
            cascades
                .iter()
                .zip(nears.zip(&config.bounds))
                .map(|(cascade, (near_depth, far_depth))| View {
                    near_depth,
                    far_depth: *far_depth,
                    texel_size: cascade.texel_size,
                    caster_depth_bias: 0.0,
                    casters_drawn: 0,
                    map_size: [bevy_map_size(world); 2],
                    clip_from_world: cascade.clip_from_world.to_cols_array(),
                })
                .collect()
        }
        Technique::Umbrage(_) => {
            let views = world.get::<SunViews>(sun).and_then(|views| views.cameras.get(&camera));
            views
                .into_iter()
                .flat_map(|views| &views.partitions)
                .map(|partition| View {
                    near_depth: partition.light_view.near_depth,
                    far_depth: partition.light_view.far_depth,
                    texel_size: partition.light_view.texel_size,
                    caster_depth_bias: partition.light_view.caster_depth_bias,
                    casters_drawn: 0,
                    map_size: partition.light_view.atlas_rect.zw().to_array(),
                    clip_from_world: partition.light_view.clip_from_world.to_cols_array(),
                })
                .collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_counts_the_fallback_map() {
        assert_eq!(Maps::new(4, 2048, 0).bytes, 64 << 20);
        assert_eq!(Maps::new(4, 2048, 2048).bytes, 80 << 20);
    }

    #[test]
    fn the_median_is_not_the_mean() {
        assert_eq!(FrameTimes::new(&[0.001, 0.1, 0.002]).median, 2.0);
        assert_eq!(FrameTimes::new(&[]).median, 0.0);
    }
}
