//! What stands on poles: lamps, traffic lights, signs, the poles of the tram's wire.

use bevy_math::{Vec2, Vec3};

use super::{
    Pieces, Yard,
    palette::{
        AMBER_LAMP, BLACK, BLUE, CROSSING, DARK_STEEL, GREEN, GREEN_LAMP, IRON, LAMP, NO_PARKING, PRIORITY, Piece,
        RED_LAMP, STEEL, STOP, STREET_NAME, WHITE, YELLOW,
    },
    solid::Solid,
};
use crate::forge::portable::{TURN, sin_cos};

/// Adds all that stands on poles.
pub(super) fn add(yard: &mut Yard) {
    let small = [0.16, 0.05, 0.006];
    yard.add(
        "lamp",
        &[0, 1, 2].map(|level| (modern(level), [0.22, 0.07, 0.008][level as usize])),
    );
    yard.add(
        "lamp_old",
        &[0, 1, 2].map(|level| (old(level), [0.22, 0.07, 0.008][level as usize])),
    );
    yard.add(
        "traffic_light",
        &[0, 1, 2].map(|level| (traffic_light(level), small[level as usize])),
    );
    for (name, face) in [
        ("sign_no_parking", NO_PARKING),
        ("sign_priority", PRIORITY),
        ("sign_crossing", CROSSING),
        ("sign_stop", STOP),
    ] {
        yard.add(
            name,
            &[0, 1].map(|level| (sign(face, level), [0.08, 0.01][level as usize])),
        );
    }
    yard.add(
        "street_name",
        &[0, 1].map(|level| (street_name(level), [0.08, 0.01][level as usize])),
    );
    yard.add(
        "wire_pole",
        &[0, 1, 2].map(|level| (wire_pole(level), [0.22, 0.07, 0.0][level as usize])),
    );
}

/// Sides of a round post in a level of detail.
fn sides(level: u32) -> u32 {
    [12, 7, 4][level.min(2) as usize]
}

/// A mast of 6.5 m whose arm reaches along +x.
fn modern(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let post = &mut pieces.plain;
    let n = sides(level);
    post.paint(DARK_STEEL);
    if level == 0 {
        post.turned(
            Vec3::ZERO,
            &[(0.16, -0.3), (0.16, 0.03), (0.115, 0.06), (0.11, 0.95), (0.085, 1.02)],
            n,
        );
        // The door to its fuses.
        post.rounded(Vec3::new(0.0, 0.62, 0.108), Vec3::new(0.09, 0.36, 0.02), 0.008);
    } else {
        post.turned(Vec3::ZERO, &[(0.13, -0.3), (0.10, 0.95)], n);
    }
    let shaft: &[(Vec3, f32)] = &[
        (Vec3::new(0.0, 0.9, 0.0), 0.078),
        (Vec3::new(0.0, 5.5, 0.0), 0.052),
        (Vec3::new(0.08, 5.95, 0.0), 0.047),
        (Vec3::new(0.30, 6.27, 0.0), 0.042),
        (Vec3::new(0.65, 6.42, 0.0), 0.038),
        (Vec3::new(1.35, 6.49, 0.0), 0.034),
    ];
    if level == 2 {
        post.tube(&[shaft[0], shaft[1], shaft[3], shaft[5]], 4);
        post.block(Vec3::new(1.6, 6.47, 0.0), Vec3::new(0.68, 0.09, 0.24));
        return pieces;
    }
    post.tube(shaft, n);
    // A flat head, thinner towards its tip, with the light below.
    let head = |x: f32, half: f32, low: f32, high: f32| {
        [
            Vec3::new(x, low, half),
            Vec3::new(x, low, -half),
            Vec3::new(x, high, -0.7 * half),
            Vec3::new(x, high, 0.7 * half),
        ]
    };
    post.apart();
    let rings = [
        head(1.26, 0.055, 6.45, 6.53),
        head(1.42, 0.13, 6.43, 6.545),
        head(1.80, 0.145, 6.43, 6.53),
        head(1.98, 0.08, 6.44, 6.48),
    ];
    for pair in rings.windows(2) {
        for i in 0..4 {
            let j = (i + 1) % 4;
            post.quad([pair[0][i], pair[1][i], pair[1][j], pair[0][j]]);
        }
    }
    post.quad(rings[0]);
    let [a, b, c, d] = rings[3];
    post.quad([d, c, b, a]);
    let glass = &mut pieces.glossy;
    glass.paint(LAMP);
    glass.block(Vec3::new(1.62, 6.424, 0.0), Vec3::new(0.34, 0.02, 0.2));
    pieces
}

