//! The lattice tower: four legs of angle sections that close in on a mast, arches, two platforms, an antenna.

use bevy_math::{Vec2, Vec3};

use super::{
    Pieces, Yard,
    palette::{CONCRETE, DARK_STEEL, RED_LAMP, TOWER, WHITE},
    solid::Solid,
};
use crate::forge::{
    mesh::Model,
    portable::{TURN, mix, power, sin_cos},
};

/// Height in metres, antenna included; levels scale it.
const HEIGHT: f32 = 118.0;
/// Where the lattice ends and the antenna begins.
const CROWN: f32 = 0.88 * HEIGHT;
/// The two platforms.
const DECKS: [f32; 2] = [33.0, 66.0];

/// `tower.glb`.
pub(super) fn forge() -> Model {
    let mut yard = Yard::new();
    let coverages = [0.55, 0.22, 0.0];
    let levels: Vec<(Pieces, f32)> = (0_u32..).zip(coverages).map(|(level, c)| (tower(level), c)).collect();
    yard.add("tower", &levels);
    yard.model
}

/// Half the width at a height: an exponential-like sweep.
fn half(y: f32) -> f32 {
    let narrow = (1.0 - y / CROWN).max(0.0);
    HEIGHT * (0.012 + 0.088 * power(narrow, 1.7))
}

/// Width of one leg below the first platform.
fn leg(y: f32) -> f32 {
    mix(4.6, 3.0, y / DECKS[0])
}

/// The lattice with what its members are drawn as.
struct Lattice {
    solid: Solid,
    level: u32,
}

impl Lattice {
    /// A member whose flanges, `width` metres wide, open towards `inward`; `bulk` members stay in coarse levels.
    fn member(&mut self, from: Vec3, to: Vec3, width: f32, inward: Vec3, bulk: bool) {
        match self.level {
            0 => {
                let along = (to - from).normalize_or(Vec3::Y);
                let second = along.cross(inward);
                // Only thick members show that their edges are sharp.
                if width > 0.4 {
                    self.solid.sharp();
                } else {
                    self.solid.soft();
                }
                self.solid
                    .angle(from, to, width, 0.14 * width, inward + second, inward - second);
            }
            1 => self.solid.tube_open(from, to, 0.5 * width),
            _ if bulk => self.solid.tube_open(from, to, 0.5 * width),
            _ => {}
        }
    }

    /// One panel between two chords: a horizontal on top, crossed diagonals, in large panels a net of secondary members.
    fn panel(&mut self, [a, b, c, d]: [Vec3; 4], width: f32, inward: Vec3, net: bool) {
        self.member(c, d, width, inward, true);
        self.member(a, d, 0.75 * width, inward, true);
        self.member(b, c, 0.75 * width, inward, false);
        if net && self.level == 0 {
            let cross = (a + b + c + d) * 0.25;
            for (from, to) in [(a, b), (c, d), (a, c), (b, d)] {
                self.member(cross, (from + to) * 0.5, 0.45 * width, inward, false);
            }
        }
    }
}

fn tower(level: u32) -> Pieces {
    let mut pieces = Pieces::default();
    let mut lattice = Lattice {
        solid: Solid::new(),
        level,
    };
    lattice.solid.paint(TOWER).soft();
    for k in 0..4 {
        let quarter = quarter(k);
        legs(&mut lattice, &quarter);
        arch(&mut lattice, &quarter);
        shaft(&mut lattice, &quarter);
    }
    pieces.plain = lattice.solid;
    let plain = pieces.plain.sharp();
    for y in DECKS {
        deck(plain, y, level);
    }
    crown(plain, level);
    plain.paint(CONCRETE);
    for (x, z) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        let middle = half(0.0) - 0.5 * leg(0.0);
        let foot = Vec3::new(x * middle, 0.25, z * middle);
        if level == 0 {
            plain.rounded(foot, Vec3::new(6.2, 1.5, 6.2), 0.2);
        } else {
            plain.block(foot, Vec3::new(6.2, 1.5, 6.2));
        }
    }
    if level < 2 {
        pieces.glossy.paint(RED_LAMP);
        pieces
            .glossy
            .turned(Vec3::Y * (HEIGHT - 0.35), &[(0.12, 0.0), (0.12, 0.22), (0.0, 0.35)], 6);
    }
    pieces
}

/// Takes (across, height, out) of the side that looks along +z to the k-th side.
fn quarter(k: usize) -> impl Fn(f32, f32, f32) -> Vec3 {
    move |across, y, out| match k {
        0 => Vec3::new(across, y, out),
        1 => Vec3::new(out, y, -across),
        2 => Vec3::new(-across, y, -out),
        _ => Vec3::new(-out, y, across),
    }
}

