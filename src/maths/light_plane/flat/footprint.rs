//! Footprints of pixels on the film, and the derivative that a rasteriser would compute.

use bevy_math::{DMat3, DVec2};

use super::{Camera, Film, Hit, Hull, Light, Segment};

/// What makes the size of a pixel on a light's film (Chong 1.3.4). Film sizes are those at distance 1 of a point light,
/// metres of a film that faces parallel light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelFootprint {
    /// s_p: a pixel's size at distance 1.
    pub pixel_size: f64,
    /// d_p: depth of the surface along the camera's axis, in metres.
    pub camera_depth: f64,
    /// d_l: depth along the light's axis, in metres; 1 for parallel light.
    pub light_depth: f64,
    /// cos α: between the camera's axis and the pixel's ray.
    pub camera_ray: f64,
    /// cos β: between the light's axis and its ray; 1 for parallel light.
    pub light_ray: f64,
    /// cos θ_p: between the surface's normal and the way to the eye.
    pub camera_surface: f64,
    /// cos θ_l: between the surface's normal and the way to the light.
    pub light_surface: f64,
}

/// Why a pixel and the texels do not match (Chong 1.3.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Aliasing {
    /// A texel covers several pixels since it is larger there: s_p d_p is smaller than d_l.
    Perspective,
    /// A texel covers several pixels since the light grazes the surface.
    Projection,
    /// A pixel covers several texels: its one sample of the map flickers without a filter over the comparisons.
    Minification,
}

impl PixelFootprint {
    /// At a hit on a surface. NaN for a surface that is a point.
    pub fn at(camera: &Camera, film: &Film, hit: &Hit, segment: &Segment) -> Self {
        let normal = segment.normal();
        let (from_eye, from_light) = (hit.point - camera.frame().origin, light_ray(film, hit.point));
        let camera_depth = from_eye.dot(camera.frame().forward());
        let (light_depth, light_ray) = match film.light() {
            Light::Point { .. } => {
                let depth = from_light.dot(film.frame().forward());
                (depth, depth / from_light.length())
            }
            Light::Directional { .. } => (1.0, 1.0),
        };
        Self {
            pixel_size: camera.pixel_size(),
            camera_depth,
            light_depth,
            camera_ray: camera_depth / from_eye.length(),
            light_ray,
            camera_surface: normal.dot(from_eye.normalize()).abs(),
            light_surface: normal.dot(from_light.normalize()).abs(),
        }
    }

    /// f as the source has it: s_p d_p cos θ_l ÷ (d_l cos θ_p). Off the axes it is wrong by cos α ÷ cos β, a third in
    /// ordinary views.
    pub fn approximate(&self) -> f64 {
        self.pixel_size * self.camera_depth * self.light_surface / (self.light_depth * self.camera_surface)
    }

    /// |dτ/dp|, exactly: with distances r = d ÷ cos along the rays, s_p cos² α r_p cos θ_l ÷ (r_l cos θ_p cos² β). A ray's
    /// width at distance r grows by cos² α per size on the camera's film; the surface cuts it by 1 ÷ cos θ_p.
    pub fn exact(&self) -> f64 {
        self.approximate() * self.camera_ray / self.light_ray
    }

    /// The part that distances make.
    pub fn perspective(&self) -> f64 {
        self.pixel_size * self.camera_depth * self.camera_ray / (self.light_depth * self.light_ray)
    }

    /// The part that the surface's direction makes: cos θ_l ÷ cos θ_p.
    pub fn projection(&self) -> f64 {
        self.light_surface / self.camera_surface
    }

    /// What is wrong here with texels of a size on the film, and of both kinds of undersampling the stronger.
    pub fn aliasing(&self, texel_size: f64) -> Aliasing {
        if self.exact() >= texel_size {
            Aliasing::Minification
        } else if self.projection() < self.perspective() / texel_size {
            Aliasing::Projection
        } else {
            Aliasing::Perspective
        }
    }
}

fn light_ray(film: &Film, point: DVec2) -> DVec2 {
    match film.light() {
        Light::Point { position } => point - position,
        Light::Directional { travel } => travel,
    }
}

/// From the camera's cube to the light's, as a shader has it (Chong A.2, 2.1.3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transfer {
    map_from_picture: DMat3,
}

impl Transfer {
    /// Between a camera and the part of a film. The light's near and far planes have no influence.
    pub fn new(camera: &Camera, film: &Film, hull: Hull) -> Self {
        let map_from_world = film.cube_from_world(hull, 1.0, 2.0);
        Self {
            map_from_picture: map_from_world * camera.cube_from_world().inverse(),
        }
    }

    /// The place l on the film of a point of the picture and its derivative dl/dp, p and l in −1..=1, by the differences of
    /// the interpolants l q and q: (Δ(l q) − l Δq) ÷ q.
    ///
    /// `depth` is the camera's cube depth and `depth_step` its change per unit of p over the surface
    /// ([`Self::depth_slope`]). The source prints a step without depth, (1, 0, 0): that is the derivative for a surface of
    /// constant cube depth, wrong even in sign for a floor.
    pub fn place_and_rate(&self, pixel: f64, depth: f64, depth_step: f64) -> (f64, f64) {
        let here = self.map_from_picture * DVec2::new(depth, pixel).extend(1.0);
        let step = self.map_from_picture * DVec2::new(depth_step, 1.0).extend(0.0);
        let place = here.y / here.z;
        (place, (step.y - place * step.z) / here.z)
    }

    /// The depth of a point in the camera's cube.
    pub fn cube_depth(camera: &Camera, point: DVec2) -> f64 {
        let point = camera.cube_from_world() * point.extend(1.0);
        point.x / point.z
    }

    /// dz/dp of a surface in the camera's cube, where it is straight; infinite for one that the camera sees edge-on.
    pub fn depth_slope(camera: &Camera, segment: &Segment) -> f64 {
        let line = camera.cube_from_world().inverse().transpose() * segment.line();
        -line.y / line.x
    }
}
