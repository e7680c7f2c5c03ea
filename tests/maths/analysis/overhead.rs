//! Closed forms for the sun overhead.

use umbrage::maths::{
    analysis::overhead::{OverheadRange, OverheadWarp, equal_maps_storage_factor, errors_along_view, storage_factor},
    error::{error_across, error_along, largest_errors},
    split::SplitScheme,
    view::ViewError,
    warp::{Warp, WarpSpan},
};

use crate::support::{OPENING, close, frustum_samples, papers_camera};

pub(crate) fn range(near: f64, far: f64) -> OverheadRange {
    OverheadRange::new(near, far, OPENING).expect("a proper range")
}

/// Lloyd, table 3.1 and oracle 6: single maps.
#[test]
fn single_maps() {
    for (far, uniform, lispsm, psm, logarithmic) in [
        (
            10.0,
            (10.0, 7.794, 77.94),
            (3.1623, 2.4648, 7.794),
            (1.0, 7.794, 7.794),
            1.9941,
        ),
        (
            100.0,
            (100.0, 85.74, 8573.65),
            (10.0, 8.5737, 85.737),
            (1.0, 85.74, 85.737),
            3.9882,
        ),
        (
            1000.0,
            (1000.0, 865.16, 865_159.4),
            (31.6228, 27.3587, 865.159),
            (1.0, 865.16, 865.159),
            5.9823,
        ),
        (
            10000.0,
            (10000.0, 8659.4, 8.65939e7),
            (100.0, 86.594, 8659.388),
            (1.0, 8659.4, 8659.388),
            7.9764,
        ),
    ] {
        let range = range(1.0, far);
        for (warp, (across, along, storage)) in [
            (OverheadWarp::Uniform, uniform),
            (OverheadWarp::Lispsm, lispsm),
            (OverheadWarp::Psm, psm),
        ] {
            let largest = range.largest_errors(range.warp_near(warp));
            close(largest.across, across, 1.0e-4);
            close(largest.along, along, 1.0e-4);
            close(largest.storage_factor(), storage, 1.0e-4);
            // The balanced error of a map with as many texels as the picture has pixels.
            close(largest.balanced_error(1.0, 1.0), storage.sqrt(), 1.0e-4);
        }
        close(range.logarithmic_error_along(), logarithmic, 1.0e-4);
    }
}

/// Lloyd, oracle 5; Stingl, oracle 7: the closed forms are those of the vertices; S̄ has a flat valley.
#[test]
fn closed_forms_are_the_vertices() {
    let (near, far) = (1.0, 100.0);
    let range = range(near, far);
    let (samples, _) = frustum_samples(&papers_camera(near, far), 90.0);
    let smallest = (far - 1.0) / OPENING;
    for warp_near in [0.3, 0.7, 1.0, 2.0, 7.0, 11.0, 11.1, 30.0, 1.0e4, f64::INFINITY] {
        let (closed, numeric) = (
            range.largest_errors(warp_near),
            largest_errors(&samples, warp_near, OPENING),
        );
        close(closed.along, numeric.along, 1.0e-9);
        close(closed.across, numeric.across, 1.0e-9);
        let ends = [near, far].map(|depth| range.errors(warp_near, depth).expect("inside"));
        close(ends[0].across.max(ends[1].across), closed.across, 1.0e-9);
        close(ends[0].along.max(ends[1].along), closed.along, 1.0e-9);
        let storage = closed.storage_factor();
        if (1.0..=11.0).contains(&warp_near) {
            close(storage, smallest, 1.0e-9);
        } else {
            assert!(storage > smallest * 1.0001, "n' = {warp_near}: {storage}");
        }
    }
    let uniform = range.largest_errors(f64::INFINITY).storage_factor();
    close(uniform / smallest, 100.0, 1.0e-9);
}

