//! [`Land`]: rolling ground of any size that is worked out where it is needed, and not stored.
//!
//! It is drawn in patches with levels of detail: squares of 20, 40 and 80 m. Each vertex of a level knows where it lies in
//! the next coarser one, so that patches may morph. Skirts hang from their edges, as neighbours may show other levels.

use std::ops::Range;

use bevy_math::{IVec2, Vec2, Vec3};

use super::{
    format::Hills,
    meshes::Rgb,
    noise,
    scenery::{Correspondence, Patch, PatchLevel},
};

/// Side of a square of the surface in metres.
const STEP: f32 = 20.0;
/// Squares along a side of a patch.
const PATCH: i32 = 16;
/// Levels of a patch of whole squares of the coarsest one.
const LEVELS: u32 = 3;
/// Where they end, metres from the middle of a patch: 2 and 4 times its side, where what a hill loses is of a pixel.
const LEVEL_ENDS: [f64; LEVELS as usize - 1] = [640.0, 1280.0];
/// How far a skirt reaches below the lowest level, metres.
const HEM: f32 = 0.5;

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

    /// Corners of the lattice from the middle of the land to its ends.
    fn half(&self) -> IVec2 {
        (self.size * 0.5 / STEP).ceil().as_ivec2()
    }

    /// The first corner of the square of `step` corners that a corner lies in. Squares of all levels begin where the land
    /// does, as patches do.
    fn low_corner(&self, corner: IVec2, step: i32) -> IVec2 {
        (corner + self.half()).div_euclid(IVec2::splat(step)) * step - self.half()
    }

    /// Height at a corner of the lattice in a level of squares of `step` corners: a plane between its own.
    fn level_height(&self, corner: IVec2, step: i32) -> f32 {
        let low = self.low_corner(corner, step);
        let f = (corner - low).as_vec2() / step as f32;
        let at = |x: i32, z: i32| self.corner(low.x + x, low.y + z);
        let (first, last) = (at(0, 0), at(step, step));
        if f == Vec2::ZERO {
            first
        } else if f.x > f.y {
            let side = at(step, 0);
            first + (side - first) * f.x + (last - side) * f.y
        } else {
            let side = at(0, step);
            first + (side - first) * f.y + (last - side) * f.x
        }
    }

    /// What is drawn: patches of 320 m, so that each can be culled, of whole squares around the extent.
    #[must_use]
    pub fn patches(&self) -> Vec<Patch> {
        let half = self.half();
        let along = |half: i32| {
            (-half..half)
                .step_by(PATCH as usize)
                .map(move |from| from..(from + PATCH).min(half))
        };
        let patch = |z: Range<i32>| along(half.x).map(move |x| self.patch(x, z.clone()));
        along(half.y).flat_map(patch).collect()
    }

    fn patch(&self, x: Range<i32>, z: Range<i32>) -> Patch {
        let corner = |ends: [i32; 2]| Vec2::new(ends[0] as f32, ends[1] as f32) * STEP;
        let middle = 0.5 * (corner([x.start, z.start]) + corner([x.end, z.end]));
        let origin = Vec3::new(middle.x, self.height(middle), middle.y);
        let steps: Vec<i32> = (0..LEVELS)
            .map(|level| 1 << level)
            .filter(|step| x.len() as i32 % step == 0 && z.len() as i32 % step == 0)
            .collect();
        let depth = HEM + self.largest_error(&x, &z, *steps.last().unwrap_or(&1));
        let level =
            |(i, step): (usize, &i32)| self.level([x.clone(), z.clone()], *step, steps.get(i + 1), origin, depth);
        Patch {
            name: "land",
            origin,
            levels: steps.iter().enumerate().map(level).collect(),
            ends: LEVEL_ENDS[..steps.len() - 1].to_vec(),
        }
    }

    /// How far a level lies from the finest one on the edges, at most.
    fn largest_error(&self, x: &Range<i32>, z: &Range<i32>, step: i32) -> f32 {
        let along_x = (x.start..=x.end).flat_map(|i| [IVec2::new(i, z.start), IVec2::new(i, z.end)]);
        let along_z = (z.start..=z.end).flat_map(|j| [IVec2::new(x.start, j), IVec2::new(x.end, j)]);
        let error = |corner: IVec2| (self.level_height(corner, step) - self.corner(corner.x, corner.y)).abs();
        along_x.chain(along_z).map(error).fold(0.0, f32::max)
    }

    /// One level, in its own space. `coarser`: the step of the next one.
    fn level(&self, [x, z]: [Range<i32>; 2], step: i32, coarser: Option<&i32>, origin: Vec3, depth: f32) -> PatchLevel {
        let mut level = PatchLevel::default();
        let mut push = |i: i32, j: i32, down: f32| {
            let p = Vec2::new(i as f32, j as f32) * STEP;
            let height = self.corner(i, j);
            let place = Vec3::new(p.x, height - down, p.y) - origin;
            let normal = self.normal(p);
            if let Some(coarser) = coarser {
                let there = self.level_height(IVec2::new(i, j), *coarser);
                level.coarser.push(Correspondence {
                    position: Vec3::Y * (there - height),
                    normal: self.level_normal(IVec2::new(i, j), *coarser) - normal,
                });
            }
            level.mesh.push_vertex(place, normal, self.color(i, j), Vec2::ZERO)
        };
        let columns = x.len() as u32 / step as u32 + 1;
        let rows = z.len() as u32 / step as u32 + 1;
        let at = |column: u32, row: u32| (x.start + column as i32 * step, z.start + row as i32 * step);
        for row in 0..rows {
            for column in 0..columns {
                let (i, j) = at(column, row);
                push(i, j, 0.0);
            }
        }
        // Around the edge, counter-clockwise seen from above: the outside is to the right.
        let edge: Vec<(u32, u32)> = (0..rows - 1)
            .map(|row| (0, row))
            .chain((0..columns - 1).map(|column| (column, rows - 1)))
            .chain((1..rows).rev().map(|row| (columns - 1, row)))
            .chain((1..columns).rev().map(|column| (column, 0)))
            .collect();
        let hem: Vec<u32> = edge
            .iter()
            .map(|(column, row)| {
                let (i, j) = at(*column, *row);
                push(i, j, depth)
            })
            .collect();
        let indices = &mut level.mesh.indices;
        for row in 0..rows - 1 {
            for column in 0..columns - 1 {
                let a = row * columns + column;
                let (b, c, d) = (a + 1, a + columns, a + columns + 1);
                indices.extend([a, c, d, a, d, b]);
            }
        }
        for k in 0..edge.len() {
            let next = (k + 1) % edge.len();
            let top = |k: usize| edge[k].1 * columns + edge[k].0;
            indices.extend([top(k), hem[k], hem[next], top(k), hem[next], top(next)]);
        }
        level
    }

    /// Smooth unit normal of a level at a corner of the lattice: between those of its own corners.
    fn level_normal(&self, corner: IVec2, step: i32) -> Vec3 {
        let low = self.low_corner(corner, step);
        let f = (corner - low).as_vec2() / step as f32;
        let at = |x: i32, z: i32| self.normal((low + IVec2::new(x, z)).as_vec2() * STEP);
        let side = if f.x > f.y { at(step, 0) } else { at(0, step) };
        let (long, short) = (f.max_element(), f.min_element());
        (at(0, 0) * (1.0 - long) + side * (long - short) + at(step, step) * short).normalize()
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
    use crate::level::meshes::{MeshData, tests::assert_sane};

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
    fn height_lies_on_the_finest_level() {
        let land = land();
        let mut area = 0.0;
        for patch in land.patches() {
            let mesh = &patch.levels[0].mesh;
            assert_sane(mesh, "patch");
            for triangle in mesh.indices.chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[triangle[k] as usize] + patch.origin);
                let double = (b - a).cross(c - a).y;
                assert!(double > -1e-2, "a triangle looks down");
                area += 0.5 * double;
                for (u, v) in [(0.3, 0.3), (0.1, 0.8), (0.6, 0.1)] {
                    let p = a + (b - a) * u + (c - a) * v;
                    let height = land.height(Vec2::new(p.x, p.z));
                    // Skirts hang down.
                    assert!((height - p.y).abs() < 2e-3 || double < 1e-2, "{p}: {height}");
                }
            }
        }
        // 720 by 400: whole squares.
        assert!((area - 720.0 * 400.0).abs() < 1.0, "{area}");
    }

    /// Morphed all the way, a level is the next coarser one: every vertex lies on it, with its normal at shared ones.
    #[test]
    fn levels_correspond() {
        let land = land();
        let mut with_levels = 0;
        for patch in land.patches() {
            assert_eq!(patch.ends.len() + 1, patch.levels.len());
            with_levels += usize::from(patch.levels.len() == 3);
            for pair in patch.levels.windows(2) {
                let [fine, coarse] = pair else {
                    unreachable!("windows of two")
                };
                assert!(coarse.mesh.indices.len() < fine.mesh.indices.len());
                assert_eq!(fine.coarser.len(), fine.mesh.positions.len());
                let surface = surface_count(&fine.mesh);
                for index in 0..fine.mesh.positions.len() {
                    let moved = fine.mesh.positions[index] + fine.coarser[index].position;
                    let normal = fine.mesh.normals[index] + fine.coarser[index].normal;
                    assert!((normal.length() - 1.0).abs() < 1e-3);
                    if index >= surface {
                        continue;
                    }
                    let height = height_on(&coarse.mesh, moved).expect("a triangle below");
                    assert!((height - moved.y).abs() < 2e-3, "{moved}: {height}");
                }
            }
            assert!(patch.levels.last().is_some_and(|last| last.coarser.is_empty()));
        }
        assert!(with_levels >= 1, "{with_levels} patches with all levels");
    }

    /// Vertices before those of the skirt: those that triangles which look up use.
    fn surface_count(mesh: &MeshData) -> usize {
        let up = mesh.indices.chunks(3).filter(|triangle| {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[triangle[k] as usize]);
            (b - a).cross(c - a).y > 1.0
        });
        up.flatten().max().map_or(0, |last| *last as usize + 1)
    }

    /// Height of the surface below or above a point.
    fn height_on(mesh: &MeshData, p: Vec3) -> Option<f32> {
        mesh.indices.chunks(3).find_map(|triangle| {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[triangle[k] as usize]);
            let area = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).y;
            let whole = area(a, b, c);
            if whole < 1.0 {
                return None;
            }
            let weights = [area(p, b, c), area(a, p, c), area(a, b, p)].map(|part| part / whole);
            let is_in = weights.iter().all(|weight| *weight > -1e-4);
            is_in.then(|| a.y * weights[0] + b.y * weights[1] + c.y * weights[2])
        })
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
