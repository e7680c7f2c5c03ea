//! The family of films: re-mapping under rotation.

use std::f64::consts::FRAC_PI_2;

use bevy_math::DVec3;
use proptest::prelude::*;
use umbrage::maths::light_plane::flat::{
    Degenerate, Exposure, Extents, Film, Frame, Hull, Light, Tilt, printed_angle, projection,
};

use super::{at, floor, lamp, near, pitched_camera};

fn hull(bottom_degrees: f64, top_degrees: f64) -> Hull {
    Hull {
        bottom: bottom_degrees.to_radians().tan(),
        top: top_degrees.to_radians().tan(),
    }
}

/// O1: near to +1, far to −1, top to 1, bottom to −1; with the printed sign −1.0816 and −3.0816.
#[test]
fn projections_take_their_corners_to_the_cube() {
    let (bottom, top, near_depth, far) = (-0.3, 0.7, 1.0, 50.0);
    let cube = projection(Extents { bottom, top }, near_depth, far);
    for ((y, z), (across, depth)) in [
        ((0.7, -1.0), (1.0, 1.0)),
        ((-0.3, -1.0), (-1.0, 1.0)),
        ((35.0, -50.0), (1.0, -1.0)),
        ((-15.0, -50.0), (-1.0, -1.0)),
    ] {
        let point = cube * at(y, z).extend(1.0);
        near(point.z, -z, 1.0e-12);
        near(point.y / point.z, across, 1.0e-12);
        near(point.x / point.z, depth, 1.0e-12);
    }
    let mut printed = cube;
    printed.z_axis.x = -cube.z_axis.x;
    let depth = |z: f64| (printed * at(0.0, z).extend(1.0)).x / -z;
    near(depth(-1.0), -3.0816, 1.0e-4);
    near(depth(-50.0), -1.0816, 1.0e-4);
}

/// O2.
#[test]
fn turning_has_the_published_values() {
    let hull = hull(-20.0, 30.0);
    let tilt = hull.tilt_of_turn(15.0_f64.to_radians()).unwrap();
    near(tilt.strength(), 0.122_607_98, 1.0e-8);
    near(tilt.parameter, 0.123_227_96, 1.0e-8);
    for (place, stretch, turned) in [
        (-1.0, 0.781_566, -1.0),
        (-0.5, 0.894_598, -0.402_039),
        (0.0, 1.015_262, 0.122_608),
        (0.5, 1.143_557, 0.586_644),
        (1.0, 1.279_483, 1.0),
    ] {
        near(tilt.stretch(place), stretch, 1.0e-6);
        near(tilt.place(place), turned, 1.0e-6);
    }
    near(tilt.stretch(1.0) * tilt.stretch(-1.0), 1.0, 1.0e-12);
    // O3: and back.
    near(hull.turn_of_tilt(tilt), 15.0_f64.to_radians(), 1.0e-12);
}

/// The thesis's derivative of turned places (section 3.1) and its chain of matrices, against the tilt.
fn printed_stretch(hull: &Hull, place: f64, turn: f64) -> f64 {
    let (top, bottom) = (hull.top.atan(), hull.bottom.atan());
    let inner = 2.0 * turn.cos() + turn.sin() * (hull.top + place * hull.top + hull.bottom - place * hull.bottom);
    top.cos() * bottom.cos() / (top - turn).cos() / (bottom - turn).cos() * inner * inner / 4.0
}

