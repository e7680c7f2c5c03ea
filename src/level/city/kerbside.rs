//! What stands along kerbs: lamps, trees in grates, bins, signs, traffic lights, bicycles; parked cars; the tram.

use bevy_math::{Vec2, Vec3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Block, KERB, Land, POLE_INSET, facing, on_pavement, pointing};
use crate::level::{
    format::{City, Species},
    made::{CAR_PAINTS, FRAMES, Made, WIRE_HOLD},
    meshes::MeshData,
    model::{Model, Placement, Tint},
    props,
    scenery::Static,
    species,
};

/// Distance of lamps from each other along a kerb in metres; they alternate with those on the other side.
const LAMPS_APART: f32 = 25.0;

/// Distance of street trees from the kerb: like all that stands along it, they leave room for people from 1.35 m on.
const TREES: f32 = 1.0;

/// Something on a pavement.
pub(super) fn put(made: Made, at: Vec2, heading: f32) -> Placement {
    Placement::upright(Model::Made(made), on_pavement(at), heading)
}

/// Something tinted on a pavement.
pub(super) fn put_tinted(made: Made, at: Vec2, heading: f32, tint: Tint) -> Placement {
    Placement {
        tint,
        ..put(made, at, heading)
    }
}

/// One of a few.
pub(super) fn any<T: Copy>(rng: &mut ChaCha8Rng, of: &[T]) -> T {
    of[rng.random_range(0..of.len())]
}

/// A tree of the city.
pub(super) fn tree(rng: &mut ChaCha8Rng, species: Species, at: Vec2, scale: f32) -> Placement {
    let variant = rng.random_range(0..4);
    Placement {
        scale: Vec3::splat(scale * rng.random_range(0.9..1.1)),
        tint: species::tint(species, rng.random()),
        ..Placement::upright(
            Model::Plant(species, variant),
            on_pavement(at),
            rng.random_range(0.0..std::f32::consts::TAU),
        )
    }
}

/// Lamps, trees and small things along the four kerbs of a block.
pub(super) fn furnish(rng: &mut ChaCha8Rng, city: &City, block: &Block, placements: &mut Vec<Placement>) {
    for (side, (corner, along, out, length)) in block.sides().into_iter().enumerate() {
        let at = |along_m: f32, inset: f32| corner + along * along_m - out * inset;
        let avenue = faces_avenue(city, corner, out);
        let lamp = match block.land {
            Land::Tower | Land::Park => Made::OldLamp,
            Land::Built(_) => Made::Lamp,
        };
        let lamps = (length / LAMPS_APART).round().max(1.0);
        // Sides that face each other across a street have their lamps half a step apart.
        let shift = if side < 2 { 0.3 } else { 0.7 };
        let lamp_at = |i: f32| (i + shift) / lamps * length;
        for i in 0..lamps as u32 {
            placements.push(put(lamp, at(lamp_at(i as f32), 0.5), pointing(out)));
        }
        let near_lamp = |m: f32| (0..lamps as u32).any(|i| (lamp_at(i as f32) - m).abs() < 1.8);
        let planted = avenue || rng.random_bool(0.5);
        if planted {
            let species = any(rng, &[Species::Birch, Species::Beech, Species::Oak]);
            let scale = if species == Species::Oak { 0.62 } else { 0.56 };
            let trees = (length / 9.0).floor() as u32;
            for i in 0..trees {
                let m = (i as f32 + 0.5) / trees as f32 * length;
                if near_lamp(m) || near_wire_pole(m, length, avenue, out) {
                    continue;
                }
                placements.push(put(Made::Grate, at(m, TREES), pointing(out)));
                placements.push(tree(rng, species, at(m, TREES), scale));
            }
        }
        small_things(rng, &at, (along, out, length), planted, placements);
    }
}

/// Does a side of a block look on one of the two avenues?
fn faces_avenue(city: &City, corner: Vec2, out: Vec2) -> bool {
    (corner * out.abs()).abs().max_element() < 0.5 * city.avenue + 0.1
}

/// Signs at the corners, a bin, now and then bicycles or a post box.
fn small_things(
    rng: &mut ChaCha8Rng,
    at: &impl Fn(f32, f32) -> Vec2,
    (along, out, length): (Vec2, Vec2, f32),
    planted: bool,
    placements: &mut Vec<Placement>,
) {
    placements.push(put(Made::StreetName, at(0.7, 0.7), facing(out)));
    // Zebra stripes lie at the low end of a block.
    let crossing = if along.x + along.y > 0.0 { 4.2 } else { length - 4.2 };
    placements.push(put(Made::Crossing, at(crossing, 0.45), facing(-along)));
    if rng.random_bool(0.35) {
        placements.push(put(Made::NoParking, at(0.62 * length, 0.45), facing(-along)));
    }
    if rng.random_bool(0.7) {
        let m = rng.random_range(0.35..0.65) * length;
        placements.push(put(Made::Bin, at(m, 0.55), 0.0));
    }
    // Bicycles stand where trees do not.
    if !planted && rng.random_bool(0.6) {
        let first = rng.random_range(0.35..0.6) * length;
        for i in 0..rng.random_range(2..5) {
            let p = at(first + 1.95 * i as f32, 0.8);
            placements.push(put_tinted(Made::Bicycle, p, facing(along), any(rng, &FRAMES)));
        }
    }
    if rng.random_bool(0.12) {
        placements.push(put(Made::PostBox, at(0.22 * length, 0.6), facing(-out)));
    }
}

