//! Models of the street: furniture, cars, a tram, a fountain, the lattice tower; and the forest's hut and fences.
//!
//! ```text
//! solid: faces in groups, chamfers, turned and swept profiles ──► normals by crease ──► parts of three materials
//! palette: one picture of plain colours, signs and prints     ──►
//! ```

mod cabin;
mod cars;
mod fountain;
mod furniture;
mod lamps;
mod palette;
mod solid;
mod stalls;
mod tower;
mod tram;

use self::solid::Solid;
use super::{
    Recipe,
    mesh::{Lod, Material, Model, Part, Variant},
};

/// The files of this room.
pub(super) const RECIPES: [Recipe; 6] = [
    Recipe {
        name: "street",
        about: "street furniture: lamps, benches, bins, signs, a kiosk, café tables",
        make: furniture::forge,
    },
    Recipe {
        name: "cars",
        about: "parked cars: a hatchback, an estate, a lorry",
        make: cars::forge,
    },
    Recipe {
        name: "tower",
        about: "a lattice tower of 118 metres",
        make: tower::forge,
    },
    Recipe {
        name: "fountain",
        about: "a fountain with two bowls in a basin",
        make: fountain::forge,
    },
    Recipe {
        name: "tram",
        about: "a tram of two cars with a pantograph",
        make: tram::forge,
    },
    Recipe {
        name: "cabin",
        about: "a log cabin, posts and split rails of a fence",
        make: cabin::forge,
    },
];

/// What a level of detail is made of: solids by material.
#[derive(Clone, Debug, Default)]
struct Pieces {
    /// Dull: paint, stone, wood.
    plain: Solid,
    /// Smooth: glass, chrome, water.
    glossy: Solid,
    /// Takes the placement's tint.
    paint: Solid,
}

/// A model under construction: the palette and the three materials.
struct Yard {
    model: Model,
    materials: [usize; 3],
}

impl Yard {
    fn new() -> Self {
        let mut model = Model::default();
        let picture = model.add_picture(palette::picture());
        let mut material = |name: &str, roughness, picture| {
            model.add_material(Material {
                base_picture: picture,
                roughness,
                ..Material::plain(name, [1.0; 3])
            })
        };
        let materials = [
            material("plain", 0.75, Some(picture)),
            material("glossy", 0.18, Some(picture)),
            material("paint", 0.35, None),
        ];
        Self { model, materials }
    }

    /// Adds a variant: its levels from fine to coarse, with the heights on the screen down to which they are meant.
    fn add(&mut self, name: &str, levels: &[(Pieces, f32)]) {
        let lods = levels.iter().map(|(pieces, screen_coverage)| {
            let solids = [&pieces.plain, &pieces.glossy, &pieces.paint];
            let parts = solids.into_iter().zip(self.materials);
            Lod {
                parts: parts
                    .filter(|(solid, _)| solid.triangle_count() > 0)
                    .map(|(solid, material)| Part {
                        mesh: solid.mesh(),
                        material,
                    })
                    .collect(),
                screen_coverage: *screen_coverage,
            }
        });
        let lods = lods.collect();
        self.model.variants.push(Variant {
            name: name.to_owned(),
            lods,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coarse_levels_fill_the_same_box() {
        for recipe in RECIPES {
            for variant in recipe.model().variants {
                let boxes: Vec<_> = variant.lods.iter().filter_map(Lod::bounds).collect();
                let size = (boxes[0].1 - boxes[0].0).max_element();
                for (low, high) in &boxes {
                    let off = (*low - boxes[0].0).abs().max((*high - boxes[0].1).abs()).max_element();
                    assert!(off < 0.12 * size, "{}: {off} m off in {size} m", variant.name);
                }
            }
        }
    }
}
