//! The best tilt.

use super::{Degenerate, Metric, Sample, Tilt, largest_badness};

/// Numbers of Newton steps and halvings after which nothing changes any more in double precision.
const MOST_STEPS: usize = 200;

/// All that a metric needs to know of the pixels of a film or a part of it: three sums for L1 and five for L2, which may be
/// added up from parts in any order.
///
/// They are b_j = Σ dᵖ μʲ (1 − μ)²ᵖ⁻ʲ with μ = (1 + l) ÷ 2, and the metric of a tilted film is Σ_j C(2p, j) b_j e²ˢ⁽ʲ⁻ᵖ⁾.
/// In plain powers of l: for L1, 4 b = Σ d (1 − l)², Σ d (1 − l²), Σ d (1 + l)². In this form all terms are positive, also
/// when parts of the film are put together ([`Self::within`]): no digits cancel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    metric: Metric,
    /// The first three, for L1.
    sums: [f64; 5],
}

impl Moments {
    /// Of no pixels.
    pub fn empty(metric: Metric) -> Self {
        Self { metric, sums: [0.0; 5] }
    }

    /// Of some pixels.
    pub fn of(samples: &[Sample], metric: Metric) -> Self {
        let mut moments = Self::empty(metric);
        let degree = 2 * metric.power();
        for sample in samples {
            let weight = sample.badness.powi(metric.power());
            let (high, low) = ((1.0 + sample.place) / 2.0, (1.0 - sample.place) / 2.0);
            for (sum, power) in moments.sums.iter_mut().zip(0..=degree) {
                *sum += weight * high.powi(power) * low.powi(degree - power);
            }
        }
        moments
    }

    /// b_j.
    pub fn sums(&self) -> &[f64] {
        &self.sums[..=2 * self.metric.power() as usize]
    }

    /// No pixels, or none with badness.
    pub fn is_empty(&self) -> bool {
        self.sums.iter().all(|sum| *sum == 0.0)
    }

    /// Of the pixels of both, which must be of one film and metric.
    #[must_use]
    pub fn plus(mut self, other: &Self) -> Self {
        for (sum, more) in self.sums.iter_mut().zip(other.sums) {
            *sum += more;
        }
        self
    }

    /// Of the same pixels on a film of which this one is the part `low..=high` (places, −1..=1).
    ///
    /// μ of the whole is (1 − ν) μ_low + ν μ_high for ν of the part, so μʲ (1 − μ)²ᵖ⁻ʲ is a sum of νⁱ (1 − ν)²ᵖ⁻ⁱ with
    /// positive weights: the products of those two-term sums. Badness of the whole is that of the part times 2 ÷ width.
    #[must_use]
    pub fn within(&self, low: f64, high: f64) -> Self {
        let degree = self.sums().len() - 1;
        let ends = [(1.0 + low) / 2.0, (1.0 + high) / 2.0];
        let scale = (2.0 / (high - low)).powi(self.metric.power());
        let mut moments = Self::empty(self.metric);
        for (power, sum) in moments.sums.iter_mut().take(degree + 1).enumerate() {
            // Coefficients of νⁱ (1 − ν)^(factors − i).
            let mut weights = [1.0, 0.0, 0.0, 0.0, 0.0];
            for factor in 0..degree {
                let [at_low, at_high] = if factor < power {
                    ends
                } else {
                    ends.map(|end| 1.0 - end)
                };
                for index in (0..=factor + 1).rev() {
                    let carried = if index > 0 { weights[index - 1] * at_high } else { 0.0 };
                    weights[index] = weights[index] * at_low + carried;
                }
            }
            *sum = scale
                * self
                    .sums
                    .iter()
                    .zip(weights)
                    .map(|(sum, weight)| sum * weight)
                    .sum::<f64>();
        }
        moments
    }

    /// The metric of a tilted film: Σ dᵖ.
    pub fn total(&self, tilt: Tilt) -> f64 {
        let middle = f64::from(self.metric.power());
        let terms = self.terms().map(|(index, term)| {
            // 0 · ∞ has no value, and an end of the film without pixels costs nothing.
            if term == 0.0 {
                0.0
            } else {
                term * (2.0 * tilt.parameter * (index - middle)).exp()
            }
        });
        terms.sum()
    }

