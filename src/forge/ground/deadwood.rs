//! Stumps and fallen logs: tubes of bark with cut faces that show their rings.

use bevy_math::{Vec2, Vec3};

use crate::forge::{
    mesh::{Lod, Material, Mesh, Model, Part, Variant, Vertex},
    plant::{
        skeleton::{Joint, Stem},
        tubes::{WoodDetail, skin, tube},
    },
    portable::{Dice, TURN, heading, mix, power, sin, sin_cos, smooth, srgb_code},
    texture::{
        bark::Bark,
        noise::octaves,
        picture::{Channels, Picture, quantised},
    },
};

const TILE: Vec2 = Vec2::new(0.8, 1.6);
const RINGS_SIDE: usize = 128;
/// Sides of the tubes and heights on the screen down to which the levels are meant.
const LEVELS: [(u32, f32); 3] = [(28, 0.25), (14, 0.08), (8, 0.0)];

/// A stump with roots, and a fallen log with stubs of boughs.
pub fn forge() -> Model {
    let mut model = Model::default();
    let [color, normal] = Bark::Oak.pictures();
    let bark = Material {
        base_picture: Some(model.add_picture(color)),
        normal_picture: Some(model.add_picture(normal)),
        ..Material::plain("bark", [1.0; 3])
    };
    let bark = model.add_material(bark);
    let cut = Material {
        base_picture: Some(model.add_picture(rings())),
        ..Material::plain("cut", [1.0; 3])
    };
    let cut = model.add_material(cut);
    let shapes: [(&str, fn(u32) -> [Mesh; 2]); 2] = [("stump", stump), ("log", log)];
    for (name, shape) in shapes {
        let lods = LEVELS.map(|(sides, screen_coverage)| {
            let [skin, faces] = shape(sides);
            Lod {
                parts: vec![
                    Part {
                        mesh: skin,
                        material: bark,
                    },
                    Part {
                        mesh: faces,
                        material: cut,
                    },
                ],
                screen_coverage,
            }
        });
        model.variants.push(Variant {
            name: name.into(),
            lods: lods.into(),
        });
    }
    model
}

fn empty() -> Mesh {
    Mesh {
        tangents: true,
        shades: true,
        ..Mesh::default()
    }
}

fn joints(points: impl Iterator<Item = (Vec3, f32)>) -> Vec<Joint> {
    points.map(|(at, radius)| Joint { at, radius }).collect()
}

/// Bark and cut face of a stump of half a metre.
fn stump(sides: u32) -> [Mesh; 2] {
    let steps = (sides / 3).max(3);
    let axis = joints((0..=steps).map(|step| {
        let height = mix(-0.3, 0.55, step as f32 / steps as f32);
        (Vec3::Y * height, 0.36 + 0.30 * power((0.55 - height) / 0.85, 3.0))
    }));
    let mut mesh = empty();
    let shade = |at: Vec3| mix(0.6, 1.0, smooth(-0.05, 0.25, at.y));
    tube(&mut mesh, &axis, sides, TILE, &shade);
    // Buttresses: the lower part is pushed out in five places.
    for vertex in &mut mesh.vertices {
        let flat = Vec2::new(vertex.position.x, vertex.position.z);
        let low = smooth(0.5, -0.1, vertex.position.y);
        let push = 1.0 + 0.28 * low * sin(5.0 * heading(flat) + 0.7) + 0.03 * sin(3.0 * heading(flat));
        vertex.position.x *= push;
        vertex.position.z *= push;
    }
    // The rim of the face is the last ring of the tube.
    let ring = mesh.vertices[mesh.vertices.len() - 1 - sides as usize..].to_vec();
    let mut faces = empty();
    face(&mut faces, &ring, Vec3::Y);
    [mesh, faces]
}

/// Bark and cut faces of a log of four and a half metres that lies along x.
fn log(sides: u32) -> [Mesh; 2] {
    let steps = (sides / 2).max(4);
    let mut dice = Dice::new(111);
    let bend: Vec<f32> = (0..3).map(|_| dice.between(0.0, TURN)).collect();
    let axis = joints((0..=steps).map(|step| {
        let share = step as f32 / steps as f32;
        let sway = Vec3::new(
            0.0,
            0.03 * sin(4.0 * share + bend[0]),
            0.10 * sin(3.0 * share + bend[1]),
        );
        let radius = mix(0.30, 0.21, share) * (1.0 + 0.04 * sin(11.0 * share + bend[2]));
        (Vec3::new(mix(-2.25, 2.25, share), radius * 0.85, 0.0) + sway, radius)
    }));
    let shade = |at: Vec3| mix(0.55, 1.0, smooth(0.0, 0.3, at.y));
    let mut mesh = empty();
    tube(&mut mesh, &axis, sides, TILE, &shade);
    let count = mesh.vertices.len();
    let mut faces = empty();
    let mut first = mesh.vertices[..=sides as usize].to_vec();
    first.reverse();
    face(&mut faces, &first, Vec3::NEG_X);
    face(&mut faces, &mesh.vertices[count - 1 - sides as usize..], Vec3::X);
    for vertex in &mut mesh.vertices {
        // Darker where it touches the ground.
        vertex.shade = shade(vertex.position);
    }
    let stubs: Vec<Stem> = [
        (0.25, 1.1, 0.42),
        (0.48, 2.4, 0.30),
        (0.66, 0.6, 0.55),
        (0.85, 1.9, 0.35),
    ]
    .into_iter()
    .map(|(share, around, length)| stub(&axis, share, around, length))
    .collect();
    let detail = WoodDetail {
        sides: sides as f32 * 0.6,
        reference: 0.2,
        thinnest: 0.0,
        tolerance: 0.0,
    };
    mesh.append(&skin(&stubs, &detail, TILE, &shade));
    [mesh, faces]
}

