//! Uniform maps whose texels stand still.

use std::collections::BTreeSet;

use bevy_math::{DMat4, DQuat, DVec2, DVec3, EulerRot};
use umbrage::maths::{
    body::light_visible,
    bounds::Bounds,
    stable::{
        fixed_axes, held_light,
        levels::{LEVEL_COUNT, ScaleLevels, Spacing},
        sphere::{SnappedMap, bounding_sphere},
    },
    view::ViewVolume,
};

use crate::support::close;

pub(crate) const LIGHT: DVec3 = DVec3::new(0.4, -1.0, 0.3);

pub(crate) const MAP_SIZE: u32 = 1024;

pub(crate) fn camera(eye: DVec3, forward: DVec3, near: f64, far: f64) -> ViewVolume {
    ViewVolume::perspective(eye, forward, DVec3::Y, 1.0, 16.0 / 9.0, near, far).expect("a proper camera")
}

/// A wide ground with houses and trees up to 15 m.
pub(crate) fn land() -> Bounds {
    Bounds::new(DVec3::new(-400.0, 0.0, -400.0), DVec3::new(400.0, 15.0, 400.0))
}

/// A walk at 1.4 m/s: 4 s straight on, a turn by 90° within 2 s, 4 s straight on, 5 s looking around by 30° to each
/// side; the head nods by 2 cm twice a second.
pub(crate) fn walk(seconds: f64) -> (DVec3, DVec3) {
    let course = |time: f64| 45.0 * (time - 4.0).clamp(0.0, 2.0);
    let mut place = DVec3::ZERO;
    let steps = (seconds * 120.0) as i32;
    for step in 0..steps {
        place += direction(course(f64::from(step) / 120.0)) * (1.4 / 120.0);
    }
    let tau = std::f64::consts::TAU;
    let glance = if seconds > 10.0 {
        30.0 * (tau * (seconds - 10.0) / 4.0).sin()
    } else {
        0.0
    };
    let height = 1.7 + 0.02 * (tau * 2.0 * seconds).sin();
    (place + DVec3::Y * height, direction(course(seconds) + glance))
}

pub(crate) fn direction(degrees: f64) -> DVec3 {
    let angle = degrees.to_radians();
    DVec3::new(angle.sin(), -0.05, -angle.cos())
}

pub(crate) fn texel(clip_from_world: &DMat4, point: DVec3, map_size: u32) -> DVec2 {
    let ndc = clip_from_world.project_point3(point);
    (ndc.truncate() * 0.5 + 0.5) * f64::from(map_size)
}

/// How far two maps are from being shifted by whole texels: largest distance to whole numbers over some points.
pub(crate) fn misfit(a: &DMat4, b: &DMat4, points: &[DVec3], map_size: u32) -> f64 {
    points
        .iter()
        .map(|point| {
            let shift = texel(a, *point, map_size) - texel(b, *point, map_size);
            (shift - shift.round()).abs().max_element()
        })
        .fold(0.0, f64::max)
}

/// Points on the ground and above it, around a place.
pub(crate) fn around(place: DVec3) -> Vec<DVec3> {
    (0..40)
        .map(|index| {
            let angle = f64::from(index) * 2.4;
            place + DVec3::new(angle.cos(), 0.02 * f64::from(index % 5), angle.sin()) * (0.3 * f64::from(index))
        })
        .collect()
}

