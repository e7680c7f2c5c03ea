//! Grids of needs and their pyramid: oracle 19 of Giegl, outliers, holes.

use bevy_math::{UVec2, Vec2};
use umbrage::maths::virtual_map::{
    grid::{GridOptions, NeedCell, NeedGrid},
    mapping::{MappingTexel, TileMappingMap},
    picture::PixelRect,
};

use super::scene::Numbers;

fn random_map(size: u32, seed: u64) -> TileMappingMap {
    let mut numbers = Numbers(seed);
    let texels = (0..size * size).map(|_| {
        let is_sky = numbers.unit() < 0.3;
        let texel = MappingTexel {
            uv: Vec2::new(numbers.unit() as f32, numbers.unit() as f32),
            levels: [numbers.whole(3, 17) as u8, numbers.whole(3, 17) as u8],
            reach: Vec2::ZERO,
        };
        (!is_sky).then_some(texel)
    });
    TileMappingMap {
        size: UVec2::splat(size),
        picture: UVec2::splat(size * 4),
        texels: texels.collect(),
        outside: 0,
    }
}

fn of(n: u32) -> GridOptions {
    GridOptions {
        tiles_per_axis: n,
        ..GridOptions::default()
    }
}

/// Oracle 19.
#[test]
fn parents_are_the_maximum_of_their_children() {
    let map = random_map(40, 19);
    let grid = NeedGrid::new(&map, &of(16));
    assert_eq!((grid.tiles_per_axis(), grid.depth(), grid.levels.len()), (16, 4, 5));
    for level in 1..5_u32 {
        let side = 1 << level;
        for y in 0..side / 2 {
            for x in 0..side / 2 {
                let parent = grid.levels[level as usize - 1][(y * side / 2 + x) as usize];
                let first = 2 * UVec2::new(x, y);
                assert_eq!(parent, grid.region(level, first, first + 2));
            }
        }
    }
    let valid = || map.texels.iter().flatten();
    let largest = |axis| valid().map(|texel| texel.levels[axis]).max().unwrap_or(0);
    let root = grid.root();
    assert_eq!(root.levels, [largest(0), largest(1)]);
    assert_eq!(root.pixels as usize, valid().count());
    let with_geometry = (0..1600_u32).filter(|index| map.texels[*index as usize].is_some());
    let rect = with_geometry.fold(PixelRect::EMPTY, |rect, index| {
        let min = UVec2::new(index % 40, index / 40) * 4;
        rect.union(PixelRect { min, max: min + 4 })
    });
    assert_eq!(root.rect, rect);
    assert_eq!(grid.histogram.map(|bins| bins.iter().sum::<u32>()), [root.pixels; 2]);
    assert_eq!(
        grid.histogram[0][17] as usize,
        valid().filter(|texel| texel.levels[0] == 17).count()
    );
    // 1365 cells for n = 32.
    let cells: usize = NeedGrid::new(&map, &of(32)).levels.iter().map(Vec::len).sum();
    assert_eq!(cells, 1365);
}

/// Each cell, against all texels one by one.
#[test]
fn cells_collect_their_pixels() {
    let map = random_map(32, 3);
    let grid = NeedGrid::new(&map, &of(8));
    for (index, cell) in grid.levels[3].iter().enumerate() {
        let own = |texel: &&MappingTexel| (texel.uv * 8.0).as_uvec2() == UVec2::new(index as u32 % 8, index as u32 / 8);
        let texels: Vec<&MappingTexel> = map.texels.iter().flatten().filter(own).collect();
        assert_eq!(cell.pixels as usize, texels.len());
        for axis in 0..2 {
            assert_eq!(
                cell.levels[axis],
                texels.iter().map(|texel| texel.levels[axis]).max().unwrap_or(0)
            );
        }
    }
}

/// Reconstruction 14: rectangles hold the whole of the pixels that a texel stands for, at ratios that are no whole
/// numbers too; the guard is on top, and ends at the picture.
#[test]
fn rectangles_hold_whole_footprints() {
    let mut map = random_map(3, 1);
    map.picture = UVec2::new(10, 7);
    map.texels = vec![None; 9];
    map.texels[4] = Some(MappingTexel {
        uv: Vec2::splat(0.1),
        levels: [5, 6],
        reach: Vec2::ZERO,
    });
    let rect = |guard| {
        NeedGrid::new(
            &map,
            &GridOptions {
                rect_guard: guard,
                ..of(4)
            },
        )
        .root()
        .rect
    };
    // 10 ÷ 3 to 20 ÷ 3, 7 ÷ 3 to 14 ÷ 3.
    assert_eq!(
        rect(0),
        PixelRect {
            min: UVec2::new(3, 2),
            max: UVec2::new(7, 5)
        }
    );
    assert_eq!(
        rect(1),
        PixelRect {
            min: UVec2::new(2, 1),
            max: UVec2::new(8, 6)
        }
    );
    assert_eq!(rect(5), PixelRect::whole(map.picture));
}

