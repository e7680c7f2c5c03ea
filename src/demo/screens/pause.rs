//! The pause menu, and the mouse that belongs to the game only while it runs.

use bevy::{
    prelude::*,
    window::{CursorGrabMode, CursorOptions, PrimaryWindow, WindowFocused},
};

use super::{Activity, Screen};
use crate::{
    demo::input::{Action, Intent},
    ui::pause::{PauseButton, pause},
};

pub(super) fn plugin(app: &mut App) {
    app.add_systems(OnEnter(Activity::Running), capture_mouse)
        .add_systems(OnExit(Activity::Running), release_mouse)
        .add_systems(OnEnter(Activity::Paused), (open, stop_time))
        .add_systems(OnExit(Activity::Paused), start_time)
        .add_systems(
            Update,
            (
                (toggle, pause_without_focus).run_if(in_state(Activity::Running)),
                (toggle, choose).run_if(in_state(Activity::Paused)),
            ),
        );
}

fn open(mut commands: Commands) {
    commands.spawn((pause(), DespawnOnExit(Activity::Paused), DespawnOnExit(Screen::Play)));
}

fn stop_time(mut time: ResMut<Time<Virtual>>) {
    time.pause();
}

fn start_time(mut time: ResMut<Time<Virtual>>) {
    time.unpause();
}

fn capture_mouse(mut windows: Query<&mut CursorOptions, With<PrimaryWindow>>) {
    for mut cursor in &mut windows {
        cursor.visible = false;
        cursor.grab_mode = CursorGrabMode::Locked;
    }
}

fn release_mouse(mut windows: Query<&mut CursorOptions, With<PrimaryWindow>>) {
    for mut cursor in &mut windows {
        cursor.visible = true;
        cursor.grab_mode = CursorGrabMode::None;
    }
}

fn toggle(intent: Res<Intent>, activity: Res<State<Activity>>, mut next: ResMut<NextState<Activity>>) {
    if intent.started(Action::TogglePause) {
        next.set(match activity.get() {
            Activity::Paused => Activity::Running,
            Activity::Starting | Activity::Running | Activity::Judging => Activity::Paused,
        });
    }
}

fn pause_without_focus(mut focus: MessageReader<WindowFocused>, mut next: ResMut<NextState<Activity>>) {
    if focus.read().last().is_some_and(|focus| !focus.focused) {
        next.set(Activity::Paused);
    }
}

fn choose(
    intent: Res<Intent>,
    buttons: Query<(&PauseButton, &Interaction), Changed<Interaction>>,
    mut next: ResMut<NextState<Activity>>,
    mut exit: MessageWriter<AppExit>,
) {
    let clicked = |wanted| {
        buttons
            .iter()
            .any(|(button, interaction)| *button == wanted && *interaction == Interaction::Pressed)
    };
    if intent.started(Action::Quit) || clicked(PauseButton::Quit) {
        exit.write(AppExit::Success);
    } else if clicked(PauseButton::Resume) {
        next.set(Activity::Running);
    }
}
