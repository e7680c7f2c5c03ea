//! Films by construction: one plane, and the miner's lamp (Chong 2.2.1, 2.2.2, appendix B).

use bevy_math::DVec3;

use super::{Camera, Degenerate, Exposure, Film, Light, Segment, Tilt};

/// Sines below this count as zero: light in the line of a surface, or on the view plane.
const IN_LINE: f64 = 1.0e-12;

/// q: where the line of a surface meets the camera's view plane, as a homogeneous point (z, y, w) of length 1. w is 0 if
/// both are parallel. Zero for a surface in the view plane, which the camera sees edge-on.
pub fn view_plane_point(camera: &Camera, segment: &Segment) -> DVec3 {
    let frame = camera.frame();
    let view_plane = frame.origin.extend(1.0).cross(frame.film().extend(0.0));
    let line = segment.line().normalize_or_zero();
    let point = line.cross(view_plane.normalize_or_zero());
    if point.length() < IN_LINE {
        return DVec3::ZERO;
    }
    point.normalize_or_zero()
}

/// The best film for one plane (Chong, theorem 1 and corollary 2): that whose own view plane goes through
/// [`view_plane_point`], parallel to the line from the light to it.
///
/// Both projections take that point to infinity, so the map from pixels to places on the film is affine: constant
/// badness, which no film can better under any metric. It holds for parallel light as well, where the film is a
/// projection and not a turn, and for a plane parallel to the view plane. "View plane" must be read as the line w = 0; with
/// near planes the theorem is wrong.
///
/// # Errors
/// [`Degenerate::EdgeOn`] with light in the plane or a plane through the eye, [`Degenerate::TooWide`] if the film cuts
/// the hull: it never does if all that is covered lies on the plane before the eye.
pub fn single_plane_tilt(camera: &Camera, segment: &Segment, exposure: &Exposure) -> Result<Tilt, Degenerate> {
    let point = view_plane_point(camera, segment);
    if point == DVec3::ZERO || is_in_line(segment, exposure.film.light()) {
        return Err(Degenerate::EdgeOn);
    }
    if !point.is_finite() {
        return Err(Degenerate::NotFinite);
    }
    exposure.tilt_through(point).ok_or(Degenerate::TooWide)
}

fn is_in_line(segment: &Segment, light: Light) -> bool {
    let line = segment.line().normalize_or_zero();
    line.dot(light.homogeneous().normalize_or_zero()).abs() < IN_LINE
}

/// The film parallel to the camera's, for light beside the eye (the miner's lamp, Chong 2.2.2).
///
/// With a point light on the view plane, w is the same for eye and light, so badness is constant on every surface
/// whatever its direction (proposition 3); the constants differ unless the light is in the eye. No other place and film
/// do that for all scenes. For several surfaces a tilt that evens out the constants is still better: [`optimal_tilt`](super::optimal_tilt).
///
/// # Errors
/// Those of [`Film::new`].
pub fn parallel_film(camera: &Camera, light: Light) -> Result<Film, Degenerate> {
    Film::new(light, camera.frame().angle)
}

/// What proposition 3 promises on a surface: |dp/dτ| on a film parallel to the camera's, both at distance 1, is the eye's
/// distance from [`view_plane_point`] over the light's. `None` for light that is not a point on the view plane; 1 for a
/// surface parallel to it. Infinite for light in the surface's line.
pub fn miners_badness(camera: &Camera, light: Light, segment: &Segment) -> Option<f64> {
    let Light::Point { position } = light else {
        return None;
    };
    let from_eye = position - camera.frame().origin;
    let is_beside = from_eye.dot(camera.frame().forward()).abs() <= IN_LINE * from_eye.length().max(1.0);
    if !is_beside {
        return None;
    }
    let point = view_plane_point(camera, segment);
    // Distances to a homogeneous point, both times its w, which may be zero.
    let distance = |from: bevy_math::DVec2| (point.truncate() - from * point.z).length();
    Some(distance(camera.frame().origin) / distance(position))
}
