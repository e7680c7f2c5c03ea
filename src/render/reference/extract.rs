//! The scene that the renderer draws, as a [`TruthScene`].

use std::{collections::HashMap, sync::Arc};

use bevy::{
    camera::visibility::{RenderLayers, VisibilityRange, VisibleEntityRanges},
    light::NotShadowCaster,
    math::{Affine3A, Mat4, Vec2, Vec3},
    mesh::{
        Indices, PrimitiveTopology, VertexAttributeValues,
        morph::{MeshMorphWeights, MorphWeights},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
    render::render_resource::TextureFormat,
};
use thiserror::Error;

use super::{
    mesh::{AlphaMask, TruthMesh},
    scene::{TruthInstance, TruthScene},
};
use crate::lod::casters::{ShadowOnly, Silenced};

/// What rays cannot be sent through.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TruthError {
    /// A mesh whose vertices are on the GPU only.
    #[error("a mesh is not in main memory: load it with `RenderAssetUsages::MAIN_WORLD`")]
    MeshNotReadable,
    /// Anything but triangle lists.
    #[error("meshes of {0:?} have no truth: only triangle lists do")]
    Topology(PrimitiveTopology),
    /// A texture of an alpha-masked material that is compressed, layered, or not in main memory.
    #[error(
        "the alpha of a texture of format {0:?} cannot be read: use an uncompressed one, loaded with `RenderAssetUsages::MAIN_WORLD`"
    )]
    Texture(TextureFormat),
}

/// Alpha below which Bevy's shadow pass drops the fragments of blended materials.
const BLEND_CUTOFF: f32 = 0.05;

/// All visible meshes of the main world, skinned ones in the pose of the last transform propagation, morphed ones by the
/// weights of their own. Meshes without a
/// triangle and those that are still being loaded are left out.
///
/// With a camera, levels of detail ([`VisibilityRange`]) are those that its last frame drew, and what is on other
/// [`RenderLayers`] is left out; without one, all levels count at once. Shadows are those of what is seen, also where
/// [another level](crate::lod::casters) casts them.
///
/// # Errors
/// Something that is drawn cannot be read.
pub fn truth_scene(world: &mut World, camera: Option<Entity>) -> Result<TruthScene, TruthError> {
    let mut drawn = world.query::<(
        Entity,
        &Mesh3d,
        &GlobalTransform,
        &InheritedVisibility,
        Option<&MeshMaterial3d<StandardMaterial>>,
        (Option<&SkinnedMesh>, Option<&MeshMorphWeights>),
        (Has<NotShadowCaster>, Has<Silenced>, Has<ShadowOnly>),
        Has<VisibilityRange>,
        Option<&RenderLayers>,
    )>();
    let world = &*world;
    let ranges = world.get_resource::<VisibleEntityRanges>();
    let camera_layers = camera.and_then(|camera| world.get::<RenderLayers>(camera)).cloned();
    let camera_layers = camera_layers.unwrap_or_default();
    let is_drawn = |entity: Entity, has_range: bool, layers: Option<&RenderLayers>| {
        camera.is_none_or(|camera| {
            let is_in_range = ranges.is_none_or(|ranges| ranges.entity_is_in_range_of_view(entity, camera));
            (!has_range || is_in_range) && layers.unwrap_or(&RenderLayers::default()).intersects(&camera_layers)
        })
    };
    let (meshes, materials, images) = (
        world.get_resource::<Assets<Mesh>>(),
        world.get_resource::<Assets<StandardMaterial>>(),
        world.get_resource::<Assets<Image>>(),
    );
    let mut known_meshes: HashMap<AssetId<Mesh>, Option<Arc<TruthMesh>>> = HashMap::new();
    let mut known_masks: HashMap<AssetId<StandardMaterial>, Option<Arc<AlphaMask>>> = HashMap::new();
    let mut instances = Vec::new();
    for (entity, handle, transform, visibility, material, (skin, morph), casting, has_range, layers) in
        drawn.iter(world)
    {
        let Some(mesh) = meshes.and_then(|meshes| meshes.get(&handle.0)) else {
            continue;
        };
        let (does_not_cast, is_silenced, only_casts) = casting;
        if !visibility.get() || only_casts || !is_drawn(entity, has_range, layers) {
            continue;
        }
        let pose = skin.and_then(|skin| joints_of(world, skin));
        let weights = morph.map_or(&[][..], |morph| weights_of(world, morph));
        let is_moved = pose.is_some() || weights.iter().any(|weight| *weight != 0.0);
        let truth_mesh = match known_meshes.get(&handle.id()) {
            Some(known) if !is_moved => known.clone(),
            _ => {
                let new = triangles(mesh, pose.as_ref(), weights)?;
                if !is_moved {
                    known_meshes.insert(handle.id(), new.clone());
                }
                new
            }
        };
        let Some(truth_mesh) = truth_mesh else {
            continue;
        };
        let asset = material.and_then(|material| Some((material.id(), materials?.get(&material.0)?)));
        let alpha = match asset {
            None => None,
            Some((id, material)) => match known_masks.get(&id) {
                Some(known) => known.clone(),
                None => {
                    let new = alpha_of(material, images)?.map(Arc::new);
                    known_masks.insert(id, new.clone());
                    new
                }
            },
        };
        instances.push(TruthInstance {
            mesh: truth_mesh,
            // Joints place skinned vertices in the world.
            world_from_local: if pose.is_some() {
                Affine3A::IDENTITY
            } else {
                transform.affine()
            },
            alpha,
            double_sided: asset.is_some_and(|(_, material)| material.cull_mode.is_none()),
            casts: !does_not_cast || is_silenced,
        });
    }
    Ok(TruthScene::new(instances))
}

