//! Perspective shadow maps as a film in the world (Chong 2.2.3), in two readings.
//!
//! A perspective shadow map is an ordinary one in the camera's cube. Its places are projections from the light, so it is
//! some [`Tilt`] of any film in the world, and lines through the light's view plane tell which. The source reads its film
//! off the near plane instead, pushed as far from the light as the scene allows, and blames it for poor sampling. But near
//! planes do not matter to places. [`PostPerspective::tilt`] is what such a map really does;
//! [`PostPerspective::printed_rule_tilt`] is what the source's tables call PSM, kept to be compared with them. As the near
//! plane goes to the light it becomes the former. Both take the half-angle film of the cube.

use bevy_math::{DMat3, DVec2, DVec3};

use super::{Camera, Degenerate, Exposure, Film, Hit, Hull, Light, Tilt, film::angle_of};

/// |w| of a transformed light below this share of its length: parallel light in the cube.
const PARALLEL: f64 = 1.0e-12;

/// A shadow map in the camera's cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PostPerspective {
    world_from_cube: DMat3,
    cube_from_world: DMat3,
    /// In the cube.
    film: Film,
    hull: Hull,
    /// Distance of the nearest point along the film's axis.
    nearest: f64,
}

impl PostPerspective {
    /// The half-angle map in the cube of a camera. The cube's near and far distances do matter: they stretch its depth,
    /// and with it what "across the light" means.
    ///
    /// The light may stand behind the eye (w < 0): in the cube light then runs towards it, and the order of places turns
    /// round, which changes no texel's size. Light across the view is parallel in the cube.
    ///
    /// # Errors
    /// [`Degenerate::NothingVisible`] without hits; [`Degenerate::TooWide`] if the light's place is among them in the
    /// cube, where the original method moves the camera back; [`Degenerate::Flat`], [`Degenerate::NotFinite`],
    /// [`Degenerate::NoLightDirection`].
    pub fn new(camera: &Camera, light: Light, hits: &[Hit]) -> Result<Self, Degenerate> {
        let cube_from_world = camera.cube_from_world();
        let transformed = cube_from_world
            * light
                .homogeneous()
                .try_normalize()
                .ok_or(Degenerate::NoLightDirection)?;
        let light = if transformed.z.abs() <= PARALLEL * transformed.length() {
            Light::Directional {
                travel: -transformed.truncate(),
            }
        } else {
            Light::Point {
                position: transformed.truncate() / transformed.z,
            }
        };
        let in_cube = hits.iter().map(|hit| {
            let point = cube_from_world * hit.point.extend(1.0);
            point.truncate() / point.z
        });
        let points: Vec<DVec2> = in_cube.collect();
        let (film, hull) = Film::half_angle(light, &points)?;
        let frame = film.frame();
        let depths = points.iter().map(|point| (*point - frame.origin).dot(frame.forward()));
        Ok(Self {
            world_from_cube: cube_from_world.inverse(),
            cube_from_world,
            film,
            hull,
            nearest: depths.fold(f64::INFINITY, f64::min),
        })
    }

    /// The place of a point of the world on the map, −1..=1. There is no near plane in it. `None` behind the map.
    pub fn place(&self, point: DVec2) -> Option<f64> {
        let in_cube = self.cube_from_world * point.extend(1.0);
        let coordinate = self.film.coordinate(in_cube.truncate() / in_cube.z)?;
        Some(self.hull.place(coordinate))
    }

    /// The map's matrix with its near plane at `share` of the way from the light to the nearest point: world to a cube
    /// −1..=1 of its own. For a light behind the eye w is negative. Places do not depend on `share`.
    pub fn map_from_world(&self, share: f64) -> DMat3 {
        let near = self.nearest * share;
        self.film.cube_from_world(self.hull, near, near + 100.0 * near.abs()) * self.cube_from_world
    }

    /// Q: what the direction of the map's film is in the world, a homogeneous point of the camera's view plane. The map's
    /// own view plane goes from the light through it.
    pub fn view_plane_point(&self) -> DVec3 {
        self.world_from_cube * self.film.frame().film().extend(0.0)
    }

    /// What the map really is, as a tilt of another film of the same light that covers the same points.
    ///
    /// # Errors
    /// [`Degenerate::TooWide`] if rounding puts its view plane into the hull.
    pub fn tilt(&self, exposure: &Exposure) -> Result<Tilt, Degenerate> {
        exposure
            .tilt_through(self.view_plane_point())
            .ok_or(Degenerate::TooWide)
    }

    /// The source's rule: the angle in the world of the axis of a film that is parallel to the image of the map's near
    /// plane, which stands at `share` of the way from the light to the nearest point (1: pushed as far as possible). Either
    /// side of the film may be its front. `None` if the image is no line.
    pub fn printed_rule_angle(&self, share: f64) -> Option<f64> {
        let frame = self.film.frame();
        let depth = self.nearest * share;
        // On a point light's film the coordinate is one at distance 1.
        let scale = match self.film.light() {
            Light::Point { .. } => depth,
            Light::Directional { .. } => 1.0,
        };
        let ends = [self.hull.top, self.hull.bottom].map(|coordinate| {
            let in_cube = frame.origin + frame.forward() * depth + frame.film() * (coordinate * scale);
            let point = self.world_from_cube * in_cube.extend(1.0);
            point.truncate() / point.z
        });
        let film = (ends[0] - ends[1]).try_normalize()?;
        angle_of(DVec2::new(-film.y, film.x))
    }

    /// [`Self::printed_rule_angle`] as a tilt. `None` if no side of that film has the whole hull before it.
    pub fn printed_rule_tilt(&self, share: f64, exposure: &Exposure) -> Option<Tilt> {
        let angle = self.printed_rule_angle(share)?;
        [angle, angle + std::f64::consts::PI]
            .into_iter()
            .find_map(|angle| exposure.tilt_of_angle(angle))
    }
}
