//! Properties that hold for random cameras, scenes and lights.

use bevy_math::{DVec2, DVec3, UVec2};
use proptest::prelude::*;
use umbrage::maths::{
    body::adjusted_depths,
    bounds::Bounds,
    fit::{FitInput, FitOptions, ProjectionCenter, WarpAxis, fit_light_view},
    footprint::texel_footprint,
    polytope::{HalfSpace, Polytope, PolytopeState},
    split::{SplitScheme, split_depths},
    view::ViewVolume,
    warp::{GuardNorm, OptimumRule, Warp},
};

use crate::{
    polytope::assert_closed,
    support::{bodies, fit},
};

pub(crate) fn point(range: f64) -> impl Strategy<Value = DVec3> {
    [-range..range, -range..range, -range..range].prop_map(DVec3::from_array)
}

pub(crate) fn direction() -> impl Strategy<Value = DVec3> {
    point(1.0).prop_filter_map("no direction", DVec3::try_normalize)
}

fn scene() -> impl Strategy<Value = Bounds> {
    (point(50.0), [0.0..200.0, 0.0..40.0, 0.0..200.0])
        .prop_map(|(min, size)| Bounds::new(min, min + DVec3::from_array(size)))
}

/// A scene and a camera near it that mostly looks at it.
pub(crate) fn seen() -> impl Strategy<Value = (Bounds, ViewVolume)> {
    let look = ([0.0..1.0, 0.0..1.0, 0.0..1.0], any::<bool>());
    (scene(), point(60.0), look, 0.2..2.4, 0.3..3.0, 0.05..2.0, 5.0..2000.0).prop_filter_map(
        "no camera",
        |(scene, eye, (target, orthographic), fov, aspect, near, far)| {
            let forward = scene.min + scene.size() * DVec3::from_array(target) - eye;
            let view = if orthographic {
                let half: DVec2 = DVec2::new(aspect, 1.0) * (20.0 * fov);
                ViewVolume::orthographic(eye, forward, DVec3::Y, -half, half, near, far)
            } else {
                ViewVolume::perspective(eye, forward, DVec3::Y, fov, aspect, near, far)
            };
            view.ok().map(|view| (scene, view))
        },
    )
}

fn warp() -> impl Strategy<Value = Warp> {
    prop_oneof![
        Just(Warp::Uniform),
        Just(Warp::Lispsm),
        Just(Warp::Psm),
        Just(Warp::Repar),
        (0.0_f32..1.0).prop_map(|focus| Warp::Tsm { focus }),
        (-1.0_f32..1.0).prop_map(|eta| Warp::Free { eta }),
    ]
}

fn options() -> impl Strategy<Value = FitOptions> {
    let depth = || prop::option::of(0.01..3000.0);
    (
        prop_oneof![
            Just(ProjectionCenter::Continuous),
            Just(ProjectionCenter::NearestVertex)
        ],
        prop_oneof![
            Just(OptimumRule::Derived),
            Just(OptimumRule::Literal),
            Just(OptimumRule::Demo)
        ],
        [depth(), depth(), depth()],
        prop_oneof![
            Just(WarpAxis::View),
            Just(WarpAxis::Middle),
            direction().prop_map(WarpAxis::Direction)
        ],
        any::<bool>(),
        prop_oneof![Just(GuardNorm::Storage), Just(GuardNorm::Largest)],
    )
        .prop_map(
            |(center, optimum, [pseudo_near, pseudo_far, visible_far], axis, guard, guard_norm)| FitOptions {
                center,
                optimum,
                pseudo_near,
                pseudo_far,
                visible_far,
                axis,
                guard,
                guard_norm,
                ..FitOptions::default()
            },
        )
}

