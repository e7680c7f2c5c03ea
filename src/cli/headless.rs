//! A Bevy app without window and event loop, driven frame by frame: for pictures and for tests.
//!
//! ```no_run
//! use umbrage::{cli::headless, level::find::asset_root};
//!
//! let mut app = headless::app(&asset_root(None)?)?;
//! // Add plugins and spawn things here.
//! headless::finish(&mut app);
//! let time = headless::frame(&mut app);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::{
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, Instant},
};

use bevy::{
    app::{PluginsState, SubApps, TerminalCtrlCHandlerPlugin},
    log::{Level, LogPlugin},
    prelude::*,
    render::{
        Render, RenderApp, RenderPlugin, RenderSystems,
        error_handler::{RenderErrorHandler, RenderErrorPolicy},
        pipelined_rendering::PipelinedRenderingPlugin,
        render_resource::{CachedPipelineState, PipelineCache},
        renderer::{RenderAdapterInfo, RenderGraph, RenderGraphSystems},
        settings::RenderCreation,
    },
    shader::ShaderCacheError,
    tasks::tick_global_task_pools_on_main_thread,
    time::TimeUpdateStrategy,
    window::{ExitCondition, WindowPlugin},
    winit::WinitPlugin,
};

use crate::{
    demo::adapter::{self, NoAdapter},
    level::{find::AssetRoot, loader},
    render::capture,
};

/// Simulated time per frame: headless runs are repeatable, whatever the machine takes.
pub const TIME_STEP: Duration = Duration::from_nanos(1_000_000_000 / 60);

/// An app with Bevy's default plugins, without window, event loop and pipelined rendering, with synchronous pipeline
/// compilation, fixed time steps and warnings on stderr. Levels and assets come from `root`, glTF files from anywhere.
///
/// Add plugins, then call [`finish`], then [`frame`] as often as needed.
///
/// # Errors
/// There is no graphics adapter.
pub fn app(root: &AssetRoot) -> Result<App, NoAdapter> {
    adapter::check()?;
    let mut app = App::new();
    loader::register_sources(&mut app, root);
    let plugins = DefaultPlugins
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        })
        .set(RenderPlugin {
            synchronous_pipeline_compilation: true,
            render_creation: RenderCreation::from(adapter::settings()),
            ..default()
        })
        .set(loader::asset_plugin(root))
        .set(LogPlugin {
            level: Level::WARN,
            // Software rendering is expected here and named in the statistics.
            filter: "bevy_render::renderer=error".to_owned(),
            ..default()
        })
        .disable::<WinitPlugin>()
        .disable::<PipelinedRenderingPlugin>()
        // The loop is ours, so that Ctrl+C can do what it always does.
        .disable::<TerminalCtrlCHandlerPlugin>();
    // The log belongs to the process: the second app of a test must not set it up again.
    static LOG_IS_SET: AtomicBool = AtomicBool::new(false);
    if LOG_IS_SET.swap(true, Ordering::Relaxed) {
        app.add_plugins(plugins.disable::<LogPlugin>());
    } else {
        app.add_plugins(plugins);
    }
    app.insert_resource(TimeUpdateStrategy::ManualDuration(TIME_STEP));
    app.insert_resource(RenderErrorHandler(|error, main_world, _| {
        main_world.insert_resource(RenderFailure(error.description.clone()));
        RenderErrorPolicy::StopRendering
    }));
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app
            .init_resource::<Submission>()
            .add_systems(
                RenderGraph,
                begin_submission
                    .after(RenderGraphSystems::Render)
                    .before(RenderGraphSystems::Submit),
            )
            .add_systems(
                Render,
                end_submission
                    .after(RenderSystems::Render)
                    .before(RenderSystems::Cleanup),
            );
    }
    Ok(app)
}

/// What the GPU refused to do: from then on nothing is drawn, and pictures stay as they are.
#[derive(Resource)]
struct RenderFailure(String);

