//! What is thrown on a terrain, and which model files it is drawn with.

use bevy_math::Vec3;

use super::{
    format::Species,
    model::{AssetRef, Tint},
};

/// The file and the variant of a species' shape, any number.
pub fn asset(species: Species, variant: u32) -> AssetRef {
    let (file, first, count) = shapes(species);
    AssetRef {
        file,
        variant: first + variant % count,
    }
}

/// File, first variant and number of variants.
fn shapes(species: Species) -> (&'static str, u32, u32) {
    match species {
        Species::Spruce => ("spruce", 0, 2),
        Species::Pine => ("pine", 0, 2),
        Species::Oak => ("oak", 0, 2),
        Species::Beech => ("beech", 0, 2),
        Species::Birch => ("birch", 0, 2),
        Species::DeadTree => ("dead_tree", 0, 2),
        Species::Bush => ("bush", 0, 2),
        Species::Fern => ("fern", 0, 2),
        Species::Grass => ("grass", 2, 1),
        Species::TallGrass => ("grass", 3, 1),
        Species::Stone => ("rock", 0, 1),
        Species::Rock => ("rock", 1, 1),
        Species::Boulder => ("rock", 2, 1),
        Species::Stump => ("deadwood", 0, 1),
        Species::Log => ("deadwood", 1, 1),
    }
}

/// Radius in metres of what a walker bumps into, at scale 1; `None`: one walks through or over it.
pub fn foot_radius(species: Species) -> Option<f32> {
    match species {
        Species::Oak => Some(0.42),
        Species::Beech => Some(0.36),
        Species::Spruce | Species::Pine => Some(0.26),
        Species::Birch => Some(0.2),
        Species::DeadTree => Some(0.24),
        Species::Stump => Some(0.45),
        Species::Rock => Some(0.55),
        Species::Boulder => Some(1.6),
        Species::Bush | Species::Fern | Species::Grass | Species::TallGrass | Species::Stone | Species::Log => None,
    }
}

/// Height of the tallest shape in metres, at scale 1.
pub fn height(species: Species) -> f32 {
    match species {
        Species::Oak => 12.5,
        Species::Beech | Species::Birch => 15.5,
        Species::Spruce => 16.2,
        Species::Pine => 18.0,
        Species::DeadTree => 9.3,
        Species::Bush => 1.8,
        Species::Boulder => 2.0,
        Species::Rock | Species::TallGrass | Species::Log => 0.9,
        Species::Stump => 0.6,
        Species::Fern | Species::Grass => 0.45,
        Species::Stone => 0.35,
    }
}

/// Largest lean from upright in radians: trees grow a little askew.
pub fn lean(species: Species) -> f32 {
    match species {
        Species::Birch | Species::DeadTree => 0.09,
        Species::Oak | Species::Beech | Species::Pine => 0.05,
        Species::Spruce => 0.025,
        _ => 0.0,
    }
}

/// One of a few tints, by a share of 0..=1: few, so that instances still share their materials.
pub fn tint(species: Species, share: f32) -> Tint {
    let tints: &[[u8; 3]] = match species {
        Species::Oak | Species::Beech => &[[255, 255, 255], [236, 242, 214], [218, 236, 232]],
        Species::Birch => &[[255, 255, 255], [255, 246, 196], [226, 238, 222]],
        Species::Spruce | Species::Pine => &[[255, 255, 255], [232, 240, 222], [224, 238, 246]],
        Species::Bush | Species::Fern => &[[255, 255, 255], [238, 240, 206]],
        Species::Grass | Species::TallGrass => &[[255, 255, 255], [255, 243, 190]],
        _ => &[[255, 255, 255]],
    };
    let index = (share.clamp(0.0, 1.0) * tints.len() as f32) as usize;
    Tint(tints[index.min(tints.len() - 1)])
}

/// Does it lie along the slope rather than stand upright?
pub fn follows_slope(species: Species) -> bool {
    !species.is_tree()
}

/// Half the extent of a box around a species at scale 1, for a stand-in.
pub fn half_extent(species: Species) -> Vec3 {
    let height = height(species);
    let across = if species.is_tree() { 0.25 * height } else { 0.5 * height };
    Vec3::new(across, 0.5 * height, across)
}
