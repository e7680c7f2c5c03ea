//! Twigs with leaves or needles, as they stand on the cards of a crown: four cells, the stalk at the middle below.

use bevy_math::{Vec2, Vec3};

use super::{canvas::Canvas, leaf::LeafShape, picture::Picture};
use crate::forge::portable::{Dice, TURN, mix, sin, sin_cos};

/// Cells per side of a picture.
pub const GRID: usize = 2;
/// Texels per side of a cell.
const CELL_TEXELS: usize = 256;
const TWIG: Vec3 = Vec3::new(0.07, 0.05, 0.035);

/// What grows on the cards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sprig {
    /// A forked twig with flat leaves, each of this share of the cell.
    Leaves {
        /// Their shape.
        shape: LeafShape,
        /// Their length as a share of the cell.
        length: f32,
        /// Leaves per twig.
        count: u32,
    },
    /// A flat spray: side twigs with short needles all along (spruce, fir).
    Spray,
    /// Tufts of long needles at the ends of short shoots (pine).
    Tufts,
    /// One frond with leaflets that grow shorter towards the tip (fern).
    Frond,
    /// Blades that rise from the ground (grass).
    Blades {
        /// Linear colour.
        color: [f32; 3],
        /// How far blades lean, in shares of the cell.
        lean: f32,
        /// Ears on some blades.
        ears: bool,
    },
}

/// Base colour with alpha, and thickness.
pub fn paint(sprig: Sprig, name: &str, seed: u64) -> [Picture; 2] {
    let mut canvas = Canvas::new(GRID, CELL_TEXELS);
    for cell in 0..canvas.cell_count() {
        let mut dice = Dice::new(seed * 16 + cell as u64);
        let canvas = &mut canvas;
        match sprig {
            Sprig::Leaves { shape, length, count } => leaves(canvas, cell, shape, length, count, &mut dice),
            Sprig::Spray => spray(canvas, cell, &mut dice),
            Sprig::Tufts => tufts(canvas, cell, &mut dice),
            Sprig::Frond => frond(canvas, cell, &mut dice),
            Sprig::Blades { color, lean, ears } => blades(canvas, cell, color.into(), lean, ears, &mut dice),
        }
    }
    canvas.pictures(name)
}

/// A unit vector at an angle from straight up, clockwise.
fn up_turned(angle: f32) -> Vec2 {
    let (sin, cos) = sin_cos(angle);
    Vec2::new(sin, cos)
}

/// A bent twig as a chain of points.
fn twig(from: Vec2, angle: f32, bend: f32, length: f32, steps: u32) -> Vec<(Vec2, f32)> {
    let mut points = vec![(from, angle)];
    let mut at = from;
    for step in 0..steps {
        let own = angle + bend * (step as f32 + 0.5) / steps as f32;
        at += up_turned(own) * (length / steps as f32);
        points.push((at, own));
    }
    points
}

fn draw_twig(canvas: &mut Canvas, cell: usize, points: &[(Vec2, f32)], width: f32, color: Vec3) {
    let count = points.len().max(2) as f32 - 1.0;
    for (i, pair) in points.windows(2).enumerate() {
        let at = |step: usize| width * (1.0 - 0.75 * step as f32 / count);
        canvas.stroke(cell, pair[0].0, pair[1].0, (at(i), at(i + 1)), color, 1.0);
    }
}

