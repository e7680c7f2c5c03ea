//! Bodies of lights at a point.

use bevy_math::DVec3;
use proptest::prelude::*;
use umbrage::maths::{
    body::{intersection_body, intersection_body_of_light, light_visible, lit_visible, unfocused_body},
    bounds::Bounds,
    light::Light,
    polytope::{Polytope, PolytopeState},
    view::ViewVolume,
};

use crate::support::close;

pub(crate) fn room() -> Bounds {
    Bounds::new(DVec3::new(-20.0, 0.0, -40.0), DVec3::new(20.0, 12.0, 10.0))
}

pub(crate) fn visitor() -> ViewVolume {
    ViewVolume::perspective(
        DVec3::new(2.0, 1.7, 5.0),
        DVec3::new(-0.2, 0.05, -1.0),
        DVec3::Y,
        1.0,
        1.5,
        0.1,
        f64::INFINITY,
    )
    .expect("a proper camera")
}

pub(crate) fn lantern(position: DVec3) -> Light {
    Light::Point { position, range: 200.0 }
}

pub(crate) fn spot() -> Light {
    Light::Spot {
        position: DVec3::new(-3.0, 10.0, -8.0),
        direction: DVec3::new(0.2, -1.0, -0.3),
        outer_angle: 0.7,
        near: 0.5,
        range: 30.0,
    }
}

/// Stingl, section 2.2.1, pseudo-code A: hull, then clip. The literal form, without the construction's shortcuts.
fn hull_then_clip(visible: &Polytope, scene: &Bounds, light: &Light) -> Polytope {
    let position = light.position().expect("a light at a point");
    let points: Vec<DVec3> = visible.vertices().iter().copied().chain([position]).collect();
    let walls = Polytope::from_box(scene.min, scene.max);
    let scene_planes = walls.faces().map(|face| face.half_space);
    let light_planes = light.half_spaces().expect("a proper light");
    scene_planes
        .chain(light_planes)
        .fold(Polytope::hull(&points), |body, plane| body.clip(&plane))
}

/// Stingl, oracle 17, for lights at a point: outside S, in S but outside V, inside H, and spots.
#[test]
fn the_body_of_a_light_at_a_point_is_hull_then_clip() {
    let visible = light_visible(&visitor(), &room());
    let inside = DVec3::new(0.0, 2.0, -5.0);
    assert!(visible.contains(inside, 0.0), "the last light is in view");
    for light in [
        lantern(DVec3::new(-60.0, 80.0, 30.0)),
        lantern(DVec3::new(15.0, 10.0, 8.0)),
        lantern(DVec3::new(-5.0, -3.0, -60.0)),
        lantern(inside),
        spot(),
        Light::Point {
            position: DVec3::new(15.0, 10.0, 8.0),
            range: 14.0,
        },
    ] {
        let body = intersection_body_of_light(&visible, &room(), &light).expect("a proper light");
        let reference = hull_then_clip(&visible, &room(), &light);
        close(body.volume(), reference.volume(), 1.0e-6);
        for (inner, outer) in [(&body, &reference), (&reference, &body)] {
            for vertex in inner.vertices() {
                assert!(outer.contains(*vertex, 1.0e-5), "{vertex} sticks out for {light:?}");
            }
        }
    }
    let enclosed = intersection_body_of_light(&visible, &room(), &lantern(inside)).expect("a proper light");
    close(enclosed.volume(), visible.volume(), 1.0e-9);
}

/// Stingl, section 2.2.1: exit points on the box, hulled, would lose the corner of the box that lies inside the hull.
#[test]
fn a_box_corner_between_light_and_view_belongs_to_the_body() {
    let scene = Bounds::new(DVec3::ZERO, DVec3::splat(10.0));
    let view =
        ViewVolume::perspective(DVec3::new(5.0, 1.0, 9.9), DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 0.1, 100.0).unwrap();
    let visible = light_visible(&view, &scene);
    let light = lantern(DVec3::new(36.0, 44.0, 12.0));
    let body = intersection_body_of_light(&visible, &scene, &light).expect("a proper light");
    let exits: Vec<DVec3> = visible
        .vertices()
        .iter()
        .flat_map(|vertex| {
            let ray = light.towards(*vertex);
            let reach = (0..3)
                .filter(|axis| ray[*axis] > 0.0)
                .map(|axis| (scene.max[axis] - vertex[axis]) / ray[axis])
                .fold(f64::INFINITY, f64::min);
            [*vertex, vertex + ray * reach]
        })
        .collect();
    let of_exits = Polytope::hull(&exits);
    let lost = (0..100).map(|step| DVec3::new(10.0, 10.0, 0.1 * f64::from(step)));
    let lost = lost.filter(|point| body.contains(*point, 1.0e-6) && !of_exits.contains(*point, 1.0e-2));
    assert!(
        lost.count() > 5,
        "the shortcut loses the edge of the box nearest to the light"
    );
    assert!(of_exits.volume() < 0.999 * body.volume(), "and casters with it");
}

