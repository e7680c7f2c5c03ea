//! `umbrage bench`: what techniques cost along a camera path, measured in one run.
//!
//! All techniques see the same frames of the same path. They take turns in blocks of a few frames ([`plan`]), so that
//! what drifts during a run hits all alike. After every change of the technique some frames are drawn that do not count,
//! until its pipelines are built and its maps are there ([`measure`]); the last frames of a block are followed by
//! frames that only receive the GPU's times. Bevy runs without pipelined rendering and every frame is waited for: the
//! parts of a frame's time add up, and nothing of one technique runs while another is measured. A rival in a scene of its own
//! (`--against-scene`, `--against-lod`) is measured after all others.
//!
//! ```text
//! frames 0..5    A: warm-up, 5 frames, drain   B: warm-up, 5 frames, drain
//! frames 5..10   B: settle, 5 frames, drain    A: settle, 5 frames, drain
//! frames 10..    A: settle, …
//! ```

mod figures;
mod measure;
mod memory;
mod plan;
mod report;
mod statistics;

use std::path::Path;

use bevy::{math::UVec2, prelude::*, render::diagnostic::RenderDiagnosticsPlugin};
use indicatif::ProgressBar;

use super::{
    Failure,
    args::{Bench as BenchArgs, NamedTechnique},
    headless,
    pass::Pass,
    pictures, remark, say,
    shoot::{self, stage::Stage, stats},
    shots,
};
use crate::{
    level::{LevelPlugin, LoadedScene, find::asset_root, scene::SceneSource},
    lod::settings::LodSettings,
    render::{UmbragePlugins, spans::ShadowPassSpan},
};
use measure::{Bench, Samples};
use memory::ProcessMemory;
use plan::Route;
use report::{Report, TechniqueReport};

/// Picture size in pixels where none is asked for.
const SIZE: UVec2 = UVec2::new(1280, 720);

/// Measures all techniques that the arguments ask for.
pub(super) fn run(assets: Option<&Path>, args: &BenchArgs) -> Result<(), Failure> {
    let root = asset_root(assets).map_err(Failure::failed)?;
    for scene in std::iter::once(&args.scene).chain(&args.against_scene) {
        scene.check(&root).map_err(Failure::failed)?;
    }
    pictures::make_folder(&args.out).map_err(Failure::Failed)?;
    let mut app = headless::app(&root).map_err(Failure::failed)?;
    app.add_plugins((
        LevelPlugin { assets: root },
        UmbragePlugins,
        RenderDiagnosticsPlugin,
        ShadowPassSpan,
    ));
    app.world_mut().resource_mut::<LodSettings>().transition.kind = args.lod;
    headless::finish(&mut app);
    let bar = shoot::progress_bar();
    let result = measure_all(&mut app, args, &bar);
    bar.finish_and_clear();
    let report = result?;
    report.write(&args.out)?;
    figures::write(&report, &args.out)?;
    say(report.table());
    Ok(())
}

fn measure_all(app: &mut App, args: &BenchArgs, bar: &ProgressBar) -> Result<Report, Failure> {
    let (route, mut reports) = measure_scene(app, args, &args.scene, &techniques(args), bar)?;
    let memory = ProcessMemory::now();
    let mut against = args.against.as_ref().map(|rival| rival.text.clone());
    if let Some(rival) = args.against.as_ref().filter(|_| has_other_scene(args)) {
        let scene = args.against_scene.as_ref().unwrap_or(&args.scene);
        let kind = args.against_lod.unwrap_or(args.lod);
        app.world_mut().resource_mut::<LodSettings>().transition.kind = kind;
        let (_, mut of_rival) = measure_scene(app, args, scene, std::slice::from_ref(rival), bar)?;
        for report in &mut of_rival {
            report.technique = format!("{} in {scene} {}", rival.text, kind.name());
            against = Some(report.technique.clone());
        }
        reports.append(&mut of_rival);
    }
    let mut report = Report::new(app, &args.scene.name(), &route, reports, memory);
    if let Some(against) = &against {
        report.compare(against);
    }
    Ok(report)
}

