//! Plans of fitted maps: oracles 20 to 23 of Giegl, ξ, caps.

use bevy_math::{DVec2, UVec2};
use umbrage::maths::virtual_map::{
    fitted::{FittedMap, FittedPlan},
    grid::{NeedCell, NeedGrid},
    picture::PixelRect,
    tile::{Tile, TileWindow},
};

use super::scene::Numbers;

fn random_cells(n: u32, occupied: f64, numbers: &mut Numbers) -> Vec<NeedCell> {
    (0..n * n)
        .map(|index| {
            if numbers.unit() >= occupied {
                return NeedCell::EMPTY;
            }
            let min = UVec2::new(index % n, index / n) * 3;
            NeedCell {
                levels: [numbers.whole(6, 17) as u8, numbers.whole(6, 17) as u8],
                pixels: 1 + numbers.whole(0, 9),
                rect: PixelRect { min, max: min + 5 },
            }
        })
        .collect()
}

fn grid(cells: &[NeedCell]) -> NeedGrid {
    NeedGrid::from_cells(cells.to_vec()).expect("a square")
}

fn map(n: u32) -> FittedMap {
    FittedMap {
        tiles_per_axis: n,
        tile_size_min: 1,
        ..FittedMap::default()
    }
}

/// Oracle 20, on 50 random grids and for ξ: leaves are disjoint and over every occupied cell once; each has what its
/// cells need, or is as fine as allowed on that axis; no leaf is empty.
#[test]
fn leaves_cover_occupied_cells_once() {
    let mut numbers = Numbers(20);
    for run in 0..50 {
        let n = [32, 16, 8][run % 3];
        let cells = random_cells(n, 0.6, &mut numbers);
        for quality_drop in [0, 1, 3] {
            let settings = FittedMap { quality_drop, ..map(n) };
            let plan = settings.plan(&grid(&cells));
            for (index, cell) in cells.iter().enumerate() {
                let place = Tile {
                    place: UVec2::new(index as u32 % n, index as u32 / n),
                    counts: UVec2::splat(n),
                };
                let over: Vec<_> = plan.tiles.iter().filter(|leaf| leaf.tile.covers(&place)).collect();
                assert!(over.len() <= 1, "{} leaves over one cell", over.len());
                if cell.pixels == 0 {
                    continue;
                }
                assert_eq!(over.len(), 1, "an occupied cell without a leaf");
                let (leaf, resolution) = (over[0], over[0].effective_resolution());
                for axis in 0..2 {
                    let wanted = (i32::from(cell.levels[axis]).min(plan.cap as i32) - quality_drop).max(0);
                    assert!(resolution[axis] >= 1 << wanted, "{leaf:?}");
                }
                // Row F13 and oracle 23.
                assert_eq!(leaf.rect.union(cell.rect), leaf.rect);
            }
            assert!(plan.tiles.iter().all(|leaf| leaf.pixels > 0));
            assert_eq!(
                plan.tiles.iter().map(|leaf| leaf.pixels).sum::<u32>(),
                cells.iter().map(|cell| cell.pixels).sum::<u32>()
            );
            assert_eq!(plan, settings.plan(&grid(&cells)), "the same grid, the same plan");
        }
    }
}

/// Leaves are no finer than their need: the largest need in a leaf is met without a level to spare, unless the smallest
/// side is reached or the axis had to be split with its neighbour.
#[test]
fn leaves_are_as_small_as_their_need() {
    let mut numbers = Numbers(4);
    for _ in 0..20 {
        let plan = map(32).plan(&grid(&random_cells(32, 0.4, &mut numbers)));
        for leaf in &plan.tiles {
            for axis in 0..2 {
                let wanted = 1_u64 << leaf.levels[axis];
                let is_smallest = leaf.window.core()[axis] == 1;
                assert!(leaf.effective_resolution()[axis] == wanted || is_smallest, "{leaf:?}");
            }
        }
    }
}

/// Oracle 21.
#[test]
fn a_single_hot_cell() {
    for depth in 1..=5_u32 {
        let n = 1 << depth;
        let cool = NeedCell {
            levels: [6, 6],
            pixels: 1,
            rect: PixelRect::whole(UVec2::ONE),
        };
        let mut cells = vec![cool; (n * n) as usize];
        cells[0].levels = [12 + depth as u8; 2];
        assert_eq!(map(n).plan(&grid(&cells)).tiles.len() as u32, 1 + 3 * depth);
        cells[0].levels = [12 + depth as u8, 6];
        assert_eq!(map(n).plan(&grid(&cells)).tiles.len() as u32, 1 + depth);
        // Without neighbours only the cell itself is drawn.
        cells.iter_mut().skip(1).for_each(|cell| *cell = NeedCell::EMPTY);
        assert_eq!(map(n).plan(&grid(&cells)).tiles.len(), 1);
    }
}

