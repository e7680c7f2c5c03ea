//! The original perspective shadow map: a light's view of the camera's clip space.

use bevy_math::{DMat4, DVec2, DVec3, UVec2, Vec4Swizzles};
use proptest::prelude::*;
use umbrage::maths::{
    bounds::Bounds,
    fit::{FitInput, FitOptions, Unfit},
    footprint::texel_footprint,
    polytope::Polytope,
    view::ViewVolume,
    warp::{
        Warp,
        post_perspective::{PostPerspectiveFit, PostPerspectiveLight, PostPerspectiveRefusal, fit_post_perspective},
    },
};

use crate::support::{OPENING, bodies, close, fit, light_at, papers_camera, roomy_scene};

fn post_perspective(
    view: &ViewVolume,
    scene: &Bounds,
    light_travel: DVec3,
    guard_texels: f64,
) -> Result<PostPerspectiveFit, PostPerspectiveRefusal> {
    let (visible, body) = bodies(view, scene, light_travel);
    fit_post_perspective(&FitInput {
        view,
        visible: &visible,
        body: &body,
        light_travel,
        warp: Warp::Psm,
        map_size: UVec2::splat(512),
        guard_texels,
        guard_metres: 0.0,
        options: FitOptions::default(),
    })
}

/// Light across the view: every texel is where the light-space warp of the same strength has it (n' = n), so that across
/// the axis the error is 1 and along it (f − n) ÷ (2 tan Θ) · z ÷ (n f) (Stingl, equations 2.5 and 2.6).
#[test]
fn light_across_the_view_is_the_warp_of_the_same_name() {
    let view = papers_camera(1.0, 40.0);
    for light in [DVec3::NEG_Y, DVec3::Y, DVec3::X] {
        let original = post_perspective(&view, &roomy_scene(), light, 0.0).expect("light from the side");
        assert_eq!(original.light, PostPerspectiveLight::Parallel);
        let warp = fit(&view, &roomy_scene(), light, Warp::Psm);
        for corner in view.corners(1.0, 40.0).into_iter().chain([DVec3::new(1.0, -2.0, -9.0)]) {
            let places = [original.clip_from_world, warp.clip_from_world].map(|clip| clip.project_point3(corner));
            assert!(
                (places[0] - places[1]).truncate().length() < 1.0e-4,
                "{light}: {} is not {}",
                places[0],
                places[1]
            );
        }
        for depth in [1.0, 6.0, 40.0] {
            let point = DVec3::NEG_Z * depth;
            let lengths = texel_footprint(&original.clip_from_world, UVec2::splat(512), point)
                .expect("in front")
                .lengths();
            let pixel = OPENING * depth / 512.0;
            close(lengths.x / pixel, 1.0, 1.0e-4);
            close(lengths.y / pixel, 39.0 / OPENING * depth / 40.0, 1.0e-4);
        }
    }
}

/// The three cases, and the plane on which all post-perspective lights lie: (f + n) ÷ (f − n).
#[test]
fn the_light_in_the_cube() {
    let view = papers_camera(1.0, 40.0);
    let plane = 41.0 / 39.0;
    let light = |angle| {
        post_perspective(&view, &roomy_scene(), light_at(angle), 0.0)
            .expect("outside the cone")
            .light
    };
    // Light from behind and above: the rays run to a point below the far side, 1 ÷ tan 30° as far as the cube is high.
    let PostPerspectiveLight::Behind(behind) = light(60.0) else {
        panic!("{:?}", light(60.0));
    };
    assert!(behind.distance(DVec3::new(0.0, -3.0, plane)) < 1.0e-4, "{behind}");
    // Light from ahead and above: from a point above the far side.
    let PostPerspectiveLight::InFront(ahead) = light(120.0) else {
        panic!("{:?}", light(120.0));
    };
    assert!(ahead.distance(DVec3::new(0.0, 3.0, plane)) < 1.0e-4, "{ahead}");
    assert_eq!(light(90.0), PostPerspectiveLight::Parallel);
}