/// `world_from_mesh` of every joint; `None` where one is missing.
fn joints_of(world: &World, skin: &SkinnedMesh) -> Option<Vec<Mat4>> {
    let bindposes = world
        .get_resource::<Assets<SkinnedMeshInverseBindposes>>()?
        .get(&skin.inverse_bindposes)?;
    skin.joints
        .iter()
        .zip(bindposes.iter())
        .map(|(joint, joint_from_mesh)| {
            let joint = world.get::<GlobalTransform>(*joint)?;
            Some(joint.to_matrix() * *joint_from_mesh)
        })
        .collect()
}

/// Weights of a mesh's morph targets.
fn weights_of<'a>(world: &'a World, morph: &'a MeshMorphWeights) -> &'a [f32] {
    match morph {
        MeshMorphWeights::Value { weights } => weights,
        MeshMorphWeights::Reference(entity) => world.get::<MorphWeights>(*entity).map_or(&[], MorphWeights::weights),
    }
}

/// Morphed first, then skinned, as Bevy does.
fn triangles(mesh: &Mesh, joints: Option<&Vec<Mat4>>, weights: &[f32]) -> Result<Option<Arc<TruthMesh>>, TruthError> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return Err(TruthError::Topology(mesh.primitive_topology()));
    }
    let attribute = |id| mesh.try_attribute_option(id).map_err(|_| TruthError::MeshNotReadable);
    let Some(VertexAttributeValues::Float32x3(positions)) = attribute(Mesh::ATTRIBUTE_POSITION)? else {
        return Ok(None);
    };
    let mut positions: Vec<Vec3> = positions.iter().copied().map(Vec3::from).collect();
    if weights.iter().any(|weight| *weight != 0.0)
        && mesh.try_has_morph_targets().map_err(|_| TruthError::MeshNotReadable)?
    {
        // One target after the other, each with a step of every vertex.
        let targets = mesh.try_morph_targets().map_err(|_| TruthError::MeshNotReadable)?;
        for (target, weight) in targets.chunks(positions.len().max(1)).zip(weights) {
            for (position, step) in positions.iter_mut().zip(target) {
                *position += *weight * step.position;
            }
        }
    }
    if let (
        Some(joints),
        Some(VertexAttributeValues::Uint16x4(indices)),
        Some(VertexAttributeValues::Float32x4(weights)),
    ) = (
        joints,
        attribute(Mesh::ATTRIBUTE_JOINT_INDEX)?,
        attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT)?,
    ) {
        for ((position, indices), weights) in positions.iter_mut().zip(indices).zip(weights) {
            let moved = indices.iter().zip(weights).map(|(index, weight)| {
                let joint = joints.get(usize::from(*index)).copied().unwrap_or(Mat4::IDENTITY);
                joint.transform_point3(*position) * *weight
            });
            *position = moved.sum();
        }
    }
    let uvs = match attribute(Mesh::ATTRIBUTE_UV_0)? {
        Some(VertexAttributeValues::Float32x2(uvs)) => uvs.iter().copied().map(Vec2::from).collect(),
        _ => Vec::new(),
    };
    let flat: Vec<u32> = match mesh.try_indices_option().map_err(|_| TruthError::MeshNotReadable)? {
        Some(Indices::U16(indices)) => indices.iter().map(|index| u32::from(*index)).collect(),
        Some(Indices::U32(indices)) => indices.clone(),
        None => (0..positions.len() as u32).collect(),
    };
    let (triangles, _) = flat.as_chunks::<3>();
    Ok(TruthMesh::new(positions, uvs, triangles.to_vec()).map(Arc::new))
}

