//! Flat faces and closed blocks with places in the picture.

use bevy_math::{Vec2, Vec3};

use super::atlas::{Cell, Strip};
use crate::forge::{
    mesh::{Mesh, Vertex},
    portable::{TURN, sin_cos},
};

/// A mesh that is being built. Every `block`, `bar` and `hexahedron` is closed.
#[derive(Clone, Debug)]
pub struct Brush {
    /// What is there.
    pub mesh: Mesh,
}

impl Default for Brush {
    fn default() -> Self {
        Self {
            mesh: Mesh {
                shades: true,
                ..Mesh::default()
            },
        }
    }
}

/// A corner of a face: place, texture coordinates, factor on the colour.
pub type Corner = (Vec3, Vec2, f32);

impl Brush {
    /// A flat quadrilateral; corners counter-clockwise seen from its front. Nothing where it has no area.
    pub fn face(&mut self, corners: [Corner; 4]) {
        let [a, b, c, d] = corners.map(|(p, ..)| p);
        let normal = (c - a).cross(d - b).normalize_or_zero();
        if normal == Vec3::ZERO {
            return;
        }
        let indices = corners.map(|corner| self.corner(corner, normal));
        self.mesh.push_quad(indices);
    }

    /// A flat triangle; corners counter-clockwise seen from its front. Nothing where it has no area.
    pub fn triangle(&mut self, corners: [Corner; 3]) {
        let [a, b, c] = corners.map(|(p, ..)| p);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        if normal == Vec3::ZERO {
            return;
        }
        let indices = corners.map(|corner| self.corner(corner, normal));
        self.mesh.indices.extend(indices);
    }

    fn corner(&mut self, (position, uv, shade): Corner, normal: Vec3) -> u32 {
        self.mesh.push(Vertex {
            position,
            normal,
            uv,
            tangent: Vec3::X,
            shade,
        })
    }

    /// A quadrilateral with a strip: metres along its first edge, its height within the strip's.
    pub fn strip_face(&mut self, corners: [Vec3; 4], strip: Strip, shade: f32) {
        let [a, b, _, d] = corners;
        let along = (b - a).normalize_or(Vec3::X);
        let rise = (d - a) - along * (d - a).dot(along);
        let height = rise.length();
        let up = rise.normalize_or(Vec3::Y);
        let shown = (height / strip.metres).min(1.0);
        // Neighbours show different parts of the strip.
        let start = a.dot(Vec3::new(1.0, 2.37, 1.0)).abs();
        self.face(corners.map(|p| {
            let from = p - a;
            let share = if height > 0.0 { from.dot(up) / height } else { 0.0 };
            (p, strip.at(start + from.dot(along), share * shown), shade)
        }));
    }

    /// A quadrilateral that shows a whole cell: corners from the lower left one, counter-clockwise.
    pub fn cell_face(&mut self, corners: [Vec3; 4], cell: Cell, shades: (f32, f32)) {
        let [a, b, c, d] = corners;
        self.face([
            (a, cell.at(Vec2::ZERO), shades.0),
            (b, cell.at(Vec2::X), shades.0),
            (c, cell.at(Vec2::ONE), shades.1),
            (d, cell.at(Vec2::Y), shades.1),
        ]);
    }

    /// A thin picture before another face: its front shows a cell, its back closes it.
    pub fn plate(&mut self, corners: [Vec3; 4], cell: Cell, shades: (f32, f32)) {
        let [a, b, c, d] = corners;
        self.cell_face(corners, cell, shades);
        self.cell_face([b, a, d, c], cell, shades);
    }

    /// A closed solid with six faces: corners of its foot counter-clockwise seen from above, then those of its top.
    pub fn hexahedron(&mut self, foot: [Vec3; 4], top: [Vec3; 4], strip: Strip) {
        for k in 0..4 {
            let next = (k + 1) % 4;
            self.strip_face([foot[k], foot[next], top[next], top[k]], strip, 1.0);
        }
        self.strip_face(top, strip, 1.0);
        // Undersides lie in their own shade.
        self.strip_face([foot[3], foot[2], foot[1], foot[0]], strip, 0.7);
    }

    /// A closed box.
    pub fn block(&mut self, low: Vec3, high: Vec3, strip: Strip) {
        let ring = |y: f32| {
            [
                Vec3::new(low.x, y, high.z),
                Vec3::new(high.x, y, high.z),
                Vec3::new(high.x, y, low.z),
                Vec3::new(low.x, y, low.z),
            ]
        };
        self.hexahedron(ring(low.y), ring(high.y), strip);
    }

