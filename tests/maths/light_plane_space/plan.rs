//! From blocks of a picture to films.

use bevy_math::{DMat4, DVec2, DVec3, UVec2, Vec3Swizzles};
use umbrage::maths::{
    body::{adjusted_depths, intersection_body, light_visible},
    bounds::Bounds,
    fit::LightFit,
    light_plane::space::{
        Damping, FilmCover, FilmDivision, FilmError, FilmFitInput, FilmMemory, FilmMetric, FilmObjective, FilmPlan,
        FilmPlanInput, FilmPlanOptions, FilmSample, FilmShape, MapSides, MergeLimits, SampleGrid, SeenPicture,
        fit_film, plan_films,
    },
    view::ViewVolume,
};

use super::scene::{Camera, Piece, camera_on_floor, scene_two, whole_floor};
use crate::support::close;

const TRAVEL: DVec3 = DVec3::new(-0.6, -1.0, 0.3);
const MAP: UVec2 = UVec2::new(512, 512);

struct Seen {
    camera: Camera,
    picture: SeenPicture,
    points: Vec<DVec3>,
    receivers: Bounds,
    view: ViewVolume,
}

impl Seen {
    fn new(camera: Camera, pieces: &[Piece], receivers: Bounds) -> Self {
        let (picture, points) = camera.picture(pieces);
        let (near, far) = adjusted_depths(&light_visible(&camera.view, &receivers), &camera.view).expect("receivers");
        let view = camera.view.split(near, far);
        Self {
            camera,
            picture,
            points,
            receivers,
            view,
        }
    }

    /// A floor and a wall.
    fn of_two_planes() -> Self {
        let (eye, ahead) = (DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.2, -0.3, -1.0));
        let camera = Camera::sparse(eye, ahead, 0.5, 1.5, UVec2::new(36, 24), UVec2::new(144, 96));
        let receivers = Bounds::new(DVec3::new(-30.0, 0.0, -30.0), DVec3::new(30.0, 4.0, 10.0));
        Self::new(camera, &scene_two(), receivers)
    }

    fn plan_from(&self, options: &FilmPlanOptions, last: &FilmMemory) -> Result<FilmPlan, FilmError> {
        plan_films(&FilmPlanInput {
            view: &self.view,
            receivers: &self.receivers,
            light_travel: TRAVEL,
            picture: &self.picture,
            clip_from_world: self.camera.grid.clip_from_world,
            margin: 0.0,
            options,
            last,
            seconds: 1.0 / 60.0,
        })
    }

    fn plan(&self, options: &FilmPlanOptions) -> FilmPlan {
        self.plan_from(options, &FilmMemory::default()).expect("films")
    }

    fn fits(&self, plan: &FilmPlan) -> Vec<LightFit> {
        let visible = light_visible(&self.view, &self.receivers);
        let body = intersection_body(&visible, &self.receivers, TRAVEL);
        let fit = |frustum: &umbrage::maths::light_plane::space::FilmFrustum| {
            fit_film(&FilmFitInput {
                view: &self.view,
                visible: &visible,
                body: &body,
                base: &plan.base,
                film: &frustum.film,
                hull: &frustum.hull,
                map_size: MAP,
                guard_texels: 0.0,
            })
            .expect("a light view")
        };
        plan.partition.frusta.iter().map(fit).collect()
    }
}

fn options(frusta: usize, division: FilmDivision, cover: FilmCover) -> FilmPlanOptions {
    FilmPlanOptions {
        objective: FilmObjective {
            map_sides: MapSides::Equal,
            ..FilmObjective::default()
        },
        limits: MergeLimits {
            frusta,
            ..MergeLimits::default()
        },
        division,
        cover,
        damping: Damping::default(),
    }
}

fn contains(fit: &DMat4, point: DVec3) -> bool {
    let place = fit.project_point3(point);
    (fit.row(3).dot(point.extend(1.0)) > 0.0)
        && place.xy().abs().max_element() < 1.0 + 1.0e-6
        && (0.0..=1.0).contains(&place.z)
}

/// One plane: texels cover the same number of pixels everywhere, and as few as there are pixels and texels (Theorem 1).
#[test]
fn one_plane_is_sampled_evenly_and_fully() {
    for cover in [FilmCover::Seen, FilmCover::Body] {
        let camera = camera_on_floor(UVec2::new(48, 32));
        let camera = Camera::sparse(
            camera.view.eye(),
            camera.view.forward(),
            20.0_f64.to_radians(),
            1.5,
            UVec2::new(48, 32),
            UVec2::new(192, 128),
        );
        let floor = Bounds::new(DVec3::new(-100.0, 0.0, -100.0), DVec3::new(100.0, 0.0, 100.0));
        let seen = Seen::new(camera, &whole_floor(), floor);
        let plan = seen.plan(&options(1, FilmDivision::Depth, cover));
        let film = &plan.partition.frusta[0].film;
        close(film.pixels, f64::from(192 * 128), 0.0);
        let grid = SampleGrid {
            samples: seen.picture.size,
            ..seen.camera.grid
        };
        let areas: Vec<f64> = seen
            .points
            .iter()
            .map(|point| {
                let sample = FilmSample::new(&plan.base, &grid, *point, DVec3::Y).expect("lit");
                let pixels_from_texels = sample.pixels_from_film * film.texel_steps(sample.film, MAP);
                pixels_from_texels.determinant().abs()
            })
            .collect();
        let (low, high) = areas.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), area| {
            (low.min(*area), high.max(*area))
        });
        assert!(high / low < 1.01, "{cover:?}: {low} to {high}");
        // |Ω| ÷ n is a bound from below. Half a pixel at the rim of the picture is looked up by none.
        let bound = film.pixels / MAP.as_dvec2().element_product();
        let rim = (1.0 - 1.0 / seen.picture.size.as_dvec2()).element_product();
        let mean = areas.iter().sum::<f64>() / areas.len() as f64;
        assert!(
            (rim - 1.0e-6..1.01).contains(&(mean / bound)),
            "{cover:?}: {mean}, bound {bound}"
        );
    }
}

