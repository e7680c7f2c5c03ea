//! `.level.ron` files as Bevy assets, and where Bevy looks for them.

use bevy::{
    asset::{AssetLoader, AssetMetaCheck, LoadContext, UnapprovedPathMode, io::AssetSourceBuilder, io::Reader},
    prelude::*,
};

use super::{find::AssetRoot, format::Level, parse, validate::LevelError};

/// The asset source of level files: `levels://room/fence.level.ron`.
pub const SOURCE: &str = "levels";

/// A checked level file.
#[derive(Asset, TypePath, Clone, Debug, PartialEq)]
pub struct LevelAsset(pub Level);

/// Reads [`LevelAsset`]s.
#[derive(Default, TypePath)]
pub struct LevelLoader;

/// Why a level file was not loaded.
#[derive(Debug, thiserror::Error)]
pub enum LevelLoadError {
    /// The file could not be read.
    #[error("cannot read levels/{file}: {source}")]
    Read {
        /// Path below `levels/`.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not a usable level.
    #[error("levels/{file}: {source}")]
    Level {
        /// Path below `levels/`.
        file: String,
        /// What is wrong.
        source: LevelError,
    },
}

impl AssetLoader for LevelLoader {
    type Asset = LevelAsset;
    type Settings = ();
    type Error = LevelLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        load_context: &mut LoadContext<'_>,
    ) -> Result<LevelAsset, LevelLoadError> {
        let file = || load_context.path().path().display().to_string();
        let mut bytes = Vec::new();
        reader
            .read_to_end(&mut bytes)
            .await
            .map_err(|source| LevelLoadError::Read { file: file(), source })?;
        let level = parse::parse(&bytes).map_err(|source| LevelLoadError::Level { file: file(), source })?;
        Ok(LevelAsset(level))
    }

    fn extensions(&self) -> &[&str] {
        &["level.ron"]
    }
}

/// Tells Bevy where level files are. Call it before [`AssetPlugin`] (part of `DefaultPlugins`) is added.
pub fn register_sources(app: &mut App, root: &AssetRoot) {
    let levels = root.levels();
    app.register_asset_source(
        SOURCE,
        AssetSourceBuilder::platform_default(&levels.to_string_lossy(), None),
    );
}

/// The asset plugin that Umbrage's programs use: assets from this root, and glTF files from anywhere on disk.
pub fn asset_plugin(root: &AssetRoot) -> AssetPlugin {
    AssetPlugin {
        file_path: root.assets().to_string_lossy().into_owned(),
        // There are no .meta files; asking for them doubles the reads.
        meta_check: AssetMetaCheck::Never,
        unapproved_path_mode: UnapprovedPathMode::Allow,
        ..default()
    }
}
