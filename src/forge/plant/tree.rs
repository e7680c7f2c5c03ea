//! A tree from its recipe: skeleton, leaves, levels of detail, impostor.

use bevy_math::{Vec2, Vec3};

use super::{
    colonise::{self, Colony},
    crown::{Crown, cards, shuffled},
    skeleton::{Seat, Skeleton},
    tubes::{WoodDetail, skin},
    weber_penn,
};
use crate::forge::{
    bake::impostor,
    mesh::{Leaf, Lod, Material, Model, Part, Variant},
    portable::{Dice, any_normal, turn},
    texture::{
        bark::Bark,
        sprigs::{self, Sprig},
    },
};

/// How stems grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Growth {
    /// By parameters of a species (Weber and Penn).
    Parameters(weber_penn::Species),
    /// By competition for space (Runions and others).
    Space(Colony),
}

/// How twigs with leaves stand on their stems.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Habit {
    /// All around, leaves upward.
    Spreading,
    /// To both sides in a level plane, some hanging.
    Flat,
    /// Down.
    Hanging,
    /// Forward and up.
    Upright,
}

/// Twigs with leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foliage {
    /// What is painted on the cards.
    pub sprig: Sprig,
    /// How they stand.
    pub habit: Habit,
    /// Stems carry twigs where their radius is smaller, in metres.
    pub thinner_than: f32,
    /// Metres along the stem from twig to twig.
    pub spacing: f32,
    /// Length of a twig in metres, and its variation.
    pub length: (f32, f32),
    /// Angle to the stem in degrees.
    pub angle: f32,
    /// How much normals are bent outward, 0..=1.
    pub round: f32,
    /// How much the cards are folded along the middle.
    pub fold: f32,
    /// Thickness of a leaf in metres.
    pub thickness: f32,
    /// Share of light that shines through.
    pub transmission: f32,
}

/// A tree's recipe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tree {
    /// File name and beginning of the variants' names.
    pub name: &'static str,
    /// Stems.
    pub growth: Growth,
    /// Bark, and its picture's size in metres, across and along.
    pub bark: (Bark, Vec2),
    /// Leaves; `None`: a dead tree.
    pub foliage: Option<Foliage>,
    /// One variant each.
    pub seeds: &'static [u64],
}

/// Height of the tree that [`LEVELS`] are meant for, in metres.
const REFERENCE_HEIGHT: f32 = 12.0;
/// Wood, share of leaves and height on the screen in levels 0, 1, 2; level 3 is the impostor.
const LEVELS: [(WoodDetail, f32, f32); 3] = [
    (
        WoodDetail {
            sides: 12.0,
            reference: 0.2,
            thinnest: 0.010,
            tolerance: 0.03,
        },
        1.0,
        0.7,
    ),
    (
        WoodDetail {
            sides: 7.0,
            reference: 0.2,
            thinnest: 0.030,
            tolerance: 0.05,
        },
        0.42,
        0.3,
    ),
    (
        WoodDetail {
            sides: 5.0,
            reference: 0.2,
            thinnest: 0.07,
            tolerance: 0.14,
        },
        0.14,
        0.12,
    ),
];

/// How far trunks go into the ground, for slopes, in metres.
const ROOT: f32 = 0.5;
/// The golden angle in radians.
const GOLDEN: f32 = 2.399_963_2;

/// Forges all variants of a tree.
pub fn forge(tree: &Tree) -> Model {
    let mut model = Model::default();
    let [color, normal] = tree.bark.0.pictures();
    let bark = Material {
        base_picture: Some(model.add_picture(color)),
        normal_picture: Some(model.add_picture(normal)),
        ..Material::plain("bark", [1.0; 3])
    };
    let bark = model.add_material(bark);
    let leaves = tree.foliage.map(|foliage| {
        let [color, thickness] = sprigs::paint(foliage.sprig, "leaves", tree.seeds[0]);
        let (base_picture, thickness_picture) = (model.add_picture(color), model.add_picture(thickness));
        model.add_material(Material {
            base_picture: Some(base_picture),
            roughness: 0.6,
            cutoff: Some(0.5),
            double_sided: true,
            leaf: Some(Leaf {
                thickness: foliage.thickness,
                thickness_picture: Some(thickness_picture),
                transmission: foliage.transmission,
            }),
            ..Material::plain("leaves", [1.0; 3])
        })
    });
    for (letter, seed) in ('a'..='z').zip(tree.seeds) {
        let name = format!("{}_{letter}", tree.name);
        let skeleton = grow(tree, *seed);
        let mut lods = levels(tree, &skeleton, bark, leaves);
        let impostor = impostor::bake(&mut model, &lods[0], &name);
        lods.push(impostor);
        model.variants.push(Variant { name, lods });
    }
    model
}

/// Stems and twigs of one variant.
fn grow(tree: &Tree, seed: u64) -> Skeleton {
    let mut skeleton = match &tree.growth {
        Growth::Parameters(species) => weber_penn::grow(species, seed),
        Growth::Space(colony) => colonise::grow(colony, seed),
    };
    if let Some(foliage) = &tree.foliage {
        skeleton.seats = shuffled(seats(&skeleton, foliage, seed), seed);
    }
    // The trunk: where it forks, its other halves come before it.
    for trunk in skeleton.stems.iter_mut().filter(|stem| stem.level == 0) {
        let mut foot = trunk.joints[0];
        if foot.at.y <= 0.0 {
            foot.at.y -= ROOT;
            trunk.joints.insert(0, foot);
        }
    }
    skeleton
}

