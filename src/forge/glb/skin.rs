//! Rigs in the file: joints as nodes, one skin, animations.

use bevy_math::{Mat3, Vec3};
use gltf_json::{
    Accessor, Animation, Index, Node, Skin,
    accessor::{ComponentType, Type},
    animation::{Channel, Interpolation, Property, Sampler, Target},
    validation::Checked::Valid,
};
use serde_json::{Map, Value, json};

use super::{File, index, raw};
use crate::forge::rig::{Clip, Rig, quaternion};

/// What a skinned mesh's node and its scene name.
#[derive(Clone, Copy)]
pub(super) struct Skeleton {
    /// The node above all joints.
    pub(super) root: Index<Node>,
    pub(super) skin: Index<Skin>,
}

impl File {
    pub(super) fn rig(&mut self, rig: &Rig) -> Skeleton {
        let root = self.root.nodes.len();
        let node_of = |joint: usize| index::<Node>(root + 1 + joint);
        let metres: Map<String, Value> = rig
            .clips
            .iter()
            .map(|clip| (clip.name.clone(), json!(clip.metres)))
            .collect();
        let children = |parent: Option<usize>| {
            let own: Vec<Index<Node>> = (0..rig.joints.len())
                .filter(|joint| rig.joints[*joint].parent == parent)
                .map(node_of)
                .collect();
            (!own.is_empty()).then_some(own)
        };
        self.root.nodes.push(Node {
            name: Some("rig".into()),
            children: children(None),
            extras: raw(&json!({ "umbrage_metres": metres })),
            ..Default::default()
        });
        for (number, joint) in rig.joints.iter().enumerate() {
            let parent = joint.parent.map_or(Vec3::ZERO, |parent| rig.joints[parent].position);
            self.root.nodes.push(Node {
                name: Some(joint.name.clone()),
                children: children(Some(number)),
                translation: Some((joint.position - parent).to_array()),
                ..Default::default()
            });
        }
        let inverse_bind = rig.joints.iter().map(|joint| {
            let [x, y, z] = (-joint.position).to_array();
            [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0]
        });
        let matrices = self.numbers(Type::Mat4, inverse_bind);
        let skin = Index::push(
            &mut self.root.skins,
            Skin {
                name: Some("skin".into()),
                inverse_bind_matrices: Some(matrices),
                joints: (0..rig.joints.len()).map(node_of).collect(),
                skeleton: Some(index(root)),
                extensions: None,
                extras: None,
            },
        );
        for clip in &rig.clips {
            self.clip(rig, clip, root + 1);
        }
        Skeleton {
            root: index(root),
            skin,
        }
    }

    /// One animation; its last key is its first again. Joints that turn in no clip have no channel; the others have one in
    /// every clip, so that players may go from clip to clip.
    fn clip(&mut self, rig: &Rig, clip: &Clip, first_joint: usize) {
        let count = clip.poses.len();
        let keys = || clip.poses.iter().chain(clip.poses.first());
        let times = (0..=count).map(|key| [clip.seconds * key as f32 / count.max(1) as f32]);
        let input = self.numbers(Type::Scalar, times);
        if let Some(last) = self.root.accessors.last_mut() {
            last.min = Some(json!([0.0]));
            last.max = Some(json!([clip.seconds]));
        }
        let mut animation = Animation {
            name: Some(clip.name.clone()),
            channels: Vec::new(),
            samplers: Vec::new(),
            extensions: None,
            extras: None,
        };
        let mut add = |node: usize, path: Property, output: Index<Accessor>| {
            let sampler = Index::push(
                &mut animation.samplers,
                Sampler {
                    input,
                    interpolation: Valid(Interpolation::Linear),
                    output,
                    extensions: None,
                    extras: None,
                },
            );
            animation.channels.push(Channel {
                sampler,
                target: Target {
                    node: index(node),
                    path: Valid(path),
                    extensions: None,
                    extras: None,
                },
                extensions: None,
                extras: None,
            });
        };
        let places = self.numbers(Type::Vec3, keys().map(|pose| pose.root.to_array()));
        add(first_joint, Property::Translation, places);
        for joint in 0..rig.joints.len() {
            let mut poses = rig.clips.iter().flat_map(|clip| &clip.poses);
            if poses.any(|pose| pose.turns[joint] != Mat3::IDENTITY) {
                let turns = self.numbers(Type::Vec4, keys().map(|pose| quaternion(pose.turns[joint])));
                add(first_joint + joint, Property::Rotation, turns);
            }
        }
        self.root.animations.push(animation);
    }

    /// Floats that are no vertex attribute.
    fn numbers<const N: usize>(&mut self, type_: Type, values: impl Iterator<Item = [f32; N]>) -> Index<Accessor> {
        let bytes: Vec<u8> = values.flatten().flat_map(f32::to_le_bytes).collect();
        let count = bytes.len() / (4 * N);
        self.accessor(&bytes, None, ComponentType::F32, type_, count)
    }
}
