//! Several films: tiles, slices, allocation, order, lookup.

use bevy_math::{DVec2, DVec3, USizeVec2, UVec2};
use umbrage::maths::{
    light_plane::space::{
        DepthSlices, FilmBin, FilmFrustum, FilmMetric, FilmMoments, FilmObjective, FilmPartition, FilmSample,
        FilmTiles, MergeLimits, depth_order, slice_by_depth,
    },
    storage::{PackingState, SizeLimits, allocate},
};

use super::scene::{Camera, Lit, Piece, sunlit};
use crate::support::close;

/// A floor and a wall that the sun grazes: much projection aliasing on one side of the picture.
fn grazed() -> [Piece; 2] {
    [
        Piece {
            point: DVec3::ZERO,
            normal: DVec3::Y,
            contains: |point| point.x > -3.0 && point.x < 40.0 && point.z > -60.0,
        },
        Piece {
            point: DVec3::new(-3.0, 0.0, 0.0),
            normal: DVec3::X,
            contains: |point| point.y > 0.0 && point.y < 8.0 && point.z > -50.0,
        },
    ]
}

fn lit() -> Lit {
    seen(&grazed(), DVec3::new(-0.12, -1.0, -0.4))
}

/// A card near the viewer in front of a far wall, the sun from behind: both meet on the light plane, and one bend cannot
/// serve both. Films for slices of depth can.
fn lit_from_behind() -> Lit {
    let card = Piece {
        point: DVec3::new(0.0, 0.0, -4.0),
        normal: DVec3::Z,
        contains: |point| point.x.abs() < 1.0 && point.y < 2.5,
    };
    let wall = Piece {
        point: DVec3::new(0.0, 0.0, -60.0),
        normal: DVec3::Z,
        contains: |_| true,
    };
    seen(&[card, wall], DVec3::new(-0.12, -0.3, -1.0))
}

fn seen(pieces: &[Piece], light_travel: DVec3) -> Lit {
    let (eye, ahead) = (DVec3::new(0.0, 1.7, 0.0), DVec3::new(-0.1, -0.1, -1.0));
    let camera = Camera::sparse(eye, ahead, 0.5, 1.5, UVec2::new(72, 48), UVec2::new(1080, 720));
    sunlit(&camera, pieces, light_travel)
}

fn tiles_of(lit: &Lit, size: usize) -> FilmTiles {
    let mut tiles = FilmTiles::new(USizeVec2::splat(size));
    for sample in &lit.samples {
        tiles.add(sample);
    }
    tiles
}

fn limits(frusta: usize) -> MergeLimits {
    MergeLimits { frusta, pass_cost: 0.0 }
}

const TEXELS: f64 = 1024.0 * 1024.0;

#[test]
fn tiles_keep_every_pixel() {
    let lit = lit();
    let whole = lit.moments();
    let objective = FilmObjective::default();
    let (partition, _) = tiles_of(&lit, 8).merged(&limits(1), objective).expect("samples");
    assert_eq!(partition.frusta.len(), 1);
    close(partition.frusta[0].film.pixels, whole.pixels, 1.0e-9);
    let single = lit
        .bin()
        .problem(objective)
        .expect("samples")
        .solve(&[])
        .expect("samples");
    close(partition.mean_error(TEXELS), single.mean_error(TEXELS), 1.0e-3);
}

