//! What holds for random planes, cameras and suns.

use bevy_math::{DVec2, DVec3, UVec2};
use proptest::prelude::*;
use umbrage::maths::{
    fit::LightAxes,
    footprint::{texel_footprint, texels_on_pixels},
    light_plane::space::{
        BaseFilm, Damping, FilmBin, FilmFitInput, FilmObjective, FilmSample, depth_form, fit_film, plane_form,
    },
    polytope::Polytope,
};

use super::scene::{Camera, Piece};
use crate::properties::{direction, point};

/// A camera that sees nothing but one plane, lit by the sun.
#[derive(Debug)]
struct Plane {
    eye: DVec3,
    forward: DVec3,
    point: DVec3,
    normal: DVec3,
    light_travel: DVec3,
}

fn plane() -> impl Strategy<Value = Plane> {
    (point(20.0), direction(), direction(), direction(), 1.0..30.0).prop_filter_map(
        "the plane does not fill the picture in the sun",
        |(eye, forward, normal, light_travel, distance)| {
            let seen_at = -normal.dot(forward);
            let lit_at = -normal.dot(light_travel);
            let is_lit = lit_at > 0.15 && lit_at < 0.999;
            // Half the picture's diagonal opens 37 degrees. It stays 4 degrees below the horizon, where depths differ too
            // much within one of 36 × 24 pixels.
            (seen_at > 0.66 && is_lit && forward.y.abs() < 0.95).then_some(Plane {
                eye,
                forward,
                point: eye + forward * distance,
                normal,
                light_travel,
            })
        },
    )
}

impl Plane {
    fn camera(&self) -> Camera {
        Camera::sparse(
            self.eye,
            self.forward,
            0.4,
            1.5,
            UVec2::new(36, 24),
            UVec2::new(1080, 720),
        )
    }