/// Oracle 22: enough ξ gives one tile over the whole map; one less does not.
#[test]
fn quality_drop_ends_at_one_map() {
    let mut numbers = Numbers(22);
    for _ in 0..200 {
        let cells = random_cells(16, 1.0, &mut numbers);
        let root = *grid(&cells).root();
        let largest = i32::from(root.levels[0].max(root.levels[1]).min(16));
        let drop = (largest - 12).max(0);
        let plan = |quality_drop| {
            FittedMap {
                quality_drop,
                ..map(16)
            }
            .plan(&grid(&cells))
        };
        assert_eq!(plan(drop).tiles.len(), 1);
        assert_eq!(plan(drop).tiles[0].tile, Tile::WHOLE);
        if drop > 0 {
            assert!(plan(drop - 1).tiles.len() > 1);
        }
    }
    // n = 32, s_max = 4096: ξ = 5 is one map of 4096² where some pixel needs the cap or more, on both axes.
    let hot = NeedCell {
        levels: [25, 31],
        pixels: 1,
        rect: PixelRect::whole(UVec2::ONE),
    };
    let plan = FittedMap {
        quality_drop: 5,
        ..FittedMap::default()
    }
    .plan(&grid(&[hot; 1024]));
    assert_eq!(
        (plan.tiles.len(), plan.tiles[0].window.size, plan.cap),
        (1, UVec2::splat(4096), 17)
    );
    assert_eq!(plan.effective_resolution(), 4096);
}

/// As the thesis splits, tiles and texels fall with ξ but for cases of one-axis splits (tiles: 1 in 21 000 of the
/// specification); the cheapest plan's cost never rises.
#[test]
fn cost_falls_with_quality_drop() {
    let mut numbers = Numbers(7);
    let (mut more_tiles, mut more_texels, mut steps) = (0, 0, 0);
    for run in 0..300 {
        let n = [4, 8, 16][run % 3];
        let occupied = numbers.unit();
        let cells = grid(&random_cells(n, occupied, &mut numbers));
        for tile_cost in [None, Some(0), Some(10_000)] {
            let settings = FittedMap {
                tile_size_max: 1024,
                tile_cost,
                ..map(n)
            };
            let plans: Vec<FittedPlan> = (0..8)
                .map(|quality_drop| {
                    FittedMap {
                        quality_drop,
                        ..settings
                    }
                    .plan(&cells)
                })
                .collect();
            for pair in plans.windows(2) {
                match tile_cost {
                    None => {
                        more_tiles += u32::from(pair[1].tiles.len() > pair[0].tiles.len());
                        more_texels += u32::from(pair[1].texels() > pair[0].texels());
                        steps += 1;
                    }
                    Some(price) => assert!(cost(&pair[1], price) <= cost(&pair[0], price)),
                }
            }
        }
    }
    assert!(
        more_tiles <= 3 && (1..100).contains(&more_texels) && steps == 2100,
        "{more_tiles} {more_texels}"
    );
}

fn cost(plan: &FittedPlan, tile_cost: u32) -> u64 {
    plan.texels() + plan.tiles.len() as u64 * u64::from(tile_cost)
}

/// The least cost of a node, by trying everything, from the cells alone.
fn least_cost(cells: &[NeedCell], n: u32, place: UVec2, counts: UVec2, price: u32) -> u64 {
    let part = UVec2::splat(n) / counts;
    let inside = |index: &usize| UVec2::new(*index as u32 % n, *index as u32 / n) / part == place;
    let need = (0..cells.len())
        .filter(inside)
        .fold(NeedCell::EMPTY, |need, index| need.merged(cells[index]));
    if need.pixels == 0 {
        return 0;
    }
    let side = |axis: usize| (1_u64 << need.levels[axis].min(14)) / u64::from(counts[axis]);
    let is_leaf = (0..2).all(|axis| side(axis) <= 4096 || counts[axis] == n);
    let leaf = if is_leaf {
        side(0).clamp(1, 4096) * side(1).clamp(1, 4096) + u64::from(price)
    } else {
        u64::MAX
    };
    [UVec2::X, UVec2::Y].into_iter().fold(leaf, |least, step| {
        if (counts * (step + 1)).max_element() > n {
            return least;
        }
        let halves =
            [0, 1].map(|half| least_cost(cells, n, place * (step + 1) + step * half, counts * (step + 1), price));
        least.min(halves[0].saturating_add(halves[1]))
    })
}