/// The thesis: two or three films bring most of the gain where there is projection aliasing, more never much.
#[test]
fn films_gain_where_the_sun_grazes() {
    let lit = lit();
    for metric in [FilmMetric::Area, FilmMetric::Stretch] {
        let objective = FilmObjective {
            metric,
            ..FilmObjective::default()
        };
        let tiles = tiles_of(&lit, 8);
        let mut cut_before = f64::INFINITY;
        let errors: Vec<[f64; 2]> = (1..=4)
            .map(|frusta| {
                let ways = [
                    tiles.merged(&limits(frusta), objective),
                    tiles.cut(&limits(frusta), objective),
                ];
                ways.map(|way| {
                    let (partition, owners) = way.expect("samples");
                    assert!(partition.frusta.len() <= frusta, "{} films", partition.frusta.len());
                    let owned = owners.owners.iter().flatten().max();
                    assert_eq!(owned, Some(&(partition.frusta.len() - 1)));
                    partition.mean_error(TEXELS)
                })
            })
            .collect();
        for (films, [merged, cut]) in errors.iter().enumerate() {
            assert!(*cut <= merged * 1.02, "{metric:?}, {films}: {errors:?}");
            assert!(*cut <= cut_before * 1.001, "{metric:?}, {films}: {errors:?}");
            cut_before = *cut;
        }
        assert!(errors[1][1] < errors[0][1] / 1.5, "{metric:?}: {errors:?}");
        assert!(errors[2][0] < errors[0][0] / 1.5, "{metric:?}: {errors:?}");
    }
}

/// Merging goes on below the budget when a film gains too little (section 3.2, stop rule).
#[test]
fn films_have_to_pay() {
    let lit = lit();
    let greedy = |pass_cost| {
        let limits = MergeLimits { frusta: 8, pass_cost };
        tiles_of(&lit, 4)
            .merged(&limits, FilmObjective::default())
            .expect("samples")
            .0
            .frusta
            .len()
    };
    assert!(greedy(0.0) > 3, "{}", greedy(0.0));
    assert!(greedy(0.2) < greedy(0.0), "{}", greedy(0.2));
    assert_eq!(greedy(1.0), 1);
}

/// Every pixel finds its film by the tile, with its middle inside the film's map; so do the corners of samples in the
/// film of one of their neighbours.
#[test]
fn the_lookup_finds_a_film_that_covers() {
    let lit = lit();
    let tiles = tiles_of(&lit, 6);
    for frusta in [2, 3, 5] {
        let merged = tiles.merged(&limits(frusta), FilmObjective::default());
        let cut = tiles.cut(&limits(frusta), FilmObjective::default());
        for (partition, owners) in [merged, cut].map(|way| way.expect("samples")) {
            let assert_covered = |film: DVec2| {
                let owner = owners.owner(film).expect("a tile with samples");
                let place = partition.frusta[owner].film.place(film).expect("w > 0");
                let inside = place.min_element() > -1.0e-9 && place.max_element() < 1.0 + 1.0e-9;
                assert!(inside, "{place} of film {owner}");
            };
            for (sample, (point, _)) in lit.samples.iter().zip(&lit.points) {
                assert_covered(sample.film);
                // Points between the middle and a corner too: the pixel is cut where the tiles meet.
                for corner in sample.corners {
                    assert_covered(sample.film.lerp(corner, 0.9));
                }
                assert!(partition.containing(&lit.base, *point).is_some(), "{point}");
            }
        }
    }
    let (_, owners) = tiles_of(&lit, 8)
        .merged(&limits(2), FilmObjective::default())
        .expect("samples");
    assert!(owners.owners.contains(&None), "tiles without samples belong to nobody");
}

/// Greedy merging against all divisions of a 3 × 3 grid into two rectangles.
#[test]
fn greedy_merging_is_near_the_best_cut() {
    let lit = lit();
    let objective = FilmObjective::default();
    let (greedy, _) = tiles_of(&lit, 3).merged(&limits(2), objective).expect("samples");
    let mut best = f64::INFINITY;
    for axis in 0..2 {
        for border in [-1.0 / 3.0, 1.0 / 3.0] {
            // Two tiles whose border lies there: move the film so that it is in the middle.
            let moved = |sample: &FilmSample| {
                let mut offset = DVec2::ZERO;
                offset[axis] = -border;
                FilmSample {
                    film: sample.film + offset,
                    corners: sample.corners.map(|corner| corner + offset),
                    ..*sample
                }
            };
            let mut size = USizeVec2::ONE;
            size[axis] = 2;
            let mut tiles = FilmTiles::new(size);
            for sample in &lit.samples {
                tiles.add(&moved(sample));
            }
            best = best.min(
                tiles
                    .merged(&limits(2), objective)
                    .expect("samples")
                    .0
                    .mean_error(TEXELS),
            );
        }
    }
    let single = lit
        .bin()
        .problem(objective)
        .expect("samples")
        .solve(&[])
        .expect("samples")
        .mean_error(TEXELS);
    let error = greedy.mean_error(TEXELS);
    assert!(error < best * 1.05, "{error} against {best}, one film {single}");
}

