//! Which level chains show, and what that costs, without a renderer.

use std::{sync::Arc, time::Duration};

use bevy::{
    camera::visibility::{VisibilityRange, VisibleEntities},
    light::NotShadowCaster,
    mesh::morph::MeshMorphWeights,
    prelude::*,
    time::TimeUpdateStrategy,
};
use umbrage::{
    lod::{
        LodCounts, LodPlugin,
        casters::{CastsFor, LodShadowBias, ShadowOnly},
        chain::{LodChain, LodCoat, LodMorph, LodState},
        eyes::LodView,
        settings::{LodDriver, LodKind, LodSettings, LodTransition},
    },
    maths::lod::{
        crossing::{Crossing, Shown},
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

/// A chain with meshes, around a place.
fn chain_of_meshes(app: &mut App, place: Vec3) -> Entity {
    let chain = chain(app, place);
    let parts: Vec<Entity> = app.world().get::<LodChain>(chain).expect("a chain").levels.concat();
    for part in parts {
        let mesh = support::block(place, Vec3::ONE);
        app.world_mut().entity_mut(part).insert((mesh, Name::new("part")));
    }
    chain
}

/// The chain that casts for another one.
fn second_of(app: &mut App, chain: Entity) -> Option<Entity> {
    let world = app.world_mut();
    let mut seconds = world.query_filtered::<(Entity, &CastsFor), With<LodChain>>();
    seconds
        .iter(world)
        .find(|(_, casts)| casts.0 == chain)
        .map(|(second, _)| second)
}

/// Levels whose shadows are cast, by the parts of the chain and of its second one.
fn casting(app: &mut App, chain: Entity) -> Vec<(usize, bool)> {
    let second = second_of(app, chain);
    let world = app.world();
    let of = |chain: Entity, is_second: bool| {
        let levels = world.get::<LodChain>(chain).expect("a chain").levels.clone();
        levels.into_iter().enumerate().flat_map(move |(level, parts)| {
            let casts = move |part: Entity| {
                world.get::<Visibility>(part) != Some(&Visibility::Hidden)
                    && world.get::<NotShadowCaster>(part).is_none()
                    && world.get::<ShadowOnly>(part).is_some() == is_second
            };
            parts
                .into_iter()
                .filter(move |part| casts(*part))
                .map(move |_| (level, is_second))
        })
    };
    of(chain, false)
        .chain(second.into_iter().flat_map(|second| of(second, true)))
        .collect()
}

#[test]
fn shadows_of_coarser_levels_come_from_a_chain_that_no_camera_sees() {
    let (mut app, camera) = app();
    let (one, other) = (
        chain_of_meshes(&mut app, Vec3::Z * -8.0),
        chain_of_meshes(&mut app, Vec3::new(3.0, 0.0, -8.0)),
    );
    app.update();
    assert_eq!(casting(&mut app, one), [(0, false)], "what is seen casts");
    app.world_mut().entity_mut(one).insert(LodShadowBias(2.0));
    app.update();
    app.update();
    assert_eq!(
        (drawn(&app, one), casting(&mut app, one)),
        (vec![1, 0, 0], vec![(1, true)]),
        "16 m for shadows"
    );
    assert_eq!(casting(&mut app, other), [(0, false)], "only one chain is biased");
    let seen = app.world().get::<VisibleEntities>(camera).expect("a camera").clone();
    let seen = seen.get(std::any::TypeId::of::<Mesh3d>());
    assert!(
        !seen.is_empty()
            && seen
                .iter()
                .all(|entity| app.world().get::<ShadowOnly>(*entity).is_none())
    );
    assert_eq!(
        app.world().resource::<LodCounts>().chains,
        2,
        "chains that only cast are not counted"
    );

    // 20.4 m for shadows: they cross, and nothing else does.
    move_camera(&mut app, camera, 2.2);
    app.update();
    let second = second_of(&mut app, one).expect("a second chain");
    let crossing = shown(&app, second);
    assert!(
        matches!(crossing, Some(Shown::Crossing(Crossing { from: 1, to: 2, t })) if t > 0.0 && t < 0.2),
        "{crossing:?}"
    );
    assert!(matches!(
        shown(&app, one),
        Some(Shown::Crossing(Crossing { to: 1, .. }))
    ));
    assert_eq!(app.world().resource::<LodCounts>().crossings, 2, "those that are seen");
    for _ in 0..25 {
        app.update();
    }
    assert_eq!(casting(&mut app, one), [(2, true)]);

    app.world_mut().entity_mut(one).remove::<LodShadowBias>();
    app.update();
    app.update();
    assert_eq!(casting(&mut app, one), [(1, false)], "what is seen casts again");
    assert_eq!(second_of(&mut app, one), None);
}

#[test]
fn biases_of_all_of_a_view_and_of_a_chain_are_multiplied() {
    let (mut app, camera) = app();
    let chain = chain_of_meshes(&mut app, Vec3::Z * -6.0);
    app.world_mut().resource_mut::<LodSettings>().shadow_bias = 1.5;
    app.world_mut().entity_mut(camera).insert(LodView {
        shadow_bias: 3.0,
        ..default()
    });
    app.world_mut().entity_mut(chain).insert(LodShadowBias(0.5));
    app.update();
    app.update();
    assert_eq!(casting(&mut app, chain), [(1, true)], "13.5 m");
    app.world_mut().entity_mut(chain).insert(LodShadowBias(f32::NAN));
    for _ in 0..25 {
        app.update();
    }
    assert_eq!(casting(&mut app, chain), [(2, true)], "27 m");
    app.world_mut().entity_mut(chain).despawn();
    app.update();
    let world = app.world_mut();
    let left = world.query_filtered::<Entity, With<CastsFor>>().iter(world).count();
    assert_eq!(left, 0, "the second chain goes with the first one");
}

#[test]
fn both_halves_of_a_picture_have_their_kind() {
    let (mut app, camera) = app();
    let (left, right) = (chain(&mut app, Vec3::X * -5.0), chain(&mut app, Vec3::X * 5.0));
    app.world_mut().resource_mut::<LodSettings>().right_half = Some(LodKind::Hard);
    app.update();
    move_camera(&mut app, camera, 9.0);
    app.update();
    assert!(matches!(shown(&app, left), Some(Shown::Crossing(_))));
    assert_eq!(shown(&app, right), Some(Shown::Level(1)));
    // Turned round, left is right.
    for _ in 0..25 {
        app.update();
    }
    app.world_mut().get_mut::<Transform>(camera).expect("a camera").rotation =
        Quat::from_rotation_y(std::f32::consts::PI);
    move_camera(&mut app, camera, 0.0);
    app.update();
    assert_eq!(shown(&app, left), Some(Shown::Level(0)));
    assert!(matches!(shown(&app, right), Some(Shown::Crossing(_))));
}

/// Weights of the first morph target, level by level.
fn weights(app: &App, chain: Entity) -> Vec<f32> {
    let world = app.world();
    let levels = &world.get::<LodChain>(chain).expect("a chain").levels;
    let weight = |part: &Entity| match world.get::<MeshMorphWeights>(*part) {
        Some(MeshMorphWeights::Value { weights }) => weights.first().copied(),
        _ => None,
    };
    levels.iter().flatten().filter_map(weight).collect()
}

#[test]
fn levels_that_correspond_morph_and_others_fade() {
    let (mut app, camera) = app();
    let (morphing, fading) = (chain(&mut app, Vec3::ZERO), chain(&mut app, Vec3::X));
    let finer: Vec<Entity> = app.world().get::<LodChain>(morphing).expect("a chain").levels[..2].concat();
    for part in finer {
        app.world_mut().entity_mut(part).insert(LodMorph);
    }
    app.world_mut().resource_mut::<LodSettings>().transition.kind = LodKind::Geomorph;
    app.update();
    for z in [9.0, 18.0] {
        move_camera(&mut app, camera, z);
        app.update();
    }
    // Behind both borders: one after the other.
    move_camera(&mut app, camera, 20.5);
    // It began a frame before.
    for frame in 2..20 {
        app.update();
        let share = frame as f32 / 20.0;
        assert_eq!(drawn(&app, morphing), [1, 0, 0], "frame {frame}");
        let [first, second] = weights(&app, morphing)[..] else {
            panic!("two parts morph")
        };
        assert!((first - share).abs() < 0.06 && second == 0.0, "frame {frame}: {first}");
    }
    assert!(drawn(&app, fading).contains(&2), "no correspondence");
    for _ in 0..30 {
        app.update();
    }
    assert_eq!(
        (drawn(&app, morphing), weights(&app, morphing)),
        (vec![0, 0, 1], vec![0.0, 0.0])
    );
    // Back, it begins at the coarser end.
    move_camera(&mut app, camera, 15.0);
    app.update();
    app.update();
    let back = weights(&app, morphing);
    assert!(drawn(&app, morphing) == [0, 1, 0] && back[1] > 0.8, "{back:?}");
}
