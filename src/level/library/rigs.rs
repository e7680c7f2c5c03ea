//! Skeletons and clips of model files.

use std::collections::BTreeMap;

use bevy::{
    animation::AnimationTargetId,
    gltf::{Gltf, GltfNode, GltfSkin},
    mesh::skinning::SkinnedMeshInverseBindposes,
    prelude::*,
};
use serde::Deserialize;

/// A joint of a skeleton.
#[derive(Clone, Debug)]
pub struct Joint {
    /// In its file.
    pub name: String,
    /// Index of an earlier joint.
    pub parent: Option<usize>,
    /// Against its parent, in the bind pose.
    pub transform: Transform,
    /// What clips call it.
    pub target: AnimationTargetId,
}

/// A movement.
#[derive(Clone, Debug)]
pub struct Clip {
    /// Its keys.
    pub handle: Handle<AnimationClip>,
    /// Duration of a loop.
    pub seconds: f32,
    /// How far one walks in a loop.
    pub metres: f32,
}

/// What moves the shapes of a file.
#[derive(Clone, Debug)]
pub struct Rig {
    /// Nodes of the skeleton, parents first; the first stands above all joints.
    pub joints: Vec<Joint>,
    /// Indices of the joints that the skin names, in its order.
    pub skin: Vec<usize>,
    /// From model space to each joint's.
    pub inverse_bindposes: Handle<SkinnedMeshInverseBindposes>,
    /// In the order of their names.
    pub clips: Vec<Clip>,
}

/// Name of the node above all joints.
const ROOT: &str = "rig";

#[derive(Deserialize)]
struct Extras {
    umbrage_metres: BTreeMap<String, f32>,
}

/// The rig of a file; `None` where it has none, or an incomplete one.
pub(super) fn read(
    file: &Gltf,
    nodes: &Assets<GltfNode>,
    skins: &Assets<GltfSkin>,
    clips: &Assets<AnimationClip>,
) -> Option<Rig> {
    let skin = skins.get(file.skins.first()?)?;
    let root = file
        .nodes
        .iter()
        .find(|handle| nodes.get(*handle).is_some_and(|node| node.name == ROOT))?;
    let mut joints: Vec<Joint> = Vec::new();
    let mut known: Vec<AssetId<GltfNode>> = Vec::new();
    let mut open: Vec<(&Handle<GltfNode>, Option<usize>, Vec<Name>)> = vec![(root, None, Vec::new())];
    while let Some((handle, parent, above)) = open.pop() {
        let node = nodes.get(handle)?;
        let mut path = above;
        path.push(Name::new(node.name.clone()));
        joints.push(Joint {
            name: node.name.clone(),
            parent,
            transform: node.transform,
            target: AnimationTargetId::from_names(path.iter()),
        });
        known.push(handle.id());
        let own = joints.len() - 1;
        open.extend(node.children.iter().map(|child| (child, Some(own), path.clone())));
    }
    let in_skin = skin
        .joints
        .iter()
        .map(|joint| known.iter().position(|id| *id == joint.id()));
    let extras = nodes.get(root)?.extras.as_ref()?;
    let metres = serde_json::from_str::<Extras>(&extras.value).ok()?.umbrage_metres;
    let clip = |(name, metres): (String, f32)| {
        let handle = file.named_animations.get(name.as_str())?;
        let seconds = clips.get(handle)?.duration();
        (seconds > 0.0 && metres >= 0.0).then(|| Clip {
            handle: handle.clone(),
            seconds,
            metres,
        })
    };
    Some(Rig {
        skin: in_skin.collect::<Option<_>>()?,
        joints,
        inverse_bindposes: skin.inverse_bind_matrices.clone(),
        clips: metres.into_iter().map(clip).collect::<Option<_>>()?,
    })
}
