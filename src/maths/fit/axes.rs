//! [`LightAxes`]: light space, aligned with a warp axis.

use bevy_math::DVec3;

use super::{FitInput, Unfit, options::WarpAxis};
use crate::maths::polytope::Polytope;

/// The axes of light space in the world: an orthonormal right-handed triple.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightAxes {
    /// x = y × z.
    pub x: DVec3,
    /// The warp axis: the view direction projected into the light plane.
    pub y: DVec3,
    /// Towards the light.
    pub z: DVec3,
}

/// Sine of the angle between light and view direction below which the camera's up direction takes over as warp axis.
const PARALLEL_SINE: f64 = 0.01;

impl LightAxes {
    /// Light space for a view direction and the direction in which light travels; none of them needs unit length.
    /// `None` when the light has no direction.
    ///
    /// Where light and view become parallel, the camera's up direction fades in as the warp axis, so that the axes turn
    /// steadily; at one single direction in the middle of the fade no continuous choice exists.
    pub fn new(forward: DVec3, up: DVec3, light_travel: DVec3) -> Option<Self> {
        let z = -light_travel.try_normalize()?;
        let in_light_plane = |direction: DVec3| {
            let direction = direction.normalize_or_zero();
            direction - z * direction.dot(z)
        };
        let ahead = in_light_plane(forward);
        let up = in_light_plane(up).normalize_or_zero();
        let fade = (PARALLEL_SINE - ahead.length()).max(0.0);
        let y = [ahead + up * fade, up, ahead]
            .into_iter()
            .find_map(|axis| (axis.length() > 1.0e-6).then(|| axis.normalize()))
            .unwrap_or_else(|| z.any_orthonormal_vector());
        // Once more, because rounding of a short vector leaves a part along z.
        let y = (y - z * y.dot(z)).normalize();
        Some(Self { x: y.cross(z), y, z })
    }

    pub(in crate::maths) fn coordinates(&self, point: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(point), self.y.dot(point), self.z.dot(point))
    }
}

/// Length of the part across the light below which a chosen warp axis is refused as parallel to the light.
const SHORTEST_AXIS: f64 = 1.0e-6;

/// The axes of the light view that the input asks for.
pub(super) fn light_axes(input: &FitInput) -> Result<LightAxes, Unfit> {
    let view = input.view;
    let axes = |ahead, up| LightAxes::new(ahead, up, input.light_travel).ok_or(Unfit::NoLightDirection);
    let along_view = axes(view.forward(), view.up())?;
    match input.options.axis {
        WarpAxis::View => Ok(along_view),
        WarpAxis::Middle => axes(surface_centroid(input.body) - view.eye(), along_view.y),
        WarpAxis::Direction(direction) if !direction.is_finite() => Err(Unfit::NotFinite),
        WarpAxis::Direction(direction) => {
            let across = direction.normalize_or_zero().reject_from_normalized(along_view.z);
            if across.length() < SHORTEST_AXIS {
                return Err(Unfit::NoWarpAxis);
            }
            axes(across, along_view.y)
        }
    }
}

/// Mean of a body's surface. Unlike the mean of its vertices it moves steadily when clipping adds or drops a vertex, and
/// unlike the mean of its volume it exists for flat bodies.
fn surface_centroid(body: &Polytope) -> DVec3 {
    let vertices = body.vertices();
    let (mut weighted, mut total) = (DVec3::ZERO, 0.0);
    for face in body.faces() {
        for pair in face.indices[1..].windows(2) {
            let [a, b, c] = [face.indices[0], pair[0], pair[1]].map(|index| vertices[index as usize]);
            let area = (b - a).cross(c - a).length();
            weighted += (a + b + c) * (area / 3.0);
            total += area;
        }
    }
    if total > 0.0 { weighted / total } else { body.center() }
}
