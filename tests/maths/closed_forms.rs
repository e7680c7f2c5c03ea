//! Storage factors in closed form: S̄ against the number of maps (Lloyd, section 5.3).

use std::f64::consts::E;

use umbrage::maths::{
    analysis::overhead::{OverheadRange, OverheadWarp, storage_factor},
    split::SplitScheme,
    storage::{
        LightPlace, PartitionScheme, best_slices_along_view, closed_storage_factor, crossover_maps,
        storage_factor_of_maps,
    },
};

use crate::support::{OPENING, close};

use LightPlace::{AlongView, Overhead};
use PartitionScheme::{FacesSlicedWarped, Logarithmic, Sliced, SlicedWarped};

fn of_slices(scheme: PartitionScheme, place: LightPlace, slices: usize, depth_ratio: f64) -> f64 {
    closed_storage_factor(scheme, place, depth_ratio, slices as f64, OPENING).expect("sound")
}

fn logarithmic(place: LightPlace, depth_ratio: f64) -> f64 {
    of_slices(Logarithmic, place, 1, depth_ratio)
}

fn of_maps(scheme: PartitionScheme, place: LightPlace, maps: f64, depth_ratio: f64) -> Option<f64> {
    storage_factor_of_maps(scheme, place, depth_ratio, maps, OPENING)
}

/// Lloyd, table 3.2, equations 17 to 21.
#[test]
fn storage_by_slices() {
    const SLICES: [usize; 8] = [1, 2, 3, 4, 5, 6, 8, 16];
    for (scheme, place, depth_ratio, expected) in [
        (
            Sliced,
            Overhead,
            10.0,
            [77.94, 11.84, 6.462, 4.794, 4.014, 3.568, 3.081, 2.477],
        ),
        (
            Sliced,
            Overhead,
            100.0,
            [8574.0, 155.9, 43.91, 23.69, 16.44, 12.92, 9.589, 6.163],
        ),
        (
            Sliced,
            Overhead,
            1000.0,
            [8.652e5, 1677.0, 233.8, 90.06, 51.39, 35.53, 22.53, 11.52],
        ),
        (
            Sliced,
            Overhead,
            10000.0,
            [8.659e7, 1.715e4, 1150.0, 311.8, 145.1, 87.83, 47.37, 19.18],
        ),
        (
            SlicedWarped,
            Overhead,
            10.0,
            [7.794, 3.745, 2.999, 2.696, 2.533, 2.431, 2.311, 2.145],
        ),
        (
            SlicedWarped,
            Overhead,
            100.0,
            [85.74, 15.59, 9.461, 7.490, 6.547, 5.999, 5.392, 4.621],
        ),
        (
            FacesSlicedWarped,
            Overhead,
            1000.0,
            [865.2, 53.04, 23.38, 16.02, 12.91, 11.24, 9.501, 7.481],
        ),
        (
            FacesSlicedWarped,
            Overhead,
            10000.0,
            [8659.0, 171.5, 53.38, 31.18, 22.99, 18.92, 14.98, 10.78],
        ),
        (
            Sliced,
            AlongView,
            10.0,
            [100.0, 20.0, 13.92, 12.65, 12.56, 12.93, 14.23, 21.34],
        ),
        (
            Sliced,
            AlongView,
            100.0,
            [1.0e4, 200.0, 64.63, 40.0, 31.55, 27.85, 25.30, 28.45],
        ),
        (
            SlicedWarped,
            AlongView,
            1000.0,
            [1.0e6, 2000.0, 300.0, 126.5, 79.24, 60.0, 44.99, 37.94],
        ),
        (
            SlicedWarped,
            AlongView,
            10000.0,
            [1.0e8, 2.0e4, 1392.0, 400.0, 199.1, 129.3, 80.0, 50.6],
        ),
        (
            FacesSlicedWarped,
            AlongView,
            10.0,
            [19.0, 9.649, 7.927, 7.226, 6.849, 6.614, 6.336, 5.953],
        ),
        (
            FacesSlicedWarped,
            AlongView,
            100.0,
            [199.0, 37.0, 22.85, 18.30, 16.12, 14.85, 13.45, 11.67],
        ),
        (
            FacesSlicedWarped,
            AlongView,
            1000.0,
            [1999.0, 123.5, 55.0, 37.99, 30.81, 26.95, 22.94, 18.28],
        ),
        (
            FacesSlicedWarped,
            AlongView,
            10000.0,
            [19999.0, 397.0, 124.3, 73.0, 54.1, 44.7, 35.6, 25.9],
        ),
    ] {
        for (slices, expected) in SLICES.into_iter().zip(expected) {
            close(of_slices(scheme, place, slices, depth_ratio), expected, 1.1e-3);
        }
    }
}