/// Stingl, oracle 18; Scherzer, oracle 11.
#[test]
fn the_focused_body_lies_in_the_unfocused_one() {
    let view = visitor().split(0.1, 60.0);
    let visible = light_visible(&view, &room());
    for light in [
        lantern(DVec3::new(-10.0, 30.0, 20.0)),
        lantern(DVec3::new(1.0, 3.0, -9.0)),
        spot(),
        Light::Directional {
            travel: DVec3::new(0.3, -1.0, 0.2),
        },
    ] {
        let body = intersection_body_of_light(&visible, &room(), &light).expect("a proper light");
        let whole = unfocused_body(&view, &light, 1000.0).expect("a proper light");
        assert_eq!(whole.state(), PolytopeState::Solid);
        for vertex in body.vertices() {
            assert!(whole.contains(*vertex, 1.0e-6), "{vertex} of {light:?}");
        }
        // Nothing but V and the light: its corners are theirs, or V's a reach towards the sun.
        let corners = view.corners(view.near(), view.far());
        for vertex in whole.vertices() {
            let is_corner = |point: DVec3| point.distance(*vertex) < 1.0e-6;
            let swept = |corner: DVec3| corner + light.towards(corner) * 1000.0;
            let is_known = corners.iter().any(|corner| is_corner(*corner))
                || match light.position() {
                    Some(position) => is_corner(position),
                    None => corners.iter().any(|corner| is_corner(swept(*corner))),
                };
            assert!(is_known, "{vertex} is no corner of V and {light:?}");
        }
        assert!(light.position().is_none_or(|position| whole.contains(position, 1.0e-6)));
        assert!(corners.iter().all(|corner| whole.contains(*corner, 1.0e-6)), "all of V");
        assert!(body.volume() < 0.5 * whole.volume(), "S cuts useless space: {light:?}");
    }
}

#[test]
fn the_sun_is_the_same_by_either_way() {
    let travel = DVec3::new(0.3, -1.0, 0.2);
    let sun = Light::Directional { travel };
    let visible = lit_visible(&visitor(), &room(), &sun).expect("a sun");
    assert_eq!(
        visible,
        light_visible(&visitor(), &room()),
        "the sun's light reaches everywhere"
    );
    let body = intersection_body_of_light(&visible, &room(), &sun).expect("a sun");
    assert_eq!(body, intersection_body(&visible, &room(), travel));
}

fn place(range: f64) -> impl Strategy<Value = DVec3> {
    [-range..range, -range..range, -range..range].prop_map(DVec3::from_array)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Stingl, oracle 17: every shadow ray from a point of H to the light stays in B as long as it stays in S; B lies
    /// in S and L; shrinking S shrinks B (Scherzer, oracle 10).
    #[test]
    fn shadow_rays_stay_in_the_body(
        eye in place(30.0), target in place(20.0), position in place(60.0), spotted in any::<bool>(),
        picks in prop::collection::vec(([0.0..1.0, 0.0..1.0, 0.0..1.0], 0.0..1.0), 12),
    ) {
        let view = ViewVolume::perspective(eye, target - eye, DVec3::Y, 1.1, 1.4, 0.1, 300.0);
        prop_assume!(view.is_ok());
        let view = view.unwrap();
        let light = if spotted {
            Light::Spot { position, direction: target - position, outer_angle: 0.6, near: 0.2, range: 90.0 }
        } else {
            Light::Point { position, range: 150.0 }
        };
        prop_assume!(light.check().is_ok());
        let visible = light_visible(&view, &room());
        prop_assume!(visible.state() == PolytopeState::Solid && visible.volume() > 1.0e-3);
        let body = intersection_body_of_light(&visible, &room(), &light).unwrap();
        let volume = light.half_spaces().unwrap();
        let is_lit = |point: DVec3| volume.iter().all(|plane| plane.excess(point) <= 0.0);
        let corners = visible.vertices();
        let pick = |share: f64| corners[((share * corners.len() as f64) as usize).min(corners.len() - 1)];
        for (shares, along) in picks {
            let receiver = shares.map(pick).iter().sum::<DVec3>() / 3.0;
            let point = receiver + (position - receiver) * along;
            if room().contains(point, 0.0) && is_lit(point) {
                prop_assert!(body.contains(point, 1.0e-5), "{point} on the ray from {receiver}");
            }
        }
        for vertex in body.vertices() {
            prop_assert!(room().contains(*vertex, 1.0e-5), "B sticks out of S at {vertex}");
            prop_assert!(volume.iter().all(|plane| plane.excess(*vertex) <= 1.0e-5), "B sticks out of L at {vertex}");
        }
        let smaller = Bounds::new(room().min, room().max - DVec3::new(4.0, 3.0, 7.0));
        let of_smaller = intersection_body_of_light(&light_visible(&view, &smaller), &smaller, &light).unwrap();
        for vertex in of_smaller.vertices() {
            prop_assert!(body.contains(*vertex, 1.0e-5), "B grew when S shrank");
        }
        prop_assert!(of_smaller.volume() <= body.volume() + 1.0e-5);
    }
}