/// Lloyd, oracles 3, 4 and 8, misprints of section 2.4 included: ends, minimum, width at the far end.
#[test]
fn shapes_along_the_view() {
    for (far, lowest_share) in [(20.0, 0.5974), (100.0, 0.3306)] {
        let range = range(1.0, far);
        let optimal = range.warp_near(OverheadWarp::Lispsm);
        let along = |depth| range.errors(optimal, depth).expect("inside").along;
        close(along(1.0), along(far), 1.0e-9);
        let lowest = along(optimal - 1.0);
        close(lowest / along(1.0), lowest_share, 1.0e-3);
        assert!(lowest < along(optimal - 1.01) && lowest < along(optimal - 0.99));
        for warp_near in [1.0, 5.0, optimal, 1.0e3, f64::INFINITY] {
            close(range.errors(warp_near, far).expect("inside").across, 1.0, 1.0e-9);
        }
        close(range.largest_errors(optimal).across, far.sqrt(), 1.0e-9);
        assert_eq!(range.errors(optimal, 0.99), None);
        assert_eq!(range.errors(optimal, far + 0.1), None);
    }
}

/// Lloyd, oracle 24 and the examples of table 3.7: trapezoidal maps.
#[test]
fn trapezoidal_maps() {
    let range = range(1.0, 100.0);
    for (offset, expected, is_minimal) in [(5.0, 1.334, true), (20.0, 6.689, true), (50.0, 33.90, false)] {
        let warp_near = range.warp_near(OverheadWarp::Trapezoidal { focus: 1.0 + offset });
        close(warp_near, expected, 1.0e-3);
        // t(z) of Lloyd, equation 6.
        let far_width = warp_near + 99.0;
        close(far_width * offset / ((warp_near + offset) * 99.0), 0.8, 1.0e-9);
        let storage = range.largest_errors(warp_near).storage_factor();
        if is_minimal {
            close(storage, 85.737, 1.0e-4);
        } else {
            assert!(storage > 85.74 * 2.0, "{storage}");
        }
    }
    for focus in [0.5, 1.0, 80.2, 99.0, f64::NAN] {
        let warp_near = range.warp_near(OverheadWarp::Trapezoidal { focus });
        assert_eq!(warp_near, f64::INFINITY, "focus at {focus}");
    }
}

/// Lloyd, oracle 9: aspect of the critical resolution; oracle 10: the split of a budget; the example of table 3.11.
#[test]
fn critical_and_balanced_resolutions() {
    for far in [10.0, 1000.0] {
        let range = range(1.0, far);
        let stretch = (far - 1.0) / OPENING;
        for (warp, aspect) in [
            (OverheadWarp::Uniform, far / stretch),
            (OverheadWarp::Lispsm, far / stretch),
            (OverheadWarp::Psm, 1.0 / stretch),
        ] {
            let largest = range.largest_errors(range.warp_near(warp));
            let critical = largest.critical_resolution(1024.0);
            close(critical.x / critical.y, aspect, 1.0e-9);
            close(
                critical.element_product(),
                1024.0 * 1024.0 * largest.storage_factor(),
                1.0e-9,
            );

            let texels = 2048.0 * 2048.0;
            let sides = largest.balanced_resolution(texels);
            close(sides.element_product(), texels, 1.0e-9);
            let error = largest.balanced_error(texels, 1024.0 * 1024.0);
            close(largest.across * 1024.0 / sides.x, error, 1.0e-9);
            close(largest.along * 1024.0 / sides.y, error, 1.0e-9);
        }
    }
    let slices = range(1.0, 1000.0).slices(&SplitScheme::Logarithmic, 4, OverheadWarp::Lispsm);
    for slice in &slices {
        let critical = slice.range.largest_errors(slice.warp_near).critical_resolution(1024.0);
        assert!(
            (critical.x - 2428.0).abs() < 1.0 && (critical.y - 1729.0).abs() < 1.0,
            "{critical}"
        );
    }
    close(storage_factor(&slices), 16.016, 1.0e-4);
    // Pictures of Lloyd, figure 1: 800², one map of 2048² and 4096².
    let errors = range(1.0, 1000.0).largest_errors(32.6228);
    let [small, large] = [2048.0_f64, 4096.0].map(|side| errors.balanced_error(side * side, 800.0 * 800.0));
    close(small / large, 2.0, 1.0e-9);
    close(small, (865.159 / 6.5536_f64).sqrt(), 1.0e-4);
}

