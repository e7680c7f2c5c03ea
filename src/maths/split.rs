//! Split distances of z-partitions (Stingl, sections 3.3.2 and 4.2; Lloyd, section 5.2).
//!
//! From few facts to many: [`split_depths`] needs the range only; [`pseudo_split_depths`] spends its inner distances on a
//! part of the range; [`VisibleDepths`] shortens the range to what a picture has shown. The last matters most: splits
//! share out *ratios* of depth, so the empty metres in front of a high viewpoint cost whole partitions. Over a city whose
//! nearest roof is 100 m away, three of four logarithmic splits of 0.1..1000 m are empty, and one map fitted to
//! 100..1000 m would do as well as all four.

use serde::{Deserialize, Serialize};

/// The largest number of partitions.
pub const MAX_PARTITIONS: usize = 16;

/// How the split distances of z-partitions are chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum SplitScheme {
    /// Equal lengths (Stingl, section 3.3.2, equation 3.6).
    Uniform,
    /// Equal ratios (equation 3.7), the best choice for warped partitions. These are Lloyd's self-similar splits
    /// (equations 15 and 16): n_i = n (f/n)^((i−1)/k) is C_(i−1) of equation 3.7, so there is no second scheme, and the
    /// technique text `split=self` means this one. Every partition has the depth ratio (f/n)^(1/k), the smallest that
    /// the worst of k partitions can have.
    Logarithmic,
    /// `(1 − lambda) · uniform + lambda · logarithmic` (equation 3.8), lambda in 0..=1.
    Practical {
        /// 0: uniform, 1: logarithmic; the thesis' default is 0.5, which NaN counts as.
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

/// Pseudo-near and pseudo-far plane (Stingl, section 4.2): the part of the range that is worth its texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PseudoPlanes {
    /// n_p: view depth in metres.
    pub near: f64,
    /// f_p: view depth in metres.
    pub far: f64,
}

impl PseudoPlanes {
    /// From shares of the range near..far, 0 being off: n_p = n + near_share (f − n), f_p = f − far_share (f − n). The
    /// thesis gives distances in equation 4.1 and shares in equation 4.2; this is the map between them. Shares are
    /// clamped to 0..=1; NaN is off.
    pub fn from_shares(near: f64, far: f64, near_share: f64, far_share: f64) -> Self {
        let length = far - near;
        let share = |value: f64| if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
        Self {
            near: near + share(near_share) * length,
            far: far - share(far_share) * length,
        }
    }
}

/// Split distances whose scheme is evaluated on the pseudo planes while the partitions still cover near..far (Stingl,
/// equation 4.1): C_0 = near and C_count = far, whatever the planes are.
///
/// Planes outside the range, NaN ones too, count as near and far. Where n_p >= f_p nothing is worth more than the rest:
/// the planes are ignored. [`SplitScheme::Manual`] says its distances itself and ignores them too. One partition has no
/// inner distance to move. Empty where [`split_depths`] is.
pub fn pseudo_split_depths(scheme: &SplitScheme, near: f64, far: f64, pseudo: PseudoPlanes, count: usize) -> Vec<f64> {
    // `max` and `min` drop NaN.
    let (pseudo_near, pseudo_far) = (pseudo.near.max(near), pseudo.far.min(far));
    let is_manual = matches!(scheme, SplitScheme::Manual(_));
    if is_manual || !near.is_finite() || !far.is_finite() || pseudo_near >= pseudo_far {
        return split_depths(scheme, near, far, count);
    }
    let mut depths = split_depths(scheme, pseudo_near, pseudo_far, count);
    if let [first, .., last] = &mut depths[..] {
        (*first, *last) = (near, far);
    }
    depths
}

/// Nearest and farthest view depth that a picture shows, in metres: what a reduction of its depth buffer gives
/// (Stingl, section 4.3; both ends here).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VisibleDepths {
    /// Smallest view depth of any pixel with geometry.
    pub nearest: f64,
    /// Largest.
    pub farthest: f64,
}

/// Share of the depth by which [`VisibleDepths::range`] should widen what an older picture has measured: at 60 pictures a
/// second it covers a viewer who approaches a wall 1 m away at 6 m/s. No margin covers what enters from beside the picture;
/// where that must not lose its shadow, only the warp may follow an older picture
/// ([`late_near`](super::near_plane::late_near)), not the range.
pub const VISIBLE_MARGIN: f64 = 0.1;

impl VisibleDepths {
    /// The part of near..far to split and to focus on: from nearest · (1 − margin) to farthest · (1 + margin), never
    /// outside near..far.
    ///
    /// Use a margin of 0 for depths of the same picture, [`VISIBLE_MARGIN`] for those of the one before. Pixels outside
    /// the result have no shadows: only depths that were measured may shorten a range. Measurements that make no
    /// interval with near..far (NaN, an empty picture, everything beyond far) and negative or NaN margins shorten
    /// nothing.
    pub fn range(&self, near: f64, far: f64, margin: f64) -> (f64, f64) {
        if !(self.nearest <= self.farthest && margin >= 0.0) {
            return (near, far);
        }
        // `max` and `min` drop NaN.
        let nearest = (self.nearest - self.nearest.abs() * margin).max(near);
        let farthest = (self.farthest + self.farthest.abs() * margin).min(far);
        if nearest < farthest {
            (nearest, farthest)
        } else {
            (near, far)
        }
    }
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
