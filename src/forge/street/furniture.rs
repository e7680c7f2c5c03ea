//! Things on pavements: benches, bins, bollards, post boxes, bicycles, grates, pots, railings.

use bevy_math::{Vec2, Vec3};

use super::{
    Pieces, Yard, lamps,
    palette::{BLACK, CHROME, CLAY, DARK_STEEL, GREEN, IRON, LOGS, RUBBER, STEEL, WHITE, WOODS, YELLOW},
    solid::Solid,
    stalls,
};
use crate::forge::{
    mesh::Model,
    portable::{TURN, sin_cos},
};

/// `street.glb`.
pub(super) fn forge() -> Model {
    let mut yard = Yard::new();
    lamps::add(&mut yard);
    let shapes: [(&str, fn(u32) -> Pieces, &[f32]); 12] = [
        ("bench", bench, &[0.06, 0.02, 0.003]),
        ("bin", bin, &[0.06, 0.004]),
        ("bollard", bollard, &[0.06, 0.004]),
        ("post_box", post_box, &[0.07, 0.004]),
        ("kiosk", stalls::kiosk, &[0.20, 0.006]),
        ("cafe", stalls::cafe, &[0.07, 0.02, 0.004]),
        ("parasol", stalls::parasol, &[0.15, 0.006]),
        ("bicycle", bicycle, &[0.09, 0.03, 0.005]),
        ("grate", grate, &[0.02, 0.004]),
        ("pot", pot, &[0.06, 0.004]),
        ("railing", railing, &[0.09, 0.03, 0.004]),
        ("shelter", stalls::shelter, &[0.20, 0.006]),
    ];
    for (name, shape, coverages) in shapes {
        let levels: Vec<(Pieces, f32)> = (0_u32..).zip(coverages).map(|(level, c)| (shape(level), *c)).collect();
        yard.add(name, &levels);
    }
    yard.model
}

/// A slatted bench, 1.8 m along x, looking along +z.
fn bench(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(IRON);
    for x in [-0.72, 0.72] {
        if level == 0 {
            // A curved side of cast iron: feet, seat, back, arm rest.
            let r = 0.022;
            let side: [&[(f32, f32)]; 3] = [
                &[(0.24, -0.15), (0.20, 0.10), (0.17, 0.28), (0.20, 0.43)],
                &[
                    (-0.27, -0.15),
                    (-0.22, 0.12),
                    (-0.20, 0.42),
                    (-0.26, 0.66),
                    (-0.36, 0.92),
                ],
                &[
                    (-0.27, 0.66),
                    (-0.10, 0.68),
                    (0.14, 0.66),
                    (0.23, 0.60),
                    (0.21, 0.52),
                    (0.19, 0.44),
                ],
            ];
            for line in side {
                let points: Vec<(Vec3, f32)> = line.iter().map(|(z, y)| (Vec3::new(x, *y, *z), r)).collect();
                solid.tube(&points, 7);
            }
            solid.beam(
                Vec3::new(x, 0.425, -0.24),
                Vec3::new(x, 0.43, 0.24),
                Vec2::new(0.045, 0.03),
                Vec3::X,
            );
        } else {
            solid.beam(
                Vec3::new(x, -0.15, 0.2),
                Vec3::new(x, 0.44, 0.2),
                Vec2::splat(0.045),
                Vec3::X,
            );
            solid.beam(
                Vec3::new(x, -0.15, -0.2),
                Vec3::new(x, 0.92, -0.35),
                Vec2::splat(0.045),
                Vec3::X,
            );
        }
    }
    let slats: &[(Vec3, Vec2, usize)] = &[
        (Vec3::new(0.0, 0.455, 0.205), Vec2::new(0.085, 0.034), 0),
        (Vec3::new(0.0, 0.455, 0.100), Vec2::new(0.085, 0.034), 1),
        (Vec3::new(0.0, 0.455, -0.005), Vec2::new(0.085, 0.034), 2),
        (Vec3::new(0.0, 0.455, -0.110), Vec2::new(0.085, 0.034), 0),
        (Vec3::new(0.0, 0.60, -0.215), Vec2::new(0.030, 0.085), 1),
        (Vec3::new(0.0, 0.72, -0.255), Vec2::new(0.030, 0.085), 0),
        (Vec3::new(0.0, 0.84, -0.300), Vec2::new(0.030, 0.085), 2),
    ];
    if level == 2 {
        solid.paint(WOODS[0]);
        solid.block(Vec3::new(0.0, 0.455, 0.05), Vec3::new(1.8, 0.034, 0.40));
        solid.block(Vec3::new(0.0, 0.72, -0.26), Vec3::new(1.8, 0.33, 0.05));
        return pieces;
    }
    for (center, section, wood) in slats {
        solid.paint(WOODS[*wood]);
        let size = Vec3::new(1.8, section.y, section.x);
        if level == 0 {
            solid.rounded(*center, size, 0.009);
        } else {
            solid.block(*center, size);
        }
    }
    pieces
}

