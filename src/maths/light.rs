//! Lights at infinity and at a point: [`Light`], its volume L, and the light views of point and spot lights.
//!
//! Light space of a light at a point: its origin is the light, z points against the axis along which it looks (towards
//! the light, as for the sun), y is the warp axis, x = y × z. Its clip space is that of a reverse-z perspective camera:
//! x and y in −1..=1, z 1 at the near plane and 0 at the far plane, w the distance along the axis.
//!
//! The renderer draws the sun; the light views of this file serve analysis, overlays and other engines.

use bevy_math::{DMat3, DMat4, DVec3, DVec4};
use thiserror::Error;

use super::{
    fit::LightAxes,
    polytope::{HalfSpace, LARGEST_COORDINATE, Polytope},
    view::ViewVolume,
};

/// A source of light. Positions and distances in metres, in world space; angles in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// The sun: parallel rays, everywhere.
    Directional {
        /// Direction in which light travels, of any length.
        travel: DVec3,
    },
    /// A light that shines from a point in all directions.
    Point {
        /// Where it is.
        position: DVec3,
        /// Distance from which it lights nothing.
        range: f64,
    },
    /// A light that shines from a point into a cone.
    Spot {
        /// Where it is.
        position: DVec3,
        /// Axis of the cone, away from the light, of any length.
        direction: DVec3,
        /// Half the opening of the cone, below π ÷ 2.
        outer_angle: f64,
        /// Distance along the axis up to which nothing casts.
        near: f64,
        /// Distance from which it lights nothing.
        range: f64,
    },
}

/// Why a light, or a light view of it, cannot be worked with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum LightError {
    /// NaN or an infinity, or coordinates beyond [`LARGEST_COORDINATE`].
    #[error("the light's position, range or angle is not a finite number")]
    NotFinite,
    /// A direction of no length.
    #[error("the light has no direction")]
    NoDirection,
    /// Near and range enclose nothing, or near does not lie in front of the light.
    #[error("the light's near distance must be positive and below its range")]
    NoRange,
    /// A cone without opening, or one that is not convex.
    #[error("the light's angle must be above zero and below a right angle")]
    NoCone,
    /// The body is empty: nothing that is seen can be lit.
    #[error("there is nothing to fit a light view to")]
    NothingVisible,
    /// The body reaches around the light: no single perspective shows it all. A point light then needs
    /// [`cube_faces`].
    #[error("the body reaches beside or behind the light")]
    TooWide,
}

/// Sides of the pyramid that stands for a spot light's cone: its base exceeds that of the cone by 5.5 %.
const CONE_SIDES: usize = 8;

impl Light {
    /// Names what is wrong with it.
    pub fn check(&self) -> Result<(), LightError> {
        let placed = |position: DVec3, range: f64| {
            if !position.is_finite() || !range.is_finite() || position.abs().max_element() + range > LARGEST_COORDINATE
            {
                Err(LightError::NotFinite)
            } else if range <= 0.0 {
                Err(LightError::NoRange)
            } else {
                Ok(())
            }
        };
        let directed = |direction: DVec3| match direction.try_normalize() {
            _ if !direction.is_finite() => Err(LightError::NotFinite),
            None => Err(LightError::NoDirection),
            Some(_) => Ok(()),
        };
        match *self {
            Self::Directional { travel } => directed(travel),
            Self::Point { position, range } => placed(position, range),
            Self::Spot {
                position,
                direction,
                outer_angle,
                near,
                range,
            } => {
                placed(position, range)?;
                directed(direction)?;
                if !near.is_finite() || outer_angle.is_nan() {
                    Err(LightError::NotFinite)
                } else if near <= 0.0 || near >= range {
                    Err(LightError::NoRange)
                } else if outer_angle <= 0.0 || outer_angle >= 0.999 * std::f64::consts::FRAC_PI_2 {
                    Err(LightError::NoCone)
                } else {
                    Ok(())
                }
            }
        }
    }

    /// Where it is; `None` for the sun.
    pub fn position(&self) -> Option<DVec3> {
        match self {
            Self::Directional { .. } => None,
            Self::Point { position, .. } | Self::Spot { position, .. } => Some(*position),
        }
    }

    /// Unit direction from a point towards the light. Zero at the light itself.
    pub fn towards(&self, point: DVec3) -> DVec3 {
        match self {
            Self::Directional { travel } => -travel.normalize_or_zero(),
            Self::Point { position, .. } | Self::Spot { position, .. } => (position - point).normalize_or_zero(),
        }
    }

