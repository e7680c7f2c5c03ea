//! A grove in cells, walked through without a renderer.

use std::time::Duration;

use bevy::{
    camera::{CameraPlugin, primitives::Aabb},
    math::Vec2,
    mesh::MeshPlugin,
    prelude::*,
    time::TimeUpdateStrategy,
};
use umbrage::{
    level::{
        grove::{
            Grove, blocks,
            field::{self, CHANGES, CellCounts, CellField, TreeLooks},
            side,
        },
        land::Land,
        simple_trees::LEVELS,
    },
    lod::{
        LodCounts, LodPlugin,
        chain::{LodChain, LodCoat, LodState},
        settings::{LodKind, LodSettings},
    },
    maths::lod::{cells::Cell, crossing::Shown},
};

/// Metres per frame, at 60 frames per second.
const STEP: f32 = 1.0;

/// An app with a grove and a camera at its origin.
fn app(count: u32, wind: f32) -> (App, Entity) {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        AssetPlugin::default(),
        MeshPlugin,
        ImagePlugin::default(),
        CameraPlugin,
        LodPlugin,
    ))
    .init_asset::<StandardMaterial>()
    .add_plugins(field::plugin)
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(16)));
    let land = Land::new(Vec2::splat(side(count) as f32 * 5.0 + 20.0), None, 1);
    let mesh = (Handle::<Mesh>::default(), Aabb::default());
    let looks = TreeLooks {
        meshes: vec![vec![mesh; LEVELS]; blocks::models().count()],
        material: Handle::default(),
    };
    let grove = Grove::new(count, 5.0, 1, land).in_wind(wind);
    let world = app.world_mut();
    world.spawn(CellField::new(grove, looks));
    let camera = world
        .spawn((Camera3d::default(), Transform::from_xyz(0.0, 1.7, 0.0)))
        .id();
    (app, camera)
}

fn walk_to(app: &mut App, camera: Entity, place: Vec3) {
    app.world_mut()
        .get_mut::<Transform>(camera)
        .expect("a camera")
        .translation = place;
    app.update();
}

fn counts(app: &App) -> CellCounts {
    *app.world().resource::<CellCounts>()
}

/// Entities that can be drawn.
fn meshes(app: &mut App) -> usize {
    app.world_mut().query::<&Mesh3d>().iter(app.world()).count()
}

/// Every leaf of the field is drawn by one thing that is opaque: the block of a cell around it, or its trees.
#[track_caller]
fn assert_drawn_once(app: &mut App, when: impl std::fmt::Display) {
    let world = app.world_mut();
    let mut fields = world.query::<&CellField>();
    let field = fields.single(world).expect("a grove");
    let leaves = field.grove().grid().leaves;
    let mut drawn = vec![0; (leaves * leaves) as usize];
    let is_opaque = |block: Entity| {
        let is_hidden = world.get::<Visibility>(block) == Some(&Visibility::Hidden);
        !is_hidden && world.get::<LodCoat>(block).is_none()
    };
    for (cell, block, trees) in field.cells() {
        if !(trees > 0 || block.is_some_and(is_opaque)) {
            continue;
        }
        assert!(
            trees == 0 || !block.is_some_and(is_opaque),
            "{when}: {cell:?} has trees and a block"
        );
        let places = |place: u32| place * cell.leaves()..((place + 1) * cell.leaves()).min(leaves);
        for z in places(cell.z) {
            places(cell.x).for_each(|x| drawn[(z * leaves + x) as usize] += 1);
        }
    }
    let wrong = drawn.iter().position(|times| *times != 1);
    if let Some(leaf) = wrong {
        let cell = Cell {
            level: 0,
            x: leaf as u32 % leaves,
            z: leaf as u32 / leaves,
        };
        panic!("{when}: {cell:?} is drawn {} times", drawn[leaf]);
    }
}

#[test]
fn a_walk_of_500_m_keeps_few_entities_and_no_gaps() {
    let (mut app, camera) = app(100_000, 0.0);
    walk_to(&mut app, camera, Vec3::new(-250.0, 1.7, 3.0));
    let first = counts(&app);
    assert!((1500..3500).contains(&first.trees), "{first:?}");
    assert!((100..500).contains(&first.blocks), "{first:?}");
    let (mut most, mut changed, mut crossings) = (meshes(&mut app), 0, 0);
    for step in 1..=500 {
        let x = -250.0 + STEP * step as f32;
        walk_to(&mut app, camera, Vec3::new(x, 1.7, 3.0));
        assert_drawn_once(&mut app, format_args!("at {x} m"));
        let now = counts(&app);
        assert!(now.changes <= 2 * CHANGES as u32, "{now:?}");
        changed += now.changes;
        crossings += app.world().resource::<LodCounts>().crossings;
        most = most.max(meshes(&mut app));
    }
    let last = counts(&app);
    assert!((40..1000).contains(&changed), "{changed} changes");
    assert!(crossings > 100, "{crossings} crossings");
    assert!(last.trees.abs_diff(first.trees) < 900, "{first:?} {last:?}");
    assert!(most < 12_000, "{most} meshes of 100 000 trees");
}

