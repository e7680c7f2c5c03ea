//! [`FilmProblem`]: the bend and the frame of least error.

use bevy_math::{DMat2, DVec2, UVec2};

use super::{FilmError, FilmFrame, FilmHull, FilmMoments, FilmShape};

/// What is made small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum FilmMetric {
    /// Mean area of a texel in pixels: L1 in both dimensions.
    #[default]
    Area,
    /// Mean of the squared sides of a texel in pixels: the trace of its metric tensor, the sum of its squared singular
    /// values. Long thin texels cost more than square ones of the same area.
    Stretch,
}

/// Whether the sides of the map may differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MapSides {
    /// As many texels along both.
    Equal,
    /// Any: n_x ÷ n_y = √(e₁ᵀ M e₁ ÷ e₂ᵀ M e₂), which makes both squared sides of a texel equal on average. For maps in an
    /// atlas.
    #[default]
    Free,
}

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FilmObjective {
    /// What is made small.
    pub metric: FilmMetric,
    /// The outline of the film.
    pub shape: FilmShape,
    /// Sides of the map.
    pub map_sides: MapSides,
}

/// A film over a base film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// k: w = 1 + k · u.
    pub bend: DVec2,
    /// The map on v = u ÷ w.
    pub frame: FilmFrame,
    /// e: the metric, summed over the pixels, of a map of one texel. A map of n texels has e ÷ n.
    pub error: f64,
    /// |Ω|: pixels in the sum.
    pub pixels: f64,
    /// n_x ÷ n_y that suits the film, 1 where sides must be equal.
    pub aspect: f64,
}

impl Film {
    /// The metric's mean over the pixels for a map of so many texels: pixels per texel for the area.
    pub fn mean_error(&self, texels: f64) -> f64 {
        self.error / (texels * self.pixels)
    }

    /// (ξ, η) in 0..1 of a point of the base film; `None` where w is not positive.
    pub fn place(&self, film: DVec2) -> Option<DVec2> {
        let width = 1.0 + self.bend.dot(film);
        (width > 0.0).then(|| self.frame.place(film / width))
    }

    /// Steps on the base film of one texel of a map, at a point of the base film: w (I + u kᵀ) E diag(1/n_x, 1/n_y).
    pub fn texel_steps(&self, film: DVec2, map_size: UVec2) -> DMat2 {
        let width = 1.0 + self.bend.dot(film);
        let film_from_v = DMat2::IDENTITY + DMat2::from_cols(film * self.bend.x, film * self.bend.y);
        let texels = map_size.max(UVec2::ONE).as_dvec2();
        let sides = DMat2::from_cols(self.frame.sides.x_axis / texels.x, self.frame.sides.y_axis / texels.y);
        film_from_v * sides * width
    }
}

/// Samples, hull and objective: all that a film depends on.
#[derive(Clone, Debug)]
pub struct FilmProblem {
    moments: FilmMoments,
    hull: FilmHull,
    objective: FilmObjective,
    /// The balanced bend.
    balanced: DVec2,
}

/// Sides that a hull is reduced to: every pair of them is a candidate for the frame.
const MOST_SIDES: usize = 20;

/// Newton's steps; it needs 4 to 12.
const MOST_STEPS: usize = 40;

impl FilmProblem {
    /// Checks what it is given, and finds the balanced bend. The hull is then replaced by one of at most 20 sides around it,
    /// with least area added at that bend.
    pub fn new(moments: &FilmMoments, hull: &FilmHull, objective: FilmObjective) -> Result<Self, FilmError> {
        if !moments.is_finite() {
            return Err(FilmError::NotFinite);
        }
        if !(moments.pixels > 0.0 && moments.area[0] > 0.0) {
            return Err(FilmError::NothingVisible);
        }
        let mut problem = Self {
            moments: *moments,
            hull: hull.clone(),
            objective,
            balanced: DVec2::ZERO,
        };
        problem.balanced = problem.balanced_bend(DVec2::ZERO);
        problem.hull = hull.simplified(MOST_SIDES, problem.balanced);
        Ok(problem)
    }

    /// The hull that is covered.
    pub fn hull(&self) -> &FilmHull {
        &self.hull
    }

