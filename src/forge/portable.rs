//! Arithmetic that gives the same bits on every machine.
//!
//! Rust's `f32::sin` and its like are whatever the platform's mathematics library says. Here they come from one library
//! that is compiled in; sums, products, square roots and rounding are exact by IEEE 754 anyway. Vectors of two and three
//! floats are safe too; quaternions and vectors of four are not (their sums are ordered by the processor's width).

use bevy_math::{Vec2, Vec3};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng, SeedableRng},
};

/// A full turn in radians.
pub const TURN: f32 = std::f32::consts::TAU;

/// Sine and cosine of an angle in radians.
pub fn sin_cos(angle: f32) -> (f32, f32) {
    libm::sincosf(angle)
}

/// Sine of an angle in radians.
pub fn sin(angle: f32) -> f32 {
    libm::sinf(angle)
}

/// Cosine of an angle in radians.
pub fn cos(angle: f32) -> f32 {
    libm::cosf(angle)
}

/// A positive number to a power; 0 for numbers that are not positive.
pub fn power(base: f32, exponent: f32) -> f32 {
    if base > 0.0 { libm::powf(base, exponent) } else { 0.0 }
}

/// The angle of a plane vector in radians, −π..=π.
pub fn heading(p: Vec2) -> f32 {
    libm::atan2f(p.y, p.x)
}

/// The angle between +y and a unit vector in radians.
pub fn declination(direction: Vec3) -> f32 {
    libm::acosf(direction.y.clamp(-1.0, 1.0))
}

/// `v` turned about a unit `axis` by an angle in radians, counter-clockwise seen from the axis' tip (Rodrigues).
pub fn turn(v: Vec3, axis: Vec3, angle: f32) -> Vec3 {
    let (sin, cos) = sin_cos(angle);
    v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos))
}

/// Some unit vector at right angles to a unit vector.
pub fn any_normal(direction: Vec3) -> Vec3 {
    let other = if direction.x.abs() < 0.7 { Vec3::X } else { Vec3::Z };
    direction.cross(other).normalize()
}

/// A smooth step from 0 at `from` to 1 at `to`.
pub fn smooth(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Between `a` (t = 0) and `b` (t = 1).
pub fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Linear light to an sRGB code of 8 bits (IEC 61966-2-1).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..=255"
)]
pub fn srgb_code(linear: f32) -> u8 {
    let c = linear.clamp(0.0, 1.0);
    let coded = if c <= 0.003_130_8 {
        12.92 * c
    } else {
        1.055 * power(c, 1.0 / 2.4) - 0.055
    };
    (coded * 255.0 + 0.5) as u8
}

/// An sRGB code of 8 bits to linear light.
pub fn linear_light(code: u8) -> f32 {
    let c = f32::from(code) / 255.0;
    if c <= 0.040_45 {
        c / 12.92
    } else {
        power((c + 0.055) / 1.055, 2.4)
    }
}

/// A stream of random numbers: the same for the same seed, on every machine.
#[derive(Clone, Debug)]
pub struct Dice(ChaCha8Rng);

impl Dice {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A number in 0..1, in steps of 2⁻²⁴.
    pub fn unit(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    /// A number in −1..1.
    pub fn signed(&mut self) -> f32 {
        self.unit() * 2.0 - 1.0
    }

    /// A number in `low..high`.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        mix(low, high, self.unit())
    }

    /// `middle` ± `spread`, evenly.
    pub fn about(&mut self, middle: f32, spread: f32) -> f32 {
        middle + spread * self.signed()
    }

    /// A whole number in `0..count`; `count` must not be 0.
    pub fn below(&mut self, count: u32) -> u32 {
        u32::try_from((u64::from(self.0.next_u32()) * u64::from(count)) >> 32).unwrap_or(0)
    }

    /// A point in the unit ball, evenly.
    pub fn in_ball(&mut self) -> Vec3 {
        loop {
            let p = Vec3::new(self.signed(), self.signed(), self.signed());
            if p.length_squared() <= 1.0 {
                return p;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_y_takes_z_to_x() {
        let turned = turn(Vec3::Z, Vec3::Y, TURN / 4.0);
        assert!((turned - Vec3::X).length() < 1e-6, "{turned}");
    }

    #[test]
    fn srgb_codes_survive_the_way_there_and_back() {
        for code in 0..=255 {
            assert_eq!(srgb_code(linear_light(code)), code);
        }
        assert_eq!(srgb_code(0.18), 118, "the sRGB code of middle grey");
    }

    #[test]
    fn functions_give_the_bits_that_every_machine_gives() {
        // Worked out with 50 digits elsewhere and rounded to single precision.
        assert_eq!(sin(1.0).to_bits(), 0x3f57_6aa4);
        assert_eq!(cos(1.0).to_bits(), 0x3f0a_5140);
        assert_eq!(power(2.0, 0.5).to_bits(), 0x3fb5_04f3);
        assert_eq!(power(-2.0, 0.5), 0.0);
    }

    #[test]
    fn dice_repeat_themselves_and_fill_their_range() {
        let mut dice = Dice::new(7);
        let throws: Vec<f32> = (0..1000).map(|_| dice.unit()).collect();
        let mut again = Dice::new(7);
        assert!(throws.iter().all(|throw| *throw == again.unit()));
        let mean = throws.iter().sum::<f32>() / 1000.0;
        assert!((0.47..0.53).contains(&mean), "mean {mean}");
        assert!((0..1000).all(|_| dice.below(3) < 3));
        assert!((0..100).all(|_| dice.in_ball().length() <= 1.0));
    }
}
