//! What holds exactly: Theorem 1, Proposition 3, directional lights, slopes of depth (oracles O13, O19, O22).

use bevy_math::{DMat2, DVec2, DVec3, UVec2, Vec3Swizzles, Vec4Swizzles};
use umbrage::maths::{
    light_plane::space::{
        FilmFitInput, FilmMetric, FilmObjective, FilmProblem, FilmSample, depth_form, fit_film, plane_form,
        point_light_clip_from_world,
    },
    polytope::Polytope,
};

use super::scene::{
    Camera, Lit, Piece, axes_along, camera_two, lit_along, lit_from, lit_over_receivers, scene_two, sunlit,
};
use crate::support::close;

/// ∂v/∂pixel of samples: 1 ÷ w (I − u kᵀ ÷ w) ∂u/∂pixel.
fn jacobians(lit: &Lit, bend: DVec2, piece: usize) -> Vec<DMat2> {
    let of_piece = lit
        .samples
        .iter()
        .zip(&lit.points)
        .filter(|(_, (_, index))| *index == piece);
    let jacobian = |sample: &FilmSample| {
        let width = 1.0 + bend.dot(sample.film);
        let outer = DMat2::from_cols(sample.film * bend.x, sample.film * bend.y);
        (DMat2::IDENTITY - outer * (1.0 / width)) * (1.0 / width) * sample.pixels_from_film.inverse()
    };
    of_piece.map(|(sample, _)| jacobian(sample)).collect()
}

#[track_caller]
fn assert_constant(jacobians: &[DMat2], tolerance: f64) -> DMat2 {
    assert!(jacobians.len() > 50, "{} samples", jacobians.len());
    let largest = jacobians[0]
        .to_cols_array()
        .into_iter()
        .fold(0.0_f64, |a, b| a.max(b.abs()));
    for other in jacobians {
        assert!(
            other.abs_diff_eq(jacobians[0], tolerance * largest),
            "{other} differs from {}",
            jacobians[0]
        );
    }
    jacobians[0]
}

fn floor_of_sixty() -> Piece {
    Piece {
        point: DVec3::ZERO,
        normal: DVec3::Y,
        contains: |point| point.x.abs() < 60.0 && point.z > -40.0,
    }
}