fn partition_of(errors: &[f64]) -> FilmPartition {
    let bin = lit().bin();
    let frustum = FilmFrustum::of_bin(&bin, FilmObjective::default(), &[]).expect("samples");
    let frusta = errors.iter().map(|error| {
        let mut frustum = frustum.clone();
        (frustum.film.error, frustum.film.pixels, frustum.film.aspect) = (*error, 1.0, 2.0);
        frustum
    });
    FilmPartition {
        frusta: frusta.collect(),
    }
}

/// Texels in proportion to √e: oracle O14's L1 allocation, 10 : 20 : 30, of total error 0.6 for 60 texels (0.7 evenly).
#[test]
fn texels_go_where_the_error_is() {
    let partition = partition_of(&[1.0, 4.0, 9.0]);
    for (share, expected) in partition.shares().into_iter().zip([1.0, 2.0, 3.0]) {
        close(share, expected / 6.0, 1.0e-12);
    }
    close(partition.mean_error(60.0) * 3.0, 0.6, 1.0e-12);
    close(partition.mean_error_of(&[10.0, 20.0, 30.0]) * 3.0, 0.6, 1.0e-12);
    close(partition.mean_error_of(&[20.0, 20.0, 20.0]) * 3.0, 0.7, 1.0e-12);
    // No other allocation is better.
    for (first, second) in [(9.0, 20.0), (11.0, 20.0), (10.0, 21.0), (12.0, 18.0)] {
        let texels = [first, second, 60.0 - first - second];
        assert!(partition.mean_error_of(&texels) * 3.0 > 0.6, "{texels:?}");
    }
    let sizes = allocate(&partition.needed_sizes(), 6 * 512 * 512, &SizeLimits::default()).sizes;
    for (size, texels) in sizes
        .iter()
        .zip([512.0 * 512.0, 2.0 * 512.0 * 512.0, 3.0 * 512.0 * 512.0])
    {
        close(f64::from(size.x * size.y), texels, 0.04);
        close(f64::from(size.x) / f64::from(size.y), 2.0, 0.04);
    }
    let packing = partition.fill_atlas(2048, &SizeLimits::default());
    assert_eq!(packing.state, PackingState::Whole);
    assert_eq!(packing.cells.len(), 3);
}

#[test]
fn slices_are_in_order() {
    let lit = lit();
    let mut slices = DepthSlices::new(12, 2.0, 70.0).expect("a range");
    for sample in &lit.samples {
        slices.add(sample);
    }
    let objective = FilmObjective::default();
    let single = lit
        .bin()
        .problem(objective)
        .expect("samples")
        .solve(&[])
        .expect("samples");
    let mut before = f64::INFINITY;
    for frusta in 1..=4 {
        let partition = slice_by_depth(&slices, &limits(frusta), objective).expect("samples");
        assert!(partition.frusta.len() <= frusta, "{} films", partition.frusta.len());
        let order = partition.depth_order().expect("slices never overlap");
        assert!(order.is_sorted(), "from near to far: {order:?}");
        let pixels: f64 = partition.frusta.iter().map(|frustum| frustum.film.pixels).sum();
        close(pixels, lit.moments().pixels, 1.0e-9);
        let error = partition.mean_error(TEXELS);
        assert!(error <= before * 1.02, "{frusta} films: {error}");
        before = error;
        // By depth alone every sample finds a film that covers it.
        for sample in &lit.samples {
            let [near, far] = sample.depths;
            for depth in [near, far] {
                let inside = |frustum: &&FilmFrustum| frustum.depths[0] <= depth && depth <= frustum.depths[1] + 1.0e-9;
                let frustum = partition.frusta.iter().find(inside).expect("depths have no gap");
                let place = frustum.film.place(sample.film).expect("w > 0");
                assert!(
                    place.min_element() > -1.0e-9 && place.max_element() < 1.0 + 1.0e-9,
                    "{place}"
                );
            }
        }
    }
    let partition = slice_by_depth(&slices, &limits(1), objective).expect("samples");
    close(partition.mean_error(TEXELS), single.mean_error(TEXELS), 1.0e-3);
}

