//! A small app with Bevy's transforms, visibility, cameras and lights, and Umbrage's shadow room.

use bevy::{
    camera::{CameraPlugin, primitives::Aabb},
    gizmos::GizmoPlugin,
    image::ImagePlugin,
    light::{CascadeShadowConfig, Cascades, LightPlugin},
    math::DVec3,
    mesh::MeshPlugin,
    prelude::*,
};
use umbrage::{
    maths::bounds::Bounds,
    shadow::{
        ShadowPlugin,
        scene_bounds::SceneBounds,
        settings::SunShadows,
        views::{CameraSunViews, SunViews},
    },
};

/// An app whose every [`App::update`] is a frame.
pub(crate) fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        TransformPlugin,
        AssetPlugin::default(),
        MeshPlugin,
        ImagePlugin::default(),
        CameraPlugin,
        GizmoPlugin,
        LightPlugin,
        ShadowPlugin,
    ));
    app
}

/// A mesh that is a box of the given half size around its place.
pub(crate) fn block(place: Vec3, half_size: Vec3) -> impl Bundle {
    (
        Mesh3d::default(),
        Aabb {
            center: Vec3::ZERO.into(),
            half_extents: half_size.into(),
        },
        Transform::from_translation(place),
    )
}

/// A flat piece of ground of 100 m × 100 m, and a tower on it.
pub(crate) fn spawn_town(app: &mut App) -> Entity {
    app.world_mut().spawn(block(Vec3::ZERO, Vec3::new(50.0, 0.0, 50.0)));
    app.world_mut()
        .spawn(block(Vec3::new(5.0, 10.0, -20.0), Vec3::new(2.0, 10.0, 2.0)))
        .id()
}

/// A camera at eye height that looks along −z.
pub(crate) fn spawn_camera(app: &mut App) -> Entity {
    let transform = Transform::from_xyz(0.0, 1.7, 10.0).looking_at(Vec3::new(0.0, 1.0, -20.0), Vec3::Y);
    app.world_mut().spawn((Camera3d::default(), transform)).id()
}

/// A sun with the given settings, shining at a slant from behind the camera.
pub(crate) fn spawn_sun(app: &mut App, settings: SunShadows) -> Entity {
    let light = DirectionalLight {
        shadow_maps_enabled: true,
        ..default()
    };
    let transform = Transform::default().looking_to(Vec3::new(0.4, -1.0, -0.3), Vec3::Y);
    app.world_mut().spawn((light, settings, transform)).id()
}

pub(crate) fn scene_bounds(app: &App) -> SceneBounds {
    *app.world().resource::<SceneBounds>()
}

pub(crate) fn views(app: &App, sun: Entity, camera: Entity) -> Option<CameraSunViews> {
    app.world().get::<SunViews>(sun)?.cameras.get(&camera).cloned()
}

pub(crate) fn cascades(app: &App, sun: Entity) -> (Cascades, CascadeShadowConfig) {
    let sun = app.world().entity(sun);
    let cascades = sun.get::<Cascades>().expect("a light has cascades");
    let config = sun.get::<CascadeShadowConfig>().expect("a light has a configuration");
    (cascades.clone(), config.clone())
}

#[track_caller]
pub(crate) fn assert_bounds(bounds: Option<Bounds>, min: Vec3, max: Vec3) {
    let bounds = bounds.expect("something is there");
    let near = |a: DVec3, b: Vec3| a.distance(b.as_dvec3()) < 1.0e-4;
    assert!(
        near(bounds.min, min) && near(bounds.max, max),
        "{bounds:?} is not {min} to {max}"
    );
}
