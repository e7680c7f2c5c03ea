//! Light views of suns for cameras.

use bevy::{camera::ScalingMode, prelude::*};
use umbrage::{
    maths::{split::SplitScheme, warp::Warp},
    shadow::{
        gizmos::SunShadowGizmos,
        settings::{Partitions, ShadowPath, SunShadows, WithoutSunShadows},
        views::{CameraSunViews, SunViews},
    },
};

use crate::support::{app, block, spawn_camera, spawn_sun, spawn_town, views};

/// Points on the ground that the camera of the tests sees.
fn seen_ground() -> impl Iterator<Item = Vec3> {
    (0..50).map(|step| Vec3::new((step % 7) as f32 * 0.3 - 1.0, 0.0, 5.0 - step as f32))
}

#[track_caller]
fn assert_covered(views: &CameraSunViews, point: Vec3, depth: f32) {
    let partition = views
        .partitions
        .iter()
        .find(|partition| (partition.light_view.near_depth..partition.light_view.far_depth).contains(&depth))
        .unwrap_or_else(|| panic!("no partition for depth {depth}"));
    for matrix in [partition.light_view.clip_from_world, views.master.clip_from_world] {
        let clip = matrix * point.extend(1.0);
        let ndc = clip.truncate() / clip.w;
        assert!(clip.w > 0.0, "{point} is behind the projection centre");
        assert!(ndc.truncate().abs().max_element() < 1.0, "{point}: {ndc}");
        assert!(ndc.z > 0.0 && ndc.z < 1.0, "{point}: {ndc}");
    }
}

#[test]
fn receivers_in_view_are_covered() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, SunShadows::HIGH);
    app.update();
    let views = views(&app, sun, camera).expect("the camera sees the town");
    assert_eq!(views.partitions.len(), 4);
    let eye = *app.world().get::<GlobalTransform>(camera).expect("placed");
    for point in seen_ground() {
        let depth = (point - eye.translation()).dot(*eye.forward());
        if depth > views.near_depth {
            assert_covered(&views, point, depth);
        }
    }
    let ends = views
        .partitions
        .windows(2)
        .map(|pair| (pair[0].light_view.far_depth, pair[1].light_view.near_depth));
    for (far, near) in ends {
        assert_eq!(far, near, "partitions meet");
    }
}

#[test]
fn light_views_sharpen_the_near_field() {
    let texel = |warp| {
        let mut app = app();
        spawn_town(&mut app);
        let camera = spawn_camera(&mut app);
        let sun = spawn_sun(
            &mut app,
            SunShadows {
                warp,
                ..SunShadows::LOW
            },
        );
        app.update();
        let views = views(&app, sun, camera).expect("the camera sees the town");
        let clip_from_world = views.partitions[0].light_view.clip_from_world.as_dmat4();
        let near = bevy::math::DVec3::new(0.0, 0.0, 7.0);
        let footprint = umbrage::maths::footprint::texel_footprint(&clip_from_world, UVec2::splat(2048), near);
        footprint.expect("in view").lengths().max_element()
    };
    let (uniform, warped) = (texel(Warp::Uniform), texel(Warp::Lispsm));
    assert!(warped < 0.4 * uniform, "{warped} m against {uniform} m");
}

#[test]
fn casters_outside_the_view_are_inside_the_maps() {
    let mut app = app();
    let tower = spawn_town(&mut app);
    // Beside the camera, towards the sun: outside the view, but its shadow falls into it.
    app.world_mut()
        .entity_mut(tower)
        .insert(Transform::from_xyz(-8.0, 10.0, 6.0));
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, SunShadows::HIGH);
    app.update();
    let views = views(&app, sun, camera).expect("the camera sees the town");
    let top = Vec3::new(-6.0, 20.0, 4.0);
    let covered = views.partitions.iter().any(|partition| {
        let ndc = partition.light_view.clip_from_world.project_point3(top);
        ndc.truncate().abs().max_element() < 1.0 && ndc.z > 0.0 && ndc.z < 1.0
    });
    assert!(covered, "the tower's top is drawn");
}

#[test]
fn cameras_can_go_without() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, SunShadows::HIGH);
    app.update();
    assert!(views(&app, sun, camera).is_some());
    app.world_mut().entity_mut(camera).insert(WithoutSunShadows);
    app.update();
    assert!(views(&app, sun, camera).is_none());
}