/// Row F10: a hundred pixels of one cell, of which few are extreme.
#[test]
fn outliers_are_discarded_by_share() {
    let mut map = random_map(10, 1);
    map.texels = (0..100)
        .map(|index| {
            let level = match index {
                0 => 20,
                1 | 2 => 15,
                _ => 10,
            };
            Some(MappingTexel {
                uv: Vec2::splat(0.3),
                levels: [level, 9],
                reach: Vec2::ZERO,
            })
        })
        .collect();
    for (fraction, level, discarded) in [
        (0.0, 20, 0),
        (0.005, 20, 0),
        (0.01, 15, 1),
        (0.029, 15, 1),
        (0.03, 10, 3),
        (1.0, 0, 100),
        (f64::NAN, 20, 0),
        (-1.0, 20, 0),
    ] {
        let grid = NeedGrid::new(
            &map,
            &GridOptions {
                discard_fraction: fraction,
                ..of(4)
            },
        );
        let expected = if fraction == 1.0 { [0, 0] } else { [level, 9] };
        assert_eq!(
            (grid.root().levels, grid.discarded),
            (expected, discarded),
            "{fraction}"
        );
        assert_eq!(grid.root().pixels, 100, "discarded pixels still look into the map");
    }
}

/// Cells that only pixels between two texels see get the texel's need, as far as the texel reaches.
#[test]
fn smaller_maps_spread() {
    let mut map = random_map(1, 1);
    map.texels = vec![Some(MappingTexel {
        uv: Vec2::splat(0.5 + 0.01),
        levels: [7, 8],
        reach: Vec2::new(0.3, 0.04),
    })];
    let occupied = |spread| {
        let grid = NeedGrid::new(&map, &GridOptions { spread, ..of(16) });
        grid.levels[4]
            .iter()
            .filter(|cell| cell.pixels > 0 && cell.levels == [7, 8])
            .count()
    };
    // Columns 3 to 12 and rows 7 and 8 are in reach.
    assert_eq!(
        (occupied(0), occupied(1), occupied(2), occupied(99)),
        (1, 3 * 2, 5 * 2, 10 * 2)
    );
}

#[test]
fn a_floor_fills_empty_cells() {
    let map = random_map(4, 5);
    let bare = NeedGrid::new(&map, &of(8));
    let floored = NeedGrid::new(
        &map,
        &GridOptions {
            floor_level: Some(11),
            ..of(8)
        },
    );
    let mut filled = 0;
    for (bare, floored) in bare.levels[3].iter().zip(&floored.levels[3]) {
        if bare.pixels == 0 {
            assert_eq!(
                (floored.levels, floored.rect),
                ([11, 11], PixelRect::whole(map.picture))
            );
            filled += 1;
        } else {
            assert_eq!(bare, floored);
        }
    }
    assert!(filled > 40, "{filled}");
}

#[test]
fn grids_of_nothing() {
    let mut map = random_map(4, 5);
    map.texels = vec![None; 16];
    let grid = NeedGrid::new(&map, &of(5));
    assert_eq!(grid.tiles_per_axis(), 8, "rounded up");
    assert_eq!(*grid.root(), NeedCell::EMPTY);
    assert_eq!(NeedGrid::new(&map, &of(0)).tiles_per_axis(), 1);
    assert_eq!(NeedGrid::from_cells(vec![NeedCell::EMPTY; 3]), None);
    assert_eq!(NeedGrid::from_cells(vec![NeedCell::EMPTY; 9]), None);
    assert_eq!(NeedGrid::from_cells(Vec::new()), None);
    // Texels that were made elsewhere: levels beyond all bounds, and places that are none.
    let texel = |uv| {
        Some(MappingTexel {
            uv,
            levels: [200, 3],
            reach: Vec2::ZERO,
        })
    };
    map.texels[0] = texel(Vec2::new(7.0, 0.2));
    map.texels[1] = texel(Vec2::NAN);
    assert_eq!(NeedGrid::new(&map, &of(4)).levels[2][3].pixels, 1);
}

/// What the GPU collects, cells and their histograms, gives the grid of the mapping map itself.
#[test]
fn collected_cells_are_those_of_the_map() {
    let map = random_map(48, 77);
    let options = GridOptions {
        discard_fraction: 0.2,
        rect_guard: 3,
        floor_level: Some(4),
        ..of(16)
    };
    let whole = NeedGrid::new(&map, &of(16));
    let mut histograms = vec![[[0; 32]; 2]; 256];
    for texel in map.texels.iter().flatten() {
        let cell = (texel.uv * 16.0).as_uvec2().min(UVec2::splat(15));
        for axis in 0..2 {
            histograms[(cell.y * 16 + cell.x) as usize][axis][usize::from(texel.levels[axis])] += 1;
        }
    }
    let cells = whole.levels[4].clone();
    let collected = NeedGrid::collected(cells.clone(), &histograms, map.picture, &options).expect("a square grid");
    let expected = NeedGrid::new(&map, &options);
    assert_eq!(collected.levels, expected.levels);
    assert!(
        collected.levels != whole.levels && expected.discarded > 0,
        "something was discarded"
    );
    // Pixels that are extreme on both axes count twice.
    assert!((expected.discarded..=2 * expected.discarded).contains(&collected.discarded));
    assert_eq!(
        NeedGrid::collected(cells[1..].to_vec(), &[], map.picture, &options),
        None
    );
}