    /// C(2p, j) b_j with j.
    fn terms(&self) -> impl DoubleEndedIterator<Item = (f64, f64)> {
        const L1: [f64; 5] = [1.0, 2.0, 1.0, 0.0, 0.0];
        const L2: [f64; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];
        let binomials = match self.metric {
            Metric::L1 => L1,
            Metric::L2 => L2,
        };
        let terms: [f64; 5] = std::array::from_fn(|index| binomials[index] * self.sums[index]);
        let count = self.sums().len();
        (0..count).map(move |index| (index as f64, terms[index]))
    }

    /// The one tilt with the smallest metric, exactly.
    ///
    /// L1 (Chong 3.1, who finds eight candidates): b_2 e⁴ˢ = b_0, and there the metric is 2 (√(b_0 b_2) + b_1). L2, where
    /// the source iterates in the angle: the positive root of 2 A_4 E⁴ + A_3 E³ − A_1 E − 2 A_0 with E = e²ˢ and
    /// A_j = C(4, j) b_j; there is one, since signs change once. It is the zero of a function that only rises in s, held
    /// between two bounds.
    ///
    /// # Errors
    /// [`Degenerate::NotFinite`]; [`Degenerate::NothingVisible`] without badness; [`Degenerate::Unbounded`] if all of it
    /// is at one end of the film.
    pub fn optimum(&self) -> Result<Tilt, Degenerate> {
        let sums = self.sums();
        if !sums.iter().all(|sum| sum.is_finite()) {
            return Err(Degenerate::NotFinite);
        }
        if self.is_empty() {
            return Err(Degenerate::NothingVisible);
        }
        let (first, last) = (sums[0], sums[sums.len() - 1]);
        // Denormal sums have too few digits for a quotient.
        if first < f64::MIN_POSITIVE || last < f64::MIN_POSITIVE {
            return Err(Degenerate::Unbounded);
        }
        match self.metric {
            Metric::L1 => Ok(Tilt::new((first.ln() - last.ln()) / 4.0)),
            Metric::L2 => Ok(Tilt::new(self.rising_zero())),
        }
    }

    /// s where Σ_j (j − 2) A_j e²ˢ⁽ʲ⁻²⁾ is zero: Newton's method, held between bounds.
    fn rising_zero(&self) -> f64 {
        let at = |parameter: f64| {
            let value_and_slope = self.terms().map(|(index, term)| {
                let power = index - 2.0;
                let value = power * term * (2.0 * parameter * power).exp();
                (value, 2.0 * power * value)
            });
            value_and_slope.fold((0.0, 0.0), |(value, slope), (more, steeper)| {
                (value + more, slope + steeper)
            })
        };
        // Where the largest sum below the middle and the largest above it balance is at most ln 2 away, up or down.
        let balance = |index: usize, other: usize| {
            let terms: Vec<f64> = self.terms().map(|(_, term)| term).collect();
            let (low, high) = (terms[index] * (2.0 - index as f64), terms[other] * (other as f64 - 2.0));
            (low.ln() - high.ln()) / (2.0 * (other - index) as f64)
        };
        let candidates = [balance(0, 3), balance(0, 4), balance(1, 3), balance(1, 4)];
        let finite = || candidates.into_iter().filter(|candidate| candidate.is_finite());
        let mut low = finite().fold(f64::INFINITY, f64::min) - 1.0;
        let mut high = finite().fold(f64::NEG_INFINITY, f64::max) + 1.0;
        let mut parameter = (low + high) / 2.0;
        for _ in 0..MOST_STEPS {
            let (value, slope) = at(parameter);
            if value > 0.0 {
                high = parameter;
            } else {
                low = parameter;
            }
            let step = parameter - value / slope;
            let next = if step > low && step < high {
                step
            } else {
                (low + high) / 2.0
            };
            if (next - parameter).abs() <= f64::EPSILON * next.abs() {
                return next;
            }
            parameter = next;
        }
        parameter
    }
}

/// The tilt with the smallest sum of badness, exactly ([`Moments::optimum`]). There Σ (d')ᵖ l' = 0: badness balances around
/// the middle of the tilted film.
///
/// # Errors
/// Those of [`Moments::optimum`].
pub fn optimal_tilt(samples: &[Sample], metric: Metric) -> Result<Tilt, Degenerate> {
    check(samples)?;
    Moments::of(samples, metric).optimum()
}

