//! The reference numbers of two scenes (oracles O18, section 3.4 and 3.5 of the specification).

use bevy_math::{DVec2, UVec2};
use umbrage::maths::light_plane::space::{
    Film, FilmHull, FilmMetric, FilmObjective, FilmProblem, FilmShape, MapSides, depth_form, plane_form,
};

use super::scene::{LIGHT_TWO, Lit, camera_on_floor, camera_two, lit_along, lit_from, scene_two, whole_floor};
use crate::support::close;

fn objective(metric: FilmMetric, shape: FilmShape) -> FilmObjective {
    FilmObjective {
        metric,
        shape,
        map_sides: MapSides::Equal,
    }
}

const OBJECTIVES: [(FilmMetric, FilmShape); 4] = [
    (FilmMetric::Area, FilmShape::Rectangle),
    (FilmMetric::Area, FilmShape::Parallelogram),
    (FilmMetric::Stretch, FilmShape::Rectangle),
    (FilmMetric::Stretch, FilmShape::Parallelogram),
];

fn problem(lit: &Lit, (metric, shape): (FilmMetric, FilmShape)) -> FilmProblem {
    FilmProblem::new(&lit.moments(), &lit.hull_of_middles(), objective(metric, shape)).expect("samples")
}

#[test]
fn scene_two_as_specified() {
    let lit = lit_from(&camera_two(UVec2::new(144, 96)), &scene_two(), LIGHT_TWO);
    let texels = 128.0 * 128.0;
    assert_eq!(lit.samples.len(), 10611);
    close(lit.samples.len() as f64 / texels, 0.64764, 1.0e-5);
    let errors: Vec<(f64, Film)> = OBJECTIVES
        .iter()
        .map(|objective| {
            let problem = problem(&lit, *objective);
            let before = problem.film_at(DVec2::ZERO).expect("valid").mean_error(texels);
            (before, problem.solve(&[]).expect("samples"))
        })
        .collect();
    close(errors[0].0, 5.601, 1.0e-4);
    close(errors[2].0, 20.98, 2.0e-4);
    for ((_, film), expected) in errors.iter().zip([0.98716, 0.86489, 2.7294, 2.4694]) {
        close(film.mean_error(texels), expected, 2.0e-5);
    }
    let bend = errors[0].1.bend;
    assert!(bend.distance(DVec2::new(-1.086, -0.070)) < 1.0e-3, "{bend}");
}

/// A floor that fills the picture: the film of Theorem 1 reaches the bound, and the solver finds it.
#[test]
fn one_plane_reaches_the_bound() {
    let camera = camera_on_floor(UVec2::new(96, 64));
    let floor = whole_floor();
    let light = bevy_math::DVec3::new(2.0, 6.0, -4.0);
    let lit = lit_from(&camera, &floor, light);
    assert_eq!(lit.samples.len(), 96 * 64);
    let plane = plane_form(floor[0].point, floor[0].normal);
    let bend = lit.base.bend_of_plane(depth_form(&camera.view), plane).expect("valid");
    assert!(bend.distance(DVec2::new(-0.63735, -0.87)) < 1.0e-5, "{bend}");
    let problem = problem(&lit, OBJECTIVES[1]);
    let texels = 64.0 * 64.0;
    let exact = problem.film_at(bend).expect("valid");
    close(exact.mean_error(texels), 1.461_181_640_625, 1.0e-9);
    let found = problem.solve(&[]).expect("samples");
    close(found.mean_error(texels), 1.461_181_640_625, 1.0e-7);
    assert!(found.bend.distance(bend) < 1.0e-3, "{} {bend}", found.bend);
    // With the pixels' corners instead of their middles the bound is |Ω| ÷ N itself.
    let whole = lit.bin().problem(objective(FilmMetric::Area, FilmShape::Parallelogram));
    let whole = whole.expect("samples").solve(&[]).expect("samples");
    close(whole.mean_error(texels), 96.0 * 64.0 / texels, 1.0e-7);
}

/// Section 3.4: what a smaller view of the scene loses, in percent of area and stretch, each judged by the large view.
#[test]
fn small_views_lose_little() {
    let large = lit_from(&camera_two(UVec2::new(288, 192)), &scene_two(), LIGHT_TWO);
    let judges = [OBJECTIVES[0], OBJECTIVES[2]].map(|objective| problem(&large, objective));
    let best = judges.each_ref().map(|judge| judge.solve(&[]).expect("samples").error);
    for (samples, losses) in [
        (UVec2::new(144, 96), [0.01, 0.003]),
        (UVec2::new(72, 48), [0.01, 0.001]),
        (UVec2::new(36, 24), [0.28, 0.13]),
        (UVec2::new(18, 12), [2.1, 1.3]),
        (UVec2::new(12, 8), [2.6, 1.8]),
        (UVec2::new(6, 4), [1.8, 1.4]),
    ] {
        let light = large.base.light().truncate();
        let small = lit_along(&camera_two(samples), &scene_two(), light, *large.base.axes());
        for (index, metric) in [OBJECTIVES[0], OBJECTIVES[2]].into_iter().enumerate() {
            let film = problem(&small, metric).solve(&[]).expect("samples");
            let error = judges[index].film_at(film.bend).expect("valid").error;
            let loss = 100.0 * (error / best[index] - 1.0);
            let expected = losses[index];
            assert!(
                (loss - expected).abs() < 0.04 * expected + 0.002,
                "{samples}: {loss}, not {expected}"
            );
        }
    }
}

