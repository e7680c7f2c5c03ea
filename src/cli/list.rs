//! `umbrage list`: what there is.

use std::{fs, path::Path};

use super::{Failure, args::ListWhat, pass::Pass, remark, say};
use crate::{
    level::{
        find::{AssetRoot, EXTENSION, asset_root},
        format::Level,
        parse::parse,
        scene::SceneSource,
    },
    shadow::technique::{KEYS, PRESETS, Technique},
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
        ListWhat::Shots { scene } => shots(assets, scene)?,
        ListWhat::Paths { scene } => paths(assets, scene)?,
    }
    Ok(())
}

fn techniques() {
    for technique in Technique::all() {
        say(format!("{:<20} {}", technique.to_string(), technique.summary()));
    }
    say("\npresets");
    for (name, settings) in PRESETS {
        let technique = Technique::Umbrage(settings);
        say(format!("{name:<20} {technique}: {}", technique.summary()));
    }
    say("\nkeys, as in zp4+lispsm:size=1024,filter=hard");
    for (key, values) in KEYS {
        say(format!("{key:<20} {values}"));
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
            for shot in level(&root, name)?.shots() {
                let [x, y, z] = shot.position;
                say(format!(
                    "{:<20} from ({x}, {y}, {z}), {}x{}, {}..{} m",
                    shot.name, shot.width, shot.height, shot.near, shot.far
                ));
            }
        }
    }
    Ok(())
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
