//! Parked cars: hulls over stations along the car, with real wheel arches; the front looks along +z.

use bevy_math::{Vec2, Vec3};

use super::{
    Pieces, Yard,
    palette::{AMBER_LAMP, BLACK, CHROME, DARK_STEEL, GLASS, LAMP, PLATE, RED_LAMP, RUBBER, STEEL, WHITE},
    solid::Solid,
};
use crate::forge::{
    mesh::Model,
    portable::{TURN, mix, sin_cos},
};

/// Heights on the screen down to which the levels are meant.
const COVERAGES: [f32; 3] = [0.07, 0.022, 0.0];

/// A line over the length of a car: (z, value) from the front to the rear, z falling.
type Line = &'static [(f32, f32)];

/// A body, in metres.
struct Body {
    /// Outline seen from the side: bonnet, roof, boot.
    top: Line,
    /// Half the width seen from above.
    half: Line,
    /// Lower edge of the side windows.
    belt: f32,
    /// z of both ends of the windscreen, of the rear window, and of the pillars between side windows.
    screen: (f32, f32),
    rear: (f32, f32),
    pillars: &'static [f32],
    /// Foremost and last side window.
    windows: (f32, f32),
    /// z of the axles, radius of the wheels.
    axles: (f32, f32),
    wheel: f32,
    /// Height of the sill.
    sill: f32,
}

const HATCHBACK: Body = Body {
    top: &[
        (2.05, 0.58),
        (1.99, 0.70),
        (1.80, 0.79),
        (1.02, 0.96),
        (0.28, 1.39),
        (-0.10, 1.455),
        (-0.60, 1.465),
        (-1.30, 1.41),
        (-1.52, 1.36),
        (-1.93, 0.99),
        (-2.00, 0.88),
        (-2.05, 0.55),
    ],
    half: &[
        (2.05, 0.60),
        (1.95, 0.73),
        (1.6, 0.83),
        (0.8, 0.87),
        (-1.2, 0.87),
        (-1.7, 0.83),
        (-1.98, 0.75),
        (-2.05, 0.68),
    ],
    belt: 0.93,
    screen: (1.02, 0.28),
    rear: (-1.52, -1.93),
    pillars: &[-0.16, -1.02],
    windows: (0.66, -1.46),
    axles: (1.28, -1.27),
    wheel: 0.315,
    sill: 0.21,
};

const ESTATE: Body = Body {
    top: &[
        (2.32, 0.56),
        (2.26, 0.70),
        (2.05, 0.80),
        (1.22, 0.95),
        (0.42, 1.38),
        (0.05, 1.45),
        (-0.60, 1.47),
        (-1.75, 1.42),
        (-2.00, 1.37),
        (-2.26, 0.98),
        (-2.31, 0.85),
        (-2.35, 0.55),
    ],
    half: &[
        (2.32, 0.62),
        (2.2, 0.76),
        (1.8, 0.86),
        (1.0, 0.90),
        (-1.5, 0.90),
        (-2.0, 0.86),
        (-2.28, 0.78),
        (-2.35, 0.70),
    ],
    belt: 0.93,
    screen: (1.22, 0.42),
    rear: (-2.00, -2.26),
    pillars: &[0.02, -0.92, -1.30],
    windows: (0.86, -1.98),
    axles: (1.45, -1.38),
    wheel: 0.33,
    sill: 0.2,
};

/// The cab of the lorry.
const CAB: Body = Body {
    top: &[
        (2.85, 0.75),
        (2.83, 1.10),
        (2.72, 1.30),
        (2.28, 2.08),
        (2.05, 2.18),
        (1.35, 2.20),
        (1.30, 2.20),
    ],
    half: &[(2.85, 0.84), (2.75, 0.92), (2.5, 0.96), (1.3, 0.96)],
    belt: 1.25,
    screen: (2.72, 2.28),
    rear: (0.0, 0.0),
    pillars: &[],
    windows: (2.42, 1.55),
    axles: (2.05, -1.65),
    wheel: 0.37,
    sill: 0.33,
};

/// `cars.glb`.
pub(super) fn forge() -> Model {
    let mut yard = Yard::new();
    for (name, shape) in [
        ("hatchback", (|level| car(&HATCHBACK, level)) as fn(u32) -> Pieces),
        ("estate", |level| car(&ESTATE, level)),
        ("lorry", lorry),
    ] {
        let levels: Vec<(Pieces, f32)> = (0_u32..).zip(COVERAGES).map(|(level, c)| (shape(level), c)).collect();
        yard.add(name, &levels);
    }
    yard.model
}

