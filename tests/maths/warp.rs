//! Warp parameters and error formulas against the oracles of Stingl and Lloyd.

use umbrage::maths::{
    error::{error_across, error_along, largest_errors},
    split::{SplitScheme, split_depths},
    warp::{Warp, WarpSpan, guarded_eta},
};

use crate::support::{OPENING, close, frustum_samples, papers_camera};

fn overhead(near: f64, far: f64) -> WarpSpan {
    WarpSpan::directional(far - near, near, 1.0)
}

/// Stingl, oracle 1.
#[test]
fn the_optimal_parameter_overhead() {
    for (far, expected) in [
        (40.0, 7.3245553),
        (100.0, 11.0),
        (300.0, 18.3205),
        (500.0, 23.3607),
        (1000.0, 32.6228),
        (1500.0, 39.7298),
    ] {
        close(overhead(1.0, far).optimal_warp_near(), expected, 1.0e-5);
    }
}

/// Stingl, oracle 10: the frustum's extent along the warp axis.
#[test]
fn the_extent_of_the_frustum_in_light_space() {
    let extents = [
        (0.0, 46.188),
        (10.0, 45.486),
        (20.0, 43.403),
        (30.0, 40.0),
        (45.0, 44.315),
        (60.0, 45.611),
        (75.0, 43.798),
        (90.0, 39.0),
    ];
    for (degrees, extent) in extents {
        close(
            frustum_samples(&papers_camera(1.0, 40.0), degrees).1.extent,
            extent,
            1.0e-4,
        );
    }
}

/// Stingl, oracle 2: general directional formula with the full frustum as body, symmetric about 90°.
#[test]
fn the_optimal_parameter_for_tilted_light() {
    for (degrees, expected) in [
        (75.0, 7.8481),
        (60.0, 8.5032),
        (45.0, 9.4561),
        (30.0, 11.1652),
        (20.0, 14.5621),
        (10.0, 22.9375),
        (2.0, 74.954),
    ] {
        for degrees in [degrees, 180.0 - degrees] {
            let (_, span) = frustum_samples(&papers_camera(1.0, 40.0), degrees);
            close(span.optimal_warp_near(), expected, 1.0e-4);
        }
    }
    let (_, span) = frustum_samples(&papers_camera(1.0, 40.0), 0.0);
    assert_eq!(span.optimal_warp_near(), f64::INFINITY);
}

/// Stingl, oracles 3, 4, 5 and 6; section 3.2.
#[test]
fn errors_along_the_view() {
    let (near, far): (f64, f64) = (1.0, 40.0);
    let optimal = overhead(near, far).optimal_warp_near();
    let slope = (far - near) / OPENING;
    close(slope, 33.77499, 1.0e-6);
    let along = |depth, warp_near| error_along(depth, warp_near, near, far, OPENING);
    let across = |depth, warp_near| error_across(depth, warp_near, near, far);
    close(along(near, optimal), 5.3403, 1.0e-4);
    close(along(far, optimal), 5.3403, 1.0e-4);
    let lowest = (near * far).sqrt();
    close(along(lowest, optimal), 2.5182, 1.0e-4);
    for depth in [near, 3.0, 10.0, far] {
        assert!(
            along(depth, optimal) > along(lowest, optimal),
            "the minimum is at √(nf), not at {depth}"
        );
        close(across(depth, near), 1.0, 1.0e-12);
        close(along(depth, near), slope * depth / (near * far), 1.0e-12);
        close(across(depth, f64::INFINITY), far / depth, 1.0e-12);
        close(along(depth, f64::INFINITY), slope / depth, 1.0e-12);
        close(across(depth, 1.0e12), far / depth, 1.0e-6);
        close(along(depth, 1.0e12), slope / depth, 1.0e-6);
    }
    close(across(near, optimal), far.sqrt(), 1.0e-9);
    close(across(far, optimal), 1.0, 1.0e-12);
}

/// Lloyd, table 3.6: the warp functions for n = 1, f = 20 (without the constants of the frustum).
#[test]
fn the_published_table_of_warps() {
    let optimal = 1.0 + 20.0_f64.sqrt();
    for (warp_near, depth, across, along) in [
        (10.0, 1.0, 0.3448, 0.3448),
        (10.0, 4.472, 0.1039, 0.1399),
        (optimal, 2.0, 0.1322, 0.1564),
        (optimal, 20.0, 0.05, 0.2236),
        (2.0, 10.0, 0.0524, 0.2881),
        (1.0, 20.0, 0.05, 1.0),
    ] {
        close(error_across(depth, warp_near, 1.0, 20.0) / 20.0, across, 1.0e-3);
        close(error_along(depth, warp_near, 1.0, 20.0, 19.0), along, 1.0e-3);
    }
}

