//! The systems that run [`compute_camera_views`] for every sun and camera, and hand the result to Bevy's cascades.

use bevy::{
    ecs::query::QueryData,
    light::{CascadeShadowConfig, Cascades},
    prelude::*,
};

use super::{
    checked::checked,
    compute::{Memory, compute_camera_views, partition_depths, split_range, visible_depths},
    correction::{Correction, warn_of},
    drop_in, full,
    light_plane::{LightPlaneInput, LightPlaneStates, SeenSurfaces, clip_from_world, film_views},
    measured::{DepthPlan, KnownDepths, MeasuredView, VisibleDepthRange, known_depths},
    scene_bounds::SceneBounds,
    settings::{ShadowPath, SunShadows, TransparentLayers, WithoutSunShadows},
    stable::HeldMaps,
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
    cameras: Query<CameraOfSuns, (With<Camera3d>, Without<WithoutSunShadows>)>,
    seen_surfaces: Query<&SeenSurfaces>,
    mut lights: Query<(
        &DirectionalLight,
        &GlobalTransform,
        &SunShadows,
        &mut SunViews,
        &mut HeldMaps,
        &mut LightPlaneStates,
    )>,
    scene: Res<SceneBounds>,
    time: Option<Res<Time>>,
    mut known: Local<Vec<Correction>>,
) {
    let (seconds, frame_seconds) = time.map_or((0.0, 0.0), |time| (time.elapsed_secs_f64(), time.delta_secs_f64()));
    let viewers: Vec<Viewer> = cameras
        .iter()
        .filter(|camera| camera.camera.is_active)
        .filter_map(|camera| match view_volume(camera.projection, camera.transform) {
            Ok(view) => Some(Viewer {
                entity: camera.entity,
                depths: camera.measured_depths(&view, seconds),
                view,
            }),
            Err(error) => {
                warn_once!("a camera gets no sun shadows: {error}");
                None
            }
        })
        .collect();
    for (light, transform, settings, mut views, mut held, mut states) in &mut lights {
        let before = std::mem::take(&mut views.cameras);
        states
            .cameras
            .retain(|camera, _| settings.light_planes.is_some() && cameras.contains(*camera));
        if !light.shadow_maps_enabled {
            held.cameras.clear();
            continue;
        }
        let (settings, corrections) = checked(settings);
        warn_of(corrections, &mut known);
        let seen: Vec<Seen> = viewers
            .iter()
            .filter_map(|viewer| {
                let view = shadowed_part(&viewer.view, settings.near, settings.distance)?;
                let plan = DepthPlan::new(settings.measures(), viewer.depths);
                let range = split_range(&view, &settings, &plan, visible_depths(&view, &scene)?);
                Some(Seen {
                    camera: viewer.entity,
                    view,
                    plan,
                    range,
                })
            })
            .collect();
        let common = seen
            .iter()
            .map(|seen| seen.range)
            .reduce(|(near, far), (other_near, other_far)| (near.min(other_near), far.max(other_far)));
        // Cameras on the drop-in path share one list of split distances: films of one would be wrong for the others.
        let shares_splits = settings.path == ShadowPath::DropIn && seen.len() > 1;
        let picture = |camera: Entity| {
            let surfaces = seen_surfaces.get(camera).ok().filter(|_| !shares_splits);
            surfaces.map(|surfaces| &surfaces.picture)
        };
        let all_orthographic = seen.iter().all(|seen| seen.view.is_orthographic());
        held.cameras
            .retain(|camera, _| seen.iter().any(|seen| seen.camera == *camera));
        for Seen {
            camera,
            view,
            plan,
            range,
        } in &seen
        {
            let depths = match (settings.path, common) {
                (ShadowPath::DropIn, Some(common)) => partition_depths(&settings, all_orthographic, common, None),
                _ => partition_depths(&settings, view.is_orthographic(), *range, plan.splits),
            };
            let light_travel = wide(transform.forward());
            let memory = Memory {
                previous: before.get(camera),
                held: held.cameras.entry(*camera).or_default(),
            };
            let camera_views = match (&settings.light_planes, cameras.get(*camera)) {
                (Some(planes), Ok(place)) => {
                    let input = LightPlaneInput {
                        view,
                        scene: &scene,
                        light_travel,
                        settings: &settings,
                        planes,
                        plan,
                        seen: picture(*camera),
                        clip_from_world: clip_from_world(place.camera, place.transform),
                        seconds: frame_seconds,
                    };
                    film_views(*camera, &input, memory, &mut states)
                }
                _ => compute_camera_views(view, &scene, light_travel, &settings, &depths, plan, memory),
            };
            if let Some(camera_views) = camera_views {
                views.cameras.insert(*camera, camera_views);
            }
        }
    }
}

/// What the light views of a camera depend on.
#[derive(QueryData)]
pub(super) struct CameraOfSuns {
    entity: Entity,
    camera: &'static Camera,
    projection: &'static Projection,
    transform: &'static GlobalTransform,
    measured: Option<&'static VisibleDepthRange>,
}

impl CameraOfSunsItem<'_, '_> {
    fn measured_depths(&self, view: &ViewVolume, seconds: f64) -> KnownDepths {
        let now = MeasuredView {
            world_from_view: *self.transform,
            clip_from_view: self.camera.clip_from_view(),
            seconds,
        };
        self.measured
            .map_or(KnownDepths::Unknown, |measured| known_depths(measured, view, &now))
    }
}

/// A camera that could have sun shadows.
struct Viewer {
    entity: Entity,
    view: ViewVolume,
    depths: KnownDepths,
}

/// A camera that sees something to shadow.
struct Seen {
    camera: Entity,
    view: ViewVolume,
    plan: DepthPlan,
    /// What is split.
    range: (f64, f64),
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
            ShadowPath::Full => {
                let has_transparent_layer = settings.transparent_layers != TransparentLayers::Off;
                full::write(views, has_transparent_layer, &mut config, &mut cascades);
            }
            ShadowPath::DropIn => drop_in::write(&settings, views, &mut config, &mut cascades),
        }
    }
}
