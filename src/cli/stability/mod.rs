//! `umbrage judge --along`: how much shadow masks crawl while one thing moves.
//!
//! A shot becomes a sequence of frames at a fixed step ([`along`]). Every frame is drawn once, as in a game (twice for
//! techniques that measure their own picture first), and its mask is compared with the one before ([`stability`]). Truth is traced for every frame of the first technique and
//! serves all of them.
//!
//! # Limits
//! The scene itself must stand still: what moves by itself would be compared with where it was at the beginning, and
//! all levels of detail would count at once.

mod along;
mod report;

pub use along::Along;

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use bevy::{math::UVec2, prelude::*};
use image::ColorType;

use super::{
    Failure,
    args::{Judge, NamedTechnique},
    headless,
    pass::Pass,
    pictures, say,
    shoot::{
        self, Session,
        stage::{NOT_TIMED, Stage},
    },
    shots,
};
use crate::{
    level::{LoadedScene, format::CameraPath, shot::Shot},
    render::{
        capture::{self, Texels},
        reference::{
            accuracy,
            extract::truth_scene,
            pixels::{self, PixelRays, PixelTruth},
            scene::TruthScene,
            stability::{self, MaskFrame},
        },
    },
};
use report::{Report, Sequence};

/// What is read of every frame.
const PASSES: [Pass; 2] = [Pass::Mask, Pass::Depth];

/// Measures all techniques on all shots that the arguments ask for.
pub(super) fn run(assets: Option<&Path>, args: &Judge) -> Result<(), Failure> {
    if args.shoot.passes != [Pass::Beauty] {
        return Err(Failure::Usage(
            "`--passes` chooses pictures of shots; with `--along` there are none".to_owned(),
        ));
    }
    let mut session = shoot::open(assets, &args.shoot, None, |scene| scene.shots.clone())?;
    let result = measure_all(&mut session, args);
    session.bar.finish_and_clear();
    say(result?.table());
    session.write_stats()
}

fn measure_all(session: &mut Session, args: &Judge) -> Result<Report, Failure> {
    let mut results = Results {
        report: Report::default(),
        out: &args.shoot.out,
        file: shoot::part_name("stability", args.shoot.shard),
        names: BTreeSet::new(),
    };
    for source in &args.shoot.scenes {
        let (shots, sun) = session.enter(source)?;
        let scene = source.name();
        let path = camera_path(session.app.world().resource::<LoadedScene>(), args)?;
        let truth = truth_scene(session.app.world_mut(), None).map_err(Failure::failed)?;
        let motions = shots
            .iter()
            .flat_map(|(_, shot)| args.stability.along.iter().map(move |along| (shot, *along)));
        for (shot, along) in motions {
            let frames = along::sequence(along, shot, path.as_ref(), args.stability.frames as usize);
            for frame in &frames {
                shots::check(frame)
                    .map_err(|problem| Failure::Failed(format!("shot {} along {along}: {problem}", shot.name)))?;
            }
            session
                .bar
                .inc_length((frames.len() * args.shoot.techniques.len()) as u64);
            let mut measurement = Measurement {
                stage: Stage::new(&mut session.app, shot, sun, &PASSES),
                truth: &truth,
                frames: &frames,
                seen: Vec::new(),
            };
            for technique in &args.shoot.techniques {
                let message = format!("{scene} {} {along} {}", shot.name, technique.text);
                session.bar.set_message(message);
                let sequence = measurement.measure(session, technique)?;
                results.add(sequence, &scene, shot, along, technique)?;
            }
            measurement.stage.strike(&mut session.app);
        }
    }
    // A shard without shots leaves a file too, so that nobody takes it for lost.
    results.write()?;
    Ok(results.report)
}

/// What has been measured, and where it goes.
struct Results<'a> {
    report: Report,
    out: &'a Path,
    file: PathBuf,
    /// Pictures so far.
    names: BTreeSet<String>,
}

impl Results<'_> {
    /// Adds a sequence and writes all of it.
    fn add(
        &mut self,
        sequence: Sequence,
        scene: &str,
        shot: &Shot,
        along: Along,
        technique: &NamedTechnique,
    ) -> Result<(), Failure> {
        let picture = pictures::file_name(scene, &shot.name, &technique.text, format!("crawl-{along}"));
        if !self.names.insert(picture.clone()) {
            return Err(Failure::Usage(format!(
                "two pictures would be called {picture}; give scenes, shots, techniques and motions once, with names that \
                 differ in [a-z0-9]"
            )));
        }
        let size = UVec2::new(shot.width, shot.height);
        pictures::write_pixels(&self.out.join(&picture), size, &sequence.picture(), ColorType::Rgb8)
            .map_err(Failure::failed)?;
        let row = sequence.row((scene, &shot.name, along, &technique.text), picture);
        self.report.rows.push(row);
        self.write()
    }

    fn write(&self) -> Result<(), Failure> {
        self.report.write(&self.out.join(&self.file))
    }
}