/// A cast-iron lamp of 4.6 m with a lantern of six panes.
fn old(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let n = sides(level);
    let post = &mut pieces.plain;
    post.paint(IRON);
    let fine = [
        (0.21, -0.3),
        (0.21, 0.10),
        (0.175, 0.14),
        (0.165, 0.42),
        (0.19, 0.46),
        (0.19, 0.52),
        (0.12, 0.62),
        (0.095, 0.95),
        (0.115, 1.00),
        (0.115, 1.06),
        (0.062, 1.14),
        (0.048, 3.25),
        (0.085, 3.30),
        (0.085, 3.36),
        (0.045, 3.42),
        (0.045, 3.62),
        (0.10, 3.72),
        (0.10, 3.76),
    ];
    let middle = [
        (0.2, -0.3),
        (0.17, 0.5),
        (0.1, 0.95),
        (0.055, 1.14),
        (0.048, 3.6),
        (0.1, 3.76),
    ];
    let coarse = [(0.18, -0.3), (0.055, 1.1), (0.05, 3.76)];
    let profile: &[(f32, f32)] = match level {
        0 => &fine,
        1 => &middle,
        _ => &coarse,
    };
    post.turned(Vec3::ZERO, profile, n);
    if level == 0 {
        // The bar for the ladder.
        post.tube(
            &[
                (Vec3::new(-0.34, 3.33, 0.0), 0.018),
                (Vec3::new(0.34, 3.33, 0.0), 0.018),
            ],
            8,
        );
        for x in [-0.34, 0.34] {
            post.turned(Vec3::new(x, 3.33, 0.0), &[(0.0, -0.035), (0.033, 0.0), (0.0, 0.035)], 8);
        }
    }
    lantern(&mut pieces, level);
    pieces
}

/// Six panes that lean outwards, between bars, under a roof with a knob.
fn lantern(pieces: &mut Pieces, level: u32) {
    let corner = |k: u32, radius: f32, y: f32| {
        let (sin, cos) = sin_cos(TURN * k as f32 / 6.0);
        Vec3::new(radius * sin, y, radius * cos)
    };
    let panes = if level == 2 { 0.985 } else { 0.95 };
    let glass = &mut pieces.glossy;
    glass.paint(LAMP);
    glass.turned(Vec3::ZERO, &[(0.13 * panes, 3.78), (0.235 * panes, 4.22)], 6);
    let post = &mut pieces.plain;
    post.paint(IRON);
    if level < 2 {
        for k in 0..6 {
            post.beam(
                corner(k, 0.13, 3.75),
                corner(k, 0.238, 4.23),
                Vec2::splat(0.022),
                corner(k, 1.0, 0.0),
            );
            if level == 0 {
                let (low, high) = (corner(k, 0.132, 3.78), corner(k + 1, 0.132, 3.78));
                post.beam(low, high, Vec2::splat(0.022), Vec3::Y);
            }
        }
    }
    let roof: &[(f32, f32)] = if level == 0 {
        &[
            (0.285, 4.21),
            (0.285, 4.24),
            (0.16, 4.36),
            (0.10, 4.40),
            (0.10, 4.46),
            (0.03, 4.50),
            (0.045, 4.54),
            (0.0, 4.60),
        ]
    } else {
        &[(0.285, 4.21), (0.12, 4.40), (0.0, 4.60)]
    };
    post.turned(Vec3::ZERO, roof, 6);
}

