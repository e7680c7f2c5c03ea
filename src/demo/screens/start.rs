//! Between loading and play: the scene is drawn behind the loading screen until its shaders are compiled, so that
//! nothing pops up while the player looks.

use std::{
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
    time::Duration,
};

use bevy::{
    prelude::*,
    render::{Render, RenderApp, RenderSystems, render_resource::PipelineCache},
};

use super::Activity;
use crate::ui::loading::{Progress, loading};

/// How many pipelines are waiting for their shaders; the render world writes it.
#[derive(Resource, Clone, Debug, Default)]
pub(in crate::demo) struct Compiling(Arc<AtomicUsize>);

impl Compiling {
    /// Whether there are any.
    pub(in crate::demo) fn is_compiling(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }
}

/// How far the start has come.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
struct Start {
    /// Since it began, in real time.
    since: Duration,
    /// Frames in a row without a pipeline that is waited for.
    quiet_frames: u32,
    /// The most pipelines that were waiting at once.
    most: usize,
}

/// The first frames ask for pipelines, and the render world is one frame behind.
const QUIET_FRAMES: u32 = 4;
/// A driver that takes longer is not waited for.
const PATIENCE: Duration = Duration::from_secs(30);

impl Start {
    /// One more frame, with this many pipelines waiting.
    fn after(self, waiting: usize, frame: Duration) -> Self {
        Self {
            since: self.since + frame,
            quiet_frames: if waiting == 0 { self.quiet_frames + 1 } else { 0 },
            most: self.most.max(waiting),
        }
    }

    fn is_over(&self) -> bool {
        self.quiet_frames >= QUIET_FRAMES || self.since >= PATIENCE
    }
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Start>()
        .add_systems(OnEnter(Activity::Starting), open)
        .add_systems(Update, wait.run_if(in_state(Activity::Starting)));
    let compiling = Compiling::default();
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app
            .insert_resource(compiling.clone())
            .add_systems(Render, count_waiting.in_set(RenderSystems::Cleanup));
        app.insert_resource(compiling);
    }
}

fn count_waiting(pipelines: Res<PipelineCache>, compiling: Res<Compiling>) {
    compiling
        .0
        .store(pipelines.waiting_pipelines().count(), Ordering::Relaxed);
}

fn open(mut commands: Commands, mut start: ResMut<Start>) {
    *start = Start::default();
    commands.spawn((loading(), DespawnOnExit(Activity::Starting)));
}

fn wait(
    compiling: Option<Res<Compiling>>,
    time: Res<Time<Real>>,
    mut start: ResMut<Start>,
    mut progress: ResMut<Progress>,
    mut next: ResMut<NextState<Activity>>,
) {
    let Some(compiling) = compiling else {
        next.set(Activity::Running);
        return;
    };
    let waiting = compiling.0.load(Ordering::Relaxed);
    *start = start.after(waiting, time.delta());
    progress.line = "Compiling shaders".into();
    progress.fraction = Some(1.0 - waiting as f32 / start.most.max(1) as f32);
    if start.is_over() {
        next.set(Activity::Running);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(waiting: &[usize], frame: Duration) -> Option<usize> {
        let mut start = Start::default();
        waiting.iter().position(|waiting| {
            start = start.after(*waiting, frame);
            start.is_over()
        })
    }

    #[test]
    fn the_start_is_over_when_nothing_has_been_waited_for_in_a_while() {
        let frame = Duration::from_millis(16);
        assert_eq!(run(&[0, 0, 7, 5, 0, 1, 0, 0, 0, 0, 0], frame), Some(9));
        assert_eq!(run(&[0, 0, 0, 0], frame), Some(3));
        assert_eq!(run(&[3; 100], frame), None);
    }

    #[test]
    fn patience_ends() {
        assert_eq!(run(&[3; 100], Duration::from_secs(3)), Some(9));
    }
}
