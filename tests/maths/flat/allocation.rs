//! Texels for each frustum.

use umbrage::maths::light_plane::flat::{
    Degenerate, Metric,
    allocation::{FillFrom, real_texels, smallest_total, total_error, whole_texels},
};

use super::{Dice, near};

/// O14, real numbers.
#[test]
fn real_allocations_have_the_published_values() {
    let errors = [1.0, 4.0, 9.0];
    for (metric, expected, total) in [
        (Metric::L1, [10.0, 20.0, 30.0], 0.6),
        (Metric::L2, [12.854_889, 20.405_864, 26.739_247], 0.028_245_3),
    ] {
        let texels = real_texels(&errors, 60.0, metric).unwrap();
        for (texels, expected) in texels.iter().zip(expected) {
            near(*texels, expected, 1.0e-6);
        }
        near(total_error(&errors, &texels, metric), total, 1.0e-7);
        near(
            smallest_total(&errors, metric) / 60.0_f64.powi(metric.power()),
            total,
            1.0e-7,
        );
    }
    near(total_error(&errors, &[20.0; 3], Metric::L1), 0.7, 1.0e-12);
    // A frustum without error gets nothing.
    assert_eq!(real_texels(&[0.0, 2.0], 10.0, Metric::L1).unwrap(), [0.0, 10.0]);
}

/// No other allocation is better.
#[test]
fn real_allocations_are_best() {
    let mut dice = Dice(6);
    for _ in 0..2000 {
        let errors: Vec<f64> = (0..4).map(|_| dice.normal().exp()).collect();
        let shares: Vec<f64> = (0..4).map(|_| dice.roll() + 1.0e-3).collect();
        let sum: f64 = shares.iter().sum();
        let other: Vec<f64> = shares.iter().map(|share| 100.0 * share / sum).collect();
        for metric in [Metric::L1, Metric::L2] {
            let best = real_texels(&errors, 100.0, metric).unwrap();
            assert!(total_error(&errors, &best, metric) <= total_error(&errors, &other, metric) * (1.0 + 1.0e-12));
        }
    }
}

fn as_reals(whole: &[u32]) -> Vec<f64> {
    whole.iter().copied().map(f64::from).collect()
}

/// O14, whole numbers.
#[test]
fn whole_allocations_have_the_published_values() {
    let errors = [1.0, 2.0, 5.0, 0.3];
    for (metric, expected, total, real) in [
        (Metric::L1, [3, 5, 7, 2], 1.597_619_0, 1.589_367_4),
        (Metric::L2, [4, 5, 6, 2], 0.356_388_9, 0.345_515_8),
    ] {
        for from in [FillFrom::One, FillFrom::Floor] {
            let texels = whole_texels(&errors, 17, metric, from).unwrap();
            assert_eq!(texels, expected);
            near(total_error(&errors, &as_reals(&texels), metric), total, 1.0e-7);
        }
        near(
            smallest_total(&errors, metric) / 17.0_f64.powi(metric.power()),
            real,
            1.0e-7,
        );
    }
}

/// Brute force over all whole allocations.
#[test]
fn filling_from_one_is_best() {
    let mut dice = Dice(7);
    let mut worse_from_floor = 0;
    for _ in 0..200 {
        let errors: Vec<f64> = (0..3).map(|_| (2.0 * dice.normal()).exp()).collect();
        let all = (1..=10_u32).flat_map(|a| (1..=11 - a).map(move |b| [a, b, 12 - a - b]));
        for metric in [Metric::L1, Metric::L2] {
            let cost = |texels: &[u32]| total_error(&errors, &as_reals(texels), metric);
            let best = all.clone().map(|texels| cost(&texels)).fold(f64::INFINITY, f64::min);
            let [from_one, from_floor] =
                [FillFrom::One, FillFrom::Floor].map(|from| whole_texels(&errors, 12, metric, from).unwrap());
            assert_eq!(from_one.iter().sum::<u32>(), 12);
            assert_eq!(from_floor.iter().sum::<u32>(), 12);
            near(cost(&from_one) / best, 1.0, 1.0e-12);
            worse_from_floor += usize::from(cost(&from_floor) > best * (1.0 + 1.0e-12));
        }
    }
    assert!(worse_from_floor <= 20, "{worse_from_floor} of 400");
}

#[test]
fn impossible_allocations_say_so() {
    let whole = |errors: &[f64], texels| whole_texels(errors, texels, Metric::L1, FillFrom::One);
    assert_eq!(whole(&[1.0, 2.0], 1), Err(Degenerate::TooFewTexels));
    assert_eq!(whole(&[1.0, 2.0], 2).unwrap(), [1, 1]);
    assert_eq!(whole(&[1.0, 0.0, 2.0], 2).unwrap(), [1, 0, 1]);
    assert_eq!(whole(&[0.0, 0.0], 9), Err(Degenerate::NothingVisible));
    assert_eq!(whole(&[], 9), Err(Degenerate::NothingVisible));
    assert_eq!(whole(&[f64::NAN], 9), Err(Degenerate::NotFinite));
    assert_eq!(whole(&[-1.0, 4.0], 9), Err(Degenerate::NotFinite));
    // Very uneven errors: floors of zero become one, and the sum still is right.
    let errors = [1.0e-12, 1.0e-12, 1.0e-12, 1.0];
    assert_eq!(
        whole_texels(&errors, 10, Metric::L1, FillFrom::Floor).unwrap(),
        [1, 1, 1, 7]
    );
}
