//! Hand-made grounds, and an obstacle course for walkers at random.

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
