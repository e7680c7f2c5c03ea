//! Hashed lattice noise: the same value for the same place on every machine.

use bevy_math::Vec2;

/// A number in -1..=1 that belongs to a lattice point.
pub fn signed(seed: u32, x: i32, y: i32) -> f32 {
    hash(seed, x, y) as f32 / u32::MAX as f32 * 2.0 - 1.0
}

/// Integer hash with full avalanche (the finaliser of `MurmurHash3`).
fn hash(seed: u32, x: i32, y: i32) -> u32 {
    let mut h = seed ^ (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77).rotate_left(16);
    for factor in [0x85eb_ca6b_u32, 0xc2b2_ae35] {
        h ^= h >> 16;
        h = h.wrapping_mul(factor);
    }
    h ^ (h >> 16)
}

/// Gradient noise with wavelength 1: about -0.7..=0.7, zero at lattice points, twice differentiable (Perlin 2002).
pub fn gradient(seed: u32, p: Vec2) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let (x, y) = (cell.x as i32, cell.y as i32);
    let corner = |dx: i32, dy: i32| {
        let slope = Vec2::new(signed(seed, x + dx, y + dy), signed(seed ^ 0x5bd1_e995, x + dx, y + dy));
        slope.dot(f - Vec2::new(dx as f32, dy as f32))
    };
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    mix(
        mix(corner(0, 0), corner(1, 0), s.x),
        mix(corner(0, 1), corner(1, 1), s.x),
        s.y,
    )
}

/// Octaves of [`gradient`], each of half the wavelength and 0.45 of the height; the first has wavelength 1. Within -1..=1.
pub fn octaves(seed: u32, p: Vec2, count: u32) -> f32 {
    let (mut sum, mut scale, mut height, mut total) = (0.0, 1.0, 1.0, 0.0);
    for i in 0..count {
        sum += height * gradient(seed.wrapping_add(i.wrapping_mul(0x632b_e5ab)), p * scale);
        total += height;
        height *= 0.45;
        scale *= 2.0;
    }
    // A gradient of at most √2 over a distance of at most √½ gives at most 1.
    if total > 0.0 { sum / total } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_bounded_continuous_and_uses_its_range() {
        let (mut low, mut high) = (f32::MAX, f32::MIN);
        for i in 0..2000 {
            let p = Vec2::new(i as f32 * 0.173, i as f32 * 0.091 - 40.0);
            let value = octaves(5, p, 4);
            low = low.min(value);
            high = high.max(value);
            let step = (octaves(5, p + Vec2::splat(1e-3), 4) - value).abs();
            assert!(step < 0.02, "a jump of {step} at {p}");
        }
        assert!(
            (-1.0..-0.2).contains(&low) && (0.2..1.0).contains(&high),
            "{low}..{high}"
        );
    }

    #[test]
    fn seeds_and_places_differ() {
        assert_ne!(signed(1, 2, 3), signed(2, 2, 3));
        assert_ne!(signed(1, 2, 3), signed(1, 3, 2));
        let mean: f32 = (0..10_000).map(|i| signed(9, i % 100, i / 100)).sum::<f32>() / 10_000.0;
        assert!(mean.abs() < 0.03, "mean {mean}");
    }
}
