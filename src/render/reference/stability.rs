//! Stability of sequences: [`crawl`] of shadow masks, [`Pop`] of any pictures.
//!
//! # Crawl energy
//!
//! A shadow may be wrong, but what does not move in the world must not move in the picture. A mask m of frame i is
//! compared with the mask of the frame before, carried along with the surfaces that it lies on:
//!
//! ```text
//! x  = e_i + d_i(p) · ray_i(p)              the surface at pixel p: eye, view depth, ray
//! q  = project_{i−1}(x)                     where the frame before saw it, in pixels
//! Δ  = m_i(p) − Σ_k w_k m_{i−1}(q_k)        q_k, w_k: the four pixels around q and their bilinear weights
//! E  = 1/N · Σ_p Δ²                         over the N pixels that are compared; masks are 0..=1
//! ```
//!
//! A pixel is compared when it is valid, when all four q_k are valid and have the same truth as p (so that what truth
//! itself changes does not count), and when x is what the frame before saw there: 1/depth, bilinear in the picture
//! (exact on planes), agrees with the depth of x within [`DEPTH_TOLERANCE`]. Surfaces that were hidden or outside the
//! picture are not compared.
//!
//! Why bilinear: at an edge of a hard mask that is fixed to the ground, the nearest pixel of the frame before lies on
//! the other side for a quarter of the pixels along the edge (mean over all offsets of the two pixel grids); with
//! bilinear weights the mean of Δ² is a sixth. A mask that agrees with truth has E = 0 for any motion, because all five
//! pixels then have one value. What is left is the *residue* of a mask that is wrong but fixed to the ground: 1/6 on
//! average for every pixel of length of those edges that are out of place; none while the camera stands still. It must
//! not be taken for crawl, hence a second, blunter number that has no residue:
//!
//! ```text
//! C  = 1/N · Σ_p (distance of m_i(p) from the interval of the four m_{i−1}(q_k))²
//! ```
//!
//! C is zero for every mask that is fixed to surfaces and has no feature of less than a pixel, and sees only what moves
//! by more than resampling could: crawl lies between C and E. While the camera stands still, both are the same.
//!
//! # Pop energy
//!
//! E_i = 1/N · Σ_p (l_i(p) − l_{i−1}(p))², the squared change from frame to frame of a picture or a mask with values of
//! 0..=1. A change by Δ at once costs Δ² in one frame; spread over n frames it costs n · (Δ/n)² = Δ²/n in all, and
//! Δ²/n² in the worst frame. Whatever else moves in the picture counts too: compare rivals on the same path, at the
//! same interval, with the same driver.

use std::ops::AddAssign;

use bevy::math::{DVec2, DVec3, IVec2, UVec2};

use super::pixels::{EDGE_STEP, PixelRays, PixelTruth};

/// Depths that differ at most by this share belong to one surface; the share that makes an edge between neighbors.
pub const DEPTH_TOLERANCE: f64 = EDGE_STEP;

/// Neighbors with less weight do not count: a place on a pixel's center is that pixel's alone, whatever rounding does.
const SMALLEST_WEIGHT: f64 = 1.0e-6;

/// A shadow mask with what is known about its pixels. All lists have row 0 on top.
#[derive(Clone, Copy, Debug)]
pub struct MaskFrame<'a> {
    /// The camera and the size in pixels.
    pub rays: PixelRays,
    /// 255 lit, 0 in shadow.
    pub mask: &'a [u8],
    /// View depth in metres; 0 where there is nothing.
    pub depths: &'a [f32],
    /// Truth at the time of this frame.
    pub truth: &'a [PixelTruth],
}

/// What changed at one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Δ².
    pub squared: f64,
    /// The part that resampling cannot explain, squared.
    pub certain: f64,
}

/// Sums over the pixels of one or more steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Crawl {
    /// Pixels of the pictures.
    pub pixels: u64,
    /// Those that could be compared.
    pub compared: u64,
    /// Sum of Δ².
    pub squared: f64,
    /// Sum of the parts that resampling cannot explain, squared.
    pub certain: f64,
}

impl Crawl {
    /// Sums up one step.
    pub fn of(changes: &[Option<Change>]) -> Self {
        let mut sum = Self {
            pixels: changes.len() as u64,
            ..Self::default()
        };
        for change in changes.iter().flatten() {
            sum.compared += 1;
            sum.squared += change.squared;
            sum.certain += change.certain;
        }
        sum
    }

    /// E: mean of Δ² over the pixels that were compared; 0 where none was.
    pub fn energy(&self) -> f64 {
        self.per_pixel(self.squared)
    }

    /// C: the same of the part that resampling cannot explain.
    pub fn certain_energy(&self) -> f64 {
        self.per_pixel(self.certain)
    }

    /// Share of pixels that were compared, 0..=1.
    pub fn compared_share(&self) -> f64 {
        self.compared as f64 / self.pixels.max(1) as f64
    }

    fn per_pixel(&self, sum: f64) -> f64 {
        sum / self.compared.max(1) as f64
    }
}

impl AddAssign for Crawl {
    fn add_assign(&mut self, step: Self) {
        self.pixels += step.pixels;
        self.compared += step.compared;
        self.squared += step.squared;
        self.certain += step.certain;
    }
}

