//! [`Terrain`]: a height field with tracks and clearings, and its mesh.

use bevy_math::{Vec2, Vec3};

use super::{
    format::{Clearing, TerrainShape, TrackShape},
    meshes::{MeshData, Rgb},
    noise,
};

/// Side of a grid cell in metres.
pub const CELL: f32 = 2.0;
/// Cells along a side of a mesh tile.
const TILE: usize = 40;
/// How far from its edge a track pulls the ground level, in metres.
const SHOULDER: f32 = 5.0;

/// Heights on a grid of [`CELL`], triangulated along the diagonal from the smallest to the largest corner of a cell:
/// [`Terrain::height`] lies exactly on the mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    size: Vec2,
    cells: [usize; 2],
    heights: Vec<f32>,
    tracks: Vec<Track>,
    clearings: Vec<Clearing>,
    seed: u32,
}

/// A smooth path on the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Points (x, z), at most 2 m apart.
    pub points: Vec<Vec2>,
    /// Ground height at the points, smoothed.
    heights: Vec<f32>,
    /// Trodden width.
    pub width: f32,
    /// Distance from the middle that plants keep: half the width, or the fence if that is farther.
    pub free: f32,
}

impl Track {
    /// The curve through the points of a level file (Catmull and Rom).
    fn new(shape: &TrackShape) -> Self {
        let corners = &shape.points;
        let at = |i: isize| corners[i.clamp(0, corners.len() as isize - 1) as usize];
        let mut points = vec![corners[0]];
        for i in 0..corners.len() as isize - 1 {
            let (a, b, c, d) = (at(i - 1), at(i), at(i + 1), at(i + 2));
            let steps = ((c - b).length() / 1.5).ceil().max(1.0) as u32;
            for step in 1..=steps {
                let t = step as f32 / steps as f32;
                let curve = b * 2.0
                    + (c - a) * t
                    + (a * 2.0 - b * 5.0 + c * 4.0 - d) * (t * t)
                    + (b * 3.0 - a - c * 3.0 + d) * (t * t * t);
                points.push(curve * 0.5);
            }
        }
        Self {
            heights: vec![0.0; points.len()],
            points,
            width: shape.width,
            free: shape.fence.map_or(0.0, |fence| fence.offset).max(0.5 * shape.width),
        }
    }

    /// Distance from the middle of the track, and the track's height there.
    fn nearest(&self, p: Vec2) -> (f32, f32) {
        let mut best = (f32::MAX, 0.0);
        for i in 1..self.points.len() {
            let (a, b) = (self.points[i - 1], self.points[i]);
            let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            let distance = p.distance_squared(a + (b - a) * t);
            if distance < best.0 {
                best = (
                    distance,
                    self.heights[i - 1] + (self.heights[i] - self.heights[i - 1]) * t,
                );
            }
        }
        (best.0.sqrt(), best.1)
    }

    /// Distance from the middle of the track.
    pub fn distance(&self, p: Vec2) -> f32 {
        self.nearest(p).0
    }
}