/// The sphere around a slice: tight, and the same wherever the camera is and looks.
#[test]
fn spheres_do_not_change_with_the_camera() {
    let reference = bounding_sphere(&camera(DVec3::ZERO, DVec3::NEG_Z, 1.0, 30.0)).expect("a far plane");
    for step in 0..200 {
        let step = f64::from(step);
        let turn = DQuat::from_euler(EulerRot::YXZ, step * 0.37, step.sin(), 0.0);
        let eye = DVec3::new(step * 3.7, 1.0, -step * step);
        let slice = camera(eye, turn * DVec3::NEG_Z, 1.0, 30.0);
        let sphere = bounding_sphere(&slice).expect("a far plane");
        assert_eq!(sphere.radius, reference.radius, "step {step}");
        for corner in slice.corners(1.0, 30.0) {
            assert!(
                corner.distance(sphere.center) <= sphere.radius * (1.0 + 1.0e-8),
                "{corner} sticks out"
            );
        }
    }
    // No smaller one: the far corners alone need it (the slice is wider than long).
    let corners = camera(DVec3::ZERO, DVec3::NEG_Z, 1.0, 30.0).corners(1.0, 30.0);
    let needed = corners[4].distance(corners[6]) * 0.5;
    assert!(reference.radius < needed * 1.002, "{} for {needed}", reference.radius);
    // A slice longer than wide touches near and far corners.
    let long = ViewVolume::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 0.3, 1.0, 1.0, 30.0).expect("a camera");
    let sphere = bounding_sphere(&long).expect("a far plane");
    let corners = long.corners(1.0, 30.0);
    let (near, far) = (corners[0].distance(sphere.center), corners[4].distance(sphere.center));
    close(near, far, 1.0e-9);
    assert!(sphere.radius >= near && sphere.radius < near * 1.002);
    assert_eq!(
        bounding_sphere(&camera(DVec3::ZERO, DVec3::NEG_Z, 1.0, f64::INFINITY)),
        None
    );
    assert_eq!(fixed_axes(DVec3::ZERO), None);
}

/// Stingl, section 3.5, exact solution; Lloyd, section 7: walking and turning shift the map by whole texels, nothing
/// else.
#[test]
fn sphere_maps_move_by_whole_texels() {
    let axes = fixed_axes(LIGHT).expect("a light");
    for map_size in [1024, 777] {
        let map = |seconds: f64| {
            let (eye, forward) = walk(seconds);
            let slice = camera(eye, forward, 1.0, 30.0);
            let sphere = bounding_sphere(&slice).expect("a far plane");
            let map = SnappedMap::around(&sphere, &axes, map_size);
            (map.clip_from_world(&axes, -200.0, 200.0), slice)
        };
        let (first, _) = map(0.0);
        let points = around(DVec3::new(1.0, 0.0, -5.0));
        let mut moved = 0;
        for step in 1..75 {
            let (now, slice) = map(f64::from(step) * 0.2);
            assert!(misfit(&first, &now, &points, map_size) < 1.0e-6, "step {step}");
            let shift = texel(&first, points[0], map_size) - texel(&now, points[0], map_size);
            moved += i32::from(shift.length() > 0.5);
            for corner in slice.corners(1.0, 30.0) {
                let ndc = now.project_point3(corner);
                assert!(ndc.truncate().abs().max_element() <= 1.0 + 1.0e-8, "{ndc} outside");
                assert!(ndc.z > 0.0 && ndc.z < 1.0);
            }
            let towards_light = now.project_point3(points[3] - LIGHT * 2.0);
            let here = now.project_point3(points[3]);
            assert!(
                (towards_light - here).truncate().length() < 1.0e-9 && towards_light.z > here.z,
                "reverse z"
            );
        }
        assert!(moved > 70, "the map follows the camera");
    }
}

/// A sun that moves steadily is drawn in steps, never farther away than the tolerance.
#[test]
fn the_light_is_held() {
    let sun = |step: i32| {
        let angle = 1.0 + f64::from(step) * 0.0005;
        DVec3::new(angle.cos(), -angle.sin(), 0.2)
    };
    let (mut held, mut changes) = (None, 0);
    for step in 0..1000 {
        let next = held_light(held, sun(step), 0.0046);
        assert!(next.angle_between(sun(step)) <= 0.0046, "step {step}");
        changes += i32::from(held.is_some_and(|held| held != next));
        held = Some(next);
    }
    assert!((95..=112).contains(&changes), "{changes} changes within half a radian");
    assert_eq!(held_light(Some(DVec3::ZERO), LIGHT, 0.01), LIGHT);
    assert_eq!(held_light(Some(DVec3::NAN), LIGHT, 0.01), LIGHT);
    assert_eq!(
        held_light(Some(LIGHT * 2.0), LIGHT, 0.01),
        LIGHT * 2.0,
        "the same direction"
    );
}

