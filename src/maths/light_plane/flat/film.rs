//! Lights, their films and the hulls on them.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use bevy_math::{DMat3, DVec2, DVec3};

use super::{Degenerate, Extents, Frame, Tilt, projection};

/// What shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// From a point, a miner's lamp for example.
    Point {
        /// In the world.
        position: DVec2,
    },
    /// The sun.
    Directional {
        /// The direction in which light travels, of any length.
        travel: DVec2,
    },
}

impl Light {
    /// The light as a homogeneous point (z, y, w): w = 0 for the sun, towards which the first two then point.
    pub fn homogeneous(self) -> DVec3 {
        match self {
            Self::Point { position } => position.extend(1.0),
            Self::Directional { travel } => (-travel).extend(0.0),
        }
    }
}

/// A line on which a light draws its map, at distance 1 from a point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    light: Light,
    /// Light and angle of the film's axis. Under parallel light that axis may be oblique to the rays.
    frame: Frame,
    /// 1 ÷ cosine between the film and the line across the rays; 1 for a point light.
    oblique: f64,
}

impl Film {
    /// A film across a direction of `angle`. Under parallel light it can stand oblique to the rays, which stretches
    /// all of it alike (Chong 4.1.3).
    ///
    /// # Errors
    /// [`Degenerate::NotFinite`], [`Degenerate::NoLightDirection`]; [`Degenerate::TooWide`] if a film under parallel light
    /// stands along the rays or faces away.
    pub fn new(light: Light, angle: f64) -> Result<Self, Degenerate> {
        if !(light.homogeneous().is_finite() && angle.is_finite()) {
            return Err(Degenerate::NotFinite);
        }
        let (origin, oblique) = match light {
            Light::Point { position } => (position, 1.0),
            Light::Directional { travel } => {
                let travel_angle = angle_of(travel).ok_or(Degenerate::NoLightDirection)?;
                let cosine = (angle - travel_angle).cos();
                // Beyond 89.99994° the lateral coordinate has lost half of its digits.
                if cosine < 1.0e-6 {
                    return Err(Degenerate::TooWide);
                }
                (DVec2::ZERO, 1.0 / cosine)
            }
        };
        let frame = Frame { origin, angle };
        Ok(Self { light, frame, oblique })
    }

    /// The film whose axis halves the angle under which the light sees some points, the ordinary shadow map (Chong 3,
    /// 4.1.3), and the hull of the points on it. Under parallel light: the film across the rays.
    ///
    /// The points' directions are taken for an arc of the circle with the widest gap left out, so no order or unwrapping
    /// of angles matters.
    ///
    /// # Errors
    /// [`Degenerate::NothingVisible`] without points, [`Degenerate::TooWide`] if the light is among them,
    /// [`Degenerate::Flat`] if all are on one ray, and those of [`Self::new`].
    pub fn half_angle(light: Light, points: &[DVec2]) -> Result<(Self, Hull), Degenerate> {
        if points.is_empty() {
            return Err(Degenerate::NothingVisible);
        }
        if !points.iter().all(|point| point.is_finite()) {
            return Err(Degenerate::NotFinite);
        }
        let angle = match light {
            Light::Directional { travel } => angle_of(travel).ok_or(Degenerate::NoLightDirection)?,
            Light::Point { position } => {
                let angles = points.iter().filter_map(|point| angle_of(*point - position));
                let mut angles: Vec<f64> = angles.collect();
                angles.sort_by(f64::total_cmp);
                let (Some(first), Some(last)) = (angles.first(), angles.last()) else {
                    return Err(Degenerate::Flat);
                };
                let mut gap = (TAU + first - last, *first, *last);
                for pair in angles.windows(2) {
                    if pair[1] - pair[0] > gap.0 {
                        gap = (pair[1] - pair[0], pair[1], pair[0] + TAU);
                    }
                }
                if gap.0 <= PI {
                    return Err(Degenerate::TooWide);
                }
                wrapped((gap.1 + gap.2) / 2.0)
            }
        };
        let film = Self::new(light, angle)?;
        let hull = film.hull(points)?;
        Ok((film, hull))
    }

    /// What shines on it.
    pub fn light(&self) -> Light {
        self.light
    }

    /// Of its axis, in radians.
    pub fn angle(&self) -> f64 {
        self.frame.angle
    }

    /// Its axis and, of a point light, the light; under parallel light the world's origin.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// The film's coordinate of the light ray through a homogeneous point (z, y, w), as a quotient: across ÷ ahead. Ahead
    /// is positive before the film's view plane. Under parallel light metres, else the tangent τ of the angle off the axis.
    pub fn quotient(&self, point: DVec3) -> (f64, f64) {
        let from_origin = point.truncate() - self.frame.origin * point.z;
        match self.light {
            Light::Point { .. } => (
                from_origin.dot(self.frame.film()),
                from_origin.dot(self.frame.forward()),
            ),
            Light::Directional { travel } => {
                // Cannot be zero: `new` refused that.
                let across = film_across(travel.normalize());
                (from_origin.dot(across) * self.oblique, point.z)
            }
        }
    }

    /// The film's coordinate of a point; `None` where the point is not before the film.
    pub fn coordinate(&self, point: DVec2) -> Option<f64> {
        let (across, ahead) = self.quotient(point.extend(1.0));
        let coordinate = across / ahead;
        (ahead > 0.0 && coordinate.is_finite()).then_some(coordinate)
    }