    /// A closed bar of triangular section between two points.
    pub fn bar(&mut self, from: Vec3, to: Vec3, radius: f32, strip: Strip) {
        let along = (to - from).normalize_or(Vec3::Y);
        let side = if along.y.abs() < 0.9 { Vec3::Y } else { Vec3::Z };
        let x = side.cross(along).normalize_or(Vec3::X);
        let z = x.cross(along);
        let rim = [x * 0.866 - z * 0.5, x * -0.866 - z * 0.5, z].map(|d| d * radius);
        for k in 0..3 {
            let (a, b) = (rim[k], rim[(k + 1) % 3]);
            self.strip_face([from + a, from + b, to + b, to + a], strip, 1.0);
        }
        let uv = strip.at(0.0, 0.5);
        self.triangle([2, 1, 0].map(|k| (from + rim[k], uv, 1.0)));
        self.triangle([0, 1, 2].map(|k| (to + rim[k], uv, 1.0)));
    }

    /// A closed upright prism with regular plan; top and foot may differ in radius.
    pub fn drum(&mut self, foot: Vec3, radii: (f32, f32), height: f32, sides: usize, strip: Strip) {
        let rim = |radius: f32, k: usize| {
            let (sin, cos) = sin_cos(TURN * (k % sides) as f32 / sides as f32);
            Vec3::new(cos, 0.0, -sin) * radius
        };
        let top = foot + Vec3::Y * height;
        let uv = strip.at(0.0, 0.5);
        for k in 0..sides {
            let (a, b) = (rim(radii.0, k), rim(radii.0, k + 1));
            let (c, d) = (rim(radii.1, k + 1), rim(radii.1, k));
            if radii.1 > 0.0 {
                self.strip_face([foot + a, foot + b, top + c, top + d], strip, 1.0);
                self.triangle([(top, uv, 1.0), (top + d, uv, 1.0), (top + c, uv, 1.0)]);
            } else {
                self.triangle([(foot + a, uv, 1.0), (foot + b, uv, 1.0), (top, uv, 1.0)]);
            }
            self.triangle([(foot, uv, 0.7), (foot + b, uv, 0.7), (foot + a, uv, 0.7)]);
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::forge::city::facade::atlas::{STONE, TILES};

    /// Every edge is used as often in one direction as in the other, normals lie on the front of their triangles, and
    /// the enclosed volume is positive; gives it in cubic metres.
    pub(in crate::forge::city::facade) fn assert_closed(mesh: &Mesh, name: &str) -> f32 {
        let key = |p: Vec3| (p * 4096.0).round().as_ivec3().to_array();
        let mut edges: BTreeMap<_, i32> = BTreeMap::new();
        let mut volume = 0.0;
        for triangle in mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.vertices[triangle[k] as usize]);
            let normal = (b.position - a.position).cross(c.position - a.position);
            assert!(
                normal.dot(a.normal) > 0.0,
                "{name}: a normal behind its triangle at {}",
                a.position
            );
            volume += a.position.dot(normal) / 6.0;
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let (from, to) = (key(from.position), key(to.position));
                *edges.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
            }
        }
        let open = edges.iter().find(|(_, sum)| **sum != 0);
        assert!(open.is_none(), "{name}: open at {open:?} (in 1/4096 m)");
        assert!(volume > 0.0, "{name}: inside out, {volume}");
        volume
    }

    #[test]
    fn solids_are_closed_and_of_their_size() {
        let mut brush = Brush::default();
        brush.block(Vec3::new(-1.0, 0.0, 2.0), Vec3::new(1.0, 3.0, 2.5), STONE);
        assert!((assert_closed(&brush.mesh, "block") - 3.0).abs() < 1e-4);
        for to in [Vec3::new(0.0, 2.0, 0.0), Vec3::X * 2.0, Vec3::new(0.0, -1.2, 1.6)] {
            let mut brush = Brush::default();
            brush.bar(Vec3::ZERO, to, 0.1, STONE);
            // A regular triangle with a circumscribed radius r has the area 3/4·√3·r².
            assert!((assert_closed(&brush.mesh, "bar") - 0.025_98).abs() < 1e-4);
        }
        let mut brush = Brush::default();
        brush.drum(Vec3::Y, (1.0, 0.0), 3.0, 4, TILES);
        assert!((assert_closed(&brush.mesh, "pyramid") - 2.0).abs() < 1e-4);
        let mut brush = Brush::default();
        brush.drum(Vec3::Y, (1.0, 1.0), 3.0, 4, TILES);
        assert!((assert_closed(&brush.mesh, "drum") - 6.0).abs() < 1e-4);
    }

    #[test]
    fn a_strip_runs_along_the_first_edge() {
        let mut brush = Brush::default();
        let corners = [Vec3::ZERO, Vec3::X * 6.4, Vec3::new(6.4, 5.0, 0.0), Vec3::Y * 5.0];
        brush.strip_face(corners, TILES, 0.5);
        let uvs: Vec<Vec2> = brush.mesh.vertices.iter().map(|v| v.uv).collect();
        assert_eq!(uvs[0], TILES.at(0.0, 0.0));
        assert_eq!(uvs[2], TILES.at(6.4, 1.0));
        assert_eq!(brush.mesh.vertices[0].normal, Vec3::Z);
        assert_eq!(brush.mesh.vertices[0].shade, 0.5);
    }
}