/// The sizes of maps come from 64 values (Stingl, oracle 24).
#[test]
fn there_are_64_levels() {
    for spacing in [Spacing::Equal, Spacing::Geometric { smallest: 2.0 }] {
        let levels = ScaleLevels {
            reference: 200.0,
            spacing,
        };
        close(levels.half_extent(LEVEL_COUNT), 200.0, 1.0e-12);
        let lowest = match spacing {
            Spacing::Equal => 3.125,
            Spacing::Geometric { smallest } => smallest,
        };
        close(levels.half_extent(1), lowest, 1.0e-12);
        let mut seen = BTreeSet::new();
        let mut worst: f64 = 1.0;
        for step in 1..=20_000 {
            let half = f64::from(step) * 0.01;
            let level = levels.level(half).expect("below the reference");
            let shown = levels.half_extent(level);
            assert!(shown >= half * (1.0 - 1.0e-9), "{half} in {shown}");
            assert!(
                level == 1 || levels.half_extent(level - 1) < half,
                "{half}: a lower level would do"
            );
            seen.insert(level);
            if half >= 3.125 {
                worst = worst.max(shown / half);
            }
        }
        assert_eq!(seen.len(), 64, "{spacing:?}");
        let bound = match spacing {
            Spacing::Equal => 1.0 + 200.0 / (64.0 * 3.125),
            Spacing::Geometric { .. } => 100.0_f64.powf(1.0 / 63.0),
        };
        assert!(
            worst <= bound + 1.0e-9 && worst > 0.9 * bound,
            "{worst} of {bound} for {spacing:?}"
        );
        assert_eq!([levels.level(200.1), levels.level(f64::NAN)], [None, None]);
    }
    close(100.0_f64.powf(1.0 / 63.0), 1.076, 1.0e-3);
}

#[test]
fn levels_are_held_against_jitter() {
    let levels = ScaleLevels {
        reference: 64.0,
        spacing: Spacing::Equal,
    };
    let (mut level, mut changes) = (None, 0);
    for step in 0..100 {
        let half = 10.0 + if step % 2 == 0 { 0.001 } else { -0.001 };
        let next = levels.held(level, half);
        changes += i32::from(level.is_some() && next != level);
        level = next;
    }
    assert_eq!((changes, level), (0, Some(11)), "a jitter about a border");
    assert_eq!(levels.held(Some(11), 9.5), Some(11), "one step is not enough");
    assert_eq!(levels.held(Some(12), 9.5), Some(10), "two steps are");
    assert_eq!(levels.held(Some(9), 9.5), Some(10), "never too small");
    assert_eq!(levels.held(Some(9), 65.0), None);
}

/// Stingl, oracle 24: with the level unchanged the texel grid stays; sizes come from at most 64 values per axis; all
/// that is focused on is inside.
#[test]
fn quantised_focus_moves_by_whole_texels_within_a_level() {
    let axes = fixed_axes(LIGHT).expect("a light");
    let levels = ScaleLevels {
        reference: 700.0,
        spacing: Spacing::Geometric { smallest: 7.0 },
    };
    let mut previous: Option<(SnappedMap, [u32; 2])> = None;
    let (mut kept, mut frames) = (0, 0);
    let points = around(DVec3::new(2.0, 0.0, -6.0));
    for frame in 0..900 {
        let (eye, forward) = walk(f64::from(frame) / 60.0);
        let visible = light_visible(&camera(eye, forward, 1.0, 40.0), &land());
        let flat = visible
            .vertices()
            .iter()
            .map(|vertex| DVec3::new(axes.x.dot(*vertex), axes.y.dot(*vertex), 0.0));
        let focus = Bounds::from_points(flat);
        let (map, chosen) = levels
            .stabilised(
                previous.map(|(_, levels)| levels),
                focus.min.truncate(),
                focus.max.truncate(),
                MAP_SIZE,
            )
            .expect("inside the reference");
        let matrix = map.clip_from_world(&axes, -200.0, 200.0);
        for vertex in visible.vertices() {
            let ndc = matrix.project_point3(*vertex);
            assert!(
                ndc.truncate().abs().max_element() <= 1.0 + 1.0e-9,
                "frame {frame}: {ndc}"
            );
        }
        if let Some((last, last_levels)) = previous {
            frames += 1;
            let misfit = misfit(&last.clip_from_world(&axes, -200.0, 200.0), &matrix, &points, MAP_SIZE);
            if last_levels == chosen {
                kept += 1;
                assert!(misfit < 1.0e-6, "frame {frame}: {misfit}");
            } else {
                assert!(misfit > 1.0e-3, "frame {frame}: another size is another grid");
            }
        }
        previous = Some((map, chosen));
    }
    let share = f64::from(kept) / f64::from(frames);
    assert!(share > 0.8 && share < 1.0, "unchanged in {share} of frames");
}
