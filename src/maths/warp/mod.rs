//! Warps: one free parameter, the distance from the projection centre to the near side of the warp frustum.
//!
//! Every warp is a perspective along the warp axis, across the light, and so is told apart by n' alone
//! ([`WarpSpan::warp_near`]). The one exception is the original perspective shadow map, whose projection is of another
//! kind: [`post_perspective`].

mod guard;
pub mod post_perspective;
mod reparametrised;
mod span;

use serde::{Deserialize, Serialize};

pub use guard::{GuardNorm, guarded_eta, guarded_eta_by};
pub use reparametrised::{frustum_extent, reparametrised_eta};
pub use span::{OptimumRule, WarpSpan, trapezoidal_warp_near};

/// How strongly the light view is warped along the projected view direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum Warp {
    /// No warp: an orthographic light view.
    Uniform,
    /// Light space perspective shadow map: the optimal parameter n_opt (Stingl, section 3.2.1, equation 3.2).
    Lispsm,
    /// `LiSPSM` that fades to uniform where the light shines along the view: eta follows the angle between both
    /// ([`reparametrised_eta`]; Stingl, section 3.2.2, after Lloyd). Outside the view cone it is `LiSPSM`.
    Repar,
    /// The strength of perspective shadow maps in the light-space formulation (eta = 1). For the original formulation
    /// see [`post_perspective`].
    Psm,
    /// Trapezoidal shadow map: a chosen share of the range gets four fifths of the map ([`trapezoidal_warp_near`];
    /// Lloyd, section 4.1, after Martin and Tan 2004).
    Tsm {
        /// The share of the light view's extent along the warp axis, from its near end, that is in focus: above 0,
        /// small values warp strongly, from 0.8 on the map is uniform. Measured as a share, not in metres, so that one
        /// value suits all partitions.
        focus: f32,
    },
    /// Free strength: −1 uniform, 0 `LiSPSM`, 1 `PSM` (Lloyd, equation 11).
    Free {
        /// The normalised warp parameter, −1..=1.
        eta: f32,
    },
}

impl Warp {
    /// The focus of a trapezoidal map where none is chosen: in one map of a whole view it is near n_opt.
    pub const TSM_FOCUS: f32 = 0.2;

    /// The largest normalised strength eta that the warp takes: −1 uniform, 0 `LiSPSM`, 1 `PSM`. Free values are
    /// clamped; NaN is uniform.
    ///
    /// [`Warp::Repar`] and [`Warp::Tsm`] depend on light and view: see [`Warp::eta_in`].
    pub fn eta(self) -> f64 {
        match self {
            Self::Uniform => -1.0,
            Self::Lispsm | Self::Repar => 0.0,
            Self::Psm | Self::Tsm { .. } => 1.0,
            Self::Free { eta } if eta.is_nan() => -1.0,
            Self::Free { eta } => f64::from(eta).clamp(-1.0, 1.0),
        }
    }

    /// The normalised strength eta in one light view, before the guard of [`guarded_eta`].
    ///
    /// `light_angle` is γ, between light and view direction, and `half_opening` is Θ in the plane of both, in radians.
    /// A trapezoidal map is kept at `PSM` where its rule asks for more: a stronger warp only adds error.
    pub fn eta_in(self, span: &WarpSpan, light_angle: f64, half_opening: f64) -> f64 {
        match self {
            Self::Repar => reparametrised_eta(light_angle, half_opening),
            Self::Tsm { focus } => span
                .eta(trapezoidal_warp_near(span.extent, f64::from(focus)))
                .clamp(-1.0, 1.0),
            Self::Uniform | Self::Lispsm | Self::Psm | Self::Free { .. } => self.eta(),
        }
    }
}
