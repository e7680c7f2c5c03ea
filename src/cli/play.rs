//! `umbrage play`: the demo in a window, or pictures of a flight where no window can be opened.

use std::path::Path;

use bevy::math::UVec2;

use super::{
    Failure,
    args::{NamedTechnique, Play, Shoot},
    pass::Pass,
    remark, shoot,
    shots::Shard,
};
use crate::{
    demo::{self, PlayError, PlayOptions, flight},
    level::{LoadedScene, find::asset_root, shot::Shot},
};

/// Where the pictures of a flight go.
const FLIGHT_FOLDER: &str = "out";
/// Pictures of a flight.
const FLIGHT_COUNT: u32 = 8;
/// Their size in pixels: small enough for a software driver.
const FLIGHT_SIZE: UVec2 = UVec2::new(480, 270);

/// Plays, or without a display shoots a flight.
pub(super) fn run(assets: Option<&Path>, args: &Play) -> Result<(), Failure> {
    let root = asset_root(assets).map_err(Failure::failed)?;
    args.scene.check(&root).map_err(Failure::failed)?;
    let options = PlayOptions {
        scene: args.scene.clone(),
        technique: args.technique(),
        lod: args.lod,
        assets: root,
    };
    match demo::run(options) {
        Ok(()) => Ok(()),
        Err(reason @ PlayError::NoDisplay(_)) => {
            demo::adapter::check().map_err(|missing| Failure::failed(format!("{reason}; {missing}")))?;
            remark(format!(
                "{reason}; rendering a short flight to {FLIGHT_FOLDER}/ instead"
            ));
            shoot::run_with(assets, &flight_args(args), None, flight_of).map(drop)
        }
        Err(problem) => Err(Failure::failed(problem)),
    }
}

/// What `shoot` would be asked for.
fn flight_args(args: &Play) -> Shoot {
    let technique = args.technique();
    Shoot {
        scenes: vec![args.scene.clone()],
        shots: None,
        shot: vec![],
        techniques: vec![NamedTechnique {
            text: technique.to_string(),
            technique,
        }],
        size: None,
        passes: vec![Pass::Beauty],
        sheet: None,
        lod: args.lod,
        shard: Shard::ALL,
        out: FLIGHT_FOLDER.into(),
    }
}

/// Shots along the scene's first camera path; of a scene without paths, its own shots in the flight's size.
fn flight_of(scene: &LoadedScene) -> Vec<Shot> {
    let along = |path| flight::shots(path, scene.sun.light_dir(), FLIGHT_COUNT, FLIGHT_SIZE);
    let shots = scene.paths.first().map(along).unwrap_or_default();
    if !shots.is_empty() {
        return shots;
    }
    let resized = |shot: &Shot| Shot {
        width: FLIGHT_SIZE.x,
        height: FLIGHT_SIZE.y,
        ..shot.clone()
    };
    scene.shots.iter().map(resized).collect()
}
