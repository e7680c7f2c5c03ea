//! Main world: parts with a coat get the fading material, and their own back.

use bevy::{mesh::MeshTag, platform::collections::HashMap, prelude::*};

use super::{
    layers::FadingLayers,
    material::{Fading, FadingMaterial},
    tag::tag,
};
use crate::lod::chain::LodCoat;

/// On a fading part: its own material.
#[derive(Component, Clone, Debug)]
pub(super) struct Undressed(Handle<StandardMaterial>);

/// One fading material per base material and way to fade, shared by all parts.
#[derive(Resource, Default)]
pub(super) struct FadingMaterials(HashMap<(AssetId<StandardMaterial>, Fading), Handle<FadingMaterial>>);

impl FadingMaterials {
    fn of(
        &mut self,
        base: &Handle<StandardMaterial>,
        extension: Fading,
        materials: &Assets<StandardMaterial>,
        fading: &mut Assets<FadingMaterial>,
    ) -> Option<Handle<FadingMaterial>> {
        if let Some(known) = self.0.get(&(base.id(), extension)) {
            return Some(known.clone());
        }
        let handle = fading.add(FadingMaterial {
            base: materials.get(base)?.clone(),
            extension,
        });
        self.0.insert((base.id(), extension), handle.clone());
        Some(handle)
    }
}

/// Keeps the copies of base materials equal to them.
pub(super) fn follow_base_materials(
    mut events: MessageReader<AssetEvent<StandardMaterial>>,
    materials: Res<Assets<StandardMaterial>>,
    mut known: ResMut<FadingMaterials>,
    mut fading: ResMut<Assets<FadingMaterial>>,
) {
    for event in events.read() {
        match event {
            AssetEvent::Modified { id } => {
                for extension in Fading::ALL {
                    let handle = known.0.get(&(*id, extension));
                    let copy = handle.and_then(|handle| fading.get_mut(handle));
                    if let (Some(mut copy), Some(base)) = (copy, materials.get(*id)) {
                        copy.base = base.clone();
                    }
                }
            }
            AssetEvent::Removed { id } => {
                for extension in Fading::ALL {
                    known.0.remove(&(*id, extension));
                }
            }
            AssetEvent::Added { .. } | AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}

/// Dresses parts whose coat is new or another.
pub(super) fn dress_parts(
    mut commands: Commands,
    mut coated: Query<
        (
            Entity,
            &LodCoat,
            &mut Visibility,
            Option<&MeshMaterial3d<StandardMaterial>>,
            Option<&mut MeshMaterial3d<FadingMaterial>>,
            Option<&Undressed>,
            Option<&mut MeshTag>,
        ),
        Changed<LodCoat>,
    >,
    materials: Res<Assets<StandardMaterial>>,
    layers: Res<FadingLayers>,
    mut known: ResMut<FadingMaterials>,
    mut fading: ResMut<Assets<FadingMaterial>>,
) {
    for (entity, coat, mut visibility, own, dressed, undressed, own_tag) in &mut coated {
        let base = match (own, undressed) {
            (Some(own), _) => &own.0,
            (None, Some(undressed)) => &undressed.0,
            (None, None) => {
                // A material of another kind cannot fade: the part is drawn in the half in which it is the opaque one.
                visibility.set_if_neq(Visibility::Hidden);
                continue;
            }
        };
        let extension = Fading {
            wins_ties: coat.wins_ties,
            dithers_shadow: coat.dithers_shadow,
        };
        let Some(wanted) = known.of(base, extension, &materials, &mut fading) else {
            continue;
        };
        let wanted_tag = tag(coat, layers.of(coat));
        match (own, dressed, own_tag) {
            (None, Some(mut dressed), Some(mut own_tag)) => {
                dressed.set_if_neq(MeshMaterial3d(wanted));
                own_tag.set_if_neq(wanted_tag);
            }
            _ => {
                let undressed = Undressed(base.clone());
                commands
                    .entity(entity)
                    .remove::<MeshMaterial3d<StandardMaterial>>()
                    .insert((MeshMaterial3d(wanted), undressed, wanted_tag));
            }
        }
    }
}

/// Gives parts that lost their coat their own material back.
pub(super) fn undress_parts(
    mut commands: Commands,
    mut uncoated: RemovedComponents<LodCoat>,
    parts: Query<&Undressed, Without<LodCoat>>,
) {
    for entity in uncoated.read() {
        if let Ok(undressed) = parts.get(entity) {
            commands
                .entity(entity)
                .remove::<(MeshMaterial3d<FadingMaterial>, Undressed, MeshTag)>()
                .insert(MeshMaterial3d(undressed.0.clone()));
        }
    }
}
