//! [`Terrain`]: a height field with tracks and clearings, and its mesh.

use bevy_math::{Vec2, Vec3, Vec4};

use super::{
    cover::{Cover, TILES},
    format::{Clearing, TerrainShape, TrackShape},
    meshes::{MeshData, Rgb},
    noise,
};

/// Side of a grid cell in metres.
pub const CELL: f32 = 2.0;
/// Cells along a side of a mesh tile.
const TILE: usize = 40;
/// Width of a pond's bank in metres.
const BANK: f32 = 3.0;
/// How far a pond's water stands below the ground around it, in metres.
const FREEBOARD: f32 = 0.4;
/// Corners of a pond's water.
const POND_SIDES: u32 = 48;
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
    /// The path of a level file.
    fn new(shape: &TrackShape) -> Self {
        let free = shape.fence.map_or(0.0, |fence| fence.offset).max(0.5 * shape.width);
        Self::along(&shape.points, shape.width, free)
    }

    /// The curve through corners (Catmull and Rom).
    fn along(corners: &[Vec2], width: f32, free: f32) -> Self {
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
            width,
            free,
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
                let height = shape.clearings.iter().fold(level(p), |height, clearing| {
                    let Some(pond) = clearing.pond else { return height };
                    let distance = p.distance(clearing.center);
                    let inside = 1.0 - smoothstep(0.6 * pond.radius, pond.radius + BANK, distance);
                    height - (pond.depth + FREEBOARD) * inside
                });
                let height = tracks.iter().fold(height, |height, track| {
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

    /// The water of a pond: a disc that reaches under its shore. `None`: a clearing without pond.
    pub fn water(&self, clearing: &Clearing) -> Option<MeshData> {
        let pond = clearing.pond?;
        let mut mesh = MeshData::default();
        let bank = self.height(clearing.center) + pond.depth;
        let place = |offset: Vec2| {
            let p = clearing.center + offset;
            Vec3::new(p.x, bank, p.y)
        };
        mesh.push_vertex(place(Vec2::ZERO), Vec3::Y, [1.0; 3], Vec2::ZERO);
        for side in 0..POND_SIDES {
            let angle = std::f32::consts::TAU * side as f32 / POND_SIDES as f32;
            let rim = place(Vec2::from_angle(angle) * (pond.radius + BANK));
            mesh.push_vertex(rim, Vec3::Y, [1.0; 3], Vec2::ZERO);
            let next = (side + 1) % POND_SIDES;
            mesh.indices.extend([0, next + 1, side + 1]);
        }
        Some(mesh)
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

    /// Forest floor, grass, trodden path and rock at a place; their sum is the brightness.
    fn weights(&self, p: Vec2, normal: Vec3) -> [f32; TILES] {
        let patches = smoothstep(-0.1, 0.45, noise::octaves(self.seed ^ 77, p / 19.0, 3));
        let meadow = self
            .clearings
            .iter()
            .map(|c| 1.0 - smoothstep(0.7 * c.radius, 1.35 * c.radius, p.distance(c.center)));
        let grass = (0.8 * patches).max(meadow.fold(0.0, f32::max));
        let steep = smoothstep(0.42, 0.7, 1.0 - normal.y.powi(2));
        let mut weights = Vec4::new(1.0 - grass, grass, 0.0, 0.0).lerp(Vec4::W, steep);
        for track in &self.tracks {
            let half = 0.5 * track.width;
            let trodden = 1.0 - smoothstep(half - 0.6, half + 1.4, track.distance(p));
            weights = weights.lerp(Vec4::Z, trodden);
        }
        for clearing in &self.clearings {
            let Some(pond) = clearing.pond else { continue };
            let distance = p.distance(clearing.center);
            let washed = 1.0 - smoothstep(0.8 * pond.radius, pond.radius + 0.6 * BANK, distance);
            weights = weights.lerp(Vec4::new(0.2, 0.0, 0.5, 0.3) * 0.6, washed);
        }
        let broad = noise::octaves(self.seed ^ 78, p / 31.0, 3);
        let fine = noise::signed(self.seed, (p.x * 8.0) as i32, (p.y * 8.0) as i32);
        (weights * (1.0 + 0.35 * broad + 0.06 * fine)).to_array()
    }

    /// What lies on the tiles of [`tiles`](Self::tiles), in the same order.
    pub fn covers(&self) -> Vec<Cover> {
        let cover = |mesh: &MeshData| Cover {
            tiles: ["forest_floor", "grass", "path", "rock"],
            weights: (mesh.positions.iter().zip(&mesh.normals))
                .map(|(p, normal)| self.weights(Vec2::new(p.x, p.z), *normal))
                .collect(),
        };
        self.tiles().iter().map(cover).collect()
    }

    /// The colour of a place without tiles.
    fn color(&self, p: Vec2, normal: Vec3) -> Rgb {
        let colors = [
            Vec3::new(0.11, 0.085, 0.05),
            Vec3::new(0.10, 0.17, 0.035),
            Vec3::new(0.30, 0.23, 0.15),
            Vec3::new(0.26, 0.25, 0.23),
        ];
        let weights = self.weights(p, normal);
        let color: Vec3 = colors
            .into_iter()
            .zip(weights)
            .map(|(color, weight)| color * weight)
            .sum();
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
            clearings: vec![
                Clearing {
                    center: Vec2::new(-20.0, 10.0),
                    radius: 12.0,
                    pond: None,
                },
                Clearing {
                    center: Vec2::new(30.0, 22.0),
                    radius: 14.0,
                    pond: Some(Pond {
                        radius: 5.0,
                        depth: 1.0,
                    }),
                },
            ],
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
    fn a_pond_holds_its_water() {
        let terrain = Terrain::new(&shape(), 3);
        let clearing = terrain.clearings()[1];
        let pond = clearing.pond.unwrap();
        let water = terrain.water(&clearing).unwrap();
        let surface = water.positions[0].y;
        assert!((surface - terrain.height(clearing.center) - pond.depth).abs() < 0.1);
        for step in 0..24 {
            let out = Vec2::from_angle(std::f32::consts::TAU * step as f32 / 24.0);
            let at = |distance: f32| terrain.height(clearing.center + out * distance);
            assert!(at(0.5 * pond.radius) < surface - 0.5 * pond.depth, "shallow at {out}");
            assert!(at(pond.radius + BANK) > surface + 0.1, "water over the bank at {out}");
        }
        for triangle in water.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| water.positions[triangle[k] as usize]);
            assert!((b - a).cross(c - a).y > 0.0, "water looks down");
        }
    }

    #[test]
    fn weights_say_what_lies_where() {
        let terrain = Terrain::new(&shape(), 3);
        let most = |p: Vec2| {
            let weights = terrain.weights(p, Vec3::Y);
            (0..TILES).max_by(|a, b| weights[*a].total_cmp(&weights[*b])).unwrap()
        };
        assert_eq!(most(terrain.tracks()[0].points[12]), 2);
        assert_eq!(most(Vec2::new(30.0, 22.0)), 2);
        assert_eq!(most(Vec2::new(-20.0, 10.0)), 1);
        assert_eq!(terrain.covers().len(), terrain.tiles().len());
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