fn leaves(canvas: &mut Canvas, cell: usize, shape: LeafShape, length: f32, count: u32, dice: &mut Dice) {
    let main = twig(
        Vec2::new(0.5, 0.0),
        dice.about(0.0, 0.12),
        dice.about(0.0, 0.35),
        0.74,
        8,
    );
    draw_twig(canvas, cell, &main, 0.014, TWIG);
    // Side twigs first, so that leaves lie over them.
    let mut seats: Vec<(Vec2, f32)> = Vec::new();
    let mut side = if dice.unit() < 0.5 { 1.0 } else { -1.0 };
    for seat in [1, 2, 3, 4, 5, 6] {
        let (at, angle) = main[seat];
        let reach = mix(0.52, 0.2, seat as f32 / 8.0) * dice.between(0.8, 1.1);
        let points = twig(at, angle + side * dice.between(0.75, 1.05), -side * 0.40, reach, 4);
        draw_twig(canvas, cell, &points, 0.009, TWIG);
        seats.extend(points[1..].iter().copied());
        side = -side;
    }
    seats.extend(main[2..].iter().copied());
    for i in 0..count {
        let (at, angle) = seats[i as usize % seats.len()];
        let side = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let own = length * dice.between(0.75, 1.15);
        let direction = up_turned(angle + side * dice.between(0.25, 1.25)) * own;
        let stalk = at + Vec2::new(dice.signed(), dice.signed()) * 0.012;
        // Leaves stay inside the cell: those that would leave it are shifted in.
        let tip = stalk + direction;
        let margin = 0.02 + 0.3 * own;
        let inside = tip.clamp(Vec2::splat(margin), Vec2::splat(1.0 - margin * 0.5));
        shape.paint(canvas, cell, stalk + (inside - tip), direction, dice);
    }
    let (tip, angle) = main[main.len() - 1];
    shape.paint(
        canvas,
        cell,
        tip,
        up_turned(angle) * length.min(0.97 - tip.y).max(0.05),
        dice,
    );
}

/// Needles on both sides of a twig.
fn needles(canvas: &mut Canvas, cell: usize, points: &[(Vec2, f32)], length: f32, color: Vec3, dice: &mut Dice) {
    for pair in points.windows(2) {
        let ((from, angle), (to, _)) = (pair[0], pair[1]);
        let count = (from.distance(to) / 0.0095).ceil();
        let mut i = 0.0;
        while i < count {
            let at = from.lerp(to, i / count);
            for side in [-1.0, 1.0] {
                let direction = up_turned(angle + side * dice.between(0.55, 1.0));
                let own = length * dice.between(0.7, 1.1);
                let tone = color * dice.between(0.6, 1.3);
                canvas.stroke(cell, at, at + direction * own, (0.0085, 0.003), tone, 0.8);
            }
            i += 1.0;
        }
    }
}

fn spray(canvas: &mut Canvas, cell: usize, dice: &mut Dice) {
    let green = Vec3::new(0.040, 0.085, 0.030);
    let main = twig(
        Vec2::new(0.5, 0.0),
        dice.about(0.0, 0.06),
        dice.about(0.0, 0.2),
        0.92,
        12,
    );
    let mut sides = Vec::new();
    for (seat, (at, angle)) in main.iter().copied().enumerate().take(12).skip(1) {
        for side in [-1.0, 1.0] {
            let share = seat as f32 / 12.0;
            // Longest in the lower third.
            let reach = 0.46 * sin(TURN * 0.5 * (0.16 + 0.80 * share)) * dice.between(0.75, 1.1);
            sides.push(twig(
                at,
                angle + side * dice.between(0.72, 0.98),
                -side * 0.35,
                reach,
                4,
            ));
        }
    }
    for points in &sides {
        draw_twig(canvas, cell, points, 0.009, TWIG);
        needles(canvas, cell, points, 0.05, green, dice);
    }
    draw_twig(canvas, cell, &main, 0.015, TWIG);
    needles(canvas, cell, &main, 0.055, green * 1.25, dice);
}

