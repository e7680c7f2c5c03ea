//! The source's own way to the best angle (Chong 3.1): stationary angles in closed form for L1, Newton's method in the
//! angle for L2, restarts at invalid angles. Kept to be compared with [`optimal_tilt`](super::optimal_tilt), which needs none of it.
//!
//! All angles are turns of a point light's film in radians. Under parallel light turning changes nothing.

use super::{Degenerate, Hull, Metric, Sample, optimum::check};

/// Newton steps before a start is given up. The printed loop has no end.
const MOST_STEPS: usize = 100;

/// The two turns, modulo 180°, at which the derivative of Σ d vanishes; exactly one is valid.
///
/// With t = tan x and a, b, c = Σ d, Σ d τ, Σ d τ², Σ d is (a + 2 b t + c t²) ÷ ((1 + T t)(1 + B t)), and so
/// stationary where (c (T + B) − 2 b T B) t² + 2 (c − a T B) t + 2 b − a (T + B) = 0. The source reports eight roots from a
/// computer algebra system: the others are these turned by 180° and zeros of the cosines it multiplied with.
///
/// # Errors
/// [`Degenerate::NotFinite`]; [`Degenerate::NothingVisible`] without badness.
pub fn stationary_turns(samples: &[Sample], hull: &Hull) -> Result<[f64; 2], Degenerate> {
    check(samples)?;
    let Hull { bottom, top } = *hull;
    let sum = |power: i32| {
        let terms = samples
            .iter()
            .map(|sample| sample.badness * hull.coordinate(sample.place).powi(power));
        terms.sum::<f64>()
    };
    let (zeroth, first, second) = (sum(0), sum(1), sum(2));
    if zeroth == 0.0 {
        return Err(Degenerate::NothingVisible);
    }
    let quadratic = second * (top + bottom) - 2.0 * first * top * bottom;
    let half_linear = second - zeroth * top * bottom;
    let constant = 2.0 * first - zeroth * (top + bottom);
    let root = (half_linear * half_linear - quadratic * constant).max(0.0).sqrt();
    // Both roots without cancellation, as angles, so that an infinite tangent is 90°.
    let large = -(half_linear + root.copysign(half_linear));
    let turns = [large.atan2(quadratic), constant.atan2(large)];
    if turns.iter().all(|turn| turn.is_finite()) {
        Ok(turns)
    } else {
        Err(Degenerate::NotFinite)
    }
}

/// The best turn for L1 among [`stationary_turns`], without bad ends of the valid range.
///
/// # Errors
/// Those of [`stationary_turns`], [`Degenerate::Unbounded`] if none is valid.
pub fn closed_form_turn(samples: &[Sample], hull: &Hull) -> Result<f64, Degenerate> {
    let turns = stationary_turns(samples, hull)?;
    let around = turns
        .into_iter()
        .flat_map(|turn| [-std::f64::consts::PI, 0.0, std::f64::consts::PI].map(|half| turn + half));
    around
        .filter(|turn| is_valid(*turn, hull))
        .min_by(|a, b| total(samples, hull, *a, Metric::L1).total_cmp(&total(samples, hull, *b, Metric::L1)))
        .ok_or(Degenerate::Unbounded)
}

/// The outcome of Newton's method from one guess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Newton {
    /// A stationary turn in the valid range, after a number of steps.
    Converged {
        /// Radians.
        turn: f64,
        /// To within the tolerance.
        steps: usize,
    },
    /// It left the valid range, met a NaN, or found no end.
    Lost,
}

/// Newton's method on the derivative of Σ dᵖ by the turn x, undamped as in the source, until a step is below `tolerance`.
///
/// dl/dl' of a pixel changes by u = l' (tan(θ_t − x) − tan(θ_b − x)) times itself per radian, so with weights dᵖ the
/// derivatives are p Σ u and Σ p² u² + p u'. The metric is not convex in x: from 0, 46 of 375 random problems left the
/// valid range.
pub fn newton_turn(samples: &[Sample], hull: &Hull, metric: Metric, guess: f64, tolerance: f64) -> Newton {
    let power = f64::from(metric.power());
    let mut turn = guess;
    for steps in 1..=MOST_STEPS {
        let Some(tilt) = hull.tilt_of_turn(turn).filter(|_| is_valid(turn, hull)) else {
            return Newton::Lost;
        };
        let ends = [hull.top, hull.bottom].map(|end| (end.atan() - turn).tan());
        let secant = |tangent: f64| 1.0 + tangent * tangent;
        let (slope, curvature) = samples.iter().fold((0.0, 0.0), |(slope, curvature), sample| {
            let weight = sample.tilted(tilt).badness.powi(metric.power());
            let tangent = (hull.coordinate(sample.place).atan() - turn).tan();
            let change = 2.0 * tangent - ends[0] - ends[1];
            let changes_by = secant(ends[0]) + secant(ends[1]) - 2.0 * secant(tangent);
            (
                slope + power * weight * change,
                curvature + weight * (power * power * change * change + power * changes_by),
            )
        });
        let step = slope / curvature;
        turn -= step;
        if !turn.is_finite() {
            return Newton::Lost;
        }
        if step.abs() < tolerance {
            return match is_valid(turn, hull) {
                true => Newton::Converged { turn, steps },
                false => Newton::Lost,
            };
        }
    }
    Newton::Lost
}

/// Chong's algorithm 1: the best of Newton's results from several guesses. A guess that gets lost is moved on by the next
/// of `offsets` (the source takes random ones) until one converges or they run out; every start but the first begins with
/// an offset of its own.
///
/// # Errors
/// [`Degenerate::NotFinite`]; [`Degenerate::Unbounded`] if no start converges.
pub fn searched_turn(
    samples: &[Sample],
    hull: &Hull,
    metric: Metric,
    extra_starts: usize,
    offsets: &[f64],
    tolerance: f64,
) -> Result<f64, Degenerate> {
    check(samples)?;
    let mut offsets = offsets.iter().copied();
    let mut found = Vec::new();
    for start in 0..=extra_starts {
        let mut guess = if start == 0 {
            0.0
        } else {
            offsets.next().map_or(0.0, |offset| start as f64 * offset)
        };
        loop {
            match newton_turn(samples, hull, metric, guess, tolerance) {
                Newton::Converged { turn, .. } => {
                    found.push(turn);
                    break;
                }
                Newton::Lost => match offsets.next() {
                    Some(offset) => guess += offset,
                    None => break,
                },
            }
        }
    }
    found
        .into_iter()
        .min_by(|a, b| total(samples, hull, *a, metric).total_cmp(&total(samples, hull, *b, metric)))
        .ok_or(Degenerate::Unbounded)
}

fn is_valid(turn: f64, hull: &Hull) -> bool {
    let (low, high) = hull.valid_turns();
    turn > low && turn < high
}

/// Infinite at invalid turns.
fn total(samples: &[Sample], hull: &Hull, turn: f64, metric: Metric) -> f64 {
    hull.tilt_of_turn(turn)
        .map_or(f64::INFINITY, |tilt| super::total_badness(samples, tilt, metric))
}
