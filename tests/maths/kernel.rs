//! Kernels of one size in the world (Stingl, section 3.6.1).

use bevy_math::{DMat4, DVec2, DVec3};
use umbrage::maths::{
    fit::LightFit,
    kernel::{kernel_radius, kernel_transform, uniform_kernel_radius},
    split::{SplitScheme, split_depths},
    warp::Warp,
};

use crate::support::{close, fit, huge_scene, light_at, papers_camera};

/// Light views of four slices, and the middle of each slice.
fn slices(warp: Warp) -> Vec<(LightFit, DVec3)> {
    let view = papers_camera(1.0, 500.0);
    let depths = split_depths(&SplitScheme::Practical { lambda: 0.5 }, 1.0, 500.0, 4);
    let slice = |range: &[f64]| {
        let fit = fit(&view.split(range[0], range[1]), &huge_scene(), light_at(60.0), warp);
        (fit, DVec3::new(0.1, -0.2, -1.0) * (range[0] * range[1]).sqrt())
    };
    depths.windows(2).map(slice).collect()
}

/// Texture coordinates of an atlas whose only map this is, v down.
fn uv(fit: &LightFit, point: DVec3) -> DVec2 {
    let ndc = fit.clip_from_world.project_point3(point);
    DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y)
}

/// Extent of an unwarped map in metres.
fn extent(fit: &LightFit) -> DVec2 {
    DVec2::new(2.0 / fit.clip_from_light.x_axis.x, 2.0 / fit.clip_from_light.y_axis.y)
}

/// Stingl, oracle 23: s_i (max − min)_i ÷ l_sc is the same for all partitions; l_sc is ½, ⅓ and ¼ for atlases of 2, 3 and 4
/// cells per side.
#[test]
fn unwarped_kernels_have_one_size_in_the_world() {
    for cells in [1.0, 2.0, 3.0, 4.0] {
        let cell_share = DVec2::splat(1.0 / cells);
        for (fit, _) in slices(Warp::Uniform) {
            let extent = extent(&fit);
            let radius = uniform_kernel_radius(0.25, extent, cell_share);
            let in_world = radius * extent / cell_share;
            close(in_world.x, 0.25, 1.0e-12);
            close(in_world.y, 0.25, 1.0e-12);
        }
    }
    assert!(!uniform_kernel_radius(1.0, DVec2::ZERO, DVec2::ONE).is_finite());
}

/// The local kernel is Stingl's where nothing is warped.
#[test]
fn local_kernels_agree_with_uniform_ones() {
    let cell_share = DVec2::new(0.5, 0.25);
    for (fit, point) in slices(Warp::Uniform) {
        let expected = uniform_kernel_radius(0.3, extent(&fit), cell_share);
        let found = kernel_radius(&fit.clip_from_world, cell_share, point, 0.3).unwrap();
        close(found.x, expected.x, 1.0e-9);
        close(found.y, expected.y, 1.0e-9);
    }
}

/// A step in the light plane moves the texture coordinates as far as the matrices of the map say; in a warped map, where
/// Stingl's rule is wrong by far, too.
#[test]
fn local_kernels_follow_the_warp() {
    let mut widest = 1.0_f64;
    for warp in [Warp::Lispsm, Warp::Psm, Warp::Free { eta: -0.4 }] {
        for (fit, point) in slices(warp) {
            let plane = [fit.axes.x, fit.axes.y];
            let kernel = kernel_transform(&fit.clip_from_world, DVec2::ONE, point, plane).unwrap();
            let step = 1.0e-5;
            for (axis, column) in plane.into_iter().zip([kernel.x_axis, kernel.y_axis]) {
                let difference = (uv(&fit, point + axis * step) - uv(&fit, point - axis * step)) / (2.0 * step);
                assert!(
                    difference.distance(column) <= 1.0e-4 * column.length(),
                    "{difference} is not {column}"
                );
            }
            // The box around the ellipse, by walking round it.
            let radius = 0.2;
            let box_of = kernel_radius(&fit.clip_from_world, DVec2::ONE, point, radius).unwrap();
            let reach = (0..3600).map(|step| {
                let (sin, cos) = (f64::from(step) * 0.1).to_radians().sin_cos();
                (kernel * DVec2::new(cos, sin) * radius).abs()
            });
            let reach = reach.fold(DVec2::ZERO, DVec2::max);
            close(box_of.x, reach.x, 1.0e-5);
            close(box_of.y, reach.y, 1.0e-5);
            let far = point * 1.5;
            let far_kernel = kernel_radius(&fit.clip_from_world, DVec2::ONE, far, radius).unwrap();
            widest = widest.max(box_of.y / far_kernel.y);
        }
    }
    assert!(widest > 1.5, "the warp bends nothing: {widest}");
}

#[test]
fn kernels_without_answer() {
    let plane = [DVec3::X, DVec3::Y];
    let behind = DMat4::from_diagonal(DVec3::ONE.extend(-1.0));
    for matrix in [
        behind,
        DMat4::ZERO,
        DMat4::from_diagonal(DVec3::splat(f64::NAN).extend(1.0)),
    ] {
        assert_eq!(kernel_transform(&matrix, DVec2::ONE, DVec3::ZERO, plane), None);
        assert_eq!(kernel_radius(&matrix, DVec2::ONE, DVec3::ZERO, 1.0), None);
    }
    let flat = DMat4::from_diagonal(DVec3::new(0.0, 1.0, 1.0).extend(1.0));
    assert_eq!(kernel_transform(&flat, DVec2::ONE, DVec3::ZERO, plane), None);
}
