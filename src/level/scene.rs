//! [`SceneSource`]: what to load, as the command line writes it.

use std::{
    collections::BTreeMap,
    fmt, io,
    io::Read,
    path::{Path, PathBuf},
    str::FromStr,
};

use super::find::AssetRoot;

/// A level with settings, or a glTF file.
///
/// Text forms: `forest`, `room/fence`, `stress_trees:count=100000,seed=2`, `path/to/x.glb`, `path/to/x.gltf`. Parsing
/// checks the form only; [`SceneSource::check`] asks the disk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SceneSource {
    /// A level of the levels folder.
    Level {
        /// Path below `levels/` without `.level.ron`.
        name: String,
        /// Settings that [`Level::set`](super::format::Level::set) takes.
        settings: BTreeMap<String, String>,
    },
    /// A `.glb` or `.gltf` file anywhere on disk; relative paths start from the working directory.
    Gltf(PathBuf),
}

/// Why a scene cannot be loaded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// The text has no meaning.
    #[error(
        "`{text}` is not a scene: write a level name, a level name with settings (forest:count=500), or a path to a .glb or .gltf file"
    )]
    Form {
        /// The text.
        text: String,
    },
    /// A setting without `=`, without key or without value, or given twice.
    #[error("`{setting}` in `{text}` is not a setting: write key=value, separated by commas, each key once")]
    Setting {
        /// The text.
        text: String,
        /// The part that is wrong.
        setting: String,
    },
    /// No such level.
    #[error("there is no level `{name}`; there are: {known} (or give a path to a .glb or .gltf file)")]
    UnknownLevel {
        /// What was asked for.
        name: String,
        /// All levels.
        known: String,
    },
    /// A file that cannot be read.
    #[error("cannot read {path}: {reason}")]
    Unreadable {
        /// The file.
        path: String,
        /// What the system says.
        reason: String,
    },
    /// A file that is not what its name says.
    #[error("{path} is not a usable glTF file: {reason}")]
    NotGltf {
        /// The file.
        path: String,
        /// What is wrong with it.
        reason: String,
    },
}

impl SceneSource {
    /// A level without settings.
    pub fn level(name: impl Into<String>) -> Self {
        Self::Level {
            name: name.into(),
            settings: BTreeMap::new(),
        }
    }

    /// The scene's own name: the level's, or the file's without folder and extension.
    pub fn name(&self) -> String {
        match self {
            Self::Level { name, .. } => name.clone(),
            Self::Gltf(path) => path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }

    /// Checks that the level exists, or that the file exists and looks like glTF all the way to its end. Settings
    /// are checked when the level is loaded.
    ///
    /// # Errors
    /// One sentence that says what is missing, and for a level what there is.
    pub fn check(&self, root: &AssetRoot) -> Result<(), SceneError> {
        match self {
            Self::Level { name, .. } => {
                let known = root.level_names();
                if known.contains(name) {
                    return Ok(());
                }
                Err(SceneError::UnknownLevel {
                    name: name.clone(),
                    known: if known.is_empty() {
                        "none".into()
                    } else {
                        known.join(", ")
                    },
                })
            }
            Self::Gltf(path) => check_gltf(path),
        }
    }
}

impl FromStr for SceneSource {
    type Err = SceneError;

    fn from_str(text: &str) -> Result<Self, SceneError> {
        let lower = text.to_ascii_lowercase();
        if lower.ends_with(".glb") || lower.ends_with(".gltf") {
            return Ok(Self::Gltf(text.into()));
        }
        let (name, settings_text) = match text.split_once(':') {
            Some((name, settings)) => (name, Some(settings)),
            None => (text, None),
        };
        let part_is_fine = |part: &str| {
            !part.is_empty()
                && part
                    .chars()
                    .all(|letter| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-')
        };
        if !name.split('/').all(part_is_fine) {
            return Err(SceneError::Form { text: text.into() });
        }
        let mut settings = BTreeMap::new();
        for setting in settings_text.into_iter().flat_map(|settings| settings.split(',')) {
            let error = || SceneError::Setting {
                text: text.into(),
                setting: setting.into(),
            };
            let (key, value) = setting.split_once('=').ok_or_else(error)?;
            let (key, value) = (key.trim(), value.trim());
            if key.is_empty() || value.is_empty() || settings.insert(key.into(), value.into()).is_some() {
                return Err(error());
            }
        }
        Ok(Self::Level {
            name: name.into(),
            settings,
        })
    }
}

impl fmt::Display for SceneSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Level { name, settings } => {
                f.write_str(name)?;
                for (i, (key, value)) in settings.iter().enumerate() {
                    write!(f, "{}{key}={value}", if i == 0 { ':' } else { ',' })?;
                }
                Ok(())
            }
            Self::Gltf(path) => write!(f, "{}", path.display()),
        }
    }
}

/// Looks at a glTF file before Bevy does, so that common mistakes get a clear sentence.
fn check_gltf(path: &Path) -> Result<(), SceneError> {
    let shown = || path.display().to_string();
    let unreadable = |error: io::Error| SceneError::Unreadable {
        path: shown(),
        reason: match error.kind() {
            io::ErrorKind::NotFound => "there is no such file".into(),
            _ => error.to_string(),
        },
    };
    let not_gltf = |reason: &str| {
        Err(SceneError::NotGltf {
            path: shown(),
            reason: reason.into(),
        })
    };
    let mut file = std::fs::File::open(path).map_err(unreadable)?;
    let about = file.metadata().map_err(unreadable)?;
    if about.is_dir() {
        return not_gltf("it is a folder");
    }
    if about.len() == 0 {
        return not_gltf("it is empty");
    }
    if path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"))
    {
        return match serde_json::from_reader::<_, serde_json::Value>(io::BufReader::new(file)) {
            Ok(json) if json.get("asset").is_some() => Ok(()),
            Ok(_) => not_gltf("its JSON has no `asset`"),
            Err(error) if error.is_eof() => not_gltf("its JSON ends too early: the file is truncated"),
            Err(error) => not_gltf(&format!("it is not JSON ({error})")),
        };
    }
    let mut header = [0; 20];
    let mut got = 0;
    while got < header.len() {
        match file.read(&mut header[got..]).map_err(unreadable)? {
            0 => break,
            more => got += more,
        }
    }
    let word = |at: usize| u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]]);
    if !header.starts_with(b"glTF") {
        return not_gltf("it does not start with the letters glTF");
    }
    if got < header.len() {
        return not_gltf("it ends within its header: the file is truncated");
    }
    if word(4) != 2 {
        return not_gltf(&format!("its version is {}, but only version 2 is read", word(4)));
    }
    if about.len() < u64::from(word(8)) {
        return not_gltf(&format!(
            "it says it has {} bytes, but has only {}: the file is truncated",
            word(8),
            about.len()
        ));
    }
    if &header[16..20] != b"JSON" || u64::from(word(12)) + 20 > u64::from(word(8)) {
        return not_gltf("its first chunk is not a whole JSON chunk");
    }
    Ok(())
}