/// Ends the building of the app: waits for its plugins and finishes them.
pub fn finish(app: &mut App) {
    while app.plugins_state() == PluginsState::Adding {
        tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
}

/// One frame of both worlds, until the GPU has drawn it; the time that it took.
pub fn frame(app: &mut App) -> Duration {
    timed_frame(app).total()
}

/// Where the time of one frame goes, one after the other: nothing runs beside it without pipelined rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameTime {
    /// The main world's schedules.
    pub main_world: Duration,
    /// Main world to render world.
    pub extract: Duration,
    /// The render world's schedules without the submission: preparing, queueing, recording commands.
    pub render_world: Duration,
    /// Handing the commands to the driver, those of read-backs included. Some software drivers draw here.
    pub submit: Duration,
    /// Waiting for the GPU to finish what was submitted.
    pub gpu_wait: Duration,
}

impl FrameTime {
    /// The whole frame.
    #[must_use]
    pub fn total(self) -> Duration {
        self.cpu() + self.submit + self.gpu_wait
    }

    /// What the two worlds take, without drawing.
    #[must_use]
    pub fn cpu(self) -> Duration {
        self.main_world + self.extract + self.render_world
    }
}

/// In the render world: how long the last submission took.
#[derive(Resource, Clone, Copy, Debug, Default)]
struct Submission {
    begin: Option<Instant>,
    time: Duration,
}

fn begin_submission(mut submission: ResMut<Submission>) {
    submission.begin = Some(Instant::now());
}

fn end_submission(mut submission: ResMut<Submission>) {
    submission.time = submission.begin.take().map_or(Duration::ZERO, |begin| begin.elapsed());
}

/// [`App::update`] step by step, and the wait for the GPU.
pub fn timed_frame(app: &mut App) -> FrameTime {
    let mut time = FrameTime::default();
    let mut last = Instant::now();
    let mut lap = |part: &mut Duration| {
        let now = Instant::now();
        *part += now - last;
        last = now;
    };
    let SubApps { main, sub_apps } = app.sub_apps_mut();
    main.run_default_schedule();
    lap(&mut time.main_world);
    for sub_app in sub_apps.values_mut() {
        sub_app.extract(main.world_mut());
        lap(&mut time.extract);
        sub_app.update();
        lap(&mut time.render_world);
        if let Some(mut submission) = sub_app.world_mut().get_resource_mut::<Submission>() {
            time.submit += std::mem::take(&mut submission.time);
        }
    }
    main.world_mut().clear_trackers();
    lap(&mut time.main_world);
    capture::wait_for_gpu(app);
    lap(&mut time.gpu_wait);
    time.render_world = time.render_world.saturating_sub(time.submit);
    time
}

/// The adapter in use, as `name (backend)`.
#[must_use]
pub fn adapter_name(app: &App) -> String {
    match app.world().get_resource::<RenderAdapterInfo>() {
        Some(info) => format!("{} ({})", info.name, info.backend),
        None => "none".to_owned(),
    }
}

/// Whether the pipelines that were asked for so far are built.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Pipelines {
    /// All are there.
    Ready,
    /// Some wait for shaders to be loaded.
    Waiting,
    /// One cannot be built, or what it draws is refused; what the compiler or the GPU says.
    Failed(String),
}

/// The state of all pipelines.
#[must_use]
pub fn pipelines(app: &App) -> Pipelines {
    if let Some(failure) = app.world().get_resource::<RenderFailure>() {
        return Pipelines::Failed(failure.0.clone());
    }
    let Some(cache) = app
        .get_sub_app(RenderApp)
        .and_then(|render_app| render_app.world().get_resource::<PipelineCache>())
    else {
        return Pipelines::Ready;
    };
    for pipeline in cache.pipelines() {
        if let CachedPipelineState::Err(error) = &pipeline.state
            && !matches!(
                error,
                ShaderCacheError::ShaderNotLoaded(_) | ShaderCacheError::ShaderImportNotYetAvailable
            )
        {
            return Pipelines::Failed(error.to_string());
        }
    }
    match cache.waiting_pipelines().next() {
        Some(_) => Pipelines::Waiting,
        None => Pipelines::Ready,
    }
}
