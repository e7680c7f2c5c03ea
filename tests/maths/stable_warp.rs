//! Warped maps whose texels stand still.

use bevy_math::{DMat4, DVec2, DVec3, UVec2};
use umbrage::maths::{
    body::light_visible,
    error::LargestErrors,
    fit::LightAxes,
    footprint::texel_footprint,
    split::{SplitScheme, split_depths},
    stable::{
        fixed_axes,
        sphere::{SnappedMap, bounding_sphere},
        warped::{LatticeSteps, SeenPoint, StableMap, StableSettings, WarpWish, WarpedGrid, fresh, hold, lattice},
    },
    view::ViewVolume,
    warp::Warp,
};

use crate::{
    stable::{LIGHT, MAP_SIZE, around, camera, direction, land, misfit, texel, walk},
    support::{bodies, fit},
};

fn settings() -> StableSettings {
    StableSettings {
        map_size: MAP_SIZE,
        guard_texels: 2.0,
        room: 0.1,
        tolerance: 2.0,
    }
}

fn wish<'a>(slice: &ViewVolume, warp: Warp, seen: &'a mut Vec<SeenPoint>) -> WarpWish<'a> {
    let fit = fit(slice, &land(), LIGHT, warp);
    let visible = light_visible(slice, &land());
    *seen = visible
        .vertices()
        .iter()
        .map(|vertex| SeenPoint {
            position: *vertex,
            depth: slice.depth(*vertex).max(slice.near()),
        })
        .collect();
    WarpWish {
        axes: fit.axes,
        near_point: fit.world_from_light.w_axis.truncate(),
        warp_near: fit.warp_near,
        seen,
    }
}

fn matrix(map: &StableMap) -> DMat4 {
    map.grid.clip_from_world(&map.window, -300.0, 300.0)
}

/// The derivation of [`umbrage::maths::stable::warped`]: anchors on one axis of one centre, scales as the square of n',
/// make one grid.
#[test]
fn one_grid_has_many_anchors() {
    let axes = LightAxes::new(DVec3::NEG_Z, DVec3::Y, LIGHT).expect("a light");
    let grid = WarpedGrid {
        axes,
        anchor: DVec2::new(1.5, -2.0),
        warp_near: 6.0,
        texels_per_metre: DVec2::new(80.0, 120.0),
        level: 0.0,
    };
    let forward = 2.5;
    let (first, second) = (6.0, 6.0 + forward);
    let same = WarpedGrid {
        anchor: grid.anchor + DVec2::Y * forward,
        warp_near: second,
        texels_per_metre: DVec2::new(80.0 * first / second, 120.0 * (first / second).powi(2)),
        ..grid
    };
    let points = around(DVec3::NEG_Z * 10.0);
    let shift = |point: &DVec3| grid.texel(*point).expect("before the centre") - same.texel(*point).expect("before");
    for point in &points {
        assert!(shift(point).distance(shift(&points[0])) < 1.0e-9, "a constant shift");
    }
    assert!(shift(&points[0]).y.abs() > 10.0);
    // Any other centre or scale is another grid.
    for other in [
        WarpedGrid { warp_near: 8.6, ..same },
        WarpedGrid {
            anchor: same.anchor + DVec2::X * 0.01,
            ..same
        },
        WarpedGrid {
            texels_per_metre: same.texels_per_metre * 1.001,
            ..same
        },
    ] {
        let shift = |point: &DVec3| grid.texel(*point).expect("before") - other.texel(*point).expect("before");
        assert!(
            points
                .iter()
                .any(|point| shift(point).distance(shift(&points[0])) > 1.0e-3),
            "{other:?}"
        );
    }
    assert_eq!(grid.texel(DVec3::Z * 100.0), None, "behind the centre");
}

