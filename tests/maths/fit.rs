//! Light views: conventions, coverage, the warp's effect, continuity.

use bevy_math::{DVec2, DVec3, UVec2, Vec4Swizzles};
use umbrage::maths::{
    bounds::Bounds,
    fit::{Fit, FitInput, FitOptions, LightAxes, LightFit, Unfit, fit_light_view},
    footprint::texel_footprint,
    polytope::Polytope,
    view::ViewVolume,
    warp::Warp,
};

use crate::support::{bodies, close, errors, fit, huge_scene, light_at, papers_camera};

fn ndc(fit: &LightFit, point: DVec3) -> DVec3 {
    fit.clip_from_world.project_point3(point)
}

/// Lloyd, section 2.12, converted: his x is mirrored, his depth runs the other way, his w is 11 times ours.
#[test]
fn the_published_matrix() {
    let view = papers_camera(1.0, 100.0);
    let frustum = view.polytope(1.0e9);
    let fit = fit_light_view(&FitInput {
        view: &view,
        visible: &frustum,
        body: &frustum,
        light_travel: DVec3::NEG_Y,
        warp: Warp::Lispsm,
        map_size: UVec2::splat(1024),
        guard_texels: 0.0,
        guard_metres: 0.0,
        options: FitOptions::default(),
    })
    .fitted()
    .expect("a frustum lit from above");
    close(fit.warp_near, 11.0, 1.0e-9);
    for (point, x, y, w) in [
        (DVec3::new(0.0, 0.0, -1.0), 0.0, -1.0, 11.0),
        (DVec3::new(0.0, 0.0, -10.0), 0.0, 0.0, 20.0),
        (DVec3::new(0.0, 0.0, -100.0), 0.0, 1.0, 110.0),
        (DVec3::new(5.0, 0.0, -20.0), 0.317543, 0.407407, 30.0),
        (DVec3::new(57.735, -57.735, -100.0), 1.0, 1.0, 110.0),
    ] {
        let clip = fit.clip_from_world * point.extend(1.0);
        close(clip.w * 11.0, w, 1.0e-6);
        assert!(
            (clip.xy() / clip.w).distance(DVec2::new(x, y)) < 1.0e-5,
            "{point}: {clip}"
        );
    }
    // The frustum is symmetric about its axis, so the axis lies in the middle of the depth range.
    close(ndc(&fit, DVec3::new(0.0, 0.0, -50.0)).z, 0.5, 1.0e-9);
    assert!(
        ndc(&fit, DVec3::new(0.0, -57.735, -100.0)).z < 0.02,
        "far from the light is near 0"
    );
    assert!(
        ndc(&fit, DVec3::new(0.0, 57.735, -100.0)).z > 0.98,
        "near the light is near 1"
    );
}

/// Conventions of the one light space: right-handed, z to the light, y along the view.
#[test]
fn the_axes_of_light_space() {
    let axes = LightAxes::new(DVec3::new(0.3, -0.2, -1.0), DVec3::Y, DVec3::new(0.5, -2.0, 0.1)).expect("a light");
    assert!(
        (axes.x.cross(axes.y) - axes.z).length() < 1.0e-12,
        "right-handed: {axes:?}"
    );
    assert!(
        (axes.z - -DVec3::new(0.5, -2.0, 0.1).normalize()).length() < 1.0e-12,
        "z points to the light"
    );
    assert!(axes.y.dot(DVec3::new(0.3, -0.2, -1.0)) > 0.0, "y follows the view");
    assert!(
        axes.x.dot(DVec3::new(0.3, -0.2, -1.0)).abs() < 1.0e-12,
        "x is across the view"
    );
    assert_eq!(LightAxes::new(DVec3::NEG_Z, DVec3::Y, DVec3::ZERO), None);
    assert_eq!(LightAxes::new(DVec3::NEG_Z, DVec3::Y, DVec3::NAN), None);
}

#[test]
fn the_axes_for_light_along_the_view() {
    for light in [DVec3::NEG_Z, DVec3::Z] {
        let axes = LightAxes::new(DVec3::NEG_Z, DVec3::Y, light).expect("a light");
        assert!(
            axes.y.distance(DVec3::Y) < 1.0e-12,
            "the camera's up direction takes over: {axes:?}"
        );
    }
    // Sweeping the light through the view direction from above turns the axis in no jump.
    let axis = |step: i32| {
        let angle = f64::from(step) * 1.0e-5;
        LightAxes::new(DVec3::NEG_Z, DVec3::Y, DVec3::new(0.3 * angle, -angle, -1.0))
            .expect("a light")
            .y
    };
    for step in 0..5000 {
        assert!(axis(step).distance(axis(step + 1)) < 0.05, "step {step}");
    }
    // All directions at once degenerate.
    let axes = LightAxes::new(DVec3::NEG_Z, DVec3::NEG_Z, DVec3::NEG_Z).expect("a light");
    close(axes.y.length(), 1.0, 1.0e-12);
    close(axes.x.dot(axes.y.cross(axes.z)), 1.0, 1.0e-12);
}

