//! From placements to entities: meshes and materials are shared, so that Bevy draws equal models in batches.

use std::{
    collections::{BTreeSet, HashMap, HashSet},
    ops::Range,
    sync::Arc,
};

use bevy::{
    asset::RenderAssetUsages,
    camera::primitives::Aabb,
    ecs::system::SystemParam,
    light::{NotShadowCaster, TransmittedShadowReceiver},
    math::Vec3A,
    mesh::{Indices, PrimitiveTopology, morph::MorphAttributes},
    prelude::*,
};

use super::{
    buildings::{self, Building},
    cover::{self, Cover, CoverMaterial, TILES},
    grove::{
        Grove, blocks,
        field::{CellField, TreeLooks},
    },
    library::{Library, placeholder},
    load::LevelEntity,
    meshes::MeshData,
    model::{Model, Placement, Tint},
    scenery::{Finish, Patch, PatchLevel, Scenery},
    simple_trees::{self, LEVEL_ENDS, LEVELS},
};
use crate::{
    forge::city::facade::assemble::Shared,
    lod::chain::{LodChain, LodMorph},
    maths::lod::selection::{LodBorders, LodMetric},
};

/// A mesh that is ready for Bevy, with its box.
pub struct ReadyMesh {
    mesh: Mesh,
    aabb: Aabb,
}

impl ReadyMesh {
    /// `None` without triangles.
    fn new(data: MeshData) -> Option<Self> {
        let (min, max) = data.bounds()?;
        Some(Self {
            mesh: to_mesh(data),
            aabb: Aabb::from_min_max(min, max),
        })
    }
}

/// A [`Patch`] whose meshes are built.
pub struct ReadyPatch {
    name: &'static str,
    origin: Vec3,
    /// From fine to coarse; all but the last one carry what differs in the next.
    levels: Vec<ReadyMesh>,
    borders: LodBorders,
}

impl ReadyPatch {
    fn new(patch: Patch) -> Self {
        let level = |level: PatchLevel| {
            let mut ready = ReadyMesh::new(level.mesh)?;
            if !level.coarser.is_empty() {
                let half = level
                    .coarser
                    .iter()
                    .fold(Vec3::ZERO, |most, moved| most.max(moved.position.abs()));
                ready.aabb.half_extents += Vec3A::from(half);
                let target = level
                    .coarser
                    .iter()
                    .map(|to| MorphAttributes::new(to.position, to.normal, Vec3::ZERO));
                ready.mesh.set_morph_targets(target.collect());
            }
            Some(ready)
        };
        Self {
            name: patch.name,
            origin: patch.origin,
            levels: patch.levels.into_iter().filter_map(level).collect(),
            borders: LodBorders::new(patch.ends),
        }
    }
}

