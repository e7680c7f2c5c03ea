//! Which level chains show, and what that costs, without a renderer.

use std::{sync::Arc, time::Duration};

use bevy::{camera::visibility::VisibilityRange, prelude::*, time::TimeUpdateStrategy};
use umbrage::{
    lod::{
        LodCounts, LodPlugin,
        chain::{LodChain, LodCoat, LodState},
        eyes::LodView,
        settings::{LodDriver, LodKind, LodSettings, LodTransition},
    },
    maths::lod::{
        crossing::Shown,
        selection::{LodBorders, LodMetric},
    },
};

use crate::support;

const FRAME: Duration = Duration::from_millis(20);

/// An app with a camera at the origin.
fn app() -> (App, Entity) {
    let mut app = support::app();
    app.add_plugins(LodPlugin)
        .insert_resource(TimeUpdateStrategy::ManualDuration(FRAME));
    let camera = app.world_mut().spawn((Camera3d::default(), Transform::default())).id();
    (app, camera)
}

/// A chain of levels up to 10 m, 20 m and beyond.
fn chain(app: &mut App, place: Vec3) -> Entity {
    let world = app.world_mut();
    let levels = (0..3).map(|_| vec![world.spawn((Transform::default(), Visibility::default())).id()]);
    let chain = LodChain {
        levels: levels.collect(),
        borders: Arc::new(LodBorders::new([10.0, 20.0])),
        metric: LodMetric::Distance,
    };
    world.spawn((chain, Transform::from_translation(place))).id()
}

fn shown(app: &App, chain: Entity) -> Option<Shown> {
    app.world().get::<LodState>(chain).and_then(LodState::shown)
}

/// Parts that are drawn, by level: 0 hidden, 1 opaque, 2 fading.
fn drawn(app: &App, chain: Entity) -> Vec<u8> {
    let world = app.world();
    let parts = world.get::<LodChain>(chain).expect("a chain").levels.iter().flatten();
    let state = |part: &Entity| match world.get::<Visibility>(*part) {
        Some(Visibility::Hidden) => 0,
        _ if world.get::<LodCoat>(*part).is_some() => 2,
        _ => 1,
    };
    parts.map(state).collect()
}

fn move_camera(app: &mut App, camera: Entity, z: f32) {
    app.world_mut()
        .get_mut::<Transform>(camera)
        .expect("a camera")
        .translation
        .z = z;
}

#[test]
fn the_first_level_is_there_at_once_and_later_ones_fade() {
    let (mut app, camera) = app();
    let near = chain(&mut app, Vec3::Z * -5.0);
    let far = chain(&mut app, Vec3::Z * -25.0);
    app.update();
    assert_eq!(
        (shown(&app, near), drawn(&app, near)),
        (Some(Shown::Level(0)), vec![1, 0, 0])
    );
    assert_eq!(
        (shown(&app, far), drawn(&app, far)),
        (Some(Shown::Level(2)), vec![0, 0, 1])
    );
    move_camera(&mut app, camera, 6.0);
    app.update();
    assert_eq!(drawn(&app, near), [1, 2, 0]);
    assert_eq!(app.world().resource::<LodCounts>().fading_parts, 1);
    // 20 ms of 400 ms each: in the second half the new one is opaque.
    for _ in 0..11 {
        app.update();
    }
    assert_eq!(drawn(&app, near), [2, 1, 0]);
    for _ in 0..9 {
        app.update();
    }
    assert_eq!(
        (shown(&app, near), drawn(&app, near)),
        (Some(Shown::Level(1)), vec![0, 1, 0])
    );
}

