//! Shop fronts and their signs. Points are shares of the cell, x right, y *up*.

use bevy_math::{Vec2, Vec3};

use super::{random, within};
use crate::forge::portable::{mix, smooth};

/// Colours of shop fronts.
const PAINTS: [Vec3; 4] = [
    Vec3::new(0.035, 0.075, 0.12),
    Vec3::new(0.17, 0.03, 0.03),
    Vec3::new(0.03, 0.10, 0.06),
    Vec3::new(0.07, 0.065, 0.06),
];

pub(super) fn shop(kind: usize, p: Vec2) -> Vec3 {
    let paint = PAINTS[kind % PAINTS.len()];
    let seed = 400 + 16 * kind as u32;
    // The door is on the right in two of them, on the left in the others.
    let x = if kind.is_multiple_of(2) { p.x } else { 1.0 - p.x };
    let frame = 0.03;
    let rim = x.min(1.0 - x).min((1.0 - p.y) * 0.8);
    if rim < frame {
        return paint * mix(0.8, 1.25, smooth(0.0, frame, rim));
    }
    let is_door = x > 0.70;
    let post = (x - 0.70).abs() < 0.022 || (!is_door && (x - 0.35).abs() < 0.012);
    let transom = (p.y - 0.80).abs() < 0.014;
    if post || transom {
        return paint;
    }
    let sill = if is_door { 0.12 } else { 0.20 };
    if p.y < sill {
        let inner = within((p.y / sill - 0.5).abs(), 0.0, 0.28);
        return paint * mix(1.1, 0.7, inner);
    }
    if is_door && (x - 0.745).abs() < 0.012 && within(p.y, 0.36, 0.56) > 0.0 {
        return Vec3::new(0.5, 0.42, 0.25);
    }
    // Inside: a warm room that darkens with depth, lamps, shelves with goods.
    let room = Vec3::new(0.20, 0.145, 0.085) * mix(0.35, 1.15, smooth(0.2, 0.8, p.y));
    let lamp = smooth(
        0.05,
        0.0,
        Vec2::new((x * 5.0).fract() - 0.5, (p.y - 0.70) * 3.2).length() * 0.35,
    );
    let shelf = ((p.y - sill) * 7.5).fract();
    let row = ((p.y - sill) * 7.5) as i32;
    let column = (x * 26.0) as i32;
    let tall = 0.30 + 0.5 * random(seed, column, row);
    let goods = !is_door && row < 3 && shelf > 0.12 && shelf < tall && random(seed + 1, column, row) > 0.22;
    let color = |c: u32| 0.04 + 0.5 * random(seed + 2 + c, column, row);
    let inside = if goods {
        Vec3::new(color(0), 0.8 * color(1), 0.7 * color(2)) * 0.75
    } else if !is_door && row < 3 && shelf < 0.12 {
        Vec3::new(0.24, 0.17, 0.10)
    } else {
        room
    };
    let lit = inside + Vec3::new(0.75, 0.58, 0.32) * lamp;
    // The street is mirrored above all.
    let slant = smooth(0.55, 0.95, p.y + 0.25 * (x - 0.5));
    lit * mix(0.95, 0.55, slant) + Vec3::new(0.10, 0.14, 0.18) * slant
}

/// Words on signs.
const WORDS: [&str; 8] = [
    "CAFE", "BOOKS", "BAKERY", "HOTEL", "FLOWERS", "CINEMA", "TAILOR", "RECORDS",
];

/// Columns of a letter, 5 × 7 dots, each column from its lowest dot up.
fn letter(c: char) -> [u8; 5] {
    match c {
        'A' => [0x3f, 0x48, 0x48, 0x48, 0x3f],
        'B' => [0x7f, 0x49, 0x49, 0x49, 0x36],
        'C' => [0x3e, 0x41, 0x41, 0x41, 0x22],
        'D' => [0x7f, 0x41, 0x41, 0x41, 0x3e],
        'E' => [0x7f, 0x49, 0x49, 0x49, 0x41],
        'F' => [0x7f, 0x48, 0x48, 0x48, 0x40],
        'H' => [0x7f, 0x08, 0x08, 0x08, 0x7f],
        'I' => [0x00, 0x41, 0x7f, 0x41, 0x00],
        'K' => [0x7f, 0x08, 0x14, 0x22, 0x41],
        'L' => [0x7f, 0x01, 0x01, 0x01, 0x01],
        'M' => [0x7f, 0x20, 0x10, 0x20, 0x7f],
        'N' => [0x7f, 0x20, 0x10, 0x08, 0x7f],
        'O' => [0x3e, 0x41, 0x41, 0x41, 0x3e],
        'R' => [0x7f, 0x48, 0x4c, 0x4a, 0x31],
        'S' => [0x32, 0x49, 0x49, 0x49, 0x26],
        'T' => [0x40, 0x40, 0x7f, 0x40, 0x40],
        'W' => [0x7e, 0x01, 0x06, 0x01, 0x7e],
        'Y' => [0x60, 0x10, 0x0f, 0x10, 0x60],
        _ => [0; 5],
    }
}

pub(super) fn sign(kind: usize, p: Vec2) -> Vec3 {
    let paint = PAINTS[(kind * 3 + 1) % PAINTS.len()];
    let gold = Vec3::new(0.62, 0.47, 0.19);
    let rim = (p.x * 4.3).min((1.0 - p.x) * 4.3).min(p.y).min(1.0 - p.y);
    if within(rim, 0.06, 0.10) > 0.0 {
        return gold * 0.8;
    }
    let word = WORDS[kind % WORDS.len()];
    // Dots of 1/13 of the height, letters six dots apart.
    let dot = 1.0 / 13.0;
    let width = (word.len() * 6 - 1) as f32 * dot / 4.33;
    let at = Vec2::new((p.x - 0.5 + 0.5 * width) * 4.33, p.y - 0.5 + 3.5 * dot) / dot;
    if at.x >= 0.0 && at.y >= 0.0 && at.y < 7.0 {
        let (column, row) = (at.x as usize, at.y as usize);
        let found = word.chars().nth(column / 6).filter(|_| column % 6 < 5);
        if found.is_some_and(|c| letter(c)[column % 6] >> row & 1 == 1) {
            return gold;
        }
    }
    paint * 1.2
}
