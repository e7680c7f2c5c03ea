//! Queried maps: oracles 7 to 13 of Giegl, on a shadow that a formula knows.

use bevy_math::{DVec2, UVec2};
use proptest::prelude::*;
use umbrage::maths::virtual_map::{
    picture::PixelRect,
    queried::{
        ChangeThreshold, Decision, JumpExponent, OpportunityJump, QueriedMap, QueriedTile, Refinement, Splitting,
        TileReport, changed_result,
    },
    tile::Tile,
};

pub(super) const PICTURE: UVec2 = UVec2::splat(96);

/// Where a pixel of a ground plane seen in perspective looks into the map; `None` is sky.
fn map_place(pixel: UVec2) -> Option<DVec2> {
    let uv = (pixel.as_dvec2() + 0.5) / PICTURE.as_dvec2();
    let distance = 0.06 / (uv.y - 0.3);
    (uv.y > 0.3 && distance < 1.0).then(|| DVec2::new(0.5 + (uv.x - 0.5) * distance, 1.0 - distance))
}

/// The shadow of discs and a thin fence.
fn is_lit(uv: DVec2) -> bool {
    let discs = [
        (0.5, 0.9, 0.02),
        (0.55, 0.6, 0.1),
        (0.2, 0.3, 0.07),
        (0.47, 0.96, 0.001),
    ];
    let is_in_disc = discs
        .iter()
        .any(|(x, y, radius)| uv.distance(DVec2::new(*x, *y)) < *radius);
    let is_in_fence = (uv.x * 150.0).fract() < 0.1 && (0.7..0.72).contains(&uv.y);
    !is_in_disc && !is_in_fence
}

/// What a tile's map says about a place: the shadow at the centre of the texel.
fn looked_up(tile: &Tile, size: u32, uv: DVec2) -> f32 {
    let texels = tile.counts.as_dvec2() * f64::from(size);
    f32::from(u8::from(is_lit(((uv * texels).floor() + 0.5) / texels)))
}

/// The shadow result and the step `apply`.
struct Result(Vec<f32>);

impl Result {
    fn lit() -> Self {
        Self(vec![1.0; (PICTURE.x * PICTURE.y) as usize])
    }

    fn apply(&mut self, draw: &QueriedTile) -> TileReport {
        let mut report = TileReport::EMPTY;
        for y in draw.rect.min.y..draw.rect.max.y {
            for x in draw.rect.min.x..draw.rect.max.x {
                let pixel = UVec2::new(x, y);
                let Some(uv) = map_place(pixel).filter(|uv| draw.tile.contains(*uv)) else {
                    continue;
                };
                let result = &mut self.0[(y * PICTURE.x + x) as usize];
                let change = changed_result(*result, looked_up(&draw.tile, draw.size, uv), 0.0);
                report.count(pixel, change.is_some());
                *result = change.unwrap_or(*result);
            }
        }
        report
    }
}

pub(super) fn small() -> QueriedMap {
    QueriedMap {
        threshold: ChangeThreshold::Pixels(0.0),
        tile_size: 16,
        tile_size_max: 32,
        maximum_jump: false,
        opportunity_jump: None,
        ..QueriedMap::default()
    }
}

/// A threshold in pixels of the test's picture.
fn pixels(count: f64) -> ChangeThreshold {
    ChangeThreshold::Pixels(count * 1024.0 * 1024.0 / f64::from(PICTURE.x * PICTURE.y))
}

fn refined(map: &QueriedMap) -> (Refinement, Result) {
    let mut result = Result::lit();
    let refinement = map.refine(PixelRect::whole(PICTURE), |draw| result.apply(draw));
    (refinement, result)
}

pub(super) fn report(changed: u32) -> TileReport {
    TileReport {
        changed,
        inside: 1 << 20,
        rect: PixelRect::whole(UVec2::splat(1024)),
    }
}

pub(super) fn square(n: u32) -> Tile {
    Tile {
        place: UVec2::ZERO,
        counts: UVec2::splat(n),
    }
}

pub(super) const MEGAPIXEL: u64 = 1 << 20;

