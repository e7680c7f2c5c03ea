//! Ground of the city: asphalt, slabs, setts, gravel.

use bevy_math::{Vec2, Vec3};

use super::sheet::{Place, Sheet};
use crate::forge::{
    portable::{mix, smooth},
    texture::noise::{cells, octaves, ridges},
};

/// Aggregate in bitumen: worn light where tyres go, with hair cracks and stains.
pub(super) fn asphalt() -> Sheet {
    const WIDTH: f32 = 3.0;
    Sheet::new(WIDTH, |p| {
        let stone = cells(401, p, (170, 170));
        let fine = octaves(402, p, (210, 210), 1);
        let patch = octaves(403, p, (3, 3), 4);
        let stain = smooth(0.16, 0.34, octaves(404, p, (4, 4), 4));
        let wander = Vec2::new(octaves(405, p, (6, 6), 4), octaves(406, p, (6, 6), 4));
        let crack = smooth(0.985, 0.998, ridges(407, p + 0.05 * wander, (5, 5), 1)) * smooth(0.12, 0.22, wander.x);
        let top = smooth(0.65, 0.15, stone.nearest);
        let bitumen = Vec3::new(0.070, 0.070, 0.072);
        let grain = mix(0.085, 0.20, stone.id * stone.id);
        let color = bitumen.lerp(Vec3::new(grain, grain * 0.985, grain * 0.96), top * 0.75);
        let light = (1.0 + 0.35 * patch + 0.35 * fine) * (1.0 - 0.28 * stain) * (1.0 - 0.55 * crack);
        Place {
            height: 0.0035 * top * (0.6 + 0.4 * stone.id) + 0.003 * fine + 0.004 * patch - 0.004 * crack,
            color: color * light,
        }
    })
}

/// Where a point lies on a stone of a course.
struct Stone {
    /// Metres to the nearest edge.
    inside: f32,
    /// Offset from its middle, −1..=1 both ways.
    offset: Vec2,
    /// A number in 0..=1 of its own.
    id: f32,
    /// Another one.
    other: f32,
}

/// A number in 0..=1 that belongs to a stone.
fn chance(seed: u32, row: i64, column: i64) -> f32 {
    let at = Vec2::new(column as f32 + 0.5, row as f32 + 0.5) / 64.0;
    cells(seed, at, (64, 64)).id
}

/// Concrete slabs of 60 by 40 centimetres in running bond.
pub(super) fn paving() -> Sheet {
    const WIDTH: f32 = 2.4;
    const SLAB: Vec2 = Vec2::new(0.6, 0.4);
    const JOINT: f32 = 0.004;
    Sheet::new(WIDTH, |p| {
        // No joint lies on the edge of the tile, where it would have to match itself.
        let stone = running_bond(p * WIDTH + SLAB * 0.25, SLAB, WIDTH);
        let grain = octaves(411, p, (120, 120), 2);
        let speck = cells(412, p, (190, 190)).id;
        let patch = octaves(413, p, (3, 3), 4);
        let stain = smooth(0.18, 0.36, octaves(414, p, (5, 5), 4));
        let spot = cells(415, p, (11, 11));
        let gum = smooth(0.10, 0.07, spot.nearest) * smooth(0.82, 0.84, spot.id);
        let joint = smooth(JOINT + 0.003, JOINT - 0.003, stone.inside);
        let bevel = smooth(0.0, 0.014, stone.inside - JOINT);
        let tilt = Vec2::new(stone.id - 0.5, stone.other - 0.5).dot(stone.offset) * 0.004;
        let tone = Vec3::new(0.270, 0.258, 0.240).lerp(Vec3::new(0.355, 0.345, 0.325), stone.id);
        let warm = Vec3::new(1.03, 1.0, 0.95).lerp(Vec3::new(0.98, 1.0, 1.03), stone.other);
        let slab = tone
            * warm
            * (1.0 + 0.16 * grain + 0.16 * (speck - 0.5) + 0.22 * patch)
            * (1.0 - 0.22 * stain)
            * (1.0 - 0.30 * gum)
            * mix(0.86, 1.0, bevel);
        Place {
            height: 0.006 * bevel + tilt + 0.0012 * grain - 0.006 * joint,
            color: slab.lerp(Vec3::new(0.085, 0.080, 0.070) * (1.0 + 0.8 * grain), joint),
        }
    })
}

/// Slabs in rows, every other row shifted by half a slab.
#[expect(clippy::cast_possible_truncation, reason = "a few rows")]
fn running_bond(p: Vec2, slab: Vec2, width: f32) -> Stone {
    let row = (p.y / slab.y).floor();
    let shift = if row as i64 % 2 == 0 { 0.0 } else { 0.5 };
    let columns = (width / slab.x).round() as i64;
    let across = p.x / slab.x + shift;
    let column = (across.floor() as i64).rem_euclid(columns);
    let within = Vec2::new(across - across.floor(), p.y / slab.y - row);
    let from_edges = (Vec2::splat(0.5) - (within - 0.5).abs()) * slab;
    let rows = (width / slab.y).round() as i64;
    let row = (row as i64).rem_euclid(rows);
    Stone {
        inside: from_edges.min_element(),
        offset: (within - 0.5) * 2.0,
        id: chance(421, row, column),
        other: chance(422, row, column),
    }
}

