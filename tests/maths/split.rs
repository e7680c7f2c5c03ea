//! Split distances against the thesis' numbers.

use bevy_math::DVec3;
use umbrage::maths::{
    body::{adjusted_depths, light_visible},
    bounds::Bounds,
    error::{error_across, error_along},
    split::{PseudoPlanes, SplitScheme, VISIBLE_MARGIN, VisibleDepths, pseudo_split_depths, split_depths},
    view::ViewVolume,
    warp::Warp,
};

use crate::support::{OPENING, close, errors, fit, papers_camera, roomy_scene};

#[track_caller]
fn assert_depths(actual: &[f64], expected: &[f64]) {
    assert_eq!(actual.len(), expected.len(), "{actual:?}");
    for (actual, expected) in actual.iter().zip(expected) {
        close(*actual, *expected, 1.0e-4);
    }
}

/// Stingl, oracle 11.
#[test]
fn the_practical_scheme_has_the_published_distances() {
    let practical = SplitScheme::Practical { lambda: 0.5 };
    assert_depths(
        &split_depths(&practical, 1.0, 500.0, 4),
        &[1.0, 65.2394, 136.4303, 240.4936, 500.0],
    );
    assert_depths(
        &split_depths(&practical, 1.0, 100.0, 4),
        &[1.0, 14.4561, 30.25, 53.4364, 100.0],
    );
}

/// Lloyd, section 3.11.
#[test]
fn logarithmic_splits_have_equal_ratios() {
    let logarithmic = SplitScheme::Logarithmic;
    assert_depths(
        &split_depths(&logarithmic, 1.0, 1000.0, 4),
        &[1.0, 5.6234, 31.623, 177.83, 1000.0],
    );
    assert_depths(
        &split_depths(&logarithmic, 1.0, 100.0, 4),
        &[1.0, 3.1623, 10.0, 31.623, 100.0],
    );
}

#[test]
fn the_practical_scheme_spans_uniform_to_logarithmic() {
    for (lambda, scheme) in [(0.0, SplitScheme::Uniform), (1.0, SplitScheme::Logarithmic)] {
        let practical = split_depths(&SplitScheme::Practical { lambda }, 0.3, 70.0, 7);
        assert_depths(&practical, &split_depths(&scheme, 0.3, 70.0, 7));
    }
}

/// Stingl, equations 3.6 and 3.7, figures 3.12 and 3.15: the first distance, m_x at the near plane, of both pure schemes.
#[test]
fn uniform_and_logarithmic_splits_have_the_published_distances() {
    for (count, uniform, logarithmic) in [
        (2, 250.5, 22.3607),
        (4, 125.75, 4.7287),
        (8, 63.375, 2.1746),
        (16, 32.1875, 1.4746),
    ] {
        let first = |scheme| split_depths(&scheme, 1.0, 500.0, count)[1];
        close(first(SplitScheme::Uniform), uniform, 1.0e-9);
        close(first(SplitScheme::Logarithmic), logarithmic, 1.0e-4);
    }
    assert_depths(
        &split_depths(&SplitScheme::Uniform, 1.0, 500.0, 4),
        &[1.0, 125.75, 250.5, 375.25, 500.0],
    );
}

/// Stingl, oracle 12 and figure 3.15 through the matrices: every slice is focused on itself. Were it on the whole view,
/// m_x would be 500 ÷ z in all of them.
#[test]
fn slices_are_focused_on_themselves() {
    let view = papers_camera(1.0, 500.0);
    let practical = SplitScheme::Practical { lambda: 0.5 };
    for (count, across, along) in [
        (2, 136.43, 117.29),
        (4, 65.24, 55.63),
        (8, 32.77, 27.52),
        (16, 16.83, 13.71),
    ] {
        let depths = split_depths(&practical, 1.0, 500.0, count);
        for (index, range) in depths.windows(2).enumerate() {
            let slice = view.split(range[0], range[1]);
            let fit = fit(&slice, &roomy_scene(), DVec3::NEG_Y, Warp::Uniform);
            let at = |depth: f64| errors(&fit, &view, DVec3::NEG_Z * depth);
            close(at(range[0]).x, range[1] / range[0], 1.0e-4);
            close(at(range[1]).x, 1.0, 1.0e-4);
            close(at(range[0]).y, (range[1] - range[0]) / (OPENING * range[0]), 1.0e-4);
            if index == 0 {
                close(at(1.0).x, across, 1.0e-3);
                close(at(1.0).y, along, 1.0e-3);
            }
        }
    }
}

