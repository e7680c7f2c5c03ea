//! L1 and L2 means of the error (Lloyd, section 3.3).

use bevy_math::DVec3;
use umbrage::maths::{
    analysis::{
        direction::{TiltedWarp, Unanalysable, frustum_map},
        means::{mean_errors, overhead_mean_errors},
        overhead::{OverheadRange, OverheadWarp},
    },
    error::{AxisErrors, error_across, error_along},
};

use crate::support::{OPENING, close, light_at, papers_camera};

/// The closed form is the quadrature for light from above, for every strength of the warp.
#[test]
fn closed_forms_are_the_quadrature() {
    for far in [3.0, 100.0, 1000.0] {
        let view = papers_camera(1.0, far);
        let range = OverheadRange::of_view(&view).expect("a range");
        for eta in [-1.0, -0.5, 0.0, 0.5, 1.0] {
            let closed = overhead_mean_errors(&range, range.warp_near(OverheadWarp::Strength { eta }));
            let found = mean_errors(&view, light_at(90.0), TiltedWarp::Strength { eta }).expect("sound");
            for (found, closed) in [
                (found.mean, closed.mean),
                (found.root_mean_square, closed.root_mean_square),
            ] {
                close(found.across, closed.across, 1.0e-7);
                close(found.along, closed.along, 1.0e-7);
            }
        }
    }
}

/// Both are sums over thin slices of the published curves, and lie in order below the largest error, for any light.
#[test]
fn means_lie_below_the_largest_error() {
    let (near, far) = (1.0, 50.0);
    let range = OverheadRange::new(near, far, OPENING).expect("a range");
    let warp_near = range.warp_near(OverheadWarp::Lispsm);
    let steps = 200_000;
    let (mut volume, mut across, mut along) = (0.0, 0.0, 0.0);
    for step in 0..steps {
        let depth = near + (far - near) * (f64::from(step) + 0.5) / f64::from(steps);
        volume += depth * depth;
        across += depth * depth * error_across(depth, warp_near, near, far);
        along += depth * depth * error_along(depth, warp_near, near, far, OPENING).powi(2);
    }
    let means = overhead_mean_errors(&range, warp_near);
    close(means.mean.across, across / volume, 1.0e-6);
    close(means.root_mean_square.along, (along / volume).sqrt(), 1.0e-6);

    let view = papers_camera(near, far);
    for degrees in [0.0, 20.0, 60.0, 90.0, 140.0] {
        for warp in [TiltedWarp::Uniform, TiltedWarp::Guarded] {
            let means = mean_errors(&view, light_at(degrees), warp).expect("sound");
            let largest = frustum_map(&view, light_at(degrees), warp).expect("sound").largest;
            let in_order = |[mean, square, largest]: [f64; 3]| mean < square && square < largest;
            let axes: [fn(AxisErrors) -> f64; 2] = [|errors| errors.across, |errors| errors.along];
            for (axis, largest) in axes.into_iter().zip([largest.across, largest.along]) {
                let row = [axis(means.mean), axis(means.root_mean_square), largest];
                assert!(in_order(row), "{degrees}° {warp:?}: {row:?}");
            }
        }
    }
}

/// Lloyd, section 3.3: a mean allows outliers. The best warp by the mean of the error along leaves a largest error that is
/// many times that of `LiSPSM`.
#[test]
fn means_allow_outliers() {
    let range = OverheadRange::new(1.0, 1000.0, OPENING).expect("a range");
    let mean = |eta: f64| {
        let warp_near = range.warp_near(OverheadWarp::Strength { eta });
        overhead_mean_errors(&range, warp_near).mean.along
    };
    let largest = |eta: f64| {
        range
            .largest_errors(range.warp_near(OverheadWarp::Strength { eta }))
            .along
    };
    let strengths = (-100..=100).map(|step| f64::from(step) / 100.0);
    let best = strengths.min_by(|a, b| mean(*a).total_cmp(&mean(*b))).expect("some");
    assert!(largest(best) > 5.0 * largest(0.0), "{best}: {}", largest(best));
}

#[test]
fn frusta_without_means() {
    let endless = papers_camera(1.0, f64::INFINITY);
    assert_eq!(
        mean_errors(&endless, DVec3::NEG_Y, TiltedWarp::Uniform),
        Err(Unanalysable::Endless)
    );
    assert_eq!(
        mean_errors(&papers_camera(1.0, 10.0), DVec3::ZERO, TiltedWarp::Uniform),
        Err(Unanalysable::NoLightDirection)
    );
}
