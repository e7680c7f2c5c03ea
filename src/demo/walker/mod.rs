//! [`Walker`]: a person on the ground, or a camera that flies. Pure: a step takes intent, ground and time.
//!
//! The body is an upright cylinder. An obstacle whose top is at most [`STEP_HEIGHT`] above the feet carries it, a
//! higher one stops it and lets it slide along; what ends below the feet or begins above the head is not there. A step
//! never deepens an overlap, so a body that starts inside an obstacle can only get out.
//!
//! Speed is gained and lost within a fraction of a second, steps uphill are slower, and ground that is too steep to
//! climb lets slide down. The eye follows the feet smoothly and sways with the strides, which can be switched off.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use bevy::prelude::*;

use super::input::Intent;
use crate::level::ground::Ground;

mod gait;
mod surroundings;
#[cfg(test)]
mod tests;

use gait::Gait;
use surroundings::Surroundings;

/// How the walker gets about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// On the ground, with gravity and obstacles.
    #[default]
    Walk,
    /// Anywhere, through anything.
    Fly,
}

/// Position, view and state of movement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Walker {
    /// Under the eye, on the ground when walking; world space, metres.
    pub feet: Vec3,
    /// Radians counter-clockwise from −z, seen from above.
    pub yaw: f32,
    /// Radians upwards, within ±[`MAX_PITCH`].
    pub pitch: f32,
    /// Walking or flying.
    pub mode: Mode,
    /// Whether the view sways with the strides; it does unless switched off.
    pub head_bob: bool,
    /// Height of the eye, which follows the feet smoothly.
    eye_y: f32,
    fall_speed: f32,
    /// Along x and z, in metres per second.
    velocity: Vec2,
    gait: Gait,
}

/// Eyes above the feet, in metres.
pub const EYE_HEIGHT: f32 = 1.7;
/// The body's height, in metres.
pub const BODY_HEIGHT: f32 = 1.8;
/// The body's radius, in metres.
pub const RADIUS: f32 = 0.3;
/// The highest edge that is stepped onto, in metres.
pub const STEP_HEIGHT: f32 = 0.4;
/// Upward part of the unit normal of the steepest slope that is climbed, and on which one stands: the cosine of 45
/// degrees.
pub const MIN_NORMAL_Y: f32 = std::f32::consts::FRAC_1_SQRT_2;
/// The view goes up and down to 89 degrees, so that left and right stay known.
pub const MAX_PITCH: f32 = FRAC_PI_2 - PI / 180.0;
/// Longest time of one step, in seconds: after a pause of the machine nobody is thrown across the level.
pub const MAX_SECONDS: f32 = 0.1;

const WALK_SPEED: f32 = 3.5;
const RUN_SPEED: f32 = 7.0;
/// How fast the velocity becomes what is wanted, per second: nine tenths within a quarter of a second.
const VELOCITY_RATE: f32 = 10.0;
/// Sliding down gets no faster than this, in metres per second.
const SLIDE_SPEED: f32 = 8.0;
const FLY_SPEED: f32 = 12.0;
const FAST_FLY_SPEED: f32 = 60.0;
const GRAVITY: f32 = 9.81;
/// Movement is cut into pieces of at most this length, less than the radius.
const PIECE: f32 = 0.15;
/// How fast the eye follows the feet, per second.
const EYE_RATE: f32 = 14.0;
/// How far the eye may be from its place above the feet.
const EYE_LAG: f32 = 0.4;
/// Overlap that counts as touching.
const TOUCH: f32 = 1.0e-3;
/// How far from the edge of hills a walker turns round, in metres.
const EDGE: f32 = 1.0;
/// Beyond this the numbers get coarse, and flying ends.
const WORLD_LIMIT: f32 = 1.0e5;

impl Walker {
    /// Standing with its eye at `eye`, looking at `target`; non-finite values are taken for zero.
    pub fn looking_at(eye: Vec3, target: Vec3, mode: Mode) -> Self {
        let eye = if eye.is_finite() { eye } else { Vec3::Y * EYE_HEIGHT };
        let direction = (target - eye).try_normalize().unwrap_or(Vec3::NEG_Z);
        Self {
            feet: eye - Vec3::Y * EYE_HEIGHT,
            yaw: (-direction.x).atan2(-direction.z),
            pitch: direction.y.clamp(-1.0, 1.0).asin().clamp(-MAX_PITCH, MAX_PITCH),
            mode,
            head_bob: true,
            eye_y: eye.y,
            fall_speed: 0.0,
            velocity: Vec2::ZERO,
            gait: Gait::default(),
        }
    }

    /// Put onto what carries it, however far below; flying, it stays where it is.
    #[must_use]
    pub fn settled(mut self, ground: &Ground) -> Self {
        if self.mode == Mode::Walk {
            self.feet.y = Surroundings::of(ground, self.feet.xz(), PIECE).support(self.feet);
            self.eye_y = self.feet.y + EYE_HEIGHT;
        }
        self
    }

    /// The eye in world space.
    pub fn eye(&self) -> Vec3 {
        Vec3::new(self.feet.x, self.eye_y, self.feet.z)
    }

