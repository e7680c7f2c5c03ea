//! What a run of `bench` found: medians of what was measured, as bench.json has them.

mod output;

use std::{collections::BTreeMap, time::Duration};

use bevy::{
    prelude::*,
    render::{RenderApp, renderer::RenderDevice, settings::WgpuFeatures},
};
use serde::Serialize;

use super::{
    measure::{DRAIN, FrameSample, SETTLE, Samples, WARM_UP},
    memory::ProcessMemory,
    plan::Route,
    statistics::{self, Ratio, median},
};
use crate::{
    cli::{
        args::NamedTechnique,
        shoot::stats::{Adapter, Maps, PassTimes, Processor},
    },
    render::spans::BEVY_SHADOW_PASS,
};

/// Names of passes that draw or apply shadows begin with this, or are [`BEVY_SHADOW_PASS`].
const OWN_PASSES: &str = "umbrage_";

/// The file bench.json.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Report {
    /// Version of Umbrage.
    umbrage: &'static str,
    adapter: Adapter,
    /// Whether the adapter measures the GPU's time.
    pub(super) has_gpu_times: bool,
    scene: String,
    path: String,
    /// Pixels.
    width: u32,
    height: u32,
    /// Measured frames per technique.
    frames: usize,
    /// How it was measured.
    uncounted_frames: Uncounted,
    /// Bytes at the end of the scene's own techniques; null where the system does not say.
    process_memory: Option<ProcessMemory>,
    /// What `ratio` compares with.
    against: Option<String>,
    pub(super) techniques: Vec<TechniqueReport>,
}

/// Frames that were drawn but do not count.
#[derive(Clone, Copy, Debug, Serialize)]
struct Uncounted {
    before_first_block: usize,
    before_later_blocks: usize,
    after_blocks: usize,
}

/// One technique.
#[derive(Clone, Debug, Default, Serialize)]
pub(super) struct TechniqueReport {
    /// As it was given.
    pub(super) technique: String,
    /// The shortest text that means the same.
    canonical_technique: String,
    /// Every setting; null for stock cascades.
    pub(super) settings: serde_json::Value,
    pub(super) frame_ms: Times,
    frames_per_second: Rates,
    /// Medians.
    parts_ms: Parts,
    /// Median of the CPU's share of a frame: both worlds and the way between them, without submission and waiting.
    cpu_ms: f64,
    /// Sum of the medians of the passes that draw and apply shadows; null where the adapter has no timestamps.
    shadow_gpu_ms: Option<f64>,
    /// Frame time and shadow passes over those of the technique that was asked for.
    ratio: Option<Ratios>,
    /// Pass to milliseconds: medians, on the GPU where it has timestamps and on the CPU that records them.
    pub(super) pass_ms: BTreeMap<String, PassTimes>,
    /// Medians of the systems of Umbrage, both worlds; those of Bevy are in `parts_ms` only.
    system_ms: BTreeMap<&'static str, f64>,
    pub(super) maps: Maps,
    /// Entities that cast shadows.
    pub(super) casters: usize,
    casters_drawn: Casters,
    draw_calls: DrawCalls,
    memory: Memory,
    /// Every measured frame.
    pub(super) all: Vec<FrameRow>,
}

/// Times of frames in milliseconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Times {
    median: f64,
    /// Mean of the slowest hundredth of the frames, of one at least.
    low_1_percent: f64,
    fastest: f64,
    quartiles: [f64; 2],
    pub(super) slowest: f64,
}

/// The same as frames per second.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Rates {
    median: f64,
    low_1_percent: f64,
}

/// Parts of a frame in milliseconds, one after the other.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Parts {
    main_world: f64,
    extract: f64,
    /// Without the submission.
    render_world: f64,
    /// Handing commands to the driver; some software drivers draw here.
    submit: f64,
    gpu_wait: f64,
}

#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Ratios {
    /// Of whole frames, with the 95 % bootstrap interval of the ratio of medians (frames drawn in pairs).
    frame: Option<Ratio>,
    /// Of the passes that draw and apply shadows.
    shadow_gpu: Option<f64>,
}

/// Casters drawn, medians over frames.
#[derive(Clone, Debug, Default, Serialize)]
struct Casters {
    /// Into all maps.
    all: f64,
    /// Into each light view, near to far.
    light_views: Vec<f64>,
    /// Into the fallback map of the full path.
    fallback: f64,
}

