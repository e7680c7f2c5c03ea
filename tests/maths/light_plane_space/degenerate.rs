//! Inputs without an answer give a named one; nothing panics.

use bevy_math::{DMat2, DMat4, DVec2, DVec3, DVec4, USizeVec2, UVec2};
use umbrage::maths::{
    fit::LightAxes,
    light_plane::space::{
        BaseFilm, Damping, DepthSlices, FilmBin, FilmError, FilmFitInput, FilmHull, FilmMoments, FilmObjective,
        FilmProblem, FilmSample, FilmTiles, MergeLimits, SampleGrid, Unsampled, fit_film, plane_form, slice_by_depth,
    },
    polytope::Polytope,
};

use super::scene::{Camera, axes_along, camera_on_floor, sunlit, whole_floor};

fn axes() -> LightAxes {
    LightAxes::new(DVec3::NEG_Z, DVec3::Y, DVec3::new(0.2, -1.0, -0.3)).expect("a light")
}

/// The pencil of a spot is that of a point whose axis is the cone's, over what its cone lights: receivers beside or behind
/// the light, for which a point has no film, are not among them.
#[test]
fn a_spot_is_a_point_that_lights_a_cone() {
    let (position, axis) = (DVec3::new(0.0, 4.0, -6.0), DVec3::new(0.2, -1.0, -0.1).normalize());
    let axes = axes_along(axis, DVec3::Z);
    let camera = camera_on_floor(UVec2::new(48, 27));
    let floor = camera.hits(&whole_floor());
    let mut points: Vec<DVec3> = floor.iter().map(|(point, _)| *point).collect();
    points.push(position + DVec3::Y);
    assert_eq!(BaseFilm::of_point(position, axes, &points), Err(FilmError::TooWide));
    let half_angle = 35.0_f64.to_radians();
    let in_cone: Vec<DVec3> = points
        .iter()
        .copied()
        .filter(|point| (point - position).angle_between(axis) <= half_angle)
        .collect();
    assert!(in_cone.len() > 100, "{} points in the cone", in_cone.len());
    let base = BaseFilm::of_point(position, axes, &in_cone).expect("in front of the spot");
    let samples: Vec<FilmSample> = in_cone
        .iter()
        .map(|point| FilmSample::new(&base, &camera.grid, *point, DVec3::Y).expect("a lit point"))
        .collect();
    let hull = FilmHull::of_samples(&samples).expect("an area");
    let bin = FilmBin::of_samples(&samples);
    let problem = bin.problem(FilmObjective::default()).expect("a problem");
    let optimum = problem.solve(&[]).expect("a film");
    let unbent = problem.film_at(DVec2::ZERO).expect("a film");
    assert!(hull.is_valid(optimum.bend), "w > 0 in the cone");
    assert!(
        optimum.error < 0.9 * unbent.error,
        "{} of {}",
        optimum.error,
        unbent.error
    );
}

#[test]
fn base_films() {
    assert_eq!(BaseFilm::of_sun(axes(), &[]), Err(FilmError::NothingVisible));
    assert_eq!(BaseFilm::of_sun(axes(), &[DVec3::NAN]), Err(FilmError::NotFinite));
    assert_eq!(
        BaseFilm::of_sun(axes(), &[DVec3::splat(1.0e15)]),
        Err(FilmError::NotFinite)
    );
    let light = DVec3::new(0.0, 5.0, 0.0);
    let down = axes_along(DVec3::NEG_Y, DVec3::Z);
    let beside = [DVec3::ZERO, DVec3::new(3.0, 5.0, 0.0)];
    assert_eq!(BaseFilm::of_point(light, down, &beside), Err(FilmError::TooWide));
    assert_eq!(BaseFilm::of_point(DVec3::NAN, down, &beside), Err(FilmError::NotFinite));
    // One point has a base film, however small.
    let single = BaseFilm::of_sun(axes(), &[DVec3::ONE]).expect("a point");
    assert!(
        single.film(DVec3::ONE).is_some_and(|film| film.length() < 1.0e-3),
        "{single:?}"
    );
    // A form that is nowhere positive, or grazes the plane.
    let base = BaseFilm::of_sun(axes(), &[DVec3::ZERO, DVec3::ONE]).expect("receivers");
    assert_eq!(base.bend_of(-DVec4::W), None);
    assert_eq!(base.bend_of(DVec4::NAN), None);
    let grazed = plane_form(DVec3::ZERO, axes().x);
    assert_eq!(base.bend_of_plane(DVec3::NEG_Z.extend(1.0), grazed), None);
}

fn grid() -> SampleGrid {
    camera_on_floor(UVec2::new(8, 8)).grid
}

