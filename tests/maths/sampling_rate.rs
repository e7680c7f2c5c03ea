//! Texels per pixel and their colors.

use bevy_math::{DMat4, DVec2, DVec3, UVec2, Vec3};
use umbrage::maths::{
    error::{AxisErrors, error_across, error_along},
    footprint::{texel_footprint, texels_on_pixels},
    sampling_rate::{RATE_KNOTS, RateMeasure, TexelsPerPixel, rate_color},
    warp::Warp,
};

use crate::support::{OPENING, close, fit, huge_scene, papers_camera};

const MAP: UVec2 = UVec2::new(2048, 512);

fn rates(light: &DMat4, camera: &DMat4, picture: UVec2, point: DVec3, normal: DVec3) -> TexelsPerPixel {
    let texel = texel_footprint(light, MAP, point).expect("in front of the light");
    let pixel = texel_footprint(camera, picture, point).expect("in front of the viewer");
    texels_on_pixels(&texel, &pixel, normal)
        .expect("not edge-on")
        .per_pixel()
}

/// The listing word by word: central differences of texel coordinates over the picture, by the ray of a pixel to the surface
/// and on into the map. Off both axes, on tilted surfaces, where texels are sheared and turned in the picture.
#[test]
fn rates_are_those_of_the_listing() {
    let light = fit(
        &papers_camera(1.0, 100.0),
        &huge_scene(),
        DVec3::new(0.3, -1.0, 0.4),
        Warp::Lispsm,
    );
    let camera = DMat4::perspective_rh(60.0_f64.to_radians(), 1.6, 1.0, 100.0);
    let picture = UVec2::new(1600, 1000);
    let point = DVec3::new(2.0, -1.5, -12.0);
    for normal in [DVec3::Y, DVec3::new(0.4, 0.8, -0.3).normalize()] {
        let world_from_clip = camera.inverse();
        let texel = |pixel: DVec2| {
            let ndc = pixel / picture.as_dvec2() * 2.0;
            let direction = world_from_clip.project_point3(ndc.extend(0.5));
            let on_surface = direction * (point.dot(normal) / direction.dot(normal));
            light.clip_from_world.project_point3(on_surface).truncate() * MAP.as_dvec2() * 0.5
        };
        let here = camera.project_point3(point).truncate() * picture.as_dvec2() * 0.5;
        let step = 1.0e-3;
        let difference = |axis: DVec2| (texel(here + axis * step) - texel(here - axis * step)) / (2.0 * step);
        let (dsdx, dsdy) = (difference(DVec2::X), difference(DVec2::Y));
        assert!(
            dsdx.dot(dsdy).abs() > 0.02 * dsdx.length() * dsdy.length(),
            "a case in which rows and columns differ: {dsdx}, {dsdy}"
        );

        let found = rates(&light.clip_from_world, &camera, picture, point, normal);
        close(
            found.get(RateMeasure::Area),
            (dsdx.x * dsdy.y - dsdy.x * dsdx.y).abs(),
            1.0e-5,
        );
        close(found.get(RateMeasure::Across), dsdx.x.hypot(dsdy.x), 1.0e-5);
        close(found.get(RateMeasure::Along), dsdx.y.hypot(dsdy.y), 1.0e-5);
    }
}

/// Sun overhead, on the view axis: 1 ÷ m_x, 1 ÷ m_z and 1 ÷ (m_x m_z) on a surface across the bisector of both beams; on
/// surfaces that are tilted otherwise about the map's x axis, cos θ_l ÷ cos θ_i as much along it.
#[test]
fn rates_are_one_over_the_errors() {
    let (near, far) = (1.0, 40.0);
    let view = papers_camera(near, far);
    let camera = DMat4::perspective_rh(60.0_f64.to_radians(), 1.0, near, far);
    let picture = UVec2::splat(800);
    for warp in [Warp::Uniform, Warp::Lispsm, Warp::Psm] {
        let light = fit(&view, &huge_scene(), DVec3::NEG_Y, warp);
        for depth in [1.5, 6.3, 39.0] {
            let errors = AxisErrors {
                across: error_across(depth, light.warp_near, near, far),
                along: error_along(depth, light.warp_near, near, far, OPENING),
            }
            .at_resolution(picture, MAP);
            for degrees in [20.0_f64, 45.0, 80.0] {
                // cos θ_l = n · y, cos θ_i = n · z.
                let (sine, cosine) = degrees.to_radians().sin_cos();
                let normal = DVec3::new(0.0, cosine, sine);
                let found = rates(&light.clip_from_world, &camera, picture, DVec3::NEG_Z * depth, normal);
                let projection = cosine / sine;
                close(found.across, 1.0 / errors.across, 1.0e-6);
                close(found.along, projection / errors.along, 1.0e-6);
                close(found.area, projection / (errors.across * errors.along), 1.0e-6);
            }
        }
    }
}

