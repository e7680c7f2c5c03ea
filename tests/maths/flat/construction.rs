//! Films by construction.

use bevy_math::DVec3;
use umbrage::maths::light_plane::flat::{
    Camera, Degenerate, Exposure, Film, Footprints, Light, Metric, Segment, Tilt,
    construction::{miners_badness, parallel_film, single_plane_tilt, view_plane_point},
    optimal_tilt, smallest_largest_tilt,
};

use super::{at, floor, lamp, near, pitched_camera, surface};

/// O8: constant badness, and both metrics find the same film.
#[test]
fn one_plane_gets_constant_badness() {
    let camera = pitched_camera();
    let point = view_plane_point(&camera, &floor());
    let point = point.truncate() / point.z;
    near(point.y, 0.0, 1.0e-12);
    near(point.x, 0.176_327, 1.0e-6);

    let exposure = Exposure::half_angle(lamp(4.0, -3.0), &camera.see(&[floor()])).unwrap();
    near(exposure.film.angle().to_degrees(), -60.388_52, 1.0e-5);
    let largest = |tilt: Tilt| {
        let badness = exposure.samples.iter().map(|sample| sample.tilted(tilt).badness);
        badness.clone().fold(0.0, f64::max) / badness.fold(f64::INFINITY, f64::min)
    };
    let before = exposure.samples.iter().map(|sample| sample.badness);
    near(before.clone().fold(0.0, f64::max), 1091.98, 0.01);
    near(before.fold(f64::INFINITY, f64::min), 90.58, 0.01);

    let tilt = single_plane_tilt(&camera, &floor(), &exposure).unwrap();
    near(largest(tilt), 1.0, 1.0e-12);
    near(exposure.angle_of_tilt(tilt).unwrap().to_degrees(), -38.452_45, 1.0e-5);
    for found in [
        optimal_tilt(&exposure.samples, Metric::L1),
        optimal_tilt(&exposure.samples, Metric::L2),
        smallest_largest_tilt(&exposure.samples),
    ] {
        near(found.unwrap().parameter, tilt.parameter, 1.0e-10);
    }
    // Of 315 pixels per unit of place half of one at each end has no texels.
    near(exposure.samples[0].tilted(tilt).badness, 314.5, 0.51);
    let footprints = Footprints::of(&exposure.samples, tilt, 1000.0).unwrap();
    near(
        footprints.average,
        (exposure.samples.len() - 1) as f64 / 1000.0,
        1.0e-12,
    );
    near(footprints.deviation, 0.0, 1.0e-12);
}

/// O19: the theorem holds for parallel light, where no turn could do it.
#[test]
fn one_plane_gets_constant_badness_in_the_sun() {
    let camera = pitched_camera();
    let sun = Light::Directional { travel: at(-1.0, -0.6) };
    let hits = camera.see(&[floor()]);
    let untrimmed = Exposure::half_angle(sun, &hits).unwrap();
    let spread = |exposure: &Exposure, tilt: Tilt| {
        let badness = exposure.samples.iter().map(|sample| sample.tilted(tilt).badness);
        badness.clone().fold(0.0, f64::max) / badness.fold(f64::INFINITY, f64::min)
    };
    // The factor of the specification, 725, is of central differences without the outermost pixels.
    let inner = Exposure::within(untrimmed.film, untrimmed.hull, &hits[1..hits.len() - 1]).unwrap();
    near(spread(&inner, Tilt::default()) - 1.0, 725.0, 3.0);
    let tilt = single_plane_tilt(&camera, &floor(), &untrimmed).unwrap();
    near(spread(&untrimmed, tilt), 1.0, 1.0e-9);

    // k in the hull without the outermost pixels.
    let trimmed = Exposure::half_angle(sun, &hits[1..hits.len() - 1]).unwrap();
    let tilt = single_plane_tilt(&camera, &floor(), &trimmed).unwrap();
    near(tilt.strength(), 0.928_328_74, 1.0e-8);
    for metric in [Metric::L1, Metric::L2] {
        near(
            optimal_tilt(&trimmed.samples, metric).unwrap().strength(),
            tilt.strength(),
            1.0e-10,
        );
    }
}

/// Corollary 2 at its edges: a plane parallel to the view plane, light in the plane, the plane through the eye.
#[test]
fn degenerate_planes_have_answers() {
    let camera = pitched_camera();
    let frame = camera.frame();
    let middle = frame.origin + frame.forward() * 5.0;
    let facing = Segment::new(middle - frame.film(), middle + frame.film());
    near(view_plane_point(&camera, &facing).z, 0.0, 1.0e-12);
    let light = lamp(3.0, -1.0);
    let exposure = Exposure::half_angle(light, &camera.see(&[facing])).unwrap();
    let tilt = single_plane_tilt(&camera, &facing, &exposure).unwrap();
    near(exposure.angle_of_tilt(tilt).unwrap().to_degrees(), -10.0, 1.0e-9);

    let exposure = Exposure::half_angle(lamp(4.0, -3.0), &camera.see(&[floor()])).unwrap();
    let in_plane = surface([8.0, -3.0], [1.0, -3.0]);
    assert_eq!(
        single_plane_tilt(&camera, &in_plane, &exposure),
        Err(Degenerate::EdgeOn)
    );
    let view_plane = Segment::new(frame.origin, frame.origin + frame.film());
    assert_eq!(view_plane_point(&camera, &view_plane), DVec3::ZERO);
    assert_eq!(
        single_plane_tilt(&camera, &view_plane, &exposure),
        Err(Degenerate::EdgeOn)
    );
    // A film along the hull's middle ray.
    let cutting = Segment::new(frame.origin, at(0.0, -3.0));
    assert!(single_plane_tilt(&camera, &cutting, &exposure).is_ok());
    assert_eq!(exposure.tilt_through(at(0.0, -3.0).extend(1.0)), None);
    assert_eq!(exposure.tilt_through(at(4.0, -3.0).extend(1.0)), None);
    assert_eq!(exposure.tilt_through(DVec3::NAN), None);
}