    fn points(&self, camera: &Camera) -> Vec<DVec3> {
        let piece = Piece {
            point: self.point,
            normal: self.normal,
            contains: |_| true,
        };
        camera.hits(&[piece]).into_iter().map(|(point, _)| point).collect()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    /// One plane: through the final matrix every texel covers the same area, and it is |Ω| ÷ N.
    #[test]
    fn one_plane_is_sampled_evenly(plane in plane()) {
        let camera = plane.camera();
        let points = plane.points(&camera);
        prop_assert_eq!(points.len(), 36 * 24);
        let axes = LightAxes::new(plane.forward, DVec3::Y, plane.light_travel).expect("a light");
        let base = BaseFilm::of_sun(axes, &points).expect("receivers");
        let samples: Vec<FilmSample> = points
            .iter()
            .map(|point| FilmSample::new(&base, &camera.grid, *point, plane.normal).expect("lit"))
            .collect();
        let problem = FilmBin::of_samples(&samples).problem(FilmObjective::default()).expect("samples");
        let film = problem.solve(&[]).expect("samples");
        let bound = 1080.0 * 720.0 / (1024.0 * 1024.0);
        prop_assert!((film.mean_error(1024.0 * 1024.0) / bound - 1.0).abs() < 0.01, "{}", film.mean_error(1024.0 * 1024.0));
        // The film of the theorem is the one that the solver finds.
        let exact = base.bend_of_plane(depth_form(&camera.view), plane_form(plane.point, plane.normal)).expect("valid");
        prop_assert!(film.bend.distance(exact) < 0.02, "{} {exact}", film.bend);

        let corners: Vec<DVec3> = points.iter().copied().step_by(11).collect();
        let visible = Polytope::hull(&corners[..corners.len().min(40)]);
        let body = visible.sweep(-plane.light_travel, 4.0);
        let map_size = UVec2::splat(1024);
        let fit = fit_film(&FilmFitInput {
            view: &camera.view,
            visible: &visible,
            body: &body,
            base: &base,
            film: &film,
            hull: problem.hull(),
            map_size,
            guard_texels: 0.0,
        }).expect("a proper film");
        let (mut sum, mut low, mut high) = (0.0, f64::INFINITY, 0.0_f64);
        for point in &points {
            let texel = texel_footprint(&fit.clip_from_world, map_size, *point).expect("in front");
            let pixel = texel_footprint(&camera.grid.clip_from_world, camera.grid.picture_size, *point).expect("in front");
            let area = texels_on_pixels(&texel, &pixel, plane.normal).expect("lit and seen").area;
            (sum, low, high) = (sum + area, low.min(area), high.max(area));
        }
        let mean = sum / points.len() as f64;
        prop_assert!((mean / bound - 1.0).abs() < 0.01, "{mean} is not {bound}");
        prop_assert!(low > 0.99 * mean && high < 1.01 * mean, "{low} to {high} around {mean}");
    }

    /// No film is better than |Ω| ÷ N on one plane, and no film of the solver loses a sample's pixel.
    #[test]
    fn films_cover_their_hull(plane in plane(), lean in [-0.3..0.3, -0.3..0.3]) {
        let camera = plane.camera();
        let points = plane.points(&camera);
        let axes = LightAxes::new(plane.forward, DVec3::Y, plane.light_travel).expect("a light");
        let base = BaseFilm::of_sun(axes, &points).expect("receivers");
        let samples: Vec<FilmSample> = points
            .iter()
            .map(|point| FilmSample::new(&base, &camera.grid, *point, plane.normal).expect("lit"))
            .collect();
        let problem = FilmBin::of_samples(&samples).problem(FilmObjective::default()).expect("samples");
        let best = problem.solve(&[]).expect("samples");
        let Some(film) = problem.film_at(best.bend + DVec2::from_array(lean)) else {
            return Ok(());
        };
        prop_assert!(film.error >= best.error * (1.0 - 1.0e-7), "{} {}", film.error, best.error);
        for corner in samples.iter().flat_map(|sample| sample.corners) {
            let place = film.place(corner).expect("w > 0");
            prop_assert!(place.min_element() > -1.0e-9 && place.max_element() < 1.0 + 1.0e-9, "{place}");
        }
    }

    /// Damping is never worse than staying, nor better than the optimum, and it ends there.
    #[test]
    fn damping_costs_less_than_staying(plane in plane(), lean in [-0.3..0.3, -0.3..0.3], seconds in 0.001..2.0) {
        let camera = plane.camera();
        let points = plane.points(&camera);
        let axes = LightAxes::new(plane.forward, DVec3::Y, plane.light_travel).expect("a light");
        let base = BaseFilm::of_sun(axes, &points).expect("receivers");
        let samples: Vec<FilmSample> = points
            .iter()
            .map(|point| FilmSample::new(&base, &camera.grid, *point, plane.normal).expect("lit"))
            .collect();
        let problem = FilmBin::of_samples(&samples).problem(FilmObjective::default()).expect("samples");
        let optimum = problem.solve(&[]).expect("samples");
        let old = optimum.bend + DVec2::from_array(lean);
        let Some(stayed) = problem.film_at(old) else {
            return Ok(());
        };
        let damping = Damping::default();
        let step = |bend: DVec2| damping.step(&base, &problem, Some(base.width_form(bend)), &optimum, seconds);
        let mut damped = step(old);
        prop_assert!(damped.film.error <= stayed.error * (1.0 + 1.0e-9), "{damped:?} {}", stayed.error);
        prop_assert!(damped.cost >= 0.0 && (damped.film.error / optimum.error - 1.0 - damped.cost).abs() < 1.0e-6);
        for _ in 0..(20.0 / seconds) as usize {
            damped = step(damped.film.bend);
        }
        prop_assert!(damped.cost <= damping.tolerance + 1.0e-9, "{damped:?}");
        prop_assert!(!damped.is_moved, "it rests");
    }
}
