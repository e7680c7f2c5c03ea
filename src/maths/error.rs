//! Aliasing error of light views: texel footprint over pixel footprint (Lloyd et al. 2006; Stingl, section 2.3.3).
//!
//! An error above 1 is under-sampling, below 1 over-sampling. All functions leave out the ratio of resolutions: multiply
//! by picture pixels ÷ map texels of the respective axis ([`AxisErrors::at_resolution`]).
//!
//! Two sizes make the error: how far apart the beams of texels and pixels are where they meet (perspective aliasing, the
//! same on every surface), and how the surface is turned to both (projection aliasing, without bound where the light
//! grazes it). Everything here but [`simple_error`] and [`accurate_error`] is about the first: the second cannot be mended
//! by a choice of maps without knowing the scene, and where it is largest the surface gets little light (Lloyd, section
//! 3.2). Maps are compared by their *largest* error over everything that may be visible, not by a mean, which would hide
//! outliers (Lloyd, section 3.3). A map with the larger largest error can still be the better picture if nothing is seen
//! where it is bad: the norm is a promise, not a difference of pictures.

use bevy_math::{DVec2, UVec2};

/// The errors of a map at one point, or anything else that has one number per axis of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisErrors {
    /// m_x: across the warp axis.
    pub across: f64,
    /// m_z: along the warp axis.
    pub along: f64,
}

impl AxisErrors {
    /// The same errors for resolutions that are not equal: texel ÷ pixel for a picture of square pixels and a map.
    /// Texels that the map keeps free at its border do not count: leave them out of `map_size`.
    pub fn at_resolution(self, picture_size: UVec2, map_size: UVec2) -> Self {
        let ratio = picture_size.as_dvec2() / map_size.as_dvec2();
        Self {
            across: self.across * ratio.x,
            along: self.along * ratio.y,
        }
    }

    /// The larger of both.
    pub fn largest(self) -> f64 {
        self.across.max(self.along)
    }
}

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
    /// Of a map that nobody looks up.
    pub const NONE: Self = Self {
        across: 0.0,
        along: 0.0,
    };

    /// The storage factor S̄ = M_x · M_z: texels needed per picture pixel for no error above 1 (Lloyd, equation 12).
    pub fn storage_factor(&self) -> f64 {
        self.across * self.along
    }

    /// The critical resolution res_s*, res_t*: texels across and along with which no error exceeds 1, for a picture of
    /// `picture_side` pixels per side (Lloyd, section 4.2).
    pub fn critical_resolution(&self, picture_side: f64) -> DVec2 {
        DVec2::new(self.across, self.along) * picture_side
    }

    /// The sides res_s, res_t of a map of `texels` texels that has the same largest error on both axes (Lloyd, equations
    /// 13 and 14). Not rounded; their product is `texels`. Not finite where an error is zero.
    pub fn balanced_resolution(&self, texels: f64) -> DVec2 {
        let aspect = self.across / self.along;
        DVec2::new((texels * aspect).sqrt(), (texels / aspect).sqrt())
    }

    /// The largest error on both axes of that map: res_i √(S̄ ÷ S_0), with `pixels` = res_i² pixels in the picture. From
    /// equations 13 and 14: M_x = √(S̄) res_i ÷ √(S_0) · √(M_x ÷ M_z) · √(M_z ÷ M_x).
    pub fn balanced_error(&self, texels: f64, pixels: f64) -> f64 {
        (self.storage_factor() * pixels / texels).sqrt()
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

/// A map that is fitted around samples, for any light direction: what it makes of every point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedMap {
    /// Light-space y where the map begins.
    start: f64,
    /// d: its extent along the warp axis.
    extent: f64,
    /// Extent across the warp axis at the map's near end.
    window: f64,
    warp_near: f64,
    opening: f64,
}

