//! [`NeedGrid`]: needs by place in the light map, and the pyramid of maxima over them (Giegl, sections 5.7 and 5.8).
//!
//! # On the GPU
//!
//! The cells are what `mapping` writes with atomics ([`mapping`](super::mapping)), and optionally 2 × 32 counters of
//! the histogram for each. `pyramid(cells: storage array<NeedCell>)`, one workgroup of 256, level by level with a
//! barrier between: parent = max of needs, union of rectangles, sum of pixels. 1365 cells for n = 32.

use bevy_math::{UVec2, Vec2};

use super::{
    mapping::{MAX_LEVEL, MappingTexel, TileMappingMap},
    picture::PixelRect,
};

/// Most cells per axis of a grid.
pub const MAX_GRID: u32 = 1024;

/// Settings of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridOptions {
    /// n: cells per axis, rounded up to a power of two, at most [`MAX_GRID`].
    pub tiles_per_axis: u32,
    /// Picture pixels by which rectangles grow on each side. A mapping map at the picture's size needs none; a smaller
    /// one needs one of its own texels, since the pixels between two of its texels may belong to another tile than
    /// both.
    pub rect_guard: u32,
    /// Cells by which a texel of a smaller mapping map may also count around its own, as far as the pixels it stands
    /// for reach on its patch. Without it, cells that only pixels between two texels see would get no tile: holes. 0 is
    /// off.
    pub spread: u32,
    /// Share of a cell's pixels, 0..=1, whose needs may be ignored: the extreme ones, by axis (section 5.7: "very few
    /// pixels"; no rule is printed). 0.005 is worth trying. They are counted as [`NeedGrid::discarded`].
    pub discard_fraction: f64,
    /// log2 of the resolution that cells without any pixel get: `None` leaves them out. With needs of an earlier frame
    /// it says how fine a shadow is where nothing was seen then.
    pub floor_level: Option<u8>,
}

impl Default for GridOptions {
    fn default() -> Self {
        Self {
            tiles_per_axis: 32,
            rect_guard: 0,
            spread: 2,
            discard_fraction: 0.0,
            floor_level: None,
        }
    }
}

/// A cell of the grid, or of a level of the pyramid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NeedCell {
    /// Largest log2 of the texels per axis *of the whole map* that a pixel in the cell needs. Because it refers to the
    /// whole map, the maximum over cells is exact on every level of the pyramid.
    pub levels: [u8; 2],
    /// Texels of the mapping map that count here: 0 is an empty cell, which gets no tile.
    pub pixels: u32,
    /// Around the pixels that they stand for.
    pub rect: PixelRect,
}

impl NeedCell {
    /// Without pixels.
    pub const EMPTY: Self = Self {
        levels: [0; 2],
        pixels: 0,
        rect: PixelRect::EMPTY,
    };

    /// Both together.
    pub fn merged(self, other: Self) -> Self {
        Self {
            levels: [0, 1].map(|axis| self.levels[axis].max(other.levels[axis])),
            pixels: self.pixels + other.pixels,
            rect: self.rect.union(other.rect),
        }
    }
}

/// Pixels per level of need, for both axes: the full histogram. The thesis has 8 bins from η_0 = 17 to η_1 = 22, which
/// its cap of 2¹⁷ makes no sense of.
pub type Histogram = [[u32; MAX_LEVEL as usize + 1]; 2];

/// Needs over the light map.
#[derive(Clone, Debug, PartialEq)]
pub struct NeedGrid {
    /// Levels of the pyramid: one cell, 2 × 2, … n × n; row by row from the top left.
    pub levels: Vec<Vec<NeedCell>>,
    /// Of all texels.
    pub histogram: Histogram,
    /// Texels of the mapping map that need more than their cell's level on some axis, by the discard rule.
    pub discarded: u32,
}