#[test]
fn two_cameras_get_their_own_light_views() {
    let mut app = app();
    spawn_town(&mut app);
    let first = spawn_camera(&mut app);
    let from_above = Transform::from_xyz(0.0, 60.0, 0.0).looking_at(Vec3::ZERO, Vec3::NEG_Z);
    let second = app
        .world_mut()
        .spawn((Camera3d::default(), Camera { order: 1, ..default() }, from_above))
        .id();
    let sleeping = app
        .world_mut()
        .spawn((
            Camera3d::default(),
            Camera {
                is_active: false,
                ..default()
            },
        ))
        .id();
    for path in [ShadowPath::Full, ShadowPath::DropIn] {
        let sun = spawn_sun(
            &mut app,
            SunShadows {
                path,
                ..SunShadows::HIGH
            },
        );
        app.update();
        let [first, second] = [first, second].map(|camera| views(&app, sun, camera).expect("both see the town"));
        assert_ne!(first.partitions[3].light_view, second.partitions[3].light_view);
        assert!(
            second.near_depth > 30.0,
            "the scene is far below: {}",
            second.near_depth
        );
        let depths = |views: &CameraSunViews| -> Vec<f32> {
            views
                .partitions
                .iter()
                .map(|partition| partition.light_view.far_depth)
                .collect()
        };
        assert_eq!(
            depths(&first) == depths(&second),
            path == ShadowPath::DropIn,
            "{path:?}"
        );
        assert_eq!(views(&app, sun, sleeping), None);
    }
}

#[test]
fn orthographic_cameras_get_uniform_maps() {
    let mut app = app();
    spawn_town(&mut app);
    let projection = OrthographicProjection {
        scaling_mode: ScalingMode::Fixed {
            width: 30.0,
            height: 20.0,
        },
        ..OrthographicProjection::default_3d()
    };
    let transform = Transform::from_xyz(0.0, 40.0, 30.0).looking_at(Vec3::ZERO, Vec3::Y);
    let mut projection = Projection::Orthographic(projection);
    bevy::camera::CameraProjection::update(&mut *projection, 300.0, 200.0);
    let camera = app.world_mut().spawn((Camera3d::default(), projection, transform)).id();
    let sun = spawn_sun(&mut app, SunShadows::HIGH);
    app.update();
    let views = views(&app, sun, camera).expect("the camera sees the town");
    for partition in &views.partitions {
        assert_eq!(partition.light_view.clip_from_world.row(3), Vec4::W, "no warp");
    }
    let eye = *app.world().get::<GlobalTransform>(camera).expect("placed");
    for point in [Vec3::ZERO, Vec3::new(14.0, 0.0, 3.0), Vec3::new(-10.0, 0.0, -6.0)] {
        assert_covered(&views, point, (point - eye.translation()).dot(*eye.forward()));
    }
}

#[test]
fn light_along_the_view() {
    for sign in [1.0, -1.0] {
        let mut app = app();
        spawn_town(&mut app);
        let camera = app
            .world_mut()
            .spawn((
                Camera3d::default(),
                Transform::from_xyz(0.0, 30.0, 30.0).looking_at(Vec3::ZERO, Vec3::Y),
            ))
            .id();
        let sun = spawn_sun(&mut app, SunShadows::HIGH);
        let along = sign * Vec3::new(0.0, -1.0, -1.0);
        app.world_mut()
            .entity_mut(sun)
            .insert(Transform::default().looking_to(along, Vec3::Y));
        app.update();
        let views = views(&app, sun, camera).expect("the camera sees the town");
        let eye = *app.world().get::<GlobalTransform>(camera).expect("placed");
        for point in [Vec3::ZERO, Vec3::new(4.0, 0.0, 3.0)] {
            assert_covered(&views, point, (point - eye.translation()).dot(*eye.forward()));
        }
    }
}