/// Lloyd, appendix C and oracle 2: the logarithmic map has one error at all depths, that of its closed form, and √(n f) in
/// its middle as a `LiSPSM` map has; no warp comes near its storage.
#[test]
fn the_logarithmic_map() {
    let range = range(0.5, 400.0);
    let place = |depth: f64| range.logarithmic_place(depth);
    assert_eq!((place(0.5), place(400.0)), (0.0, 1.0));
    close(place(200.0_f64.sqrt()), 0.5, 1.0e-12);
    for depth in [0.6, 2.0, 14.0, 300.0] {
        let step = depth * 1.0e-5;
        let depth_per_map = 2.0 * step / (place(depth + step) - place(depth - step));
        close(
            depth_per_map / (OPENING * depth),
            range.logarithmic_error_along(),
            1.0e-8,
        );
    }
    for eta in [-1.0, -0.3, 0.0, 0.4, 1.0] {
        let warped = range.largest_errors(range.warp_near(OverheadWarp::Strength { eta }));
        let storage = warped.storage_factor() / range.logarithmic_error_along();
        assert!(storage > 100.0, "{eta}: {storage} times as many texels");
    }
}

/// Lloyd, oracle 18: how much of the map the frustum covers.
#[test]
fn covered_shares_of_the_map() {
    let range = range(1.0, 100.0);
    close(range.used_share(range.warp_near(OverheadWarp::Lispsm)), 0.55, 1.0e-9);
    close(range.used_share(range.warp_near(OverheadWarp::Psm)), 1.0, 1.0e-9);
    close(range.used_share(f64::INFINITY), 0.505, 1.0e-9);
}

/// Lloyd, table 3.6, with the constants of the frustum: the published curves of figure 5.
#[test]
fn warps_by_their_parameter() {
    let range = OverheadRange::new(1.0, 20.0, 19.0).expect("a proper range");
    let lispsm = 1.0 + 20.0_f64.sqrt();
    for (warp, warp_near, depth, across, along) in [
        (OverheadWarp::Uniform, f64::INFINITY, 2.0, 0.5, 0.5),
        (OverheadWarp::Near(10.0), 10.0, 10.0, 0.0655, 0.1245),
        (OverheadWarp::Lispsm, lispsm, 10.0, 0.0591, 0.1564),
        (OverheadWarp::Strength { eta: 0.0 }, lispsm, 4.472, 0.0817, 0.1336),
        (OverheadWarp::Near(2.0), 2.0, 20.0, 0.05, 0.525),
        (OverheadWarp::Psm, 1.0, 4.472, 0.05, 0.2236),
        (OverheadWarp::Strength { eta: 1.0 }, 1.0, 10.0, 0.05, 0.5),
    ] {
        let actual = range.warp_near(warp);
        if warp_near.is_finite() {
            close(actual, warp_near, 1.0e-9);
        } else {
            assert_eq!(actual, warp_near);
        }
        let errors = range.errors(actual, depth).expect("inside");
        close(errors.across / 20.0, across, 2.0e-3);
        close(errors.along, along, 2.0e-3);
    }
    let same = range.warp_near(OverheadWarp::Strength {
        eta: Warp::Lispsm.eta(),
    });
    close(same, range.span().optimal_warp_near(), 1.0e-12);
}

