//! Trees of few triangles without textures, in levels of detail, for tests with a million of them. The foot is at the
//! origin, +y up; a little of each is below ground.

use bevy_math::Vec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::meshes::{MeshData, Rgb, SkirtShape};

/// Shapes per kind.
pub const VARIANTS: u32 = 4;
/// Where levels of detail end, metres from the eye: up to 600 triangles, up to 120, up to 30.
pub const LEVEL_ENDS: [f32; 2] = [25.0, 60.0];
/// Levels of detail.
pub const LEVELS: usize = LEVEL_ENDS.len() + 1;

/// What kind of tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SimpleTree {
    /// Trunk and jagged cones, 9 to 13 m.
    Conifer,
    /// White trunk and leaf balls, 8 to 11 m.
    Birch,
    /// Bare trunk and branches, 6 to 9 m.
    Dead,
}

/// Radius of the trunk at the ground in metres.
pub fn foot_radius(tree: SimpleTree) -> f32 {
    match tree {
        SimpleTree::Conifer => 0.25,
        SimpleTree::Birch => 0.18,
        SimpleTree::Dead => 0.22,
    }
}

/// Height of the tallest variant in metres.
pub fn height(tree: SimpleTree) -> f32 {
    match tree {
        SimpleTree::Conifer => 13.0,
        SimpleTree::Birch => 11.0,
        SimpleTree::Dead => 9.0,
    }
}

/// Builds one of the [`VARIANTS`] shapes of a kind in its finest level.
pub fn build(tree: SimpleTree, variant: u32) -> MeshData {
    build_level(tree, variant, 0)
}

/// Builds one of the [`VARIANTS`] shapes of a kind in one of its [`LEVELS`], from fine to coarse.
pub fn build_level(tree: SimpleTree, variant: u32, level: usize) -> MeshData {
    let mut rng = dice(tree, variant);
    let mut mesh = MeshData::default();
    match (tree, level) {
        (_, 2..) => far_tree(&mut mesh, tree, variant),
        (SimpleTree::Conifer, _) => conifer(&mut mesh, &mut rng, level),
        (SimpleTree::Birch, _) => birch(&mut mesh, &mut rng, level),
        (SimpleTree::Dead, _) => dead_tree(&mut mesh, &mut rng, level),
    }
    mesh
}

fn dice(tree: SimpleTree, variant: u32) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(u64::from(variant % VARIANTS) + 100 * tree as u64)
}

/// What is left of a tree from afar: two pyramids on a common base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crown {
    /// Lowest and highest point.
    pub ends: [Vec3; 2],
    /// Share of the way from the lowest point where it is thickest.
    pub waist: f32,
    /// Radius there in metres.
    pub radius: f32,
    /// At the ends, and between.
    pub colors: [Rgb; 3],
}

/// The crown of one of the shapes of a kind; of a dead tree its upper half.
pub fn crown(tree: SimpleTree, variant: u32) -> Crown {
    let mut rng = dice(tree, variant);
    match tree {
        SimpleTree::Conifer => {
            let [height, radius, first] = conifer_sizes(&mut rng);
            Crown {
                ends: [Vec3::Y * (0.6 * first), Vec3::Y * height],
                waist: 0.12,
                radius: 0.88 * radius,
                colors: [0.5, 0.85, 1.2].map(|light| scaled(NEEDLES, light)),
            }
        }
        SimpleTree::Birch => {
            let top = birch_top(&mut rng);
            Crown {
                ends: [top * 0.3, top * 1.1],
                waist: 0.38,
                radius: 1.9,
                colors: [LEAVES.0, scaled([0.17, 0.25, 0.06], 1.0), LEAVES.1],
            }
        }
        SimpleTree::Dead => {
            let height = rng.random_range(6.0..9.0);
            Crown {
                ends: [Vec3::Y * (0.25 * height), Vec3::new(0.3, height, 0.1)],
                waist: 0.2,
                radius: 0.3,
                colors: [GREY.0, GREY.0, GREY.1],
            }
        }
    }
}