/// 60 m/s over 3 m: what is near is there, although few cells change in a frame.
#[test]
fn near_trees_stand_alone_in_their_own_levels() {
    let (mut app, camera) = app(20_000, 0.0);
    for step in 0..60 {
        walk_to(&mut app, camera, Vec3::new(STEP * step as f32, 3.0, 0.0));
    }
    let eye = Vec3::new(59.0, 3.0, 0.0);
    let world = app.world_mut();
    let mut chains = world.query::<(&LodChain, &LodState, &Transform)>();
    let goals: Vec<(f32, usize)> = chains
        .iter(world)
        .filter(|(chain, ..)| chain.levels.len() == LEVELS)
        .map(|(_, state, place)| (place.translation.distance(eye), state.shown().map_or(9, Shown::goal)))
        .collect();
    let near = |limit: f32| goals.iter().filter(|(distance, _)| *distance < limit).count();
    // A tree for every 25 m².
    assert!((60..100).contains(&near(25.0)), "{} trees within 25 m", near(25.0));
    assert!((390..530).contains(&near(60.0)), "{} trees within 60 m", near(60.0));
    for (distance, goal) in goals {
        let expected = if distance < 23.0 {
            0..1
        } else if distance < 57.0 {
            0..2
        } else {
            0..3
        };
        assert!(expected.contains(&goal), "level {goal} at {distance} m");
        assert!(distance < 62.0 || goal == 2, "level {goal} at {distance} m");
    }
}

#[test]
fn an_eye_that_jumps_finds_everything_there() {
    let (mut app, camera) = app(100_000, 0.0);
    for place in [
        Vec3::new(0.0, 1.7, 0.0),
        Vec3::new(700.0, 1.7, -650.0),
        Vec3::new(0.0, 900.0, 0.0),
        Vec3::new(-3000.0, 1.7, 0.0),
        Vec3::new(-400.0, 30.0, 100.0),
    ] {
        walk_to(&mut app, camera, place);
        assert_drawn_once(&mut app, format_args!("in the first frame at {place}"));
        let first = counts(&app);
        walk_to(&mut app, camera, place);
        assert_drawn_once(&mut app, format_args!("in the second frame at {place}"));
        let second = counts(&app);
        assert_eq!(second.changes, 0, "{place}: something was left to do");
        assert_eq!(CellCounts { changes: 0, ..first }, second);
    }
}

/// Whatever the kind of transition, and where it changes.
#[test]
fn every_kind_leaves_no_gaps() {
    let (mut app, camera) = app(30_000, 0.0);
    for (round, kind) in LodKind::ALL.into_iter().enumerate() {
        app.world_mut().resource_mut::<LodSettings>().transition.kind = kind;
        for step in 0..120 {
            let x = -100.0 + 30.0 * round as f32 + STEP * step as f32;
            walk_to(&mut app, camera, Vec3::new(x, 1.7, 0.0));
            // Both levels of a plain crossing are semitransparent.
            if kind != LodKind::Plain {
                assert_drawn_once(&mut app, format_args!("{} at {x} m", kind.name()));
            }
        }
    }
}

#[test]
fn the_number_of_entities_hardly_grows_with_that_of_trees() {
    let [few, many, most] = [10_000, 100_000, 1_000_000].map(|count| {
        let (mut app, _) = app(count, 0.0);
        app.update();
        (meshes(&mut app), counts(&app).trees)
    });
    // More or less by the eye's place in its leaf.
    for (_, near) in [few, many, most] {
        assert!((1600..2300).contains(&near), "{near} trees stand alone");
    }
    assert!(most.0 < few.0 * 11 / 10, "{few:?} {many:?} {most:?}");
}

#[test]
fn a_grove_may_end_anywhere() {
    for count in [1, 2, 63, 64, 65, 1000] {
        let (mut app, camera) = app(count, 0.0);
        app.update();
        assert_eq!(counts(&app).trees, count, "all are near");
        walk_to(&mut app, camera, Vec3::new(0.0, 5000.0, 0.0));
        let root_is_leaf = count <= 64;
        assert_eq!(counts(&app).trees, if root_is_leaf { count } else { 0 });
    }
}

#[test]
fn only_near_trees_bend_in_the_wind() {
    let (mut app, _) = app(20_000, 10.0);
    let rotations = |app: &mut App| -> Vec<(f32, Quat)> {
        let world = app.world_mut();
        let mut parts = world.query_filtered::<&Transform, With<Mesh3d>>();
        parts
            .iter(world)
            .map(|place| (place.translation.length(), place.rotation))
            .collect()
    };
    app.update();
    app.update();
    let before = rotations(&mut app);
    for _ in 0..20 {
        app.update();
    }
    let after = rotations(&mut app);
    let moved = |range: std::ops::Range<f32>| {
        let pairs = before.iter().zip(&after).filter(|(a, _)| range.contains(&a.0));
        pairs.filter(|(a, b)| a.1 != b.1).count()
    };
    assert!(moved(0.0..30.0) > 100, "{} parts moved", moved(0.0..30.0));
    assert_eq!(moved(65.0..1e4), 0, "far trees stand still");
}
