//! Main world to render world: light views of full-path suns onto their cameras.

use bevy::{
    prelude::*,
    render::{Extract, ExtractSchedule, RenderApp, sync_world::RenderEntity},
};

use super::camera::takes_full_path;
use crate::maths::polytope::Polytope;
use crate::shadow::{
    checked::checked,
    layout::AtlasLayout,
    settings::{ShadowPath, SunShadows},
    timing::SystemTimes,
    views::{LightView, SunViews},
};

/// On a camera's render entity: the sun that its full-path shadows come from.
#[derive(Component, Clone, Debug)]
pub struct ExtractedSun {
    /// Render entity of the light.
    pub light: Entity,
    /// The settings of this frame.
    pub settings: SunShadows,
    /// Unit vector towards the light.
    pub direction_to_light: Vec3,
    /// View depth from which everything is lit, metres.
    pub shadow_distance: f32,
    /// View depth at which shadows end whatever is seen, metres; may be infinite.
    pub end_depth: f32,
    /// One per map, nearest first.
    pub light_views: Vec<LightView>,
    /// Where the maps lie in the atlas; of no size for a camera that sees nothing.
    pub layout: AtlasLayout,
    /// What the camera sees of the receivers; for virtual maps only.
    pub visible: Option<Polytope>,
}

/// Extracts [`ExtractedSun`].
pub struct ExtractPlugin;

impl Plugin for ExtractPlugin {
    fn build(&self, app: &mut App) {
        let times = SystemTimes::of(app);
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app.add_systems(ExtractSchedule, times.clock("extract_suns", extract_suns));
        }
    }
}

fn extract_suns(
    mut commands: Commands,
    suns: Extract<
        Query<(
            &RenderEntity,
            &DirectionalLight,
            &SunShadows,
            &SunViews,
            &GlobalTransform,
            &ViewVisibility,
        )>,
    >,
    cameras: Extract<Query<(Entity, &RenderEntity, &Msaa), With<Camera3d>>>,
    mut already: Query<&mut ExtractedSun>,
) {
    for (camera, camera_render, msaa) in &cameras {
        let mut full_path_suns = suns.iter().filter(|_| takes_full_path(*msaa));
        let found = full_path_suns.find_map(|(light, directional, settings, views, transform, visibility)| {
            if settings.path != ShadowPath::Full || !directional.shadow_maps_enabled || !visibility.get() {
                return None;
            }
            // A camera without views sees nothing that could be shadowed: its shadow result is lit everywhere.
            let camera_views = views.cameras.get(&camera);
            let partitions = camera_views.map_or(&[][..], |views| &views.partitions);
            let settings = checked(settings).0;
            let whole = partitions.first().filter(|_| settings.maps.is_virtual());
            Some(ExtractedSun {
                light: light.id(),
                visible: whole.map(|partition| partition.visible.clone()),
                settings,
                direction_to_light: *transform.back(),
                shadow_distance: camera_views.map_or(f32::MAX, |views| views.far_depth),
                light_views: partitions
                    .iter()
                    .map(|partition| partition.light_view.clone())
                    .collect(),
                end_depth: camera_views.map_or(f32::INFINITY, |views| views.end_depth),
                layout: camera_views.map(|views| views.layout.clone()).unwrap_or_default(),
            })
        });
        match (found, already.get_mut(camera_render.id())) {
            (Some(sun), Ok(mut old)) => *old = sun,
            (Some(sun), Err(_)) => {
                commands.entity(camera_render.id()).insert(sun);
            }
            (None, Ok(_)) => {
                commands.entity(camera_render.id()).remove::<ExtractedSun>();
            }
            (None, Err(_)) => {}
        }
    }
}
