//! Façades and roofs: a kit of bays and what is assembled from it.
//!
//! ```text
//! bays (one window's width) ──► sides ──► a storey: four sides and corners ──► storeys, roof: a building
//! bays, roofs                             assemble                             `level::buildings` places them
//! ```
//!
//! All pieces share one material and one picture ([`atlas`]), whose walls are nearly white: a building's paint is the
//! tint of its placement. Far views of bays are rendered from the bays themselves ([`views`]).

pub mod assemble;
pub mod atlas;
pub mod bays;
pub mod brush;
pub mod paint;
pub mod roofs;
pub mod views;

use crate::forge::{
    Recipe,
    mesh::{Lod, Material, Model, Part, Variant},
};
use bays::{Bay, Storey};

/// Ways to build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Style {
    /// An old town house: plaster, cornices, french balconies, a mansard roof.
    Stucco,
    /// Brick with stone lintels and a flat roof with a tank.
    Brick,
    /// Cast panels with balconies.
    Concrete,
    /// Offices: large panes between fins.
    Office,
    /// Offices: ribbons of windows under sunshades.
    Ribbon,
    /// A house with shutters and a gabled roof.
    House,
}

impl Style {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Stucco,
        Self::Brick,
        Self::Concrete,
        Self::Office,
        Self::Ribbon,
        Self::House,
    ];

    /// Width of a bay in metres.
    pub fn bay(self) -> f32 {
        match self {
            Self::Stucco => 2.8,
            Self::Brick | Self::House => 3.0,
            Self::Concrete | Self::Office | Self::Ribbon => 3.2,
        }
    }

    /// Do upper storeys have balconies?
    pub fn has_balconies(self) -> bool {
        matches!(self, Self::Stucco | Self::Concrete)
    }

    /// What walls are made of.
    pub fn strip(self, storey: Storey) -> atlas::Strip {
        match (self, storey) {
            (Self::Stucco, Storey::Ground) => atlas::ASHLAR,
            (Self::Stucco | Self::House | Self::Ribbon, _) => atlas::PLASTER,
            (Self::Brick, _) => atlas::BRICK,
            (Self::Concrete | Self::Office, _) => atlas::CONCRETE,
        }
    }

    /// In names of pieces.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stucco => "stucco",
            Self::Brick => "brick",
            Self::Concrete => "concrete",
            Self::Office => "office",
            Self::Ribbon => "ribbon",
            Self::House => "house",
        }
    }
}

/// Name of the file and, behind `paint_`, of its material.
pub const FILE: &str = "facades";

/// The file of this folder.
pub const RECIPE: Recipe = Recipe {
    name: FILE,
    about: "façades: a kit of bays in six styles",
    make: forge,
};

/// A model with the material and the picture of all façades, without shapes.
pub fn material() -> Model {
    let mut model = Model::default();
    let picture = model.add_picture(views::picture());
    model.add_material(Material {
        base_picture: Some(picture),
        roughness: 0.85,
        ..Material::plain("paint_facades", [1.0; 3])
    });
    model
}

/// The kit: one variant per bay.
fn forge() -> Model {
    let mut model = Model::default();
    let picture = model.add_picture(views::picture());
    let material = model.add_material(Material {
        base_picture: Some(picture),
        roughness: 0.85,
        ..Material::plain("paint_facades", [1.0; 3])
    });
    for (style, storey, bay) in kit() {
        let lods = bays::levels(style, storey, bay)
            .into_iter()
            .enumerate()
            .map(|(level, mesh)| Lod {
                parts: vec![Part { mesh, material }],
                screen_coverage: [0.08, 0.02, 0.0][level.min(2)],
            });
        let mut lods: Vec<Lod> = lods.collect();
        if let Some(last) = lods.last_mut() {
            last.screen_coverage = 0.0;
        }
        let floor = match storey {
            Storey::Ground => "ground",
            Storey::Upper => "upper",
        };
        let name = format!("{}_{floor}_{}", style.name(), bay.name());
        model.variants.push(Variant { name, lods });
    }
    model
}

/// Every bay of every style that has a far view, in the order of those views.
pub fn kit() -> Vec<(Style, Storey, Bay)> {
    let mut kit = Vec::new();
    for style in Style::ALL {
        for storey in [Storey::Ground, Storey::Upper] {
            kit.extend(Bay::all(style, storey).into_iter().map(|bay| (style, storey, bay)));
        }
    }
    kit
}
