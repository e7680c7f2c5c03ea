//! [`QueriedMap`]: refine a tile only if refining it changed the picture (Giegl, chapter 4).
//!
//! Start with one tile over the whole map. Apply it to the shadow result, count the pixels that it changed, and split
//! it if there are more than a threshold. What is measured is the effect on the screen, whatever caused it; nothing is
//! carried over from earlier frames.
//!
//! # Order
//!
//! Level by level, coarse to fine: [`QueriedMap::refine`]. The thesis consumes one finished query at a time; both
//! orders draw the same tiles, because what a tile changes depends on its parent's result only: siblings own disjoint
//! pixels, and tiles never write beside themselves. So without jumps the tiles of a larger threshold are a subset of
//! those of a smaller.
//!
//! A tile that changes nothing ends although a finer one might show a caster that is too thin for both: "`min` = 0
//! equals the tiled map" is true to the eye, not to the bit.
//!
//! # On the GPU
//!
//! Fixed number of recorded steps, log2(max) + 1 levels, no read-back. Per level:
//!
//! * `cull`, one invocation per (caster, tile): indirect draws; zero instances for unused slots.
//! * raster passes: slot i of the level into a texture of `tile_size`.
//! * `apply(tiles: storage array<TileUniform>, tile_depth: texture_depth_2d, depth: texture_depth_2d, result:
//!   texture_storage_2d<r32float, read_write>, reports: storage array<TileReport, atomic>)`, 8 × 8, one invocation per
//!   pixel of the tile's rectangle (`dispatch_indirect`): unproject, skip what [`Tile::contains`] denies, look up,
//!   [`changed_result`], write; sums of `changed` and `inside` and the rectangle are reduced in workgroup memory, one
//!   atomic each per workgroup. No copy of the old result is needed: in one pass a pixel has one owner.
//! * `decide(tiles, reports, next_tiles, jumps)`, one invocation per tile of the level: [`QueriedMap::decide`].

use bevy_math::UVec2;

use super::{picture::PixelRect, tile::Tile};

/// When a tile is worth refining.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum ChangeThreshold {
    /// More changed pixels than this, for a picture of 1024² pixels; scaled with the picture's area. η_min of the
    /// thesis: 300 for quality, 2500 for speed.
    Pixels(f64),
    /// A larger share of changed pixels among those inside the tile, 0..=1. The thesis rejected it (section 4.5.1)
    /// because occlusion queries had to count twice; with counters both numbers come from one pass.
    Share(f64),
}

/// How a tile is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum Splitting {
    /// 2 × 2.
    Quad,
    /// In two, the axis with fewer tiles first; costs 6 tiles for what [`Splitting::Quad`] does with 4 (section 4.5.1).
    Binary,
    /// 3 × 3; costs 19 tiles where two quad splits cost 9 (section 4.5.1).
    Grid3,
}

/// The exponent of the opportunity jump: how many steps of refinement a larger texture is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum JumpExponent {
    /// `tile_size_max` ÷ `tile_size`, as printed in section 4.4.2.
    Ratio,
    /// Its log2: a texture twice as large equals one split. This is the exponent that the text describes.
    Steps,
    /// As printed for the only ratio that was measured, 2, else [`JumpExponent::Steps`].
    Measured,
}

/// Opportunity jump (section 4.4.2): use the largest texture if counts are expected to fall below the threshold anyway.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub struct OpportunityJump {
    /// f: the factor by which the count is assumed to fall with each step; 1/2 is careful, 1/4 good, 1/8 bold.
    pub decay: f64,
    /// Number of steps.
    pub exponent: JumpExponent,
}

/// Settings of a queried map.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub struct QueriedMap {
    /// Split above this.
    pub threshold: ChangeThreshold,
    /// Largest number of tiles per axis: ξ_max.
    pub max_tiles_per_axis: u32,
    /// Texels per side of ordinary tiles: s.
    pub tile_size: u32,
    /// Texels per side of tiles after a jump: s_max. Not larger than `tile_size`: no jumps.
    pub tile_size_max: u32,
    /// How tiles are divided.
    pub splitting: Splitting,
    /// Maximum refinement jump (section 4.4.1): one larger texture instead of the last splits.
    pub maximum_jump: bool,
    /// Opportunity jump; `None` is off.
    pub opportunity_jump: Option<OpportunityJump>,
    /// Split the first tile whatever it changed, as section 4.5 counts.
    pub force_first_split: bool,
    /// Most tiles on one level, for passes that are recorded in advance; the splits that changed most win.
    pub max_tiles_per_level: usize,
}