/// A broken bough on the upper side of a log.
fn stub(axis: &[Joint], share: f32, around: f32, length: f32) -> Stem {
    let place = share * (axis.len() - 1) as f32;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..length")]
    let foot = axis[(place as usize).min(axis.len() - 1)];
    let (sin, cos) = sin_cos(around);
    let outward = Vec3::new(0.45, sin, cos).normalize();
    let joint = |along: f32, radius: f32| Joint {
        at: foot.at + outward * along,
        radius,
    };
    Stem {
        level: 1,
        joints: vec![
            joint(foot.radius * 0.5, 0.075),
            joint(foot.radius + 0.4 * length, 0.05),
            joint(foot.radius + length, 0.012),
        ],
    }
}

/// A flat face inside a ring of vertices (counter-clockwise seen from the tip of `normal`, the last one at the first).
fn face(mesh: &mut Mesh, ring: &[Vertex], normal: Vec3) {
    let Some((last, rim)) = ring.split_last() else { return };
    let center = rim.iter().map(|v| v.position).sum::<Vec3>() / rim.len().max(1) as f32;
    let tangent = (last.position - center).normalize_or(Vec3::X);
    let tangent = (tangent - normal * tangent.dot(normal)).normalize_or(Vec3::X);
    let over = normal.cross(tangent);
    let radius = rim.iter().map(|v| v.position.distance(center)).fold(1e-3, f32::max);
    let mut put = |position: Vec3| {
        let from = (position - center) / radius;
        mesh.push(Vertex {
            position,
            normal,
            uv: Vec2::new(0.5 + 0.49 * from.dot(tangent), 0.5 - 0.49 * from.dot(over)),
            tangent,
            shade: 1.0,
        })
    };
    let middle = put(center);
    let corners: Vec<u32> = rim.iter().map(|v| put(v.position)).collect();
    for (i, corner) in corners.iter().enumerate() {
        let next = corners[(i + 1) % corners.len()];
        mesh.indices.extend([middle, *corner, next]);
    }
}

/// End grain: rings, rays and cracks.
fn rings() -> Picture {
    Picture::from_fn("rings", RINGS_SIDE, RINGS_SIDE, Channels::Rgb, |x, y| {
        let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / RINGS_SIDE as f32;
        let from = p - 0.5;
        let angle = heading(from);
        let wobble = 0.02 * octaves(121, p, (4, 4), 3);
        let radius = from.length() + wobble;
        let ring = 0.5 + 0.5 * sin(radius * TURN * 26.0);
        let crack = smooth(0.93, 0.99, sin(angle * 3.0 + 8.0 * wobble)) * smooth(0.02, 0.3, radius);
        let bark = smooth(0.455, 0.475, radius);
        let heart = smooth(0.36, 0.26, radius);
        let wood = Vec3::new(0.36, 0.25, 0.14).lerp(Vec3::new(0.24, 0.14, 0.07), 0.45 * ring + 0.4 * heart);
        let gray = wood.lerp(Vec3::new(0.20, 0.185, 0.165), 0.35 + 0.5 * octaves(122, p, (5, 5), 3));
        let color = gray.lerp(Vec3::new(0.035, 0.026, 0.02), (0.85 * crack).max(bark));
        let [r, g, b] = color.to_array().map(|c| quantised(f32::from(srgb_code(c)) / 255.0, 52));
        [r, g, b, 255]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cut_faces_look_outward_and_close_their_tubes() {
        for (sides, _) in LEVELS {
            for (shape, wanted) in [
                (stump as fn(u32) -> [Mesh; 2], vec![Vec3::Y]),
                (log, vec![Vec3::NEG_X, Vec3::X]),
            ] {
                let [_, faces] = shape(sides);
                assert_eq!(faces.triangle_count(), sides as usize * wanted.len());
                for corners in faces.indices.chunks(3) {
                    let [a, b, c] = [0, 1, 2].map(|i| faces.vertices[corners[i] as usize]);
                    let normal = (b.position - a.position).cross(c.position - a.position).normalize();
                    assert!(normal.dot(a.normal) > 0.9, "{normal} against {}", a.normal);
                    assert!(wanted.contains(&a.normal));
                }
            }
        }
    }
}