/// A level whose meshes are built: everything that takes time and needs no world.
pub struct Prepared {
    /// Meshes in world space, and how they look.
    pub statics: Vec<(&'static str, ReadyMesh, Finish)>,
    /// Ground in levels of detail.
    pub patches: Vec<ReadyPatch>,
    /// Every model that is built here.
    pub models: Vec<(Model, ReadyMesh)>,
    /// The levels of all simple trees, in the order of [`blocks::models`]; empty where there are none.
    pub trees: Vec<Vec<ReadyMesh>>,
    /// Every storey and roof that buildings share, with the camera distances in metres of each level of detail.
    pub shared: Vec<(Shared, Vec<(ReadyMesh, Range<f32>)>)>,
    /// Every model file that is needed, without extension.
    pub files: BTreeSet<&'static str>,
    /// Everything that stands somewhere.
    pub placements: Vec<Placement>,
    /// Trees that are drawn cell by cell.
    pub grove: Option<Grove>,
    /// What a walker stands on.
    pub ground: super::ground::Ground,
}

impl Prepared {
    /// Builds the meshes; `report` is called with a share of 0..=1.
    pub fn new(scenery: Scenery, report: impl Fn(f32)) -> Self {
        let (mut models, mut files, mut shared) = (Vec::new(), BTreeSet::new(), BTreeSet::new());
        let mut seen = HashSet::new();
        let mut has_trees = scenery.grove.is_some();
        for placement in &scenery.placements {
            if seen.insert(placement.model) {
                if let Model::Building(building) = placement.model {
                    shared.extend(building.parts().into_iter().map(|(part, ..)| part));
                }
                match placement.model.asset() {
                    Some(asset) => {
                        files.insert(asset.file);
                    }
                    None if blocks::index(placement.model).is_some() => has_trees = true,
                    None => models.push(placement.model),
                }
            }
        }
        if scenery
            .statics
            .iter()
            .any(|part| matches!(part.finish, Finish::Cover(_)))
        {
            files.insert(cover::FILE);
        }
        let (own, total) = (models.len(), (models.len() + shared.len()).max(1) as f32);
        let build = |(i, model): (usize, Model)| {
            report(i as f32 / total);
            Some((model, ReadyMesh::new(model.build())?))
        };
        let levels = |(i, part): (usize, Shared)| {
            report((own + i) as f32 / total);
            let levels = buildings::levels(&part).into_iter();
            let ready = levels.filter_map(|(mesh, range)| Some((ReadyMesh::new(mesh)?, range)));
            (part, ready.collect())
        };
        let tree = |(kind, variant)| {
            let levels = (0..LEVELS).map(|level| simple_trees::build_level(kind, variant, level));
            levels.filter_map(ReadyMesh::new).collect()
        };
        Self {
            trees: blocks::models().filter(|_| has_trees).map(tree).collect(),
            models: models.into_iter().enumerate().filter_map(build).collect(),
            shared: shared.into_iter().enumerate().map(levels).collect(),
            files,
            statics: scenery
                .statics
                .into_iter()
                .filter_map(|part| Some((part.name, ReadyMesh::new(part.mesh)?, part.finish)))
                .collect(),
            patches: scenery.patches.into_iter().map(ReadyPatch::new).collect(),
            placements: scenery.placements,
            grove: scenery.grove,
            ground: scenery.ground,
        }
    }
}

/// Converts triangles to a Bevy mesh that both worlds keep (the main world's copy serves picking and ray tracing).
pub fn to_mesh(data: MeshData) -> Mesh {
    let alpha = |[r, g, b]: [f32; 3]| [r, g, b, 1.0];
    let colors: Vec<[f32; 4]> = data.colors.into_iter().map(alpha).collect();
    let arrays = |vectors: Vec<Vec3>| vectors.iter().map(Vec3::to_array).collect::<Vec<_>>();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, arrays(data.positions))
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, arrays(data.normals))
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_UV_0,
            data.uvs.iter().map(Vec2::to_array).collect::<Vec<_>>(),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors)
        .with_inserted_indices(Indices::U32(data.indices))
}

/// The asset collections that spawning adds to.
#[derive(SystemParam)]
pub struct LevelAssets<'w> {
    /// Meshes.
    pub meshes: ResMut<'w, Assets<Mesh>>,
    /// Materials.
    pub materials: ResMut<'w, Assets<StandardMaterial>>,
    /// Materials of ground.
    pub covers: ResMut<'w, Assets<CoverMaterial>>,
    /// Pictures.
    pub images: ResMut<'w, Assets<Image>>,
}

/// Shared handles of a level that is being spawned.
pub struct Palette {
    solid: Handle<StandardMaterial>,
    water: Handle<StandardMaterial>,
    glass: Handle<StandardMaterial>,
    models: HashMap<Model, (Handle<Mesh>, Aabb)>,
    trees: Vec<Vec<(Handle<Mesh>, Aabb)>>,
    shared: HashMap<Shared, Vec<((Handle<Mesh>, Aabb), Range<f32>)>>,
    library: Library,
    stand_in: (Handle<Mesh>, Aabb),
}