/// Lloyd, table 3.7 and oracle 7; Stingl, oracle 7.
#[test]
fn the_normalised_strength() {
    let span = overhead(1.0, 100.0);
    let (samples, _) = frustum_samples(&papers_camera(1.0, 100.0), 90.0);
    for (eta, warp_near, across, along, storage) in [
        (-1.0, f64::INFINITY, 100.0, 85.737, 8573.65),
        (-0.75, 341.0, 77.5, 66.446, 5149.55),
        (-0.5, 121.0, 55.0, 47.155, 2593.53),
        (-0.25, 47.667, 32.5, 27.864, 905.59),
        (0.0, 11.0, 10.0, 8.574, 85.737),
        (0.25, 3.1429, 3.0769, 27.864, 85.737),
        (0.5, 1.8333, 1.8182, 47.155, 85.737),
        (0.75, 1.2941, 1.2903, 66.446, 85.737),
        (1.0, 1.0, 1.0, 85.737, 85.737),
    ] {
        let actual = span.warp_near(eta);
        if warp_near.is_finite() {
            close(actual, warp_near, 1.0e-4);
        } else {
            assert_eq!(actual, warp_near);
        }
        close(span.eta(actual), eta, 1.0e-9);
        let errors = largest_errors(&samples, actual, OPENING);
        close(errors.across, across, 1.0e-4);
        close(errors.along, along, 1.0e-4);
        close(errors.storage_factor(), storage, 1.0e-4);
    }
}

/// Stingl, oracle 8: the branch eta = 0.5 for n = 1, f = 40; strictly decreasing and continuous.
#[test]
fn the_strength_is_monotone() {
    let span = overhead(1.0, 40.0);
    close(span.warp_near(0.5), 1.75975, 1.0e-5);
    close(span.warp_near(-1.0e-9), span.warp_near(1.0e-9), 1.0e-6);
    let parameters: Vec<f64> = (1..=40)
        .map(|step| span.warp_near(-1.0 + f64::from(step) * 0.05))
        .collect();
    assert!(parameters.is_sorted_by(|a, b| a > b), "{parameters:?}");
}

/// Stingl, oracle 28; Lloyd, section 3.1 to 3.3: storage factors overhead, f ÷ n = 1000.
#[test]
fn storage_factors() {
    let view = papers_camera(1.0, 1000.0);
    for (count, uniform, warped) in [
        (1, 865_159.4, 865.159),
        (2, 1677.3, 53.04),
        (4, 90.06, 16.02),
        (8, 22.53, 9.501),
        (16, 11.52, 7.481),
    ] {
        let depths = split_depths(&SplitScheme::Logarithmic, 1.0, 1000.0, count);
        let (samples, span) = frustum_samples(&view.split(depths[0], depths[1]), 90.0);
        let storage = |warp_near| count as f64 * largest_errors(&samples, warp_near, OPENING).storage_factor();
        close(storage(f64::INFINITY), uniform, 1.0e-3);
        close(storage(span.optimal_warp_near()), warped, 1.0e-3);
        close(storage(span.warp_near(1.0)), warped, 1.0e-3);
    }
}

/// Stingl, oracle 13; Lloyd, oracle 19: logarithmic slices with `LiSPSM` share one error profile.
#[test]
fn warped_logarithmic_slices_are_alike() {
    let depths = split_depths(&SplitScheme::Logarithmic, 1.0, 500.0, 4);
    for range in depths.windows(2) {
        let (near, far) = (range[0], range[1]);
        let optimal = overhead(near, far).optimal_warp_near();
        close(error_across(near, optimal, near, far), 2.1746, 1.0e-4);
        close(error_along(near, optimal, near, far, OPENING), 1.4850, 1.0e-4);
        close(error_along(far, optimal, near, far, OPENING), 1.4850, 1.0e-4);
    }
}

/// Stingl, oracle 14.
#[test]
fn many_slices_converge_to_the_logarithmic_map() {
    let count = 4096.0_f64;
    let ratio = 500.0_f64.powf(1.0 / count);
    close(count * (ratio - 1.0) / OPENING, 5.382, 1.0e-3);
    let storage = count * error_along(1.0, f64::INFINITY, 1.0, ratio, OPENING);
    close(storage, 5.382, 1.0e-3);
}

