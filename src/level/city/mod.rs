//! The city: blocks between streets, districts of falling height, squares, trees, furniture, cars, a tram, a lattice
//! tower.
//!
//! ```text
//! columns ──► blocks ──► buildings_of                     what stands on each
//!                   ├──► ground: asphalt, kerbs, lawns, markings, rails
//!                   ├──► kerbside: lamps, trees, signs, cars, poles and wires of the tram
//!                   └──► squares: tower, kiosk, café; park with a fountain
//! ```

use bevy_math::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

mod ground;
mod kerbside;
mod squares;

use super::{
    buildings::{Building, Style},
    forest,
    format::{City, Level},
    ground::{Ground, Step, Surface},
    made::WIRE_HOLD,
    meshes::Rgb,
    model::{Model, Placement},
    scatter,
    scenery::Scenery,
    terrain::Terrain,
};

/// Distance of the wire's poles from the kerb.
const POLE_INSET: f32 = 0.5;
/// Height of pavements above streets.
const KERB: f32 = 0.15;
const PAVING: Rgb = [0.31, 0.30, 0.285];
const STONE: Rgb = [0.40, 0.39, 0.37];
const GRASS: Rgb = [0.10, 0.17, 0.045];
const ASPHALT: Rgb = [0.115, 0.115, 0.12];

/// One block, pavement included.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Block {
    min: Vec2,
    max: Vec2,
    /// How it is used.
    land: Land,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Land {
    /// 0 in the middle of the city, 1 at its edge.
    Built(f32),
    /// The square of the tower.
    Tower,
    /// Grass and trees.
    Park,
}

impl Block {
    fn size(&self) -> Vec2 {
        self.max - self.min
    }

    fn middle(&self) -> Vec2 {
        (self.min + self.max) * 0.5
    }

    /// The four sides: first corner, unit vector along, unit vector out to the street, length.
    fn sides(&self) -> [(Vec2, Vec2, Vec2, f32); 4] {
        let size = self.size();
        [
            (self.min, Vec2::X, Vec2::NEG_Y, size.x),
            (self.min.with_x(self.max.x), Vec2::Y, Vec2::X, size.y),
            (self.max, Vec2::NEG_X, Vec2::Y, size.x),
            (self.max.with_x(self.min.x), Vec2::NEG_Y, Vec2::NEG_X, size.y),
        ]
    }
}

/// Heading of a model whose +z is to look along `d`.
fn facing(d: Vec2) -> f32 {
    d.x.atan2(d.y)
}

/// Heading of a model whose +x is to point along `d`.
fn pointing(d: Vec2) -> f32 {
    (-d.y).atan2(d.x)
}

fn on_pavement(p: Vec2) -> Vec3 {
    Vec3::new(p.x, KERB, p.y)
}

/// Distance of the tram's tracks from the middle of the avenue along z: as far from its kerbs as the brackets of the
/// wire reach. `None`: the avenue is too narrow for a tram.
fn track(city: &City) -> Option<f32> {
    let track = 0.5 * city.avenue - (WIRE_HOLD.x - POLE_INSET);
    (track > 1.5).then_some(track)
}

/// Generates a city.
pub fn generate(level: &Level, city: &City) -> Scenery {
    let mut rng = ChaCha8Rng::seed_from_u64(level.seed);
    let xs = columns(&mut rng, city, city.blocks.0);
    let zs = columns(&mut rng, city, city.blocks.1);
    let blocks = blocks(&xs, &zs);
    let edge = Vec2::new(xs[xs.len() - 1].1, zs[zs.len() - 1].1) + city.street;
    let mut statics = ground::tiles(level, edge);
    statics.extend(ground::markings(&xs, &zs, city));
    let mut placements = Vec::new();
    let mut steps = Vec::new();
    let mut slots = Vec::new();
    let mut blockers = Vec::new();
    for block in &blocks {
        statics.extend(ground::slab(block, city));
        steps.push(Step {
            min: block.min,
            max: block.max,
            top: KERB,
        });
        match block.land {
            Land::Built(t) => buildings_of(&mut rng, city, block, t, &mut placements),
            Land::Tower => {
                squares::tower_square(&mut rng, city, block, &mut placements);
                blockers.extend(squares::tower_feet(city, block));
            }
            Land::Park => squares::park(&mut rng, city, block, &mut placements),
        }
        kerbside::furnish(&mut rng, city, block, &mut placements);
        slots.extend(kerbside::parking(block));
    }
    kerbside::traffic_lights(city, &mut placements);
    if let Some(track) = track(city) {
        statics.push(kerbside::tram(city, &blocks, track, &mut placements));
    }
    kerbside::park_cars(&mut rng, city, slots, &mut placements);
    let outskirts = Terrain::new(&level.terrain, level.seed);
    let outside = |p: Vec2| p.abs().cmpgt(edge + 6.0).any();
    let thrown = scatter::scatter(&outskirts, &level.scatter, outside, level.seed);
    placements.extend(thrown.iter().map(|thrown| forest::plant(&outskirts, thrown)));
    blockers.extend(placements.iter().filter_map(Placement::blocker));
    Scenery {
        statics,
        placements,
        ground: Ground::new(Surface::Flat(0.0), steps, blockers).within(level.terrain.size),
        ..Scenery::default()
    }
}