/// Whatever lets light through does so where the sun reaches it only.
type Drawn = (
    Mesh3d,
    MeshMaterial3d<StandardMaterial>,
    Aabb,
    Transform,
    LevelEntity,
    TransmittedShadowReceiver,
);

impl Palette {
    /// Adds materials and the models' meshes.
    pub fn new(assets: &mut LevelAssets, prepared: &mut Prepared, library: Library) -> Self {
        let stand_in = placeholder::striped_box();
        let models = std::mem::take(&mut prepared.models);
        let trees = std::mem::take(&mut prepared.trees);
        let mut add = |ready: ReadyMesh| (assets.meshes.add(ready.mesh), ready.aabb);
        let shared = std::mem::take(&mut prepared.shared).into_iter().map(|(part, levels)| {
            let levels = levels.into_iter().map(|(ready, range)| (add(ready), range));
            (part, levels.collect())
        });
        Self {
            shared: shared.collect(),
            trees: trees
                .into_iter()
                .map(|levels| {
                    let levels = levels.into_iter();
                    levels
                        .map(|ready| (assets.meshes.add(ready.mesh), ready.aabb))
                        .collect()
                })
                .collect(),
            solid: assets.materials.add(StandardMaterial {
                perceptual_roughness: 0.95,
                reflectance: 0.25,
                ..default()
            }),
            // Dark ground seen through it, and the sky in its ripples: the sky's picture for mirrors is coarse.
            water: assets.materials.add(StandardMaterial {
                base_color: Color::linear_rgb(0.012, 0.018, 0.014),
                perceptual_roughness: 0.32,
                reflectance: 0.35,
                ..default()
            }),
            glass: assets.materials.add(StandardMaterial {
                base_color: Color::WHITE.with_alpha(0.5),
                alpha_mode: AlphaMode::Blend,
                perceptual_roughness: 0.4,
                double_sided: true,
                cull_mode: None,
                ..default()
            }),
            models: models
                .into_iter()
                .map(|(model, ready)| (model, (assets.meshes.add(ready.mesh), ready.aabb)))
                .collect(),
            library,
            stand_in: (
                assets.meshes.add(to_mesh(stand_in)),
                Aabb::from_min_max(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 1.0, 0.5)),
            ),
        }
    }

    /// One sentence per model file that could not be used.
    pub fn notes(&self) -> &[String] {
        &self.library.notes
    }

    /// What is seen instead of a model: a box of side 1 that stands on its origin.
    pub fn stand_in(&self) -> impl Bundle + use<> {
        let (mesh, aabb) = self.stand_in.clone();
        (Mesh3d(mesh), MeshMaterial3d(self.solid.clone()), aabb)
    }

    /// The model files.
    pub fn library(&mut self) -> &mut Library {
        &mut self.library
    }

    /// Spawns meshes in world space.
    pub fn spawn_statics(
        &mut self,
        commands: &mut Commands,
        assets: &mut LevelAssets,
        statics: Vec<(&'static str, ReadyMesh, Finish)>,
    ) {
        let mut covers: HashMap<[&str; TILES], Option<Handle<CoverMaterial>>> = HashMap::new();
        for (name, mut ready, finish) in statics {
            let mut cover = None;
            if let Finish::Cover(Cover { tiles, weights }) = &finish {
                let material =
                    covers
                        .entry(*tiles)
                        .or_insert_with(|| match self.library.cover(*tiles, &mut assets.images) {
                            Ok(material) => material.map(|material| assets.covers.add(material)),
                            Err(sentence) => {
                                self.library.notes.push(sentence);
                                None
                            }
                        });
                if material.is_some() {
                    ready.mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, weights.clone());
                }
                cover = material.clone();
            }
            let mesh = Mesh3d(assets.meshes.add(ready.mesh));
            let mut entity = commands.spawn((Name::new(name), mesh, ready.aabb, LevelEntity));
            match (cover, finish) {
                (Some(cover), _) => entity.insert(MeshMaterial3d(cover)),
                (None, Finish::Water) => entity.insert((MeshMaterial3d(self.water.clone()), NotShadowCaster)),
                (None, Finish::Glass) => entity.insert((MeshMaterial3d(self.glass.clone()), NotShadowCaster)),
                (None, _) => entity.insert(MeshMaterial3d(self.solid.clone())),
            };
        }
    }

    /// Spawns ground in levels of detail.
    pub fn spawn_patches(&self, commands: &mut Commands, meshes: &mut Assets<Mesh>, patches: Vec<ReadyPatch>) {
        for patch in patches {
            let place = Transform::from_translation(patch.origin);
            let levels: Vec<Vec<Entity>> = patch
                .levels
                .into_iter()
                .map(|ReadyMesh { mesh, aabb }| {
                    let has_correspondence = mesh.has_morph_targets();
                    let mesh = Mesh3d(meshes.add(mesh));
                    let material = MeshMaterial3d(self.solid.clone());
                    let mut part = commands.spawn((Name::new(patch.name), mesh, material, aabb, place, LevelEntity));
                    if has_correspondence {
                        part.insert(LodMorph);
                    }
                    vec![part.id()]
                })
                .collect();
            if levels.len() > 1 {
                let chain = LodChain {
                    levels,
                    borders: Arc::new(patch.borders),
                    metric: LodMetric::Distance,
                };
                commands.spawn((place, chain, LevelEntity));
            }
        }
    }

    /// Spawns trees that are drawn cell by cell.
    pub fn spawn_grove(&self, commands: &mut Commands, grove: Grove) {
        let looks = TreeLooks {
            meshes: self.trees.clone(),
            material: self.solid.clone(),
        };
        commands.spawn((Name::new("grove"), CellField::new(grove, looks), LevelEntity));
    }

    /// Spawns placements: one entity for a model that is built here, one per material and level of detail for a file's, and a chain
    /// that chooses among the levels.
    pub fn spawn(&mut self, commands: &mut Commands, assets: &mut LevelAssets, placements: &[Placement]) {
        let mut batch = Batch::default();
        for placement in placements {
            let transform = Transform {
                translation: placement.position,
                rotation: placement.rotation,
                scale: placement.scale,
            };
            let drawn = |(mesh, aabb): &(Handle<Mesh>, Aabb), material: &Handle<StandardMaterial>, transform| {
                let material = MeshMaterial3d(material.clone());
                let mesh = Mesh3d(mesh.clone());
                (mesh, material, *aabb, transform, LevelEntity, TransmittedShadowReceiver)
            };
            let Some(asset) = placement.model.asset() else {
                if let Some(levels) = blocks::index(placement.model).and_then(|index| self.trees.get(index)) {
                    let starts = [0.0].into_iter().chain(LEVEL_ENDS);
                    let ends = LEVEL_ENDS.into_iter().chain([f32::INFINITY]);
                    let ranges = starts.zip(ends).map(|(from, to)| from..to);
                    let parts = levels.iter().map(|level| vec![drawn(level, &self.solid, transform)]);
                    batch.add(transform, parts.zip(ranges).collect(), LodMetric::Distance);
                } else if let Some(model) = self.models.get(&placement.model) {
                    batch.always.push(drawn(model, &self.solid, transform));
                }
                continue;
            };
            let Some(shape) = self.library.shape(asset).cloned() else {
                let size = 2.0 * placement.model.half_extent();
                let transform = transform.with_scale(placement.scale * size);
                batch.always.push(drawn(&self.stand_in, &self.solid, transform));
                continue;
            };
            if let Model::Building(building) = placement.model {
                let sample = shape.lods(1.0).find_map(|(parts, _)| parts.first().cloned());
                let mut material = |tint: Tint| {
                    let part = sample.as_ref()?;
                    self.library.material(asset, part, tint, &mut assets.materials)
                };
                if let (Some(paint), Some(bare)) = (material(placement.tint), material(Tint::WHITE)) {
                    self.add_building(&mut batch, &building, transform, [&paint, &bare]);
                }
                continue;
            }
            let mut levels = Vec::new();
            for (parts, range) in shape.lods(placement.scale.max_element()) {
                let mut drawn_parts = Vec::new();
                for part in parts {
                    let material = self
                        .library
                        .material(asset, part, placement.tint, &mut assets.materials);
                    let Some(material) = material else { continue };
                    drawn_parts.push(drawn(&(part.mesh.clone(), part.aabb), &material, transform));
                }
                levels.push((drawn_parts, range));
            }
            batch.add(transform, levels, LodMetric::ProjectedSize);
        }
        batch.spawn(commands);
    }

    /// Adds the storeys and the roof of a building, in its paint and in what is bare.
    fn add_building(
        &self,
        batch: &mut Batch,
        building: &Building,
        place: Transform,
        [paint, bare]: [&Handle<StandardMaterial>; 2],
    ) {
        for (part, offset, scale) in building.parts() {
            let material = if Building::is_painted(&part) { paint } else { bare };
            let own = place * Transform::from_translation(offset).with_scale(scale);
            let levels = self.shared.get(&part).into_iter().flatten();
            let levels = levels.map(|((mesh, aabb), range)| {
                let (mesh, material) = (Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()));
                let drawn = (mesh, material, *aabb, own, LevelEntity, TransmittedShadowReceiver);
                (vec![drawn], range.clone())
            });
            batch.add(own, levels.collect(), LodMetric::ProjectedSize);
        }
    }
}

