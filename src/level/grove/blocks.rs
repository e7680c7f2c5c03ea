//! What stands for all trees of a cell: one mesh, with nearly as many triangles for large cells as for small ones.
//!
//! The block of a leaf has every tree in its last level, with the same triangles at the same place as the tree would have on
//! its own. That of a cell of level 1 has the crown of every tree. Those of level k have one crown for 2^(k − 1) trees along
//! x and along z: as high as its trees are on average, and as wide as all of them together cover.

use bevy_math::{Affine3A, Vec3};

use super::{Grove, LEAF_TREES};
use crate::{
    level::{
        meshes::{MeshData, Rgb},
        model::{Model, Placement},
        simple_trees::{self, Crown, LEVELS, SimpleTree, VARIANTS},
    },
    maths::lod::cells::Cell,
};

/// Trees along a side that are asked for one crown at most: the others are like them.
const SAMPLES: u32 = 2;

/// The last levels of all trees.
#[derive(Clone, Debug)]
pub struct FarTrees {
    /// By kind and shape, see [`index`].
    meshes: Vec<MeshData>,
    crowns: Vec<Crown>,
}

const KINDS: [SimpleTree; 3] = [SimpleTree::Conifer, SimpleTree::Birch, SimpleTree::Dead];

/// All trees there are.
pub fn models() -> impl Iterator<Item = (SimpleTree, u32)> {
    KINDS
        .into_iter()
        .flat_map(|kind| (0..VARIANTS).map(move |variant| (kind, variant)))
}

/// Place of a tree in [`models`]; `None` of what is no tree of a grove.
#[must_use]
pub fn index(model: Model) -> Option<usize> {
    match model {
        Model::SimpleTree(kind, variant) => Some(kind as usize * VARIANTS as usize + (variant % VARIANTS) as usize),
        _ => None,
    }
}

impl Default for FarTrees {
    fn default() -> Self {
        Self {
            meshes: models()
                .map(|(kind, variant)| simple_trees::build_level(kind, variant, LEVELS - 1))
                .collect(),
            crowns: models()
                .map(|(kind, variant)| simple_trees::crown(kind, variant))
                .collect(),
        }
    }
}

/// Where a block's own space begins: the middle of its cell, at height 0.
#[must_use]
pub fn origin(grove: &Grove, cell: Cell) -> Vec3 {
    let center = grove.grid().center(cell).as_vec2();
    Vec3::new(center.x, 0.0, center.y)
}

/// The block of a cell, in its own space; empty where no trees are left.
#[must_use]
pub fn block(grove: &Grove, far: &FarTrees, cell: Cell) -> MeshData {
    let mut mesh = MeshData::default();
    let origin = origin(grove, cell);
    if cell.level == 0 {
        for tree in grove.trees_in(cell) {
            let Some(index) = index(tree.model) else { continue };
            let place = Affine3A::from_scale_rotation_translation(tree.scale, tree.rotation, tree.position - origin);
            mesh.append(&far.meshes[index], place);
        }
        return mesh;
    }
    let group = 1 << (cell.level - 1);
    let groups = cell.leaves() * LEAF_TREES / group;
    for z in 0..groups {
        for x in 0..groups {
            let first = [cell.x * groups + x, cell.z * groups + z].map(|place| place * group);
            if let Some(crown) = crown(grove, far, first, group) {
                let ends = crown.ends.map(|end| end - origin);
                mesh.push_spindle(ends, (crown.waist, crown.radius), 4, crown.colors);
            }
        }
    }
    mesh
}

/// The crown of a group of trees in world space; `None` where none are left.
fn crown(grove: &Grove, far: &FarTrees, first: [u32; 2], group: u32) -> Option<Crown> {
    let step = (group / SAMPLES).max(1);
    let samples = (0..group.min(SAMPLES)).flat_map(|z| (0..group.min(SAMPLES)).map(move |x| [x, z]));
    let trees = samples.filter_map(|[x, z]| grove.tree([first[0] + x * step, first[1] + z * step]));
    let crowns: Vec<Crown> = trees.filter_map(|tree| stands_in(far, &tree)).collect();
    let share = 1.0 / crowns.len() as f32;
    let mean = |of: &dyn Fn(&Crown) -> Vec3| crowns.iter().map(of).sum::<Vec3>() * share;
    let (low, high) = (mean(&|crown| crown.ends[0]), mean(&|crown| crown.ends[1]));
    let area = crowns.iter().map(|crown| crown.radius.powi(2)).sum::<f32>() * share;
    let color = |k: usize| -> Rgb {
        // Wide crowns are what is seen.
        let weighted = mean(&|crown| Vec3::from(crown.colors[k]) * crown.radius.powi(2));
        (weighted / area).to_array()
    };
    (!crowns.is_empty()).then(|| Crown {
        ends: [low, high],
        waist: crowns.iter().map(|crown| crown.waist).sum::<f32>() * share,
        radius: group as f32 * area.sqrt(),
        colors: [0, 1, 2].map(color),
    })
}

