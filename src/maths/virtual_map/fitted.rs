//! [`FittedMap`]: tiles as fine as the picture needs them (Giegl, sections 5.9 to 5.12).
//!
//! # Traversal
//!
//! A node is a tile of a grid of 2^p_x × 2^p_y; its need is the largest in its cells, read from the pyramid at level m
//! = max(p_x, p_y). With t = min(need, cap) − ξ on each axis,
//!
//! ```text
//! split the axis if   t > p + log2 s_max   and   p < log2 n             else   side = 2^clamp(t − p, log2 s_min, log2 s_max)
//! ```
//!
//! Nodes without pixels are dropped. Both the level limit and the empty-node test are missing in the thesis, whose test
//! also has the sign of log2 s_max wrong: as printed it never ends. cap = log2 n + log2 s_max is the finest that the
//! settings can give; taking ξ from the capped need makes ξ = log2 n exactly one map of s_max in every scene.
//!
//! A negative ξ asks for more than a texel per pixel. The grid then has n 2^(−ξ) cells per axis, so that the same
//! pixels are capped as at ξ = 0.
//!
//! # On the GPU
//!
//! `plan(cells: storage array<NeedCell>, leaves: storage array<FittedTile>, count: atomic, draws: storage
//! array<indirect>)`, one workgroup with the queue in workgroup memory: each round takes up to 256 nodes, each
//! invocation runs [`FittedMap`]'s test on one and appends children or a leaf. The order of leaves then depends on
//! scheduling; the picture does not, because leaves are disjoint. Viewports cannot be set from the GPU: slots per
//! texture size with indirect draws of zero instances, or a read-back of the leaves. `apply(leaf: uniform, tile_depth:
//! texture_depth_2d, depth: texture_depth_2d, result: texture_storage_2d<r32float, write>)`, 8 × 8 over the leaf's
//! rectangle: unproject, skip what [`Tile::contains`] denies, look up at [`Tile::texture_uv`], write.

use bevy_math::{DMat4, UVec2};

use super::{
    grid::{MAX_GRID, NeedCell, NeedGrid},
    mapping::{MAX_LEVEL, TileMappingMap},
    picture::PixelRect,
    thrift,
    tile::{Tile, TileWindow},
};

/// Settings of a fitted map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FittedMap {
    /// ξ: levels taken off every need. 1 halves the resolution everywhere, −1 doubles it; −4..=5 is useful, more is
    /// allowed.
    pub quality_drop: i32,
    /// n: most tiles per axis at ξ = 0; a power of two.
    pub tiles_per_axis: u32,
    /// s_max: largest side of a tile's core in texels; a power of two.
    pub tile_size_max: u32,
    /// Smallest side of a tile's core in texels; a power of two.
    pub tile_size_min: u32,
    /// Texels around each core for filters; textures are larger than cores by twice as many.
    pub margin: u32,
    /// What drawing one more tile costs, in texels. `None` splits tiles only where their need exceeds the largest
    /// texture, as the thesis does: fewest tiles, most texels. With a cost, the plan with the least texels + cost ·
    /// tiles is found; 65 536 is a good start. Grids of more than 256 cells per axis are always split as in the thesis.
    pub tile_cost: Option<u32>,
}

impl Default for FittedMap {
    /// `fitted:xi=0,n=32,tile_max=4096`.
    fn default() -> Self {
        Self {
            quality_drop: 0,
            tiles_per_axis: 32,
            tile_size_max: 4096,
            tile_size_min: 64,
            margin: 0,
            tile_cost: None,
        }
    }
}

/// A tile of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FittedTile {
    /// Which part of the map.
    pub tile: Tile,
    /// Texture: core and margins.
    pub window: TileWindow,
    /// Pixels of the picture that may look into it.
    pub rect: PixelRect,
    /// The largest needs of its pixels, before cap and ξ.
    pub levels: [u8; 2],
    /// Texels of the mapping map that look into it.
    pub pixels: u32,
}

impl FittedTile {
    /// Texels per axis of a whole map with the resolution of this tile.
    pub fn effective_resolution(&self) -> [u64; 2] {
        let (counts, core) = (self.tile.counts.as_u64vec2(), self.window.core().as_u64vec2());
        (counts * core).to_array()
    }

    /// The matrix that draws it.
    pub fn clip_from_world(&self, map_clip_from_world: &DMat4) -> DMat4 {
        self.tile.clip_from_world(map_clip_from_world, &self.window)
    }
}

/// The tiles of a frame: disjoint, and together over all pixels that look into the map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FittedPlan {
    /// In the order of the traversal.
    pub tiles: Vec<FittedTile>,
    /// log2 of the largest need that was met; pixels that need more are capped ([`TileMappingMap::texels_above`]).
    pub cap: u32,
    /// ξ, as it was used.
    pub quality_drop: i32,
}

impl FittedPlan {
    /// Texels drawn, margins included.
    pub fn texels(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.window.texels()).sum()
    }

    /// Texels per axis of a tiled map with the resolution of the finest tile.
    pub fn effective_resolution(&self) -> u64 {
        let finest = self.tiles.iter().flat_map(FittedTile::effective_resolution);
        finest.max().unwrap_or(0)
    }

    /// Share of the valid texels of a mapping map whose need was not met, 0..=1.
    pub fn capped_share(&self, map: &TileMappingMap) -> f64 {
        f64::from(map.texels_above(self.cap)) / f64::from(map.valid_texels().max(1))
    }
}

