//! [`VirtualMapReports`]: what the virtual maps of a frame were, for both worlds.

use std::{
    cmp::Reverse,
    sync::{Arc, Mutex},
};

use bevy::{ecs::entity::EntityHashMap, prelude::*};

use super::{fitted::plan::FittedCounts, tiles::TileDraw};
use crate::maths::virtual_map::queried::{Decision, TileReport};

/// The virtual map of one camera in the last frame that was recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VirtualMapReport {
    /// In the order in which they were applied: later ones overwrite earlier ones.
    pub tiles: Vec<DrawnTile>,
    /// Bytes of tile textures alive at once.
    pub texture_bytes: u64,
    /// Bytes of what else the map needs on the GPU: the old result, reports and read-back, without draws and the result.
    pub buffer_bytes: u64,
    /// Splits of a queried map: k of 1 + 4 k + l tiles.
    pub splits: u32,
    /// Jumps of a queried map: l.
    pub jumps: u32,
    /// Read-backs that the frame waited for.
    pub read_backs: u32,
    /// What a fitted map measured.
    pub fitted: Option<FittedCounts>,
}

/// A tile as it was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnTile {
    /// Place, texels and pixels.
    pub draw: TileDraw,
    /// What applying it did, where that was counted.
    pub report: Option<TileReport>,
    /// What became of it, for queried maps; `None` after jumps and for other maps.
    pub decision: Option<Decision>,
}

impl VirtualMapReport {
    /// Texels drawn, margins included.
    pub fn texels(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.draw.window.texels()).sum()
    }

    /// Texels per axis of one map with the resolution of the finest tile.
    pub fn effective_resolution(&self) -> u64 {
        let sides = self.tiles.iter().map(|drawn| {
            let texels = drawn.draw.tile.counts.as_u64vec2() * drawn.draw.window.core().as_u64vec2();
            texels.max_element()
        });
        sides.max().unwrap_or(0)
    }

    /// Texels of tiles, margins included, and how many tiles have them; the largest first.
    pub fn sizes(&self) -> Vec<(UVec2, usize)> {
        let mut sizes: Vec<UVec2> = self.tiles.iter().map(|tile| tile.draw.window.size).collect();
        sizes.sort_by_key(|size| Reverse((size.element_product(), size.x)));
        let groups = sizes.chunk_by(|a, b| a == b);
        groups.map(|group| (group[0], group.len())).collect()
    }
}

/// The reports of the last frame, by camera of the main world. Shared: the render world writes, both may read.
#[derive(Resource, Clone, Debug, Default)]
pub struct VirtualMapReports(Arc<Mutex<EntityHashMap<VirtualMapReport>>>);

impl VirtualMapReports {
    /// The report of a camera; `None` if it has no virtual map.
    pub fn get(&self, camera: Entity) -> Option<VirtualMapReport> {
        self.0.lock().ok()?.get(&camera).cloned()
    }

    /// Replaces the report of a camera.
    pub(super) fn set(&self, camera: Entity, report: VirtualMapReport) {
        if let Ok(mut reports) = self.0.lock() {
            reports.insert(camera, report);
        }
    }

    /// Keeps those of some cameras only.
    pub(super) fn retain(&self, is_kept: impl Fn(Entity) -> bool) {
        if let Ok(mut reports) = self.0.lock() {
            reports.retain(|camera, _| is_kept(*camera));
        }
    }
}
