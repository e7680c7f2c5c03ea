//! H, B and adjusted depths.

use bevy_math::{DVec2, DVec3};
use umbrage::maths::{
    body::{adjusted_depths, intersection_body, light_visible},
    bounds::Bounds,
    polytope::{Polytope, PolytopeState},
    view::{ViewError, ViewVolume},
};

use crate::support::{bodies, close, huge_scene, light_at, papers_camera};

fn street() -> Bounds {
    Bounds::new(DVec3::new(-40.0, 0.0, -60.0), DVec3::new(30.0, 25.0, 20.0))
}

fn walker() -> ViewVolume {
    ViewVolume::perspective(
        DVec3::new(3.0, 1.7, 4.0),
        DVec3::new(0.3, -0.1, -1.0),
        DVec3::Y,
        1.1,
        1.6,
        0.1,
        f64::INFINITY,
    )
    .expect("a proper camera")
}

/// Stingl, oracle 17: the plane-based body equals sweep, hull and clip.
#[test]
fn both_ways_to_the_intersection_body_agree() {
    let scene = street();
    for light in [
        DVec3::NEG_Y,
        DVec3::new(0.4, -1.0, 0.7),
        DVec3::new(-2.0, -0.3, 0.1),
        DVec3::new(1.0, 0.0, 0.0),
        DVec3::new(0.3, -0.1, -1.0),
        DVec3::new(-0.3, 0.1, 1.0),
    ] {
        let (visible, body) = bodies(&walker(), &scene, light);
        let swept = visible.sweep(-light, 1.01 * scene.size().length());
        let hull = Polytope::hull(swept.vertices());
        close(swept.volume(), hull.volume(), 1.0e-6);
        let reference = umbrage_scene_planes(&scene)
            .into_iter()
            .fold(hull, |body, plane| body.clip(&plane));
        close(body.volume(), reference.volume(), 1.0e-6);
        for (inner, outer) in [(&body, &reference), (&reference, &body)] {
            for vertex in inner.vertices() {
                assert!(outer.contains(*vertex, 1.0e-5), "{vertex} sticks out for light {light}");
            }
        }
    }
}

fn umbrage_scene_planes(scene: &Bounds) -> Vec<umbrage::maths::polytope::HalfSpace> {
    Polytope::from_box(scene.min, scene.max)
        .faces()
        .map(|face| face.half_space)
        .collect()
}

/// Stingl 2.2.1: hulling the exit points instead of sweeping past S would lose the box corner inside the prism.
#[test]
fn a_box_corner_inside_the_prism_belongs_to_the_body() {
    let scene = Bounds::new(DVec3::ZERO, DVec3::splat(10.0));
    let view =
        ViewVolume::perspective(DVec3::new(5.0, 1.0, 9.9), DVec3::NEG_Z, DVec3::Y, 1.5, 1.0, 0.1, 100.0).unwrap();
    let light = -DVec3::new(1.0, 1.0, 0.2);
    let (_, body) = bodies(&view, &scene, light);
    let corner = DVec3::new(10.0, 10.0, 5.0);
    assert!(
        body.contains(corner, 1.0e-6),
        "the edge of the box nearest to the light casts into the view"
    );
}

#[test]
fn an_infinite_far_plane_ends_at_the_scene() {
    let visible = light_visible(&walker(), &street());
    let (near, far) = adjusted_depths(&visible, &walker()).expect("sees the street");
    close(near, 0.1, 1.0e-9);
    let farthest = street()
        .corners()
        .map(|corner| walker().depth(corner))
        .into_iter()
        .fold(0.0, f64::max);
    assert!(
        far <= farthest + 1.0e-9 && far > 0.9 * farthest,
        "{far} against {farthest}"
    );
}

/// Stingl, section 4.3: the adjusted near exceeds the original one when the camera is outside S.
#[test]
fn near_moves_to_the_scene() {
    let scene = Bounds::new(DVec3::new(-5.0, -5.0, -30.0), DVec3::new(5.0, 5.0, -20.0));
    let view = papers_camera(0.1, 1000.0);
    let (near, far) = adjusted_depths(&light_visible(&view, &scene), &view).expect("sees the box");
    close(near, 20.0, 1.0e-12);
    close(far, 30.0, 1.0e-12);
}

