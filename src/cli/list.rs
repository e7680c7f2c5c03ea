//! `umbrage list`: what there is.

use std::{fs, path::Path};

use bevy::math::Vec3;

use super::{Failure, args::ListWhat, pass::Pass, remark, say};
use crate::{
    level::{
        find::{AssetRoot, EXTENSION, asset_root},
        format::{Level, LevelShot},
        parse::parse,
        scene::SceneSource,
        sky::course::clock,
    },
    plot::figures::figures,
    shadow::technique::{PRESETS, StockBias, Technique, keys},
};

/// Prints a list, one entry per line: name, two spaces at least, meaning.
pub(super) fn run(assets: Option<&Path>, what: &ListWhat) -> Result<(), Failure> {
    match what {
        ListWhat::Scenes => {
            let root = asset_root(assets).map_err(Failure::failed)?;
            for name in root.level_names() {
                say(format!("{name:<20} {}", level(&root, &name)?.about));
            }
        }
        ListWhat::Techniques => techniques(),
        ListWhat::Passes => {
            for pass in Pass::ALL {
                say(format!("{:<8} {}", pass.name(), pass.about()));
            }
        }
        ListWhat::Plots => {
            for figure in figures() {
                say(format!("{:<34} {} ({})", figure.name, figure.title, figure.source));
            }
        }
        ListWhat::Shots { scene } => shots(assets, scene)?,
        ListWhat::Paths { scene } => paths(assets, scene)?,
    }
    Ok(())
}

fn techniques() {
    for technique in Technique::all() {
        say(format!("{:<20} {}", technique.to_string(), technique.summary()));
    }
    let tuned = Technique::Bevy(StockBias::TUNED);
    say(format!("{:<20} {}", tuned.to_string(), tuned.summary()));
    say("\npresets");
    for (name, settings) in PRESETS {
        let technique = Technique::Umbrage(settings);
        say(format!("{name:<20} {technique}: {}", technique.summary()));
    }
    say("\nkeys, as in zp4+lispsm:size=1024,filter=hard");
    for (key, values, bases) in keys() {
        if bases.is_empty() {
            say(format!("{key:<20} {values}"));
        } else {
            say(format!("{key:<20} {values} ({})", bases.join("; ")));
        }
    }
}

fn shots(assets: Option<&Path>, scene: &SceneSource) -> Result<(), Failure> {
    let root = asset_root(assets).map_err(Failure::failed)?;
    scene.check(&root).map_err(Failure::failed)?;
    match scene {
        SceneSource::Gltf(path) => {
            remark(format!(
                "{} has no shots of its own; `shoot` frames it, or takes shots from a file (--shots)",
                path.display()
            ));
        }
        SceneSource::Level { name, .. } => {
            let level = level(&root, name)?;
            level.shots.iter().for_each(|shot| say(shot_line(shot)));
            if !level.tuning_shots.is_empty() {
                say("\nfor tuning, taken only with --shot");
                level.tuning_shots.iter().for_each(|shot| say(shot_line(shot)));
            }
            if !level.views.is_empty() {
                say("\nfor pictures, taken only with --shot");
                level.views.iter().for_each(|shot| say(shot_line(shot)));
            }
        }
    }
    Ok(())
}

fn shot_line(shot: &LevelShot) -> String {
    let (Vec3 { x, y, z }, (width, height)) = (shot.position, shot.size);
    let kind = shot.kind.map(|kind| format!("; {}", kind.about())).unwrap_or_default();
    let hour = shot.hour.map(|hour| format!("; {}", clock(hour))).unwrap_or_default();
    let (name, near, far) = (&shot.name, shot.near, shot.far);
    format!("{name:<20} from ({x}, {y}, {z}), {width}x{height}, {near}..{far} m{hour}{kind}")
}

fn paths(assets: Option<&Path>, scene: &SceneSource) -> Result<(), Failure> {
    let root = asset_root(assets).map_err(Failure::failed)?;
    scene.check(&root).map_err(Failure::failed)?;
    let paths = match scene {
        SceneSource::Gltf(_) => Vec::new(),
        SceneSource::Level { name, .. } => level(&root, name)?.camera_paths,
    };
    if paths.is_empty() {
        remark(format!("{scene} has no camera paths; `bench` goes round it"));
    }
    for path in paths {
        say(format!(
            "{:<20} {} s, {} keys",
            path.name,
            path.duration(),
            path.keys.len()
        ));
    }
    Ok(())
}

/// Reads the file of a level.
fn level(root: &AssetRoot, name: &str) -> Result<Level, Failure> {
    let path = root.levels().join(format!("{name}.{EXTENSION}"));
    let bytes = fs::read(&path).map_err(|error| Failure::Failed(format!("cannot read {}: {error}", path.display())))?;
    parse(&bytes).map_err(|error| Failure::Failed(format!("{}: {error}", path.display())))
}
