//! Loading as a state machine: set [`RequestedScene`], watch [`SceneStatus`], use [`LoadedScene`].

use std::{
    collections::{BTreeMap, BTreeSet},
    sync::{
        Arc,
        atomic::{AtomicU32, Ordering},
    },
};

use bevy::{
    asset::{AssetLoadError, LoadState, io::AssetReaderError},
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
};

use super::{
    find::{AssetRoot, EXTENSION},
    format::{CameraPath, Level, Spawn, SunSettings},
    ground::Ground,
    grove::Grove,
    inhabitants,
    library::{self, ModelAssets},
    load_gltf::GltfJob,
    loader::{LevelAsset, LevelLoadError, SOURCE},
    scene::SceneSource,
    scenery,
    shot::Shot,
    sky,
    spawn::{LevelAssets, Palette, Prepared},
};

/// The scene that should be there. Setting it, even to the same value, despawns the old one and loads the new one;
/// `None` leaves nothing.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct RequestedScene(pub Option<SceneSource>);

/// How far loading is.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub enum SceneStatus {
    /// Nothing was asked for.
    #[default]
    Idle,
    /// On the way: `done` of `total`, which never falls for one scene.
    Loading {
        /// Steps done.
        done: u32,
        /// All steps.
        total: u32,
        /// What is going on, for a loading screen.
        what: String,
    },
    /// [`LoadedScene`] is there and everything is spawned.
    Ready,
    /// One sentence that says why not.
    Failed(String),
}

/// The scene that is there; absent unless [`SceneStatus::Ready`].
#[derive(Resource, Clone, Debug)]
pub struct LoadedScene {
    /// Level name or file stem.
    pub name: String,
    /// At least one.
    pub shots: Vec<Shot>,
    /// For choosing settings and for pictures; taken only when they are named.
    pub named_only: Vec<Shot>,
    /// Where a player starts.
    pub spawn: Spawn,
    /// Sun and sky; shots may turn the sun.
    pub sun: SunSettings,
    /// What a walker stands on.
    pub ground: Ground,
    /// Camera flights.
    pub paths: Vec<CameraPath>,
    /// Sentences for the user, such as a shot that had to be made up.
    pub notes: Vec<String>,
}

/// On every root entity of the scene; despawning them removes it.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct LevelEntity;

/// On the directional light that the level spawns.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Sun;

/// The folder that levels come from.
#[derive(Resource, Clone, Debug)]
pub struct LevelRoot(pub AssetRoot);

/// What is being loaded.
#[derive(Resource, Default)]
pub(super) enum Job {
    #[default]
    None,
    File {
        handle: Handle<LevelAsset>,
        name: String,
        settings: BTreeMap<String, String>,
    },
    Build {
        handle: Handle<LevelAsset>,
        level: Box<Level>,
        progress: Arc<AtomicU32>,
        task: Task<Prepared>,
    },
    /// Waiting for model files.
    Models {
        handle: Handle<LevelAsset>,
        level: Box<Level>,
        prepared: Box<Prepared>,
        models: Box<library::Loading>,
    },
    Spawn(Box<SpawnJob>),
    Gltf(GltfJob),
    /// Ready; the handle keeps the file watched.
    Level(Handle<LevelAsset>),
}

pub(super) struct SpawnJob {
    handle: Handle<LevelAsset>,
    level: Box<Level>,
    palette: Palette,
    placements: Vec<super::model::Placement>,
    grove: Option<Grove>,
    ground: Ground,
    next: usize,
}

/// All steps of a level: file, generator, meshes, entities.
const TOTAL: u32 = 1000;
const BUILD_AT: u32 = 20;
const MESHES_AT: u32 = 250;
const MODELS_AT: u32 = 350;
const SPAWN_AT: u32 = 800;
/// Placements spawned per frame: a few milliseconds.
const SPAWN_BATCH: usize = 4000;

pub(super) fn loading(done: u32, what: impl Into<String>) -> SceneStatus {
    SceneStatus::Loading {
        done,
        total: TOTAL,
        what: what.into(),
    }
}

