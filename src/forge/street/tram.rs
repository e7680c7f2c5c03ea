//! A tram of two cars with a pantograph; its front looks along +z, rails lie at height 0.

use bevy_math::{Vec2, Vec3};

use super::{
    Pieces, Yard,
    palette::{BLACK, CHROME, CREAM, DARK_STEEL, GLASS, LAMP, RED_LAMP, RUBBER, STEEL, WHITE},
    solid::Solid,
};
use crate::forge::mesh::Model;

/// Half the length of one car.
const HALF: f32 = 5.4;
/// Distance between the middles of the cars.
const PITCH: f32 = 11.4;
/// Where the pantograph meets the wire.
const WIRE: f32 = 5.6;

/// `tram.glb`.
pub(super) fn forge() -> Model {
    let mut yard = Yard::new();
    let levels: Vec<(Pieces, f32)> = (0_u32..)
        .zip([0.16, 0.05, 0.0])
        .map(|(level, c)| (tram(level), c))
        .collect();
    yard.add("tram", &levels);
    yard.model
}

fn tram(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let mut car = Pieces::default();
    body(&mut car, level);
    running_gear(&mut car.plain, level);
    for (heading, z) in [(0.0, 0.5 * PITCH), (std::f32::consts::PI, -0.5 * PITCH)] {
        let at = Vec3::Z * z;
        pieces.plain.add(&car.plain, at, heading, 1.0);
        pieces.glossy.add(&car.glossy, at, heading, 1.0);
        pieces.paint.add(&car.paint, at, heading, 1.0);
    }
    let plain = &mut pieces.plain;
    // Bellows between the cars.
    plain.paint(RUBBER);
    let folds = if level == 0 { 5 } else { 1 };
    for i in 0..folds {
        let z = (i as f32 - 0.5 * (folds - 1) as f32) * 0.15;
        let deep = if level == 0 { 0.07 } else { 0.7 };
        plain.block(Vec3::new(0.0, 1.65, z), Vec3::new(1.9, 2.4, deep));
    }
    if level == 0 {
        plain.block(Vec3::new(0.0, 1.65, 0.0), Vec3::new(1.75, 2.25, 0.7));
    }
    pantograph(plain, level);
    pieces
}

/// One car: its nose at +z, the bellows at −z.
fn body(car: &mut Pieces, level: u32) {
    // Places along the car, with the share of the full width there and how far the front of the roof is drawn down.
    let mut stations = vec![
        (HALF, 0.70, 0.50),
        (HALF - 0.14, 0.84, 0.30),
        (HALF - 0.65, 0.95, 0.06),
        (HALF - 1.2, 1.0, 0.0),
    ];
    if level < 2 {
        for i in 0..6 {
            let z = HALF - 1.4 - 1.5 * i as f32;
            stations.extend([(z, 1.0, 0.0), (z - 1.38, 1.0, 0.0)]);
        }
    }
    stations.push((-HALF, 1.0, 0.0));
    let section = |(z, wide, drawn): (f32, f32, f32)| {
        let upper = |y: f32| y - drawn * (y - 1.3).max(0.0) * 0.35;
        let half: &[(f32, f32)] = if level == 2 {
            &[(1.15, 0.32), (1.2, 1.32), (1.14, 2.55), (0.8, 3.12)]
        } else {
            &[
                (1.08, 0.30),
                (1.19, 0.48),
                (1.20, 0.95),
                (1.20, 1.32),
                (1.14, 2.55),
                (1.09, 2.86),
                (0.84, 3.08),
                (0.40, 3.15),
            ]
        };
        let right: Vec<Vec3> = half.iter().map(|(x, y)| Vec3::new(x * wide, upper(*y), z)).collect();
        let left = right.iter().rev().map(|p| p.with_x(-p.x));
        right.iter().copied().chain(left).collect::<Vec<Vec3>>()
    };
    let rows: Vec<Vec<Vec3>> = stations.iter().map(|station| section(*station)).collect();
    let last = rows[0].len() - 1;
    let (window, roof) = if level == 2 { (1, 2) } else { (3, 5) };
    let kind = |i: usize, j: usize| {
        let j = j.min(last - 1 - j);
        let length = stations[i].0 - stations[i + 1].0;
        let nose = i == 1 || i == 2;
        // The second, fourth and sixth opening are doors.
        let door = level < 2 && length > 1.3 && length < 1.45 && (i / 2) % 2 == 1;
        if (j == window && (length > 0.4 || nose)) || (door && j + 1 == window) {
            GLASS
        } else if j >= roof {
            STEEL
        } else if j + 1 == roof {
            CREAM
        } else {
            WHITE
        }
    };
    car.paint.apart();
    car.paint.hull(&rows, |i, j| (kind(i, j) == WHITE).then_some(WHITE));
    car.plain.apart();
    car.plain
        .hull(&rows, |i, j| [STEEL, CREAM].contains(&kind(i, j)).then(|| kind(i, j)));
    car.glossy.apart();
    car.glossy.hull(&rows, |i, j| (kind(i, j) == GLASS).then_some(GLASS));
    car.paint.apart();
    car.paint.face(&rows[0]);
    let mut back = rows[rows.len() - 1].clone();
    back.reverse();
    car.plain.paint(DARK_STEEL).apart();
    car.plain.face(&back);
    nose(car, level);
}

