//! Texels for each of several frusta (Chong 3.2).
//!
//! A frustum with error e over a film of unit length has Σ d = e ÷ x with x texels and Σ d² = e ÷ x² ([`Metric::L1`],
//! [`Metric::L2`]; d in pixels per texel). The sum over all frusta is to be smallest with L texels in all. Frusta without
//! error get none.

use super::{Degenerate, Metric};

/// Σ eᵢ ÷ xᵢᵖ for given numbers of texels. Frusta without error cost nothing, whatever they have.
pub fn total_error(errors: &[f64], texels: &[f64], metric: Metric) -> f64 {
    let used = errors.iter().zip(texels).filter(|(error, _)| **error > 0.0);
    used.map(|(error, texels)| error / texels.powi(metric.power())).sum()
}

/// e^(1 ÷ (p + 1)): the share of the texels that a frustum should have, up to a common factor.
pub fn weight(error: f64, metric: Metric) -> f64 {
    match metric {
        Metric::L1 => error.sqrt(),
        Metric::L2 => error.cbrt(),
    }
}

/// The smallest total error with one texel in all: (Σ e^(1 ÷ (p + 1)))ᵖ⁺¹. With L texels it is that ÷ Lᵖ.
pub fn smallest_total(errors: &[f64], metric: Metric) -> f64 {
    let weights = errors.iter().map(|error| weight(*error, metric));
    weights.sum::<f64>().powi(metric.power() + 1)
}

/// The best real numbers of texels: x_i = L e_i^(1 ÷ (p + 1)) ÷ Σ e_j^(1 ÷ (p + 1)), where the derivatives p e_i ÷ x_iᵖ⁺¹ are
/// all equal (a Lagrange multiplier; the source only names the method).
///
/// # Errors
/// [`Degenerate::NothingVisible`] without errors above zero; [`Degenerate::NotFinite`].
pub fn real_texels(errors: &[f64], texels: f64, metric: Metric) -> Result<Vec<f64>, Degenerate> {
    let weights: Vec<f64> = errors.iter().map(|error| weight(*error, metric)).collect();
    let sum: f64 = weights.iter().sum();
    if !(sum.is_finite() && texels.is_finite() && errors.iter().all(|error| *error >= 0.0)) {
        return Err(Degenerate::NotFinite);
    }
    if sum == 0.0 {
        return Err(Degenerate::NothingVisible);
    }
    Ok(weights.iter().map(|weight| texels * weight / sum).collect())
}

/// From where whole texels are handed out one by one to where they help most ("water-filling").
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FillFrom {
    /// One texel each. The best of all whole numbers, since every further texel of a frustum helps less than the one before.
    #[default]
    One,
    /// The real numbers, rounded down, as in the source: fewer steps, and all but always the same.
    Floor,
}

/// The best whole numbers of texels.
///
/// # Errors
/// Those of [`real_texels`]; [`Degenerate::TooFewTexels`] for fewer texels than frusta with an error.
pub fn whole_texels(errors: &[f64], texels: u32, metric: Metric, from: FillFrom) -> Result<Vec<u32>, Degenerate> {
    let real = real_texels(errors, f64::from(texels), metric)?;
    let used = errors.iter().filter(|error| **error > 0.0).count();
    if used > texels as usize {
        return Err(Degenerate::TooFewTexels);
    }
    let first = errors.iter().zip(&real).map(|(error, real)| match from {
        _ if *error == 0.0 => 0,
        FillFrom::One => 1,
        FillFrom::Floor => (real.floor() as u32).max(1),
    });
    let mut whole: Vec<u32> = first.collect();
    // Floors of less than one count as one, which may be too many in all: the least missed are taken back.
    let cost = |index: usize, count: u32| errors[index] / f64::from(count).powi(metric.power());
    while whole.iter().sum::<u32>() > texels {
        let loss = |index: &usize| cost(*index, whole[*index] - 1) - cost(*index, whole[*index]);
        let candidates = (0..whole.len()).filter(|index| whole[*index] > 1);
        let Some(least) = candidates.min_by(|a, b| loss(a).total_cmp(&loss(b))) else {
            break;
        };
        whole[least] -= 1;
    }
    for _ in whole.iter().sum::<u32>()..texels {
        let gain = |index: &usize| cost(*index, whole[*index]) - cost(*index, whole[*index] + 1);
        let candidates = (0..whole.len()).filter(|index| errors[*index] > 0.0);
        let Some(most) = candidates.max_by(|a, b| gain(a).total_cmp(&gain(b))) else {
            break;
        };
        whole[most] += 1;
    }
    Ok(whole)
}
