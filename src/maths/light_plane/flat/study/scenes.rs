//! Scenes like the source's.

use bevy_math::DVec2;

use super::super::{Camera, Degenerate, Exposure, Light, Segment};

/// A scene of flatland with its camera and light.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Of the source's case.
    pub name: &'static str,
    /// Who looks.
    pub camera: Camera,
    /// What is there.
    pub surfaces: Vec<Segment>,
    /// What shines.
    pub light: Light,
}

impl Scene {
    /// The picture on the half-angle film.
    ///
    /// # Errors
    /// Those of [`Exposure::half_angle`].
    pub fn exposure(&self) -> Result<Exposure, Degenerate> {
        Exposure::half_angle(self.light, &self.camera.see(&self.surfaces))
    }
}

/// The source's four cases, rebuilt, with 1000 pixels: a single plane (the source's angles of 9° and 51° fix it), simple
/// geometry (floor and wall), light from top (a wall that faces the viewer under a high light far away), and projection
/// aliasing (a card that points at the light).
pub fn scenes() -> Vec<Scene> {
    let upright = |from: [f64; 2], to: [f64; 2]| Segment::new(at(from), at(to));
    let single_plane_light = -4.0 * 9.0_f64.to_radians().tan();
    let cases = [
        (
            "single plane",
            camera(1.0, 30.0, 1.0, 20.0),
            vec![upright([0.0, -0.452 * 4.0], [0.0, -2.008 * 4.0])],
            [4.0, single_plane_light],
        ),
        (
            "simple geometry",
            camera(1.0, 30.0, 0.5, 20.0),
            vec![upright([0.0, -1.0], [0.0, -6.0]), upright([0.0, -6.0], [3.0, -6.0])],
            [4.0, 0.5],
        ),
        (
            "light from top",
            camera(1.4, 18.0, 0.3, 30.0),
            vec![upright([0.0, -0.8], [0.0, -9.0]), upright([0.0, -9.0], [5.0, -9.0])],
            [33.0, -8.6],
        ),
        (
            "projection aliasing",
            camera(1.0, 30.0, 0.5, 20.0),
            vec![
                upright([0.0, -1.0], [0.0, -12.0]),
                upright([0.0, -4.0], [0.9, -3.7]),
                upright([0.0, -12.0], [5.0, -12.0]),
            ],
            [6.0, -3.2],
        ),
    ];
    let scenes = cases.into_iter().filter_map(|(name, camera, surfaces, light)| {
        Some(Scene {
            name,
            camera: camera.ok()?,
            surfaces,
            light: Light::Point { position: at(light) },
        })
    });
    scenes.collect()
}

/// From the source's (y, z).
fn at([y, z]: [f64; 2]) -> DVec2 {
    DVec2::new(z, y)
}

fn camera(height: f64, half_fov: f64, near: f64, far: f64) -> Result<Camera, Degenerate> {
    Camera::new(at([height, 0.0]), 0.0, half_fov.to_radians(), near, far, 1000)
}
