//! [`BaseFilm`]: the film that all others of a light are told from.

use bevy_math::{DVec2, DVec3, DVec4};
use thiserror::Error;

use crate::maths::{
    fit::LightAxes,
    polytope::{LARGEST_COORDINATE, magnitude},
    view::ViewVolume,
};

/// Why there is no film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum FilmError {
    /// Nothing has to be covered: no samples, no receivers.
    #[error("there is nothing to cover with a light plane")]
    NothingVisible,
    /// What has to be covered has no area on the film: all of it lies in one ray or one plane of light.
    #[error("what the light plane has to cover has no area")]
    NoArea,
    /// NaN or an infinity, or coordinates beyond [`LARGEST_COORDINATE`].
    #[error("the samples, the hull or the light are not finite numbers")]
    NotFinite,
    /// The receivers reach beside or behind the light: no single film shows them all.
    #[error("the receivers reach beside or behind the light")]
    TooWide,
    /// Not one texel.
    #[error("the map has no texels")]
    NoTexels,
}

/// A film that is perpendicular to the axis of light space, scaled so that the receivers fill −1..1.
///
/// Film coordinates u of a point: for the sun light-space x and y, for a light at a point x and y over the distance along
/// the axis; less the middle of the receivers, over half the longer side of their box. That keeps moments small enough for
/// sums in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseFilm {
    axes: LightAxes,
    /// A point on the ray u = 0, where w of the base film is 1.
    center: DVec3,
    /// Of a light at a point.
    position: Option<DVec3>,
    /// Metres (for a light at a point: metres per metre of distance) per unit of u.
    scale: f64,
}

/// Height of the light over a plane, relative to the numbers that it is computed from, below which it grazes the plane.
const LEAST_HEIGHT: f64 = 1.0e-9;

impl BaseFilm {
    /// The base film of the sun over the receivers.
    pub fn of_sun(axes: LightAxes, receivers: &[DVec3]) -> Result<Self, FilmError> {
        let unscaled = Self {
            axes,
            center: DVec3::ZERO,
            position: None,
            scale: 1.0,
        };
        unscaled.around(receivers)
    }

    /// The base film of a light at a point over the receivers. `axes.z` points against the axis along which the light
    /// looks: any direction that has all receivers in front of it ([`FilmError::TooWide`] otherwise), best their middle.
    pub fn of_point(position: DVec3, axes: LightAxes, receivers: &[DVec3]) -> Result<Self, FilmError> {
        if !position.is_finite() {
            return Err(FilmError::NotFinite);
        }
        let unscaled = Self {
            axes,
            center: position - axes.z,
            position: Some(position),
            scale: 1.0,
        };
        unscaled.around(receivers)
    }

    fn around(self, receivers: &[DVec3]) -> Result<Self, FilmError> {
        if receivers.is_empty() {
            return Err(FilmError::NothingVisible);
        }
        let axes = [self.axes.x, self.axes.y, self.axes.z];
        if receivers.iter().chain(&axes).any(|point| point.is_nan()) || magnitude(receivers) > LARGEST_COORDINATE {
            return Err(FilmError::NotFinite);
        }
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for receiver in receivers {
            let film = self.film(*receiver).ok_or(FilmError::TooWide)?;
            (low, high) = (low.min(film), high.max(film));
        }
        let middle = (low + high) * 0.5;
        let scale = (high - low).max_element() * 0.5;
        // A single ray of light: its pixels still have an area, which the scale must not swamp.
        let smallest = 1.0e-9 * low.abs().max(high.abs()).max_element().max(1.0e-3);
        Ok(Self {
            center: self.center + self.axes.x * middle.x + self.axes.y * middle.y,
            scale: scale.max(smallest),
            ..self
        })
    }

    /// The axes of light space.
    pub fn axes(&self) -> &LightAxes {
        &self.axes
    }

    /// Metres per unit of film for the sun; for a light at a point, metres per metre of distance along its axis.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The point of the ray u = 0 at which w of the base film is 1, in the world.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// The light as a homogeneous point in the world: (position, 1), or (direction towards it, 0) for the sun.
    pub fn light(&self) -> DVec4 {
        self.position
            .map_or(self.axes.z.extend(0.0), |position| position.extend(1.0))
    }

