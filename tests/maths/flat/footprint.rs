//! Footprints and derivatives of the map from pixels to places.

use umbrage::maths::light_plane::flat::{Aliasing, Exposure, Film, Light, PixelFootprint, Segment, Transfer};

use super::{at, floor, lamp, near, pitched_camera, surface};

/// The scene of O10 and O11: floor and three cards.
fn scene() -> [Segment; 4] {
    [
        surface([0.0, -1.0], [0.0, -30.0]),
        surface([0.2, -6.0], [1.4, -5.0]),
        surface([0.1, -3.0], [1.0, -4.0]),
        surface([2.0, -20.0], [0.5, -8.0]),
    ]
}

/// O11: the exact footprint equals the analytic derivative, the approximate one is off by up to a third.
#[test]
fn exact_footprints_are_derivatives() {
    let camera = pitched_camera();
    let film = Film::new(lamp(4.0, -3.0), -60.0_f64.to_radians()).unwrap();
    let hits = camera.see(&scene());
    assert!(hits.len() > 500);
    let mut worst = 0.0_f64;
    for hit in &hits {
        let footprint = PixelFootprint::at(&camera, &film, hit, &scene()[hit.segment]);
        let derivative = film.rate(hit.point, hit.step).abs();
        near(footprint.exact() / derivative, 1.0, 1.0e-12);
        near(
            footprint.perspective() * footprint.projection() / derivative,
            1.0,
            1.0e-12,
        );
        worst = worst.max((footprint.approximate() / derivative - 1.0).abs());
    }
    assert!((0.25..0.40).contains(&worst), "{worst}");
}

/// The same under parallel light, on a film that faces it.
#[test]
fn footprints_hold_for_parallel_light() {
    let camera = pitched_camera();
    let sun = Light::Directional { travel: at(-0.6, -1.0) };
    let hits = camera.see(&scene());
    let exposure = Exposure::half_angle(sun, &hits).unwrap();
    for hit in &hits {
        let footprint = PixelFootprint::at(&camera, &exposure.film, hit, &scene()[hit.segment]);
        near(
            footprint.exact() / exposure.film.rate(hit.point, hit.step).abs(),
            1.0,
            1.0e-12,
        );
    }
}

/// The derivative of a hit is that of finite differences.
#[test]
fn rates_are_finite_differences() {
    let camera = pitched_camera();
    let fine = camera.with_pixels(1_000_001).unwrap();
    for light in [lamp(4.0, -3.0), Light::Directional { travel: at(-0.6, -1.0) }] {
        let exposure = Exposure::half_angle(light, &camera.see(&[floor()])).unwrap();
        let hits = fine.see(&[floor()]);
        for pair in hits.windows(2).step_by(100_000) {
            let places = [pair[0].point, pair[1].point].map(|point| exposure.film.coordinate(point).unwrap());
            let rate = exposure.film.rate(pair[0].point, pair[0].step);
            near(rate / (places[1] - places[0]), 1.0, 1.0e-4);
        }
    }
}

/// O10: printed and corrected step of the interpolants.
#[test]
fn interpolants_need_the_step_in_depth() {
    let camera = pitched_camera();
    let scene = scene();
    let film = Film::new(lamp(4.0, -3.0), -60.0_f64.to_radians()).unwrap();
    let hits = camera.see(&scene);
    let exposure = Exposure::tight(film, &hits).unwrap();
    let transfer = Transfer::new(&camera, &film, exposure.hull);
    let half_pixels = f64::from(camera.pixels()) / 2.0;
    let mut on_floor = 0;
    for (hit, sample) in hits.iter().zip(&exposure.samples) {
        let depth = Transfer::cube_depth(&camera, hit.point);
        let slope = Transfer::depth_slope(&camera, &scene[hit.segment]);
        let (place, rate) = transfer.place_and_rate(hit.pixel, depth, slope);
        near(place, sample.place, 1.0e-10);
        near(half_pixels / rate.abs() / sample.badness, 1.0, 1.0e-9);
        if hit.segment == 0 {
            on_floor += 1;
            if on_floor == 41 {
                near(slope, -1.148_644, 1.0e-6);
                near(rate, 0.917_367, 1.0e-6);
                near(transfer.place_and_rate(hit.pixel, depth, 0.0).1, -0.159_191, 1.0e-6);
            }
        }
    }
}

/// Figure 1.4: near surfaces suffer from perspective, grazed ones from projection, far ones have several texels per pixel.
#[test]
fn kinds_of_aliasing_are_told_apart() {
    let footprint = PixelFootprint {
        pixel_size: 0.001,
        camera_depth: 2.0,
        light_depth: 10.0,
        camera_ray: 1.0,
        light_ray: 1.0,
        camera_surface: 0.8,
        light_surface: 0.8,
    };
    near(footprint.exact(), 0.0002, 1.0e-15);
    assert_eq!(footprint.aliasing(0.001), Aliasing::Perspective);
    assert_eq!(footprint.aliasing(0.0001), Aliasing::Minification);
    let grazed = PixelFootprint {
        light_surface: 0.01,
        ..footprint
    };
    assert_eq!(grazed.aliasing(0.001), Aliasing::Projection);
    let far = PixelFootprint {
        camera_depth: 40.0,
        ..footprint
    };
    assert_eq!(far.aliasing(0.001), Aliasing::Minification);
    // Off the axes.
    let aside = PixelFootprint {
        camera_ray: 0.6,
        light_ray: 0.8,
        ..footprint
    };
    near(aside.exact() / aside.approximate(), 0.75, 1.0e-12);
}