/// Oracle 7: 1 + 4 k tiles and the jumps, no tile beyond the limit, whatever is switched on.
#[test]
fn tile_counts() {
    for maximum_jump in [false, true] {
        for threshold in [0.0, 3.0, 40.0] {
            for decay in [None, Some(0.5), Some(0.25)] {
                let map = QueriedMap {
                    threshold: pixels(threshold),
                    maximum_jump,
                    opportunity_jump: decay.map(|decay| OpportunityJump {
                        decay,
                        exponent: JumpExponent::Ratio,
                    }),
                    ..small()
                };
                let (refinement, _) = refined(&map);
                assert_eq!(refinement.tiles.len(), 1 + 4 * refinement.splits + refinement.jumps);
                assert!(refinement.tiles.len() <= 1365);
                assert!(refinement.tiles.iter().all(|tile| tile.tile.counts.max_element() <= 32));
                let jumped = refinement.tiles.iter().filter(|tile| tile.decision.is_none());
                assert_eq!(jumped.clone().count(), refinement.jumps);
                assert!(jumped.clone().all(|tile| tile.size == 32));
                assert_eq!(
                    maximum_jump || (decay.is_some() && threshold > 0.0),
                    refinement.jumps > 0
                );
            }
        }
    }
    assert_eq!((0..6).map(|level| 4_u32.pow(level)).sum::<u32>(), 1365);
    // Every tile refines: the bound is met, level by level.
    let all = small().refine(PixelRect::whole(PICTURE), |_| report(1));
    assert_eq!((all.tiles.len(), all.splits), (1365, 341));
    assert!(all.tiles.is_sorted_by_key(|tile| tile.tile.counts.x));
}

/// Oracle 8: without jumps a larger threshold draws a subset of the tiles.
#[test]
fn larger_thresholds_draw_fewer_tiles() {
    let tiles = |threshold| {
        let (refinement, _) = refined(&QueriedMap {
            threshold: pixels(threshold),
            ..small()
        });
        refinement.tiles.iter().map(|tile| tile.tile).collect::<Vec<_>>()
    };
    let mut finer = tiles(0.0);
    for threshold in [1.0, 4.0, 10.0, 30.0, 100.0, 4000.0] {
        let coarser = tiles(threshold);
        assert!(coarser.iter().all(|tile| finer.contains(tile)), "{threshold}");
        assert!(coarser.len() < finer.len(), "{threshold}: {} tiles", coarser.len());
        finer = coarser;
    }
    assert_eq!(finer.len(), 1);
}

/// Oracle 9: what is counted for a tile is what differs between the results before and after it, and does not depend on
/// the threshold.
#[test]
fn counts_are_differences() {
    let mut all = Vec::new();
    for threshold in [0.0, 10.0] {
        let mut result = Result::lit();
        let (map, mut mismatches) = (
            QueriedMap {
                threshold: pixels(threshold),
                ..small()
            },
            0,
        );
        let refinement = map.refine(PixelRect::whole(PICTURE), |draw| {
            let before = result.0.clone();
            let report = result.apply(draw);
            let differing = before.iter().zip(&result.0).filter(|(a, b)| a != b).count();
            mismatches += u32::from(differing != report.changed as usize);
            report
        });
        assert_eq!(mismatches, 0);
        all.push(refinement.tiles);
    }
    for tile in &all[1] {
        let same = all[0].iter().find(|other| other.tile == tile.tile).unwrap();
        assert_eq!(same.report, tile.report);
    }
    // The first tile is compared with light everywhere: it counts the shadowed pixels.
    let whole = (0..PICTURE.y).flat_map(|y| (0..PICTURE.x).map(move |x| UVec2::new(x, y)));
    let dark = whole
        .filter_map(map_place)
        .filter(|uv| looked_up(&Tile::WHOLE, 16, *uv) == 0.0);
    assert_eq!(all[0][0].report.changed as usize, dark.count());
}