/// The camera path asked for; `None` where none was.
fn camera_path(scene: &LoadedScene, args: &Judge) -> Result<Option<CameraPath>, Failure> {
    let Some(name) = &args.stability.path else {
        return Ok(None);
    };
    match scene.paths.iter().find(|path| path.name == *name) {
        Some(path) => Ok(Some(path.clone())),
        None => Err(Failure::Usage(format!(
            "{} has no camera path `{name}`; it has {}",
            scene.name,
            shots::list(scene.paths.iter().map(|path| path.name.as_str()))
        ))),
    }
}

/// One motion of one shot.
struct Measurement<'a> {
    stage: Stage,
    truth: &'a TruthScene,
    frames: &'a [Shot],
    /// What does not depend on techniques, as far as frames have been drawn.
    seen: Vec<Seen>,
}

/// Camera, depths and truth of one frame.
struct Seen {
    rays: PixelRays,
    depths: Vec<f32>,
    truth: Vec<PixelTruth>,
}

impl Measurement<'_> {
    /// One technique.
    fn measure(&mut self, session: &mut Session, technique: &NamedTechnique) -> Result<Sequence, Failure> {
        let mut sequence = Sequence::default();
        let is_drawn_twice = technique.technique.measures_its_own_picture();
        let mut before: Option<Texels> = None;
        for (index, frame) in self.frames.iter().enumerate() {
            self.stage.aim(&mut session.app, frame);
            let [mask, depth] = if index == 0 {
                self.stage.apply(&mut session.app, &technique.technique);
                self.settled(&mut session.app)?
            } else {
                if is_drawn_twice {
                    headless::frame(&mut session.app);
                }
                headless::frame(&mut session.app);
                self.read(&session.app)?
            };
            if self.seen.len() == index {
                let seen = self.see(frame, &mask, &depth);
                self.seen.push(seen);
            }
            let seen = &self.seen[index];
            let size = seen.rays.size;
            sequence.add_frame(accuracy::compare(size, &mask.bytes, &seen.truth).overall);
            if let Some(before) = &before {
                let frame_before = self.seen[index - 1].frame(before);
                sequence.add_step(&stability::crawl(&frame_before, &seen.frame(&mask)));
            }
            before = Some(mask);
            session.bar.inc(1);
        }
        Ok(sequence)
    }

    /// Mask and depth of the first frame, when everything is loaded and stands still.
    fn settled(&self, app: &mut App) -> Result<[Texels; 2], Failure> {
        let settled = self.stage.settle(app, &PASSES, NOT_TIMED)?;
        <[Texels; 2]>::try_from(settled.texels).map_err(|_| missing())
    }

    /// Mask and depth of the frame just drawn.
    fn read(&self, app: &App) -> Result<[Texels; 2], Failure> {
        let read = |pass| {
            let image = self.stage.image(pass).ok_or_else(missing)?;
            capture::read_image(app, image)
                .map_err(|error| Failure::Failed(format!("the picture cannot be read back: {error}")))
        };
        Ok([read(PASSES[0])?, read(PASSES[1])?])
    }

    fn see(&self, frame: &Shot, mask: &Texels, depth: &Texels) -> Seen {
        let size = UVec2::new(mask.width, mask.height);
        let rays = PixelRays::of_camera(size, &frame.camera(), f64::from(frame.fov_y_deg).to_radians());
        let depths = depth.to_f32();
        let to_light = -Vec3::from(frame.light_dir).as_dvec3();
        let truth = pixels::trace(self.truth, &rays, &depths, f64::from(frame.far), to_light, |_| {}).truth;
        Seen { rays, depths, truth }
    }
}

impl Seen {
    fn frame<'a>(&'a self, mask: &'a Texels) -> MaskFrame<'a> {
        MaskFrame {
            rays: self.rays,
            mask: &mask.bytes,
            depths: &self.depths,
            truth: &self.truth,
        }
    }
}

fn missing() -> Failure {
    Failure::Failed("the passes mask and depth were not drawn".to_owned())
}