/// The plan with a price per tile is the cheapest there is, covers all pixels, and gives every cell its need.
#[test]
fn thrifty_plans_are_the_cheapest() {
    let mut numbers = Numbers(12);
    for _ in 0..25 {
        let cells = random_cells(4, 0.6, &mut numbers);
        for price in [0, 50_000, 10_000_000] {
            let settings = FittedMap {
                tile_cost: Some(price),
                ..map(4)
            };
            let plan = settings.plan(&grid(&cells));
            assert_eq!(
                cost(&plan, price),
                least_cost(&cells, 4, UVec2::ZERO, UVec2::ONE, price)
            );
            let thesis = map(4).plan(&grid(&cells));
            assert!(cost(&plan, price) <= cost(&thesis, price));
            for (index, cell) in cells.iter().enumerate().filter(|(_, cell)| cell.pixels > 0) {
                let place = Tile {
                    place: UVec2::new(index as u32 % 4, index as u32 / 4),
                    counts: UVec2::splat(4),
                };
                let over: Vec<_> = plan.tiles.iter().filter(|leaf| leaf.tile.covers(&place)).collect();
                assert_eq!(over.len(), 1);
                for axis in 0..2 {
                    assert!(over[0].effective_resolution()[axis] >= 1 << u32::from(cell.levels[axis]).min(plan.cap));
                }
                assert_eq!(over[0].rect.union(cell.rect), over[0].rect);
            }
        }
    }
    // A grid that is too fine for the search is split as in the thesis.
    let mut cells = vec![NeedCell::EMPTY; 512 * 512];
    cells[7] = NeedCell {
        levels: [18, 9],
        pixels: 1,
        rect: PixelRect::whole(UVec2::ONE),
    };
    let fine = |tile_cost| {
        FittedMap {
            quality_drop: -4,
            tile_cost,
            ..FittedMap::default()
        }
        .plan(&grid(&cells))
    };
    assert_eq!(fine(Some(100)), fine(None));
}

/// ξ below 0: the grid grows, the same needs are capped, and each level costs four times the texels.
#[test]
fn negative_quality_drop_makes_finer_grids() {
    for (quality_drop, n) in [
        (5, 32),
        (0, 32),
        (-1, 64),
        (-3, 256),
        (-4, 512),
        (-9, 1024),
        (i32::MIN, 1024),
    ] {
        assert_eq!(
            FittedMap {
                quality_drop,
                ..FittedMap::default()
            }
            .grid_tiles_per_axis(),
            n,
            "{quality_drop}"
        );
    }
    assert_eq!(
        FittedMap {
            tiles_per_axis: 20,
            ..FittedMap::default()
        }
        .grid_tiles_per_axis(),
        16
    );
    let cell = NeedCell {
        levels: [17, 17],
        pixels: 1,
        rect: PixelRect::whole(UVec2::ONE),
    };
    let plan = |quality_drop: i32| {
        let settings = FittedMap {
            quality_drop,
            ..FittedMap::default()
        };
        let n = settings.grid_tiles_per_axis();
        let mut cells = vec![NeedCell::EMPTY; (n * n) as usize];
        cells[5] = cell;
        settings.plan(&grid(&cells))
    };
    for (quality_drop, resolution) in [(0, 131_072), (-1, 262_144), (-3, 1_048_576), (-4, 2_097_152)] {
        let plan = plan(quality_drop);
        assert_eq!((plan.cap, plan.tiles.len()), (17, 1));
        assert_eq!(plan.tiles[0].effective_resolution(), [resolution; 2]);
        assert_eq!(plan.tiles[0].window.size, UVec2::splat(4096));
    }
    // A grid that could not grow caps earlier, and says so.
    let coarse = FittedMap {
        quality_drop: -3,
        ..FittedMap::default()
    }
    .plan(&grid(&[cell; 1024]));
    assert_eq!(coarse.cap, 14);
}

#[test]
fn margins_and_limits_of_tiles() {
    let cell = NeedCell {
        levels: [9, 3],
        pixels: 1,
        rect: PixelRect::whole(UVec2::ONE),
    };
    let tile = |settings: FittedMap| settings.plan(&grid(&[cell])).tiles[0];
    let leaf = tile(FittedMap {
        margin: 3,
        ..FittedMap::default()
    });
    assert_eq!(
        leaf.window,
        TileWindow {
            size: UVec2::new(512 + 6, 64 + 6),
            margin: 3
        }
    );
    assert_eq!(
        tile(FittedMap {
            tile_size_min: 1,
            ..FittedMap::default()
        })
        .window
        .size,
        UVec2::new(512, 8)
    );
    // Sides are powers of two, at least 1, and the smallest is no larger than the largest.
    assert_eq!(
        tile(FittedMap {
            tile_size_max: 300,
            tile_size_min: 1000,
            ..FittedMap::default()
        })
        .window
        .size,
        UVec2::splat(256)
    );
    assert_eq!(
        tile(FittedMap {
            tile_size_max: 0,
            tile_size_min: 0,
            tiles_per_axis: 0,
            ..FittedMap::default()
        })
        .window
        .size,
        UVec2::ONE
    );
    assert!(FittedMap::default().plan(&grid(&[NeedCell::EMPTY; 4])).tiles.is_empty());
    // Texels land where lookups look: the middle of the tile is the middle of the texture.
    let [min, max] = leaf.tile.map_rect();
    assert_eq!(leaf.tile.texture_uv(&leaf.window, (min + max) * 0.5), DVec2::splat(0.5));
}