/// Stingl, oracle 15; Scherzer, table 3.3 (oracle 7): levelled at pseudo planes.
#[test]
fn pseudo_planes() {
    let whole = range(1.0, 300.0);
    let warp = OverheadWarp::PseudoPlanes { near: 31.0, far: 270.0 };
    let warp_near = whole.warp_near(warp);
    close(warp_near, 92.4877, 1.0e-5);
    for (depth, along) in [(31.0, 3.4612), (270.0, 3.4612), (1.0, 61.17), (300.0, 3.6535)] {
        close(whole.errors(warp_near, depth).expect("inside").along, along, 1.0e-4);
    }
    let off = OverheadWarp::PseudoPlanes { near: 0.0, far: 1.0e9 };
    assert_eq!(whole.warp_near(off), whole.warp_near(OverheadWarp::Lispsm));

    let range = range(0.1, 70.0);
    for (visible, warp_near, across, along, at_end) in [
        (70.0, 2.7458, 26.458, 22.880, 22.880),
        (50.0, 2.3361, 22.638, 19.577, 26.741),
        (30.0, 1.8321, 17.878, 15.461, 33.860),
        (20.0, 1.5142, 14.842, 12.835, 40.786),
        (10.0, 1.1, 10.845, 9.379, 55.818),
        (5.0, 0.8071, 7.990, 6.910, 75.760),
    ] {
        let actual = range.warp_near(OverheadWarp::PseudoPlanes {
            near: 0.1,
            far: visible,
        });
        close(actual, warp_near, 1.0e-4);
        let errors = |depth| range.errors(actual, depth).expect("inside");
        close(errors(0.1).across, across, 1.0e-4);
        close(errors(0.1).along, along, 1.0e-4);
        close(errors(visible).along, along, 1.0e-4);
        close(errors(70.0).along, at_end, 1.0e-4);
        // Error only moves: the storage factor stays.
        close(range.largest_errors(actual).storage_factor(), 605.352, 1.0e-5);
    }
}

/// Stingl, equation 4.1: the splits lie between the pseudo planes, the ends stay; only the end slices are warped for them.
#[test]
fn pseudo_planes_of_slices() {
    let whole = range(1.0, 500.0);
    let warp = OverheadWarp::PseudoPlanes { near: 10.0, far: 400.0 };
    let slices = whole.slices(&SplitScheme::Practical { lambda: 0.5 }, 4, warp);
    let ends: Vec<f64> = slices.iter().map(|slice| slice.range.far()).collect();
    let expected = |index: f64| 0.5 * (10.0 + 390.0 * index / 4.0) + 0.5 * 10.0 * 40.0_f64.powf(index / 4.0);
    for (index, end) in ends[..3].iter().enumerate() {
        close(*end, expected(index as f64 + 1.0), 1.0e-12);
    }
    assert_eq!((slices[0].range.near(), ends[3]), (1.0, 500.0));
    for slice in &slices[1..3] {
        assert_eq!(slice.warp_near, slice.range.warp_near(OverheadWarp::Lispsm));
    }
    close(slices[0].warp_near, 1.0 + (10.0 * ends[0]).sqrt(), 1.0e-12);
    close(slices[3].warp_near, ends[2] + (ends[2] * 400.0).sqrt(), 1.0e-12);
    let crossed = OverheadWarp::PseudoPlanes { near: 400.0, far: 10.0 };
    assert_eq!(whole.slices(&SplitScheme::Logarithmic, 2, crossed).len(), 2);
}

