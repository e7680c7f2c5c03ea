//! Noise that repeats: whole wavelengths fit into the unit square, so that pictures tile.

use bevy_math::Vec2;

/// A number in 0..=1 that belongs to a lattice point (finaliser of `MurmurHash3`).
fn lattice(seed: u32, x: u32, y: u32) -> f32 {
    let mut h = seed ^ x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77).rotate_left(16);
    for factor in [0x85eb_ca6b_u32, 0xc2b2_ae35] {
        h ^= h >> 16;
        h = h.wrapping_mul(factor);
    }
    (h ^ (h >> 16)) as f32 / u32::MAX as f32
}

/// Lattice cell of a coordinate with its neighbour, both within `period`, and the place between them.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "0..period after the remainder"
)]
fn cell(coordinate: f32, period: u32) -> (u32, u32, f32) {
    let floor = coordinate.floor();
    let index = (floor as i64).rem_euclid(i64::from(period)) as u32;
    (index, (index + 1) % period, coordinate - floor)
}

/// Gradient noise (Perlin 2002): about −0.7..=0.7, `period.0` by `period.1` wavelengths per unit square.
pub fn gradient(seed: u32, p: Vec2, period: (u32, u32)) -> f32 {
    let (x0, x1, fx) = cell(p.x * period.0 as f32, period.0);
    let (y0, y1, fy) = cell(p.y * period.1 as f32, period.1);
    let corner = |x: u32, y: u32, dx: f32, dy: f32| {
        let slope_x = lattice(seed, x, y) * 2.0 - 1.0;
        let slope_y = lattice(seed ^ 0x5bd1_e995, x, y) * 2.0 - 1.0;
        slope_x * dx + slope_y * dy
    };
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    mix(
        mix(corner(x0, y0, fx, fy), corner(x1, y0, fx - 1.0, fy), fade(fx)),
        mix(
            corner(x0, y1, fx, fy - 1.0),
            corner(x1, y1, fx - 1.0, fy - 1.0),
            fade(fx),
        ),
        fade(fy),
    )
}

/// Octaves of [`gradient`], each with twice the wavelengths and half the height, divided by the sum of heights.
pub fn octaves(seed: u32, p: Vec2, period: (u32, u32), count: u32) -> f32 {
    let (mut sum, mut height, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..count {
        let finer = (period.0 << octave, period.1 << octave);
        sum += height * gradient(seed.wrapping_add(octave.wrapping_mul(0x632b_e5ab)), p, finer);
        total += height;
        height *= 0.5;
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

/// Ridges: 1 on crests, lower between them; octaves of 1 − 2·|gradient|.
pub fn ridges(seed: u32, p: Vec2, period: (u32, u32), count: u32) -> f32 {
    let (mut sum, mut height, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..count {
        let finer = (period.0 << octave, period.1 << octave);
        let value = gradient(seed.wrapping_add(octave.wrapping_mul(0x2545_f491)), p, finer);
        sum += height * (1.0 - 2.0 * value.abs());
        total += height;
        height *= 0.5;
    }
    if total > 0.0 { sum / total } else { 0.0 }
}

/// Cellular noise (Worley 1996).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Distance to the nearest feature point, in cells.
    pub nearest: f32,
    /// Distance to the second nearest, in cells.
    pub second: f32,
    /// A number in 0..=1 that belongs to the nearest point.
    pub id: f32,
}

/// Distances to feature points, one per cell, `period.0` by `period.1` cells per unit square.
pub fn cells(seed: u32, p: Vec2, period: (u32, u32)) -> Cell {
    let (x0, _, fx) = cell(p.x * period.0 as f32, period.0);
    let (y0, _, fy) = cell(p.y * period.1 as f32, period.1);
    let mut found = Cell {
        nearest: f32::MAX,
        second: f32::MAX,
        id: 0.0,
    };
    for (dy, y) in [(-1.0, y0 + period.1 - 1), (0.0, y0), (1.0, y0 + 1)] {
        for (dx, x) in [(-1.0, x0 + period.0 - 1), (0.0, x0), (1.0, x0 + 1)] {
            let (x, y) = (x % period.0, y % period.1);
            let point = Vec2::new(dx + lattice(seed, x, y), dy + lattice(seed ^ 0x68e3_1da4, x, y));
            let distance = point.distance(Vec2::new(fx, fy));
            if distance < found.nearest {
                found.second = found.nearest;
                found.nearest = distance;
                found.id = lattice(seed ^ 0xb529_7a4d, x, y);
            } else if distance < found.second {
                found.second = distance;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_without_a_seam() {
        for i in 0..200 {
            let t = i as f32 / 200.0;
            for (left, right) in [
                (Vec2::new(0.0, t), Vec2::new(1.0, t)),
                (Vec2::new(t, 0.0), Vec2::new(t, 1.0)),
            ] {
                assert!(
                    (octaves(3, left, (4, 7), 3) - octaves(3, right, (4, 7), 3)).abs() < 1e-5,
                    "{left}"
                );
                assert!(
                    (ridges(3, left, (4, 7), 3) - ridges(3, right, (4, 7), 3)).abs() < 1e-5,
                    "{left}"
                );
                let (a, b) = (cells(3, left, (4, 7)), cells(3, right, (4, 7)));
                assert!(
                    (a.nearest - b.nearest).abs() < 1e-4 && (a.second - b.second).abs() < 1e-4,
                    "{left}"
                );
            }
        }
    }

    #[test]
    fn noise_is_continuous_and_uses_its_range() {
        let (mut low, mut high) = (f32::MAX, f32::MIN);
        for i in 0..4000 {
            let p = Vec2::new(i as f32 * 0.0137, i as f32 * 0.0071);
            let value = gradient(5, p, (8, 8));
            assert!(
                (gradient(5, p + Vec2::splat(1e-4), (8, 8)) - value).abs() < 0.01,
                "a jump at {p}"
            );
            low = low.min(value);
            high = high.max(value);
        }
        assert!(
            (-1.0..-0.4).contains(&low) && (0.4..1.0).contains(&high),
            "{low}..{high}"
        );
    }
}
