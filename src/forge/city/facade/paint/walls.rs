//! Strips: walls, roofs, trimmings. Points are shares of the strip, x right, y *up*; everything repeats to the right.

use bevy_math::{Vec2, Vec3};

use super::{random, within};
use crate::forge::{
    city::facade::atlas::BAYS_PER_TURN,
    portable::{TURN, mix, sin, smooth},
    texture::noise::{octaves, ridges},
};

/// Place within a bay, 0..1; and a weight that is 1 in the bay and falls to 0 at its borders.
fn in_bay(p: Vec2) -> (f32, f32) {
    let x = (p.x * BAYS_PER_TURN as f32).fract();
    (x, smooth(0.0, 0.12, x) * smooth(1.0, 0.88, x))
}

/// Rain marks: under sills in the middle of bays, and from the upper border down.
fn dirt(p: Vec2, sill: f32) -> f32 {
    let (x, inside) = in_bay(p);
    let streaks = smooth(-0.15, 0.5, octaves(31, Vec2::new(p.x, 0.13 * p.y), (160, 2), 2));
    let below = smooth(sill - 0.26, sill - 0.03, p.y) * smooth(sill + 0.06, sill - 0.02, p.y);
    let under = smooth(0.30, 0.16, (x - 0.5).abs()) * below;
    let ends = smooth(0.1, 0.02, ((x - 0.5).abs() - 0.24).abs()) * below;
    let top = smooth(0.75, 1.0, p.y);
    let blotch = smooth(-0.1, 0.6, octaves(33, p, (20, 5), 3)) * inside;
    (0.5 * streaks * (0.8 * under + 0.5 * top) + 0.35 * ends * streaks + 0.28 * blotch).min(1.0)
}

pub(super) fn plaster(p: Vec2) -> Vec3 {
    let grain = 1.0 + 0.07 * octaves(1, p, (256, 64), 2) + 0.05 * octaves(2, p, (24, 6), 3);
    let clean = Vec3::splat(0.80 * grain);
    clean.lerp(Vec3::new(0.36, 0.33, 0.29), 0.75 * dirt(p, 0.23))
}

pub(super) fn ashlar(p: Vec2) -> Vec3 {
    // Courses of blocks with open joints; the lowest is a plinth.
    let courses = 9.0;
    let row = (p.y * courses).floor();
    let (in_row, shift) = ((p.y * courses).fract(), if row as i32 % 2 == 0 { 0.0 } else { 0.5 });
    let blocks = 16.0;
    let column = (p.x * blocks + shift).floor().rem_euclid(blocks);
    let in_block = (p.x * blocks + shift).fract();
    let edge = in_block.min(1.0 - in_block) * 0.8 / 0.05;
    let joint = smooth(0.0, 1.0, (in_row.min(1.0 - in_row) * 0.48 / 0.045).min(edge));
    let tone = 0.70 + 0.10 * random(5, column as i32, row as i32);
    let grain = 1.0 + 0.10 * octaves(6, p, (192, 64), 2);
    // Lit upper edges, shaded lower ones.
    let relief = 1.0 + 0.10 * smooth(0.8, 0.92, in_row) - 0.10 * smooth(0.2, 0.08, in_row);
    let splash = smooth(0.3, 0.02, p.y) * (0.65 + 0.5 * octaves(8, p, (64, 8), 2));
    let stone = Vec3::new(1.0, 0.97, 0.92) * tone * grain * relief * mix(0.42, 1.0, joint);
    stone.lerp(Vec3::new(0.22, 0.20, 0.18), (0.6 * splash).clamp(0.0, 1.0))
}

pub(super) fn brick(p: Vec2) -> Vec3 {
    let (courses, bricks) = (40.0, 48.0);
    let row = (p.y * courses).floor();
    let shift = if row as i32 % 2 == 0 { 0.0 } else { 0.5 };
    let column = (p.x * bricks + shift).floor().rem_euclid(bricks);
    let (in_row, in_brick) = ((p.y * courses).fract(), (p.x * bricks + shift).fract());
    let mortar = in_row < 0.22 || in_brick < 0.07;
    let tone = random(11, column as i32, row as i32);
    let burnt = random(12, column as i32, row as i32);
    let grain = 1.0 + 0.12 * octaves(13, p, (256, 80), 2);
    let clay = Vec3::new(0.36, 0.135, 0.085).lerp(Vec3::new(0.46, 0.21, 0.13), tone);
    let clay = if burnt > 0.9 { clay * 0.62 } else { clay };
    let wall = if mortar { Vec3::new(0.42, 0.37, 0.32) } else { clay } * grain;
    wall.lerp(Vec3::new(0.10, 0.085, 0.075), 0.6 * dirt(p, 0.28))
}

