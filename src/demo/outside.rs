//! The outside view: an inset that shows the player's view volume from outside, with what the shadow systems computed
//! for it.

use bevy::{
    camera::{Viewport, visibility::RenderLayers},
    prelude::*,
    window::PrimaryWindow,
};

use super::{
    DemoSystems,
    hud::Notice,
    input::{Action, Intent},
    overlay::Overlay,
    player::Player,
    screens::{Activity, Screen},
};
use crate::{
    level::sky::UnderSky,
    lod::eyes::LodView,
    shadow::{gizmos::SunShadowGizmos, settings::WithoutSunShadows},
    ui::{help::HelpRoot, judge::JudgeRoot},
};

/// Whether the outside view is shown.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutsideView(pub bool);

/// On the camera of the outside view.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Outside;

/// Lines on this layer are seen from outside only.
const LINES_LAYER: usize = 1;

/// Side of the inset over that of the window.
const SHARE: f32 = 0.4;

/// Where the outside camera stands, seen from the player, in metres: behind, above and beside.
const BACK: f32 = 60.0;
const ABOVE: f32 = 70.0;
const BESIDE: f32 = 45.0;
/// What it looks at: a point that far before the player, in metres.
const AHEAD: f32 = 45.0;

/// The outside camera's place for a player's; a player who looks straight up or down is seen as if looking north.
pub fn outside_of(player: &Transform) -> Transform {
    let forward = player.forward().with_y(0.0).normalize_or(Vec3::NEG_Z);
    let right = forward.cross(Vec3::Y);
    let eye = player.translation - forward * BACK + right * BESIDE + Vec3::Y * ABOVE;
    Transform::from_translation(eye).looking_at(player.translation + forward * AHEAD, Vec3::Y)
}

/// The inset at the right end of a window, above its middle; `None` where the window is too small for one.
pub fn inset(window: UVec2) -> Option<Viewport> {
    let physical_size = (window.as_vec2() * SHARE).as_uvec2();
    (physical_size.min_element() >= 16).then(|| Viewport {
        physical_position: UVec2::new(window.x - physical_size.x, window.y / 10),
        physical_size,
        ..default()
    })
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<OutsideView>().add_systems(
        Update,
        (
            toggle.run_if(in_state(Activity::Running)),
            (spawn_or_despawn, follow).chain(),
            show_lines.run_if(resource_exists::<GizmoConfigStore>),
        )
            .chain()
            .in_set(DemoSystems::Act),
    );
}

fn toggle(intent: Res<Intent>, mut outside: ResMut<OutsideView>, mut notice: ResMut<Notice>) {
    if intent.started(Action::ToggleOutside) {
        outside.0 = !outside.0;
        notice.show(if outside.0 {
            "outside view: intersection bodies and split frusta of your view"
        } else {
            "outside view off"
        });
    }
}

fn spawn_or_despawn(mut commands: Commands, wanted: Res<OutsideView>, cameras: Query<Entity, With<Outside>>) {
    if cameras.is_empty() && wanted.0 {
        commands.spawn((
            Name::new("Outside camera"),
            Outside,
            Camera3d::default(),
            Camera { order: 1, ..default() },
            Projection::Perspective(PerspectiveProjection {
                near: 1.0,
                far: 2000.0,
                ..default()
            }),
            RenderLayers::from_layers(&[0, LINES_LAYER]),
            Msaa::Off,
            UnderSky,
            WithoutSunShadows,
            LodView {
                decides: false,
                ..default()
            },
            DespawnOnExit(Screen::Play),
        ));
    }
    if !wanted.0 {
        cameras.iter().for_each(|camera| commands.entity(camera).despawn());
    }
}

fn follow(
    players: Query<&Transform, (With<Player>, Without<Outside>)>,
    windows: Query<&Window, With<PrimaryWindow>>,
    covering: Query<(), Or<(With<HelpRoot>, With<JudgeRoot>)>>,
    mut cameras: Query<(&mut Transform, &mut Camera), With<Outside>>,
) {
    let (Ok(player), Ok((mut transform, mut camera))) = (players.single(), cameras.single_mut()) else {
        return;
    };
    *transform = outside_of(player);
    if let Ok(window) = windows.single() {
        let viewport = inset(window.physical_size());
        // It is drawn after the interface, and would cover it.
        camera.is_active = viewport.is_some() && covering.is_empty();
        camera.viewport = viewport;
    }
}

/// The overlay's lines in both views, or bodies and slices from outside only where no overlay is on.
fn show_lines(
    outside: Res<OutsideView>,
    overlay: Res<Overlay>,
    players: Query<Entity, With<Player>>,
    mut store: ResMut<GizmoConfigStore>,
) {
    let (config, gizmos) = store.config_mut::<SunShadowGizmos>();
    let only_outside = outside.0 && !overlay.has_lines();
    config.enabled = outside.0 || overlay.has_lines();
    config.render_layers = RenderLayers::layer(if only_outside { LINES_LAYER } else { 0 });
    *gizmos = SunShadowGizmos {
        camera: players.single().ok(),
        ..if only_outside {
            SunShadowGizmos {
                light_views: false,
                ..Overlay::All.gizmos()
            }
        } else {
            overlay.gizmos()
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_player_is_in_sight() {
        for forward in [Vec3::NEG_Z, Vec3::X, Vec3::Y, Vec3::NEG_Y, Vec3::new(0.3, 0.9, 0.1)] {
            let player = Transform::from_xyz(10.0, 2.0, -5.0).looking_to(forward, Vec3::Z);
            let outside = outside_of(&player);
            let towards = (player.translation - outside.translation).normalize();
            assert!(outside.is_finite() && outside.forward().dot(towards) > 0.8, "{forward}");
            assert!(outside.translation.y > player.translation.y);
        }
    }

    #[test]
    fn the_inset_lies_in_the_window() {
        for window in [UVec2::new(1280, 720), UVec2::new(100, 400)] {
            let inset = inset(window).expect("large enough");
            assert!((inset.physical_position + inset.physical_size).cmple(window).all());
        }
        assert!(inset(UVec2::ZERO).is_none() && inset(UVec2::new(1280, 20)).is_none());
    }
}
