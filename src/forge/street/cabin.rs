//! The forest's wooden things: a log cabin, the posts and split rails of a fence.

use bevy_math::{Vec2, Vec3};

use super::{
    Pieces, Yard,
    palette::{DARK_STONE, GLASS, IRON, LOGS, RED, STONE, WHITE, WOODS},
    solid::Solid,
};
use crate::forge::{
    mesh::Model,
    portable::{Dice, mix},
};

/// Half the plan of the cabin, roof excluded.
const HALF: Vec2 = Vec2::new(3.0, 2.4);
/// Radius of a log.
const LOG: f32 = 0.155;
/// Height of the lowest log, and of the eaves.
const WALLS: (f32, f32) = (0.45, 3.05);
/// Rise of the ridge above the eaves.
const RISE: f32 = 2.1;

/// `cabin.glb`.
pub(super) fn forge() -> Model {
    let mut yard = Yard::new();
    let levels = |shape: fn(u32) -> Pieces, coverages: &[f32]| -> Vec<(Pieces, f32)> {
        (0_u32..).zip(coverages).map(|(level, c)| (shape(level), *c)).collect()
    };
    yard.add("hut", &levels(hut, &[0.25, 0.08, 0.0]));
    yard.add("fence_post", &levels(fence_post, &[0.05, 0.003]));
    yard.add("fence_rails", &levels(fence_rails, &[0.05, 0.003]));
    yard.model
}

/// A log cabin; its door looks along +z.
fn hut(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    // A foot of stone that reaches into the slope, and the dark room that shows between logs.
    solid.paint(DARK_STONE);
    let foot = Vec3::new(2.0 * HALF.x + 0.3, 1.2, 2.0 * HALF.y + 0.3);
    solid.block(Vec3::Y * -0.3, foot);
    solid.paint(LOGS[1]);
    solid.block(Vec3::Y * 1.6, Vec3::new(2.0 * HALF.x - 0.1, 2.7, 2.0 * HALF.y - 0.1));
    walls(solid, level);
    gables(solid, level);
    roof(solid, level);
    chimney(solid, level);
    porch(solid, level);
    if level == 2 {
        return pieces;
    }
    door(solid, level);
    for x in [-1.9, 1.9] {
        window(&mut pieces, x, level);
    }
    if level == 0 {
        stones(&mut pieces.plain);
    }
    pieces
}

/// A log with cut ends that are lighter than its bark.
fn log(solid: &mut Solid, from: Vec3, to: Vec3, dice: &mut Dice, level: u32) {
    let n = [9, 6, 4][level.min(2) as usize];
    let (a, b) = (LOG * dice.about(1.0, 0.06), LOG * dice.about(1.0, 0.06));
    solid.paint(LOGS[if dice.unit() < 0.6 { 0 } else { 2 }]);
    solid.sawn(&[(from, a), (to, b)], n, WOODS[2]);
}

/// Nine logs on each side, crossing at the corners.
fn walls(solid: &mut Solid, level: u32) {
    let mut dice = Dice::new(601);
    if level == 2 {
        for side in [-1.0, 1.0] {
            for i in 0..3 {
                let y = 0.9 + 0.87 * i as f32;
                solid.paint(LOGS[i % 2 * 2]);
                solid.block(
                    Vec3::new(0.0, y, HALF.y * side),
                    Vec3::new(2.0 * HALF.x + 0.4, 0.85, 0.26),
                );
                solid.block(
                    Vec3::new(HALF.x * side, y, 0.0),
                    Vec3::new(0.26, 0.85, 2.0 * HALF.y + 0.4),
                );
            }
        }
        return;
    }
    for i in 0..9 {
        let y = WALLS.0 + 0.29 * i as f32;
        for side in [-1.0, 1.0] {
            // The topmost ends under the eaves.
            let out = if i == 8 { 0.02 } else { dice.between(0.2, 0.34) };
            let (x, z) = (HALF.x + dice.between(0.2, 0.34), HALF.y + out);
            log(
                solid,
                Vec3::new(-x, y, HALF.y * side),
                Vec3::new(x, y, HALF.y * side),
                &mut dice,
                level,
            );
            let y = y + 0.145;
            log(
                solid,
                Vec3::new(HALF.x * side, y, -z),
                Vec3::new(HALF.x * side, y, z),
                &mut dice,
                level,
            );
        }
    }
}

