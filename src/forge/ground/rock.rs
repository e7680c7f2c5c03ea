//! Rocks: icospheres cut by planes and roughened, with creases kept sharp.

use std::collections::BTreeMap;

use bevy_math::{Vec2, Vec3};

use crate::forge::{
    mesh::{Lod, Material, Mesh, Model, Part, Variant, Vertex},
    portable::{Dice, mix, smooth, srgb_code},
    texture::{
        bark::normal_code,
        noise::{cells, octaves},
        picture::{Channels, Picture, quantised},
    },
};

/// Faces that meet at a greater angle keep a crease: its cosine.
const CREASE: f32 = 0.80;
/// Size of the picture as a share of a rock's length.
const TILE: f32 = 0.7;
const SIDE: usize = 256;

/// Three rocks: a stone, a block, a boulder.
pub fn forge() -> Model {
    let mut model = Model::default();
    let [color, normal] = pictures();
    let stone = Material {
        base_picture: Some(model.add_picture(color)),
        normal_picture: Some(model.add_picture(normal)),
        ..Material::plain("rock", [1.0; 3])
    };
    let material = model.add_material(stone);
    for (name, seed, size) in [
        ("rock_small", 101, Vec3::new(0.34, 0.24, 0.28)),
        ("rock_medium", 102, Vec3::new(0.85, 0.62, 0.70)),
        ("rock_large", 103, Vec3::new(2.1, 1.5, 1.7)),
    ] {
        let lods = [(3, 0.25), (2, 0.08), (1, 0.0)].map(|(steps, screen_coverage)| Lod {
            parts: vec![Part {
                mesh: rock(seed, size, steps),
                material,
            }],
            screen_coverage,
        });
        model.variants.push(Variant {
            name: name.into(),
            lods: lods.into(),
        });
    }
    model
}

/// One rock with 20 · 4^`steps` triangles; `size` is half its extent in metres. A third of it is below the ground.
fn rock(seed: u64, size: Vec3, steps: u32) -> Mesh {
    let mut dice = Dice::new(seed);
    let planes: Vec<(Vec3, f32)> = (0..15)
        .map(|_| (dice.in_ball().normalize_or(Vec3::Y), dice.between(0.62, 0.92)))
        .collect();
    let (directions, faces) = icosphere(steps);
    let cut = |direction: Vec3| {
        planes
            .iter()
            .map(|(normal, distance)| (normal.dot(direction), distance, *normal))
            .filter(|(facing, ..)| *facing > 0.05)
            .map(|(facing, distance, normal)| (distance / facing, normal))
            .fold(
                (1.0, direction),
                |nearest, found| if found.0 < nearest.0 { found } else { nearest },
            )
    };
    let points: Vec<Vec3> = directions
        .iter()
        .map(|direction| {
            let rough = 0.05 * noise(seed, *direction * 3.0) + 0.022 * noise(seed + 1, *direction * 9.0);
            *direction * (cut(*direction).0 + rough) * size + Vec3::Y * (size.y * 0.30)
        })
        .collect();
    // A cut's faces show the picture from one side, so that its seams are at the edges of the cut.
    let sides: Vec<Vec3> = faces
        .iter()
        .map(|[a, b, c]| cut((directions[*a] + directions[*b] + directions[*c]).normalize()).1)
        .collect();
    let shade = |p: Vec3| mix(0.6, 1.0, smooth(0.0, 0.45 * size.y, p.y));
    creased(&points, &faces, &sides, TILE * 2.0 * size.x, &shade)
}