/// Any direction, or (nearly) along the view.
pub(crate) fn light_for(view: &ViewVolume, direction: DVec3, along: u8) -> DVec3 {
    match along {
        0 => view.forward(),
        1 => -view.forward(),
        2 => view.forward() + direction * 1.0e-4,
        3 => direction * 1.0e-3 - view.forward(),
        _ => direction,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn clipping_never_grows(min in point(10.0), size in point(10.0), planes in prop::collection::vec((point(10.0), direction()), 1..20)) {
        let mut body = Polytope::from_box(min, min + size.abs());
        for (point, normal) in planes {
            let half_space = HalfSpace::through(point, normal);
            let before = body.clone();
            body = body.clip(&half_space);
            prop_assert!(body.volume() <= before.volume() + 1.0e-6);
            for vertex in body.vertices() {
                prop_assert!(before.contains(*vertex, 1.0e-6));
                prop_assert!(half_space.excess(*vertex) <= 1.0e-6);
            }
            if body.state() == PolytopeState::Solid {
                assert_closed(&body);
            }
        }
    }

    /// What is cut off and what is left make the whole.
    #[test]
    fn clipping_divides(points in prop::collection::vec(point(10.0), 4..12), through in point(5.0), normal in direction()) {
        let whole = Polytope::hull(&points);
        let half_space = HalfSpace::through(through, normal);
        let rest = HalfSpace::through(through, -normal);
        let sum = whole.clone().clip(&half_space).volume() + whole.clone().clip(&rest).volume();
        prop_assert!((sum - whole.volume()).abs() <= 1.0e-6 * whole.volume().max(1.0), "{sum} against {}", whole.volume());
    }

    #[test]
    fn hulls_contain_their_points(points in prop::collection::vec(point(10.0), 4..14)) {
        let hull = Polytope::hull(&points);
        assert_closed(&hull);
        for point in points {
            prop_assert!(hull.contains(point, 1.0e-6));
        }
    }

    #[test]
    fn sweeping_is_the_hull_of_both_ends(points in prop::collection::vec(point(10.0), 4..10), along in direction(), distance in 0.1..50.0) {
        let body = Polytope::hull(&points);
        let swept = body.sweep(along, distance);
        let ends: Vec<DVec3> = body.vertices().iter().flat_map(|vertex| [*vertex, vertex + along * distance]).collect();
        let hull = Polytope::hull(&ends);
        prop_assert!((swept.volume() - hull.volume()).abs() <= 1.0e-5 * hull.volume().max(1.0));
    }

    /// Stingl, oracle 17.
    #[test]
    fn the_intersection_body((scene, view) in seen(), direction in direction(), along in 0_u8..8, shares in [0.0..1.0, 0.0..1.0, 0.0..1.0]) {
        let light = light_for(&view, direction, along);
        let (visible, body) = bodies(&view, &scene, light);
        prop_assume!(!visible.is_empty());
        let tolerance = 1.0e-5;
        for vertex in visible.vertices() {
            prop_assert!(body.contains(*vertex, tolerance), "H sticks out of B at {vertex}");
        }
        for vertex in body.vertices() {
            prop_assert!(scene.contains(*vertex, tolerance), "B sticks out of S at {vertex}");
        }
        prop_assume!(visible.state() == PolytopeState::Solid && visible.volume() > 1.0e-3);
        // From a point of B the light reaches H: the shadow ray passes all half-spaces of H at once.
        let blend = DVec3::from_array(shares);
        let pick = |share: f64| body.vertices()[((share * body.vertices().len() as f64) as usize).min(body.vertices().len() - 1)];
        let point = (pick(blend.x) + pick(blend.y) + pick(blend.z)) / 3.0;
        let light = light.normalize();
        let (mut from, mut to) = (-1.0e-3, f64::INFINITY);
        for face in visible.faces() {
            let speed = face.half_space.normal.dot(light);
            let excess = face.half_space.excess(point) - 1.0e-3;
            if speed > 1.0e-9 { to = f64::min(to, -excess / speed); }
            else if speed < -1.0e-9 { from = f64::max(from, -excess / speed); }
            else { prop_assert!(excess <= 0.0); }
        }
        prop_assert!(from <= to, "the shadow of {point} misses H: {from} to {to}");
    }

    /// Stingl, oracles 16, 17 and 19, for every warp and option, parallel light included.
    #[test]
    fn light_views_cover_their_bodies((scene, view) in seen(), direction in direction(), along in 0_u8..8, warp in warp(), options in options()) {
        let light_travel = light_for(&view, direction, along);
        let (visible, body) = bodies(&view, &scene, light_travel);
        prop_assume!(!visible.is_empty());
        let guard_texels = 2.0;
        let fit = fit_light_view(&FitInput { view: &view, visible: &visible, body: &body, light_travel, warp, map_size: UVec2::splat(512), guard_texels, guard_metres: 0.0, options }).fitted();
        prop_assert!(fit.is_some());
        let fit = fit.unwrap();
        prop_assert!(fit.clip_from_light.determinant() > 0.0, "mirrored");
        prop_assert!((fit.world_from_light.determinant() - 1.0).abs() < 1.0e-9, "not rigid");
        let towards_light = -light_travel.normalize();
        let along_axis = |vertex: &DVec3| fit.axes.y.dot(*vertex);
        let ends = body.vertices().iter().chain(visible.vertices()).map(along_axis);
        let (first, last) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), y| (first.min(y), last.max(y)));
        let extent = last - first;
        let inner = 1.0 - guard_texels * 2.0 / 512.0 + 1.0e-6;
        for vertex in visible.vertices().iter().chain(body.vertices()) {
            let clip = fit.clip_from_world * vertex.extend(1.0);
            prop_assert!(clip.w > 0.0, "behind the projection centre");
            let ndc = clip.truncate() / clip.w;
            prop_assert!(ndc.x.abs() <= inner && ndc.y.abs() <= inner, "{ndc}");
            prop_assert!(ndc.z > 0.0 && ndc.z < 1.0, "{ndc}");
            let moved = fit.clip_from_world.project_point3(*vertex + towards_light * 0.5);
            prop_assert!((moved - ndc).truncate().length() < 1.0e-6, "moving along the light changes the texel");
            prop_assert!(moved.z > ndc.z, "depth falls towards the light");
            let footprint = texel_footprint(&fit.clip_from_world, UVec2::splat(512), *vertex);
            prop_assert!(footprint.is_some_and(|footprint| footprint.area() > 0.0));
            let (across, along) = footprint.map(|footprint| (footprint.across.length(), footprint.along.dot(fit.axes.y))).unwrap_or((f64::NAN, f64::NAN));
            prop_assert!(across <= fit.relative_texel_size * clip.w * (1.0 + 1.0e-6), "a texel {across} m wide at w = {}", clip.w);
            if clip.w * clip.w <= (1.0 + extent / fit.warp_near).min(1.0e6) {
                prop_assert!(along <= fit.relative_texel_size * clip.w * (1.0 + 1.0e-6), "a texel {along} m long at w = {}", clip.w);
            }
            prop_assert!(across.max(along) >= fit.near_texel_size * (1.0 - 1.0e-6), "a texel of {across} m by {along} m");
        }
        // In single precision everything still lies inside the map.
        let single = fit.clip_from_world_f32();
        for vertex in body.vertices() {
            let ndc = single.project_point3(vertex.as_vec3());
            prop_assert!(ndc.truncate().abs().max_element() <= 1.0 && (0.0..=1.0).contains(&ndc.z), "{ndc}");
        }
    }

    /// The sweep adds casters, never texels: B has the light-plane outline of H.
    #[test]
    fn bodies_share_their_outline((scene, view) in seen(), light in direction()) {
        let (visible, body) = bodies(&view, &scene, light);
        prop_assume!(visible.state() == PolytopeState::Solid);
        let (right, up) = light.any_orthonormal_pair();
        let outline = |body: &Polytope| Bounds::from_points(body.vertices().iter().map(|vertex| DVec3::new(vertex.dot(right), vertex.dot(up), 0.0)));
        let (small, large) = (outline(&visible), outline(&body));
        prop_assert!(small.min.distance(large.min) < 1.0e-4 && small.max.distance(large.max) < 1.0e-4, "{small:?} {large:?}");
    }

    #[test]
    fn adjusted_depths_shrink((scene, view) in seen(), light in direction()) {
        let (visible, _) = bodies(&view, &scene, light);
        if let Some((near, far)) = adjusted_depths(&visible, &view) {
            prop_assert!(near >= view.near() && near < far);
            prop_assert!(far <= view.far() * (1.0 + 1.0e-5) + 1.0e-5);
            // Focusing on the shortened view loses nothing.
            let (again, _) = bodies(&view.split(near, far), &scene, light);
            prop_assert!((again.volume() - visible.volume()).abs() <= 1.0e-5 * visible.volume().max(1.0));
        }
    }

    #[test]
    fn splits_increase(near in 0.01..10.0, length in 0.1..10000.0, count in 0_usize..20, lambda in 0.0_f32..1.0, inner in prop::collection::vec(-10.0_f32..1000.0, 0..20)) {
        for scheme in [SplitScheme::Uniform, SplitScheme::Logarithmic, SplitScheme::Practical { lambda }, SplitScheme::Manual(inner)] {
            let depths = split_depths(&scheme, near, near + length, count);
            prop_assert_eq!(depths.len(), count.clamp(1, 16) + 1);
            prop_assert!(depths.is_sorted_by(|a, b| a < b), "{:?}", depths);
            prop_assert_eq!((depths[0], depths[depths.len() - 1]), (near, near + length));
        }
    }

    /// A warped map is never worse than the unwarped one by more than a fiftieth, by the measure of storage, wherever the
    /// light is.
    #[test]
    fn the_guard_holds(direction in direction(), far in 5.0..2000.0) {
        let view = ViewVolume::perspective(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.5, 0.5, far).unwrap();
        let scene = Bounds::new(DVec3::splat(-1.0e4), DVec3::splat(1.0e4));
        let (visible, _) = bodies(&view, &scene, direction);
        let storage = |warp| {
            let fit = fit(&view, &scene, direction, warp);
            let errors = visible.vertices().iter().map(|vertex| {
                let footprint = texel_footprint(&fit.clip_from_world, UVec2::splat(1024), *vertex).unwrap();
                // Beside the axis texels are sheared; the papers count their extent along it.
                DVec2::new(footprint.across.length(), footprint.along.dot(fit.axes.y)) / view.depth(*vertex)
            }).fold(DVec2::ZERO, DVec2::max);
            errors.x * errors.y
        };
        let (uniform, warped) = (storage(Warp::Uniform), storage(Warp::Lispsm));
        // The guard's tolerance of a fiftieth.
        prop_assert!(warped <= uniform * 1.021, "{warped} against {uniform}");
    }
}