/// Logs that shorten towards the ridge, at both ends of the house.
fn gables(solid: &mut Solid, level: u32) {
    let mut dice = Dice::new(602);
    for side in [-1.0, 1.0] {
        let x = HALF.x * side;
        if level == 2 {
            solid.paint(LOGS[0]).apart();
            let ends = [
                Vec3::new(x, WALLS.1, -HALF.y),
                Vec3::new(x, WALLS.1 + RISE, 0.0),
                Vec3::new(x, WALLS.1, HALF.y),
            ];
            solid.face(&if side > 0.0 { ends } else { [ends[2], ends[1], ends[0]] });
            continue;
        }
        for i in 0..6 {
            let y = WALLS.1 + 0.10 + 0.29 * i as f32;
            let z = (HALF.y + 0.1) * (1.0 - (y + 0.1 - WALLS.1) / RISE);
            log(solid, Vec3::new(x, y, -z), Vec3::new(x, y, z), &mut dice, level);
        }
    }
}

/// Courses of shingles on both sides; their lower edges cast a line of shade each.
fn roof(solid: &mut Solid, level: u32) {
    let mut dice = Dice::new(603);
    let (reach, out) = (HALF.x + 0.6, HALF.y + 0.75);
    let eaves = WALLS.1 - 0.75 * RISE / HALF.y * 0.9;
    let ridge = WALLS.1 + RISE + 0.08;
    for side in [-1.0, 1.0] {
        let at = |t: f32, x: f32, lift: f32| Vec3::new(x, mix(eaves, ridge, t) + lift, side * mix(out, 0.0, t));
        let courses = [8, 4, 1][level.min(2) as usize];
        for i in 0..courses {
            let (low, high) = (i as f32 / courses as f32, (i as f32 + 1.12) / courses as f32);
            let pieces = if level == 0 { 6 } else { 1 };
            let mut from = -reach;
            for k in 0..pieces {
                let width = 2.0 * reach / pieces as f32;
                let to = if k + 1 == pieces {
                    reach
                } else {
                    from + width * dice.about(1.0, 0.12)
                };
                solid.paint([LOGS[0], LOGS[2], LOGS[0], LOGS[1]][dice.below(4) as usize]);
                let drop = if level == 0 { dice.between(-0.012, 0.012) } else { 0.0 };
                shingles(
                    solid,
                    [low + drop, high.min(1.0)],
                    [from, to.min(reach) - 0.012],
                    side,
                    &at,
                );
                from = to;
            }
        }
        // Rafters that show below the eaves.
        if level == 0 {
            solid.paint(LOGS[0]);
            for k in 0..7 {
                let x = mix(-HALF.x, HALF.x, k as f32 / 6.0);
                solid.beam(at(0.03, x, -0.12), at(0.45, x, -0.12), Vec2::new(0.12, 0.14), Vec3::X);
            }
        }
    }
    solid.paint(LOGS[0]);
    solid.tube(
        &[
            (Vec3::new(-reach - 0.05, ridge + 0.03, 0.0), 0.11),
            (Vec3::new(reach + 0.05, ridge + 0.03, 0.0), 0.11),
        ],
        6,
    );
}

/// A slab of a course: thick at its lower edge, on the next one at its upper.
fn shingles(
    solid: &mut Solid,
    [low, high]: [f32; 2],
    [from, to]: [f32; 2],
    side: f32,
    at: &impl Fn(f32, f32, f32) -> Vec3,
) {
    let ring = |x: f32| {
        [
            at(low, x, -0.02),
            at(low, x, 0.055),
            at(high, x, 0.02),
            at(high, x, -0.03),
        ]
    };
    let (a, b) = (ring(from), ring(to));
    solid.apart();
    for i in 0..4 {
        let j = (i + 1) % 4;
        let quad = [a[i], b[i], b[j], a[j]];
        let [p, q, r, s] = quad;
        solid.quad(if side > 0.0 { quad } else { [s, r, q, p] });
    }
    for (ring, outward) in [(a, side < 0.0), (b, side > 0.0)] {
        let [p, q, r, s] = ring;
        solid.apart();
        solid.face(&if outward { [p, s, r, q] } else { [p, q, r, s] });
    }
}