/// The matrix of a stable map shows its window of its grid, as the fit of the same warp would.
#[test]
fn matrices_of_grids_agree_with_the_fit() {
    let slice = camera(DVec3::Y * 1.7, direction(20.0), 0.5, 60.0);
    for warp in [Warp::Lispsm, Warp::Uniform] {
        let mut seen = Vec::new();
        let wish = wish(&slice, warp, &mut seen);
        assert_eq!(wish.warp_near.is_finite(), warp == Warp::Lispsm);
        let map = hold(None, &wish, &settings()).expect("sees the land");
        let matrix = matrix(&map);
        for point in wish.seen {
            let expected = map.grid.texel(point.position).expect("before the centre") - map.window.first;
            assert!(
                texel(&matrix, point.position, MAP_SIZE).distance(expected) < 1.0e-6,
                "{point:?}"
            );
            assert!(
                expected.min_element() >= 2.0 && expected.max_element() <= 1022.0,
                "guard texels: {expected}"
            );
            let moved = matrix.project_point3(point.position - LIGHT);
            let here = matrix.project_point3(point.position);
            assert!(
                (moved - here).truncate().length() < 1.0e-9 && moved.z > here.z,
                "along the light"
            );
        }
        let sharpest = fresh(&wish, &settings()).expect("sees the land");
        let reference = fit(&slice, &land(), LIGHT, warp);
        let sizes = texel_footprint(
            &reference.clip_from_world,
            UVec2::splat(MAP_SIZE),
            slice.eye() + slice.forward(),
        );
        let lengths = sizes.expect("in the map").lengths();
        let mut from_grid = map;
        from_grid.grid = sharpest;
        let sizes = texel_footprint(
            &self::matrix(&from_grid),
            UVec2::splat(MAP_SIZE),
            slice.eye() + slice.forward(),
        );
        let of_grid = sizes.expect("in the map").lengths();
        assert!(
            (of_grid / lengths - 1.0).abs().max_element() < 0.02,
            "{of_grid} against {lengths}"
        );
    }
}

/// Shaders work in single precision: within 100 m of the origin the grid stays to a fiftieth of a texel.
#[test]
fn single_precision_keeps_the_grid() {
    let mut seen = Vec::new();
    let mut last: Option<StableMap> = None;
    for frame in 0..60 {
        let (eye, forward) = walk(f64::from(frame) / 60.0);
        let slice = camera(eye + DVec3::new(80.0, 0.0, -60.0), forward, 2.2, 16.0);
        let wish = wish(&slice, Warp::Lispsm, &mut seen);
        let map = hold(last.as_ref().map(|map| &map.grid), &wish, &settings()).expect("sees the land");
        let shadow_texel = |map: &StableMap, point: DVec3| {
            let ndc = matrix(map).as_mat4().project_point3(point.as_vec3());
            (ndc.truncate().as_dvec2() * 0.5 + 0.5) * f64::from(MAP_SIZE)
        };
        if let Some(last) = last.filter(|last| last.grid == map.grid) {
            for point in wish.seen {
                let shift = shadow_texel(&map, point.position) - shadow_texel(&last, point.position);
                assert!(
                    (shift - shift.round()).abs().max_element() < 0.02,
                    "frame {frame}: {shift}"
                );
            }
        }
        last = Some(map);
    }
}

/// All of B lies inside the depths of its map, with room for bias, and they rarely change.
#[test]
fn depths_of_stable_maps() {
    let mut previous: Option<(StableMap, (f64, f64))> = None;
    let (mut same_grid, mut same_depths) = (0, 0);
    let mut seen = Vec::new();
    for frame in 0..300 {
        let (eye, forward) = walk(f64::from(frame) / 60.0);
        let slice = camera(eye, forward, 2.2, 16.0);
        let wish = wish(&slice, Warp::Lispsm, &mut seen);
        let last = previous.as_ref().map(|(map, _)| &map.grid);
        let map = hold(last, &wish, &settings()).expect("sees the land");
        let (_, body) = bodies(&slice, &land(), LIGHT);
        let depths = map.grid.depth_range(body.vertices()).expect("a body");
        let matrix = map.grid.clip_from_world(&map.window, depths.0, depths.1);
        for vertex in body.vertices() {
            let ndc = matrix.project_point3(*vertex);
            assert!(ndc.z > 0.001 && ndc.z < 0.999, "frame {frame}: {ndc}");
            assert!(ndc.truncate().abs().max_element() < 1.0, "frame {frame}: {ndc}");
        }
        let extremes = body.vertices().iter().map(|vertex| matrix.project_point3(*vertex).z);
        let (least, greatest) = extremes.fold((1.0_f64, 0.0_f64), |(a, b), z| (a.min(z), b.max(z)));
        assert!(greatest - least > 0.8, "frame {frame}: {least} to {greatest}");
        if let Some((last, last_depths)) = previous
            && last.grid == map.grid
        {
            same_grid += 1;
            same_depths += i32::from(last_depths == depths);
        }
        previous = Some((map, depths));
    }
    assert!(same_depths * 100 > same_grid * 80, "{same_depths} of {same_grid}");
    let grid = previous.expect("a map").0.grid;
    assert_eq!(grid.depth_range(&[]), None);
    assert_eq!(grid.depth_range(&[DVec3::NAN]), None);
    assert_eq!(grid.depth_range(&[DVec3::Z * 1.0e4]), None, "behind the centre");
}

