//! [`ViewVolume`]: the camera's view frustum V in world space, perspective, orthographic or off-centre.

use bevy_math::{DVec2, DVec3};
use thiserror::Error;

use super::polytope::{HalfSpace, Polytope};

/// Why a camera has no view volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum ViewError {
    /// A NaN or an infinity in the camera's place or opening.
    #[error("the camera's position, direction or projection is not a finite number")]
    NotFinite,
    /// Near and far enclose nothing, or the near plane of a perspective camera is not in front of the eye.
    #[error("the camera's near plane must lie in front of its far plane, and of the eye if it is a perspective camera")]
    NoRange,
    /// The opening has no area.
    #[error("the camera's projection has no area")]
    NoArea,
}

/// The view frustum V: four corner lines from the eye's plane outwards, cut at near and far view depth.
///
/// View depth is the distance from the eye along the view direction, in metres. `far` may be infinite: bodies are built
/// by clipping the finite scene, never from far corners.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewVolume {
    eye: DVec3,
    forward: DVec3,
    up: DVec3,
    /// Corner lines at view depth 0, relative to the eye: bottom left, bottom right, top right, top left.
    offsets: [DVec3; 4],
    /// Their change per metre of view depth.
    slopes: [DVec3; 4],
    near: f64,
    far: f64,
    orthographic: bool,
}

impl ViewVolume {
    /// A perspective camera. `fov_y` is the full vertical opening in radians, `aspect` is width ÷ height; `forward` and
    /// `up` need not have unit length nor be perpendicular.
    pub fn perspective(
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        fov_y: f64,
        aspect: f64,
        near: f64,
        far: f64,
    ) -> Result<Self, ViewError> {
        let half_height = (fov_y * 0.5).tan();
        let half = DVec2::new(half_height * aspect, half_height);
        Self::from_openings(
            eye,
            forward,
            up,
            [(-half, half), (-half * 2.0, half * 2.0)],
            [1.0, 2.0],
            near,
            far,
        )
    }

    /// An orthographic camera that sees the rectangle from `min` to `max` (right and up, in metres from the eye's axis).
    pub fn orthographic(
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        min: DVec2,
        max: DVec2,
        near: f64,
        far: f64,
    ) -> Result<Self, ViewError> {
        Self::from_openings(eye, forward, up, [(min, max); 2], [0.0, 1.0], near, far)
    }

    fn from_openings(
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        openings: [(DVec2, DVec2); 2],
        depths: [f64; 2],
        near: f64,
        far: f64,
    ) -> Result<Self, ViewError> {
        let forward = forward.try_normalize().ok_or(ViewError::NotFinite)?;
        let right = forward
            .cross(up)
            .try_normalize()
            .unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let corners = [0, 1].map(|end| {
            let (min, max) = openings[end];
            [(min.x, min.y), (max.x, min.y), (max.x, max.y), (min.x, max.y)]
                .map(|(x, y)| eye + right * x + up * y + forward * depths[end])
        });
        Self::from_corners(eye, forward, up, corners, near, far)
    }

