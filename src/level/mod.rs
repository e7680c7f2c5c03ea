//! Levels: where geometry, sun, spawn, shots and camera paths come from.
//!
//! ```text
//! .level.ron ─ parse, validate ─► Level ─ scenery::generate ─► placements, static meshes, ground ─ spawn ─► entities
//! .glb, .gltf ─ check ─► Bevy's loader ─► entities, a sun and a shot that frames them
//! ```
//!
//! Set [`RequestedScene`], watch [`SceneStatus`], use [`LoadedScene`]. Everything up to `spawn` is values in, values
//! out, and the same on every machine for the same seed.

use bevy::prelude::*;

pub mod buildings;
pub mod city;
pub mod cover;
pub mod find;
pub mod forest;
pub mod format;
pub mod gltf_lods;
pub mod ground;
pub mod grove;
pub mod inhabitants;
pub mod land;
pub mod library;
mod load;
mod load_gltf;
pub mod loader;
pub mod made;
pub mod meshes;
pub mod model;
pub mod noise;
pub mod parse;
pub mod props;
pub mod rooms;
pub mod scatter;
pub mod scene;
pub mod scenery;
pub mod shot;
pub mod simple_trees;
pub mod sky;
pub mod spawn;
pub mod species;
pub mod terrain;
pub mod validate;

pub use load::{LevelEntity, LevelRoot, LoadedScene, RequestedScene, SceneStatus, Sun};

/// Loads levels and glTF scenes.
///
/// Before `DefaultPlugins`, call [`loader::register_sources`] with the same root, and give `DefaultPlugins` the
/// [`loader::asset_plugin`].
pub struct LevelPlugin {
    /// The folder that contains `levels/` and `assets/`; see [`find::asset_root`].
    pub assets: find::AssetRoot,
}

/// The systems of this room, in `Update`.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LevelSystems;

impl Plugin for LevelPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<loader::LevelAsset>()
            .init_asset_loader::<loader::LevelLoader>()
            .insert_resource(LevelRoot(self.assets.clone()))
            .init_resource::<RequestedScene>()
            .init_resource::<SceneStatus>()
            .init_resource::<load::Job>()
            .add_plugins(cover::plugin)
            .add_plugins(sky::plugin)
            .add_plugins(inhabitants::plugin)
            .add_plugins(grove::field::plugin)
            .add_systems(
                Update,
                (load::reload, load::start, load::advance_level, load_gltf::advance_gltf)
                    .chain()
                    .in_set(LevelSystems),
            );
    }
}
