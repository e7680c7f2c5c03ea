//! Blur of the shadow result on the screen: the CPU twin of `shaders/blur/eye_blur.wgsl`.
//!
//! Scherzer 2005, section 4.3, hides the stripes of projection aliasing by blurring the screen-sized shadow result up
//! to 16 times, more near the viewer than far away. The paper names neither kernel nor function of depth; here:
//!
//! - One iteration is \[1 2 1] ÷ 4 along the rows, then along the columns: variance i ÷ 2 pixels² per axis after i of
//!   them.
//! - Artefacts have a size in the world, so their size on the screen falls with 1 ÷ z and the variance that hides them
//!   with 1 ÷ z²: a pixel takes part in [`iterations_at`] its depth. A last iteration may count in part, so that no
//!   ring of pixels is seen where the number changes.
//! - Neighbours exchange values only where both lie on one surface ([`is_same_surface`]): nothing crosses an edge of
//!   depth or normals, and sky keeps out.
//! - Two neighbours exchange with the smaller of both strengths, and what a pixel does not take from a neighbour it
//!   keeps of its own. So every iteration is a diffusion: values stay in 0..=1, their sum over the picture is
//!   unchanged, even along edges, and a constant stays a constant. (Renormalising by accepted weights would keep only
//!   the first and last.)
//!
//! A filter, not a soft shadow: it knows no penumbra.

use bevy_math::Vec3;

/// The largest number of iterations (Scherzer, figure 8).
pub const MAX_ITERATIONS: u32 = 16;

/// Cosine of the largest angle between normals of one surface: 25°.
pub const SAME_SURFACE_COSINE: f32 = 0.9;

/// Distance of a neighbour from the pixel's plane up to which both are on one surface, as a share of view depth.
pub const LARGEST_STEP: f32 = 0.002;

/// Shares of an iteration below this are none: far pixels are bit-identical to the unblurred ones.
const LEAST_SHARE: f32 = 0.05;

/// What the blur knows of a pixel's surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EyePixel {
    /// World-space position, metres.
    pub position: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Distance along the view direction, metres; 0 for sky.
    pub view_depth: f32,
}

/// How much to blur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EyeBlur {
    /// Iterations of near pixels, 0..=[`MAX_ITERATIONS`].
    pub iterations: u32,
    /// View depth up to which pixels take part in all of them, metres; infinite: no dependence on depth.
    pub full_depth: f32,
}

/// Iterations in which a pixel takes part, a fraction included: all up to `full_depth`, then as the square of depth, so
/// that the kernel's size in the world stays.
pub fn iterations_at(blur: &EyeBlur, view_depth: f32) -> f32 {
    if view_depth <= 0.0 {
        return 0.0;
    }
    let nearness = (blur.full_depth / view_depth).min(1.0);
    let iterations = blur.iterations.min(MAX_ITERATIONS) as f32 * nearness * nearness;
    if iterations < LEAST_SHARE { 0.0 } else { iterations }
}

/// Strength of one iteration at a pixel, 0..=1. `iteration` counts from 0.
pub fn strength(blur: &EyeBlur, view_depth: f32, iteration: u32) -> f32 {
    (iterations_at(blur, view_depth) - iteration as f32).clamp(0.0, 1.0)
}

/// Whether two neighbouring pixels show one surface: similar normals, and each near the plane of the other.
pub fn is_same_surface(a: &EyePixel, b: &EyePixel) -> bool {
    let step = b.position - a.position;
    let off_plane = a.normal.dot(step).abs().max(b.normal.dot(step).abs());
    a.view_depth > 0.0
        && b.view_depth > 0.0
        && a.normal.dot(b.normal) >= SAME_SURFACE_COSINE
        && off_plane <= LARGEST_STEP * a.view_depth.min(b.view_depth)
}

/// Weight with which a pixel takes the value of a neighbour.
pub fn exchange(blur: &EyeBlur, pixel: &EyePixel, neighbour: &EyePixel, iteration: u32) -> f32 {
    if is_same_surface(pixel, neighbour) {
        0.25 * strength(blur, pixel.view_depth, iteration).min(strength(blur, neighbour.view_depth, iteration))
    } else {
        0.0
    }
}

/// A picture of pixels and shadow results, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct EyePicture {
    /// Pixels per row.
    pub width: usize,
    /// Surfaces.
    pub pixels: Vec<EyePixel>,
    /// 1 lit, 0 in shadow.
    pub visibility: Vec<f32>,
}

impl EyePicture {
    /// One pass: half an iteration. `axis`: 0 along the rows, 1 along the columns.
    pub fn pass(&self, blur: &EyeBlur, iteration: u32, axis: usize) -> Vec<f32> {
        let height = self.pixels.len() / self.width.max(1);
        let stride = if axis == 0 { 1 } else { self.width };
        let size = if axis == 0 { self.width } else { height };
        (0..self.pixels.len())
            .map(|index| {
                let place = index / stride % size;
                let own = self.visibility[index];
                let mut result = own;
                if place > 0 {
                    result +=
                        self.share(blur, iteration, index, index - stride) * (self.visibility[index - stride] - own);
                }
                if place + 1 < size {
                    result +=
                        self.share(blur, iteration, index, index + stride) * (self.visibility[index + stride] - own);
                }
                result
            })
            .collect()
    }

    fn share(&self, blur: &EyeBlur, iteration: u32, pixel: usize, neighbour: usize) -> f32 {
        exchange(blur, &self.pixels[pixel], &self.pixels[neighbour], iteration)
    }

    /// The whole blur.
    pub fn blurred(mut self, blur: &EyeBlur) -> Self {
        for iteration in 0..blur.iterations.min(MAX_ITERATIONS) {
            for axis in 0..2 {
                self.visibility = self.pass(blur, iteration, axis);
            }
        }
        self
    }
}
