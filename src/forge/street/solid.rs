//! Solids of made things: boxes with chamfered edges, turned and swept profiles, angle sections, hulls.
//!
//! A [`Solid`] is a heap of faces in groups. Within a group normals are smoothed over edges flatter than the group's
//! crease; between groups never. Faces have one swatch of the palette, or a piece of a picture.

use std::collections::BTreeMap;

use bevy_math::{Vec2, Vec3};

use crate::forge::{
    mesh::{Mesh, Vertex},
    portable::{TURN, any_normal, sin_cos, turn},
};

/// Cosine of the angle between faces up to which an edge is rounded: 40 degrees.
const ROUND: f32 = 0.766;

/// Corners, counter-clockwise seen from outside, with texture coordinates.
#[derive(Clone, Debug)]
struct Face {
    corners: Vec<(Vec3, Vec2)>,
    group: u32,
    /// Cosine of the angle to a neighbour up to which the edge between them is rounded.
    crease: f32,
}

/// A heap of faces.
#[derive(Clone, Debug)]
pub(super) struct Solid {
    faces: Vec<Face>,
    group: u32,
    swatch: Vec2,
    crease: f32,
}

impl Default for Solid {
    fn default() -> Self {
        Self {
            faces: Vec::new(),
            group: 0,
            swatch: Vec2::ZERO,
            crease: ROUND,
        }
    }
}

impl Solid {
    /// Nothing yet.
    pub(super) fn new() -> Self {
        Self::default()
    }

    /// Paints what follows with a place of the palette.
    pub(super) fn paint(&mut self, swatch: Vec2) -> &mut Self {
        self.swatch = swatch;
        self
    }

    /// Begins a group: what follows has edges of its own.
    pub(super) fn apart(&mut self) -> &mut Self {
        self.group += 1;
        self
    }

    /// Rounds all edges of what follows: thin members get by with half the vertices.
    pub(super) fn soft(&mut self) -> &mut Self {
        self.crease = -1.0;
        self
    }

    /// Keeps the edges of what follows that are sharper than 40 degrees.
    pub(super) fn sharp(&mut self) -> &mut Self {
        self.crease = ROUND;
        self
    }

    /// A flat face: corners counter-clockwise seen from outside.
    pub(super) fn face(&mut self, corners: &[Vec3]) {
        let corners = corners.iter().map(|corner| (*corner, self.swatch)).collect();
        self.faces.push(Face {
            corners,
            group: self.group,
            crease: self.crease,
        });
    }

