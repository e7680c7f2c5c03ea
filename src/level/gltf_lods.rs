//! Levels of detail in glTF files of any origin: the extension `MSFT_lod`, and names that end in `_LOD0`, `_LOD1`, ….
//!
//! - *Extension*: a node names the nodes of its coarser levels, which usually stand in no scene. They are spawned beside it.
//! - *Names*: nodes beside each other whose names differ in that ending only.
//!
//! Where a level ends is said by `MSFT_screencoverage` in the extras of the finest node, as shares of the picture's height;
//! where nothing is said, by [`DEFAULT_COVERAGE`]. Distances are taken from the middle of the finest level as it stands when
//! it is loaded. What is wrong in a file is said in a sentence, and its nodes are drawn as they are.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    sync::Arc,
};

use bevy::{
    ecs::system::SystemParam,
    gltf::{Gltf, GltfMaterial, GltfMesh, GltfNode},
    prelude::*,
};
use gltf_json::Root;
use serde_json::Value;

use super::{library::lods, load::LevelEntity, spawn::borders_of};
use crate::{
    lod::chain::LodChain,
    maths::lod::selection::{LodBorders, LodMetric},
};

/// Share of the picture's height down to which the finest level is drawn where a file does not say; every further level is
/// drawn down to a third of the one before, the last one to any distance.
pub const DEFAULT_COVERAGE: f32 = 0.35;

/// The levels of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeChain {
    /// Indices of nodes from fine to coarse, at least two.
    pub nodes: Vec<usize>,
    /// Shares of the picture's height down to which each is drawn; 0: to any distance.
    pub coverages: Vec<f32>,
}

/// All chains of a file, and a sentence for each that is wrong.
#[must_use]
pub fn chains(document: &Root) -> (Vec<NodeChain>, Vec<String>) {
    let (mut chains, mut notes) = (Vec::new(), Vec::new());
    let mut taken = HashSet::new();
    let (by_extension, by_name) = (by_extension(document), by_name(document));
    for (first, nodes) in by_extension.into_iter().chain(by_name) {
        let name = name_of(document, first);
        let chain = nodes.and_then(|nodes| {
            let coverages = coverages(document, first, nodes.len())?;
            Ok(NodeChain { nodes, coverages })
        });
        match chain {
            Ok(chain) if chain.nodes.iter().any(|node| taken.contains(node)) => {}
            Ok(chain) => {
                taken.extend(chain.nodes.iter().copied());
                chains.push(chain);
            }
            Err(problem) => notes.push(format!(
                "the levels of detail of the node {name} are drawn all at once: {problem}"
            )),
        }
    }
    (chains, notes)
}

/// What Bevy calls a node.
fn name_of(document: &Root, node: usize) -> String {
    let name = document.nodes.get(node).and_then(|node| node.name.clone());
    name.unwrap_or_else(|| format!("GltfNode{node}"))
}

/// Nodes with the extension, and their levels.
fn by_extension(document: &Root) -> Vec<(usize, Result<Vec<usize>, String>)> {
    let count = document.nodes.len();
    let levels = |(first, node): (usize, &gltf_json::Node)| {
        let extension = node.extensions.as_ref()?.others.get("MSFT_lod")?;
        let ids = extension.get("ids").and_then(Value::as_array);
        let coarser: Option<Vec<usize>> = ids.and_then(|ids| {
            let index = |id: &Value| id.as_u64().and_then(|id| usize::try_from(id).ok());
            ids.iter().map(index).collect()
        });
        let nodes = match coarser {
            None => Err("its MSFT_lod has no list `ids` of nodes".to_owned()),
            Some(coarser) => {
                let nodes: Vec<usize> = std::iter::once(first).chain(coarser).collect();
                let different: HashSet<usize> = nodes.iter().copied().collect();
                match nodes.iter().find(|node| **node >= count) {
                    Some(node) => Err(format!("its MSFT_lod names the node {node}, but there are {count}")),
                    None if different.len() < nodes.len() => Err("its MSFT_lod names a node twice".to_owned()),
                    None if nodes.len() < 2 => return None,
                    None => Ok(nodes),
                }
            }
        };
        Some((first, nodes))
    };
    document.nodes.iter().enumerate().filter_map(levels).collect()
}

