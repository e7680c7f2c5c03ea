//! [`MeshData`]: vertex-coloured triangles made from closed solids, as plain values.
//!
//! Every `push_*` of a solid is closed with outward winding (counter-clockwise seen from outside), so that shadow
//! passes may cull either side. Solids may stand in each other; faces must not lie on each other.

use bevy_math::{Affine3A, Mat3, Quat, Vec2, Vec3};

use super::noise;

/// Linear RGB.
pub type Rgb = [f32; 3];

/// Triangles with one normal, colour and texture coordinate per vertex.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Metres, y up.
    pub positions: Vec<Vec3>,
    /// Unit length.
    pub normals: Vec<Vec3>,
    /// Linear RGB.
    pub colors: Vec<Rgb>,
    /// 0..=1 on textured cards, zero elsewhere.
    pub uvs: Vec<Vec2>,
    /// Three per triangle.
    pub indices: Vec<u32>,
}

impl MeshData {
    /// True without triangles.
    pub fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// Adds a vertex and returns its index.
    pub fn push_vertex(&mut self, position: Vec3, normal: Vec3, color: Rgb, uv: Vec2) -> u32 {
        self.positions.push(position);
        self.normals.push(normal);
        self.colors.push(color);
        self.uvs.push(uv);
        (self.positions.len() - 1) as u32
    }

    /// Adds a flat triangle; counter-clockwise seen from its front. Nothing where it has no area.
    pub fn push_triangle(&mut self, corners: [Vec3; 3], color: Rgb) {
        let normal = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize_or_zero();
        if normal == Vec3::ZERO {
            return;
        }
        for corner in corners {
            let index = self.push_vertex(corner, normal, color, Vec2::ZERO);
            self.indices.push(index);
        }
    }

    /// Adds a flat quadrilateral; counter-clockwise seen from its front.
    pub fn push_quad(&mut self, corners: [Vec3; 4], color: Rgb) {
        let normal = (corners[2] - corners[0])
            .cross(corners[3] - corners[1])
            .normalize_or_zero();
        if normal == Vec3::ZERO {
            return;
        }
        let [a, b, c, d] = corners.map(|corner| self.push_vertex(corner, normal, color, Vec2::ZERO));
        self.indices.extend([a, b, c, a, c, d]);
    }

    /// Adds an axis-aligned box.
    pub fn push_box(&mut self, center: Vec3, size: Vec3, color: Rgb) {
        self.push_oriented_box(center, size, Quat::IDENTITY, color);
    }

    /// Adds a box turned around its middle.
    pub fn push_oriented_box(&mut self, center: Vec3, size: Vec3, rotation: Quat, color: Rgb) {
        let axes = Mat3::from_quat(rotation);
        let half = size * 0.5;
        let axes = [axes.x_axis * half.x, axes.y_axis * half.y, axes.z_axis * half.z];
        for i in 0..3 {
            let (n, u, v) = (axes[i], axes[(i + 1) % 3], axes[(i + 2) % 3]);
            self.push_quad([n - u - v, n + u - v, n + u + v, n - u + v].map(|p| center + p), color);
            self.push_quad(
                [-n - u - v, -n - u + v, -n + u + v, -n + u - v].map(|p| center + p),
                color,
            );
        }
    }

    /// Adds a square bar between two points.
    pub fn push_bar(&mut self, from: Vec3, to: Vec3, thickness: f32, color: Rgb) {
        let along = to - from;
        if along.length_squared() < 1e-12 {
            return;
        }
        let rotation = Quat::from_mat3(&Mat3::from_cols_array_2d(&frame(along).map(|axis| axis.to_array())));
        let size = Vec3::new(thickness, along.length(), thickness);
        self.push_oriented_box((from + to) * 0.5, size, rotation, color);
    }

