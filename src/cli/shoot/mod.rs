//! `umbrage shoot`: pictures of scenes without a window.

pub(super) mod films;
mod sheet;
pub(super) mod stage;
pub(super) mod stats;
pub(super) mod virtual_map;

use std::{
    collections::{BTreeMap, HashSet},
    io::{self, IsTerminal},
    path::{Path, PathBuf},
    thread,
    time::Duration,
};

use bevy::{prelude::*, render::diagnostic::RenderDiagnosticsPlugin};
use indicatif::{ProgressBar, ProgressStyle};

use super::{
    Failure,
    args::{NamedTechnique, Shoot},
    headless,
    judge::{Judge, Judged},
    pass::Pass,
    pictures, remark, say,
    shots::{self, Shard, ShotError},
};
use crate::{
    level::{
        LevelPlugin, LoadedScene, RequestedScene, SceneStatus, Sun, find::asset_root, scene::SceneSource, shot::Shot,
    },
    lod::settings::LodSettings,
    render::{UmbragePlugins, mask::MaskPlugin, spans::ShadowPassSpan},
};
use stage::{NOT_TIMED, Stage, TIMED};
use stats::{FrameTimes, Stats, Take};

/// Takes all pictures that the arguments ask for.
pub(super) fn run(assets: Option<&Path>, args: &Shoot) -> Result<(), Failure> {
    run_with(assets, args, None, |scene| scene.shots.clone()).map(drop)
}

/// The same, and judges every take.
pub(super) fn run_judging(assets: Option<&Path>, args: &Shoot, judge: Judge) -> Result<Judge, Failure> {
    let judged = run_with(assets, args, Some(judge), |scene| scene.shots.clone())?;
    judged.ok_or_else(|| Failure::Failed("nothing was judged".to_owned()))
}

/// The same, with a choice of shots for scenes where no file of shots was given.
pub(super) fn run_with(
    assets: Option<&Path>,
    args: &Shoot,
    judge: Option<Judge>,
    shots_of_scene: fn(&LoadedScene) -> Vec<Shot>,
) -> Result<Option<Judge>, Failure> {
    let mut session = open(assets, args, judge, shots_of_scene)?;
    let result = args.scenes.iter().try_for_each(|scene| session.shoot_scene(scene));
    session.bar.finish_and_clear();
    result?;
    // A shard without shots leaves a file too, so that nobody takes it for lost.
    session.write_stats()?;
    Ok(session.judge)
}

/// Checks the arguments and starts an app for them.
pub(super) fn open<'a>(
    assets: Option<&Path>,
    args: &'a Shoot,
    judge: Option<Judge>,
    shots_of_scene: fn(&LoadedScene) -> Vec<Shot>,
) -> Result<Session<'a>, Failure> {
    let root = asset_root(assets).map_err(Failure::failed)?;
    for scene in &args.scenes {
        scene.check(&root).map_err(Failure::failed)?;
    }
    let from_file = args
        .shots
        .as_deref()
        .map(shots::read_shots)
        .transpose()
        .map_err(Failure::failed)?;
    pictures::make_folder(&args.out).map_err(Failure::Failed)?;
    let mut app = headless::app(&root).map_err(Failure::failed)?;
    app.add_plugins((
        LevelPlugin { assets: root },
        UmbragePlugins,
        MaskPlugin,
        RenderDiagnosticsPlugin,
        ShadowPassSpan,
    ));
    app.world_mut().resource_mut::<LodSettings>().transition.kind = args.lod;
    headless::finish(&mut app);
    Ok(Session {
        stats: Stats::new(&app),
        app,
        args,
        from_file,
        shots_of_scene,
        names: HashSet::new(),
        place: 0,
        bar: progress_bar(),
        judge,
    })
}

/// A bar on a terminal, nothing anywhere else.
pub(super) fn progress_bar() -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(0);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    bar
}

/// Loads a scene in place of the one before; its sun.
pub(super) fn load(app: &mut App, source: &SceneSource, bar: &ProgressBar) -> Result<Entity, Failure> {
    let world = app.world_mut();
    world.insert_resource(SceneStatus::Idle);
    world.insert_resource(RequestedScene(Some(source.clone())));
    loop {
        app.update();
        match app.world().resource::<SceneStatus>() {
            SceneStatus::Ready => break,
            SceneStatus::Failed(problem) => return Err(Failure::Failed(problem.clone())),
            SceneStatus::Loading { done, total, what } => {
                bar.set_message(format!("{source}: {what} {done}/{total}"));
            }
            SceneStatus::Idle => {}
        }
        // Files are read by other threads.
        thread::sleep(Duration::from_millis(1));
    }
    let world = app.world_mut();
    let mut suns = world.query_filtered::<Entity, With<Sun>>();
    let sun = suns.iter(world).next();
    sun.ok_or_else(|| Failure::Failed(format!("{} has no sun", source.name())))
}