/// The tilt with the smallest largest badness (L∞). The source reports L∞ but does not optimise it.
///
/// Every pixel's badness is convex in s, so the largest is, and the slope of the worst pixel's, whose sign is that of l',
/// tells on which side the optimum lies. A pixel with weight μ² d is above today's largest badness F once μ² d e²ˢ > F,
/// which bounds s.
///
/// # Errors
/// As [`optimal_tilt`].
pub fn smallest_largest_tilt(samples: &[Sample]) -> Result<Tilt, Degenerate> {
    check(samples)?;
    let largest = largest_badness(samples, Tilt::default());
    let heaviest = |side: f64| {
        let weights = samples
            .iter()
            .map(|sample| sample.badness * ((1.0 + side * sample.place) / 2.0).powi(2));
        weights.fold(0.0, f64::max)
    };
    if largest == 0.0 {
        return Err(Degenerate::NothingVisible);
    }
    let (above, below) = (heaviest(1.0), heaviest(-1.0));
    if above < f64::MIN_POSITIVE || below < f64::MIN_POSITIVE {
        return Err(Degenerate::Unbounded);
    }
    let mut high = (largest / above).ln() / 2.0;
    let mut low = -(largest / below).ln() / 2.0;
    for _ in 0..MOST_STEPS {
        let middle = (low + high) / 2.0;
        if middle <= low || middle >= high {
            break;
        }
        let tilted = samples.iter().map(|sample| sample.tilted(Tilt::new(middle)));
        let worst = tilted.max_by(|a, b| a.badness.total_cmp(&b.badness));
        if worst.is_some_and(|worst| worst.place > 0.0) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Ok(Tilt::new((low + high) / 2.0))
}

/// Newton's method in s for any power p ≥ ½ from a starting tilt, steps held to ±1; with the number of steps until one is
/// below `tolerance`:
///
/// F' = 2 p Σ (d')ᵖ l' and F'' = Σ (d')ᵖ (4 p² l'² + 2 p (1 − l'²)) > 0.
///
/// F is strictly convex, so it only ever points at the one optimum; from no tilt it took 7 steps at most over 2000 random
/// problems to a tolerance of 10⁻⁶, and it cannot leave the valid films. Far from the optimum a step is about 1 ÷ (2 p), so
/// large powers take long; after 200 steps it returns where it is. For L1 and L2 prefer [`optimal_tilt`].
///
/// # Errors
/// As [`optimal_tilt`].
pub fn newton(samples: &[Sample], power: f64, start: Tilt, tolerance: f64) -> Result<(Tilt, usize), Degenerate> {
    check(samples)?;
    let reaches = |side: f64| {
        samples
            .iter()
            .any(|sample| sample.badness > 0.0 && side * sample.place > -1.0)
    };
    if !samples.iter().any(|sample| sample.badness > 0.0) {
        return Err(Degenerate::NothingVisible);
    }
    if !(reaches(1.0) && reaches(-1.0)) {
        return Err(Degenerate::Unbounded);
    }
    let mut parameter = start.parameter;
    for steps in 1..=MOST_STEPS {
        let tilted = samples.iter().map(|sample| sample.tilted(Tilt::new(parameter)));
        let (slope, curvature) = tilted.fold((0.0, 0.0), |(slope, curvature), sample| {
            let weight = sample.badness.powf(power);
            let square = sample.place * sample.place;
            (
                slope + 2.0 * power * weight * sample.place,
                curvature + weight * (4.0 * power * power * square + 2.0 * power * (1.0 - square)),
            )
        });
        let step = (slope / curvature).clamp(-1.0, 1.0);
        if !step.is_finite() {
            return Err(Degenerate::NotFinite);
        }
        parameter -= step;
        if step.abs() < tolerance {
            return Ok((Tilt::new(parameter), steps));
        }
    }
    Ok((Tilt::new(parameter), MOST_STEPS))
}

/// Samples that the formulas are about.
pub(super) fn check(samples: &[Sample]) -> Result<(), Degenerate> {
    let is_sound = |sample: &Sample| sample.badness.is_finite() && sample.badness >= 0.0 && sample.place.abs() <= 1.0;
    if samples.iter().all(is_sound) {
        Ok(())
    } else {
        Err(Degenerate::NotFinite)
    }
}
