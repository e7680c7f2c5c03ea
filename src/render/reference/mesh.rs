//! [`TruthMesh`]: the triangles of one mesh and their tree.

use std::time::Duration;

use bevy::math::{DVec2, DVec3, Vec2, Vec3};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    cwbvh::{CwBvh, builder::build_cwbvh},
    ray::Ray,
};

/// Alpha of a mesh's material, at mip 0.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaMask {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// Alpha of every texel, 0..=255, row 0 on top.
    pub alpha: Vec<u8>,
    /// Factor on it.
    pub base: f32,
    /// Where the product is below, there is nothing.
    pub cutoff: f32,
}

impl AlphaMask {
    /// Whether there is a surface at a texture coordinate: bilinear, repeating, as the GPU samples mip 0.
    pub fn is_solid(&self, uv: DVec2) -> bool {
        if self.width == 0 || self.height == 0 || self.alpha.len() < self.width as usize * self.height as usize {
            return self.base >= self.cutoff;
        }
        let place = uv * DVec2::new(f64::from(self.width), f64::from(self.height)) - 0.5;
        let (corner, share) = (place.floor(), place - place.floor());
        let texel = |dx: i64, dy: i64| {
            let x = (corner.x as i64).saturating_add(dx).rem_euclid(i64::from(self.width));
            let y = (corner.y as i64).saturating_add(dy).rem_euclid(i64::from(self.height));
            f64::from(self.alpha[(y * i64::from(self.width) + x) as usize]) / 255.0
        };
        let top = texel(0, 0) * (1.0 - share.x) + texel(1, 0) * share.x;
        let bottom = texel(0, 1) * (1.0 - share.x) + texel(1, 1) * share.x;
        let alpha = top * (1.0 - share.y) + bottom * share.y;
        alpha * f64::from(self.base) >= f64::from(self.cutoff)
    }
}

/// A ray in the space of a mesh: origin + t · direction. The direction keeps the length that the instance's transform
/// gives it, so that t means the same in both spaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalRay {
    /// Where t is 0.
    pub origin: DVec3,
    /// One unit of t.
    pub direction: DVec3,
    /// Hits before it do not count.
    pub nearest: f64,
    /// Hits beyond it do not count.
    pub farthest: f64,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Along the ray.
    pub t: f64,
    /// Normal of the triangle's plane by its winding, in the space of the mesh, not of unit length.
    pub normal: DVec3,
    /// Texture coordinate.
    pub uv: DVec2,
}

impl TriangleHit {
    /// Whether the ray comes from the side that winds counter-clockwise.
    pub fn is_front(&self, ray: &LocalRay) -> bool {
        self.normal.dot(ray.direction) < 0.0
    }
}

/// The triangles of one mesh and their tree.
pub struct TruthMesh {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    indices: Vec<[u32; 3]>,
    tree: CwBvh,
    bounds: (Vec3, Vec3),
}

/// Boxes of the tree are grown by this share of their size and of their distance from the origin, so that rounding in
/// single precision does not lose flat ones.
const PADDING: f32 = 1.0e-5;

