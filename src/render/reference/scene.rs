//! [`TruthScene`]: instances of meshes, and rays through them.

use std::{sync::Arc, time::Duration};

use bevy::math::{Affine3A, DAffine3, DVec3, Vec3};
use obvhs::{
    BvhBuildParams,
    cwbvh::{CwBvh, builder::build_cwbvh},
};
use serde::{Deserialize, Serialize};

use super::mesh::{AlphaMask, LocalRay, TriangleHit, TruthMesh, padded, tree_ray};

/// One mesh in the world.
#[derive(Clone)]
pub struct TruthInstance {
    /// Shared among instances.
    pub mesh: Arc<TruthMesh>,
    /// Its place.
    pub world_from_local: Affine3A,
    /// Where the material has holes.
    pub alpha: Option<Arc<AlphaMask>>,
    /// Whether both sides are drawn. Otherwise only the front is, and a light behind a surface shines through it, as
    /// in the renderer.
    pub double_sided: bool,
    /// Whether it casts shadows.
    pub casts: bool,
}

/// What a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Along the ray, in units of its direction's length.
    pub t: f64,
    /// Geometric unit normal, turned to where the ray comes from.
    pub normal_world: DVec3,
}

/// What is in a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneStatistics {
    /// Meshes in the world.
    pub instances: usize,
    /// Those that cast shadows.
    pub casters: usize,
    /// Different meshes.
    pub meshes: usize,
    /// Triangles of all instances.
    pub triangles: u64,
    /// Lower corner of the box around everything, in metres.
    pub bounds_min_m: [f32; 3],
    /// Upper corner.
    pub bounds_max_m: [f32; 3],
    /// Ground that the box covers, in square metres.
    pub area_m2: f64,
}

struct Placed {
    instance: TruthInstance,
    local_from_world: DAffine3,
    world_from_local: DAffine3,
}

/// Instances of meshes in a tree.
pub struct TruthScene {
    placed: Vec<Placed>,
    tree: Option<CwBvh>,
}

impl TruthScene {
    /// From instances. Those whose transform is not finite or flattens them to nothing are left out.
    pub fn new(instances: impl IntoIterator<Item = TruthInstance>) -> Self {
        let placed: Vec<Placed> = instances
            .into_iter()
            .filter_map(|instance| {
                let world_from_local = double(&instance.world_from_local);
                let volume = world_from_local.matrix3.determinant();
                (world_from_local.is_finite() && volume != 0.0).then(|| Placed {
                    local_from_world: world_from_local.inverse(),
                    world_from_local,
                    instance,
                })
            })
            .collect();
        let boxes: Vec<_> = placed
            .iter()
            .map(|placed| {
                let (min, max) = placed.bounds_world();
                padded(min, max)
            })
            .collect();
        let tree =
            (!boxes.is_empty()).then(|| build_cwbvh(&boxes, BvhBuildParams::fast_build(), &mut Duration::default()));
        Self { placed, tree }
    }

    /// Instances in the scene.
    pub fn len(&self) -> usize {
        self.placed.len()
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.placed.is_empty()
    }

    /// What is in it.
    pub fn statistics(&self) -> SceneStatistics {
        let triangles = self.placed.iter().map(|placed| placed.instance.mesh.len() as u64);
        let (min, max) = self
            .placed
            .iter()
            .map(|placed| placed.bounds_world())
            .reduce(|(min, max), (other_min, other_max)| (min.min(other_min), max.max(other_max)))
            .unwrap_or_default();
        let size = (max - min).as_dvec3();
        SceneStatistics {
            instances: self.placed.len(),
            casters: self.placed.iter().filter(|placed| placed.instance.casts).count(),
            meshes: self.meshes().len(),
            triangles: triangles.sum(),
            bounds_min_m: min.to_array(),
            bounds_max_m: max.to_array(),
            area_m2: size.x * size.z,
        }
    }

    /// Every mesh once.
    fn meshes(&self) -> Vec<&Arc<TruthMesh>> {
        let mut meshes: Vec<_> = self.placed.iter().map(|placed| &placed.instance.mesh).collect();
        meshes.sort_by_key(|mesh| Arc::as_ptr(mesh));
        meshes.dedup_by_key(|mesh| Arc::as_ptr(mesh));
        meshes
    }

