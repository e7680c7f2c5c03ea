//! Warps: one free parameter, the distance from the projection centre to the near side of the warp frustum.

use serde::{Deserialize, Serialize};

use super::error::{LightSample, largest_errors};

/// How strongly the light view is warped along the projected view direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum Warp {
    /// No warp: an orthographic light view.
    Uniform,
    /// Light space perspective shadow map: the optimal parameter n_opt (Stingl, section 3.2.1, equation 3.2).
    Lispsm,
    /// The strength of perspective shadow maps in the light-space formulation (eta = 1).
    Psm,
    /// Free strength: −1 uniform, 0 `LiSPSM`, 1 `PSM` (Lloyd, equation 11).
    Free {
        /// The normalised warp parameter, −1..=1.
        eta: f32,
    },
}

impl Warp {
    /// The normalised strength eta: −1 uniform, 0 `LiSPSM`, 1 `PSM`. Free values are clamped; NaN is uniform.
    pub fn eta(self) -> f64 {
        match self {
            Self::Uniform => -1.0,
            Self::Lispsm => 0.0,
            Self::Psm => 1.0,
            Self::Free { eta } if eta.is_nan() => -1.0,
            Self::Free { eta } => f64::from(eta).clamp(-1.0, 1.0),
        }
    }
}

/// What a warp has to level: the extent of the body along the warp axis and the view depths at its two ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WarpSpan {
    /// d: extent of the warp frustum along light-space y, in metres.
    pub extent: f64,
    /// z0: view depth at its near end, in metres.
    pub near_depth: f64,
    /// z1: view depth at its far end, in metres.
    pub far_depth: f64,
}

impl WarpSpan {
    /// The span of a directional light: z0 is the view depth of the nearest point of LVS, and walking along the warp
    /// axis at that depth changes the view depth by `sine` = v · y per metre, the sine of the angle between light and
    /// view direction (Stingl, section 3.2.1, after Wimmer and Scherzer 2006).
    pub fn directional(extent: f64, near_depth: f64, sine: f64) -> Self {
        Self {
            extent,
            near_depth,
            far_depth: near_depth + extent * sine,
        }
    }

    /// α = z1 ÷ z0; 1 when there is nothing to level.
    fn depth_ratio(&self) -> f64 {
        let ratio = self.far_depth / self.near_depth;
        if ratio.is_finite() && self.near_depth > 0.0 {
            ratio.max(1.0)
        } else {
            1.0
        }
    }

    /// n_opt = d ÷ (√(z1/z0) − 1) (Stingl, equation 3.2): the error along the warp axis is equal at both ends.
    /// Infinite when there is nothing to level.
    pub fn optimal_warp_near(&self) -> f64 {
        self.warp_near(0.0)
    }

    /// n' in metres for a strength eta in −1..=1 (Lloyd, equation 11; Stingl, equation 3.4): infinite at −1, n_opt at 0,
    /// `PSM` at 1. Between −1 and 0 and between 0 and 1 the largest error along the warp axis is linear in eta.
    pub fn warp_near(&self, eta: f64) -> f64 {
        let ratio = self.depth_ratio();
        let root = ratio.sqrt();
        let near = self.extent / (ratio - 1.0)
            * if eta <= 0.0 {
                (1.0 + root - eta * (ratio - 1.0)) / (1.0 + eta)
            } else {
                (1.0 + root) / (eta * root + 1.0)
            };
        if near.is_finite() && near > 0.0 && near < self.extent * LARGEST_RELATIVE_WARP_NEAR {
            near
        } else {
            f64::INFINITY
        }
    }

    /// The strength eta of a `warp_near` between that of `PSM` and infinity: the inverse of [`WarpSpan::warp_near`].
    pub fn eta(&self, warp_near: f64) -> f64 {
        let ratio = self.depth_ratio();
        if ratio == 1.0 || warp_near.is_infinite() {
            return -1.0;
        }
        let root = ratio.sqrt();
        let near = warp_near * (ratio - 1.0) / self.extent;
        if near >= 1.0 + root {
            (1.0 + root - near) / (near + ratio - 1.0)
        } else {
            ((1.0 + root) / near - 1.0) / root
        }
    }
}

/// Beyond this multiple of the extent a warp bends nothing that single precision could tell: it is uniform.
const LARGEST_RELATIVE_WARP_NEAR: f64 = 1.0e6;

/// How much larger than the smallest storage factor that of plain `LiSPSM` may be before the guard weakens the warp.
const GUARD_TOLERANCE: f64 = 0.02;

/// The strength that is left of `target` where the light comes from inside the view cone (Lloyd, section 4.4).
///
/// There n_opt bends the map far too much: the storage factor S̄ grows to a multiple of the unwarped one. The guard
/// searches eta from −1 (uniform) to 0 (`LiSPSM`) for the smallest S̄ over the samples of LVS, and takes the largest eta
/// whose S̄ exceeds it by no more than a fiftieth. So `LiSPSM` stays exactly n_opt wherever that is good; S̄ never exceeds
/// the unwarped one by more than a fiftieth; and since S̄ has one valley over eta, the choice moves steadily with camera
/// and light instead of popping. Other targets are weakened in proportion: `(1 + target) · (1 + eta) − 1`.
pub fn guarded_eta(target: f64, samples: &[LightSample], span: &WarpSpan) -> f64 {
    if target <= -1.0 || samples.is_empty() {
        return -1.0;
    }
    let cost = |eta: f64| largest_errors(samples, span.warp_near(eta), 1.0).storage_factor();
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