/// Lloyd, table 3.3 (figure 12), in columns.
#[test]
fn storage_by_maps() {
    for (maps, row) in [
        (1.0, [8.652e5, 865.2, f64::NAN, 1.0e6, f64::NAN]),
        (4.0, [90.06, 16.02, 865.2, 126.5, 1999.0]),
        (5.0, [51.39, 12.91, 270.8, 79.24, 626.5]),
        (6.0, [35.53, 11.24, 128.6, 60.0, 298.0]),
        (10.0, [17.20, 8.619, 32.15, 39.81, 75.24]),
        (16.0, [11.52, 7.481, 16.02, 37.94, 37.99]),
        (24.0, [9.244, 6.932, 11.24, 42.68, 26.95]),
        (40.0, [7.761, 6.530, 8.619, 56.50, 20.91]),
    ] {
        let columns = [
            (Sliced, Overhead),
            (SlicedWarped, Overhead),
            (FacesSlicedWarped, Overhead),
            (Sliced, AlongView),
            (FacesSlicedWarped, AlongView),
        ];
        for ((scheme, place), expected) in columns.into_iter().zip(row) {
            match of_maps(scheme, place, maps, 1000.0) {
                Some(storage) => close(storage, expected, 1.0e-3),
                None => assert!(expected.is_nan(), "{scheme:?} with {maps} maps"),
            }
        }
    }
}

/// Lloyd, oracle 12 and table 3.5 (figure 10); appendix C.
#[test]
fn slices_converge_to_the_logarithmic_map() {
    let optimal = logarithmic(Overhead, 1000.0);
    close(optimal, 5.9823, 1.0e-4);
    for (slices, expected) in [(1, 144.6), (2, 8.87), (3, 3.91), (4, 2.677), (8, 1.588), (16, 1.251)] {
        close(
            of_slices(SlicedWarped, Overhead, slices, 1000.0) / optimal,
            expected,
            1.0e-3,
        );
    }
    let all: Vec<f64> = (1..=64).map(|k| of_slices(SlicedWarped, Overhead, k, 1000.0)).collect();
    assert!(all.is_sorted_by(|a, b| a > b));
    // 1 + ln α ÷ 2k.
    let many = of_slices(SlicedWarped, Overhead, 4096, 1000.0);
    close(many / optimal, 1.0 + 1000.0_f64.ln() / 8192.0, 1.0e-6);
    close(
        of_slices(Sliced, Overhead, 4, 1000.0) / of_slices(SlicedWarped, Overhead, 4, 1000.0),
        5.6234,
        1.0e-4,
    );
    let behind = logarithmic(AlongView, 1000.0);
    close(behind, 2.0 * 1000.0_f64.ln() + 1.0, 1.0e-12);
    close(of_slices(FacesSlicedWarped, AlongView, 100_000, 1000.0), behind, 1.0e-4);
}

/// Lloyd, table 3.4 (figure 13) and oracle 20.
#[test]
fn crossovers() {
    for (depth_ratio, expected) in [
        (5.0, 4.02),
        (10.0, 5.58),
        (20.0, 7.15),
        (50.0, 9.23),
        (100.0, 10.80),
        (200.0, 12.37),
        (500.0, 14.44),
        (1000.0, 16.02),
        (2000.0, 17.59),
        (5000.0, 19.67),
        (10000.0, 21.24),
        (100_000.0, 26.46),
    ] {
        let maps = crossover_maps(depth_ratio).expect("sound");
        assert!((maps - expected).abs() < 0.01, "{depth_ratio}: {maps}");
        assert!(
            (maps - (0.35 + 2.27 * depth_ratio.ln())).abs() < 0.05,
            "{depth_ratio}: {maps}"
        );
        let behind = |scheme, maps| of_maps(scheme, AlongView, maps, depth_ratio).expect("sound");
        assert!(behind(FacesSlicedWarped, maps * 1.01) < behind(Sliced, maps * 1.01));
    }
    // Where faces win with four maps already.
    assert_eq!(crossover_maps(4.0), Some(4.0));
    for depth_ratio in [10.0, 100.0, 1000.0, 10000.0] {
        // For all of them: with a = α^(1/j) it says 4 a < (a + 1) (a² + 1) = a³ + a² + a + 1, which is at least 4 a^1.5.
        for maps in (4..=400).step_by(4) {
            let overhead = |scheme| of_maps(scheme, Overhead, f64::from(maps), depth_ratio).expect("sound");
            assert!(
                overhead(Sliced) < overhead(FacesSlicedWarped),
                "ZP wins overhead with {maps} maps at {depth_ratio}"
            );
        }
    }
}

