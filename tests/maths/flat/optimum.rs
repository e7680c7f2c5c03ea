//! The best tilt by each metric.

use umbrage::maths::light_plane::flat::{
    Degenerate, Hull, Metric, Moments, Sample, Tilt, largest_badness, newton, optimal_tilt, smallest_largest_tilt,
    total_badness,
};

use super::{Dice, five_samples, near, samples};

fn turn_degrees(tilt: Tilt, bottom: f64, top: f64) -> f64 {
    let hull = Hull {
        bottom: bottom.to_radians().tan(),
        top: top.to_radians().tan(),
    };
    hull.turn_of_tilt(tilt).to_degrees()
}

/// O4.
#[test]
fn the_least_mean_has_the_published_values() {
    let samples = five_samples();
    let sums = Moments::of(&samples, Metric::L1).sums().to_vec();
    // R, Q, P of the specification are four times these.
    for (sum, expected) in sums.iter().zip([9.25, 5.75, 47.25]) {
        near(4.0 * sum, expected, 1.0e-12);
    }
    let tilt = optimal_tilt(&samples, Metric::L1).unwrap();
    near(tilt.parameter, -0.407_707_28, 1.0e-8);
    near(tilt.strength(), -0.386_524_22, 1.0e-8);
    near(total_badness(&samples, tilt, Metric::L1), 13.328_019_9, 1.0e-7);
    near(total_badness(&samples, Tilt::default(), Metric::L1), 17.0, 1.0e-12);
    near(turn_degrees(tilt, -30.0, 30.0), -33.801_50, 1.0e-5);
    near(turn_degrees(tilt, -10.0, 40.0), -31.296_74, 1.0e-5);
}

/// O5, first part.
#[test]
fn the_least_mean_square_has_the_published_values() {
    let samples = five_samples();
    let moments = Moments::of(&samples, Metric::L2);
    let coefficients = [26.0625, 34.75, 81.375, 124.75, 1381.0625];
    for ((sum, binomial), expected) in moments.sums().iter().zip([1.0, 4.0, 6.0, 4.0, 1.0]).zip(coefficients) {
        near(16.0 * binomial * sum, expected, 1.0e-9);
    }
    let tilt = optimal_tilt(&samples, Metric::L2).unwrap();
    near(tilt.parameter, -0.481_932_76, 1.0e-8);
    near(tilt.strength(), -0.447_790_16, 1.0e-8);
    near(total_badness(&samples, tilt, Metric::L2), 37.508_097_0, 1.0e-7);
    near(moments.total(tilt), 37.508_097_0, 1.0e-7);
    near(total_badness(&samples, Tilt::default(), Metric::L2), 103.0, 1.0e-12);
    near(turn_degrees(tilt, -30.0, 30.0), -37.796_99, 1.0e-5);
    near(turn_degrees(tilt, -10.0, 40.0), -34.313_45, 1.0e-5);
}

/// O5, second part: −(ln 3) ÷ 2 and 3.
#[test]
fn the_least_maximum_has_the_published_values() {
    let samples = five_samples();
    let tilt = smallest_largest_tilt(&samples).unwrap();
    near(tilt.parameter, -(3.0_f64.ln()) / 2.0, 1.0e-12);
    near(largest_badness(&samples, tilt), 3.0, 1.0e-12);
}

/// O6: badness to the power p balances around the middle of the best film, and there is one least value over valid films.
#[test]
fn badness_balances_at_the_optimum() {
    let mut dice = Dice(1);
    for _ in 0..200 {
        let samples = dice.problem();
        for metric in [Metric::L1, Metric::L2] {
            let best = optimal_tilt(&samples, metric).unwrap();
            let tilted: Vec<Sample> = samples.iter().map(|sample| sample.tilted(best)).collect();
            let powers = || tilted.iter().map(|sample| sample.badness.powi(metric.power()));
            let balance: f64 = powers().zip(&tilted).map(|(power, sample)| power * sample.place).sum();
            near(balance / powers().sum::<f64>(), 0.0, 1.0e-12);

            let values: Vec<f64> = (-400..=400)
                .map(|step| total_badness(&samples, Tilt::new(f64::from(step) / 100.0), metric))
                .collect();
            let valleys = values
                .windows(3)
                .filter(|three| three[1] < three[0] && three[1] < three[2]);
            assert_eq!(valleys.count(), 1);
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(total_badness(&samples, best, metric) <= least);
        }
        let best = smallest_largest_tilt(&samples).unwrap();
        for step in [-0.3, -1.0e-3, -1.0e-7, 1.0e-7, 1.0e-3, 0.3] {
            let beside = Tilt::new(best.parameter + step);
            assert!(largest_badness(&samples, best) <= largest_badness(&samples, beside) * (1.0 + 1.0e-12));
        }
    }
}

