//! The loading screen: asks for the scene, shows its progress, goes on to play, or says why not.

use bevy::prelude::*;

use super::{Activity, Screen};
use crate::{
    demo::{
        Verdict,
        input::{Action, Intent},
    },
    level::{LoadedScene, RequestedScene, SceneStatus},
    ui::loading::{Progress, loading},
};

pub(super) fn plugin(app: &mut App) {
    app.add_systems(OnEnter(Screen::Loading), open).add_systems(
        Update,
        (
            leave.run_if(in_state(Screen::Loading).or_else(in_state(Activity::Starting))),
            follow.run_if(in_state(Screen::Loading)),
        ),
    );
}

fn open(mut commands: Commands) {
    commands.spawn((Name::new("Loading camera"), Camera2d, DespawnOnExit(Screen::Loading)));
    commands.spawn((loading(), DespawnOnExit(Screen::Loading)));
}

fn leave(intent: Res<Intent>, status: Res<SceneStatus>, verdict: Res<Verdict>, mut exit: MessageWriter<AppExit>) {
    if !intent.started(Action::TogglePause) {
        return;
    }
    if let SceneStatus::Failed(sentence) = &*status {
        verdict.fail(sentence);
        exit.write(AppExit::error());
    } else {
        exit.write(AppExit::Success);
    }
}

fn follow(
    requested: Res<RequestedScene>,
    status: Res<SceneStatus>,
    loaded: Option<Res<LoadedScene>>,
    mut progress: ResMut<Progress>,
    mut next: ResMut<NextState<Screen>>,
) {
    let title = requested.0.as_ref().map_or_else(String::new, ToString::to_string);
    progress.set_if_neq(progress_of(title, &status));
    if *status == SceneStatus::Ready && loaded.is_some() {
        next.set(Screen::Play);
    }
}

/// What the loading screen shows of `status`.
fn progress_of(title: String, status: &SceneStatus) -> Progress {
    let (fraction, line, failed) = match status {
        SceneStatus::Idle => (None, String::new(), false),
        SceneStatus::Loading { done, total, what } => {
            ((*total > 0).then(|| *done as f32 / *total as f32), what.clone(), false)
        }
        SceneStatus::Ready => (Some(1.0), "ready".to_owned(), false),
        SceneStatus::Failed(sentence) => (None, format!("{sentence}\npress Esc to quit"), true),
    };
    Progress {
        title,
        fraction,
        line,
        failed,
    }
}