    /// The light's volume L as half-spaces: none for the sun, the box around its sphere for a point light, and for a
    /// spot light the pyramid around its cone between near and range. All of them contain the true volume.
    pub fn half_spaces(&self) -> Result<Vec<HalfSpace>, LightError> {
        self.check()?;
        Ok(match *self {
            Self::Directional { .. } => Vec::new(),
            Self::Point { position, range } => [DVec3::X, DVec3::Y, DVec3::Z]
                .into_iter()
                .flat_map(|axis| [axis, -axis])
                .map(|normal| HalfSpace::through(position + normal * range, normal))
                .collect(),
            Self::Spot {
                position,
                direction,
                outer_angle,
                near,
                range,
            } => {
                let axis = direction.normalize();
                let (right, up) = axis.any_orthonormal_pair();
                let (sine, cosine) = outer_angle.sin_cos();
                let sides = (0..CONE_SIDES).map(|side| {
                    let angle = side as f64 / CONE_SIDES as f64 * std::f64::consts::TAU;
                    let outwards = right * angle.cos() + up * angle.sin();
                    HalfSpace::through(position, outwards * cosine - axis * sine)
                });
                let ends = [
                    HalfSpace::through(position + axis * near, -axis),
                    HalfSpace::through(position + axis * range, axis),
                ];
                sides.chain(ends).collect()
            }
        })
    }
}

/// A light view of a light at a point: the matrices that draw one map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLightView {
    /// Rigid: the world in light space.
    pub light_from_world: DMat4,
    /// Perspective, and focus if there is one; reverse z.
    pub clip_from_light: DMat4,
    /// `clip_from_light · light_from_world`.
    pub clip_from_world: DMat4,
    /// Distances along the axis at which depth is 1 and 0 before focusing, in metres.
    pub depths: LinearDepth,
}

impl PointLightView {
    /// A square perspective from a point along −z of the axes, `tangent` metres to each side per metre of distance.
    ///
    /// With s = −z the distance along the axis, depth is near (far − s) ÷ ((far − near) s): 1 at near, 0 at far.
    fn new(position: DVec3, axes: &LightAxes, tangent: f64, depths: LinearDepth) -> Self {
        let rotation = DMat3::from_cols(axes.x, axes.y, axes.z).transpose();
        let light_from_world = DMat4::from_mat3_translation(rotation, -(rotation * position));
        let depth_scale = depths.near / (depths.far - depths.near);
        let clip_from_light = DMat4::from_cols(
            DVec4::new(1.0 / tangent, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 1.0 / tangent, 0.0, 0.0),
            DVec4::new(0.0, 0.0, depth_scale, -1.0),
            DVec4::new(0.0, 0.0, depth_scale * depths.far, 0.0),
        );
        Self {
            light_from_world,
            clip_from_light,
            clip_from_world: clip_from_light * light_from_world,
            depths,
        }
    }

    /// The same light view, zoomed to a body: A_fit in the light's post-perspective space (Stingl, section 3.1.2,
    /// equation 3.1). All of the body ends in the clip box, and every side of the box is touched.
    ///
    /// The box of the projected corners is that of the whole body, because a perspective keeps what lies before its
    /// centre convex. [`LightError::TooWide`] if a corner lies beside or behind the light: clip the body with L first.
    pub fn focused(&self, body: &Polytope) -> Result<Self, LightError> {
        if body.is_empty() {
            return Err(LightError::NothingVisible);
        }
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for vertex in body.vertices() {
            let clip = self.clip_from_world * vertex.extend(1.0);
            if !(clip.w > 1.0e-9 * self.depths.far) {
                return Err(LightError::TooWide);
            }
            let ndc = clip.truncate() / clip.w;
            (low, high) = (low.min(ndc), high.max(ndc));
        }
        let size = (high - low).max(DVec3::splat(1.0e-9));
        let center = (low + high) * 0.5;
        let (from, scale) = (
            DVec3::new(center.x, center.y, center.z - 0.5 * size.z),
            DVec3::new(2.0, 2.0, 1.0) / size,
        );
        let focus_from_clip = DMat4::from_scale(scale) * DMat4::from_translation(-from);
        Ok(Self {
            clip_from_light: focus_from_clip * self.clip_from_light,
            clip_from_world: focus_from_clip * self.clip_from_world,
            ..*self
        })
    }
}

/// Light space of a light at a point that looks along `axis`, turned so that y is the view direction as the light sees
/// it at the world-space point `seen` (Stingl, section 3.2.1: the points e and e + v in post-perspective light space).
///
/// With e and v in light space and s the distance along the axis, (e + t v).xy ÷ s(e + t v) changes along
/// v.xy s(e) − e.xy s(v) for any t: taking the derivative instead of a second point, no point can lie behind the light.
/// `None` when the axis has no direction; where the view direction is seen end-on, the camera's up direction takes
/// over.
pub fn aligned_axes(position: DVec3, axis: DVec3, view: &ViewVolume, seen: DVec3) -> Option<LightAxes> {
    let axes = LightAxes::new(view.forward(), view.up(), axis)?;
    let (offset, along) = (seen - position, view.forward());
    let drift = along * offset.dot(axes.z) - offset * along.dot(axes.z);
    let image = (axes.x * axes.x.dot(drift) + axes.y * axes.y.dot(drift)) * -1.0;
    if image.length() <= 1.0e-6 * offset.length() {
        return Some(axes);
    }
    let y = image.normalize();
    Some(LightAxes {
        x: y.cross(axes.z),
        y,
        ..axes
    })
}

