//! Convex bodies: construction, clipping, sweeping, hulls, and inputs without an answer.

use bevy_math::DVec3;
use umbrage::maths::polytope::{HalfSpace, Polytope, PolytopeState};

use crate::support::{close, papers_camera};

fn unit_cube() -> Polytope {
    Polytope::from_box(DVec3::ZERO, DVec3::ONE)
}

/// Euler's formula for closed convex surfaces.
#[track_caller]
pub(crate) fn assert_closed(body: &Polytope) {
    let (vertices, edges, faces) = (body.vertices().len(), body.edges().len(), body.faces().len());
    assert_eq!(
        vertices + faces,
        edges + 2,
        "{vertices} vertices, {edges} edges, {faces} faces"
    );
}

#[test]
fn a_box_is_a_box() {
    let cube = unit_cube();
    assert_eq!(cube.state(), PolytopeState::Solid);
    assert_eq!(
        (cube.vertices().len(), cube.edges().len(), cube.faces().len()),
        (8, 12, 6)
    );
    close(cube.volume(), 1.0, 1.0e-12);
    for face in cube.faces() {
        let [a, b, c] = [0, 1, 2].map(|index| cube.vertices()[face.indices[index] as usize]);
        let turn = (b - a).cross(c - b).dot(face.half_space.normal);
        assert!(turn > 0.0, "loops run counter-clockwise seen from outside");
    }
}

#[test]
fn a_frustum_has_the_volume_of_a_frustum() {
    let (near, far): (f64, f64) = (1.0, 40.0);
    let frustum = papers_camera(near, far).polytope(1.0e9);
    assert_eq!(frustum.state(), PolytopeState::Solid);
    let side = 2.0 * 30.0_f64.to_radians().tan();
    close(
        frustum.volume(),
        side * side * (far.powi(3) - near.powi(3)) / 3.0,
        1.0e-12,
    );
    assert!(
        frustum.contains(DVec3::new(0.0, 0.0, -20.0), 0.0),
        "the middle is inside"
    );
    assert!(
        !frustum.contains(DVec3::new(0.0, 0.0, -0.5), 0.0),
        "in front of near is outside"
    );
}

#[test]
fn a_mirrored_frustum_is_turned_outside_out() {
    let mut corners = papers_camera(1.0, 2.0).corners(1.0, 2.0);
    let upright = Polytope::from_frustum_corners(&corners).volume();
    corners.swap(0, 1);
    corners.swap(2, 3);
    corners.swap(4, 5);
    corners.swap(6, 7);
    close(Polytope::from_frustum_corners(&corners).volume(), upright, 1.0e-12);
}

#[test]
fn a_pyramid_is_its_hull() {
    let mut corners = papers_camera(1.0, 3.0).corners(1.0, 3.0);
    corners[..4].fill(DVec3::ZERO);
    let pyramid = Polytope::from_frustum_corners(&corners);
    assert_eq!((pyramid.vertices().len(), pyramid.faces().len()), (5, 5));
    close(pyramid.volume(), (6.0_f64 / 3.0_f64.sqrt()).powi(2), 1.0e-9);
}

#[test]
fn clipping_cuts_off_a_corner() {
    let corner = HalfSpace::through(DVec3::new(1.0, 1.0, 0.5), DVec3::ONE * 7.0);
    let body = unit_cube().clip(&corner);
    assert_eq!((body.vertices().len(), body.faces().len()), (10, 7));
    assert_closed(&body);
    close(body.volume(), 1.0 - 0.125 / 6.0, 1.0e-12);
}

#[test]
fn clipping_through_vertices_and_edges_makes_no_slivers() {
    let through_edges = HalfSpace::through(DVec3::ZERO, DVec3::new(1.0, -1.0, 0.0));
    let wedge = unit_cube().clip(&through_edges);
    assert_eq!((wedge.vertices().len(), wedge.faces().len()), (6, 5));
    close(wedge.volume(), 0.5, 1.0e-12);
    let again = wedge.clone().clip(&through_edges);
    assert_eq!(again, wedge, "clipping twice changes nothing");
}