/// Lloyd, table 3.8, f ÷ n = 1000: S̄ without warp, with n_opt, and guarded: hardly above the better of both, and from
/// light inside the view cone as good as the best parameter of all (which between 90° and 145° is stronger than n_opt).
#[test]
fn storage_factors_for_tilted_light() {
    let view = papers_camera(1.0, 1000.0);
    for (degrees, uniform, optimal, best) in [
        (90.0, 8.652e5, 865.2, 865.2),
        (100.0, 9.389e5, 1151.0, 1150.0),
        (120.0, 9.995e5, 2028.0, 1975.0),
        (130.0, 9.845e5, 3233.0, 2743.0),
        (140.0, 9.395e5, 6640.0, 4675.0),
        (150.0, 8.660e5, 4.123e4, 3.176e4),
        (155.0, 9.063e5, 1.101e6, 4.841e5),
        (160.0, 9.397e5, 4.135e6, 7.808e5),
        (170.0, 9.848e5, 1.198e7, 9.848e5),
    ] {
        for degrees in [degrees, 180.0 - degrees] {
            let (samples, span) = frustum_samples(&view, degrees);
            let storage = |warp_near| largest_errors(&samples, warp_near, OPENING).storage_factor();
            close(storage(f64::INFINITY), uniform, 1.0e-3);
            close(storage(span.optimal_warp_near()), optimal, 1.0e-3);
            let guarded = storage(span.warp_near(guarded_eta(0.0, &samples, &span)));
            assert!(guarded <= f64::min(optimal, uniform) * 1.021, "{degrees}°: {guarded}");
            if (65.0..=115.0).contains(&degrees) || (degrees - 90.0).abs() >= 65.0 {
                assert!(guarded <= best * 1.021, "{degrees}°: {guarded} against {best}");
            }
        }
    }
}

/// The guard leaves n_opt alone overhead, falls back to uniform along the light, and never jumps in between.
#[test]
fn the_guard_fades() {
    for far in [40.0, 1000.0] {
        let view = papers_camera(1.0, far);
        // How much the far end of the map is squeezed: 0 uniform, 1 without bounds.
        let squeeze = |degrees: f64| {
            let (samples, span) = frustum_samples(&view, degrees);
            let eta = guarded_eta(0.0, &samples, &span);
            assert!(
                degrees < 35.0 || eta == 0.0,
                "outside the view cone nothing is guarded, {degrees}°"
            );
            span.extent / (span.extent + span.warp_near(eta))
        };
        let squeezes: Vec<f64> = (0..=1800).map(|step| squeeze(f64::from(step) * 0.05)).collect();
        assert_eq!(squeezes[0], 0.0);
        assert!(squeezes[100] < 0.1, "5°: {}", squeezes[100]);
        for (step, pair) in squeezes.windows(2).enumerate() {
            let change = (pair[1] - pair[0]).abs();
            assert!(
                change < 0.05,
                "{}°: from {} to {}",
                step as f64 * 0.05,
                pair[0],
                pair[1]
            );
        }
    }
}

#[test]
fn other_targets_are_weakened_in_proportion() {
    let (samples, span) = frustum_samples(&papers_camera(1.0, 1000.0), 90.0);
    for warp in [
        Warp::Uniform,
        Warp::Psm,
        Warp::Free { eta: 0.4 },
        Warp::Free { eta: -0.3 },
    ] {
        close(guarded_eta(warp.eta(), &samples, &span), warp.eta(), 1.0e-12);
    }
    let (samples, span) = frustum_samples(&papers_camera(1.0, 1000.0), 20.0);
    let weakened = guarded_eta(0.0, &samples, &span);
    close(guarded_eta(1.0, &samples, &span) + 1.0, 2.0 * (weakened + 1.0), 1.0e-12);
}

#[test]
fn strengths_out_of_range() {
    assert_eq!(Warp::Free { eta: 7.0 }.eta(), 1.0);
    assert_eq!(Warp::Free { eta: f32::NEG_INFINITY }.eta(), -1.0);
    assert_eq!(Warp::Free { eta: f32::NAN }.eta(), -1.0);
    for span in [
        WarpSpan::directional(0.0, 1.0, 1.0),
        WarpSpan::directional(10.0, 0.0, 1.0),
        WarpSpan::directional(10.0, 1.0, 0.0),
        WarpSpan::directional(10.0, 1.0, -1.0),
        WarpSpan::directional(f64::NAN, 1.0, 1.0),
    ] {
        assert_eq!(span.optimal_warp_near(), f64::INFINITY, "{span:?}");
        assert_eq!(span.warp_near(1.0), f64::INFINITY, "{span:?}");
    }
}