/// Stingl, oracle 16: every vertex is inside and every bound in x and y is attained.
#[test]
fn the_focus_is_tight() {
    let view = papers_camera(1.0, 60.0);
    let scene = Bounds::new(DVec3::new(-30.0, -2.0, -50.0), DVec3::new(40.0, 15.0, 10.0));
    for warp in [Warp::Uniform, Warp::Lispsm, Warp::Psm] {
        let light = light_at(70.0) + DVec3::X * 0.3;
        let (_, body) = bodies(&view, &scene, light);
        let fit = fit(&view, &scene, light, warp);
        let points: Vec<DVec3> = body.vertices().iter().map(|vertex| ndc(&fit, *vertex)).collect();
        let bounds = Bounds::from_points(points);
        assert!(
            (bounds.min.truncate() - -DVec2::ONE).length() < 1.0e-6,
            "{warp:?}: {bounds:?}"
        );
        assert!(
            (bounds.max.truncate() - DVec2::ONE).length() < 1.0e-6,
            "{warp:?}: {bounds:?}"
        );
        assert!(bounds.min.z > 0.0 && bounds.min.z < 0.05, "{warp:?}: {bounds:?}");
        assert!(bounds.max.z < 1.0 && bounds.max.z > 0.95, "{warp:?}: {bounds:?}");
    }
}

/// Focusing on the scene: with the far plane drawn in from 1500 m to 500 m the footprint shrinks to a third.
#[test]
fn a_third_of_the_range_gives_a_third_of_the_texel() {
    let size = |far| fit(&papers_camera(1.0, far), &huge_scene(), DVec3::NEG_Y, Warp::Uniform).texel_size;
    close(
        size(500.0) / size(1500.0),
        ((499.0 * 500.0) / (1499.0 * 1500.0_f64)).sqrt(),
        1.0e-6,
    );
}

/// Stingl, figures 3.4 and 3.5, oracle 16: the standard map up to f = 1500 m against the focused one up to 500 m. Its largest
/// errors fall to a third, and the errors at the far end stay 1 across and K ÷ f along.
#[test]
fn standard_and_focused_maps_have_the_published_errors() {
    let largest = |far: f64, scene: Bounds| {
        let view = papers_camera(1.0, far);
        let fit = fit(&view, &scene, DVec3::NEG_Y, Warp::Uniform);
        let last = far.min(-scene.min.z);
        close(errors(&fit, &view, DVec3::NEG_Z * last).x, 1.0, 1.0e-4);
        errors(&fit, &view, DVec3::NEG_Z)
    };
    let standard = largest(1500.0, huge_scene());
    close(standard.x, 1500.0, 1.0e-4);
    close(standard.y, 1298.2, 1.0e-4);
    // The camera sees as far as before; the scene ends at 500 m.
    let focused = largest(1500.0, Bounds::new(DVec3::splat(-500.0), DVec3::splat(500.0)));
    close(focused.x, 500.0, 1.0e-4);
    close(focused.y, 432.1, 1.0e-3);
    close(focused.y / standard.y, 0.3329, 1.0e-3);
}

#[test]
fn guard_texels_stay_free() {
    let view = papers_camera(1.0, 60.0);
    let (visible, body) = bodies(&view, &huge_scene(), DVec3::new(0.2, -1.0, 0.1));
    let input = FitInput {
        view: &view,
        visible: &visible,
        body: &body,
        light_travel: DVec3::new(0.2, -1.0, 0.1),
        warp: Warp::Lispsm,
        map_size: UVec2::splat(256),
        guard_texels: 3.0,
        guard_metres: 0.0,
        options: FitOptions::default(),
    };
    let fit = fit_light_view(&input).fitted().expect("a proper camera");
    let largest = body
        .vertices()
        .iter()
        .map(|vertex| ndc(&fit, *vertex).truncate().abs().max_element())
        .fold(0.0, f64::max);
    close(largest, 1.0 - 3.0 * 2.0 / 256.0, 1.0e-9);
    let absurd = fit_light_view(&FitInput {
        guard_texels: 1.0e9,
        ..input
    })
    .fitted()
    .expect("clamped");
    assert!(absurd.clip_from_world.is_finite());
}

