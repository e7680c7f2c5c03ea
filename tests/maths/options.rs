//! Options of the fit: projection centres, pseudo planes, visible depths, warp axes.

use bevy_math::{DVec3, UVec2};
use umbrage::maths::{
    bounds::Bounds,
    fit::{DepthRange, Fit, FitInput, FitOptions, LightFit, ProjectionCenter, Unfit, WarpAxis, fit_light_view},
    view::ViewVolume,
    warp::{GuardNorm, OptimumRule, Warp, WarpSpan, frustum_extent},
};

use crate::support::{bodies, close, errors, fit_with, light_at, papers_camera, roomy_scene};

const UNGUARDED: FitOptions = FitOptions {
    center: ProjectionCenter::Continuous,
    optimum: OptimumRule::Derived,
    pseudo_near: None,
    pseudo_far: None,
    visible_far: None,
    axis: WarpAxis::View,
    face_start: None,
    guard: false,
    guard_norm: GuardNorm::Storage,
    depths: DepthRange::Bodies,
};

fn warped(far: f64, light: DVec3, options: FitOptions) -> (ViewVolume, LightFit) {
    let view = papers_camera(1.0, far);
    let fit = fit_with(&view, &roomy_scene(), light, Warp::Lispsm, options);
    (view, fit)
}

/// Stingl, oracle 15: n = 1, f = 300, pseudo planes at 31 and 270.
#[test]
fn pseudo_planes() {
    let options = FitOptions {
        pseudo_near: Some(31.0),
        pseudo_far: Some(270.0),
        ..FitOptions::default()
    };
    let (view, fit) = warped(300.0, DVec3::NEG_Y, options);
    close(fit.warp_near, 92.4877, 1.0e-5);
    for (depth, along) in [(31.0, 3.4612), (270.0, 3.4612), (1.0, 61.17), (300.0, 3.6535)] {
        close(errors(&fit, &view, DVec3::NEG_Z * depth).y, along, 1.0e-4);
    }
    let lowest = (31.0_f64 * 270.0).sqrt();
    let least = errors(&fit, &view, DVec3::NEG_Z * lowest).y;
    for depth in [lowest * 0.9, lowest * 1.1] {
        assert!(
            errors(&fit, &view, DVec3::NEG_Z * depth).y > least,
            "the minimum is at √(n_p f_p)"
        );
    }
}

/// Stingl, equation 4.2 as corrected: equal errors at both planes for tilted light too, where d is not z1 − z0. They are
/// measured along the warp axis, from the point of the map's near end that has the depth of e.
#[test]
fn pseudo_planes_under_tilted_light() {
    let options = FitOptions {
        pseudo_near: Some(9.0),
        pseudo_far: Some(60.0),
        ..UNGUARDED
    };
    for angle in [50.0_f64, 70.0, 120.0, 140.0] {
        let (view, fit) = warped(100.0, light_at(angle), options);
        let sine = angle.to_radians().sin();
        let center = view.eye() + view.forward();
        let aside = fit.axes.y.dot(fit.world_from_light.w_axis.truncate() - center);
        let up = -aside * sine / view.forward().dot(fit.axes.z);
        let start = center + fit.axes.y * aside + fit.axes.z * up;
        close(view.depth(start), 1.0, 1.0e-9);
        let along = |depth: f64| errors(&fit, &view, start + fit.axes.y * ((depth - 1.0) / sine)).y;
        close(along(9.0), along(60.0), 1.0e-9);
        assert!(
            along(1.0) > 2.0 * along(9.0),
            "the price in front of the pseudo-near plane"
        );
        close(fit.warp_near, (1.0 + (9.0_f64 * 60.0).sqrt()) / sine, 1.0e-9);
    }
}