/// A running `shoot`.
pub(super) struct Session<'a> {
    pub(super) app: App,
    args: &'a Shoot,
    from_file: Option<Vec<Shot>>,
    shots_of_scene: fn(&LoadedScene) -> Vec<Shot>,
    stats: Stats,
    /// File names so far.
    names: HashSet<String>,
    /// Shots so far, of all scenes: what shards count.
    place: usize,
    pub(super) bar: ProgressBar,
    /// What judging has found; `None`: pictures only.
    judge: Option<Judge>,
}

impl Session<'_> {
    fn shoot_scene(&mut self, source: &SceneSource) -> Result<(), Failure> {
        let (shots, sun) = self.enter(source)?;
        let scene = source.name();
        self.claim_names(&scene, &shots)?;
        self.bar.inc_length((shots.len() * self.args.techniques.len()) as u64);
        for (place, shot) in shots {
            self.shoot_shot(&scene, place, &shot, sun)?;
        }
        Ok(())
    }

    /// Checks the names of all pictures of a scene before the first is drawn.
    fn claim_names(&mut self, scene: &str, shots: &[(usize, Shot)]) -> Result<(), Failure> {
        for (_, shot) in shots {
            for technique in &self.args.techniques {
                for pass in &self.args.passes {
                    let name = pictures::file_name(scene, &shot.name, &technique.text, pass);
                    if self.names.contains(&name) {
                        return Err(Failure::Usage(format!(
                            "two pictures would be called {name}; give scenes, shots and techniques once, with names that differ \
                             in [a-z0-9]"
                        )));
                    }
                    self.names.insert(name);
                }
            }
        }
        Ok(())
    }

    /// Loads a scene; its shots to take with their places among all shots, and its sun.
    pub(super) fn enter(&mut self, source: &SceneSource) -> Result<(Vec<(usize, Shot)>, Entity), Failure> {
        let sun = load(&mut self.app, source, &self.bar)?;
        let shots = self.shots_of(&source.name())?;
        Ok((shots, sun))
    }

    /// The shots to take of the scene just loaded, checked and in the size asked for, with their places among all shots.
    fn shots_of(&mut self, scene: &str) -> Result<Vec<(usize, Shot)>, Failure> {
        let all = match (&self.from_file, &self.args.shots) {
            (Some(shots), Some(file)) => of_file(shots, file, scene)?,
            _ => {
                let loaded = self.app.world().resource::<LoadedScene>();
                loaded.notes.iter().for_each(remark);
                let mut shots = (self.shots_of_scene)(loaded);
                if !self.args.shot.is_empty() {
                    shots.extend(loaded.named_only.iter().cloned());
                }
                shots
            }
        };
        let shots = shots::named(all, &self.args.shot, scene).map_err(Failure::usage)?;
        let first = self.place;
        self.place += shots.len();
        let mut shots: Vec<(usize, Shot)> = (first..).zip(shots).collect();
        shots.retain(|(place, _)| self.args.shard.takes(*place));
        for (_, shot) in &mut shots {
            if let Some(size) = self.args.size {
                (shot.width, shot.height) = (size.width, size.height);
            }
            shots::check(shot).map_err(|problem| {
                Failure::failed(ShotError::InScene {
                    scene: scene.to_owned(),
                    shot: shot.name.clone(),
                    problem,
                })
            })?;
        }
        Ok(shots)
    }

    /// All techniques of one shot.
    fn shoot_shot(&mut self, scene: &str, place: usize, shot: &Shot, sun: Entity) -> Result<(), Failure> {
        let stage = Stage::new(&mut self.app, shot, sun, &self.args.passes);
        if let Some(judge) = &mut self.judge {
            judge.begin_shot(place);
        }
        let first = self.stats.takes.len();
        for technique in &self.args.techniques {
            self.bar
                .set_message(format!("{scene} {} {}", shot.name, technique.text));
            let take = self.take(scene, shot, technique, &stage, sun)?;
            self.stats.takes.push(take);
            self.bar.inc(1);
        }
        stage.strike(&mut self.app);
        if let Some(columns) = self.args.sheet {
            let sheets = sheet::write(&self.args.out, &self.stats.takes[first..], columns)?;
            self.names.extend(sheets);
        }
        self.write_stats()
    }

    /// One technique of one shot.
    fn take(
        &mut self,
        scene: &str,
        shot: &Shot,
        technique: &NamedTechnique,
        stage: &Stage,
        sun: Entity,
    ) -> Result<Take, Failure> {
        let app = &mut self.app;
        stage.apply(app, &technique.technique);
        let (lit, shaded): (Vec<_>, Vec<_>) = self.args.passes.iter().partition(|pass| **pass == Pass::Lit);
        // Judging takes its time elsewhere; `bench` measures frames.
        let timed = if self.judge.is_some() { NOT_TIMED } else { TIMED };
        let settled = stage.settle(app, &shaded, timed)?;
        let mut take = Take {
            scene: scene.to_owned(),
            shot: shot.clone(),
            technique: technique.text.clone(),
            canonical_technique: technique.technique.to_string(),
            settings: stats::settings_of(app, &technique.technique),
            files: BTreeMap::new(),
            is_still: settled.is_still,
            frame_ms: FrameTimes::new(&settled.seconds),
            pass_ms: settled.pass_ms,
            casters: stats::count_casters(app),
            maps: stats::maps_of(app, sun, stage.camera(), &technique.technique),
            light_views: stats::views_of(app, sun, stage.camera(), &technique.technique),
            virtual_map: virtual_map::stats_of(app, stage.camera()),
            films: films::stats_of(app, sun, stage.camera()),
        };
        let mut texels: Vec<_> = shaded.into_iter().zip(settled.texels).collect();
        if let Some(judge) = &mut self.judge {
            let judged = Judged {
                scene,
                shot,
                technique,
                sun,
                camera: stage.camera(),
                texels: &texels,
                texels_drawn: take.maps.texels(),
            };
            judge.judge(app, &judged, &self.args.out, &self.bar)?;
        }
        if !lit.is_empty() {
            stage.set_shadows(app, false);
            let settled = stage.settle(app, &[Pass::Lit], NOT_TIMED)?;
            stage.set_shadows(app, true);
            take.is_still &= settled.is_still;
            texels.extend(settled.texels.into_iter().map(|texels| (Pass::Lit, texels)));
        }
        if !take.is_still {
            remark(format!("{scene}, shot {}: the picture does not stand still", shot.name));
        }
        for (pass, texels) in texels {
            let name = pictures::file_name(scene, &shot.name, &technique.text, pass);
            let path = self.args.out.join(&name);
            pictures::write_png(&path, &texels, pass, shot.far).map_err(Failure::failed)?;
            if io::stdout().is_terminal() {
                self.bar.suspend(|| say(path.display().to_string()));
            }
            take.files.insert(pass.name(), name);
        }
        Ok(take)
    }

    /// Writes the statistics so far. Shards that share a folder write one file each.
    pub(super) fn write_stats(&self) -> Result<(), Failure> {
        let path = self.args.out.join(part_name("stats", self.args.shard));
        let json = serde_json::to_string_pretty(&self.stats).map_err(Failure::failed)?;
        pictures::write_whole(&path, json.as_bytes()).map_err(Failure::failed)
    }
}

/// The file of one shard: `stats.json` when there is only one, else `stats.2-of-3.json`.
pub(super) fn part_name(stem: &str, shard: Shard) -> PathBuf {
    if shard == Shard::ALL {
        format!("{stem}.json").into()
    } else {
        format!("{stem}.{}-of-{}.json", shard.index, shard.count).into()
    }
}

/// The shots of a file for a scene; there must be some.
fn of_file(shots: &[Shot], file: &Path, scene: &str) -> Result<Vec<Shot>, Failure> {
    let own = shots::for_scene(shots, scene);
    if own.is_empty() {
        let mut scenes: Vec<_> = shots.iter().filter_map(|shot| shot.scene.as_deref()).collect();
        scenes.sort_unstable();
        scenes.dedup();
        return Err(Failure::failed(ShotError::NoneForScene {
            file: file.to_owned(),
            scene: scene.to_owned(),
            available: shots::list(scenes.into_iter()),
        }));
    }
    Ok(own)
}