pub(super) fn concrete(p: Vec2) -> Vec3 {
    let (x, _) = in_bay(p);
    let joint = 1.0 - 0.5 * smooth(0.012, 0.004, x.min(1.0 - x)) * smooth(0.0, 0.01, p.y);
    let boards = 1.0 + 0.05 * octaves(21, Vec2::new(p.x * 0.25, p.y), (4, 24), 1);
    let grain = 1.0 + 0.08 * octaves(22, p, (200, 48), 3);
    // Holes of the formwork's ties.
    let hole = |cx: f32, cy: f32| smooth(0.022, 0.012, Vec2::new(x - cx, p.y - cy).length());
    let holes = [(0.1, 0.15), (0.9, 0.15), (0.1, 0.88), (0.9, 0.88)].map(|(cx, cy)| hole(cx, cy));
    let ties = 1.0 - 0.45 * holes.iter().sum::<f32>();
    let tone = 0.97 + 0.06 * random(23, (p.x * BAYS_PER_TURN as f32) as i32, 0);
    let clean = Vec3::new(0.66, 0.655, 0.64) * (joint * boards * grain * ties * tone);
    clean.lerp(Vec3::new(0.20, 0.19, 0.175), 0.8 * dirt(p, 0.29))
}

pub(super) fn tiles(p: Vec2) -> Vec3 {
    let (rows, columns) = (16.0, 64.0);
    let row = (p.y * rows).floor();
    let in_row = (p.y * rows).fract();
    let column = (p.x * columns).floor();
    let wave = sin(TURN * p.x * columns);
    let tone = random(41, column as i32, row as i32);
    let relief = (0.86 + 0.2 * wave) * mix(0.5, 1.0, smooth(0.0, 0.3, in_row)) * mix(1.12, 0.95, in_row);
    let moss = smooth(0.15, 0.5, octaves(42, p, (18, 7), 3));
    let clay = Vec3::new(0.33, 0.125, 0.075).lerp(Vec3::new(0.39, 0.165, 0.10), tone) * relief;
    clay.lerp(Vec3::new(0.13, 0.115, 0.07), 0.55 * moss)
}

pub(super) fn stone(p: Vec2) -> Vec3 {
    let grain = 0.74 * (1.0 + 0.10 * octaves(51, p, (256, 8), 3) + 0.08 * octaves(52, p, (48, 2), 2));
    let weather = smooth(0.0, 0.5, octaves(53, Vec2::new(p.x, 0.2 * p.y), (120, 2), 2)) * smooth(0.9, 0.2, p.y);
    Vec3::new(1.0, 0.975, 0.93) * grain * (1.0 - 0.35 * weather)
}

pub(super) fn gravel(p: Vec2) -> Vec3 {
    let speck = random(61, (p.x * 1024.0) as i32, (p.y * 32.0) as i32);
    let patch = 1.0 + 0.25 * octaves(62, p, (12, 3), 3);
    Vec3::new(0.30, 0.285, 0.265) * (0.65 + 0.7 * speck) * patch
}

pub(super) fn zinc(p: Vec2) -> Vec3 {
    let sheets = 20.0;
    let sheet = (p.x * sheets).floor();
    let x = (p.x * sheets).fract();
    let seam = 1.0 - 0.45 * smooth(0.07, 0.03, x) + 0.25 * within(x, 0.08, 0.13);
    let tone = 0.92 + 0.16 * random(71, sheet as i32, 0);
    let stain = 1.0 + 0.2 * octaves(72, Vec2::new(p.x, 0.3 * p.y), (60, 3), 3);
    Vec3::new(0.30, 0.335, 0.37) * (seam * tone * stain)
}

pub(super) fn iron(p: Vec2) -> Vec3 {
    Vec3::new(0.045, 0.05, 0.052) * (1.0 + 0.3 * octaves(81, p, (200, 4), 2))
}

pub(super) fn wood(p: Vec2) -> Vec3 {
    let slat = (p.x * 128.0).fract();
    let grain = 1.0 + 0.25 * ridges(91, Vec2::new(p.x, 0.2 * p.y), (300, 2), 2) - 0.2;
    Vec3::new(0.20, 0.16, 0.11) * grain * mix(0.6, 1.0, smooth(0.0, 0.18, slat))
}

pub(super) fn cloth(p: Vec2, color: Vec3) -> Vec3 {
    let stripe = (p.x * 32.0).fract() < 0.5;
    let base = if stripe { color } else { Vec3::new(0.66, 0.64, 0.58) };
    base * (0.9 + 0.12 * octaves(95, p, (128, 4), 2))
}
