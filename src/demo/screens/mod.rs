//! The screens as states: loading, then play; while playing: starting, running, paused or judging.

use bevy::prelude::*;

mod loading;
mod pause;
mod play;
mod start;

pub(super) use start::Compiling;

/// What fills the window.
#[derive(States, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Screen {
    /// A scene is being loaded, or failed to load.
    #[default]
    Loading,
    /// The player is in the scene.
    Play,
}

/// Whether the game goes on.
#[derive(SubStates, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[source(Screen = Screen::Play)]
pub enum Activity {
    /// The scene is drawn behind the loading screen, until its shaders are compiled.
    #[default]
    Starting,
    /// The player moves, the mouse is captured.
    Running,
    /// The pause menu is open: time stands still and the mouse is free.
    Paused,
    /// The frame is frozen and compared with ray-traced truth.
    Judging,
}

pub(super) fn plugin(app: &mut App) {
    app.init_state::<Screen>().add_sub_state::<Activity>().add_plugins((
        loading::plugin,
        start::plugin,
        play::plugin,
        pause::plugin,
    ));
}