/// The value of a line at z.
fn on(line: Line, z: f32) -> f32 {
    for pair in line.windows(2) {
        let ((a, from), (b, to)) = (pair[0], pair[1]);
        if z >= b {
            return mix(from, to, ((a - z) / (a - b)).clamp(0.0, 1.0));
        }
    }
    line.last().map_or(0.0, |(_, value)| *value)
}

impl Body {
    /// Places along the car where its section is drawn.
    fn stations(&self, level: u32) -> Vec<f32> {
        let mut stations: Vec<f32> = self.top.iter().map(|(z, _)| *z).collect();
        let (front, rear) = (stations[0], stations[stations.len() - 1]);
        if level < 2 {
            for pillar in self.pillars {
                stations.extend([pillar + 0.045, pillar - 0.045]);
            }
            stations.extend([self.windows.0, self.windows.1]);
            for axle in [self.axles.0, self.axles.1] {
                let arch = self.arch();
                let shares: &[f32] = if level == 0 {
                    &[-1.0, -0.98, -0.78, -0.42, 0.0, 0.42, 0.78, 0.98, 1.0]
                } else {
                    &[-1.0, -0.75, 0.75, 1.0]
                };
                stations.extend(shares.iter().map(|share| axle + share * arch));
            }
        }
        stations.retain(|z| *z <= front && *z >= rear);
        stations.sort_by(|a, b| b.total_cmp(a));
        stations.dedup_by(|a, b| (*a - *b).abs() < 0.012);
        stations
    }

    fn arch(&self) -> f32 {
        self.wheel + 0.055
    }

    /// Lower edge of the body: the sill, higher over the wheels.
    fn low(&self, z: f32) -> f32 {
        let arch = self.arch();
        let over = |axle: f32| {
            let off = z - axle;
            let rise = (arch * arch - off * off).max(0.0).sqrt();
            if rise > 0.0 { self.wheel + rise } else { 0.0 }
        };
        self.sill.max(over(self.axles.0)).max(over(self.axles.1))
    }

    /// Half a section at z, from the sill up to the middle of the roof.
    fn section(&self, z: f32, level: u32) -> Vec<Vec3> {
        let (top, half) = (on(self.top, z), on(self.half, z));
        let low = if level == 2 { self.sill } else { self.low(z) }.min(top - 0.06);
        let belt = self.belt.min(top - 0.035);
        let middle = mix(low, belt, 0.5).max(low + 0.02).min(belt);
        let edge = (0.965 * half - 0.33 * (top - 0.03 - belt)).max(0.3 * half);
        let point = |x: f32, y: f32| Vec3::new(x, y, z);
        if level == 2 {
            return vec![
                point(half, low),
                point(0.98 * half, belt),
                point(edge, top - 0.03),
                point(0.5 * edge, top),
            ];
        }
        vec![
            point(0.95 * half, low),
            point(half, middle),
            point(0.985 * half, mix(middle, belt, 0.86)),
            point(0.965 * half, belt),
            point(edge, top - 0.035),
            point(0.93 * edge, top - 0.008),
            point(0.5 * edge, top + 0.012),
        ]
    }

    /// Is the cell between two stations and section points `j`, `j` + 1 glass? `points` per half section.
    fn is_glass(&self, front: f32, rear: f32, j: usize, points: usize) -> bool {
        let middle = 0.5 * (front + rear);
        let j = j.min(2 * points - 2 - j);
        let within = |(from, to): (f32, f32)| middle < from && middle > to;
        let over = j + 1 >= points - usize::from(points > 4) * 2;
        if over {
            return within(self.screen) || within(self.rear);
        }
        let side = if points > 4 { 3 } else { 1 };
        let pillar = self.pillars.iter().any(|pillar| (pillar - middle).abs() < 0.04);
        j == side && within(self.windows) && !pillar
    }

