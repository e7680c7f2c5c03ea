//! Depths measured on the GPU: against the CPU twin, and what light views make of them.

use bevy::{camera::RenderTarget, core_pipeline::prepass::DepthPrepass, prelude::*};
use umbrage::{
    maths::near_plane::DepthChain,
    prelude::*,
    render::{
        capture,
        mask::{MaskPlugin, ShadowMask},
    },
    shadow::{
        measured::{MeasureUse, MeasuredDepths, NearMeasurement, VisibleDepthRange},
        views::SunViews,
    },
};

use crate::{
    harness::{Harness, add_target, eye},
    truth::{LIGHTS, boxes, harness_with},
};

const ALL: MeasuredDepths = MeasuredDepths {
    near: NearMeasurement::On,
    far: true,
    splits: true,
    measure: MeasureUse::Late,
};

fn measured(harness: &Harness, camera: Entity) -> Option<&VisibleDepthRange> {
    harness.app.world().get::<VisibleDepthRange>(camera)
}

/// Sides that are no multiples of anything, pictures smaller than a workgroup, and one of sky only.
#[test]
fn the_gpu_finds_the_ends_of_pictures_of_any_size() {
    let mut harness = harness_with(&boxes());
    let sun = harness.sun(
        LIGHTS[0],
        SunShadows {
            measured: ALL,
            map_size: 128,
            ..SunShadows::HIGH
        },
    );
    harness.app.add_plugins(MaskPlugin);
    let sky = Transform::from_xyz(0.0, 3.0, 14.0).looking_at(Vec3::new(0.0, 50.0, 1.0), Vec3::Z);
    let cameras: Vec<_> = [
        (UVec2::new(161, 91), eye()),
        (UVec2::new(1, 1), eye()),
        (UVec2::new(33, 67), eye().looking_at(Vec3::new(-5.0, 1.0, 8.0), Vec3::Y)),
        (UVec2::new(31, 2), eye()),
        (UVec2::new(65, 31), sky),
    ]
    .into_iter()
    .enumerate()
    .map(|(index, (size, eye))| {
        let target = add_target(&mut harness.app, size);
        let [mask, depth, normal] = [
            ShadowMask::MASK_FORMAT,
            ShadowMask::DEPTH_FORMAT,
            ShadowMask::NORMAL_FORMAT,
        ]
        .map(|format| {
            let image = capture::readable_target(size.x, size.y, format);
            harness.app.world_mut().resource_mut::<Assets<Image>>().add(image)
        });
        let camera = harness.app.world_mut().spawn((
            Camera3d::default(),
            Camera {
                order: 1 + index as isize,
                ..default()
            },
            RenderTarget::Image(target.into()),
            Msaa::Off,
            DepthPrepass,
            Projection::Perspective(PerspectiveProjection {
                near: 0.2,
                far: 120.0,
                ..default()
            }),
            eye,
            ShadowMask {
                light: sun,
                mask,
                depth: depth.clone(),
                normal,
            },
        ));
        (camera.id(), size, depth)
    })
    .collect();
    harness.start();
    for (camera, size, depth) in cameras {
        let depths = capture::read_image(&harness.app, &depth)
            .expect("the depths can be read")
            .to_f32();
        let twin = DepthChain::new(size, &depths).expect("a picture");
        let measured = measured(&harness, camera).expect("a measurement");
        let pixels = depths.iter().filter(|depth| **depth > 0.0).count();
        assert_eq!(measured.pixel_count as usize, pixels, "{size}");
        let Some((nearest, farthest)) = twin.range() else {
            assert_eq!((measured.depths, size.x), (None, 65), "only the sky is empty");
            continue;
        };
        let found = measured.depths.expect("something is seen");
        // The mask's shader turns depths into metres in single precision.
        for (found, expected) in [(found.nearest, nearest), (found.farthest, farthest)] {
            let error = (found / f64::from(expected) - 1.0).abs();
            assert!(error < 1.0e-5, "{size}: {found}, not {expected}");
        }
    }
}

/// Nobody asks: nothing is measured, and what was known is forgotten.
#[test]
fn measurements_come_and_go_with_the_settings() {
    let mut harness = harness_with(&boxes());
    // One map: nothing is measured by itself.
    let sun = harness.sun(LIGHTS[0], SunShadows::LOW);
    harness.start();
    assert_eq!(measured(&harness, harness.camera), None);
    let set = |harness: &mut Harness, measured| {
        let mut settings = harness.app.world_mut().get_mut::<SunShadows>(sun).expect("settings");
        settings.measured = measured;
    };
    set(&mut harness, ALL);
    harness.frames(3);
    assert!(measured(&harness, harness.camera).is_some_and(|range| range.depths.is_some()));
    set(&mut harness, MeasuredDepths::OFF);
    harness.frames(2);
    assert_eq!(measured(&harness, harness.camera), None);
}

