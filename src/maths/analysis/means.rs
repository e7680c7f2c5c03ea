//! Means of the error over a whole view frustum, beside its largest value.
//!
//! Lloyd et al. 2006, section 3.3, names the norms L1 and L2 and decides for L∞, because a mean allows outliers. As a
//! diagnostic they tell how typical the largest error is: a map whose mean is far below its largest error is bad in a
//! small part of the view only.
//!
//! Means are over the volume of the frustum: every cubic metre counts the same, so a view depth z counts with z².

use bevy_math::DVec3;

use super::{
    direction::{TiltedWarp, Unanalysable, frustum_map},
    overhead::OverheadRange,
};
use crate::maths::{error::AxisErrors, view::ViewVolume};

/// Means of m_x and m_z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanErrors {
    /// L1: the mean.
    pub mean: AxisErrors,
    /// L2: the root of the mean square. Never below the mean, never above the largest error.
    pub root_mean_square: AxisErrors,
}

/// Means for the sun overhead, in closed form. `warp_near` is n' in metres, infinite for no warp.
///
/// With m_x = f (p + q z) ÷ z and m_z = c (p + q z)² ÷ z, where p + q z is the width of the warp frustum relative to its
/// far end ([`error_across`](crate::maths::error::error_across), [`error_along`](crate::maths::error::error_along)), the
/// integrals of the errors and their squares times z² are those of polynomials.
pub fn overhead_mean_errors(range: &OverheadRange, warp_near: f64) -> MeanErrors {
    let (near, far) = (range.near(), range.far());
    let bend = 1.0 / warp_near;
    let stretch = 1.0 + (far - near) * bend;
    let (p, q) = ((1.0 - near * bend) / stretch, bend / stretch);
    let along = (far - near) / range.opening() * stretch;
    // Mean over the volume of a polynomial in z that is the error, or its square, times z².
    let volume = far.powi(3) - near.powi(3);
    let mean = |coefficients: &[f64]| {
        let terms = coefficients.iter().enumerate().map(|(power, coefficient)| {
            let power = power as i32 + 1;
            coefficient * (far.powi(power) - near.powi(power)) / f64::from(power)
        });
        3.0 * terms.sum::<f64>() / volume
    };
    MeanErrors {
        mean: AxisErrors {
            across: far * mean(&[0.0, p, q]),
            along: along * mean(&[0.0, p * p, 2.0 * p * q, q * q]),
        },
        root_mean_square: AxisErrors {
            across: far * mean(&[p * p, 2.0 * p * q, q * q]).sqrt(),
            along: along
                * mean(&[
                    p.powi(4),
                    4.0 * p.powi(3) * q,
                    6.0 * (p * q).powi(2),
                    4.0 * p * q.powi(3),
                    q.powi(4),
                ])
                .sqrt(),
        },
    }
}

/// Means for any light direction, by Gaussian quadrature: five points in each direction, over panels of view depth whose
/// ends differ by no more than a factor of two.
pub fn mean_errors(view: &ViewVolume, light_travel: DVec3, warp: TiltedWarp) -> Result<MeanErrors, Unanalysable> {
    let map = frustum_map(view, light_travel, warp)?;
    let (near, far) = (view.near(), view.far());
    let panels = (far / near).log2().ceil().max(1.0);
    let ends = |panel: f64| near * (far / near).powf(panel / panels);
    let (mut volume, mut sums, mut squares) = (0.0, [0.0; 2], [0.0; 2]);
    for panel in 0..panels as usize {
        let (start, end) = (ends(panel as f64), ends(panel as f64 + 1.0));
        for (along, depth_weight) in GAUSS {
            let depth = start + (end - start) * along;
            let corners = view.corners(depth, depth);
            for (right, right_weight) in GAUSS {
                for (up, up_weight) in GAUSS {
                    let point = corners[0]
                        .lerp(corners[1], right)
                        .lerp(corners[3].lerp(corners[2], right), up);
                    let weight = depth_weight * right_weight * up_weight * depth * depth * (end - start);
                    let errors = map.errors(view, point);
                    volume += weight;
                    for (index, error) in [errors.across, errors.along].into_iter().enumerate() {
                        sums[index] += weight * error;
                        squares[index] += weight * error * error;
                    }
                }
            }
        }
    }
    let errors = |[across, along]: [f64; 2]| AxisErrors { across, along };
    Ok(MeanErrors {
        mean: errors(sums.map(|sum| sum / volume)),
        root_mean_square: errors(squares.map(|square| (square / volume).sqrt())),
    })
}

/// Places in 0..1 and weights of the five-point rule, which is exact for polynomials up to the ninth degree.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_095),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_095),
];