/// Windscreen, lamps, line number, bumper.
fn nose(car: &mut Pieces, level: u32) {
    let glossy = &mut car.glossy;
    glossy.paint(GLASS).apart();
    let z = HALF + 0.012;
    glossy.face(&[
        Vec3::new(-0.74, 1.38, z),
        Vec3::new(0.74, 1.38, z),
        Vec3::new(0.70, 2.26, z),
        Vec3::new(-0.70, 2.26, z),
    ]);
    if level == 2 {
        return;
    }
    for side in [-1.0, 1.0] {
        glossy.paint(LAMP);
        glossy.rounded(Vec3::new(0.58 * side, 0.86, HALF), Vec3::new(0.24, 0.16, 0.07), 0.03);
        glossy.paint(RED_LAMP);
        glossy.rounded(Vec3::new(0.58 * side, 1.08, HALF), Vec3::new(0.20, 0.08, 0.06), 0.02);
    }
    let plain = &mut car.plain;
    plain.paint(BLACK);
    plain.rounded(Vec3::new(0.0, 0.48, HALF + 0.02), Vec3::new(1.5, 0.22, 0.24), 0.06);
    plain.rounded(Vec3::new(0.0, 2.42, HALF - 0.07), Vec3::new(1.0, 0.22, 0.16), 0.03);
    if level == 0 {
        // Door leaves, wipers, mirrors, what stands on the roof.
        for side in [-1.0, 1.0] {
            plain.tube(
                &[
                    (Vec3::new(0.3 * side, 1.4, HALF + 0.03), 0.012),
                    (Vec3::new(0.5 * side, 1.95, HALF + 0.03), 0.009),
                ],
                4,
            );
            let mirror = Vec3::new(1.26 * side, 2.1, HALF - 0.35);
            plain.rounded(mirror, Vec3::new(0.12, 0.34, 0.1), 0.03);
            plain.tube(
                &[
                    (mirror + Vec3::Y * 0.1, 0.014),
                    (Vec3::new(1.0 * side, 2.4, HALF - 0.5), 0.014),
                ],
                4,
            );
        }
        plain.paint(DARK_STEEL);
        plain.rounded(Vec3::new(0.0, 3.24, 2.2), Vec3::new(1.5, 0.28, 2.2), 0.06);
        plain.rounded(Vec3::new(0.0, 3.22, -3.3), Vec3::new(1.3, 0.24, 1.6), 0.06);
    } else {
        plain.paint(DARK_STEEL);
        plain.block(Vec3::new(0.0, 3.24, 2.2), Vec3::new(1.5, 0.28, 2.2));
    }
}

/// Two bogies below a car.
fn running_gear(solid: &mut Solid, level: u32) {
    for z in [3.3, -3.3] {
        solid.paint(BLACK);
        solid.block(Vec3::new(0.0, 0.36, z), Vec3::new(1.9, 0.36, 2.5));
        if level == 2 {
            continue;
        }
        solid.paint(DARK_STEEL);
        let n = if level == 0 { 14 } else { 7 };
        for axle in [-0.9, 0.9] {
            for side in [-1.0, 1.0] {
                let at = |x: f32, r: f32| (Vec3::new(x * side, 0.31, z + axle), r);
                solid.tube(&[at(0.46, 0.34), at(0.50, 0.33), at(0.50, 0.31), at(0.60, 0.31)], n);
            }
        }
    }
    solid.paint(BLACK);
    solid.block(Vec3::new(0.0, 0.42, 0.0), Vec3::new(1.9, 0.3, 3.4));
}

/// Two bent arms from the roof of the front car to the wire.
fn pantograph(solid: &mut Solid, level: u32) {
    let z = 0.5 * PITCH - 1.2;
    let n = if level == 0 { 6 } else { 3 };
    solid.paint(DARK_STEEL);
    solid.block(Vec3::new(0.0, 3.26, z), Vec3::new(1.1, 0.14, 1.3));
    let knee = Vec3::new(0.0, 4.35, z - 1.05);
    let head = Vec3::new(0.0, WIRE - 0.12, z + 0.15);
    for x in [-0.32, 0.32] {
        let side = Vec3::X * x;
        solid.tube(&[(Vec3::new(x, 3.33, z + 0.45), 0.035), (knee + side, 0.03)], n);
        solid.tube(&[(knee + side, 0.028), (head + side, 0.022)], n);
    }
    solid.tube(&[(knee - Vec3::X * 0.38, 0.03), (knee + Vec3::X * 0.38, 0.03)], n);
    solid.paint(CHROME);
    for off in [-0.16, 0.16] {
        let bow = |x: f32, y: f32| (Vec3::new(x, y, head.z + off), 0.02);
        solid.tube(
            &[
                bow(-0.85, WIRE - 0.26),
                bow(-0.62, WIRE - 0.05),
                bow(0.62, WIRE - 0.05),
                bow(0.85, WIRE - 0.26),
            ],
            n.min(5),
        );
    }
    if level == 0 {
        solid.paint(STEEL);
        for x in [-0.32, 0.32] {
            solid.beam(
                head + Vec3::new(x, 0.03, -0.2),
                head + Vec3::new(x, 0.03, 0.2),
                Vec2::splat(0.03),
                Vec3::Y,
            );
        }
    }
}