/// Stingl, section 3.4: one strength for all logarithmic slices is a warp that follows the split scheme.
#[test]
fn one_strength_follows_the_split_scheme() {
    let view = papers_camera(1.0, 500.0);
    let depths = split_depths(&SplitScheme::Logarithmic, 1.0, 500.0, 4);
    for eta in [-0.5, 0.0, 0.4] {
        let warp_near = |range: &[f64]| {
            let slice = view.split(range[0], range[1]);
            fit(&slice, &roomy_scene(), DVec3::NEG_Y, Warp::Free { eta }).warp_near
        };
        let first = warp_near(&depths[..2]);
        for range in depths.windows(2) {
            close(warp_near(range), first * range[0] / depths[0], 1.0e-6);
        }
    }
}

/// Stingl, oracle 12: m_x at the near plane of a uniform map per split is C_1 ÷ n; it halves per doubling.
#[test]
fn the_error_of_unwarped_splits_halves_per_doubling() {
    let practical = SplitScheme::Practical { lambda: 0.5 };
    for (count, error) in [(2, 136.43), (4, 65.24), (8, 32.77), (16, 16.83)] {
        close(split_depths(&practical, 1.0, 500.0, count)[1], error, 1.0e-3);
    }
}

#[test]
fn manual_distances_are_clamped_sorted_and_kept_apart() {
    let manual = |inner: &[f32], count| split_depths(&SplitScheme::Manual(inner.to_vec()), 1.0, 100.0, count);
    assert_depths(&manual(&[30.0, 10.0], 3), &[1.0, 10.0, 30.0, 100.0]);
    assert_depths(&manual(&[10.0, 30.0, 50.0, 70.0], 3), &[1.0, 10.0, 30.0, 100.0]);
    assert_depths(&manual(&[10.0], 3), &[1.0, 10.0, 55.0, 100.0]);
    assert_depths(&manual(&[], 2), &[1.0, 50.5, 100.0]);
    let clamped = manual(&[-5.0, f32::NAN, 0.5, 200.0, f32::INFINITY], 5);
    assert_eq!(clamped.len(), 6);
    assert!(clamped.is_sorted_by(|a, b| a < b), "{clamped:?}");
    assert!(clamped[2] < 1.1 && clamped[3] > 99.9, "{clamped:?}");
}

#[test]
fn counts_and_ranges_out_of_bounds() {
    let uniform = SplitScheme::Uniform;
    assert_eq!(split_depths(&uniform, 1.0, 2.0, 0).len(), 2);
    assert_eq!(split_depths(&uniform, 1.0, 2.0, 100).len(), 17);
    assert!(split_depths(&uniform, 2.0, 2.0, 3).is_empty());
    assert!(split_depths(&uniform, f64::NAN, 2.0, 3).is_empty());
    assert!(split_depths(&uniform, 1.0, f64::INFINITY, 3).is_empty());
    assert_depths(
        &split_depths(&SplitScheme::Logarithmic, -1.0, 3.0, 2),
        &[-1.0, 1.0, 3.0],
    );
}

/// Lloyd, equations 15 and 16 and oracle 11: self-similar splits are the logarithmic ones.
#[test]
fn self_similar_splits_are_logarithmic() {
    let (near, far, count) = (0.3, 700.0, 6);
    let depths = split_depths(&SplitScheme::Logarithmic, near, far, count);
    for index in 1..=count {
        let exponent = (index as f64 - 1.0) / count as f64;
        close(depths[index - 1], near * (far / near).powf(exponent), 1.0e-12);
        close(
            depths[index] / depths[index - 1],
            (far / near).powf(1.0 / count as f64),
            1.0e-12,
        );
    }
}