    /// The camera's place: −z along the view, y up; the eye, and what the strides add to it.
    pub fn camera(&self) -> Transform {
        let sway = if self.head_bob { self.gait.sway() } else { Vec2::ZERO };
        let sideways = Quat::from_rotation_y(self.yaw) * Vec3::X;
        Transform::from_translation(self.eye() + sideways * sway.x + Vec3::Y * sway.y).with_rotation(self.rotation())
    }

    /// From walking to flying and back; the feet find the ground with the next step.
    pub fn toggle_mode(&mut self) {
        self.mode = match self.mode {
            Mode::Walk => Mode::Fly,
            Mode::Fly => Mode::Walk,
        };
        self.feet.y = self.eye_y - EYE_HEIGHT;
        self.fall_speed = 0.0;
        self.velocity = Vec2::ZERO;
        self.gait = Gait::default();
    }

    /// Turns and moves for `seconds`.
    pub fn step(&mut self, intent: &Intent, ground: &Ground, seconds: f32) {
        let seconds = if seconds.is_finite() {
            seconds.clamp(0.0, MAX_SECONDS)
        } else {
            0.0
        };
        if intent.look.is_finite() {
            self.yaw = (self.yaw + intent.look.x + PI).rem_euclid(TAU) - PI;
            self.pitch = (self.pitch + intent.look.y).clamp(-MAX_PITCH, MAX_PITCH);
        }
        let movement = if intent.movement.is_finite() {
            intent.movement
        } else {
            Vec3::ZERO
        };
        match self.mode {
            Mode::Walk => self.walk(movement, intent.faster, ground, seconds),
            Mode::Fly => self.fly(movement, intent.faster, seconds),
        }
    }

    /// The normal of the ground that the feet stand on, where it is too steep to stand.
    fn steep_ground(&self, ground: &Ground) -> Option<Vec3> {
        let normal = ground.normal(self.feet.x, self.feet.z);
        let stands = self.feet.y - ground.height(self.feet.x, self.feet.z) < TOUCH;
        (stands && normal.y < MIN_NORMAL_Y).then_some(normal)
    }

    fn rotation(&self) -> Quat {
        Quat::from_rotation_y(self.yaw) * Quat::from_rotation_x(self.pitch)
    }

    fn fly(&mut self, movement: Vec3, faster: bool, seconds: f32) {
        let speed = if faster { FAST_FLY_SPEED } else { FLY_SPEED };
        let direction = self.rotation() * Vec3::new(movement.x, 0.0, -movement.z) + Vec3::Y * movement.y;
        let eye = self.eye() + direction.clamp_length_max(1.0) * speed * seconds;
        let eye = eye.clamp(Vec3::splat(-WORLD_LIMIT), Vec3::splat(WORLD_LIMIT));
        self.eye_y = eye.y;
        self.feet = eye - Vec3::Y * EYE_HEIGHT;
    }

    fn walk(&mut self, movement: Vec3, faster: bool, ground: &Ground, seconds: f32) {
        let speed = if faster { RUN_SPEED } else { WALK_SPEED };
        let direction = Quat::from_rotation_y(self.yaw) * Vec3::new(movement.x, 0.0, -movement.z);
        let direction = direction.xz().clamp_length_max(1.0);
        self.velocity = match self.steep_ground(ground) {
            Some(normal) => {
                // What pulls along the slope, seen from above.
                let pull = normal.xz() * normal.y * GRAVITY;
                (self.velocity + pull * seconds).clamp_length_max(SLIDE_SPEED)
            }
            None => {
                let wanted = direction * speed * gait::uphill(ground.normal(self.feet.x, self.feet.z), direction);
                wanted + (self.velocity - wanted) * (-VELOCITY_RATE * seconds).exp()
            }
        };

        let before = self.feet;
        let path = self.velocity * seconds;
        let around = Surroundings::of(ground, self.feet.xz(), path.length() + PIECE);
        let pieces = (path.length() / PIECE).ceil().max(1.0);
        for _ in 0..pieces as u32 {
            self.feet = around.slide(self.feet, path / pieces);
        }
        let way = (self.feet - before).xz();
        if way.length() < 0.5 * path.length() {
            // Stopped: a wall takes the speed, so that turning away from it is not held up.
            self.velocity = way / seconds.max(1e-6);
        }
        self.gait
            .walked(if self.fall_speed > 0.0 { 0.0 } else { way.length() }, seconds);

        let support = around.support(self.feet);
        let drop = self.feet.y - support;
        if drop <= 0.0 || (drop <= STEP_HEIGHT && self.fall_speed == 0.0) {
            self.feet.y = support;
            self.fall_speed = 0.0;
        } else {
            self.fall_speed += GRAVITY * seconds;
            self.feet.y = (self.feet.y - self.fall_speed * seconds).max(support);
        }

        let wanted = self.feet.y + EYE_HEIGHT;
        self.eye_y = wanted + (self.eye_y - wanted) * (-EYE_RATE * seconds).exp();
        self.eye_y = self.eye_y.clamp(wanted - EYE_LAG, wanted + EYE_LAG);
    }
}
