//! Times of the mathematics that a frame needs on the CPU: `cargo bench --no-default-features`.
//!
//! Targets, on one core: four light views 0.1 ms, the plan of a fitted map 1 ms, the cells and levels of 100 000 trees for
//! an eye that walks 1 ms.

use std::hint::black_box;

use bevy_math::{DMat4, DVec2, DVec3, DVec4, UVec2};
use criterion::{Criterion, criterion_group, criterion_main};
use umbrage::maths::{
    body::{adjusted_depths, intersection_body, light_visible},
    bounds::Bounds,
    fit::{FitInput, FitOptions, LightAxes, LightFit, fit_light_view},
    light_plane::space::{
        BaseFilm, FilmBin, FilmMemory, FilmMetric, FilmObjective, FilmPlanInput, FilmPlanOptions, FilmSample,
        MergeLimits, SampleGrid, SeenBlock, SeenPicture, plan_films, reduce_block,
    },
    lod::{
        cells::{Cell, CellBorders, CellGrid, OpenCells},
        selection::LodBorders,
    },
    split::{SplitScheme, split_depths},
    view::ViewVolume,
    virtual_map::{
        fitted::FittedMap,
        grid::{GridOptions, NeedGrid},
        mapping::{MappingOptions, TileMappingMap},
        picture::DepthPicture,
    },
    warp::Warp,
};

const EYE: DVec3 = DVec3::new(0.0, 1.7, 0.0);
const SUN: DVec3 = DVec3::new(0.4, -0.8, 0.3);

fn scene() -> Bounds {
    Bounds::new(DVec3::new(-300.0, -2.0, -300.0), DVec3::new(300.0, 25.0, 300.0))
}

fn camera() -> ViewVolume {
    let forward = DVec3::new(0.2, -0.1, -1.0);
    ViewVolume::perspective(EYE, forward, DVec3::Y, 1.0, 16.0 / 9.0, 0.1, 500.0).expect("a camera")
}

/// H and adjusted depths of the view, then per slice H, B, warp and focus.
fn four_light_views(view: &ViewVolume, scene: &Bounds, light_travel: DVec3, warp: Warp) -> [LightFit; 4] {
    let (near, far) = adjusted_depths(&light_visible(view, scene), view).expect("receivers");
    let depths = split_depths(&SplitScheme::Practical { lambda: 0.9 }, near, far, 4);
    std::array::from_fn(|index| {
        let slice = view.split(depths[index], depths[index + 1]);
        let visible = light_visible(&slice, scene);
        let input = FitInput {
            view: &slice,
            visible: &visible,
            body: &intersection_body(&visible, scene, light_travel),
            light_travel,
            warp,
            map_size: UVec2::splat(2048),
            guard_texels: 2.0,
            guard_metres: 0.0,
            options: FitOptions::default(),
        };
        fit_light_view(&input).fitted().expect("a light view")
    })
}

fn fitting(criterion: &mut Criterion) {
    let (view, scene) = (camera(), scene());
    for (name, warp) in [("uniform", Warp::Uniform), ("lispsm", Warp::Lispsm)] {
        criterion.bench_function(&format!("four light views, {name}"), |bencher| {
            bencher.iter(|| four_light_views(black_box(&view), &scene, black_box(SUN), warp));
        });
    }
}

/// Reverse-z matrix of a camera with an infinite far plane.
fn clip_from_world(view: &ViewVolume) -> DMat4 {
    let back = -view.forward();
    let right = view.up().cross(back).normalize();
    let up = back.cross(right);
    let columns = [right.extend(0.0), up.extend(0.0), back.extend(0.0), EYE.extend(1.0)];
    let world_from_view = DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]);
    let scale = 2.0 / view.opening();
    let clip_from_view = DMat4::from_cols(
        DVec4::X * scale.x,
        DVec4::Y * scale.y,
        DVec4::NEG_W,
        DVec4::Z * view.near(),
    );
    clip_from_view * world_from_view.inverse()
}

/// Where a ray of the picture meets rolling ground, with its normal.
fn ground(view: &ViewVolume, world_from_clip: &DMat4, ndc: DVec2) -> Option<(DVec3, DVec3)> {
    let through = world_from_clip.project_point3(ndc.extend(0.5));
    let ray = (through - EYE).normalize();
    let height = |point: DVec3| point.y - 0.8 * (point.x * 0.11).sin() * (point.z * 0.07).cos();
    let mut distance = view.near();
    while distance < 400.0 {
        let point = EYE + ray * distance;
        if height(point) < 0.0 {
            let slope = |step: DVec3| (height(point + step) - height(point - step)) / 2.0e-3;
            let normal = DVec3::new(slope(DVec3::X * 1.0e-3), 1.0, slope(DVec3::Z * 1.0e-3));
            return Some((point, normal.normalize()));
        }
        distance += 0.02 + distance * 0.01;
    }
    None
}

