//! Textures of tiles: oracle 24 of Giegl, waves, budgets.

use bevy_math::UVec2;
use umbrage::maths::virtual_map::{
    fitted::FittedMap,
    grid::{NeedCell, NeedGrid},
    memory::{BYTES_PER_TEXEL, DEFAULT_BUDGET, TextureMode, TileTooLarge},
    picture::PixelRect,
    queried::QueriedMap,
    tile::TileWindow,
    tiled::TiledMap,
};

use super::scene::Numbers;

const MODES: [TextureMode; 4] = [
    TextureMode::Full,
    TextureMode::Corner,
    TextureMode::SquareSeries,
    TextureMode::Exact,
];

fn random_grid(seed: u64) -> NeedGrid {
    let mut numbers = Numbers(seed);
    let cells = (0..1024).map(|_| NeedCell {
        levels: [numbers.whole(8, 15) as u8, numbers.whole(8, 15) as u8],
        pixels: numbers.whole(0, 3),
        rect: PixelRect::whole(UVec2::ONE),
    });
    NeedGrid::from_cells(cells.collect()).expect("a square")
}

fn small() -> FittedMap {
    FittedMap {
        tile_size_max: 1024,
        margin: 2,
        ..FittedMap::default()
    }
}

/// Oracle 24: what each mode keeps, in MiB and relative to the largest texture.
#[test]
fn memory_of_the_modes() {
    let mebibytes =
        |mode: TextureMode, is_near_square| mode.pool_bytes(4096, is_near_square) as f64 / f64::from(1 << 20);
    for (mode, is_near_square, expected, factor) in [
        (TextureMode::Full, true, 64.0, 1.0),
        (TextureMode::Corner, true, 64.0, 1.0),
        (TextureMode::SquareSeries, true, 85.333, 4.0 / 3.0),
        // Squares, and both orientations of 1 : 2, each half of a square: 4/3 (1 + ½ + ½).
        (TextureMode::Exact, true, 170.667, 8.0 / 3.0),
        (TextureMode::Exact, false, 256.0, 4.0),
    ] {
        let actual = mebibytes(mode, is_near_square);
        assert!((actual - expected).abs() < 0.2, "{mode:?}: {actual}");
        assert!((actual / 64.0 - factor).abs() < 0.01);
    }
}

#[test]
fn textures_hold_their_tiles() {
    let window = TileWindow::around(UVec2::new(256, 64), 2);
    let sizes = MODES.map(|mode| mode.texture_size(&window, 1028));
    assert_eq!(
        sizes,
        [
            UVec2::splat(1028),
            UVec2::splat(1028),
            UVec2::splat(260),
            UVec2::new(260, 68)
        ]
    );
    let drawn = MODES.map(|mode| mode.drawn_size(&window, 1028));
    assert_eq!(drawn, [UVec2::splat(1028), window.size, window.size, window.size]);
    let plan = small().plan(&random_grid(1));
    for tile in &plan.tiles {
        assert!(tile.window.size.max_element() <= small().largest_texture());
        for pair in MODES.windows(2) {
            let [more, less] =
                [pair[0], pair[1]].map(|mode| mode.texture_size(&tile.window, small().largest_texture()));
            assert!(
                less.cmple(more).all() && less.cmpge(tile.window.size).all(),
                "each mode is thriftier than the one before"
            );
        }
    }
}

/// Waves hold all tiles once, in order, within the budget, and none could take the next one's first tile.
#[test]
fn waves_keep_within_the_budget() {
    let plan = small().plan(&random_grid(2));
    assert!(plan.tiles.len() > 100);
    let largest = small().largest_texture();
    for mode in MODES {
        let bytes = |index: usize| {
            mode.texture_size(&plan.tiles[index].window, largest).element_product() as u64 * BYTES_PER_TEXEL
        };
        for budget in [5_u64 << 20, 16 << 20, 1 << 40] {
            let waves = plan.waves(mode, largest, budget).unwrap();
            let mut next = 0;
            for (index, wave) in waves.waves.iter().enumerate() {
                assert_eq!(wave.start, next);
                assert!(!wave.is_empty());
                next = wave.end;
                let sum: u64 = wave.clone().map(bytes).sum();
                assert!(sum <= budget && sum <= waves.peak_bytes);
                assert!(
                    index + 1 == waves.waves.len() || sum + bytes(next) > budget,
                    "a wave ends early"
                );
            }
            assert_eq!(next, plan.tiles.len());
            assert!(waves.peak_bytes <= budget);
        }
        let one_too_large = plan.waves(mode, largest, 1000).unwrap_err();
        assert!(matches!(one_too_large, TileTooLarge { tile: 0, bytes } if bytes > 1000));
    }
    let empty = small().plan(&NeedGrid::from_cells(vec![NeedCell::EMPTY]).unwrap());
    assert!(empty.waves(TextureMode::Exact, largest, 0).unwrap().waves.is_empty());
}

