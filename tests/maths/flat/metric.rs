//! Badness, metrics, footprints.

use proptest::prelude::*;
use umbrage::maths::light_plane::flat::{
    Camera, Degenerate, Exposure, Footprints, Metric, Tilt, largest_badness, lost_share, smallest_mean_badness,
    total_badness,
};

use super::{at, five_samples, floor, lamp, near, pitched_camera, samples, surface};

/// O9: integrals over pixels that are affine on the best film, k = 0.4, and the bounds of section 2.1.2.
#[test]
fn continuous_integrals_have_the_published_values() {
    let tilt = Tilt::of_strength(0.4).unwrap();
    let count = 200_000;
    let middles = (0..count).map(|index| (2.0 * f64::from(index) + 1.0) / f64::from(count) - 1.0);
    let places: Vec<f64> = middles.collect();
    let even = samples(&places, &vec![1.0; places.len()]);
    let width = 2.0 / f64::from(count);
    let (first, second) = (
        total_badness(&even, tilt, Metric::L1) * width,
        total_badness(&even, tilt, Metric::L2) * width,
    );
    near(first, 2.507_936_508, 1.0e-8);
    near(second, 3.756_009_070, 1.0e-8);
    // K² ÷ |Ω'| = K³ ÷ |Ω'|² = 2: reached without a tilt.
    near(total_badness(&even, Tilt::default(), Metric::L1) * width, 2.0, 1.0e-12);
    near(total_badness(&even, Tilt::default(), Metric::L2) * width, 2.0, 1.0e-12);
    assert!(first > 2.0 && second > 2.0);
    let closed = Footprints::of_even_pixels(tilt);
    near(closed.average, first / 2.0, 1.0e-8);
    near(closed.deviation.powi(2) + closed.average.powi(2), second / 2.0, 1.0e-8);
    near(closed.worst, largest_badness(&even, tilt), 1.0e-5);
}

/// O17: the table of the single plane follows from one unknown, the hull's half width, as no other reading of its columns
/// does: the half-angle film is 42° off, the "PSM" 82°.
#[test]
fn the_table_of_the_single_plane_is_consistent() {
    let half_width = 22.6_f64.to_radians().tan();
    let tilt = |degrees: f64| Tilt::of_strength(half_width * degrees.to_radians().tan()).unwrap();
    let normal = tilt(42.0);
    let printed_psm = normal.then(tilt(40.0));
    for (tilt, [worst, average, last]) in [(normal, [2.112, 1.169, 1.655]), (printed_psm, [4.381, 1.850, 3.071])] {
        let found = Footprints::of_even_pixels(tilt);
        // The half width is printed to three digits.
        near(0.96 * found.worst / worst, 1.0, 1.0e-3);
        near(0.96 * found.average / average, 1.0, 1.0e-3);
        near(0.96 * found.average_and_deviation() / last, 1.0, 1.0e-3);
    }
}

/// The columns of the tables are the mean over pixels, in pixels per texel.
#[test]
fn footprints_are_per_pixel() {
    let found = Footprints::of(&five_samples(), Tilt::default(), 4.0).unwrap();
    near(found.worst, 4.5, 1.0e-12);
    near(found.average, 1.7, 1.0e-12);
    // Half of √(103 ÷ 5 − 3.4²).
    near(found.deviation, 9.04_f64.sqrt() / 2.0, 1.0e-12);
    near(found.average_and_deviation(), found.average + found.deviation, 0.0);
    assert_eq!(Footprints::of(&[], Tilt::default(), 4.0), None);
    near(smallest_mean_badness(950, 1000.0), 0.95, 1.0e-15);
}

/// Section 2.1.2: no film of a floor that fills the film has a mean below pixels ÷ texels.
#[test]
fn no_film_is_better_than_the_bound() {
    let hits = pitched_camera().see(&[floor()]);
    let exposure = Exposure::half_angle(lamp(4.0, -3.0), &hits).unwrap();
    // The hull ends at the middles of the outermost pixels.
    let bound = smallest_mean_badness(hits.len() - 1, 1000.0);
    for step in -30..=30 {
        let tilt = Tilt::new(f64::from(step) / 10.0);
        let found = Footprints::of(&exposure.samples, tilt, 1000.0).unwrap();
        assert!(found.average >= bound * (1.0 - 1.0e-9), "{}", found.average);
        assert!(found.worst >= found.average);
    }
}

/// Section 3, figure 3.1: between two surfaces that the light sees apart, texels are lost; tilting moves them but a
/// gap stays a gap.
#[test]
fn gaps_lose_texels() {
    let whole = samples(&[-0.75, -0.25, 0.25, 0.75], &[2.0; 4]);
    near(lost_share(&whole, Tilt::default()).unwrap(), 0.0, 1.0e-12);
    near(lost_share(&whole[1..], Tilt::default()).unwrap(), 0.25, 1.0e-12);
    let gap = samples(&[-0.75, 0.75], &[2.0; 2]);
    near(lost_share(&gap, Tilt::default()).unwrap(), 0.5, 1.0e-12);
    let tilt = Tilt::of_strength(0.6).unwrap();
    let kept = 2.0 - tilt.place(0.5) + tilt.place(-0.5);
    near(lost_share(&gap, tilt).unwrap(), 1.0 - kept / 2.0, 1.0e-12);
    // Two pixels on one place count once.
    let double = samples(&[-0.75, -0.75], &[2.0; 2]);
    near(lost_share(&double, Tilt::default()).unwrap(), 0.75, 1.0e-12);
    near(lost_share(&[], Tilt::default()).unwrap(), 1.0, 0.0);
    let bad = samples(&[f64::NAN], &[1.0]);
    assert_eq!(lost_share(&bad, Tilt::default()), Err(Degenerate::NotFinite));
}

