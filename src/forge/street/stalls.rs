//! Things on squares and at stops: a kiosk, café tables with chairs, a parasol, a shelter.

use bevy_math::{Vec2, Vec3};

use super::{
    Pieces,
    palette::{
        AWNING, BLUE, CONCRETE, CREAM, DARK_STEEL, GLASS, GREEN, IRON, PAPERS, PLACARD, POSTER, RED, STONE, WOODS,
    },
    solid::Solid,
};
use crate::forge::portable::{TURN, sin_cos};

/// A kiosk of 3.2 by 2.4 m, 3.3 m high, with newspapers, a counter and an awning towards +z.
pub(super) fn kiosk(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(CONCRETE);
    solid.block(Vec3::new(0.0, -0.02, 0.0), Vec3::new(3.3, 0.36, 2.5));
    solid.paint(GREEN);
    solid.block(Vec3::new(0.0, 0.66, 0.0), Vec3::new(3.2, 1.0, 2.4));
    solid.block(Vec3::new(0.0, 2.55, 0.0), Vec3::new(3.2, 0.35, 2.4));
    let glass = &mut pieces.glossy;
    glass.paint(GLASS);
    glass.block(Vec3::new(0.0, 1.77, -0.04), Vec3::new(3.06, 1.22, 2.2));
    let solid = &mut pieces.plain;
    solid.paint(GREEN);
    let posts = [
        (-1.55, 1.15),
        (1.55, 1.15),
        (-1.55, -1.15),
        (1.55, -1.15),
        (-0.55, 1.15),
        (0.55, 1.15),
    ];
    for (x, z) in &posts[..if level == 0 { 6 } else { 4 }] {
        solid.block(Vec3::new(*x, 1.77, *z), Vec3::new(0.1, 1.24, 0.1));
    }
    // An overhanging roof with a curved cap.
    solid.paint(CREAM);
    if level == 0 {
        solid.rounded(Vec3::new(0.0, 2.78, 0.05), Vec3::new(3.7, 0.14, 3.0), 0.04);
    } else {
        solid.block(Vec3::new(0.0, 2.78, 0.05), Vec3::new(3.7, 0.14, 3.0));
    }
    solid.paint(GREEN).apart();
    let cap = |y: f32, x: f32, z: f32| {
        [
            Vec3::new(-x, y, z),
            Vec3::new(x, y, z),
            Vec3::new(x, y, -z),
            Vec3::new(-x, y, -z),
        ]
    };
    let steps = [
        cap(2.85, 1.62, 1.22),
        cap(2.98, 1.28, 0.92),
        cap(3.15, 0.75, 0.5),
        cap(3.3, 0.2, 0.12),
    ];
    for pair in steps.windows(2) {
        for i in 0..4 {
            let j = (i + 1) % 4;
            solid.quad([pair[0][i], pair[0][j], pair[1][j], pair[1][i]]);
        }
    }
    solid.face(&steps[steps.len() - 1]);
    // Prints: papers below the counter and at the sides, posters behind.
    let wall = |center: Vec3, right: Vec3, half: Vec2| {
        let (r, u) = (right * half.x, Vec3::Y * half.y);
        [center - r - u, center + r - u, center + r + u, center - r + u]
    };
    for x in [-1.05, 0.0, 1.05] {
        solid.picture(
            wall(Vec3::new(x, 0.68, 1.206), Vec3::X, Vec2::new(0.46, 0.36)),
            PAPERS.0,
            PAPERS.1,
        );
    }
    for side in [-1.0, 1.0] {
        solid.picture(
            wall(
                Vec3::new(1.606 * side, 1.5, 0.2),
                Vec3::NEG_Z * side,
                Vec2::new(0.6, 0.75),
            ),
            POSTER.0,
            POSTER.1,
        );
    }
    solid.picture(
        wall(Vec3::new(0.0, 1.5, -1.206), Vec3::NEG_X, Vec2::new(0.7, 0.75)),
        PLACARD.0,
        PLACARD.1,
    );
    // Counter and awning.
    solid.paint(WOODS[2]);
    solid.block(Vec3::new(0.0, 1.18, 1.32), Vec3::new(2.9, 0.05, 0.42));
    let (low, high) = (Vec3::new(1.7, 2.05, 2.15), Vec3::new(1.62, 2.62, 1.2));
    let mirrored = |p: Vec3| p.with_x(-p.x);
    let under = Vec3::Y * 0.012;
    for part in 0..3 {
        let across = |t: f32, p: Vec3| mirrored(p).lerp(p, t / 3.0);
        let (a, b) = (part as f32, part as f32 + 1.0);
        let corners = [across(a, low), across(b, low), across(b, high), across(a, high)];
        solid.picture(corners, AWNING.0, AWNING.1);
        let [p, q, r, s] = corners.map(|corner| corner - under);
        solid.picture([q, p, s, r], AWNING.0, AWNING.1);
        if level == 0 {
            let drop = Vec3::Y * -0.2;
            let edge = [corners[0] + drop, corners[1] + drop, corners[1], corners[0]];
            solid.picture(edge, AWNING.0, Vec2::new(AWNING.1.x, AWNING.0.y));
            let [p, q, r, s] = edge.map(|corner| corner - Vec3::Z * 0.012);
            solid.picture([q, p, s, r], AWNING.0, Vec2::new(AWNING.1.x, AWNING.0.y));
        }
    }
    if level == 0 {
        solid.paint(IRON);
        for x in [-1.6, 1.6] {
            solid.tube(
                &[(Vec3::new(x, 1.75, 1.2), 0.014), (Vec3::new(x, 2.03, 2.12), 0.014)],
                5,
            );
        }
    }
    // A stand with more papers beside the counter.
    solid.paint(DARK_STEEL);
    solid.block(Vec3::new(2.15, 0.6, 1.0), Vec3::new(0.5, 1.2, 0.06));
    solid.picture(
        wall(Vec3::new(2.15, 0.72, 1.036), Vec3::X, Vec2::new(0.22, 0.44)),
        PAPERS.0,
        PAPERS.1,
    );
    pieces
}

