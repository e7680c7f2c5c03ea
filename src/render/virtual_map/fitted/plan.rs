//! From measured needs to tiles: [`FittedFrame`].

use std::time::{Duration, Instant};

use bevy::prelude::*;

use super::{
    measure::Measurement,
    parameters::{PictureCamera, need_parameters},
};
use crate::{
    maths::virtual_map::{
        feedback::PictureMotion,
        fitted::{FittedMap, FittedPlan, FittedTile},
        grid::GridOptions,
        mapping::MappingOptions,
        memory::TextureMode,
        picture::PixelRect,
        tile::TileWindow,
    },
    render::{gpu_types::NeedParameters, virtual_map::tiles::TileDraw},
    shadow::{
        fitted::{FittedMaps, NeedFeedback, NeedMapping},
        views::LightView,
    },
};

/// What a frame asks for: everything that the tiles depend on besides the depths of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedRequest {
    /// Settings.
    pub settings: FittedMaps,
    /// The same as tiles that fit the memory.
    pub map: FittedMap,
    /// The light view of the whole map.
    pub light_view: LightView,
    /// Its index: the z-partition that the map is for.
    pub partition: u32,
    /// View depths in metres of the pixels that look into the map: from the first one up to, without, the second.
    pub depths: [f32; 2],
    /// Whose picture.
    pub camera: PictureCamera,
    /// Whether other pictures look into the map, too: those of fading levels and of transparent layers.
    pub has_more_pictures: bool,
}

impl FittedRequest {
    /// What the pass measures. A mapping map holds the needs of one picture: where there are more, all pixels are collected.
    pub fn measurement(&self) -> Measurement {
        let mapping = if self.has_more_pictures {
            NeedMapping::Full
        } else {
            self.settings.mapping
        };
        let settings = FittedMaps {
            mapping,
            ..self.settings.clone()
        };
        Measurement::new(&settings, self.camera.size, self.map.grid_tiles_per_axis())
    }

    /// The motion that needs have to hold for; `None` within the same frame.
    fn motion(&self) -> Option<PictureMotion> {
        match self.settings.feedback {
            NeedFeedback::SameFrame => None,
            NeedFeedback::NextFrame { step, turn } => {
                let (step, turn) = (f64::from(step), f64::from(turn).to_radians());
                self.camera.motion(step, turn)
            }
        }
    }

    /// What the shaders read.
    pub fn parameters(&self) -> NeedParameters {
        let measurement = self.measurement();
        let options = MappingOptions {
            motion: self.motion(),
            ..self.settings.mapping_options()
        };
        need_parameters(
            &self.camera,
            self.light_view.clip_from_world,
            self.depths,
            &options,
            measurement.map_size,
            measurement.cells,
        )
    }

    /// How the grid is made of what was measured. Needs of an earlier frame: rectangles grow by what may move over the
    /// picture, and cells in which nothing was seen get one tile's worth of the resolution of a single map.
    fn grid_options(&self) -> GridOptions {
        let options = self.settings.grid_options(self.map.grid_tiles_per_axis());
        let Some(motion) = self.motion() else {
            return options;
        };
        let flow = motion.flow(f64::from(self.light_view.near_depth)).ceil();
        GridOptions {
            rect_guard: flow.min(f64::from(u32::MAX)) as u32,
            floor_level: Some(self.map.tile_size_max.max(1).ilog2() as u8),
            ..options
        }
    }

    /// Whether the needs of an earlier frame hold for this one: the same picture and settings, and a camera within the
    /// motion.
    pub fn is_served_by(&self, earlier: &Self) -> bool {
        let NeedFeedback::NextFrame { step, turn } = earlier.settings.feedback else {
            return false;
        };
        let [moved, turned] = self.camera.moved_since(&earlier.camera);
        self.settings == earlier.settings
            && self.map == earlier.map
            && (self.camera.size, self.camera.origin) == (earlier.camera.size, earlier.camera.origin)
            && self.camera.clip_from_view == earlier.camera.clip_from_view
            && moved <= f64::from(step)
            // Angles from matrices in single precision are off by a ten-thousandth of a radian.
            && turned <= f64::from(turn).to_radians() + 2.0e-4
    }