/// Scherzer, table 3.1: the paper's own parameters, 512 pixels and 2048 texels per side.
#[test]
fn the_picture_of_2005() {
    let range = range(0.1, 70.0);
    for (warp, storage, across, along, balanced) in [
        (OverheadWarp::Uniform, 423_746.0, 175.0, 151.3, 162.7),
        (OverheadWarp::Lispsm, 605.35, 6.614, 5.720, 6.151),
        (OverheadWarp::Psm, 605.35, 0.25, 151.3, 6.151),
    ] {
        let warp_near = range.warp_near(warp);
        let largest = range.largest_errors(warp_near);
        close(largest.storage_factor(), storage, 1.0e-4);
        close(largest.across * 0.25, across, 1.0e-3);
        close(largest.along * 0.25, along, 1.0e-3);
        close(largest.balanced_error(2048.0 * 2048.0, 512.0 * 512.0), balanced, 1.0e-3);
    }
    close(range.warp_near(OverheadWarp::Lispsm), 2.745751, 1.0e-6);
    close(range.logarithmic_error_along(), 5.673, 1.0e-3);
    // Table 3.4: C_P lies √(n f) behind the eye; the warp frustum's ends differ by √α.
    let warp_near = range.warp_near(OverheadWarp::Lispsm);
    close(warp_near - 0.1, 2.6458, 1.0e-4);
    close((warp_near + 69.9) / warp_near, 26.458, 1.0e-4);
}

/// Scherzer, table 3.2, the column of the derived rule.
#[test]
fn optimal_parameters_for_tilted_light() {
    for (degrees, expected) in [
        (90.0_f64, 2.7458),
        (60.0, 2.9588),
        (45.0, 3.2887),
        (30.0, 3.9443),
        (20.0, 4.8226),
        (10.0, 6.9465),
        (5.0, 10.176),
        (1.0, 26.547),
        (0.1, 142.66),
    ] {
        let span = WarpSpan::directional(69.9, 0.1, degrees.to_radians().sin());
        close(span.optimal_warp_near(), expected, 1.0e-4);
    }
}

/// Stingl, oracle 12 and the tables of section 3.3: uniform maps in slices.
#[test]
fn slices_without_warp() {
    let range = range(1.0, 500.0);
    for (lambda, ends) in [
        (0.5, [136.43, 65.24, 32.77, 16.83]),
        (1.0, [22.36, 4.729, 2.175, 1.475]),
        (0.0, [250.5, 125.75, 63.375, 32.1875]),
    ] {
        for (count, end) in [2, 4, 8, 16].into_iter().zip(ends) {
            let slices = range.slices(&SplitScheme::Practical { lambda }, count, OverheadWarp::Uniform);
            let errors = errors_along_view(&slices, 1.0).expect("inside");
            close(errors.across, end, 5.0e-4);
            close(errors.along, (errors.across - 1.0) / OPENING, 1.0e-9);
        }
    }
    let slices = range.slices(&SplitScheme::Practical { lambda: 0.5 }, 2, OverheadWarp::Uniform);
    close(errors_along_view(&slices, 1.0).expect("inside").along, 117.29, 1.0e-4);
}

/// Stingl, figure 3.18 in section 3.3: warped slices.
#[test]
fn slices_with_warp() {
    let range = range(1.0, 500.0);
    let practical = range.slices(&SplitScheme::Practical { lambda: 0.5 }, 4, OverheadWarp::Lispsm);
    close(practical[0].warp_near, 9.077, 1.0e-4);
    for (index, across, along) in [
        (0, 8.077, 6.888),
        (1, 1.446, 0.6535),
        (2, 1.3277, 0.4975),
        (3, 1.442, 0.648),
    ] {
        let slice = practical[index];
        let largest = slice.range.largest_errors(slice.warp_near);
        close(largest.across, across, 1.0e-3);
        // The second slice is given as 0.6535 and as 0.632.
        assert!((largest.along / along - 1.0).abs() < 0.04, "{index}: {largest:?}");
    }
    let first = practical[0]
        .range
        .errors(practical[0].warp_near, 65.2394_f64.sqrt())
        .expect("inside");
    close(first.along, 2.701, 1.0e-3);

    let logarithmic = range.slices(&SplitScheme::Logarithmic, 4, OverheadWarp::Lispsm);
    for slice in &logarithmic {
        let largest = slice.range.largest_errors(slice.warp_near);
        close(largest.across, 2.1746, 1.0e-4);
        close(largest.along, 1.4850, 1.0e-4);
        let middle = (slice.range.near() * slice.range.far()).sqrt();
        close(
            slice.range.errors(slice.warp_near, middle).expect("inside").along,
            1.2817,
            1.0e-4,
        );
    }
    // Self-similar slices: both storage factors agree; others need more with maps of one size.
    close(
        storage_factor(&logarithmic),
        equal_maps_storage_factor(&logarithmic),
        1.0e-9,
    );
    assert!(equal_maps_storage_factor(&practical) > storage_factor(&practical) * 2.0);
}