/// Draw calls of shadow maps, medians over frames. A multi-draw counts once.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct DrawCalls {
    all: f64,
    /// Into Bevy's maps: cascades, or the fallback map of the full path.
    bevy_maps: f64,
    /// Into the atlas of the full path: one multi-draw per light view and bin.
    atlas: f64,
}

/// Bytes, the largest of all frames.
#[derive(Clone, Copy, Debug, Default, Serialize)]
struct Memory {
    all: u64,
    /// Bevy's map array: cascades, or the fallback map and the mask layer of the full path.
    bevy_maps: u64,
    atlas: u64,
    shadow_result: u64,
    caster_buffers: u64,
}

/// One measured frame.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct FrameRow {
    frame: usize,
    /// Seconds on the path.
    pub(super) path_s: f32,
    pub(super) ms: f64,
    main_world_ms: f64,
    extract_ms: f64,
    render_world_ms: f64,
    submit_ms: f64,
    gpu_wait_ms: f64,
    casters_drawn: usize,
}

impl FrameRow {
    fn new(sample: &FrameSample, seconds: &[f32]) -> Self {
        let time = sample.time;
        Self {
            frame: sample.frame,
            path_s: seconds.get(sample.frame).copied().unwrap_or_default(),
            ms: ms(time.total()),
            main_world_ms: ms(time.main_world),
            extract_ms: ms(time.extract),
            render_world_ms: ms(time.render_world),
            submit_ms: ms(time.submit),
            gpu_wait_ms: ms(time.gpu_wait),
            casters_drawn: sample.all_casters(),
        }
    }
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

impl TechniqueReport {
    /// Without measurements.
    pub(super) fn new(technique: &NamedTechnique) -> Self {
        Self {
            technique: technique.text.clone(),
            canonical_technique: technique.technique.to_string(),
            ..Self::default()
        }
    }

    /// Sums up what was measured; `seconds` are the times of the route.
    pub(super) fn fill(&mut self, samples: &Samples, seconds: &[f32]) {
        let frames = &samples.frames;
        self.all = frames.iter().map(|sample| FrameRow::new(sample, seconds)).collect();
        let of_rows = |of: &dyn Fn(&FrameRow) -> f64| self.all.iter().map(of).collect::<Vec<f64>>();
        let of_frames = |of: &dyn Fn(&FrameSample) -> f64| median(&frames.iter().map(of).collect::<Vec<f64>>());
        let largest = |of: &dyn Fn(&FrameSample) -> u64| frames.iter().map(of).max().unwrap_or(0);

        let times = of_rows(&|row| row.ms);
        let quantile = |share| statistics::quantile(&times, share);
        self.frame_ms = Times {
            median: median(&times),
            low_1_percent: statistics::low_1_percent(&times),
            fastest: quantile(0.0),
            quartiles: [0.25, 0.75].map(quantile),
            slowest: quantile(1.0),
        };
        self.frames_per_second = Rates {
            median: rate(self.frame_ms.median),
            low_1_percent: rate(self.frame_ms.low_1_percent),
        };
        self.parts_ms = Parts {
            main_world: median(&of_rows(&|row| row.main_world_ms)),
            extract: median(&of_rows(&|row| row.extract_ms)),
            render_world: median(&of_rows(&|row| row.render_world_ms)),
            submit: median(&of_rows(&|row| row.submit_ms)),
            gpu_wait: median(&of_rows(&|row| row.gpu_wait_ms)),
        };
        self.cpu_ms = of_frames(&|frame| ms(frame.time.cpu()));
        self.pass_ms = pass_medians(&samples.passes);
        self.shadow_gpu_ms = shadow_gpu_ms(&self.pass_ms);
        self.system_ms = samples
            .systems
            .iter()
            .map(|(system, times)| (*system, median(times)))
            .collect();
        let light_views = frames.iter().map(|frame| frame.casters.len()).max().unwrap_or(0);
        self.casters_drawn = Casters {
            all: of_frames(&|frame| frame.all_casters() as f64),
            light_views: (0..light_views)
                .map(|view| of_frames(&|frame| frame.casters.get(view).copied().unwrap_or(0) as f64))
                .collect(),
            fallback: of_frames(&|frame| frame.fallback_casters as f64),
        };
        self.draw_calls = DrawCalls {
            all: of_frames(&|frame| frame.cost.draw_calls() as f64),
            bevy_maps: of_frames(&|frame| frame.cost.bevy_draw_calls as f64),
            atlas: of_frames(&|frame| frame.cost.atlas_draw_calls as f64),
        };
        self.memory = Memory {
            all: largest(&|frame| frame.cost.bytes()),
            bevy_maps: largest(&|frame| frame.cost.bevy_maps),
            atlas: largest(&|frame| frame.cost.atlas),
            shadow_result: largest(&|frame| frame.cost.result),
            caster_buffers: largest(&|frame| frame.cost.caster_buffers),
        };
    }