impl Default for QueriedMap {
    /// `queried:min=300,max=32,tile=1024,tile_max=4096`.
    fn default() -> Self {
        Self {
            threshold: ChangeThreshold::Pixels(300.0),
            max_tiles_per_axis: 32,
            tile_size: 1024,
            tile_size_max: 4096,
            splitting: Splitting::Quad,
            maximum_jump: true,
            opportunity_jump: Some(OpportunityJump {
                decay: 0.25,
                exponent: JumpExponent::Measured,
            }),
            force_first_split: false,
            max_tiles_per_level: usize::MAX,
        }
    }
}

/// What applying a tile did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileReport {
    /// Pixels whose shadow result changed, in either direction: η.
    pub changed: u32,
    /// Pixels inside the tile.
    pub inside: u32,
    /// Rectangle around the pixels inside.
    pub rect: PixelRect,
}

impl TileReport {
    /// Before any pixel.
    pub const EMPTY: Self = Self {
        changed: 0,
        inside: 0,
        rect: PixelRect::EMPTY,
    };

    /// Counts a pixel inside the tile.
    pub fn count(&mut self, pixel: UVec2, is_changed: bool) {
        self.inside += 1;
        self.changed += u32::from(is_changed);
        self.rect = self.rect.union(PixelRect {
            min: pixel,
            max: pixel + 1,
        });
    }
}

/// The new shadow result of a pixel if it differs from the old one by more than a tolerance; `None` writes and counts
/// nothing. Filtered results need a tolerance (1/255 and more), or counts never fall; 0 is exact.
pub fn changed_result(old: f32, new: f32, tolerance: f32) -> Option<f32> {
    ((new - old).abs() > tolerance).then_some(new)
}

/// What becomes of a tile after its report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Nothing: it is good enough, or at the limit.
    Final,
    /// The same tile once more with the largest texture; final.
    MaximumJump,
    /// The same, because little is expected of further splits; final.
    OpportunityJump,
    /// Its children are drawn.
    Split,
    /// It should be split, but the level is full: final.
    Dropped,
}

/// A tile to draw and apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueriedTile {
    /// Which part of the map.
    pub tile: Tile,
    /// Texels per side of its texture.
    pub size: u32,
    /// Where in the picture it can matter: the rectangle of its parent's pixels.
    pub rect: PixelRect,
    /// The decision after applying it; `None` after a jump: nothing is counted.
    pub decision: Option<Decision>,
    /// What applying it did; jumped tiles too, if the caller counts.
    pub report: TileReport,
}

/// All tiles of a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Refinement {
    /// In the order in which they were applied: level by level, jumps last.
    pub tiles: Vec<QueriedTile>,
    /// Number of splits: k.
    pub splits: usize,
    /// Number of jumps: l.
    pub jumps: usize,
    /// Splits that did not fit on their level.
    pub dropped: usize,
}

impl Refinement {
    /// Texels drawn: (1 + 4 k) s² + l s_max² for quad splits.
    pub fn texels(&self) -> u64 {
        self.tiles.iter().map(|tile| u64::from(tile.size).pow(2)).sum()
    }
}

impl QueriedMap {
    /// Parts per axis into which a tile would be split; `None` at the limit.
    pub fn parts(&self, tile: &Tile) -> Option<UVec2> {
        let parts = match self.splitting {
            Splitting::Quad => UVec2::splat(2),
            Splitting::Grid3 => UVec2::splat(3),
            Splitting::Binary if tile.counts.x <= tile.counts.y => UVec2::new(2, 1),
            Splitting::Binary => UVec2::new(1, 2),
        };
        let counts = tile.counts.as_u64vec2() * parts.as_u64vec2();
        (counts.max_element() <= u64::from(self.max_tiles_per_axis)).then_some(parts)
    }

    /// What to do with an ordinary tile after its report, in a picture of some pixels.
    ///
    /// Final unless it changed more than the threshold and may be split. Then, in this order,
    ///
    /// ```text
    /// maximum jump        ξ_max s ≤ s_max ξ                   ξ: tiles per axis now
    /// opportunity jump    η f^e ≤ η_min                       e: see JumpExponent
    /// ```
    ///
    /// else split. With a threshold of 0 there is no opportunity jump. NaN thresholds refine nothing.
    pub fn decide(&self, tile: &Tile, report: &TileReport, picture_pixels: u64) -> Decision {
        let (changed, threshold) = match self.threshold {
            ChangeThreshold::Pixels(pixels) => (
                f64::from(report.changed),
                pixels * picture_pixels as f64 / THRESHOLD_PIXELS,
            ),
            ChangeThreshold::Share(share) => (f64::from(report.changed) / f64::from(report.inside.max(1)), share),
        };
        let is_forced = self.force_first_split && *tile == Tile::WHOLE;
        if self.parts(tile).is_none() || !(is_forced || changed > threshold) {
            return Decision::Final;
        }
        if is_forced || self.tile_size_max <= self.tile_size {
            return Decision::Split;
        }
        let reached = u64::from(self.tile_size_max) * u64::from(tile.counts.min_element());
        if self.maximum_jump && u64::from(self.max_tiles_per_axis) * u64::from(self.tile_size) <= reached {
            return Decision::MaximumJump;
        }
        let expected = |jump: &OpportunityJump| changed * jump.decay.powf(self.steps(jump.exponent));
        match &self.opportunity_jump {
            Some(jump) if expected(jump) <= threshold => Decision::OpportunityJump,
            _ => Decision::Split,
        }
    }

