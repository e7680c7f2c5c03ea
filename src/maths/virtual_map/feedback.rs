//! Needs of an earlier frame: how much finer, and where else, a moved camera may need the map.
//!
//! A read-back within the frame is the reference: it knows the needs exactly, and waits. A plan from the needs of the
//! frame before waits for nothing, but the camera has moved by then. [`PictureMotion`] makes the earlier needs large
//! enough for *any* camera within a motion.
//!
//! # Derivation
//!
//! A point of the scene at view depth Z lies at the place q (pixels from the principal point, f pixels per unit of
//! tangent) of the picture. A step over the surface with view-space components (t_xy, t_z), for example that of one map
//! length along u, moves its image by the pixels
//!
//! ```text
//! s = f ÷ Z (t_xy − (q ÷ f) t_z)                                                                                   (1)
//! ```
//!
//! and its need is |s|. *First the camera moves* by at most δ = speed · time in any direction, without turning. Z' ≥ Z
//! − δ, and (1) for the new place q' and depth, minus Z ÷ Z' times (1), is
//!
//! ```text
//! s' − (Z ÷ Z') s = (q − q') t_z ÷ Z'        |q − q'| = f |Z δ_x − X δ_z| ÷ (Z Z') ≤ f δ ÷ (Z' cos α)
//! |s'| ≤ Z ÷ (Z − δ) · |s| + f δ |t_z| ÷ ((Z − δ)² cos α)                                                            (2)
//! ```
//!
//! with α between the axis and the ray to the point: X² + Z² = Z² ÷ cos² α. The second term is what an oblique surface
//! gains by being seen from another side. *Then it turns* by at most ψ = turning · time, about any axis through the
//! eye. A rotation R takes the image step to s'' = f ÷ z (R s)_xy − … = (f ÷ z) ((R s)_xy − (q'' ÷ f)(R s)_z), z the
//! third coordinate of R (q', f). s lies in the picture's plane, so |(R s)_z| ≤ |s| sin ψ; and z = f cos α'' ÷ cos α'.
//! Hence
//!
//! ```text
//! |s''| ≤ |s'| (cos α' ÷ cos α'')(1 + tan α'' sin ψ) ≤ |s'| (cos ψ + tan θ sin ψ)(1 + tan θ sin ψ)                        (3)
//! ```
//!
//! since α' ≥ α'' − ψ, and α'' ≤ θ, the angle to the corner, for every point that is still in the picture; with ψ > θ
//! the first factor is 1 ÷ cos θ, because α' may be 0. For turning first and moving then the same holds: the eye's way
//! is what counts, and δ bounds it in any direction.
//!
//! # What it cannot know
//!
//! Needs are those of the light map they were measured in: draw the plan with *that* light view, not with one fitted to
//! the new camera. And no dilation covers what was not in the earlier picture at all: behind things, and in a strip
//! along the border ([`entering_angle`](crate::maths::near_plane::entering_angle)). Cells without any earlier pixel get
//! a coarse tile by [`GridOptions::floor_level`](super::grid::GridOptions::floor_level), and the measure against the
//! reference shows how much that matters. Cells with some earlier pixels may be too coarse for new ones nearer than
//! those.

use bevy_math::{DVec2, DVec3};

use super::{mapping::PixelPatch, picture::DepthPicture};
use crate::maths::{near_plane::Motion, view::ViewVolume};

/// A bound of a camera's motion, in the terms of its picture. Perspective cameras with square pixels; an orthographic
/// picture neither grows nor shears by motion, so its needs stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureMotion {
    /// δ: metres.
    pub step: f64,
    /// ψ: radians.
    pub turn: f64,
    /// f: pixels per unit of tangent, the larger of both axes.
    pub focal: f64,
    /// tan θ: to the farthest corner of the picture.
    pub corner: f64,
}

impl PictureMotion {
    /// For a camera and the motion between measuring and drawing. `picture_height` in pixels. Negative and NaN motions
    /// count as none. `None` for orthographic cameras.
    pub fn new(view: &ViewVolume, motion: &Motion, picture_height: f64) -> Option<Self> {
        let opening = view.opening();
        let corners = view.corners(0.0, 1.0);
        let corner = (4..8).map(|index| (corners[index] - corners[index - 4] - view.forward()).length());
        (!view.is_orthographic()).then(|| Self {
            step: (motion.speed * motion.time).max(0.0),
            turn: (motion.turning * motion.time).clamp(0.0, std::f64::consts::FRAC_PI_2),
            focal: picture_height / opening.y,
            corner: corner.fold(0.0, f64::max),
        })
    }

    /// The factor by which turning can raise a need: inequality 3.
    pub fn turn_factor(&self) -> f64 {
        let sine = self.corner * self.turn.sin();
        let tilt = if self.turn < self.corner.atan() {
            self.turn.cos() + sine
        } else {
            (1.0 + self.corner * self.corner).sqrt()
        };
        tilt * (1.0 + sine)
    }

    /// Needs of a patch for every camera within the motion: inequalities 2 and 3. Infinite for surfaces that the camera
    /// may reach.
    pub fn dilated_need(&self, need: DVec2, patch: &PixelPatch, picture: &DepthPicture) -> DVec2 {
        let place = patch.clip.truncate();
        let depth = picture.linear_depth(place, patch.clip.z);
        let rest = depth - self.step;
        if !(rest > 0.0) {
            return DVec2::INFINITY;
        }
        // Depth per pixel on the patch, through the inverse of depth: 1 ÷ d is affine in place and depth.
        let size = picture.size().as_dvec2();
        let moves = [
            DVec3::new(2.0 / size.x, 0.0, patch.slopes.x),
            DVec3::new(0.0, -2.0 / size.y, patch.slopes.y),
        ];
        let inverse_depth = picture.world_from_clip().row(3).truncate();
        let per_pixel = moves.map(|step| -depth * depth * inverse_depth.dot(step));
        let depth_steps = DVec2::from_array(patch.sides().map(|side| DVec2::from_array(per_pixel).dot(side).abs()));
        let gained =
            depth_steps * (self.focal * self.step * (1.0 + self.tangent_squared(place)).sqrt() / (rest * rest));
        (need * (depth / rest) + gained) * self.turn_factor()
    }

    /// tan² α of a clip-space place: by similar triangles, the corner's at (±1, ±1).
    fn tangent_squared(&self, place: DVec2) -> f64 {
        self.corner * self.corner * place.abs().max_element().powi(2).min(1.0)
    }

    /// Most pixels by which anything that was at or beyond a view depth moves over the picture while it stays inside:
    /// the guard of screen rectangles that a plan of an earlier frame needs.
    ///
    /// The rays to it before and after, each in its camera's axes, are at most γ = ψ + arcsin(δ ÷ Z) apart. With a = (q
    /// ÷ f, 1) and b likewise, sin γ = |a × b| ÷ (|a| |b|), and |a × b| ≥ |a − b| because the line through a and b is
    /// at least 1 away from the eye. So |q'' − q| ≤ f sin γ ÷ cos² θ.
    pub fn flow(&self, least_depth: f64) -> f64 {
        let angle = self.turn + (self.step / least_depth).clamp(0.0, 1.0).asin();
        let sine = angle.min(std::f64::consts::FRAC_PI_2).sin();
        self.focal * sine * (1.0 + self.corner * self.corner)
    }
}