    fn frame_times(&self) -> Vec<f64> {
        self.all.iter().map(|row| row.ms).collect()
    }
}

/// Frames per second; 0 for no time.
fn rate(frame_ms: f64) -> f64 {
    if frame_ms > 0.0 { 1e3 / frame_ms } else { 0.0 }
}

fn pass_medians(passes: &BTreeMap<(String, Processor), Vec<f64>>) -> BTreeMap<String, PassTimes> {
    let mut medians: BTreeMap<String, PassTimes> = BTreeMap::new();
    for ((pass, processor), times) in passes {
        let of_pass = medians.entry(pass.clone()).or_default();
        match processor {
            Processor::Gpu => of_pass.gpu = Some(median(times)),
            Processor::Cpu => of_pass.cpu = Some(median(times)),
        }
    }
    medians
}

/// Whether a pass draws or applies shadows. One inside the span of another (with a path) is part of that.
pub(super) fn is_of_shadows(pass: &str) -> bool {
    pass == BEVY_SHADOW_PASS || (pass.starts_with(OWN_PASSES) && !pass.contains('/'))
}

/// The sum over all shadow passes; `None` where the time of one is not known.
fn shadow_gpu_ms(passes: &BTreeMap<String, PassTimes>) -> Option<f64> {
    let of_shadows = passes.iter().filter(|(pass, _)| is_of_shadows(pass));
    let times: Option<Vec<f64>> = of_shadows.map(|(_, times)| times.gpu).collect();
    times.filter(|times| !times.is_empty()).map(|times| times.iter().sum())
}

impl Report {
    /// Of a run on the adapter of an app.
    pub(super) fn new(
        app: &App,
        scene: &str,
        route: &Route,
        techniques: Vec<TechniqueReport>,
        process_memory: Option<ProcessMemory>,
    ) -> Self {
        let device = app
            .get_sub_app(RenderApp)
            .and_then(|render_app| render_app.world().get_resource::<RenderDevice>());
        let needed = WgpuFeatures::TIMESTAMP_QUERY
            | WgpuFeatures::TIMESTAMP_QUERY_INSIDE_ENCODERS
            | WgpuFeatures::TIMESTAMP_QUERY_INSIDE_PASSES;
        let (width, height) = route.shots.first().map_or((0, 0), |shot| (shot.width, shot.height));
        Self {
            umbrage: env!("CARGO_PKG_VERSION"),
            adapter: Adapter::of(app),
            has_gpu_times: device.is_some_and(|device| device.features().contains(needed)),
            scene: scene.to_owned(),
            path: route.name.clone(),
            width,
            height,
            frames: route.shots.len(),
            uncounted_frames: Uncounted {
                before_first_block: WARM_UP,
                before_later_blocks: SETTLE,
                after_blocks: DRAIN,
            },
            process_memory,
            against: None,
            techniques,
        }
    }

    /// Fills in ratios to the technique of this text, which is one of those measured.
    pub(super) fn compare(&mut self, against: &str) {
        let rival = self.techniques.iter().find(|report| report.technique == against);
        let Some(rival) = rival else { return };
        let (frame_times, shadow_gpu_ms) = (rival.frame_times(), rival.shadow_gpu_ms);
        self.against = Some(against.to_owned());
        for report in &mut self.techniques {
            let shadow_gpu = report.shadow_gpu_ms.zip(shadow_gpu_ms.filter(|ms| *ms > 0.0));
            report.ratio = Some(Ratios {
                frame: statistics::ratio(&report.frame_times(), &frame_times),
                shadow_gpu: shadow_gpu.map(|(own, of_rival)| own / of_rival),
            });
        }
    }