    fn steps(&self, exponent: JumpExponent) -> f64 {
        let ratio = f64::from(self.tile_size_max) / f64::from(self.tile_size);
        match exponent {
            JumpExponent::Steps => ratio.log2(),
            JumpExponent::Measured if ratio != 2.0 => ratio.log2(),
            JumpExponent::Ratio | JumpExponent::Measured => ratio,
        }
    }

    /// Refines level by level for the pixels of a picture, which may be a part of a larger one. `apply` draws a tile, applies
    /// it within its rectangle and reports; it is called in the order of the result. The same reports give the same tiles.
    pub fn refine(&self, picture: PixelRect, mut apply: impl FnMut(&QueriedTile) -> TileReport) -> Refinement {
        self.refine_levels(picture, |tiles| tiles.iter().map(&mut apply).collect())
    }

    /// The same with all tiles of a level at once, as a GPU wants them: `apply` returns their reports in their order.
    /// The last call has the jumps, if there are any: tiles without a decision, which need no counting. Missing reports
    /// count as [`TileReport::EMPTY`].
    pub fn refine_levels(
        &self,
        picture: PixelRect,
        mut apply: impl FnMut(&[QueriedTile]) -> Vec<TileReport>,
    ) -> Refinement {
        let size = picture.max.saturating_sub(picture.min);
        let picture_pixels = u64::from(size.x) * u64::from(size.y);
        let ordinary = |tile: Tile, rect: PixelRect| QueriedTile {
            tile,
            size: self.tile_size,
            rect,
            decision: Some(Decision::Final),
            report: TileReport::EMPTY,
        };
        let mut refinement = Refinement::default();
        let mut jumps = Vec::new();
        let mut level = vec![ordinary(Tile::WHOLE, picture)];
        while !level.is_empty() {
            let reports = apply(&level);
            for (tile, report) in level.iter_mut().zip(reports) {
                tile.report = report;
                tile.decision = Some(self.decide(&tile.tile, &report, picture_pixels));
            }
            refinement.dropped += self.drop_excess(&mut level);
            let mut next = Vec::new();
            for tile in &level {
                match tile.decision {
                    Some(Decision::Split) => {
                        let parts = self.parts(&tile.tile).unwrap_or(UVec2::ONE);
                        next.extend(tile.tile.children(parts).map(|child| ordinary(child, tile.report.rect)));
                        refinement.splits += 1;
                    }
                    Some(Decision::MaximumJump | Decision::OpportunityJump) => jumps.push(QueriedTile {
                        size: self.tile_size_max,
                        decision: None,
                        rect: tile.report.rect,
                        ..*tile
                    }),
                    _ => {}
                }
            }
            refinement.tiles.append(&mut level);
            level = next;
        }
        if !jumps.is_empty() {
            let reports = apply(&jumps);
            for (jump, report) in jumps.iter_mut().zip(reports) {
                jump.report = report;
            }
        }
        refinement.jumps = jumps.len();
        refinement.tiles.append(&mut jumps);
        refinement
    }

    /// Drops the splits that change least until the next level has room; of equal ones the later. Returns their number.
    fn drop_excess(&self, level: &mut [QueriedTile]) -> usize {
        let mut splits: Vec<usize> = (0..level.len())
            .filter(|index| level[*index].decision == Some(Decision::Split))
            .collect();
        let children = match self.splitting {
            Splitting::Quad => 4,
            Splitting::Binary => 2,
            Splitting::Grid3 => 9,
        };
        let room = self.max_tiles_per_level / children;
        // Stable: of equal counts the earlier stay in front.
        splits.sort_by_key(|index| std::cmp::Reverse(level[*index].report.changed));
        let excess = splits.split_off(room.min(splits.len()));
        for index in &excess {
            level[*index].decision = Some(Decision::Dropped);
        }
        excess.len()
    }
}

/// The picture for which thresholds in pixels are meant: 1024².
const THRESHOLD_PIXELS: f64 = 1_048_576.0;
