//! Warp axes: along the view, towards the middle of the body, given.

use bevy_math::{DVec2, DVec3, UVec2};
use umbrage::maths::{
    body::{intersection_body, light_visible},
    bounds::Bounds,
    fit::{FitInput, FitOptions, LightAxes, LightFit, WarpAxis, fit_light_view},
    polytope::{HalfSpace, Polytope},
    view::ViewVolume,
    warp::{Warp, WarpSpan},
};

use crate::support::{OPENING, close, errors, fit_with, light_at, papers_camera, roomy_scene};

/// Scherzer, oracles 1, 2 and 5; equations 2 and 3.
#[test]
fn the_warp_axis_and_the_projection_center() {
    for (forward, light) in [
        (DVec3::new(0.3, -0.2, -1.0), DVec3::new(0.5, -2.0, 0.1)),
        (DVec3::new(-1.0, 0.4, 0.2), DVec3::new(-0.5, -0.4, 0.9)),
    ] {
        let (forward, light) = (forward.normalize(), light.normalize());
        let axis = |light| LightAxes::new(forward, DVec3::Y, light).expect("a light").y;
        let vector = light.cross(forward).cross(light).normalize();
        assert!(axis(light).distance(vector) < 1.0e-12, "equation 3");
        assert!(
            axis(-light).distance(vector) < 1.0e-12,
            "the sign of the light does not matter"
        );
        assert!(axis(light).dot(light).abs() < 1.0e-12, "across the light");
        close(axis(light).dot(forward), forward.cross(light).length(), 1.0e-12);
    }
    let view = papers_camera(1.0, 100.0);
    let fit = fit_with(&view, &roomy_scene(), DVec3::NEG_Y, Warp::Lispsm, FitOptions::default());
    let center = fit.world_from_light.w_axis.truncate() - fit.axes.y * fit.warp_near;
    assert!(
        center.distance(view.eye() - fit.axes.y * (fit.warp_near - 1.0)) < 1.0e-4,
        "equation 2: {center}"
    );
    // Tilted light: still n_opt before the near end of B, in the plane of light and view; along the light it is beside the
    // view axis at the nearest depth, n cos γ from the eye's height that the paper takes.
    for degrees in [40.0_f64, 60.0, 140.0] {
        let light = light_at(degrees);
        let options = FitOptions {
            guard: false,
            ..FitOptions::default()
        };
        let fit = fit_with(&view, &roomy_scene(), light, Warp::Lispsm, options);
        let center = fit.world_from_light.w_axis.truncate() - fit.axes.y * fit.warp_near - view.eye();
        assert!(center.dot(fit.axes.x).abs() < 1.0e-9, "{degrees}°: {center}");
        let start = view.corners(1.0, 100.0).map(|corner| fit.axes.y.dot(corner));
        let start = start.into_iter().fold(f64::INFINITY, f64::min);
        close(center.dot(fit.axes.y), start - fit.warp_near, 1.0e-9);
        close(center.dot(-fit.axes.z), degrees.to_radians().cos(), 1.0e-9);
    }
}

/// Scherzer, section 3.4 and oracle 13: the middle vector.
#[test]
fn the_middle_of_the_body() {
    let view = papers_camera(1.0, 100.0);
    let light_travel = DVec3::NEG_Y;
    let with = |body: &Polytope, axis| {
        let options = FitOptions {
            axis,
            ..FitOptions::default()
        };
        let input = FitInput {
            view: &view,
            visible: body,
            body,
            light_travel,
            warp: Warp::Lispsm,
            map_size: UVec2::splat(1024),
            guard_texels: 0.0,
            guard_metres: 0.0,
            options,
        };
        fit_light_view(&input).fitted().expect("a light view")
    };
    let beside = Polytope::from_box(DVec3::new(10.0, 0.0, -50.0), DVec3::new(30.0, 5.0, -20.0));
    let fit = with(&beside, WarpAxis::Middle);
    assert!(
        fit.axes.y.distance(DVec3::new(0.49614, 0.0, -0.86824)) < 1.0e-5,
        "{}",
        fit.axes.y
    );
    assert!(with(&beside, WarpAxis::View).axes.y.distance(DVec3::NEG_Z) < 1.0e-12);
    // The projection centre lies on the line through the eye; view depth changes by v · y per metre.
    let origin = fit.world_from_light.w_axis.truncate();
    assert!(fit.axes.x.dot(origin).abs() < 1.0e-9, "{origin}");
    let extent = 30.0 * 0.86824 + 20.0 * 0.49614;
    close(
        fit.warp_near,
        WarpSpan::directional(extent, 20.0, 0.86824).optimal_warp_near(),
        1.0e-4,
    );

    let symmetric = Polytope::from_box(DVec3::new(-20.0, -3.0, -50.0), DVec3::new(20.0, 5.0, -2.0));
    assert!(with(&symmetric, WarpAxis::Middle).axes.y.distance(DVec3::NEG_Z) < 1.0e-12);
    let overhead = Polytope::from_box(DVec3::new(-2.0, -9.0, -2.0), DVec3::new(2.0, -5.0, 2.0));
    assert!(
        with(&overhead, WarpAxis::Middle).axes.y.distance(DVec3::NEG_Z) < 1.0e-12,
        "parallel to the light"
    );
    let around = Polytope::from_box(DVec3::splat(-5.0), DVec3::splat(5.0));
    assert!(
        with(&around, WarpAxis::Middle).axes.y.distance(DVec3::NEG_Z) < 1.0e-12,
        "no direction"
    );
    let behind = Polytope::from_box(DVec3::new(-5.0, -2.0, 10.0), DVec3::new(5.0, 2.0, 30.0));
    assert_eq!(
        with(&behind, WarpAxis::Middle).eta,
        -1.0,
        "against the view nothing is warped"
    );
    let ground = Polytope::from_box(DVec3::new(0.0, -1.0, -50.0), DVec3::new(40.0, -1.0, -10.0));
    assert!(
        with(&ground, WarpAxis::Middle).axes.y.x > 0.4,
        "flat bodies have a middle"
    );
}