#[test]
fn depths_of_a_wall_that_faces_the_camera_are_an_interval() {
    let wall = Bounds::new(DVec3::new(-5.0, -5.0, -20.0), DVec3::new(5.0, 5.0, -20.0));
    let view = papers_camera(0.1, 1000.0);
    let visible = light_visible(&view, &wall);
    assert_eq!(visible.state(), PolytopeState::Flat);
    let (near, far) = adjusted_depths(&visible, &view).expect("sees the wall");
    assert!(near < far, "{near} < {far}");
}

#[test]
fn looking_away_sees_nothing() {
    let scene = Bounds::new(DVec3::new(-5.0, -5.0, 20.0), DVec3::new(5.0, 5.0, 30.0));
    let view = papers_camera(0.1, 1000.0);
    let (visible, body) = bodies(&view, &scene, DVec3::NEG_Y);
    assert_eq!(visible.state(), PolytopeState::Empty);
    assert_eq!(body.state(), PolytopeState::Empty);
    assert_eq!(adjusted_depths(&visible, &view), None);
}

#[test]
fn inputs_without_an_answer_are_named() {
    let view = papers_camera(0.1, 1000.0);
    assert_eq!(light_visible(&view, &Bounds::EMPTY).state(), PolytopeState::Empty);
    let enormous = Bounds::new(DVec3::splat(-1.0e30), DVec3::splat(1.0e30));
    assert_eq!(light_visible(&view, &enormous).state(), PolytopeState::Enormous);
    let nan = Bounds::new(DVec3::NAN, DVec3::ONE);
    assert_eq!(light_visible(&view, &nan).state(), PolytopeState::NotFinite);
    let visible = light_visible(&view, &huge_scene());
    let body = intersection_body(&visible, &huge_scene(), DVec3::ZERO);
    assert_eq!(body.state(), PolytopeState::NotFinite);
}

#[test]
fn cameras_without_a_volume_are_named() {
    let camera = |eye, forward, fov, near, far| ViewVolume::perspective(eye, forward, DVec3::Y, fov, 1.0, near, far);
    let (zero, ahead) = (DVec3::ZERO, DVec3::NEG_Z);
    assert_eq!(camera(DVec3::NAN, ahead, 1.0, 0.1, 10.0), Err(ViewError::NotFinite));
    assert_eq!(camera(zero, zero, 1.0, 0.1, 10.0), Err(ViewError::NotFinite));
    assert_eq!(camera(zero, ahead, f64::NAN, 0.1, 10.0), Err(ViewError::NotFinite));
    assert_eq!(camera(zero, ahead, 1.0, 10.0, 0.1), Err(ViewError::NoRange));
    assert_eq!(camera(zero, ahead, 1.0, 0.0, 10.0), Err(ViewError::NoRange));
    assert_eq!(camera(zero, ahead, 0.0, 0.1, 10.0), Err(ViewError::NoArea));
    let flat = ViewVolume::orthographic(zero, ahead, DVec3::Y, DVec2::ZERO, DVec2::X, 0.0, 10.0);
    assert_eq!(flat, Err(ViewError::NoArea));
    assert!(
        camera(zero, DVec3::Y, 1.0, 0.1, 10.0).is_ok(),
        "looking straight up is fine"
    );
}

#[test]
fn an_orthographic_camera_sees_a_box() {
    let view = ViewVolume::orthographic(
        DVec3::new(0.0, 50.0, 0.0),
        DVec3::NEG_Y,
        DVec3::NEG_Z,
        DVec2::new(-3.0, -2.0),
        DVec2::new(3.0, 2.0),
        -10.0,
        1000.0,
    )
    .expect("a proper camera");
    assert!(view.is_orthographic());
    let scene = Bounds::new(DVec3::new(-100.0, 0.0, -100.0), DVec3::new(100.0, 20.0, 100.0));
    let (visible, body) = bodies(&view, &scene, DVec3::NEG_Y);
    close(visible.volume(), 6.0 * 4.0 * 20.0, 1.0e-9);
    close(body.volume(), visible.volume(), 1.0e-9);
    let (near, far) = adjusted_depths(&visible, &view).expect("sees the scene");
    close(near, 30.0, 1.0e-9);
    close(far, 50.0, 1.0e-9);
}

/// Stingl, oracle 18: the focused body lies inside the hull of the whole frustum swept to the light.
#[test]
fn focusing_never_grows_the_body() {
    let view = papers_camera(1.0, 200.0);
    let scene = street();
    let light = light_at(70.0);
    let (_, body) = bodies(&view, &scene, light);
    let unfocused = view.polytope(1.0e9).sweep(-light, 1.0e4);
    for vertex in body.vertices() {
        assert!(unfocused.contains(*vertex, 1.0e-6), "{vertex}");
    }
}
