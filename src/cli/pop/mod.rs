//! `umbrage pop`: how much changes of levels of detail are seen along a camera path.
//!
//! At some places of the path the camera stops and watches. The levels' eye walks on from there along the path, at 60
//! frames per second, so that levels change as they would for a walker; since the camera stands still, pictures change by
//! that and nothing else. The energy of a frame is the squared change of the picture, in linear light, summed over pixels
//! and colours ([`picture_energy`]). When the eye stops, the camera watches on until what fades has ended.
//!
//! All kinds see the same way of the same eye. Kinds driven by time take 0.4 s; Bevy's dither, which is driven by
//! distance, begins as far before a border as the eye walks in 0.4 s.

mod report;
mod strip;

use std::path::Path;

use bevy::prelude::*;

use super::{
    Failure,
    args::{Pop, Shoot},
    headless::{self, Pipelines},
    pass::Pass,
    pictures, say,
    shoot::{
        self, Session,
        stage::{NOT_TIMED, Stage},
    },
    shots::{self, Shard},
};
use crate::{
    level::{LoadedScene, format::CameraPath, shot::Shot},
    lod::{
        LodCounts,
        eyes::LodView,
        settings::{LodDriver, LodKind, LodSettings, LodTransition},
    },
    maths::lod::energy::picture_energy,
    render::capture,
};
use report::{Report, Row};
use strip::Watched;

/// Kinds when none is asked for.
const KINDS: [LodKind; 4] = [LodKind::Hard, LodKind::Dither, LodKind::Plain, LodKind::Unpopping];
/// Frames per second of the eye's way.
const RATE: f32 = 60.0;
/// Seconds of a crossing.
const SECONDS: f32 = 0.4;
/// Frames after the eye's last step: the longest crossing, and the strip's last picture.
const ENDING: u32 = 26;
/// Frames until the levels of a new place are drawn.
const SETTLING: usize = 4;

/// Measures what the arguments ask for.
pub(super) fn run(assets: Option<&Path>, args: &Pop) -> Result<(), Failure> {
    let shoot_args = Shoot {
        scenes: vec![args.scene.clone()],
        shots: None,
        shot: Vec::new(),
        techniques: vec![args.technique.clone()],
        size: Some(args.size),
        passes: vec![Pass::Beauty],
        sheet: None,
        lod: LodKind::default(),
        shard: Shard::ALL,
        out: args.out.clone(),
    };
    let mut session = shoot::open(assets, &shoot_args, None, |scene| scene.shots.clone())?;
    let result = measure(&mut session, args);
    session.bar.finish_and_clear();
    say(result?.table());
    Ok(())
}

fn measure(session: &mut Session, args: &Pop) -> Result<Report, Failure> {
    let (_, sun) = session.enter(&args.scene)?;
    let scene = session.app.world().resource::<LoadedScene>().clone();
    let path = camera_path(&scene, args)?;
    let kinds = if args.kinds.is_empty() {
        &KINDS
    } else {
        args.kinds.as_slice()
    };
    session.bar.inc_length(u64::from(args.stops) * kinds.len() as u64);
    let mut report = Report::new(&args.scene.to_string(), &path.name, args);
    let mut most_seen: Option<Vec<Watched>> = None;
    for stop in 0..args.stops {
        let start = path.duration() * (stop as f32 + 0.5) / args.stops as f32;
        let shot = shot_at(&scene, path, start, args);
        shots::check(&shot)
            .map_err(|problem| Failure::Failed(format!("the path {} at {start} s: {problem}", path.name)))?;
        let stage = Stage::new(&mut session.app, &shot, sun, &[Pass::Beauty]);
        stage.apply(&mut session.app, &args.technique.technique);
        let mut watched = Vec::new();
        for kind in kinds {
            session
                .bar
                .set_message(format!("{} at {start:.1} s, {}", path.name, kind.name()));
            let watch = Watch {
                stage: &stage,
                path,
                start,
                frames: args.frames,
            };
            set_transition(&mut session.app, *kind, watch.speed(), args);
            watched.push(watch.run(&mut session.app, *kind)?);
            session.bar.inc(1);
        }
        stage.strike(&mut session.app);
        report.add(watched.iter().map(Row::of));
        let is_most = |before: &Vec<Watched>| watched[0].peak().1 > before[0].peak().1;
        if most_seen.as_ref().is_none_or(is_most) {
            most_seen = Some(watched);
        }
        report.write(&args.out)?;
    }
    if let Some(watched) = most_seen {
        let pixels = strip::draw(&watched).map_err(Failure::failed)?;
        let name = pictures::file_name(&scene.name, &path.name, args.technique.text.as_str(), "strip");
        let png = pixels.png().map_err(Failure::failed)?;
        pictures::write_whole(&args.out.join(name), &png).map_err(Failure::failed)?;
    }
    Ok(report)
}

