//! Light views of the sun from films: conventions, coverage, sizes.

use bevy_math::{DVec2, DVec3, UVec2, Vec3Swizzles};
use umbrage::maths::{
    bounds::Bounds,
    fit::{FitInput, FitOptions, LightAxes, LightFit, fit_light_view},
    footprint::{texel_footprint, texels_on_pixels},
    light_plane::space::{BaseFilm, Film, FilmFitInput, FilmHull, FilmObjective, FilmProblem, fit_film},
    polytope::Polytope,
    warp::Warp,
};

use super::scene::{Camera, Lit, Piece, sunlit};
use crate::support::{bodies, close};

const TRAVEL: DVec3 = DVec3::new(-0.5, -1.0, -0.3);
const SIZE: UVec2 = UVec2::new(1024, 512);

fn street() -> [Piece; 2] {
    [
        Piece {
            point: DVec3::ZERO,
            normal: DVec3::Y,
            contains: |point| point.x.abs() < 40.0 && point.z > -60.0,
        },
        Piece {
            point: DVec3::new(-3.0, 0.0, 0.0),
            normal: DVec3::new(1.0, 0.0, 0.1),
            contains: |point| point.y > 0.0 && point.y < 8.0 && point.z > -50.0,
        },
    ]
}

fn walker() -> Camera {
    let (eye, ahead) = (DVec3::new(0.0, 1.7, 0.0), DVec3::new(0.1, -0.15, -1.0));
    Camera::sparse(eye, ahead, 0.5, 16.0 / 9.0, UVec2::new(72, 40), UVec2::new(1280, 720))
}

struct Fitted {
    lit: Lit,
    camera: Camera,
    visible: Polytope,
    body: Polytope,
    hull: FilmHull,
    film: Film,
    guard_texels: f64,
}

impl Fitted {
    fn new(light_travel: DVec3, is_whole: bool, guard_texels: f64) -> Self {
        let camera = walker();
        let mut lit = sunlit(&camera, &street(), light_travel);
        let scene = Bounds::new(DVec3::new(-40.0, 0.0, -60.0), DVec3::new(40.0, 12.0, 5.0));
        let (visible, body) = bodies(&camera.view, &scene, light_travel);
        let hull = if is_whole {
            lit.base = BaseFilm::of_sun(*lit.base.axes(), visible.vertices()).expect("receivers");
            FilmHull::of_body(&lit.base, &visible).expect("an area")
        } else {
            FilmHull::of_samples(&lit.samples).expect("an area")
        };
        let problem = FilmProblem::new(&lit.moments(), &hull, FilmObjective::default()).expect("samples");
        let film = problem.solve(&[]).expect("samples");
        Self {
            lit,
            camera,
            visible,
            body,
            hull,
            film,
            guard_texels,
        }
    }

    fn fit(&self) -> LightFit {
        self.fit_of(&self.film)
    }

    fn fit_of(&self, film: &Film) -> LightFit {
        fit_film(&FilmFitInput {
            view: &self.camera.view,
            visible: &self.visible,
            body: &self.body,
            base: &self.lit.base,
            film,
            hull: &self.hull,
            map_size: SIZE,
            guard_texels: self.guard_texels,
        })
        .expect("a proper film")
    }
}