/// A board that casts its shadow onto another one that comes into the picture right before the camera, from one frame to
/// the next: nobody has measured it, and its shadow is there all the same, in its first frame. Once the camera stands
/// where it was measured, the near plane has moved in front of it.
#[test]
fn no_shadow_is_lost_where_a_surface_enters_near_the_camera() {
    for (measure, cuts) in [(MeasureUse::Late, false), (MeasureUse::Same, true)] {
        let mut harness = harness_with(&boxes());
        let sun = harness.sun(
            Vec3::NEG_Y,
            SunShadows {
                measured: MeasuredDepths { measure, ..ALL },
                map_size: 512,
                ..SunShadows::HIGH
            },
        );
        let material = harness.material(Color::WHITE);
        let board = harness.mesh(Cuboid::new(0.2, 0.02, 0.2));
        // 0.8 m before the camera, where the picture ends 0.59 m to its right: beside it, until the camera turns by 9 degrees.
        let place = eye() * Transform::from_xyz(0.76, -0.25, -0.8);
        for up in [0.0, 1.0] {
            harness.app.world_mut().spawn((
                Mesh3d(board.clone()),
                MeshMaterial3d(material.clone()),
                Transform::from_translation(place.translation + Vec3::Y * up),
            ));
        }
        harness.start();
        let near_of = |harness: &Harness| {
            let views = harness.app.world().get::<SunViews>(sun).expect("views");
            views.cameras[&harness.camera].partitions[0].light_view.near_depth
        };
        let before = measured(&harness, harness.camera)
            .and_then(|range| range.depths)
            .expect("a measurement");
        assert!(before.nearest > 5.0, "the boards are not in the picture: {before:?}");
        assert_eq!(near_of(&harness) > 5.0, cuts, "{measure:?}: {}", near_of(&harness));
        let mut camera = harness
            .app
            .world_mut()
            .get_mut::<Transform>(harness.camera)
            .expect("a camera");
        camera.rotate_y(-0.16);
        harness.frames(1);
        assert!(
            near_of(&harness) < 0.7,
            "{measure:?}: the board is behind the near plane {}",
            near_of(&harness)
        );
        let in_shadow = shadow_on_the_board(&harness, place.translation);
        assert!(in_shadow > 0.95, "{measure:?}: {in_shadow} of the board is in shadow");
        // Two frames later it has been measured.
        harness.frames(2);
        let after = measured(&harness, harness.camera)
            .and_then(|range| range.depths)
            .expect("a measurement");
        assert!(after.nearest < 1.2, "{after:?}");
        assert!(
            shadow_on_the_board(&harness, place.translation) > 0.95,
            "{measure:?}, measured"
        );
    }
}

/// Share of the lower board's visible top that is in shadow.
fn shadow_on_the_board(harness: &Harness, center: Vec3) -> f64 {
    let world = harness.app.world();
    let (camera, transform) = (
        world.get::<Camera>(harness.camera).expect("a camera"),
        world.get::<GlobalTransform>(harness.camera).expect("a place"),
    );
    let result = harness.shadow_result(harness.camera);
    let size = crate::truth::SIZE;
    let values: Vec<f32> = (0..900)
        .filter_map(|index| {
            let offset = Vec2::new((index % 30) as f32, (index / 30) as f32) / 30.0 - 0.483;
            let point = center + Vec3::new(offset.x * 0.18, 0.0101, offset.y * 0.18);
            let place = camera.world_to_viewport(transform, point).ok()?;
            let is_inside = place.cmpge(Vec2::splat(1.0)).all() && place.cmplt(size.as_vec2() - 1.0).all();
            is_inside.then(|| result[place.y as usize * size.x as usize + place.x as usize])
        })
        .collect();
    assert!(
        values.len() > 100,
        "only {} points of the board are in the picture",
        values.len()
    );
    values.iter().filter(|value| **value < 0.5).count() as f64 / values.len() as f64
}

/// A cut to another place: the ranges of the old place mean nothing, and the bounds take over for the frames of the delay.
#[test]
fn a_cut_falls_back_to_bounds() {
    let mut harness = harness_with(&boxes());
    let settings = |measured| SunShadows {
        measured,
        map_size: 256,
        ..SunShadows::HIGH
    };
    let sun = harness.sun(LIGHTS[0], settings(ALL));
    harness.start();
    let views_of = |harness: &Harness| {
        let views = harness.app.world().get::<SunViews>(sun).expect("views");
        views.cameras[&harness.camera].clone()
    };
    let tracked = views_of(&harness);
    let move_camera = |harness: &mut Harness| {
        let mut camera = harness
            .app
            .world_mut()
            .get_mut::<Transform>(harness.camera)
            .expect("a camera");
        *camera = Transform::from_xyz(40.0, 1.0, -40.0).looking_at(Vec3::new(0.0, 1.0, -40.0), Vec3::Y);
    };
    move_camera(&mut harness);
    harness.frames(1);
    let after_the_cut = views_of(&harness);
    harness.frames(3);
    let tracked_again = views_of(&harness);
    harness
        .app
        .world_mut()
        .entity_mut(sun)
        .insert(settings(MeasuredDepths::OFF));
    harness.frames(1);
    let bounds = views_of(&harness);
    assert_eq!(after_the_cut, bounds, "the frame after the cut");
    assert_ne!(tracked_again, bounds, "measured depths make a difference here");
    assert_ne!(tracked, after_the_cut);
}