/// Points and normals that the pixels of a picture see, row by row from the top; `None` where it sees the sky.
fn picture(view: &ViewVolume, size: UVec2) -> Vec<Option<(DVec3, DVec3)>> {
    let world_from_clip = clip_from_world(view).inverse();
    let pixel = |index: u32| {
        let place = DVec2::new(f64::from(index % size.x), f64::from(index / size.x)) + 0.5;
        let ndc = place / size.as_dvec2() * DVec2::new(2.0, -2.0) + DVec2::new(-1.0, 1.0);
        ground(view, &world_from_clip, ndc)
    };
    (0..size.x * size.y).map(pixel).collect()
}

fn planning(criterion: &mut Criterion) {
    let (view, scene) = (camera(), scene());
    let size = UVec2::new(480, 270);
    let matrix = clip_from_world(&view);
    let depth = |seen: &Option<(DVec3, DVec3)>| seen.map_or(0.0, |(point, _)| matrix.project_point3(point).z as f32);
    let depths: Vec<f32> = picture(&view, size).iter().map(depth).collect();
    let depths = DepthPicture::new(size, &depths, matrix.inverse()).expect("a picture");
    let visible = light_visible(&view, &scene);
    let input = FitInput {
        view: &view,
        visible: &visible,
        body: &intersection_body(&visible, &scene, SUN),
        light_travel: SUN,
        warp: Warp::Lispsm,
        map_size: UVec2::splat(2048),
        guard_texels: 2.0,
        guard_metres: 0.0,
        options: FitOptions::default(),
    };
    let master = fit_light_view(&input).fitted().expect("a light view");
    let mapping = TileMappingMap::new(
        &depths,
        &master.clip_from_world,
        UVec2::splat(256),
        &MappingOptions::default(),
    );
    let options = GridOptions::default();
    assert_eq!((options.tiles_per_axis, mapping.valid_texels() > 20_000), (32, true));
    // What `fitted` draws, what the thesis does, and `fitted:xi=-2`; with 2 x 2 comparisons tiles are halves, and twice as many.
    let drawn = FittedMap {
        tile_cost: Some(65_536),
        ..FittedMap::default()
    };
    let thesis = FittedMap {
        tile_cost: None,
        ..drawn
    };
    let filtered = FittedMap {
        tiles_per_axis: 64,
        tile_size_max: 2048,
        margin: 1,
        ..drawn
    };
    let fine = FittedMap {
        quality_drop: -2,
        ..filtered
    };
    for (name, map) in [
        ("n = 32", drawn),
        ("n = 32, as the thesis splits", thesis),
        ("n = 64, 2 x 2 comparisons", filtered),
        ("n = 64, 2 x 2 comparisons, xi = -2", fine),
    ] {
        let options = GridOptions {
            tiles_per_axis: map.grid_tiles_per_axis(),
            ..options
        };
        criterion.bench_function(&format!("plan of a fitted map, 256² mapping map, {name}"), |bencher| {
            bencher.iter(|| map.plan(&NeedGrid::new(black_box(&mapping), &options)));
        });
        let grid = NeedGrid::new(&mapping, &options);
        criterion.bench_function(&format!("plan of a fitted map from its grid, {name}"), |bencher| {
            bencher.iter(|| map.plan(black_box(&grid)));
        });
    }
}

fn films(criterion: &mut Criterion) {
    let view = camera();
    let samples = UVec2::new(64, 36);
    let seen: Vec<(DVec3, DVec3)> = picture(&view, samples).into_iter().flatten().collect();
    let receivers: Vec<DVec3> = seen.iter().map(|(point, _)| *point).collect();
    let axes = LightAxes::new(view.forward(), view.up(), SUN).expect("a light");
    let base = BaseFilm::of_sun(axes, &receivers).expect("receivers");
    let grid = SampleGrid {
        clip_from_world: clip_from_world(&view),
        picture_size: UVec2::new(1920, 1080),
        samples,
    };
    let sampled = seen
        .iter()
        .filter_map(|(point, normal)| FilmSample::new(&base, &grid, *point, *normal).ok());
    let bin = FilmBin::of_samples(&sampled.collect::<Vec<_>>());
    for (name, metric) in [("area", FilmMetric::Area), ("stretch", FilmMetric::Stretch)] {
        let objective = FilmObjective {
            metric,
            ..FilmObjective::default()
        };
        criterion.bench_function(&format!("optimal film, {name}"), |bencher| {
            bencher.iter(|| {
                black_box(&bin)
                    .problem(objective)
                    .and_then(|problem| problem.solve(&[]))
            });
        });
    }
}

