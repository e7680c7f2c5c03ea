//! From plans to entities: joints, meshes of all levels that share them, a player for the clips.

use bevy::{
    animation::AnimatedBy,
    camera::{primitives::Aabb, visibility::VisibilityRange},
    mesh::skinning::SkinnedMesh,
    prelude::*,
};

use super::{
    Gait, Inhabitant,
    plan::{self, Plan},
    rule::InhabitantRule,
};
use crate::level::{
    ground::Ground,
    library::{Library, rigs::Rig},
    load::LevelEntity,
    spawn::LevelAssets,
};

/// How far limbs reach beyond the box of the bind pose, in metres: a deer's neck when it grazes.
const REACH: f32 = 0.6;

/// Spawns the figures of a level. Gives one sentence per model file that cannot be used: its figures stay away.
pub(in crate::level) fn spawn(
    commands: &mut Commands,
    assets: &mut LevelAssets,
    graphs: &mut Assets<AnimationGraph>,
    library: &mut Library,
    (rules, ground, seed): (&[InhabitantRule], &Ground, u64),
) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    let mut casts: Vec<(&'static str, Option<Cast>)> = Vec::new();
    for plan in plan::plans(rules, ground, seed) {
        let file = plan.asset.file;
        if !casts.iter().any(|(known, _)| *known == file) {
            let cast = library.rig(file).and_then(|rig| Cast::new(rig, graphs));
            // A file that is not there has its sentence already.
            if cast.is_none() && library.shape(plan.asset).is_some() {
                notes.push(format!(
                    "models/{file}.glb has no figure with the clip walk and another one: its inhabitants stay away"
                ));
            }
            casts.push((file, cast));
        }
        let cast = casts
            .iter()
            .find(|(known, _)| *known == file)
            .and_then(|(_, cast)| cast.as_ref());
        if let Some(cast) = cast {
            cast.spawn(commands, assets, library, plan);
        }
    }
    notes
}

/// What all figures of a file share.
struct Cast {
    rig: Rig,
    graph: Handle<AnimationGraph>,
    walk: Gait,
    rest: Gait,
    metres: f32,
}

impl Cast {
    fn new(rig: &Rig, graphs: &mut Assets<AnimationGraph>) -> Option<Self> {
        let walk = rig.clips.iter().find(|clip| clip.metres > 0.0)?;
        let rest = rig.clips.iter().find(|clip| clip.metres == 0.0)?;
        let (graph, nodes) = AnimationGraph::from_clips([walk.handle.clone(), rest.handle.clone()]);
        let gait = |index: usize, seconds| Gait {
            node: nodes[index],
            seconds,
        };
        Some(Self {
            rig: rig.clone(),
            graph: graphs.add(graph),
            walk: gait(0, walk.seconds),
            rest: gait(1, rest.seconds),
            metres: walk.metres,
        })
    }

    fn spawn(&self, commands: &mut Commands, assets: &mut LevelAssets, library: &mut Library, plan: Plan) {
        let Some(shape) = library.shape(plan.asset).cloned() else {
            return;
        };
        let mut player = AnimationPlayer::default();
        for gait in [self.walk, self.rest] {
            player.play(gait.node).pause();
        }
        let (asset, tint, scale) = (plan.asset, plan.tint, plan.scale);
        let root = commands
            .spawn((
                Name::new(asset.file),
                Transform::from_scale(Vec3::splat(scale)),
                Visibility::default(),
                AnimationGraphHandle(self.graph.clone()),
                player,
                Inhabitant {
                    metres: self.metres * scale,
                    walk: self.walk,
                    rest: self.rest,
                    plan,
                },
                LevelEntity,
            ))
            .id();
        let mut joints: Vec<Entity> = Vec::with_capacity(self.rig.joints.len());
        for joint in &self.rig.joints {
            let parent = joint.parent.map_or(root, |parent| joints[parent]);
            let entity = commands.spawn((
                Name::new(joint.name.clone()),
                joint.transform,
                Visibility::default(),
                joint.target,
                AnimatedBy(root),
                ChildOf(parent),
            ));
            joints.push(entity.id());
        }
        let skin = SkinnedMesh {
            inverse_bindposes: self.rig.inverse_bindposes.clone(),
            joints: self.rig.skin.iter().map(|joint| joints[*joint]).collect(),
        };
        for (parts, range) in shape.lods(scale) {
            for part in parts {
                let Some(material) = library.material(asset, part, tint, &mut assets.materials) else {
                    continue;
                };
                let aabb = Aabb {
                    center: part.aabb.center,
                    half_extents: part.aabb.half_extents + REACH,
                };
                let mut entity = commands.spawn((
                    Mesh3d(part.mesh.clone()),
                    MeshMaterial3d(material),
                    aabb,
                    skin.clone(),
                    ChildOf(root),
                ));
                if range != (0.0..f32::INFINITY) {
                    let hard = |distance: f32| distance..distance;
                    entity.insert(VisibilityRange {
                        start_margin: hard(range.start),
                        end_margin: hard(range.end),
                        use_aabb: false,
                    });
                }
            }
        }
    }
}