/// The dynamic programme against every division of five slices into at most three runs.
#[test]
fn the_runs_of_slices_are_the_best() {
    let lit = lit_from_behind();
    let (near, far, count) = (2.0_f64, 70.0_f64, 5);
    let mut slices = DepthSlices::new(count, near, far).expect("a range");
    for sample in &lit.samples {
        slices.add(sample);
    }
    let objective = FilmObjective::default();
    let found = slice_by_depth(&slices, &limits(3), objective).expect("samples");
    close(slices.start(0), near, 1.0e-12);
    close(slices.start(count), far, 1.0e-12);
    // Runs are told apart by where they start: one run at a time through a coarser programme that has no choice.
    let mut best = f64::INFINITY;
    for first in 1..count {
        for second in first..count {
            let bounds = [0, first, second, count].map(|index| slices.start(index));
            let needs = bounds.windows(2).filter(|range| range[0] < range[1]).map(|range| {
                let mut run = DepthSlices::new(1, range[0], range[1]).expect("a range");
                for sample in &lit.samples {
                    let [from, to] = sample.depths;
                    let inside = (to.min(range[1]).ln() - from.max(range[0]).ln()) / (to / from).ln();
                    let is_first_or_last = [range[0] == near && to <= range[0], range[1] == far && from >= range[1]];
                    let share = if from == to { 1.0 } else { inside };
                    if share > 0.0 || is_first_or_last.contains(&true) {
                        run.add(&FilmSample {
                            pixels: sample.pixels * share.clamp(0.0, 1.0),
                            ..*sample
                        });
                    }
                }
                let partition = slice_by_depth(&run, &limits(1), objective);
                partition.map_or(0.0, |partition| partition.frusta[0].film.error.sqrt())
            });
            best = best.min(needs.sum::<f64>().powi(2));
        }
    }
    let single = lit
        .bin()
        .problem(objective)
        .expect("samples")
        .solve(&[])
        .expect("samples")
        .error;
    let found = found.mean_error(1.0) * lit.moments().pixels;
    assert!(found < single / 1.5, "{found} against one film's {single}");
    assert!(found < best * 1.01, "{found} against {best}");
}

#[test]
fn order_by_depth() {
    assert_eq!(depth_order(&[[5.0, 9.0], [1.0, 5.0], [9.0, 40.0]]), Some(vec![1, 0, 2]));
    assert_eq!(depth_order(&[[1.0, 5.1], [5.0, 9.0]]), None);
    assert_eq!(depth_order(&[]), Some(Vec::new()));
    let lit = lit();
    let (partition, _) = tiles_of(&lit, 8)
        .merged(&limits(3), FilmObjective::default())
        .expect("samples");
    let depths: Vec<[f64; 2]> = partition.frusta.iter().map(|frustum| frustum.depths).collect();
    assert_eq!(partition.depth_order(), depth_order(&depths));
}

/// Bins add up to the whole, whatever the order.
#[test]
fn bins_merge() {
    let lit = lit();
    let (first, second) = lit.samples.split_at(lit.samples.len() / 3);
    let mut merged = FilmBin::of_samples(second);
    merged.merge(&FilmBin::of_samples(first));
    let whole = lit.bin();
    let sum = |moments: &FilmMoments| moments.area_sum(DVec2::new(0.2, 0.1));
    close(sum(&merged.moments), sum(&whole.moments), 1.0e-12);
    assert_eq!(merged.depths, whole.depths);
    let objective = FilmObjective::default();
    let error = |bin: &FilmBin| {
        bin.problem(objective)
            .expect("samples")
            .solve(&[])
            .expect("samples")
            .error
    };
    close(error(&merged), error(&whole), 1.0e-6);
    assert!(FilmBin::default().is_empty(), "nothing in it");
}