    /// The bend of least P S: area of the hull's image times Σ a w³. There is exactly one, inside the valid films.
    ///
    /// With means over the hull's image (subscript P) and over the badness a w³ (subscript S), the logarithm has the
    /// gradient 3 (m_S − m_P) and, because ∂(w⁻³)/∂k = −3 u w⁻⁴ and ∂(w³)/∂k = 3 u w²,
    ///
    /// ```text
    /// H = 12 Var_P + 6 Var_S + 3 m_P m_Pᵀ − 3 m_S m_Sᵀ
    /// ```
    ///
    /// At a stationary point m_S = m_P and H = 12 Var_P + 6 Var_S is positive definite: all of them are minima, so there is
    /// one. Newton's method is used with this H everywhere, which always points downhill, and with half steps where that
    /// leaves the valid films or gains nothing.
    ///
    /// `start` must be valid, or 0 is used.
    pub fn balanced_bend(&self, start: DVec2) -> DVec2 {
        let mut image = Vec::with_capacity(MOST_SIDES);
        let mut bend = if self.hull.is_valid(start) { start } else { DVec2::ZERO };
        let Some((mut value, mut gradient, mut hessian)) = self.balance(bend, &mut image) else {
            return DVec2::ZERO;
        };
        for _ in 0..MOST_STEPS {
            let step = hessian.inverse() * -gradient;
            if !(gradient.dot(step) < -1.0e-18) {
                break;
            }
            let mut share = 1.0;
            let better = loop {
                let next = bend + step * share;
                match self.balance(next, &mut image) {
                    Some(balance) if balance.0 < value => break Some((next, balance)),
                    _ if share < 1.0e-6 => break None,
                    _ => share *= 0.5,
                }
            };
            let Some((next, balance)) = better else {
                break;
            };
            bend = next;
            (value, gradient, hessian) = balance;
        }
        bend
    }

    /// log P S, its gradient, and H.
    fn balance(&self, bend: DVec2, image: &mut Vec<DVec2>) -> Option<(f64, DVec2, DMat2)> {
        if !self.hull.is_valid(bend) {
            return None;
        }
        self.hull.project_into(bend, image);
        let area = FilmHull::image_area(image);
        let badness = self.moments.badness(bend);
        let variance = |square: DMat2, mean: DVec2| square - DMat2::from_cols(mean * mean.x, mean * mean.y);
        let value = area.total.ln() + badness.total.ln();
        let hessian = variance(area.square, area.mean) * 12.0 + variance(badness.square, badness.mean) * 6.0;
        value
            .is_finite()
            .then_some((value, (badness.mean - area.mean) * 3.0, hessian))
    }

    /// The film with a given bend and the best frame for it; `None` for bends that are not valid over the hull.
    pub fn film_at(&self, bend: DVec2) -> Option<Film> {
        let (frame, error) = self.framed(bend, &mut Vec::with_capacity(MOST_SIDES))?;
        let [first, second] = self.squared_sides(&self.moments.stretch_matrix(bend), &frame.sides);
        let aspect = match self.objective.map_sides {
            MapSides::Equal => 1.0,
            MapSides::Free => (first / second).sqrt().clamp(1.0e-3, 1.0e3),
        };
        Some(Film {
            bend,
            frame,
            error,
            pixels: self.moments.pixels,
            aspect,
        })
    }

    fn squared_sides(&self, stretch: &DMat2, sides: &DMat2) -> [f64; 2] {
        [sides.x_axis, sides.y_axis].map(|side| side.dot(*stretch * side))
    }

    fn framed(&self, bend: DVec2, image: &mut Vec<DVec2>) -> Option<(FilmFrame, f64)> {
        if !bend.is_finite() || !self.hull.is_valid(bend) {
            return None;
        }
        self.hull.project_into(bend, image);
        let shape = self.objective.shape;
        match self.objective.metric {
            FilmMetric::Area => {
                let total = self.moments.area_sum(bend);
                FilmFrame::around(image, shape, |sides| sides.determinant() * total)
            }
            FilmMetric::Stretch => {
                let stretch = self.moments.stretch_matrix(bend);
                FilmFrame::around(image, shape, |sides| {
                    let [first, second] = self.squared_sides(&stretch, sides);
                    match self.objective.map_sides {
                        MapSides::Equal => first + second,
                        // Of all n_x ÷ n_y with n_x n_y = 1 the least.
                        MapSides::Free => 2.0 * (first * second).sqrt(),
                    }
                })
            }
        }
    }