#[test]
fn clipping_beside_touching_and_beyond() {
    let cube = unit_cube();
    let beside = HalfSpace::through(DVec3::X * 2.0, DVec3::X);
    let touching = HalfSpace::through(DVec3::X, DVec3::X);
    let touching_outside = HalfSpace::through(DVec3::X, DVec3::NEG_X);
    let beyond = HalfSpace::through(DVec3::X * 2.0, DVec3::NEG_X);
    assert_eq!(cube.clone().clip(&beside), cube);
    assert_eq!(cube.clone().clip(&touching), cube);
    assert_eq!(cube.clone().clip(&touching_outside).state(), PolytopeState::Empty);
    assert_eq!(cube.clone().clip(&beyond).state(), PolytopeState::Empty);
}

#[test]
fn flat_boxes_are_flat_and_can_be_clipped() {
    let ground = Polytope::from_box(DVec3::new(-5.0, 0.0, -5.0), DVec3::new(5.0, 0.0, 5.0));
    assert_eq!(ground.state(), PolytopeState::Flat);
    let half = ground.clip(&HalfSpace::through(DVec3::ZERO, DVec3::new(1.0, 0.3, 0.0)));
    assert_eq!(half.state(), PolytopeState::Flat);
    let bounds = half.bounds();
    close(bounds.size().x, 5.0, 1.0e-9);
    close(bounds.size().z, 10.0, 1.0e-9);
}

#[test]
fn inputs_without_an_answer_are_named() {
    let states = [
        (Polytope::from_box(DVec3::ONE, DVec3::ZERO), PolytopeState::Empty),
        (Polytope::from_box(DVec3::NAN, DVec3::ONE), PolytopeState::NotFinite),
        (
            Polytope::from_box(DVec3::ZERO, DVec3::splat(1.0e13)),
            PolytopeState::Enormous,
        ),
        (
            Polytope::from_box(DVec3::ZERO, DVec3::INFINITY),
            PolytopeState::Enormous,
        ),
        (
            Polytope::from_frustum_corners(&[DVec3::NAN; 8]),
            PolytopeState::NotFinite,
        ),
        (Polytope::from_frustum_corners(&[DVec3::ONE; 8]), PolytopeState::Empty),
        (Polytope::hull(&[]), PolytopeState::Empty),
        (
            Polytope::hull(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0]),
            PolytopeState::Empty,
        ),
        (
            Polytope::hull(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE.with_z(0.0)]),
            PolytopeState::Flat,
        ),
        (
            Polytope::hull(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::NAN]),
            PolytopeState::NotFinite,
        ),
        (
            unit_cube().clip(&HalfSpace::through(DVec3::ZERO, DVec3::NAN)),
            PolytopeState::NotFinite,
        ),
        (unit_cube().sweep(DVec3::Y, f64::NAN), PolytopeState::NotFinite),
        (unit_cube().sweep(DVec3::Y, 1.0e13), PolytopeState::Enormous),
        (Polytope::default(), PolytopeState::Empty),
    ];
    for (index, (body, state)) in states.iter().enumerate() {
        assert_eq!(body.state(), *state, "case {index}");
        assert_eq!(body.is_empty(), *state != PolytopeState::Flat, "case {index}");
    }
}

#[test]
fn sweeping_adds_a_prism() {
    let swept = unit_cube().sweep(DVec3::new(0.0, 2.0, 0.0), 3.0);
    close(swept.volume(), 4.0, 1.0e-12);
    let slanted = unit_cube().sweep(DVec3::new(1.0, 1.0, 1.0), 3.0_f64.sqrt());
    // The cube, and one prism of volume 1 per face that looks along the direction.
    close(slanted.volume(), 4.0, 1.0e-12);
    assert_closed(&slanted);
}

#[test]
fn hulls_merge_coplanar_points() {
    let mut points = unit_cube().vertices().to_vec();
    points.extend([
        DVec3::splat(0.5),
        DVec3::new(0.5, 0.5, 1.0),
        DVec3::new(0.5, 0.0, 0.0),
        DVec3::ZERO,
    ]);
    let hull = Polytope::hull(&points);
    assert_eq!(
        (hull.vertices().len(), hull.edges().len(), hull.faces().len()),
        (8, 12, 6)
    );
    close(hull.volume(), 1.0, 1.0e-9);
}
