//! What one walks and drives on: asphalt, pavements with kerbs, lawns, markings, rails.

use bevy_math::{Vec2, Vec3};

use super::{ASPHALT, Block, GRASS, KERB, Land, PAVING, STONE, SUBURB, track};
use crate::level::{
    cover::Cover,
    format::{City, Level},
    meshes::{MeshData, Rgb},
    noise,
    scenery::{Finish, Static},
};

const MARKING: Rgb = [0.62, 0.62, 0.6];
const IRON: Rgb = [0.075, 0.07, 0.066];
const RAIL: Rgb = [0.27, 0.265, 0.26];

/// Tiles of streets and built blocks.
const STREET: [&str; 4] = ["asphalt", "paving", "cobbles", "grass"];
/// Tiles of parks.
const PARK: [&str; 4] = ["gravel", "paving", "path", "grass"];

/// A mesh of ground with the weights of its tiles, and colours that stand in for them.
#[derive(Default)]
struct Carpet {
    mesh: MeshData,
    weights: Vec<[f32; 4]>,
}

impl Carpet {
    /// A vertex that looks up, all of one tile.
    fn push(&mut self, p: Vec2, height: f32, tile: usize, color: Rgb, light: f32) -> u32 {
        let mut weights = [0.0; 4];
        weights[tile] = light;
        self.weights.push(weights);
        let at = Vec3::new(p.x, height, p.y);
        self.mesh.push_vertex(at, Vec3::Y, color.map(|c| c * light), Vec2::ZERO)
    }

    /// A rectangle of one tile.
    fn rectangle(&mut self, min: Vec2, max: Vec2, height: f32, tile: usize, color: Rgb) {
        let [a, b, c, d] = [min, Vec2::new(min.x, max.y), max, Vec2::new(max.x, min.y)]
            .map(|p| self.push(p, height, tile, color, 1.0));
        self.mesh.indices.extend([a, b, c, a, c, d]);
    }

    fn finish(self, name: &'static str, tiles: [&'static str; 4]) -> Static {
        Static {
            name,
            mesh: self.mesh,
            finish: Finish::Cover(Cover {
                tiles,
                weights: self.weights,
            }),
        }
    }
}

/// Asphalt within the city's edge and grass outside, in tiles of 80 m.
pub(super) fn tiles(level: &Level, edge: Vec2) -> Vec<Static> {
    let cell = 8.0;
    let tile = 10;
    let half = level.terrain.size.max(edge * 2.0) * 0.5;
    let count = [half.x, half.y].map(|side| (2.0 * side / cell).ceil() as i32);
    let at = |i: i32, j: i32| Vec2::new(i as f32 - 0.5 * count[0] as f32, j as f32 - 0.5 * count[1] as f32) * cell;
    let mut tiles = Vec::new();
    for tile_j in (0..count[1]).step_by(tile) {
        for tile_i in (0..count[0]).step_by(tile) {
            let mut carpet = Carpet::default();
            let last = [
                (tile_i + tile as i32).min(count[0]),
                (tile_j + tile as i32).min(count[1]),
            ];
            for j in tile_j..=last[1] {
                for i in tile_i..=last[0] {
                    let p = at(i, j);
                    let light = 1.0 + 0.14 * noise::octaves(level.seed as u32, p / 23.0, 3);
                    let inside = p.abs().cmplt(edge).all();
                    let (tile, color) = if inside { (0, ASPHALT) } else { (3, GRASS) };
                    carpet.push(p, 0.0, tile, color, light);
                }
            }
            let columns = (last[0] - tile_i + 1) as u32;
            for j in 0..(last[1] - tile_j) as u32 {
                for i in 0..columns - 1 {
                    let a = j * columns + i;
                    let (b, c, d) = (a + 1, a + columns, a + columns + 1);
                    carpet.mesh.indices.extend([a, c, d, a, d, b]);
                }
            }
            tiles.push(carpet.finish("ground", STREET));
        }
    }
    tiles
}

/// Pavement of a block: kerb stones around paving; setts on squares, lawns where people live in houses and in parks.
pub(super) fn slab(block: &Block, city: &City) -> Vec<Static> {
    let mut stone = MeshData::default();
    kerb(&mut stone, block);
    let mut carpet = Carpet::default();
    let inner = |inset: f32| (block.min + inset, block.max - inset);
    let (min, max) = inner(KERB_WIDTH);
    let parts = match block.land {
        Land::Park => {
            carpet.rectangle(min, max, KERB, 1, PAVING);
            park_lawns(&mut carpet, block, city);
            carpet.finish("block", PARK)
        }
        Land::Tower => {
            carpet.rectangle(min, max, KERB, 1, PAVING);
            let (min, max) = inner(city.pavement);
            carpet.rectangle(min, max, KERB + LAYER, 2, STONE);
            carpet.finish("block", STREET)
        }
        Land::Built(t) => {
            carpet.rectangle(min, max, KERB, 1, PAVING);
            if t > SUBURB {
                let (min, max) = inner(city.pavement);
                carpet.rectangle(min, max, KERB + LAYER, 3, GRASS);
            }
            carpet.finish("block", STREET)
        }
    };
    vec![Static::colored("kerb", stone), parts]
}

/// Width of kerb stones in metres.
const KERB_WIDTH: f32 = 0.25;
/// How far one layer of ground lies above the one below, against flicker.
const LAYER: f32 = 0.025;

