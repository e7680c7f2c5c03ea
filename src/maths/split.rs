//! Split distances of z-partitions (Stingl, section 3.3.2).

use serde::{Deserialize, Serialize};

/// The largest number of partitions.
pub const MAX_PARTITIONS: usize = 16;

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

/// Split distances C_0 = near to C_count = far, in metres of view depth: `count + 1` values, strictly increasing.
///
/// `count` is clamped to 1..=16. Ratios need a positive near: where an orthographic camera has none, logarithmic splits
/// are uniform. [`SplitScheme::Manual`] with too few distances divides the rest uniformly; with too many it ignores the
/// last; distances that coincide after clamping are set a millionth of the range apart. Empty unless both depths are
/// finite and `near < far`.
pub fn split_depths(scheme: &SplitScheme, near: f64, far: f64, count: usize) -> Vec<f64> {
    if !near.is_finite() || !far.is_finite() || near >= far {
        return Vec::new();
    }
    let count = count.clamp(1, MAX_PARTITIONS);
    let share = |index: usize| index as f64 / count as f64;
    let uniform = |index: usize| near + (far - near) * share(index);
    let logarithmic = |index: usize| {
        if near > 0.0 {
            near * (far / near).powf(share(index))
        } else {
            uniform(index)
        }
    };
    let mut depths: Vec<f64> = match scheme {
        SplitScheme::Uniform => (0..=count).map(uniform).collect(),
        SplitScheme::Logarithmic => (0..=count).map(logarithmic).collect(),
        SplitScheme::Practical { lambda } => {
            let lambda = if lambda.is_finite() {
                f64::from(*lambda).clamp(0.0, 1.0)
            } else {
                0.5
            };
            (0..=count)
                .map(|index| (1.0 - lambda) * uniform(index) + lambda * logarithmic(index))
                .collect()
        }
        SplitScheme::Manual(inner) => manual_depths(inner, near, far, count),
    };
    depths[0] = near;
    depths[count] = far;
    if matches!(scheme, SplitScheme::Manual(_)) {
        separate(&mut depths);
    }
    depths
}

fn manual_depths(inner: &[f32], near: f64, far: f64, count: usize) -> Vec<f64> {
    let mut given: Vec<f64> = inner
        .iter()
        .filter(|depth| !depth.is_nan())
        .map(|depth| f64::from(*depth).clamp(near, far))
        .collect();
    given.sort_by(f64::total_cmp);
    given.truncate(count - 1);
    let mut depths = vec![near];
    depths.extend(given);
    let last = depths[depths.len() - 1];
    let missing = count + 1 - depths.len();
    depths.extend((1..=missing).map(|index| last + (far - last) * index as f64 / missing as f64));
    depths
}

/// Moves inner distances as little as needed to be strictly increasing.
fn separate(depths: &mut [f64]) {
    let last = depths.len() - 1;
    let gap = (depths[last] - depths[0]) * 1.0e-6;
    for index in 1..last {
        depths[index] = depths[index].max(depths[index - 1] + gap);
    }
    for index in (1..last).rev() {
        depths[index] = depths[index].min(depths[index + 1] - gap);
    }
}