/// A round café table with three chairs.
pub(super) fn cafe(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    let n = [18, 8, 5][level.min(2) as usize];
    solid.paint(IRON);
    if level == 0 {
        solid.turned(
            Vec3::ZERO,
            &[(0.24, -0.05), (0.24, 0.02), (0.04, 0.05), (0.028, 0.1), (0.028, 0.7)],
            n,
        );
    } else {
        solid.turned(Vec3::ZERO, &[(0.2, -0.05), (0.03, 0.05), (0.03, 0.7)], n);
    }
    solid.paint(STONE);
    solid.turned(Vec3::ZERO, &[(0.33, 0.69), (0.35, 0.70), (0.35, 0.72), (0.34, 0.73)], n);
    let chair = chair(level);
    for k in 0..3 {
        let heading = TURN * (k as f32 / 3.0 + 0.06);
        let (sin, cos) = sin_cos(heading);
        solid.add(&chair, Vec3::new(-0.62 * sin, 0.0, -0.62 * cos), heading, 1.0);
    }
    pieces
}

/// A chair that looks along +z.
fn chair(level: u32) -> Solid {
    let mut solid = Solid::new();
    solid.paint(IRON);
    if level < 2 {
        let n = if level == 0 { 6 } else { 3 };
        for x in [-0.19, 0.19] {
            solid.tube(
                &[
                    (Vec3::new(x * 1.08, -0.03, 0.22), 0.012),
                    (Vec3::new(x, 0.45, 0.17), 0.012),
                ],
                n,
            );
            solid.tube(
                &[
                    (Vec3::new(x * 1.08, -0.03, -0.26), 0.012),
                    (Vec3::new(x, 0.45, -0.18), 0.012),
                    (Vec3::new(x, 0.84, -0.27), 0.012),
                ],
                n,
            );
        }
    }
    solid.paint(WOODS[2]);
    let seats: &[f32] = if level == 0 {
        &[-0.13, -0.02, 0.09, 0.19]
    } else {
        &[0.02]
    };
    let deep = if level == 0 { 0.085 } else { 0.40 };
    for z in seats {
        solid.block(Vec3::new(0.0, 0.46, *z), Vec3::new(0.42, 0.018, deep));
    }
    if level == 0 {
        for (y, z) in [(0.62, -0.22), (0.72, -0.243), (0.81, -0.263)] {
            solid.block(Vec3::new(0.0, y, z), Vec3::new(0.40, 0.06, 0.016));
        }
    } else {
        solid.block(Vec3::new(0.0, 0.72, -0.243), Vec3::new(0.40, 0.24, 0.016));
    }
    solid
}