proptest! {
    /// Section 3.1 and O3: explicit re-mapping, its derivative, the group law, and back.
    #[test]
    fn tilts_are_turns(
        bottom in -80.0..70.0_f64, width in 1.0..140.0_f64, share in 0.02..0.98_f64, next in 0.02..0.98_f64,
        place in -1.0..1.0_f64,
    ) {
        let hull = hull(bottom, (bottom + width).min(80.0));
        let (low, high) = hull.valid_turns();
        let turn = low + (high - low) * share;
        let tilt = hull.tilt_of_turn(turn).expect("a valid turn");
        let k = (hull.top - hull.bottom) * turn.sin() / (2.0 * turn.cos() + (hull.top + hull.bottom) * turn.sin());
        prop_assert!((tilt.strength() - k).abs() < 1.0e-9);
        prop_assert!((hull.turn_of_tilt(tilt) - turn).abs() < 1.0e-9);
        let stretch = printed_stretch(&hull, place, turn);
        prop_assert!((tilt.stretch(place) / stretch - 1.0).abs() < 1.0e-8);
        let mobius = (1.0 + k * place).powi(2) / (1.0 - k * k);
        prop_assert!((tilt.stretch(place) / mobius - 1.0).abs() < 1.0e-7);

        // Through angles.
        let turned = hull.turned(turn).expect("a valid turn");
        let by_angle = turned.place((hull.coordinate(place).atan() - turn).tan());
        prop_assert!((tilt.place(place) - by_angle).abs() < 1.0e-8);

        // Another turn of the turned film.
        let (low, high) = turned.valid_turns();
        let second = low + (high - low) * next;
        let both = tilt.then(turned.tilt_of_turn(second).expect("a valid turn"));
        let at_once = hull.tilt_of_turn(turn + second).expect("a valid turn");
        prop_assert!((both.parameter - at_once.parameter).abs() < 1.0e-8);
        prop_assert!((both.then(at_once.inverse()).parameter).abs() < 1.0e-8);
    }

    /// Places rise, stretches are positive and their ends multiply to 1, also for tilts beyond every digit of k.
    #[test]
    fn tilts_keep_ends_and_order(parameter in -300.0..300.0_f64, place in -0.999..0.999_f64) {
        let tilt = Tilt::new(parameter);
        prop_assert!((tilt.place(1.0) - 1.0).abs() < 1.0e-12 && (tilt.place(-1.0) + 1.0).abs() < 1.0e-12);
        prop_assert!((tilt.stretch(1.0) * tilt.stretch(-1.0) - 1.0).abs() < 1.0e-12);
        prop_assert!(tilt.stretch(place) > 0.0);
        prop_assert!(tilt.place(place) <= tilt.place(place + 1.0e-4));
    }
}

/// Chong A.2 and section 3.1: valid as long as the whole hull is before the film.
#[test]
fn invalid_turns_have_no_tilt() {
    let hull = hull(-20.0, 30.0);
    let (low, high) = hull.valid_turns();
    near(low.to_degrees(), -60.0, 1.0e-9);
    near(high.to_degrees(), 70.0, 1.0e-9);
    for turn in [low - 1.0e-6, high + 1.0e-6, FRAC_PI_2, -FRAC_PI_2, 3.0, f64::NAN] {
        assert_eq!(hull.tilt_of_turn(turn), None, "{turn}");
        assert_eq!(hull.turned(turn), None, "{turn}");
    }
    for turn in [low + 1.0e-6, high - 1.0e-6, 0.0] {
        assert!(hull.tilt_of_turn(turn).is_some(), "{turn}");
    }
    assert_eq!([1.0, -1.0, 2.0, f64::NAN].map(Tilt::of_strength), [None; 4]);
    near(Tilt::of_strength(0.5).unwrap().strength(), 0.5, 1.0e-12);
}

/// A turned film's own exposure is the tilted exposure.
#[test]
fn a_turned_film_sees_tilted_samples() {
    let hits = pitched_camera().see(&[floor()]);
    let exposure = Exposure::half_angle(lamp(4.0, -3.0), &hits).unwrap();
    let angle = -40.0_f64.to_radians();
    let turned = Exposure::tight(Film::new(lamp(4.0, -3.0), angle).unwrap(), &hits).unwrap();
    let tilt = exposure.tilt_of_angle(angle).unwrap();
    for (sample, turned) in exposure.samples.iter().zip(&turned.samples) {
        near(sample.tilted(tilt).place, turned.place, 1.0e-12);
        near(sample.tilted(tilt).badness / turned.badness, 1.0, 1.0e-10);
    }
    near(exposure.angle_of_tilt(tilt).unwrap(), angle, 1.0e-12);
}

/// O19 and section 4.1.3: turning the film under parallel light changes no place.
#[test]
fn turning_means_nothing_to_parallel_light() {
    let hits = pitched_camera().see(&[floor()]);
    let sun = Light::Directional { travel: at(-0.6, -1.0) };
    let exposure = Exposure::half_angle(sun, &hits).unwrap();
    for degrees in [20.0_f64, -40.0] {
        let angle = exposure.film.angle() + degrees.to_radians();
        let oblique = Exposure::tight(Film::new(sun, angle).unwrap(), &hits).unwrap();
        for (sample, oblique) in exposure.samples.iter().zip(&oblique.samples) {
            near(sample.place, oblique.place, 1.0e-12);
            near(sample.badness / oblique.badness, 1.0, 1.0e-12);
        }
        assert!(oblique.hull.top - oblique.hull.bottom > 1.05 * (exposure.hull.top - exposure.hull.bottom));
        assert_eq!(exposure.tilt_of_angle(angle), Some(Tilt::default()));
    }
    assert_eq!(exposure.angle_of_tilt(Tilt::default()), None);
    let behind = exposure.film.angle() + 1.6;
    assert_eq!(exposure.tilt_of_angle(behind), None);
    assert_eq!(Film::new(sun, behind), Err(Degenerate::TooWide));
}

