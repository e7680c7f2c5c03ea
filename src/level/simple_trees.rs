//! Trees of few triangles without textures, for tests with a million of them. The foot is at the origin, +y up; a
//! little of each is below ground.

use bevy_math::Vec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::meshes::{MeshData, Rgb, SkirtShape};

/// Shapes per kind.
pub const VARIANTS: u32 = 4;

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

/// Builds one of the [`VARIANTS`] shapes of a kind.
pub fn build(tree: SimpleTree, variant: u32) -> MeshData {
    let mut rng = ChaCha8Rng::seed_from_u64(u64::from(variant % VARIANTS) + 100 * tree as u64);
    let mut mesh = MeshData::default();
    match tree {
        SimpleTree::Conifer => conifer(&mut mesh, &mut rng),
        SimpleTree::Birch => birch(&mut mesh, &mut rng),
        SimpleTree::Dead => dead_tree(&mut mesh, &mut rng),
    }
    mesh
}

const BARK: (Rgb, Rgb) = ([0.085, 0.055, 0.035], [0.13, 0.085, 0.055]);
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

fn conifer(mesh: &mut MeshData, rng: &mut ChaCha8Rng) {
    let height = rng.random_range(9.0..13.0);
    let radius = height * rng.random_range(0.17..0.21);
    mesh.push_round((Vec3::NEG_Y * ROOT, 0.26), (Vec3::Y * height * 0.8, 0.05), 6, BARK);
    let skirts = 5;
    let first = rng.random_range(1.0..1.8);
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
        let green = scaled([0.045, 0.105, 0.04], 0.8 + 0.55 * t);
        let length = (height - first) * (0.36 - 0.1 * t);
        mesh.push_skirt(Vec3::Y * foot, length.min(height - foot), own, shape, green);
    }
}

fn birch(mesh: &mut MeshData, rng: &mut ChaCha8Rng) {
    let height = rng.random_range(7.0..9.0);
    let lean = direction(rng.random_range(0.0..std::f32::consts::TAU), 0.0) * rng.random_range(0.0..0.5);
    let top = Vec3::Y * height + lean;
    let at = |t: f32| top * t;
    let white = ([0.5, 0.48, 0.44], [0.62, 0.6, 0.55]);
    mesh.push_round((Vec3::NEG_Y * ROOT, 0.17), (at(0.97), 0.05), 6, white);
    let balls = 6;
    for i in 0..balls {
        let t = i as f32 / (balls - 1) as f32;
        let side = direction(i as f32 * 2.4 + rng.random_range(0.0..0.8), 0.0) * (0.9 * (1.0 - t) + 0.1);
        let center = at(0.44 + 0.53 * t) + side;
        let radius = rng.random_range(0.95..1.3) * (1.0 - 0.35 * t);
        let light = rng.random_range(0.85..1.15);
        let greens = (scaled([0.10, 0.17, 0.04], light), scaled([0.24, 0.33, 0.08], light));
        mesh.push_blob(
            center,
            Vec3::new(radius, radius * 1.2, radius),
            0.28,
            rng.random(),
            greens,
        );
    }
}

fn dead_tree(mesh: &mut MeshData, rng: &mut ChaCha8Rng) {
    let height = rng.random_range(6.0..9.0);
    let grey = ([0.16, 0.145, 0.125], [0.25, 0.235, 0.21]);
    mesh.push_round((Vec3::NEG_Y * ROOT, 0.27), (Vec3::Y * height * 0.55, 0.16), 6, grey);
    mesh.push_round(
        (Vec3::Y * (height * 0.55 - 0.05), 0.155),
        (Vec3::new(0.3, height, 0.1), 0.02),
        6,
        grey,
    );
    for i in 0..9 {
        let heading = i as f32 * 2.4 + rng.random_range(0.0..1.0);
        let foot = Vec3::Y * height * (0.25 + 0.065 * i as f32);
        let length = height * rng.random_range(0.2..0.34) * (1.15 - 0.07 * i as f32);
        let tip = foot + direction(heading, rng.random_range(0.2..0.9)) * length;
        mesh.push_round((foot, 0.075), (tip, 0.015), 5, grey);
        for k in [0.45, 0.7] {
            let fork = foot + (tip - foot) * k;
            let twig =
                fork + direction(heading + rng.random_range(-1.2..1.2), rng.random_range(0.1..1.2)) * length * 0.45;
            mesh.push_round((fork, 0.035), (twig, 0.008), 4, grey);
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
                let mesh = build(tree, variant);
                let name = format!("{tree:?} {variant}");
                assert_solid(&mesh, &name);
                let (min, max) = mesh.bounds().unwrap();
                assert!(min.y < -0.1, "{name} floats at {}", min.y);
                assert!(max.y <= height(tree), "{name} is {} m high", max.y);
                assert!(max.y >= 0.45 * height(tree), "{name} is only {} m high", max.y);
                let triangles = mesh.indices.len() / 3;
                assert!(triangles <= 600, "{name}: {triangles} triangles");
            }
        }
    }

    #[test]
    fn variants_differ_and_repeat() {
        assert_eq!(build(SimpleTree::Conifer, 1), build(SimpleTree::Conifer, 1 + VARIANTS));
        assert_ne!(build(SimpleTree::Conifer, 1), build(SimpleTree::Conifer, 2));
    }
}