/// Stingl, oracle 30 and section 4.2: pseudo planes change the warp, nothing that is covered. Off, they change no bit.
#[test]
fn pseudo_planes_keep_what_is_covered() {
    let view = papers_camera(1.0, 200.0);
    let light = light_at(65.0) + DVec3::X * 0.2;
    let (visible, body) = bodies(&view, &roomy_scene(), light);
    let with = |pseudo_near, pseudo_far, visible_far| {
        let options = FitOptions {
            pseudo_near,
            pseudo_far,
            visible_far,
            ..FitOptions::default()
        };
        fit_with(&view, &roomy_scene(), light, Warp::Lispsm, options)
    };
    let plain = with(None, None, None);
    for (near, far) in [
        (Some(1.0), Some(1.0e9)),
        (Some(-5.0), None),
        (Some(0.5), Some(f64::INFINITY)),
    ] {
        assert_eq!(with(near, far, far), plain, "planes outside of the range are off");
    }
    for (near, far, seen) in [
        (Some(30.0), None, None),
        (None, Some(60.0), None),
        (Some(20.0), Some(40.0), None),
        (None, None, Some(70.0)),
        (Some(90.0), Some(10.0), None),
        (Some(1.0e9), Some(1.0e9), None),
        (None, Some(-4.0), None),
    ] {
        let fit = with(near, far, seen);
        assert!(
            fit.warp_near.is_finite() && fit.warp_near != plain.warp_near,
            "{near:?} {far:?}"
        );
        assert_eq!(fit.world_from_light, plain.world_from_light, "the same light space");
        let bounds = |points: &[DVec3]| {
            Bounds::from_points(points.iter().map(|point| fit.clip_from_world.project_point3(*point)))
        };
        for covered in [bounds(body.vertices()), bounds(visible.vertices())] {
            assert!((covered.min.truncate() + 1.0).length() < 1.0e-6, "{covered:?}");
            assert!((covered.max.truncate() - 1.0).length() < 1.0e-6, "{covered:?}");
            assert!(covered.min.z > 0.0 && covered.max.z < 1.0, "{covered:?}");
        }
    }
    // Where the planes meet, n' is the limit of the formula.
    let span = WarpSpan::directional(99.0, 1.0, 1.0);
    close(span.levelled_between(40.0, 40.0).optimal_warp_near(), 41.0, 1.0e-5);
    close(span.levelled_between(40.0, 20.0).optimal_warp_near(), 41.0, 1.0e-5);
    close(span.levelled_between(500.0, 600.0).optimal_warp_near(), 101.0, 1.0e-5);
    close(span.levelled_between(0.0, 0.5).optimal_warp_near(), 2.0, 1.0e-5);
    for (near, far) in [(f64::NAN, 3.0), (2.0, f64::NAN)] {
        assert_eq!(span.levelled_between(near, far), span);
    }
}

/// Scherzer, table 3.3 and oracle 7: Δz from visibility (n = 0.1, f = 70) moves error to the invisible end.
#[test]
fn visible_depths() {
    let view = papers_camera(0.1, 70.0);
    for (visible_far, warp_near, across, along, along_far) in [
        (70.0, 2.7458, 26.458, 22.880, 22.880),
        (50.0, 2.3361, 22.638, 19.577, 26.741),
        (30.0, 1.8321, 17.878, 15.461, 33.860),
        (20.0, 1.5142, 14.842, 12.835, 40.786),
        (10.0, 1.1, 10.845, 9.379, 55.818),
        (5.0, 0.8071, 7.990, 6.910, 75.760),
    ] {
        let options = FitOptions {
            visible_far: Some(visible_far),
            ..FitOptions::default()
        };
        let fit = fit_with(&view, &roomy_scene(), DVec3::NEG_Y, Warp::Lispsm, options);
        close(fit.warp_near, warp_near, 1.0e-4);
        let at = |depth: f64| errors(&fit, &view, DVec3::NEG_Z * depth);
        close(at(0.1).x, across, 1.0e-4);
        close(at(0.1).y, along, 1.0e-4);
        close(at(visible_far).y, along, 1.0e-4);
        close(at(70.0).y, along_far, 1.0e-4);
        close(at(0.1).x * at(0.1).y.max(at(70.0).y), 605.352, 1.0e-4);
    }
    // Of a visible depth and a pseudo-far plane the nearer counts; literal Δz is z_vis − z_n, which is the same thing.
    let warp_near = |pseudo_far, visible_far, optimum| {
        let options = FitOptions {
            pseudo_far,
            visible_far,
            optimum,
            ..UNGUARDED
        };
        fit_with(&view, &roomy_scene(), light_at(60.0), Warp::Lispsm, options).warp_near
    };
    let expected = (0.1 + (0.1_f64 * 20.0).sqrt()) / 60.0_f64.to_radians().sin();
    for optimum in [OptimumRule::Derived, OptimumRule::Literal] {
        close(warp_near(None, Some(20.0), optimum), expected, 1.0e-6);
        close(warp_near(Some(30.0), Some(20.0), optimum), expected, 1.0e-6);
        close(warp_near(Some(20.0), Some(30.0), optimum), expected, 1.0e-6);
    }
}

/// Scherzer, section 2.8, flag (i), and table 3.2, through the fit.
#[test]
fn readings_of_the_optimum_in_light_views() {
    let view = papers_camera(0.1, 70.0);
    for angle in [40.0_f64, 60.0, 90.0, 130.0] {
        let folded = (90.0 - (angle - 90.0).abs()).to_radians();
        let extent = frustum_extent(0.1, 70.0, 30.0_f64.to_radians(), folded);
        let of = |optimum| {
            let options = FitOptions { optimum, ..UNGUARDED };
            fit_with(&view, &roomy_scene(), light_at(angle), Warp::Lispsm, options).warp_near
        };
        let near = 0.1;
        let sine = folded.sin();
        close(
            of(OptimumRule::Derived),
            (near + (near * (near + extent * sine)).sqrt()) / sine,
            1.0e-6,
        );
        close(
            of(OptimumRule::Literal),
            (near + (near * (near + extent)).sqrt()) / sine,
            1.0e-6,
        );
        let demo = near / sine;
        close(
            of(OptimumRule::Demo),
            (demo + (demo * (demo + extent * sine)).sqrt()) / sine,
            1.0e-6,
        );
    }
}