/// Nothing jumps where the light passes from one case to the next.
#[test]
fn cases_meet() {
    let view = papers_camera(1.0, 40.0);
    let at = |angle| post_perspective(&view, &roomy_scene(), light_at(angle), 0.0).expect("light from the side");
    let points = [DVec3::new(0.3, -0.2, -2.0), DVec3::new(-4.0, 5.0, -20.0)];
    for (before, after) in [(89.9999, 90.0), (90.0, 90.0001)] {
        for point in points {
            let places = [before, after].map(|angle| at(angle).clip_from_world.project_point3(point));
            assert!(
                places[0].distance(places[1]) < 1.0e-4,
                "{before}° to {after}°: {places:?}"
            );
        }
    }
}

/// Casters behind the eye need no care: their texel is that of the receivers on the same ray.
#[test]
fn casters_behind_the_viewer() {
    let view = papers_camera(1.0, 40.0);
    let light = light_at(50.0);
    let map = post_perspective(&view, &roomy_scene(), light, 0.0)
        .expect("outside the cone")
        .clip_from_world;
    let receiver = DVec3::new(0.5, -1.0, -6.0);
    let caster = receiver - light * 30.0;
    assert!(view.depth(caster) < -5.0, "behind the viewer");
    let places = [receiver, caster].map(|point| map.project_point3(point));
    assert!((places[0] - places[1]).truncate().length() < 1.0e-9, "{places:?}");
    assert!(places[1].z > places[0].z && places[1].z < 1.0, "{places:?}");
    close((map * caster.extend(1.0)).w, (map * receiver.extend(1.0)).w, 1.0e-9);
}

#[test]
fn light_inside_the_cone_is_refused() {
    let view = papers_camera(1.0, 40.0);
    for angle in [0.0, 5.0, 20.0, 29.0, 151.0, 170.0, 180.0] {
        let outcome = post_perspective(&view, &roomy_scene(), light_at(angle), 0.0);
        assert_eq!(outcome, Err(PostPerspectiveRefusal::TooWide), "{angle}°");
    }
    for angle in [35.0, 60.0, 90.0, 120.0, 145.0] {
        assert!(
            post_perspective(&view, &roomy_scene(), light_at(angle), 0.0).is_ok(),
            "{angle}°"
        );
    }
}

/// It breaks gradually: the nearer the light comes to the cone, the more storage the map needs, at last more than without
/// a warp, where the guarded warp of light space stays close to the better of both.
#[test]
fn light_near_the_cone_is_bad() {
    let view = papers_camera(1.0, 40.0);
    let storage = |map: &DMat4| {
        let areas = view.corners(1.0, 40.0).map(|corner| {
            let footprint = texel_footprint(map, UVec2::splat(512), corner).expect("in front");
            footprint.area() / view.depth(corner).powi(2)
        });
        areas.into_iter().fold(0.0, f64::max)
    };
    let original = |angle| {
        storage(
            &post_perspective(&view, &roomy_scene(), light_at(angle), 0.0)
                .expect("a map")
                .clip_from_world,
        )
    };
    let warp = |angle, warp| storage(&fit(&view, &roomy_scene(), light_at(angle), warp).clip_from_world);
    assert!(
        original(31.0) > 3.0 * original(60.0),
        "{} {}",
        original(31.0),
        original(60.0)
    );
    assert!(original(60.0) > original(90.0), "{} {}", original(60.0), original(90.0));
    assert!(
        warp(31.0, Warp::Lispsm) < original(31.0),
        "{} {}",
        warp(31.0, Warp::Lispsm),
        original(31.0)
    );
}

