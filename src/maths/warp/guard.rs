//! [`guarded_eta`]: warps where the light comes from inside the view cone.

use super::{
    super::error::{FittedMap, LargestErrors, LightSample, largest_errors_at},
    span::WarpSpan,
};

/// How much larger than the smallest cost that of plain `LiSPSM` may be before the guard weakens the warp.
const GUARD_TOLERANCE: f64 = 0.02;

/// What the guard keeps small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum GuardNorm {
    /// The storage factor S̄ = M_x · M_z: right where a map can take any shape, so that the error of one axis can be traded
    /// for that of the other (Lloyd, section 4.2).
    #[default]
    Storage,
    /// The larger of M_x and M_z: right where the map is a square whatever the errors are, as Bevy's cascades.
    Largest,
}

impl GuardNorm {
    fn cost(self, errors: &LargestErrors) -> f64 {
        match self {
            Self::Storage => errors.storage_factor(),
            Self::Largest => errors.across.max(errors.along),
        }
    }
}

/// The strength that is left of `target` where the light comes from inside the view cone (Lloyd, section 4.4).
///
/// There n_opt bends the map far too much: the storage factor S̄ grows to a multiple of the unwarped one. The guard
/// searches eta from −1 (uniform) to 0 (`LiSPSM`) for the smallest S̄ over the samples of LVS, and takes the largest eta
/// whose S̄ exceeds it by no more than a fiftieth. So `LiSPSM` stays exactly n_opt wherever that is good; S̄ never exceeds
/// the unwarped one by more than a fiftieth; and since S̄ has one valley over eta, the choice moves steadily with camera
/// and light instead of popping. Other targets are weakened in proportion: `(1 + target) · (1 + eta) − 1`.
pub fn guarded_eta(target: f64, samples: &[LightSample], span: &WarpSpan) -> f64 {
    guarded_eta_by(GuardNorm::Storage, target, samples, samples, span)
}

/// [`guarded_eta`] by another norm, over a part of what is in the map: `fitted` are the samples that the map is fitted
/// around, `judged` those whose errors count.
pub fn guarded_eta_by(
    norm: GuardNorm,
    target: f64,
    fitted: &[LightSample],
    judged: &[LightSample],
    span: &WarpSpan,
) -> f64 {
    if target <= -1.0 || fitted.is_empty() || judged.is_empty() {
        return -1.0;
    }
    let cost = |eta: f64| {
        let map = FittedMap::around(fitted, span.warp_near(eta), 1.0);
        norm.cost(&largest_errors_at(&map, judged))
    };
    let (mut left, mut right) = (-1.0_f64, 0.0_f64);
    for _ in 0..GUARD_STEPS {
        let [inner_left, inner_right] = [GOLDEN, 1.0 - GOLDEN].map(|share| left + (right - left) * share);
        if cost(inner_left) <= cost(inner_right) {
            right = inner_right;
        } else {
            left = inner_left;
        }
    }
    let best = (left + right) * 0.5;
    let smallest = cost(best).min(cost(-1.0)).min(cost(0.0));
    let allowed = smallest * (1.0 + GUARD_TOLERANCE);
    let eta = if cost(0.0) <= allowed {
        0.0
    } else {
        let (mut good, mut bad) = (if cost(best) <= allowed { best } else { -1.0 }, 0.0);
        for _ in 0..GUARD_STEPS {
            let middle = (good + bad) * 0.5;
            if cost(middle) <= allowed {
                good = middle
            } else {
                bad = middle
            }
        }
        good
    };
    (1.0 + target) * (1.0 + eta) - 1.0
}

/// Share of an interval that one step of the golden section cuts off.
const GOLDEN: f64 = 0.381_966_011_250_105;

/// Steps of the guard's searches: enough for three digits of eta.
const GUARD_STEPS: usize = 16;
