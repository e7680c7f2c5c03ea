//! The player: a walker that carries the camera.

use bevy::{core_pipeline::prepass::DepthPrepass, prelude::*};

use super::{
    DemoSystems,
    hud::Notice,
    input::{Action, Intent},
    screens::Activity,
    walker::{Mode, Walker},
};
use crate::level::{LoadedScene, sky::UnderSky};

/// On the camera that the player sees through.
#[derive(Component, Clone, Debug)]
#[require(Camera3d)]
pub struct Player {
    /// Where the player is and looks.
    pub walker: Walker,
}

/// The player at the spawn of a scene, with a camera like that of shots: 60 degrees high, no multisampling.
pub(super) fn player(scene: &LoadedScene, mode: Mode) -> impl Bundle {
    let walker = Walker::looking_at(scene.spawn.position, scene.spawn.look_at, mode).settled(&scene.ground);
    (
        Name::new("Player"),
        walker.camera(),
        Player { walker },
        Projection::Perspective(PerspectiveProjection {
            fov: 60f32.to_radians(),
            near: 0.1,
            far: 1000.0,
            ..default()
        }),
        IsDefaultUiCamera,
        // What the full path needs.
        Msaa::Off,
        DepthPrepass,
        UnderSky,
    )
}

pub(super) fn plugin(app: &mut App) {
    app.add_systems(
        Update,
        (toggle_fly, toggle_bob, move_player)
            .chain()
            .in_set(DemoSystems::Act)
            .run_if(in_state(Activity::Running)),
    );
}

fn toggle_fly(intent: Res<Intent>, mut players: Query<&mut Player>, mut notice: ResMut<Notice>) {
    if !intent.started(Action::ToggleFly) {
        return;
    }
    for mut player in &mut players {
        player.walker.toggle_mode();
        notice.show(match player.walker.mode {
            Mode::Walk => "walking",
            Mode::Fly => "flying: E up, Q down",
        });
    }
}

fn toggle_bob(intent: Res<Intent>, mut players: Query<&mut Player>, mut notice: ResMut<Notice>) {
    if !intent.started(Action::ToggleBob) {
        return;
    }
    for mut player in &mut players {
        let sways = &mut player.walker.head_bob;
        *sways = !*sways;
        notice.show(if *sways {
            "the view sways"
        } else {
            "the view does not sway"
        });
    }
}

fn move_player(
    intent: Res<Intent>,
    time: Res<Time>,
    scene: Res<LoadedScene>,
    mut players: Query<(&mut Player, &mut Transform)>,
) {
    for (mut player, mut transform) in &mut players {
        player.walker.step(&intent, &scene.ground, time.delta_secs());
        *transform = player.walker.camera();
    }
}