    /// Bytes of instances and trees; meshes count once.
    pub fn bytes(&self) -> usize {
        let tree = self.tree.as_ref().map_or(0, |tree| {
            size_of_val(tree.nodes.as_slice()) + size_of_val(tree.primitive_indices.as_slice())
        });
        size_of_val(self.placed.as_slice()) + tree + self.meshes().iter().map(|mesh| mesh.bytes()).sum::<usize>()
    }

    /// Whether something that casts shadows lies on the way from a world-space point to the sun, from `offset` metres on.
    pub fn is_in_shadow(&self, point_world: DVec3, direction_to_light: DVec3, offset: f64) -> bool {
        let ray = LocalRay {
            origin: point_world,
            direction: direction_to_light.normalize_or_zero(),
            nearest: offset,
            farthest: f64::INFINITY,
        };
        // The ray goes towards the light: a surface that faces the light is met from behind.
        self.any(&ray, |placed, local, hit| {
            placed.instance.casts && (placed.instance.double_sided || !placed.faces(hit, local))
        })
    }

    /// The nearest surface that a ray from the eye meets with t in `nearest..=farthest`.
    pub fn first_surface(&self, origin: DVec3, direction: DVec3, nearest: f64, farthest: f64) -> Option<Surface> {
        let ray = LocalRay {
            origin,
            direction,
            nearest,
            farthest,
        };
        let mut first: Option<Surface> = None;
        self.any(&ray, |placed, local, hit| {
            let is_drawn = placed.instance.double_sided || placed.faces(hit, local);
            if is_drawn && first.is_none_or(|other| hit.t < other.t) {
                let normal = placed.normal_world(hit.normal);
                first = Some(Surface {
                    t: hit.t,
                    normal_world: if normal.dot(direction) > 0.0 { -normal } else { normal },
                });
            }
            false
        });
        first
    }

    /// Calls `visit` with every solid triangle on a ray until it returns true; whether it did.
    fn any(&self, ray: &LocalRay, mut visit: impl FnMut(&Placed, &LocalRay, &TriangleHit) -> bool) -> bool {
        let (Some(tree), Some(tree_ray)) = (&self.tree, tree_ray(ray)) else {
            return false;
        };
        let mut found = false;
        !tree.ray_traverse_miss(tree_ray, |_, primitive| {
            if !found {
                let placed = &self.placed[tree.primitive_indices[primitive] as usize];
                let local = LocalRay {
                    origin: placed.local_from_world.transform_point3(ray.origin),
                    direction: placed.local_from_world.transform_vector3(ray.direction),
                    ..*ray
                };
                found = placed.instance.mesh.any(&local, |hit| {
                    let solid = placed
                        .instance
                        .alpha
                        .as_ref()
                        .is_none_or(|alpha| alpha.is_solid(hit.uv));
                    solid && visit(placed, &local, hit)
                });
            }
            if found { 0.0 } else { f32::INFINITY }
        })
    }
}

impl Placed {
    /// Corners of the box in the world around the box of the mesh.
    fn bounds_world(&self) -> (Vec3, Vec3) {
        let (min, max) = self.instance.mesh.bounds();
        let corner = |index: usize| {
            let pick = |bit: usize, low: f32, high: f32| if index >> bit & 1 == 0 { low } else { high };
            let corner = Vec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z));
            self.world_from_local.transform_point3(corner.as_dvec3()).as_vec3()
        };
        let corners: [Vec3; 8] = std::array::from_fn(corner);
        (
            corners.into_iter().fold(Vec3::INFINITY, Vec3::min),
            corners.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max),
        )
    }

    /// Whether a ray meets the side that the renderer takes for the front: mirrored instances turn their winding.
    fn faces(&self, hit: &TriangleHit, local: &LocalRay) -> bool {
        hit.is_front(local) == (self.world_from_local.matrix3.determinant() > 0.0)
    }

    fn normal_world(&self, normal_local: DVec3) -> DVec3 {
        (self.local_from_world.matrix3.transpose() * normal_local).normalize_or_zero()
    }
}

fn double(affine: &Affine3A) -> DAffine3 {
    DAffine3::from_mat3_translation(
        bevy::math::DMat3::from_cols(
            affine.matrix3.x_axis.as_dvec3(),
            affine.matrix3.y_axis.as_dvec3(),
            affine.matrix3.z_axis.as_dvec3(),
        ),
        affine.translation.as_dvec3(),
    )
}
