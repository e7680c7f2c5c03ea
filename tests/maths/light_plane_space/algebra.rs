//! Films, moments, hulls and frames one by one (oracles O18 and O20).

use bevy_math::{DMat2, DVec2, DVec3, UVec2};
use umbrage::maths::light_plane::space::{FilmFrame, FilmHull, FilmMoments, FilmObjective, FilmSample, FilmShape};

use super::scene::{LIGHT_TWO, camera_two, lit_from, scene_two};
use crate::support::close;

/// (∂v/∂u)⁻¹ = w (I + u kᵀ), of determinant w³; checked against differences of u ÷ w and in `texel_steps`.
#[test]
fn the_derivative_of_a_bent_film() {
    let lit = lit_from(&camera_two(UVec2::new(36, 24)), &scene_two(), LIGHT_TWO);
    let problem = lit.bin().problem(FilmObjective::default()).expect("samples");
    let size = UVec2::new(300, 200);
    for (bend, point) in [
        (DVec2::new(0.3, -0.4), DVec2::new(0.2, 0.1)),
        (DVec2::new(-1.0, -0.05), DVec2::new(0.4, -0.3)),
    ] {
        let film = problem.film_at(bend).expect("valid");
        let steps = film.texel_steps(point, size);
        let place = |point: DVec2| film.place(point).expect("w > 0") * size.as_dvec2();
        for (step, axis) in [(steps.x_axis, DVec2::X), (steps.y_axis, DVec2::Y)] {
            let small = 1.0e-5;
            let moved = (place(point + step * small) - place(point - step * small)) / (2.0 * small);
            assert!(moved.distance(axis) < 1.0e-6, "{moved} is not {axis}");
        }
        let width = 1.0 + bend.dot(point);
        let texel_area = film.frame.area() / size.as_dvec2().element_product();
        close(steps.determinant(), width.powi(3) * texel_area, 1.0e-12);
    }
}

fn sample(film: DVec2, pixels_from_film: DMat2) -> FilmSample {
    FilmSample {
        film,
        pixels_from_film,
        corners: [film; 4],
        pixels: 1.0,
        depths: [1.0; 2],
    }
}

/// The trace of Jᵀ J is the sum of the squared partial derivatives and of the squared singular values: 3 for a shear. The
/// thesis's squared eigenvalues would be 2.
#[test]
fn the_stretch_is_a_sum_of_singular_values() {
    let shear = DMat2::from_cols(DVec2::X, DVec2::new(1.0, 1.0));
    let moments = FilmMoments::of(&sample(DVec2::ZERO, shear));
    let matrix = moments.stretch_matrix(DVec2::ZERO);
    close(matrix.x_axis.x + matrix.y_axis.y, 3.0, 1.0e-15);
    // Squared singular values: roots of s² − trace s + det² = s² − 3 s + 1.
    let (root, det) = (5.0_f64.sqrt(), shear.determinant());
    close((3.0 + root) / 2.0 + (3.0 - root) / 2.0, 3.0, 1.0e-15);
    close((3.0 + root) / 2.0 * ((3.0 - root) / 2.0), det * det, 1.0e-12);
}

/// Sums add up, and a sample that stands for more pixels counts as many.
#[test]
fn moments_add_up() {
    let a = sample(DVec2::new(0.3, -0.2), DMat2::from_cols_array(&[3.0, 0.5, -0.2, 2.0]));
    let b = sample(DVec2::new(-0.6, 0.7), DMat2::from_cols_array(&[1.0, 0.1, 0.3, 4.0]));
    let mut twice = FilmMoments::of(&a);
    twice += FilmMoments::of(&a);
    let heavy = FilmMoments::of(&FilmSample { pixels: 2.0, ..a });
    let total: FilmMoments = [a, b, a].iter().map(FilmMoments::of).sum();
    for bend in [DVec2::ZERO, DVec2::new(0.4, 0.3)] {
        close(heavy.area_sum(bend), twice.area_sum(bend), 1.0e-14);
        let sum = heavy.area_sum(bend) + FilmMoments::of(&b).area_sum(bend);
        close(total.area_sum(bend), sum, 1.0e-14);
        let matrix = heavy.stretch_matrix(bend) + FilmMoments::of(&b).stretch_matrix(bend);
        assert!(total.stretch_matrix(bend).abs_diff_eq(matrix, 1.0e-12), "{matrix}");
    }
    close(total.pixels, 3.0, 0.0);
}

#[test]
fn single_precision_sums_suffice() {
    let lit = lit_from(&camera_two(UVec2::new(144, 96)), &scene_two(), LIGHT_TWO);
    let exact = lit.moments();
    let mut rounded = [[0.0_f32; 6]; 6];
    for sample in &lit.samples {
        let moments = FilmMoments::of(sample);
        for (sum, value) in rounded.iter_mut().flatten().zip(moments.stretch.iter().flatten()) {
            *sum += *value as f32;
        }
    }
    let single = FilmMoments {
        stretch: rounded.map(|row| row.map(f64::from)),
        ..exact
    };
    let bend = DVec2::new(-1.0, -0.05);
    let (exact, single) = (exact.stretch_matrix(bend), single.stretch_matrix(bend));
    let largest = exact.to_cols_array().into_iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    // One running sum; work groups that add up parts do better.
    assert!(exact.abs_diff_eq(single, 1.0e-4 * largest), "{exact} {single}");
}