/// Granite setts of about 9 centimetres, laid in segments of arcs, with sand between them.
pub(super) fn cobbles() -> Sheet {
    const WIDTH: f32 = 1.92;
    Sheet::new(WIDTH, |p| {
        let wobble = Vec2::new(octaves(431, p, (10, 10), 2), octaves(432, p, (10, 10), 2));
        let stone = sett(p + 0.006 * wobble);
        let grain = octaves(433, p, (100, 100), 2);
        let speck = cells(434, p, (170, 170)).id;
        let patch = octaves(435, p, (3, 3), 4);
        let body = smooth(0.0, 0.013, stone.inside - 0.004 + 0.002 * grain);
        let dome = (1.0 - 0.5 * stone.offset.length_squared()).max(0.0);
        let tilt = Vec2::new(stone.id - 0.5, stone.other - 0.5).dot(stone.offset) * 0.006;
        let tone = Vec3::new(0.150, 0.146, 0.142).lerp(Vec3::new(0.290, 0.282, 0.268), stone.id);
        let tone = tone.lerp(Vec3::new(0.235, 0.190, 0.160), 0.55 * smooth(0.72, 0.95, stone.other));
        let granite = tone * (1.0 + 0.35 * grain + 0.34 * (speck - 0.5) + 0.2 * patch);
        let mossy = smooth(0.05, 0.3, patch);
        let sand = Vec3::new(0.085, 0.076, 0.062).lerp(Vec3::new(0.055, 0.062, 0.028), mossy) * (1.0 + 0.9 * grain);
        Place {
            height: body * (0.010 + 0.007 * dome + 0.004 * stone.other + tilt) + 0.0015 * grain,
            color: sand.lerp(granite, body),
        }
    })
}

/// The sett at a place: rows of 20 bend over four arcs per tile.
#[expect(clippy::cast_possible_truncation, reason = "a few rows")]
fn sett(p: Vec2) -> Stone {
    const ROWS: i64 = 20;
    const COLUMNS: i64 = 20;
    const SIDE: f32 = 1.92 / 20.0;
    // Two arcs side by side: their rise is a parabola, highest in their middle.
    let arc = p.x * 2.0 - (p.x * 2.0).floor() - 0.5;
    let rise = 0.10 * (1.0 - 4.0 * arc * arc);
    let along = (p.y + rise) * ROWS as f32;
    let row = along.floor();
    let index = (row as i64).rem_euclid(ROWS);
    let shift = chance(441, index, 63);
    let across = p.x * COLUMNS as f32 + shift;
    // Joints wander, so that no two setts are equally wide.
    let joint = |k: i64| k as f32 + 0.34 * (chance(442, index, k.rem_euclid(COLUMNS)) - 0.5);
    let mut column = across.floor() as i64;
    if across < joint(column) {
        column -= 1;
    } else if across >= joint(column + 1) {
        column += 1;
    }
    let (left, right) = (joint(column), joint(column + 1));
    let share = (across - left) / (right - left);
    let within = Vec2::new(share, along - row);
    let size = Vec2::new((right - left) * SIDE, SIDE);
    let from_edges = (Vec2::splat(0.5) - (within - 0.5).abs()) * size;
    // Rounded corners.
    let radius = 0.016;
    let corner = (Vec2::splat(radius) - from_edges).max(Vec2::ZERO);
    let inside = if corner.min_element() > 0.0 {
        radius - corner.length()
    } else {
        from_edges.min_element()
    };
    let column = column.rem_euclid(COLUMNS);
    Stone {
        inside,
        offset: (within - 0.5) * 2.0,
        id: chance(443, index, column),
        other: chance(444, index, column),
    }
}

/// Rounded gravel in two sizes.
pub(super) fn gravel() -> Sheet {
    const WIDTH: f32 = 1.6;
    Sheet::new(WIDTH, |p| {
        let wander = Vec2::new(octaves(451, p, (24, 24), 2), octaves(452, p, (24, 24), 2));
        let small = cells(453, p + 0.006 * wander, (110, 110));
        let large = cells(454, p + 0.010 * wander, (52, 52));
        let bump = octaves(455, p, (3, 3), 4);
        let dome = |stone: f32| (1.0 - 1.9 * stone * stone).max(0.0);
        let lies = smooth(0.35, 0.45, large.id);
        let (top, over) = (0.013 * dome(large.nearest) * lies, 0.005 * dome(small.nearest));
        let big = smooth(-0.001, 0.001, top - over);
        let id = mix(small.id, (large.id - 0.4) / 0.6, big);
        let tone = Vec3::new(0.170, 0.155, 0.135).lerp(Vec3::new(0.370, 0.345, 0.305), id * id);
        let tone = tone.lerp(Vec3::new(0.30, 0.235, 0.165), 0.5 * smooth(0.6, 0.7, 1.0 - id));
        let edge = mix(dome(small.nearest), dome(large.nearest), big);
        Place {
            height: top.max(over) + 0.012 * bump,
            color: tone * mix(0.42, 1.05, smooth(0.0, 0.75, edge)) * (1.0 + 0.25 * bump),
        }
    })
}
