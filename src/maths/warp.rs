//! Warps: one free parameter, the distance from the projection centre to the near side of the warp frustum.

use serde::{Deserialize, Serialize};

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