/// Lloyd, oracle 12, and Stingl, oracle 14: k (α^(1/k) − 1) falls towards ln α; the storage of unwarped logarithmic
/// splits is α^(1/k) times as large and ends there too.
#[test]
fn storage_of_logarithmic_splits_converges_to_the_optimum() {
    let ratio = 1000.0_f64;
    let sum = |count: usize| {
        let depths = split_depths(&SplitScheme::Logarithmic, 1.0, ratio, count);
        depths.windows(2).map(|range| range[1] / range[0] - 1.0).sum::<f64>()
    };
    let sums: Vec<f64> = (1..=16).map(sum).collect();
    assert!(sums.is_sorted_by(|a, b| a > b) && sums[15] > ratio.ln(), "{sums:?}");
    close(sums[3] / ratio.ln(), 2.677, 1.0e-3);
    close(sums[15] / ratio.ln(), 1.251, 1.0e-3);
    let many = 100_000.0;
    close(many * (500.0_f64.powf(1.0 / many) - 1.0) / OPENING, 5.382, 1.0e-3);
}

/// Stingl, oracle 13: with n_opt all logarithmic splits have the same error, (r − 1) ÷ (2 tan Θ √r) at the ends of the
/// warp axis and √r across it.
#[test]
fn warped_logarithmic_splits_are_equal() {
    let depths = split_depths(&SplitScheme::Logarithmic, 1.0, 500.0, 4);
    for range in depths.windows(2) {
        let (near, far) = (range[0], range[1]);
        let warp_near = near + (near * far).sqrt();
        close(error_across(near, warp_near, near, far), 2.1746, 1.0e-4);
        for end in [near, far] {
            close(error_along(end, warp_near, near, far, OPENING), 1.4850, 1.0e-4);
        }
    }
}

/// Stingl, equation 4.1: the inner distances are those of the scheme on the pseudo planes, the outer ones stay.
#[test]
fn pseudo_planes_move_inner_distances_only() {
    let (near, far) = (1.0, 300.0);
    let pseudo = PseudoPlanes { near: 30.0, far: 270.0 };
    for lambda in [0.0_f32, 0.5, 1.0] {
        let depths = pseudo_split_depths(&SplitScheme::Practical { lambda }, near, far, pseudo, 4);
        assert_eq!((depths[0], depths[4]), (near, far));
        for (index, depth) in depths.iter().enumerate().take(4).skip(1) {
            let share = index as f64 / 4.0;
            let lambda = f64::from(lambda);
            let expected = (1.0 - lambda) * (30.0 + 240.0 * share) + lambda * 30.0 * 9.0_f64.powf(share);
            close(*depth, expected, 1.0e-9);
        }
        assert!(depths.is_sorted_by(|a, b| a < b), "{depths:?}");
    }
}

#[test]
fn pseudo_planes_that_say_nothing() {
    let scheme = SplitScheme::Practical { lambda: 0.5 };
    let plain = split_depths(&scheme, 1.0, 300.0, 5);
    for (near, far) in [
        (0.0, 1000.0),
        (f64::NAN, f64::NAN),
        (200.0, 100.0),
        (500.0, 600.0),
        (0.2, 0.5),
        (1.0, 300.0),
    ] {
        assert_eq!(
            pseudo_split_depths(&scheme, 1.0, 300.0, PseudoPlanes { near, far }, 5),
            plain,
            "{near} {far}"
        );
    }
    let manual = SplitScheme::Manual(vec![7.0]);
    let planes = PseudoPlanes { near: 30.0, far: 200.0 };
    assert_depths(&pseudo_split_depths(&manual, 1.0, 300.0, planes, 2), &[1.0, 7.0, 300.0]);
    assert_depths(&pseudo_split_depths(&scheme, 1.0, 300.0, planes, 1), &[1.0, 300.0]);
    assert!(pseudo_split_depths(&scheme, f64::NAN, 300.0, planes, 2).is_empty());
    assert!(pseudo_split_depths(&scheme, 300.0, 1.0, planes, 2).is_empty());
}

