//! [`TiledMap`]: brute force, every tile at full size (Giegl, chapter 3). The reference for the other two.

use bevy_math::{DMat4, DVec2, UVec2};

use super::tile::{Tile, TileWindow, map_uv};
use crate::maths::polytope::Polytope;

/// Most tiles per axis that can be asked for. There are more where memory is short ([`TiledMap::within`]).
pub const MAX_TILES_PER_AXIS: u32 = 32;

/// A virtual map of n × n tiles that one texture shows one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TiledMap {
    /// n.
    pub tiles_per_axis: u32,
    /// The texture.
    pub window: TileWindow,
}

impl TiledMap {
    /// A map of `tiles_per_axis` (clamped to 1..=32) square textures of `tile_size` texels with a margin inside.
    pub fn new(tiles_per_axis: u32, tile_size: u32, margin: u32) -> Self {
        Self {
            tiles_per_axis: tiles_per_axis.clamp(1, MAX_TILES_PER_AXIS),
            window: TileWindow::of_size(UVec2::splat(tile_size), margin),
        }
    }

    /// All tiles, row by row from the top left. They fill the map without gap or overlap.
    pub fn tiles(&self) -> impl Iterator<Item = Tile> {
        Tile::WHOLE.children(UVec2::splat(self.tiles_per_axis))
    }

    /// Texels per axis of one map with the same texels: n · core, which is n · size only without a margin.
    pub fn effective_resolution(&self) -> u64 {
        u64::from(self.tiles_per_axis) * u64::from(self.window.core().x)
    }

    /// Texels drawn per frame: they grow with the square of n, while what the eye sees grows with its logarithm
    /// (section 3.6).
    pub fn texels(&self) -> u64 {
        u64::from(self.tiles_per_axis).pow(2) * self.window.texels()
    }

    /// The tiles in which something visible can lie, row by row: those that the outline of H = LVS touches in the map.
    ///
    /// The light view's projection takes the convex body to a convex outline, so a tile is apart from it exactly if a
    /// line along the tile's sides or along an edge of the outline separates them; edges of the body that are no edges
    /// of its outline give lines that separate nothing wrongly. Errs by 10⁻⁶ of the map on the side of drawing. Without
    /// a visible body there are no tiles. All tiles if a vertex lies behind the projection centre, which no fit leaves
    /// there.
    pub fn tiles_with_receivers(&self, clip_from_world: &DMat4, visible: &Polytope) -> Vec<Tile> {
        let places: Option<Vec<DVec2>> = (visible.vertices().iter())
            .map(|vertex| map_uv(clip_from_world, *vertex))
            .collect();
        let Some(places) = places else {
            return self.tiles().collect();
        };
        if places.is_empty() {
            return Vec::new();
        }
        let edges = visible.edges();
        let normals = edges.iter().filter_map(|edge| {
            let [start, end] = edge.map(|vertex| map_uv(clip_from_world, vertex));
            (end? - start?).perp().try_normalize()
        });
        let separators: Vec<Separator> = [DVec2::X, DVec2::Y]
            .into_iter()
            .chain(normals)
            .map(|axis| Separator::new(axis, &places))
            .collect();
        self.tiles()
            .filter(|tile| !separators.iter().any(|separator| separator.is_apart(tile)))
            .collect()
    }

    /// Tiles per axis to draw while the camera rests (section 3.7): one map in motion, then 2, 4, 8 … up to n, one step
    /// per frame. `still_frames` counts the frames since the last change of camera, light or scene; 0 is motion.
    pub fn progressive_tiles_per_axis(&self, still_frames: u32) -> u32 {
        1_u32
            .checked_shl(still_frames)
            .map_or(self.tiles_per_axis, |tiles| tiles.min(self.tiles_per_axis))
    }
}

/// A direction of the map and the interval that the outline has on it.
struct Separator {
    axis: DVec2,
    low: f64,
    high: f64,
}

impl Separator {
    fn new(axis: DVec2, places: &[DVec2]) -> Self {
        let spans = places.iter().map(|place| place.dot(axis));
        let (low, high) = spans.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), span| {
            (low.min(span), high.max(span))
        });
        Self {
            axis,
            low: low - TOLERANCE,
            high: high + TOLERANCE,
        }
    }

    fn is_apart(&self, tile: &Tile) -> bool {
        let [min, max] = tile.map_rect();
        let (middle, half) = ((min + max).dot(self.axis) * 0.5, (max - min).dot(self.axis.abs()) * 0.5);
        middle - half > self.high || middle + half < self.low
    }
}

/// Shares of the map by which a tile may miss the outline and still be drawn.
const TOLERANCE: f64 = 1.0e-6;
