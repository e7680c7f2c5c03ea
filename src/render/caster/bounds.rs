//! Local bounds of meshes, for culling casters on the GPU.

use bevy::{
    asset::AssetId,
    camera::{primitives::Aabb, visibility::NoFrustumCulling},
    math::Vec3A,
    mesh::{Mesh3d, skinning::SkinnedMesh},
    platform::collections::HashMap,
    prelude::*,
    render::Extract,
};

/// Local bounds by mesh asset: the union over all entities that draw it.
#[derive(Resource, Default, Debug)]
pub struct MeshBounds(HashMap<AssetId<Mesh>, LocalBounds>);

/// Bounds of one mesh in its local space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalBounds {
    /// A box.
    Box {
        /// Center, metres.
        center: Vec3,
        /// Half extents, metres.
        half_extents: Vec3,
    },
    /// Never culled: skinned, or excluded from frustum culling by its owner.
    Unbounded,
}

impl MeshBounds {
    /// Bounds of a mesh; unbounded while unknown.
    pub fn get(&self, mesh: AssetId<Mesh>) -> LocalBounds {
        self.0.get(&mesh).copied().unwrap_or(LocalBounds::Unbounded)
    }
}

impl LocalBounds {
    /// The smallest bounds that hold both.
    pub fn union(self, other: Self) -> Self {
        let (
            Self::Box {
                center: a,
                half_extents: ha,
            },
            Self::Box {
                center: b,
                half_extents: hb,
            },
        ) = (self, other)
        else {
            return Self::Unbounded;
        };
        let (min, max) = ((a - ha).min(b - hb), (a + ha).max(b + hb));
        Self::Box {
            center: (min + max) / 2.0,
            half_extents: (max - min) / 2.0,
        }
    }
}

/// Follows the bounds that Bevy computes for entities.
pub fn extract_mesh_bounds(
    mut bounds: ResMut<MeshBounds>,
    changed: Extract<
        Query<
            (&Mesh3d, Option<&Aabb>, Has<NoFrustumCulling>, Has<SkinnedMesh>),
            Or<(
                Changed<Mesh3d>,
                Changed<Aabb>,
                Added<NoFrustumCulling>,
                Added<SkinnedMesh>,
            )>,
        >,
    >,
) {
    for (mesh, aabb, unculled, skinned) in &changed {
        let local = match aabb {
            Some(aabb) if !unculled && !skinned => from_aabb(aabb),
            _ => LocalBounds::Unbounded,
        };
        bounds
            .0
            .entry(mesh.id())
            .and_modify(|known| *known = known.union(local))
            .or_insert(local);
    }
}

fn from_aabb(aabb: &Aabb) -> LocalBounds {
    // A degenerate mesh (no vertices, NaN) is drawn unculled rather than lost.
    if !aabb.center.is_finite() || !aabb.half_extents.is_finite() || aabb.half_extents.cmplt(Vec3A::ZERO).any() {
        return LocalBounds::Unbounded;
    }
    LocalBounds::Box {
        center: aabb.center.into(),
        half_extents: aabb.half_extents.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn union_holds_both_and_unbounded_wins() {
        let a = LocalBounds::Box {
            center: Vec3::ZERO,
            half_extents: Vec3::ONE,
        };
        let b = LocalBounds::Box {
            center: Vec3::X * 3.0,
            half_extents: Vec3::ONE,
        };
        let LocalBounds::Box { center, half_extents } = a.union(b) else {
            panic!("two boxes have a box as union");
        };
        assert_eq!(center, Vec3::X * 1.5, "center of the union");
        assert_eq!(half_extents, Vec3::new(2.5, 1.0, 1.0), "half extents of the union");
        assert_eq!(
            a.union(LocalBounds::Unbounded),
            LocalBounds::Unbounded,
            "unbounded wins"
        );
    }
}
