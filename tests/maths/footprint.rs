//! Footprints: the matrix pipeline against the error formulas.

use bevy_math::{DMat4, DVec2, DVec3, UVec2};
use umbrage::maths::{
    error::{error_across, error_along},
    footprint::{texel_footprint, texels_on_pixels},
    warp::Warp,
};

use crate::support::{OPENING, close, fit, huge_scene, papers_camera};

const SIZE: UVec2 = UVec2::splat(1024);

/// Stingl, oracle 9: texel footprints along the view vector through the whole pipeline equal m_x and m_z.
#[test]
fn the_pipeline_has_the_published_errors() {
    let (near, far) = (1.0, 40.0);
    let view = papers_camera(near, far);
    for warp in [
        Warp::Uniform,
        Warp::Lispsm,
        Warp::Psm,
        Warp::Free { eta: -0.5 },
        Warp::Free { eta: 0.5 },
    ] {
        let fit = fit(&view, &huge_scene(), DVec3::NEG_Y, warp);
        for depth in [1.0, 2.0, 6.3, 20.0, 39.0] {
            let point = DVec3::NEG_Z * depth;
            let lengths = texel_footprint(&fit.clip_from_world, SIZE, point)
                .expect("in front")
                .lengths();
            let pixel = OPENING * depth / 1024.0;
            close(lengths.x / pixel, error_across(depth, fit.warp_near, near, far), 1.0e-6);
            close(
                lengths.y / pixel,
                error_along(depth, fit.warp_near, near, far, OPENING),
                1.0e-6,
            );
        }
    }
    let fit = fit(&view, &huge_scene(), DVec3::NEG_Y, Warp::Lispsm);
    for (depth, across, along) in [(2.0, 3.5940, 3.4490), (20.0, 1.1365, 3.4490)] {
        let footprint = texel_footprint(&fit.clip_from_world, SIZE, DVec3::NEG_Z * depth).expect("in front");
        let errors = footprint.lengths() / (OPENING * depth / 1024.0);
        close(errors.x, across, 1.0e-4);
        close(errors.y, along, 1.0e-4);
    }
}

#[test]
fn footprints_step_by_one_texel_in_the_light_plane() {
    let light = DVec3::new(0.5, -1.0, 0.2);
    let fit = fit(&papers_camera(1.0, 100.0), &huge_scene(), light, Warp::Lispsm);
    let point = DVec3::new(4.0, -3.0, -30.0);
    let footprint = texel_footprint(&fit.clip_from_world, SIZE, point).expect("in front");
    close(footprint.ray.dot(light.normalize()).abs(), 1.0, 1.0e-9);
    let texel = |point| fit.clip_from_world.project_point3(point).truncate() * 512.0;
    let step = 1.0e-3;
    let across = (texel(point + footprint.across * step) - texel(point)) / step;
    let along = (texel(point + footprint.along * step) - texel(point)) / step;
    assert!(across.distance(DVec2::X) < 1.0e-3, "{across}");
    assert!(along.distance(DVec2::Y) < 1.0e-3, "{along}");
    close(
        footprint.area(),
        footprint.across.cross(footprint.along).length(),
        1.0e-12,
    );
}

#[test]
fn the_mean_texel_size_is_the_footprint_in_the_middle() {
    let view = papers_camera(1.0, 100.0);
    let fit = fit(&view, &huge_scene(), DVec3::NEG_Y, Warp::Uniform);
    let footprint = texel_footprint(&fit.clip_from_world, SIZE, DVec3::NEG_Z * 50.0).expect("in front");
    close(fit.texel_size, footprint.area().sqrt(), 1.0e-6);
    close(fit.near_texel_size, footprint.lengths().max_element(), 1.0e-6);
    close(fit.relative_texel_size, footprint.lengths().max_element(), 1.0e-6);
}

/// Lloyd, equation 1: the error on a surface is perspective times projection.
#[test]
fn errors_on_surfaces_factor() {
    let view = papers_camera(1.0, 100.0);
    let light = fit(&view, &huge_scene(), DVec3::new(0.3, -1.0, 0.4), Warp::Lispsm);
    let camera = DMat4::perspective_rh(60.0_f64.to_radians(), 1.0, 1.0, 100.0);
    let point = DVec3::new(2.0, -1.5, -12.0);
    let texel = texel_footprint(&light.clip_from_world, SIZE, point).expect("in front");
    let pixel = texel_footprint(&camera, SIZE, point).expect("in front");
    for normal in [DVec3::Y, DVec3::new(0.2, 0.9, -0.3), DVec3::new(1.0, 1.0, 1.0)] {
        let error = texels_on_pixels(&texel, &pixel, normal).expect("not edge-on");
        close(error.area, error.perspective * error.projection, 1.0e-9);
        assert!(
            error.largest >= error.across.max(error.along) * (1.0 - 1.0e-12),
            "{error:?}"
        );
        assert!(error.largest * error.largest >= error.area, "{error:?}");
    }
    let edge_on = texel.ray.any_orthonormal_vector();
    assert!(texels_on_pixels(&texel, &pixel, edge_on).is_none_or(|error| error.area > 1.0e9));
    assert_eq!(texels_on_pixels(&texel, &pixel, DVec3::ZERO), None);
}