/// Entities to be.
#[derive(Default)]
struct Batch {
    always: Vec<Drawn>,
    chains: Vec<(Transform, Vec<Vec<Drawn>>, Arc<LodBorders>, LodMetric)>,
    /// Borders so far, by the bits of their metres.
    borders: HashMap<Vec<u32>, Arc<LodBorders>>,
}

impl Batch {
    /// Adds an object whose levels are drawn at these camera distances in metres, without gaps from 0 on.
    fn add(&mut self, place: Transform, mut levels: Vec<(Vec<Drawn>, Range<f32>)>, metric: LodMetric) {
        levels.retain(|(_, range)| !range.is_empty());
        let ends = borders_of(levels.iter().map(|(_, range)| range));
        if ends.is_empty() {
            self.always.extend(levels.into_iter().flat_map(|(parts, _)| parts));
            return;
        }
        let key = ends.iter().map(|end| end.to_bits()).collect();
        let borders = self.borders.entry(key).or_insert_with(|| {
            let borders = ends.iter().copied().map(f64::from);
            Arc::new(LodBorders::new(borders))
        });
        let parts = levels.into_iter().map(|(parts, _)| parts).collect();
        self.chains.push((place, parts, borders.clone(), metric));
    }

    /// Spawns everything.
    fn spawn(self, commands: &mut Commands) {
        commands.spawn_batch(self.always);
        for (place, levels, borders, metric) in self.chains {
            let levels = levels.into_iter().map(|parts| {
                let parts = parts.into_iter().map(|part| commands.spawn(part).id());
                parts.collect()
            });
            let chain = LodChain {
                levels: levels.collect(),
                borders,
                metric,
            };
            commands.spawn((place, chain, LevelEntity));
        }
    }
}

/// Where levels end, from the ranges of those that are drawn at all; empty for one level without end.
pub fn borders_of<'a>(ranges: impl Iterator<Item = &'a Range<f32>>) -> Vec<f32> {
    ranges.map(|range| range.end).filter(|end| end.is_finite()).collect()
}
