//! From plans to entities: joints, meshes of all levels that share them, a player for the clips.

use std::sync::Arc;

use bevy::{animation::AnimatedBy, camera::primitives::Aabb, mesh::skinning::SkinnedMesh, prelude::*};

use super::{
    Gait, Gaits, Inhabitant,
    plan::{self, Plan},
    rule::InhabitantRule,
};
use crate::{
    level::{
        ground::Ground,
        library::{Library, rigs::Rig},
        load::LevelEntity,
        spawn::{LevelAssets, Palette, borders_of},
    },
    lod::chain::LodChain,
    maths::lod::selection::{LodBorders, LodMetric},
};

/// How far limbs reach beyond the box of the bind pose, in metres: a deer's neck when it grazes.
const REACH: f32 = 0.6;

/// Spawns the figures of a level. Where a model file cannot be used, striped boxes go their ways instead, and the library
/// gets one sentence.
pub(in crate::level) fn spawn(
    commands: &mut Commands,
    assets: &mut LevelAssets,
    graphs: &mut Assets<AnimationGraph>,
    palette: &mut Palette,
    (rules, ground, seed): (&[InhabitantRule], &Ground, u64),
) {
    let mut casts: Vec<(&'static str, Option<Cast>)> = Vec::new();
    for plan in plan::plans(rules, ground, seed) {
        let file = plan.asset.file;
        if !casts.iter().any(|(known, _)| *known == file) {
            let library = palette.library();
            let cast = library.rig(file).and_then(|rig| Cast::new(rig, graphs));
            // A file that is not there has its sentence already.
            if cast.is_none() && library.shape(plan.asset).is_some() {
                library.notes.push(format!(
                    "models/{file}.glb has no figure with the clip walk and another one; striped boxes go its ways"
                ));
            }
            casts.push((file, cast));
        }
        let cast = casts
            .iter()
            .find(|(known, _)| *known == file)
            .and_then(|(_, cast)| cast.as_ref());
        match cast {
            Some(cast) => cast.spawn(commands, assets, palette.library(), plan),
            None => spawn_box(commands, palette, plan),
        }
    }
}

/// A striped box as large as the figure, which goes its way.
fn spawn_box(commands: &mut Commands, palette: &Palette, plan: Plan) {
    let name = Name::new(plan.asset.file);
    let at_its_size = Transform::from_scale(plan.figure.size());
    let gaits = None;
    commands
        .spawn((
            name,
            Transform::default(),
            Visibility::default(),
            Inhabitant { plan, gaits },
            LevelEntity,
        ))
        .with_child((palette.stand_in(), at_its_size));
}

/// What all figures of a file share.
struct Cast {
    rig: Rig,
    graph: Handle<AnimationGraph>,
    gaits: Gaits,
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
            gaits: Gaits {
                walk: gait(0, walk.seconds),
                rest: gait(1, rest.seconds),
                metres: walk.metres,
            },
        })
    }

    fn spawn(&self, commands: &mut Commands, assets: &mut LevelAssets, library: &mut Library, plan: Plan) {
        let Some(shape) = library.shape(plan.asset).cloned() else {
            return;
        };
        let mut player = AnimationPlayer::default();
        for gait in [self.gaits.walk, self.gaits.rest] {
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
                    gaits: Some(Gaits {
                        metres: self.gaits.metres * scale,
                        ..self.gaits
                    }),
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
        let mut levels = Vec::new();
        for (parts, range) in shape.lods(scale).filter(|(_, range)| !range.is_empty()) {
            let mut entities = Vec::new();
            for part in parts {
                let Some(material) = library.material(asset, part, tint, &mut assets.materials) else {
                    continue;
                };
                let aabb = Aabb {
                    center: part.aabb.center,
                    half_extents: part.aabb.half_extents + REACH,
                };
                let entity = commands.spawn((
                    Mesh3d(part.mesh.clone()),
                    MeshMaterial3d(material),
                    aabb,
                    skin.clone(),
                    ChildOf(root),
                ));
                entities.push(entity.id());
            }
            levels.push((entities, range));
        }
        let borders = borders_of(levels.iter().map(|(_, range)| range));
        if !borders.is_empty() {
            commands.entity(root).insert(LodChain {
                levels: levels.into_iter().map(|(entities, _)| entities).collect(),
                borders: Arc::new(LodBorders::new(borders.into_iter().map(f64::from))),
                metric: LodMetric::ProjectedSize,
            });
        }
    }
}