impl FittedMap {
    /// The smallest map around the samples. `warp_near` (n') may be infinite; `opening` is 2 tan Θ. Without samples the
    /// map is empty and its errors are not finite.
    pub fn around(samples: &[LightSample], warp_near: f64, opening: f64) -> Self {
        let start = samples.iter().map(|sample| sample.along).fold(f64::INFINITY, f64::min);
        let end = samples
            .iter()
            .map(|sample| sample.along)
            .fold(f64::NEG_INFINITY, f64::max);
        let (left, right) = samples
            .iter()
            .map(|sample| sample.across / (1.0 + (sample.along - start) / warp_near))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(left, right), across| {
                (left.min(across), right.max(across))
            });
        Self {
            start,
            extent: end - start,
            window: right - left,
            warp_near,
            opening,
        }
    }

    /// The errors at a point: m_x = w_lx ÷ w_i and m_z = w_lz ÷ w_i with the pixel w_i = 2 tan Θ · depth, the texel across
    /// w_lx = u · window and along w_lz = u² d ÷ u_far, where u = 1 + y ÷ n' is the width of the warp frustum relative to
    /// its near end (Lloyd, equations 2 to 4 without the ratio of resolutions). Off the warp axis texels are sheared; the
    /// errors leave that out, as the paper does.
    pub fn at(&self, sample: &LightSample) -> AxisErrors {
        let width = 1.0 + (sample.along - self.start) / self.warp_near;
        let far_width = 1.0 + self.extent / self.warp_near;
        let pixel = self.opening * sample.depth;
        AxisErrors {
            across: width * self.window / pixel,
            along: width * width * self.extent / (far_width * pixel),
        }
    }
}

/// The largest errors of a light view that is fitted around the samples, for any light direction (Lloyd, section 4.4).
///
/// Exact for the convex hull of the samples, because both errors are quasi-convex. Samples must have positive depth;
/// `warp_near` (n') may be infinite; `opening` is 2 tan Θ.
pub fn largest_errors(samples: &[LightSample], warp_near: f64, opening: f64) -> LargestErrors {
    let map = FittedMap::around(samples, warp_near, opening);
    largest_errors_at(&map, samples)
}

/// The largest errors of a map over some points, which need not be those that it was fitted around.
pub fn largest_errors_at(map: &FittedMap, samples: &[LightSample]) -> LargestErrors {
    let mut largest = LargestErrors {
        across: 0.0,
        along: 0.0,
    };
    for errors in samples.iter().map(|sample| map.at(sample)) {
        largest.across = largest.across.max(errors.across);
        largest.along = largest.along.max(errors.along);
    }
    largest
}

/// dp ÷ ds: how many pixels of picture p a unit of map s covers (Stingl, equation 2.1), for the sun overhead.
///
/// `depth_per_map` is dz ÷ ds: metres of view depth per unit of the map. The cosines are those between the surface normal
/// and the directions to the eye (α) and to the light (β): their quotient is the projection aliasing, the rest the
/// perspective aliasing. Infinite or NaN where the surface is edge-on to the light.
pub fn simple_error(depth: f64, depth_per_map: f64, cosine_to_eye: f64, cosine_to_light: f64) -> f64 {
    depth_per_map / depth * (cosine_to_eye / cosine_to_light)
}

/// One of the two beams that meet on a surface: through a pixel from the eye, or through a texel from the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beam {
    /// r: pixels or texels along the axis of interest.
    pub resolution: f64,
    /// dG ÷ dt: how much faster than evenly the picture or map moves over its plane here; 1 unless it is warped.
    pub stretch: f64,
    /// W: width of the image plane, in metres, at [`Self::plane_depth`].
    pub plane_width: f64,
    /// n: depth of the image plane, in metres.
    pub plane_depth: f64,
    /// d: depth of the surface point, in metres, along the normal of the image plane (not its distance: the printed powers
    /// of cos φ are right for depths only). For parallel beams the same as [`Self::plane_depth`].
    pub depth: f64,
    /// cos φ: between the beam and the normal of the image plane.
    pub plane_cosine: f64,
    /// cos ψ: between the beam and the normal of the surface.
    pub surface_cosine: f64,
}

impl Beam {
    /// w': length of the beam's footprint on the surface, in metres, in the plane of both angles. The plane of the image
    /// at the point's depth has W d ÷ n ÷ r metres per pixel; across the beam that is cos φ as much, on the surface
    /// 1 ÷ cos ψ as much again. Infinite or NaN where the surface is edge-on.
    pub fn footprint(&self) -> f64 {
        let on_plane = self.stretch * self.plane_width / self.resolution * (self.depth / self.plane_depth);
        on_plane * self.plane_cosine / self.surface_cosine
    }
}

/// m: the accurate aliasing error for any light and surface (Lloyd 2007, in Stingl, equation 2.2, where ψ_l is printed
/// twice): footprint of the light's beam ÷ that of the eye's. Along one axis; both beams and the surface normal lie in one
/// plane. Infinite or NaN where the surface is edge-on to the light.
pub fn accurate_error(light: &Beam, eye: &Beam) -> f64 {
    light.footprint() / eye.footprint()
}