/// The crawl of one step, pixel by pixel of the later frame; `None` where a pixel cannot be compared. Frames whose
/// lists do not fill their size have `None` at what is missing.
pub fn crawl(before: &MaskFrame, after: &MaskFrame) -> Vec<Option<Change>> {
    let (width, height) = (after.rays.size.x as usize, after.rays.size.y as usize);
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| change_at(before, after, x, y))
        .collect()
}

fn change_at(before: &MaskFrame, after: &MaskFrame, x: usize, y: usize) -> Option<Change> {
    let index = y * after.rays.size.x as usize + x;
    let truth = *after.truth.get(index)?;
    let (mask, depth) = (value(*after.mask.get(index)?), f64::from(*after.depths.get(index)?));
    if !truth.is_valid() {
        return None;
    }
    let point_world = after.rays.eye + after.rays.direction(x as f64 + 0.5, y as f64 + 0.5) * depth;
    let (place_px, depth_before) = project(&before.rays, point_world)?;
    let taps = taps(place_px - 0.5);
    let (mut difference, mut inverse_depth, mut weights) = (0.0, 0.0, 0.0);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for (pixel, weight) in taps.into_iter().filter(|(_, weight)| *weight > SMALLEST_WEIGHT) {
        let index = index_of(before, pixel)?;
        if *before.truth.get(index)? != truth {
            return None;
        }
        let tap = value(*before.mask.get(index)?);
        difference += weight * (mask - tap);
        inverse_depth += weight / f64::from(*before.depths.get(index)?);
        weights += weight;
        (least, most) = (least.min(tap), most.max(tap));
    }
    let is_same_surface = (inverse_depth / weights * depth_before - 1.0).abs() <= DEPTH_TOLERANCE;
    is_same_surface.then(|| Change {
        squared: (difference / weights).powi(2),
        certain: (mask - mask.clamp(least, most)).powi(2),
    })
}

/// The four pixels around a place, given from the first pixel's center, with their bilinear weights.
fn taps(place: DVec2) -> [(IVec2, f64); 4] {
    let corner = place.floor();
    let share = place - corner;
    let at = |dx: i32, dy: i32| {
        let weight = |step: i32, share: f64| if step == 0 { 1.0 - share } else { share };
        (
            corner.as_ivec2().saturating_add(IVec2::new(dx, dy)),
            weight(dx, share.x) * weight(dy, share.y),
        )
    };
    [at(0, 0), at(1, 0), at(0, 1), at(1, 1)]
}

/// Where a camera sees a point of the world: pixels, y down, pixel centers at halves; and its view depth in metres.
/// `None` behind the camera.
fn project(rays: &PixelRays, point_world: DVec3) -> Option<(DVec2, f64)> {
    let offset = point_world - rays.eye;
    let depth = offset.dot(rays.forward);
    let size = rays.size.as_dvec2();
    let scale = depth * rays.tan_half_fov_y;
    let ndc = DVec2::new(
        offset.dot(rays.right) / (scale * size.x / size.y),
        offset.dot(rays.up) / scale,
    );
    let place_px = DVec2::new(ndc.x + 1.0, 1.0 - ndc.y) / 2.0 * size;
    (depth > 0.0 && place_px.is_finite()).then_some((place_px, depth))
}

fn index_of(frame: &MaskFrame, pixel: IVec2) -> Option<usize> {
    let pixel = UVec2::try_from(pixel).ok()?;
    let is_inside = pixel.cmplt(frame.rays.size).all();
    is_inside.then(|| pixel.y as usize * frame.rays.size.x as usize + pixel.x as usize)
}

fn value(mask: u8) -> f64 {
    f64::from(mask) / 255.0
}

/// Pop energy of a sequence.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pop {
    /// E_i of every step from one frame to the next.
    pub steps: Vec<f64>,
}

impl Pop {
    /// Of frames with values of 0..=1. Frames of different lengths are compared as far as both go; a step without
    /// pixels has the energy 0.
    pub fn of<F: AsRef<[f32]>>(frames: &[F]) -> Self {
        let step = |before: &[f32], after: &[f32]| {
            let count = before.len().min(after.len()).max(1);
            let squared = |(a, b): (&f32, &f32)| (f64::from(*b) - f64::from(*a)).powi(2);
            before.iter().zip(after).map(squared).sum::<f64>() / count as f64
        };
        Self {
            steps: frames
                .windows(2)
                .map(|pair| step(pair[0].as_ref(), pair[1].as_ref()))
                .collect(),
        }
    }

    /// Sum over all steps.
    pub fn total(&self) -> f64 {
        self.steps.iter().sum()
    }

    /// Mean over all steps; 0 without any.
    pub fn mean(&self) -> f64 {
        self.total() / self.steps.len().max(1) as f64
    }

    /// The worst step: the frame that it leads to, counted from 0, and its energy. `None` without steps.
    pub fn peak(&self) -> Option<(usize, f64)> {
        let (step, energy) = self.steps.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
        Some((step + 1, *energy))
    }
}

/// Luma of 8-bit RGBA as it is shown (Rec. ITU-R BT.709, not linearized: equal steps look about equal), 0..=1.
pub fn luma(rgba: &[u8]) -> Vec<f32> {
    let (pixels, _) = rgba.as_chunks::<4>();
    pixels
        .iter()
        .map(|[r, g, b, _]| (0.2126 * f32::from(*r) + 0.7152 * f32::from(*g) + 0.0722 * f32::from(*b)) / 255.0)
        .collect()
}