    fn hull(&self, pieces: &mut Pieces, level: u32) {
        let stations = self.stations(level);
        let rows: Vec<Vec<Vec3>> = stations
            .iter()
            .map(|z| {
                let half = self.section(*z, level);
                let other = half.iter().rev().map(|p| p.with_x(-p.x));
                half.iter().copied().chain(other).collect()
            })
            .collect();
        let points = rows[0].len() / 2;
        let glass = |i: usize, j: usize| self.is_glass(stations[i], stations[i + 1], j, points);
        pieces.paint.apart();
        pieces.paint.hull(&rows, |i, j| (!glass(i, j)).then_some(WHITE));
        pieces.glossy.apart();
        pieces.glossy.hull(&rows, |i, j| glass(i, j).then_some(GLASS));
        let (first, last) = (&rows[0], &rows[rows.len() - 1]);
        pieces.paint.apart();
        pieces.paint.face(first);
        let mut back = last.clone();
        back.reverse();
        pieces.paint.face(&back);
        // What one sees through the arches and under the sill.
        let (front, rear) = (stations[0] - 0.3, stations[stations.len() - 1] + 0.2);
        let wide = on(self.half, 0.5 * (front + rear)) - 0.22;
        let top = self.wheel + self.arch() + 0.03;
        let plain = &mut pieces.plain;
        plain.paint(BLACK);
        plain.block(
            Vec3::new(0.0, 0.5 * (self.sill + top), 0.5 * (front + rear)),
            Vec3::new(2.0 * wide, top - self.sill, front - rear),
        );
    }

    fn wheels(&self, pieces: &mut Pieces, level: u32) {
        for z in [self.axles.0, self.axles.1] {
            let outer = on(self.half, z) - 0.015;
            for side in [-1.0, 1.0] {
                let center = Vec3::new(side * outer, self.wheel, z);
                wheel(&mut pieces.plain, center, -side, self.wheel, level);
            }
        }
    }
}

/// A wheel whose outer side is at `center`; `inward` is ±1 along x.
fn wheel(solid: &mut Solid, center: Vec3, inward: f32, radius: f32, level: u32) {
    let n = [16, 9, 6][level.min(2) as usize];
    let at = |depth: f32, r: f32| (center + Vec3::X * (inward * depth), r * radius);
    solid.paint(RUBBER);
    if level > 0 {
        solid.tube(&[at(0.0, 0.98), at(0.2, 0.98)], n);
        if level == 1 {
            solid.paint(STEEL);
            solid.tube(&[at(-0.004, 0.62), at(0.05, 0.62)], 8);
        }
        return;
    }
    solid.tube(&[at(0.0, 0.72), at(0.012, 0.95), at(0.03, 1.0), at(0.19, 1.0)], n);
    solid.paint(DARK_STEEL);
    solid.tube(&[at(-0.003, 0.70), at(0.05, 0.70)], n);
    // Five broad spokes around the hub.
    solid.paint(CHROME);
    solid.tube(&[at(-0.012, 0.20), at(0.03, 0.22)], 10);
    for k in 0..5 {
        let (sin, cos) = sin_cos(TURN * k as f32 / 5.0);
        let reach = Vec3::new(0.0, cos, sin);
        let hub = at(-0.002, 0.0).0;
        solid.beam(
            hub + reach * (0.15 * radius),
            hub + reach * (0.70 * radius),
            Vec2::new(0.014, 0.30 * radius),
            Vec3::X,
        );
    }
}

/// A car of one body.
fn car(body: &Body, level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    body.hull(&mut pieces, level);
    body.wheels(&mut pieces, level);
    if level < 2 {
        trim(body, &mut pieces, level);
    }
    pieces
}

/// Lamps, bumpers, plates, mirrors, handles.
fn trim(body: &Body, pieces: &mut Pieces, level: u32) {
    let (front, rear) = (body.top[0].0, body.top[body.top.len() - 1].0);
    let (nose, tail) = (on(body.half, front - 0.1), on(body.half, rear + 0.12));
    for side in [-1.0, 1.0] {
        let glossy = &mut pieces.glossy;
        glossy.paint(LAMP);
        glossy.rounded(
            Vec3::new(side * (nose - 0.15), 0.655, front - 0.10),
            Vec3::new(0.32, 0.12, 0.20),
            0.04,
        );
        glossy.paint(RED_LAMP);
        glossy.rounded(
            Vec3::new(side * (tail - 0.07), 0.80, rear + 0.10),
            Vec3::new(0.15, 0.26, 0.20),
            0.03,
        );
        if level == 0 {
            glossy.paint(AMBER_LAMP);
            glossy.rounded(
                Vec3::new(side * (nose + 0.005), 0.655, front - 0.17),
                Vec3::new(0.05, 0.08, 0.12),
                0.015,
            );
            let mirror = body.screen.0 - 0.42;
            let at = Vec3::new(side * (on(body.half, mirror) + 0.075), body.belt + 0.08, mirror);
            pieces.paint.apart();
            pieces.paint.rounded(at, Vec3::new(0.19, 0.13, 0.09), 0.035);
            glossy.paint(CHROME);
            glossy.block(at - Vec3::Z * 0.043, Vec3::new(0.15, 0.09, 0.01));
            let plain = &mut pieces.plain;
            plain.paint(BLACK);
            for pillar in &body.pillars[..body.pillars.len().min(2)] {
                let z = pillar + 0.17;
                plain.rounded(
                    Vec3::new(side * (on(body.half, z) - 0.004), body.belt - 0.10, z),
                    Vec3::new(0.03, 0.03, 0.16),
                    0.012,
                );
            }
        }
    }
    let plain = &mut pieces.plain;
    plain.paint(BLACK);
    plain.rounded(Vec3::new(0.0, 0.47, front - 0.075), Vec3::new(0.86, 0.10, 0.18), 0.03);
    plain.rounded(Vec3::new(0.0, 0.30, front - 0.16), Vec3::new(1.28, 0.14, 0.36), 0.04);
    plain.rounded(Vec3::new(0.0, 0.34, rear + 0.16), Vec3::new(1.44, 0.20, 0.34), 0.05);
    let plate = |z: f32, y: f32, right: Vec3| {
        let (r, u, c) = (right * 0.26, Vec3::Y * 0.055, Vec3::new(0.0, y, z));
        [c - r - u, c + r - u, c + r + u, c - r + u]
    };
    let (low, high) = PLATE;
    let (low, high) = (
        Vec2::new(low.x, mix(low.y, high.y, 0.2)),
        Vec2::new(high.x, mix(low.y, high.y, 0.8)),
    );
    plain.picture(plate(front + 0.018, 0.42, Vec3::X), low, high);
    plain.picture(plate(rear - 0.012, 0.60, Vec3::NEG_X), low, high);
}