/// The depth that a warped map stores for level ground under an overhead sun rises by less than a texel per texel along
/// the warp axis, however high the scene is: what bias has to cover does not depend on casters far above.
#[test]
fn a_high_scene_does_not_tilt_depths() {
    let eye = DVec3::Y * 1.7;
    let view = ViewVolume::perspective(eye, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 0.1, 100.0).expect("a proper camera");
    for height in [3.0, 30.0, 300.0] {
        let scene = Bounds::new(DVec3::new(-200.0, 0.0, -200.0), DVec3::new(200.0, height, 200.0));
        let fit = fit(&view, &scene, DVec3::NEG_Y, Warp::Lispsm);
        for ahead in [3.0, 10.0, 60.0] {
            let point = DVec3::NEG_Z * ahead;
            let footprint = texel_footprint(&fit.clip_from_world, UVec2::splat(1024), point).expect("in front");
            let next = point + DVec3::NEG_Z * footprint.along.length();
            let step = ndc(&fit, next).z - ndc(&fit, point).z;
            let metres = step / fit.depth_per_metre_at(point);
            assert!(
                metres.abs() < footprint.lengths().max_element(),
                "{height} m high, {ahead} m ahead: {metres} m per texel of {footprint:?}"
            );
        }
    }
}

#[test]
fn moved_receivers_stay_inside() {
    let view = papers_camera(1.0, 60.0);
    let light_travel = DVec3::new(0.2, -1.0, 0.1);
    let (visible, body) = bodies(&view, &huge_scene(), light_travel);
    let fit = fit_light_view(&FitInput {
        view: &view,
        visible: &visible,
        body: &body,
        light_travel,
        warp: Warp::Lispsm,
        map_size: UVec2::splat(256),
        guard_texels: 0.0,
        guard_metres: 0.7,
        options: FitOptions::default(),
    })
    .fitted()
    .expect("a proper camera");
    for vertex in visible.vertices() {
        for offset in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z] {
            let ndc = ndc(&fit, *vertex + offset * 0.7);
            assert!(ndc.x.abs() <= 1.0 && ndc.y.abs() <= 1.0 && ndc.z > 0.0, "{ndc}");
        }
    }
}

/// Stingl, oracle 20: overhead light and a symmetric frustum give a symmetric map in every split.
#[test]
fn the_projection_center_is_symmetric() {
    let view = papers_camera(1.0, 400.0);
    for (near, far) in [(1.0, 5.0), (5.0, 40.0), (40.0, 400.0)] {
        let fit = fit(&view.split(near, far), &huge_scene(), DVec3::NEG_Y, Warp::Lispsm);
        let [bottom_left, bottom_right, ..] = view.corners(near, far);
        close(ndc(&fit, bottom_right).x, -ndc(&fit, bottom_left).x, 1.0e-6);
        assert!(
            fit.world_from_light.w_axis.x.abs() < 1.0e-9,
            "the origin lies on the projected view axis"
        );
    }
}

/// Small camera motion moves the light view a little: no jump of the projection centre.
#[test]
fn light_views_move_steadily() {
    let scene = Bounds::new(DVec3::new(-80.0, 0.0, -80.0), DVec3::new(80.0, 20.0, 80.0));
    let at = |yaw: f64| {
        let forward = DVec3::new(yaw.sin(), -0.1, -yaw.cos());
        let view = ViewVolume::perspective(DVec3::new(0.0, 1.7, 0.0), forward, DVec3::Y, 1.0, 1.5, 0.1, 1000.0);
        fit(&view.unwrap(), &scene, DVec3::new(0.6, -1.0, 0.2), Warp::Lispsm)
    };
    let point = DVec3::new(0.0, 0.5, -8.0);
    for step in 0..400 {
        let yaw = f64::from(step) * 0.001;
        let (before, after) = (at(yaw), at(yaw + 0.001));
        assert!(ndc(&before, point).distance(ndc(&after, point)) < 0.02, "yaw {yaw}");
        assert!((after.warp_near / before.warp_near - 1.0).abs() < 0.05, "yaw {yaw}");
    }
}