/// Less memory, smaller tiles, the same finest resolution.
#[test]
fn settings_within_a_budget() {
    let default = FittedMap::default();
    assert_eq!(
        default.within(DEFAULT_BUDGET),
        Some(default),
        "4096² of 4 bytes are 64 MiB"
    );
    let filtered = FittedMap { margin: 2, ..default };
    for (budget, size, n) in [
        (DEFAULT_BUDGET, 2048, 64),
        (17 << 20, 2048, 64),
        (16 << 20, 1024, 128),
        (1 << 20, 256, 512),
    ] {
        let within = filtered.within(budget).unwrap();
        assert_eq!((within.tile_size_max, within.tiles_per_axis), (size, n), "{budget}");
        assert!(u64::from(within.largest_texture()).pow(2) * 4 <= budget);
        assert_eq!(u64::from(size) * u64::from(n), 131_072);
    }
    assert_eq!(default.within(64 * 64 * 4).unwrap().tile_size_max, 64);
    assert_eq!(default.within(64 * 64 * 4 - 1), None);
}

/// All textures at once: quality drops by whole levels for all tiles until they fit; enough memory changes nothing.
#[test]
fn one_pass_degrades_evenly() {
    let grid = random_grid(3);
    let full = small().plan(&grid);
    let together = |budget| small().plan_together(&grid, TextureMode::Exact, budget);
    assert_eq!(together(1 << 40), Some(full.clone()));
    let mut drops = Vec::new();
    for budget in [256_u64 << 20, 64 << 20, 16 << 20, 4 << 20, 100_000] {
        let plan = together(budget).unwrap();
        assert!(plan.texels() * BYTES_PER_TEXEL <= budget);
        let finer = FittedMap {
            quality_drop: plan.quality_drop - 1,
            ..small()
        }
        .plan(&grid);
        assert!(
            plan.quality_drop == 0 || finer.texels() * BYTES_PER_TEXEL > budget,
            "no better plan fits"
        );
        drops.push(plan.quality_drop);
    }
    assert!(drops.is_sorted() && drops[0] < drops[4], "{drops:?}");
    assert_eq!(together(1000), None, "not even the smallest tile");
}

/// Tiled and queried maps keep their resolution under a smaller budget, as long as n may grow.
#[test]
fn smaller_budgets_make_more_and_smaller_tiles() {
    let map = TiledMap::new(8, 2048, 0);
    assert_eq!(map.within(16 << 20), map, "2048² fits 16 MiB exactly");
    let half = map.within((16 << 20) - 1);
    assert_eq!((half.tiles_per_axis, half.window.size), (16, UVec2::splat(1024)));
    assert_eq!(half.effective_resolution(), map.effective_resolution());
    let quarter = map.within(1 << 20);
    assert_eq!((quarter.tiles_per_axis, quarter.window.size), (32, UVec2::splat(512)));
    let fine = TiledMap::new(32, 4096, 0).within(32 << 20);
    assert_eq!((fine.tiles_per_axis, fine.window.size), (64, UVec2::splat(2048)));
    assert_eq!(fine.effective_resolution(), 131_072);
    let wide = TiledMap::new(8, 2048, 200).within(1 << 20);
    assert_eq!((wide.window.size, wide.window.margin), (UVec2::splat(512), 64));
    let least = map.within(1 << 12);
    assert_eq!(
        (least.tiles_per_axis, least.window.size),
        (256, UVec2::splat(32)),
        "n is at its limit"
    );
    assert_eq!(map.within(0).window.size, UVec2::ONE);

    let map = QueriedMap::default();
    assert_eq!(map.within(DEFAULT_BUDGET), map, "4096² is 64 MiB");
    let no_jumps = map.within(4 << 20);
    assert_eq!((no_jumps.tile_size, no_jumps.tile_size_max), (1024, 1024));
    assert_eq!(no_jumps.max_tiles_per_axis, 32);
    let small = map.within(1 << 20);
    assert_eq!(
        (small.tile_size, small.tile_size_max, small.max_tiles_per_axis),
        (512, 512, 64)
    );
}
