//! [`SceneBounds`]: the boxes around everything that casts or receives shadows, following moving things.

use bevy::{
    camera::{
        primitives::Aabb,
        visibility::{DynamicSkinnedMeshBounds, InheritedVisibility},
    },
    ecs::{entity::EntityHashMap, query::QueryData},
    light::{NotShadowCaster, NotShadowReceiver},
    math::{DVec3, Vec3A},
    mesh::skinning::SkinnedMesh,
    prelude::*,
};

use crate::maths::bounds::Bounds;

/// Leaves a mesh out of [`SceneBounds`]: for sky domes and other backdrops whose size would blur every shadow.
///
/// It still casts and receives shadows where light views happen to reach it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct NotInSceneBounds;

/// World-space boxes around the visible meshes, in metres: S of the papers. `None`: there are none.
///
/// Kept up to date every frame in [`ShadowSystems::UpdateSceneBounds`](super::ShadowSystems::UpdateSceneBounds) from the
/// [`Aabb`]s of all entities with [`Mesh3d`] that are not hidden. Meshes without an [`Aabb`] (with
/// [`NoFrustumCulling`](bevy::camera::visibility::NoFrustumCulling), or not loaded yet) have no known size and do not
/// count; give them an [`Aabb`] if their shadows matter. Skinned meshes without
/// [`DynamicSkinnedMeshBounds`] are padded by half their size, because their limbs leave their box.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct SceneBounds {
    /// Everything.
    pub scene: Option<Bounds>,
    /// What casts shadows: no [`NotShadowCaster`].
    pub casters: Option<Bounds>,
    /// What receives shadows: no [`NotShadowReceiver`].
    pub receivers: Option<Bounds>,
}

impl SceneBounds {
    fn from_sums(sums: Sums) -> Self {
        let some = |bounds: Bounds| (!bounds.is_empty()).then_some(bounds);
        Self {
            scene: some(sums.casters.union(&sums.receivers)),
            casters: some(sums.casters),
            receivers: some(sums.receivers),
        }
    }
}

/// What [`SceneBounds`] needs to know about a mesh.
#[derive(QueryData)]
pub(super) struct MeshInScene {
    aabb: Option<&'static Aabb>,
    transform: &'static GlobalTransform,
    visibility: &'static InheritedVisibility,
    not_caster: Has<NotShadowCaster>,
    not_receiver: Has<NotShadowReceiver>,
    left_out: Has<NotInSceneBounds>,
    skinned: Has<SkinnedMesh>,
    follows_skin: Has<DynamicSkinnedMeshBounds>,
}

/// A mesh whose box or role may have changed this frame.
type MeshChanged = Or<(
    Changed<Mesh3d>,
    Changed<Aabb>,
    Changed<GlobalTransform>,
    Changed<InheritedVisibility>,
    Added<NotShadowCaster>,
    Added<NotShadowReceiver>,
    Added<NotInSceneBounds>,
)>;

#[derive(Clone, Copy, Debug)]
struct Entry {
    bounds: Bounds,
    casts: bool,
    receives: bool,
}

impl Entry {
    fn new(mesh: &MeshInSceneItem) -> Option<Self> {
        let casts = !mesh.not_caster;
        let receives = !mesh.not_receiver;
        if mesh.left_out || !mesh.visibility.get() || !(casts || receives) {
            return None;
        }
        let mut bounds = world_bounds(mesh.aabb?, mesh.transform);
        if mesh.skinned && !mesh.follows_skin {
            bounds = bounds.expanded(0.5 * bounds.size().max_element());
        }
        let finite = bounds.min.is_finite() && bounds.max.is_finite() && !bounds.is_empty();
        if !finite {
            warn_once!("a mesh whose bounding box is not finite is left out of the scene's bounds");
        }
        finite.then_some(Self {
            bounds,
            casts,
            receives,
        })
    }
}

/// The world-space box around an entity's local box.
fn world_bounds(aabb: &Aabb, transform: &GlobalTransform) -> Bounds {
    let world_from_local = transform.affine();
    let center = world_from_local.transform_point3a(aabb.center);
    let half = world_from_local.matrix3.abs() * aabb.half_extents.abs();
    let wide = |point: Vec3A| -> DVec3 { point.to_vec3().as_dvec3() };
    Bounds::new(wide(center - half), wide(center + half))
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    casters: Bounds,
    receivers: Bounds,
}

impl Sums {
    fn add(&mut self, entry: &Entry) {
        if entry.casts {
            self.casters = self.casters.union(&entry.bounds);
        }
        if entry.receives {
            self.receivers = self.receivers.union(&entry.bounds);
        }
    }

    /// True when the entry reaches the surface of a sum, so that its leaving may shrink the sum.
    fn depends_on(&self, entry: &Entry) -> bool {
        let touches = |sum: &Bounds| entry.bounds.min.cmple(sum.min).any() || entry.bounds.max.cmpge(sum.max).any();
        (entry.casts && touches(&self.casters)) || (entry.receives && touches(&self.receivers))
    }
}

/// The box of every mesh, so that a frame costs as much as it changes.
#[derive(Resource, Default)]
pub(super) struct MeshBounds {
    entries: EntityHashMap<Entry>,
    sums: Sums,
    /// A mesh on the surface of a sum changed: the sums have to be built anew.
    stale: bool,
}

impl MeshBounds {
    fn set(&mut self, entity: Entity, entry: Option<Entry>) {
        let before = match entry {
            Some(entry) => self.entries.insert(entity, entry),
            None => self.entries.remove(&entity),
        };
        self.stale |= before.is_some_and(|before| self.sums.depends_on(&before));
        if let Some(entry) = entry {
            self.sums.add(&entry);
        }
    }

    fn sums(&mut self) -> Sums {
        if self.stale {
            self.stale = false;
            self.sums = Sums::default();
            for entry in self.entries.values() {
                self.sums.add(entry);
            }
        }
        self.sums
    }
}

/// Components whose removal changes the role of a mesh.
#[derive(bevy::ecs::system::SystemParam)]
pub(super) struct Removals<'w, 's> {
    meshes: RemovedComponents<'w, 's, Mesh3d>,
    boxes: RemovedComponents<'w, 's, Aabb>,
    not_casters: RemovedComponents<'w, 's, NotShadowCaster>,
    not_receivers: RemovedComponents<'w, 's, NotShadowReceiver>,
    left_out: RemovedComponents<'w, 's, NotInSceneBounds>,
}

/// Brings [`SceneBounds`] up to date with what was spawned, despawned, moved, shown, hidden or marked.
pub(super) fn update_scene_bounds(
    changed: Query<(Entity, MeshInScene), (With<Mesh3d>, MeshChanged)>,
    meshes: Query<MeshInScene, With<Mesh3d>>,
    mut removals: Removals,
    mut mesh_bounds: ResMut<MeshBounds>,
    mut scene_bounds: ResMut<SceneBounds>,
) {
    let removed = removals
        .meshes
        .read()
        .chain(removals.boxes.read())
        .chain(removals.not_casters.read())
        .chain(removals.not_receivers.read())
        .chain(removals.left_out.read());
    for entity in removed {
        let entry = meshes.get(entity).ok().and_then(|mesh| Entry::new(&mesh));
        mesh_bounds.set(entity, entry);
    }
    for (entity, mesh) in &changed {
        mesh_bounds.set(entity, Entry::new(&mesh));
    }
    let sums = mesh_bounds.sums();
    scene_bounds.set_if_neq(SceneBounds::from_sums(sums));
}
