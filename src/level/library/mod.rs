//! Model files as shared meshes and materials: every placement of a model uses the same few handles.
//!
//! ```text
//! assets/models/NAME.glb ─ Bevy's loader ─► nodes VARIANT_LODn, materials, pictures ─ structure ─► variants with levels
//!                                             pictures ─ pictures::with_mips, on other threads ─► pictures with mips
//! ```
//!
//! A file that cannot be read is a sentence in [`Library::notes`]; its placements become striped boxes
//! ([`placeholder`]).

use std::{collections::BTreeMap, ops::Range};

use bevy::{
    asset::{LoadState, RecursiveDependencyLoadState, RenderAssetUsages},
    camera::primitives::{Aabb, MeshAabb},
    ecs::system::SystemParam,
    gltf::{Gltf, GltfLoaderSettings, GltfMaterial, GltfMesh, GltfNode, GltfSkin},
    platform::collections::HashMap,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, futures::check_ready},
};

pub mod lods;
pub mod materials;
pub mod pictures;
pub mod placeholder;
pub mod rigs;
pub mod structure;

use super::{
    cover::{self, CoverMaterial},
    model::{AssetRef, Tint},
};
use materials::Look;
use rigs::Rig;

/// One material's triangles of one level of detail.
#[derive(Clone, Debug)]
pub struct Part {
    /// Triangles.
    pub mesh: Handle<Mesh>,
    /// Box around them.
    pub aabb: Aabb,
    /// Index into the file's materials.
    look: usize,
    /// Is it a coarse level? Light through its leaves would be seen by nobody.
    is_far: bool,
}

/// One shape of a file, in levels from fine to coarse.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Parts of each level.
    lods: Vec<Vec<Part>>,
    /// See [`lods::ranges`].
    coverages: Vec<f32>,
    /// Height of the finest level in metres.
    height: f32,
}

impl Shape {
    /// Levels with the camera distances in metres that they are drawn at, for an instance of this scale.
    pub fn lods(&self, scale: f32) -> impl Iterator<Item = (&[Part], Range<f32>)> {
        let ranges = lods::ranges(&self.coverages, self.height * scale);
        self.lods.iter().map(Vec::as_slice).zip(ranges)
    }
}

/// A file whose pictures have mips.
struct ModelFile {
    shapes: Vec<Shape>,
    looks: Vec<Look>,
    rig: Option<Rig>,
}

/// All model files that a level asked for.
#[derive(Default)]
pub struct Library {
    files: BTreeMap<&'static str, ModelFile>,
    tinted: HashMap<(&'static str, usize, Tint, bool), Handle<StandardMaterial>>,
    /// One sentence per file that could not be used.
    pub notes: Vec<String>,
}

impl Library {
    /// The shape that a reference names; `None` where its file could not be used.
    pub fn shape(&self, asset: AssetRef) -> Option<&Shape> {
        let shapes = &self.files.get(asset.file)?.shapes;
        shapes.get(asset.variant as usize % shapes.len().max(1))
    }

    /// What moves the shapes of a file; `None` where nothing does.
    pub fn rig(&self, file: &str) -> Option<&Rig> {
        self.files.get(file)?.rig.as_ref()
    }

    /// The material that covers ground with these tiles of [`cover::FILE`]; `None` where the file could not be used.
    ///
    /// # Errors
    /// One sentence: the file lacks a tile, or its pictures do not fit each other.
    pub fn cover(
        &self,
        tiles: [&str; cover::TILES],
        images: &mut Assets<Image>,
    ) -> Result<Option<CoverMaterial>, String> {
        let in_file = |text: String| format!("cannot cover the ground: {FOLDER}/{}.glb {text}", cover::FILE);
        let Some(file) = self.files.get(cover::FILE) else {
            return Ok(None);
        };
        let find = |name: &str| {
            let look = file.looks.iter().position(|look| look.name == name)?;
            let mut parts = file.shapes.iter().flat_map(|shape| shape.lods.iter().flatten());
            let width = 2.0 * parts.find(|part| part.look == look)?.aabb.half_extents.x;
            let [color, normal] = file.looks[look].color_and_normal()?;
            Some(cover::Tile {
                color: images.get(color)?,
                normal: images.get(normal)?,
                width,
            })
        };
        let mut found = Vec::new();
        for name in tiles {
            found.push(find(name).ok_or_else(|| in_file(format!("has no tile {name}")))?);
        }
        let found: [cover::Tile; cover::TILES] = found.try_into().map_err(|_| in_file("has too few tiles".into()))?;
        let layers = cover::layers(&found).map_err(in_file)?;
        Ok(Some(layers.material(images)))
    }

