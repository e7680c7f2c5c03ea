//! Filters with a size in the world against formulas: the shadow of a straight edge over flat ground.

use bevy::{math::DVec3, prelude::*};

use crate::{
    harness::eye,
    truth::{Cuboid3, SIZE, harness_with, settings, trace, viewing_ray},
};

/// Height of the roof over the ground, metres.
const HEIGHT: f64 = 6.0;

fn light_dir() -> DVec3 {
    DVec3::new(-0.3, -1.0, 0.1).normalize()
}

/// A thin roof that ends at x = 0.
fn roof() -> Vec<Cuboid3> {
    vec![Cuboid3 {
        min: DVec3::new(-40.0, HEIGHT, -50.0),
        max: DVec3::new(0.0, HEIGHT + 0.001, 50.0),
    }]
}

/// The share of a disc that lies beyond a chord at a distance from its centre, in radii.
fn disc_share(distance: f64) -> f64 {
    let chord = distance.clamp(-1.0, 1.0);
    0.5 + (chord * (1.0 - chord * chord).sqrt() + chord.asin()) / std::f64::consts::PI
}

/// Pixels of the ground: shadow result, and distance from the edge of the shadow across the light, lit side positive.
fn ground(technique: &str) -> Vec<(f64, f64)> {
    let boxes = roof();
    let mut harness = harness_with(&boxes);
    harness.sun(light_dir().as_vec3(), settings(technique));
    harness.start();
    let result = harness.shadow_result(harness.camera);
    let origin = eye().translation.as_dvec3();
    let across = DVec3::Z.cross(light_dir()).normalize();
    let across = across * across.x.signum();
    (0..SIZE.x * SIZE.y)
        .filter_map(|index| {
            let direction = viewing_ray(eye(), f64::from(index % SIZE.x) + 0.5, f64::from(index / SIZE.x) + 0.5);
            let (t, _, id) = trace(origin, direction, &boxes)?;
            let point = origin + direction * t;
            let is_ground = id == 0 && t * direction.dot(eye().forward().as_dvec3()) < 40.0;
            is_ground.then(|| {
                let from_edge = (point - DVec3::Y * HEIGHT).dot(across);
                (f64::from(result[index as usize]), from_edge)
            })
        })
        .collect()
}

/// Mean error within the penumbra, and the largest one beyond it; and how many pixels are within.
fn errors_of(technique: &str, radius: f64) -> (f64, f64, usize) {
    let (mut sum, mut within, mut largest_beyond) = (0.0, 0, 0.0_f64);
    for (shown, from_edge) in ground(technique) {
        let error = (shown - disc_share(from_edge / radius)).abs();
        if from_edge.abs() < radius {
            within += 1;
            sum += error;
        } else if from_edge.abs() > 1.25 * radius {
            largest_beyond = largest_beyond.max(error);
        }
    }
    println!(
        "{technique}: mean error {:.4} in {within} pixels, {largest_beyond:.4} beyond",
        sum / within as f64
    );
    (sum / within as f64, largest_beyond, within)
}

/// One radius in metres, whatever the warp and the partition (Stingl, equation 3.9).
#[test]
fn discs_have_one_size_in_the_world() {
    for maps in [
        "uniform:size=2048",
        "lispsm:size=1024",
        "zp4:size=1024",
        "zp4+lispsm:size=1024",
    ] {
        let (mean, beyond, within) = errors_of(&format!("{maps},filter=poisson,taps=64,radius=0.4"), 0.4);
        assert!(within > 500, "{maps}: only {within} pixels are in the penumbra");
        assert!(mean < 0.02, "{maps}: mean error {mean} in the penumbra");
        assert!(beyond < 0.01, "{maps}: an error of {beyond} beyond the penumbra");
    }
}

/// A sun with a size: the radius is the distance along the light to the edge times the tangent of half its diameter.
#[test]
fn penumbrae_have_the_size_of_the_suns() {
    let distance = HEIGHT / -light_dir().y;
    for degrees in [3.0_f64, 6.0] {
        let radius = distance * (degrees.to_radians() / 2.0).tan();
        let technique = format!("zp4+lispsm:size=1024,filter=pcss,taps=64,radius=0.6,sun_diameter={degrees}");
        let (mean, beyond, within) = errors_of(&technique, radius);
        assert!(within > 200, "{degrees}: only {within} pixels are in the penumbra");
        assert!(mean < 0.02, "{degrees}: mean error {mean} in the penumbra");
        assert!(beyond < 0.01, "{degrees}: an error of {beyond} beyond the penumbra");
    }
}

/// More taps are nearer to the integral.
#[test]
fn taps_reduce_noise() {
    let mean = |taps: u32| {
        let technique = format!("zp4+lispsm:size=1024,filter=poisson,taps={taps},radius=0.4");
        errors_of(&technique, 0.4).0
    };
    let (few, many) = (mean(8), mean(64));
    assert!(many < 0.5 * few, "mean error {few} with 8 taps, {many} with 64");
}