/// The leg at the right of a side: four chords with lattice on its four faces, up to the first platform.
fn legs(lattice: &mut Lattice, at: &impl Fn(f32, f32, f32) -> Vec3) {
    let storeys = 6;
    let height =
        |i: u32| DECKS[0] * (1.25 * i as f32 / storeys as f32 - 0.25 * (i * i) as f32 / (storeys * storeys) as f32);
    let corners = |y: f32| {
        let (outer, inner) = (half(y), half(y) - leg(y));
        [
            at(outer, y, outer),
            at(inner, y, outer),
            at(inner, y, inner),
            at(outer, y, inner),
        ]
    };
    for i in 0..storeys {
        let (low, high) = (corners(height(i)), corners(height(i + 1)));
        let middle = (low[0] + low[2]) * 0.5;
        for k in 0..4 {
            let next = (k + 1) % 4;
            let inward = (middle - low[k]).with_y(0.0).normalize_or(Vec3::X);
            lattice.member(low[k], high[k], if k == 0 { 0.62 } else { 0.5 }, inward, true);
            let face = (middle - (low[k] + low[next]) * 0.5).with_y(0.0).normalize_or(Vec3::X);
            lattice.panel([low[k], low[next], high[k], high[next]], 0.26, face, false);
        }
    }
}

/// The arch between two legs of a side: two ribs with a zigzag between them, which spring from the legs' inner chords.
fn arch(lattice: &mut Lattice, at: &impl Fn(f32, f32, f32) -> Vec3) {
    const SPRING: f32 = 11.0;
    const DEPTH: f32 = 1.5;
    let parts = if lattice.level == 2 { 6 } else { 16 };
    // The ribs share their springers and part towards the crown.
    let rib = |t: f32, inset: f32| {
        let (sin, cos) = sin_cos(0.5 * TURN * t);
        let y = SPRING + (DECKS[0] - 4.0 - SPRING - inset) * sin;
        let reach = half(SPRING) - leg(SPRING) - inset * sin;
        at(reach * cos, y, half(y) - 0.1)
    };
    let inward = at(0.0, 0.0, -1.0);
    for i in 0..parts {
        let (t, u) = (i as f32 / parts as f32, (i + 1) as f32 / parts as f32);
        lattice.member(rib(t, 0.0), rib(u, 0.0), 0.36, inward, true);
        if lattice.level < 2 {
            lattice.member(rib(t, DEPTH), rib(u, DEPTH), 0.30, inward, false);
            let (from, to) = if i % 2 == 0 { (0.0, DEPTH) } else { (DEPTH, 0.0) };
            lattice.member(rib(t, from), rib(u, to), 0.18, inward, false);
        }
    }
    // Hangers from the deck.
    if lattice.level < 2 {
        for i in [5, 6, 7, 8, 9, 10, 11] {
            let foot = rib(i as f32 / parts as f32, 0.0);
            let top = foot + Vec3::Y * (DECKS[0] - foot.y);
            lattice.member(foot, top, 0.16, inward, false);
        }
    }
}

/// A side above the first platform with its right chord.
fn shaft(lattice: &mut Lattice, at: &impl Fn(f32, f32, f32) -> Vec3) {
    let storeys = 17;
    let height = |i: u32| {
        let t = i as f32 / storeys as f32;
        mix(DECKS[0], CROWN, 1.35 * t - 0.35 * t * t)
    };
    for i in 0..storeys {
        let (y, z) = (height(i), height(i + 1));
        let (low, high) = (half(y), half(z));
        let thin = 1.0 - 0.6 * i as f32 / storeys as f32;
        let inward = at(0.0, 0.0, -1.0);
        let corner = at(-0.7, 0.0, -0.7);
        lattice.member(at(low, y, low), at(high, z, high), 0.58 * thin, corner, true);
        let panel = [at(-low, y, low), at(low, y, low), at(-high, z, high), at(high, z, high)];
        lattice.panel(panel, 0.28 * thin, inward, i < 11);
    }
}