/// What the camera sees is in the maps, every pixel of it, however the films divide it.
#[test]
fn every_pixel_is_in_a_map() {
    let seen = Seen::of_two_planes();
    for division in [FilmDivision::Depth, FilmDivision::Tiles] {
        for frusta in [1, 2, 4] {
            for metric in [FilmMetric::Area, FilmMetric::Stretch] {
                let mut options = options(frusta, division, FilmCover::Seen);
                options.objective.metric = metric;
                options.limits.pass_cost = 0.0;
                let plan = seen.plan(&options);
                let fits = seen.fits(&plan);
                assert!(frusta == 1 || fits.len() > 1, "{division:?}: {} films", fits.len());
                for point in &seen.points {
                    assert!(
                        fits.iter().any(|fit| contains(&fit.clip_from_world, *point)),
                        "{division:?}, {frusta} films: {point} is in no map"
                    );
                }
            }
        }
    }
}

/// All that the camera may see is in the film, or in that of its depth.
#[test]
fn films_of_the_body_lose_nothing() {
    let seen = Seen::of_two_planes();
    let one = seen.plan(&options(1, FilmDivision::Depth, FilmCover::Body));
    let fit = seen.fits(&one).remove(0).clip_from_world;
    for vertex in light_visible(&seen.view, &seen.receivers).vertices() {
        assert!(contains(&fit, *vertex), "{vertex}");
    }
    let several = seen.plan(&options(4, FilmDivision::Depth, FilmCover::Body));
    let fits = seen.fits(&several);
    let depths: Vec<[f64; 2]> = several.partition.frusta.iter().map(|frustum| frustum.depths).collect();
    close(depths[0][0], seen.view.near(), 1.0e-9);
    close(depths[depths.len() - 1][1], seen.view.far(), 1.0e-9 * seen.view.far());
    assert!(depths.windows(2).all(|pair| pair[0][1] == pair[1][0]), "{depths:?}");
    for (fit, [near, far]) in fits.iter().zip(depths) {
        for vertex in light_visible(&seen.view.split(near, far), &seen.receivers).vertices() {
            assert!(contains(&fit.clip_from_world, *vertex), "{vertex}");
        }
    }
}

/// More films have less error, and films of what is seen less than those of what may be seen.
#[test]
fn errors_fall() {
    let seen = Seen::of_two_planes();
    let need = |frusta, division, cover| {
        let mut options = options(frusta, division, cover);
        options.limits.pass_cost = 0.0;
        seen.plan(&options).partition.mean_error(1.0)
    };
    let [body, one] = [FilmCover::Body, FilmCover::Seen].map(|cover| need(1, FilmDivision::Depth, cover));
    assert!(one < body, "{one} {body}");
    // The division goes by balanced bends, which are within a hundredth of the best.
    for division in [FilmDivision::Depth, FilmDivision::Tiles] {
        let [two, four] = [2, 4].map(|frusta| need(frusta, division, FilmCover::Seen));
        assert!(two < one * 1.01, "{division:?}: {one} {two}");
        // Of two planes, one film each is the best division by depth.
        let gain = if division == FilmDivision::Depth { 1.0 } else { 0.99 };
        assert!(four <= two * gain, "{division:?}: {two} {four}");
    }
    let plan = seen.plan(&options(1, FilmDivision::Depth, FilmCover::Seen));
    assert!(plan.gain > 1.5, "over no bend: {}", plan.gain);
}

/// A camera that stands still has films that stand still; without damping they are the optimum at once.
#[test]
fn films_stand_still() {
    let seen = Seen::of_two_planes();
    for division in [FilmDivision::Depth, FilmDivision::Tiles] {
        let options = options(3, division, FilmCover::Seen);
        let first = seen.plan(&options);
        close(first.damping_cost, 0.0, 1.0e-12);
        let second = seen.plan_from(&options, &first.memory).expect("films");
        let bends =
            |plan: &FilmPlan| -> Vec<DVec2> { plan.partition.frusta.iter().map(|frustum| frustum.film.bend).collect() };
        assert_eq!(first.partition.frusta.len(), second.partition.frusta.len());
        for (before, after) in bends(&first).into_iter().zip(bends(&second)) {
            assert!(
                (before - after).length() < 1.0e-9 * before.length().max(1.0),
                "{before} {after}"
            );
        }
        assert!(second.damping_cost <= 0.05, "{}", second.damping_cost);
    }
}

