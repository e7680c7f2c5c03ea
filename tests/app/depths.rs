//! Light views of measured depths and of maps that stand still, without a renderer.

use bevy::{math::DVec3, prelude::*};
use umbrage::{
    maths::{split::VisibleDepths, warp::Warp},
    shadow::{
        measured::{MeasureUse, MeasuredDepths, MeasuredView, NearMeasurement, VisibleDepthRange},
        settings::{MapResolution, SunShadows},
        stable::{HeldMap, HeldMaps, Stability},
        views::CameraSunViews,
    },
};

use crate::support::{app, spawn_camera, spawn_sun, spawn_town, views};

const SPLITS: MeasuredDepths = MeasuredDepths {
    near: NearMeasurement::Off,
    far: false,
    splits: true,
    measure: MeasureUse::Late,
};

/// A measurement from where the camera stands.
fn measure(app: &mut App, camera: Entity, nearest: f64, farthest: f64) {
    let world = app.world_mut();
    let view = MeasuredView {
        world_from_view: *world.get::<GlobalTransform>(camera).expect("a place"),
        clip_from_view: world.get::<Camera>(camera).expect("a camera").clip_from_view(),
        seconds: world.resource::<Time>().elapsed_secs_f64(),
    };
    world.entity_mut(camera).insert(VisibleDepthRange {
        depths: Some(VisibleDepths { nearest, farthest }),
        pixel_count: 1,
        view,
    });
}

fn ends(views: &CameraSunViews) -> Vec<f32> {
    let first = views.partitions[0].light_view.near_depth;
    let ends = views.partitions.iter().map(|partition| partition.light_view.far_depth);
    std::iter::once(first).chain(ends).collect()
}

#[test]
fn splits_lie_where_something_is_seen() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, SunShadows::HIGH);
    app.update();
    let bounds = ends(&views(&app, sun, camera).expect("views"));
    let mut with = |measured| {
        app.world_mut().get_mut::<SunShadows>(sun).expect("settings").measured = measured;
        measure(&mut app, camera, 20.0, 40.0);
        app.update();
        views(&app, sun, camera).expect("views")
    };
    let late = with(SPLITS);
    let depths = ends(&late);
    assert_eq!((depths[0], depths[4]), (bounds[0], bounds[4]), "everything is covered");
    assert!(
        depths[1..4].iter().all(|depth| (20.0..40.0).contains(depth)),
        "{depths:?}"
    );
    assert!(bounds[1] < 5.0, "{bounds:?}");
    let same = with(MeasuredDepths {
        near: NearMeasurement::On,
        far: true,
        measure: MeasureUse::Same,
        ..SPLITS
    });
    let depths = ends(&same);
    assert!(
        (depths[0] - 20.0).abs() < 0.001 && (depths[4] - 40.0).abs() < 0.001,
        "{depths:?}"
    );
    assert_eq!(
        (same.near_depth, same.far_depth),
        (late.near_depth, late.far_depth),
        "transparent surfaces and what is beyond keep the whole range"
    );
    assert_eq!(same.master, late.master);
}

/// Balanced maps share texels by what is seen: the first slice, most of which lies before the nearest surface, gets fewer
/// where that is known.
#[test]
fn measured_planes_count_in_balanced_maps() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let mut settings = SunShadows::HIGH;
    settings.partitions.resolution = MapResolution::Balanced;
    let sun = spawn_sun(&mut app, settings);
    let first_map = |app: &mut App| {
        app.update();
        let views = views(app, sun, camera).expect("views");
        let size = views.partitions[0].light_view.atlas_rect.zw().as_u64vec2();
        size.element_product()
    };
    let unknown = first_map(&mut app);
    measure(&mut app, camera, 6.0, 60.0);
    let known = first_map(&mut app);
    assert!(known * 2 < unknown, "{known} texels for {unknown}");
}