/// Traffic lights at the four corners of the avenues' crossing, one for each way in.
pub(super) fn traffic_lights(city: &City, placements: &mut Vec<Placement>) {
    let corner = 0.5 * city.avenue;
    for (x, z) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        let sign = Vec2::new(x, z);
        for (inset, heading) in [
            (Vec2::new(0.6, 4.6), facing(Vec2::new(0.0, z))),
            (Vec2::new(4.6, 0.6), facing(Vec2::new(x, 0.0))),
        ] {
            placements.push(put(Made::TrafficLight, sign * (corner + inset), heading));
        }
        placements.push(put(
            Made::Priority,
            sign * (corner + Vec2::new(0.6, 7.0)),
            facing(Vec2::new(0.0, z)),
        ));
    }
}

/// Parking slots along the kerbs of a block: place and heading.
pub(super) fn parking(block: &Block) -> Vec<(Vec2, Vec2)> {
    let mut slots = Vec::new();
    for (corner, along, out, length) in block.sides() {
        let count = ((length - 14.0) / 5.9).floor().max(0.0) as u32;
        for i in 0..count {
            slots.push((corner + along * (9.0 + 5.9 * i as f32) + out * 1.05, along));
        }
    }
    slots
}

/// Cars in a random choice of slots, as many as the level asks for.
pub(super) fn park_cars(
    rng: &mut ChaCha8Rng,
    city: &City,
    mut slots: Vec<(Vec2, Vec2)>,
    placements: &mut Vec<Placement>,
) {
    for _ in 0..city.cars {
        if slots.is_empty() {
            return;
        }
        let (p, along) = slots.swap_remove(rng.random_range(0..slots.len()));
        let body = match rng.random_range(0..12) {
            0..6 => Made::Hatchback,
            6..11 => Made::Estate,
            _ => Made::Lorry,
        };
        let jitter = Vec2::new(rng.random_range(-0.12..0.12), rng.random_range(-0.12..0.12)) * along.abs();
        let way = if rng.random_bool(0.85) { along } else { -along };
        placements.push(Placement {
            tint: any(rng, &CAR_PAINTS),
            ..Placement::upright(
                Model::Made(body),
                Vec3::new(p.x + jitter.x, 0.0, p.y + jitter.y),
                facing(way) + rng.random_range(-0.02..0.02),
            )
        });
    }
}

/// Places of the wire's poles along a side of `length` metres.
fn wire_poles(length: f32) -> [f32; 2] {
    [0.13 * length, 0.87 * length]
}

fn near_wire_pole(m: f32, length: f32, avenue: bool, out: Vec2) -> bool {
    avenue && out.x != 0.0 && wire_poles(length).iter().any(|pole| (pole - m).abs() < 1.6)
}

/// Poles and wires over both tracks, stops, and two trams.
pub(super) fn tram(city: &City, blocks: &[Block], track: f32, placements: &mut Vec<Placement>) -> Static {
    let mut holds: [Vec<f32>; 2] = Default::default();
    for block in blocks {
        for (corner, along, out, length) in block.sides() {
            if out.x == 0.0 || !faces_avenue(city, corner, out) {
                continue;
            }
            let side = usize::from(out.x < 0.0);
            for m in wire_poles(length) {
                let p = corner + along * m - out * POLE_INSET;
                placements.push(put(Made::WirePole, p, pointing(out)));
                holds[side].push(p.y);
            }
        }
    }
    let mut wires = MeshData::default();
    for (x, ends) in [-track, track].into_iter().zip(&mut holds) {
        ends.sort_by(f32::total_cmp);
        for pair in ends.windows(2) {
            let end = |z: f32| Vec3::new(x, WIRE_HOLD.y + KERB, z);
            let sag = 0.0016 * (pair[1] - pair[0]);
            wires.append(&props::wire(end(pair[0]), end(pair[1]), sag, 0.014), Default::default());
        }
    }
    let tint = Tint([176, 38, 34]);
    for (x, z, heading) in [(-track, 95.0, 0.0), (track, -100.0, std::f32::consts::PI)] {
        placements.push(Placement {
            tint,
            ..Placement::upright(Model::Made(Made::Tram), Vec3::new(x, 0.0, z), heading)
        });
    }
    Static::colored("wires", wires)
}
