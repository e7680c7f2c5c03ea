//! Cameras, lights and scenes that several tests use.

use bevy_math::{DVec2, DVec3, UVec2};
use umbrage::maths::{
    body::{intersection_body, light_visible},
    bounds::Bounds,
    error::LightSample,
    fit::{FitInput, FitOptions, LightAxes, LightFit, fit_light_view},
    footprint::texel_footprint,
    polytope::Polytope,
    view::ViewVolume,
    warp::{Warp, WarpSpan},
};

/// 2 tan Θ for Θ = 30°, the papers' camera.
pub(crate) const OPENING: f64 = 1.154_700_538_379_251_7;

/// The papers' camera: full field of view 60°, square, at the origin, looking along −z.
pub(crate) fn papers_camera(near: f64, far: f64) -> ViewVolume {
    ViewVolume::perspective(
        DVec3::ZERO,
        DVec3::NEG_Z,
        DVec3::Y,
        60.0_f64.to_radians(),
        1.0,
        near,
        far,
    )
    .expect("a proper camera")
}

/// A light that travels at `degrees` to the view direction −z: 0 from behind the viewer, 90 from above.
pub(crate) fn light_at(degrees: f64) -> DVec3 {
    let angle = degrees.to_radians();
    DVec3::new(0.0, -angle.sin(), -angle.cos())
}

/// Corners of the view frustum as samples, the span, and the sine, for a light at an angle to the view.
pub(crate) fn frustum_samples(view: &ViewVolume, degrees: f64) -> (Vec<LightSample>, WarpSpan) {
    let axes = LightAxes::new(view.forward(), view.up(), light_at(degrees)).expect("a light");
    let samples: Vec<LightSample> = view
        .corners(view.near(), view.far())
        .iter()
        .map(|corner| LightSample {
            across: axes.x.dot(*corner),
            along: axes.y.dot(*corner),
            depth: view.depth(*corner),
        })
        .collect();
    let along = || samples.iter().map(|sample| sample.along);
    let extent = along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min);
    let span = WarpSpan::directional(extent, view.near(), view.forward().dot(axes.y));
    (samples, span)
}

/// A scene that contains every view frustum of the tests.
pub(crate) fn huge_scene() -> Bounds {
    Bounds::new(DVec3::splat(-1.0e5), DVec3::splat(1.0e5))
}

/// Contains every view frustum of most tests; small enough that no near plane counts as flat beside it.
pub(crate) fn roomy_scene() -> Bounds {
    Bounds::new(DVec3::splat(-1000.0), DVec3::splat(1000.0))
}

/// H and B of a camera in a scene.
pub(crate) fn bodies(view: &ViewVolume, scene: &Bounds, light_travel: DVec3) -> (Polytope, Polytope) {
    let visible = light_visible(view, scene);
    let body = intersection_body(&visible, scene, light_travel);
    (visible, body)
}

/// The light view of the whole camera range, without guard texels.
pub(crate) fn fit(view: &ViewVolume, scene: &Bounds, light_travel: DVec3, warp: Warp) -> LightFit {
    fit_with(view, scene, light_travel, warp, FitOptions::default())
}

/// The same with options.
pub(crate) fn fit_with(
    view: &ViewVolume,
    scene: &Bounds,
    light_travel: DVec3,
    warp: Warp,
    options: FitOptions,
) -> LightFit {
    let (visible, body) = bodies(view, scene, light_travel);
    fit_light_view(&FitInput {
        view,
        visible: &visible,
        body: &body,
        light_travel,
        warp,
        map_size: UVec2::splat(1024),
        guard_texels: 0.0,
        guard_metres: 0.0,
        options,
    })
    .fitted()
    .expect("a proper camera, scene and light")
}

/// m_x and m_z at a point of the papers' camera: the sides of a texel through the matrix over that of a pixel, resolutions
/// equal. Beside the axis texels are sheared; the papers count their extent along it.
pub(crate) fn errors(fit: &LightFit, view: &ViewVolume, point: DVec3) -> DVec2 {
    let footprint = texel_footprint(&fit.clip_from_world, UVec2::splat(1024), point).expect("in front");
    let sides = DVec2::new(footprint.across.length(), footprint.along.dot(fit.axes.y));
    sides / (OPENING * view.depth(point) / 1024.0)
}

/// Asserts equality to a relative tolerance.
#[track_caller]
pub(crate) fn close(actual: f64, expected: f64, relative: f64) {
    assert!(
        (actual - expected).abs() <= relative * expected.abs().max(1.0e-12),
        "{actual} is not {expected} to a relative {relative}"
    );
}
