//! Kinds of transition beside Unpopping, kinds side by side, and shadows of other levels than are seen.

use bevy::{
    mesh::{
        VertexAttributeValues,
        morph::MorphAttributes,
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};
use umbrage::{
    lod::{
        chain::{LodChain, LodMorph},
        settings::{LodKind, LodSettings},
    },
    maths::lod::energy::linear_light,
    prelude::*,
};

use super::{SIZE, cards, chain, flat, picture_at, pixel, set_share, stage};
use crate::harness::{Harness, WARM_UP};

/// Bevy chooses shaders when meshes change, and not when visibility ranges do.
#[test]
fn dither_can_be_chosen_while_running() {
    let mut harness = stage();
    let (red, blue) = (
        flat(&mut harness, Color::srgb(0.8, 0.1, 0.1)),
        flat(&mut harness, Color::srgb(0.1, 0.1, 0.9)),
    );
    let card = harness.mesh(cards(&[(1.0, 1.0, 0.0)]));
    chain(&mut harness, Transform::default(), &[(&card, &red), (&card, &blue)]);
    harness.app.world_mut().resource_mut::<LodSettings>().transition.kind = LodKind::Hard;
    harness.start();
    let colors = |picture: &[u8]| {
        let block = (20..28).flat_map(|y| (40..56).map(move |x| (x, y)));
        block.filter(|(x, y)| pixel(picture, *x, *y)[2] > 128).count()
    };
    assert_eq!(colors(&picture_at(&mut harness, 0.5)), 0, "the finer level");
    harness.app.world_mut().resource_mut::<LodSettings>().transition.kind = LodKind::Dither;
    let half = colors(&picture_at(&mut harness, 0.5));
    assert!(
        (48..=80).contains(&half),
        "{half} of 128 pixels show the coarser level half way"
    );
    harness.app.world_mut().resource_mut::<LodSettings>().transition.kind = LodKind::Hard;
    assert_eq!(colors(&picture_at(&mut harness, 0.5)), 0, "and back");
}

#[test]
fn two_kinds_side_by_side() {
    let mut harness = stage();
    let (black, blue) = (
        flat(&mut harness, Color::linear_rgb(0.0, 0.0, 0.0)),
        flat(&mut harness, Color::linear_rgb(0.0, 0.0, 1.0)),
    );
    let card = harness.mesh(cards(&[(0.5, 0.5, 0.0)]));
    // Kinds go by the places of chains, which a part's own need not be.
    for x in [-1.0, 1.0] {
        let place = Transform::from_xyz(x, 0.0, 0.0);
        let chain = chain(&mut harness, place, &[(&card, &black), (&card, &blue)]);
        harness.app.world_mut().entity_mut(chain).insert(place);
    }
    harness.app.world_mut().resource_mut::<LodSettings>().right_half = Some(LodKind::Hard);
    harness.start();
    // Of equal surfaces the finer one is over the other: it fades in the second half.
    let late = picture_at(&mut harness, 0.75);
    let [left, right] = [36, 60].map(|x| linear_light(pixel(&late, x, 27)[2]));
    assert!(
        (0.4..0.7).contains(&left) && right == 0.0,
        "fading {left}, switching {right}"
    );
    let end = picture_at(&mut harness, 1.1);
    let [left, right] = [36, 60].map(|x| linear_light(pixel(&end, x, 27)[2]));
    assert_eq!([left, right], [1.0, 1.0]);
}

/// A card that morphs into a lower one: its edge moves, and nothing is transparent.
#[test]
fn levels_that_correspond_move_into_each_other() {
    let mut harness = stage();
    let dark = flat(&mut harness, Color::linear_rgb(0.0, 0.0, 0.0));
    let down = |half_height: f32| [-half_height, -half_height, half_height, half_height].map(|y| Vec3::Y * y);
    let targets = down(-0.6).map(|to| MorphAttributes::new(to, Vec3::ZERO, Vec3::ZERO));
    let high = harness.mesh(cards(&[(1.0, 1.2, 0.0)]).with_morph_targets(targets.to_vec()));
    let low = harness.mesh(cards(&[(1.0, 0.6, 0.0)]));
    let chain = chain(&mut harness, Transform::default(), &[(&high, &dark), (&low, &dark)]);
    let world = harness.app.world_mut();
    let finer = world.get::<LodChain>(chain).expect("a chain").levels[0][0];
    world.entity_mut(finer).insert(LodMorph);
    world.resource_mut::<LodSettings>().transition.kind = LodKind::Geomorph;
    harness.start();
    let heights: Vec<usize> = [0.0, 0.5, 0.999, 1.0]
        .into_iter()
        .map(|t| {
            let shown = picture_at(&mut harness, t);
            let column: Vec<u8> = (0..SIZE.y).map(|y| pixel(&shown, 48, y)[0]).collect();
            assert!(column.iter().all(|code| [0, 255].contains(code)), "t {t}: {column:?}");
            column.iter().filter(|code| **code == 0).count()
        })
        .collect();
    let [start, half, last, end] = heights[..] else {
        unreachable!("four")
    };
    assert!(start >= 2 * end - 2 && last == end, "{heights:?}");
    assert!(half.abs_diff((start + end) / 2) <= 1, "{heights:?}");
}

/// With biased shadows the fine level is seen, and the shadow is the coarse one's.
#[test]
fn shadows_can_be_those_of_a_coarser_level() {
    let mut harness = stage();
    let gray = harness.material(Color::srgb(0.5, 0.5, 0.5));
    let (small, large) = (
        harness.mesh(Cuboid::new(0.4, 0.4, 0.1)),
        harness.mesh(Cuboid::new(1.2, 1.2, 0.1)),
    );
    let place = Transform::from_xyz(-0.8, 0.8, 0.5);
    chain(&mut harness, place, &[(&small, &gray), (&large, &gray)]);
    let wall = harness.mesh(cards(&[(3.0, 2.0, -0.5)]));
    harness.app.world_mut().spawn((Mesh3d(wall), MeshMaterial3d(gray)));
    harness.sun(Vec3::new(1.0, -1.0, -1.0), SunShadows::LOW);
    harness.start();
    let dark = |harness: &Harness| {
        let result = harness.shadow_result(harness.camera);
        result.iter().filter(|lit| **lit < 0.5).count()
    };
    let seen = |harness: &mut Harness| {
        set_share(harness, -2.0);
        harness.frames(WARM_UP);
        dark(harness)
    };
    let fine = seen(&mut harness);
    harness.app.world_mut().resource_mut::<LodSettings>().shadow_bias = 4.0;
    let biased = seen(&mut harness);
    assert!(
        biased > 4 * fine && fine > 5,
        "{fine} pixels in shadow, with the bias {biased}"
    );
    harness.app.world_mut().resource_mut::<LodSettings>().shadow_bias = 1.0;
    assert_eq!(seen(&mut harness), fine, "and back");
    set_share(&mut harness, 1.5);
    harness.frames(WARM_UP);
    let coarse = dark(&harness);
    assert!(
        coarse.abs_diff(biased) < biased / 3,
        "the coarse level's own {coarse}, biased {biased}"
    );
}

/// Two levels of an animated thing share joints: the fading one is bent as the opaque one is, and blends with it.
#[test]
fn skinned_levels_fade_in_their_pose() {
    let mut harness = stage();
    let (red, blue) = (
        flat(&mut harness, Color::srgb(0.8, 0.1, 0.1)),
        flat(&mut harness, Color::srgb(0.1, 0.1, 0.8)),
    );
    let bent = |harness: &mut Harness, half_height: f32, z: f32| {
        let mut mesh = cards(&[(1.0, half_height, z)]);
        // The right side hangs on the second joint.
        let joints = [0, 1, 1, 0].map(|joint| [joint, 0, 0, 0]).to_vec();
        mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(joints));
        mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0_f32, 0.0, 0.0, 0.0]; 4]);
        harness.mesh(mesh)
    };
    let (narrow, wide) = (bent(&mut harness, 0.3, 0.0), bent(&mut harness, 0.5, 0.1));
    let entity = chain(&mut harness, Transform::default(), &[(&narrow, &red), (&wide, &blue)]);
    let world = harness.app.world_mut();
    let inverse_bindposes = world
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(vec![Mat4::IDENTITY, Mat4::IDENTITY]);
    let joints = [0.0, 1.2]
        .map(|y| world.spawn(Transform::from_xyz(0.0, y, 0.0)).id())
        .to_vec();
    let levels = world.get::<LodChain>(entity).expect("a chain").levels.clone();
    for part in levels.into_iter().flatten() {
        let skin = SkinnedMesh {
            inverse_bindposes: inverse_bindposes.clone(),
            joints: joints.clone(),
        };
        world.entity_mut(part).insert(skin);
    }
    harness.start();
    let [start, quarter, middle] = [0.0, 0.25, 0.5].map(|t| picture_at(&mut harness, t));
    // Raised by 1.2 m at x = 1: the middle of the right edge is 12 pixels higher than that of the left one.
    let (left, right) = ((SIZE.x / 2 - 9, SIZE.y / 2), (SIZE.x / 2 + 8, SIZE.y / 2 - 11));
    for (x, y) in [left, right] {
        let [r, _, b] = pixel(&start, x, y);
        assert!(r > 200 && b < 50, "the old level is at {x}, {y}: {r}, {b}");
        let [r, _, b] = pixel(&middle, x, y);
        assert!(b > 200 && r < 50, "the new level is at {x}, {y}: {r}, {b}");
    }
    assert_eq!(
        pixel(&start, SIZE.x / 2 + 8, SIZE.y / 2 + 2),
        [255; 3],
        "and not where it would be unbent"
    );
    let farthest = start
        .iter()
        .zip(&quarter)
        .zip(&middle)
        .map(|((start, quarter), middle)| {
            let mixed = 0.5 * (linear_light(*start) + linear_light(*middle));
            (linear_light(*quarter) - mixed).abs()
        })
        .fold(0.0, f64::max);
    assert!(farthest < 0.01, "{farthest} of light off");
}
