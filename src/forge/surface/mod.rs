//! Tiles of ground that repeat without a seam: colour, 512 texels wide, and normals, 256.
//!
//! Each variant of `surfaces.glb` is a flat square as wide as its tile in metres, +y up, centred on the origin; its
//! material has the variant's name. Renderers take the two pictures and the width, and lay them over terrain, streets
//! and squares: u = x / width, v = z / width.
//!
//! | tile | width in metres | what |
//! |---|---|---|
//! | `forest_floor` | 2.2 | leaf litter on dark soil, twigs, needles, moss |
//! | `path` | 2.5 | trodden earth with pebbles |
//! | `rock` | 3 | granite with joints and lichen |
//! | `grass` | 1.5 | a mown lawn with clover |
//! | `asphalt` | 3 | aggregate in bitumen, worn and patched |
//! | `paving` | 2.4 | slabs of 60 by 40 centimetres in running bond |
//! | `cobbles` | 1.92 | granite setts laid in segments of arcs |
//! | `gravel` | 1.6 | rounded gravel |

mod nature;
mod sheet;
mod street;

use bevy_math::{Vec2, Vec3};

use self::sheet::Sheet;
use super::{
    Recipe,
    mesh::{Lod, Material, Mesh, Model, Part, Variant, Vertex},
};

/// `surfaces.glb`.
pub(super) const RECIPE: Recipe = Recipe {
    name: "surfaces",
    about: "tiles of ground: litter, earth, rock, grass, asphalt, paving, setts, gravel",
    make: forge,
};

/// Name, roughness and maker of each tile.
const TILES: [(&str, f32, fn() -> Sheet); 8] = [
    ("forest_floor", 0.95, nature::forest_floor),
    ("path", 0.95, nature::path),
    ("rock", 0.85, nature::rock),
    ("grass", 0.9, nature::grass),
    ("asphalt", 0.85, street::asphalt),
    ("paving", 0.8, street::paving),
    ("cobbles", 0.7, street::cobbles),
    ("gravel", 0.9, street::gravel),
];

fn forge() -> Model {
    let mut model = Model::default();
    for (name, roughness, make) in TILES {
        let sheet = make();
        let [color, normal] = sheet.pictures(name);
        let material = Material {
            base_picture: Some(model.add_picture(color)),
            normal_picture: Some(model.add_picture(normal)),
            roughness,
            ..Material::plain(name, [1.0; 3])
        };
        let material = model.add_material(material);
        model.variants.push(Variant {
            name: name.into(),
            lods: vec![Lod {
                parts: vec![Part {
                    mesh: square(sheet.width),
                    material,
                }],
                screen_coverage: 0.0,
            }],
        });
    }
    model
}

/// A flat square with one tile of the picture.
fn square(width: f32) -> Mesh {
    let mut mesh = Mesh {
        tangents: true,
        ..Mesh::default()
    };
    let corners = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)].map(|(u, v)| {
        mesh.push(Vertex {
            position: Vec3::new(u - 0.5, 0.0, v - 0.5) * width,
            normal: Vec3::Y,
            uv: Vec2::new(u, v),
            tangent: Vec3::X,
            shade: 1.0,
        })
    });
    mesh.push_quad(corners);
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_look_up_and_show_their_picture_upright() {
        let mesh = square(2.0);
        let [a, b, c] = [0, 1, 2].map(|i| mesh.vertices[mesh.indices[i] as usize]);
        let up = (b.position - a.position).cross(c.position - a.position);
        assert!(up.y > 0.0 && up.x == 0.0 && up.z == 0.0, "{up}");
        // The top of the picture lies towards −z, so that normal × tangent points up in it.
        assert_eq!(Vec3::Y.cross(Vec3::X), Vec3::NEG_Z);
        assert!(c.uv.y < b.uv.y && c.position.z < b.position.z);
    }

    #[test]
    fn no_tile_has_a_seam() {
        for (name, _, make) in TILES {
            let [color, _] = make().pictures(name);
            let texel = |x: usize, y: usize| color.texels[y * sheet::SIDE + x].map(f32::from);
            let step = |a: [f32; 4], b: [f32; 4]| (0..3).map(|k| (a[k] - b[k]).abs()).sum::<f32>();
            let last = sheet::SIDE - 1;
            let mean = |from: usize, to: usize| {
                (0..sheet::SIDE)
                    .map(|i| step(texel(from, i), texel(to, i)) + step(texel(i, from), texel(i, to)))
                    .sum::<f32>()
                    / sheet::SIDE as f32
            };
            let inside = (0..last).map(|i| mean(i, i + 1)).fold(0.0, f32::max);
            assert!(
                mean(last, 0) <= inside,
                "{name}: {} at the seam, {inside} inside",
                mean(last, 0)
            );
        }
    }
}