    /// Adds a round bar between two points: a cylinder, a truncated cone, or a cone where one radius is zero.
    /// Smooth around, flat caps. At least three sides.
    pub fn push_round(&mut self, from: (Vec3, f32), to: (Vec3, f32), sides: u32, colors: (Rgb, Rgb)) {
        let ((a, radius_a), (b, radius_b)) = (from, to);
        let along = b - a;
        let [x, y, z] = frame(along);
        let rim = |i: u32| {
            let (sin, cos) = (i as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
            x * cos + z * sin
        };
        // A normal leans by as much as the side does.
        let lean = (radius_a - radius_b) / along.length();
        let normal = |i: u32| (rim(i) + y * lean).normalize();
        for i in 0..sides {
            let (j, half) = (i + 1, (normal(i) + normal(i + 1)).normalize());
            let p = |center: Vec3, radius: f32, i: u32| center + rim(i % sides) * radius;
            let mut corners = Vec::with_capacity(4);
            // Around: z comes before x, so that outside is the front.
            if radius_a > 0.0 {
                corners.push((p(a, radius_a, j), normal(j), colors.0));
                corners.push((p(a, radius_a, i), normal(i), colors.0));
            } else {
                corners.push((a, half, colors.0));
            }
            if radius_b > 0.0 {
                corners.push((p(b, radius_b, i), normal(i), colors.1));
                corners.push((p(b, radius_b, j), normal(j), colors.1));
            } else {
                corners.push((b, half, colors.1));
            }
            let corners: Vec<u32> = corners
                .into_iter()
                .map(|(p, n, color)| self.push_vertex(p, n, color, Vec2::ZERO))
                .collect();
            for k in 2..corners.len() {
                self.indices.extend([corners[0], corners[k - 1], corners[k]]);
            }
            self.push_triangle([a, p(a, radius_a, i), p(a, radius_a, j)], colors.0);
            self.push_triangle([b, p(b, radius_b, j), p(b, radius_b, i)], colors.1);
        }
    }

    /// Adds two pyramids on a common base, smooth and with as few corners as can be: `waist` is the share of the way where it
    /// is thickest, and its radius; colours at both ends and between. At least three sides.
    pub fn push_spindle(&mut self, ends: [Vec3; 2], waist: (f32, f32), sides: u32, colors: [Rgb; 3]) {
        let [from, to] = ends;
        let [x, y, z] = frame(to - from);
        let center = from.lerp(to, waist.0);
        let tips = [(from, -y, colors[0]), (to, y, colors[2])];
        let [low, high] = tips.map(|(tip, normal, color)| self.push_vertex(tip, normal, color, Vec2::ZERO));
        let first = high + 1;
        for i in 0..sides {
            let (sin, cos) = (i as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
            let out = x * cos + z * sin;
            self.push_vertex(center + out * waist.1, out, colors[1], Vec2::ZERO);
        }
        for i in 0..sides {
            let (a, b) = (first + i, first + (i + 1) % sides);
            // Around: z comes before x, so that outside is the front.
            self.indices.extend([b, a, high, low, a, b]);
        }
    }

    /// Adds a skirt of a fir: a cone with a jagged rim and a hollow underside. `jag` is the share of the radius that
    /// every second corner falls short of; the rim hangs by `droop`.
    pub fn push_skirt(&mut self, foot: Vec3, height: f32, radius: f32, shape: SkirtShape, color: Rgb) {
        let sides = shape.points * 2;
        let apex = foot + Vec3::Y * height;
        let hollow = foot + Vec3::Y * (0.25 * height);
        let dark = color.map(|c| c * 0.55);
        let rim = |i: u32| {
            let i = i % sides;
            let angle = shape.turn + i as f32 / sides as f32 * std::f32::consts::TAU;
            let (outer, low) = if i.is_multiple_of(2) {
                (1.0, shape.droop)
            } else {
                (1.0 - shape.jag, 0.0)
            };
            let (sin, cos) = angle.sin_cos();
            foot + Vec3::new(cos * radius * outer, -low, sin * radius * outer)
        };
        for i in 0..sides {
            let (a, b) = (rim(i), rim(i + 1));
            let face = (a - b).cross(apex - b).normalize();
            // Half way between the facet and a smooth cone: soft light, crisp silhouette.
            let smooth = |p: Vec3| ((p - foot).with_y(0.6 * radius).normalize() + face).normalize();
            let tip = self.push_vertex(apex, face, color, Vec2::ZERO);
            let left = self.push_vertex(b, smooth(b), color, Vec2::ZERO);
            let right = self.push_vertex(a, smooth(a), color, Vec2::ZERO);
            self.indices.extend([left, right, tip]);
            self.push_triangle([a, b, hollow], dark);
        }
    }

    /// Adds a ball with a rough surface of 80 flat triangles, displaced by up to `roughness` of its radii; the colour
    /// runs from the first at the bottom to the second at the top.
    pub fn push_blob(&mut self, center: Vec3, radii: Vec3, roughness: f32, seed: u32, colors: (Rgb, Rgb)) {
        let (directions, triangles) = icosphere();
        let points: Vec<Vec3> = directions
            .iter()
            .enumerate()
            .map(|(i, direction)| center + *direction * radii * (1.0 + roughness * noise::signed(seed, i as i32, 7)))
            .collect();
        for triangle in triangles {
            let up = 0.5 + 0.5 * triangle.iter().map(|i| directions[*i].y).sum::<f32>() / 3.0;
            let color = std::array::from_fn(|k| colors.0[k] + (colors.1[k] - colors.0[k]) * up);
            self.push_triangle(triangle.map(|i| points[i]), color);
        }
    }

    /// Adds another mesh, moved, turned and scaled without mirroring.
    pub fn append(&mut self, other: &Self, transform: Affine3A) {
        let first = self.positions.len() as u32;
        let normal_matrix = transform.matrix3.inverse().transpose();
        self.positions
            .extend(other.positions.iter().map(|p| transform.transform_point3(*p)));
        self.normals.extend(
            other
                .normals
                .iter()
                .map(|n| Vec3::from(normal_matrix * bevy_math::Vec3A::from(*n)).normalize()),
        );
        self.colors.extend(&other.colors);
        self.uvs.extend(&other.uvs);
        self.indices.extend(other.indices.iter().map(|i| first + i));
    }

    /// Smallest and largest corner; `None` without vertices.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.positions.first()?;
        Some(
            self.positions
                .iter()
                .fold((first, first), |(min, max), p| (min.min(*p), max.max(*p))),
        )
    }
}

/// How a skirt of [`MeshData::push_skirt`] is cut.
#[derive(Clone, Copy, Debug)]
pub struct SkirtShape {
    /// Long corners of the rim.
    pub points: u32,
    /// Share of the radius that the corners between fall short of.
    pub jag: f32,
    /// How far the long corners hang, in metres.
    pub droop: f32,
    /// Turn around the axis, in radians.
    pub turn: f32,
}

/// Right-handed unit axes (x, y, z) with y along a vector.
fn frame(along: Vec3) -> [Vec3; 3] {
    let y = along.normalize();
    let side = if y.y.abs() < 0.99 { Vec3::Y } else { Vec3::X };
    let x = side.cross(y).normalize();
    [x, y, x.cross(y)]
}

/// Directions and triangles of an icosahedron that was split once.
fn icosphere() -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let g = (1.0 + 5.0_f32.sqrt()) * 0.5;
    let mut points = Vec::with_capacity(42);
    for (u, v) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        points.extend([Vec3::new(u, v, 0.0), Vec3::new(0.0, u, v), Vec3::new(v, 0.0, u)]);
    }
    let edge = 2.1;
    let near = |a: Vec3, b: Vec3| a.distance(b) < edge;
    let mut triangles = Vec::with_capacity(80);
    let mut middles: Vec<((usize, usize), usize)> = Vec::with_capacity(30);
    let corners = points.clone();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let (p, q, r) = (corners[a], corners[b], corners[c]);
                if !(near(p, q) && near(q, r) && near(r, p)) {
                    continue;
                }
                let [a, b, c] = if (q - p).cross(r - p).dot(p) > 0.0 {
                    [a, b, c]
                } else {
                    [a, c, b]
                };
                let mut middle = |a: usize, b: usize| {
                    let key = (a.min(b), a.max(b));
                    middles
                        .iter()
                        .find(|(edge, _)| *edge == key)
                        .map(|(_, i)| *i)
                        .unwrap_or_else(|| {
                            points.push((corners[a] + corners[b]) * 0.5);
                            middles.push((key, points.len() - 1));
                            points.len() - 1
                        })
                };
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                triangles.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
            }
        }
    }
    (points.into_iter().map(Vec3::normalize).collect(), triangles)
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::HashMap;

    use super::*;

    /// Indices in range, unit normals, nothing that is not a number, no triangle without area.
    pub(in crate::level) fn assert_sane(mesh: &MeshData, name: &str) {
        assert!(!mesh.is_empty() && mesh.indices.len().is_multiple_of(3), "{name}");
        let count = mesh.positions.len();
        assert_eq!(
            [mesh.normals.len(), mesh.colors.len(), mesh.uvs.len()],
            [count; 3],
            "{name}"
        );
        assert!(
            mesh.indices.iter().all(|i| (*i as usize) < count),
            "{name}: index out of range"
        );
        assert!(mesh.positions.iter().all(|p| p.is_finite()), "{name}: position");
        assert!(
            mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4),
            "{name}: normal"
        );
        assert!(
            mesh.colors.iter().flatten().all(|c| (0.0..=1.0).contains(c)),
            "{name}: colour"
        );
        for triangle in mesh.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[triangle[k] as usize]);
            assert!(
                (b - a).cross(c - a).length() > 1e-9,
                "{name}: triangle {a} {b} {c} has no area"
            );
        }
    }

    /// Every edge is used as often in one direction as in the other, the enclosed volume is positive, and vertex
    /// normals lie on the front of their triangles.
    pub(in crate::level) fn assert_solid(mesh: &MeshData, name: &str) {
        assert_sane(mesh, name);
        let key = |p: Vec3| (p * 4096.0).round().as_ivec3().to_array();
        let mut edges: HashMap<_, i32> = HashMap::new();
        let mut volume = 0.0;
        for triangle in mesh.indices.chunks(3) {
            let corners = [0, 1, 2].map(|k| mesh.positions[triangle[k] as usize]);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            volume += f64::from(corners[0].dot(normal)) / 6.0;
            for k in 0..3 {
                let (a, b) = (key(corners[k]), key(corners[(k + 1) % 3]));
                *edges.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
                let cosine = mesh.normals[triangle[k] as usize].dot(normal.normalize());
                assert!(
                    cosine > 0.0,
                    "{name}: a vertex normal lies behind its triangle ({cosine}) at {}",
                    corners[k]
                );
            }
        }
        assert!(edges.values().all(|sum| *sum == 0), "{name}: not closed");
        assert!(volume > 0.0, "{name}: inside out, volume {volume}");
    }

    #[test]
    fn primitives_are_solids() {
        let white = [1.0; 3];
        let mut mesh = MeshData::default();
        mesh.push_oriented_box(Vec3::ONE, Vec3::new(1.0, 2.0, 3.0), Quat::from_rotation_x(0.4), white);
        assert_solid(&mesh, "box");
        let round = [
            ("cylinder", 0.5, 0.5),
            ("cone", 0.5, 0.0),
            ("upside down", 0.0, 0.5),
            ("trunk", 0.5, 0.2),
        ];
        for (name, a, b) in round {
            for to in [Vec3::new(0.3, 2.0, 0.1), Vec3::NEG_Y, Vec3::X] {
                let mut mesh = MeshData::default();
                mesh.push_round((Vec3::ZERO, a), (to, b), 7, (white, white));
                assert_solid(&mesh, name);
            }
        }
        let mut mesh = MeshData::default();
        mesh.push_bar(Vec3::ZERO, Vec3::new(1.0, 2.0, 0.5), 0.1, white);
        assert_solid(&mesh, "bar");
        for to in [Vec3::Y * 3.0, Vec3::new(1.0, -2.0, 0.5)] {
            let mut mesh = MeshData::default();
            mesh.push_spindle([Vec3::ZERO, to], (0.3, 0.8), 5, [white; 3]);
            assert_solid(&mesh, "spindle");
        }
        let mut mesh = MeshData::default();
        let shape = SkirtShape {
            points: 7,
            jag: 0.3,
            droop: 0.2,
            turn: 0.5,
        };
        mesh.push_skirt(Vec3::Y, 3.0, 1.5, shape, white);
        assert_solid(&mesh, "skirt");
        let mut mesh = MeshData::default();
        mesh.push_blob(Vec3::Y, Vec3::new(1.0, 0.7, 1.2), 0.2, 3, (white, white));
        assert_solid(&mesh, "blob");
    }

    #[test]
    fn a_box_has_its_volume_and_an_appended_one_is_moved() {
        let mut unit = MeshData::default();
        unit.push_box(Vec3::ZERO, Vec3::ONE, [0.5; 3]);
        let mut mesh = MeshData::default();
        mesh.append(
            &unit,
            Affine3A::from_scale_rotation_translation(Vec3::new(2.0, 1.0, 1.0), Quat::IDENTITY, Vec3::Y),
        );
        assert_solid(&mesh, "appended");
        assert_eq!(
            mesh.bounds(),
            Some((Vec3::new(-1.0, 0.5, -0.5), Vec3::new(1.0, 1.5, 0.5)))
        );
    }

    #[test]
    fn a_bar_follows_its_direction() {
        let mut mesh = MeshData::default();
        let (from, to) = (Vec3::new(1.0, 0.0, 0.0), Vec3::new(1.0, 3.0, 4.0));
        mesh.push_bar(from, to, 0.2, [0.5; 3]);
        let axis = (to - from).normalize();
        for p in &mesh.positions {
            let off = (*p - from).reject_from(axis).length();
            assert!(
                (off - 0.1 * std::f32::consts::SQRT_2).abs() < 1e-4,
                "{p} is {off} off the axis"
            );
        }
    }
}