/// Without the guard n_opt is used as it stands, inside the view cone too.
#[test]
fn the_guard_can_be_switched_off() {
    for (degrees, expected) in [(20.0, 14.5621), (10.0, 22.9375)] {
        let (_, plain) = warped(40.0, light_at(degrees), UNGUARDED);
        close(plain.warp_near, expected, 1.0e-4);
        assert_eq!(plain.eta, 0.0);
        let (_, guarded) = warped(40.0, light_at(degrees), FitOptions::default());
        assert!(guarded.warp_near > 2.0 * expected, "{} is guarded", guarded.warp_near);
    }
}

/// Stingl, section 4.1 and oracle 20: the nearest vertex of LVS jumps where its neighbour comes nearer; the new centre
/// does not. Both sit at the depth of e, so the warp is as strong.
#[test]
fn projection_centers() {
    let scene = Bounds::new(DVec3::new(-80.0, -20.0, -80.0), DVec3::new(80.0, 20.0, 80.0));
    let at = |yaw: f64, center| {
        // A yawing camera outside of the scene looks at one of its edges: first one end is nearest, then the other.
        let forward = DVec3::new(yaw.sin(), 0.0, -yaw.cos());
        let view =
            ViewVolume::perspective(DVec3::new(0.0, 1.7, 200.0), forward, DVec3::Y, 1.0, 1.5, 0.1, 1000.0).unwrap();
        let options = FitOptions {
            center,
            ..FitOptions::default()
        };
        fit_with(&view, &scene, DVec3::NEG_Y, Warp::Lispsm, options)
    };
    let largest_jump = |center| {
        let point = DVec3::new(20.0, 0.0, 10.0);
        (-20..20)
            .map(|step| {
                let yaw = f64::from(step) * 0.001 + 0.0005;
                let places = [yaw, yaw + 0.001].map(|yaw| at(yaw, center).clip_from_world.project_point3(point));
                places[0].distance(places[1])
            })
            .fold(0.0, f64::max)
    };
    let (steady, jumping) = (
        largest_jump(ProjectionCenter::Continuous),
        largest_jump(ProjectionCenter::NearestVertex),
    );
    assert!(steady < 0.01, "{steady}");
    assert!(jumping > 0.1, "{jumping}");
    let [new, old] = [ProjectionCenter::Continuous, ProjectionCenter::NearestVertex].map(|center| at(0.01, center));
    assert_eq!((new.warp_near, new.axes), (old.warp_near, old.axes));
    assert!(
        (new.world_from_light.w_axis - old.world_from_light.w_axis).length() > 50.0,
        "the old one is a corner"
    );
}

#[test]
fn options_without_an_answer_are_named() {
    let view = papers_camera(1.0, 100.0);
    let light_travel = DVec3::new(0.2, -1.0, 0.1);
    let (visible, body) = bodies(&view, &roomy_scene(), light_travel);
    let outcome = |options| {
        fit_light_view(&FitInput {
            view: &view,
            visible: &visible,
            body: &body,
            light_travel,
            warp: Warp::Lispsm,
            map_size: UVec2::splat(512),
            guard_texels: 0.0,
            guard_metres: 0.0,
            options,
        })
    };
    let along = |axis| {
        outcome(FitOptions {
            axis: WarpAxis::Direction(axis),
            ..FitOptions::default()
        })
    };
    for axis in [DVec3::ZERO, light_travel, -light_travel * 1.0e6] {
        assert_eq!(along(axis), Fit::Degenerate(Unfit::NoWarpAxis), "{axis}");
    }
    for axis in [DVec3::NAN, DVec3::INFINITY] {
        assert_eq!(along(axis), Fit::Degenerate(Unfit::NotFinite), "{axis}");
    }
    assert!(
        along(DVec3::splat(1.0e300))
            .fitted()
            .is_none_or(|fit| fit.clip_from_world.is_finite())
    );
    for index in 0..3 {
        let depth = |which| (which == index).then_some(f64::NAN);
        let options = FitOptions {
            pseudo_near: depth(0),
            pseudo_far: depth(1),
            visible_far: depth(2),
            ..FitOptions::default()
        };
        assert_eq!(outcome(options), Fit::Degenerate(Unfit::NotFinite));
    }
    let options = FitOptions {
        depths: DepthRange::Receivers { room: f64::NAN },
        ..FitOptions::default()
    };
    assert_eq!(outcome(options), Fit::Degenerate(Unfit::NotFinite));
}
