//! [`Grove`]: trees on a lattice, up to a million, that are worked out where they are needed and not stored.
//!
//! ```text
//! Grove, lattice place ─► tree          the same on every machine, whatever was asked before
//! Grove, cell          ─► block         one mesh for all trees of a cell, coarser for larger cells
//! eyes, distances      ─► open cells    near leaves: entities with chains of levels; all else: one entity per block
//! ```
//!
//! A tree that belongs to a block and one that stands alone in its last level have the same triangles at the same place
//! ([`blocks`]), so that leaves open and close unseen. Blocks of different sizes fade into each other like the levels of any
//! object: an open cell has a [`LodChain`](crate::lod::chain::LodChain) of its children's blocks and its own ([`field`]).
//!
//! Memory: less than 100 bytes for the grove itself, however many trees; what is near is entities and meshes, whose number grows with
//! the logarithm of the side.

use bevy_math::{DVec2, Vec2, Vec3};

use super::{
    ground::Blocker,
    land::Land,
    model::{Model, Placement},
    noise,
    simple_trees::{SimpleTree, VARIANTS},
};
use crate::maths::lod::cells::{Cell, CellBorders, CellGrid};

pub mod blocks;
pub mod field;
pub mod wind;

/// Trees along a side of a leaf.
pub const LEAF_TREES: u32 = 8;

/// How far trees are off their places on the lattice, at most, as a share of its spacing.
const JITTER: f32 = 0.3;

/// A square lattice of trees on rolling land, filled row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grove {
    count: u32,
    spacing: f32,
    seed: u32,
    land: Land,
    wind: f32,
}

impl Grove {
    /// So many trees at a spacing in metres.
    #[must_use]
    pub fn new(count: u32, spacing: f32, seed: u64, land: Land) -> Self {
        Self {
            count,
            spacing,
            seed: (seed ^ seed >> 32) as u32,
            land,
            wind: 0.0,
        }
    }

    /// The same in wind of so many metres per second along +x; 0: none. Useful 0..=20.
    #[must_use]
    pub fn in_wind(self, speed: f32) -> Self {
        Self { wind: speed, ..self }
    }

    /// Metres per second.
    #[must_use]
    pub fn wind(&self) -> f32 {
        self.wind
    }

    /// Trees.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// What they stand on.
    #[must_use]
    pub fn land(&self) -> &Land {
        &self.land
    }

    /// Trees along a side of the lattice.
    #[must_use]
    pub fn side(&self) -> u32 {
        side(self.count)
    }

    /// The smallest (x, z): whole spacings from the origin, which lies between trees.
    fn corner(&self) -> Vec2 {
        Vec2::splat(-((self.side() / 2) as f32) * self.spacing)
    }

    /// The tree at a place of the lattice; `None` where none is left.
    #[must_use]
    pub fn tree(&self, [x, z]: [u32; 2]) -> Option<Placement> {
        let side = self.side();
        if x >= side || u64::from(z) * u64::from(side) + u64::from(x) >= u64::from(self.count) {
            return None;
        }
        let die = |number: u32| noise::signed(self.seed.wrapping_add(number), x as i32, z as i32);
        let kind = [
            SimpleTree::Conifer,
            SimpleTree::Birch,
            SimpleTree::Conifer,
            SimpleTree::Dead,
        ][face(die(0), 4) as usize];
        let model = Model::SimpleTree(kind, face(die(1), VARIANTS));
        let p = self.place([x, z]) + Vec2::new(die(2), die(3)) * (JITTER * self.spacing);
        let foot = Vec3::new(p.x, self.land.height(p), p.y);
        Some(Placement {
            scale: Vec3::splat(1.0 + 0.2 * die(4)),
            ..Placement::upright(model, foot, std::f32::consts::PI * die(5))
        })
    }

    /// A place of the lattice (x, z).
    fn place(&self, [x, z]: [u32; 2]) -> Vec2 {
        self.corner() + (Vec2::new(x as f32, z as f32) + 0.5) * self.spacing
    }

    /// All trees, row by row.
    pub fn trees(&self) -> impl Iterator<Item = Placement> {
        let side = self.side();
        (0..self.count).filter_map(move |i| self.tree([i % side, i / side]))
    }

    /// The trees of a cell, row by row.
    pub fn trees_in(&self, cell: Cell) -> impl Iterator<Item = Placement> {
        let width = cell.leaves() * LEAF_TREES;
        let first = [cell.x * width, cell.z * width];
        (0..width).flat_map(move |z| (0..width).filter_map(move |x| self.tree([first[0] + x, first[1] + z])))
    }

    /// The trunks that come nearer to (x, z) than `reach` metres.
    #[must_use]
    pub fn blockers_near(&self, p: Vec2, reach: f32) -> Vec<Blocker> {
        // A tree is off its place by less than a spacing, its trunk included.
        let margin = reach + self.spacing.max(1.0);
        let index = |v: f32| ((v - self.corner().x) / self.spacing - 0.5).clamp(0.0, self.side() as f32) as u32;
        let (low, high) = (p - margin, p + margin);
        let places = (index(low.y)..=index(high.y)).flat_map(|z| (index(low.x)..=index(high.x)).map(move |x| [x, z]));
        places
            .filter_map(|place| self.tree(place)?.blocker())
            .filter(|blocker| blocker.outwards(p).0 < reach)
            .collect()
    }

