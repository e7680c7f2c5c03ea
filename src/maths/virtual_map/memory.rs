//! Textures of tiles: size modes (Giegl, section 5.12), waves under a bound of memory, and what to do when a bound is
//! too small.

use std::ops::Range;

use bevy_math::UVec2;

use super::{
    fitted::{FittedMap, FittedPlan},
    grid::NeedGrid,
    queried::QueriedMap,
    tile::TileWindow,
    tiled::TiledMap,
};

/// Bytes of a texel of 32-bit depth.
pub const BYTES_PER_TEXEL: u64 = 4;

/// Tile textures alive at once by default: 64 MiB, one of 4096².
pub const DEFAULT_BUDGET: u64 = 64 << 20;

/// Most tiles per axis of a tiled map whose tiles are small for want of memory.
pub const MOST_TILES_PER_AXIS: u32 = 256;

/// Which texture shows a tile of w × h texels; in the order of the thesis's numbers 0 to 3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum TextureMode {
    /// 0: the largest texture, filled: every tile is drawn with s_max² texels.
    Full,
    /// 1: a rectangle of w × h in the largest texture.
    Corner,
    /// 2: a rectangle of w × h in a square of max(w, h), from a series of squares. Recommended.
    #[default]
    SquareSeries,
    /// 3: a texture of w × h.
    Exact,
}

impl TextureMode {
    /// Texels of the texture that shows a tile. `largest` is the side of the largest texture, margins included.
    pub fn texture_size(self, window: &TileWindow, largest: u32) -> UVec2 {
        match self {
            Self::Full | Self::Corner => UVec2::splat(largest),
            Self::SquareSeries => UVec2::splat(window.size.max_element()),
            Self::Exact => window.size,
        }
    }

    /// Texels of the texture that are cleared, drawn and read for a tile.
    pub fn drawn_size(self, window: &TileWindow, largest: u32) -> UVec2 {
        match self {
            Self::Full => UVec2::splat(largest),
            _ => window.size,
        }
    }

    /// Bytes of all textures that a mode may ever need, one of each size, with sides of 1 to `largest` (a power of two)
    /// and no margins. Relative to `largest`²: 1, 1, 4/3, and for exact textures 8/3 if no tile is more than twice as
    /// long as wide (`is_near_square`), else 4. The thesis prints 8/3, which leaves out the longer ones.
    pub fn pool_bytes(self, largest: u32, is_near_square: bool) -> u64 {
        let sides = || {
            (0..32)
                .map(|level| 1_u64 << level)
                .take_while(|side| *side <= u64::from(largest))
        };
        let texels = match self {
            Self::Full | Self::Corner => u64::from(largest).pow(2),
            Self::SquareSeries => sides().map(|side| side * side).sum(),
            Self::Exact => {
                let pairs = sides().flat_map(|x| sides().map(move |y| (x, y)));
                let allowed = pairs.filter(|(x, y)| !is_near_square || x.max(y) / x.min(y) <= 2);
                allowed.map(|(x, y)| x * y).sum()
            }
        };
        texels * BYTES_PER_TEXEL
    }
}

/// A tile's texture is larger than the budget. [`FittedMap::within`] makes tiles smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileTooLarge {
    /// Index of the tile.
    pub tile: usize,
    /// Bytes of its texture.
    pub bytes: u64,
}

/// Tiles drawn together, then applied together.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Waves {
    /// Indices into the plan's tiles: consecutive, together all of them.
    pub waves: Vec<Range<usize>>,
    /// Bytes of the textures of the largest wave.
    pub peak_bytes: u64,
}

impl FittedPlan {
    /// Divides the tiles, in their order, into as few waves as the budget allows. Tiles are disjoint and depths do not
    /// depend on what else is drawn, so waves change no bit of the picture.
    ///
    /// `largest` is the side of the largest texture, margins included.
    pub fn waves(&self, mode: TextureMode, largest: u32, budget_bytes: u64) -> Result<Waves, TileTooLarge> {
        let mut waves = Waves::default();
        let (mut start, mut bytes) = (0, 0);
        for (index, tile) in self.tiles.iter().enumerate() {
            let size = mode.texture_size(&tile.window, largest).as_u64vec2();
            let more = size.element_product() * BYTES_PER_TEXEL;
            if more > budget_bytes {
                return Err(TileTooLarge {
                    tile: index,
                    bytes: more,
                });
            }
            if bytes + more > budget_bytes {
                waves.waves.push(start..index);
                (start, bytes) = (index, 0);
            }
            bytes += more;
            waves.peak_bytes = waves.peak_bytes.max(bytes);
        }
        if start < self.tiles.len() {
            waves.waves.push(start..self.tiles.len());
        }
        Ok(waves)
    }
}

