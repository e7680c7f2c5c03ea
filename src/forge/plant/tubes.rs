//! Skin on stems: tubes whose sides and joints follow from a level of detail.

use bevy_math::{Vec2, Vec3};

use super::skeleton::{Joint, Stem};
use crate::forge::{
    mesh::{Mesh, Vertex},
    portable::{TURN, any_normal, sin_cos},
};

/// How finely stems are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WoodDetail {
    /// Sides of a tube of [`WoodDetail::reference`]; thinner ones have fewer, at least three.
    pub sides: f32,
    /// Radius of a thick trunk, in metres.
    pub reference: f32,
    /// Stems whose base is thinner are left out, in metres.
    pub thinnest: f32,
    /// How far the axis may be off where joints are left out, in metres.
    pub tolerance: f32,
}

impl WoodDetail {
    /// The same for a plant of another size.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        Self {
            sides: self.sides,
            reference: self.reference * factor,
            thinnest: self.thinnest * factor,
            tolerance: self.tolerance * factor,
        }
    }
}

/// Tubes around stems. `tile` is the size of the bark's picture in metres, across and along; `shade` gives the vertex
/// colours.
pub fn skin(stems: &[Stem], detail: &WoodDetail, tile: Vec2, shade: &dyn Fn(Vec3) -> f32) -> Mesh {
    let mut mesh = Mesh {
        tangents: true,
        shades: true,
        ..Mesh::default()
    };
    for stem in stems.iter().filter(|stem| stem.base_radius() >= detail.thinnest) {
        let joints = simplified(&stem.joints, detail.tolerance);
        tube(&mut mesh, &joints, sides(stem.base_radius(), detail), tile, shade);
    }
    mesh
}

/// Sides of a tube: with the square root of its radius.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 3..=32"
)]
fn sides(radius: f32, detail: &WoodDetail) -> u32 {
    (detail.sides * (radius / detail.reference).sqrt() + 0.5).clamp(3.0, 32.0) as u32
}

/// How much more a wrong radius counts than a wrong place: outlines of trunks show it.
const RADIUS_WEIGHT: f32 = 2.5;

/// Joints without those that are near to the line between their neighbours (Ramer 1972, Douglas and Peucker 1973); radii
/// count too.
pub fn simplified(joints: &[Joint], tolerance: f32) -> Vec<Joint> {
    let mut kept = vec![false; joints.len()];
    if let Some(last) = kept.len().checked_sub(1) {
        kept[0] = true;
        kept[last] = true;
        split(joints, 0, last, tolerance, &mut kept);
    }
    joints
        .iter()
        .zip(kept)
        .filter(|(_, kept)| *kept)
        .map(|(joint, _)| *joint)
        .collect()
}

fn split(joints: &[Joint], from: usize, to: usize, tolerance: f32, kept: &mut [bool]) {
    let (a, b) = (joints[from], joints[to]);
    let along = b.at - a.at;
    let mut worst = (0.0, from);
    for (i, joint) in joints.iter().enumerate().take(to).skip(from + 1) {
        let t = ((joint.at - a.at).dot(along) / along.length_squared().max(1e-9)).clamp(0.0, 1.0);
        let off_axis = joint.at.distance(a.at + along * t);
        let off_radius = (joint.radius - (a.radius + (b.radius - a.radius) * t)).abs();
        let off = off_axis.max(off_radius * RADIUS_WEIGHT);
        if off > worst.0 {
            worst = (off, i);
        }
    }
    if worst.0 > tolerance {
        kept[worst.1] = true;
        split(joints, from, worst.1, tolerance, kept);
        split(joints, worst.1, to, tolerance, kept);
    }
}

