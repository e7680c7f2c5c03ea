//! Kernels of one size in the world over the partitions of a view (Stingl, section 3.6.1).

use bevy_math::{DVec2, DVec3, Vec2};
use umbrage::maths::{
    bias::receiver_plane,
    filter::kernel::{Kernel, kernel_per_metre, scaled},
    fit::LightFit,
    split::{SplitScheme, split_depths},
    warp::Warp,
};

use crate::support::{close, fit, huge_scene, light_at, papers_camera};

/// Light views of four slices, and a point in the middle of each slice.
fn slices(warp: Warp) -> Vec<(LightFit, DVec3)> {
    let view = papers_camera(1.0, 500.0);
    let depths = split_depths(&SplitScheme::Practical { lambda: 0.5 }, 1.0, 500.0, 4);
    let slice = |range: &[f64]| {
        let fit = fit(&view.split(range[0], range[1]), &huge_scene(), light_at(60.0), warp);
        (fit, DVec3::new(0.1, -0.2, -1.0) * (range[0] * range[1]).sqrt())
    };
    depths.windows(2).map(slice).collect()
}

/// The kernel of a radius in metres at a point, on a surface that faces the light.
fn kernel(fit: &LightFit, point: DVec3, radius: f64) -> Kernel {
    let to_light = fit.axes.z.as_vec3();
    let matrix = fit.clip_from_world_f32();
    let plane = receiver_plane(matrix, point.as_vec3(), to_light, to_light).expect("in the map");
    scaled(&kernel_per_metre(matrix, &plane, to_light), radius as f32)
}

/// Half the sides of the box around the ellipse.
fn reach(kernel: &Kernel) -> Vec2 {
    Vec2::new(
        Vec2::new(kernel.across.x, kernel.along.x).length(),
        Vec2::new(kernel.across.y, kernel.along.y).length(),
    )
}

/// Texture coordinates of the map, v down.
fn uv(fit: &LightFit, point: DVec3) -> DVec2 {
    let ndc = fit.clip_from_world.project_point3(point);
    DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y)
}

/// Stingl, oracle 23: s_i (max − min)_i ÷ l_sc is the same for all partitions. With l_sc = 1, that of a map on its own,
/// s_i = r_l ÷ (max − min) as a radius.
#[test]
fn unwarped_kernels_have_one_size_over_all_slices() {
    for (fit, point) in slices(Warp::Uniform) {
        let extent = DVec2::new(2.0 / fit.clip_from_light.x_axis.x, 2.0 / fit.clip_from_light.y_axis.y);
        let in_world = reach(&kernel(&fit, point, 0.25)).as_dvec2() * extent;
        close(in_world.x, 0.25, 1.0e-4);
        close(in_world.y, 0.25, 1.0e-4);
    }
}

/// A step in the light plane moves the texture coordinates as far as the matrices of the map say; in a warped map, where
/// Stingl's rule is wrong by far, too.
#[test]
fn local_kernels_follow_the_warp() {
    let mut widest = 1.0_f32;
    for warp in [Warp::Lispsm, Warp::Psm, Warp::Free { eta: -0.4 }] {
        for (fit, point) in slices(warp) {
            let found = reach(&kernel(&fit, point, 1.0)).as_dvec2();
            let step = 1.0e-5;
            let slopes = [fit.axes.x, fit.axes.y]
                .map(|axis| (uv(&fit, point + axis * step) - uv(&fit, point - axis * step)) / (2.0 * step));
            close(found.x, DVec2::new(slopes[0].x, slopes[1].x).length(), 1.0e-3);
            close(found.y, DVec2::new(slopes[0].y, slopes[1].y).length(), 1.0e-3);
            let far = reach(&kernel(&fit, point * 1.5, 1.0));
            widest = widest.max(found.y as f32 / far.y);
        }
    }
    assert!(widest > 1.5, "the warp bends nothing: {widest}");
}