#[test]
fn samples() {
    let base = BaseFilm::of_sun(axes(), &[DVec3::ZERO, DVec3::ONE]).expect("receivers");
    let ahead = DVec3::new(0.5, 0.0, -3.0);
    let sample = |point, normal| FilmSample::new(&base, &grid(), point, normal);
    assert!(sample(ahead, DVec3::Y).is_ok(), "a floor");
    assert_eq!(sample(DVec3::NAN, DVec3::Y), Err(Unsampled::NotFinite));
    assert_eq!(sample(ahead, DVec3::ZERO), Err(Unsampled::NotFinite));
    assert_eq!(sample(ahead, DVec3::NAN), Err(Unsampled::NotFinite));
    assert_eq!(sample(ahead, DVec3::NEG_Y), Err(Unsampled::FacesAway));
    assert_eq!(sample(DVec3::new(0.0, 3.0, 9.0), DVec3::Y), Err(Unsampled::NotInFront));
    // Edge-on to the camera: the normal is across the ray and still looks to the light.
    let ray = ahead - DVec3::new(0.0, 3.0, 0.0);
    let across = axes().z.reject_from(ray);
    let edge_on = sample(ahead, across).map(|sample| sample.pixels_from_film.determinant().abs());
    assert!(
        edge_on.is_err() || edge_on.is_ok_and(|area| area < 1.0e-6),
        "{edge_on:?}"
    );
    let broken = SampleGrid {
        clip_from_world: DMat4::NAN,
        ..grid()
    };
    assert_eq!(
        FilmSample::new(&base, &broken, ahead, DVec3::Y),
        Err(Unsampled::NotInFront)
    );
    // Grazed by the light: counted, but not for any number of pixels.
    let grazing = axes().z.any_orthonormal_vector() + axes().z * 1.0e-9;
    let grazing = if grazing.dot(ray) > 0.0 {
        axes().z * 2.0e-9 - grazing
    } else {
        grazing
    };
    let (grazed, lit) = (
        sample(ahead, grazing).expect("lit"),
        sample(ahead, axes().z).expect("lit"),
    );
    let area = |sample: &FilmSample| sample.pixels_from_film.determinant().abs();
    assert!(area(&grazed) < 25.0 * area(&lit), "{} {}", area(&grazed), area(&lit));
    // A pixel that reaches over the horizon of its plane keeps a bounded corner.
    let far = sample(DVec3::new(0.0, 0.0, -4000.0), DVec3::Y).expect("lit");
    assert!(far.corners.iter().all(|corner| corner.is_finite()), "{far:?}");
}

#[test]
fn hulls_and_problems() {
    assert_eq!(FilmHull::new([]), Err(FilmError::NothingVisible));
    assert_eq!(FilmHull::new([DVec2::NAN, DVec2::ONE]), Err(FilmError::NotFinite));
    assert_eq!(FilmHull::new([DVec2::ONE; 5]), Err(FilmError::NoArea));
    assert_eq!(
        FilmHull::new([DVec2::ZERO, DVec2::ONE, DVec2::splat(0.3)]),
        Err(FilmError::NoArea)
    );
    assert_eq!(FilmHull::from_supports(&[1.0, 1.0]), Err(FilmError::NothingVisible));
    assert_eq!(
        FilmHull::from_supports(&[f64::NEG_INFINITY; 32]),
        Err(FilmError::NotFinite)
    );
    let square = FilmHull::new([DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y]).expect("an area");
    let objective = FilmObjective::default();
    let problem = |moments: FilmMoments| FilmProblem::new(&moments, &square, objective).map(|_| ());
    assert_eq!(problem(FilmMoments::default()), Err(FilmError::NothingVisible));
    let not_a_number = FilmMoments {
        pixels: f64::NAN,
        ..FilmMoments::default()
    };
    assert_eq!(problem(not_a_number), Err(FilmError::NotFinite));
    assert!(FilmBin::default().problem(objective).is_err(), "no samples");
}

/// One sample is enough: its pixel is the film.
#[test]
fn one_sample() {
    let camera = Camera::new(
        DVec3::new(0.0, 3.0, 0.0),
        DVec3::new(0.0, -1.0, -1.0),
        0.4,
        1.0,
        UVec2::ONE,
    );
    let lit = sunlit(&camera, &whole_floor(), DVec3::new(0.1, -1.0, 0.2));
    assert_eq!(lit.samples.len(), 1);
    let film = lit
        .bin()
        .problem(FilmObjective::default())
        .expect("a pixel")
        .solve(&[])
        .expect("a pixel");
    // Linear in the pixel, which is not small: the area is right to what the plane's perspective does within it.
    assert!(film.mean_error(1.0) > 0.5 && film.mean_error(1.0) < 2.0, "{film:?}");
}