impl TruthMesh {
    /// From triangles; `None` when none of them has an area and finite corners. `uvs` may be empty.
    pub fn new(positions: Vec<Vec3>, uvs: Vec<Vec2>, mut indices: Vec<[u32; 3]>) -> Option<Self> {
        indices.retain(|triangle| {
            let corners = triangle.map(|index| positions.get(index as usize).copied());
            let [Some(a), Some(b), Some(c)] = corners else {
                return false;
            };
            let area = (b - a).as_dvec3().cross((c - a).as_dvec3()).length();
            a.is_finite() && b.is_finite() && c.is_finite() && area > 0.0
        });
        if indices.is_empty() {
            return None;
        }
        let boxes: Vec<Aabb> = indices
            .iter()
            .map(|triangle| {
                let corners = triangle.map(|index| positions[index as usize]);
                let (min, max) = (
                    corners[0].min(corners[1]).min(corners[2]),
                    corners[0].max(corners[1]).max(corners[2]),
                );
                padded(min, max)
            })
            .collect();
        let min = boxes.iter().fold(Vec3::INFINITY, |min, aabb| {
            min.min(Vec3::from_array(aabb.min.to_array()))
        });
        let max = boxes.iter().fold(Vec3::NEG_INFINITY, |max, aabb| {
            max.max(Vec3::from_array(aabb.max.to_array()))
        });
        let tree = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut Duration::default());
        let uvs = if uvs.len() == positions.len() { uvs } else { Vec::new() };
        Some(Self {
            positions,
            uvs,
            indices,
            tree,
            bounds: (min, max),
        })
    }

    /// Corners of the box around all triangles.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    /// Triangles with an area.
    #[expect(clippy::len_without_is_empty, reason = "a mesh without triangles is not made")]
    pub fn len(&self) -> usize {
        self.indices.len()
    }

    /// Bytes of triangles and tree.
    pub fn bytes(&self) -> usize {
        size_of_val(self.positions.as_slice())
            + size_of_val(self.uvs.as_slice())
            + size_of_val(self.indices.as_slice())
            + size_of_val(self.tree.nodes.as_slice())
            + size_of_val(self.tree.primitive_indices.as_slice())
    }

    /// Calls `visit` with every triangle that the ray meets, in any order, until it returns true; whether it did.
    pub fn any(&self, ray: &LocalRay, mut visit: impl FnMut(&TriangleHit) -> bool) -> bool {
        let Some(tree_ray) = tree_ray(ray) else {
            return false;
        };
        let mut found = false;
        !self.tree.ray_traverse_miss(tree_ray, |_, primitive| {
            if !found {
                let triangle = self.indices[self.tree.primitive_indices[primitive] as usize];
                found = self.hit(ray, triangle).is_some_and(|hit| visit(&hit));
            }
            // The traversal ends at the first finite distance.
            if found { 0.0 } else { f32::INFINITY }
        })
    }

    /// Watertight: the three edge functions are computed from corners relative to the origin in double precision, two
    /// triangles that share an edge get values of exactly opposite sign for it, and zero counts as inside for both.
    fn hit(&self, ray: &LocalRay, triangle: [u32; 3]) -> Option<TriangleHit> {
        let corners = triangle.map(|index| self.positions[index as usize].as_dvec3());
        let [a, b, c] = corners.map(|corner| corner - ray.origin);
        let (u, v, w) = (
            ray.direction.dot(b.cross(c)),
            ray.direction.dot(c.cross(a)),
            ray.direction.dot(a.cross(b)),
        );
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let sum = u + v + w;
        if !inside || sum == 0.0 {
            return None;
        }
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let t = normal.dot(a) / normal.dot(ray.direction);
        let uv = match self.uvs.as_slice() {
            [] => DVec2::ZERO,
            uvs => {
                let [a, b, c] = triangle.map(|index| uvs[index as usize].as_dvec2());
                (a * u + b * v + c * w) / sum
            }
        };
        (t >= ray.nearest && t <= ray.farthest).then_some(TriangleHit { t, normal, uv })
    }
}

/// A box for a tree, grown by [`PADDING`].
pub(super) fn padded(min: Vec3, max: Vec3) -> Aabb {
    let padding = Vec3::splat((max - min).max_element() * PADDING + 1.0e-7) + min.abs().max(max.abs()) * PADDING;
    Aabb::new((min - padding).to_array().into(), (max + padding).to_array().into())
}

/// A ray for a tree, without limits: the triangles' own test has them. `None` where single precision ends.
pub(super) fn tree_ray(ray: &LocalRay) -> Option<Ray> {
    // NOTE: adding zero turns −0 into 0. The trees take the inverse of −0 for negative but its sign for positive, and
    // miss every box: a light along an axis of the scene would cast no shadows.
    let (origin, direction) = (ray.origin.as_vec3(), ray.direction.as_vec3() + Vec3::ZERO);
    let is_fit = origin.is_finite() && direction.is_finite() && direction != Vec3::ZERO;
    is_fit.then(|| Ray::new(origin.to_array().into(), direction.to_array().into(), 0.0, f32::MAX))
}