    /// A rectangle with a piece of a picture: corners counter-clockwise from the lower left, `low` and `high` are the
    /// picture's lower left and upper right coordinates there.
    pub(super) fn picture(&mut self, corners: [Vec3; 4], low: Vec2, high: Vec2) {
        self.apart();
        let uvs = [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)];
        let corners = corners.into_iter().zip(uvs).collect();
        self.faces.push(Face {
            corners,
            group: self.group,
            crease: self.crease,
        });
    }

    /// A box without chamfers.
    pub(super) fn block(&mut self, center: Vec3, size: Vec3) {
        self.beam(
            center - Vec3::Y * (0.5 * size.y),
            center + Vec3::Y * (0.5 * size.y),
            Vec2::new(size.x, size.z),
            Vec3::X,
        );
    }

    /// A box whose edges are cut by `chamfer` metres and shaded round.
    pub(super) fn rounded(&mut self, center: Vec3, size: Vec3, chamfer: f32) {
        self.apart();
        let half = 0.5 * size;
        let cut = chamfer.min(half.min_element() * 0.9);
        let corner = |signs: Vec3, axis: usize| {
            let mut p = signs * (half - cut);
            p[axis] = signs[axis] * half[axis];
            center + p
        };
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [-1.0, 1.0] {
                let at = |a: f32, b: f32| {
                    let mut signs = Vec3::splat(side);
                    signs[next] = a * side;
                    signs[last] = b;
                    corner(signs, axis)
                };
                self.face(&[at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]);
            }
            // Edges along this axis.
            for (a, b) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let at = |along: f32, axis_of: usize| {
                    let mut signs = Vec3::ONE;
                    signs[axis] = along;
                    signs[next] = a;
                    signs[last] = b;
                    corner(signs, axis_of)
                };
                let mut edge = [at(-1.0, next), at(-1.0, last), at(1.0, last), at(1.0, next)];
                if a * b < 0.0 {
                    edge.reverse();
                }
                self.face(&edge);
            }
        }
        for i in 0..8 {
            let sign = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let signs = Vec3::new(sign(0), sign(1), sign(2));
            let mut cap = [0, 1, 2].map(|axis| corner(signs, axis));
            if signs.x * signs.y * signs.z < 0.0 {
                cap.reverse();
            }
            self.face(&cap);
        }
    }

    /// A bar of rectangular section: `section` is its width across `side` and at right angles to it, in metres.
    pub(super) fn beam(&mut self, from: Vec3, to: Vec3, section: Vec2, side: Vec3) {
        let along = (to - from).normalize_or(Vec3::Y);
        let right = (side - along * side.dot(along)).normalize_or(any_normal(along)) * (0.5 * section.x);
        let up = right.cross(along).normalize_or(Vec3::X) * (0.5 * section.y);
        let ring = [right + up, right - up, -right - up, -right + up];
        self.apart();
        self.prism(&ring.map(|p| from + p), &ring.map(|p| to + p));
    }

    /// The closed solid between two equal rings; rings turn clockwise seen along the way from the first to the second.
    pub(super) fn prism(&mut self, first: &[Vec3], second: &[Vec3]) {
        let count = first.len();
        for i in 0..count {
            let j = (i + 1) % count;
            self.face(&[first[i], first[j], second[j], second[i]]);
        }
        let mut foot = first.to_vec();
        foot.reverse();
        self.face(&foot);
        self.face(second);
    }

    /// A round bar along points with their radii; it ends in a point where the radius is 0.
    pub(super) fn tube(&mut self, points: &[(Vec3, f32)], sides: u32) {
        let ends = self.swatch;
        self.sawn(points, sides, ends);
    }

    /// The same with ends of another colour.
    pub(super) fn sawn(&mut self, points: &[(Vec3, f32)], sides: u32, ends: Vec2) {
        self.apart();
        let mut right = Vec3::ZERO;
        let mut rings: Vec<Vec<Vec3>> = Vec::with_capacity(points.len());
        for (i, (at, radius)) in points.iter().enumerate() {
            let before = points[i.saturating_sub(1)].0;
            let after = points[(i + 1).min(points.len() - 1)].0;
            let along = (after - before).normalize_or(Vec3::Y);
            let start = if i == 0 { any_normal(along) } else { right };
            right = (start - along * start.dot(along)).normalize_or(any_normal(along));
            let ring = (0..sides).map(|k| *at + turn(right, along, TURN * k as f32 / sides as f32) * *radius);
            rings.push(ring.collect());
        }
        self.skin(&rings);
        self.paint(ends).lids(&rings);
    }

    /// A thin three-sided bar without ends, for what is seen from far away.
    pub(super) fn tube_open(&mut self, from: Vec3, to: Vec3, radius: f32) {
        self.apart();
        let along = (to - from).normalize_or(Vec3::Y);
        let right = any_normal(along);
        let ring = |at: Vec3| -> Vec<Vec3> {
            (0..3)
                .map(|k| at + turn(right, along, TURN * k as f32 / 3.0) * radius)
                .collect()
        };
        self.skin(&[ring(from), ring(to)]);
    }

    /// A profile turned about the upright axis through `foot`: radii and heights from below to above, metres. Lids close
    /// the ends that have a radius.
    pub(super) fn turned(&mut self, foot: Vec3, profile: &[(f32, f32)], sides: u32) {
        self.apart();
        let rings: Vec<Vec<Vec3>> = profile
            .iter()
            .map(|(radius, height)| {
                let point = |k: u32| {
                    let (sin, cos) = sin_cos(TURN * k as f32 / sides as f32);
                    foot + Vec3::new(radius * sin, *height, radius * cos)
                };
                (0..sides).map(point).collect()
            })
            .collect();
        self.skin(&rings);
        self.lids(&rings);
    }

    /// Faces between closed rings that turn counter-clockwise seen from their far end.
    fn skin(&mut self, rings: &[Vec<Vec3>]) {
        for pair in rings.windows(2) {
            let count = pair[0].len();
            for i in 0..count {
                let j = (i + 1) % count;
                self.quad([pair[0][i], pair[0][j], pair[1][j], pair[1][i]]);
            }
        }
    }

    fn lids(&mut self, rings: &[Vec<Vec3>]) {
        let [Some(first), Some(last)] = [rings.first(), rings.last()] else {
            return;
        };
        let mut foot = first.clone();
        foot.reverse();
        for ring in [foot, last.clone()] {
            if ring[0].distance(ring[1]) > 1e-5 {
                self.face(&ring);
            }
        }
    }

    /// Two triangles, or one where corners coincide; none without area.
    pub(super) fn quad(&mut self, corners: [Vec3; 4]) {
        let mut distinct: Vec<Vec3> = Vec::with_capacity(4);
        for corner in corners {
            if distinct.iter().all(|other| other.distance(corner) > 1e-5) {
                distinct.push(corner);
            }
        }
        if distinct.len() > 2 {
            self.face(&distinct);
        }
    }

    /// A bar of angle section: two flanges of `width` metres, `thickness` thick, whose heel lies on the line between
    /// the points and which open towards `first` and `second`. Its ends are open: they sit in joints.
    pub(super) fn angle(&mut self, from: Vec3, to: Vec3, width: f32, thickness: f32, first: Vec3, second: Vec3) {
        let along = (to - from).normalize_or(Vec3::Y);
        let a = (first - along * first.dot(along)).normalize_or(any_normal(along));
        let b = along.cross(a);
        let b = if b.dot(second) < 0.0 { -b } else { b };
        let mut section = vec![
            Vec3::ZERO,
            a * width,
            a * width + b * thickness,
            (a + b) * thickness,
            b * width + a * thickness,
            b * width,
        ];
        if along.cross(a).dot(b) < 0.0 {
            section.reverse();
        }
        self.apart();
        for i in 0..section.len() {
            let (p, q) = (section[i], section[(i + 1) % section.len()]);
            self.face(&[from + p, from + q, to + q, to + p]);
        }
    }

    /// A surface over a grid of points; rows run so that the outside lies at row × column direction. `paint` gives the
    /// swatch of a cell by row and column; `None` leaves the cell out.
    pub(super) fn hull(&mut self, rows: &[Vec<Vec3>], paint: impl Fn(usize, usize) -> Option<Vec2>) {
        for (i, pair) in rows.windows(2).enumerate() {
            for j in 0..pair[0].len() - 1 {
                if let Some(swatch) = paint(i, j) {
                    self.swatch = swatch;
                    self.quad([pair[0][j], pair[1][j], pair[1][j + 1], pair[0][j + 1]]);
                }
            }
        }
    }

    /// Adds another solid, moved, turned about +y by `heading` radians and scaled.
    pub(super) fn add(&mut self, other: &Self, at: Vec3, heading: f32, scale: f32) {
        let first = self.group + 1;
        let place = |p: Vec3| at + turn(p, Vec3::Y, heading) * scale;
        for face in &other.faces {
            self.faces.push(Face {
                corners: face.corners.iter().map(|(p, uv)| (place(*p), *uv)).collect(),
                group: face.group + first,
                crease: face.crease,
            });
        }
        self.group = first + other.group + 1;
    }

    /// Number of triangles.
    pub(super) fn triangle_count(&self) -> usize {
        self.faces.iter().map(|face| face.corners.len().saturating_sub(2)).sum()
    }

    /// The triangles with their normals.
    pub(super) fn mesh(&self) -> Mesh {
        let key = |p: Vec3| p.to_array().map(|c| (c * 4096.0).round() as i64);
        let weighted: Vec<Vec3> = self.faces.iter().map(|face| area_normal(&face.corners)).collect();
        let mut around: BTreeMap<(u32, [i64; 3]), Vec<usize>> = BTreeMap::new();
        for (index, face) in self.faces.iter().enumerate() {
            for (p, _) in &face.corners {
                around.entry((face.group, key(*p))).or_default().push(index);
            }
        }
        let mut mesh = Mesh::default();
        let mut known = BTreeMap::new();
        for (face, own) in self.faces.iter().zip(&weighted) {
            let Some(straight) = own.try_normalize() else {
                continue;
            };
            let corners: Vec<u32> = face
                .corners
                .iter()
                .map(|(position, uv)| {
                    let near = &around[&(face.group, key(*position))];
                    let smooth = near.iter().map(|other| weighted[*other]);
                    let normal = smooth
                        .filter(|other| other.normalize_or_zero().dot(straight) >= face.crease)
                        .sum::<Vec3>()
                        .normalize_or(straight);
                    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
                    let same = (bits(*position), bits(normal), uv.to_array().map(f32::to_bits));
                    *known.entry(same).or_insert_with(|| {
                        mesh.push(Vertex {
                            position: *position,
                            normal,
                            uv: *uv,
                            tangent: any_normal(normal),
                            shade: 1.0,
                        })
                    })
                })
                .collect();
            for i in 1..corners.len() - 1 {
                mesh.indices.extend([corners[0], corners[i], corners[i + 1]]);
            }
        }
        mesh
    }
}