/// A chimney of field stones with a slab on top.
fn chimney(solid: &mut Solid, level: u32) {
    let at = Vec3::new(1.6, 0.0, -0.9);
    solid.paint(DARK_STONE);
    if level > 0 {
        solid.block(at + Vec3::Y * 4.53, Vec3::new(0.7, 2.46, 0.7));
        return;
    }
    let mut dice = Dice::new(604);
    for i in 0..8 {
        let y = 3.5 + 0.29 * i as f32;
        solid.paint([DARK_STONE, STONE][(dice.unit() * 1.4) as usize % 2]);
        let size = Vec3::new(0.70, 0.28, 0.70) + Vec3::new(dice.signed(), 0.0, dice.signed()) * 0.05;
        solid.rounded(at + Vec3::Y * y, size, 0.04);
    }
    solid.paint(STONE);
    solid.rounded(at + Vec3::Y * 5.71, Vec3::new(0.9, 0.09, 0.9), 0.025);
    solid.paint(LOGS[1]);
    solid.block(at + Vec3::Y * 5.76, Vec3::new(0.4, 0.06, 0.4));
}

/// A door of boards with battens, a frame and a step.
fn door(solid: &mut Solid, level: u32) {
    let z = HALF.y + 0.13;
    solid.paint(WOODS[1]);
    solid.block(Vec3::new(0.0, 1.38, z), Vec3::new(1.16, 2.2, 0.24));
    let boards = if level == 0 { 5 } else { 1 };
    for i in 0..boards {
        let width = 1.0 / boards as f32;
        solid.paint(WOODS[i % 3]);
        let x = -0.5 + width * (i as f32 + 0.5);
        solid.block(Vec3::new(x, 1.33, z + 0.115), Vec3::new(width - 0.014, 2.04, 0.06));
    }
    if level == 0 {
        solid.paint(LOGS[0]);
        for y in [0.65, 1.95] {
            solid.block(Vec3::new(0.0, y, z + 0.155), Vec3::new(0.94, 0.12, 0.04));
        }
        solid.paint(IRON);
        solid.tube(
            &[
                (Vec3::new(0.4, 1.2, z + 0.19), 0.015),
                (Vec3::new(0.4, 1.45, z + 0.19), 0.015),
            ],
            6,
        );
    }
}

/// A window with a frame, bars and shutters.
fn window(pieces: &mut Pieces, x: f32, level: u32) {
    let z = HALF.y + 0.12;
    let glass = &mut pieces.glossy;
    glass.paint(GLASS);
    glass.block(Vec3::new(x, 1.75, z), Vec3::new(0.8, 0.8, 0.14));
    let solid = &mut pieces.plain;
    solid.paint(WHITE);
    for side in [-1.0, 1.0] {
        solid.block(Vec3::new(x + 0.42 * side, 1.75, z + 0.04), Vec3::new(0.08, 0.96, 0.16));
        solid.block(Vec3::new(x, 1.75 + 0.44 * side, z + 0.04), Vec3::new(0.76, 0.08, 0.16));
    }
    if level > 0 {
        return;
    }
    solid.block(Vec3::new(x, 1.75, z + 0.075), Vec3::new(0.035, 0.8, 0.03));
    solid.block(Vec3::new(x, 1.75, z + 0.075), Vec3::new(0.8, 0.035, 0.03));
    solid.paint(RED);
    for side in [-1.0, 1.0] {
        solid.rounded(
            Vec3::new(x + 0.69 * side, 1.75, z + 0.07),
            Vec3::new(0.42, 0.92, 0.05),
            0.012,
        );
    }
    solid.paint(WOODS[0]);
    solid.block(Vec3::new(x, 1.25, z + 0.14), Vec3::new(1.0, 0.16, 0.22));
}