impl FittedMap {
    /// Side of the largest texture in texels, margins included.
    pub fn largest_texture(&self) -> u32 {
        TileWindow::around(UVec2::splat(self.tile_size_max), self.margin).size.x
    }

    /// These settings with tiles small enough that one texture fits a budget, and as many more of them: s_max halves, n
    /// doubles, and the finest resolution stays (until [`MAX_GRID`](super::grid::MAX_GRID)). `None` if not even the
    /// smallest tile fits.
    ///
    /// A margin is added to the power of two: 4096² with a margin does not fit into 64 MiB, so its tiles become 2048².
    pub fn within(&self, budget_bytes: u64) -> Option<Self> {
        let mut map = *self;
        loop {
            if u64::from(map.largest_texture()).pow(2) * BYTES_PER_TEXEL <= budget_bytes {
                return Some(map);
            }
            if map.tile_size_max / 2 < map.tile_size_min.max(1) {
                return None;
            }
            map.tile_size_max /= 2;
            map.tiles_per_axis = map.tiles_per_axis.saturating_mul(2);
        }
    }

    /// A plan whose textures are all alive together, as applying many tiles in one pass needs it: where they do not fit
    /// a budget, ξ rises for all until they do, so that quality drops evenly. The plan's
    /// [`quality_drop`](FittedPlan::quality_drop) says by how much. `None` if not even the smallest textures fit.
    pub fn plan_together(&self, grid: &NeedGrid, mode: TextureMode, budget_bytes: u64) -> Option<FittedPlan> {
        (self.quality_drop..=self.quality_drop.max(0).saturating_add(32)).find_map(|quality_drop| {
            let map = Self { quality_drop, ..*self };
            let plan = map.plan(grid);
            let waves = plan.waves(mode, map.largest_texture(), budget_bytes);
            waves.is_ok_and(|waves| waves.waves.len() <= 1).then_some(plan)
        })
    }
}

impl TiledMap {
    /// This map with tiles small enough that one texture fits a budget, and as many more of them as keep the resolution:
    /// the side of the texture halves, n doubles. Margins shrink with it only where they are more than an eighth of it. Where
    /// n is at [`MOST_TILES_PER_AXIS`], the resolution falls. Tiles of one texel always fit.
    pub fn within(&self, budget_bytes: u64) -> Self {
        let mut map = *self;
        while map.window.texels() * BYTES_PER_TEXEL > budget_bytes && map.window.size.max_element() > 1 {
            let size = map.window.size / 2;
            let widest = (size.min_element() / 8).max(1);
            map.window = TileWindow::of_size(size, map.window.margin.min(widest));
            map.tiles_per_axis = (map.tiles_per_axis * 2).min(MOST_TILES_PER_AXIS);
        }
        map
    }
}

impl QueriedMap {
    /// These settings with textures small enough that one of each size fits a budget, larger ones being used in their
    /// corner for smaller tiles. First s_max halves, down to s; then s halves with it and ξ_max doubles, so that the
    /// finest resolution stays.
    pub fn within(&self, budget_bytes: u64) -> Self {
        let mut map = *self;
        let bytes = |map: &Self| u64::from(map.tile_size_max.max(map.tile_size)).pow(2) * BYTES_PER_TEXEL;
        while bytes(&map) > budget_bytes && map.tile_size > 1 {
            if map.tile_size_max > map.tile_size {
                map.tile_size_max = (map.tile_size_max / 2).max(map.tile_size);
            } else {
                map.tile_size /= 2;
                map.tile_size_max = map.tile_size;
                map.max_tiles_per_axis = map.max_tiles_per_axis.saturating_mul(2);
            }
        }
        map
    }
}
