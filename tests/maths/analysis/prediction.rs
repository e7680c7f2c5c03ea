//! Predicted texel ÷ pixel against what matrices of the whole pipeline measure.

use bevy_math::{DMat4, DVec3, UVec2};
use umbrage::maths::{
    analysis::{
        direction::{TiltedWarp, frustum_map},
        overhead::{OverheadRange, OverheadWarp, errors_along_view},
    },
    bounds::Bounds,
    fit::{FitInput, FitOptions, fit_light_view},
    footprint::{texel_footprint, texels_on_pixels},
    split::SplitScheme,
    view::ViewVolume,
    warp::Warp,
};

use crate::support::{bodies, close, fit, huge_scene, light_at, papers_camera};

/// Uniform, `LiSPSM`, `PSM` and four slices of them, with pictures that are not square, maps of another size and guard
/// texels: along the view axis, sun overhead, within the 2 % that are promised (without guard texels far closer).
#[test]
fn overhead_predictions_are_what_is_measured() {
    let (picture, guard) = (UVec2::new(1600, 900), 2);
    let (fov_y, near, far) = (50.0_f64.to_radians(), 0.5, 300.0);
    let aspect = 16.0 / 9.0;
    let view =
        ViewVolume::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, fov_y, aspect, near, far).expect("a camera");
    let camera = DMat4::perspective_rh(fov_y, aspect, near, far);
    let range = OverheadRange::of_view(&view).expect("a range");
    let scene = Bounds::new(DVec3::splat(-500.0), DVec3::splat(500.0));
    let practical = SplitScheme::Practical { lambda: 0.5 };
    for (warp, overhead_warp, splits, count, map_side) in [
        (Warp::Uniform, OverheadWarp::Uniform, &SplitScheme::Logarithmic, 1, 4096),
        (Warp::Lispsm, OverheadWarp::Lispsm, &SplitScheme::Logarithmic, 1, 4096),
        (Warp::Psm, OverheadWarp::Psm, &SplitScheme::Logarithmic, 1, 4096),
        (Warp::Uniform, OverheadWarp::Uniform, &SplitScheme::Logarithmic, 4, 2048),
        (Warp::Lispsm, OverheadWarp::Lispsm, &SplitScheme::Logarithmic, 4, 2048),
        (Warp::Lispsm, OverheadWarp::Lispsm, &practical, 4, 2048),
        (
            Warp::Free { eta: 0.5 },
            OverheadWarp::Strength { eta: 0.5 },
            &practical,
            16,
            512,
        ),
    ] {
        let slices = range.slices(splits, count, overhead_warp);
        for slice in &slices {
            let volume = view.split(slice.range.near(), slice.range.far());
            let (visible, body) = bodies(&volume, &scene, DVec3::NEG_Y);
            let fitted = fit_light_view(&FitInput {
                view: &volume,
                visible: &visible,
                body: &body,
                light_travel: DVec3::NEG_Y,
                warp,
                map_size: UVec2::splat(map_side),
                guard_texels: f64::from(guard),
                guard_metres: 0.0,
                options: FitOptions::default(),
            })
            .fitted()
            .expect("a light view");
            for share in [0.01, 0.2, 0.6, 0.99] {
                let depth = slice.range.near() + share * (slice.range.far() - slice.range.near());
                let point = DVec3::NEG_Z * depth;
                let texel = texel_footprint(&fitted.clip_from_world, UVec2::splat(map_side), point).expect("in front");
                let pixel = texel_footprint(&camera, picture, point).expect("in front");
                // A surface that both beams meet at the same angle: no projection aliasing.
                let measured = texels_on_pixels(&texel, &pixel, DVec3::new(0.0, 1.0, 1.0)).expect("not edge-on");
                let predicted = errors_along_view(&slices, depth).expect("inside");
                let of_map = |texels| predicted.at_resolution(picture, UVec2::splat(texels));
                close(of_map(map_side).across, measured.across, 0.02);
                close(of_map(map_side).along, measured.along, 0.02);
                // Without the free border the rest is rounding.
                close(of_map(map_side - 2 * guard).across, measured.across, 1.0e-5);
                close(of_map(map_side - 2 * guard).along, measured.along, 1.0e-5);
                close(of_map(map_side).largest(), measured.across.max(measured.along), 0.02);
            }
        }
    }
}

/// For light at an angle, and inside the view cone too, the map of the analysis is the map of the pipeline, where the
/// pipeline's guard leaves n' alone.
#[test]
fn tilted_predictions_are_what_is_measured() {
    let view = papers_camera(1.0, 100.0);
    let camera = DMat4::perspective_rh(60.0_f64.to_radians(), 1.0, 1.0, 100.0);
    let size = UVec2::splat(1024);
    for degrees in [50.0, 90.0, 120.0] {
        let light = light_at(degrees);
        let fitted = fit(&view, &huge_scene(), light, Warp::Lispsm);
        let map = frustum_map(&view, light, TiltedWarp::Lispsm).expect("sound");
        close(map.warp_near, fitted.warp_near, 1.0e-6);
        for depth in [1.5, 20.0, 90.0] {
            let point = DVec3::NEG_Z * depth;
            let lengths = texel_footprint(&fitted.clip_from_world, size, point)
                .expect("in front")
                .lengths();
            let pixel = texel_footprint(&camera, size, point).expect("in front").lengths();
            let errors = map.errors(&view, point);
            close(lengths.x / pixel.x, errors.across, 1.0e-4);
            close(lengths.y / pixel.y, errors.along, 1.0e-4);
        }
    }
}
