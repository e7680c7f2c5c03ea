//! Several frusta, each with a film and a share of the texels of its own (Chong 3.2, algorithm 2).
//!
//! A light's hull is cut into slices, more than there are to be maps; then neighbours are put together until as many are
//! left as are wanted. Splitting pays where surfaces of different directions follow each other (projection aliasing),
//! and where parts of the film serve nobody. It never hurts with real numbers of texels.
//!
//! The printed algorithm 2 does not start each attempt to merge from the present state, measures the merged frustum with
//! another one's angle, mixes angles with offsets, hands out no texels where there is nothing to merge, and leaves open
//! which border goes. Here a merge is a value: two neighbours' pixels under one tilt.

use super::{
    Degenerate, Metric, Moments, Sample, Tilt,
    allocation::{smallest_total, weight},
    metric::pixel_span,
};

/// A part of the initial film with pixels in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Where it begins on the initial film, −1..=1.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
    /// On the part.
    pub moments: Moments,
}

/// Which part of the film a slice keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SliceExtent {
    /// All between its borders, as in the source.
    #[default]
    Borders,
    /// What its pixels cover, half a pixel to both sides included: gaps between slices cost no texels.
    Pixels,
}

/// A frustum of a split.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// Where it begins on the initial film, −1..=1.
    pub low: f64,
    /// Where it ends.
    pub high: f64,
    /// Of its film, relative to the initial one, in places of this frustum.
    pub tilt: Tilt,
    /// e: Σ dᵖ over its pixels if it had one texel.
    pub error: f64,
}

impl Frustum {
    /// The best single film over a slice. Its error is that over a film of unit length, 2ᵖ of that over −1..=1. In closed
    /// form for L1, with sums over its pixels: 2 ÷ (l₁ − l₀) · (√(Σ d (l − l₀)² · Σ d (l₁ − l)²) + Σ d (l − l₀)(l₁ − l)).
    ///
    /// All pixels at one end are the limit of ever more tilt, which has no cost: the error is then taken without tilt.
    ///
    /// # Errors
    /// [`Degenerate::NotFinite`], [`Degenerate::NothingVisible`].
    pub fn over(slice: &Slice, metric: Metric) -> Result<Self, Degenerate> {
        let tilt = match slice.moments.optimum() {
            Err(Degenerate::Unbounded) => Tilt::default(),
            tilt => tilt?,
        };
        Ok(Self {
            low: slice.low,
            high: slice.high,
            tilt,
            error: 2.0_f64.powi(metric.power()) * slice.moments.total(tilt),
        })
    }

    /// A pixel of the initial film on this frustum's own film; `None` outside of it.
    pub fn sample(&self, sample: Sample) -> Option<Sample> {
        let rescaled = sample.rescaled(self.low, self.high);
        (rescaled.place.abs() <= 1.0).then(|| rescaled.tilted(self.tilt))
    }
}

/// A film that is split into frusta.
#[derive(Clone, Debug, PartialEq)]
pub struct Split {
    /// From the bottom to the top of the film; gaps between them serve no pixel.
    pub frusta: Vec<Frustum>,
    /// Which error counts.
    pub metric: Metric,
}

impl Split {
    /// The errors of the frusta, for the allocation of texels.
    pub fn errors(&self) -> Vec<f64> {
        self.frusta.iter().map(|frustum| frustum.error).collect()
    }

    /// Σ dᵖ over all pixels with real numbers of texels, `texels` in all, best allocated.
    pub fn total_error(&self, texels: f64) -> f64 {
        smallest_total(&self.errors(), self.metric) / texels.powi(self.metric.power())
    }
}

/// Cuts the film at `borders` (rising, −1 to 1, from [`Exposure::even_borders`](super::Exposure::even_borders)). A pixel on a
/// border belongs to the slice above it. Slices without pixels are left out: they need no map and count for nothing.
///
/// # Errors
/// [`Degenerate::NothingVisible`] if no slice has pixels; [`Degenerate::NotFinite`].
pub fn slices(
    samples: &[Sample],
    borders: &[f64],
    metric: Metric,
    extent: SliceExtent,
) -> Result<Vec<Slice>, Degenerate> {
    super::optimum::check(samples)?;
    let count = borders.len().saturating_sub(1);
    let mut members: Vec<Vec<Sample>> = vec![Vec::new(); count];
    for sample in samples {
        let above = borders.iter().filter(|border| **border <= sample.place).count();
        if above > 0 && sample.place <= borders[count] {
            members[(above - 1).min(count - 1)].push(*sample);
        }
    }
    let slices = members.iter().zip(borders.windows(2)).filter_map(|(members, pair)| {
        let spans = members.iter().map(|sample| pixel_span(*sample));
        let covered = spans.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), span| {
            (low.min(span.0), high.max(span.1))
        });
        let (low, high) = match extent {
            SliceExtent::Borders => (pair[0], pair[1]),
            SliceExtent::Pixels => (covered.0.max(pair[0]), covered.1.min(pair[1])),
        };
        let is_used = high > low && members.iter().any(|sample| sample.badness > 0.0);
        is_used.then(|| {
            let rescaled: Vec<Sample> = members.iter().map(|sample| sample.rescaled(low, high)).collect();
            Slice {
                low,
                high,
                moments: Moments::of(&rescaled, metric),
            }
        })
    });
    let slices: Vec<Slice> = slices.collect();
    if slices.is_empty() {
        return Err(Degenerate::NothingVisible);
    }
    Ok(slices)
}