    /// The film at [`Self::balanced_bend`]: one solve without search, for comparing many groups of tiles.
    pub fn balanced(&self) -> Option<Film> {
        self.film_at(self.balanced)
    }

    /// The film of least error.
    ///
    /// Goes downhill from the best of the balanced bend, no bend, and what is proposed: the bend of the last picture, or
    /// of the largest planes. The metric has kinks where the frame turns to other edges, so the descent is that of Nelder
    /// and Mead, in coordinates in which the balanced minimum is round.
    pub fn solve(&self, proposals: &[DVec2]) -> Result<Film, FilmError> {
        let mut image = Vec::with_capacity(MOST_SIDES);
        let mut error = |bend: DVec2| self.framed(bend, &mut image).map_or(f64::INFINITY, |(_, error)| error);
        let starts = [self.balanced, DVec2::ZERO];
        let starts = starts.iter().chain(proposals).map(|start| (*start, error(*start)));
        let (start, _) = starts
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((self.balanced, f64::INFINITY));
        let round = self
            .balance(start, &mut Vec::with_capacity(MOST_SIDES))
            .map_or(DMat2::IDENTITY, |(_, _, hessian)| whitening(hessian));
        let bend = descend(start, round, &mut error);
        self.film_at(bend).ok_or(FilmError::NoArea)
    }
}

/// R with R Rᵀ = H⁻¹: steps R y cost y² ÷ 2.
fn whitening(hessian: DMat2) -> DMat2 {
    let first = hessian.x_axis.x.sqrt();
    let below = hessian.x_axis.y / first;
    let second = (hessian.y_axis.y - below * below).sqrt();
    let lower = DMat2::from_cols(DVec2::new(first, below), DVec2::new(0.0, second));
    let whitening = lower.inverse().transpose();
    if whitening.is_finite() {
        whitening
    } else {
        DMat2::IDENTITY
    }
}

/// Sizes of the simplex at the start of each round of the descent, and the evaluations of a round: a second round frees a
/// simplex that collapsed onto a kink.
const ROUNDS: [(f64, usize); 2] = [(0.3, 60), (0.05, 40)];

/// Spread of values at which a simplex has arrived.
const ARRIVED: f64 = 1.0e-9;

/// Descends by the simplex method of Nelder and Mead (1965) with their coefficients.
fn descend(start: DVec2, scale: DMat2, value: &mut impl FnMut(DVec2) -> f64) -> DVec2 {
    let mut best = start;
    for (size, evaluations) in ROUNDS {
        let corners = [
            best,
            best + scale * DVec2::X * size,
            best + scale * DVec2::new(-0.5, 0.8) * size,
        ];
        let mut simplex = corners.map(|corner| (corner, value(corner)));
        let mut left = evaluations;
        while left > 0 {
            simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
            let [low, middle, high] = simplex;
            if high.1 - low.1 <= ARRIVED * low.1.abs() {
                break;
            }
            let center = (low.0 + middle.0) * 0.5;
            let mut at = |share: f64| {
                left = left.saturating_sub(1);
                let point = center + (high.0 - center) * share;
                (point, value(point))
            };
            let reflected = at(-1.0);
            simplex[2] = if reflected.1 < low.1 {
                let expanded = at(-2.0);
                if expanded.1 < reflected.1 { expanded } else { reflected }
            } else if reflected.1 < middle.1 {
                reflected
            } else {
                let contracted = at(if reflected.1 < high.1 { -0.5 } else { 0.5 });
                if contracted.1 < high.1.min(reflected.1) {
                    contracted
                } else {
                    left = left.saturating_sub(2);
                    let halfway = (middle.0 + low.0) * 0.5;
                    simplex[1] = (halfway, value(halfway));
                    let halfway = (high.0 + low.0) * 0.5;
                    (halfway, value(halfway))
                }
            };
        }
        best = simplex
            .into_iter()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(best, |(point, _)| point);
    }
    best
}