/// Oracle 10: threshold 0 against the tiled map of the same limit: pixels differ only where a tile ended early because
/// it had changed nothing.
#[test]
fn threshold_zero_is_the_tiled_map_where_tiles_did_not_end() {
    let (refinement, result) = refined(&small());
    let ended: Vec<&QueriedTile> = (refinement.tiles.iter())
        .filter(|tile| tile.report.changed == 0 && tile.tile.counts.x < 32)
        .collect();
    let (mut differing, mut compared) = (0, 0);
    for y in 0..PICTURE.y {
        for x in 0..PICTURE.x {
            let Some(uv) = map_place(UVec2::new(x, y)) else {
                continue;
            };
            let tiled = looked_up(&Tile::at(UVec2::splat(32), uv).unwrap(), 16, uv);
            let is_ended = ended.iter().any(|tile| tile.tile.contains(uv));
            let is_same = tiled == result.0[(y * PICTURE.x + x) as usize];
            assert!(is_same || is_ended, "{x} {y}");
            differing += u32::from(!is_same);
            compared += u32::from(!is_ended);
        }
    }
    // The thin fence is what early ends miss: equal to the eye, not to the bit.
    assert!(differing > 0 && compared > 500, "{differing} {compared}");
}

/// Rectangles of the parents leave out no pixel: applying to the whole picture gives the same.
#[test]
fn screen_rectangles_change_nothing() {
    let (with, result) = refined(&QueriedMap {
        maximum_jump: true,
        ..small()
    });
    let mut whole = Result::lit();
    let without = QueriedMap {
        maximum_jump: true,
        ..small()
    }
    .refine(PixelRect::whole(PICTURE), |draw| {
        whole.apply(&QueriedTile {
            rect: PixelRect::whole(PICTURE),
            ..*draw
        })
    });
    assert_eq!(with, without);
    assert_eq!(result.0, whole.0);
    let pixels: u64 = with.tiles.iter().map(|tile| tile.rect.pixels()).sum();
    assert!(
        pixels * 4 < with.tiles.len() as u64 * u64::from(PICTURE.x * PICTURE.y),
        "{pixels}"
    );
}

/// Oracle 11.
#[test]
fn the_maximum_jump_fires_at_half_the_limit() {
    let map = QueriedMap {
        tile_size: 2048,
        tile_size_max: 4096,
        opportunity_jump: None,
        ..QueriedMap::default()
    };
    for (n, expected) in [
        (1, Decision::Split),
        (8, Decision::Split),
        (16, Decision::MaximumJump),
        (32, Decision::Final),
    ] {
        assert_eq!(map.decide(&square(n), &report(5000), MEGAPIXEL), expected, "{n}");
    }
    let same = QueriedMap { tile_size: 4096, ..map };
    for n in [1, 2, 4, 8, 16] {
        assert_eq!(
            same.decide(&square(n), &report(5000), MEGAPIXEL),
            Decision::Split,
            "{n}"
        );
    }
    assert_eq!(same.decide(&square(32), &report(5000), MEGAPIXEL), Decision::Final);
    // The default's textures are four times as large: two levels earlier.
    let four = QueriedMap { tile_size: 1024, ..map };
    assert_eq!(four.decide(&square(4), &report(5000), MEGAPIXEL), Decision::Split);
    assert_eq!(four.decide(&square(8), &report(5000), MEGAPIXEL), Decision::MaximumJump);
}

