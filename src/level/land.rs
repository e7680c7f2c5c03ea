//! [`Land`]: rolling ground of any size that is worked out where it is needed, and not stored.

use bevy_math::{Vec2, Vec3};

use super::{
    format::Hills,
    meshes::{MeshData, Rgb},
    noise,
};

/// Side of a square of the surface in metres.
const STEP: f32 = 20.0;
/// Squares along a side of a mesh tile.
const TILE: i32 = 16;

/// Heights on a lattice of 20 m, triangulated along the diagonal from the smallest to the largest corner of a square:
/// [`Land::height`] lies exactly on the mesh. At the origin the ground is at 0, whatever the seed. Absent hills: flat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Land {
    size: Vec2,
    hills: Option<Hills>,
    seed: u32,
}

impl Land {
    /// Land of this extent along x and z, centred on the origin. Of hills the rim is left out.
    #[must_use]
    pub fn new(size: Vec2, hills: Option<Hills>, seed: u64) -> Self {
        let seed = (seed ^ seed >> 32) as u32;
        Self { size, hills, seed }
    }

    /// Extent along x and z, centred on the origin.
    #[must_use]
    pub fn size(&self) -> Vec2 {
        self.size
    }

    /// Height of a corner of the lattice.
    fn corner(&self, i: i32, j: i32) -> f32 {
        let Some(hills) = self.hills else { return 0.0 };
        let noise = |p: Vec2| noise::octaves(self.seed, p / hills.wavelength, hills.octaves);
        // Noise rarely passes 0.6 of its bound.
        hills.amplitude * (noise(Vec2::new(i as f32, j as f32) * STEP) - noise(Vec2::ZERO)) / 0.6
    }

    /// Height at (x, z), also outside.
    #[must_use]
    pub fn height(&self, p: Vec2) -> f32 {
        if self.hills.is_none() {
            return 0.0;
        }
        let place = p / STEP;
        let f = place - place.floor();
        let [i, j] = place.floor().to_array().map(|v| v as i32);
        let (low, high) = (self.corner(i, j), self.corner(i + 1, j + 1));
        if f.x > f.y {
            let side = self.corner(i + 1, j);
            low + (side - low) * f.x + (high - side) * f.y
        } else {
            let side = self.corner(i, j + 1);
            low + (side - low) * f.y + (high - side) * f.x
        }
    }

    /// Smooth unit normal at (x, z).
    #[must_use]
    pub fn normal(&self, p: Vec2) -> Vec3 {
        let slope = |axis: Vec2| self.height(p + axis * STEP) - self.height(p - axis * STEP);
        Vec3::new(-slope(Vec2::X), 2.0 * STEP, -slope(Vec2::Y)).normalize()
    }

    /// The mesh in tiles, so that each can be culled: 320 m each, of whole squares around the extent.
    #[must_use]
    pub fn tiles(&self) -> Vec<MeshData> {
        let half = (self.size * 0.5 / STEP).ceil().as_ivec2();
        let along = |half: i32| {
            (-half..half)
                .step_by(TILE as usize)
                .map(move |from| from..(from + TILE).min(half))
        };
        let tile = |z: std::ops::Range<i32>| along(half.x).map(move |x| self.tile(x, z.clone()));
        along(half.y).flat_map(tile).collect()
    }

    fn tile(&self, x: std::ops::Range<i32>, z: std::ops::Range<i32>) -> MeshData {
        let mut mesh = MeshData::default();
        for j in z.start..=z.end {
            for i in x.start..=x.end {
                let p = Vec2::new(i as f32, j as f32) * STEP;
                let place = Vec3::new(p.x, self.corner(i, j), p.y);
                mesh.push_vertex(place, self.normal(p), self.color(i, j), Vec2::ZERO);
            }
        }
        let columns = (x.end - x.start + 1) as u32;
        for j in 0..(z.end - z.start) as u32 {
            for i in 0..columns - 1 {
                let a = j * columns + i;
                let (b, c, d) = (a + 1, a + columns, a + columns + 1);
                mesh.indices.extend([a, c, d, a, d, b]);
            }
        }
        mesh
    }

    /// Grass between leaves.
    fn color(&self, i: i32, j: i32) -> Rgb {
        let patches = 0.5 + 0.5 * noise::signed(self.seed ^ 77, i, j);
        let mix = |a: f32, b: f32| a + (b - a) * patches;
        [mix(0.105, 0.085), mix(0.125, 0.085), mix(0.045, 0.04)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::meshes::tests::assert_sane;

    fn land() -> Land {
        let hills = Hills {
            amplitude: 8.0,
            wavelength: 150.0,
            octaves: 3,
            rim_height: 0.0,
            rim_width: 0.0,
        };
        Land::new(Vec2::new(700.0, 390.0), Some(hills), 5)
    }

    #[test]
    fn height_lies_on_the_mesh() {
        let land = land();
        let mut area = 0.0;
        for tile in land.tiles() {
            assert_sane(&tile, "tile");
            for triangle in tile.indices.chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|k| tile.positions[triangle[k] as usize]);
                let double = (b - a).cross(c - a).y;
                assert!(double > 0.0, "a triangle looks down");
                area += 0.5 * double;
                for (u, v) in [(0.3, 0.3), (0.1, 0.8), (0.6, 0.1)] {
                    let p = a + (b - a) * u + (c - a) * v;
                    let height = land.height(Vec2::new(p.x, p.z));
                    assert!((height - p.y).abs() < 2e-3, "{p}: {height}");
                }
            }
        }
        // 720 by 400: whole squares.
        assert!((area - 720.0 * 400.0).abs() < 1.0, "{area}");
    }

    #[test]
    fn it_rolls_and_is_level_with_the_origin() {
        let heights = |land: &Land| -> Vec<f32> {
            (0..200)
                .map(|i| land.height(Vec2::new(i as f32 * 31.0 - 3000.0, i as f32 * 17.0)))
                .collect()
        };
        let found = heights(&land());
        let (low, high) = found
            .iter()
            .fold((0.0_f32, 0.0_f32), |(low, high), h| (low.min(*h), high.max(*h)));
        assert!(
            (-20.0..-2.0).contains(&low) && (2.0..20.0).contains(&high),
            "{low}..{high}"
        );
        assert_eq!(land().height(Vec2::ZERO), 0.0);
        let flat = Land { hills: None, ..land() };
        assert!(heights(&flat).iter().all(|height| *height == 0.0));
        assert_eq!(flat.normal(Vec2::ONE), Vec3::Y);
    }
}