impl FittedMap {
    /// Cells per axis of the grid that these settings need: n, and twice as many for each level below ξ = 0. At most
    /// [`MAX_GRID`]; where that is less, more pixels are capped.
    pub fn grid_tiles_per_axis(&self) -> u32 {
        let n = u64::from(floor_power(self.tiles_per_axis));
        let fine = n << self.quality_drop.saturating_neg().clamp(0, 16);
        fine.min(u64::from(MAX_GRID)) as u32
    }

    /// log2 of the largest need that a grid of 2^`depth` cells per axis can meet.
    fn cap(&self, depth: u32) -> u32 {
        let nominal = floor_power(self.tiles_per_axis).ilog2() + self.largest_core();
        let reached = i64::from(depth + self.largest_core()) + i64::from(self.quality_drop);
        i64::from(nominal).min(reached).clamp(0, i64::from(MAX_LEVEL)) as u32
    }

    fn largest_core(&self) -> u32 {
        floor_power(self.tile_size_max).ilog2()
    }

    /// The tiles for a grid, depth first, children row by row. Finer grids than needed are no harm; coarser ones cap
    /// more.
    pub fn plan(&self, grid: &NeedGrid) -> FittedPlan {
        let traversal = Traversal {
            map: self,
            grid,
            cap: self.cap(grid.depth()),
        };
        let tiles = match self.tile_cost {
            Some(cost) if grid.depth() <= thrift::MAX_DEPTH => thrift::cheapest(&traversal, cost),
            _ => traversal.leaves(),
        };
        FittedPlan {
            tiles,
            cap: traversal.cap,
            quality_drop: self.quality_drop,
        }
    }
}

/// The largest power of two that is not larger; 1 for 0.
fn floor_power(value: u32) -> u32 {
    1 << value.max(1).ilog2()
}

/// A tile under consideration.
#[derive(Clone, Copy)]
pub(super) struct Node {
    pub(super) place: UVec2,
    /// p: log2 of the tiles per axis.
    pub(super) splits: UVec2,
}

impl Node {
    pub(super) fn new(place: [u32; 2], splits: [u32; 2]) -> Self {
        Self {
            place: place.into(),
            splits: splits.into(),
        }
    }

    /// Both halves across an axis.
    pub(super) fn halves(&self, axis: usize) -> [Self; 2] {
        let step = UVec2::AXES[axis];
        [0, 1].map(|half| Self {
            place: (self.place << step) + step * half,
            splits: self.splits + step,
        })
    }
}

pub(super) struct Traversal<'a> {
    pub(super) map: &'a FittedMap,
    pub(super) grid: &'a NeedGrid,
    pub(super) cap: u32,
}

impl Traversal<'_> {
    /// The thesis's plan.
    fn leaves(&self) -> Vec<FittedTile> {
        let mut tiles = Vec::new();
        let mut nodes = vec![Node::new([0, 0], [0, 0])];
        while let Some(node) = nodes.pop() {
            let need = self.need(&node);
            if need.pixels == 0 {
                continue;
            }
            let parts = self.parts(&node, &need);
            if parts == UVec2::ZERO {
                tiles.push(self.leaf(&node, &need));
                continue;
            }
            // The last one pushed is the next.
            for y in (0..=parts.y).rev() {
                for x in (0..=parts.x).rev() {
                    nodes.push(Node {
                        place: (node.place << parts) + UVec2::new(x, y),
                        splits: node.splits + parts,
                    });
                }
            }
        }
        tiles
    }

    pub(super) fn need(&self, node: &Node) -> NeedCell {
        let level = node.splits.max_element();
        let shift = UVec2::splat(level) - node.splits;
        self.grid.region(level, node.place << shift, (node.place + 1) << shift)
    }

    /// t − p: log2 of the core's side that a level of need asks for on an axis.
    fn side(&self, splits: UVec2, level: u8, axis: usize) -> i64 {
        let target = i64::from(level).min(i64::from(self.cap)) - i64::from(self.map.quality_drop);
        target - i64::from(splits[axis])
    }

    /// Whether a tile with this need must be split across an axis.
    fn is_split(&self, splits: UVec2, level: u8, axis: usize) -> bool {
        self.side(splits, level, axis) > i64::from(self.map.largest_core()) && splits[axis] < self.grid.depth()
    }

    /// 1 for each axis that must be split.
    fn parts(&self, node: &Node, need: &NeedCell) -> UVec2 {
        let part = |axis: usize| u32::from(self.is_split(node.splits, need.levels[axis], axis));
        UVec2::new(part(0), part(1))
    }

    /// Texels along the side of a leaf's core.
    fn core(&self, splits: UVec2, level: u8, axis: usize) -> u32 {
        let largest = self.map.largest_core();
        let smallest = floor_power(self.map.tile_size_min).ilog2().min(largest);
        1 << self
            .side(splits, level, axis)
            .clamp(i64::from(smallest), i64::from(largest))
    }

    /// Texels along the side of a leaf's texture, margins included; `None` where it must be split.
    pub(super) fn texture_side(&self, splits: UVec2, level: u8, axis: usize) -> Option<u64> {
        let side = || {
            TileWindow::around(UVec2::splat(self.core(splits, level, axis)), self.map.margin)
                .size
                .x
        };
        (!self.is_split(splits, level, axis)).then(|| side().into())
    }

    pub(super) fn leaf(&self, node: &Node, need: &NeedCell) -> FittedTile {
        let core = |axis: usize| self.core(node.splits, need.levels[axis], axis);
        FittedTile {
            tile: Tile {
                place: node.place,
                counts: UVec2::ONE << node.splits,
            },
            window: TileWindow::around(UVec2::new(core(0), core(1)), self.map.margin),
            rect: need.rect,
            levels: need.levels,
            pixels: need.pixels,
        }
    }
}
