//! Drawing frames and writing down what they took.

use std::collections::BTreeMap;

use bevy::{
    core_pipeline::prepass::{DepthPrepass, NormalPrepass},
    prelude::*,
    render::RenderApp,
};

use super::plan::{Block, Route};
use crate::{
    cli::{
        Failure,
        args::NamedTechnique,
        headless::{self, FrameTime, Pipelines},
        shoot::{
            stage::Stage,
            stats::{self, Processor},
        },
    },
    render::cost::{ShadowCost, shadow_cost},
    shadow::{settings::ShadowPath, technique::Technique, timing::SystemTimes},
};

/// Frames that are not measured before a technique's first block: pipelines are built, buffers grow.
pub(super) const WARM_UP: usize = 10;
/// Frames that are not measured after every later change of the technique: what changed in the main world is extracted,
/// batched and drawn in successive frames, and maps are made anew.
pub(super) const SETTLE: usize = 4;
/// Frames that are drawn after a block to receive the last times of passes: a frame's timestamps are read back while the
/// next one is drawn and reach the main world in the one after that.
pub(super) const DRAIN: usize = 2;
/// Frames after which pipelines that are still not built are given up.
const PATIENCE: usize = 300;

/// What was measured of one technique.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    /// In the order of the route.
    pub(super) frames: Vec<FrameSample>,
    /// Milliseconds.
    pub(super) passes: BTreeMap<(String, Processor), Vec<f64>>,
    /// Milliseconds.
    pub(super) systems: BTreeMap<&'static str, Vec<f64>>,
}

/// One measured frame.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameSample {
    /// Place on the route.
    pub(super) frame: usize,
    pub(super) time: FrameTime,
    /// Casters drawn into each light view, near to far.
    pub(super) casters: Vec<usize>,
    /// Casters drawn into the fallback map of the full path.
    pub(super) fallback_casters: usize,
    pub(super) cost: ShadowCost,
}

impl FrameSample {
    /// Casters drawn into all maps.
    pub(super) fn all_casters(&self) -> usize {
        self.casters.iter().sum::<usize>() + self.fallback_casters
    }
}

/// The scene that is measured.
pub(super) struct Bench<'a> {
    pub(super) app: &'a mut App,
    pub(super) stage: &'a Stage,
    pub(super) sun: Entity,
    pub(super) route: &'a Route,
}

impl Bench<'_> {
    /// Switches to a technique, lets it settle, and measures a block of frames.
    pub(super) fn run(
        &mut self,
        block: &Block,
        technique: &NamedTechnique,
        samples: &mut Samples,
    ) -> Result<(), Failure> {
        self.switch(&technique.technique);
        self.aim(block.frames.start);
        self.settle(if block.is_first { WARM_UP } else { SETTLE }, &technique.text)?;
        let system_times = SystemTimes::of(self.app);
        system_times.switch(true);
        // Times of passes arrive late: those of the settled frames are dropped, those of the drained frames kept.
        for frame in block.frames.clone() {
            self.aim(frame);
            let keep_passes = frame >= block.frames.start + DRAIN;
            let time = self.draw(keep_passes.then_some(&mut *samples));
            for (system, time) in system_times.take() {
                samples
                    .systems
                    .entry(system)
                    .or_default()
                    .push(time.as_secs_f64() * 1e3);
            }
            let sample = self.sample(frame, time, &technique.technique);
            samples.frames.push(sample);
        }
        system_times.switch(false);
        for drained in 0..DRAIN {
            let keep_passes = drained + block.frames.len() >= DRAIN;
            self.draw(keep_passes.then_some(&mut *samples));
        }
        Ok(())
    }

    /// Every technique gets what it needs and no more: only the full path reads the depth prepass.
    fn switch(&mut self, technique: &Technique) {
        self.stage.apply(self.app, technique);
        let mut camera = self.app.world_mut().entity_mut(self.stage.camera());
        if takes_full_path(technique) {
            camera.insert((DepthPrepass, NormalPrepass));
        } else {
            camera.remove::<(DepthPrepass, NormalPrepass)>();
        }
    }

    fn aim(&mut self, frame: usize) {
        if let (Some(shot), Some(mut transform)) = (
            self.route.shots.get(frame),
            self.app.world_mut().get_mut::<Transform>(self.stage.camera()),
        ) {
            *transform = shot.camera();
        }
    }

    /// Draws frames until all pipelines are there and were for some frames.
    fn settle(&mut self, frames: usize, technique: &str) -> Result<(), Failure> {
        let mut ready = 0;
        for _ in 0..PATIENCE {
            headless::frame(self.app);
            match headless::pipelines(self.app) {
                Pipelines::Failed(error) => {
                    return Err(Failure::Failed(format!(
                        "a shader cannot be used on this adapter: {error}"
                    )));
                }
                Pipelines::Waiting => ready = 0,
                Pipelines::Ready => ready += 1,
            }
            if ready >= frames {
                return Ok(());
            }
        }
        Err(Failure::Failed(format!(
            "{technique}: some shaders were not loaded within {PATIENCE} frames"
        )))
    }

    /// Draws one frame; the times of passes that arrived with it go to `samples`.
    fn draw(&mut self, samples: Option<&mut Samples>) -> FrameTime {
        stats::forget_pass_times(self.app);
        let time = headless::timed_frame(self.app);
        if let Some(samples) = samples {
            for (pass, processor, values) in stats::pass_samples(self.app) {
                samples.passes.entry((pass, processor)).or_default().extend(values);
            }
        }
        time
    }

    /// What the frame just drawn contained.
    fn sample(&self, frame: usize, time: FrameTime, technique: &Technique) -> FrameSample {
        let camera = self.stage.camera();
        let views = stats::views_of(self.app, self.sun, camera, technique);
        let has_fallback = takes_full_path(technique) && stats::draws_fallback(self.app, camera);
        let fallback_casters = stats::bevy_casters(self.app.world(), self.sun, camera);
        let cost = self
            .app
            .get_sub_app(RenderApp)
            .zip(stats::render_entity(self.app, camera))
            .map(|(render_app, camera)| shadow_cost(render_app.world(), camera));
        FrameSample {
            frame,
            time,
            casters: views.iter().map(|view| view.casters_drawn).collect(),
            fallback_casters: fallback_casters.first().copied().filter(|_| has_fallback).unwrap_or(0),
            cost: cost.unwrap_or_default(),
        }
    }
}

fn takes_full_path(technique: &Technique) -> bool {
    matches!(technique, Technique::Umbrage(settings) if settings.path == ShadowPath::Full)
}