/// 0 below `low`, 1 above `high`, smooth between.
fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Terrain {
    /// Builds the height field.
    pub fn new(shape: &TerrainShape, seed: u64) -> Self {
        let seed = (seed ^ (seed >> 32)) as u32;
        let cells = [shape.size.x, shape.size.y].map(|side| (side / CELL).ceil().max(1.0) as usize);
        let mut terrain = Self {
            size: Vec2::new(cells[0] as f32, cells[1] as f32) * CELL,
            cells,
            heights: Vec::new(),
            tracks: shape.tracks.iter().map(Track::new).collect(),
            clearings: shape.clearings.clone(),
            seed,
        };
        let raw = |p: Vec2| Self::raw_height(shape, seed, terrain.size, p);
        let level = |p: Vec2| {
            shape.clearings.iter().fold(raw(p), |height, clearing| {
                let inside = 1.0
                    - smoothstep(
                        0.7 * clearing.radius,
                        1.6 * clearing.radius,
                        p.distance(clearing.center),
                    );
                if inside > 0.0 {
                    height + (raw(clearing.center) - height) * inside
                } else {
                    height
                }
            })
        };
        let mut tracks = terrain.tracks.clone();
        for track in &mut tracks {
            let heights: Vec<f32> = track.points.iter().map(|p| level(*p)).collect();
            // A mean over about 12 m: people cut and fill when they walk.
            track.heights = (0..heights.len())
                .map(|i| {
                    let near = &heights[i.saturating_sub(4)..(i + 5).min(heights.len())];
                    near.iter().sum::<f32>() / near.len() as f32
                })
                .collect();
        }
        let mut heights = Vec::with_capacity((cells[0] + 1) * (cells[1] + 1));
        for j in 0..=cells[1] {
            for i in 0..=cells[0] {
                let p = terrain.corner(i, j);
                let height = tracks.iter().fold(level(p), |height, track| {
                    let (distance, trodden) = track.nearest(p);
                    let inside =
                        1.0 - smoothstep(0.5 * track.width + CELL, 0.5 * track.width + CELL + SHOULDER, distance);
                    height + (trodden - height) * inside
                });
                heights.push(height);
            }
        }
        terrain.tracks = tracks;
        terrain.heights = heights;
        terrain
    }

    fn raw_height(shape: &TerrainShape, seed: u32, size: Vec2, p: Vec2) -> f32 {
        let Some(hills) = shape.hills else { return 0.0 };
        let noise = noise::octaves(seed, p / hills.wavelength, hills.octaves);
        let edge = (size * 0.5 - p.abs()).min_element();
        let rim = if hills.rim_width > 0.0 {
            1.0 - smoothstep(0.0, hills.rim_width, edge)
        } else {
            0.0
        };
        // Noise rarely passes 0.6 of its bound.
        hills.amplitude * noise / 0.6 + hills.rim_height * rim
    }

    /// Place of a grid corner (x, z).
    fn corner(&self, i: usize, j: usize) -> Vec2 {
        Vec2::new(i as f32, j as f32) * CELL - self.size * 0.5
    }

    fn at(&self, i: usize, j: usize) -> f32 {
        self.heights[j * (self.cells[0] + 1) + i]
    }

    /// Extent along x and z: the asked size rounded up to whole cells.
    pub fn size(&self) -> Vec2 {
        self.size
    }

    /// The tracks.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// The clearings.
    pub fn clearings(&self) -> &[Clearing] {
        &self.clearings
    }

    /// The cell of a place, and where in it (0..=1); places outside are moved to the edge.
    fn locate(&self, p: Vec2) -> ([usize; 2], Vec2) {
        let grid = ((p + self.size * 0.5) / CELL).clamp(Vec2::ZERO, self.size / CELL);
        let cell = [grid.x, grid.y].map(|v| v as usize);
        let cell = [cell[0].min(self.cells[0] - 1), cell[1].min(self.cells[1] - 1)];
        (cell, grid - Vec2::new(cell[0] as f32, cell[1] as f32))
    }

    /// Height of the mesh at (x, z); outside, that of the nearest edge.
    pub fn height(&self, p: Vec2) -> f32 {
        let ([i, j], f) = self.locate(p);
        let (low, high) = (self.at(i, j), self.at(i + 1, j + 1));
        if f.x > f.y {
            let side = self.at(i + 1, j);
            low + (side - low) * f.x + (high - side) * f.y
        } else {
            let side = self.at(i, j + 1);
            low + (side - low) * f.y + (high - side) * f.x
        }
    }

    /// Smooth unit normal at (x, z).
    pub fn normal(&self, p: Vec2) -> Vec3 {
        let slope = |axis: Vec2| self.height(p + axis * CELL) - self.height(p - axis * CELL);
        Vec3::new(-slope(Vec2::X), 2.0 * CELL, -slope(Vec2::Y)).normalize()
    }

    /// The mesh in tiles, so that each can be culled; together one closed sheet with outward side up.
    pub fn tiles(&self) -> Vec<MeshData> {
        let mut tiles = Vec::new();
        for tile_j in (0..self.cells[1]).step_by(TILE) {
            for tile_i in (0..self.cells[0]).step_by(TILE) {
                tiles.push(self.tile([tile_i, tile_j]));
            }
        }
        tiles
    }

    fn tile(&self, first: [usize; 2]) -> MeshData {
        let mut mesh = MeshData::default();
        let last = [0, 1].map(|k| (first[k] + TILE).min(self.cells[k]));
        for j in first[1]..=last[1] {
            for i in first[0]..=last[0] {
                let p = self.corner(i, j);
                let normal = self.normal(p);
                mesh.push_vertex(
                    Vec3::new(p.x, self.at(i, j), p.y),
                    normal,
                    self.color(p, normal),
                    Vec2::ZERO,
                );
            }
        }
        let columns = (last[0] - first[0] + 1) as u32;
        for j in 0..(last[1] - first[1]) as u32 {
            for i in 0..columns - 1 {
                let a = j * columns + i;
                let (b, c, d) = (a + 1, a + columns, a + columns + 1);
                mesh.indices.extend([a, c, d, a, d, b]);
            }
        }
        mesh
    }

    /// Grass, dry grass, earth and rock.
    fn color(&self, p: Vec2, normal: Vec3) -> Rgb {
        let grass = Vec3::new(0.10, 0.17, 0.035);
        let dry = Vec3::new(0.24, 0.23, 0.075);
        let litter = Vec3::new(0.13, 0.095, 0.05);
        let earth = Vec3::new(0.33, 0.25, 0.16);
        let stone = Vec3::new(0.26, 0.25, 0.23);
        let patches = smoothstep(-0.25, 0.35, noise::octaves(self.seed ^ 77, p / 19.0, 3));
        let meadow = self
            .clearings
            .iter()
            .map(|c| 1.0 - smoothstep(0.8 * c.radius, 1.4 * c.radius, p.distance(c.center)));
        let meadow = meadow.fold(0.0, f32::max);
        let mut color = litter.lerp(grass, patches.max(meadow));
        color = color.lerp(
            dry,
            0.6 * smoothstep(0.0, 0.5, noise::octaves(self.seed ^ 78, p / 31.0, 3)),
        );
        color = color.lerp(stone, smoothstep(0.55, 0.75, 1.0 - normal.y.powi(2)));
        for track in &self.tracks {
            let half = 0.5 * track.width;
            color = color.lerp(earth, 1.0 - smoothstep(half - 0.6, half + 1.4, track.distance(p)));
        }
        color *= 1.0 + 0.18 * noise::signed(self.seed, (p.x * 8.0) as i32, (p.y * 8.0) as i32);
        color.clamp(Vec3::ZERO, Vec3::ONE).to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::{format::*, meshes::tests::assert_sane};

    fn shape() -> TerrainShape {
        TerrainShape {
            size: Vec2::new(120.0, 90.0),
            hills: Some(Hills {
                amplitude: 8.0,
                wavelength: 50.0,
                octaves: 4,
                rim_height: 6.0,
                rim_width: 20.0,
            }),
            clearings: vec![Clearing {
                center: Vec2::new(-20.0, 10.0),
                radius: 12.0,
            }],
            tracks: vec![TrackShape {
                width: 3.0,
                points: vec![Vec2::new(-55.0, -20.0), Vec2::new(0.0, 5.0), Vec2::new(50.0, -10.0)],
                fence: None,
            }],
        }
    }

    #[test]
    fn height_lies_on_the_mesh() {
        let terrain = Terrain::new(&shape(), 3);
        for tile in terrain.tiles() {
            assert_sane(&tile, "tile");
            for triangle in tile.indices.chunks(3).step_by(7) {
                let [a, b, c] = [0, 1, 2].map(|k| tile.positions[triangle[k] as usize]);
                assert!((b - a).cross(c - a).y > 0.0, "a triangle looks down");
                for (u, v) in [(0.3, 0.3), (0.1, 0.8), (0.6, 0.1)] {
                    let p = a + (b - a) * u + (c - a) * v;
                    let height = terrain.height(Vec2::new(p.x, p.z));
                    assert!((height - p.y).abs() < 1e-3, "{p}: {height}");
                }
            }
        }
    }

    #[test]
    fn tiles_cover_the_terrain_once() {
        let terrain = Terrain::new(&shape(), 3);
        let area: f32 = terrain
            .tiles()
            .iter()
            .flat_map(|tile| {
                tile.indices
                    .chunks(3)
                    .map(|t| [0, 1, 2].map(|k| tile.positions[t[k] as usize]))
                    .collect::<Vec<_>>()
            })
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).y)
            .sum();
        assert!((area - 120.0 * 90.0).abs() < 1.0, "{area}");
    }

    #[test]
    fn a_track_is_level_across_and_a_clearing_is_level() {
        let terrain = Terrain::new(&shape(), 3);
        let track = &terrain.tracks()[0];
        for i in (10..track.points.len() - 10).step_by(5) {
            let across = (track.points[i + 1] - track.points[i - 1]).normalize().perp() * 1.5;
            let (left, right) = (
                terrain.height(track.points[i] + across),
                terrain.height(track.points[i] - across),
            );
            assert!((left - right).abs() < 0.35, "{left} {right}");
        }
        let middle = terrain.height(Vec2::new(-20.0, 10.0));
        for offset in [Vec2::new(4.0, 5.0), Vec2::new(-6.0, 4.0), Vec2::new(0.0, 8.0)] {
            let height = terrain.height(Vec2::new(-20.0, 10.0) + offset);
            assert!((height - middle).abs() < 0.5, "{height} {middle}");
        }
    }

    #[test]
    fn places_outside_have_the_edge_s_height() {
        let terrain = Terrain::new(&shape(), 3);
        assert_eq!(
            terrain.height(Vec2::new(1e9, 0.0)),
            terrain.height(Vec2::new(60.0, 0.0))
        );
        assert!(terrain.height(Vec2::splat(-1e9)).is_finite());
    }

    #[test]
    fn the_seed_changes_the_hills() {
        assert_eq!(Terrain::new(&shape(), 3), Terrain::new(&shape(), 3));
        assert_ne!(Terrain::new(&shape(), 3).heights, Terrain::new(&shape(), 4).heights);
    }
}