/// The pseudo planes of the warp move its projection centre, never what is covered.
#[test]
fn measured_planes_of_the_warp_cover_the_same() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(&mut app, SunShadows::LOW);
    app.update();
    let whole = views(&app, sun, camera).expect("views");
    app.world_mut().get_mut::<SunShadows>(sun).expect("settings").measured = MeasuredDepths {
        near: NearMeasurement::On,
        far: true,
        ..MeasuredDepths::OFF
    };
    measure(&mut app, camera, 12.0, 30.0);
    app.update();
    let measured = views(&app, sun, camera).expect("views");
    let [a, b] = [&whole, &measured].map(|views| views.partitions[0].light_view.clip_from_world.as_dmat4());
    assert!(!a.abs_diff_eq(b, 1.0e-6), "another warp");
    for corner in measured.partitions[0].body.vertices() {
        let ndc = b.project_point3(*corner);
        assert!(ndc.truncate().abs().max_element() <= 1.0 + 1.0e-5, "{corner} at {ndc}");
    }
    assert_eq!(whole.partitions[0].body, measured.partitions[0].body);
}

fn step(app: &mut App, camera: Entity, distance: f32) {
    let mut transform = app.world_mut().get_mut::<Transform>(camera).expect("a place");
    let ahead = transform.forward() * distance;
    transform.translation += ahead;
    app.update();
}

/// Where a point lies in the first map, in texels.
fn texel(app: &App, sun: Entity, camera: Entity, point: DVec3) -> DVec3 {
    let views = views(app, sun, camera).expect("views");
    let ndc = views.partitions[0]
        .light_view
        .clip_from_world
        .as_dmat4()
        .project_point3(point);
    (ndc * 0.5 + 0.5) * 1024.0
}

#[test]
fn stable_maps_are_held_from_frame_to_frame() {
    for (stable, warp) in [
        (Stability::Sphere, Warp::Uniform),
        (Stability::Quantised, Warp::Uniform),
        (Stability::Held, Warp::Lispsm),
    ] {
        let mut app = app();
        spawn_town(&mut app);
        let camera = spawn_camera(&mut app);
        let sun = spawn_sun(
            &mut app,
            SunShadows {
                stable,
                warp,
                map_size: 1024,
                ..SunShadows::MEDIUM
            },
        );
        app.update();
        let points = [DVec3::new(0.0, 0.0, 6.0), DVec3::new(0.3, 0.0, 5.0)];
        let mut held = 0;
        for _ in 0..10 {
            let before = points.map(|point| texel(&app, sun, camera, point).truncate());
            step(&mut app, camera, 0.013);
            let after = points.map(|point| texel(&app, sun, camera, point).truncate());
            let shifts = [0, 1].map(|index| after[index] - before[index]);
            // Single precision: texels far from the origin of a map are rounded to a few thousandths.
            let is_whole = shifts[0].distance(shifts[0].round()) < 0.02 && shifts[0].distance(shifts[1]) < 0.02;
            held += i32::from(is_whole);
        }
        assert!(held >= 8, "{stable:?}: only {held} of 10 steps are whole texels");
        let maps = &app.world().get::<HeldMaps>(sun).expect("held maps").cameras[&camera];
        let kinds: Vec<bool> = maps.iter().map(Option::is_some).collect();
        assert_eq!(kinds, [stable != Stability::Sphere; 2], "{stable:?}");
        assert!(
            matches!(
                (stable, maps[0]),
                (Stability::Held, Some(HeldMap::Grid(_)))
                    | (Stability::Quantised, Some(HeldMap::Levels(_)))
                    | (Stability::Sphere, None)
            ),
            "{stable:?}: {maps:?}"
        );
        // Nothing is held for cameras that are gone, nor for suns that are fitted anew.
        app.world_mut().despawn(camera);
        app.update();
        assert!(
            app.world()
                .get::<HeldMaps>(sun)
                .is_some_and(|held| held.cameras.is_empty())
        );
    }
}

/// A map that is fitted anew moves by parts of a texel: what the test above would find without stability.
#[test]
fn fresh_fits_do_not_move_by_whole_texels() {
    let mut app = app();
    spawn_town(&mut app);
    let camera = spawn_camera(&mut app);
    let sun = spawn_sun(
        &mut app,
        SunShadows {
            map_size: 1024,
            ..SunShadows::MEDIUM
        },
    );
    app.update();
    let point = DVec3::new(0.0, 0.0, 6.0);
    let mut whole = 0;
    for _ in 0..10 {
        let before = texel(&app, sun, camera, point).truncate();
        step(&mut app, camera, 0.013);
        let shift = texel(&app, sun, camera, point).truncate() - before;
        whole += i32::from(shift.distance(shift.round()) < 0.02);
    }
    assert!(whole <= 3, "{whole} of 10 steps are whole texels");
}