/// A litter bin of 95 cm on a foot, with a hood.
fn bin(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    let n = [18, 7][level.min(1) as usize];
    solid.paint(GREEN);
    if level == 0 {
        solid.turned(Vec3::ZERO, &[(0.16, -0.1), (0.16, 0.03), (0.05, 0.05), (0.05, 0.16)], n);
        solid.turned(
            Vec3::ZERO,
            &[
                (0.19, 0.15),
                (0.21, 0.17),
                (0.235, 0.66),
                (0.25, 0.67),
                (0.25, 0.70),
                (0.225, 0.70),
                (0.215, 0.5),
                (0.0, 0.5),
            ],
            n,
        );
        for k in 0..4 {
            let (sin, cos) = sin_cos(TURN * (k as f32 + 0.5) / 4.0);
            let at = |y: f32| Vec3::new(0.225 * sin, y, 0.225 * cos);
            solid.beam(at(0.68), at(0.86), Vec2::splat(0.02), Vec3::X);
        }
        solid.turned(Vec3::ZERO, &[(0.26, 0.84), (0.26, 0.87), (0.14, 0.93), (0.0, 0.95)], n);
        solid.paint(STEEL);
        solid.turned(
            Vec3::ZERO,
            &[(0.238, 0.60), (0.241, 0.61), (0.241, 0.63), (0.236, 0.64)],
            n,
        );
    } else {
        solid.turned(Vec3::ZERO, &[(0.17, -0.1), (0.25, 0.68), (0.25, 0.87), (0.0, 0.95)], n);
    }
    pieces
}

/// A cast bollard of 95 cm.
fn bollard(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(IRON);
    if level == 0 {
        solid.turned(
            Vec3::ZERO,
            &[
                (0.10, -0.2),
                (0.10, 0.10),
                (0.075, 0.14),
                (0.06, 0.72),
                (0.08, 0.75),
                (0.08, 0.79),
                (0.045, 0.81),
                (0.075, 0.87),
                (0.055, 0.93),
                (0.0, 0.95),
            ],
            14,
        );
        solid.paint(WHITE);
        solid.turned(
            Vec3::ZERO,
            &[(0.0625, 0.58), (0.0655, 0.60), (0.0645, 0.68), (0.061, 0.70)],
            14,
        );
    } else {
        solid.turned(Vec3::ZERO, &[(0.09, -0.2), (0.07, 0.85), (0.0, 0.95)], 6);
    }
    pieces
}

/// A yellow post box on a foot, 1.45 m; its slot looks along +z.
fn post_box(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    if level == 1 {
        solid.paint(YELLOW);
        solid.block(Vec3::new(0.0, 0.625, 0.0), Vec3::new(0.5, 1.65, 0.38));
        return pieces;
    }
    solid.paint(DARK_STEEL);
    solid.rounded(Vec3::new(0.0, 0.2, 0.0), Vec3::new(0.22, 0.8, 0.22), 0.015);
    solid.paint(YELLOW);
    // A body with a round top, swept along x.
    solid.apart();
    let ring = |x: f32| {
        let mut ring = vec![Vec3::new(x, 0.5, 0.2), Vec3::new(x, 0.5, -0.2)];
        for k in 0..=8 {
            let (sin, cos) = sin_cos(0.5 * TURN * k as f32 / 8.0);
            ring.push(Vec3::new(x, 1.25 + 0.2 * sin, -0.2 * cos));
        }
        ring
    };
    solid.prism(&ring(-0.26), &ring(0.26));
    solid.paint(BLACK);
    solid.block(Vec3::new(0.0, 1.22, 0.2), Vec3::new(0.34, 0.035, 0.012));
    solid.rounded(Vec3::new(0.0, 0.83, 0.2), Vec3::new(0.40, 0.42, 0.012), 0.004);
    solid.paint(WHITE);
    solid.block(Vec3::new(0.0, 1.07, 0.2), Vec3::new(0.16, 0.1, 0.014));
    pieces
}