/// The last level: a crown and a trunk, or a trunk and its branches.
fn far_tree(mesh: &mut MeshData, tree: SimpleTree, variant: u32) {
    let crown = crown(tree, variant);
    let mut trunk = |from: Vec3, to: Vec3, waist: (f32, f32), (low, high): (Rgb, Rgb)| {
        mesh.push_spindle([from, to], waist, 3, [low, low, high]);
    };
    let root = Vec3::NEG_Y * ROOT;
    match tree {
        SimpleTree::Conifer => trunk(root, crown.ends[1] * 0.6, (0.1, 0.25), BARK),
        SimpleTree::Birch => trunk(root, crown.ends[1] * 0.8, (0.1, 0.17), WHITE_BARK),
        SimpleTree::Dead => {
            trunk(root, crown.ends[1], (0.1, 0.26), GREY);
            let height = crown.ends[1].y;
            for i in 0..3 {
                let foot = Vec3::Y * height * (0.35 + 0.16 * i as f32);
                let tip = foot + direction(i as f32 * 2.4 + variant as f32, 0.5) * (0.3 * height);
                trunk(foot, tip, (0.2, 0.09), GREY);
            }
            return;
        }
    }
    mesh.push_spindle(crown.ends, (crown.waist, crown.radius), 5, crown.colors);
}

const BARK: (Rgb, Rgb) = ([0.085, 0.055, 0.035], [0.13, 0.085, 0.055]);
const WHITE_BARK: (Rgb, Rgb) = ([0.5, 0.48, 0.44], [0.62, 0.6, 0.55]);
const GREY: (Rgb, Rgb) = ([0.16, 0.145, 0.125], [0.25, 0.235, 0.21]);
const NEEDLES: Rgb = [0.045, 0.105, 0.04];
/// Of a birch, below and above.
const LEAVES: (Rgb, Rgb) = ([0.10, 0.17, 0.04], [0.24, 0.33, 0.08]);
/// How far trunks go into the ground, for slopes.
const ROOT: f32 = 0.6;

fn scaled(color: Rgb, factor: f32) -> Rgb {
    color.map(|c| c * factor)
}

/// A unit vector at this heading and rise.
fn direction(heading: f32, rise: f32) -> Vec3 {
    let (sin, cos) = heading.sin_cos();
    Vec3::new(cos, rise, sin).normalize()
}

/// Height, radius of the crown, and height of the lowest branches.
fn conifer_sizes(rng: &mut ChaCha8Rng) -> [f32; 3] {
    let height = rng.random_range(9.0..13.0);
    let radius = height * rng.random_range(0.17..0.21);
    [height, radius, rng.random_range(1.0..1.8)]
}

fn conifer(mesh: &mut MeshData, rng: &mut ChaCha8Rng, level: usize) {
    let [height, radius, first] = conifer_sizes(rng);
    let sides = if level == 0 { 6 } else { 3 };
    mesh.push_round((Vec3::NEG_Y * ROOT, 0.26), (Vec3::Y * height * 0.8, 0.05), sides, BARK);
    let skirts = 5;
    for i in 0..skirts {
        let t = i as f32 / skirts as f32;
        let foot = first + (height - first) * t * 0.92;
        let own = radius * (1.0 - t).powf(0.85) + 0.12;
        let shape = SkirtShape {
            points: 7,
            jag: rng.random_range(0.2..0.34),
            droop: own * rng.random_range(0.15..0.3),
            turn: rng.random_range(0.0..std::f32::consts::TAU),
        };
        let light = 0.8 + 0.55 * t;
        let green = scaled(NEEDLES, light);
        let length = ((height - first) * (0.36 - 0.1 * t)).min(height - foot);
        if level == 0 {
            mesh.push_skirt(Vec3::Y * foot, length, own, shape, green);
        } else {
            let ends = [foot - shape.droop, foot + length].map(|y| Vec3::Y * y);
            let waist = 0.6 * shape.droop / (length + shape.droop);
            let colors = [scaled(green, 0.55), green, green];
            mesh.push_spindle(ends, (waist, own * (1.0 - 0.5 * shape.jag)), 6, colors);
        }
    }
}

/// The highest point of the trunk.
fn birch_top(rng: &mut ChaCha8Rng) -> Vec3 {
    let height = rng.random_range(7.0..9.0);
    let lean = direction(rng.random_range(0.0..std::f32::consts::TAU), 0.0) * rng.random_range(0.0..0.5);
    Vec3::Y * height + lean
}

