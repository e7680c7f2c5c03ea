//! [`Scenery`]: a whole level as values, before anything is spawned.

use bevy_math::Vec3;

use super::{
    city,
    cover::Cover,
    forest,
    format::{Generator, Level},
    ground::Ground,
    grove::Grove,
    meshes::MeshData,
    model::Placement,
    rooms,
};

/// What a generator makes of a level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scenery {
    /// Meshes that stand in one place only, in world space.
    pub statics: Vec<Static>,
    /// The same in levels of detail.
    pub patches: Vec<Patch>,
    /// Everything else.
    pub placements: Vec<Placement>,
    /// Trees that are drawn cell by cell.
    pub grove: Option<Grove>,
    /// What a walker stands on.
    pub ground: Ground,
}

/// A mesh in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Static {
    /// For inspectors.
    pub name: &'static str,
    /// Triangles.
    pub mesh: MeshData,
    /// How its surface looks.
    pub finish: Finish,
}

/// A piece of ground in levels of detail, in its vertices' colours.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// For inspectors.
    pub name: &'static str,
    /// Where the levels' own space begins, world space: distances are measured from there.
    pub origin: Vec3,
    /// From fine to coarse.
    pub levels: Vec<PatchLevel>,
    /// Where all levels but the last end, metres.
    pub ends: Vec<f64>,
}

/// A level of a [`Patch`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchLevel {
    /// Triangles, opaque.
    pub mesh: MeshData,
    /// For each vertex, what differs in the next coarser level; empty in the last one.
    pub coarser: Vec<Correspondence>,
}

/// What differs for a vertex in the next coarser level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correspondence {
    /// Metres.
    pub position: Vec3,
    /// Added to its normal, it gives the other one.
    pub normal: Vec3,
}

/// How the surface of a [`Static`] looks.
#[derive(Clone, Debug, PartialEq)]
pub enum Finish {
    /// In the vertices' colours, dull.
    Colored,
    /// Tiles of ground; the vertices' colours stand in where their file is missing.
    Cover(Cover),
    /// Still, dark water.
    Water,
    /// Glass in the vertices' colours, half clear; casts no shadow.
    Glass,
}

impl Static {
    /// A mesh with vertex colours.
    pub fn colored(name: &'static str, mesh: MeshData) -> Self {
        Self {
            name,
            mesh,
            finish: Finish::Colored,
        }
    }
}

/// Generates a level: the same for the same level, on every machine.
pub fn generate(level: &Level) -> Scenery {
    match &level.generator {
        Generator::Forest(forest) => forest::generate(level, forest),
        Generator::City(city) => city::generate(level, city),
        Generator::Room(room) => rooms::generate(level, *room),
        Generator::StressTrees(trees) => rooms::stress_trees(level, *trees),
    }
}