/// Adds one tube along joints; open at the base, closed by a point at the tip.
pub fn tube(mesh: &mut Mesh, joints: &[Joint], sides: u32, tile: Vec2, shade: &dyn Fn(Vec3) -> f32) {
    let Some(base) = joints.first() else { return };
    let repeats = (TURN * base.radius / tile.x).round().max(1.0);
    let mut side = any_normal(direction(joints, 0));
    let mut length = 0.0;
    let mut before: Option<u32> = None;
    for (i, joint) in joints.iter().enumerate() {
        let forward = direction(joints, i);
        // The frame is carried along without twist (parallel transport by projection).
        side = (side - forward * side.dot(forward)).normalize_or(any_normal(forward));
        let over = forward.cross(side);
        if i > 0 {
            length += joint.at.distance(joints[i - 1].at);
        }
        let slope = slope(joints, i);
        let first = u32::try_from(mesh.vertices.len()).unwrap_or(u32::MAX);
        for corner in 0..=sides {
            let share = corner as f32 / sides as f32;
            // The seam's two vertices are at the very same place.
            let (sin, cos) = sin_cos(TURN * (corner % sides) as f32 / sides as f32);
            // `over` is forward × side: growing angles turn counter-clockwise about the axis, to the right from outside.
            let outward = side * cos + over * sin;
            let tangent = over * cos - side * sin;
            mesh.push(Vertex {
                position: joint.at + outward * joint.radius,
                normal: (outward - forward * slope).normalize(),
                uv: Vec2::new(share * repeats, -length / tile.y),
                tangent,
                shade: shade(joint.at),
            });
        }
        if let Some(before) = before {
            for corner in 0..sides {
                mesh.push_quad([before + corner, before + corner + 1, first + corner + 1, first + corner]);
            }
        }
        before = Some(first);
    }
}

/// Direction of the axis at a joint: the mean of its two segments.
fn direction(joints: &[Joint], i: usize) -> Vec3 {
    let before = joints[i.saturating_sub(1)].at;
    let after = joints[(i + 1).min(joints.len() - 1)].at;
    (after - before).normalize_or(Vec3::Y)
}

/// Growth of the radius per metre of axis at a joint.
fn slope(joints: &[Joint], i: usize) -> f32 {
    let before = joints[i.saturating_sub(1)];
    let after = joints[(i + 1).min(joints.len() - 1)];
    let length = after.at.distance(before.at);
    if length > 1e-6 {
        (after.radius - before.radius) / length
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pole() -> Vec<Joint> {
        (0..=4)
            .map(|i| Joint {
                at: Vec3::Y * i as f32,
                radius: 0.2,
            })
            .collect()
    }

    #[test]
    fn a_straight_pole_needs_two_joints() {
        assert_eq!(simplified(&pole(), 0.01).len(), 2);
        let mut bent = pole();
        for (joint, x) in bent.iter_mut().zip([0.0, 0.15, 0.3, 0.15, 0.0]) {
            joint.at.x = x;
        }
        assert_eq!(simplified(&bent, 0.01).len(), 3, "both halves are straight");
        assert_eq!(simplified(&bent, 0.31).len(), 2, "coarse enough");
        bent[1].radius = 0.3;
        assert_eq!(simplified(&bent, 0.05).len(), 4, "radii count too");
    }

    #[test]
    fn a_tube_faces_outward_and_its_picture_is_not_mirrored() {
        let mut mesh = Mesh::default();
        tube(&mut mesh, &pole(), 8, Vec2::new(0.6, 0.5), &|_| 1.0);
        assert_eq!((mesh.vertices.len(), mesh.triangle_count()), (5 * 9, 4 * 8 * 2));
        for corners in mesh.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|i| mesh.vertices[corners[i] as usize]);
            let face = (b.position - a.position).cross(c.position - a.position).normalize();
            assert!(face.dot(a.normal) > 0.9, "{face} against {}", a.normal);
            // u grows along the tangent, v against normal × tangent.
            let (du, dv) = (b.uv - a.uv, c.uv - a.uv);
            let area = du.x * dv.y - du.y * dv.x;
            let tangent = ((b.position - a.position) * dv.y - (c.position - a.position) * du.y) / area;
            let down = ((c.position - a.position) * du.x - (b.position - a.position) * dv.x) / area;
            assert!(tangent.normalize().dot(a.tangent) > 0.9);
            assert!(down.normalize().dot(a.normal.cross(a.tangent)) < -0.9);
        }
        // 2 π 0.2 m are two pictures of 0.6 m; 4 m are eight of 0.5 m.
        assert_eq!(mesh.vertices[44].uv, Vec2::new(2.0, -8.0));
    }
}
