//! Scene bounds follow moving, spawned, despawned, hidden and marked things.

use bevy::{
    camera::{primitives::Aabb, visibility::NoFrustumCulling},
    light::{NotShadowCaster, NotShadowReceiver},
    mesh::skinning::SkinnedMesh,
    prelude::*,
};
use umbrage::shadow::scene_bounds::{NotInSceneBounds, SceneBounds};

use crate::support::{app, assert_bounds, block, scene_bounds};

#[test]
fn an_empty_scene_has_no_bounds() {
    let mut app = app();
    app.update();
    assert_eq!(scene_bounds(&app), SceneBounds::default());
}

#[test]
fn bounds_follow_things() {
    let mut app = app();
    let ground = app.world_mut().spawn(block(Vec3::ZERO, Vec3::new(5.0, 0.0, 5.0))).id();
    let bird = app.world_mut().spawn(block(Vec3::Y * 3.0, Vec3::ONE)).id();
    app.update();
    assert_bounds(
        scene_bounds(&app).scene,
        Vec3::new(-5.0, 0.0, -5.0),
        Vec3::new(5.0, 4.0, 5.0),
    );

    app.world_mut()
        .entity_mut(bird)
        .insert(Transform::from_xyz(0.0, 20.0, 0.0));
    app.update();
    assert_bounds(
        scene_bounds(&app).scene,
        Vec3::new(-5.0, 0.0, -5.0),
        Vec3::new(5.0, 21.0, 5.0),
    );

    app.world_mut()
        .entity_mut(bird)
        .insert(Transform::from_xyz(0.0, 2.0, 0.0));
    app.update();
    assert_bounds(
        scene_bounds(&app).scene,
        Vec3::new(-5.0, 0.0, -5.0),
        Vec3::new(5.0, 3.0, 5.0),
    );

    app.world_mut().entity_mut(bird).insert(Visibility::Hidden);
    app.update();
    assert_bounds(
        scene_bounds(&app).scene,
        Vec3::new(-5.0, 0.0, -5.0),
        Vec3::new(5.0, 0.0, 5.0),
    );

    app.world_mut().entity_mut(bird).insert(Visibility::Inherited);
    app.update();
    assert_bounds(
        scene_bounds(&app).scene,
        Vec3::new(-5.0, 0.0, -5.0),
        Vec3::new(5.0, 3.0, 5.0),
    );

    app.world_mut().entity_mut(bird).despawn();
    app.update();
    assert_bounds(
        scene_bounds(&app).scene,
        Vec3::new(-5.0, 0.0, -5.0),
        Vec3::new(5.0, 0.0, 5.0),
    );

    app.world_mut().entity_mut(ground).remove::<Mesh3d>();
    app.update();
    assert_eq!(scene_bounds(&app), SceneBounds::default());
}

#[test]
fn children_move_with_their_parents() {
    let mut app = app();
    let parent = app
        .world_mut()
        .spawn((Transform::default(), Visibility::default()))
        .id();
    app.world_mut().spawn((block(Vec3::X, Vec3::ONE), ChildOf(parent)));
    app.update();
    assert_bounds(
        scene_bounds(&app).scene,
        Vec3::new(0.0, -1.0, -1.0),
        Vec3::new(2.0, 1.0, 1.0),
    );
    let turned = Transform::from_xyz(0.0, 10.0, 0.0)
        .with_rotation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2))
        .with_scale(Vec3::splat(2.0));
    app.world_mut().entity_mut(parent).insert(turned);
    app.update();
    assert_bounds(
        scene_bounds(&app).scene,
        Vec3::new(-2.0, 10.0, -2.0),
        Vec3::new(2.0, 14.0, 2.0),
    );
}

