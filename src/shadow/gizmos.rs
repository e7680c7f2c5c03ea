//! [`SunShadowGizmos`]: bodies, slices and light views drawn as lines, in the colors of their partitions.

use bevy::{
    color::palettes::basic,
    gizmos::{AppGizmoBuilder, GizmoPlugin},
    prelude::*,
};

use super::{ShadowSystems, compute::light_view_corners, views::SunViews};

/// Draws what the shadow systems computed, when its [`GizmoConfig`] is enabled (it is not by default):
///
/// ```no_run
/// # use bevy::prelude::*;
/// # use umbrage::shadow::gizmos::SunShadowGizmos;
/// fn show(mut store: ResMut<GizmoConfigStore>) {
///     store.config_mut::<SunShadowGizmos>().0.enabled = true;
/// }
/// ```
///
/// Best seen from a second camera that has no shadows of its own, with `camera` set to the first.
#[derive(Clone, Debug, Reflect, GizmoConfigGroup)]
#[reflect(Clone, Default, Debug)]
pub struct SunShadowGizmos {
    /// Only the light views of this camera; `None`: of all.
    pub camera: Option<Entity>,
    /// The intersection bodies B.
    pub bodies: bool,
    /// The slices of the view frustum.
    pub split_frusta: bool,
    /// The clip boxes of the light views: the frusta P of the warps.
    pub light_views: bool,
}

impl Default for SunShadowGizmos {
    fn default() -> Self {
        Self {
            camera: None,
            bodies: true,
            split_frusta: true,
            light_views: true,
        }
    }
}

/// The color of a partition: red, yellow, green, blue, and again (Stingl, equation 5.1).
pub fn partition_color(index: usize) -> Color {
    [basic::RED, basic::YELLOW, basic::LIME, basic::BLUE][index % 4].into()
}

/// Draws [`SunShadowGizmos`] in apps that have Bevy's gizmos.
pub(super) fn plugin(app: &mut App) {
    if !app.is_plugin_added::<GizmoPlugin>() {
        return;
    }
    let disabled = GizmoConfig {
        enabled: false,
        ..default()
    };
    app.insert_gizmo_config(SunShadowGizmos::default(), disabled)
        .add_systems(
            PostUpdate,
            draw.after(ShadowSystems::UpdateLightViews).run_if(is_enabled),
        );
}

fn is_enabled(store: Res<GizmoConfigStore>) -> bool {
    store.config::<SunShadowGizmos>().0.enabled
}

fn draw(lights: Query<&SunViews>, mut gizmos: Gizmos<SunShadowGizmos>) {
    let shown = gizmos.config_ext.clone();
    let views = lights
        .iter()
        .flat_map(|views| &views.cameras)
        .filter(|(camera, _)| shown.camera.is_none_or(|only| only == **camera));
    for (_, camera_views) in views {
        for (index, partition) in camera_views.partitions.iter().enumerate() {
            let color = partition_color(index);
            if shown.bodies {
                for [from, to] in partition.body.edges() {
                    gizmos.line(from.as_vec3(), to.as_vec3(), color);
                }
            }
            let faint = color.with_alpha(0.4);
            if shown.split_frusta && !partition.body.is_empty() {
                draw_box(&mut gizmos, partition.split_frustum, [0, 1, 3, 2, 4, 5, 7, 6], faint);
            }
            if shown.light_views && !partition.body.is_empty() {
                let corners = light_view_corners(&partition.light_view);
                draw_box(&mut gizmos, corners, [0, 1, 2, 3, 4, 5, 6, 7], faint);
            }
        }
    }
}

/// Twelve edges; `order` tells where the corner with the bits x, y, z stands in the array.
fn draw_box(gizmos: &mut Gizmos<SunShadowGizmos>, corners: [Vec3; 8], order: [usize; 8], color: Color) {
    for corner in 0..8 {
        for bit in [1, 2, 4] {
            if corner & bit == 0 {
                gizmos.line(corners[order[corner]], corners[order[corner | bit]], color);
            }
        }
    }
}