/// Unit vectors and triangles of a subdivided icosahedron.
fn icosphere(steps: u32) -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
    let mut points: Vec<Vec3> = Vec::new();
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        points.push(Vec3::new(a, b, 0.0));
    }
    for (a, b) in [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)] {
        points.push(Vec3::new(0.0, a, b));
    }
    for (a, b) in [(golden, -1.0), (golden, 1.0), (-golden, -1.0), (-golden, 1.0)] {
        points.push(Vec3::new(a, 0.0, b));
    }
    let mut points: Vec<Vec3> = points.into_iter().map(Vec3::normalize).collect();
    let mut faces: Vec<[usize; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..steps {
        let mut middles = BTreeMap::new();
        let mut finer = Vec::with_capacity(faces.len() * 4);
        for [a, b, c] in faces {
            let mut middle = |from: usize, to: usize| {
                *middles.entry((from.min(to), from.max(to))).or_insert_with(|| {
                    points.push((points[from] + points[to]).normalize());
                    points.len() - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        faces = finer;
    }
    (points, faces)
}

/// Triangles with smooth normals, except over creases. The picture, `tile` metres wide, is projected on each triangle
/// along the axis that is nearest to its direction in `sides`.
fn creased(points: &[Vec3], faces: &[[usize; 3]], sides: &[Vec3], tile: f32, shade: &dyn Fn(Vec3) -> f32) -> Mesh {
    let face_normals: Vec<Vec3> = faces
        .iter()
        .map(|[a, b, c]| {
            (points[*b] - points[*a])
                .cross(points[*c] - points[*a])
                .normalize_or(Vec3::Y)
        })
        .collect();
    let mut around: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    for (face, corners) in faces.iter().enumerate() {
        for corner in corners {
            around[*corner].push(face);
        }
    }
    let mut mesh = Mesh {
        tangents: true,
        shades: true,
        ..Mesh::default()
    };
    let mut known = BTreeMap::new();
    for (face, corners) in faces.iter().enumerate() {
        let own = face_normals[face];
        // Which way the picture is projected, and on which side.
        let side = sides[face];
        let size = side.abs();
        let axis = if size.y >= size.x && size.y >= size.z {
            1
        } else if size.x >= size.z {
            0
        } else {
            2
        };
        let (right, up) = projection(axis, side[axis] >= 0.0);
        for corner in corners {
            let normal = around[*corner]
                .iter()
                .map(|other| face_normals[*other])
                .filter(|other| other.dot(own) > CREASE)
                .sum::<Vec3>()
                .normalize_or(own);
            let key = (*corner, axis, side[axis] >= 0.0, normal.to_array().map(f32::to_bits));
            let index = *known.entry(key).or_insert_with(|| {
                let p = points[*corner];
                mesh.push(Vertex {
                    position: p,
                    normal,
                    uv: Vec2::new(p.dot(right), -p.dot(up)) / tile,
                    tangent: (right - normal * normal.dot(right)).normalize_or(right),
                    shade: shade(p),
                })
            });
            mesh.indices.push(index);
        }
    }
    mesh
}

/// Right and up of the picture on faces whose normals are nearest to an axis (0 x, 1 y, 2 z): never mirrored.
fn projection(axis: usize, positive: bool) -> (Vec3, Vec3) {
    let sign = if positive { 1.0 } else { -1.0 };
    match axis {
        0 => (Vec3::NEG_Z * sign, Vec3::Y),
        1 => (Vec3::X, Vec3::NEG_Z * sign),
        _ => (Vec3::X * sign, Vec3::Y),
    }
}

/// Value noise in space, −1..=1, smooth.
fn noise(seed: u64, p: Vec3) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let s = f * f * (Vec3::splat(3.0) - 2.0 * f);
    let value = |dx: f32, dy: f32, dz: f32| {
        let corner = cell + Vec3::new(dx, dy, dz);
        let [x, y, z] = corner.to_array().map(|c| c as i64 as u64);
        let mut h = seed ^ x.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        h ^= z.wrapping_mul(0x1656_67b1_9e37_79f9);
        h = (h ^ (h >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        h = (h ^ (h >> 32)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (h >> 40) as f32 / (1 << 24) as f32 * 2.0 - 1.0
    };
    let along_x = |dy: f32, dz: f32| mix(value(0.0, dy, dz), value(1.0, dy, dz), s.x);
    let along_y = |dz: f32| mix(along_x(0.0, dz), along_x(1.0, dz), s.y);
    mix(along_y(0.0), along_y(1.0), s.z)
}

/// Colour and normals of a tile of granite with cracks and lichen.
fn pictures() -> [Picture; 2] {
    let place = |x: usize, y: usize| {
        let p = Vec2::new((x % SIDE) as f32 / SIDE as f32, (y % SIDE) as f32 / SIDE as f32);
        let wander = Vec2::new(octaves(3, p, (4, 4), 3), octaves(4, p, (4, 4), 3));
        let grain = octaves(5, p, (40, 40), 2);
        let patch = octaves(6, p, (3, 3), 4);
        let joint = cells(7, p + 0.16 * wander, (2, 2));
        let crack = smooth(0.045, 0.01, joint.second - joint.nearest + 0.12 * grain.abs()) * smooth(-0.05, 0.12, patch);
        let speckle = cells(8, p, (48, 48)).id;
        let height = 0.5 + 0.6 * patch + 0.35 * grain - 0.5 * crack;
        let gray = Vec3::new(0.052, 0.050, 0.047).lerp(
            Vec3::new(0.30, 0.29, 0.275),
            (0.42 + 0.7 * patch + 0.35 * grain + 0.2 * (speckle - 0.5)).clamp(0.0, 1.0),
        );
        let lichen = smooth(0.10, 0.30, octaves(9, p + 0.05 * wander, (5, 5), 4));
        let color = gray.lerp(Vec3::new(0.16, 0.17, 0.075), 0.7 * lichen) * (1.0 - 0.6 * crack);
        (height, color)
    };
    let color = Picture::from_fn("rock", SIDE, SIDE, Channels::Rgb, |x, y| {
        let [r, g, b] = place(x, y)
            .1
            .to_array()
            .map(|c| quantised(f32::from(srgb_code(c)) / 255.0, 52));
        [r, g, b, 255]
    });
    let heights: Vec<f32> = (0..SIDE * SIDE).map(|i| place(i % SIDE, i / SIDE).0).collect();
    let high = |x: usize, y: usize| heights[(y % SIDE) * SIDE + x % SIDE];
    let normal = Picture::from_fn("rock_normal", SIDE, SIDE, Channels::Rgb, |x, y| {
        let across = high(x + 1, y) - high(x + SIDE - 1, y);
        let down = high(x, y + 1) - high(x, y + SIDE - 1);
        normal_code(Vec3::new(-across * 3.0, down * 3.0, 1.0).normalize())
    });
    [color, normal]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_icosphere_is_closed_and_turns_outward() {
        let (points, faces) = icosphere(2);
        assert_eq!((points.len(), faces.len()), (162, 320), "Euler: V = F / 2 + 2");
        let mut area = 0.0;
        for [a, b, c] in &faces {
            let normal = (points[*b] - points[*a]).cross(points[*c] - points[*a]);
            assert!(normal.dot(points[*a]) > 0.0);
            area += 0.5 * normal.length();
        }
        assert!((area / 12.566 - 1.0).abs() < 0.03, "{area}");
    }

    #[test]
    fn a_cube_keeps_its_edges() {
        let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let points: Vec<Vec3> = (0..8).map(corner).collect();
        let quads = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        let faces: Vec<[usize; 3]> = quads
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect();
        let sides: Vec<Vec3> = faces
            .iter()
            .map(|[a, b, c]| (points[*b] - points[*a]).cross(points[*c] - points[*a]))
            .collect();
        let mesh = creased(&points, &faces, &sides, 1.0, &|_| 1.0);
        assert_eq!(mesh.vertices.len(), 24, "four per side");
        for vertex in &mesh.vertices {
            assert_eq!(vertex.normal.abs().max_element(), 1.0);
            assert!(vertex.tangent.dot(vertex.normal).abs() < 1e-6);
        }
        for corners in mesh.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|i| mesh.vertices[corners[i] as usize]);
            let (du, dv) = (b.uv - a.uv, c.uv - a.uv);
            assert!(
                du.x * dv.y - du.y * dv.x < 0.0,
                "v grows downward: seen from outside, pictures are not mirrored"
            );
        }
    }
}
