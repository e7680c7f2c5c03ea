//! Windows and doors. Points are shares of the cell, x right, y *up*.

use bevy_math::{Vec2, Vec3};

use super::{random, within};
use crate::forge::{
    portable::{TURN, mix, sin, smooth},
    texture::noise::octaves,
};

const FRAME: Vec3 = Vec3::new(0.66, 0.65, 0.62);
const DARK: Vec3 = Vec3::new(0.07, 0.075, 0.08);

/// A pane that reflects the sky: darker below, where houses opposite are mirrored.
fn glass(seed: u32, p: Vec2) -> Vec3 {
    let skyline = 0.42 + 0.12 * octaves(seed, Vec2::new(p.x, 0.3), (5, 1), 3);
    let sky = Vec3::new(0.17, 0.23, 0.31) * mix(0.75, 1.15, p.y);
    let houses = Vec3::new(0.028, 0.033, 0.040);
    let seen = smooth(skyline - 0.03, skyline + 0.06, p.y + 0.06 * (p.x - 0.5));
    houses.lerp(sky, seen * (0.72 + 0.25 * octaves(seed + 1, p, (3, 4), 2)))
}

/// Curtains at both sides that leave `open` (a share of the width) free.
fn curtains(p: Vec2, open: f32) -> Option<Vec3> {
    let off = (p.x - 0.5).abs() * 2.0;
    // They hang closer to the middle on top.
    let edge = open - 0.25 * smooth(0.35, 1.0, p.y);
    (off > edge).then(|| {
        let fold = 0.82 + 0.18 * sin(TURN * (p.x * 11.0 + 0.4 * p.y));
        Vec3::new(0.50, 0.48, 0.43) * fold
    })
}

/// A blind that is let down by a share of the height.
fn blind(p: Vec2, down: f32, color: Vec3) -> Option<Vec3> {
    (p.y > 1.0 - down).then(|| color * mix(0.72, 1.0, smooth(0.0, 0.5, (p.y * 28.0).fract())))
}

pub(super) fn window(kind: usize, p: Vec2) -> Vec3 {
    let seed = 200 + 10 * kind as u32;
    let (columns, transoms, bar, frame, color): (usize, &[f32], f32, f32, Vec3) = match kind {
        0..=3 => (2, &[0.70], 0.05, 0.06, FRAME),
        4 | 5 => (2, &[0.30, 0.80], 0.05, 0.055, FRAME),
        6 => (2, &[], 0.035, 0.04, FRAME * 0.9),
        7 => (3, &[], 0.03, 0.035, DARK),
        _ => (4, &[0.22], 0.016, 0.02, DARK),
    };
    let rim = p.x.min(1.0 - p.x).min(p.y.min(1.0 - p.y) * 0.64);
    if rim < frame {
        return color * mix(0.7, 1.0, smooth(0.0, frame, rim));
    }
    let column = p.x * columns as f32;
    let nearest = (column - (column + 0.5).floor()).abs() / columns as f32;
    let upright = columns > 1 && nearest < 0.5 * bar;
    let across = transoms.iter().any(|y| (p.y - y).abs() < 0.35 * bar);
    if upright || across {
        return color * 0.95;
    }
    // French doors have boards below.
    if matches!(kind, 4 | 5) && p.y < 0.30 {
        let inner = within((column.fract() - 0.5).abs(), 0.0, 0.33) * within((p.y - 0.165).abs(), 0.0, 0.085);
        return FRAME * mix(0.95, 0.78, inner);
    }
    let behind = match kind {
        0 => curtains(p, 0.62),
        2 => curtains(p, 0.34),
        3 => blind(p, 0.42, Vec3::new(0.46, 0.42, 0.34)),
        4 => curtains(p, 0.5),
        6 => blind(p, 0.3, Vec3::new(0.40, 0.40, 0.39)),
        7 => curtains(p, 0.8),
        8 => {
            let pane = (column.floor() as i32, seed);
            blind(p, 0.75 * random(pane.1, pane.0, 0) - 0.1, Vec3::new(0.24, 0.25, 0.25))
        }
        9 => {
            // Lamps in the ceilings behind.
            let lamp = within((p.y - 0.86).abs(), 0.0, 0.012) * within((column.fract() - 0.5).abs(), 0.0, 0.28);
            (lamp > 0.0).then_some(Vec3::new(0.55, 0.53, 0.45))
        }
        _ => None,
    };
    let mirrored = glass(seed, p);
    // Frames throw a little shade on what is behind the pane.
    let shade = mix(0.6, 1.0, smooth(frame, frame + 0.06, 1.0 - p.y));
    behind.map_or(mirrored, |color| color * shade * 0.8 + mirrored * 0.22)
}

pub(super) fn door(kind: usize, p: Vec2) -> Vec3 {
    let color = [
        Vec3::new(0.05, 0.12, 0.09),
        Vec3::new(0.16, 0.075, 0.035),
        Vec3::new(0.10, 0.11, 0.12),
    ][kind % 3];
    let rim = p.x.min(1.0 - p.x).min(1.0 - p.y);
    if rim < 0.05 {
        return FRAME * 0.8;
    }
    // A fanlight over two leaves.
    if p.y > 0.80 {
        let bars = within((p.x - 0.5).abs(), 0.0, 0.02) + within((p.y - 0.81).abs(), 0.0, 0.012);
        return if bars > 0.0 {
            FRAME * 0.8
        } else {
            glass(300 + kind as u32, p)
        };
    }
    if (p.x - 0.5).abs() < 0.012 {
        return color * 0.35;
    }
    let x = (p.x * 2.0).fract();
    let panel = |low: f32, high: f32| {
        let d = (x - 0.22).min(0.78 - x).min((p.y - low).min(high - p.y) * 1.8);
        mix(1.0, 0.62, smooth(0.0, 0.035, d) - 0.75 * smooth(0.05, 0.09, d))
    };
    let grain = 1.0 + 0.15 * octaves(310, Vec2::new(p.x, 0.1 * p.y), (60, 2), 2);
    let knob = smooth(0.03, 0.02, Vec2::new((p.x - 0.56) * 1.0, (p.y - 0.38) * 1.5).length());
    let wood = color * grain * panel(0.06, 0.32) * panel(0.40, 0.74) * mix(0.75, 1.0, smooth(0.0, 0.12, p.y));
    wood.lerp(Vec3::new(0.5, 0.4, 0.2), knob)
}