    /// What was measured, for headings.
    pub(super) fn title(&self) -> String {
        format!("{}, path {}, {}x{}", self.scene, self.path, self.width, self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::headless::FrameTime;

    /// Frames of these times, of which 1 ms each is CPU.
    fn samples(times_ms: &[u64]) -> Samples {
        let frame = |(frame, time): (usize, &u64)| FrameSample {
            frame,
            time: FrameTime {
                main_world: Duration::from_millis(1),
                submit: Duration::from_millis(2),
                gpu_wait: Duration::from_millis(time - 3),
                ..default()
            },
            casters: vec![3, 4],
            fallback_casters: 5,
            ..default()
        };
        let pass = |name: &str, processor, times: &[f64]| ((name.to_owned(), processor), times.to_vec());
        Samples {
            frames: times_ms.iter().enumerate().map(frame).collect(),
            passes: [
                pass("umbrage_draw_casters", Processor::Gpu, &[1.0, 9.0, 2.0]),
                pass("umbrage_draw_casters", Processor::Cpu, &[50.0]),
                pass("umbrage_virtual_map/umbrage_cull_casters", Processor::Gpu, &[100.0]),
                pass(BEVY_SHADOW_PASS, Processor::Gpu, &[0.5]),
                pass("main_opaque_pass_3d", Processor::Gpu, &[70.0]),
            ]
            .into(),
            systems: [("plan_casters", vec![0.25, 0.75])].into(),
        }
    }

    pub(super) fn report(technique: &str, times_ms: &[u64]) -> TechniqueReport {
        let mut report = TechniqueReport::new(&technique.parse().expect("a technique"));
        let seconds: Vec<f32> = (0..times_ms.len()).map(|frame| frame as f32 * 0.5).collect();
        report.fill(&samples(times_ms), &seconds);
        report
    }

    pub(super) fn whole(techniques: Vec<TechniqueReport>) -> Report {
        Report {
            umbrage: "0",
            adapter: Adapter::default(),
            has_gpu_times: true,
            scene: "forest".to_owned(),
            path: "walk".to_owned(),
            width: 64,
            height: 36,
            frames: 3,
            uncounted_frames: Uncounted {
                before_first_block: WARM_UP,
                before_later_blocks: SETTLE,
                after_blocks: DRAIN,
            },
            process_memory: None,
            against: None,
            techniques,
        }
    }

    #[test]
    fn frames_are_summed_up() {
        let report = report("lispsm", &[4, 40, 8]);
        assert_eq!((report.frame_ms.median, report.frame_ms.low_1_percent), (8.0, 40.0));
        assert_eq!((report.frame_ms.fastest, report.frame_ms.quartiles), (4.0, [6.0, 24.0]));
        assert_eq!(report.frames_per_second.low_1_percent, 25.0);
        assert_eq!(
            (report.cpu_ms, report.parts_ms.submit, report.parts_ms.gpu_wait),
            (1.0, 2.0, 5.0)
        );
        assert_eq!(report.system_ms["plan_casters"], 0.5);
        assert_eq!(
            (report.casters_drawn.all, &report.casters_drawn.light_views),
            (12.0, &vec![3.0, 4.0])
        );
    }

    #[test]
    fn shadow_passes_are_ours_and_bevys() {
        let report = report("lispsm", &[4]);
        assert_eq!(
            report.shadow_gpu_ms,
            Some(2.5),
            "2 of ours, 0.5 of Bevy's, none of the main pass, none twice"
        );
        assert_eq!(report.pass_ms["umbrage_draw_casters"].cpu, Some(50.0));
        assert_eq!(shadow_gpu_ms(&BTreeMap::new()), None);
        let mut passes = report.pass_ms;
        passes.entry("umbrage_cull_casters".to_owned()).or_default().cpu = Some(0.1);
        assert_eq!(shadow_gpu_ms(&passes), None, "one pass without a time");
    }

    #[test]
    fn the_rival_has_ratio_one() {
        let mut whole = whole(vec![report("lispsm", &[6, 8, 10]), report("bevy", &[3, 4, 5])]);
        whole.compare("bevy");
        let ratios: Vec<f64> = whole
            .techniques
            .iter()
            .filter_map(|report| report.ratio?.frame)
            .map(|ratio| ratio.of_medians)
            .collect();
        assert_eq!(ratios, [2.0, 1.0]);
    }
}