/// The normal of a flat face, twice its area long.
fn area_normal(corners: &[(Vec3, Vec2)]) -> Vec3 {
    let origin = corners[0].0;
    corners[1..]
        .windows(2)
        .map(|pair| (pair[0].0 - origin).cross(pair[1].0 - origin))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume by the divergence theorem: right only where all faces turn outward and the surface is closed.
    fn volume(solid: &Solid) -> f32 {
        let mesh = solid.mesh();
        let corner = |i: usize| mesh.vertices[mesh.indices[i] as usize].position;
        (0..mesh.triangle_count())
            .map(|t| corner(3 * t).dot(corner(3 * t + 1).cross(corner(3 * t + 2))) / 6.0)
            .sum()
    }

    #[test]
    fn boxes_and_beams_are_closed_and_turn_outward() {
        let mut solid = Solid::new();
        solid.block(Vec3::new(3.0, 4.0, 5.0), Vec3::new(1.0, 2.0, 0.5));
        assert!((volume(&solid) - 1.0).abs() < 1e-4, "{}", volume(&solid));
        let mut beam = Solid::new();
        beam.beam(Vec3::ZERO, Vec3::new(3.0, 0.0, 4.0), Vec2::new(0.1, 0.2), Vec3::Y);
        assert!((volume(&beam) - 0.1).abs() < 1e-4, "{}", volume(&beam));
    }

    #[test]
    fn chamfers_cut_their_volume_away() {
        let mut solid = Solid::new();
        solid.rounded(Vec3::new(1.0, 2.0, 3.0), Vec3::splat(1.0), 0.1);
        // 12 edges lose 0.1² / 2 · 0.8 each, 8 corners a cube of 0.1 but its tetrahedron: 5/6.
        let wanted = 1.0 - 12.0 * 0.005 * 0.8 - 8.0 * 0.001 * 5.0 / 6.0;
        assert!((volume(&solid) - wanted).abs() < 1e-4, "{} of {wanted}", volume(&solid));
        assert_eq!(solid.triangle_count(), 44);
    }

    #[test]
    fn turned_and_swept_profiles_are_closed() {
        let mut cone = Solid::new();
        cone.turned(Vec3::ZERO, &[(1.0, 0.0), (0.0, 3.0)], 64);
        assert!((volume(&cone) - 3.1416).abs() < 0.01, "{}", volume(&cone));
        let mut tube = Solid::new();
        tube.tube(&[(Vec3::ZERO, 0.5), (Vec3::X, 0.5), (Vec3::X * 2.0, 0.5)], 64);
        assert!((volume(&tube) - 1.5708).abs() < 0.01, "{}", volume(&tube));
    }

    #[test]
    fn angle_sections_open_the_way_they_are_told() {
        for (first, second) in [(Vec3::X, Vec3::Z), (Vec3::Z, Vec3::X), (Vec3::NEG_X, Vec3::Z)] {
            let mut solid = Solid::new();
            solid.angle(Vec3::ZERO, Vec3::Y, 0.1, 0.01, first, second);
            let mesh = solid.mesh();
            let (low, high) = mesh.bounds().expect("vertices");
            let reach = first + second;
            assert!((high + low - reach * 0.1 - Vec3::Y).length() < 1e-5, "{low} {high}");
            // Outer faces lie on the heel's side.
            let vertex = mesh
                .vertices
                .iter()
                .find(|v| v.normal.dot(first) < -0.99)
                .expect("a back");
            assert!(vertex.position.dot(first).abs() < 1e-6);
        }
    }

    #[test]
    fn added_solids_keep_their_volume_and_edges() {
        let mut one = Solid::new();
        one.block(Vec3::new(2.0, 0.0, 0.0), Vec3::ONE);
        let mut two = one.clone();
        two.add(&one, Vec3::ZERO, 1.0, 2.0);
        assert!((volume(&two) - 9.0).abs() < 1e-3, "{}", volume(&two));
        assert_eq!(two.mesh().vertices.len(), 48, "four per side");
    }

    #[test]
    fn soft_edges_share_their_corners() {
        let mut solid = Solid::new();
        solid.soft().block(Vec3::ZERO, Vec3::ONE);
        let mesh = solid.mesh();
        assert_eq!(mesh.vertices.len(), 8);
        for vertex in &mesh.vertices {
            assert!(vertex.normal.dot(vertex.position.normalize()) > 0.999);
        }
    }
}
