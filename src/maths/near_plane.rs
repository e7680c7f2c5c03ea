//! The near plane for shadows: by hand, or from the least depth of the picture (Stingl 2011, section 4.3).
//!
//! The nearer the near plane, the larger f ÷ n, and the coarser the map: between the eye and the first thing
//! that is seen, texels are wasted. A GPU reduces the depths of the prepass to their least; [`DepthChain`] is its CPU
//! twin.

use bevy_math::{DVec3, UVec2};

use super::{body::adjusted_depths, bounds::Bounds, polytope::Polytope, view::ViewVolume};

/// Smallest and largest near plane that a control should offer, in metres: up to the adjusted far plane, and down to
/// `smallest` with the eye inside S, else to the adjusted near plane (Stingl, section 4.3). `None` when nothing is
/// seen.
pub fn near_limits(view: &ViewVolume, scene: &Bounds, visible: &Polytope, smallest: f64) -> Option<(f64, f64)> {
    let (near, far) = adjusted_depths(visible, view)?;
    let low = if scene.contains(view.eye(), 0.0) {
        smallest.clamp(0.0, far)
    } else {
        near
    };
    Some((low, far))
}

/// A picture of least and greatest depths at half the size of the one before, down to one texel.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthLevel {
    /// Texels per row and column.
    pub size: UVec2,
    /// Least and greatest view depth of every texel, metres, row by row.
    pub depths: Vec<[f32; 2]>,
}

/// All levels from a picture of depths to one texel (Stingl, appendix A.2).
#[derive(Clone, Debug, PartialEq)]
pub struct DepthChain {
    /// The picture first.
    pub levels: Vec<DepthLevel>,
}

impl DepthLevel {
    /// The next level: size ÷ 2, rounded down, at least 1.
    ///
    /// A texel covers two texels of the source on each axis, the last one three where the source's size is odd:
    /// rounding down never loses a column. (The listing in the thesis reads four texels and assumes even sizes.)
    pub fn reduced(&self) -> Self {
        let size = (self.size / 2).max(UVec2::ONE);
        let last = |place: u32, size: u32, source: u32| {
            if place + 1 == size { source } else { 2 * place + 2 }
        };
        let depths = (0..size.y)
            .flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y)))
            .map(|place| {
                let rows = 2 * place.y..last(place.y, size.y, self.size.y);
                rows.flat_map(|y| {
                    let columns = 2 * place.x..last(place.x, size.x, self.size.x);
                    columns.map(move |x| (y * self.size.x + x) as usize)
                })
                .fold(NOTHING, |[least, greatest], index| {
                    let [low, high] = self.depths[index];
                    [least.min(low), greatest.max(high)]
                })
            })
            .collect();
        Self { size, depths }
    }
}

/// Depths of a texel that shows only sky.
pub const NOTHING: [f32; 2] = [f32::INFINITY, 0.0];

impl DepthChain {
    /// The chain of a picture of view depths in metres; 0, NaN and infinity are sky. `None` for no picture, or for
    /// another number of depths than pixels.
    pub fn new(size: UVec2, depths: &[f32]) -> Option<Self> {
        if size.min_element() == 0 || depths.len() != (size.x * size.y) as usize {
            return None;
        }
        let picture = depths.iter().map(|depth| {
            if *depth > 0.0 && depth.is_finite() {
                [*depth; 2]
            } else {
                NOTHING
            }
        });
        let mut levels = vec![DepthLevel {
            size,
            depths: picture.collect(),
        }];
        while let Some(level) = levels.last().filter(|level| level.size != UVec2::ONE) {
            levels.push(level.reduced());
        }
        Some(Self { levels })
    }

    /// Least and greatest view depth of the picture; `None` when it shows only sky.
    pub fn range(&self) -> Option<(f32, f32)> {
        let [least, greatest] = *self.levels.last()?.depths.first()?;
        (least <= greatest).then_some((least, greatest))
    }
}

/// How far a camera and what it sees move between the frame that was measured and the frame that uses the measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Largest speed of the camera relative to anything it sees, metres per second.
    pub speed: f64,
    /// Largest turning speed, radians per second.
    pub turning: f64,
    /// Time between both frames, seconds.
    pub time: f64,
}

/// The near plane to use when the least depth is known from an earlier frame only: how near something seen then may
/// have come. Never nearer than the view's own near plane.
///
/// A point seen at view depth z lies at z ÷ cos α from the eye, α at most the angle θ from the axis to a corner of the
/// picture. Turning by δ = ω t moves it to at most α + δ from the axis, walking by s t brings it nearer by as much:
///
/// ```text
/// z' ≥ z cos(α + δ) ÷ cos α − s t = z (cos δ − tan α sin δ) − s t ≥ z (cos δ − tan θ sin δ) − s t
/// ```
///
/// This holds for everything inside the earlier picture, also for what was hidden: it lies farther along the same ray.
/// (So it holds for near planes only; a hidden point may lie beyond any earlier far plane.) It cannot hold for what
/// enters from beside the picture: a strip of [`entering_angle`] along its borders in which something nearer than the
/// result can appear. Such receivers lie in no map for the frames of the delay; measure with a field of view wider by
/// the strip, or treat them as lit, as everything outside of maps is.
pub fn late_near(least_depth: f64, view: &ViewVolume, motion: &Motion) -> f64 {
    let (turn, step) = (motion.turning.abs() * motion.time, motion.speed.abs() * motion.time);
    let corner = corner_tangent(view);
    let shrink = turn.cos() - corner * turn.sin();
    let near = least_depth * shrink - step;
    if turn + corner.atan() < std::f64::consts::FRAC_PI_2 && near > view.near() {
        near
    } else {
        view.near()
    }
}

/// Width of the border, as an angle, in which the picture may show what the earlier one did not, for things no nearer
/// than `distance` metres: the turn, and what a sideways step uncovers.
pub fn entering_angle(distance: f64, motion: &Motion) -> f64 {
    let (turn, step) = (motion.turning.abs() * motion.time, motion.speed.abs() * motion.time);
    turn + (step / distance).min(1.0).asin()
}

/// Tangent of the angle from the view direction to the farthest corner of the picture; 0 for orthographic cameras.
fn corner_tangent(view: &ViewVolume) -> f64 {
    let [near, far] = [view.near(), view.near() + 1.0].map(|depth| {
        let corners = view.corners(depth, depth);
        std::array::from_fn::<DVec3, 4, _>(|index| corners[index] - view.eye() - view.forward() * depth)
    });
    let slopes = near.iter().zip(far).map(|(near, far)| (far - near).length());
    slopes.fold(0.0, f64::max)
}
