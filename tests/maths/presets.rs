//! Every warp through its matrix: parameters, footprints, equivalences.

use std::f64::consts::FRAC_PI_2;

use bevy_math::{DVec2, DVec3};
use umbrage::maths::{
    error::{error_across, error_along},
    fit::{FitOptions, LightFit},
    view::ViewVolume,
    warp::{Warp, WarpSpan, frustum_extent, reparametrised_eta, trapezoidal_warp_near},
};

use crate::support::{OPENING, close, errors, fit, fit_with, light_at, papers_camera, roomy_scene};

fn degrees_eta(angle: f64) -> f64 {
    reparametrised_eta(angle.to_radians(), 30.0_f64.to_radians())
}

/// M_x and M_z through the matrix: both errors are largest at a corner of the frustum.
fn largest(fit: &LightFit, view: &ViewVolume) -> DVec2 {
    let corners = view.corners(view.near(), view.far());
    corners
        .map(|corner| errors(fit, view, corner))
        .into_iter()
        .fold(DVec2::ZERO, DVec2::max)
}

fn overhead(near: f64, far: f64, warp: Warp) -> (ViewVolume, LightFit) {
    let view = papers_camera(near, far);
    let fit = fit(&view, &roomy_scene(), DVec3::NEG_Y, warp);
    (view, fit)
}

/// Stingl, oracle 8 and equation 3.3 for Θ = 30°.
#[test]
fn the_reparametrised_strength() {
    for (angle, eta) in [
        (0.0, -1.0),
        (10.0, -1.0),
        (15.0, -0.8),
        (20.0, -0.6),
        (30.0, -0.2),
        (45.0, -0.00681),
        (48.0, 0.0),
        (90.0, 0.0),
    ] {
        assert!(
            (degrees_eta(angle) - eta).abs() < 1.0e-5,
            "{angle}°: {}",
            degrees_eta(angle)
        );
        close(degrees_eta(180.0 - angle), degrees_eta(angle), 1.0e-9);
        close(degrees_eta(-angle), degrees_eta(angle), 1.0e-9);
    }
    for border in [10.0, 30.0, 48.0] {
        let jump = degrees_eta(border + 1.0e-6) - degrees_eta(border - 1.0e-6);
        assert!((0.0..1.0e-6).contains(&jump), "a jump of {jump} at {border}°");
    }
    assert_eq!(reparametrised_eta(f64::NAN, 0.5), -1.0);
    assert_eq!(reparametrised_eta(1.0, f64::NAN), -1.0);
    assert_eq!(reparametrised_eta(FRAC_PI_2, 7.0), 0.0, "absurd openings are drawn in");
}

/// Stingl, oracle 10, with the corrected W_s1, and section 2.3.5: W_lz, n_repar and n_opt for n = 1, f = 40, Θ = 30°.
#[test]
fn the_published_reparametrised_parameters() {
    let half_opening = 30.0_f64.to_radians();
    let extent = |angle: f64| frustum_extent(1.0, 40.0, half_opening, angle.to_radians());
    for (angle, expected) in [(0.0, 46.188), (10.0, 45.486), (20.0, 43.403), (30.0, 40.0)] {
        close(extent(angle), expected, 1.0e-4);
    }
    for (angle, width, repar, optimal) in [
        (90.0, 39.0000, 7.3246, 7.3246),
        (75.0, 43.7977, 8.2256, 7.8481),
        (60.0, 45.6107, 8.5661, 8.5032),
        (48.0, 44.8219, 8.4180, 9.2275),
        (45.0, 44.3153, 8.6840, 9.4561),
        (30.0, 40.0000, 19.3905, 11.1652),
        (20.0, 43.4025, 85.4823, 14.5621),
        (15.0, 44.6142, 220.35, 17.5496),
    ] {
        close(extent(angle), width, 1.0e-5);
        let whole = WarpSpan::new(extent(angle), 1.0, 40.0);
        close(whole.warp_near(degrees_eta(angle)), repar, 1.0e-4);
        let sine = angle.to_radians().sin();
        close(
            WarpSpan::directional(width, 1.0, sine).optimal_warp_near(),
            optimal,
            1.0e-4,
        );
    }
    let whole = WarpSpan::new(extent(60.0), 1.0, 40.0);
    assert_eq!(whole.warp_near(-1.0), f64::INFINITY);
    close(whole.warp_near(0.0), extent(60.0) / (40.0_f64.sqrt() - 1.0), 1.0e-12);
    close(whole.warp_near(1.0), extent(60.0) / 39.0, 1.0e-12);
}