/// Lloyd, oracle 19 and table 3.11: jumps at seams.
#[test]
fn seams_of_slices() {
    for (far, count, jump_across, jump_along) in [
        (100.0_f64, 2, 3.162, 10.0),
        (100.0, 4, 1.778, 3.162),
        (1000.0, 2, 5.623, 31.62),
        (1000.0, 4, 2.371, 5.623),
        (10000.0, 4, 3.162, 10.0),
    ] {
        let jumps = |warp| {
            let slices = range(1.0, far).slices(&SplitScheme::Logarithmic, count, warp);
            let seam = slices[0].range.far();
            let before = slices[0].range.errors(slices[0].warp_near, seam).expect("inside");
            let after = errors_along_view(&slices, seam).expect("inside");
            (after.across / before.across, after.along / before.along)
        };
        let (across, along) = jumps(OverheadWarp::Lispsm);
        close(across, jump_across, 1.0e-3);
        close(along, 1.0, 1.0e-9);
        let (across, along) = jumps(OverheadWarp::Psm);
        close(across, 1.0, 1.0e-9);
        close(along, 1.0 / jump_along, 1.0e-3);
    }
}

/// Every depth of the range has one slice, seams and both ends included (Lloyd, oracle 21).
#[test]
fn slices_cover_the_range_once() {
    let range = range(1.0, 1000.0);
    let slices = range.slices(&SplitScheme::Logarithmic, 4, OverheadWarp::Uniform);
    for depth in [1.0, 5.6234, 31.7, 1000.0] {
        let errors = errors_along_view(&slices, depth).expect("inside");
        assert!(errors.across >= 1.0 - 1.0e-9, "{depth}");
    }
    // At a seam the slice behind it serves.
    let seam = slices[1].range.far();
    close(
        errors_along_view(&slices, seam).expect("inside").across,
        1000.0_f64.powf(0.25),
        1.0e-9,
    );
    assert_eq!(errors_along_view(&slices, 0.999), None);
    assert_eq!(errors_along_view(&slices, 1000.001), None);
    assert_eq!(errors_along_view(&slices, f64::NAN), None);
    assert_eq!(errors_along_view(&[], 1.0), None);
}

#[test]
fn ranges_without_sense() {
    for (near, far, opening, error) in [
        (f64::NAN, 10.0, 1.0, ViewError::NotFinite),
        (1.0, f64::INFINITY, 1.0, ViewError::NotFinite),
        (0.0, 10.0, 1.0, ViewError::NoRange),
        (5.0, 5.0, 1.0, ViewError::NoRange),
        (1.0, 10.0, 0.0, ViewError::NoArea),
    ] {
        assert_eq!(OverheadRange::new(near, far, opening), Err(error));
    }
    let range = OverheadRange::of_view(&papers_camera(1.0, 40.0)).expect("a proper camera");
    close(range.depth_ratio(), 40.0, 1.0e-12);
    for warp in [
        OverheadWarp::Near(-3.0),
        OverheadWarp::Near(f64::NAN),
        OverheadWarp::Strength { eta: f64::NAN },
    ] {
        assert_eq!(range.warp_near(warp), f64::INFINITY, "{warp:?}");
    }
    close(error_across(1.0, f64::INFINITY, 1.0, 40.0), 40.0, 1.0e-12);
    close(error_along(1.0, f64::INFINITY, 1.0, 40.0, OPENING), 33.77499, 1.0e-6);
}