    /// The tiles for what was measured. `read_back`: how long that took. `None` when the GPU's words are no grid.
    pub fn plan(&self, contents: &[Vec<u8>], read_back: Duration) -> Option<FittedFrame> {
        let started = Instant::now();
        let (grid, totals) = self.measurement().grid(contents, &self.grid_options())?;
        let plan = self.map.plan(&grid);
        let counts = FittedCounts {
            pixels: totals.pixels(),
            capped: totals.pixels_above(plan.cap),
            outside: u64::from(totals.outside),
            discarded: u64::from(grid.discarded),
            cells: grid.tiles_per_axis(),
            read_back,
            planning: started.elapsed(),
            buffer_bytes: 0,
        };
        Some(FittedFrame {
            request: self.clone(),
            plan,
            counts,
        })
    }
}

/// The tiles of one map in this frame.
#[derive(Clone, Debug)]
pub struct FittedFrame {
    /// What was asked for in the frame in which the needs were measured: the tiles are cut from *its* light view.
    pub request: FittedRequest,
    /// The tiles.
    pub plan: FittedPlan,
    /// What was counted.
    pub counts: FittedCounts,
}

impl FittedFrame {
    /// The tiles as they are drawn: in the target's pixels, and with the textures of the size mode.
    pub fn tile_draws(&self) -> Vec<TileDraw> {
        let FittedRequest {
            map, camera, settings, ..
        } = &self.request;
        let mode = settings.texture_mode;
        let draw = |tile: &FittedTile| {
            let window = match mode {
                TextureMode::Full => TileWindow::around(UVec2::splat(map.tile_size_max), map.margin),
                _ => tile.window,
            };
            TileDraw {
                light_view: self.request.partition,
                tile: tile.tile,
                window,
                texture: mode.texture_size(&window, map.largest_texture()),
                rect: PixelRect {
                    min: tile.rect.min + camera.origin,
                    max: tile.rect.max + camera.origin,
                },
            }
        };
        self.plan.tiles.iter().map(draw).collect()
    }

    /// Textures to have: of a series of squares all up to the largest tile, so that most stay from frame to frame; exact ones
    /// as tiles need them.
    pub fn texture_sizes(&self) -> Vec<UVec2> {
        let map = &self.request.map;
        match self.request.settings.texture_mode {
            TextureMode::Full | TextureMode::Corner => vec![UVec2::splat(map.largest_texture())],
            TextureMode::SquareSeries => {
                let sides = self.plan.tiles.iter().map(|tile| tile.window.core().max_element());
                let largest = sides.max().unwrap_or_default().max(map.tile_size_min);
                let cores = (0..32).map(|level| 1_u32 << level);
                let cores = cores.filter(|core| (map.tile_size_min..=largest).contains(core));
                cores.map(|core| UVec2::splat(core + 2 * map.margin)).collect()
            }
            TextureMode::Exact => self.plan.tiles.iter().map(|tile| tile.window.size).collect(),
        }
    }
}

/// On a camera's render entity: its maps in this frame, one per z-partition, nearest first.
#[derive(Component, Clone, Debug)]
pub struct FittedFrames(pub Vec<FittedFrame>);

impl FittedFrames {
    /// What was counted in all of them. They were read back together.
    pub fn counts(&self) -> FittedCounts {
        let mut all = self.0.iter().map(|frame| frame.counts);
        let first = all.next().unwrap_or_default();
        all.fold(first, |sum, counts| FittedCounts {
            pixels: sum.pixels + counts.pixels,
            capped: sum.capped + counts.capped,
            outside: sum.outside + counts.outside,
            discarded: sum.discarded + counts.discarded,
            cells: sum.cells.max(counts.cells),
            read_back: sum.read_back.max(counts.read_back),
            planning: sum.planning + counts.planning,
            buffer_bytes: sum.buffer_bytes + counts.buffer_bytes,
        })
    }
}

/// What the measurement of a frame found and cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FittedCounts {
    /// Pixels (texels of a mapping map) that look into the map.
    pub pixels: u64,
    /// Those that need more than the finest tiles have.
    pub capped: u64,
    /// Those whose surface lies beside the map: lit.
    pub outside: u64,
    /// At most so many were left out by the discard rule.
    pub discarded: u64,
    /// n of the grid.
    pub cells: u32,
    /// Waiting for the GPU.
    pub read_back: Duration,
    /// Grid, pyramid and tiles on the CPU.
    pub planning: Duration,
    /// Memory of buffers besides tile textures.
    pub buffer_bytes: u64,
}

impl FittedCounts {
    /// Share in percent of the pixels in the map that need more than the finest tiles have.
    pub fn capped_percent(&self) -> f64 {
        100.0 * self.capped as f64 / self.pixels.max(1) as f64
    }

    /// Share in percent of all pixels whose surface lies beside the map.
    pub fn outside_percent(&self) -> f64 {
        100.0 * self.outside as f64 / (self.pixels + self.outside).max(1) as f64
    }
}