    /// The material of a part under a tint; the same handle for the same tint.
    pub fn material(
        &mut self,
        asset: AssetRef,
        part: &Part,
        tint: Tint,
        materials: &mut Assets<StandardMaterial>,
    ) -> Option<Handle<StandardMaterial>> {
        let look = self.files.get(asset.file)?.looks.get(part.look)?;
        let tint = if look.takes_tint { tint } else { Tint::WHITE };
        let handle = self
            .tinted
            .entry((asset.file, part.look, tint, part.is_far))
            .or_insert_with(|| materials.add(look.tinted(tint, part.is_far)));
        Some(handle.clone())
    }
}

/// What Bevy's loader made of the files.
#[derive(SystemParam)]
pub struct ModelAssets<'w> {
    files: Option<Res<'w, Assets<Gltf>>>,
    nodes: Option<Res<'w, Assets<GltfNode>>>,
    groups: Option<Res<'w, Assets<GltfMesh>>>,
    materials: Option<Res<'w, Assets<GltfMaterial>>>,
    skins: Option<Res<'w, Assets<GltfSkin>>>,
    clips: Option<Res<'w, Assets<AnimationClip>>>,
}

impl ModelAssets<'_> {
    /// The rig of a file.
    fn rig(&self, handle: &Handle<Gltf>) -> Option<Rig> {
        let file = self.files.as_ref()?.get(handle)?;
        rigs::read(file, self.nodes.as_ref()?, self.skins.as_ref()?, self.clips.as_ref()?)
    }
}

/// Files on their way.
pub struct Loading {
    files: Vec<(&'static str, Handle<Gltf>)>,
    library: Library,
    /// Pictures that get their mips, under the handles that were reserved for them.
    pictures: Option<Vec<(Handle<Image>, Task<Image>)>>,
    total: usize,
}

/// The first level of detail that counts as far.
const FIRST_FAR: usize = 2;
/// Folder of model files below the assets folder.
const FOLDER: &str = "models";

impl Loading {
    /// Asks for files.
    pub fn start(server: &AssetServer, names: impl IntoIterator<Item = &'static str>) -> Self {
        let settings = |settings: &mut GltfLoaderSettings| {
            settings.load_cameras = false;
            settings.load_lights = false;
            // Their copies with mips are what is drawn.
            settings.load_materials = RenderAssetUsages::MAIN_WORLD;
        };
        let load = |name| {
            let path = format!("{FOLDER}/{name}.glb");
            (name, server.load_builder().with_settings(settings).load(path))
        };
        Self {
            files: names.into_iter().map(load).collect(),
            library: Library::default(),
            pictures: None,
            total: 0,
        }
    }

    /// Takes a step; the library once everything is there or has failed, else the share that is done, 0..=1.
    pub fn advance(
        &mut self,
        server: &AssetServer,
        models: &ModelAssets,
        meshes: &Assets<Mesh>,
        images: &mut Assets<Image>,
    ) -> Result<Library, f32> {
        let Some(tasks) = &mut self.pictures else {
            let waiting = self
                .files
                .iter()
                .filter(|(_, handle)| is_on_its_way(server, handle))
                .count();
            if waiting > 0 {
                return Err(0.5 * (1.0 - waiting as f32 / self.files.len() as f32));
            }
            self.read_all(server, models, meshes, images);
            return Err(0.5);
        };
        tasks.retain_mut(|(handle, task)| match check_ready(task) {
            None => true,
            Some(picture) => {
                // The handle was reserved for it and is alive: this cannot fail.
                let _ = images.insert(handle.id(), picture);
                false
            }
        });
        if tasks.is_empty() {
            return Ok(std::mem::take(&mut self.library));
        }
        Err(1.0 - 0.5 * tasks.len() as f32 / self.total.max(1) as f32)
    }

