//! Lights, their volumes and the light views of lights at a point.

use bevy_math::{DVec2, DVec3};
use umbrage::maths::{
    body::{intersection_body_of_light, light_visible, lit_visible},
    bounds::Bounds,
    light::{Light, LightError, LinearDepth, PointLightView, aligned_axes, cube_faces, point_view, spot_view},
    polytope::{HalfSpace, Polytope, PolytopeState},
    view::ViewVolume,
};

use crate::{
    light_body::{lantern, room, spot, visitor},
    support::{close, huge_scene, light_at, papers_camera},
};

/// L contains the cone and the sphere that it stands for, and not much more.
#[test]
fn volumes_of_lights_contain_their_light() {
    let Light::Spot {
        position,
        direction,
        outer_angle,
        near,
        range,
    } = spot()
    else {
        panic!("a spot")
    };
    let axis = direction.normalize();
    let (right, up) = axis.any_orthonormal_pair();
    let planes = spot().half_spaces().expect("a proper light");
    let is_inside = |point: DVec3| planes.iter().all(|plane| plane.excess(point) <= 1.0e-9);
    for step in 0..64 {
        let (sine, cosine) = (f64::from(step) * 0.1).sin_cos();
        let on_cone = |angle: f64| axis * angle.cos() + (right * cosine + up * sine) * angle.sin();
        assert!(
            is_inside(position + on_cone(outer_angle) * (range - 0.01)),
            "step {step}"
        );
        assert!(is_inside(position + axis * near * 1.01), "in front of near");
        assert!(
            !is_inside(position + on_cone(outer_angle * 1.1) * range * 0.5),
            "step {step}: beside the cone"
        );
    }
    assert!(!is_inside(position + axis * near * 0.99), "behind near");
    assert!(!is_inside(position + axis * range * 1.01), "beyond the range");
    let lvs = lit_visible(&visitor(), &room(), &spot()).expect("a proper light");
    let lit_everywhere = light_visible(&visitor(), &room());
    assert!(
        lvs.volume() > 0.0 && lvs.volume() < 0.5 * lit_everywhere.volume(),
        "L cuts H"
    );
}

#[test]
fn lights_without_an_answer_are_named() {
    let view = visitor();
    let of = |light: Light| lit_visible(&view, &room(), &light).map(|body| body.state());
    let cone = |outer_angle, near, range, direction| Light::Spot {
        position: DVec3::Y,
        direction,
        outer_angle,
        near,
        range,
    };
    let down = DVec3::NEG_Y;
    assert_eq!(
        of(Light::Directional { travel: DVec3::ZERO }),
        Err(LightError::NoDirection)
    );
    assert_eq!(
        of(Light::Directional { travel: DVec3::NAN }),
        Err(LightError::NotFinite)
    );
    assert_eq!(of(lantern(DVec3::NAN)), Err(LightError::NotFinite));
    assert_eq!(of(lantern(DVec3::splat(1.0e30))), Err(LightError::NotFinite));
    let dark = Light::Point {
        position: DVec3::Y,
        range: 0.0,
    };
    assert_eq!(of(dark), Err(LightError::NoRange));
    assert_eq!(of(cone(0.5, 2.0, 1.0, down)), Err(LightError::NoRange));
    assert_eq!(of(cone(0.5, 0.0, 1.0, down)), Err(LightError::NoRange));
    assert_eq!(of(cone(0.5, 0.1, 1.0, DVec3::ZERO)), Err(LightError::NoDirection));
    assert_eq!(of(cone(1.6, 0.1, 1.0, down)), Err(LightError::NoCone));
    assert_eq!(of(cone(0.0, 0.1, 1.0, down)), Err(LightError::NoCone));
    assert_eq!(of(cone(f64::NAN, 0.1, 1.0, down)), Err(LightError::NotFinite));
    assert_eq!(of(cone(0.5, 0.1, 9.0, down)), Ok(PolytopeState::Solid));
    // The viewer outside the cone.
    let elsewhere = Light::Spot {
        position: DVec3::new(0.0, 5.0, 60.0),
        direction: DVec3::Z,
        outer_angle: 0.5,
        near: 0.1,
        range: 20.0,
    };
    assert_eq!(of(elsewhere), Ok(PolytopeState::Empty));
    let nothing = Polytope::default();
    let body = intersection_body_of_light(&nothing, &room(), &spot()).expect("a proper light");
    assert_eq!(body.state(), PolytopeState::Empty);
    let axes = aligned_axes(DVec3::ZERO, down, &view, DVec3::NEG_Y).expect("an axis");
    let map = spot_view(&spot(), &axes).expect("a spot");
    assert_eq!(map.focused(&nothing), Err(LightError::NothingVisible));
    assert_eq!(spot_view(&lantern(DVec3::ZERO), &axes), Err(LightError::NoCone));
    assert_eq!(cube_faces(&spot(), 0.1), Err(LightError::NoRange));
    assert_eq!(cube_faces(&lantern(DVec3::ZERO), 300.0), Err(LightError::NoRange));
    assert_eq!(aligned_axes(DVec3::ZERO, DVec3::ZERO, &view, DVec3::X), None);
}