/// Stingl, section 4.2: shares of 0 are the planes themselves (oracle 29 shows them so).
#[test]
fn pseudo_planes_from_shares() {
    let planes = |near_share, far_share| PseudoPlanes::from_shares(1.0, 301.0, near_share, far_share);
    assert_eq!(planes(0.0, 0.0), PseudoPlanes { near: 1.0, far: 301.0 });
    assert_eq!(planes(0.1, 0.2), PseudoPlanes { near: 31.0, far: 241.0 });
    assert_eq!(planes(-1.0, f64::NAN), planes(0.0, 0.0));
    assert_eq!(planes(2.0, 2.0), PseudoPlanes { near: 301.0, far: 1.0 });
}

#[test]
fn visible_depths_shorten_the_range_with_a_margin() {
    let shown = VisibleDepths {
        nearest: 100.0,
        farthest: 600.0,
    };
    assert_eq!(shown.range(0.1, 1000.0, 0.0), (100.0, 600.0));
    let (near, far) = shown.range(0.1, 1000.0, VISIBLE_MARGIN);
    close(near, 90.0, 1.0e-12);
    close(far, 660.0, 1.0e-12);
    assert_eq!(shown.range(0.1, 620.0, VISIBLE_MARGIN).1, 620.0);
    assert_eq!(shown.range(95.0, 1000.0, VISIBLE_MARGIN).0, 95.0);
    assert_eq!(shown.range(0.1, 1000.0, 7.0), (0.1, 1000.0));
}

#[test]
fn visible_depths_that_say_nothing() {
    let all = (0.1, 1000.0);
    for (nearest, farthest, margin) in [
        (f64::NAN, 5.0, 0.1),
        (5.0, f64::NAN, 0.1),
        (f64::INFINITY, f64::NEG_INFINITY, 0.1),
        (2000.0, 3000.0, 0.1),
        (0.01, 0.02, 0.1),
        (6.0, 5.0, 0.1),
        (5.0, 6.0, f64::NAN),
        (5.0, 6.0, -0.5),
        (5.0, 5.0, 0.0),
    ] {
        assert_eq!(
            VisibleDepths { nearest, farthest }.range(all.0, all.1, margin),
            all,
            "{nearest} {farthest} {margin}"
        );
    }
}

/// A view over a city from 120 m above its roofs. The scene's box begins at the eye, since one tower reaches up there, so
/// the adjusted near plane does not help; what the picture has shown does. With it four splits beat one map fitted to
/// the visible depths; without it three of four splits are empty and the fourth is no better than that one map.
#[test]
fn empty_depths_in_front_of_a_city_cost_no_partitions() {
    let eye = DVec3::new(0.0, 150.0, 0.0);
    let camera = ViewVolume::perspective(eye, DVec3::new(0.0, -0.4, -1.0), DVec3::Y, 1.0, 1.5, 0.1, 1000.0).unwrap();
    let scene = Bounds::new(DVec3::new(-1000.0, 0.0, -1000.0), DVec3::new(1000.0, 160.0, 1000.0));
    let (near, far) = adjusted_depths(&light_visible(&camera, &scene), &camera).unwrap();
    close(near, 0.1, 1.0e-6);
    let shown = VisibleDepths {
        nearest: 110.0,
        farthest: far,
    };
    let worst_ratio = |(near, far), count| {
        let depths = split_depths(&SplitScheme::Logarithmic, near, far, count);
        let filled = depths.windows(2).filter(|range| range[1] > shown.nearest);
        let ratios: Vec<f64> = filled.map(|range| range[1] / range[0]).collect();
        (ratios.len(), ratios.into_iter().fold(1.0, f64::max))
    };
    let range = shown.range(near, far, VISIBLE_MARGIN);
    let (one_map, four) = (worst_ratio(range, 1), worst_ratio(range, 4));
    let whole = worst_ratio((near, far), 4);
    assert_eq!((whole.0, four.0), (1, 4), "partitions that are not empty");
    assert!(
        whole.1 > one_map.1 * 0.9 && four.1 * 5.0 < one_map.1,
        "{whole:?} {one_map:?} {four:?}"
    );
}