/// A traffic light of 3.4 m whose lamps look along +z, with one for walkers on its side.
fn traffic_light(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let n = sides(level);
    let post = &mut pieces.plain;
    post.paint(DARK_STEEL);
    post.tube(&[(Vec3::Y * -0.3, 0.055), (Vec3::Y * 3.4, 0.05)], n);
    post.paint(BLACK);
    if level < 2 {
        post.rounded(Vec3::new(0.0, 2.85, 0.13), Vec3::new(0.28, 0.86, 0.14), 0.03);
        post.rounded(Vec3::new(0.13, 2.2, 0.0), Vec3::new(0.14, 0.52, 0.22), 0.02);
    } else {
        post.block(Vec3::new(0.0, 2.85, 0.13), Vec3::new(0.28, 0.86, 0.14));
        return pieces;
    }
    for (i, lamp) in [GREEN_LAMP, AMBER_LAMP, RED_LAMP].into_iter().enumerate() {
        let center = Vec3::new(0.0, 2.58 + 0.27 * i as f32, 0.2);
        disc(&mut pieces.glossy, center + Vec3::Z * 0.003, 0.095, n, lamp);
        if level == 0 {
            visor(&mut pieces.plain, center, 0.11, 0.17);
        }
    }
    for (y, lamp) in [(2.08, GREEN_LAMP), (2.32, RED_LAMP)] {
        let glass = &mut pieces.glossy;
        glass.paint(lamp);
        glass.block(Vec3::new(0.20, y, 0.0), Vec3::new(0.008, 0.16, 0.16));
    }
    let post = &mut pieces.plain;
    post.paint(YELLOW);
    post.rounded(Vec3::new(0.0, 1.12, 0.08), Vec3::new(0.09, 0.15, 0.07), 0.012);
    pieces
}

/// A flat disc that looks along +z.
fn disc(solid: &mut Solid, center: Vec3, radius: f32, sides: u32, swatch: Vec2) {
    let ring: Vec<Vec3> = (0..sides)
        .map(|k| {
            let (sin, cos) = sin_cos(TURN * k as f32 / sides as f32);
            center + Vec3::new(radius * cos, radius * sin, 0.0)
        })
        .collect();
    solid.paint(swatch).apart();
    solid.face(&ring);
}

/// A hood over a lamp that looks along +z: half a ring of two layers.
fn visor(solid: &mut Solid, center: Vec3, radius: f32, depth: f32) {
    solid.apart();
    let at = |k: u32, r: f32, z: f32| {
        let (sin, cos) = sin_cos(-0.35 + (TURN * 0.5 + 0.7) * k as f32 / 8.0);
        center + Vec3::new(r * cos, r * sin, z)
    };
    for k in 0..8 {
        solid.quad([
            at(k, radius, 0.0),
            at(k, radius, depth),
            at(k + 1, radius, depth),
            at(k + 1, radius, 0.0),
        ]);
        let inner = radius - 0.006;
        solid.quad([
            at(k + 1, inner, 0.0),
            at(k + 1, inner, depth),
            at(k, inner, depth),
            at(k, inner, 0.0),
        ]);
    }
}

/// A sign of 60 cm on a post of 2.6 m; it looks along +z.
fn sign(face: Piece, level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(STEEL);
    if level == 0 {
        solid.tube(&[(Vec3::Y * -0.3, 0.03), (Vec3::Y * 2.6, 0.03)], 8);
    } else {
        solid.tube(&[(Vec3::Y * -0.3, 0.03), (Vec3::Y * 2.6, 0.03)], 3);
    }
    plate(solid, Vec3::new(0.0, 2.25, 0.045), Vec2::splat(0.6), face, level == 0);
    pieces
}

