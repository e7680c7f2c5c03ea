//! Split distances.

use serde::{Deserialize, Serialize};

/// How the split distances of z-partitions are chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum SplitScheme {
    /// Equal lengths (Stingl, section 3.3.2, equation 3.6).
    Uniform,
    /// Equal ratios (equation 3.7): self-similar splits, the best choice for warped partitions.
    Logarithmic,
    /// `(1 − lambda) · uniform + lambda · logarithmic` (equation 3.8), lambda in 0..=1.
    Practical {
        /// 0: uniform, 1: logarithmic.
        lambda: f32,
    },
    /// Inner split distances in metres of view depth, ascending; values outside the range are clamped into it.
    Manual(Vec<f32>),
}
