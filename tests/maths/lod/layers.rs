//! Layers of nearest surfaces: what overlaps in a picture, and who gets which.

use bevy_math::Vec3;
use proptest::prelude::*;
use umbrage::maths::lod::layers::{Ball, free_layer, overlap};

fn ball(x: f32, z: f32, radius: f32) -> Ball {
    Ball {
        center: Vec3::new(x, 0.0, z),
        radius,
    }
}

#[test]
fn balls_overlap_where_a_ray_meets_both() {
    let near = ball(0.0, -10.0, 1.0);
    assert!(overlap(Vec3::ZERO, near, ball(2.0, -50.0, 1.0)), "behind");
    assert!(!overlap(Vec3::ZERO, near, ball(20.0, -50.0, 1.0)), "beside");
    assert!(!overlap(Vec3::ZERO, near, ball(0.0, 50.0, 1.0)), "behind the eye");
    assert!(
        overlap(Vec3::ZERO, ball(0.0, 0.5, 1.0), ball(9.0, 0.0, 1.0)),
        "around the eye"
    );
    // Tangents: angles asin(1/10) and asin(1/10) to both sides.
    let angle = 2.0 * 0.1_f32.asin();
    let at = |angle: f32| ball(10.0 * angle.sin(), -10.0 * angle.cos(), 1.0);
    assert!(overlap(Vec3::ZERO, near, at(0.99 * angle)) && !overlap(Vec3::ZERO, near, at(1.01 * angle)));
}

#[test]
fn what_overlaps_gets_another_layer() {
    let eyes = [Vec3::ZERO];
    let mut taken: Vec<(Ball, u32)> = Vec::new();
    let mut layers = Vec::new();
    // Three behind each other, one beside, a fourth and a fifth behind.
    for (x, z) in [
        (0.0, -10.0),
        (0.0, -20.0),
        (0.0, -30.0),
        (60.0, -10.0),
        (0.0, -40.0),
        (0.0, -50.0),
    ] {
        let new = ball(x, z, 2.0);
        let layer = free_layer(new, taken.iter().copied(), &eyes, 4);
        taken.push((new, layer));
        layers.push(layer);
    }
    assert_eq!(
        layers,
        [0, 1, 2, 0, 3, 0],
        "the last one shares the first one of the emptiest"
    );
    // Another eye sees other things behind each other.
    let beside = [(ball(0.0, -10.0, 2.0), 0)];
    let new = ball(20.0, -10.0, 2.0);
    assert_eq!(free_layer(new, beside, &eyes, 4), 0);
    assert_eq!(
        free_layer(new, beside, &[Vec3::ZERO, Vec3::new(-30.0, 0.0, -10.0)], 4),
        1
    );
    assert_eq!(free_layer(new, [], &[], 0), 0, "at least one layer");
}

proptest! {
    /// A ball around two holds both, and is no larger than needed.
    #[test]
    fn a_ball_around_both(x in -9.0_f32..9.0, z in -9.0_f32..9.0, a in 0.0_f32..5.0, b in 0.0_f32..5.0) {
        let (one, other) = (ball(0.0, 0.0, a), ball(x, z, b));
        let both = one.with(other);
        for inner in [one, other] {
            prop_assert!(both.center.distance(inner.center) + inner.radius <= both.radius + 1e-4);
        }
        let apart = one.center.distance(other.center);
        prop_assert!(both.radius <= (0.5 * (apart + a + b)).max(a).max(b) + 1e-4);
    }

    /// Levels that share a layer without need are not seen before each other.
    #[test]
    fn layers_are_shared_by_what_is_apart(seeds in prop::collection::vec((-40.0_f32..40.0, 5.0_f32..80.0), 1..12)) {
        let eyes = [Vec3::ZERO];
        let mut taken: Vec<(Ball, u32)> = Vec::new();
        for (x, far) in seeds {
            let new = ball(x, -far, 3.0);
            let layer = free_layer(new, taken.iter().copied(), &eyes, 12);
            let mut rivals = taken.iter().filter(|(_, own)| *own == layer);
            prop_assert!(rivals.all(|(other, _)| !overlap(eyes[0], new, *other)));
            taken.push((new, layer));
        }
    }
}
