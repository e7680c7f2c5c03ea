//! The systems that run [`compute_camera_views`] for every sun and camera, and hand the result to Bevy's cascades.

use bevy::{
    light::{CascadeShadowConfig, Cascades},
    prelude::*,
};

use super::{
    checked::{Correction, checked, warn_of},
    compute::{compute_camera_views, partition_depths, visible_depths},
    drop_in, full,
    scene_bounds::SceneBounds,
    settings::{ShadowPath, SunShadows, WithoutSunShadows},
    stock::{StockSettings, set_biases},
    view_volume::{shadowed_part, view_volume, wide},
    views::SunViews,
};
use crate::maths::view::ViewVolume;

/// Computes [`SunViews`] of every light with [`SunShadows`] for every active 3D camera.
///
/// On the drop-in path all cameras share their split distances, because Bevy keeps one list per light: the range of
/// depths is then the union of what they see.
pub(super) fn update_sun_views(
    cameras: Query<(Entity, &Camera, &Projection, &GlobalTransform), (With<Camera3d>, Without<WithoutSunShadows>)>,
    mut lights: Query<(&DirectionalLight, &GlobalTransform, &SunShadows, &mut SunViews)>,
    scene: Res<SceneBounds>,
    mut known: Local<Vec<Correction>>,
) {
    let view_volumes: Vec<(Entity, ViewVolume)> = cameras
        .iter()
        .filter(|(_, camera, ..)| camera.is_active)
        .filter_map(
            |(entity, _, projection, transform)| match view_volume(projection, transform) {
                Ok(view) => Some((entity, view)),
                Err(error) => {
                    warn_once!("a camera gets no sun shadows: {error}");
                    None
                }
            },
        )
        .collect();
    for (light, transform, settings, mut views) in &mut lights {
        let before = std::mem::take(&mut views.cameras);
        if !light.shadow_maps_enabled {
            continue;
        }
        let (settings, corrections) = checked(settings);
        warn_of(corrections, &mut known);
        let seen: Vec<(Entity, ViewVolume, (f64, f64))> = view_volumes
            .iter()
            .filter_map(|(entity, view)| {
                let view = shadowed_part(view, settings.near, settings.distance)?;
                let range = visible_depths(&view, &scene)?;
                Some((*entity, view, range))
            })
            .collect();
        let common = seen
            .iter()
            .map(|(.., range)| *range)
            .reduce(|(near, far), (other_near, other_far)| (near.min(other_near), far.max(other_far)));
        let all_orthographic = seen.iter().all(|(_, view, _)| view.is_orthographic());
        for (entity, view, range) in &seen {
            let depths = match (settings.path, common) {
                (ShadowPath::DropIn, Some(common)) => partition_depths(&settings, all_orthographic, common),
                _ => partition_depths(&settings, view.is_orthographic(), *range),
            };
            let light_travel = wide(transform.forward());
            let previous = before.get(entity);
            if let Some(camera_views) = compute_camera_views(view, &scene, light_travel, &settings, &depths, previous) {
                views.cameras.insert(*entity, camera_views);
            }
        }
    }
}

/// Overwrites the cascades that Bevy has just built with those of the light's path.
pub(super) fn write_cascades(
    mut lights: Query<(
        &mut DirectionalLight,
        &SunShadows,
        &SunViews,
        &StockSettings,
        &mut CascadeShadowConfig,
        &mut Cascades,
    )>,
) {
    for (mut light, settings, views, stock, mut config, mut cascades) in &mut lights {
        let (settings, _) = checked(settings);
        set_biases(&settings, stock, &mut light);
        if !light.shadow_maps_enabled {
            continue;
        }
        match settings.path {
            ShadowPath::Full => full::write(views, &mut config, &mut cascades),
            ShadowPath::DropIn => drop_in::write(&settings, views, &mut config, &mut cascades),
        }
    }
}
