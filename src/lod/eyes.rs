//! The eyes that levels of detail are chosen for.

use bevy::prelude::*;

use super::{casters::product, settings::LodSettings};
use crate::maths::lod::selection::{LodEye, LodMetric};

/// On a 3D camera: how it looks at levels of detail. Cameras without it count as [`LodView::default`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct LodView {
    /// Factor on distances of this view, beside the global one.
    pub bias: f32,
    /// Factor on distances for shadows, beside that, `bias` and the chains' own.
    pub shadow_bias: f32,
    /// Where distances are measured from, world space; `None`: from the camera.
    pub origin: Option<Vec3>,
    /// Whether this view has a say. Views from outside, maps and mirrors may do with what others see.
    pub decides: bool,
}

impl Default for LodView {
    fn default() -> Self {
        Self {
            bias: 1.0,
            shadow_bias: 1.0,
            origin: None,
            decides: true,
        }
    }
}

/// One eye.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Eye {
    camera: Entity,
    position: Vec3,
    /// Of the camera itself.
    camera_position: Vec3,
    /// To the right in the camera's picture, world space.
    right: Vec3,
    lens: LodEye,
    /// Factor on distances for shadows.
    shadow_bias: f64,
}

impl Eye {
    /// Whether it has left its camera.
    fn is_elsewhere(&self) -> bool {
        self.position != self.camera_position
    }
}

/// The eyes of this frame.
#[derive(Resource, Clone, Debug, Default)]
pub struct LodEyes {
    eyes: Vec<Eye>,
    /// How far eyes have moved so far: a bound on the change of any distance, metres.
    travelled: f64,
    /// Everything has to be compared anew: other eyes, lenses or settings.
    are_new: bool,
    /// Nothing fades in this frame: an eye was put elsewhere.
    has_jumped: bool,
}

impl LodEyes {
    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.eyes.is_empty()
    }

    /// Where the cameras stand, also those whose eyes are elsewhere.
    pub fn cameras(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.eyes.iter().map(|eye| eye.camera_position)
    }

    /// Whether a point lies in the right half of the first eye's picture.
    pub(super) fn is_right(&self, point: Vec3) -> bool {
        let first = self.eyes.first();
        first.is_some_and(|eye| (point - eye.camera_position).dot(eye.right) > 0.0)
    }

    /// Whether a view has shadows of other levels than are seen.
    pub(super) fn have_biased_shadows(&self) -> bool {
        self.eyes.iter().any(|eye| eye.shadow_bias != 1.0)
    }

    /// The smallest distance of a point from an eye, through its lens: what borders are compared with. Infinite without eyes.
    #[must_use]
    pub fn distance(&self, point: Vec3, metric: LodMetric) -> f64 {
        self.least(point, |eye| eye.lens.factor(metric))
    }

    /// The same for shadows.
    pub(super) fn shadow_distance(&self, point: Vec3, metric: LodMetric) -> f64 {
        self.least(point, |eye| eye.lens.factor(metric) * eye.shadow_bias)
    }

    fn least(&self, point: Vec3, factor: impl Fn(&Eye) -> f64) -> f64 {
        let distances = self.eyes.iter().map(|eye| {
            let distance = f64::from(eye.position.distance(point));
            distance * factor(eye)
        });
        distances.fold(f64::INFINITY, f64::min)
    }

    /// The largest factor of a lens: by how much more than an eye a distance can change.
    pub(super) fn largest_factor(&self, metric: LodMetric) -> f64 {
        let factors = self.eyes.iter().map(|eye| eye.lens.factor(metric));
        factors.fold(0.0, f64::max)
    }

    /// The same for shadows.
    pub(super) fn largest_shadow_factor(&self, metric: LodMetric) -> f64 {
        let factors = self.eyes.iter().map(|eye| eye.lens.factor(metric) * eye.shadow_bias);
        factors.fold(0.0, f64::max)
    }

    /// How much farther a point is from the first eye's camera than from the eye, metres: what Bevy's own distances are
    /// off by. `None` where cameras and eyes are one.
    pub(super) fn camera_offset(&self, point: Vec3) -> Option<f32> {
        let eye = self.eyes.first().filter(|eye| eye.is_elsewhere())?;
        Some(eye.camera_position.distance(point) - eye.position.distance(point))
    }

    pub(super) fn travelled(&self) -> f64 {
        self.travelled
    }

    pub(super) fn are_new(&self) -> bool {
        self.are_new
    }

    /// Whether an eye was put elsewhere in this frame: nothing fades then, everything is there at once.
    #[must_use]
    pub fn have_jumped(&self) -> bool {
        self.has_jumped
    }

    /// The eyes of the next frame.
    fn update(&mut self, eyes: Vec<Eye>, teleport: f32) {
        let kind = |eye: &Eye| (eye.camera, eye.lens, eye.shadow_bias, eye.is_elsewhere());
        let same = self.eyes.iter().map(kind).eq(eyes.iter().map(kind));
        let same_cameras = self
            .eyes
            .iter()
            .map(|eye| eye.camera)
            .eq(eyes.iter().map(|eye| eye.camera));
        let moves = self
            .eyes
            .iter()
            .zip(&eyes)
            .map(|(old, new)| old.position.distance(new.position));
        let farthest = moves.fold(0.0, f32::max);
        self.has_jumped = !same_cameras || farthest > teleport;
        self.are_new = !same || self.has_jumped;
        self.travelled += f64::from(farthest);
        self.eyes = eyes;
    }
}