/// Asks for the same scene again when its file has changed on disk (feature `dev` watches).
pub(super) fn reload(
    mut events: MessageReader<AssetEvent<LevelAsset>>,
    job: Res<Job>,
    mut requested: ResMut<RequestedScene>,
) {
    let Job::Level(handle) = &*job else {
        events.clear();
        return;
    };
    if events.read().any(|event| event.is_modified(handle.id())) {
        requested.set_changed();
    }
}

/// Removes the old scene and starts the new one.
pub(super) fn start(
    mut commands: Commands,
    requested: Res<RequestedScene>,
    root: Res<LevelRoot>,
    server: Res<AssetServer>,
    mut job: ResMut<Job>,
    mut status: ResMut<SceneStatus>,
    old: Query<Entity, With<LevelEntity>>,
) {
    if !requested.is_changed() {
        return;
    }
    for entity in &old {
        commands.entity(entity).despawn();
    }
    commands.remove_resource::<LoadedScene>();
    *job = Job::None;
    let Some(source) = &requested.0 else {
        *status = SceneStatus::Idle;
        return;
    };
    if let Err(error) = source.check(&root.0) {
        *status = SceneStatus::Failed(error.to_string());
        return;
    }
    *status = loading(0, format!("Reading {}", source.name()));
    *job = match source {
        SceneSource::Level { name, settings } => Job::File {
            handle: server.load(format!("{SOURCE}://{name}.{EXTENSION}")),
            name: name.clone(),
            settings: settings.clone(),
        },
        SceneSource::Gltf(path) => Job::Gltf(GltfJob::start(&server, path)),
    };
}

/// Takes the next step of a level, if one is due.
pub(super) fn advance_level(
    mut commands: Commands,
    server: Res<AssetServer>,
    levels: Res<Assets<LevelAsset>>,
    models: ModelAssets,
    mut graphs: Option<ResMut<Assets<AnimationGraph>>>,
    mut assets: LevelAssets,
    mut job: ResMut<Job>,
    mut status: ResMut<SceneStatus>,
) {
    let next = match &mut *job {
        Job::File { handle, name, settings } => match server.load_state(&*handle) {
            LoadState::Failed(error) => Err(one_sentence(&error)),
            _ => match levels.get(&*handle) {
                None => return,
                Some(LevelAsset(level)) => build(handle.clone(), level, name, settings),
            },
        },
        Job::Build {
            handle,
            level,
            progress,
            task,
        } => match check_ready(task) {
            None => {
                let done = progress.load(Ordering::Relaxed);
                status.set_if_neq(loading(done.max(BUILD_AT), format!("Building {}", level.name)));
                return;
            }
            Some(prepared) => Ok(Job::Models {
                handle: handle.clone(),
                level: level.clone(),
                models: Box::new(library::Loading::start(&server, files_of(&prepared, level))),
                prepared: Box::new(prepared),
            }),
        },
        Job::Models {
            handle,
            level,
            prepared,
            models: loading_models,
        } => {
            let step = loading_models.advance(&server, &models, &assets.meshes, &mut assets.images);
            match step {
                Err(share) => {
                    let done = MODELS_AT + ((SPAWN_AT - MODELS_AT) as f32 * share) as u32;
                    status.set_if_neq(loading(done, format!("Reading models for {}", level.name)));
                    return;
                }
                Ok(library) => {
                    let mut palette = Palette::new(&mut assets, prepared, library);
                    palette.spawn_statics(&mut commands, &mut assets, std::mem::take(&mut prepared.statics));
                    palette.spawn_patches(&mut commands, &mut assets.meshes, std::mem::take(&mut prepared.patches));
                    sky::spawn_sun(&mut commands, &level.sun);
                    Ok(Job::Spawn(Box::new(SpawnJob {
                        handle: handle.clone(),
                        level: level.clone(),
                        palette,
                        placements: std::mem::take(&mut prepared.placements),
                        grove: prepared.grove,
                        ground: std::mem::take(&mut prepared.ground),
                        next: 0,
                    })))
                }
            }
        }
        Job::Spawn(spawn) => {
            let end = (spawn.next + SPAWN_BATCH).min(spawn.placements.len());
            let batch = &spawn.placements[spawn.next..end];
            spawn.palette.spawn(&mut commands, &mut assets, batch);
            spawn.next = end;
            if end < spawn.placements.len() {
                let share = end as f32 / spawn.placements.len() as f32;
                let done = SPAWN_AT + ((TOTAL - SPAWN_AT) as f32 * share) as u32;
                *status = loading(done, format!("Placing {}", spawn.level.name));
                return;
            }
            if let Some(graphs) = &mut graphs {
                let of_level = (&spawn.level.inhabitants[..], &spawn.ground, spawn.level.seed);
                inhabitants::spawn(&mut commands, &mut assets, graphs, &mut spawn.palette, of_level);
            }
            if let Some(grove) = spawn.grove {
                spawn.palette.spawn_grove(&mut commands, grove);
            }
            let mut scene = loaded(&spawn.level, std::mem::take(&mut spawn.ground));
            scene.notes.extend_from_slice(spawn.palette.notes());
            commands.insert_resource(scene);
            *status = SceneStatus::Ready;
            Ok(Job::Level(spawn.handle.clone()))
        }
        Job::None | Job::Gltf(_) | Job::Level(_) => return,
    };
    *job = next.unwrap_or_else(|sentence| {
        *status = SceneStatus::Failed(sentence);
        Job::None
    });
}