/// The crown of a tree where it stands.
fn stands_in(far: &FarTrees, tree: &Placement) -> Option<Crown> {
    let own = far.crowns[index(tree.model)?];
    let place = |p: Vec3| tree.position + tree.rotation * (p * tree.scale);
    Some(Crown {
        ends: own.ends.map(place),
        radius: own.radius * tree.scale.x,
        ..own
    })
}

#[cfg(test)]
mod tests {
    use bevy_math::Mat4;

    use super::*;
    use crate::level::{grove::tests::grove, meshes::tests::assert_sane};

    /// The same triangles as the trees have on their own: a leaf that opens or closes is not seen.
    #[test]
    fn a_leaf_is_its_trees_in_their_last_level() {
        let (grove, far) = (grove(3000), FarTrees::default());
        let cell = Cell { level: 0, x: 1, z: 4 };
        let mesh = block(&grove, &far, cell);
        assert_sane(&mesh, "leaf");
        let mut at = 0;
        for tree in grove.trees_in(cell) {
            let Model::SimpleTree(kind, variant) = tree.model else {
                panic!("{tree:?} is no tree")
            };
            let own = simple_trees::build_level(kind, variant, LEVELS - 1);
            let world_from_local = Mat4::from_scale_rotation_translation(tree.scale, tree.rotation, tree.position);
            for (i, local) in own.positions.iter().enumerate() {
                let off =
                    (mesh.positions[at + i] + origin(&grove, cell)).distance(world_from_local.transform_point3(*local));
                assert!(off < 1e-3, "{off} m");
                assert!(mesh.normals[at + i].distance(tree.rotation * own.normals[i]) < 1e-4);
                assert_eq!(mesh.colors[at + i], own.colors[i]);
            }
            at += own.positions.len();
        }
        assert_eq!(at, mesh.positions.len(), "nothing else");
    }

    /// Whatever they stand for, blocks have as many triangles, cover as much ground, and are as high.
    #[test]
    fn larger_blocks_are_coarser_and_stand_for_the_same() {
        let (grove, far) = (grove(65_536), FarTrees::default());
        let cover = |mesh: &MeshData, cell: Cell| {
            let side = grove.grid().side(cell) as f32;
            let triangles = mesh.indices.chunks(3).map(|triangle| {
                let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[triangle[k] as usize]);
                0.5 * (b - a).cross(c - a).y.max(0.0)
            });
            triangles.sum::<f32>() / side.powi(2)
        };
        let middle = |level: u32| Cell {
            level,
            x: 16 >> level,
            z: 16 >> level,
        };
        let first = block(&grove, &far, middle(1));
        for level in 1..=4 {
            let mesh = block(&grove, &far, middle(level));
            assert_sane(&mesh, "block");
            assert_eq!(mesh.indices.len(), first.indices.len(), "level {level}");
            let (own, of_first) = (cover(&mesh, middle(level)), cover(&first, middle(1)));
            assert!(
                (own / of_first - 1.0).abs() < 0.35,
                "level {level} covers {own}, not {of_first}"
            );
            let (min, max) = mesh.bounds().unwrap();
            assert!(
                min.y > -20.0 && (6.0..30.0).contains(&max.y),
                "level {level}: {min} {max}"
            );
        }
    }

    #[test]
    fn cells_without_trees_have_no_block() {
        // 10 trees: the last row of 4 has 2.
        let (grove, far) = (grove(10), FarTrees::default());
        let cell = Cell { level: 0, x: 0, z: 0 };
        assert!(!block(&grove, &far, cell).is_empty());
        assert!(block(&grove, &far, Cell { x: 1, ..cell }).is_empty());
        assert!(block(&grove, &far, Cell { level: 3, x: 1, z: 0 }).is_empty());
    }
}