/// Ω is what the pixels see: the nearest surface, nothing behind the eye, nothing where there is none; surfaces that the
/// light sees edge-on have badness without bound, which can be limited.
#[test]
fn pixels_see_the_nearest_surface() {
    let camera = Camera::new(at(0.0, 0.0), 0.0, 45.0_f64.to_radians(), 1.0, 10.0, 8).unwrap();
    let wall = surface([-9.0, -4.0], [9.0, -4.0]);
    let card = surface([0.1, -2.0], [1.0, -2.0]);
    let behind = surface([-9.0, 1.0], [9.0, 1.0]);
    let hits = camera.see(&[behind, wall, card]);
    assert_eq!(hits.len(), 8);
    let segments: Vec<usize> = hits.iter().map(|hit| hit.segment).collect();
    assert_eq!(segments, [1, 1, 1, 1, 2, 2, 1, 1]);
    near(hits[0].pixel, -7.0 / 8.0, 1.0e-15);
    assert!((hits[0].point - at(-3.5, -4.0)).length() < 1.0e-12);
    assert!((hits[0].step - at(1.0, 0.0)).length() < 1.0e-12);
    assert!(camera.see(&[behind]).is_empty());
    assert!(camera.see(&[surface([1.0, -1.0], [1.0, -1.0])]).is_empty());

    let edge_on = camera.see(&[wall, surface([-0.2, -3.0], [0.4, -2.0])]);
    let exposure = Exposure::half_angle(lamp(1.0, -1.0), &edge_on).unwrap();
    assert!(exposure.samples.iter().any(|sample| sample.badness > 1.0e9));
    let limited = exposure.limited(4000.0);
    near(largest_badness(&limited.samples, Tilt::default()), 4000.0, 0.0);
}

#[test]
fn impossible_cameras_are_refused() {
    let camera = |half_fov: f64, near, far, pixels| Camera::new(at(0.0, 0.0), 0.0, half_fov, near, far, pixels);
    assert!(camera(0.5, 1.0, 2.0, 1).is_ok());
    for (half_fov, near, far, pixels) in [
        (0.0, 1.0, 2.0, 1),
        (1.6, 1.0, 2.0, 1),
        (0.5, 0.0, 2.0, 1),
        (0.5, 2.0, 2.0, 1),
    ] {
        assert_eq!(camera(half_fov, near, far, pixels), Err(Degenerate::Camera));
    }
    assert_eq!(camera(0.5, 1.0, 2.0, 0), Err(Degenerate::Camera));
    assert_eq!(camera(0.5, f64::NAN, 2.0, 1), Err(Degenerate::Camera));
    assert_eq!(camera(f64::NAN, 1.0, 2.0, 1), Err(Degenerate::NotFinite));
    assert_eq!(camera(0.5, 1.0, f64::INFINITY, 1), Err(Degenerate::NotFinite));
    assert_eq!(pitched_camera().with_pixels(0), Err(Degenerate::Camera));
}

proptest! {
    /// Nothing panics, whatever the numbers.
    #[test]
    fn strange_numbers_are_survived(
        places in proptest::collection::vec(prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(-1.0), Just(1.0), -2.0..2.0_f64], 0..6),
        badness in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(0.0), Just(1.0e-320), Just(1.0e300), 0.0..9.0_f64],
        parameter in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(800.0), -9.0..9.0_f64],
    ) {
        use umbrage::maths::light_plane::flat::{newton, optimal_tilt, smallest_largest_tilt, split::{slices, greedy_merge, exact_partition, SliceExtent}};
        let samples = samples(&places, &vec![badness; places.len()]);
        let tilt = Tilt::new(parameter);
        for metric in [Metric::L1, Metric::L2] {
            if let Ok(best) = optimal_tilt(&samples, metric) {
                prop_assert!(best.parameter.is_finite());
            }
            for extent in [SliceExtent::Borders, SliceExtent::Pixels] {
                if let Ok(parts) = slices(&samples, &[-1.0, 0.0, 0.5, 1.0], metric, extent) {
                    let _ = greedy_merge(&parts, 1, 0.1, metric);
                    let _ = exact_partition(&parts, 2, metric);
                }
            }
            let _ = total_badness(&samples, tilt, metric);
        }
        let _ = (newton(&samples, 3.0, tilt, 1.0e-6), smallest_largest_tilt(&samples));
        let _ = (lost_share(&samples, tilt), Footprints::of(&samples, tilt, 0.0));
    }
}
