//! The play screen: puts the player into the scene, shows the head-up display and the help.

use bevy::prelude::*;

use super::{Activity, Screen};
use crate::{
    demo::{
        DemoSystems, Notice, Scenes,
        input::{Action, Intent, ROWS},
        player::player,
        walker::Mode,
    },
    level::{LoadedScene, RequestedScene, SceneStatus, scene::SceneSource},
    ui::{
        help::{HelpRoot, help},
        hud::hud,
    },
};

pub(super) fn plugin(app: &mut App) {
    app.add_systems(OnEnter(Screen::Play), open).add_systems(
        Update,
        (
            (toggle_help, next_scene)
                .in_set(DemoSystems::Act)
                .run_if(not(in_state(Activity::Starting))),
            wait_for_scene.run_if(not(resource_exists::<LoadedScene>)),
        )
            .run_if(in_state(Screen::Play)),
    );
}

fn open(
    mut commands: Commands,
    scene: Option<Res<LoadedScene>>,
    requested: Res<RequestedScene>,
    mut notice: ResMut<Notice>,
) {
    let Some(scene) = scene else { return };
    if !scene.notes.is_empty() {
        notice.show(scene.notes.join("\n"));
    }
    // Files of others have no ground to walk on.
    let mode = match requested.0 {
        Some(SceneSource::Gltf(_)) => Mode::Fly,
        _ => Mode::Walk,
    };
    commands.spawn((player(&scene, mode), DespawnOnExit(Screen::Play)));
    commands.spawn((hud(), DespawnOnExit(Screen::Play)));
}

/// A level file that changes while playing is loaded again.
fn wait_for_scene(mut next: ResMut<NextState<Screen>>) {
    next.set(Screen::Loading);
}

fn toggle_help(mut commands: Commands, intent: Res<Intent>, open: Query<Entity, With<HelpRoot>>) {
    if !intent.started(Action::ToggleHelp) {
        return;
    }
    if open.is_empty() {
        let rows = ROWS.iter().map(|row| (row.label(), row.does.to_owned())).collect();
        commands.spawn((help(rows), DespawnOnExit(Screen::Play)));
    }
    for entity in &open {
        commands.entity(entity).despawn();
    }
}

/// Asks for the next level of the list and goes to the loading screen.
fn next_scene(
    intent: Res<Intent>,
    scenes: Res<Scenes>,
    mut requested: ResMut<RequestedScene>,
    mut status: ResMut<SceneStatus>,
    mut next: ResMut<NextState<Screen>>,
) {
    if !intent.started(Action::NextScene) {
        return;
    }
    if let Some(scene) = scenes.after(requested.0.as_ref()) {
        requested.0 = Some(scene);
        // Until the level room takes notice: the old scene's `Ready` must not end the loading screen.
        *status = SceneStatus::Idle;
        next.set(Screen::Loading);
    }
}
