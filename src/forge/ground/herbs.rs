//! Ferns and grass: a few strips and cards on the ground.

use bevy_math::{Vec2, Vec3};

use crate::forge::{
    mesh::{Leaf, Lod, Material, Mesh, Model, Part, Variant, Vertex},
    portable::{Dice, TURN, mix, sin_cos, turn},
    texture::sprigs::{self, GRID, Sprig},
};

/// The golden angle in radians.
const GOLDEN: f32 = 2.399_963_2;
/// Heights on the screen down to which the levels are meant.
const COVERAGES: [f32; 3] = [0.18, 0.07, 0.0];

/// A strip that rises from the ground and bends over.
#[derive(Clone, Copy)]
struct Strip {
    /// Where it begins, in metres.
    foot: Vec3,
    /// Away from the middle, a level unit vector.
    outward: Vec3,
    /// Metres.
    length: f32,
    width: f32,
    /// Angle from straight up at the foot and at the tip, in radians.
    lean: (f32, f32),
    /// Pieces.
    segments: u32,
    /// Which of the painted cells it shows.
    cell: u32,
    /// Brightness.
    tone: f32,
}

fn strip(mesh: &mut Mesh, strip: &Strip) {
    let right = strip.outward.cross(Vec3::Y);
    let grid = GRID as u32;
    let (column, row) = (strip.cell % grid, strip.cell / grid % grid);
    let mut at = strip.foot;
    let mut before: Option<[u32; 2]> = None;
    for joint in 0..=strip.segments {
        let share = joint as f32 / strip.segments as f32;
        let (sin, cos) = sin_cos(mix(strip.lean.0, strip.lean.1, share));
        let along = strip.outward * sin + Vec3::Y * cos;
        if joint > 0 {
            at += along * (strip.length / strip.segments as f32);
        }
        // Leaves near the ground get light from above too: normals lean upward.
        let normal = (Vec3::Y * 1.2 + strip.outward * 0.3 + along.cross(right) * -0.4).normalize();
        let pair = [-0.5, 0.5].map(|across| {
            let u = (column as f32 + 0.5 + across) / grid as f32;
            let v = (row as f32 + 1.0 - share) / grid as f32;
            mesh.push(Vertex {
                position: at + right * (across * strip.width),
                normal,
                uv: Vec2::new(u, v),
                tangent: right,
                shade: strip.tone * mix(0.72, 1.0, share.min(0.5) * 2.0),
            })
        });
        if let Some([left, right]) = before {
            mesh.push_quad([left, right, pair[1], pair[0]]);
        }
        before = Some(pair);
    }
}

fn level(unit: f32) -> Vec3 {
    let (sin, cos) = sin_cos(TURN * unit);
    Vec3::new(cos, 0.0, sin)
}

fn material(model: &mut Model, name: &str, sprig: Sprig, seed: u64) -> usize {
    let [color, thickness] = sprigs::paint(sprig, name, seed);
    let (base_picture, thickness_picture) = (model.add_picture(color), model.add_picture(thickness));
    model.add_material(Material {
        base_picture: Some(base_picture),
        roughness: 0.7,
        cutoff: Some(0.5),
        double_sided: true,
        leaf: Some(Leaf {
            thickness: 0.000_2,
            thickness_picture: Some(thickness_picture),
            transmission: 0.45,
        }),
        ..Material::plain(name, [1.0; 3])
    })
}

fn variant(name: String, material: usize, meshes: [Mesh; 3]) -> Variant {
    let lods = meshes.into_iter().zip(COVERAGES).map(|(mesh, screen_coverage)| Lod {
        parts: vec![Part { mesh, material }],
        screen_coverage,
    });
    Variant {
        name,
        lods: lods.collect(),
    }
}

fn empty() -> Mesh {
    Mesh {
        shades: true,
        ..Mesh::default()
    }
}

/// Male fern: a funnel of fronds, two shapes.
pub fn fern() -> Model {
    let mut model = Model::default();
    let material = material(&mut model, "fern", Sprig::Frond, 81);
    for (letter, seed) in [('a', 81), ('b', 82)] {
        let meshes = [(13, 5), (9, 3), (5, 2)].map(|(fronds, segments)| {
            let mut dice = Dice::new(seed);
            let mut mesh = empty();
            let turned = dice.unit() * TURN;
            for number in 0..fronds {
                let outward = level((turned + GOLDEN * number as f32) / TURN);
                let inner = number as f32 / 13.0;
                let length = dice.between(0.62, 0.90) * mix(1.0, 0.75, inner);
                strip(
                    &mut mesh,
                    &Strip {
                        foot: outward * 0.03 - Vec3::Y * 0.03,
                        outward,
                        length,
                        width: length * 0.52 * mix(1.0, 1.5, 1.0 - fronds as f32 / 13.0),
                        lean: (mix(0.55, 0.2, inner), dice.between(1.25, 1.8)),
                        segments,
                        cell: dice.below(4),
                        tone: dice.between(0.8, 1.0),
                    },
                );
            }
            mesh
        });
        model.variants.push(variant(format!("fern_{letter}"), material, meshes));
    }
    model
}