/// The fit takes the extent that it measures for W_lz and z1/z0 for alpha, so that eta = 0 is n_opt for every light.
#[test]
fn reparametrised_light_views() {
    let unguarded = FitOptions {
        guard: false,
        ..FitOptions::default()
    };
    let view = papers_camera(1.0, 40.0);
    for angle in [90.0, 75.0, 48.1, 45.0, 30.0, 20.0, 15.0, 10.0, 0.0] {
        for angle in [angle, 180.0 - angle] {
            let warp_near = |warp| fit_with(&view, &roomy_scene(), light_at(angle), warp, unguarded).warp_near;
            let folded = (90.0 - (angle - 90.0_f64).abs()).to_radians();
            let extent = frustum_extent(1.0, 40.0, 30.0_f64.to_radians(), folded);
            let span = WarpSpan::directional(extent, 1.0, folded.sin());
            let expected = span.warp_near(degrees_eta(angle));
            let actual = warp_near(Warp::Repar);
            if expected.is_finite() {
                close(actual, expected, 1.0e-9);
            } else {
                assert_eq!(actual, expected, "{angle}°");
            }
            if folded > 48.0_f64.to_radians() {
                assert_eq!(
                    actual,
                    warp_near(Warp::Lispsm),
                    "outside the cone it is LiSPSM, {angle}°"
                );
            }
        }
    }
}

/// Θ is the opening towards the light: of a wide picture, the light leaves the cone later sideways than upwards.
#[test]
fn the_cone_of_wide_pictures() {
    let view = ViewVolume::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 0.8, 2.5, 1.0, 40.0).expect("a camera");
    let eta = |light: DVec3| {
        let unguarded = FitOptions {
            guard: false,
            ..FitOptions::default()
        };
        fit_with(&view, &roomy_scene(), light, Warp::Repar, unguarded).eta
    };
    for (side, half_opening) in [
        (DVec3::Y, 0.4_f64),
        (DVec3::X, (0.4_f64.tan() * 2.5).atan()),
        (DVec3::new(0.6, 0.8, 0.0), (0.4_f64.tan() / 0.8).atan()),
    ] {
        for side in [side, -side] {
            for view_part in [DVec3::Z, DVec3::NEG_Z] {
                let light = view_part * half_opening.cos() + side * half_opening.sin();
                assert!((eta(light) + 0.2).abs() < 1.0e-6, "{side}: {}", eta(light));
            }
        }
    }
}

/// Stingl, figure 3.8 (Θ = 30°, γ = 20°): n_opt is worse across the axis than no warp, the re-parametrised warp is not.
#[test]
fn light_inside_the_cone() {
    let view = papers_camera(1.0, 40.0);
    let unguarded = FitOptions {
        guard: false,
        ..FitOptions::default()
    };
    let errors = |warp| largest(&fit_with(&view, &roomy_scene(), light_at(20.0), warp, unguarded), &view);
    let (uniform, optimal, repar) = (errors(Warp::Uniform), errors(Warp::Lispsm), errors(Warp::Repar));
    assert!(optimal.x > 1.5 * uniform.x, "{optimal} against {uniform}");
    assert!(repar.x < 1.25 * uniform.x, "{repar} against {uniform}");
    assert!(
        repar.x * repar.y < 1.3 * uniform.x * uniform.y,
        "{repar} against {uniform}"
    );
}