    /// Linear forms of a world-space point (x, y, z, 1): u_x w₀, u_y w₀ and w₀, where w₀ is 1 for the sun, and the distance
    /// along the axis in metres for a light at a point. They vanish at the light.
    pub fn forms(&self) -> [DVec4; 3] {
        match self.position {
            None => {
                let of_axis = |axis: DVec3| (axis.extend(-axis.dot(self.center))) / self.scale;
                [of_axis(self.axes.x), of_axis(self.axes.y), DVec4::W]
            }
            Some(position) => {
                let through_light = |axis: DVec3| axis.extend(-axis.dot(position));
                let width = through_light(-self.axes.z);
                let of_axis = |axis: DVec3| {
                    let middle = axis.dot(self.center - position);
                    (through_light(axis) - width * middle) / self.scale
                };
                [of_axis(self.axes.x), of_axis(self.axes.y), width]
            }
        }
    }

    /// u of a point in the world; `None` beside or behind a light at a point.
    pub fn film(&self, point: DVec3) -> Option<DVec2> {
        let offset = point - self.center;
        let across = DVec2::new(self.axes.x.dot(offset), self.axes.y.dot(offset));
        let Some(position) = self.position else {
            return Some(across / self.scale);
        };
        let distance = self.axes.z.dot(position - point);
        let axis = self.center - position;
        let middle = DVec2::new(self.axes.x.dot(axis), self.axes.y.dot(axis));
        let across = DVec2::new(self.axes.x.dot(point - position), self.axes.y.dot(point - position));
        (distance > 1.0e-9 * (point - position).length()).then(|| (across / distance - middle) / self.scale)
    }

    /// Gradients of u_x and u_y in the world at a point in front of the light, per metre.
    pub fn film_gradients(&self, point: DVec3) -> [DVec3; 2] {
        let [across, along, width] = self.forms();
        let at = point.extend(1.0);
        let w = width.dot(at);
        [across, along].map(|form| (form.truncate() - width.truncate() * (form.dot(at) / w)) / w)
    }

    /// w of a film as a linear form of a world-space point: zero at the light, 1 on the ray u = 0 for the sun.
    ///
    /// Unlike k it means the same over every base film of the light, up to a positive factor: keep it from picture to
    /// picture, and read it with [`BaseFilm::bend_of`].
    pub fn width_form(&self, bend: DVec2) -> DVec4 {
        let [across, along, width] = self.forms();
        width + across * bend.x + along * bend.y
    }

    /// The bend k of a film whose w is this form. `None` when the form is not positive in the middle of the receivers, or
    /// not finite. The form must vanish at the light.
    ///
    /// The form is c (w₀ + k · u w₀): its value on the ray u = 0 is c, and its gradient along the axes is c k ÷ scale.
    pub fn bend_of(&self, width_form: DVec4) -> Option<DVec2> {
        let constant = width_form.dot(self.center.extend(1.0));
        let slopes = DVec2::new(
            width_form.truncate().dot(self.axes.x),
            width_form.truncate().dot(self.axes.y),
        );
        let bend = slopes * self.scale / constant;
        (constant > 0.0 && bend.is_finite()).then_some(bend)
    }

    /// The bend that is best for one plane (Chong, section 2.2.1, Theorem 1, in space): pixels on it then map to the film by
    /// an affine map, so that all its texels cover the same area.
    ///
    /// w must be proportional to the camera's view depth C on the plane Π, and vanish at the light L. Linear forms that
    /// agree on the plane differ by a multiple of Π:
    ///
    /// ```text
    /// w = C − Π (C · L) ÷ (Π · L)
    /// ```
    ///
    /// which is the plane through the light and the line that Π and C = 0 have in common, without a special case for
    /// parallel ones. Where the light lies on C = 0, w = C for every plane: that is Proposition 3 (section 2.2.2), one film
    /// with texels of constant area on each polygon of any scene. For the sun it is light across the view direction.
    ///
    /// `camera` from [`depth_form`], `plane` from [`plane_form`]. `None` where the light grazes the plane, and where the
    /// film is not valid in the middle of the receivers, as it may be for planes that do not fill them.
    pub fn bend_of_plane(&self, camera: DVec4, plane: DVec4) -> Option<DVec2> {
        let light = self.light();
        let height = plane.dot(light);
        let largest = plane.truncate().length() * light.truncate().length() + (plane.w * light.w).abs();
        if !(height.abs() > LEAST_HEIGHT * largest) {
            return None;
        }
        self.bend_of(camera - plane * (camera.dot(light) / height))
    }
}

/// View depth as a linear form of a world-space point (x, y, z, 1); 1 everywhere for orthographic cameras.
pub fn depth_form(view: &ViewVolume) -> DVec4 {
    if view.is_orthographic() {
        return DVec4::W;
    }
    view.forward().extend(-view.forward().dot(view.eye()))
}

/// Signed distance from a plane as a linear form of a world-space point (x, y, z, 1).
pub fn plane_form(point: DVec3, normal: DVec3) -> DVec4 {
    normal.extend(-normal.dot(point))
}