fn birch(mesh: &mut MeshData, rng: &mut ChaCha8Rng, level: usize) {
    let top = birch_top(rng);
    let at = |t: f32| top * t;
    let sides = if level == 0 { 6 } else { 3 };
    mesh.push_round((Vec3::NEG_Y * ROOT, 0.17), (at(0.97), 0.05), sides, WHITE_BARK);
    let balls = 6;
    for i in 0..balls {
        let t = i as f32 / (balls - 1) as f32;
        let side = direction(i as f32 * 2.4 + rng.random_range(0.0..0.8), 0.0) * (0.9 * (1.0 - t) + 0.1);
        let center = at(0.44 + 0.53 * t) + side;
        let radius = rng.random_range(0.95..1.3) * (1.0 - 0.35 * t);
        let light = rng.random_range(0.85..1.15);
        let greens = (scaled(LEAVES.0, light), scaled(LEAVES.1, light));
        let seed = rng.random();
        if level == 0 {
            mesh.push_blob(center, Vec3::new(radius, radius * 1.2, radius), 0.28, seed, greens);
        } else {
            let between: Rgb = std::array::from_fn(|k| 0.5 * (greens.0[k] + greens.1[k]));
            let ends = [-1.2, 1.2].map(|y| center + Vec3::Y * (y * radius));
            mesh.push_spindle(ends, (0.5, 1.1 * radius), 6, [greens.0, between, greens.1]);
        }
    }
}

fn dead_tree(mesh: &mut MeshData, rng: &mut ChaCha8Rng, level: usize) {
    let height = rng.random_range(6.0..9.0);
    let sides = if level == 0 { 6 } else { 3 };
    mesh.push_round((Vec3::NEG_Y * ROOT, 0.27), (Vec3::Y * height * 0.55, 0.16), sides, GREY);
    mesh.push_round(
        (Vec3::Y * (height * 0.55 - 0.05), 0.155),
        (Vec3::new(0.3, height, 0.1), 0.02),
        sides,
        GREY,
    );
    for i in 0..9 {
        let heading = i as f32 * 2.4 + rng.random_range(0.0..1.0);
        let foot = Vec3::Y * height * (0.25 + 0.065 * i as f32);
        let length = height * rng.random_range(0.2..0.34) * (1.15 - 0.07 * i as f32);
        let tip = foot + direction(heading, rng.random_range(0.2..0.9)) * length;
        if level == 0 {
            mesh.push_round((foot, 0.075), (tip, 0.015), 5, GREY);
        } else {
            mesh.push_spindle([foot, tip], (0.1, 0.08), 3, [GREY.0, GREY.0, GREY.1]);
        }
        for k in [0.45, 0.7] {
            let fork = foot + (tip - foot) * k;
            let twig =
                fork + direction(heading + rng.random_range(-1.2..1.2), rng.random_range(0.1..1.2)) * length * 0.45;
            if level == 0 {
                mesh.push_round((fork, 0.035), (twig, 0.008), 4, GREY);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::meshes::tests::assert_solid;

    const ALL: [SimpleTree; 3] = [SimpleTree::Conifer, SimpleTree::Birch, SimpleTree::Dead];

    #[test]
    fn every_tree_is_solid_light_and_stands_in_the_ground() {
        for tree in ALL {
            for variant in 0..VARIANTS {
                for (level, most) in [600, 120, 30].into_iter().enumerate() {
                    let mesh = build_level(tree, variant, level);
                    let name = format!("{tree:?} {variant}, level {level}");
                    assert_solid(&mesh, &name);
                    let (min, max) = mesh.bounds().unwrap();
                    assert!(min.y < -0.1, "{name} floats at {}", min.y);
                    assert!(max.y <= height(tree), "{name} is {} m high", max.y);
                    assert!(max.y >= 0.45 * height(tree), "{name} is only {} m high", max.y);
                    let triangles = mesh.indices.len() / 3;
                    assert!(triangles <= most, "{name}: {triangles} triangles");
                }
            }
        }
    }

    /// Levels stand for each other: nearly the same box.
    #[test]
    fn levels_are_as_large_as_each_other() {
        for tree in ALL {
            for variant in 0..VARIANTS {
                let boxes = [0, 1, 2].map(|level| build_level(tree, variant, level).bounds().unwrap());
                for (min, max) in &boxes[1..] {
                    let off = (*min - boxes[0].0).abs().max((*max - boxes[0].1).abs()).max_element();
                    // Three branches stand for the nine of a dead tree.
                    let share = if tree == SimpleTree::Dead { 0.2 } else { 0.12 };
                    assert!(off < share * height(tree), "{tree:?} {variant}: {off} m, {boxes:?}");
                }
            }
        }
    }

    #[test]
    fn variants_differ_and_repeat() {
        assert_eq!(build(SimpleTree::Conifer, 1), build(SimpleTree::Conifer, 1 + VARIANTS));
        assert_ne!(build(SimpleTree::Conifer, 1), build(SimpleTree::Conifer, 2));
    }
}