#[test]
fn inputs_without_an_answer_are_named() {
    let view = papers_camera(1.0, 100.0);
    let (visible, body) = bodies(&view, &roomy_scene(), DVec3::NEG_Y);
    let outcome = |view, visible, body, light_travel, guard_texels| {
        fit_post_perspective(&FitInput {
            view,
            visible,
            body,
            light_travel,
            warp: Warp::Psm,
            map_size: UVec2::splat(0),
            guard_texels,
            guard_metres: 0.0,
            options: FitOptions::default(),
        })
    };
    let unfit = |unfit| Err(PostPerspectiveRefusal::Unfit(unfit));
    let (empty, nan) = (Polytope::default(), Polytope::from_box(DVec3::NAN, DVec3::NAN));
    let enormous = Polytope::from_box(DVec3::ZERO, DVec3::splat(1.0e20));
    let down = DVec3::NEG_Y;
    assert_eq!(outcome(&view, &empty, &body, down, 0.0), unfit(Unfit::NothingVisible));
    assert_eq!(outcome(&view, &nan, &body, down, 0.0), unfit(Unfit::NotFinite));
    assert_eq!(outcome(&view, &visible, &enormous, down, 0.0), unfit(Unfit::Enormous));
    assert_eq!(
        outcome(&view, &visible, &body, DVec3::ZERO, 0.0),
        unfit(Unfit::NoLightDirection)
    );
    assert_eq!(
        outcome(&view, &visible, &body, DVec3::NAN, 0.0),
        unfit(Unfit::NotFinite)
    );
    assert_eq!(outcome(&view, &visible, &body, down, f64::NAN), unfit(Unfit::NotFinite));
    let orthographic = ViewVolume::orthographic(
        DVec3::ZERO,
        DVec3::NEG_Z,
        DVec3::Y,
        DVec2::splat(-10.0),
        DVec2::splat(10.0),
        0.0,
        100.0,
    )
    .expect("a camera");
    assert_eq!(
        outcome(&orthographic, &visible, &body, down, 0.0),
        Err(PostPerspectiveRefusal::Orthographic)
    );
    let behind = Polytope::from_box(DVec3::new(-1.0, -1.0, 5.0), DVec3::new(1.0, 1.0, 9.0));
    assert!(
        outcome(&view, &behind, &behind, down, 0.0).is_err(),
        "nothing in front of the eye"
    );
    assert!(outcome(&view, &visible, &body, down, 1.0e9).is_ok_and(|fit| fit.clip_from_world.is_finite()));
}

fn direction() -> impl Strategy<Value = DVec3> {
    [-1.0..1.0, -1.0..1.0, -1.0..1.0]
        .prop_filter_map("no direction", |at: [f64; 3]| DVec3::from_array(at).try_normalize())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Whatever is not refused covers its bodies, keeps light rays in their texel and raises depth towards the light.
    #[test]
    fn maps_cover_their_bodies(
        eye in [-50.0..50.0, 0.5..30.0, -50.0..50.0], forward in direction(), light_travel in direction(),
        fov in 0.3..2.0, aspect in 0.5..2.5, near in 0.1..2.0, far in 10.0..2000.0,
    ) {
        let scene = Bounds::new(DVec3::new(-80.0, -2.0, -90.0), DVec3::new(70.0, 25.0, 100.0));
        let view = ViewVolume::perspective(DVec3::from_array(eye), forward, DVec3::Y, fov, aspect, near, far);
        prop_assume!(view.is_ok());
        let view = view.unwrap();
        let (visible, body) = bodies(&view, &scene, light_travel);
        prop_assume!(!visible.is_empty());
        let fit = post_perspective(&view, &scene, light_travel, 2.0);
        let angle = light_travel.dot(view.forward()).abs().acos();
        let corner = (view.opening() * 0.5).length().atan();
        // Outside of a cone around the whole picture there is a map, whatever is visible of it.
        prop_assert!(fit.is_ok() || angle < corner + 0.25, "{fit:?} at {angle} with corners at {corner}");
        let Ok(PostPerspectiveFit { clip_from_world: map, .. }) = fit else {
            return Ok(());
        };
        prop_assert!(map.determinant() > 0.0, "mirrored");
        for vertex in visible.vertices().iter().chain(body.vertices()) {
            let clip = map * vertex.extend(1.0);
            prop_assert!(clip.w > 0.0);
            let ndc = clip.xyz() / clip.w;
            prop_assert!(ndc.truncate().abs().max_element() <= 1.0 - 2.0 * 2.0 / 512.0 + 1.0e-6, "{ndc}");
            prop_assert!(ndc.z > 0.0 && ndc.z < 1.0, "{ndc}");
            let moved = map.project_point3(*vertex - light_travel * 0.5);
            prop_assert!((moved - ndc).truncate().length() < 1.0e-6, "{moved} from {ndc}");
            prop_assert!(moved.z > ndc.z, "depth falls towards the light");
        }
    }
}