#[test]
fn casters_and_receivers_are_told_apart() {
    let mut app = app();
    app.world_mut().spawn((block(Vec3::ZERO, Vec3::ONE), NotShadowCaster));
    let lamp = app
        .world_mut()
        .spawn((block(Vec3::Y * 10.0, Vec3::ONE), NotShadowReceiver))
        .id();
    app.update();
    let bounds = scene_bounds(&app);
    assert_bounds(bounds.receivers, Vec3::NEG_ONE, Vec3::ONE);
    assert_bounds(bounds.casters, Vec3::new(-1.0, 9.0, -1.0), Vec3::new(1.0, 11.0, 1.0));
    assert_bounds(bounds.scene, Vec3::NEG_ONE, Vec3::new(1.0, 11.0, 1.0));

    app.world_mut().entity_mut(lamp).remove::<NotShadowReceiver>();
    app.update();
    assert_bounds(scene_bounds(&app).receivers, Vec3::NEG_ONE, Vec3::new(1.0, 11.0, 1.0));

    app.world_mut()
        .entity_mut(lamp)
        .insert((NotShadowReceiver, NotShadowCaster));
    app.update();
    assert_bounds(scene_bounds(&app).scene, Vec3::NEG_ONE, Vec3::ONE);
    assert_eq!(scene_bounds(&app).casters, None);
}

#[test]
fn backdrops_and_boundless_things_do_not_count() {
    let mut app = app();
    app.world_mut().spawn(block(Vec3::ZERO, Vec3::ONE));
    let sky = app
        .world_mut()
        .spawn((block(Vec3::ZERO, Vec3::splat(1.0e4)), NotInSceneBounds))
        .id();
    app.world_mut().spawn((
        Mesh3d::default(),
        Transform::from_xyz(500.0, 0.0, 0.0),
        NoFrustumCulling,
    ));
    app.world_mut().spawn(block(Vec3::ZERO, Vec3::splat(f32::INFINITY)));
    app.world_mut().spawn(block(Vec3::splat(f32::NAN), Vec3::ONE));
    app.update();
    assert_bounds(scene_bounds(&app).scene, Vec3::NEG_ONE, Vec3::ONE);

    app.world_mut().entity_mut(sky).remove::<NotInSceneBounds>();
    app.update();
    assert_bounds(scene_bounds(&app).scene, Vec3::splat(-1.0e4), Vec3::splat(1.0e4));
    app.world_mut().entity_mut(sky).insert(NotInSceneBounds);
    app.update();
    assert_bounds(scene_bounds(&app).scene, Vec3::NEG_ONE, Vec3::ONE);
}

#[test]
fn skinned_meshes_are_padded() {
    let mut app = app();
    let walker = app
        .world_mut()
        .spawn((block(Vec3::ZERO, Vec3::ONE), SkinnedMesh::default()))
        .id();
    app.update();
    assert_bounds(scene_bounds(&app).scene, Vec3::splat(-2.0), Vec3::splat(2.0));
    app.world_mut().entity_mut(walker).insert(Aabb {
        center: Vec3::ZERO.into(),
        half_extents: Vec3::splat(2.0).into(),
    });
    app.update();
    assert_bounds(scene_bounds(&app).scene, Vec3::splat(-4.0), Vec3::splat(4.0));
}

#[test]
fn bounds_that_do_not_change_are_not_marked_as_changed() {
    #[derive(Resource, Default)]
    struct Changes(u32);
    let mut app = app();
    app.init_resource::<Changes>();
    app.add_systems(Last, |bounds: Res<SceneBounds>, mut changes: ResMut<Changes>| {
        changes.0 += u32::from(bounds.is_changed());
    });
    app.world_mut().spawn(block(Vec3::ZERO, Vec3::splat(5.0)));
    let bird = app.world_mut().spawn(block(Vec3::ZERO, Vec3::ONE)).id();
    app.update();
    let after_first_frame = app.world().resource::<Changes>().0;
    for step in 0..5 {
        app.world_mut()
            .entity_mut(bird)
            .insert(Transform::from_xyz(step as f32 * 0.5, 0.0, 0.0));
        app.update();
    }
    assert_eq!(app.world().resource::<Changes>().0, after_first_frame);
}