/// A square platform with its girder, joists and railing.
fn deck(solid: &mut Solid, y: f32, level: u32) {
    let reach = half(y) + 1.4;
    solid.paint(TOWER);
    solid.block(Vec3::Y * (y + 0.45), Vec3::new(2.0 * reach, 0.18, 2.0 * reach));
    solid.soft();
    for k in 0..4 {
        let at = quarter(k);
        let (left, right) = (at(-reach, y, reach), at(reach, y, reach));
        let up = |p: Vec3, h: f32| p + Vec3::Y * h;
        solid.beam(up(left, -0.35), up(right, -0.35), Vec2::new(0.16, 0.16), Vec3::Y);
        if level == 2 {
            continue;
        }
        let bays = (2.0 * reach / if level == 0 { 1.1 } else { 2.2 }).round() as u32;
        for i in 0..bays {
            let (a, b) = (
                left.lerp(right, i as f32 / bays as f32),
                left.lerp(right, (i + 1) as f32 / bays as f32),
            );
            // Girder: a zigzag below the deck.
            let (foot, top) = if i % 2 == 0 { (-0.35, 0.36) } else { (0.36, -0.35) };
            solid.tube_open(up(a, foot), up(b, top), 0.05);
            solid.tube_open(up(a, 0.5), up(a, 1.65), 0.025);
            if level == 0 {
                let bars = 4;
                for j in 1..bars {
                    let p = a.lerp(b, j as f32 / bars as f32);
                    solid.tube_open(up(p, 0.6), up(p, 1.6), 0.011);
                }
                let inner = a - at(0.0, 0.0, 2.0 * reach);
                if k == 0 && i > 0 {
                    solid.beam(up(a, 0.26), up(inner, 0.26), Vec2::new(0.1, 0.2), Vec3::X);
                }
            }
        }
        for h in [1.1, 1.62] {
            solid.beam(up(left, h), up(right, h), Vec2::splat(0.06), Vec3::Y);
        }
    }
    solid.sharp();
    if level < 2 {
        // A cabin in the middle.
        solid.paint(DARK_STEEL);
        let wide = 0.9 * half(y);
        solid.block(Vec3::Y * (y + 2.0), Vec3::new(wide, 2.9, wide));
        solid.paint(TOWER);
        solid.block(Vec3::Y * (y + 3.55), Vec3::new(wide + 0.8, 0.2, wide + 0.8));
    }
}

/// The small platform on top and the antenna.
fn crown(solid: &mut Solid, level: u32) {
    let n = if level == 0 { 10 } else { 5 };
    solid.paint(TOWER);
    let wide = 2.0 * half(CROWN) + 1.2;
    solid.block(Vec3::Y * (CROWN + 0.1), Vec3::new(wide, 0.25, wide));
    if level < 2 {
        for k in 0..4 {
            let at = quarter(k);
            let (left, right) = (
                at(-0.48 * wide, CROWN, 0.48 * wide),
                at(0.48 * wide, CROWN, 0.48 * wide),
            );
            for i in 0..5 {
                let p = left.lerp(right, i as f32 / 5.0);
                solid.tube_open(p, p + Vec3::Y * 1.3, 0.025);
            }
            let up = Vec3::Y * 1.3;
            solid.beam(left + up, right + up, Vec2::splat(0.05), Vec3::Y);
        }
    }
    solid.tube(
        &[
            (Vec3::Y * CROWN, 0.55),
            (Vec3::Y * (CROWN + 3.0), 0.5),
            (Vec3::Y * (CROWN + 3.2), 0.2),
            (Vec3::Y * (HEIGHT - 0.3), 0.06),
        ],
        n,
    );
    if level == 2 {
        return;
    }
    for (y, reach) in [(CROWN + 5.0, 0.9), (CROWN + 7.0, 0.75), (CROWN + 9.0, 0.6)] {
        for d in [Vec3::X, Vec3::Z] {
            solid.tube(&[(Vec3::Y * y - d * reach, 0.035), (Vec3::Y * y + d * reach, 0.035)], 4);
            for side in [-reach, reach] {
                let p = Vec3::Y * y + d * side;
                solid.tube(&[(p - Vec3::Y * 0.55, 0.03), (p + Vec3::Y * 0.55, 0.03)], 4);
            }
        }
    }
    solid.paint(WHITE);
    for (y, heading) in [(CROWN - 3.0, 0.4_f32), (CROWN - 6.5, 2.2)] {
        let (sin, cos) = sin_cos(heading);
        let out = Vec3::new(sin, 0.0, cos);
        let at = Vec3::Y * y + out * (half(y) + 0.25);
        solid.tube(
            &[
                (at, 0.1),
                (at + out * 0.18, 0.62),
                (at + out * 0.42, 0.75),
                (at + out * 0.45, 0.72),
            ],
            12,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tower_has_its_height_and_foot() {
        for level in 0..3 {
            let pieces = tower(level);
            let (low, high) = pieces.plain.mesh().bounds().expect("a tower");
            assert!((high.y - (HEIGHT - 0.3)).abs() < 0.2, "{}", high.y);
            assert!(low.y > -0.6 && low.y < 0.0);
            assert!((high.x - 12.6).abs() < 0.3 && (high.z - high.x).abs() < 0.1, "{high}");
        }
    }
}