/// The path asked for, else the scene's first one.
fn camera_path<'a>(scene: &'a LoadedScene, args: &Pop) -> Result<&'a CameraPath, Failure> {
    let found = match &args.path {
        Some(name) => scene.paths.iter().find(|path| path.name == *name),
        None => scene.paths.first(),
    };
    found.ok_or_else(|| {
        let names = shots::list(scene.paths.iter().map(|path| path.name.as_str()));
        Failure::Usage(match &args.path {
            Some(name) if !scene.paths.is_empty() => {
                format!("{} has no camera path {name}; it has {names}", scene.name)
            }
            _ => format!("{} has no camera path to walk along", scene.name),
        })
    })
}

/// The picture of the camera that stops at a time of the path.
fn shot_at(scene: &LoadedScene, path: &CameraPath, seconds: f32, args: &Pop) -> Shot {
    let (position, target) = path.sample(seconds).unwrap_or((Vec3::ZERO, Vec3::NEG_Z));
    Shot {
        scene: None,
        name: path.name.clone(),
        position: position.to_array(),
        target: target.to_array(),
        up: [0.0, 1.0, 0.0],
        fov_y_deg: 60.0,
        near: 0.1,
        far: 500.0,
        width: args.size.width,
        height: args.size.height,
        light_dir: scene.sun.light_dir().to_array(),
    }
}

/// `speed` is the eye's, in metres per second.
fn set_transition(app: &mut App, kind: LodKind, speed: f32, args: &Pop) {
    let mut settings = app.world_mut().resource_mut::<LodSettings>();
    settings.shadows = args.shadows;
    settings.shadow_bias = args.shadow_bias;
    settings.fading_layers = args.layers;
    // Bevy's dither has none, and all kinds are to change at the same borders.
    settings.hysteresis = 0.0;
    settings.transition = LodTransition {
        kind,
        driver: match kind {
            LodKind::Dither => LodDriver::Distance {
                metres: speed * SECONDS,
            },
            _ => LodDriver::Time { seconds: SECONDS },
        },
    };
}

/// One place of the path.
struct Watch<'a> {
    stage: &'a Stage,
    path: &'a CameraPath,
    start: f32,
    frames: u32,
}

impl Watch<'_> {
    fn eye(&self, frame: u32) -> Vec3 {
        let seconds = self.start + frame as f32 / RATE;
        self.path.sample(seconds).map_or(Vec3::ZERO, |(position, _)| position)
    }

    /// Metres per second of the eye, over all frames.
    fn speed(&self) -> f32 {
        let way = self.eye(0).distance(self.eye(self.frames));
        way * RATE / self.frames as f32
    }

    /// Watches one kind.
    fn run(&self, app: &mut App, kind: LodKind) -> Result<Watched, Failure> {
        let camera = self.stage.camera();
        let place = |app: &mut App, origin: Vec3| {
            app.world_mut().entity_mut(camera).insert(LodView {
                origin: Some(origin),
                ..default()
            });
        };
        // Nothing of the kind before stays: an eye that jumps takes all levels along.
        place(app, self.eye(0) + Vec3::Y * 1e4);
        headless::frame(app);
        place(app, self.eye(0));
        self.stage.settle(app, &[Pass::Beauty], NOT_TIMED)?;
        for _ in 0..SETTLING {
            headless::frame(app);
        }
        let mut watched = Watched::new(kind, self.read(app)?);
        for frame in 1..=self.frames + ENDING {
            place(app, self.eye(frame.min(self.frames)));
            headless::frame(app);
            let picture = self.read(app)?;
            let energy = picture_energy(&watched.last().bytes, &picture.bytes);
            let counts = *app.world().resource::<LodCounts>();
            watched.add(picture, energy, counts);
        }
        Ok(watched)
    }

    fn read(&self, app: &App) -> Result<capture::Texels, Failure> {
        if let Pipelines::Failed(error) = headless::pipelines(app) {
            return Err(Failure::Failed(format!(
                "levels of detail cannot be drawn on this adapter: {error}"
            )));
        }
        let image = self.stage.image(Pass::Beauty);
        let image = image.ok_or_else(|| Failure::Failed("no picture was drawn".to_owned()))?;
        capture::read_image(app, image)
            .map_err(|error| Failure::Failed(format!("the picture cannot be read back: {error}")))
    }
}
