//! Walking through the real levels.

use std::f32::consts::PI;

use bevy::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use umbrage::{
    demo::{
        input::Intent,
        walker::{BODY_HEIGHT, Mode, RADIUS, STEP_HEIGHT, Walker},
    },
    level::{find::asset_root, ground::Ground, parse, scenery},
};

/// How deep a body at `feet` is inside of an obstacle.
fn depth(ground: &Ground, feet: Vec3) -> f32 {
    let at = feet.xz();
    let in_the_way = ground
        .blockers_near(at, RADIUS)
        .into_iter()
        .filter(|blocker| blocker.top > feet.y + STEP_HEIGHT && blocker.bottom < feet.y + BODY_HEIGHT);
    in_the_way
        .map(|blocker| RADIUS - blocker.outwards(at).0)
        .fold(0.0, f32::max)
}

fn stroll(name: &str, least_way: f32) {
    let root = asset_root(None).unwrap_or_else(|error| panic!("{error}"));
    let path = root.levels().join(format!("{name}.level.ron"));
    let bytes = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let level = parse::parse(&bytes).unwrap_or_else(|error| panic!("{name}: {error}"));
    let ground = scenery::generate(&level).ground;

    let mut walker = Walker::looking_at(level.spawn.position, level.spawn.look_at, Mode::Walk).settled(&ground);
    assert!(
        depth(&ground, walker.feet) < 0.01,
        "{name}: the spawn is inside of something"
    );
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let (mut way, mut farthest) = (0.0, 0.0f32);
    let start = walker.feet;
    for frame in 0..5 * 60 * 60 {
        if frame % 240 == 0 {
            walker.yaw = random.random_range(-PI..PI);
        }
        let intent = Intent {
            movement: Vec3::Z,
            faster: true,
            look: Vec2::new(random.random_range(-0.03..0.03), 0.0),
            ..default()
        };
        let before = walker.feet;
        walker.step(&intent, &ground, 1.0 / 60.0);
        let feet = walker.feet;
        let height = ground.height(feet.x, feet.z);
        assert!(walker.camera().is_finite(), "{name}, frame {frame}: {walker:?}");
        assert!(feet.y >= height - 1e-3, "{name}, frame {frame}: {feet} below {height}");
        assert!(
            depth(&ground, feet) < 0.01,
            "{name}, frame {frame}: inside of something at {feet}"
        );
        way += feet.xz().distance(before.xz());
        farthest = farthest.max(feet.xz().distance(start.xz()));
    }
    assert!(way > least_way, "{name}: got stuck after {way} m");
    assert!(farthest > 20.0, "{name}: never got farther than {farthest} m");
}

#[test]
fn a_stroll_in_the_forest() {
    stroll("forest", 1000.0);
}

#[test]
fn a_stroll_in_the_city() {
    stroll("city", 1000.0);
}