#[test]
fn nothing_to_shadow_gives_no_light_views() {
    let mut app = app();
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, SunShadows::HIGH);
    app.update();
    assert_eq!(views(&app, sun, camera), None, "an empty scene");

    app.world_mut().spawn(block(Vec3::new(0.0, 0.0, 60.0), Vec3::ONE));
    app.update();
    assert_eq!(views(&app, sun, camera), None, "a scene behind the camera");

    app.world_mut().spawn(block(Vec3::new(0.0, 0.0, -10.0), Vec3::ONE));
    app.update();
    assert!(views(&app, sun, camera).is_some(), "something in view");

    app.world_mut()
        .get_mut::<DirectionalLight>(sun)
        .expect("a sun")
        .shadow_maps_enabled = false;
    app.update();
    assert_eq!(views(&app, sun, camera), None, "a sun without shadows");
}

#[test]
fn broken_cameras_get_no_light_views() {
    let mut app = app();
    spawn_town(&mut app);
    let sun = spawn_sun(&mut app, SunShadows::HIGH);
    let nan = app
        .world_mut()
        .spawn((Camera3d::default(), Transform::from_xyz(f32::NAN, 0.0, 0.0)))
        .id();
    let closed = PerspectiveProjection { fov: 0.0, ..default() };
    let closed = app
        .world_mut()
        .spawn((Camera3d::default(), Projection::Perspective(closed)))
        .id();
    let minimized = PerspectiveProjection {
        aspect_ratio: f32::NAN,
        ..default()
    };
    let minimized = app
        .world_mut()
        .spawn((Camera3d::default(), Projection::Perspective(minimized)))
        .id();
    let good = spawn_camera(&mut app);
    app.update();
    for camera in [nan, closed, minimized] {
        assert_eq!(views(&app, sun, camera), None);
    }
    assert!(views(&app, sun, good).is_some(), "the good one is not disturbed");
}

#[test]
fn settings_out_of_range_are_clamped() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let settings = SunShadows {
        partitions: Partitions {
            count: 99,
            scheme: SplitScheme::Practical { lambda: 7.0 },
            ..Partitions::default()
        },
        warp: Warp::Free { eta: f32::NAN },
        distance: Some(-4.0),
        near: Some(f32::NAN),
        map_size: 0,
        ..SunShadows::HIGH
    };
    let sun = spawn_sun(&mut app, settings.clone());
    let drop_in = spawn_sun(
        &mut app,
        SunShadows {
            path: ShadowPath::DropIn,
            ..settings
        },
    );
    app.update();
    assert_eq!(views(&app, sun, camera).expect("views").partitions.len(), 16);
    assert_eq!(views(&app, drop_in, camera).expect("views").partitions.len(), 4);
}

#[test]
fn near_and_distance_limit_the_range() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(
        &mut app,
        SunShadows {
            near: Some(5.0),
            distance: Some(20.0),
            ..SunShadows::HIGH
        },
    );
    app.update();
    let limited = views(&app, sun, camera).expect("views");
    assert!(
        limited.near_depth >= 5.0 && limited.far_depth <= 20.0 + 1.0e-4,
        "{limited:?}"
    );
    app.world_mut().get_mut::<SunShadows>(sun).expect("settings").near = Some(30.0);
    app.update();
    assert_eq!(views(&app, sun, camera), None, "an empty range has no shadows");
}

#[test]
fn light_views_come_and_go_with_the_settings() {
    let mut app = app();
    spawn_town(&mut app);
    spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, SunShadows::HIGH);
    app.update();
    assert!(app.world().get::<SunViews>(sun).is_some());
    app.world_mut().entity_mut(sun).remove::<SunShadows>();
    app.update();
    assert!(app.world().get::<SunViews>(sun).is_none());
    app.world_mut().entity_mut(sun).insert(SunShadows::LOW);
    app.update();
    assert!(
        app.world()
            .get::<SunViews>(sun)
            .is_some_and(|views| views.cameras.len() == 1)
    );
    app.world_mut().entity_mut(sun).despawn();
    app.update();
}

#[test]
fn gizmos_draw_what_is_computed() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    spawn_sun(&mut app, SunShadows::HIGH);
    let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
    let (config, shown) = store.config_mut::<SunShadowGizmos>();
    assert!(!config.enabled, "off by default");
    config.enabled = true;
    shown.camera = Some(camera);
    app.update();
    app.update();
    let drawn = app.world().resource::<Assets<GizmoAsset>>();
    assert!(!drawn.is_empty(), "lines are handed to Bevy");
}