/// The matrix of a map agrees with places, and depth is 1 at the near plane, for both kinds of light.
#[test]
fn matrices_of_maps_have_the_same_places() {
    let hits = pitched_camera().see(&[floor()]);
    for light in [lamp(4.0, -3.0), Light::Directional { travel: at(-0.6, -1.0) }] {
        let exposure = Exposure::half_angle(light, &hits).unwrap();
        let cube = exposure.film.cube_from_world(exposure.hull, 0.5, 60.0);
        for (hit, sample) in hits.iter().zip(&exposure.samples) {
            let point = cube * hit.point.extend(1.0);
            near(point.y / point.z, sample.place, 1.0e-12);
        }
        let frame = exposure.film.frame();
        for (ahead, depth) in [(0.5, 1.0), (60.0, -1.0)] {
            let point = cube * (frame.origin + frame.forward() * ahead).extend(1.0);
            near(point.x / point.z, depth, 1.0e-12);
        }
    }
}

/// Frames turn from −z to +y, and the thesis prints films from vertical, counter-clockwise.
#[test]
fn frames_turn_from_minus_z_to_plus_y() {
    let frame = |degrees: f64| Frame {
        origin: at(0.0, 0.0),
        angle: degrees.to_radians(),
    };
    assert!((frame(0.0).forward() - at(0.0, -1.0)).length() < 1.0e-15);
    assert!((frame(0.0).film() - at(1.0, 0.0)).length() < 1.0e-15);
    assert!((frame(90.0).forward() - at(1.0, 0.0)).length() < 1.0e-15);
    assert!((frame(90.0).film() - at(0.0, 1.0)).length() < 1.0e-15);
    let matrix = frame(30.0).world_from_frame();
    assert!((matrix * DVec3::new(-1.0, 0.0, 0.0) - frame(30.0).forward().extend(0.0)).length() < 1.0e-15);
    near(printed_angle(-38.0_f64.to_radians()), 38.0, 1.0e-12);
    near(printed_angle(1.0_f64.to_radians()), 179.0, 1.0e-12);
}

#[test]
fn films_without_an_answer_say_so() {
    let light = lamp(0.0, 0.0);
    let half = |points: &[bevy_math::DVec2]| Film::half_angle(light, points).map(|_| ());
    assert_eq!(half(&[]), Err(Degenerate::NothingVisible));
    assert_eq!(half(&[at(f64::NAN, 1.0)]), Err(Degenerate::NotFinite));
    assert_eq!(half(&[at(0.0, -1.0), at(0.0, -2.0)]), Err(Degenerate::Flat));
    assert_eq!(half(&[at(0.0, 0.0)]), Err(Degenerate::Flat));
    let around = [at(1.0, 0.1), at(-1.0, 0.1), at(0.0, -1.0)];
    assert_eq!(half(&around), Err(Degenerate::TooWide));
    assert!(half(&[at(1.0, -0.1), at(-1.0, -0.1), at(0.0, -1.0)]).is_ok());
    // Across the cut of atan2, in any order.
    let (film, _) = Film::half_angle(light, &[at(0.5, 1.0), at(0.1, 1.0), at(-0.5, 1.0)]).unwrap();
    near(film.angle().cos(), -1.0, 1.0e-12);
    let dark = Light::Directional { travel: at(0.0, 0.0) };
    assert_eq!(Film::new(dark, 0.0), Err(Degenerate::NoLightDirection));
    assert_eq!(Film::new(light, f64::NAN), Err(Degenerate::NotFinite));
    let hits = pitched_camera().see(&[floor()]);
    let film = Film::half_angle(lamp(4.0, -3.0), &[at(0.0, -1.0), at(0.0, -5.0)])
        .unwrap()
        .0;
    let empty = |bottom, top| Exposure::within(film, Hull { bottom, top }, &hits).map(|_| ());
    assert_eq!(empty(0.0, 0.0), Err(Degenerate::Flat));
    assert_eq!(empty(0.0, f64::NAN), Err(Degenerate::NotFinite));
    assert_eq!(empty(1.0e6, 1.0e7), Err(Degenerate::NothingVisible));
}