/// The middle moves steadily although clipping adds and drops vertices; the paper's sum of vertices would jump.
#[test]
fn the_middle_moves_steadily() {
    let scene = Bounds::new(DVec3::new(-80.0, 0.0, -80.0), DVec3::new(80.0, 20.0, 80.0));
    let light = DVec3::new(0.6, -1.0, 0.2);
    let at = |yaw: f64| {
        let forward = DVec3::new(yaw.sin(), -0.1, -yaw.cos());
        let eye = DVec3::new(30.0, 1.7, 40.0);
        let view = ViewVolume::perspective(eye, forward, DVec3::Y, 1.0, 1.5, 0.1, 1000.0).unwrap();
        let visible = light_visible(&view, &scene);
        let body = intersection_body(&visible, &scene, light);
        let sum: DVec3 = body.vertices().iter().map(|vertex| vertex - eye).sum();
        let options = FitOptions {
            axis: WarpAxis::Middle,
            ..FitOptions::default()
        };
        let published = LightAxes::new(sum, forward, light).expect("a light").y;
        (fit_with(&view, &scene, light, Warp::Lispsm, options).axes.y, published)
    };
    let (mut steady, mut published) = (0.0_f64, 0.0_f64);
    for step in 0..600 {
        let (before, after) = (at(f64::from(step) * 0.002), at(f64::from(step + 1) * 0.002));
        steady = steady.max(before.0.distance(after.0));
        published = published.max(before.1.distance(after.1));
    }
    assert!(steady < 0.02, "{steady}");
    assert!(published > 5.0 * steady, "{published} against {steady}");
}

/// Lloyd, sections 5.1 and 5.3: with the light from behind, the column over a side face is a light overhead with Θ = 45°.
#[test]
fn a_side_face() {
    let (near, far): (f64, f64) = (1.0, 100.0);
    let view = papers_camera(near, far);
    let light = DVec3::NEG_Z;
    // The right face's column: |y| <= x.
    let column = [DVec3::new(-1.0, 1.0, 0.0), DVec3::new(-1.0, -1.0, 0.0)]
        .into_iter()
        .fold(light_visible(&view, &roomy_scene()), |body, normal| {
            body.clip(&HalfSpace::through(DVec3::ZERO, normal))
        });
    let beyond_near_face = HalfSpace::through(DVec3::X * near * OPENING * 0.5, DVec3::NEG_X);
    let column = column.clip(&beyond_near_face);
    let body = intersection_body(&column, &roomy_scene(), light);
    let with = |warp, options| {
        let input = FitInput {
            view: &view,
            visible: &column,
            body: &body,
            light_travel: light,
            warp,
            map_size: UVec2::splat(1024),
            guard_texels: 0.0,
            guard_metres: 0.0,
            options,
        };
        fit_light_view(&input).fitted().expect("a light view")
    };
    let of = |warp, axis| {
        with(
            warp,
            FitOptions {
                axis,
                ..FitOptions::default()
            },
        )
    };
    let ratio = far / near;
    let storage = |fit: &LightFit| {
        let face = view.corners(near, far);
        let corners = [face[1], face[2], face[5], face[6]];
        let largest = corners
            .map(|corner| errors(fit, &view, corner))
            .into_iter()
            .fold(DVec2::ZERO, DVec2::max);
        largest.element_product()
    };
    let axis = WarpAxis::Direction(DVec3::new(1.0, 0.0, 0.4));
    for warp in [Warp::Lispsm, Warp::Repar, Warp::Psm] {
        let fit = of(warp, axis);
        assert!(
            fit.axes.y.distance(DVec3::X) < 1.0e-12,
            "projected into the light plane"
        );
        close(storage(&fit), (ratio - 1.0) * 0.5, 1.0e-4);
    }
    let (edge_near, edge_far) = (near * OPENING * 0.5, far * OPENING * 0.5);
    close(
        of(Warp::Lispsm, axis).warp_near,
        edge_near + (edge_near * edge_far).sqrt(),
        1.0e-6,
    );
    close(of(Warp::Psm, axis).warp_near, edge_near, 1.0e-6);
    // Pseudo planes are view depths, on the face proportional to the distance along the axis.
    let options = FitOptions {
        axis,
        pseudo_near: Some(10.0),
        pseudo_far: Some(60.0),
        ..FitOptions::default()
    };
    let levelled = (10.0 * 60.0_f64).sqrt() * OPENING * 0.5;
    close(with(Warp::Lispsm, options).warp_near, edge_near + levelled, 1.0e-6);
    assert!(storage(&of(Warp::Uniform, axis)) > 90.0 * (ratio - 1.0) * 0.5);
    // Against the face, and beside the eye, there is nothing to warp.
    assert_eq!(of(Warp::Lispsm, WarpAxis::Direction(DVec3::NEG_X)).eta, -1.0);
    assert_eq!(of(Warp::Lispsm, WarpAxis::Direction(DVec3::Y)).eta, -1.0);
}
