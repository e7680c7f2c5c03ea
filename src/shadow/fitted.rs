//! [`FittedMaps`]: settings of a fitted virtual map (Giegl 2007, chapter 5).

use std::ops::RangeInclusive;

use bevy::prelude::*;

use super::virtual_maps::{DEFAULT_MEMORY, MEMORY};
use crate::maths::virtual_map::{
    fitted::FittedMap,
    grid::GridOptions,
    mapping::{MappingOptions, NeedMeasure, NeighbourPick},
    memory::TextureMode,
};

/// A virtual map whose tiles are as fine as the picture needs them: the depths of every frame say where the map is looked
/// up and how finely, and only such tiles are drawn.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub struct FittedMaps {
    /// ξ: levels taken off every need, −4..=5. 0, the default: texels of at most a pixel. Each level down halves the side
    /// of texels and asks for up to four times as many of them, each level up the other way.
    pub quality_drop: i32,
    /// n: most tiles per axis at ξ = 0, a power of two, 1..=64; default 32. With `tile_size_max` it bounds the finest
    /// resolution, n · `tile_size_max`: pixels that need more are *capped*, and counted.
    pub tiles_per_axis: u32,
    /// Largest side of a tile in texels, a power of two, 64..=8192; default 4096. Does not fit the tile memory with
    /// filters that need a margin: tiles become half as large then and twice as many per axis.
    pub tile_size_max: u32,
    /// How the picture is sampled.
    pub mapping: NeedMapping,
    /// Which neighbour gives the slope of a pixel's surface; default the one that differs less, which is safe.
    pub pick: NeighbourPick,
    /// How a pixel's place in the map becomes a need; default the sides of a texel, exact in any direction.
    pub measure: NeedMeasure,
    /// Share of a cell's pixels whose needs may be ignored, 0..=1, on each axis; default 0. 0.005 saves texels where a few
    /// pixels graze the light. Costs a histogram of 256 bytes per cell.
    pub discard: f32,
    /// Which texture shows a tile; default a square of the tile's longer side. Changes no bit of the picture.
    pub texture_mode: TextureMode,
    /// What drawing one more tile costs, in texels: the plan with the least texels + cost · tiles is drawn. Default 65 536.
    /// `None`: split only where a tile's need exceeds the largest texture, as in the thesis; fewest tiles, most texels.
    pub tile_cost: Option<u32>,
    /// Which needs the tiles of a frame come from.
    pub feedback: NeedFeedback,
    /// MiB of tile textures alive at once, 1..=4096; default 64. Half of it is kept for casters that fade where there are
    /// levels of detail. Where the largest tile needs more, tiles are smaller and more.
    pub memory: u32,
}

/// How the picture is sampled for its needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum NeedMapping {
    /// Every pixel, by a compute pass that collects needs in a grid on the GPU. Only the grid is read back: 28 bytes per
    /// cell.
    #[default]
    Full,
    /// One pixel in many, into a mapping map that is read back whole; the grid is made on the CPU. The thesis's way, for
    /// comparison: pixels between the samples may find no tile. While levels fade, and with transparent layers, all pixels
    /// are collected.
    Low {
        /// Texels per side of the mapping map, 16..=1024; 256 in the thesis.
        size: u32,
        /// Four bytes per texel as in the thesis, in place of numbers.
        bytes: bool,
    },
}

/// Which needs the tiles of a frame come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
pub enum NeedFeedback {
    /// Those of the same frame: the CPU waits for the GPU in the middle of every frame. Exact, and the reference.
    #[default]
    SameFrame,
    /// Those of the frame before, made large enough for every camera within a motion; without waiting in the frame. What
    /// comes into view is coarse for a frame, and lit where the earlier map does not reach. Faster motion than this falls
    /// back to the same frame.
    NextFrame {
        /// Metres per frame, 0..=10; default 0.1.
        step: f32,
        /// Degrees per frame, 0..=45; default 1.
        turn: f32,
    },
}

impl NeedFeedback {
    /// Metres per frame that a running player stays within at 60 frames per second.
    pub const STEP: f32 = 0.1;
    /// Degrees per frame that a player who looks around stays within, mostly.
    pub const TURN: f32 = 1.0;
}

impl Default for FittedMaps {
    fn default() -> Self {
        Self {
            quality_drop: 0,
            tiles_per_axis: 32,
            tile_size_max: 4096,
            mapping: NeedMapping::Full,
            pick: NeighbourPick::Smaller,
            measure: NeedMeasure::Sides,
            discard: 0.0,
            texture_mode: TextureMode::SquareSeries,
            tile_cost: Some(65_536),
            feedback: NeedFeedback::SameFrame,
            memory: DEFAULT_MEMORY,
        }
    }
}