/// Where a material has holes; `None`: nowhere.
fn alpha_of(material: &StandardMaterial, images: Option<&Assets<Image>>) -> Result<Option<AlphaMask>, TruthError> {
    let cutoff = match material.alpha_mode {
        AlphaMode::Mask(cutoff) => cutoff,
        AlphaMode::Blend | AlphaMode::Premultiplied | AlphaMode::Add => BLEND_CUTOFF,
        _ => return Ok(None),
    };
    let mut mask = AlphaMask {
        width: 0,
        height: 0,
        alpha: Vec::new(),
        base: material.base_color.alpha(),
        cutoff,
    };
    let image = material
        .base_color_texture
        .as_ref()
        .and_then(|texture| images?.get(texture));
    if let Some(image) = image {
        (mask.width, mask.height) = (image.width(), image.height());
        mask.alpha = alpha_texels(image)?;
    }
    Ok(Some(mask))
}

/// Alpha of mip 0, row 0 on top, rounded to 8 bits; formats without alpha are solid, as for the GPU.
fn alpha_texels(image: &Image) -> Result<Vec<u8>, TruthError> {
    let format = image.texture_descriptor.format;
    if let (Some(data), TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb) = (&image.data, format) {
        let texels = image.width() as usize * image.height() as usize;
        return Ok(data.chunks_exact(4).take(texels).map(|texel| texel[3]).collect());
    }
    let places = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    places
        .map(|(x, y)| {
            let color = image.get_color_at(x, y).map_err(|_| TruthError::Texture(format))?;
            Ok((color.alpha().clamp(0.0, 1.0) * 255.0).round() as u8)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use bevy::{
        asset::RenderAssetUsages,
        render::render_resource::{Extent3d, TextureDimension},
    };

    use super::*;

    fn image(format: TextureFormat, data: &[u8]) -> Image {
        let size = Extent3d {
            width: 2,
            height: 1,
            depth_or_array_layers: 1,
        };
        let mut image = Image::new_uninit(size, TextureDimension::D2, format, RenderAssetUsages::all());
        image.data = Some(data.to_vec());
        image
    }

    #[test]
    fn alpha_is_read_from_what_bevy_can_read() {
        let half = 0.25_f32.to_le_bytes();
        let one = 1.0_f32.to_le_bytes();
        let floats: Vec<u8> = [[one, one, one, half], [one, one, one, one]].concat().concat();
        for (format, data, alpha) in [
            (TextureFormat::Rgba8UnormSrgb, &[1, 2, 3, 4, 5, 6, 7, 8][..], [4, 8]),
            (TextureFormat::Bgra8UnormSrgb, &[1, 2, 3, 4, 5, 6, 7, 8], [4, 8]),
            (TextureFormat::R8Unorm, &[0, 9], [255, 255]),
            (TextureFormat::Rg8Unorm, &[0, 0, 9, 9], [255, 255]),
            (
                TextureFormat::Rgba16Unorm,
                &[0, 0, 0, 0, 0, 0, 255, 127, 0, 0, 0, 0, 0, 0, 255, 255],
                [127, 255],
            ),
            (TextureFormat::Rgba32Float, &floats, [64, 255]),
        ] {
            assert_eq!(alpha_texels(&image(format, data)), Ok(alpha.to_vec()), "{format:?}");
        }
        for format in [TextureFormat::Bc7RgbaUnorm, TextureFormat::Rgba16Snorm] {
            assert_eq!(alpha_texels(&image(format, &[0; 16])), Err(TruthError::Texture(format)));
        }
        let mut on_the_gpu = image(TextureFormat::Rgba8Unorm, &[]);
        on_the_gpu.data = None;
        assert_eq!(
            alpha_texels(&on_the_gpu),
            Err(TruthError::Texture(TextureFormat::Rgba8Unorm))
        );
    }
}
