//! Systems: asking cameras for samples, and light planes of one camera.

use bevy::{math::DMat4, prelude::*};

use super::{LightPlaneInput, LightPlaneStates, SeenSurfaces, SurfaceSampling, compute_light_plane_views};
use crate::shadow::{
    compute::Memory,
    settings::{SunShadows, WithoutSunShadows},
    views::CameraSunViews,
};

/// Gives [`SurfaceSampling`] to cameras while a sun asks for light planes, and takes it away.
pub(in crate::shadow) fn ask_cameras(
    mut commands: Commands,
    suns: Query<(&SunShadows, &DirectionalLight)>,
    cameras: Query<(Entity, &Msaa, Has<SurfaceSampling>), (With<Camera3d>, Without<WithoutSunShadows>)>,
) {
    let is_wanted = suns
        .iter()
        .any(|(settings, light)| settings.light_planes.is_some() && light.shadow_maps_enabled);
    for (camera, msaa, is_sampled) in &cameras {
        match (is_wanted, is_sampled) {
            (true, false) if *msaa == Msaa::Off => {
                commands.entity(camera).insert(SurfaceSampling::default());
            }
            (true, false) => warn_once!(
                "a camera with multisampling gets a uniform shadow map: light planes need `Msaa::Off` (SMAA, FXAA and TAA work)"
            ),
            (false, true) => {
                commands.entity(camera).remove::<(SurfaceSampling, SeenSurfaces)>();
            }
            _ => {}
        }
    }
}

/// The light views of one camera, and its state on the light.
pub(in crate::shadow) fn film_views(
    camera_entity: Entity,
    input: &LightPlaneInput,
    memory: Memory,
    states: &mut LightPlaneStates,
) -> Option<CameraSunViews> {
    compute_light_plane_views(input, memory, states.cameras.entry(camera_entity).or_default())
}

/// World to clip space of a camera.
pub(in crate::shadow) fn clip_from_world(camera: &Camera, transform: &GlobalTransform) -> DMat4 {
    camera.clip_from_view().as_dmat4() * transform.to_matrix().as_dmat4().inverse()
}
