//! Aliasing error of light views: texel footprint over pixel footprint (Lloyd et al. 2006; Stingl, section 2.3.3).
//!
//! An error above 1 is under-sampling, below 1 over-sampling. All functions leave out the ratio of resolutions: multiply
//! by picture pixels ÷ map texels of the respective axis.

/// m_x: error across the warp axis at view depth `depth`, for the sun overhead (Stingl, equation 2.3).
///
/// `warp_near` is n' in metres, infinite for a uniform map; `near` and `far` bound the view frustum that the map covers.
pub fn error_across(depth: f64, warp_near: f64, near: f64, far: f64) -> f64 {
    far * warp_width(depth, warp_near, near, far) / depth
}

/// m_z: error along the warp axis at view depth `depth`, for the sun overhead (Stingl, equation 2.4).
///
/// `opening` is 2 tan Θ: the picture's extent per metre of view depth.
pub fn error_along(depth: f64, warp_near: f64, near: f64, far: f64, opening: f64) -> f64 {
    let width = warp_width(depth, warp_near, near, far);
    let stretch = 1.0 + (far - near) / warp_near;
    (far - near) / opening * width * width * stretch / depth
}

/// Width of the warp frustum at a view depth, relative to its far end: 1 everywhere for an infinite `warp_near`.
fn warp_width(depth: f64, warp_near: f64, near: f64, far: f64) -> f64 {
    (1.0 + (depth - near) / warp_near) / (1.0 + (far - near) / warp_near)
}

/// The largest errors over a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestErrors {
    /// M_x: across the warp axis.
    pub across: f64,
    /// M_z: along the warp axis.
    pub along: f64,
}

impl LargestErrors {
    /// The storage factor S̄ = M_x · M_z: texels needed per picture pixel for no error above 1 (Lloyd, equation 12).
    pub fn storage_factor(&self) -> f64 {
        self.across * self.along
    }
}

/// A point of a body as the error of a light view sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Light-space x, relative to the projection centre, in metres.
    pub across: f64,
    /// Light-space y, along the warp axis, in metres.
    pub along: f64,
    /// View depth in metres; 1 everywhere for an orthographic camera.
    pub depth: f64,
}

/// The largest errors of a light view that is fitted around the samples, for any light direction (Lloyd, section 4.4).
///
/// Exact for the convex hull of the samples, because both errors are quasi-convex. Samples must have positive depth;
/// `warp_near` (n') may be infinite; `opening` is 2 tan Θ.
pub fn largest_errors(samples: &[LightSample], warp_near: f64, opening: f64) -> LargestErrors {
    let start = samples.iter().map(|sample| sample.along).fold(f64::INFINITY, f64::min);
    let end = samples
        .iter()
        .map(|sample| sample.along)
        .fold(f64::NEG_INFINITY, f64::max);
    let width = |sample: &LightSample| 1.0 + (sample.along - start) / warp_near;
    let (left, right) = samples
        .iter()
        .map(|sample| sample.across / width(sample))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(left, right), across| {
            (left.min(across), right.max(across))
        });
    let far_width = 1.0 + (end - start) / warp_near;
    let mut largest = LargestErrors {
        across: 0.0,
        along: 0.0,
    };
    for sample in samples {
        let width = width(sample);
        let pixel = opening * sample.depth;
        largest.across = largest.across.max(width * (right - left) / pixel);
        largest.along = largest.along.max(width * width * (end - start) / (far_width * pixel));
    }
    largest
}