fn levels(tree: &Tree, skeleton: &Skeleton, bark: usize, leaves: Option<usize>) -> Vec<Lod> {
    let crown = Crown::new(&skeleton.seats);
    let joints = skeleton.stems.iter().flat_map(|stem| &stem.joints);
    let height = joints.map(|joint| joint.at.y).fold(0.1, f32::max);
    let size = (height / REFERENCE_HEIGHT).min(1.0);
    let shade = |at: Vec3| {
        if skeleton.seats.is_empty() {
            1.0
        } else {
            crown.shade(at)
        }
    };
    LEVELS
        .iter()
        .enumerate()
        .map(|(level, (detail, share, screen_coverage))| {
            let mut parts = vec![Part {
                mesh: skin(&skeleton.stems, &detail.scaled(size), tree.bark.1, &shade),
                material: bark,
            }];
            if let (Some(foliage), Some(material)) = (&tree.foliage, leaves) {
                let fold = if level == 0 { foliage.fold } else { 0.0 };
                parts.push(Part {
                    mesh: cards(&skeleton.seats, *share, &crown, foliage.round, fold),
                    material,
                });
            }
            parts.retain(|part| part.mesh.triangle_count() > 0);
            Lod {
                parts,
                // Small plants are looked at from nearer, and their impostors have as few texels as those of trees.
                screen_coverage: screen_coverage * size.sqrt(),
            }
        })
        .collect()
}

/// Twigs along all stems that are thin enough.
fn seats(skeleton: &Skeleton, foliage: &Foliage, seed: u64) -> Vec<Seat> {
    let mut dice = Dice::new(seed ^ 0x1eaf);
    let mut seats = Vec::new();
    for stem in &skeleton.stems {
        // Short stems carry short twigs, so that tops are slender.
        let size = (0.35 + 0.3 * stem.length() / foliage.length.0).min(1.0);
        let foliage = &Foliage {
            length: (foliage.length.0 * size, foliage.length.1 * size),
            ..*foliage
        };
        let mut wait = foliage.spacing * dice.unit();
        let mut number = dice.below(8);
        for pair in stem.joints.windows(2) {
            let along = pair[1].at - pair[0].at;
            let length = along.length();
            let mut place = wait;
            while place < length {
                let share = place / length;
                let radius = pair[0].radius + (pair[1].radius - pair[0].radius) * share;
                if radius < foliage.thinner_than {
                    let at = pair[0].at + along * share;
                    seats.push(seat(at, along / length, number, foliage, &mut dice));
                    number += 1;
                }
                place += foliage.spacing * dice.between(0.75, 1.25);
            }
            wait = place - length;
        }
        // One at the very tip.
        if let [.., before, tip] = stem.joints[..] {
            if tip.radius < foliage.thinner_than {
                let along = (tip.at - before.at).normalize_or(Vec3::Y);
                let straight = Foliage {
                    angle: foliage.angle * 0.3,
                    ..*foliage
                };
                seats.push(seat(tip.at, along, number, &straight, &mut dice));
            }
        }
    }
    seats
}

fn seat(at: Vec3, stem: Vec3, number: u32, foliage: &Foliage, dice: &mut Dice) -> Seat {
    let angle = (foliage.angle * dice.between(0.8, 1.2)).to_radians();
    let (along, upper) = match foliage.habit {
        Habit::Spreading => {
            let axis = turn(any_normal(stem), stem, GOLDEN * number as f32);
            let along = turn(stem, axis, angle) + Vec3::Y * 0.15;
            (along, Vec3::Y * 0.75 + dice.in_ball() * 0.95)
        }
        Habit::Flat => {
            let side = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
            let flat = turn(stem, Vec3::Y, side * angle);
            let droop = if number % 5 < 2 { 0.85 } else { 0.30 };
            let along = flat - Vec3::Y * droop + dice.in_ball() * 0.15;
            (along, Vec3::Y + dice.in_ball() * 0.75)
        }
        Habit::Hanging => {
            let axis = turn(any_normal(stem), stem, GOLDEN * number as f32);
            let along = turn(stem, axis, angle) * 0.55 - Vec3::Y * 0.7 + dice.in_ball() * 0.35;
            (along, dice.in_ball() + Vec3::Y * 0.2)
        }
        Habit::Upright => {
            let axis = turn(any_normal(stem), stem, GOLDEN * number as f32);
            let along = turn(stem, axis, angle) + Vec3::Y * 0.55;
            (along, dice.in_ball() + Vec3::Y * 0.35)
        }
    };
    let along = along.normalize_or(Vec3::Y);
    let upper = (upper - along * upper.dot(along)).normalize_or(any_normal(along));
    Seat {
        at,
        along,
        upper,
        length: dice.about(foliage.length.0, foliage.length.1),
        cell: dice.below(4),
        tone: dice.between(0.78, 1.0),
    }
}