/// Start and end of each row of blocks along one axis; the avenue between the two middle ones lies on the origin.
fn columns(rng: &mut ChaCha8Rng, city: &City, count: u32) -> Vec<(f32, f32)> {
    let half = count / 2;
    let mut columns = Vec::new();
    let mut at = 0.5 * city.avenue;
    for _ in half..count {
        let side = rng.random_range(city.block_side.0..=city.block_side.1);
        columns.push((at, at + side));
        at += side + city.street;
    }
    at = -0.5 * city.avenue;
    for _ in 0..half {
        let side = rng.random_range(city.block_side.0..=city.block_side.1);
        columns.insert(0, (at - side, at));
        at -= side + city.street;
    }
    columns
}

fn blocks(xs: &[(f32, f32)], zs: &[(f32, f32)]) -> Vec<Block> {
    let middle = [xs.len() / 2, zs.len() / 2];
    let reach = Vec2::new(xs[xs.len() - 1].1, zs[zs.len() - 1].1);
    let mut blocks = Vec::new();
    for (j, z) in zs.iter().enumerate() {
        for (i, x) in xs.iter().enumerate() {
            let (min, max) = (Vec2::new(x.0, z.0), Vec2::new(x.1, z.1));
            let land = if [i, j] == middle {
                Land::Tower
            } else if [i + 1, j + 1] == middle || [i, j + 2] == [xs.len() - 1, zs.len() - 1] {
                Land::Park
            } else {
                Land::Built(((min + max) * 0.5 / reach).abs().max_element().min(1.0))
            };
            blocks.push(Block { min, max, land });
        }
    }
    blocks
}

/// From here on outwards people live in houses.
const SUBURB: f32 = 0.72;
/// Up to here offices stand.
const CENTRE: f32 = 0.42;

/// Two rows of buildings along the longer axis of a block.
fn buildings_of(rng: &mut ChaCha8Rng, city: &City, block: &Block, t: f32, placements: &mut Vec<Placement>) {
    let inset = city.pavement + if t > SUBURB { 1.5 } else { 0.0 };
    let (min, size) = (block.min + inset, block.size() - 2.0 * inset);
    let along_x = size.x >= size.y;
    let (long, short) = if along_x { (size.x, size.y) } else { (size.y, size.x) };
    let lot = if t > SUBURB { 13.0 } else { 17.0 };
    for row in 0..2 {
        let lots = (long / lot).round().max(1.0) as u32;
        let mut cuts: Vec<f32> = (0..=lots).map(|i| i as f32 / lots as f32 * long).collect();
        for cut in &mut cuts[1..lots as usize] {
            *cut += rng.random_range(-2.0..2.0);
        }
        for (lot_number, pair) in cuts.windows(2).enumerate() {
            let gap = if t > SUBURB {
                3.0
            } else {
                [0.3, 0.3, 2.5][rng.random_range(0..3)]
            };
            let width = pair[1] - pair[0] - gap;
            let depth = 0.5 * short * rng.random_range(0.72..0.88);
            let (floors, style) = storeys(rng, city, t);
            // Façades stand on the pavement's edge and look to the street.
            let across = if row == 0 { 0.5 * depth } else { short - 0.5 * depth };
            let middle = 0.5 * (pair[0] + pair[1]);
            let (along, outward) = if along_x {
                (Vec2::X, Vec2::Y)
            } else {
                (Vec2::Y, Vec2::X)
            };
            let front = if row == 0 { -outward } else { outward };
            // Where the next building is a hand's breadth away, there are no windows.
            let narrow = gap < 1.0;
            let (before, after) = (narrow && lot_number > 0, narrow && lot_number + 1 < lots as usize);
            // To the right of one who looks at the front; y of the plan is z of the world.
            let right = Vec2::new(front.y, -front.x);
            let decimetres = |metres: f32| (metres * 10.0) as u16;
            let paint = rng.random();
            let building = Building {
                width_dm: decimetres(width),
                depth_dm: decimetres(depth),
                floors,
                style,
                blind: if right.dot(along) > 0.0 {
                    (after, before)
                } else {
                    (before, after)
                },
                detail: rng.random(),
            };
            placements.push(Placement {
                tint: building.tint(paint),
                ..Placement::upright(
                    Model::Building(building),
                    on_pavement(min + along * middle + outward * across),
                    facing(front),
                )
            });
        }
    }
}

/// How high and in which style one builds at this distance from the middle.
fn storeys(rng: &mut ChaCha8Rng, city: &City, t: f32) -> (u16, Style) {
    let most = city.max_floors as f32;
    let (low, high, styles): (f32, f32, &[Style]) = if t < CENTRE {
        (
            0.35,
            1.0 - 0.6 * t,
            &[Style::Brick, Style::Ribbon, Style::Office, Style::Office],
        )
    } else if t < SUBURB {
        (
            0.18,
            0.36,
            &[Style::Stucco, Style::Concrete, Style::Stucco, Style::Brick],
        )
    } else {
        (0.08, 0.15, &[Style::House, Style::House, Style::House, Style::Stucco])
    };
    let share: f32 = rng.random();
    let floors = most * (low + (high - low) * share * share.sqrt());
    (
        floors.round().clamp(2.0, 200.0) as u16,
        styles[rng.random_range(0..styles.len())],
    )
}
