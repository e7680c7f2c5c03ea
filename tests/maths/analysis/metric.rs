//! The one-directional error metrics against the footprints of matrices.

use bevy_math::{DMat4, DVec3, UVec2};
use umbrage::maths::{
    error::{Beam, accurate_error, error_along, simple_error},
    footprint::{texel_footprint, texels_on_pixels},
};

use crate::support::{OPENING, close};

/// Stingl, equation 2.1, is m_z on a surface across both beams' bisector: with dz ÷ ds of a uniform map and of a warped one.
#[test]
fn the_simple_metric_is_the_error_along() {
    let (near, far) = (1.0, 40.0);
    for warp_near in [f64::INFINITY, 7.3245553, 1.0] {
        for depth in [1.0, 6.0, 40.0] {
            let width = 1.0 + (depth - near) / warp_near;
            let far_width = 1.0 + (far - near) / warp_near;
            let depth_per_map = (far - near) * width * width / far_width;
            // One unit of picture is 2 tan Θ wide at depth 1.
            let simple = simple_error(depth, depth_per_map / OPENING, 0.6, 0.6);
            close(simple, error_along(depth, warp_near, near, far, OPENING), 1.0e-9);
        }
    }
    close(simple_error(2.0, 6.0, 0.9, 0.3), 9.0, 1.0e-12);
}

/// Lloyd's accurate metric (Stingl, equation 2.2) against the Jacobians of a camera's and a spot light's matrices, in a
/// common plane: a surface at a slant, off both axes.
#[test]
fn the_accurate_metric_is_the_footprint() {
    let (picture, map) = (UVec2::splat(800), UVec2::splat(512));
    let camera = DMat4::perspective_rh(1.0, 1.0, 0.5, 100.0);
    let (light_place, light_target) = (DVec3::new(0.0, 9.0, -2.0), DVec3::new(0.0, 0.0, -8.0));
    let light_projection = DMat4::perspective_rh(0.9, 1.0, 2.0, 50.0);
    let light = light_projection * DMat4::look_at_rh(light_place, light_target, DVec3::X);
    // The plane x = 0 holds both eyes, the point and the normal. The light's map x runs along it.
    for (point, normal) in [
        (DVec3::new(0.0, -1.0, -7.0), DVec3::new(0.0, 1.0, 0.3)),
        (DVec3::new(0.0, 0.7, -10.0), DVec3::new(0.0, 0.4, 1.0)),
    ] {
        let normal = normal.normalize();
        let beam = |place: DVec3, axis: DVec3, opening: f64, plane_depth: f64, resolution: f64| {
            let ray = point - place;
            Beam {
                resolution,
                stretch: 1.0,
                plane_width: 2.0 * (opening * 0.5).tan() * plane_depth,
                plane_depth,
                depth: ray.dot(axis),
                plane_cosine: ray.normalize().dot(axis),
                surface_cosine: ray.normalize().dot(normal).abs(),
            }
        };
        let eye_beam = beam(DVec3::ZERO, DVec3::NEG_Z, 1.0, 0.5, 800.0);
        let light_axis = (light_target - light_place).normalize();
        let light_beam = beam(light_place, light_axis, 0.9, 2.0, 512.0);
        let texel = texel_footprint(&light, map, point).expect("in front");
        let pixel = texel_footprint(&camera, picture, point).expect("in front");
        let measured = texels_on_pixels(&texel, &pixel, normal).expect("not edge-on");
        let accurate = accurate_error(&light_beam, &eye_beam);
        close(measured.across, accurate, 1.0e-6);
        close(light_beam.footprint() / eye_beam.footprint(), accurate, 1.0e-12);
    }
    let edge_on = Beam {
        resolution: 1.0,
        stretch: 1.0,
        plane_width: 1.0,
        plane_depth: 1.0,
        depth: 1.0,
        plane_cosine: 1.0,
        surface_cosine: 0.0,
    };
    assert_eq!(edge_on.footprint(), f64::INFINITY);
}