/// Oracle 12 and the table of both readings.
#[test]
fn the_opportunity_jump() {
    let map = |decay, ratio: u32, exponent| QueriedMap {
        threshold: ChangeThreshold::Pixels(2500.0),
        tile_size: 1024,
        tile_size_max: 1024 * ratio,
        maximum_jump: false,
        opportunity_jump: Some(OpportunityJump { decay, exponent }),
        ..QueriedMap::default()
    };
    use JumpExponent::{Measured, Ratio, Steps};
    for (decay, ratio, exponent, most) in [
        (0.5, 2, Ratio, 10_000),
        (0.5, 2, Steps, 5_000),
        (0.25, 2, Ratio, 40_000),
        (0.25, 2, Steps, 10_000),
        (0.125, 2, Ratio, 160_000),
        (0.125, 2, Steps, 20_000),
        (0.25, 4, Ratio, 640_000),
        (0.25, 4, Steps, 40_000),
        (0.25, 2, Measured, 40_000),
        (0.25, 4, Measured, 40_000),
    ] {
        let decide = |changed| map(decay, ratio, exponent).decide(&square(2), &report(changed), MEGAPIXEL);
        assert_eq!(decide(most), Decision::OpportunityJump, "{decay} {ratio} {exponent:?}");
        assert_eq!(decide(most + 1), Decision::Split, "{decay} {ratio} {exponent:?}");
        assert_eq!(decide(2500), Decision::Final, "strictly more than the threshold");
        assert_eq!(decide(2501), Decision::OpportunityJump);
    }
    let never = QueriedMap {
        threshold: ChangeThreshold::Pixels(0.0),
        ..map(0.125, 2, Ratio)
    };
    for changed in [1, 100, 1_000_000] {
        assert_eq!(never.decide(&square(2), &report(changed), MEGAPIXEL), Decision::Split);
    }
    // Textures that are no larger are no opportunity.
    assert_eq!(
        map(0.25, 1, Ratio).decide(&square(2), &report(3000), MEGAPIXEL),
        Decision::Split
    );
}

/// Oracle 13: what frames cost, and what the other ways to split cost.
#[test]
fn costs() {
    // Four splits and two jumps in s = 2048, s_max = 4096: the forest of the thesis.
    let map = QueriedMap {
        threshold: ChangeThreshold::Pixels(2500.0),
        tile_size: 2048,
        tile_size_max: 4096,
        ..QueriedMap::default()
    };
    let refinement = map.refine(PixelRect::whole(UVec2::splat(1024)), |draw| {
        let is_corner = draw.tile.place == UVec2::ZERO;
        let is_beside = draw.tile.place == UVec2::X && draw.tile.counts.x == 16;
        report(if is_corner {
            1_000_000
        } else if is_beside {
            3000
        } else {
            0
        })
    });
    assert_eq!(
        (refinement.tiles.len(), refinement.splits, refinement.jumps),
        (19, 4, 2)
    );
    assert_eq!(refinement.texels(), 104_857_600);
    assert_eq!(4_294_967_296.0 / 104_857_600.0, 40.96);
    assert_eq!(refinement.texels(), 25 * 2048 * 2048);

    let tiles = |splitting, levels: u32, is_chain: bool| {
        let side = if splitting == Splitting::Grid3 { 3 } else { 2_u32 };
        let map = QueriedMap {
            splitting,
            max_tiles_per_axis: side.pow(levels),
            ..small()
        };
        let refinement = map.refine(PixelRect::whole(PICTURE), |draw| {
            report(u32::from(!is_chain || draw.tile.place == UVec2::ZERO))
        });
        refinement.tiles.len()
    };
    assert_eq!(tiles(Splitting::Binary, 1, false) - 1, 6, "instead of 4");
    assert_eq!(
        (tiles(Splitting::Grid3, 2, true), tiles(Splitting::Quad, 2, true)),
        (19, 9)
    );
}

proptest! {
    /// Finer tiles never come before coarser ones over the same place, jumps last; the same reports give the same
    /// tiles.
    #[test]
    fn order_is_coarse_to_fine(seed in any::<u32>(), limit in 1_usize..40, jump in any::<bool>()) {
        let map = QueriedMap { max_tiles_per_level: limit * 4, maximum_jump: jump, ..small() };
        let apply = |draw: &QueriedTile| {
            let hash = (draw.tile.place.x * 7919 + draw.tile.place.y * 104_729 + draw.tile.counts.x).wrapping_mul(seed | 1);
            report(hash >> 31)
        };
        let refinement = map.refine(PixelRect::whole(PICTURE), apply);
        prop_assert_eq!(&refinement, &map.refine(PixelRect::whole(PICTURE), apply));
        for (index, tile) in refinement.tiles.iter().enumerate() {
            for later in &refinement.tiles[index + 1..] {
                let is_again = later.tile == tile.tile && later.decision.is_none();
                prop_assert!(!later.tile.covers(&tile.tile) || is_again);
            }
        }
    }
}
