//! z-partitions over all directions of light, and their seams, against Lloyd's tables.

use bevy_math::DVec3;
use umbrage::maths::{
    error::{LargestErrors, LightSample, error_across, error_along, largest_errors},
    fit::LightAxes,
    split::{SplitScheme, split_depths},
    warp::WarpSpan,
};

use crate::{
    face::hemisphere,
    support::{OPENING, close, light_at, papers_camera},
};

/// Unwarped S̄ of a slice, and the smaller of that and the S̄ of n_opt.
fn slice_storage(near: f64, far: f64, light: DVec3) -> (f64, f64) {
    let view = papers_camera(near, far);
    let axes = LightAxes::new(view.forward(), view.up(), light).unwrap();
    let samples: Vec<LightSample> = view
        .corners(near, far)
        .iter()
        .map(|corner| LightSample {
            across: axes.x.dot(*corner),
            along: axes.y.dot(*corner),
            depth: view.depth(*corner),
        })
        .collect();
    let along = samples.iter().map(|sample| sample.along);
    let extent = along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min);
    let span = WarpSpan::directional(extent, near, view.forward().dot(axes.y));
    let storage = |warp_near| largest_errors(&samples, warp_near, OPENING).storage_factor();
    let unwarped = storage(f64::INFINITY);
    (unwarped, unwarped.min(storage(span.optimal_warp_near())))
}

/// S̄ of all slices together, unwarped and warped.
fn storage(ratio: f64, slices: usize, light: DVec3) -> (f64, f64) {
    let depths = split_depths(&SplitScheme::Logarithmic, 1.0, ratio, slices);
    depths
        .windows(2)
        .map(|range| slice_storage(range[0], range[1], light))
        .fold((0.0, 0.0), |sum, slice| (sum.0 + slice.0, sum.1 + slice.1))
}

/// Lloyd, table 3.9: the worst direction is nearly twice as bad as light along the view, with or without warps; warps
/// lower the mean.
#[test]
fn slices_over_the_hemisphere() {
    for (slices, largest, mean, largest_warped, mean_warped) in [
        (1, 1.94e6, 1.239e6, 1.94e6, 4174.0),
        (2, 3879.0, 2439.0, 3517.0, 161.2),
        (3, 581.9, 352.8, 551.2, 65.98),
        (4, 245.3, 142.4, 245.3, 44.68),
        (8, 87.3, 43.2, 87.3, 28.28),
    ] {
        let all: Vec<(f64, f64)> = hemisphere(18, 36).map(|light| storage(1000.0, slices, light)).collect();
        let summary = |values: Vec<f64>| {
            let logarithms: f64 = values.iter().map(|value| value.ln()).sum();
            let mean = (logarithms / values.len() as f64).exp();
            (values.into_iter().fold(0.0, f64::max), mean)
        };
        let unwarped = summary(all.iter().map(|storage| storage.0).collect());
        let warped = summary(all.iter().map(|storage| storage.1).collect());
        close(unwarped.0, largest, 3.0e-3);
        close(unwarped.1, mean, 3.0e-2);
        close(warped.0, largest_warped, 3.0e-3);
        close(warped.1, mean_warped, 3.0e-2);
    }
}

/// Lloyd, table 3.10: four slices, light in the plane of view and up; oracle 14.
#[test]
fn four_slices_over_the_angle_of_light() {
    for (degrees, unwarped, warped) in [
        (90.0, 90.06, 16.02),
        (100.0, 101.6, 22.43),
        (110.0, 110.1, 30.89),
        (120.0, 115.2, 41.86),
        (130.0, 116.9, 55.75),
        (140.0, 115.0, 72.37),
        (150.0, 109.5, 89.72),
        (160.0, 118.9, 118.9),
        (180.0, 126.5, 126.5),
    ] {
        for degrees in [degrees, 180.0 - degrees] {
            let found = storage(1000.0, 4, light_at(degrees));
            close(found.0, unwarped, 1.0e-3);
            close(found.1, warped, 1.0e-3);
        }
    }
}

/// Lloyd, section 5.2, oracle 19 and table 3.11: at a seam of `LiSPSM` slices m_z is continuous and m_x jumps by
/// α^(1/2k); with `PSM` m_x is continuous and m_z jumps by α^(1/k).
#[test]
fn seams_of_warped_slices() {
    for (ratio, count, across_jump, along_jump) in [
        (100.0, 2, 3.162, 10.0),
        (100.0, 4, 1.778, 3.162),
        (1000.0, 2, 5.623, 31.62),
        (1000.0, 4, 2.371, 5.623),
        (10000.0, 4, 3.162, 10.0),
    ] {
        let depths = split_depths(&SplitScheme::Logarithmic, 1.0, ratio, count);
        for triple in depths.windows(3) {
            let split = triple[1];
            let jumps = |warp_near: fn(f64, f64) -> f64| {
                let at_split = |near: f64, far: f64| LargestErrors {
                    across: error_across(split, warp_near(near, far), near, far),
                    along: error_along(split, warp_near(near, far), near, far, OPENING),
                };
                let (before, after) = (at_split(triple[0], split), at_split(split, triple[2]));
                (after.across / before.across, before.along / after.along)
            };
            let lispsm = jumps(|near, far| near + (near * far).sqrt());
            close(lispsm.0, across_jump, 1.0e-3);
            close(lispsm.1, 1.0, 1.0e-9);
            let psm = jumps(|near, _| near);
            close(psm.0, 1.0, 1.0e-9);
            close(psm.1, along_jump, 1.0e-3);
        }
    }
}
