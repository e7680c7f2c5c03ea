//! A fountain: an octagonal basin of 7 m, a pillar with two bowls, falling water.

use bevy_math::Vec3;

use super::{
    Pieces, Yard,
    palette::{BRONZE, DARK_STONE, STONE, WATER, WHITE},
    solid::Solid,
};
use crate::forge::{
    mesh::Model,
    portable::{TURN, mix, sin_cos},
};

/// `fountain.glb`.
pub(super) fn forge() -> Model {
    let mut yard = Yard::new();
    let levels: Vec<(Pieces, f32)> = (0_u32..)
        .zip([0.22, 0.07, 0.0])
        .map(|(level, c)| (fountain(level), c))
        .collect();
    yard.add("fountain", &levels);
    yard.model
}

fn fountain(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let n = [24, 12, 8][level.min(2) as usize];
    let stone = &mut pieces.plain;
    stone.paint(DARK_STONE);
    for (radius, low, high) in [(4.3, -0.3, 0.14), (3.9, 0.0, 0.28)] {
        stone.turned(
            Vec3::ZERO,
            &[(radius, low), (radius, high - 0.02), (radius - 0.02, high)],
            8,
        );
    }
    stone.paint(STONE);
    let rim: &[(f32, f32)] = if level == 0 {
        &[
            (3.42, 0.28),
            (3.46, 0.34),
            (3.34, 0.42),
            (3.34, 0.66),
            (3.44, 0.72),
            (3.52, 0.78),
            (3.52, 0.86),
            (3.48, 0.89),
            (3.04, 0.89),
            (3.0, 0.86),
            (3.0, 0.4),
        ]
    } else {
        &[
            (3.42, 0.28),
            (3.34, 0.66),
            (3.52, 0.78),
            (3.50, 0.89),
            (3.0, 0.89),
            (3.0, 0.4),
        ]
    };
    stone.turned(Vec3::ZERO, rim, 8);
    pillar(stone, n, level);
    bronze(stone, level);
    let water = &mut pieces.glossy;
    water.paint(WATER);
    for (radius, y) in [(3.02, 0.72), (1.30, 2.16), (0.64, 3.02)] {
        water.turned(
            Vec3::ZERO,
            &[(radius, y), (0.0, y + 0.004)],
            if radius > 3.0 { 8 } else { n },
        );
    }
    if level < 2 {
        jets(water, level);
    }
    pieces
}

/// The pillar and its bowls, turned in one profile each.
fn pillar(stone: &mut Solid, n: u32, level: u32) {
    if level == 2 {
        stone.turned(
            Vec3::ZERO,
            &[
                (0.8, 0.28),
                (0.4, 1.0),
                (0.3, 1.75),
                (1.45, 2.22),
                (1.3, 2.16),
                (0.2, 2.12),
            ],
            n,
        );
        stone.turned(
            Vec3::ZERO,
            &[(0.28, 2.1), (0.2, 2.7), (0.72, 3.06), (0.64, 3.02), (0.1, 3.0)],
            n,
        );
        return;
    }
    stone.turned(
        Vec3::ZERO,
        &[
            (0.95, 0.28),
            (0.95, 0.80),
            (0.88, 0.86),
            (0.62, 0.90),
            (0.55, 1.00),
            (0.38, 1.10),
            (0.34, 1.25),
            (0.40, 1.45),
            (0.33, 1.60),
            (0.36, 1.66),
            (0.36, 1.72),
            (0.75, 1.84),
            (1.15, 2.00),
            (1.38, 2.14),
            (1.48, 2.17),
            (1.48, 2.23),
            (1.42, 2.25),
            (1.32, 2.20),
            (1.20, 2.12),
            (0.30, 2.10),
        ],
        n,
    );
    stone.turned(
        Vec3::ZERO,
        &[
            (0.34, 2.10),
            (0.30, 2.22),
            (0.18, 2.32),
            (0.17, 2.45),
            (0.21, 2.55),
            (0.16, 2.66),
            (0.30, 2.74),
            (0.55, 2.88),
            (0.68, 3.00),
            (0.75, 3.03),
            (0.75, 3.08),
            (0.70, 3.09),
            (0.60, 3.00),
            (0.15, 2.98),
        ],
        n,
    );
}