/// Light along the view direction, both ways, has nothing to warp but is no special case; an orthographic camera neither.
#[test]
fn light_along_the_view() {
    let camera = camera_on_floor(UVec2::new(36, 24));
    let lit = sunlit(&camera, &whole_floor(), camera.view.forward());
    let problem = lit.bin().problem(FilmObjective::default()).expect("samples");
    let film = problem.solve(&[]).expect("samples");
    let bound = 36.0 * 24.0 / 4096.0;
    assert!(
        (film.mean_error(4096.0) / bound - 1.0).abs() < 0.01,
        "{}",
        film.mean_error(4096.0)
    );
    let points: Vec<DVec3> = lit.points.iter().map(|(point, _)| *point).step_by(60).collect();
    let visible = Polytope::hull(&points);
    let input = FilmFitInput {
        view: &camera.view,
        visible: &visible,
        body: &visible,
        base: &lit.base,
        film: &film,
        hull: problem.hull(),
        map_size: UVec2::splat(64),
        guard_texels: 1.0,
    };
    assert!(
        fit_film(&input).is_ok_and(|fit| fit.clip_from_world.is_finite()),
        "flat bodies are padded"
    );
    let empty = Polytope::default();
    assert_eq!(
        fit_film(&FilmFitInput {
            visible: &empty,
            ..input
        })
        .map(|_| ()),
        Err(FilmError::NothingVisible)
    );
    let no_texels = FilmFitInput {
        map_size: UVec2::new(0, 64),
        ..input
    };
    assert_eq!(fit_film(&no_texels).map(|_| ()), Err(FilmError::NoTexels));
    let not_a_number = FilmFitInput {
        guard_texels: f64::NAN,
        ..input
    };
    assert_eq!(fit_film(&not_a_number).map(|_| ()), Err(FilmError::NotFinite));
    let absurd = FilmFitInput {
        guard_texels: 1.0e9,
        ..input
    };
    assert!(
        fit_film(&absurd).is_ok_and(|fit| fit.clip_from_world.is_finite()),
        "clamped"
    );
}

#[test]
fn partitions() {
    let objective = FilmObjective::default();
    let none = FilmTiles::new(USizeVec2::ZERO).merged(&MergeLimits::default(), objective);
    assert_eq!(none.map(|_| ()), Err(FilmError::NothingVisible));
    assert!(DepthSlices::new(0, 1.0, 2.0).is_none(), "no slices");
    assert!(DepthSlices::new(3, 0.0, 2.0).is_none(), "no near plane");
    assert!(DepthSlices::new(3, 2.0, f64::INFINITY).is_none(), "no far plane");
    let empty = DepthSlices::new(3, 1.0, 9.0).expect("a range");
    assert_eq!(
        slice_by_depth(&empty, &MergeLimits::default(), objective),
        Err(FilmError::NothingVisible)
    );
    // Limits of nothing still give a film.
    let lit = sunlit(
        &camera_on_floor(UVec2::new(9, 6)),
        &whole_floor(),
        DVec3::new(0.1, -1.0, 0.2),
    );
    let nothing = MergeLimits {
        frusta: 0,
        pass_cost: 0.0,
    };
    let mut tiles = FilmTiles::new(USizeVec2::splat(4));
    let mut slices = DepthSlices::new(4, 1.0, 9.0).expect("a range");
    for sample in &lit.samples {
        tiles.add(sample);
        slices.add(sample);
    }
    assert_eq!(tiles.merged(&nothing, objective).expect("samples").0.frusta.len(), 1);
    assert_eq!(
        slice_by_depth(&slices, &nothing, objective)
            .expect("samples")
            .frusta
            .len(),
        1
    );
}

/// Damping without a last film, with one that has become invalid, and without time.
#[test]
fn damping() {
    let lit = sunlit(
        &camera_on_floor(UVec2::new(36, 24)),
        &whole_floor(),
        DVec3::new(0.1, -1.0, 0.2),
    );
    let problem = lit.bin().problem(FilmObjective::default()).expect("samples");
    let optimum = problem.solve(&[]).expect("samples");
    let damping = Damping::default();
    let first = damping.step(&lit.base, &problem, None, &optimum, 0.016);
    assert!(
        first.is_moved && first.cost == 0.0 && first.film == optimum,
        "{first:?}"
    );
    let invalid = lit.base.width_form(DVec2::new(1.5, -2.0));
    let rescued = damping.step(&lit.base, &problem, Some(invalid), &optimum, 0.0);
    assert!(
        problem.hull().is_valid(rescued.film.bend) && rescued.cost > 0.0,
        "{rescued:?}"
    );
    let at_once = Damping {
        settle_seconds: 0.0,
        ..damping
    };
    let away = lit.base.width_form(optimum.bend + DVec2::new(0.2, 0.1));
    assert!(
        at_once.step(&lit.base, &problem, Some(away), &optimum, 0.016).cost < 1.0e-9,
        "follows"
    );
    let broken = damping.step(&lit.base, &problem, Some(DVec4::NAN), &optimum, f64::NAN);
    assert_eq!(broken.film, optimum);
    let still = damping.step(
        &lit.base,
        &problem,
        Some(lit.base.width_form(optimum.bend)),
        &optimum,
        1.0,
    );
    assert!(!still.is_moved, "at the optimum");
    let singular = FilmSample {
        pixels_from_film: DMat2::ZERO,
        ..lit.samples[0]
    };
    assert!(
        FilmBin::of_samples(&[singular])
            .problem(FilmObjective::default())
            .is_err(),
        "no badness"
    );
}
