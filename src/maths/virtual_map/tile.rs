//! [`Tile`]: one cell of a grid over a light map, its crop matrix and its texture.

use bevy_math::{DMat4, DVec2, DVec3, DVec4, UVec2};

/// Texture coordinates 0..=1 of a light map, v down, for a world-space point. `None` behind the projection centre and
/// for NaN; points beside the map have coordinates outside 0..=1.
pub fn map_uv(clip_from_world: &DMat4, point: DVec3) -> Option<DVec2> {
    let clip = *clip_from_world * point.extend(1.0);
    let uv = DVec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w);
    (clip.w > 0.0 && uv.is_finite()).then_some(uv)
}

/// One cell of a grid over a light map; the grid may have more columns than rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tile {
    /// Column and row, from the top left of the map: rows go down as v does, light clip space y goes up.
    pub place: UVec2,
    /// Tiles per axis of the grid that the tile belongs to, at least 1: n of Giegl, section 3.3.
    pub counts: UVec2,
}

impl Tile {
    /// The tile that is the whole map.
    pub const WHOLE: Self = Self {
        place: UVec2::ZERO,
        counts: UVec2::ONE,
    };

    /// The tile of a place in the map: half open, so that each place has one tile; coordinates of exactly 1 belong to
    /// the last. `None` outside the map, for NaN and for a grid without tiles.
    pub fn at(counts: UVec2, map_uv: DVec2) -> Option<Self> {
        let is_inside = map_uv.cmpge(DVec2::ZERO).all() && map_uv.cmple(DVec2::ONE).all();
        (is_inside && counts.min_element() > 0).then(|| Self {
            place: (map_uv * counts.as_dvec2()).as_uvec2().min(counts - 1),
            counts,
        })
    }

    /// Whether a place in the map belongs to this tile and to no other of its grid. A pixel that does not must leave
    /// the shadow result as it is: writing "lit" there would erase what other tiles have found (Giegl's border of
    /// farthest depths is right only where results are multiplied).
    pub fn contains(&self, map_uv: DVec2) -> bool {
        Self::at(self.counts, map_uv) == Some(*self)
    }

    /// Coordinates within the tile, 0..1 inside, v down.
    pub fn tile_uv(&self, map_uv: DVec2) -> DVec2 {
        map_uv * self.counts.as_dvec2() - self.place.as_dvec2()
    }

    /// Smallest and largest texture coordinates of the map within the tile.
    pub fn map_rect(&self) -> [DVec2; 2] {
        [0, 1].map(|end| (self.place + end).as_dvec2() / self.counts.as_dvec2())
    }

    /// The tiles of a grid `parts` times as fine that make up this one, row by row.
    pub fn children(&self, parts: UVec2) -> impl Iterator<Item = Self> {
        let (first, counts) = (self.place * parts, self.counts * parts);
        let places = (0..parts.y).flat_map(move |y| (0..parts.x).map(move |x| UVec2::new(x, y)));
        places.map(move |offset| Self {
            place: first + offset,
            counts,
        })
    }

    /// Whether another tile, of any grid, lies within this one.
    pub fn covers(&self, other: &Self) -> bool {
        // Cross-multiplied, so that no rounding is involved.
        let [own, of] = [self.counts, other.counts].map(|counts| counts.as_u64vec2());
        let (low, high) = (self.place.as_u64vec2() * of, (self.place + 1).as_u64vec2() * of);
        low.cmple(other.place.as_u64vec2() * own).all() && high.cmpge((other.place + 1).as_u64vec2() * own).all()
    }

    /// From the map's clip space to the tile's: the crop matrix of Giegl, section 3.3, which the thesis does not print.
    ///
    /// With n tiles on an axis and the tile's middle at c in −1..=1,
    ///
    /// ```text
    /// x_t = K (x − c w)      K = n core ÷ size      c_x = (2 column + 1) ÷ n − 1      c_y = 1 − (2 row + 1) ÷ n
    /// ```
    ///
    /// z and w stay: a tile's depths are the map's. It acts on clip coordinates before the division, so it holds for
    /// warped maps and for spot lights too. Without a margin K = n; with one the core of the texture shows the tile and
    /// the margin a little of its neighbours (section 3.5: "overlap θ/2").
    pub fn clip_from_map_clip(&self, window: &TileWindow) -> DMat4 {
        let counts = self.counts.as_dvec2();
        let shrink = window.core().as_dvec2() / window.size.as_dvec2();
        // Whole numbers up to here: exact.
        let shift = counts - 1.0 - 2.0 * self.place.as_dvec2();
        let (scale, shift) = (counts * shrink, shift * shrink);
        DMat4::from_cols(
            DVec4::new(scale.x, 0.0, 0.0, 0.0),
            DVec4::new(0.0, scale.y, 0.0, 0.0),
            DVec4::Z,
            DVec4::new(shift.x, -shift.y, 0.0, 1.0),
        )
    }

    /// The matrix that draws the tile: crop times the map's `clip_from_world`.
    ///
    /// Round it to single precision at the very end. Vertices then err by some 2⁻²³ R ÷ W of the map, with R the
    /// largest world coordinate and W the width of the map in metres: 1/64 of a texel of 131 072 for R = W, a quarter
    /// for R = 16 W. Where that is too much, draw relative to the camera.
    pub fn clip_from_world(&self, map_clip_from_world: &DMat4, window: &TileWindow) -> DMat4 {
        self.clip_from_map_clip(window) * *map_clip_from_world
    }

    /// Texture coordinates of the tile's texture for a place in the map: (margin + tile_uv · core) ÷ size. Inside 0..=1
    /// for places up to the margin beside the tile.
    pub fn texture_uv(&self, window: &TileWindow, map_uv: DVec2) -> DVec2 {
        (f64::from(window.margin) + self.tile_uv(map_uv) * window.core().as_dvec2()) / window.size.as_dvec2()
    }
}

/// The texture of a tile: a core that is the tile, and a margin for filters around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TileWindow {
    /// Texels of the texture, margins included.
    pub size: UVec2,
    /// Texels on each side that belong to the neighbours: g.
    pub margin: u32,
}

impl TileWindow {
    /// A texture of a given size; its core shrinks by the margins, and with it the effective resolution. The margin is
    /// reduced where it would leave no core.
    pub fn of_size(size: UVec2, margin: u32) -> Self {
        let size = size.max(UVec2::ONE);
        Self {
            size,
            margin: margin.min((size.min_element() - 1) / 2),
        }
    }

    /// A texture around a core: larger than it by the margins, so that the resolution is exactly that of the core.
    pub fn around(core: UVec2, margin: u32) -> Self {
        Self {
            size: core
                .max(UVec2::ONE)
                .saturating_add(UVec2::splat(margin.saturating_mul(2))),
            margin,
        }
    }

    /// Texels that represent the tile itself: size − 2 g.
    pub fn core(&self) -> UVec2 {
        self.size - 2 * self.margin
    }

    /// Texels of the texture.
    pub fn texels(&self) -> u64 {
        u64::from(self.size.x) * u64::from(self.size.y)
    }
}

/// The margin of a filter kernel that is `kernel` texels wide, θ: ⌈θ/2⌉ texels on each side, so that the taps of a
/// kernel anywhere in the tile lie in the tile's texture (Giegl, section 3.5). At most 256; zero for NaN and negative
/// widths.
///
/// The width is in texels of the tile. A kernel of constant width in the world is 2 times as many texels wide in a tile
/// of twice the resolution.
pub fn filter_margin(kernel: f64) -> u32 {
    (kernel * 0.5).ceil().clamp(0.0, 256.0) as u32
}