/// A heron with raised wings on a ball.
fn bronze(solid: &mut Solid, level: u32) {
    solid.paint(BRONZE);
    let n = if level == 0 { 12 } else { 6 };
    solid.turned(
        Vec3::ZERO,
        &[
            (0.16, 2.98),
            (0.12, 3.14),
            (0.20, 3.20),
            (0.22, 3.32),
            (0.16, 3.44),
            (0.0, 3.48),
        ],
        n,
    );
    if level == 2 {
        solid.turned(Vec3::ZERO, &[(0.12, 3.4), (0.14, 3.8), (0.0, 4.32)], 4);
        return;
    }
    let at = |y: f32, z: f32| Vec3::new(0.0, y, z);
    for x in [-0.035, 0.035] {
        let side = Vec3::X * x;
        solid.tube(&[(at(3.44, 0.0) + side, 0.014), (at(3.66, -0.02) + side, 0.016)], 5);
    }
    solid.tube(
        &[
            (at(3.62, -0.26), 0.01),
            (at(3.66, -0.12), 0.085),
            (at(3.74, 0.02), 0.115),
            (at(3.84, 0.13), 0.075),
            (at(3.96, 0.17), 0.040),
        ],
        n,
    );
    solid.tube(
        &[
            (at(3.92, 0.17), 0.042),
            (at(4.06, 0.13), 0.030),
            (at(4.18, 0.13), 0.026),
            (at(4.25, 0.19), 0.034),
            (at(4.25, 0.24), 0.024),
            (at(4.235, 0.42), 0.004),
        ],
        n.min(8),
    );
    // Wings: fans of feathers with two sides.
    for side in [-1.0, 1.0] {
        let root = Vec3::new(side * 0.08, 3.80, 0.02);
        let tip = |k: u32| {
            let (sin, cos) = sin_cos(mix(0.25, 1.25, k as f32 / 6.0));
            let reach = mix(0.62, 0.42, k as f32 / 6.0);
            root + Vec3::new(side * 0.55 * cos, 0.75 * cos, -sin) * reach
        };
        for k in 0..6 {
            let (a, b) = (tip(k), tip(k + 1));
            let notch = root.lerp((a + b) * 0.5, 0.84);
            let thick = Vec3::new(side * 0.012, -0.008, 0.0);
            for corners in [[root, a, notch], [root, notch, b]] {
                let lower = corners.map(|p| p - thick);
                solid.apart();
                if side > 0.0 {
                    solid.face(&[corners[0], corners[2], corners[1]]);
                    solid.face(&lower);
                } else {
                    solid.face(&corners);
                    solid.face(&[lower[0], lower[2], lower[1]]);
                }
            }
        }
    }
}

/// Thin jets from the rim of the basin and from the upper bowl.
fn jets(water: &mut Solid, level: u32) {
    water.paint(WHITE);
    let steps = if level == 0 { 8 } else { 4 };
    let mut arc = |from: Vec3, to: Vec3, rise: f32| {
        let point = |i: u32| {
            let t = i as f32 / steps as f32;
            (
                from.lerp(to, t) + Vec3::Y * (4.0 * rise * t * (1.0 - t)),
                mix(0.012, 0.020, t),
            )
        };
        water.tube(&(0..=steps).map(point).collect::<Vec<_>>(), 3);
    };
    for k in 0..8 {
        let (sin, cos) = sin_cos(TURN * (k as f32 + 0.5) / 8.0);
        let d = Vec3::new(sin, 0.0, cos);
        arc(d * 2.95 + Vec3::Y * 0.8, d * 1.7 + Vec3::Y * 0.72, 0.75);
        arc(d * 0.72 + Vec3::Y * 3.07, d * 1.0 + Vec3::Y * 2.17, 0.12);
        if k % 2 == 0 {
            arc(d * 1.46 + Vec3::Y * 2.22, d * 1.9 + Vec3::Y * 0.72, 0.18);
        }
    }
}
