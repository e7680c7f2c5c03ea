//! [`Damping`]: films that do not jump from picture to picture.

use bevy_math::{DVec2, DVec4};

use super::{BaseFilm, Film, FilmProblem};

/// How a film follows its optimum.
///
/// Every change of the bend changes every texel, and shadow edges crawl. The thesis does not speak of time. What is kept
/// from picture to picture is the world-space form of w ([`BaseFilm::width_form`]), as k depends on the base film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// Relative error above the optimum up to which the film stays as it is.
    pub tolerance: f64,
    /// Seconds in which 1 − 1 ÷ e of a change is done; 0 follows at once.
    pub settle_seconds: f64,
}

impl Default for Damping {
    /// 5 % more error is not seen, and half a second is short beside the way that a walker takes to change the view.
    fn default() -> Self {
        Self {
            tolerance: 0.05,
            settle_seconds: 0.5,
        }
    }
}

/// A film after [`Damping::step`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damped {
    /// The film.
    pub film: Film,
    /// What it costs in accuracy: its error over that of the optimum, less 1. Not negative.
    pub cost: f64,
    /// False: the bend of the last picture, as it was.
    pub is_moved: bool,
}

/// Bisections for the part of a step that the hull demands.
const BISECTIONS: usize = 30;

impl Damping {
    /// The film of this picture, given the form of w of the last one and the optimum of this one.
    ///
    /// Stays while the cost is within the tolerance, else goes a part of the straight way in k towards the optimum. Valid
    /// bends form a convex set, so from an old bend that has become invalid the film goes as far as it must: nothing is
    /// lost. On a straight way P S is never above its worse end (it is quasi-convex): by that measure damping costs no more
    /// than staying would. The frame is that of least error for the bend; it may turn from one picture to the next.
    pub fn step(
        &self,
        base: &BaseFilm,
        problem: &FilmProblem,
        last_width: Option<DVec4>,
        optimum: &Film,
        seconds: f64,
    ) -> Damped {
        let moved = |film: Film| Damped {
            film,
            cost: (film.error / optimum.error - 1.0).max(0.0),
            is_moved: true,
        };
        let Some(last) = last_width.and_then(|form| base.bend_of(form)) else {
            return moved(*optimum);
        };
        if let Some(film) = problem.film_at(last)
            && film.error <= optimum.error * (1.0 + self.tolerance)
        {
            return Damped {
                is_moved: false,
                ..moved(film)
            };
        }
        let at = |share: f64| last.lerp(optimum.bend, share);
        let eased = 1.0 - (-seconds.max(0.0) / self.settle_seconds.max(0.0)).exp();
        let eased = if eased.is_finite() { eased } else { 1.0 };
        let share = eased.max(least_valid_share(problem, at));
        moved(problem.film_at(at(share)).unwrap_or(*optimum))
    }
}

/// How far along a way into the valid films it becomes valid.
fn least_valid_share(problem: &FilmProblem, at: impl Fn(f64) -> DVec2) -> f64 {
    if problem.hull().is_valid(at(0.0)) {
        return 0.0;
    }
    let (mut invalid, mut valid) = (0.0, 1.0);
    for _ in 0..BISECTIONS {
        let middle = (invalid + valid) * 0.5;
        *(if problem.hull().is_valid(at(middle)) {
            &mut valid
        } else {
            &mut invalid
        }) = middle;
    }
    valid
}