/// Slices as one: from the beginning of the first to the end of the last, gaps included. `None` for none.
pub fn merged(slices: &[Slice]) -> Option<Slice> {
    let (low, high) = (slices.first()?.low, slices.last()?.high);
    let place = |at: f64| (2.0 * at - low - high) / (high - low);
    let mut moments = None;
    for slice in slices {
        let part = slice.moments.within(place(slice.low), place(slice.high));
        moments = Some(moments.map_or(part, |sum: Moments| sum.plus(&part)));
    }
    Some(Slice {
        low,
        high,
        moments: moments?,
    })
}

/// Merges neighbours one by one, always the two that cost least, until at most `frusta` are left; then on as long as one
/// frustum less costs at most a share `cheap` more (0: only if it costs nothing; 0.03 is a good trade for a pass over the casters).
///
/// Greedy: over 32 slices of a wavy function [`exact_partition`] is 4 % better for two frusta and L1, 23 % for L2, and
/// hardly for more.
///
/// # Errors
/// [`Degenerate::NothingVisible`] without slices, [`Degenerate::NotFinite`].
pub fn greedy_merge(slices: &[Slice], frusta: usize, cheap: f64, metric: Metric) -> Result<Split, Degenerate> {
    let mut parts = slices.to_vec();
    let over = |slice: &Slice| Frustum::over(slice, metric);
    let mut found = parts.iter().map(over).collect::<Result<Vec<_>, _>>()?;
    if found.is_empty() {
        return Err(Degenerate::NothingVisible);
    }
    while found.len() > 1 {
        let errors: Vec<f64> = found.iter().map(|frustum| frustum.error).collect();
        let sum: f64 = errors.iter().map(|error| weight(*error, metric)).sum();
        let mut best: Option<(f64, usize, Slice, Frustum)> = None;
        for index in 0..parts.len() - 1 {
            let Some(both) = merged(&parts[index..index + 2]) else {
                continue;
            };
            let frustum = over(&both)?;
            let change =
                weight(frustum.error, metric) - weight(errors[index], metric) - weight(errors[index + 1], metric);
            if best.as_ref().is_none_or(|(least, ..)| change < *least) {
                best = Some((change, index, both, frustum));
            }
        }
        let Some((change, index, both, frustum)) = best else {
            break;
        };
        let grown = (1.0 + change / sum).powi(metric.power() + 1) - 1.0;
        if found.len() <= frusta.max(1) && grown > cheap {
            break;
        }
        parts.splice(index..index + 2, [both]);
        found.splice(index..index + 2, [frustum]);
    }
    Ok(Split { frusta: found, metric })
}

/// The best of all ways to put neighbouring slices together to at most `frusta` frusta.
///
/// The total error is (Σ e^(1 ÷ (p + 1)))ᵖ⁺¹ ÷ Lᵖ, so the least sum of those weights is wanted, over neighbours: dynamic
/// programming over the borders, D\[b\]\[j\] = min over i of D\[b − 1\]\[i\] + e(i, j)^(1 ÷ (p + 1)). For n slices n² ÷ 2
/// optima in closed form.
///
/// # Errors
/// As [`greedy_merge`].
pub fn exact_partition(slices: &[Slice], frusta: usize, metric: Metric) -> Result<Split, Degenerate> {
    let count = slices.len();
    // From slice `first` to before `last`, for first < last.
    let mut candidates = vec![vec![None; count + 1]; count];
    for first in 0..count {
        for last in first + 1..=count {
            let Some(all) = merged(&slices[first..last]) else {
                continue;
            };
            candidates[first][last] = Some(Frustum::over(&all, metric)?);
        }
    }
    // The least sum of weights of slices before `last` in `parts + 1` frusta, and where the last frustum begins.
    let mut least = vec![vec![(f64::INFINITY, 0); count + 1]; frusta.max(1)];
    for parts in 0..least.len() {
        for last in 1..=count {
            for first in 0..last {
                let before = match (parts, first) {
                    (_, 0) => 0.0,
                    (0, _) => continue,
                    _ => least[parts - 1][first].0,
                };
                let Some(frustum) = candidates[first][last] else {
                    continue;
                };
                let sum = before + weight(frustum.error, metric);
                if sum < least[parts][last].0 {
                    least[parts][last] = (sum, first);
                }
            }
        }
    }
    let mut found = Vec::new();
    let (mut parts, mut last) = (least.len() - 1, count);
    while last > 0 {
        let first = least[parts][last].1;
        found.extend(candidates[first][last]);
        (parts, last) = (parts.saturating_sub(1), first);
    }
    if found.is_empty() {
        return Err(Degenerate::NothingVisible);
    }
    found.reverse();
    Ok(Split { frusta: found, metric })
}