/// No texel is lost: with the hull of all that may be seen, all of B is inside; with the hull of the samples all pixels
/// are, up to their corners. Every side is touched.
#[test]
fn everything_is_covered() {
    let whole = Fitted::new(TRAVEL, true, 0.0);
    let fit = whole.fit();
    let places: Vec<DVec3> = whole
        .body
        .vertices()
        .iter()
        .map(|vertex| fit.clip_from_world.project_point3(*vertex))
        .collect();
    for place in &places {
        assert!(place.xy().abs().max_element() < 1.0 + 1.0e-9, "{place}");
        assert!(place.z > 0.0 && place.z < 1.0, "{place}");
    }
    for axis in 0..2 {
        let extremes = places.iter().map(|place| place[axis]);
        close(extremes.clone().fold(0.0, f64::max), 1.0, 1.0e-9);
        close(extremes.fold(0.0, f64::min), -1.0, 1.0e-9);
    }
    let sampled = Fitted::new(TRAVEL, false, 2.0);
    let fit = sampled.fit();
    let inner = 1.0 - 4.0 / SIZE.as_dvec2();
    let mut reached = DVec2::ZERO;
    for ((point, _), sample) in sampled.lit.points.iter().zip(&sampled.lit.samples) {
        let place = fit.clip_from_world.project_point3(*point);
        assert!(
            place.xy().abs().cmple(inner + 1.0e-9).all() && place.z > 0.0 && place.z < 1.0,
            "{place}"
        );
        let expected = (sampled.film.place(sample.film).expect("w > 0") * 2.0 - 1.0) * inner;
        assert!(place.xy().distance(expected) < 1.0e-9, "{place} {expected}");
        let clip = fit.clip_from_world * point.extend(1.0);
        assert!(clip.w > 1.0 - 1.0e-9, "w is 1 at the near end: {clip}");
        for corner in sample.corners {
            reached = reached.max((sampled.film.place(corner).expect("w > 0") * 2.0 - 1.0).abs());
        }
    }
    assert!(reached.distance(DVec2::ONE) < 1.0e-9, "{reached}");
}

/// Casters beside the film, where w may be anything, do not count: a scene that is much wider has the same depths.
#[test]
fn casters_beside_the_film_do_not_matter() {
    let mut fitted = Fitted::new(TRAVEL, false, 0.0);
    let near = fitted.fit();
    fitted.body = Polytope::from_box(DVec3::new(-2000.0, 0.0, -2000.0), DVec3::new(2000.0, 12.0, 2000.0));
    let beyond = fitted
        .body
        .vertices()
        .iter()
        .any(|vertex| (near.clip_from_world * vertex.extend(1.0)).w <= 0.0);
    assert!(beyond, "some of the scene lies behind w = 0");
    let wide = fitted.fit();
    // The column of light is a little longer where the scene no longer ends beside it.
    close(wide.depth_per_metre, near.depth_per_metre, 0.4);
    for (point, _) in &fitted.lit.points {
        let depth = wide.clip_from_world.project_point3(*point).z;
        assert!(depth > 0.0 && depth < 1.0, "{depth}");
    }
}

/// Light space as everywhere: right-handed, z to the light, w and depth as documented.
#[test]
fn the_conventions_of_light_views() {
    for (light_travel, bend) in [
        (TRAVEL, None),
        (TRAVEL, Some(DVec2::ZERO)),
        (DVec3::new(-0.2, -1.0, 0.9), None),
    ] {
        let mut fitted = Fitted::new(light_travel, false, 1.0);
        if let Some(bend) = bend {
            let problem = FilmProblem::new(&fitted.lit.moments(), &fitted.hull, FilmObjective::default());
            fitted.film = problem.expect("samples").film_at(bend).expect("valid");
        }
        let fit = fitted.fit();
        let LightAxes { x, y, z } = fit.axes;
        assert!((x.cross(y) - z).length() < 1.0e-12, "right-handed");
        assert!(
            (z + light_travel.normalize()).length() < 1.0e-12,
            "z points to the light"
        );
        let product = fit.clip_from_light * fit.world_from_light.inverse();
        assert!(
            product.abs_diff_eq(fit.clip_from_world, 1.0e-6),
            "{product} {}",
            fit.clip_from_world
        );
        assert_eq!(fit.warp_near.is_infinite(), fitted.film.bend == DVec2::ZERO);
        for (point, _) in fitted.lit.points.iter().step_by(37) {
            let local = fit.world_from_light.inverse().transform_point3(*point);
            let clip = fit.clip_from_world * point.extend(1.0);
            close(clip.w, 1.0 + local.y / fit.warp_near, 1.0e-9);
            let higher = *point + z * 0.25;
            let (from, to) = (
                fit.clip_from_world.project_point3(*point),
                fit.clip_from_world.project_point3(higher),
            );
            assert!(from.xy().distance(to.xy()) < 1.0e-9, "the same texel");
            close(to.z - from.z, 0.25 * fit.depth_per_metre_at(*point), 1.0e-6);
        }
        let eye_height = fit
            .world_from_light
            .inverse()
            .transform_point3(fitted.camera.view.eye())
            .z;
        assert!(
            eye_height.abs() < 1.0,
            "depths are counted from near the eye: {eye_height}"
        );
    }
}