#[test]
fn chains_at_rest_are_not_compared_until_an_eye_has_come_far_enough() {
    let (mut app, camera) = app();
    for i in 0..50 {
        chain(&mut app, Vec3::new(i as f32 * 0.01, 0.0, -15.0));
    }
    app.update();
    app.update();
    let compared = |app: &App| app.world().resource::<LodCounts>().compared;
    assert_eq!(compared(&app), 0, "nothing moves");
    move_camera(&mut app, camera, 4.0);
    app.update();
    assert_eq!(compared(&app), 0, "borders are 5 m away");
    move_camera(&mut app, camera, 5.5);
    app.update();
    assert_eq!(compared(&app), 50);
    assert_eq!(app.world().resource::<LodCounts>().crossings, 50);
}

/// A chain whose parent moves is followed, too.
#[test]
fn things_that_move_are_followed() {
    let (mut app, _) = app();
    let chain = chain(&mut app, Vec3::ZERO);
    let cart = app
        .world_mut()
        .spawn((Transform::from_xyz(0.0, 0.0, -15.0), Visibility::default()))
        .id();
    app.world_mut().entity_mut(chain).insert(ChildOf(cart));
    app.update();
    app.update();
    app.update();
    let at = |app: &App| shown(app, chain).map(Shown::goal);
    assert_eq!(at(&app), Some(1));
    app.world_mut()
        .get_mut::<Transform>(cart)
        .expect("a cart")
        .translation
        .z = -25.0;
    app.update();
    app.update();
    assert_eq!(at(&app), Some(2));
}

#[test]
fn an_eye_that_jumps_takes_all_levels_along() {
    let (mut app, camera) = app();
    let chain = chain(&mut app, Vec3::ZERO);
    app.update();
    move_camera(&mut app, camera, 15.0);
    app.update();
    assert_eq!(shown(&app, chain), Some(Shown::Level(1)), "15 m in a frame");
    // Another eye from afar has no say unless it is nearer.
    app.world_mut().spawn((
        Camera3d::default(),
        Transform::from_xyz(0.0, 0.0, 5.0),
        LodView {
            decides: false,
            ..default()
        },
    ));
    app.update();
    assert_eq!(shown(&app, chain), Some(Shown::Level(1)));
    app.world_mut()
        .entity_mut(camera)
        .insert(LodView { bias: 2.0, ..default() });
    for _ in 0..30 {
        app.update();
    }
    assert_eq!(shown(&app, chain), Some(Shown::Level(2)), "a bias of 2 makes 15 m 30 m");
}

#[test]
fn kinds_change_while_running_for_all_or_for_one() {
    let (mut app, camera) = app();
    let (one, other) = (chain(&mut app, Vec3::ZERO), chain(&mut app, Vec3::X));
    app.world_mut().entity_mut(one).insert(LodTransition {
        kind: LodKind::Hard,
        driver: LodDriver::default(),
    });
    move_camera(&mut app, camera, 9.0);
    app.update();
    move_camera(&mut app, camera, 11.5);
    app.update();
    assert_eq!(shown(&app, one), Some(Shown::Level(1)));
    assert!(matches!(shown(&app, other), Some(Shown::Crossing(_))));
    app.world_mut().resource_mut::<LodSettings>().transition.kind = LodKind::Late;
    app.update();
    assert_eq!(
        shown(&app, other),
        Some(Shown::Level(0)),
        "11.5 m are 5.75 m for the late kind"
    );
    app.world_mut().resource_mut::<LodSettings>().transition.kind = LodKind::Dither;
    app.update();
    let ranges = |app: &mut App| {
        let world = app.world_mut();
        let mut ranges = world.query::<&VisibilityRange>();
        let ends: Vec<f32> = ranges.iter(world).map(|range| range.end_margin.end).collect();
        ends
    };
    let mut ends = ranges(&mut app);
    ends.sort_by(f32::total_cmp);
    assert_eq!(ends, [10.0, 20.0, f32::INFINITY]);
    assert_eq!(drawn(&app, other), [1, 1, 1], "Bevy decides");
    app.world_mut().resource_mut::<LodSettings>().transition.kind = LodKind::Unpopping;
    app.update();
    assert_eq!(ranges(&mut app), Vec::<f32>::new());
    assert_eq!(drawn(&app, other), [0, 1, 0]);
}