    /// Reads all files and starts making mips.
    fn read_all(
        &mut self,
        server: &AssetServer,
        models: &ModelAssets,
        meshes: &Assets<Mesh>,
        images: &mut Assets<Image>,
    ) {
        let mut tasks = Vec::new();
        for (name, handle) in std::mem::take(&mut self.files) {
            let sentence = match (
                server.load_state(&handle),
                server.recursive_dependency_load_state(&handle),
            ) {
                (LoadState::Failed(error), _) | (_, RecursiveDependencyLoadState::Failed(error)) => {
                    super::load::one_sentence(&error)
                }
                _ => match read(name, &handle, models, meshes) {
                    Ok((shapes, mut looks)) => {
                        for look in &mut looks {
                            tasks.extend(with_mips(look, images));
                        }
                        let rig = models.rig(&handle);
                        self.library.files.insert(name, ModelFile { shapes, looks, rig });
                        continue;
                    }
                    Err(sentence) => format!("{FOLDER}/{name}.glb: {sentence}"),
                },
            };
            self.library
                .notes
                .push(format!("cannot use {sentence}; {}", stand_in(name)));
        }
        self.total = tasks.len();
        self.pictures = Some(tasks);
    }
}

/// What is seen instead of a file.
fn stand_in(file: &str) -> &'static str {
    match file {
        cover::FILE => "plain colours stand in for it",
        _ => "striped boxes stand in for it",
    }
}

fn is_on_its_way(server: &AssetServer, handle: &Handle<Gltf>) -> bool {
    let failed = |state: &LoadState| matches!(state, LoadState::Failed(_));
    !failed(&server.load_state(handle))
        && matches!(
            server.recursive_dependency_load_state(handle),
            RecursiveDependencyLoadState::NotLoaded | RecursiveDependencyLoadState::Loading
        )
}

/// Shapes and materials of a file.
fn read(
    name: &'static str,
    handle: &Handle<Gltf>,
    models: &ModelAssets,
    meshes: &Assets<Mesh>,
) -> Result<(Vec<Shape>, Vec<Look>), String> {
    let (Some(files), Some(nodes), Some(groups), Some(materials)) =
        (&models.files, &models.nodes, &models.groups, &models.materials)
    else {
        return Err("this app does not load glTF files (it lacks GltfPlugin)".into());
    };
    let file = files.get(handle).ok_or("it is gone")?;
    let names: HashMap<_, _> = file
        .named_materials
        .iter()
        .map(|(name, handle)| (handle.id(), name))
        .collect();
    let looks: Vec<Look> = file
        .materials
        .iter()
        .filter_map(|handle| {
            let own_name = names.get(&handle.id()).map_or("", |name| name);
            Some(Look::new(name, own_name, materials.get(handle)?))
        })
        .collect();
    let nodes: Vec<&GltfNode> = file.nodes.iter().filter_map(|node| nodes.get(node)).collect();
    let named = nodes.iter().map(|node| {
        (
            node.name.as_str(),
            node.extras.as_ref().map(|extras| extras.value.as_str()),
        )
    });
    let mut shapes = Vec::new();
    for variant in structure::variants(named)? {
        let mut lods = Vec::new();
        for (level, index) in variant.nodes.into_iter().enumerate() {
            let group = nodes[index].mesh.as_ref().and_then(|group| groups.get(group));
            let primitives = group.map(|group| group.primitives.as_slice()).unwrap_or_default();
            let parts: Option<Vec<Part>> = primitives
                .iter()
                .map(|primitive| {
                    let own = primitive.material.as_ref()?;
                    Some(Part {
                        mesh: primitive.mesh.clone(),
                        aabb: meshes.get(&primitive.mesh)?.compute_aabb()?,
                        look: file.materials.iter().position(|material| material == own)?,
                        is_far: level >= FIRST_FAR,
                    })
                })
                .collect();
            let parts = parts.filter(|parts| !parts.is_empty());
            lods.push(parts.ok_or(format!("node {} has no triangles with a material", nodes[index].name))?);
        }
        let tops = lods.iter().flatten().map(|part| part.aabb.max().y);
        shapes.push(Shape {
            height: tops.fold(0.1, f32::max),
            lods,
            coverages: variant.coverages,
        });
    }
    Ok((shapes, looks))
}

/// Replaces a material's pictures by handles of copies that get mips on other threads.
fn with_mips(look: &mut Look, images: &mut Assets<Image>) -> Vec<(Handle<Image>, Task<Image>)> {
    let pool = AsyncComputeTaskPool::get();
    let mut tasks = Vec::new();
    for (slot, purpose) in look.pictures() {
        let Some(original) = slot.as_ref().and_then(|handle| images.get(handle)) else {
            continue;
        };
        let original = original.clone();
        let handle = images.reserve_handle();
        *slot = Some(handle.clone());
        tasks.push((
            handle,
            pool.spawn(async move { pictures::with_mips(original, purpose) }),
        ));
    }
    tasks
}
