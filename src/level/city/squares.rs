//! Squares and parks: the lattice tower with a kiosk and café tables, a fountain between lawns and trees.

use bevy_math::{Vec2, Vec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{
    Block, facing,
    ground::{PARK_PLACE, PARK_WAY},
    kerbside::{any, put, put_tinted, tree},
    on_pavement, pointing,
};
use crate::level::{
    format::{City, Species},
    ground::{Blocker, BlockerShape},
    made::{CLOTHS, Made, TOWER_FEET, TOWER_HEIGHT},
    model::{Model, Placement},
};

/// The lattice tower with benches, a kiosk, café tables and pots around it.
pub(super) fn tower_square(rng: &mut ChaCha8Rng, city: &City, block: &Block, placements: &mut Vec<Placement>) {
    let middle = block.middle();
    placements.push(Placement {
        scale: Vec3::splat(tower_scale(city)),
        ..put(Made::Tower, middle, 0.0)
    });
    for (side, (_, along, out, length)) in block.sides().into_iter().enumerate() {
        let edge = middle + out * (0.5 * (block.size() * out.abs()).max_element() - city.pavement - 2.0);
        for k in [-0.32, -0.1, 0.1, 0.32] {
            let bench = edge + along * (k * length);
            placements.push(put(Made::Bench, bench, facing(-out)));
            if k < 0.0 {
                placements.push(put(Made::Bin, bench + along * 1.6, 0.0));
            }
        }
        for k in [-0.21, 0.21] {
            placements.push(put(Made::Grate, edge + along * (k * length), 0.0));
            placements.push(tree(rng, Species::Birch, edge + along * (k * length), 0.55));
        }
        // Bollards keep cars off the square.
        let rim = edge + out * (city.pavement + 1.1);
        for i in 0..9 {
            let m = (i as f32 / 8.0 - 0.5) * 0.7 * length;
            placements.push(put(Made::Bollard, rim + along * m, 0.0));
        }
        if side == 3 {
            cafe(rng, edge - out * 4.2, along, out, placements);
        }
        if side == 1 {
            let kiosk = edge - out * 3.2 + along * (0.30 * length);
            placements.push(put(Made::Kiosk, kiosk, facing(-along)));
            placements.push(put(Made::PostBox, kiosk + along * 2.2 - out * 1.0, facing(-along)));
        }
    }
}

/// The tower's model is scaled to the level's height.
fn tower_scale(city: &City) -> f32 {
    city.tower_height / TOWER_HEIGHT
}

/// The feet of the tower, which a walker goes around.
pub(super) fn tower_feet(city: &City, block: &Block) -> [Blocker; 4] {
    let (off, half) = (TOWER_FEET.0 * tower_scale(city), TOWER_FEET.1 * tower_scale(city));
    [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, z)| Blocker {
        center: block.middle() + Vec2::new(x, z) * off,
        shape: BlockerShape::Box {
            half: Vec2::splat(half),
            yaw: 0.0,
        },
        bottom: -1.0,
        top: 30.0 * tower_scale(city),
    })
}

/// Two rows of tables under parasols, with pots at the ends.
fn cafe(rng: &mut ChaCha8Rng, middle: Vec2, along: Vec2, out: Vec2, placements: &mut Vec<Placement>) {
    let cloth = any(rng, &CLOTHS);
    for row in 0..2 {
        for i in 0..4 {
            let p = middle + along * (3.4 * (i as f32 - 1.5)) - out * (3.2 * row as f32);
            let p = p + Vec2::new(rng.random_range(-0.2..0.2), rng.random_range(-0.2..0.2));
            placements.push(put(Made::Cafe, p, rng.random_range(0.0..std::f32::consts::TAU)));
            if (i + row) % 2 == 0 {
                placements.push(put_tinted(
                    Made::Parasol,
                    p + Vec2::splat(0.1),
                    rng.random_range(0.0..1.0),
                    cloth,
                ));
            }
        }
    }
    for (m, d) in [(-7.0, 0.0), (7.0, 0.0), (-7.0, 3.2), (7.0, 3.2)] {
        let p = middle + along * m - out * d;
        placements.push(put(Made::Pot, p, 0.0));
        placements.push(Placement {
            scale: Vec3::splat(0.42),
            position: on_pavement(p) + Vec3::Y * 0.5,
            ..Placement::upright(
                Model::Plant(Species::Bush, 0),
                on_pavement(p),
                rng.random_range(0.0..6.0),
            )
        });
    }
}

/// A fountain where four ways meet, lawns with trees, benches, a railing around all.
pub(super) fn park(rng: &mut ChaCha8Rng, city: &City, block: &Block, placements: &mut Vec<Placement>) {
    let half = block.size() * 0.5 - city.pavement;
    let middle = block.middle();
    placements.push(put(Made::Fountain, middle, 0.4));
    let mut trees: Vec<Vec2> = Vec::new();
    for _ in 0..400 {
        let p = Vec2::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)) * (half - 2.5);
        let on_a_way = p.abs().min_element() < PARK_WAY + 1.2 || p.length() < PARK_PLACE + 1.5;
        if on_a_way || trees.iter().any(|other| other.distance(p) < 6.0) {
            continue;
        }
        trees.push(p);
        let species = any(rng, &[Species::Oak, Species::Beech, Species::Oak, Species::Birch]);
        placements.push(tree(rng, species, middle + p, 0.78));
    }
    for _ in 0..14 {
        let p = Vec2::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)) * (half - 1.5);
        if p.abs().min_element() > PARK_WAY + 1.0 && p.length() > PARK_PLACE + 1.0 {
            placements.push(tree(rng, Species::Bush, middle + p, 0.8));
        }
    }
    for (_, along, out, _) in block.sides() {
        let (reach, side) = ((half * out.abs()).max_element(), (half * along.abs()).max_element());
        railing(middle + out * (reach - 0.4), along, side - 0.4, placements);
        // Benches around the fountain and along the ways.
        for part in [-1.0, 1.0] {
            let diagonal = (out + along * part).normalize();
            placements.push(put(
                Made::Bench,
                middle + diagonal * (PARK_PLACE - 0.9),
                facing(-diagonal),
            ));
            let p = middle + out * (0.5 * (PARK_PLACE + reach)) + along * (part * (PARK_WAY + 0.5));
            placements.push(put(Made::Bench, p, facing(-along * part)));
            placements.push(put(Made::Bin, p + out * 1.5, 0.0));
        }
        placements.push(put(
            Made::OldLamp,
            middle + out * (reach - 2.5) + along * (PARK_WAY + 0.4),
            0.0,
        ));
    }
}

/// Panels on both sides of an entrance, scaled to fit.
fn railing(edge: Vec2, along: Vec2, side: f32, placements: &mut Vec<Placement>) {
    for part in [-1.0, 1.0] {
        let length = side - PARK_WAY;
        let panels = (length / 2.0).round().max(1.0);
        let width = length / panels;
        for i in 0..panels as u32 {
            let from = edge + along * (part * (PARK_WAY + width * i as f32));
            placements.push(Placement {
                scale: Vec3::new(0.5 * width, 1.0, 1.0),
                ..put(Made::Railing, from, pointing(along * part))
            });
        }
    }
}