/// What one design does on the walk.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    frames: u32,
    unchanged: u32,
    /// Sum and largest of texel ÷ pixel over that of a fresh fit.
    sum: f64,
    worst: f64,
    /// Sum of texel ÷ pixel over that of the sphere-snapped uniform map.
    sum_to_sphere: f64,
}

impl Outcome {
    fn unchanged_share(&self) -> f64 {
        f64::from(self.unchanged) / f64::from(self.frames - 1)
    }

    fn mean(&self) -> f64 {
        self.sum / f64::from(self.frames)
    }

    fn mean_to_sphere(&self) -> f64 {
        self.sum_to_sphere / f64::from(self.frames)
    }
}

/// Texel ÷ pixel: the root of the storage factor, relative.
fn side(errors: LargestErrors) -> f64 {
    errors.storage_factor().sqrt()
}

/// Walks for 15 s at 60 frames per second with one of three logarithmic slices from 0.3 m to 120 m.
fn experiment(slice_index: usize, design: &Design) -> Outcome {
    let depths = split_depths(&SplitScheme::Logarithmic, 0.3, 120.0, 3);
    let (near, far) = (depths[slice_index], depths[slice_index + 1]);
    let axes = fixed_axes(LIGHT).expect("a light");
    let mut outcome = Outcome::default();
    let mut last: Option<(StableMap, DMat4)> = None;
    let mut seen = Vec::new();
    for frame in 0..900 {
        let (eye, forward) = walk(f64::from(frame) / 60.0);
        let slice = camera(eye, forward, near, far);
        let wish = wish(&slice, Warp::Lispsm, &mut seen);
        let map = design(last.as_ref().map(|(map, _)| &map.grid), &wish).expect("sees the land");
        let now = matrix(&map);
        for point in wish.seen {
            let texel = texel(&now, point.position, MAP_SIZE);
            assert!(
                texel.min_element() >= 2.0 - 1.0e-6 && texel.max_element() <= 1022.0 + 1.0e-6,
                "frame {frame}"
            );
        }
        if let Some((previous, before)) = &last {
            let points: Vec<DVec3> = wish.seen.iter().map(|point| point.position).collect();
            let misfit = misfit(before, &now, &points, MAP_SIZE);
            // No texel depends on the level.
            let on_last_level = WarpedGrid {
                level: previous.grid.level,
                ..map.grid
            };
            if previous.grid == on_last_level {
                outcome.unchanged += 1;
                assert!(
                    misfit < 1.0e-5,
                    "frame {frame}: the window slides by whole texels: {misfit}"
                );
            } else {
                assert!(misfit > 1.0e-4, "frame {frame}: another grid");
            }
        }
        let sharpest = side(fresh(&wish, &settings()).expect("sees the land").errors(wish.seen));
        let ours = side(map.grid.errors(wish.seen));
        let sphere = bounding_sphere(&slice).expect("a far plane");
        let uniform = SnappedMap::around(&sphere, &axes, MAP_SIZE).texel.x / near;
        outcome.frames += 1;
        outcome.sum += ours / sharpest;
        outcome.worst = outcome.worst.max(ours / sharpest);
        outcome.sum_to_sphere += ours / uniform;
        last = Some((map, now));
    }
    outcome
}