/// Films are those of what is asked for now, whatever was asked for before: no trace of it stays within the tolerance.
#[test]
fn films_with_other_choices_are_forgotten() {
    let seen = Seen::of_two_planes();
    let wanted = options(1, FilmDivision::Depth, FilmCover::Seen);
    let fresh = seen.plan(&wanted);
    let mut stretched = wanted;
    stretched.objective.metric = FilmMetric::Stretch;
    let mut differ = 0;
    for other in [options(1, FilmDivision::Depth, FilmCover::Body), stretched] {
        let before = seen.plan(&other);
        let after = seen.plan_from(&wanted, &before.memory).expect("films");
        assert_eq!(after.partition, fresh.partition, "{other:?}");
        close(after.damping_cost, 0.0, 1.0e-12);
        differ += usize::from(before.partition != fresh.partition);
    }
    assert_eq!(differ, 2, "there was something to forget");
}

/// Films follow a camera that turns: their cost stays small, and they arrive when it stops.
#[test]
fn films_follow() {
    let turned = |angle: f64| {
        let ahead = DVec3::new(angle.sin(), -0.3, -angle.cos());
        let camera = Camera::sparse(
            DVec3::new(0.0, 2.0, 0.0),
            ahead,
            0.5,
            1.5,
            UVec2::new(36, 24),
            UVec2::new(144, 96),
        );
        let receivers = Bounds::new(DVec3::new(-30.0, 0.0, -30.0), DVec3::new(30.0, 4.0, 10.0));
        Seen::new(camera, &scene_two(), receivers)
    };
    let options = options(1, FilmDivision::Depth, FilmCover::Seen);
    let mut memory = FilmMemory::default();
    let mut largest_cost = 0.0_f64;
    for step in 0..20 {
        let plan = turned(0.02 * f64::from(step))
            .plan_from(&options, &memory)
            .expect("films");
        largest_cost = largest_cost.max(plan.damping_cost);
        memory = plan.memory;
    }
    assert!(largest_cost > 0.0, "damping is at work");
    let still = turned(0.4);
    let mut cost = f64::INFINITY;
    for _ in 0..120 {
        let plan = still.plan_from(&options, &memory).expect("films");
        cost = plan.damping_cost;
        memory = plan.memory;
    }
    assert!(cost <= 0.05 + 1.0e-9, "two seconds later: {cost}");
    assert!(largest_cost < 1.0, "{largest_cost}");
}

/// Rectangles and the other metric have films too; a parallelogram is not worse than a rectangle.
#[test]
fn shapes() {
    let seen = Seen::of_two_planes();
    let error = |shape| {
        let mut options = options(1, FilmDivision::Depth, FilmCover::Seen);
        options.objective.shape = shape;
        seen.plan(&options).partition.frusta[0].film.error
    };
    let [rectangle, parallelogram] = [FilmShape::Rectangle, FilmShape::Parallelogram].map(error);
    assert!(
        parallelogram <= rectangle * (1.0 + 1.0e-9),
        "{parallelogram} {rectangle}"
    );
}

#[test]
fn nothing_has_no_films() {
    let mut seen = Seen::of_two_planes();
    let options = options(2, FilmDivision::Tiles, FilmCover::Seen);
    let last = FilmMemory::default();
    let block = seen.picture.blocks.iter().flatten().next().copied().expect("a block");
    seen.picture.blocks[0] = Some(umbrage::maths::light_plane::space::SeenBlock {
        position: DVec3::NAN,
        ..block
    });
    assert!(seen.plan_from(&options, &last).is_ok(), "one bad block is left out");
    seen.picture.blocks.fill(None);
    assert_eq!(
        seen.plan_from(&options, &last),
        Err(FilmError::NothingVisible),
        "only sky"
    );
    let seen = Seen::of_two_planes();
    let plan = |light_travel| {
        plan_films(&FilmPlanInput {
            view: &seen.view,
            receivers: &seen.receivers,
            light_travel,
            picture: &seen.picture,
            clip_from_world: seen.camera.grid.clip_from_world,
            margin: 0.1,
            options: &options,
            last: &last,
            seconds: 0.0,
        })
    };
    assert_eq!(
        plan(DVec3::ZERO),
        Err(FilmError::NotFinite),
        "a light without direction"
    );
    for travel in [seen.view.forward(), seen.view.forward() + DVec3::X * 1.0e-9] {
        let plan = plan(travel).expect("light along the view has films");
        assert!(seen.fits(&plan).iter().all(|fit| fit.clip_from_world.is_finite()));
    }
    let against = plan(-seen.view.forward());
    assert_eq!(
        against,
        Err(FilmError::NothingVisible),
        "all that is seen faces away from the light"
    );
}