/// Kerb stones around a block: about 1 m long, with joints, no two quite the same grey.
fn kerb(mesh: &mut MeshData, block: &Block) {
    for (corner, along, out, length) in block.sides() {
        let count = (length / 1.0).round().max(1.0);
        for i in 0..count as u32 {
            let (from, to) = (i as f32 / count * length, (i as f32 + 1.0) / count * length - 0.012);
            let middle = corner + along * (0.5 * (from + to)) - out * (0.5 * KERB_WIDTH);
            let size = (along.abs() * (to - from) + out.abs() * KERB_WIDTH).max(Vec2::splat(0.05));
            let grey = 0.9 + 0.2 * noise::signed(7, (middle.x * 8.0) as i32, (middle.y * 8.0) as i32).abs();
            mesh.push_box(
                Vec3::new(middle.x, 0.5 * (KERB - 0.3), middle.y),
                Vec3::new(size.x, KERB + 0.3, size.y),
                STONE.map(|c| c * grey),
            );
        }
    }
}

/// Half the width of the ways that cross a park, and radius of the place in its middle, in metres.
pub(super) const PARK_WAY: f32 = 2.0;
/// See [`PARK_WAY`].
pub(super) const PARK_PLACE: f32 = 8.5;

/// Four lawns between gravel ways that meet around the fountain.
fn park_lawns(carpet: &mut Carpet, block: &Block, city: &City) {
    let (min, max) = (block.min + city.pavement, block.max - city.pavement);
    carpet.rectangle(min, max, KERB + LAYER, 0, [0.24, 0.22, 0.19]);
    let middle = block.middle();
    let height = KERB + 2.0 * LAYER;
    for corner in [min, Vec2::new(max.x, min.y), max, Vec2::new(min.x, max.y)] {
        // Seen from the middle: two edges of the lawn, cut by the round place.
        let toward = (corner - middle).signum();
        let far = (corner - middle).abs() - 0.6;
        let point = |x: f32, z: f32| middle + toward * Vec2::new(x, z);
        let steps = 6;
        let start = (PARK_PLACE * PARK_PLACE - PARK_WAY * PARK_WAY).sqrt();
        let from = (PARK_WAY / start).atan();
        let mut ring = vec![point(far.x, PARK_WAY), point(far.x, far.y), point(PARK_WAY, far.y)];
        for step in 0..=steps {
            let angle = std::f32::consts::FRAC_PI_2 - from
                + (2.0 * from - std::f32::consts::FRAC_PI_2) * step as f32 / steps as f32;
            ring.push(point(PARK_PLACE * angle.cos(), PARK_PLACE * angle.sin()));
        }
        let corners: Vec<u32> = ring.iter().map(|p| carpet.push(*p, height, 3, GRASS, 1.0)).collect();
        // A fan from the far corner, which sees all others.
        let fan = corners[1];
        let rest: Vec<u32> = corners[2..].iter().chain(&corners[..1]).copied().collect();
        for pair in rest.windows(2) {
            let triangle = if toward.x * toward.y > 0.0 {
                [fan, pair[1], pair[0]]
            } else {
                [fan, pair[0], pair[1]]
            };
            carpet.mesh.indices.extend(triangle);
        }
    }
}

/// Dashes in the middle of streets, zebra stripes across them, covers of manholes; rails in the avenue.
pub(super) fn markings(xs: &[(f32, f32)], zs: &[(f32, f32)], city: &City) -> Vec<Static> {
    let mut statics = Vec::new();
    for (along_x, rows, across) in [(true, zs, xs), (false, xs, zs)] {
        for pair in rows.windows(2) {
            let middle = 0.5 * (pair[0].1 + pair[1].0);
            let mut mesh = MeshData::default();
            let place = |at: f32, off: f32| {
                if along_x {
                    Vec3::new(at, 0.0, middle + off)
                } else {
                    Vec3::new(middle + off, 0.0, at)
                }
            };
            let size = |length: f32, height: f32, width: f32| {
                if along_x {
                    Vec3::new(length, height, width)
                } else {
                    Vec3::new(width, height, length)
                }
            };
            for block in across {
                let dashes = ((block.1 - block.0 - 8.0) / 6.0).floor() as u32;
                for i in 0..dashes {
                    mesh.push_box(
                        place(block.0 + 7.0 + 6.0 * i as f32, 0.0),
                        size(2.6, 0.03, 0.14),
                        MARKING,
                    );
                }
                let stripes = ((pair[1].0 - pair[0].1) / 1.1).floor() as u32;
                for i in 0..stripes {
                    let off = (i as f32 - 0.5 * (stripes - 1) as f32) * 1.1;
                    mesh.push_box(place(block.0 + 2.2, off), size(2.8, 0.03, 0.5), MARKING);
                }
                let cover = place(0.7 * block.0 + 0.3 * block.1, 1.6);
                mesh.push_round((cover, 0.33), (cover + Vec3::Y * 0.012, 0.33), 12, (IRON, IRON));
            }
            statics.push(Static::colored("markings", mesh));
        }
    }
    statics.extend(track(city).map(|track| rails(zs, track)));
    statics
}

/// Two tracks of grooved rails, 1 m gauge, in the avenue along z.
fn rails(zs: &[(f32, f32)], track: f32) -> Static {
    let mut mesh = MeshData::default();
    let (from, to) = (zs[0].0, zs[zs.len() - 1].1);
    for middle in [-track, track] {
        for side in [-0.5, 0.5] {
            let x = middle + side;
            let inner = -0.055 * f32::signum(side);
            for (off, width, height, color) in [(0.0, 0.06, 0.036, RAIL), (inner, 0.05, 0.02, [0.02; 3])] {
                let center = Vec3::new(x + off, 0.0, 0.5 * (from + to));
                mesh.push_box(center, Vec3::new(width, height, to - from), color);
            }
        }
    }
    Static::colored("rails", mesh)
}
