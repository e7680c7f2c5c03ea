//! [`Walker`]: a person on the ground, or a camera that flies. Pure: a step takes intent, ground and time.
//!
//! The body is an upright cylinder. An obstacle whose top is at most [`STEP_HEIGHT`] above the feet carries it, a
//! higher one stops it and lets it slide along; what ends below the feet or begins above the head is not there. A step
//! never deepens an overlap, so a body that starts inside an obstacle can only get out.
//!
//! Speed is gained and lost within a fraction of a second, steps uphill are slower, and ground that is too steep to climb
//! lets slide down. The eye follows the feet smoothly and sways with the strides, which can be switched off.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use bevy::prelude::*;

use super::input::Intent;
use crate::level::ground::Ground;

mod gait;
mod surroundings;

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
/// Upward part of the unit normal of the steepest slope that is climbed, and on which one stands: the cosine of 45 degrees.
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

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::level::{
        format::{Hills, TerrainShape},
        ground::{Blocker, BlockerShape, Step, Surface},
        terrain::Terrain,
    };

    const FRAME: f32 = 1.0 / 60.0;

    fn blocker(x: f32, z: f32, shape: BlockerShape, bottom: f32, top: f32) -> Blocker {
        Blocker {
            center: Vec2::new(x, z),
            shape,
            bottom,
            top,
        }
    }

    fn wall(x: f32, z: f32, half: Vec2, yaw: f32, top: f32) -> Blocker {
        blocker(x, z, BlockerShape::Box { half, yaw }, -50.0, top)
    }

    fn flat(blockers: Vec<Blocker>) -> Ground {
        Ground::new(Surface::Flat(0.0), Vec::new(), blockers)
    }

    fn forward() -> Intent {
        Intent {
            movement: Vec3::Z,
            ..default()
        }
    }

    fn at(x: f32, y: f32, z: f32) -> Walker {
        let eye = Vec3::new(x, y + EYE_HEIGHT, z);
        Walker::looking_at(eye, eye + Vec3::NEG_Z, Mode::Walk)
    }

    fn walk(walker: &mut Walker, intent: &Intent, ground: &Ground, seconds: f32) {
        for _ in 0..(seconds / FRAME).round() as u32 {
            walker.step(intent, ground, FRAME);
        }
    }

    #[test]
    fn the_view_is_where_it_was_asked_for() {
        for target in [
            Vec3::new(3.0, 1.0, -2.0),
            Vec3::new(-1.0, 5.0, 4.0),
            Vec3::new(0.2, -9.0, 0.1),
        ] {
            let eye = Vec3::new(0.5, 2.0, 0.0);
            let walker = Walker::looking_at(eye, target, Mode::Walk);
            let forward = walker.camera().forward();
            assert!(
                forward.dot((target - eye).normalize()) > 0.9998,
                "{target}: {forward:?}"
            );
            assert_eq!(walker.eye(), eye);
        }
    }

    #[test]
    fn walking_forward_goes_where_the_view_goes_at_walking_speed() {
        let ground = flat(vec![]);
        let mut walker = at(0.0, 0.0, 0.0);
        walk(&mut walker, &forward(), &ground, 1.0);
        let before = walker.feet;
        assert!(
            (-WALK_SPEED..-0.85 * WALK_SPEED).contains(&before.z),
            "soon at full speed: {before}"
        );
        walk(&mut walker, &forward(), &ground, 1.0);
        assert!(
            walker.feet.abs_diff_eq(before - Vec3::Z * WALK_SPEED, 1e-3),
            "{}",
            walker.feet
        );
        walk(&mut walker, &Intent::default(), &ground, 2.0);
        let braked = before.z - WALK_SPEED - walker.feet.z;
        assert!((0.1..0.5).contains(&braked), "stands after {braked} m");
        let start = walker.feet;
        walker.yaw = FRAC_PI_2;
        walk(
            &mut walker,
            &Intent {
                faster: true,
                ..forward()
            },
            &ground,
            1.0,
        );
        assert!(
            (-RUN_SPEED..-0.85 * RUN_SPEED).contains(&(walker.feet.x - start.x)),
            "to the left of before: {}",
            walker.feet
        );
        let diagonal = Intent {
            movement: Vec3::new(1.0, 0.0, 1.0),
            ..default()
        };
        walk(&mut walker, &diagonal, &ground, 2.0);
        let before = walker.feet;
        walk(&mut walker, &diagonal, &ground, 1.0);
        assert!(
            (walker.feet.distance(before) - WALK_SPEED).abs() < 1e-3,
            "no faster along the diagonal"
        );
    }

    #[test]
    fn a_wall_stops_and_lets_slide() {
        let ground = flat(vec![wall(0.0, -3.0, Vec2::new(50.0, 0.5), 0.0, 3.0)]);
        let mut walker = at(0.0, 0.0, 0.0);
        walker.yaw = -PI / 4.0;
        walk(&mut walker, &forward(), &ground, 4.0);
        assert!(
            (walker.feet.z - (-2.5 + RADIUS)).abs() < 0.01,
            "stopped at the wall: {}",
            walker.feet
        );
        assert!(walker.feet.x > 5.0, "slid along it: {}", walker.feet);
    }

    #[test]
    fn a_trunk_is_walked_around_unless_hit_dead_center() {
        let trunk = blocker(0.0, -3.0, BlockerShape::Cylinder { radius: 0.5 }, 0.0, 9.0);
        let ground = flat(vec![trunk]);
        let mut walker = at(0.1, 0.0, 0.0);
        walk(&mut walker, &forward(), &ground, 4.0);
        assert!(walker.feet.z < -6.0, "passed it: {}", walker.feet);
    }

    #[test]
    fn low_edges_are_stepped_on_and_high_ones_are_not() {
        let half = Vec2::new(2.0, 2.0);
        for (top, y) in [(0.35, 0.35), (0.6, 0.0)] {
            let mut walker = at(0.0, 0.0, 0.0);
            walk(
                &mut walker,
                &forward(),
                &flat(vec![wall(0.0, -4.0, half, 0.0, top)]),
                1.0,
            );
            assert!((walker.feet.y - y).abs() < 1e-4, "an edge of {top} m: {}", walker.feet);
        }
        let pavement = Step {
            min: Vec2::new(-9.0, -9.0),
            max: Vec2::new(9.0, -1.0),
            top: 0.15,
        };
        let ground = Ground::new(Surface::Flat(0.0), vec![pavement], vec![]);
        let mut walker = at(0.0, 0.0, 0.0);
        walk(&mut walker, &forward(), &ground, 1.0);
        assert!(
            (walker.feet.y - 0.15).abs() < 1e-4 && walker.feet.z < -3.0,
            "{}",
            walker.feet
        );
        let backwards = Intent {
            movement: Vec3::NEG_Z,
            ..default()
        };
        walk(&mut walker, &backwards, &ground, 2.0);
        assert_eq!(walker.feet.y, 0.0, "and down again");
    }

    #[test]
    fn the_eye_rises_smoothly_over_an_edge() {
        let ground = flat(vec![wall(0.0, -4.0, Vec2::splat(3.0), 0.0, 0.4)]);
        let mut walker = at(0.0, 0.0, 0.0);
        let mut highest_rate = 0.0f32;
        for _ in 0..60 {
            let before = walker.eye().y;
            walker.step(&forward(), &ground, FRAME);
            highest_rate = highest_rate.max((walker.eye().y - before) / FRAME);
        }
        assert!(
            (walker.eye().y - 0.4 - EYE_HEIGHT).abs() < 0.01,
            "arrived: {}",
            walker.eye()
        );
        assert!(highest_rate < EYE_RATE * 0.41, "{highest_rate} m/s");
    }

    #[test]
    fn after_flying_onto_a_roof_one_stands_on_it_and_over_a_field_one_falls() {
        let ground = flat(vec![wall(0.0, 0.0, Vec2::splat(5.0), 0.3, 8.0)]);
        for (x, y) in [(0.0, 8.0), (20.0, 0.0)] {
            let mut walker = at(x, 12.0, 0.0);
            walker.mode = Mode::Fly;
            walker.toggle_mode();
            walk(&mut walker, &Intent::default(), &ground, 0.2);
            assert!(walker.feet.y > 11.0, "still falling: {}", walker.feet);
            walk(&mut walker, &Intent::default(), &ground, 3.0);
            assert!((walker.feet.y - y).abs() < 1e-4, "at {x}: {}", walker.feet);
        }
    }

    #[test]
    fn who_walks_begins_on_the_ground_and_who_flies_in_the_air() {
        let ground = Ground::flat(5.0);
        for y in [4.0, 6.0, 50.0] {
            let walker = at(0.0, y, 0.0).settled(&ground);
            assert_eq!((walker.feet.y, walker.eye().y), (5.0, 5.0 + EYE_HEIGHT), "from {y}");
        }
        let mut flying = at(0.0, 50.0, 0.0);
        flying.mode = Mode::Fly;
        assert_eq!(flying.settled(&ground), flying);
    }

    #[test]
    fn one_can_walk_under_a_roof() {
        let roof = blocker(
            0.0,
            -4.0,
            BlockerShape::Box {
                half: Vec2::splat(2.0),
                yaw: 0.0,
            },
            2.2,
            2.6,
        );
        let mut walker = at(0.0, 0.0, 0.0);
        walk(&mut walker, &forward(), &flat(vec![roof]), 3.0);
        assert!(walker.feet.z < -9.0 && walker.feet.y == 0.0, "{}", walker.feet);
    }

    #[test]
    fn one_gets_out_of_an_obstacle_that_one_starts_in() {
        let ground = flat(vec![wall(0.0, 0.0, Vec2::new(3.0, 2.0), 0.7, 5.0)]);
        let mut walker = at(0.2, 0.0, 0.3);
        walk(&mut walker, &Intent::default(), &ground, 0.1);
        let around = Surroundings::of(&ground, walker.feet.xz(), 1.0);
        assert!(around.depth(walker.feet) <= TOUCH, "{}", walker.feet);
    }

    /// A slope that falls towards +z, cut out of noise-free hills by their rim: level in the middle, steep at the edge.
    fn slope(rim_height: f32) -> Ground {
        let shape = TerrainShape {
            size: Vec2::splat(60.0),
            hills: Some(Hills {
                amplitude: 0.0,
                wavelength: 50.0,
                octaves: 1,
                rim_height,
                rim_width: 20.0,
            }),
            clearings: vec![],
            tracks: vec![],
        };
        Ground::new(
            Surface::Hills(Box::new(Terrain::new(&shape, 1))),
            Vec::new(),
            Vec::new(),
        )
    }

    #[test]
    fn steep_ground_is_not_climbed_and_lets_slide_down() {
        let (gentle, steep) = (slope(6.0), slope(60.0));
        let climb = |ground: &Ground| {
            let mut walker = at(0.0, 0.0, -5.0).settled(ground);
            walk(&mut walker, &forward(), ground, 20.0);
            walker.feet
        };
        let (up, stopped) = (climb(&gentle), climb(&steep));
        assert!(up.z < -28.0, "to the edge: {up}");
        assert!(stopped.z > -25.0 && stopped.y < 30.0, "stopped on the way: {stopped}");

        let steepest = |ground: &Ground| {
            (0..200)
                .map(|i| -10.0 - 0.09 * i as f32)
                .min_by(|a, b| ground.normal(0.0, *a).y.total_cmp(&ground.normal(0.0, *b).y))
                .expect("heights")
        };
        let z = steepest(&steep);
        assert!(steep.normal(0.0, z).y < MIN_NORMAL_Y, "the test's slope is steep");
        let mut walker = at(0.0, 0.0, z).settled(&steep);
        let top = walker.feet.y;
        walk(&mut walker, &Intent::default(), &steep, 4.0);
        assert!(walker.feet.y < top - 3.0, "slid from {top} to {}", walker.feet);
        assert!(
            steep.normal(0.0, walker.feet.z).y > MIN_NORMAL_Y,
            "until it is level enough"
        );
        let z = steepest(&gentle);
        let mut stands = at(0.0, 0.0, z).settled(&gentle);
        let before = stands.feet;
        walk(&mut stands, &Intent::default(), &gentle, 2.0);
        assert_eq!(stands.feet, before, "gentle slopes hold");
    }

    #[test]
    fn the_view_sways_with_the_strides_unless_switched_off() {
        let ground = flat(vec![]);
        for (head_bob, least, most) in [(true, 0.01, 0.05), (false, 0.0, 0.0)] {
            let mut walker = at(0.0, 0.0, 0.0);
            walker.head_bob = head_bob;
            let mut highest = 0.0f32;
            for _ in 0..120 {
                walker.step(&forward(), &ground, FRAME);
                highest = highest.max((walker.camera().translation.y - EYE_HEIGHT).abs());
            }
            assert!((least..=most).contains(&highest), "{head_bob}: {highest}");
        }
    }

    #[test]
    fn twenty_frames_a_second_pass_no_wall() {
        let ground = flat(vec![wall(0.0, -6.0, Vec2::new(50.0, 0.02), 0.0, 3.0)]);
        let mut walker = at(0.0, 0.0, 0.0);
        let run = Intent {
            faster: true,
            ..forward()
        };
        for _ in 0..60 {
            walker.step(&run, &ground, 0.05);
        }
        assert!((walker.feet.z + 6.0 - 0.02 - RADIUS).abs() < 0.01, "{}", walker.feet);
    }

    #[test]
    fn the_worlds_edge_holds_on_a_plane() {
        let ground = flat(vec![]).within(Vec2::new(20.0, 30.0));
        let mut walker = at(0.0, 0.0, 0.0);
        walker.yaw = 0.3;
        walk(&mut walker, &forward(), &ground, 30.0);
        assert!((walker.feet.z + 15.0 - EDGE).abs() < 1e-3, "{}", walker.feet);
        assert!(
            (walker.feet.x + 10.0 - EDGE).abs() < 1e-3,
            "slides along it: {}",
            walker.feet
        );
    }

    #[test]
    fn bad_numbers_change_nothing() {
        let ground = flat(vec![]);
        let mut walker = at(1.0, 0.0, 2.0);
        walker.step(&Intent::default(), &ground, FRAME);
        let before = walker;
        let nonsense = Intent {
            movement: Vec3::NAN,
            look: Vec2::splat(f32::INFINITY),
            ..default()
        };
        walker.step(&nonsense, &ground, FRAME);
        walker.step(&forward(), &ground, f32::NAN);
        walker.step(&forward(), &ground, -1.0);
        assert_eq!(walker, before);
        walker.step(&forward(), &ground, 3600.0);
        assert!(
            walker.feet.distance(before.feet) <= WALK_SPEED * MAX_SECONDS + 1e-4,
            "a long frame is a short step"
        );
        let nowhere = Walker::looking_at(Vec3::NAN, Vec3::NAN, Mode::Walk);
        assert!(nowhere.camera().is_finite(), "{nowhere:?}");
    }

    #[test]
    fn flying_goes_along_the_view_and_through_the_ground() {
        let ground = flat(vec![wall(0.0, -5.0, Vec2::splat(1.0), 0.0, 90.0)]);
        let mut walker = at(0.0, 10.0, 0.0);
        walker.toggle_mode();
        walker.pitch = -PI / 4.0;
        walk(&mut walker, &forward(), &ground, 2.0);
        let way = 2.0 * FLY_SPEED * std::f32::consts::FRAC_1_SQRT_2;
        let expected = Vec3::new(0.0, 10.0 + EYE_HEIGHT - way, -way);
        assert!(walker.eye().abs_diff_eq(expected, 1e-3), "{}", walker.eye());
        walker.toggle_mode();
        walk(&mut walker, &Intent::default(), &ground, 1.0);
        assert_eq!(walker.feet.y, 0.0, "back on the ground");
    }

    /// Hills with steep places, trunks, turned boxes, low walls and roofs.
    fn obstacle_course(seed: u64) -> Ground {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let terrain = Terrain::new(
            &TerrainShape {
                size: Vec2::new(80.0, 60.0),
                hills: Some(Hills {
                    amplitude: 9.0,
                    wavelength: 22.0,
                    octaves: 4,
                    rim_height: 4.0,
                    rim_width: 8.0,
                }),
                clearings: vec![],
                tracks: vec![],
            },
            seed,
        );
        let blockers = (0..250)
            .map(|_| {
                let (x, z) = (random.random_range(-39.0..39.0), random.random_range(-29.0..29.0));
                let ground = terrain.height(Vec2::new(x, z));
                let shape = if random.random_bool(0.5) {
                    BlockerShape::Cylinder {
                        radius: random.random_range(0.1..1.0),
                    }
                } else {
                    BlockerShape::Box {
                        half: Vec2::new(random.random_range(0.05..3.0), random.random_range(0.05..1.5)),
                        yaw: random.random_range(-3.0..3.0),
                    }
                };
                let bottom = if random.random_bool(0.2) {
                    ground + random.random_range(0.5..3.0)
                } else {
                    ground - 9.0
                };
                blocker(x, z, shape, bottom, bottom.max(ground) + random.random_range(0.1..4.0))
            })
            .collect();
        Ground::new(Surface::Hills(Box::new(terrain)), Vec::new(), blockers)
    }

    #[test]
    fn ten_minutes_of_random_walking_leave_no_walker_outside_below_or_within() {
        for seed in 0..4 {
            let ground = obstacle_course(seed);
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut walker = at(0.0, 20.0, 0.0);
            let mut way = 0.0;
            for frame in 0..10 * 60 * 60 {
                if frame % 20 == 0 {
                    walker.yaw = random.random_range(-PI..PI);
                }
                let intent = Intent {
                    movement: Vec3::new(random.random_range(-1.0..1.0), 0.0, random.random_range(-0.2..1.0)),
                    faster: random.random_bool(0.7),
                    look: Vec2::new(random.random_range(-0.1..0.1), random.random_range(-0.1..0.1)),
                    ..default()
                };
                let before = walker.feet;
                let around = Surroundings::of(&ground, before.xz(), 5.0);
                let depth_before = around.depth(before);
                walker.step(&intent, &ground, if frame % 97 == 0 { 0.5 } else { FRAME });

                let feet = walker.feet;
                let height = ground.height(feet.x, feet.z);
                assert!(
                    feet.is_finite() && walker.camera().is_finite(),
                    "seed {seed} frame {frame}: {walker:?}"
                );
                assert!(
                    feet.y >= height - 1e-3,
                    "seed {seed} frame {frame}: {feet} below {height}"
                );
                assert!(
                    walker.eye().y >= height + 1.0,
                    "seed {seed} frame {frame}: the eye {}",
                    walker.eye()
                );
                assert!(
                    feet.x.abs() <= 39.001 && feet.z.abs() <= 29.001,
                    "seed {seed} frame {frame}: left at {feet}"
                );
                let depth = around.depth(feet);
                assert!(
                    depth <= depth_before.max(2.0 * TOUCH),
                    "seed {seed} frame {frame}: {depth} deep at {feet}, {depth_before} before at {before}"
                );
                way += feet.xz().distance(before.xz());
            }
            assert!(way > 1000.0, "seed {seed}: got stuck after {way} m");
        }
    }
}
