//! From Bevy's cameras to [`ViewVolume`]s.

use bevy::{math::DVec3, prelude::*};

use crate::maths::view::{ViewError, ViewVolume};

/// The view volume of a camera in world space, for every kind of [`Projection`].
///
/// Cameras with NaN, an empty range or a picture without area (a minimized window) give an error that says so.
pub fn view_volume(projection: &Projection, transform: &GlobalTransform) -> Result<ViewVolume, ViewError> {
    let world_from_view = transform.to_matrix().as_dmat4();
    // Bevy's order: bottom right, top right, top left, bottom left; nearer plane first. View space looks along -z.
    let corners = projection
        .get_frustum_corners(-1.0, -2.0)
        .map(|corner| world_from_view.transform_point3(corner.to_vec3().as_dvec3()));
    let [bottom_right, top_right, top_left, bottom_left] = [0, 1, 2, 3];
    let plane =
        |start: usize| [bottom_left, bottom_right, top_right, top_left].map(|corner: usize| corners[start + corner]);
    ViewVolume::from_corners(
        transform.translation().as_dvec3(),
        transform.forward().as_vec3().as_dvec3(),
        transform.up().as_vec3().as_dvec3(),
        [plane(0), plane(4)],
        f64::from(near_distance(projection)),
        f64::from(projection.far()),
    )
}

fn near_distance(projection: &Projection) -> f32 {
    match projection {
        Projection::Perspective(perspective) => perspective.near,
        Projection::Orthographic(orthographic) => orthographic.near,
        // Reverse z: the near plane is where depth is 1.
        Projection::Custom(custom) => -custom.get_clip_from_view().inverse().project_point3(Vec3::Z).z,
    }
}

/// The part of a view volume that shadows are computed for: `near` and `distance` of the settings, in metres.
///
/// `None` when nothing is left.
pub(super) fn shadowed_part(view: &ViewVolume, near: Option<f32>, distance: Option<f32>) -> Option<ViewVolume> {
    let near = near.map_or(view.near(), |near| view.near().max(f64::from(near)));
    let far = distance.map_or(view.far(), |distance| view.far().min(f64::from(distance)));
    (near < far).then(|| view.split(near, far))
}

/// A world-space direction in double precision.
pub(super) fn wide(direction: Dir3) -> DVec3 {
    direction.as_vec3().as_dvec3()
}
