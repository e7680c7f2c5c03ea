//! The shadow result blended with that of the frame before, carried along with the surfaces: the CPU twin of
//! `shaders/history/blend_history.wgsl`.
//!
//! What the eye sees of crawl is the change from frame to frame. With m the new result, h the history at the same point of
//! the world and N frames, the blend and its change are
//!
//! ```text
//! b = h + (m − h) ÷ N      b − h = (m − h) ÷ N
//! ```
//!
//! A result that flips between 0 and 1 in every frame changes by 1/N instead of 1, its square by 1/N²; one that jumps once
//! changes by (1 − 1/N)^k ÷ N in the k-th frame after it, and the sum of all squares is 1 ÷ (2N − 1).
//!
//! The history is bilinear between four pixels, so that a picture that is carried along changes by nothing but its own
//! resampling; what is thinner than a pixel is worn away by it, more the longer it lives. It is limited to least and greatest of
//! the new result within [`REACH`] pixels: where nothing in the new result has an edge, nothing of the old one is left, and a
//! shadow that has really moved leaves no trail.
//!
//! After Scherzer et al. 2007 (*Pixel-Correct Shadow Maps with Temporal Reprojection and Shadow Test Confidence*), who weigh
//! every new value by how near it lies to the middle of its texel, and so converge to the picture of infinitely fine maps
//! while the camera moves. Measured on thin rails (see [`stable`](super)), weights of that kind crawl more at the same
//! sharpness than a fixed share.

use bevy_math::{DMat4, DVec2, DVec3, DVec4, IVec2, UVec2, Vec4Swizzles};

/// Pixels to each side in which the new result limits the history: as far as a map that is fitted anew moves an edge.
pub const REACH: i32 = 2;

/// View depths that differ at most by this share belong to one surface.
pub const DEPTH_TOLERANCE: f64 = 0.005;

/// Neighbors with less weight do not count.
const SMALLEST_WEIGHT: f64 = 1.0e-5;

/// A frame that has been blended. Row 0 is on top.
#[derive(Clone, Copy, Debug)]
pub struct BlendedFrame<'a> {
    /// Pixels per row and column.
    pub size: UVec2,
    /// World to clip space.
    pub clip_from_world: DMat4,
    /// View depth: dot product with a world-space point and 1.
    pub view_depth_from_world: DVec4,
    /// 1 lit, 0 in shadow.
    pub visibility: &'a [f32],
    /// Metres; 0 for sky.
    pub view_depths: &'a [f32],
}

impl BlendedFrame<'_> {
    /// What the frame holds at a point of the world; `None` where it did not see it.
    pub fn visibility_at(&self, point_world: DVec3) -> Option<f64> {
        let clip = self.clip_from_world * point_world.extend(1.0);
        if !(clip.w > 0.0) {
            return None;
        }
        let place = (clip.xy() / clip.w * DVec2::new(0.5, -0.5) + 0.5) * self.size.as_dvec2() - 0.5;
        let corner = place.floor();
        let share = place - corner;
        let (mut sum, mut inverse_depth) = (0.0, 0.0);
        for step in [IVec2::ZERO, IVec2::X, IVec2::Y, IVec2::ONE] {
            let weight = |step: i32, share: f64| if step == 0 { 1.0 - share } else { share };
            let weight = weight(step.x, share.x) * weight(step.y, share.y);
            if weight < SMALLEST_WEIGHT {
                continue;
            }
            let pixel = UVec2::try_from(corner.as_ivec2().saturating_add(step)).ok()?;
            let index = (pixel.y as usize) * self.size.x as usize + pixel.x as usize;
            let is_inside = pixel.cmplt(self.size).all();
            let depth = self.view_depths.get(index).filter(|depth| is_inside && **depth > 0.0)?;
            sum += weight * f64::from(*self.visibility.get(index)?);
            inverse_depth += weight / f64::from(*depth);
        }
        let expected = self.view_depth_from_world.dot(point_world.extend(1.0));
        ((inverse_depth * expected - 1.0).abs() <= DEPTH_TOLERANCE).then_some(sum)
    }
}

/// The new result blended with the frame before, `new_share` of it new (1 ÷ N). `positions`: what every pixel of the new
/// picture sees, in world space; `None` for sky, which is lit. Lists that do not fill the size have pixels missing.
pub fn blend(size: UVec2, own: &[f32], positions: &[Option<DVec3>], before: &BlendedFrame, new_share: f64) -> Vec<f32> {
    let blended = own
        .iter()
        .zip(positions)
        .enumerate()
        .map(|(index, (own_value, position))| {
            let Some(position) = position else {
                return 1.0;
            };
            let Some(history) = before.visibility_at(*position) else {
                return *own_value;
            };
            let (least, greatest) = nearby(size, own, index);
            let history = history.clamp(f64::from(least), f64::from(greatest));
            (history + (f64::from(*own_value) - history) * new_share) as f32
        });
    blended.collect()
}

/// Least and greatest of the new result within [`REACH`] pixels.
fn nearby(size: UVec2, own: &[f32], index: usize) -> (f32, f32) {
    let last = size.as_ivec2() - 1;
    let width = size.x as usize;
    let pixel = IVec2::new((index % width) as i32, (index / width) as i32);
    let reach = -REACH..=REACH;
    let places = reach.clone().flat_map(|y| reach.clone().map(move |x| IVec2::new(x, y)));
    places.fold((1.0, 0.0), |(least, greatest): (f32, f32), step| {
        let place = (pixel + step).clamp(IVec2::ZERO, last).as_uvec2();
        let value = own
            .get(place.y as usize * width + place.x as usize)
            .copied()
            .unwrap_or(1.0);
        (least.min(value), greatest.max(value))
    })
}
