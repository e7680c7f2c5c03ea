//! From placements to entities: meshes and materials are shared, so that Bevy draws equal models in batches.

use std::collections::HashMap;

use bevy::{
    asset::RenderAssetUsages,
    camera::primitives::Aabb,
    ecs::system::SystemParam,
    image::{ImageSampler, ImageSamplerDescriptor},
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};

use super::{
    load::LevelEntity,
    meshes::MeshData,
    model::{Model, Placement},
    plants,
    scenery::Scenery,
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

/// A level whose meshes are built: everything that takes time and needs no world.
pub struct Prepared {
    /// Meshes in world space.
    pub statics: Vec<(&'static str, ReadyMesh)>,
    /// Solid parts and leaves of every model.
    pub models: Vec<(Model, [Option<ReadyMesh>; 2])>,
    /// Everything that stands somewhere.
    pub placements: Vec<Placement>,
    /// What a walker stands on.
    pub ground: super::ground::Ground,
}

impl Prepared {
    /// Builds the meshes; `report` is called with a share of 0..=1.
    pub fn new(scenery: Scenery, report: impl Fn(f32)) -> Self {
        let mut models: Vec<Model> = Vec::new();
        let mut seen = std::collections::HashSet::new();
        for placement in &scenery.placements {
            if seen.insert(placement.model) {
                models.push(placement.model);
            }
        }
        let total = models.len().max(1) as f32;
        let build = |(i, model): (usize, Model)| {
            report(i as f32 / total);
            let mesh = model.build();
            (model, [mesh.solid, mesh.leaves].map(ReadyMesh::new))
        };
        Self {
            models: models.into_iter().enumerate().map(build).collect(),
            statics: scenery
                .statics
                .into_iter()
                .filter_map(|part| Some((part.name, ReadyMesh::new(part.mesh)?)))
                .collect(),
            placements: scenery.placements,
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
    meshes: ResMut<'w, Assets<Mesh>>,
    materials: ResMut<'w, Assets<StandardMaterial>>,
    images: ResMut<'w, Assets<Image>>,
}

/// Shared handles of a level that is being spawned.
pub struct Palette {
    solid: Handle<StandardMaterial>,
    leaves: Handle<StandardMaterial>,
    models: HashMap<Model, [Option<(Handle<Mesh>, Aabb)>; 2]>,
}

impl Palette {
    /// Adds materials and the models' meshes.
    pub fn new(assets: &mut LevelAssets, models: Vec<(Model, [Option<ReadyMesh>; 2])>) -> Self {
        let mut add = |part: Option<ReadyMesh>| part.map(|ready| (assets.meshes.add(ready.mesh), ready.aabb));
        let models = models
            .into_iter()
            .map(|(model, parts)| (model, parts.map(&mut add)))
            .collect();
        let leaf_texture = assets.images.add(leaf_image());
        let matt = StandardMaterial {
            perceptual_roughness: 0.95,
            reflectance: 0.25,
            ..default()
        };
        Self {
            leaves: assets.materials.add(StandardMaterial {
                base_color_texture: Some(leaf_texture),
                alpha_mode: AlphaMode::Mask(0.5),
                // Seen from both sides with the crown's normals: flipped ones would blacken half of the leaves.
                cull_mode: None,
                ..matt.clone()
            }),
            solid: assets.materials.add(matt),
            models,
        }
    }

    /// Spawns meshes in world space.
    pub fn spawn_statics(
        &self,
        commands: &mut Commands,
        assets: &mut LevelAssets,
        statics: Vec<(&'static str, ReadyMesh)>,
    ) {
        for (name, ready) in statics {
            commands.spawn((
                Name::new(name),
                Mesh3d(assets.meshes.add(ready.mesh)),
                MeshMaterial3d(self.solid.clone()),
                ready.aabb,
                LevelEntity,
            ));
        }
    }

    /// Spawns placements: one entity each, and a second one for leaves.
    pub fn spawn(&self, commands: &mut Commands, placements: &[Placement]) {
        let mut entities = Vec::with_capacity(placements.len());
        for placement in placements {
            let Some(parts) = self.models.get(&placement.model) else {
                continue;
            };
            let transform = Transform {
                translation: placement.position,
                rotation: placement.rotation,
                scale: placement.scale,
            };
            for (part, material) in parts.iter().zip([&self.solid, &self.leaves]) {
                if let Some((mesh, aabb)) = part {
                    entities.push((
                        Mesh3d(mesh.clone()),
                        MeshMaterial3d(material.clone()),
                        *aabb,
                        transform,
                        LevelEntity,
                    ));
                }
            }
        }
        commands.spawn_batch(entities);
    }
}

/// Twigs on a clear ground, without smaller mip levels: shadows and truth look leaves up at full size.
fn leaf_image() -> Image {
    let side = 128;
    let mut image = Image::new(
        Extent3d {
            width: side,
            height: side,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        plants::leaf_texture(side),
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::default(),
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor::linear());
    image
}
