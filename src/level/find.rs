//! Where levels and assets are found: `--assets`, `UMBRAGE_ASSETS`, the working directory, beside the executable,
//! then the crate's own folder. The first that contains `levels/` is taken; a folder that was asked for by name must.

use std::{
    env,
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
};

/// The environment variable that names the folder.
pub const VARIABLE: &str = "UMBRAGE_ASSETS";

/// How level files end.
pub const EXTENSION: &str = "level.ron";

/// The folder that contains `levels/` and `assets/`; absolute.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssetRoot(PathBuf);

/// Why no folder was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FindError {
    /// A folder that was asked for is of no use.
    #[error(
        "{origin} names {path}, which has no folder levels/ in it: name the folder that contains levels/ and assets/"
    )]
    NoLevels {
        /// `--assets` or the variable.
        origin: &'static str,
        /// The folder as it was given.
        path: String,
    },
    /// Nothing anywhere.
    #[error(
        "no folder levels/ in the working directory, beside the executable or in the crate: \
         name the folder that contains it with --assets or {VARIABLE}"
    )]
    Nowhere,
    /// A path that Bevy's asset server cannot take.
    #[error("the path {path} of the levels is not UTF-8 text: move them to another folder")]
    NotText {
        /// The folder, with replacements.
        path: String,
    },
}

/// Finds the folder; `cli` is the value of `--assets`.
///
/// # Errors
/// A folder that was asked for has no `levels/`, or none was found anywhere.
pub fn asset_root(cli: Option<&Path>) -> Result<AssetRoot, FindError> {
    let beside = env::current_exe()
        .ok()
        .and_then(|exe| exe.parent().map(Path::to_path_buf));
    let places = [env::current_dir().ok(), beside, Some(env!("CARGO_MANIFEST_DIR").into())];
    asset_root_among(cli, env::var_os(VARIABLE), places.into_iter().flatten())
}

/// [`asset_root`] with its surroundings as values.
fn asset_root_among(
    cli: Option<&Path>,
    variable: Option<OsString>,
    places: impl IntoIterator<Item = PathBuf>,
) -> Result<AssetRoot, FindError> {
    let variable = variable.filter(|value| !value.is_empty()).map(PathBuf::from);
    for (origin, path) in [("--assets", cli), (VARIABLE, variable.as_deref())] {
        if let Some(path) = path {
            return root_at(path).unwrap_or_else(|| {
                Err(FindError::NoLevels {
                    origin,
                    path: path.display().to_string(),
                })
            });
        }
    }
    places
        .into_iter()
        .find_map(|place| root_at(&place))
        .unwrap_or(Err(FindError::Nowhere))
}

/// The root in this folder, if it has levels.
fn root_at(path: &Path) -> Option<Result<AssetRoot, FindError>> {
    let path = std::path::absolute(path).ok()?;
    path.join("levels").is_dir().then(|| match path.to_str() {
        Some(_) => Ok(AssetRoot(path)),
        None => Err(FindError::NotText {
            path: path.display().to_string(),
        }),
    })
}

impl AssetRoot {
    /// The folder of level files.
    pub fn levels(&self) -> PathBuf {
        self.0.join("levels")
    }

    /// The folder of models, textures and fonts.
    pub fn assets(&self) -> PathBuf {
        self.0.join("assets")
    }

    /// Names of all levels, sorted: paths below `levels/` with `/`, without `.level.ron`.
    pub fn level_names(&self) -> Vec<String> {
        let mut names = Vec::new();
        collect(&self.levels(), "", &mut names);
        names.sort();
        names
    }
}

/// Adds the names of the levels in a folder and below it.
fn collect(folder: &Path, prefix: &str, names: &mut Vec<String>) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let file = entry.file_name();
        let Some(file) = file.to_str() else { continue };
        if entry.path().is_dir() {
            collect(&entry.path(), &format!("{prefix}{file}/"), names);
        } else if let Some(name) = file.strip_suffix(&format!(".{EXTENSION}")) {
            names.push(format!("{prefix}{name}"));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with_levels() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join("levels/room")).unwrap();
        fs::write(folder.path().join("levels/b.level.ron"), "").unwrap();
        fs::write(folder.path().join("levels/room/a.level.ron"), "").unwrap();
        fs::write(folder.path().join("levels/notes.txt"), "").unwrap();
        folder
    }

    #[test]
    fn the_order_is_cli_variable_places() {
        let (a, b, c) = (folder_with_levels(), folder_with_levels(), folder_with_levels());
        let none = tempfile::tempdir().unwrap();
        let places = || vec![none.path().to_path_buf(), c.path().to_path_buf()];
        let variable = || Some(b.path().as_os_str().to_owned());
        let found = |cli, variable| asset_root_among(cli, variable, places()).unwrap().0;
        assert_eq!(found(Some(a.path()), variable()), a.path());
        assert_eq!(found(None, variable()), b.path());
        assert_eq!(
            found(None, Some("".into())),
            c.path(),
            "an empty variable counts as unset"
        );
        assert_eq!(found(None, None), c.path());
    }

    #[test]
    fn a_named_folder_without_levels_is_an_error_and_not_skipped() {
        let (none, some) = (tempfile::tempdir().unwrap(), folder_with_levels());
        let places = [some.path().to_path_buf()];
        let error = asset_root_among(Some(none.path()), None, places.clone()).unwrap_err();
        assert!(
            matches!(error, FindError::NoLevels { origin: "--assets", .. }),
            "{error}"
        );
        let error = asset_root_among(None, Some(none.path().as_os_str().to_owned()), places).unwrap_err();
        assert!(matches!(error, FindError::NoLevels { origin: VARIABLE, .. }), "{error}");
        assert_eq!(
            asset_root_among(None, None, [none.path().to_path_buf()]),
            Err(FindError::Nowhere)
        );
    }

    #[test]
    fn level_names_are_paths_without_extension() {
        let folder = folder_with_levels();
        let root = asset_root_among(Some(folder.path()), None, []).unwrap();
        assert_eq!(root.level_names(), ["b", "room/a"]);
    }
}