/// Looks at all active 3D cameras.
pub(super) fn update_eyes(
    cameras: Query<
        (
            Entity,
            &Camera,
            &Projection,
            &Transform,
            &GlobalTransform,
            Has<ChildOf>,
            Option<&LodView>,
        ),
        With<Camera3d>,
    >,
    settings: Res<LodSettings>,
    mut eyes: ResMut<LodEyes>,
) {
    let mut found: Vec<Eye> = Vec::new();
    for (camera, settings_of_camera, projection, local, global, is_child, view) in &cameras {
        let view = view.copied().unwrap_or_default();
        if !settings_of_camera.is_active || !view.decides {
            continue;
        }
        let half_view = match projection {
            Projection::Perspective(perspective) => (0.5 * f64::from(perspective.fov)).tan(),
            _ => LodEye::default().half_view,
        };
        // Transforms are propagated later in the frame.
        let (own, right) = if is_child {
            (global.translation(), *global.right())
        } else {
            (local.translation, *local.right())
        };
        found.push(Eye {
            camera,
            position: view.origin.unwrap_or(own),
            camera_position: own,
            right,
            lens: LodEye {
                half_view,
                bias: f64::from(view.bias * settings.bias),
            },
            shadow_bias: product([view.shadow_bias]),
        });
    }
    found.retain(|eye| eye.position.is_finite());
    found.sort_by_key(|eye| eye.camera);
    eyes.update(found, settings.teleport);
    eyes.are_new |= settings.is_changed();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn eye(index: u32, x: f32, bias: f64) -> Eye {
        Eye {
            camera: Entity::from_raw_u32(index).expect("an entity"),
            position: Vec3::X * x,
            camera_position: Vec3::ZERO,
            right: Vec3::X,
            lens: LodEye { bias, ..default() },
            shadow_bias: 1.0,
        }
    }

    #[test]
    fn the_nearest_eye_decides() {
        let mut eyes = LodEyes::default();
        assert_eq!(eyes.distance(Vec3::ZERO, LodMetric::Distance), f64::INFINITY);
        eyes.update(vec![eye(1, 10.0, 1.0), eye(2, -4.0, 3.0)], 10.0);
        assert_eq!(eyes.distance(Vec3::ZERO, LodMetric::Distance), 10.0);
        assert_eq!(eyes.largest_factor(LodMetric::Distance), 3.0);
        assert_eq!(eyes.camera_offset(Vec3::X * 12.0), Some(10.0));
    }

    #[test]
    fn shadows_have_distances_of_their_own() {
        let mut eyes = LodEyes::default();
        let coarse = Eye {
            shadow_bias: 4.0,
            ..eye(1, 2.0, 1.0)
        };
        eyes.update(vec![coarse, eye(2, -3.0, 2.0)], 10.0);
        assert!(eyes.have_biased_shadows());
        assert_eq!(eyes.distance(Vec3::ZERO, LodMetric::Distance), 2.0);
        assert_eq!(eyes.shadow_distance(Vec3::ZERO, LodMetric::Distance), 6.0);
        assert_eq!(eyes.largest_shadow_factor(LodMetric::Distance), 4.0);
    }

    #[test]
    fn pictures_have_a_right_half() {
        let mut eyes = LodEyes::default();
        assert!(!eyes.is_right(Vec3::X));
        eyes.update(vec![eye(1, 10.0, 1.0)], 10.0);
        assert!(eyes.is_right(Vec3::new(0.1, 0.0, -5.0)), "the camera is at the origin");
        assert!(!eyes.is_right(Vec3::new(-0.1, 0.0, -5.0)));
    }

    #[test]
    fn steps_add_up_and_jumps_are_noticed() {
        let mut eyes = LodEyes::default();
        eyes.update(vec![eye(1, 1.0, 1.0)], 10.0);
        assert!(eyes.has_jumped && eyes.are_new, "the first eye");
        eyes.update(vec![eye(1, 3.0, 1.0)], 10.0);
        assert!(!eyes.has_jumped && !eyes.are_new, "a step");
        assert_eq!(eyes.travelled, 2.0);
        eyes.update(vec![eye(1, 3.0, 2.0)], 10.0);
        assert!(!eyes.has_jumped && eyes.are_new, "another lens");
        eyes.update(vec![eye(1, 50.0, 2.0)], 10.0);
        assert!(eyes.has_jumped, "47 m in a frame");
        eyes.update(vec![eye(1, 0.0, 2.0)], 100.0);
        assert!(!eyes.has_jumped && eyes.are_new, "back at its camera");
        eyes.update(vec![eye(1, 0.0, 2.0)], 100.0);
        assert!(!eyes.are_new, "still there");
        eyes.update(vec![eye(1, 0.5, 2.0)], 100.0);
        assert!(eyes.are_new, "away from its camera");
    }
}