/// From a picture of blocks to films: all that a frame computes.
fn film_plans(criterion: &mut Criterion) {
    let view = camera();
    let (size, grid) = (UVec2::new(192, 108), UVec2::new(48, 27));
    let clip = clip_from_world(&view);
    let seen = picture(&view, size);
    let depths: Vec<f32> = seen
        .iter()
        .map(|hit| hit.map_or(0.0, |(point, _)| clip.project_point3(point).z as f32))
        .collect();
    let blocks = (0..grid.element_product()).map(|index| {
        let reduced = reduce_block(&depths, size, grid, UVec2::new(index % grid.x, index / grid.x))?;
        let (position, normal) = seen[(reduced.pixel.y * size.x + reduced.pixel.x) as usize]?;
        Some(SeenBlock {
            position,
            normal,
            depths_ndc: reduced.depths_ndc,
            pixel: reduced.pixel,
            pixels: reduced.pixels,
            plane: reduced.plane,
        })
    });
    let picture = SeenPicture {
        clip_from_world: clip,
        size,
        grid,
        blocks: blocks.collect(),
    };
    let receivers = scene();
    for frusta in [1, 4] {
        let options = FilmPlanOptions {
            limits: MergeLimits {
                frusta,
                ..MergeLimits::default()
            },
            ..FilmPlanOptions::default()
        };
        let last = FilmMemory::default();
        let input = FilmPlanInput {
            view: &view,
            receivers: &receivers,
            light_travel: SUN,
            picture: &picture,
            clip_from_world: clip,
            margin: 0.0,
            options: &options,
            last: &last,
            seconds: 1.0 / 60.0,
        };
        assert!(plan_films(&input).is_ok(), "the picture has films");
        criterion.bench_function(&format!("plan of {frusta} films, 48 x 27 blocks"), |bencher| {
            bencher.iter(|| plan_films(black_box(&input)));
        });
    }
}

/// Trees along a side of a leaf, and their spacing in metres.
const LEAF_TREES: u32 = 8;
const SPACING: f64 = 5.0;

/// What a frame has to ask of a field of trees: which cells change, and which level each near tree wants.
fn cells(criterion: &mut Criterion) {
    let grid = |trees: f64| CellGrid {
        corner: DVec2::splat(-0.5 * SPACING * trees.sqrt()),
        leaf_side: f64::from(LEAF_TREES) * SPACING,
        leaves: (trees.sqrt() / f64::from(LEAF_TREES)).ceil() as u32,
    };
    let borders = CellBorders {
        single: 124.0,
        blocks: 220.0,
        lead: 0.08,
    };
    let levels = LodBorders::new([25.0, 60.0]);
    for trees in [1e4, 1e5, 1e6] {
        let grid = grid(trees);
        let mut open = OpenCells::new(grid);
        let mut frame = 0_u32;
        criterion.bench_function(
            &format!("cells and levels of {trees} trees, an eye that walks"),
            |bencher| {
                bencher.iter(|| {
                    frame += 1;
                    let way = f64::from(frame % 8000) * 0.025;
                    let x = if way < 100.0 { way } else { 200.0 - way };
                    let eye = DVec3::new(x - 50.0, 1.7, 2.0);
                    let distance = |cell: Cell| {
                        let center = grid.center(cell);
                        eye.distance(DVec3::new(center.x, 0.0, center.y))
                    };
                    open.settle(&borders, distance);
                    let leaves = open.iter().filter(|cell| cell.level == 0);
                    let wanted = leaves.map(|leaf| {
                        let first = grid.center(leaf) - 0.5 * grid.leaf_side;
                        let tree = |i: u32| {
                            let place = DVec2::new((i % LEAF_TREES).into(), (i / LEAF_TREES).into()) + 0.5;
                            let foot = first + place * SPACING;
                            levels.held_level(2, eye.distance(DVec3::new(foot.x, 0.0, foot.y)), 0.05)
                        };
                        (0..LEAF_TREES * LEAF_TREES).map(tree).sum::<usize>()
                    });
                    black_box(wanted.sum::<usize>())
                });
            },
        );
    }
}

criterion_group!(benches, fitting, planning, films, film_plans, cells);
criterion_main!(benches);
