//! The thesis's own search for the best angle.

use umbrage::maths::light_plane::flat::{
    Degenerate, Hull, Metric, optimal_tilt,
    search::{Newton, closed_form_turn, newton_turn, searched_turn, stationary_turns},
};

use super::{Dice, five_samples, near, samples};

/// "Within 0.01 degrees."
const TOLERANCE: f64 = 0.01 * std::f64::consts::PI / 180.0;

fn hull(dice: &mut Dice) -> Hull {
    let bottom = dice.between(-1.35, 1.0);
    let top = dice.between(bottom + 0.1, 1.35);
    Hull {
        bottom: bottom.tan(),
        top: top.tan(),
    }
}

/// Section 3.1: of two stationary turns exactly one is valid, the best.
#[test]
fn one_stationary_turn_is_valid() {
    let mut dice = Dice(4);
    for _ in 0..400 {
        let (hull, samples) = (hull(&mut dice), dice.problem());
        let best = hull.turn_of_tilt(optimal_tilt(&samples, Metric::L1).unwrap());
        near(closed_form_turn(&samples, &hull).unwrap(), best, 1.0e-8);
        let (low, high) = hull.valid_turns();
        let turns = stationary_turns(&samples, &hull).unwrap();
        let halves = |turn: f64| [-1.0, 0.0, 1.0].map(|half| turn + half * std::f64::consts::PI);
        let valid = turns
            .into_iter()
            .flat_map(halves)
            .filter(|turn| *turn > low && *turn < high);
        assert_eq!(valid.count(), 1);
    }
}

/// O4 and O5 through angles.
#[test]
fn turns_have_the_published_values() {
    for (bottom, top, first, second) in [
        (-30.0_f64, 30.0_f64, -33.801_50, -37.796_99),
        (-10.0, 40.0, -31.296_74, -34.313_45),
    ] {
        let hull = Hull {
            bottom: bottom.to_radians().tan(),
            top: top.to_radians().tan(),
        };
        let samples = five_samples();
        near(closed_form_turn(&samples, &hull).unwrap().to_degrees(), first, 1.0e-5);
        let Newton::Converged { turn, steps } = newton_turn(&samples, &hull, Metric::L2, 0.0, TOLERANCE) else {
            panic!("no end");
        };
        near(turn.to_degrees(), second, 0.01);
        assert!(steps <= 6, "{steps}");
        // The thesis has no need of it for L1. On the second hull its first step is −67.6°, beyond the valid −50°.
        let is_lost = newton_turn(&samples, &hull, Metric::L1, 0.0, TOLERANCE) == Newton::Lost;
        assert_eq!(is_lost, bottom == -10.0);
    }
}

/// Section 3.1: Newton in the angle takes few steps where it ends, but a share of hard problems leaves the valid range
/// (46 of 375 in the specification's), where restarts or the parameter are needed.
#[test]
fn newton_in_the_angle_gets_lost_at_times() {
    let mut dice = Dice(5);
    let (mut lost, mut steps_in_all, mut rescued) = (0, 0, 0);
    let offsets: Vec<f64> = (0..64).map(|_| dice.between(-0.3, 0.3)).collect();
    for _ in 0..400 {
        let (hull, samples) = (hull(&mut dice), dice.problem());
        let best = hull.turn_of_tilt(optimal_tilt(&samples, Metric::L2).unwrap());
        match newton_turn(&samples, &hull, Metric::L2, 0.0, TOLERANCE) {
            Newton::Converged { turn, steps } => {
                near(turn, best, 1.0e-3);
                steps_in_all += steps;
            }
            Newton::Lost => {
                lost += 1;
                let found = searched_turn(&samples, &hull, Metric::L2, 3, &offsets, TOLERANCE);
                rescued += usize::from(found.is_ok_and(|turn| (turn - best).abs() < 1.0e-3));
            }
        }
    }
    assert!((20..100).contains(&lost), "{lost} of 400");
    assert!(rescued * 10 >= lost * 9, "{rescued} of {lost}");
    let mean = steps_in_all as f64 / (400 - lost) as f64;
    assert!((3.0..6.5).contains(&mean), "{mean} steps");
}

#[test]
fn searches_without_an_end_say_so() {
    let hull = Hull { bottom: -0.5, top: 0.5 };
    let one_end = samples(&[1.0, 1.0], &[1.0, 2.0]);
    assert_eq!(
        searched_turn(&one_end, &hull, Metric::L2, 2, &[0.1, 0.2], TOLERANCE),
        Err(Degenerate::Unbounded)
    );
    assert_eq!(closed_form_turn(&one_end, &hull), Err(Degenerate::Unbounded));
    let bad = samples(&[0.0], &[f64::NAN]);
    assert_eq!(closed_form_turn(&bad, &hull), Err(Degenerate::NotFinite));
    assert_eq!(
        searched_turn(&bad, &hull, Metric::L1, 0, &[], TOLERANCE),
        Err(Degenerate::NotFinite)
    );
    assert_eq!(
        stationary_turns(&samples(&[0.0], &[0.0]), &hull),
        Err(Degenerate::NothingVisible)
    );
    assert_eq!(
        newton_turn(&five_samples(), &hull, Metric::L1, 3.0, TOLERANCE),
        Newton::Lost
    );
}