/// A plate that looks along +z, grey behind.
fn plate(solid: &mut Solid, center: Vec3, size: Vec2, face: Piece, thick: bool) {
    let half = (0.5 * size).extend(0.0);
    let corner = |x: f32, y: f32, z: f32| center + half * Vec3::new(x, y, 0.0) + Vec3::Z * z;
    let z = if thick {
        solid.block(center, size.extend(0.012));
        0.0065
    } else {
        solid.apart();
        solid.face(&[
            corner(1.0, -1.0, 0.0),
            corner(-1.0, -1.0, 0.0),
            corner(-1.0, 1.0, 0.0),
            corner(1.0, 1.0, 0.0),
        ]);
        0.0
    };
    let corners = [
        corner(-1.0, -1.0, z),
        corner(1.0, -1.0, z),
        corner(1.0, 1.0, z),
        corner(-1.0, 1.0, z),
    ];
    solid.picture(corners, face.0, face.1);
}

/// Two street names crosswise on a post of 3 m.
fn street_name(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(GREEN);
    solid.tube(
        &[(Vec3::Y * -0.3, 0.035), (Vec3::Y * 3.0, 0.035)],
        if level == 0 { 10 } else { 3 },
    );
    if level == 0 {
        solid.turned(
            Vec3::Y * 3.0,
            &[(0.035, 0.0), (0.055, 0.03), (0.05, 0.07), (0.0, 0.1)],
            10,
        );
    }
    let band = |low: f32, high: f32| {
        let (from, to) = STREET_NAME;
        let at = |t: f32| from + (to - from) * t;
        (Vec2::new(from.x, at(low).y), Vec2::new(to.x, at(high).y))
    };
    for (heading, y) in [(0.0, 2.62), (0.25 * TURN, 2.86)] {
        for side in [0.0, 0.5 * TURN] {
            let mut one = Solid::new();
            one.paint(BLUE);
            if side == 0.0 && level == 0 {
                one.block(Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.86, 0.20, 0.012));
            }
            let corner = |x: f32, y: f32| Vec3::new(0.43 * x, 0.1 * y, 0.0075);
            let corners = [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
            ];
            let (low, high) = band(0.27, 0.73);
            one.picture(corners, low, high);
            solid.add(&one, Vec3::Y * y, heading + side, 1.0);
        }
    }
    pieces
}

/// A pole of 7.2 m for the wire of a tram; its bracket reaches 4 m along +x and holds the wire at a height of 5.6 m.
fn wire_pole(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let n = sides(level);
    let post = &mut pieces.plain;
    post.paint(DARK_STEEL);
    if level == 0 {
        post.turned(
            Vec3::ZERO,
            &[
                (0.17, -0.3),
                (0.17, 0.35),
                (0.13, 0.42),
                (0.11, 3.4),
                (0.12, 3.42),
                (0.12, 3.5),
                (0.085, 3.54),
                (0.075, 7.1),
                (0.0, 7.2),
            ],
            n,
        );
    } else {
        post.turned(Vec3::ZERO, &[(0.15, -0.3), (0.08, 7.1), (0.0, 7.2)], n);
    }
    let arm = if level == 2 { 3 } else { 6 };
    post.tube(
        &[(Vec3::new(0.0, 6.1, 0.0), 0.032), (Vec3::new(4.05, 6.1, 0.0), 0.026)],
        arm,
    );
    post.tube(
        &[(Vec3::new(0.0, 7.0, 0.0), 0.012), (Vec3::new(3.0, 6.12, 0.0), 0.012)],
        3,
    );
    if level < 2 {
        // The holder below the arm, with its insulators.
        post.tube(
            &[(Vec3::new(3.0, 6.1, 0.0), 0.016), (Vec3::new(4.0, 5.64, 0.0), 0.014)],
            arm,
        );
        post.tube(
            &[(Vec3::new(4.0, 6.1, 0.0), 0.012), (Vec3::new(4.0, 5.6, 0.0), 0.012)],
            4,
        );
        post.paint(WHITE);
        for (x, y) in [(0.35, 6.1), (3.3, 5.96)] {
            post.rounded(Vec3::new(x, y, 0.0), Vec3::new(0.16, 0.1, 0.1), 0.03);
        }
    }
    pieces
}
