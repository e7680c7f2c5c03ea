//! Trees in cells: nothing is seen of a leaf that opens, and little of blocks that take each other's place.

use bevy::{camera::primitives::Aabb, math::Vec2, prelude::*};
use umbrage::{
    level::{
        grove::{
            Grove, blocks,
            field::{self, CellCounts, CellField, TreeLooks},
            side,
        },
        land::Land,
        simple_trees::{LEVELS, build_level},
        spawn::to_mesh,
    },
    lod::{LodCounts, eyes::LodView},
    maths::lod::energy::picture_energy,
    prelude::*,
    render::capture,
};

use crate::harness::Harness;

const SIZE: UVec2 = UVec2::new(192, 108);

/// A grove before a camera at its edge, in the sun.
fn stage(count: u32) -> Harness {
    let edge = 2.5 * side(count) as f32;
    let eye = Transform::from_xyz(10.0, 9.0, edge + 14.0).looking_at(Vec3::new(0.0, 2.0, 0.0), Vec3::Y);
    let mut harness = Harness::new(SIZE, eye);
    harness.app.add_plugins(field::plugin);
    let meshes = blocks::models()
        .map(|(kind, variant)| {
            let levels = (0..LEVELS).map(|level| {
                let data = build_level(kind, variant, level);
                let (min, max) = data.bounds().expect("a tree");
                (harness.mesh(to_mesh(data)), Aabb::from_min_max(min, max))
            });
            levels.collect()
        })
        .collect();
    let material = harness.material(StandardMaterial {
        perceptual_roughness: 0.95,
        reflectance: 0.25,
        ..default()
    });
    let land = Land::new(Vec2::splat(2.0 * edge + 20.0), None, 1);
    for mut patch in land.patches() {
        let mesh = harness.mesh(to_mesh(patch.levels.remove(0).mesh));
        let place = Transform::from_translation(patch.origin);
        let ground = (Mesh3d(mesh), MeshMaterial3d(material.clone()), place);
        harness.app.world_mut().spawn(ground);
    }
    let grove = Grove::new(count, 5.0, 1, land);
    let world = harness.app.world_mut();
    world.spawn(CellField::new(grove, TreeLooks { meshes, material }));
    harness.sun(Vec3::new(-0.6, -0.6, -0.4), SunShadows::default());
    harness
}

/// Puts the eye of the levels above the middle; the picture's camera stays.
fn set_height(harness: &mut Harness, height: f32) {
    harness.app.world_mut().entity_mut(harness.camera).insert(LodView {
        origin: Some(Vec3::Y * height),
        ..default()
    });
}

fn picture(harness: &Harness) -> Vec<u8> {
    let texels = capture::read_image(&harness.app, &harness.target).expect("the picture can be read");
    texels.bytes
}

fn trees(harness: &Harness) -> u32 {
    harness.app.world().resource::<CellCounts>().trees
}

/// Share of pixels that differ by more than rounding does.
fn difference(a: &[u8], b: &[u8]) -> f64 {
    let pixels = a.chunks(4).zip(b.chunks(4));
    let differ = pixels.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 6));
    differ.count() as f64 / f64::from(SIZE.x * SIZE.y)
}

/// Trees that stand alone in their last level look as they do in the block of their leaf, shadows included, in every frame of
/// the change.
#[test]
fn nothing_is_seen_of_a_leaf_that_opens() {
    let mut harness = stage(256);
    set_height(&mut harness, 140.0);
    harness.start();
    harness.frames(3);
    assert_eq!(trees(&harness), 0, "all in blocks");
    let in_blocks = picture(&harness);
    let colors: std::collections::HashSet<&[u8]> = in_blocks.chunks(4).collect();
    assert!(colors.len() > 300, "a picture of trees has {} colors", colors.len());
    for (frame, height) in [132.0, 124.0, 116.0, 115.0, 115.0, 115.0].into_iter().enumerate() {
        set_height(&mut harness, height);
        harness.frames(1);
        let now = difference(&picture(&harness), &in_blocks);
        assert!(now < 0.002, "frame {frame}: {:.2} % of the pixels differ", 100.0 * now);
    }
    assert_eq!(trees(&harness), 256, "all alone");
    set_height(&mut harness, 30.0);
    harness.frames(2);
    let near = difference(&picture(&harness), &in_blocks);
    assert!(near > 0.02, "finer levels look different: {:.2} %", 100.0 * near);
}

/// Blocks of four leaves and those of the leaves, by Unpopping: no frame of the crossing changes much of what the whole
/// changes.
#[test]
fn blocks_fade_into_larger_blocks() {
    let mut harness = stage(1024);
    set_height(&mut harness, 210.0);
    harness.start();
    harness.frames(3);
    let (before, mut last) = (picture(&harness), picture(&harness));
    set_height(&mut harness, 218.0);
    harness.frames(2);
    assert_eq!(
        harness.app.world().resource::<LodCounts>().crossings,
        4,
        "the cells of level 1 cross"
    );
    let mut largest: f64 = 0.0;
    for _ in 0..40 {
        harness.frames(1);
        let now = picture(&harness);
        largest = largest.max(picture_energy(&last, &now));
        last = now;
    }
    assert_eq!(harness.app.world().resource::<LodCounts>().crossings, 0, "all is done");
    let hard = picture_energy(&before, &last);
    assert!(hard > 1.0, "levels differ: {hard}");
    assert!(largest < 0.1 * hard, "a frame changes {largest}, the whole {hard}");
}