/// Measures techniques in a scene.
fn measure_scene(
    app: &mut App,
    args: &BenchArgs,
    source: &SceneSource,
    techniques: &[NamedTechnique],
    bar: &ProgressBar,
) -> Result<(Route, Vec<TechniqueReport>), Failure> {
    let sun = shoot::load(app, source, bar)?;
    let scene = source.name();
    let route = route(app.world().resource::<LoadedScene>(), args)?;
    let Some(first) = route.shots.first() else {
        return Err(Failure::Failed(format!(
            "the path {} of {scene} has no keys",
            route.name
        )));
    };
    let stage = Stage::new(app, first, sun, &[Pass::Beauty]);
    let mut samples = vec![Samples::default(); techniques.len()];
    let mut reports: Vec<TechniqueReport> = techniques.iter().map(TechniqueReport::new).collect();
    bar.inc_length((techniques.len() * route.shots.len()) as u64);
    for block in plan::blocks(techniques.len(), route.shots.len()) {
        let technique = &techniques[block.technique];
        bar.set_message(format!("{scene} {} {}", route.name, technique.text));
        let mut bench = Bench {
            app,
            stage: &stage,
            sun,
            route: &route,
        };
        bench.run(&block, technique, &mut samples[block.technique])?;
        bar.inc(block.frames.len() as u64);
        if block.is_first {
            let report = &mut reports[block.technique];
            report.settings = stats::settings_of(app, &technique.technique);
            report.maps = stats::maps_of(app, sun, stage.camera(), &technique.technique);
            report.casters = stats::count_casters(app);
        }
    }
    for (report, samples) in reports.iter_mut().zip(&samples) {
        report.fill(samples, &route.seconds);
    }
    stage.strike(app);
    Ok((route, reports))
}

/// Whether the rival is measured in a scene of its own: after the others, as two scenes are not there at once.
fn has_other_scene(args: &BenchArgs) -> bool {
    args.against_scene.is_some() || args.against_lod.is_some()
}

/// The techniques asked for, and the one that they are measured against, unless it has a scene of its own. One that is given twice is measured twice,
/// which shows the noise.
fn techniques(args: &BenchArgs) -> Vec<NamedTechnique> {
    let mut techniques = args.techniques.clone();
    let is_here = |rival: &&NamedTechnique| !has_other_scene(args) && !args.techniques.contains(rival);
    let rival = args.against.iter().filter(is_here);
    techniques.extend(rival.cloned());
    techniques
}

/// The path asked for, else the scene's first one; of a scene without paths, a round about what its first shot looks at.
fn route(scene: &LoadedScene, args: &BenchArgs) -> Result<Route, Failure> {
    let size = args.size.map_or(SIZE, |size| UVec2::new(size.width, size.height));
    let path = match &args.path {
        Some(name) => {
            let found = scene.paths.iter().find(|path| path.name == *name);
            Some(found.ok_or_else(|| {
                let names = shots::list(scene.paths.iter().map(|path| path.name.as_str()));
                Failure::Usage(format!("{} has no path `{name}`; it has {names}", scene.name))
            })?)
        }
        None => scene.paths.first(),
    };
    let route = match (path, scene.shots.first()) {
        (Some(path), _) => Route::along(path, scene.sun.light_dir(), args.frames, size),
        (None, Some(shot)) => {
            remark(format!(
                "{} has no camera paths: the camera goes round what the shot {} looks at",
                scene.name, shot.name
            ));
            Route::orbit(shot, args.frames, size)
        }
        (None, None) => {
            return Err(Failure::Failed(format!("{} has neither paths nor shots", scene.name)));
        }
    };
    for (frame, shot) in route.shots.iter().enumerate() {
        shots::check(shot).map_err(|problem| {
            Failure::Failed(format!(
                "frame {frame} of the path {} of {}: {problem}",
                route.name, scene.name
            ))
        })?;
    }
    Ok(route)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lod::settings::LodKind;

    fn named(text: &str) -> NamedTechnique {
        text.parse().expect("a technique")
    }

    #[test]
    fn the_rival_is_measured_once() {
        let args = |techniques: &[&str], against: Option<&str>| BenchArgs {
            scene: SceneSource::level("forest"),
            path: None,
            techniques: techniques.iter().map(|text| named(text)).collect(),
            frames: 20,
            against: against.map(named),
            against_scene: None,
            against_lod: None,
            lod: LodKind::default(),
            size: None,
            out: "out".into(),
        };
        let texts = |args: &BenchArgs| -> Vec<String> {
            techniques(args).into_iter().map(|technique| technique.text).collect()
        };
        assert_eq!(texts(&args(&["lispsm"], None)), ["lispsm"]);
        assert_eq!(texts(&args(&["lispsm"], Some("bevy"))), ["lispsm", "bevy"]);
        assert_eq!(texts(&args(&["bevy", "lispsm"], Some("bevy"))), ["bevy", "lispsm"]);
        assert_eq!(texts(&args(&["bevy", "bevy"], None)), ["bevy", "bevy"]);
    }
}
