//! Split distances against the thesis' numbers.

use umbrage::maths::split::{SplitScheme, split_depths};

use crate::support::close;

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