fn spot_map(view: &ViewVolume) -> PointLightView {
    let light = spot();
    let Light::Spot {
        position, direction, ..
    } = light
    else {
        panic!("a spot")
    };
    let axes = aligned_axes(position, direction, view, position + direction).expect("an axis");
    spot_view(&light, &axes).expect("a spot")
}

/// Reverse z, w the distance along the axis, the cone inscribed in the map.
#[test]
fn the_light_view_of_a_spot() {
    let Light::Spot {
        position,
        direction,
        outer_angle,
        near,
        range,
    } = spot()
    else {
        panic!("a spot")
    };
    let map = spot_map(&visitor());
    let axis = direction.normalize();
    close(map.light_from_world.determinant(), 1.0, 1.0e-9);
    close(
        map.clip_from_world.project_point3(position + axis * near).z,
        1.0,
        1.0e-9,
    );
    assert!(map.clip_from_world.project_point3(position + axis * range).z.abs() < 1.0e-9);
    let (right, up) = axis.any_orthonormal_pair();
    for step in 0..64 {
        let (sine, cosine) = (f64::from(step) * 0.1).sin_cos();
        let along = axis * outer_angle.cos() + (right * cosine + up * sine) * outer_angle.sin();
        let clip = map.clip_from_world * (position + along * 7.0).extend(1.0);
        close(clip.w, 7.0 * outer_angle.cos(), 1.0e-9);
        close(DVec2::new(clip.x, clip.y).length() / clip.w, 1.0, 1.0e-9);
    }
    let nearer = map.clip_from_world.project_point3(position + axis * 3.0).z;
    assert!(
        nearer > map.clip_from_world.project_point3(position + axis * 3.1).z,
        "reverse z"
    );
}

/// Stingl, oracle 16, for a spot: all of B in the clip box, every bound attained; and at least as fine as before.
#[test]
fn a_spot_is_focused_on_its_body() {
    let view = visitor().split(0.1, 13.0);
    let visible = light_visible(&view, &room());
    let body = intersection_body_of_light(&visible, &room(), &spot()).expect("a proper light");
    assert_eq!(body.state(), PolytopeState::Solid);
    let whole = spot_map(&view);
    let map = whole.focused(&body).expect("B lies in L");
    let points = body
        .vertices()
        .iter()
        .map(|vertex| map.clip_from_world.project_point3(*vertex));
    let bounds = Bounds::from_points(points);
    assert!(bounds.min.distance(DVec3::new(-1.0, -1.0, 0.0)) < 1.0e-9, "{bounds:?}");
    assert!(bounds.max.distance(DVec3::ONE) < 1.0e-9, "{bounds:?}");
    let product = map.clip_from_light * map.light_from_world;
    assert!(
        product.abs_diff_eq(map.clip_from_world, 1.0e-9),
        "the product of its parts"
    );
    let size = |map: &PointLightView| {
        let points = body
            .vertices()
            .iter()
            .map(|vertex| map.clip_from_world.project_point3(*vertex));
        let size = Bounds::from_points(points).size();
        size.x * size.y
    };
    assert!(
        size(&map) > 1.2 * size(&whole),
        "{} against {}",
        size(&map),
        size(&whole)
    );
}

/// Stingl, section 3.2.1: after the rotation e + v lies above e in the map.
#[test]
fn axes_of_a_spot_follow_the_view_as_the_light_sees_it() {
    let view = visitor();
    let position = DVec3::new(-3.0, 10.0, -8.0);
    for seen in [DVec3::new(1.0, 0.5, 2.0), DVec3::new(-6.0, 3.0, -12.0)] {
        let axes = aligned_axes(position, DVec3::new(0.2, -1.0, -0.3), &view, seen).expect("an axis");
        assert!((axes.x.cross(axes.y) - axes.z).length() < 1.0e-12, "right-handed");
        let map = spot_view(&spot(), &axes).expect("a spot");
        let image = |step: f64| map.clip_from_world.project_point3(seen + view.forward() * step);
        let moved = image(1.0e-3) - image(0.0);
        assert!(moved.y > 0.0 && moved.x.abs() < 1.0e-6 * moved.y, "{moved}");
        // A line stays a line: a long step ends above e too.
        let far = image(2.0) - image(0.0);
        assert!(far.x.abs() < 1.0e-9 * far.y.abs(), "{far}");
    }
    // Seen end-on, the camera's up direction takes over.
    let behind = view.eye() - view.forward() * 3.0;
    let axes = aligned_axes(behind, view.forward(), &view, view.eye()).expect("an axis");
    assert!(axes.y.dot(view.up()) > 0.999, "{axes:?}");
}