impl NeedGrid {
    /// Collects a mapping map. An empty map gives a grid without pixels.
    pub fn new(map: &TileMappingMap, options: &GridOptions) -> Self {
        let n = options.tiles_per_axis.clamp(1, MAX_GRID).next_power_of_two();
        let edges = [0, 1].map(|axis| {
            let (size, picture) = (map.size[axis], map.picture[axis]);
            (0..size)
                .map(|place| [place * picture / size, ((place + 1) * picture).div_ceil(size)])
                .collect()
        });
        let collector = Collector { map, options, n, edges };
        let mut cells = vec![NeedCell::EMPTY; (n * n) as usize];
        let mut histogram = [[0; MAX_LEVEL as usize + 1]; 2];
        collector.each(|place, texel| {
            let rect = collector.rect(place);
            for axis in 0..2 {
                histogram[axis][usize::from(texel.levels[axis].min(MAX_LEVEL))] += 1;
            }
            collector.each_cell(texel, |cell| {
                cells[cell] = cells[cell].merged(NeedCell {
                    levels: texel.levels,
                    pixels: 1,
                    rect,
                });
            });
        });
        let discarded = collector.discard(&mut cells);
        finish(&mut cells, map.picture, options);
        Self {
            levels: pyramid(cells, n),
            histogram,
            discarded,
        }
    }

    /// A grid of cells that the GPU has collected, row by row, with as many histograms if pixels are to be discarded;
    /// guard, discard rule and floor as in [`Self::new`]. [`Self::discarded`] is an upper bound: pixels that are extreme on
    /// both axes count twice. `None` where [`Self::from_cells`] is.
    pub fn collected(
        mut cells: Vec<NeedCell>,
        histograms: &[Histogram],
        picture: UVec2,
        options: &GridOptions,
    ) -> Option<Self> {
        let mut discarded = 0;
        for (cell, histogram) in cells.iter_mut().zip(histograms) {
            discarded += lower(cell, histogram, options.discard_fraction);
        }
        finish(&mut cells, picture, options);
        Some(Self {
            discarded,
            ..Self::from_cells(cells)?
        })
    }

    /// A grid of given cells, row by row; n = √count must be a power of two. `None` otherwise.
    pub fn from_cells(cells: Vec<NeedCell>) -> Option<Self> {
        let n = (cells.len() as f64).sqrt() as u32;
        let is_square = n.is_power_of_two() && u64::from(n).pow(2) == cells.len() as u64;
        is_square.then(|| Self {
            levels: pyramid(cells, n),
            histogram: [[0; MAX_LEVEL as usize + 1]; 2],
            discarded: 0,
        })
    }

    /// n.
    pub fn tiles_per_axis(&self) -> u32 {
        1 << self.depth()
    }

    /// log2 n: the index of the finest level.
    pub fn depth(&self) -> u32 {
        self.levels.len() as u32 - 1
    }

    /// The need of a single map for everything.
    pub fn root(&self) -> &NeedCell {
        &self.levels[0][0]
    }

    /// All cells of a level from `first` up to and without `end`, together.
    pub fn region(&self, level: u32, first: UVec2, end: UVec2) -> NeedCell {
        let side = 1_u32 << level;
        let cells = &self.levels[level as usize];
        let rows = (first.y..end.y).map(|y| &cells[(y * side + first.x) as usize..(y * side + end.x) as usize]);
        rows.flatten().fold(NeedCell::EMPTY, |sum, cell| sum.merged(*cell))
    }
}

fn pyramid(cells: Vec<NeedCell>, n: u32) -> Vec<Vec<NeedCell>> {
    let mut levels = vec![cells];
    let mut side = n;
    while side > 1 {
        let fine = &levels[levels.len() - 1];
        let half = side / 2;
        let parents = (0..half * half).map(|index| {
            let first = (index / half * 2 * side + index % half * 2) as usize;
            [first, first + 1, first + side as usize, first + side as usize + 1]
                .into_iter()
                .fold(NeedCell::EMPTY, |parent, child| parent.merged(fine[child]))
        });
        let parents = parents.collect();
        levels.push(parents);
        side = half;
    }
    levels.reverse();
    levels
}

/// Lowers the levels of a cell to the least that leave at most the allowed share of its pixels above them, by axis.
/// Returns the pixels above, summed over the axes. NaN allows none.
fn lower(cell: &mut NeedCell, histogram: &Histogram, fraction: f64) -> u32 {
    let allowed = (f64::from(cell.pixels) * fraction.clamp(0.0, 1.0)).floor() as u32;
    let mut discarded = 0;
    for axis in 0..2 {
        let mut above = 0;
        while cell.levels[axis] > 0 {
            let more = histogram[axis][usize::from(cell.levels[axis].min(MAX_LEVEL))];
            if above + more > allowed {
                break;
            }
            above += more;
            cell.levels[axis] -= 1;
        }
        discarded += above;
    }
    discarded
}