    /// How fast the coordinate changes as a point moves: the derivative of the quotient.
    pub fn rate(&self, point: DVec2, step: DVec2) -> f64 {
        let (across, ahead) = self.quotient(point.extend(1.0));
        let (across_step, ahead_step) = self.quotient(step.extend(0.0));
        (across_step * ahead - across * ahead_step) / (ahead * ahead)
    }

    /// The smallest hull around some points.
    ///
    /// # Errors
    /// [`Degenerate::NothingVisible`] without points; [`Degenerate::TooWide`] if one of them is not before the film;
    /// [`Degenerate::Flat`].
    pub fn hull(&self, points: &[DVec2]) -> Result<Hull, Degenerate> {
        if points.is_empty() {
            return Err(Degenerate::NothingVisible);
        }
        let mut hull = Hull {
            bottom: f64::INFINITY,
            top: f64::NEG_INFINITY,
        };
        for point in points {
            let coordinate = self.coordinate(*point).ok_or(Degenerate::TooWide)?;
            hull.bottom = hull.bottom.min(coordinate);
            hull.top = hull.top.max(coordinate);
        }
        if hull.top > hull.bottom {
            Ok(hull)
        } else {
            Err(Degenerate::Flat)
        }
    }

    /// From the world to the cube −1..=1 of the map over a hull, near at +1. `near` and `far` are distances along the axis,
    /// under parallel light from the world's origin.
    pub fn cube_from_world(&self, hull: Hull, near: f64, far: f64) -> DMat3 {
        let frame_from_world = self.frame.world_from_frame().inverse();
        match self.light {
            Light::Point { .. } => {
                let extents = Extents {
                    bottom: hull.bottom * near,
                    top: hull.top * near,
                };
                projection(extents, near, far) * frame_from_world
            }
            Light::Directional { .. } => {
                let across = |point| self.quotient(point).0;
                let axes = DVec3::new(across(DVec3::X), across(DVec3::Y), across(DVec3::Z));
                let centre = DVec3::Z * (hull.top + hull.bottom) / 2.0;
                let lateral = (axes - centre) * 2.0 / (hull.top - hull.bottom);
                let ahead = -frame_from_world.row(0);
                let depth = (DVec3::Z * (far + near) - ahead * 2.0) / (far - near);
                DMat3::from_cols(depth, lateral, DVec3::Z).transpose()
            }
        }
    }
}

/// The direction of a film, +y of a frame, from that of its axis.
fn film_across(axis: DVec2) -> DVec2 {
    DVec2::new(axis.y, -axis.x)
}

/// Of a direction, from −z towards +y; `None` without one.
pub(super) fn angle_of(direction: DVec2) -> Option<f64> {
    let direction = direction.try_normalize()?;
    Some(direction.y.atan2(-direction.x))
}

/// The same angle in −π..=π.
pub(super) fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// The part of a film that must be covered, in its coordinate: tan θ_b to tan θ_t (B and T) for a point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hull {
    /// B.
    pub bottom: f64,
    /// T, above B.
    pub top: f64,
}

impl Hull {
    /// l: from a coordinate of the film to −1..=1.
    pub fn place(&self, coordinate: f64) -> f64 {
        (2.0 * coordinate - self.top - self.bottom) / (self.top - self.bottom)
    }

    /// τ: back.
    pub fn coordinate(&self, place: f64) -> f64 {
        ((1.0 + place) * self.top + (1.0 - place) * self.bottom) / 2.0
    }

    /// Between which turns of a point light's film the whole hull is before it: θ_t − 90° and θ_b + 90°, both excluded
    /// (Chong 3.1, A.2).
    pub fn valid_turns(&self) -> (f64, f64) {
        (self.top.atan() - FRAC_PI_2, self.bottom.atan() + FRAC_PI_2)
    }

    /// The tilt that turning a point light's film by `turn` radians makes; `None` for an invalid turn.
    ///
    /// e²ˢ = (cos x + T sin x) ÷ (cos x + B sin x), which is the same as k = (T − B) sin x ÷ (2 cos x + (T + B) sin x): both
    /// parts are cosines of the turned ends of the hull, up to positive factors.
    pub fn tilt_of_turn(&self, turn: f64) -> Option<Tilt> {
        let (sine, cosine) = turn.sin_cos();
        let (high, low) = (cosine + self.top * sine, cosine + self.bottom * sine);
        let is_valid = high > 0.0 && low > 0.0;
        is_valid.then(|| Tilt::new((high / low).ln() / 2.0))
    }

    /// The turn of a point light's film that makes a tilt, in radians.
    pub fn turn_of_tilt(&self, tilt: Tilt) -> f64 {
        let strength = tilt.strength();
        (2.0 * strength).atan2(self.top - self.bottom - strength * (self.top + self.bottom))
    }

    /// The hull on the film after a turn; `None` for an invalid turn.
    pub fn turned(&self, turn: f64) -> Option<Self> {
        self.tilt_of_turn(turn)?;
        let turned = |coordinate: f64| (coordinate.atan() - turn).tan();
        Some(Self {
            bottom: turned(self.bottom),
            top: turned(self.top),
        })
    }
}
