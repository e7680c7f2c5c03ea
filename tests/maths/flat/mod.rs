//! Light planes in flatland (Chong 2003): oracles of the thesis and its corrections. Oracle numbers O1 to O23.

mod allocation;
mod construction;
mod footprint;
mod metric;
mod optimum;
mod post_perspective;
mod search;
mod split;
mod study;
mod tilt;

use bevy_math::DVec2;
use umbrage::maths::light_plane::flat::{Camera, Light, Sample, Segment};

/// From the thesis's coordinates (y, z).
fn at(y: f64, z: f64) -> DVec2 {
    DVec2::new(z, y)
}

fn surface(from: [f64; 2], to: [f64; 2]) -> Segment {
    Segment::new(at(from[0], from[1]), at(to[0], to[1]))
}

fn lamp(y: f64, z: f64) -> Light {
    Light::Point { position: at(y, z) }
}

/// The camera of most oracles: 1 above the floor, looking 10° down, 60° wide, 1000 pixels.
fn pitched_camera() -> Camera {
    Camera::new(
        at(1.0, 0.0),
        -10.0_f64.to_radians(),
        30.0_f64.to_radians(),
        1.0,
        100.0,
        1000,
    )
    .expect("sound")
}

fn floor() -> Segment {
    surface([0.0, -0.5], [0.0, -40.0])
}

fn samples(places: &[f64], badness: &[f64]) -> Vec<Sample> {
    let pairs = places.iter().zip(badness);
    pairs
        .map(|(place, badness)| Sample {
            place: *place,
            badness: *badness,
        })
        .collect()
}

/// The data of O4 to O6.
fn five_samples() -> Vec<Sample> {
    samples(&[-1.0, -0.5, 0.0, 0.5, 1.0], &[1.0, 1.0, 2.0, 4.0, 9.0])
}

/// Numbers in 0..1 that are the same in every run.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }

    /// Mean 0, deviation 1, near enough: the sum of twelve.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.roll()).sum::<f64>() - 6.0
    }

    /// 52 pixels over a whole hull with log-normal badness, as in O7.
    fn problem(&mut self) -> Vec<Sample> {
        let mut places = vec![-1.0, 1.0];
        places.extend((0..50).map(|_| self.between(-1.0, 1.0)));
        let badness: Vec<f64> = places.iter().map(|_| (1.5 * self.normal()).exp()).collect();
        samples(&places, &badness)
    }
}

/// Asserts equality to an absolute tolerance.
#[track_caller]
fn near(actual: f64, expected: f64, tolerance: f64) {
    assert!(
        (actual - expected).abs() <= tolerance,
        "{actual} is not within {tolerance} of {expected}"
    );
}