/// Nodes beside each other that are called `NAME_LOD0`, `NAME_LOD1`, …
fn by_name(document: &Root) -> Vec<(usize, Result<Vec<usize>, String>)> {
    let mut parents = HashMap::new();
    for (parent, node) in document.nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            parents.insert(child.value(), parent);
        }
    }
    let mut groups: BTreeMap<(Option<usize>, String), Vec<(usize, usize)>> = BTreeMap::new();
    for (index, node) in document.nodes.iter().enumerate() {
        let Some((stem, level)) = node.name.as_deref().and_then(split_name) else {
            continue;
        };
        let group = groups.entry((parents.get(&index).copied(), stem)).or_default();
        group.push((level, index));
    }
    let chain = |mut group: Vec<(usize, usize)>| {
        group.sort_unstable();
        let first = group.first()?.1;
        if group.len() < 2 {
            return None;
        }
        let wrong = group.iter().enumerate().find(|(place, (level, _))| place != level);
        let nodes = match wrong {
            Some((place, _)) => Err(format!("beside it is no single node of level {place}")),
            None => Ok(group.iter().map(|(_, index)| *index).collect()),
        };
        Some((first, nodes))
    };
    groups.into_values().filter_map(chain).collect()
}

/// `NAME_LOD2` as name and level, in capitals or not.
fn split_name(name: &str) -> Option<(String, usize)> {
    let at = name.to_ascii_lowercase().rfind("_lod")?;
    let level = name[at + "_lod".len()..].parse().ok()?;
    Some((name[..at].to_owned(), level))
}

/// What a file says about where levels end, else the default.
fn coverages(document: &Root, first: usize, levels: usize) -> Result<Vec<f32>, String> {
    let extras = document.nodes.get(first).and_then(|node| node.extras.as_ref());
    let said = extras.and_then(|extras| {
        let extras: Value = serde_json::from_str(extras.get()).ok()?;
        extras.get("MSFT_screencoverage").cloned()
    });
    let Some(said) = said else {
        let share = |level: usize| DEFAULT_COVERAGE * 3.0_f32.powi(-(level as i32));
        let shares = (0..levels).map(|level| if level + 1 < levels { share(level) } else { 0.0 });
        return Ok(shares.collect());
    };
    let shares: Option<Vec<f32>> = said.as_array().and_then(|shares| {
        let share = |share: &Value| share.as_f64().filter(|share| (0.0..=1.0).contains(share));
        shares
            .iter()
            .map(|value| share(value).map(|share| share as f32))
            .collect()
    });
    match shares {
        Some(shares) if shares.len() == levels => Ok(shares),
        _ => Err(format!(
            "it has {levels} levels, but its MSFT_screencoverage is {said}, not as many numbers between 0 and 1"
        )),
    }
}

/// A file's assets and the entities of its scene.
#[derive(SystemParam)]
pub(super) struct GltfScene<'w, 's> {
    nodes: Option<Res<'w, Assets<GltfNode>>>,
    groups: Option<Res<'w, Assets<GltfMesh>>>,
    looks: Option<Res<'w, Assets<GltfMaterial>>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
    names: Query<'w, 's, &'static Name, Without<Mesh3d>>,
    children: Query<'w, 's, &'static Children>,
    parents: Query<'w, 's, &'static ChildOf>,
    drawn: Query<'w, 's, (), With<Mesh3d>>,
}

impl GltfScene<'_, '_> {
    /// The entities of the scene's nodes.
    fn entities(&self, document: &Root, root: Entity) -> HashMap<usize, Entity> {
        let mut entities = HashMap::new();
        let scene = document.scene.map_or(0, |scene| scene.value());
        let Some(scene) = document.scenes.get(scene) else {
            return entities;
        };
        let nodes: Vec<usize> = scene.nodes.iter().map(|node| node.value()).collect();
        // The scene's own entity stands between.
        for entity in std::iter::once(root).chain(self.children_of(root)) {
            self.pair(document, &nodes, entity, &mut entities);
        }
        entities
    }

    fn children_of(&self, entity: Entity) -> Vec<Entity> {
        self.children.get(entity).into_iter().flatten().copied().collect()
    }

    /// Bevy spawns nodes in the order of the file, and calls them as the file does.
    fn pair(&self, document: &Root, nodes: &[usize], above: Entity, entities: &mut HashMap<usize, Entity>) {
        let mut below = self.children_of(above).into_iter();
        for node in nodes {
            let name = name_of(document, *node);
            let is_it = |entity: &Entity| self.names.get(*entity).is_ok_and(|own| own.as_str() == name);
            let Some(entity) = below.find(is_it) else { return };
            entities.insert(*node, entity);
            let children: Vec<usize> = document.nodes[*node]
                .children
                .iter()
                .flatten()
                .map(|child| child.value())
                .collect();
            self.pair(document, &children, entity, entities);
        }
    }

