//! `stats.json`: what was drawn, with what, and how long it took.

use std::collections::BTreeMap;

use bevy::{
    light::{CascadeShadowConfig, Cascades, DirectionalLightShadowMap, NotShadowCaster},
    prelude::*,
    reflect::serde::TypedReflectSerializer,
    render::renderer::RenderAdapterInfo,
};
use serde::Serialize;

use crate::{
    level::shot::Shot,
    shadow::{settings::ShadowPath, technique::Technique, views::SunViews},
};

/// The file.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Stats {
    /// Version of Umbrage.
    umbrage: &'static str,
    /// What drew.
    adapter: Adapter,
    /// One per scene, shot and technique.
    pub(super) takes: Vec<Take>,
}

/// The graphics adapter.
#[derive(Clone, Debug, Default, Serialize)]
struct Adapter {
    name: String,
    backend: String,
    driver: String,
    driver_info: String,
    device_type: String,
}

/// One scene, shot and technique.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Take {
    /// The scene's name.
    pub(super) scene: String,
    /// The shot that was taken.
    pub(super) shot: Shot,
    /// As it was given.
    pub(super) technique: String,
    /// The shortest text that means the same.
    pub(super) canonical_technique: String,
    /// Every setting of the technique; null for stock cascades.
    pub(super) settings: serde_json::Value,
    /// Pass to file name.
    pub(super) files: BTreeMap<&'static str, String>,
    /// Whether the picture stood still, bit for bit.
    pub(super) is_still: bool,
    /// Whole frames in milliseconds, both worlds and the GPU, from the warm-up on; with the passes that were asked for.
    pub(super) frame_ms: FrameTimes,
    /// Entities that cast shadows.
    pub(super) casters: usize,
    /// Shadow maps.
    pub(super) maps: Maps,
    /// Light views, near to far.
    pub(super) light_views: Vec<View>,
}

/// Times of whole frames.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct FrameTimes {
    median: f64,
    all: Vec<f64>,
}

impl FrameTimes {
    /// From seconds.
    pub(super) fn new(seconds: &[f64]) -> Self {
        let all: Vec<f64> = seconds.iter().map(|seconds| seconds * 1e3).collect();
        let mut sorted = all.clone();
        sorted.sort_by(f64::total_cmp);
        Self {
            median: sorted.get(sorted.len() / 2).copied().unwrap_or(0.0),
            all,
        }
    }
}

/// Memory of shadow maps: 32-bit depth.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Maps {
    /// Maps of the technique.
    count: u32,
    /// Texels per side of each.
    size: u32,
    /// Texels per side of the fallback map; 0: none.
    fallback_size: u32,
    /// All of them.
    bytes: u64,
}

impl Maps {
    fn new(count: u32, size: u32, fallback_size: u32) -> Self {
        let square = |side: u32| u64::from(side) * u64::from(side);
        Self {
            count,
            size,
            fallback_size,
            bytes: (u64::from(count) * square(size) + square(fallback_size)) * size_of::<f32>() as u64,
        }
    }
}

/// One light view.
#[derive(Clone, Debug, Serialize)]
pub(super) struct View {
    /// View depths in metres.
    near_depth: f32,
    far_depth: f32,
    /// Mean side of a texel in metres.
    texel_size: f32,
    /// Taken from the depth of casters on the drop-in path, in units of the depth range.
    caster_depth_bias: f32,
    /// Column by column.
    clip_from_world: [f32; 16],
}

impl Stats {
    /// Without takes.
    pub(super) fn new(app: &App) -> Self {
        let info = app.world().get_resource::<RenderAdapterInfo>();
        Self {
            umbrage: env!("CARGO_PKG_VERSION"),
            adapter: info.map_or_else(Adapter::default, |info| Adapter {
                name: info.name.clone(),
                backend: info.backend.to_string(),
                driver: info.driver.clone(),
                driver_info: info.driver_info.clone(),
                device_type: format!("{:?}", info.device_type),
            }),
            takes: Vec::new(),
        }
    }
}

/// Every field of the settings, by its name in the code.
pub(super) fn settings_of(app: &App, technique: &Technique) -> serde_json::Value {
    let Technique::Umbrage(settings) = technique else {
        return serde_json::Value::Null;
    };
    let registry = app.world().resource::<AppTypeRegistry>().read();
    serde_json::to_value(TypedReflectSerializer::new(settings, &registry)).unwrap_or_default()
}

/// Entities with a mesh that casts shadows.
pub(super) fn count_casters(app: &mut App) -> usize {
    let world = app.world_mut();
    world
        .query_filtered::<(), (With<Mesh3d>, Without<NotShadowCaster>)>()
        .iter(world)
        .count()
}

/// The maps of a technique.
pub(super) fn maps_of(app: &App, sun: Entity, technique: &Technique) -> Maps {
    let bevy_size = app
        .world()
        .get_resource::<DirectionalLightShadowMap>()
        .map_or(0, |map| u32::try_from(map.size).unwrap_or(u32::MAX));
    match technique {
        Technique::Bevy => {
            let config = app.world().get::<CascadeShadowConfig>(sun);
            let count = config.map_or(0, |config| u32::try_from(config.bounds.len()).unwrap_or(u32::MAX));
            Maps::new(count, bevy_size, 0)
        }
        Technique::Umbrage(settings) => {
            let has_fallback = settings.path == ShadowPath::Full && settings.fallback_map;
            Maps::new(
                settings.partitions.count,
                settings.map_size,
                if has_fallback { bevy_size } else { 0 },
            )
        }
    }
}

/// The light views of a camera in the frame just drawn.
pub(super) fn views_of(app: &App, sun: Entity, camera: Entity, technique: &Technique) -> Vec<View> {
    let world = app.world();
    match technique {
        Technique::Bevy => {
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