/// The guard is a ceiling for the re-parametrised warp, never a second fade.
#[test]
fn the_guard_of_the_reparametrised_warp() {
    for far in [40.0, 1000.0] {
        let view = papers_camera(1.0, far);
        for step in 0..=180 {
            let light = light_at(f64::from(step));
            let eta = |warp| fit(&view, &roomy_scene(), light, warp).eta;
            let expected = eta(Warp::Lispsm).min(degrees_eta(f64::from(step)));
            assert!((eta(Warp::Repar) - expected).abs() < 1.0e-6, "{step}°, far {far}");
        }
    }
}

/// Every preset with its closed form of n', for n and f overhead (Lloyd, section 4.1, equation 11, table of presets).
fn presets(near: f64, far: f64) -> Vec<(Warp, f64)> {
    let root = (far / near).sqrt();
    let optimal = near + (near * far).sqrt();
    let mut presets = vec![
        (Warp::Uniform, f64::INFINITY),
        (Warp::Lispsm, optimal),
        (Warp::Repar, optimal),
        (Warp::Psm, near),
    ];
    for eta in [
        -1.0, -0.9, -0.75, -0.5, -0.25, -0.1, 0.0, 0.125, 0.25, 0.5, 0.75, 0.875, 1.0,
    ] {
        let relative = if eta <= 0.0 {
            (root + 1.0 - eta * (far / near - 1.0)) / (eta + 1.0)
        } else {
            (root + 1.0) / (eta * root + 1.0)
        };
        presets.push((Warp::Free { eta: eta as f32 }, near * relative));
    }
    for focus in [0.125_f32, 0.25, 0.5, 0.625, 0.8125] {
        let (depth, range) = (f64::from(focus) * (far - near), far - near);
        let expected = if f64::from(focus) >= 0.8 {
            f64::INFINITY
        } else {
            0.2 * range * depth / (0.8 * range - depth)
        };
        presets.push((Warp::Tsm { focus }, expected.max(near)));
    }
    presets
}

/// Stingl, oracles 3 to 6 and 9: the footprint of a texel through every preset's matrix is the published error.
#[test]
fn every_preset_has_the_published_errors() {
    for (near, far) in [(1.0, 40.0), (0.5, 700.0), (20.0, 30.0)] {
        for (warp, warp_near) in presets(near, far) {
            let (view, fit) = overhead(near, far, warp);
            if warp_near.is_finite() {
                close(fit.warp_near, warp_near, 1.0e-6);
            } else {
                assert_eq!(fit.warp_near, warp_near, "{warp:?}");
            }
            for share in [0.0, 0.02, 0.1, 0.4, 0.9, 1.0] {
                let depth = near + (far - near) * share;
                let actual = errors(&fit, &view, DVec3::NEG_Z * depth);
                close(actual.x, error_across(depth, warp_near, near, far), 1.0e-4);
                close(actual.y, error_along(depth, warp_near, near, far, OPENING), 1.0e-4);
            }
        }
    }
}