#[test]
fn a_surface_halfway_between_light_and_viewer_has_no_projection_error() {
    let view = papers_camera(1.0, 100.0);
    let light = fit(&view, &huge_scene(), DVec3::NEG_Y, Warp::Uniform);
    let camera = DMat4::perspective_rh(60.0_f64.to_radians(), 1.0, 1.0, 100.0);
    let point = DVec3::NEG_Z * 10.0;
    let texel = texel_footprint(&light.clip_from_world, SIZE, point).expect("in front");
    let pixel = texel_footprint(&camera, SIZE, point).expect("in front");
    let error = texels_on_pixels(&texel, &pixel, DVec3::new(0.0, 1.0, 1.0)).expect("not edge-on");
    close(error.projection, 1.0, 1.0e-9);
    close(error.across, error_across(10.0, f64::INFINITY, 1.0, 100.0), 1.0e-6);
    close(
        error.along,
        error_along(10.0, f64::INFINITY, 1.0, 100.0, OPENING),
        1.0e-6,
    );
}

#[test]
fn points_without_a_footprint() {
    let light = fit(&papers_camera(1.0, 100.0), &huge_scene(), DVec3::NEG_Y, Warp::Lispsm);
    assert_eq!(texel_footprint(&light.clip_from_world, SIZE, DVec3::Z * 50.0), None);
    assert_eq!(texel_footprint(&light.clip_from_world, SIZE, DVec3::NAN), None);
    assert_eq!(texel_footprint(&DMat4::ZERO, SIZE, DVec3::ZERO), None);
    assert_eq!(texel_footprint(&DMat4::IDENTITY, UVec2::ZERO, DVec3::ZERO), None);
}

/// The Jacobian from the map to the picture over a tilted surface, by moving a point in the map and watching it in the
/// picture: central differences through the inverse light matrix, no footprint involved.
#[test]
fn texels_in_the_picture_are_finite_differences() {
    let view = papers_camera(1.0, 100.0);
    let light = fit(&view, &huge_scene(), DVec3::new(0.3, -1.0, 0.4), Warp::Lispsm);
    let camera = DMat4::perspective_rh(60.0_f64.to_radians(), 1.6, 1.0, 100.0);
    let (map_size, picture_size) = (UVec2::new(2048, 512), UVec2::new(1600, 1000));
    let point = DVec3::new(2.0, -1.5, -12.0);
    for normal in [DVec3::Y, DVec3::new(0.4, 0.8, -0.3).normalize()] {
        // Where the ray of a texel meets the surface: two points of the ray, then the plane.
        let world_from_clip = light.clip_from_world.inverse();
        let on_surface = |texel: DVec2| {
            let ndc = texel / map_size.as_dvec2() * 2.0;
            let [start, end] = [0.2, 0.8].map(|depth| world_from_clip.project_point3(ndc.extend(depth)));
            let share = (point - start).dot(normal) / (end - start).dot(normal);
            start + (end - start) * share
        };
        let pixel = |texel: DVec2| camera.project_point3(on_surface(texel)).truncate() * picture_size.as_dvec2() * 0.5;
        let here = light.clip_from_world.project_point3(point).truncate() * map_size.as_dvec2() * 0.5;
        assert!(on_surface(here).distance(point) < 1.0e-6, "{}", on_surface(here));
        let step = 1.0e-3;
        let difference = |axis: DVec2| (pixel(here + axis * step) - pixel(here - axis * step)) / (2.0 * step);
        let (across, along) = (difference(DVec2::X), difference(DVec2::Y));

        let texel = texel_footprint(&light.clip_from_world, map_size, point).expect("in front");
        let footprint = texel_footprint(&camera, picture_size, point).expect("in front");
        let ratio = texels_on_pixels(&texel, &footprint, normal).expect("not edge-on");
        close(ratio.across, across.length(), 1.0e-5);
        close(ratio.along, along.length(), 1.0e-5);
        close(ratio.area, across.perp_dot(along).abs(), 1.0e-5);
        // The longest extent over all directions of the map, by trying them.
        let longest = (0..36_000)
            .map(|i| DVec2::from_angle(f64::from(i) * 1.0e-4))
            .map(|turn| (across * turn.x + along * turn.y).length())
            .fold(0.0, f64::max);
        close(ratio.largest, longest, 1.0e-5);

        let [step_across, step_along] = texel.on_plane(normal);
        let world = |axis: DVec2| (on_surface(here + axis * step) - on_surface(here - axis * step)) / (2.0 * step);
        assert!(step_across.distance(world(DVec2::X)) < 1.0e-5 * step_across.length());
        assert!(step_along.distance(world(DVec2::Y)) < 1.0e-5 * step_along.length());
    }
}