/// O7: every metric is strictly convex in the parameter, and Newton's method ends in 7 steps at most.
#[test]
fn newton_in_the_parameter_is_quick() {
    let mut dice = Dice(2);
    let mut most = 0;
    for _ in 0..2000 {
        let samples = dice.problem();
        for (metric, power) in [(Metric::L1, 1.0), (Metric::L2, 2.0)] {
            let best = optimal_tilt(&samples, metric).unwrap();
            let (found, steps) = newton(&samples, power, Tilt::default(), 1.0e-6).unwrap();
            near(found.parameter, best.parameter, 1.0e-6);
            most = most.max(steps);
        }
    }
    assert!(most <= 7, "{most} steps");
    let samples = dice.problem();
    for metric in [Metric::L1, Metric::L2] {
        let at = |step: i32| total_badness(&samples, Tilt::new(f64::from(step) / 10.0), metric);
        for step in -60..=60 {
            assert!(at(step - 1) + at(step + 1) > 2.0 * at(step));
        }
    }
    // The power 40 is nearly the maximum.
    let (found, _) = newton(&five_samples(), 40.0, Tilt::default(), 1.0e-9).unwrap();
    near(
        found.parameter,
        smallest_largest_tilt(&five_samples()).unwrap().parameter,
        1.0e-2,
    );
}

/// Sums of parts add up to those of the whole, without lost digits in narrow parts.
#[test]
fn moments_of_parts_add_up() {
    let mut dice = Dice(3);
    let samples = dice.problem();
    for metric in [Metric::L1, Metric::L2] {
        let whole = Moments::of(&samples, metric);
        let mut sum = Moments::empty(metric);
        let borders: Vec<f64> = (0..=1000).map(|index| f64::from(index) / 500.0 - 1.0).collect();
        for pair in borders.windows(2) {
            let is_member = |sample: &&Sample| {
                sample.place >= pair[0] && (sample.place < pair[1] || pair[1] == 1.0 && sample.place == 1.0)
            };
            let members = samples.iter().filter(is_member);
            let part: Vec<Sample> = members.map(|sample| sample.rescaled(pair[0], pair[1])).collect();
            sum = sum.plus(&Moments::of(&part, metric).within(pair[0], pair[1]));
        }
        for (sum, whole) in sum.sums().iter().zip(whole.sums()) {
            near(sum / whole, 1.0, 1.0e-12);
        }
        for parameter in [-3.0, 0.0, 0.7] {
            let tilt = Tilt::new(parameter);
            near(whole.total(tilt) / total_badness(&samples, tilt, metric), 1.0, 1.0e-12);
        }
    }
}

#[test]
fn problems_without_an_optimum_say_so() {
    let both = [Metric::L1, Metric::L2];
    for (places, badness, expected) in [
        (vec![], vec![], Degenerate::NothingVisible),
        (vec![-1.0, 1.0], vec![0.0, 0.0], Degenerate::NothingVisible),
        (vec![1.0, 1.0], vec![1.0, 2.0], Degenerate::Unbounded),
        (vec![-1.0, 1.0], vec![3.0, 0.0], Degenerate::Unbounded),
        (vec![-1.0, 1.0], vec![3.0, f64::NAN], Degenerate::NotFinite),
        (vec![-1.0, 1.0], vec![3.0, f64::INFINITY], Degenerate::NotFinite),
        (vec![-1.0, f64::NAN], vec![3.0, 1.0], Degenerate::NotFinite),
        (vec![-1.0, 1.5], vec![3.0, 1.0], Degenerate::NotFinite),
    ] {
        let samples = samples(&places, &badness);
        for metric in both {
            assert_eq!(optimal_tilt(&samples, metric), Err(expected), "{places:?} {badness:?}");
        }
        assert_eq!(smallest_largest_tilt(&samples), Err(expected));
        assert_eq!(newton(&samples, 1.0, Tilt::default(), 1.0e-6), Err(expected));
    }
    let enormous = samples(&[-1.0, 1.0], &[1.0e200, 1.0e200]);
    assert_eq!(optimal_tilt(&enormous, Metric::L2), Err(Degenerate::NotFinite));
    near(optimal_tilt(&enormous, Metric::L1).unwrap().parameter, 0.0, 1.0e-12);
    // Twenty orders of magnitude: still exact, where k and the angle have run out of digits.
    let uneven = samples(&[-1.0, 1.0], &[1.0e-20, 1.0e20]);
    for metric in both {
        near(
            optimal_tilt(&uneven, metric).unwrap().parameter,
            -20.0 * 10.0_f64.ln() / 2.0,
            1.0e-9,
        );
    }
}