/// Off the view axis, LiSPSM's texels are sheared: across is one over the distance of their borders, not over their side.
#[test]
fn sheared_texels_are_measured_between_their_borders() {
    let light = fit(&papers_camera(1.0, 40.0), &huge_scene(), DVec3::NEG_Y, Warp::Lispsm);
    let camera = DMat4::perspective_rh(60.0_f64.to_radians(), 1.0, 1.0, 40.0);
    let point = DVec3::new(2.5, 0.0, -6.0);
    let texel = texel_footprint(&light.clip_from_world, MAP, point).expect("in front");
    let pixel = texel_footprint(&camera, UVec2::splat(800), point).expect("in front");
    let on_pixels = texels_on_pixels(&texel, &pixel, DVec3::new(0.0, 1.0, 1.0)).expect("not edge-on");
    let found = on_pixels.per_pixel();
    close(found.area, 1.0 / on_pixels.area, 1.0e-12);
    assert!(
        found.across * on_pixels.across > 1.01,
        "{found:?}: no shear in {on_pixels:?}"
    );
    assert!(found.across * found.along > found.area * 1.01, "{found:?}");
}

fn assert_color(texels_per_pixel: f32, wanted: [f32; 3]) {
    let color = rate_color(texels_per_pixel);
    assert!(
        (color - Vec3::from_array(wanted)).abs().max_element() < 1.0e-5,
        "{texels_per_pixel}: {color}, not {wanted:?}"
    );
}

/// Stingl, oracle 21, and the other knots.
#[test]
fn knots_have_the_published_colors() {
    for (texels_per_pixel, wanted) in [
        (0.0, [0.2, 0.0, 0.0]),
        (1.0 / 7.75, [1.0, 0.2, 0.0]),
        (1.0 / 3.25, [1.0, 1.0, 0.0]),
        (1.0, [0.0, 1.0, 0.0]),
        (3.25, [0.3, 0.8, 1.0]),
        (7.75, [0.0, 0.0, 1.0]),
        (10.0, [0.0, 0.0, 0.4]),
    ] {
        assert_color(texels_per_pixel, wanted);
    }
    for beyond in [10.001, 40.0, 1.0e9, f32::INFINITY] {
        assert_color(beyond, [0.0, 0.0, 0.4]);
    }
    for nothing in [-1.0, f32::NEG_INFINITY, f32::NAN] {
        assert_color(nothing, [0.2, 0.0, 0.0]);
    }
}

#[test]
fn colors_are_straight_lines_between_knots() {
    for (texels_per_pixel, wanted) in [
        (0.064_516_13, [0.6, 0.1, 0.0]),
        (0.218_362_28, [1.0, 0.6, 0.0]),
        (0.653_846_15, [0.5, 1.0, 0.0]),
        (2.125, [0.15, 0.9, 0.5]),
        (5.5, [0.15, 0.4, 1.0]),
        (8.875, [0.0, 0.0, 0.7]),
    ] {
        assert_color(texels_per_pixel, wanted);
    }
    // A quarter of the way in every interval: no curve that meets the lines in the middle.
    for pair in RATE_KNOTS.windows(2) {
        let ((start, first), (end, last)) = (pair[0], pair[1]);
        assert_color(start * 0.75 + end * 0.25, (first * 0.75 + last * 0.25).to_array());
    }
}