/// The sizes that bias and guards are computed from are those of texels in the world.
#[test]
fn the_sizes_of_texels() {
    let fitted = Fitted::new(TRAVEL, false, 2.0);
    let fit = fitted.fit();
    let (mut near, mut far) = (0.0_f64, 0.0_f64);
    for (point, _) in &fitted.lit.points {
        let footprint = texel_footprint(&fit.clip_from_world, SIZE, *point).expect("in front");
        let width = (fit.clip_from_world * point.extend(1.0)).w;
        let side = footprint.lengths().max_element();
        if width < 1.1 {
            near = near.max(side / width);
        }
        far = far.max(width);
        let film = fitted.lit.base.film(*point).expect("the sun sees all");
        let inner = 1.0 - 4.0 / SIZE.as_dvec2();
        let steps = fitted.film.texel_steps(film, SIZE);
        let area = steps.determinant() * fitted.lit.base.scale().powi(2) / inner.element_product();
        close(footprint.area(), area, 1.0e-9);
    }
    close(near, fit.near_texel_size, 0.2);
    assert!(far > 3.0, "{far}");
    let middle: Vec<f64> = fitted
        .lit
        .points
        .iter()
        .filter_map(|(point, _)| {
            let width = (fit.clip_from_world * point.extend(1.0)).w;
            let footprint = texel_footprint(&fit.clip_from_world, SIZE, *point)?;
            ((width / far.sqrt() - 1.0).abs() < 0.1).then(|| footprint.lengths().max_element() / width)
        })
        .collect();
    close(middle.iter().copied().fold(0.0, f64::max), fit.relative_texel_size, 0.2);
    assert!(
        fit.texel_size > fit.near_texel_size * 0.3 && fit.texel_size.is_finite(),
        "{fit:?}"
    );
}

/// Mean pixels per texel over the samples, through the matrix.
fn mean_area(fitted: &Fitted, fit: &LightFit) -> f64 {
    let pieces = street();
    let areas = fitted.lit.points.iter().map(|(point, index)| {
        let texel = texel_footprint(&fit.clip_from_world, SIZE, *point).expect("in front");
        let grid = &fitted.camera.grid;
        let pixel = texel_footprint(&grid.clip_from_world, grid.picture_size, *point).expect("in front");
        texels_on_pixels(&texel, &pixel, pieces[*index].normal)
            .expect("not edge-on")
            .area
    });
    areas.sum::<f64>() / fitted.lit.points.len() as f64
}

/// The error that the solver makes small is that of the matrix, and it is less than that of the warps of light space.
#[test]
fn the_promised_error_is_kept() {
    for light_travel in [TRAVEL, DVec3::new(-0.2, -1.0, -0.8), DVec3::new(-0.3, -0.6, 0.8)] {
        let fitted = Fitted::new(light_travel, false, 0.0);
        let mean = mean_area(&fitted, &fitted.fit());
        let texels = f64::from(SIZE.x * SIZE.y);
        close(mean, fitted.film.mean_error(texels), 1.0e-6);
        for warp in [Warp::Uniform, Warp::Lispsm, Warp::Psm] {
            let rival = fit_light_view(&FitInput {
                view: &fitted.camera.view,
                visible: &fitted.visible,
                body: &fitted.body,
                light_travel,
                warp,
                map_size: UVec2::splat(1024),
                guard_texels: 0.0,
                guard_metres: 0.0,
                options: FitOptions::default(),
            });
            // Its map of 1024² texels, counted as ours of half as many.
            let rival = mean_area(&fitted, &rival.fitted().expect("a proper camera"));
            assert!(rival > 1.2 * mean, "{warp:?}, {light_travel}: {rival} against {mean}");
        }
    }
}