/// A small lorry: a cab and a box on a frame, 6 m long.
fn lorry(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    CAB.hull(&mut pieces, level);
    CAB.wheels(&mut pieces, level);
    let plain = &mut pieces.plain;
    plain.paint(DARK_STEEL);
    for x in [-0.42, 0.42] {
        plain.block(Vec3::new(x, 0.62, -0.85), Vec3::new(0.1, 0.2, 4.3));
    }
    plain.block(Vec3::new(0.0, 0.37, -1.65), Vec3::new(1.5, 0.1, 0.1));
    plain.paint(WHITE);
    let (center, size) = (Vec3::new(0.0, 1.86, -0.95), Vec3::new(2.1, 2.2, 4.35));
    if level == 0 {
        plain.rounded(center, size, 0.05);
    } else {
        plain.block(center, size);
    }
    if level == 2 {
        return pieces;
    }
    // Rails of the box, mudguards, doors behind, steps.
    plain.paint(STEEL);
    for x in [-1.045, 1.045] {
        plain.block(Vec3::new(x, 0.80, -0.95), Vec3::new(0.04, 0.09, 4.3));
        if level == 0 {
            plain.tube(
                &[
                    (Vec3::new(0.55 * x, 0.9, -3.14), 0.014),
                    (Vec3::new(0.55 * x, 2.85, -3.14), 0.014),
                ],
                5,
            );
            plain.block(Vec3::new(x, 2.94, -0.95), Vec3::new(0.04, 0.05, 4.3));
        }
    }
    plain.paint(BLACK);
    for side in [-1.0, 1.0] {
        plain.rounded(Vec3::new(side * 0.88, 0.83, -1.65), Vec3::new(0.32, 0.05, 0.95), 0.02);
        plain.rounded(Vec3::new(side * 0.8, 0.5, 0.4), Vec3::new(0.4, 0.34, 0.9), 0.05);
        let mirror = Vec3::new(side * 1.14, 1.72, 2.38);
        plain.rounded(mirror, Vec3::new(0.17, 0.32, 0.08), 0.03);
        plain.tube(&[(mirror, 0.012), (Vec3::new(side * 0.93, 1.82, 2.3), 0.012)], 4);
        pieces.glossy.paint(LAMP);
        pieces
            .glossy
            .rounded(Vec3::new(side * 0.68, 0.66, 2.80), Vec3::new(0.26, 0.17, 0.12), 0.04);
        pieces.glossy.paint(RED_LAMP);
        pieces
            .glossy
            .block(Vec3::new(side * 0.8, 0.64, -3.08), Vec3::new(0.3, 0.12, 0.08));
    }
    plain.rounded(Vec3::new(0.0, 0.44, 2.78), Vec3::new(1.82, 0.22, 0.2), 0.05);
    plain.rounded(Vec3::new(0.0, 0.98, 2.815), Vec3::new(1.1, 0.18, 0.08), 0.02);
    plain.block(Vec3::new(0.0, 0.5, -3.05), Vec3::new(1.9, 0.1, 0.1));
    pieces
}
