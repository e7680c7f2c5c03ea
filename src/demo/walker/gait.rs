//! [`Gait`]: what strides do to the eye, and slopes to the speed.

use std::f32::consts::TAU;

use bevy::math::{Vec2, Vec3, Vec3Swizzles};

/// Two steps, one of each foot, in metres.
const STRIDE: f32 = 1.9;
/// How far the eye goes to each side and up and down, in metres.
const SWAY: Vec2 = Vec2::new(0.012, 0.02);
/// Below this speed the sway fades, in metres per second.
const FULL_SPEED: f32 = 2.5;
/// How fast the sway comes and goes, per second.
const FADE_RATE: f32 = 6.0;
/// How strongly a rise slows down, per unit of rise over way.
const UPHILL: f32 = 0.9;

/// Where in a stride the walker is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Gait {
    /// Share of the stride, 0..1.
    phase: f32,
    /// Share of the full sway, 0..=1.
    strength: f32,
}

impl Gait {
    /// Goes on by `way` metres in `seconds`.
    pub(super) fn walked(&mut self, way: f32, seconds: f32) {
        if seconds <= 0.0 {
            return;
        }
        let wanted = (way / seconds / FULL_SPEED).min(1.0);
        self.strength = wanted + (self.strength - wanted) * (-FADE_RATE * seconds).exp();
        self.phase = (self.phase + way / STRIDE).fract();
    }

    /// The eye's way to the right and up: it rises and falls once with every step, and swings to the foot that stands.
    pub(super) fn sway(&self) -> Vec2 {
        let angle = self.phase * TAU;
        SWAY * self.strength * Vec2::new(angle.sin(), (2.0 * angle).sin())
    }
}

/// Share of the speed that is left in walking towards `direction` (x, z; at most of unit length) on ground with this
/// unit normal. Falls off exponentially with the rise, as in W. Tobler's hiking function (1993), but more gently: this
/// is a game; downhill nobody gets faster.
pub(super) fn uphill(normal: Vec3, direction: Vec2) -> f32 {
    let rise = -normal.xz().dot(direction) / normal.y.max(0.1);
    (-UPHILL * rise.max(0.0)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eye_rises_twice_in_a_stride_and_rests_when_one_stands() {
        let mut gait = Gait::default();
        let mut heights = Vec::new();
        for _ in 0..600 {
            gait.walked(3.5 / 60.0, 1.0 / 60.0);
            heights.push(gait.sway().y);
        }
        let upwards = heights
            .windows(2)
            .filter(|pair| pair[0] <= 0.0 && pair[1] > 0.0)
            .count();
        // 35 m are 18.4 strides of two rises each.
        assert!((35..=38).contains(&upwards), "{upwards}");
        assert!(heights.iter().all(|height| height.abs() <= SWAY.y));
        for _ in 0..120 {
            gait.walked(0.0, 1.0 / 60.0);
        }
        assert!(gait.sway().length() < 1e-5, "{:?}", gait.sway());
    }

    #[test]
    fn uphill_is_slower_and_downhill_is_not() {
        let slope = Vec3::new(-0.6, 0.8, 0.0);
        // A rise of 0.75 towards +x: exp(−0.675).
        assert!((uphill(slope, Vec2::X) - 0.5092).abs() < 1e-3);
        assert_eq!(uphill(slope, Vec2::NEG_X), 1.0);
        assert_eq!(uphill(slope, Vec2::Y), 1.0);
        assert_eq!(uphill(Vec3::Y, Vec2::X), 1.0);
    }
}