impl FittedMaps {
    /// Values of `quality_drop`.
    pub const QUALITY_DROPS: RangeInclusive<i32> = -4..=5;
    /// Values of `tiles_per_axis`.
    pub const TILES_PER_AXIS: RangeInclusive<u32> = 1..=64;
    /// Values of `tile_size_max`.
    pub const TILE_SIZES: RangeInclusive<u32> = 64..=8192;
    /// Texels per side of a mapping map.
    pub const MAP_SIZES: RangeInclusive<u32> = 16..=1024;

    /// Texels per axis of the whole map at its finest.
    #[must_use]
    pub fn texels_per_axis(&self) -> u32 {
        let finer = self.quality_drop.saturating_neg().clamp(0, 8);
        self.tiles_per_axis
            .saturating_mul(self.tile_size_max)
            .saturating_mul(1 << finer)
    }

    /// Brings all numbers into range.
    pub(super) fn clamp(&mut self) {
        let power = |value: u32, range: RangeInclusive<u32>| {
            let value = value.clamp(*range.start(), *range.end());
            1 << value.ilog2()
        };
        self.quality_drop = self
            .quality_drop
            .clamp(*Self::QUALITY_DROPS.start(), *Self::QUALITY_DROPS.end());
        self.tiles_per_axis = power(self.tiles_per_axis, Self::TILES_PER_AXIS);
        self.tile_size_max = power(self.tile_size_max, Self::TILE_SIZES);
        self.memory = self.memory.clamp(*MEMORY.start(), *MEMORY.end());
        // NaN discards nothing.
        self.discard = self.discard.max(0.0).min(1.0);
        if let NeedMapping::Low { size, .. } = &mut self.mapping {
            *size = (*size).clamp(*Self::MAP_SIZES.start(), *Self::MAP_SIZES.end());
        }
        if let NeedFeedback::NextFrame { step, turn } = &mut self.feedback {
            // NaN is no motion.
            *step = step.max(0.0).min(10.0);
            *turn = turn.max(0.0).min(45.0);
        }
    }

    /// Tiles for a filter that reads `margin` texels beyond them, small enough for some bytes of tile textures. `None` if
    /// not even the smallest fit.
    pub fn map(&self, margin: u32, budget_bytes: u64) -> Option<FittedMap> {
        let map = FittedMap {
            quality_drop: self.quality_drop,
            tiles_per_axis: self.tiles_per_axis,
            tile_size_max: self.tile_size_max,
            margin,
            tile_cost: self.tile_cost,
            ..FittedMap::default()
        };
        map.within(budget_bytes)
    }

    /// How needs are measured, for a still camera.
    pub fn mapping_options(&self) -> MappingOptions {
        let is_listed = matches!(self.mapping, NeedMapping::Low { bytes: true, .. });
        MappingOptions {
            measure: self.measure,
            pick: self.pick,
            wide_steps: is_listed,
            bytes: is_listed,
            ..MappingOptions::default()
        }
    }

    /// How needs are collected in a grid of `cells` per axis.
    pub fn grid_options(&self, cells: u32) -> GridOptions {
        GridOptions {
            tiles_per_axis: cells,
            discard_fraction: f64::from(self.discard),
            ..GridOptions::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_in_range_and_others_are_brought_there() {
        let mut settings = FittedMaps::default();
        settings.clamp();
        assert_eq!(settings, FittedMaps::default());
        assert_eq!(settings.texels_per_axis(), 131_072);
        let mut settings = FittedMaps {
            quality_drop: -9,
            tiles_per_axis: 33,
            tile_size_max: 100_000,
            mapping: NeedMapping::Low { size: 3, bytes: true },
            discard: f32::NAN,
            memory: 0,
            feedback: NeedFeedback::NextFrame {
                step: f32::NAN,
                turn: 90.0,
            },
            ..FittedMaps::default()
        };
        settings.clamp();
        assert_eq!(
            (settings.quality_drop, settings.tiles_per_axis, settings.tile_size_max),
            (-4, 32, 8192)
        );
        assert_eq!(
            (settings.mapping, settings.discard),
            (NeedMapping::Low { size: 16, bytes: true }, 0.0)
        );
        assert_eq!(
            (settings.memory, settings.feedback),
            (1, NeedFeedback::NextFrame { step: 0.0, turn: 45.0 })
        );
    }

    #[test]
    fn tiles_with_margins_fit_the_memory() {
        let settings = FittedMaps::default();
        let of = |margin, memory: u64| settings.map(margin, memory << 20);
        let hard = of(0, 64).expect("64 MiB hold 4096²");
        assert_eq!((hard.tile_size_max, hard.tiles_per_axis), (4096, 32));
        let filtered = of(1, 64).expect("64 MiB hold 2050²");
        assert_eq!((filtered.tile_size_max, filtered.tiles_per_axis), (2048, 64));
        let small = of(1, 1).map(|map| (map.tile_size_max, map.tiles_per_axis));
        assert_eq!(small, Some((256, 512)));
        assert_eq!(of(1, 0), None);
    }
}