    /// Its cells.
    #[must_use]
    pub fn grid(&self) -> CellGrid {
        CellGrid {
            corner: DVec2::from(self.corner().as_dvec2()),
            leaf_side: f64::from(LEAF_TREES) * f64::from(self.spacing),
            leaves: self.side().div_ceil(LEAF_TREES),
        }
    }

    /// Where cells change, so that no tree of a block is nearer than the end of its last but one level.
    #[must_use]
    pub fn borders(&self) -> CellBorders {
        let side = self.grid().leaf_side;
        // Half a diagonal of a leaf, and again at twice the distances (bias 2); slopes add little.
        let single = f64::from(super::simple_trees::LEVEL_ENDS[1]) + 1.6 * side;
        CellBorders {
            single,
            blocks: (5.5 * side).max(1.3 * single),
            lead: 0.08,
        }
    }
}

/// Trees along a side of a lattice of so many.
#[must_use]
pub fn side(count: u32) -> u32 {
    f64::from(count).sqrt().ceil() as u32
}

/// A face of a die from a number in -1..=1.
fn face(number: f32, faces: u32) -> u32 {
    ((0.5 + 0.5 * number) * faces as f32).min(faces as f32 - 1.0) as u32
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::level::format::Hills;

    pub(in crate::level) fn grove(count: u32) -> Grove {
        let hills = Hills {
            amplitude: 8.0,
            wavelength: 250.0,
            octaves: 3,
            rim_height: 0.0,
            rim_width: 0.0,
        };
        let size = Vec2::splat(side(count) as f32 * 5.0 + 20.0);
        Grove::new(count, 5.0, 3, Land::new(size, Some(hills), 3))
    }

    #[test]
    fn there_are_as_many_trees_as_asked_wherever_one_looks() {
        for count in [1, 2, 999, 5000] {
            let grove = grove(count);
            assert_eq!(grove.trees().count(), count as usize);
            let root = grove.grid().root();
            let places = |trees: Vec<Placement>| -> HashSet<[u32; 3]> {
                trees
                    .iter()
                    .map(|tree| tree.position.to_array().map(f32::to_bits))
                    .collect()
            };
            let all = places(grove.trees().collect());
            assert_eq!(all.len(), count as usize, "places differ");
            assert_eq!(places(grove.trees_in(root).collect()), all);
            let mut of_children = HashSet::new();
            for child in grove.grid().children(root) {
                of_children.extend(places(grove.trees_in(child).collect()));
            }
            assert!(
                root.level == 0 || of_children == all,
                "{count} trees in the root's children"
            );
        }
    }

    #[test]
    fn trees_stand_in_their_cells_on_the_ground() {
        let grove = grove(3000);
        let grid = grove.grid();
        for cell in [Cell { level: 0, x: 2, z: 3 }, Cell { level: 1, x: 1, z: 0 }] {
            let half = 0.5 * grid.side(cell) as f32;
            for tree in grove.trees_in(cell) {
                let p = Vec2::new(tree.position.x, tree.position.z);
                let off = (p - grid.center(cell).as_vec2()).abs().max_element();
                assert!(off < half, "{off} m off the middle of {cell:?}");
                assert_eq!(tree.position.y, grove.land().height(p));
                assert!((0.8..=1.2).contains(&tree.scale.x), "{tree:?}");
            }
        }
        let models: HashSet<Model> = grove.trees().map(|tree| tree.model).collect();
        assert_eq!(models.len(), 12, "all kinds and shapes");
    }

    #[test]
    fn trunks_near_a_walker_are_found_and_no_others() {
        let grove = grove(3000);
        let all: Vec<Blocker> = grove.trees().filter_map(|tree| tree.blocker()).collect();
        for (p, reach) in [
            (Vec2::ZERO, 0.5),
            (Vec2::new(31.0, -77.0), 6.0),
            (Vec2::new(136.0, -139.0), 4.0),
            (Vec2::new(900.0, 0.0), 50.0),
        ] {
            let near: Vec<Blocker> = all
                .iter()
                .filter(|blocker| blocker.outwards(p).0 < reach)
                .copied()
                .collect();
            assert_eq!(grove.blockers_near(p, reach), near, "{p} {reach}");
        }
        assert!(grove.blockers_near(Vec2::ZERO, 0.5).is_empty(), "the origin is free");
    }

    /// Blocks only stand for trees that are in their last level.
    #[test]
    fn borders_keep_blocks_beyond_the_levels_of_trees() {
        let grove = grove(1_000_000);
        let (grid, borders) = (grove.grid(), grove.borders());
        let half_diagonal = grid.leaf_side * std::f64::consts::FRAC_1_SQRT_2;
        for factor in [0.5, 1.0, 2.0] {
            let nearest = borders.single - factor * half_diagonal;
            assert!(
                nearest > f64::from(super::super::simple_trees::LEVEL_ENDS[1]),
                "{factor}"
            );
            assert!(borders.leave_room(&grid, factor) > 1.5, "{factor}");
        }
    }
}