/// Applies settings and starts the generator on another thread.
fn build(
    handle: Handle<LevelAsset>,
    level: &Level,
    name: &str,
    settings: &BTreeMap<String, String>,
) -> Result<Job, String> {
    let mut level = level.clone();
    if level.name != name {
        return Err(format!(
            "levels/{name}.{EXTENSION} calls itself `{}`: its `name` must be its path",
            level.name
        ));
    }
    for (key, value) in settings {
        level.set(key, value).map_err(|error| format!("{name}: {error}"))?;
    }
    let progress = Arc::new(AtomicU32::new(BUILD_AT));
    let task = {
        let (level, progress) = (level.clone(), progress.clone());
        AsyncComputeTaskPool::get().spawn(async move {
            let scenery = scenery::generate(&level);
            Prepared::new(scenery, |share| {
                let done = MESHES_AT + ((MODELS_AT - MESHES_AT) as f32 * share) as u32;
                progress.store(done, Ordering::Relaxed);
            })
        })
    };
    Ok(Job::Build {
        handle,
        level: Box::new(level),
        progress,
        task,
    })
}

/// Model files that a level needs.
fn files_of(prepared: &Prepared, level: &Level) -> BTreeSet<&'static str> {
    let figures = level.inhabitants.iter().map(|rule| rule.figure.file());
    prepared.files.iter().copied().chain(figures).collect()
}

fn loaded(level: &Level, ground: Ground) -> LoadedScene {
    LoadedScene {
        name: level.name.clone(),
        shots: level.shots(),
        named_only: level.named_only(),
        spawn: level.spawn,
        sun: level.sun,
        ground,
        paths: level.camera_paths.clone(),
        notes: Vec::new(),
    }
}

/// What went wrong, without Bevy's wrapping where the error is ours, and always on one line.
pub(super) fn one_sentence(error: &AssetLoadError) -> String {
    let text = match error {
        AssetLoadError::AssetLoaderError(error) => match error.error().downcast_ref::<LevelLoadError>() {
            Some(own) => own.to_string(),
            None => format!("{}: {}", error.path(), error.error()),
        },
        AssetLoadError::AssetReaderError(AssetReaderError::NotFound(path)) => {
            format!("{}: there is no such file", path.display())
        }
        other => other.to_string(),
    };
    text.lines().next().unwrap_or("unknown error").to_string()
}