/// Guards rectangles and fills cells without pixels, as the options say.
fn finish(cells: &mut [NeedCell], picture: UVec2, options: &GridOptions) {
    for cell in cells {
        cell.rect = cell.rect.grown(options.rect_guard, picture);
        if let (0, Some(level)) = (cell.pixels, options.floor_level) {
            *cell = NeedCell {
                levels: [level.min(MAX_LEVEL); 2],
                pixels: 1,
                rect: PixelRect::whole(picture),
            };
        }
    }
}

struct Collector<'a> {
    map: &'a TileMappingMap,
    options: &'a GridOptions,
    n: u32,
    /// First and last picture column of each column of the mapping map; rows likewise.
    edges: [Vec<[u32; 2]>; 2],
}

impl Collector<'_> {
    fn each(&self, mut visit: impl FnMut(UVec2, &MappingTexel)) {
        let mut texels = self.map.texels.iter();
        for y in 0..self.map.size.y {
            for x in 0..self.map.size.x {
                if let Some(Some(texel)) = texels.next() {
                    visit(UVec2::new(x, y), texel);
                }
            }
        }
    }

    /// Cells in which a texel counts: its own, and those its pixels reach. None for places that are NaN.
    fn each_cell(&self, texel: &MappingTexel, mut visit: impl FnMut(usize)) {
        if texel.uv.is_nan() {
            return;
        }
        // Conversions saturate below 0.
        let cell = |place: Vec2| place.as_uvec2().min(UVec2::splat(self.n - 1));
        let n = self.n as f32;
        let (place, reach) = (texel.uv * n, texel.reach * n);
        let own = cell(place);
        let inside = place - own.as_vec2();
        let is_alone = inside.cmpge(reach).all() && (inside + reach).cmplt(Vec2::ONE).all();
        if is_alone || self.options.spread == 0 {
            visit((own.y * self.n + own.x) as usize);
            return;
        }
        let spread = UVec2::splat(self.options.spread);
        let first = cell(place - reach).max(own.saturating_sub(spread));
        let last = cell(place + reach).min(own.saturating_add(spread));
        for y in first.y..=last.y {
            for x in first.x..=last.x {
                visit((y * self.n + x) as usize);
            }
        }
    }

    /// The pixels that a texel stands for: whole, not only the one that was looked at.
    fn rect(&self, place: UVec2) -> PixelRect {
        let [columns, rows] = &self.edges;
        let (column, row) = (columns[place.x as usize], rows[place.y as usize]);
        PixelRect {
            min: UVec2::new(column[0], row[0]),
            max: UVec2::new(column[1], row[1]),
        }
    }

    /// Lowers the level of each cell to the least that leaves at most the allowed share of its pixels above it. Returns
    /// the texels above, each once.
    fn discard(&self, cells: &mut [NeedCell]) -> u32 {
        let fraction = self.options.discard_fraction.clamp(0.0, 1.0);
        // NaN stays NaN and discards nothing.
        if !(fraction > 0.0) {
            return 0;
        }
        let mut histograms = vec![[[0_u32; MAX_LEVEL as usize + 1]; 2]; cells.len()];
        self.each(|_, texel| {
            self.each_cell(texel, |cell| {
                for axis in 0..2 {
                    histograms[cell][axis][usize::from(texel.levels[axis].min(MAX_LEVEL))] += 1;
                }
            });
        });
        for (cell, histogram) in cells.iter_mut().zip(&histograms) {
            lower(cell, histogram, fraction);
        }
        let mut discarded = 0;
        self.each(|_, texel| {
            let mut is_above = false;
            self.each_cell(texel, |cell| {
                is_above |= (0..2).any(|axis| texel.levels[axis] > cells[cell].levels[axis]);
            });
            discarded += u32::from(is_above);
        });
        discarded
    }
}