    /// What is drawn of an entity and all below it.
    fn parts(&self, entity: Entity) -> Vec<Entity> {
        let all = std::iter::once(entity).chain(self.children.iter_descendants(entity));
        all.filter(|entity| self.drawn.contains(*entity)).collect()
    }

    /// Spawns a node that stands in no scene, with all below it; what is drawn of it.
    fn spawn(&mut self, commands: &mut Commands, node: &Handle<GltfNode>, parent: Entity, parts: &mut Vec<Entity>) {
        let Some(node) = self.nodes.as_ref().and_then(|nodes| nodes.get(node)).cloned() else {
            return;
        };
        let name = Name::new(node.name.clone());
        let entity = commands
            .spawn((name, node.transform, Visibility::default(), ChildOf(parent)))
            .id();
        let group = node.mesh.as_ref().and_then(|mesh| self.groups.as_ref()?.get(mesh));
        for primitive in group.map_or(Vec::new(), |group| group.primitives.clone()) {
            let look = primitive
                .material
                .and_then(|look| self.looks.as_ref()?.get(&look).cloned());
            let material = self
                .materials
                .add(look.map_or_else(StandardMaterial::default, |look| standard(&look)));
            let part = (Mesh3d(primitive.mesh), MeshMaterial3d(material), ChildOf(entity));
            parts.push(commands.spawn(part).id());
        }
        for child in &node.children {
            self.spawn(commands, child, entity, parts);
        }
    }

    /// Makes chains of the levels of a spawned scene. `bounds_of` gives the box around parts in world space.
    pub(super) fn make_chains(
        &mut self,
        commands: &mut Commands,
        (gltf, document): (&Gltf, &Root),
        root: Entity,
        chains: Vec<NodeChain>,
        bounds_of: impl Fn(&[Entity]) -> Option<(Vec3, Vec3)>,
    ) {
        let entities = self.entities(document, root);
        for chain in chains {
            let Some(finest) = chain.nodes.first().and_then(|node| entities.get(node)).copied() else {
                // The scene has none of it.
                continue;
            };
            let Some((min, max)) = bounds_of(&self.parts(finest)) else {
                continue;
            };
            let parent = self.parents.get(finest).map_or(root, ChildOf::parent);
            let mut levels = Vec::new();
            for node in &chain.nodes {
                let parts = match (entities.get(node), gltf.nodes.get(*node)) {
                    (Some(entity), _) => self.parts(*entity),
                    (None, Some(handle)) => {
                        let mut parts = Vec::new();
                        self.spawn(commands, handle, parent, &mut parts);
                        parts
                    }
                    (None, None) => Vec::new(),
                };
                levels.push(parts);
            }
            let ranges = lods::ranges(&chain.coverages, (max - min).max_element());
            let borders = borders_of(ranges.iter()).into_iter().map(f64::from);
            let chain = LodChain {
                levels,
                borders: Arc::new(LodBorders::new(borders)),
                metric: LodMetric::ProjectedSize,
            };
            let middle = Transform::from_translation((min + max) * 0.5);
            commands.spawn((middle, chain, LevelEntity));
        }
    }
}

/// The surface that Bevy gives such a material in a scene.
fn standard(look: &GltfMaterial) -> StandardMaterial {
    StandardMaterial {
        base_color: look.base_color,
        base_color_channel: look.base_color_channel.clone(),
        base_color_texture: look.base_color_texture.clone(),
        emissive: look.emissive,
        emissive_channel: look.emissive_channel.clone(),
        emissive_texture: look.emissive_texture.clone(),
        perceptual_roughness: look.perceptual_roughness,
        metallic: look.metallic,
        metallic_roughness_channel: look.metallic_roughness_channel.clone(),
        metallic_roughness_texture: look.metallic_roughness_texture.clone(),
        reflectance: look.reflectance,
        specular_tint: look.specular_tint,
        specular_transmission: look.specular_transmission,
        thickness: look.thickness,
        ior: look.ior,
        attenuation_distance: look.attenuation_distance,
        attenuation_color: look.attenuation_color,
        normal_map_channel: look.normal_map_channel.clone(),
        normal_map_texture: look.normal_map_texture.clone(),
        occlusion_channel: look.occlusion_channel.clone(),
        occlusion_texture: look.occlusion_texture.clone(),
        clearcoat: look.clearcoat,
        clearcoat_perceptual_roughness: look.clearcoat_perceptual_roughness,
        anisotropy_strength: look.anisotropy_strength,
        anisotropy_rotation: look.anisotropy_rotation,
        double_sided: look.double_sided,
        cull_mode: look.cull_mode,
        unlit: look.unlit,
        alpha_mode: look.alpha_mode,
        uv_transform: look.uv_transform,
        ..default()
    }
}