/// Lloyd, equations 9 and 10 in terms of eta, and oracles 4 to 8; Stingl, oracle 7: S̄ is the same for all strengths from
/// `LiSPSM` to `PSM` and larger for weaker ones; M_x (geometric) and M_z (piecewise linear) follow eta.
#[test]
fn presets_are_equivalent_by_storage() {
    let (near, far): (f64, f64) = (1.0, 40.0);
    let ratio = far / near;
    let root = ratio.sqrt();
    let constant = (ratio - 1.0) / OPENING;
    close(constant, 33.775, 1.0e-5);
    for step in 0..=16 {
        let eta = -1.0 + f64::from(step) / 8.0;
        let (view, fit) = overhead(near, far, Warp::Free { eta: eta as f32 });
        let actual = largest(&fit, &view);
        let q = (1.0 + eta.abs() * (root - 1.0)) / root;
        let across = if eta <= 0.0 { ratio * q } else { 1.0 / q };
        close(actual.x, across, 1.0e-5);
        close(actual.y, constant * q, 1.0e-5);
        let storage = constant * if eta <= 0.0 { ratio * q * q } else { 1.0 };
        close(actual.element_product(), storage, 1.0e-5);
        close(errors(&fit, &view, DVec3::NEG_Z * far).x, 1.0, 1.0e-5);
    }
    let storage = |warp| {
        let (view, fit) = overhead(near, far, warp);
        largest(&fit, &view).element_product()
    };
    close(storage(Warp::Uniform), 1351.0, 1.0e-4);
    close(storage(Warp::Lispsm), constant, 1.0e-5);
    close(storage(Warp::Psm), constant, 1.0e-5);
    close(storage(Warp::Repar), constant, 1.0e-5);
    close(storage(Warp::Tsm { focus: 0.25 }), constant, 1.0e-5);
    assert!(
        storage(Warp::Tsm { focus: 0.5 }) > 1.5 * constant,
        "out of the minimal range"
    );
}

/// Scherzer, table 3.1: n = 0.1, f = 70, picture 512², map 2048².
#[test]
fn the_published_quality() {
    for (warp, storage, across, along) in [
        (Warp::Uniform, 423_746.0, 175.0, 151.3),
        (Warp::Lispsm, 605.35, 6.614, 5.720),
        (Warp::Psm, 605.35, 0.25, 151.3),
    ] {
        let (view, fit) = overhead(0.1, 70.0, warp);
        let actual = largest(&fit, &view);
        close(actual.x * 0.25, across, 1.0e-3);
        close(actual.y * 0.25, along, 1.0e-3);
        close(actual.element_product(), storage, 1.0e-4);
    }
}

/// Lloyd, oracle 24 and the examples of table 3.7: the focus gets four fifths of the map.
#[test]
fn trapezoidal_maps() {
    for (depth, warp_near) in [(5.0, 1.334), (20.0, 6.689), (50.0, 33.90)] {
        close(trapezoidal_warp_near(99.0, depth / 99.0), warp_near, 1.0e-3);
        let focus = (depth / 99.0) as f32;
        let (view, fit) = overhead(1.0, 100.0, Warp::Tsm { focus });
        close(fit.warp_near, warp_near, 1.0e-3);
        let place = fit.clip_from_world.project_point3(DVec3::NEG_Z * (1.0 + depth)).y;
        close(place * 0.5 + 0.5, 0.8, 1.0e-6);
        let storage = largest(&fit, &view).element_product();
        if depth < 30.0 {
            close(storage, 85.737, 1.0e-4);
        } else {
            assert!(storage > 2.0 * 85.74, "{storage}");
        }
    }
    for (focus, warp_near) in [(0.0, 1.0), (-3.0, 1.0), (0.8, f64::INFINITY), (9.0, f64::INFINITY)] {
        assert_eq!(
            overhead(1.0, 100.0, Warp::Tsm { focus }).1.warp_near,
            warp_near,
            "{focus}"
        );
    }
    assert_eq!(
        overhead(1.0, 100.0, Warp::Tsm { focus: f32::NAN }).1.warp_near,
        f64::INFINITY
    );
    assert_eq!(trapezoidal_warp_near(10.0, 0.0), 0.0);
}