#[test]
fn world_distance_along_the_light_converts_to_depth() {
    let light = DVec3::new(0.4, -1.0, 0.3);
    let fit = fit(&papers_camera(1.0, 100.0), &huge_scene(), light, Warp::Lispsm);
    for point in [DVec3::new(0.0, -1.0, -2.0), DVec3::new(5.0, 3.0, -60.0)] {
        let moved = point - light.normalize() * 0.25;
        let change = ndc(&fit, moved).z - ndc(&fit, point).z;
        close(change, 0.25 * fit.depth_per_metre_at(point), 1.0e-6);
    }
    assert_eq!(fit.depth_per_metre_at(DVec3::Z * 1.0e7), 0.0);
}

#[test]
fn matrices_compose() {
    let fit = fit(
        &papers_camera(1.0, 100.0),
        &huge_scene(),
        DVec3::new(0.4, -1.0, 0.3),
        Warp::Psm,
    );
    let composed = fit.clip_from_light * fit.world_from_light.inverse();
    let point = DVec3::new(3.0, -2.0, -30.0).extend(1.0);
    assert!((composed * point).distance(fit.clip_from_world * point) < 1.0e-9);
    close(fit.world_from_light.determinant(), 1.0, 1.0e-12);
    assert_eq!(fit.clip_from_world_f32().w_axis.w, fit.clip_from_world.w_axis.w as f32);
    assert_eq!(fit.world_from_light_f32().row(3), bevy_math::Vec4::W);
    assert_eq!(fit.clip_from_light_f32().x_axis.w, 0.0);
}

#[test]
fn orthographic_cameras_are_not_warped() {
    let view = ViewVolume::orthographic(
        DVec3::ZERO,
        DVec3::NEG_Z,
        DVec3::Y,
        DVec2::splat(-10.0),
        DVec2::splat(10.0),
        0.0,
        100.0,
    )
    .expect("a proper camera");
    let fit = fit(&view, &huge_scene(), DVec3::NEG_Y, Warp::Psm);
    assert_eq!((fit.warp_near, fit.eta), (f64::INFINITY, -1.0));
}

#[test]
fn flat_scenes_are_padded() {
    let ground = Bounds::new(DVec3::new(-50.0, 0.0, -50.0), DVec3::new(50.0, 0.0, 50.0));
    let view = ViewVolume::perspective(DVec3::Y * 2.0, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 0.1, 500.0).unwrap();
    for light in [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, -0.001, 0.0)] {
        let fit = fit(&view, &ground, light, Warp::Lispsm);
        for point in [DVec3::new(0.0, 0.0, -10.0), DVec3::new(3.0, 0.0, -45.0)] {
            let ndc = ndc(&fit, point);
            assert!(
                ndc.x.abs() <= 1.0 && ndc.y.abs() <= 1.0 && ndc.z > 0.0 && ndc.z < 1.0,
                "{light}: {ndc}"
            );
        }
    }
}

#[test]
fn inputs_without_an_answer_are_named() {
    let view = papers_camera(1.0, 100.0);
    let (visible, body) = bodies(&view, &huge_scene(), DVec3::NEG_Y);
    let empty = Polytope::default();
    let nan = Polytope::from_box(DVec3::NAN, DVec3::NAN);
    let enormous = Polytope::from_box(DVec3::ZERO, DVec3::splat(1.0e20));
    let outcome = |visible, body, light_travel| {
        fit_light_view(&FitInput {
            view: &view,
            visible,
            body,
            light_travel,
            warp: Warp::Lispsm,
            map_size: UVec2::splat(0),
            guard_texels: 1.0,
            guard_metres: 0.0,
            options: FitOptions::default(),
        })
    };
    let down = DVec3::NEG_Y;
    assert_eq!(outcome(&empty, &body, down), Fit::Degenerate(Unfit::NothingVisible));
    assert_eq!(outcome(&visible, &empty, down), Fit::Degenerate(Unfit::NothingVisible));
    assert_eq!(outcome(&nan, &body, down), Fit::Degenerate(Unfit::NotFinite));
    assert_eq!(outcome(&visible, &enormous, down), Fit::Degenerate(Unfit::Enormous));
    assert_eq!(
        outcome(&visible, &body, DVec3::ZERO),
        Fit::Degenerate(Unfit::NoLightDirection)
    );
    assert_eq!(outcome(&visible, &body, DVec3::NAN), Fit::Degenerate(Unfit::NotFinite));
    assert!(
        outcome(&visible, &body, down).fitted().is_some(),
        "a map of no texels is treated as one texel"
    );
}