/// A deck before the door with posts, a small roof and steps.
fn porch(solid: &mut Solid, level: u32) {
    let (near, far) = (HALF.y + 0.16, HALF.y + 1.55);
    let planks = if level == 0 { 8 } else { 1 };
    for i in 0..planks {
        let width = (far - near) / planks as f32;
        solid.paint(WOODS[(i * 2) % 3]);
        let z = near + width * (i as f32 + 0.5);
        solid.block(Vec3::new(0.0, 0.24, z), Vec3::new(2.6, 0.06, width - 0.012));
    }
    solid.paint(LOGS[0]);
    solid.block(
        Vec3::new(0.0, -0.05, 0.5 * (near + far)),
        Vec3::new(2.4, 0.52, far - near - 0.2),
    );
    for i in 0..2 {
        solid.paint(WOODS[1]);
        solid.block(
            Vec3::new(0.0, 0.13 - 0.16 * i as f32, far + 0.16 + 0.28 * i as f32),
            Vec3::new(1.3, 0.06, 0.3),
        );
    }
    solid.paint(LOGS[0]);
    let n = if level == 0 { 8 } else { 4 };
    for side in [-1.0, 1.0] {
        let x = 1.2 * side;
        solid.tube(
            &[
                (Vec3::new(x, -0.5, far - 0.12), 0.075),
                (Vec3::new(x, 2.42, far - 0.12), 0.065),
            ],
            n,
        );
        if level == 0 {
            for y in [0.72, 1.08] {
                solid.tube(
                    &[(Vec3::new(x, y, near), 0.035), (Vec3::new(x, y, far - 0.12), 0.035)],
                    6,
                );
            }
            // A brace towards the beam.
            solid.tube(
                &[
                    (Vec3::new(x, 1.95, far - 0.12), 0.035),
                    (Vec3::new(x * 0.66, 2.42, far - 0.12), 0.035),
                ],
                6,
            );
        }
    }
    solid.tube(
        &[
            (Vec3::new(-1.45, 2.45, far - 0.12), 0.075),
            (Vec3::new(1.45, 2.45, far - 0.12), 0.075),
        ],
        n,
    );
    solid.paint(LOGS[2]);
    solid.beam(
        Vec3::new(0.0, 2.40, far + 0.3),
        Vec3::new(0.0, 2.86, near - 0.2),
        Vec2::new(3.1, 0.07),
        Vec3::X,
    );
}

/// Field stones along the foot.
fn stones(solid: &mut Solid) {
    let mut dice = Dice::new(605);
    for (along, across, length, reach) in [(Vec3::X, Vec3::Z, HALF.x, HALF.y), (Vec3::Z, Vec3::X, HALF.y, HALF.x)] {
        for side in [-1.0, 1.0] {
            let mut t = -length - 0.1;
            while t < length - 0.2 {
                let width = dice.between(0.35, 0.7);
                solid.paint([DARK_STONE, STONE, DARK_STONE][dice.below(3) as usize]);
                let center =
                    along * (t + 0.5 * width) + across * (side * (reach + 0.13)) + Vec3::Y * dice.about(0.12, 0.04);
                let size = along * (width - 0.02) + across * 0.14 + Vec3::Y * dice.between(0.26, 0.36);
                solid.rounded(center, size, 0.05);
                t += width;
            }
        }
    }
}

/// A fence post of 1 m, to be scaled to its height; its foot is 0.4 below the origin.
fn fence_post(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(LOGS[2]);
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    if level == 0 {
        solid.tube(
            &[
                (at(0.0, -0.4, 0.0), 0.066),
                (at(0.004, 0.3, 0.006), 0.061),
                (at(-0.004, 0.93, 0.0), 0.056),
                (at(0.0, 1.0, 0.0), 0.020),
            ],
            8,
        );
    } else {
        solid.tube(&[(at(0.0, -0.4, 0.0), 0.064), (at(0.0, 0.98, 0.0), 0.05)], 4);
    }
    pieces
}

/// Three split rails of 1 m along +x from the origin, for a fence of 1 m: to be scaled to length and height.
fn fence_rails(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    let mut dice = Dice::new(606);
    for (i, y) in [0.30, 0.60, 0.88].into_iter().enumerate() {
        solid.paint([LOGS[2], LOGS[0], WOODS[1]][i]);
        if level > 0 {
            solid.block(Vec3::new(0.5, y, 0.0), Vec3::new(1.04, 0.07, 0.045));
            continue;
        }
        // Split from a trunk: a wedge with a flat face, bent a little.
        let steps = 4;
        let ring = |t: f32, dice: &mut Dice| {
            let rise = y + dice.about(0.0, 0.012);
            let (tall, deep) = (dice.between(0.030, 0.043), dice.between(0.020, 0.030));
            [(-1.0, -0.8), (-0.7, 1.0), (0.8, 0.9), (1.0, -0.5)]
                .map(|(up, out)| Vec3::new(t, rise + up * tall, out * deep))
        };
        let rings: Vec<[Vec3; 4]> = (0..=steps)
            .map(|k| ring(mix(-0.02, 1.02, k as f32 / steps as f32), &mut dice))
            .collect();
        solid.apart();
        for pair in rings.windows(2) {
            for k in 0..4 {
                let next = (k + 1) % 4;
                solid.quad([pair[0][k], pair[1][k], pair[1][next], pair[0][next]]);
            }
        }
        let [a, b, c, d] = rings[0];
        solid.quad([a, b, c, d]);
        let [a, b, c, d] = rings[steps];
        solid.quad([d, c, b, a]);
    }
    pieces
}