/// Lloyd, table 3.4: more slices than 2 ln α are worse from behind.
#[test]
fn the_best_number_of_slices_from_behind() {
    for (depth_ratio, best, storage) in [
        (10.0_f64, 5, 12.56),
        (100.0, 9, 25.04),
        (1000.0, 14, 37.56),
        (10000.0, 18, 50.09),
    ] {
        let found = (1..60)
            .min_by(|a, b| {
                let behind = |k| of_slices(Sliced, AlongView, k, depth_ratio);
                behind(*a).total_cmp(&behind(*b))
            })
            .expect("some");
        assert_eq!(found, best);
        close(of_slices(Sliced, AlongView, found, depth_ratio), storage, 1.0e-3);
        let real = best_slices_along_view(depth_ratio).expect("sound");
        assert!((real - found as f64).abs() < 1.0);
        let at_best = closed_storage_factor(Sliced, AlongView, depth_ratio, real, OPENING).expect("sound");
        close(at_best, 2.0 * E * depth_ratio.ln(), 1.0e-9);
    }
}

/// Lloyd, equations 22 and 23: how storage grows with the depth ratio.
#[test]
fn asymptotics() {
    let ratio = 1.0e40_f64;
    for maps in [4.0, 8.0] {
        let depth = of_maps(Sliced, Overhead, maps, ratio).expect("sound");
        close(depth * OPENING / (maps * ratio.powf(2.0 / maps)), 1.0, 1.0e-4);
        let faces = of_maps(FacesSlicedWarped, Overhead, maps, ratio).expect("sound");
        close(faces * OPENING / (0.25 * maps * ratio.powf(4.0 / maps)), 1.0, 1.0e-4);
    }
}

/// Closed forms are what slices add up to; behind too, with faces as under 45°.
#[test]
fn closed_forms_are_sums_over_slices() {
    for count in [1, 3, 7, 16] {
        let range = OverheadRange::new(0.5, 400.0, 0.9).expect("a range");
        for (scheme, warp) in [(Sliced, OverheadWarp::Uniform), (SlicedWarped, OverheadWarp::Lispsm)] {
            let slices = range.slices(&SplitScheme::Logarithmic, count, warp);
            let closed = closed_storage_factor(scheme, Overhead, 800.0, count as f64, 0.9);
            close(storage_factor(&slices), closed.expect("sound"), 1.0e-9);
        }
        let face = OverheadRange::side_face_from_behind(0.5, 400.0).expect("a range");
        let slices = face.slices(&SplitScheme::Logarithmic, count, OverheadWarp::Lispsm);
        let closed = closed_storage_factor(FacesSlicedWarped, AlongView, 800.0, count as f64, 0.9);
        close(4.0 * storage_factor(&slices) + 1.0, closed.expect("sound"), 1.0e-9);
    }
}

#[test]
fn numbers_without_sense() {
    for (maps, depth_ratio, opening) in [
        (0.0, 100.0, 1.0),
        (-1.0, 100.0, 1.0),
        (4.0, 1.0, 1.0),
        (4.0, f64::NAN, 1.0),
        (4.0, f64::INFINITY, 1.0),
        (4.0, 100.0, 0.0),
        (f64::NAN, 100.0, 1.0),
    ] {
        assert_eq!(
            closed_storage_factor(Sliced, Overhead, depth_ratio, maps, opening),
            None
        );
    }
    for ratio in [1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(crossover_maps(ratio), None);
        assert_eq!(best_slices_along_view(ratio), None);
        assert_eq!(closed_storage_factor(Logarithmic, Overhead, ratio, 1.0, 1.0), None);
    }
    assert_eq!(of_maps(FacesSlicedWarped, AlongView, 3.9, 100.0), None);
}