    /// Any projection whose edges are straight lines, from its corners (bottom left, bottom right, top right, top left)
    /// at two different view depths, nearer first.
    pub fn from_corners(
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        corners: [[DVec3; 4]; 2],
        near: f64,
        far: f64,
    ) -> Result<Self, ViewError> {
        let forward = forward.try_normalize().ok_or(ViewError::NotFinite)?;
        let finite = eye.is_finite() && up.is_finite() && corners.iter().flatten().all(|corner| corner.is_finite());
        if !finite || !near.is_finite() || far.is_nan() {
            return Err(ViewError::NotFinite);
        }
        let depths = corners.map(|[corner, ..]| (corner - eye).dot(forward));
        let slopes: [DVec3; 4] =
            std::array::from_fn(|index| (corners[1][index] - corners[0][index]) / (depths[1] - depths[0]));
        let offsets: [DVec3; 4] = std::array::from_fn(|index| corners[0][index] - eye - slopes[index] * depths[0]);
        if !slopes.iter().all(|slope| slope.is_finite()) {
            return Err(ViewError::NoRange);
        }
        let orthographic = slopes.iter().all(|slope| slope.distance(forward) < 1.0e-9);
        if far <= near || (!orthographic && near <= 0.0) {
            return Err(ViewError::NoRange);
        }
        let diagonals = [corners[1][2] - corners[1][0], corners[1][3] - corners[1][1]];
        if diagonals[0].cross(diagonals[1]).length() <= 1.0e-12 * diagonals[0].length() * diagonals[1].length()
            || diagonals[0] == DVec3::ZERO
        {
            return Err(ViewError::NoArea);
        }
        Ok(Self {
            eye,
            forward,
            up,
            offsets,
            slopes,
            near,
            far,
            orthographic,
        })
    }

    /// The eye, in world space.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The view direction, of unit length.
    pub fn forward(&self) -> DVec3 {
        self.forward
    }

    /// The camera's up direction.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// View depth of the near plane, in metres.
    pub fn near(&self) -> f64 {
        self.near
    }

    /// View depth of the far plane, in metres; may be infinite.
    pub fn far(&self) -> f64 {
        self.far
    }

    /// True for parallel projections.
    pub fn is_orthographic(&self) -> bool {
        self.orthographic
    }

    /// View depth of a point, in metres.
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.eye).dot(self.forward)
    }

    /// Corners at two view depths: near bottom left, bottom right, top right, top left, then far.
    pub fn corners(&self, near: f64, far: f64) -> [DVec3; 8] {
        std::array::from_fn(|index| {
            let depth = if index < 4 { near } else { far };
            self.eye + self.offsets[index % 4] + self.slopes[index % 4] * depth
        })
    }

    /// The slice between two view depths; an empty interval is widened to a sliver.
    pub fn split(&self, near: f64, far: f64) -> Self {
        Self {
            near,
            far: far.max(near + 1.0e-9 * near.abs().max(1.0e-3)),
            ..self.clone()
        }
    }

    /// Mean width and height of the picture in metres, per metre of view depth: 2 tan Θ of the papers for perspective
    /// cameras, zero for orthographic ones.
    pub fn opening(&self) -> DVec2 {
        let [bottom_left, bottom_right, top_right, top_left] = self.slopes;
        DVec2::new(
            (bottom_right - bottom_left + top_right - top_left).length() * 0.5,
            (top_left - bottom_left + top_right - bottom_right).length() * 0.5,
        )
    }

    /// The half-spaces whose intersection is the volume: four sides, near, and far unless it is infinite.
    pub fn half_spaces(&self) -> Vec<HalfSpace> {
        let at_one: [DVec3; 4] = std::array::from_fn(|index| self.eye + self.offsets[index] + self.slopes[index]);
        let center = at_one.iter().sum::<DVec3>() * 0.25;
        let mut half_spaces = Vec::with_capacity(6);
        for index in 0..4 {
            let next = (index + 1) % 4;
            let normal = (at_one[next] - at_one[index])
                .cross(self.slopes[index])
                .normalize_or_zero();
            let side = HalfSpace::through(at_one[index], normal);
            half_spaces.push(if side.excess(center) > 0.0 {
                HalfSpace::through(at_one[index], -normal)
            } else {
                side
            });
        }
        half_spaces.push(HalfSpace::through(self.eye + self.forward * self.near, -self.forward));
        if self.far.is_finite() {
            half_spaces.push(HalfSpace::through(self.eye + self.forward * self.far, self.forward));
        }
        half_spaces
    }

    /// The volume itself as a body; a far plane farther than `farthest` metres is drawn in to it.
    pub fn polytope(&self, farthest: f64) -> Polytope {
        Polytope::from_frustum_corners(&self.corners(self.near, self.far.min(farthest.max(self.near))))
    }
}
