//! Assets from code: trees, undergrowth, rocks and dead wood as binary glTF files.
//!
//! Everything follows from seeds and constants by portable arithmetic ([`portable`]): the same bytes on every machine,
//! without a GPU. The files are committed; `umbrage forge --check` compares.
//!
//! ```text
//! growth model ──► stems, seats of leaves ──► tubes, cards: levels 0, 1, 2 ──► views: the impostor, level 3 ──► .glb
//! plant/{weber_penn, colonise}   plant/skeleton   plant/{tubes, crown}           bake/impostor                   glb
//! ```
//!
//! | file | what | by |
//! |---|---|---|
//! | oak, bush | broad crowns | space colonisation, Runions et al. 2007 ([`plant::colonise`]) |
//! | birch, beech, spruce, pine, `dead_tree` | parametric trees | Weber and Penn 1995 ([`plant::weber_penn`]) |
//! | fern, grass | strips with painted fronds and blades | [`ground::herbs`] |
//! | rock | icospheres cut by planes | [`ground::rock`] |
//! | deadwood | a stump, a log | [`ground::deadwood`] |
//! | street, cars, tram, tower, fountain, cabin | furniture, vehicles, a lattice tower, a log cabin | [`street`] |
//! | surfaces | tiles of ground: litter, earth, rock, grass, asphalt, stone | [`surface`] |
//! | deer, walker | skinned figures with clips | soft objects, marching tetrahedra, edge collapse ([`figure`]) |
//! | facades | a kit of bays in six styles, with one picture | [`city::facade`] |
//!
//! Leaves are alpha-masked cards; PNG holds no mips, so loaders make them with
//! [`texture::mips::coverage_preserving_mips`], else crowns thin out with distance.
//!
//! ```
//! use umbrage::forge;
//!
//! let fern = forge::assets().iter().find(|asset| asset.name == "fern").unwrap();
//! assert_eq!(&fern.forge()[..4], b"glTF");
//! ```

pub mod bake;
pub mod city;
pub mod figure;
pub mod glb;
pub mod ground;
pub mod mesh;
pub mod plant;
pub mod portable;
pub mod rig;
pub mod street;
pub mod surface;
pub mod texture;

use ground::{deadwood, herbs, rock};
use mesh::Model;
use plant::{species, tree};

/// How to make one file.
#[derive(Clone, Copy, Debug)]
pub struct Recipe {
    /// File name without extension.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    make: fn() -> Model,
}

impl Recipe {
    /// Meshes, materials and pictures.
    pub fn model(&self) -> Model {
        (self.make)()
    }

    /// The bytes of the .glb file.
    pub fn forge(&self) -> Vec<u8> {
        glb::bytes(&self.model())
    }
}

const ASSETS: &[Recipe] = &[
    Recipe {
        name: "oak",
        about: "pedunculate oak, two shapes",
        make: || tree::forge(&species::OAK),
    },
    Recipe {
        name: "birch",
        about: "silver birch, two shapes",
        make: || tree::forge(&species::BIRCH),
    },
    Recipe {
        name: "beech",
        about: "beech, two shapes",
        make: || tree::forge(&species::BEECH),
    },
    Recipe {
        name: "spruce",
        about: "Norway spruce, two shapes",
        make: || tree::forge(&species::SPRUCE),
    },
    Recipe {
        name: "pine",
        about: "Scots pine, two shapes",
        make: || tree::forge(&species::PINE),
    },
    Recipe {
        name: "dead_tree",
        about: "standing dead tree, two shapes",
        make: || tree::forge(&species::DEAD_TREE),
    },
    Recipe {
        name: "bush",
        about: "hazel bush, two shapes",
        make: || tree::forge(&species::BUSH),
    },
    Recipe {
        name: "fern",
        about: "male fern, two shapes",
        make: herbs::fern,
    },
    Recipe {
        name: "grass",
        about: "grass: a low tuft, a high one with ears",
        make: herbs::grass,
    },
    Recipe {
        name: "rock",
        about: "rocks: a stone, a block, a boulder",
        make: rock::forge,
    },
    Recipe {
        name: "deadwood",
        about: "a stump and a fallen log",
        make: deadwood::forge,
    },
    surface::RECIPE,
    street::RECIPES[0],
    street::RECIPES[1],
    street::RECIPES[2],
    street::RECIPES[3],
    street::RECIPES[4],
    street::RECIPES[5],
    figure::RECIPES[0],
    figure::RECIPES[1],
    city::facade::RECIPE,
];

/// All assets.
pub fn assets() -> &'static [Recipe] {
    ASSETS
}