/// The three surfaces of O12.
fn cards() -> [Segment; 3] {
    [
        surface([0.0, -1.0], [0.0, -30.0]),
        surface([0.2, -6.0], [1.4, -5.0]),
        surface([0.1, -3.0], [1.0, -4.0]),
    ]
}

/// |dp/dτ| on the unit film in the camera's units, smallest and largest, of a surface.
fn range(camera: &Camera, exposure: &Exposure, segment: usize) -> (f64, f64) {
    let unit = 2.0 / (exposure.hull.top - exposure.hull.bottom) * camera.pixel_size();
    let hits = camera.see(&cards());
    let of_segment = hits
        .iter()
        .zip(&exposure.samples)
        .filter(|(hit, _)| hit.segment == segment);
    let badness = of_segment.map(|(_, sample)| sample.badness * unit);
    (
        badness.clone().fold(f64::INFINITY, f64::min),
        badness.fold(0.0, f64::max),
    )
}

/// O12: a lamp on the view plane and a film parallel to it make badness constant on every surface.
#[test]
fn a_miners_lamp_is_constant_on_every_surface() {
    let camera = pitched_camera();
    let frame = camera.frame();
    let position = frame.origin + frame.film() * 2.5;
    let light = Light::Point { position };
    let hits = camera.see(&cards());
    let parallel = Exposure::tight(parallel_film(&camera, light).unwrap(), &hits).unwrap();
    for (index, expected) in [0.288_849, 1.872_968, 0.634_774].into_iter().enumerate() {
        let (low, high) = range(&camera, &parallel, index);
        near(low, expected, 1.0e-6);
        near(high / low, 1.0, 1.0e-12);
        near(
            miners_badness(&camera, light, &cards()[index]).unwrap(),
            expected,
            1.0e-6,
        );
    }
    // Another 5° and the floor is uneven.
    let tilted = Film::new(light, frame.angle + 5.0_f64.to_radians()).unwrap();
    let tilted = Exposure::tight(tilted, &hits).unwrap();
    let floor = hits.iter().zip(&tilted.samples).filter(|(hit, _)| hit.segment == 0);
    let badness = floor.map(|(_, sample)| sample.badness);
    near(badness.clone().fold(0.0, f64::max), 303.23, 0.01);
    near(badness.fold(f64::INFINITY, f64::min), 219.13, 0.01);

    // Light in the eye: the same everywhere.
    let eye = Light::Point {
        position: frame.origin + frame.film() * 1.0e-12,
    };
    let at_eye = Exposure::tight(parallel_film(&camera, eye).unwrap(), &hits).unwrap();
    for index in 0..3 {
        let (low, high) = range(&camera, &at_eye, index);
        near(low, 1.0, 1.0e-9);
        near(high, 1.0, 1.0e-9);
    }
    let facing = Segment::new(
        frame.origin + frame.forward(),
        frame.origin + frame.forward() + frame.film(),
    );
    near(miners_badness(&camera, light, &facing).unwrap(), 1.0, 1.0e-12);
    assert_eq!(miners_badness(&camera, lamp(4.0, -3.0), &facing), None);
    assert_eq!(
        miners_badness(&camera, Light::Directional { travel: at(-1.0, 0.0) }, &facing),
        None
    );
}

/// Section 2.2.2: near the eye the parallel film is close to the best, if not the best, with surfaces of several
/// directions; far from it, it is not.
#[test]
fn the_parallel_film_is_nearly_best_near_the_eye() {
    let camera = pitched_camera();
    let frame = camera.frame();
    let hits = camera.see(&cards());
    let loss = |height: f64| {
        let light = Light::Point {
            position: frame.origin + frame.film() * height,
        };
        let exposure = Exposure::tight(parallel_film(&camera, light).unwrap(), &hits).unwrap();
        let mean = |tilt| Footprints::of(&exposure.samples, tilt, 1000.0).unwrap().average;
        mean(Tilt::default()) / mean(optimal_tilt(&exposure.samples, Metric::L1).unwrap()) - 1.0
    };
    let losses = [0.05, 0.2, 2.5].map(loss);
    assert!(losses[0] > 0.0 && losses[0] < 1.0e-3, "{losses:?}");
    assert!(losses[0] < losses[1] && losses[1] < 0.01, "{losses:?}");
    assert!(losses[2] > 0.03, "{losses:?}");
}
