//! A walker at random in forest and city: ten minutes of game time for every seed.

use std::{collections::HashSet, f32::consts::PI, fs};

use bevy::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use umbrage::{
    demo::{
        input::Intent,
        walker::{BODY_HEIGHT, Mode, RADIUS, STEP_HEIGHT, Walker},
    },
    level::{find::asset_root, ground::Ground, parse::parse, scenery},
};

const FRAME: f32 = 1.0 / 60.0;
const SECONDS: usize = 600;
/// Side of the squares that are counted as visited, in metres.
const SQUARE: f32 = 5.0;
/// Overlap that counts as touching, in metres.
const TOUCH: f32 = 2.0e-3;

fn ground_and_start(name: &str) -> (Ground, Walker) {
    let root = asset_root(None).expect("the repository's levels");
    let bytes = fs::read(root.levels().join(format!("{name}.level.ron"))).expect("a level file");
    let level = parse(&bytes).expect("a level");
    let ground = scenery::generate(&level).ground;
    let walker = Walker::looking_at(level.spawn.position, level.spawn.look_at, Mode::Walk).settled(&ground);
    (ground, walker)
}

/// How deep a body with these feet is in something that it can neither step on nor pass below.
fn depth(ground: &Ground, feet: Vec3) -> f32 {
    ground
        .blockers_near(feet.xz(), RADIUS)
        .into_iter()
        .filter(|blocker| blocker.top > feet.y + STEP_HEIGHT && blocker.bottom < feet.y + BODY_HEIGHT)
        .map(|blocker| RADIUS - blocker.outwards(feet.xz()).0)
        .fold(0.0, f32::max)
}

/// Walks for ten minutes, turns at random every second or so, runs now and then, and looks at every frame.
fn wander(name: &str, ground: &Ground, mut walker: Walker, seed: u64) {
    let what = |second: usize| format!("{name}, seed {seed}, second {second}");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let half = ground.extent().expect("levels have an end") * 0.5;
    let start_depth = depth(ground, walker.feet);
    assert!(start_depth < TOUCH, "{}: the start lies {start_depth} m deep", what(0));
    let mut visited = HashSet::new();
    let mut squares_by_minute = Vec::new();
    let (mut way_in_ten_seconds, mut way_in_a_second) = (0.0, 1.0);
    for second in 0..SECONDS {
        // Who was stopped in the last second looks anywhere, others mostly ahead.
        let widest = if way_in_a_second < 0.3 { PI } else { 0.5 * PI };
        let turn = random.random_range(-widest..widest);
        way_in_a_second = 0.0;
        let faster = random.random_bool(0.4);
        let sideways = if random.random_bool(0.2) {
            random.random_range(-1.0..1.0)
        } else {
            0.0
        };
        for frame in 0..60 {
            // A quick turn in the first fifth of each second, as with a mouse.
            let yaw = if frame < 12 { turn / 12.0 } else { 0.0 };
            let intent = Intent {
                movement: Vec3::new(sideways, 0.0, 1.0),
                faster,
                look: Vec2::new(yaw, 0.0),
                ..default()
            };
            let before = walker.feet;
            walker.step(&intent, ground, FRAME);
            let feet = walker.feet;
            assert!(
                feet.is_finite() && walker.camera().is_finite(),
                "{}: {walker:?}",
                what(second)
            );
            let height = ground.height(feet.x, feet.z);
            assert!(feet.y >= height - 1e-3, "{}: {feet} below {height}", what(second));
            assert!(
                walker.camera().translation.y > height + 1.2,
                "{}: {walker:?}",
                what(second)
            );
            let deep = depth(ground, feet);
            assert!(deep < TOUCH, "{}: {deep} m deep at {feet}", what(second));
            assert!(feet.xz().abs().cmple(half).all(), "{}: left at {feet}", what(second));
            let step = feet.xz().distance(before.xz());
            assert!(step < 0.16, "{}: {step} m in a frame", what(second));
            way_in_ten_seconds += step;
            way_in_a_second += step;
        }
        visited.insert((walker.feet.xz() / SQUARE).floor().as_ivec2());
        if second % 10 == 9 {
            assert!(
                way_in_ten_seconds > 5.0,
                "{}: {way_in_ten_seconds} m in ten seconds",
                what(second)
            );
            way_in_ten_seconds = 0.0;
        }
        if second % 60 == 59 {
            squares_by_minute.push(visited.len());
        }
    }
    for pair in squares_by_minute.windows(3) {
        assert!(
            pair[2] > pair[0],
            "{}: no new ground: {squares_by_minute:?}",
            what(SECONDS)
        );
    }
    assert!(visited.len() > 100, "{}: {squares_by_minute:?}", what(SECONDS));
}

#[test]
fn ten_minutes_in_the_forest_get_nobody_stuck() {
    let (ground, walker) = ground_and_start("forest");
    for seed in 0..3 {
        wander("forest", &ground, walker, seed);
    }
}

#[test]
fn ten_minutes_in_the_city_get_nobody_stuck() {
    let (ground, walker) = ground_and_start("city");
    for seed in 0..3 {
        wander("city", &ground, walker, seed);
    }
}