/// Tufts in a patch.
const TUFTS: u32 = 15;
/// Radius of a patch in metres.
const PATCH: f32 = 1.5;

/// Tufts on a disc, denser in the middle; `tuft` is one of them, `size` its length.
fn patch(tuft: &Mesh, seed: u64, size: f32) -> Mesh {
    let mut dice = Dice::new(seed ^ 0x9a7c);
    let mut mesh = empty();
    for number in 0..TUFTS {
        // Equal areas for each tuft on a spiral.
        let radius = PATCH * ((number as f32 + 0.5) / TUFTS as f32).sqrt() * dice.between(0.8, 1.0);
        let at = turn(Vec3::X * radius, Vec3::Y, GOLDEN * number as f32);
        let (angle, scale, tone) = (TURN * dice.unit(), dice.between(0.6, 1.15), dice.between(0.8, 1.0));
        // A little lower at the rim: a slope may fall away under it.
        let sink = Vec3::Y * (0.04 * size * radius);
        let mut own = tuft.clone();
        for vertex in &mut own.vertices {
            vertex.position = turn(vertex.position, Vec3::Y, angle) * scale + at - sink;
            vertex.normal = turn(vertex.normal, Vec3::Y, angle);
            vertex.tangent = turn(vertex.tangent, Vec3::Y, angle);
            vertex.shade *= tone;
        }
        mesh.append(&own);
    }
    mesh
}

/// Grass: a low tuft, a high one with ears, and a patch of each.
pub fn grass() -> Model {
    let mut model = Model::default();
    let mut patch_variants = Vec::new();
    for (letter, seed, size, ears, color) in [
        ('a', 91, 0.42, false, [0.15, 0.25, 0.06]),
        ('b', 92, 0.85, true, [0.19, 0.25, 0.075]),
    ] {
        let sprig = Sprig::Blades {
            color,
            lean: if ears { 0.32 } else { 0.55 },
            ears,
        };
        let material = material(&mut model, &format!("grass_{letter}"), sprig, seed);
        let meshes = [(9, 2), (5, 1), (3, 1)].map(|(cards, segments)| {
            let mut dice = Dice::new(seed);
            let mut mesh = empty();
            let turned = dice.unit();
            for number in 0..cards {
                let outward = level(turned + number as f32 / cards as f32 * 0.5 + 0.5 * (number % 2) as f32);
                let length = size * dice.between(0.8, 1.1);
                strip(
                    &mut mesh,
                    &Strip {
                        foot: outward * (size * 0.14 * dice.unit()) - Vec3::Y * 0.02,
                        outward,
                        length,
                        width: length * mix(1.0, 1.35, 1.0 - cards as f32 / 9.0),
                        lean: (0.05, dice.between(0.25, 0.6)),
                        segments,
                        cell: dice.below(4),
                        tone: dice.between(0.8, 1.0),
                    },
                );
            }
            mesh
        });
        // What covers the ground is needed in fewer cards and disappears where it is as high as a few pixels.
        let [_, some, few] = &meshes;
        let lods = [(some, 0.05), (few, 0.009)].map(|(tuft, coverage)| (patch(tuft, seed, size), coverage));
        patch_variants.push(Variant {
            name: format!("grass_patch_{letter}"),
            lods: lods
                .into_iter()
                .map(|(mesh, screen_coverage)| Lod {
                    parts: vec![Part { mesh, material }],
                    screen_coverage,
                })
                .collect(),
        });
        model
            .variants
            .push(variant(format!("grass_{letter}"), material, meshes));
    }
    model.variants.extend(patch_variants);
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_upright_strip_is_as_long_as_it_says() {
        let mut mesh = empty();
        strip(
            &mut mesh,
            &Strip {
                foot: Vec3::ZERO,
                outward: Vec3::X,
                length: 2.0,
                width: 0.5,
                lean: (0.0, 0.0),
                segments: 4,
                cell: 1,
                tone: 1.0,
            },
        );
        let (low, high) = mesh.bounds().expect("vertices");
        assert!((high - low - Vec3::new(0.0, 2.0, 0.5)).length() < 1e-5, "{low} {high}");
        assert_eq!(mesh.triangle_count(), 8);
        assert!(
            mesh.vertices.iter().all(|v| v.uv.x >= 0.5 && v.uv.y <= 0.5),
            "cell 1 is the upper right one"
        );
    }
}