/// A point light beside the view: one narrow perspective; in the midst of it: only the cube shows everything.
#[test]
fn the_light_view_of_a_point_light() {
    let view = visitor();
    let visible = light_visible(&view, &room());
    let position = DVec3::new(-60.0, 80.0, 30.0);
    let light = lantern(position);
    let body = intersection_body_of_light(&visible, &room(), &light).expect("a proper light");
    let axes = aligned_axes(position, visible.center() - position, &view, view.eye()).expect("an axis");
    let map = point_view(&light, &axes, &visible, &body, 1.0).expect("a narrow view");
    let bounds = Bounds::from_points(
        body.vertices()
            .iter()
            .map(|vertex| map.clip_from_world.project_point3(*vertex)),
    );
    assert!(bounds.min.distance(DVec3::new(-1.0, -1.0, 0.0)) < 1.0e-9, "{bounds:?}");
    assert!(bounds.max.distance(DVec3::ONE) < 1.0e-9, "{bounds:?}");

    let amidst = DVec3::new(0.0, 2.0, -5.0);
    let light = lantern(amidst);
    let body = intersection_body_of_light(&visible, &room(), &light).expect("a proper light");
    let axes = aligned_axes(amidst, DVec3::NEG_Z, &view, view.eye()).expect("an axis");
    assert_eq!(
        point_view(&light, &axes, &visible, &body, 0.1),
        Err(LightError::TooWide)
    );
    let views = cube_faces(&light, 0.1).expect("six views");
    let body = body.clip(&HalfSpace::through(amidst, DVec3::Y));
    for vertex in body.vertices() {
        let holds = |map: &PointLightView| {
            let clip = map.clip_from_world * vertex.extend(1.0);
            clip.w > 0.0 && clip.x.abs() <= clip.w * 1.000_001 && clip.y.abs() <= clip.w * 1.000_001
        };
        let distance = vertex.distance(amidst);
        assert!(distance < 0.1 || views.iter().any(holds), "{vertex} is in no face");
    }
}

/// Faces of the cube look along their axes, are not mirrored and overlap nowhere.
#[test]
fn faces_of_the_cube() {
    let position = DVec3::new(1.0, 2.0, 3.0);
    let views = cube_faces(&lantern(position), 0.1).expect("six views");
    for (index, axis) in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z]
        .into_iter()
        .enumerate()
    {
        close(views[index].light_from_world.determinant(), 1.0, 1.0e-12);
        let count = views
            .iter()
            .filter(|view| {
                let clip = view.clip_from_world * (position + axis * 5.0 + DVec3::splat(0.3)).extend(1.0);
                clip.w > 0.0 && clip.x.abs() <= clip.w && clip.y.abs() <= clip.w
            })
            .count();
        assert_eq!(count, 1, "{axis}");
        let ahead = views[index].clip_from_world.project_point3(position + axis * 5.0);
        assert!(
            ahead.truncate().length() < 1.0e-12 && ahead.z > 0.0 && ahead.z < 1.0,
            "{axis}: {ahead}"
        );
    }
}

/// Brabec's near plane: the nearest receiver begins the range, casters before it are clamped and shade as before
/// (Lloyd, oracle 23), and receivers get the whole precision.
#[test]
fn pulled_in_near_planes_lose_no_shadow() {
    let view = visitor();
    let light = spot();
    let Light::Spot {
        position,
        direction,
        near,
        range,
        ..
    } = light
    else {
        panic!("a spot")
    };
    let floor = Bounds::new(room().min, room().max.with_y(3.0));
    let visible = lit_visible(&view, &floor, &light).expect("a proper light");
    let depth = LinearDepth::around_receivers(&visible, position, direction).expect("receivers");
    assert!(depth.near > near && depth.far <= range, "{depth:?}");
    let axis = direction.normalize();
    for vertex in visible.vertices() {
        let distance = (vertex - position).dot(axis);
        let receiver = depth.clamped(distance);
        assert!((0.0..1.0).contains(&receiver), "receivers are inside the range");
        for caster in [0.01, 0.3, 0.9, 0.999] {
            assert!(
                depth.clamped(distance * caster) > receiver,
                "a caster at {caster} of the way shades"
            );
        }
        assert!(depth.clamped(distance * 1.01) <= receiver, "what lies behind does not");
    }
    let wide = LinearDepth { near, far: range };
    let step = |depth: &LinearDepth| depth.clamped(8.0) - depth.clamped(8.001);
    assert!(step(&depth) > 2.0 * step(&wide), "finer steps");
    assert_eq!(
        LinearDepth::around_receivers(&Polytope::default(), position, axis),
        None
    );
    assert_eq!(LinearDepth::around_receivers(&visible, position, DVec3::ZERO), None);
}

/// The same for the sun: Lloyd, oracle 23.
#[test]
fn casters_in_front_of_the_focus_keep_their_shadow() {
    let view = papers_camera(1.0, 50.0);
    let travel = light_at(70.0);
    let visible = light_visible(&view, &huge_scene());
    let depth = LinearDepth::around_receivers(&visible, DVec3::ZERO, travel).expect("receivers");
    let receiver = view.eye() + view.forward() * 20.0;
    let caster = |metres: f64| depth.clamped((receiver - travel * metres).dot(travel));
    for metres in [1.0, 10.0, 1.0e3, 1.0e5] {
        assert!(caster(metres) > caster(0.0), "{metres} m towards the light");
    }
    assert_eq!(caster(1.0e3), 1.0, "clamped");
}
