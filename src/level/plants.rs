//! Meshes of trees, bushes and rocks. The foot is at the origin, +y up; a little of each is below ground.

use bevy_math::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    format::Species,
    meshes::{MeshData, ModelMesh, Rgb, SkirtShape},
};

/// Shapes per species.
pub const VARIANTS: u32 = 4;

/// Radius of the trunk at the ground in metres, for walkers; a rock's and a bush's own radius.
pub fn foot_radius(species: Species) -> f32 {
    match species {
        Species::Conifer => 0.25,
        Species::Oak => 0.35,
        Species::Birch => 0.18,
        Species::DeadTree => 0.22,
        Species::Bush => 0.5,
        Species::Rock => 0.8,
    }
}

/// Height of the tallest variant in metres.
pub fn height(species: Species) -> f32 {
    match species {
        Species::Conifer => 13.0,
        Species::Oak | Species::Birch => 11.0,
        Species::DeadTree => 9.0,
        Species::Bush | Species::Rock => 1.6,
    }
}

/// Builds one of the [`VARIANTS`] shapes of a species.
pub fn build(species: Species, variant: u32) -> ModelMesh {
    let mut rng = ChaCha8Rng::seed_from_u64(u64::from(variant % VARIANTS) + 100 * species as u64);
    let mut plant = ModelMesh::default();
    match species {
        Species::Conifer => conifer(&mut plant.solid, &mut rng),
        Species::Oak => oak(&mut plant, &mut rng),
        Species::Birch => birch(&mut plant.solid, &mut rng),
        Species::DeadTree => dead_tree(&mut plant.solid, &mut rng),
        Species::Bush => bush(&mut plant.solid, &mut rng),
        Species::Rock => rock(&mut plant.solid, &mut rng),
    }
    plant
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

fn oak(plant: &mut ModelMesh, rng: &mut ChaCha8Rng) {
    let fork = rng.random_range(2.4..3.2);
    let solid = &mut plant.solid;
    solid.push_round((Vec3::NEG_Y * ROOT, 0.42), (Vec3::Y * fork, 0.24), 7, BARK);
    let mut tips = Vec::new();
    let boughs = 5;
    for i in 0..boughs {
        let heading = (i as f32 + rng.random_range(0.0..0.6)) / boughs as f32 * std::f32::consts::TAU;
        let foot = Vec3::Y * (fork - rng.random_range(0.1..0.5));
        let tip = foot + direction(heading, rng.random_range(0.7..1.4)) * rng.random_range(2.4..3.4);
        solid.push_round((foot, 0.16), (tip, 0.05), 5, BARK);
        tips.push(tip);
    }
    let top = Vec3::Y * (fork + rng.random_range(3.2..4.0));
    solid.push_round((Vec3::Y * (fork - 0.1), 0.2), (top, 0.06), 5, BARK);
    tips.push(top);
    let middle = tips.iter().sum::<Vec3>() / tips.len() as f32;
    for tip in tips {
        for _ in 0..13 {
            let (heading, rise) = (
                rng.random_range(0.0..std::f32::consts::TAU),
                rng.random_range(-0.8..1.6),
            );
            let center = tip + direction(heading, rise) * rng.random_range(0.5..1.5);
            let outward = (center - middle + Vec3::Y * 0.6).normalize();
            let facing = (outward
                + direction(
                    rng.random_range(0.0..std::f32::consts::TAU),
                    rng.random_range(-1.0..1.0),
                ))
            .normalize_or(Vec3::Y);
            let right = facing.any_orthonormal_vector();
            let half = rng.random_range(0.75..1.15);
            // Leaves inside the crown are in each other's shade.
            let depth = ((center - middle).length() / 3.2).clamp(0.45, 1.0);
            let color = scaled([0.30, 0.40, 0.13], depth * rng.random_range(0.8..1.1));
            plant
                .leaves
                .push_card(center, right * half, facing.cross(right) * half, outward, color);
        }
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

fn bush(mesh: &mut MeshData, rng: &mut ChaCha8Rng) {
    for i in 0..4 {
        let side = direction(i as f32 * 1.7 + rng.random_range(0.0..0.6), 0.0) * if i == 0 { 0.0 } else { 0.6 };
        let radius = rng.random_range(0.5..0.75);
        let light = rng.random_range(0.85..1.15);
        let greens = (scaled([0.05, 0.085, 0.025], light), scaled([0.14, 0.21, 0.06], light));
        mesh.push_blob(
            side + Vec3::Y * 0.45,
            Vec3::new(radius, radius * 0.9, radius),
            0.22,
            rng.random(),
            greens,
        );
    }
}

fn rock(mesh: &mut MeshData, rng: &mut ChaCha8Rng) {
    let radii = Vec3::new(
        rng.random_range(0.7..1.1),
        rng.random_range(0.45..0.8),
        rng.random_range(0.6..0.9),
    );
    let grey = ([0.12, 0.115, 0.105], [0.30, 0.29, 0.27]);
    mesh.push_blob(Vec3::Y * 0.25, radii, 0.22, rng.random(), grey);
    let side = direction(rng.random_range(0.0..std::f32::consts::TAU), 0.0) * 0.8;
    mesh.push_blob(side + Vec3::Y * 0.1, radii * 0.5, 0.22, rng.random(), grey);
}

/// The leaf texture: `side` x `side` RGBA, sRGB, opaque or clear. Twigs of pointed leaves on a clear ground whose
/// colour is the leaves', so that filtering draws no dark seams.
pub fn leaf_texture(side: u32) -> Vec<u8> {
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let leaves: Vec<(Vec2, Vec2, f32, f32)> = (0..64)
        .map(|_| {
            let (radius, heading) = (
                0.43 * rng.random::<f32>().sqrt(),
                rng.random_range(0.0..std::f32::consts::TAU),
            );
            let middle = Vec2::splat(0.5) + Vec2::from_angle(heading) * radius;
            let along = Vec2::from_angle(heading + rng.random_range(-0.9..0.9));
            (
                middle,
                along,
                rng.random_range(0.055..0.085),
                rng.random_range(0.72..1.0),
            )
        })
        .collect();
    let mut pixels = Vec::with_capacity((side * side * 4) as usize);
    for y in 0..side {
        for x in 0..side {
            let p = (Vec2::new(x as f32, y as f32) + 0.5) / side as f32;
            let hit = leaves.iter().rev().find(|(middle, along, length, _)| {
                let offset = p - *middle;
                let (u, v) = (offset.dot(*along) / length, offset.dot(along.perp()) / length);
                // Two arcs that meet in points.
                u.abs() < 1.0 && v.abs() < 0.48 * (1.0 - u * u)
            });
            let light = hit.map_or(0.86, |(.., light)| *light);
            let [r, g, b] = [235.0, 245.0, 205.0].map(|c: f32| (c * light) as u8);
            pixels.extend([r, g, b, if hit.is_some() { 255 } else { 0 }]);
        }
    }
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::meshes::tests::{assert_sane, assert_solid};

    const ALL: [Species; 6] = [
        Species::Conifer,
        Species::Oak,
        Species::Birch,
        Species::DeadTree,
        Species::Bush,
        Species::Rock,
    ];

    #[test]
    fn every_plant_is_solid_and_stands_in_the_ground() {
        for species in ALL {
            for variant in 0..VARIANTS {
                let plant = build(species, variant);
                let name = format!("{species:?} {variant}");
                assert_solid(&plant.solid, &name);
                let (min, mut max) = plant.solid.bounds().unwrap();
                if !plant.leaves.is_empty() {
                    assert_sane(&plant.leaves, &name);
                    max = max.max(plant.leaves.bounds().unwrap().1);
                }
                assert!(min.y < -0.1, "{name} floats at {}", min.y);
                assert!(max.y <= height(species), "{name} is {} m high", max.y);
                assert!(max.y >= 0.45 * height(species), "{name} is only {} m high", max.y);
            }
        }
    }

    #[test]
    fn variants_differ_and_repeat() {
        assert_eq!(build(Species::Conifer, 1), build(Species::Conifer, 1 + VARIANTS));
        assert_ne!(build(Species::Conifer, 1), build(Species::Conifer, 2));
    }

    #[test]
    fn trees_stay_light_enough_for_thousands() {
        for species in ALL {
            let plant = build(species, 0);
            let triangles = (plant.solid.indices.len() + plant.leaves.indices.len()) / 3;
            assert!(triangles <= 600, "{species:?}: {triangles} triangles");
        }
    }

    #[test]
    fn the_leaf_texture_is_partly_clear_with_a_clear_border() {
        let side = 64;
        let pixels = leaf_texture(side);
        let clear = pixels.chunks(4).filter(|p| p[3] == 0).count() as f32 / (side * side) as f32;
        assert!((0.3..0.75).contains(&clear), "{clear} is clear");
        assert!(
            (0..side as usize).all(|x| pixels[x * 4 + 3] == 0),
            "a leaf is cut by the border"
        );
    }
}