/// The numbers of the module's table: frames without a change, and texel ÷ pixel against a fresh fit (mean and largest)
/// and against the sphere-snapped uniform map (mean), for three slices.
#[test]
fn warped_maps_that_stand_still_on_a_walk() {
    let loose = StableSettings {
        room: 0.2,
        tolerance: 3.0,
        ..settings()
    };
    let steps = LatticeSteps::default();
    let designs: [(&str, &Design, [[f64; 4]; 3]); 4] = [
        (
            "hold",
            &|previous, wish| hold(previous, wish, &settings()),
            [
                [0.919, 1.25, 1.41, 0.38],
                [0.981, 1.23, 1.41, 0.35],
                [0.981, 1.16, 1.41, 0.30],
            ],
        ),
        (
            "hold loosely",
            &|previous, wish| hold(previous, wish, &loose),
            [
                [0.945, 1.45, 1.73, 0.44],
                [0.990, 1.45, 1.73, 0.41],
                [0.988, 1.28, 1.73, 0.33],
            ],
        ),
        (
            "lattice",
            &|_, wish| lattice(wish, &steps, &settings()),
            [
                [0.836, 1.38, 1.73, 0.42],
                [0.960, 1.35, 1.55, 0.39],
                [0.962, 1.41, 1.68, 0.36],
            ],
        ),
        (
            "fresh",
            &|_, wish| hold(None, wish, &settings()),
            [[0.0, 1.1, 1.1, 0.34], [0.0, 1.1, 1.1, 0.31], [0.0, 1.1, 1.1, 0.28]],
        ),
    ];
    for (name, design, expected) in designs {
        for (slice, expected) in expected.into_iter().enumerate() {
            let outcome = experiment(slice, design);
            let measured = [
                outcome.unchanged_share(),
                outcome.mean(),
                outcome.worst,
                outcome.mean_to_sphere(),
            ];
            let is_close = measured
                .iter()
                .zip(expected)
                .all(|(measured, expected)| (measured - expected).abs() < 0.02);
            assert!(
                is_close,
                "{name}, slice {slice}: {measured:.3?} instead of {expected:?}"
            );
        }
    }
}

type Design<'a> = dyn Fn(Option<&WarpedGrid>, &WarpWish) -> Option<StableMap> + 'a;

/// The same camera gets the same grid from the lattice, whatever came before; no grid is held under another light.
#[test]
fn memory_and_light() {
    let slice = camera(DVec3::new(3.0, 1.7, 5.0), direction(37.0), 0.5, 30.0);
    let mut seen = Vec::new();
    let wish = wish(&slice, Warp::Lispsm, &mut seen);
    let steps = LatticeSteps::default();
    let map = lattice(&wish, &steps, &settings()).expect("sees the land");
    let nearly = WarpWish {
        near_point: wish.near_point + DVec3::splat(1.0e-6),
        warp_near: wish.warp_near * (1.0 + 1.0e-6),
        ..wish
    };
    assert_eq!(
        lattice(&nearly, &steps, &settings()).map(|map| map.grid),
        Some(map.grid)
    );
    let held = hold(None, &wish, &settings()).expect("sees the land");
    assert_eq!(hold(Some(&held.grid), &nearly, &settings()), Some(held));
    let moved_light = WarpedGrid {
        axes: LightAxes::new(direction(37.0), DVec3::Y, LIGHT + DVec3::X * 1.0e-3).expect("a light"),
        ..held.grid
    };
    assert_ne!(
        hold(Some(&moved_light), &wish, &settings()).map(|map| map.grid),
        Some(moved_light)
    );
}

#[test]
fn wishes_without_an_answer_have_no_map() {
    let slice = camera(DVec3::Y * 1.7, DVec3::NEG_Z, 0.5, 30.0);
    let mut seen = Vec::new();
    let good = wish(&slice, Warp::Lispsm, &mut seen);
    let nowhere = [SeenPoint {
        position: DVec3::NAN,
        depth: 1.0,
    }];
    let tiny = StableSettings {
        map_size: 4,
        ..settings()
    };
    for (wish, settings) in [
        (WarpWish { seen: &[], ..good }, settings()),
        (WarpWish { seen: &nowhere, ..good }, settings()),
        (
            WarpWish {
                near_point: DVec3::NAN,
                ..good
            },
            settings(),
        ),
        (
            WarpWish {
                warp_near: f64::NAN,
                ..good
            },
            settings(),
        ),
        (WarpWish { warp_near: 0.0, ..good }, settings()),
        (good, tiny),
    ] {
        assert_eq!(hold(None, &wish, &settings), None, "{wish:?}");
        assert_eq!(lattice(&wish, &LatticeSteps::default(), &settings), None, "{wish:?}");
    }
    // One point: a map of almost nothing, but a map.
    let alone = [good.seen[0]];
    let map = hold(None, &WarpWish { seen: &alone, ..good }, &settings()).expect("one point");
    assert!(map.grid.texels_per_metre.is_finite());
}
