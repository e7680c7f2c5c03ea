//! The city: blocks between streets, districts of falling height, squares, trees, furniture, cars, a lattice tower.

use bevy_math::{Vec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    buildings::{Building, Style},
    forest,
    format::{City, Level, Species},
    ground::{Ground, Step, Surface},
    meshes::{MeshData, Rgb},
    model::{Model, Placement},
    noise, props, scatter,
    scenery::{Scenery, Static},
    terrain::Terrain,
};

/// Height of pavements above streets.
const KERB: f32 = 0.15;
const PAVING: Rgb = [0.31, 0.30, 0.285];
const STONE: Rgb = [0.40, 0.39, 0.37];
const GRASS: Rgb = [0.10, 0.17, 0.045];
const ASPHALT: Rgb = [0.115, 0.115, 0.12];
const MARKING: Rgb = [0.62, 0.62, 0.6];

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

/// Generates a city.
pub fn generate(level: &Level, city: &City) -> Scenery {
    let mut rng = ChaCha8Rng::seed_from_u64(level.seed);
    let xs = columns(&mut rng, city, city.blocks.0);
    let zs = columns(&mut rng, city, city.blocks.1);
    let blocks = blocks(&xs, &zs);
    let edge = Vec2::new(xs[xs.len() - 1].1, zs[zs.len() - 1].1) + city.street;
    let mut statics = ground_tiles(level, edge);
    statics.extend(markings(&xs, &zs));
    let mut placements = Vec::new();
    let mut steps = Vec::new();
    let mut slots = Vec::new();
    for block in &blocks {
        statics.push(slab(block, city));
        steps.push(Step {
            min: block.min,
            max: block.max,
            top: KERB,
        });
        match block.land {
            Land::Built(t) => buildings_of(&mut rng, city, block, t, &mut placements),
            Land::Tower => tower_square(city, block, &mut placements),
            Land::Park => park(&mut rng, city, block, &mut placements, &mut statics),
        }
        furniture(&mut rng, block, &mut placements);
        slots.extend(parking(block));
    }
    park_cars(&mut rng, city, slots, &mut placements);
    let outskirts = Terrain::new(&level.terrain, level.seed);
    let outside = |p: Vec2| p.abs().cmpgt(edge + 6.0).any();
    let thrown = scatter::scatter(&outskirts, &level.scatter, outside, level.seed);
    placements.extend(thrown.iter().map(|thrown| forest::plant(&outskirts, thrown)));
    let blockers = placements.iter().filter_map(Placement::blocker).collect();
    Scenery {
        statics,
        placements,
        ground: Ground::new(Surface::Flat(0.0), steps, blockers).within(level.terrain.size),
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

/// Asphalt within the city's edge and grass outside, in tiles of 80 m.
fn ground_tiles(level: &Level, edge: Vec2) -> Vec<Static> {
    let cell = 8.0;
    let tile = 10;
    let half = level.terrain.size.max(edge * 2.0) * 0.5;
    let count = [half.x, half.y].map(|side| (2.0 * side / cell).ceil() as i32);
    let at = |i: i32, j: i32| Vec2::new(i as f32 - 0.5 * count[0] as f32, j as f32 - 0.5 * count[1] as f32) * cell;
    let color = |p: Vec2| {
        let base = if p.abs().cmplt(edge).all() { ASPHALT } else { GRASS };
        let light = 1.0 + 0.14 * noise::octaves(level.seed as u32, p / 23.0, 3);
        base.map(|c| c * light)
    };
    let mut tiles = Vec::new();
    for tile_j in (0..count[1]).step_by(tile) {
        for tile_i in (0..count[0]).step_by(tile) {
            let mut mesh = MeshData::default();
            let last = [
                (tile_i + tile as i32).min(count[0]),
                (tile_j + tile as i32).min(count[1]),
            ];
            for j in tile_j..=last[1] {
                for i in tile_i..=last[0] {
                    let p = at(i, j);
                    mesh.push_vertex(Vec3::new(p.x, 0.0, p.y), Vec3::Y, color(p), Vec2::ZERO);
                }
            }
            let columns = (last[0] - tile_i + 1) as u32;
            for j in 0..(last[1] - tile_j) as u32 {
                for i in 0..columns - 1 {
                    let a = j * columns + i;
                    let (b, c, d) = (a + 1, a + columns, a + columns + 1);
                    mesh.indices.extend([a, c, d, a, d, b]);
                }
            }
            tiles.push(Static::colored("ground", mesh));
        }
    }
    tiles
}

/// Pavement of a block: kerb stones around paving, lawn where people live in houses.
fn slab(block: &Block, city: &City) -> Static {
    let mut mesh = MeshData::default();
    let mut layer = |inset: f32, top: f32, color: Rgb| {
        let size = block.size() - 2.0 * inset;
        let middle = block.middle();
        mesh.push_box(
            Vec3::new(middle.x, 0.5 * (top - 0.3), middle.y),
            Vec3::new(size.x, top + 0.3, size.y),
            color,
        );
    };
    layer(0.0, KERB - 0.02, STONE);
    layer(0.25, KERB, PAVING);
    match block.land {
        Land::Park => layer(city.pavement, KERB + 0.03, GRASS),
        Land::Built(t) if t > SUBURB => layer(city.pavement, KERB + 0.03, GRASS),
        Land::Built(_) | Land::Tower => {}
    }
    Static::colored("block", mesh)
}

/// Dashes in the middle of streets and zebra stripes across the avenues' crossing.
fn markings(xs: &[(f32, f32)], zs: &[(f32, f32)]) -> Vec<Static> {
    let mut statics = Vec::new();
    for (along_x, rows, across) in [(true, zs, xs), (false, xs, zs)] {
        for pair in rows.windows(2) {
            let middle = 0.5 * (pair[0].1 + pair[1].0);
            let mut mesh = MeshData::default();
            let mut mark = |at: f32, off: f32, length: f32, width: f32| {
                let (center, size) = if along_x {
                    (Vec3::new(at, 0.0, middle + off), Vec3::new(length, 0.03, width))
                } else {
                    (Vec3::new(middle + off, 0.0, at), Vec3::new(width, 0.03, length))
                };
                mesh.push_box(center, size, MARKING);
            };
            for block in across {
                let dashes = ((block.1 - block.0 - 8.0) / 6.0).floor() as u32;
                for i in 0..dashes {
                    mark(block.0 + 7.0 + 6.0 * i as f32, 0.0, 2.6, 0.14);
                }
                let stripes = ((pair[1].0 - pair[0].1) / 1.1).floor() as u32;
                for i in 0..stripes {
                    let off = (i as f32 - 0.5 * (stripes - 1) as f32) * 1.1;
                    mark(block.0 + 2.2, off, 2.8, 0.5);
                }
            }
            statics.push(Static::colored("markings", mesh));
        }
    }
    statics
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

/// The lattice tower with benches and lamps around it.
fn tower_square(city: &City, block: &Block, placements: &mut Vec<Placement>) {
    let middle = block.middle();
    let tower = Model::LatticeTower(city.tower_height.round() as u32);
    placements.push(Placement::upright(tower, on_pavement(middle), 0.0));
    for (_, along, out, length) in block.sides() {
        let edge = middle + out * (0.5 * (block.size() * out.abs()).max_element() - city.pavement - 2.0);
        for k in [-0.3, -0.1, 0.1, 0.3] {
            placements.push(Placement::upright(
                Model::Bench,
                on_pavement(edge + along * (k * length)),
                facing(-out),
            ));
        }
        for k in [-0.2, 0.2] {
            let birch = Placement {
                scale: Vec3::splat(0.8),
                ..Placement::upright(
                    Model::Plant(Species::Birch, 2),
                    on_pavement(edge + along * (k * length)),
                    0.7,
                )
            };
            placements.push(birch);
        }
    }
}

/// A lawn with trees, bushes and benches behind a thin railing.
fn park(rng: &mut ChaCha8Rng, city: &City, block: &Block, placements: &mut Vec<Placement>, statics: &mut Vec<Static>) {
    let half = block.size() * 0.5 - city.pavement;
    let mut trees: Vec<Vec2> = Vec::new();
    for _ in 0..400 {
        let p = Vec2::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0)) * (half - 3.5);
        if trees.iter().any(|other| other.distance(p) < 6.0) {
            continue;
        }
        trees.push(p);
        let species = [Species::Oak, Species::Oak, Species::Birch][rng.random_range(0..3)];
        let model = Model::Plant(species, rng.random_range(0..4));
        placements.push(Placement {
            scale: Vec3::splat(rng.random_range(0.75..1.05)),
            ..Placement::upright(
                model,
                on_pavement(block.middle() + p),
                rng.random_range(0.0..std::f32::consts::TAU),
            )
        });
    }
    let mut railing = MeshData::default();
    for (_, along, out, _) in block.sides() {
        let (reach, side) = ((half * out.abs()).max_element(), (half * along.abs()).max_element());
        let edge = block.middle() + out * (reach - 0.4);
        // An entrance in the middle of each side.
        for part in [-1.0, 1.0] {
            let (from, to) = (edge + along * (part * 2.0), edge + along * (part * (side - 0.4)));
            props::push_railing(
                &mut railing,
                on_pavement(from),
                on_pavement(to),
                1.0,
                [0.05, 0.06, 0.055],
            );
            let bench = block.middle() + out * (reach - 2.2) + along * (part * 5.0);
            placements.push(Placement::upright(Model::Bench, on_pavement(bench), facing(-out)));
        }
    }
    statics.push(Static::colored("railing", railing));
}

/// Lamps and street trees along the kerbs.
fn furniture(rng: &mut ChaCha8Rng, block: &Block, placements: &mut Vec<Placement>) {
    for (corner, along, out, length) in block.sides() {
        let lamps = (length / 24.0).floor().max(1.0);
        for i in 0..lamps as u32 {
            let at = (i as f32 + 0.5) / lamps * length;
            let p = corner + along * at - out * 0.5;
            placements.push(Placement::upright(Model::Lamp, on_pavement(p), pointing(out)));
        }
        if rng.random_bool(0.45) {
            continue;
        }
        let trees = (length / 8.0).floor() as u32;
        for i in 0..trees {
            let at = (i as f32 + 0.5) / trees as f32 * length;
            let near_lamp = (0..lamps as u32).any(|k| ((k as f32 + 0.5) / lamps * length - at).abs() < 1.5);
            if near_lamp {
                continue;
            }
            let model = Model::Plant(Species::Birch, rng.random_range(0..4));
            placements.push(Placement {
                scale: Vec3::splat(rng.random_range(0.55..0.7)),
                ..Placement::upright(
                    model,
                    on_pavement(corner + along * at - out * 1.1),
                    rng.random_range(0.0..6.0),
                )
            });
        }
    }
}

/// Parking slots along the kerbs of a block: place and heading.
fn parking(block: &Block) -> Vec<(Vec2, Vec2)> {
    let mut slots = Vec::new();
    for (corner, along, out, length) in block.sides() {
        let count = ((length - 14.0) / 5.6).floor().max(0.0) as u32;
        for i in 0..count {
            slots.push((corner + along * (9.0 + 5.6 * i as f32) + out * 1.15, along));
        }
    }
    slots
}

fn park_cars(rng: &mut ChaCha8Rng, city: &City, mut slots: Vec<(Vec2, Vec2)>, placements: &mut Vec<Placement>) {
    for _ in 0..city.cars {
        if slots.is_empty() {
            return;
        }
        let (p, along) = slots.swap_remove(rng.random_range(0..slots.len()));
        let paint = rng.random_range(0..props::CAR_PAINTS.len()) as u8;
        placements.push(Placement::upright(
            Model::Car(paint),
            Vec3::new(p.x, 0.0, p.y),
            facing(along),
        ));
    }
}