#[test]
fn hulls() {
    let square = [
        (0.0, 0.0),
        (1.0, 0.0),
        (1.0, 1.0),
        (0.0, 1.0),
        (0.5, 0.5),
        (0.5, 0.0),
        (1.0, 1.0),
    ];
    let hull = FilmHull::new(square.map(DVec2::from)).expect("an area");
    assert_eq!(hull.points().len(), 4);
    close(hull.area(), 1.0, 1.0e-15);
    close(hull.dilated(0.1).area(), 1.44, 1.0e-12);
    // Maxima in 8 directions: an octagon around the square whose slanted sides touch its corners.
    let supports: Vec<f64> = (0..8)
        .map(|index| {
            let normal = DVec2::from_angle(f64::from(index) * std::f64::consts::FRAC_PI_4);
            hull.points()
                .iter()
                .map(|point| normal.dot(*point))
                .fold(f64::NEG_INFINITY, f64::max)
        })
        .collect();
    let around = FilmHull::from_supports(&supports).expect("an area");
    close(around.area(), 1.0, 1.0e-9);
    // A disc of 64 points, reduced to 12 sides around it, at two bends.
    let disc: Vec<DVec2> = (0..64)
        .map(|index| DVec2::from_angle(f64::from(index) * 0.098_174_770_424_681))
        .collect();
    let hull = FilmHull::new(disc.clone()).expect("an area");
    for bend in [DVec2::ZERO, DVec2::new(0.6, 0.5)] {
        let simple = hull.simplified(12, bend);
        assert_eq!(simple.points().len(), 12);
        assert!(simple.area() < 1.12 * hull.area(), "{}", simple.area());
        for point in &disc {
            let inside = simple.points().iter().zip(simple.points().iter().cycle().skip(1));
            let mut excess = inside.map(|(a, b)| (b - a).perp_dot(point - a));
            assert!(excess.all(|side| side > -1.0e-12), "{point} is lost");
        }
    }
}

#[test]
fn frames_around_polygons() {
    let area = |sides: &DMat2| sides.determinant();
    let turned = DMat2::from_angle(0.4);
    let rectangle = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (0.0, 1.0)].map(|point| turned * DVec2::from(point));
    let (frame, cost) = FilmFrame::around(&rectangle, FilmShape::Rectangle, area).expect("an area");
    close(cost, 3.0, 1.0e-12);
    close(frame.area(), 3.0, 1.0e-12);
    let skewed = [(0.0, 0.0), (3.0, 0.0), (4.0, 1.0), (1.0, 1.0)].map(|point| turned * DVec2::from(point));
    let (frame, cost) = FilmFrame::around(&skewed, FilmShape::Parallelogram, area).expect("an area");
    close(cost, 3.0, 1.0e-12);
    for point in skewed {
        let place = frame.place(point);
        assert!(
            place.cmpge(DVec2::splat(-1.0e-12)).all() && place.cmple(DVec2::splat(1.0 + 1.0e-12)).all(),
            "{place}"
        );
    }
    let (_, rectangular) = FilmFrame::around(&skewed, FilmShape::Rectangle, area).expect("an area");
    assert!(rectangular > 3.5, "{rectangular}");
    // Never mirrored, and the first side looks along +x.
    assert!(
        frame.sides.determinant() > 0.0 && frame.sides.x_axis.x > 0.0,
        "{frame:?}"
    );
    // The least parallelogram around a triangle has twice its area.
    let triangle = [(0.0, 0.0), (2.0, 0.3), (0.4, 1.7)].map(DVec2::from);
    let (_, cost) = FilmFrame::around(&triangle, FilmShape::Parallelogram, area).expect("an area");
    close(cost, (triangle[1]).perp_dot(triangle[2]), 1.0e-12);
    assert!(
        FilmFrame::around(&[DVec2::ZERO; 3], FilmShape::Rectangle, area).is_none(),
        "no area"
    );
}

/// Jᵤ of a sample against differences: neighbouring pixels of the same plane.
#[test]
fn samples_know_their_derivatives() {
    let camera = camera_two(UVec2::new(600, 400));
    let pieces = scene_two();
    let lit = lit_from(&camera, &pieces, LIGHT_TWO);
    let mut checked = 0;
    for (pair, samples) in lit.points.windows(3).zip(lit.samples.windows(3)) {
        let step = pair[2].0 - pair[0].0;
        let in_row = pair.iter().all(|(_, index)| *index == pair[0].1) && step.length() < 0.5;
        if in_row && samples[0].film.distance(samples[2].film) < 0.01 {
            let pixels = samples[1].pixels_from_film * (samples[2].film - samples[0].film);
            assert!(pixels.distance(DVec2::new(2.0, 0.0)) < 0.02, "{pixels}");
            checked += 1;
        }
    }
    assert!(checked > 1000, "{checked}");
    let flat = DVec3::new(0.0, 0.0, -4.0);
    assert!(lit.base.film(flat).is_some(), "in front of the light");
}