/// A bicycle in a stand of bent tube; it points along +z. Its frame takes the tint.
fn bicycle(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let n = [6, 4, 3][level.min(2) as usize];
    let solid = &mut pieces.plain;
    solid.paint(STEEL);
    let stand: Vec<(Vec3, f32)> = [
        (-0.35, -0.2),
        (-0.35, 0.62),
        (-0.28, 0.75),
        (0.28, 0.75),
        (0.35, 0.62),
        (0.35, -0.2),
    ]
    .map(|(z, y)| (Vec3::new(0.16, y, z + 0.1), 0.024))
    .into();
    solid.tube(&stand, n);
    let (rear, front, radius) = (-0.52, 0.53, 0.335);
    for z in [rear, front] {
        wheel(solid, Vec3::new(0.0, radius, z), radius, level);
    }
    let frame = &mut pieces.paint;
    let (crank, seat, head) = (
        Vec3::new(0.0, 0.29, -0.08),
        Vec3::new(0.0, 0.80, -0.24),
        Vec3::new(0.0, 0.82, 0.36),
    );
    let tubes = [
        (crank, head - Vec3::Y * 0.08, 0.017),
        (seat, head, 0.015),
        (crank, seat + Vec3::new(0.0, 0.12, -0.035), 0.016),
        (crank, Vec3::new(0.0, radius, rear), 0.012),
        (seat, Vec3::new(0.0, radius, rear), 0.010),
        (head + Vec3::new(0.0, 0.12, -0.03), Vec3::new(0.0, radius, front), 0.014),
    ];
    for (from, to, r) in tubes {
        frame.tube(&[(from, r), (to, r)], n);
    }
    let solid = &mut pieces.plain;
    solid.paint(BLACK);
    let bar = head + Vec3::new(0.0, 0.14, -0.03);
    let grip = |x: f32| (bar + Vec3::new(x, 0.03, -0.12), 0.013);
    let middle = [(bar - Vec3::X * 0.1, 0.012), (bar + Vec3::X * 0.1, 0.012)];
    if level < 2 {
        solid.tube(&[grip(-0.28), middle[0], middle[1], grip(0.28)], n);
        solid.rounded(seat + Vec3::new(0.0, 0.14, -0.04), Vec3::new(0.14, 0.05, 0.25), 0.02);
        solid.paint(CHROME);
        solid.tube(&[(crank - Vec3::X * 0.03, 0.085), (crank + Vec3::X * 0.03, 0.085)], 8);
        solid.block(crank + Vec3::new(0.09, -0.15, 0.03), Vec3::new(0.09, 0.02, 0.07));
        solid.block(crank + Vec3::new(-0.09, 0.15, -0.03), Vec3::new(0.09, 0.02, 0.07));
    } else {
        solid.tube(&[grip(-0.28), grip(0.28)], n);
    }
    pieces
}