#[test]
fn theorem_one_in_space() {
    let camera = camera_two(UVec2::new(96, 64));
    let floor = [floor_of_sixty()];
    let light = DVec3::new(3.0, 7.0, -6.0);
    let lit = lit_along(&camera, &floor, light, axes_along(DVec3::NEG_Y, DVec3::Z));
    let plane = plane_form(DVec3::ZERO, DVec3::Y);
    let bend = lit.base.bend_of_plane(depth_form(&camera.view), plane).expect("valid");
    assert_constant(&jacobians(&lit, bend, 0), 1.0e-11);
    // On the film that looks at the middle of the floor areas differ by a factor of 5.8 · 10⁵.
    let middle = lit.points.iter().map(|(point, _)| *point).sum::<DVec3>() / lit.points.len() as f64;
    let towards = middle - light;
    let looking = lit.base.bend_of(towards.extend(-towards.dot(light))).expect("in front");
    let determinants = jacobians(&lit, looking, 0)
        .into_iter()
        .map(|jacobian| jacobian.determinant().abs());
    let (low, high) = determinants.fold((f64::INFINITY, 0.0_f64), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    close(high / low, 5.8e5, 0.01);
    // The same film, made the base film: the specification's number.
    let tilted = axes_along(lit.base.width_form(bend).xyz(), DVec3::new(0.3, 1.0, 0.2));
    let straight = lit_along(&camera, &floor, light, tilted);
    let jacobian = assert_constant(&jacobians(&straight, DVec2::ZERO, 0), 1.0e-11);
    close(jacobian.determinant().abs(), 0.002_882_204_0, 1.0e-8);
    // The form of w means the same over any base film.
    let scaled = lit_over_receivers(&camera, &floor, light, *lit.base.axes());
    let rebased = scaled.base.bend_of(lit.base.width_form(bend)).expect("valid");
    let direct = scaled
        .base
        .bend_of_plane(depth_form(&camera.view), plane)
        .expect("valid");
    assert!(rebased.distance(direct) < 1.0e-9, "{rebased} {direct}");
    assert_constant(&jacobians(&scaled, rebased, 0), 1.0e-11);
}

/// A plane parallel to the picture needs no special case: its film is parallel to it.
#[test]
fn a_plane_across_the_view() {
    let camera = camera_two(UVec2::new(48, 32));
    let forward = camera.view.forward();
    let wall = [Piece {
        point: DVec3::new(2.0, -1.0, -10.0),
        normal: DVec3::new(-0.2, 0.3, 1.0),
        contains: |_| true,
    }];
    let lit = lit_from(&camera, &wall, DVec3::new(-4.0, 8.0, -2.0));
    let plane = plane_form(wall[0].point, -forward);
    let bend = lit.base.bend_of_plane(depth_form(&camera.view), plane).expect("valid");
    assert_constant(&jacobians(&lit, bend, 0), 1.0e-12);
    let normal = lit.base.width_form(bend).xyz().normalize();
    assert!(normal.distance(forward) < 1.0e-9, "{normal}");
}

/// Three planes of different directions.
fn three_pieces() -> [Piece; 3] {
    [
        floor_of_sixty(),
        Piece {
            point: DVec3::new(0.0, 0.0, -12.0),
            normal: DVec3::new(0.3, 0.1, 1.0),
            contains: |point| point.y > 0.0 && point.y < 4.0,
        },
        Piece {
            point: DVec3::new(-3.0, 0.0, 0.0),
            normal: DVec3::new(1.0, 0.2, 0.3),
            contains: |point| point.y > 0.0 && point.y < 3.0 && point.z < -5.0,
        },
    ]
}

/// Proposition 3: the light in the plane w = 0 of the camera with the camera's axis. On every polygon ∂u/∂pixel is
/// constant, whatever the roll; its determinant in units of a film at distance 1 is 1 − α · Δ.
#[test]
fn proposition_three_in_space() {
    let camera = camera_two(UVec2::new(96, 64));
    let view = &camera.view;
    let forward = view.forward();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let light = view.eye() + right * 2.5 + up * 1.7;
    let pieces = three_pieces();
    let lit = lit_along(&camera, &pieces, light, axes_along(forward, DVec3::new(0.4, 1.0, 0.0)));
    for (index, piece) in pieces.iter().enumerate() {
        let jacobian = assert_constant(&jacobians(&lit, DVec2::ZERO, index), 1.0e-10);
        // 1 ÷ depth = α · u + β on a plane n · (p − q) = 0, where p = eye + depth (u_x right + u_y up + forward).
        let depth = (piece.point - view.eye()).dot(piece.normal);
        let alpha = DVec2::new(right.dot(piece.normal), up.dot(piece.normal)) / depth;
        let pixel = DVec2::new(1.5, 1.0) * 30.0_f64.to_radians().tan() * 2.0 / DVec2::new(96.0, 64.0);
        let expected = (1.0 - alpha.dot(DVec2::new(2.5, 1.7))) * pixel.element_product();
        close(jacobian.determinant().abs(), expected.abs(), 1.0e-9);
        // The film of Theorem 1 is this one for every plane.
        let bend = lit
            .base
            .bend_of_plane(depth_form(view), plane_form(piece.point, piece.normal));
        assert!(bend.expect("valid").length() < 1.0e-12, "{bend:?}");
    }
    let askew = lit_along(&camera, &pieces, light, axes_along(forward + up * 0.09, DVec3::Y));
    let first = jacobians(&askew, DVec2::ZERO, 0);
    assert!(
        first
            .iter()
            .any(|other| !other.abs_diff_eq(first[0], 0.05 * first[0].determinant().abs().sqrt())),
        "a film that is tilted by 5 degrees is not constant"
    );
}

/// The sun: the family of w with the light's direction in w = 0 holds the films of both theorems.
#[test]
fn the_theorems_hold_for_the_sun() {
    let camera = camera_two(UVec2::new(96, 64));
    let floor = [floor_of_sixty()];
    let lit = sunlit(&camera, &floor, DVec3::new(0.5, -1.0, -0.3));
    let plane = plane_form(DVec3::ZERO, DVec3::Y);
    let bend = lit.base.bend_of_plane(depth_form(&camera.view), plane).expect("valid");
    assert_constant(&jacobians(&lit, bend, 0), 1.0e-11);
    for metric in [FilmMetric::Area, FilmMetric::Stretch] {
        let objective = FilmObjective {
            metric,
            ..FilmObjective::default()
        };
        let film = lit
            .bin()
            .problem(objective)
            .expect("samples")
            .solve(&[])
            .expect("samples");
        let constant = lit
            .bin()
            .problem(objective)
            .expect("samples")
            .film_at(bend)
            .expect("valid");
        assert!(film.error <= constant.error * (1.0 + 1.0e-9), "{metric:?}");
    }
    // Light across the view: w is the view depth, for every plane.
    let forward = camera.view.forward();
    let across = forward.cross(DVec3::new(-1.0, 0.2, 0.1)).normalize();
    let down = if across.y > 0.0 { -across } else { across };
    let pieces = [floor_of_sixty()];
    let lit = sunlit(&camera, &pieces, down);
    let depth_bend = lit.base.bend_of(depth_form(&camera.view)).expect("valid");
    assert_constant(&jacobians(&lit, depth_bend, 0), 1.0e-11);
    for normal in [DVec3::Y, DVec3::new(0.1, 1.0, 0.4)] {
        let bend = lit
            .base
            .bend_of_plane(depth_form(&camera.view), plane_form(DVec3::ZERO, normal));
        assert!(bend.expect("valid").distance(depth_bend) < 1.0e-9, "{bend:?}");
    }
}

/// On a plane in front of any film depth changes evenly over the map; the formula of slopes is that of the plane in clip
/// space. And depth falls steadily away from the light.
#[test]
fn slopes_of_depth_are_constant() {
    let camera = camera_two(UVec2::new(72, 48));
    let pieces = scene_two();
    let light = DVec3::new(-4.0, 8.0, -2.0);
    let lit = lit_from(&camera, &pieces, light);
    let problem = FilmProblem::new(&lit.moments(), &lit.hull_of_middles(), FilmObjective::default()).expect("samples");
    for bend in [DVec2::ZERO, DVec2::new(-1.0, -0.05)] {
        let film = problem.film_at(bend).expect("valid");
        let width = lit.base.width_form(bend);
        let widths = lit.points.iter().map(|(point, _)| width.dot(point.extend(1.0)));
        let (low, high) = widths.fold((f64::INFINITY, 0.0_f64), |(low, high), w| (low.min(w), high.max(w)));
        let size = UVec2::splat(128);
        let clip_from_world =
            point_light_clip_from_world(&lit.base, &film, size, 0.0, 0.9 * low, 1.1 * high).expect("a range");
        for (index, piece) in pieces.iter().enumerate() {
            let in_clip = clip_from_world.inverse().transpose() * plane_form(piece.point, piece.normal);
            let slopes = -in_clip.xy() / in_clip.z;
            let on_piece = || lit.points.iter().filter(|(_, of)| *of == index);
            let ndc: Vec<DVec3> = on_piece()
                .map(|(point, _)| clip_from_world.project_point3(*point))
                .collect();
            for place in &ndc {
                let expected = ndc[0].z + slopes.dot(place.xy() - ndc[0].xy());
                assert!((place.z - expected).abs() < 1.0e-11, "{place} {expected}");
                assert!(place.xy().abs().max_element() < 1.0 + 1.0e-9, "{place}");
                assert!(place.z > 0.0 && place.z < 1.0, "{place}");
            }
        }
        for (point, _) in lit.points.iter().step_by(97) {
            let nearer = clip_from_world.project_point3(point.lerp(light, 0.1));
            let ndc = clip_from_world.project_point3(*point);
            assert!(
                nearer.z > ndc.z && nearer.xy().distance(ndc.xy()) < 1.0e-9,
                "{nearer} {ndc}"
            );
        }
    }
    assert!(
        point_light_clip_from_world(
            &lit.base,
            &problem.film_at(DVec2::ZERO).expect("valid"),
            UVec2::splat(8),
            0.0,
            2.0,
            1.0
        )
        .is_none(),
        "no range"
    );
}

/// The same for the sun, through the matrix that is drawn with: reverse z, casters between light and receivers included.
#[test]
fn slopes_of_depth_are_constant_in_the_sun() {
    let camera = camera_two(UVec2::new(72, 48));
    let pieces = scene_two();
    let travel = DVec3::new(0.5, -1.0, -0.3);
    let lit = sunlit(&camera, &pieces, travel);
    let bin = lit.bin();
    let problem = bin.problem(FilmObjective::default()).expect("samples");
    let best = problem.solve(&[]).expect("samples");
    let corners: Vec<DVec3> = lit.points.iter().map(|(point, _)| *point).step_by(67).collect();
    let visible = Polytope::hull(&corners[..corners.len().min(40)]);
    let body = visible.sweep(-travel.normalize(), 3.0);
    for bend in [DVec2::ZERO, best.bend * 0.5, best.bend] {
        let film = problem.film_at(bend).expect("valid");
        let fit = fit_film(&FilmFitInput {
            view: &camera.view,
            visible: &visible,
            body: &body,
            base: &lit.base,
            film: &film,
            hull: problem.hull(),
            map_size: UVec2::splat(128),
            guard_texels: 0.0,
        });
        let clip_from_world = fit.expect("a proper film").clip_from_world;
        for (index, piece) in pieces.iter().enumerate() {
            let in_clip = clip_from_world.inverse().transpose() * plane_form(piece.point, piece.normal);
            let slopes = -in_clip.xy() / in_clip.z;
            let on_piece = lit.points.iter().filter(|(_, of)| *of == index);
            let ndc: Vec<DVec3> = on_piece
                .map(|(point, _)| clip_from_world.project_point3(*point))
                .collect();
            for place in &ndc {
                let expected = ndc[0].z + slopes.dot(place.xy() - ndc[0].xy());
                assert!((place.z - expected).abs() < 1.0e-9, "{bend}: {place} {expected}");
            }
        }
        for (point, _) in lit.points.iter().step_by(97) {
            let nearer = clip_from_world.project_point3(*point - travel);
            let ndc = clip_from_world.project_point3(*point);
            assert!(
                nearer.z > ndc.z && nearer.xy().distance(ndc.xy()) < 1.0e-9,
                "{nearer} {ndc}"
            );
        }
    }
}

/// A camera that is not level changes nothing: fewer assumptions than flatland.
#[test]
fn a_rolled_light_frame_changes_nothing() {
    let camera = Camera::new(
        DVec3::new(1.0, 3.0, 2.0),
        DVec3::new(-0.4, -0.5, -1.0),
        0.5,
        1.2,
        UVec2::new(48, 40),
    );
    let floor = [floor_of_sixty()];
    let error = |up: DVec3| {
        let lit = lit_along(
            &camera,
            &floor,
            DVec3::new(5.0, 9.0, -3.0),
            axes_along(DVec3::new(-0.6, -1.0, -0.4), up),
        );
        let problem = lit.bin().problem(FilmObjective::default()).expect("samples");
        problem.solve(&[]).expect("samples").error
    };
    close(error(DVec3::Y), error(DVec3::new(1.0, 0.3, 0.9)), 1.0e-5);
}