/// Lloyd, oracles 1 and 2: the coordinate along the axis runs from 0 to 1, its derivative is the published one, and
/// √(n f) lies in the middle of a `LiSPSM` map.
#[test]
fn the_coordinate_along_the_axis() {
    for warp in [Warp::Lispsm, Warp::Psm, Warp::Tsm { focus: 0.25 }] {
        let (_, fit) = overhead(1.0, 40.0, warp);
        let place = |depth: f64| fit.clip_from_world.project_point3(DVec3::NEG_Z * depth).y * 0.5 + 0.5;
        assert!(
            place(1.0).abs() < 1.0e-9 && (place(40.0) - 1.0).abs() < 1.0e-9,
            "{warp:?}"
        );
        for depth in [1.5, 4.0, 12.0, 39.0] {
            let distance = fit.warp_near + depth - 1.0;
            let slope = (fit.warp_near + 39.0) * fit.warp_near / (distance * distance * 39.0);
            close((place(depth + 1.0e-4) - place(depth - 1.0e-4)) / 2.0e-4, slope, 1.0e-5);
        }
        if warp == Warp::Lispsm {
            close(place(40.0_f64.sqrt()), 0.5, 1.0e-9);
        }
    }
}

/// Lloyd, oracle 18: how much of the map the view frustum covers.
#[test]
fn covered_shares_of_the_map() {
    let root = 100.0_f64.sqrt();
    for (warp, share) in [
        (Warp::Uniform, (1.0 + 0.01) * 0.5),
        (Warp::Lispsm, (1.0 + 1.0 / root) * 0.5),
        (Warp::Psm, 1.0),
    ] {
        let (view, fit) = overhead(1.0, 100.0, warp);
        let corner = |index: usize| fit.clip_from_world.project_point3(view.corners(1.0, 100.0)[index]);
        let (near, far) = (corner(1).x - corner(0).x, corner(5).x - corner(4).x);
        let height = corner(4).y - corner(0).y;
        close((near + far).abs() * 0.5 * height / 4.0, share, 1.0e-6);
    }
}

/// Scherzer, oracle 6: a warped map tends to the uniform one, by at most 2 d ÷ n'.
#[test]
fn weak_warps_tend_to_uniform() {
    let view = papers_camera(1.0, 40.0);
    let light = light_at(70.0);
    let uniform = fit(&view, &roomy_scene(), light, Warp::Uniform);
    let mut differences = Vec::new();
    for eta in [-0.95, -0.99, -0.999, -0.9999] {
        let warped = fit(&view, &roomy_scene(), light, Warp::Free { eta });
        let extent = frustum_extent(1.0, 40.0, 30.0_f64.to_radians(), 70.0_f64.to_radians());
        assert!(warped.warp_near > 10.0 * extent, "weak");
        let difference = view.corners(1.0, 40.0).map(|corner| {
            let places = [uniform, warped].map(|fit| fit.clip_from_world.project_point3(corner).truncate() * 0.5);
            (places[0] - places[1]).abs().max_element()
        });
        let most = difference.into_iter().fold(0.0, f64::max);
        assert!(
            most <= 2.0 * extent / warped.warp_near,
            "{most} at n' = {}",
            warped.warp_near
        );
        differences.push(most);
    }
    assert!(differences.is_sorted_by(|a, b| a > b), "{differences:?}");
    assert!(differences[3] < 1.0e-3, "{differences:?}");
}

/// Scherzer, oracle 22: light along the view gives the uniform map to the last bit, from ahead and from behind; light
/// across it divides S̄ by f ÷ n.
#[test]
fn duelling_frusta() {
    let view = papers_camera(0.5, 120.0);
    for light in [DVec3::Z, DVec3::NEG_Z] {
        let of = |warp| fit(&view, &roomy_scene(), light, warp).clip_from_world;
        for warp in [
            Warp::Lispsm,
            Warp::Repar,
            Warp::Psm,
            Warp::Tsm { focus: 0.25 },
            Warp::Free { eta: 0.5 },
        ] {
            assert_eq!(of(warp), of(Warp::Uniform), "{warp:?}");
        }
    }
    let storage = |warp| largest(&fit(&view, &roomy_scene(), DVec3::NEG_Y, warp), &view).element_product();
    close(storage(Warp::Uniform) / storage(Warp::Lispsm), 240.0, 1.0e-5);
}