/// The stretch of a film is that of every texel, summed one by one; likewise the area.
#[test]
fn sums_replace_samples() {
    let lit = lit_from(&camera_two(UVec2::new(72, 48)), &scene_two(), LIGHT_TWO);
    let moments = lit.moments();
    for bend in [DVec2::ZERO, DVec2::new(0.3, -0.2), DVec2::new(-0.5, 0.1)] {
        let sides = bevy_math::DMat2::from_cols(DVec2::new(1.3, 0.2), DVec2::new(-0.4, 0.9));
        let (mut area, mut stretch) = (0.0, 0.0);
        for sample in &lit.samples {
            let width = 1.0 + bend.dot(sample.film);
            let outer = bevy_math::DMat2::from_cols(sample.film * bend.x, sample.film * bend.y);
            let pixels = sample.pixels_from_film * (bevy_math::DMat2::IDENTITY + outer) * sides * width;
            area += pixels.determinant().abs();
            stretch += pixels.x_axis.length_squared() + pixels.y_axis.length_squared();
        }
        close(moments.area_sum(bend) * sides.determinant(), area, 1.0e-12);
        let matrix = moments.stretch_matrix(bend);
        let quadratic = |side: DVec2| side.dot(matrix * side);
        close(quadratic(sides.x_axis) + quadratic(sides.y_axis), stretch, 1.0e-12);
    }
}

/// Whatever the start: one minimum of P S, where the badness-weighted mean is the middle of the film.
#[test]
fn there_is_one_balanced_bend() {
    let lit = lit_from(&camera_two(UVec2::new(72, 48)), &scene_two(), LIGHT_TWO);
    let problem = problem(&lit, OBJECTIVES[0]);
    let bend = problem.balanced_bend(DVec2::ZERO);
    let mut tried = 0;
    for index in 0..400 {
        // Evenly spread (plastic number), so that every run tries the same.
        let start = DVec2::new(f64::from(index) * 0.754_877_666, f64::from(index) * 0.569_840_291).fract() * 6.0 - 3.0;
        if problem.hull().is_valid(start) {
            tried += 1;
            let other = problem.balanced_bend(start);
            assert!(bend.distance(other) < 1.0e-6, "from {start}: {other}, not {bend}");
        }
    }
    assert!(tried > 20, "{tried} valid starts");
    // Means over the samples and over the image of the hull.
    let (mut weighted, mut total) = (DVec2::ZERO, 0.0);
    for sample in &lit.samples {
        let width = 1.0 + bend.dot(sample.film);
        let badness = sample.pixels_from_film.determinant().abs() * width.powi(3);
        weighted += sample.film / width * badness;
        total += badness;
    }
    let image = problem
        .hull()
        .points()
        .iter()
        .map(|point| point / (1.0 + bend.dot(*point)));
    let image = FilmHull::new(image).expect("an area");
    let (mut first, mut area) = (DVec2::ZERO, 0.0);
    let corner = image.points()[0];
    for pair in image.points()[1..].windows(2) {
        let part = (pair[0] - corner).perp_dot(pair[1] - corner);
        first += (corner + pair[0] + pair[1]) / 3.0 * part;
        area += part;
    }
    let (mean, center) = (weighted / total, first / area);
    assert!(mean.distance(center) < 1.0e-7, "{mean} {center}");
}

/// From many other starts no film is better than the solver's.
#[test]
fn no_better_minimum_is_known() {
    for light in [LIGHT_TWO, bevy_math::DVec3::new(3.0, 9.0, -8.0)] {
        let lit = lit_from(&camera_two(UVec2::new(72, 48)), &scene_two(), light);
        for objective in OBJECTIVES {
            let problem = problem(&lit, objective);
            let found = problem.solve(&[]).expect("samples").error;
            let mut best = f64::INFINITY;
            for column in -40..=40 {
                for row in -40..=40 {
                    let bend = DVec2::new(f64::from(column), f64::from(row)) * 0.05;
                    best = best.min(problem.film_at(bend).map_or(f64::INFINITY, |film| film.error));
                }
            }
            assert!(found <= best * 1.0001, "{objective:?}: {found} against {best}");
        }
    }
}