/// A thin wheel in the plane x = 0.
fn wheel(solid: &mut Solid, center: Vec3, radius: f32, level: u32) {
    let n = [18, 10, 7][level.min(2) as usize];
    let at = |k: u32, r: f32, x: f32| {
        let (sin, cos) = sin_cos(TURN * k as f32 / n as f32);
        center + Vec3::new(x, r * cos, r * sin)
    };
    solid.paint(RUBBER).apart();
    // A ring of triangular section.
    for k in 0..n {
        let ring = |k: u32| {
            [
                at(k, radius, 0.0),
                at(k, radius - 0.035, 0.016),
                at(k, radius - 0.035, -0.016),
            ]
        };
        let (a, b) = (ring(k), ring(k + 1));
        for i in 0..3 {
            let j = (i + 1) % 3;
            solid.quad([a[i], a[j], b[j], b[i]]);
        }
    }
    if level == 0 {
        solid.paint(CHROME);
        for k in 0..9 {
            solid.tube(&[(center, 0.003), (at(2 * k, radius - 0.03, 0.0), 0.003)], 3);
        }
    }
}

/// An iron grate of 1.6 m around a street tree, with a hole in its middle.
fn grate(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(LOGS[1]);
    solid.block(Vec3::new(0.0, -0.02, 0.0), Vec3::new(1.56, 0.06, 1.56));
    solid.paint(IRON);
    for side in [-1.0, 1.0] {
        solid.block(Vec3::new(0.0, 0.0, 0.78 * side), Vec3::new(1.6, 0.06, 0.05));
        solid.block(Vec3::new(0.78 * side, 0.0, 0.0), Vec3::new(0.05, 0.06, 1.51));
    }
    if level == 0 {
        for k in 0..28 {
            let (sin, cos) = sin_cos(TURN * k as f32 / 28.0);
            let d = Vec3::new(sin, 0.0, cos);
            let reach = 0.76 / sin.abs().max(cos.abs());
            solid.beam(
                d * 0.34 + Vec3::Y * 0.015,
                d * reach + Vec3::Y * 0.015,
                Vec2::new(0.022, 0.03),
                d.cross(Vec3::Y),
            );
        }
    }
    pieces
}

/// A planter of fired clay, 60 cm; a bush goes into it.
fn pot(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(CLAY);
    if level == 0 {
        solid.turned(
            Vec3::ZERO,
            &[
                (0.26, -0.05),
                (0.27, 0.03),
                (0.37, 0.46),
                (0.42, 0.48),
                (0.43, 0.58),
                (0.41, 0.60),
                (0.36, 0.59),
                (0.35, 0.54),
            ],
            20,
        );
    } else {
        solid.turned(Vec3::ZERO, &[(0.26, -0.05), (0.42, 0.58), (0.36, 0.56)], 7);
    }
    solid.paint(LOGS[1]);
    solid.turned(Vec3::ZERO, &[(0.352, 0.53), (0.30, 0.555), (0.0, 0.57)], 7);
    pieces
}

/// A panel of a park railing: 2 m along +x from the origin, 1.1 m high, its post at the origin.
fn railing(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(IRON);
    solid.beam(Vec3::Y * -0.2, Vec3::Y * 1.12, Vec2::splat(0.05), Vec3::X);
    if level == 0 {
        solid.turned(
            Vec3::Y * 1.12,
            &[(0.02, 0.0), (0.042, 0.04), (0.02, 0.08), (0.0, 0.1)],
            8,
        );
    }
    for y in [0.15, 0.92] {
        solid.beam(
            Vec3::new(0.0, y, 0.0),
            Vec3::new(2.0, y, 0.0),
            Vec2::new(0.012, 0.04),
            Vec3::Z,
        );
    }
    let bars = 14;
    for k in 1..bars {
        let x = 2.0 * k as f32 / bars as f32;
        let (foot, top) = (Vec3::new(x, 0.08, 0.0), Vec3::new(x, 1.0, 0.0));
        match level {
            0 => {
                solid.tube(&[(foot, 0.009), (top, 0.009)], 5);
                // A spear head.
                solid.turned(top, &[(0.009, 0.0), (0.022, 0.03), (0.0, 0.11)], 4);
            }
            1 => solid.tube(&[(foot, 0.010), (top, 0.010), (top + Vec3::Y * 0.1, 0.0)], 3),
            _ if k % 2 == 0 => {
                let half = Vec3::X * 0.016;
                solid.apart();
                for side in [half, -half] {
                    solid.face(&[foot - side, foot + side, top + Vec3::Y * 0.1]);
                }
            }
            _ => {}
        }
    }
    pieces
}