/// A parasol of 3 m over a café table.
pub(super) fn parasol(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let n = 8;
    let solid = &mut pieces.plain;
    solid.paint(WOODS[2]);
    solid.tube(
        &[(Vec3::Y * 0.0, 0.024), (Vec3::Y * 2.62, 0.024)],
        if level == 0 { 8 } else { 3 },
    );
    if level == 0 {
        solid.paint(CONCRETE);
        solid.rounded(Vec3::new(0.0, 0.05, 0.0), Vec3::new(0.5, 0.12, 0.5), 0.03);
    }
    // Cloth takes the tint: eight gores with a hanging rim, and their underside.
    let cloth = &mut pieces.paint;
    let at = |k: u32, r: f32, y: f32| {
        let (sin, cos) = sin_cos(TURN * k as f32 / n as f32);
        Vec3::new(r * sin, y, r * cos)
    };
    for k in 0..n {
        cloth.apart();
        let (rim, top) = (|k: u32, y: f32| at(k, 1.5, y), Vec3::Y * 2.62);
        let middle = |k: u32, y: f32| at(k, 0.8, y);
        cloth.face(&[middle(k, 2.40), middle(k + 1, 2.40), top]);
        cloth.quad([rim(k, 2.10), rim(k + 1, 2.10), middle(k + 1, 2.40), middle(k, 2.40)]);
        cloth.apart();
        cloth.face(&[rim(k + 1, 2.09), rim(k, 2.09), top - Vec3::Y * 0.012]);
        if level == 0 {
            cloth.apart();
            cloth.quad([rim(k, 1.92), rim(k + 1, 1.92), rim(k + 1, 2.10), rim(k, 2.10)]);
            let inner = |k: u32, y: f32| at(k, 1.49, y);
            cloth.quad([inner(k + 1, 1.92), inner(k, 1.92), inner(k, 2.10), inner(k + 1, 2.10)]);
        }
    }
    if level == 0 {
        let solid = &mut pieces.plain;
        solid.paint(WOODS[1]);
        for k in 0..n {
            solid.beam(at(k, 0.02, 2.56), at(k, 1.47, 2.07), Vec2::new(0.018, 0.014), Vec3::Y);
        }
    }
    pieces
}

/// A tram stop: glass on a frame, 4 m along x, open towards +z, with a bench and a poster.
pub(super) fn shelter(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let solid = &mut pieces.plain;
    solid.paint(DARK_STEEL);
    for x in [-1.95, -0.65, 0.65, 1.95] {
        solid.beam(
            Vec3::new(x, -0.2, -0.65),
            Vec3::new(x, 2.45, -0.65),
            Vec2::splat(0.07),
            Vec3::X,
        );
    }
    if level == 0 {
        solid.rounded(Vec3::new(0.0, 2.5, 0.0), Vec3::new(4.3, 0.1, 1.75), 0.03);
        for x in [-1.95, 1.95] {
            solid.beam(
                Vec3::new(x, 2.4, -0.65),
                Vec3::new(x, 2.4, 0.7),
                Vec2::splat(0.06),
                Vec3::X,
            );
        }
    } else {
        solid.block(Vec3::new(0.0, 2.5, 0.0), Vec3::new(4.3, 0.1, 1.75));
    }
    for y in [0.12, 2.38] {
        solid.block(Vec3::new(0.0, y, -0.65), Vec3::new(3.9, 0.06, 0.05));
    }
    // A lit case with a poster on both sides.
    solid.block(Vec3::new(1.95, 1.15, 0.05), Vec3::new(0.16, 2.1, 1.3));
    for side in [-1.0, 1.0] {
        let (r, u) = (Vec3::NEG_Z * side * 0.56, Vec3::Y * 0.86);
        let c = Vec3::new(1.95 + 0.0815 * side, 1.2, 0.05);
        let piece = if side > 0.0 { POSTER } else { PLACARD };
        solid.picture([c - r - u, c + r - u, c + r + u, c - r + u], piece.0, piece.1);
    }
    solid.paint(BLUE);
    solid.block(Vec3::new(0.0, 2.5, 0.882), Vec3::new(4.28, 0.09, 0.012));
    let glass = &mut pieces.glossy;
    glass.paint(GLASS);
    for x in [-1.3, 0.0, 1.3] {
        glass.block(Vec3::new(x, 1.25, -0.65), Vec3::new(1.2, 2.16, 0.012));
    }
    glass.block(Vec3::new(-1.95, 1.25, 0.0), Vec3::new(0.012, 2.16, 1.2));
    let solid = &mut pieces.plain;
    solid.paint(WOODS[0]);
    if level > 0 {
        solid.block(Vec3::new(-0.5, 0.46, -0.3), Vec3::new(2.2, 0.035, 0.34));
    } else {
        for z in [-0.42, -0.30, -0.18] {
            solid.block(Vec3::new(-0.5, 0.46, z), Vec3::new(2.2, 0.035, 0.1));
        }
        solid.paint(DARK_STEEL);
        for x in [-1.3, 0.3] {
            solid.block(Vec3::new(x, 0.13, -0.3), Vec3::new(0.05, 0.62, 0.34));
        }
    }
    solid.paint(RED);
    solid.block(Vec3::new(-1.0, 2.66, 0.5), Vec3::new(1.2, 0.22, 0.05));
    pieces
}