fn tufts(canvas: &mut Canvas, cell: usize, dice: &mut Dice) {
    let green = Vec3::new(0.055, 0.105, 0.042);
    let main = twig(Vec2::new(0.5, 0.0), dice.about(0.0, 0.1), dice.about(0.0, 0.3), 0.62, 6);
    let mut shoots = Vec::new();
    for seat in [2, 3, 4, 5] {
        let (at, angle) = main[seat];
        let side = if seat % 2 == 0 { 1.0 } else { -1.0 };
        shoots.push(twig(
            at,
            angle + side * dice.between(0.6, 0.95),
            -side * 0.4,
            dice.between(0.16, 0.27),
            3,
        ));
    }
    shoots.push(main[3..].to_vec());
    draw_twig(canvas, cell, &main, 0.024, TWIG * 1.2);
    for shoot in &shoots {
        draw_twig(canvas, cell, shoot, 0.017, TWIG * 1.2);
        let last = shoot.len() - 1;
        for i in 0..110 {
            // More needles, pointing more forward, near the tip.
            let share = 1.0 - (i as f32 / 110.0) * (i as f32 / 110.0);
            let place = share * last as f32;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..=last")]
            let seat = (place as usize).min(last.saturating_sub(1));
            let at = shoot[seat].0.lerp(shoot[seat + 1].0, place - seat as f32);
            let spread = mix(1.15, 0.75, share) * dice.signed();
            let direction = up_turned(shoot[last].1 + spread) * dice.between(0.16, 0.245);
            let tip = (at + direction).clamp(Vec2::splat(0.01), Vec2::splat(0.99));
            canvas.stroke(cell, at, tip, (0.0085, 0.004), green * dice.between(0.6, 1.35), 0.8);
        }
    }
}

fn frond(canvas: &mut Canvas, cell: usize, dice: &mut Dice) {
    let green = Vec3::new(0.085, 0.185, 0.030);
    let main = twig(Vec2::new(0.5, 0.0), 0.0, dice.about(0.0, 0.2), 0.97, 24);
    for (seat, (at, angle)) in main.iter().copied().enumerate().take(24).skip(3) {
        let share = seat as f32 / 24.0;
        let reach = 0.42 * (1.0 - share) * (0.55 + 1.9 * share).min(1.0) + 0.015;
        for side in [-1.0, 1.0] {
            let pinna = twig(at, angle + side * dice.between(1.1, 1.25), -side * 0.3, reach, 6);
            draw_twig(canvas, cell, &pinna, 0.006, green * 0.8);
            let tone = green * dice.between(0.75, 1.2);
            for pair in pinna.windows(2) {
                for step in 0..2 {
                    let root = pair[0].0.lerp(pair[1].0, step as f32 / 2.0);
                    let left = 1.0 - (root - at).length() / reach.max(1e-3);
                    for lobe_side in [-1.0, 1.0] {
                        let direction = up_turned(pair[0].1 + lobe_side * 1.0) * (0.008 + 0.024 * left.max(0.0));
                        canvas.stroke(cell, root, root + direction, (0.017, 0.008), tone, 0.5);
                    }
                }
            }
        }
    }
    draw_twig(canvas, cell, &main, 0.012, green * Vec3::new(1.1, 0.8, 0.8));
}

fn blades(canvas: &mut Canvas, cell: usize, color: Vec3, lean: f32, ears: bool, dice: &mut Dice) {
    for i in 0..34 {
        let from = Vec2::new(0.5 + 0.26 * dice.signed(), 0.0);
        let length = dice.between(0.45, 0.97);
        let side = (from.x - 0.5) * 1.6 + 0.35 * dice.signed();
        let bend = side * lean * 2.4 + lean * dice.signed();
        let points = twig(from, side * 0.4, bend, length * 0.96, 7);
        let tone = color * dice.between(0.6, 1.3) * Vec3::new(dice.between(0.95, 1.3), 1.0, 1.0);
        for (step, pair) in points.windows(2).enumerate() {
            let width = |step: usize| 0.026 * (1.0 - step as f32 / 7.5);
            let fade = mix(0.55, 1.1, step as f32 / 7.0);
            let inside = |p: Vec2| p.clamp(Vec2::new(0.01, 0.0), Vec2::splat(0.99));
            canvas.stroke(
                cell,
                inside(pair[0].0),
                inside(pair[1].0),
                (width(step), width(step + 1)),
                tone * fade,
                0.4,
            );
        }
        if ears && i % 4 == 0 {
            let straw = Vec3::new(0.30, 0.24, 0.11);
            for pair in points[4..].windows(2) {
                canvas.stroke(
                    cell,
                    pair[0].0,
                    pair[1].0,
                    (0.028, 0.018),
                    straw * dice.between(0.7, 1.1),
                    0.7,
                );
            }
        }
    }
}
