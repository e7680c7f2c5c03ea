//! Texels per pixel, as numbers and as colors: the CPU twin of `shaders/heat_map/sampling_rate.wgsl`.
//!
//! Stingl 2011 measures what is drawn, projection aliasing included, by how far one step of the picture goes in the map
//! (section 5.7, figure 5.6, listing A.3). With S the texel coordinates of the map in which a pixel is looked up, and X, Y
//! those of the picture, the derivatives of S are the Jacobian, and the measures are its determinant and its rows' lengths:
//!
//! ```text
//!     ⎛ ∂S_x÷∂X  ∂S_x÷∂Y ⎞      area    |det J| = |∂S_x÷∂X · ∂S_y÷∂Y − ∂S_x÷∂Y · ∂S_y÷∂X|
//! J = ⎜                  ⎟      across  √((∂S_x÷∂X)² + (∂S_x÷∂Y)²)                             x of the map
//!     ⎝ ∂S_y÷∂X  ∂S_y÷∂Y ⎠      along   √((∂S_y÷∂X)² + (∂S_y÷∂Y)²)                             y of the map
//! ```
//!
//! J = T⁻¹ P on the surface, with the steps T of a texel and P of a pixel of [`footprint`](super::footprint): the inverse of
//! the texel in pixels that [`TexelsOnPixels`] measures. The inverse of a matrix with the columns a, b has the rows b and a,
//! turned by a right angle, over the determinant, so that all three follow from its lengths ([`TexelsOnPixels::per_pixel`]).
//!
//! Beware of two things. The caption of the thesis's figure calls the number pixel to texel; its code, and this, has texels
//! per pixel: *small* is under-sampled. And the area is a ratio of areas, the others of lengths: twice as coarse a map halves
//! those and quarters the area.
//!
//! # Compared with the errors m
//! With the sun overhead, on the view axis and on a surface across the bisector of both beams, J is diagonal: across = 1 ÷ m_x,
//! along = 1 ÷ m_z, area = 1 ÷ (m_x m_z) with the errors of [`error`](super::error) at the resolutions of picture and map.
//! On a surface that is tilted about the map's x axis, along is cos θ_l ÷ cos θ_i as much. Off the view axis warps shear
//! texels: then a row of J is 1 ÷ the *distance* of two texel borders, no more 1 ÷ the length of a texel's side.

use bevy_math::Vec3;

use super::footprint::TexelsOnPixels;

/// Which of the numbers of the Jacobian is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum RateMeasure {
    /// Texels in the area of a pixel.
    #[default]
    Area,
    /// Texels per pixel in the map's x direction.
    Across,
    /// Texels per pixel in the map's y direction.
    Along,
}

impl RateMeasure {
    /// All, in the order of the thesis.
    pub const ALL: [Self; 3] = [Self::Area, Self::Across, Self::Along];
}

/// Texels of the map per pixel of the picture, on a surface. Below 1: under-sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelsPerPixel {
    /// |det J|: texels in the area of a pixel.
    pub area: f64,
    /// Length of the first row of J: how fast the map's x coordinate changes over the picture at most, in texels per pixel.
    pub across: f64,
    /// Length of the second row: the same of the map's y coordinate.
    pub along: f64,
}

impl TexelsPerPixel {
    /// One of the three.
    pub fn get(&self, measure: RateMeasure) -> f64 {
        match measure {
            RateMeasure::Area => self.area,
            RateMeasure::Across => self.across,
            RateMeasure::Along => self.along,
        }
    }
}

impl TexelsOnPixels {
    /// Texels per pixel (Stingl, listing A.3), with a, b the steps of a texel in pixels: |det J| = 1 ÷ |det (a b)|, rows of the
    /// lengths |b| ÷ |det (a b)| and |a| ÷ |det (a b)|.
    pub fn per_pixel(&self) -> TexelsPerPixel {
        TexelsPerPixel {
            area: 1.0 / self.area,
            across: self.along / self.area,
            along: self.across / self.area,
        }
    }
}

/// Colors of some numbers of texels per pixel: red is under-sampled, green as fine as the picture, blue over-sampled (Stingl,
/// figure 5.6). As the screen shows them, so sRGB.
pub const RATE_KNOTS: [(f32, Vec3); 7] = [
    (0.0, Vec3::new(0.2, 0.0, 0.0)),
    (1.0 / 7.75, Vec3::new(1.0, 0.2, 0.0)),
    (1.0 / 3.25, Vec3::new(1.0, 1.0, 0.0)),
    (1.0, Vec3::new(0.0, 1.0, 0.0)),
    (3.25, Vec3::new(0.3, 0.8, 1.0)),
    (7.75, Vec3::new(0.0, 0.0, 1.0)),
    (10.0, Vec3::new(0.0, 0.0, 0.4)),
];

/// The color of texels per pixel, sRGB: straight lines between [`RATE_KNOTS`] over the number itself, not its logarithm.
/// From 10 on that of the last knot; less than nothing and not a number count as 0.
pub fn rate_color(texels_per_pixel: f32) -> Vec3 {
    let mut color = RATE_KNOTS[0].1;
    for pair in RATE_KNOTS.windows(2) {
        let ((start, _), (end, end_color)) = (pair[0], pair[1]);
        // 1 beyond the interval, which leaves its end; 0 before it, which changes nothing.
        let share = ((texels_per_pixel - start) / (end - start)).max(0.0).min(1.0);
        color = color.lerp(end_color, share);
    }
    color
}