/// The light view of a spot light's whole cone. `axes` from [`aligned_axes`] along its direction.
pub fn spot_view(light: &Light, axes: &LightAxes) -> Result<PointLightView, LightError> {
    light.check()?;
    match *light {
        Light::Spot {
            position,
            outer_angle,
            near,
            range,
            ..
        } => Ok(PointLightView::new(
            position,
            axes,
            outer_angle.tan(),
            LinearDepth { near, far: range },
        )),
        _ => Err(LightError::NoCone),
    }
}

/// The light view of a point light that is focused on a body: the narrow perspective of the papers. `axes` from
/// [`aligned_axes`] along the direction from the light to the middle of what it lights.
///
/// What lies nearer to the light than `near` metres along the axis is cut off: casters there need
/// [`LinearDepth::clamped`]. [`LightError::TooWide`] if some of the receivers `visible` lie there too.
pub fn point_view(
    light: &Light,
    axes: &LightAxes,
    visible: &Polytope,
    body: &Polytope,
    near: f64,
) -> Result<PointLightView, LightError> {
    light.check()?;
    let Light::Point { position, range } = *light else {
        return Err(LightError::NoRange);
    };
    if !(near > 0.0) {
        return Err(LightError::NoRange);
    }
    let before = HalfSpace::through(position - axes.z * near, axes.z);
    if visible
        .vertices()
        .iter()
        .any(|vertex| before.excess(*vertex) > 1.0e-9 * range)
    {
        return Err(LightError::TooWide);
    }
    let far = range.max(2.0 * near);
    PointLightView::new(position, axes, 1.0, LinearDepth { near, far }).focused(&body.clone().clip(&before))
}

/// The six light views of a point light, towards +x, −x, +y, −y, +z and −z: every direction lies in one of them.
pub fn cube_faces(light: &Light, near: f64) -> Result<[PointLightView; 6], LightError> {
    light.check()?;
    match *light {
        Light::Point { position, range } if near > 0.0 && near < range => {
            let depths = LinearDepth { near, far: range };
            Ok(
                [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].map(|axis| {
                    let y = if axis.y == 0.0 { DVec3::Y } else { DVec3::Z };
                    let axes = LightAxes {
                        x: y.cross(-axis),
                        y,
                        z: -axis,
                    };
                    PointLightView::new(position, &axes, 1.0, depths)
                }),
            )
        }
        _ => Err(LightError::NoRange),
    }
}

/// Depth that is linear in the distance from the light along its axis, 1 at `near` and 0 at `far`.
///
/// With a pulled-in near plane (Brabec et al. 2002; Stingl, section 3.1.2): depth has to tell receivers apart, not
/// casters, so its range may begin at the nearest receiver. Casters in front of it are stored at depth 1, nearer to the
/// light than every receiver, and shade what they would have shaded. Lloyd, section 6.4, does the same for the sun.
/// For uniform maps: under a warp, depth that is written per vertex is wrong inside triangles
/// ([`vertex_depth_error`](super::depth_offset::vertex_depth_error)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearDepth {
    /// Distance at which depth is 1, in metres; from any origin along the axis for the sun.
    pub near: f64,
    /// Distance at which depth is 0, in metres.
    pub far: f64,
}

/// Share of its range by which a pulled-in near plane stays in front of the nearest receiver, so that this receiver
/// compares as farther than a clamped caster, bias included.
const PULLED_IN_MARGIN: f64 = 0.01;

impl LinearDepth {
    /// The range of distances along `axis` from `origin` that receivers need: from a hundredth of it in front of the
    /// nearest receiver to the farthest. `None` without receivers.
    pub fn around_receivers(visible: &Polytope, origin: DVec3, axis: DVec3) -> Option<Self> {
        let axis = axis.try_normalize()?;
        if visible.is_empty() {
            return None;
        }
        let distances = visible.vertices().iter().map(|vertex| (vertex - origin).dot(axis));
        let (nearest, far) = distances.fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), distance| {
            (near.min(distance), far.max(distance))
        });
        let length = (far - nearest).max(1.0e-6 * far.abs().max(1.0));
        Some(Self {
            near: nearest - PULLED_IN_MARGIN * length,
            far: nearest + length,
        })
    }

    /// Depth of a distance, clamped to 0..=1 as unclipped rasterisation does.
    pub fn clamped(&self, distance: f64) -> f64 {
        ((self.far - distance) / (self.far - self.near)).clamp(0.0, 1.0)
    }
}
