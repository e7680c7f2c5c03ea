//! Queried maps: other ways to split and to count, full levels.

use bevy_math::UVec2;
use umbrage::maths::virtual_map::{
    picture::PixelRect,
    queried::{ChangeThreshold, Decision, QueriedMap, Splitting, TileReport, changed_result},
};

use super::queried::{MEGAPIXEL, PICTURE, report, small, square};

#[test]
fn binary_splits_alternate() {
    let map = QueriedMap {
        splitting: Splitting::Binary,
        max_tiles_per_axis: 4,
        ..small()
    };
    let refinement = map.refine(PixelRect::whole(PICTURE), |_| report(1));
    let counts: Vec<UVec2> = refinement.tiles.iter().map(|tile| tile.tile.counts).collect();
    assert_eq!(counts.len(), 1 + 2 + 4 + 8 + 16);
    assert_eq!(
        [counts[1], counts[3], counts[7], counts[15]],
        [(2, 1), (2, 2), (4, 2), (4, 4)].map(UVec2::from)
    );
    assert_eq!(
        QueriedMap {
            splitting: Splitting::Grid3,
            ..map
        }
        .parts(&square(3)),
        None,
        "9 are more than 4"
    );
}

#[test]
fn the_relative_threshold_and_the_scale_of_the_absolute() {
    let share = QueriedMap {
        threshold: ChangeThreshold::Share(0.01),
        opportunity_jump: None,
        maximum_jump: false,
        ..small()
    };
    let with = |changed, inside| TileReport {
        changed,
        inside,
        ..report(0)
    };
    assert_eq!(share.decide(&square(4), &with(2, 100), MEGAPIXEL), Decision::Split);
    assert_eq!(share.decide(&square(4), &with(1, 100), MEGAPIXEL), Decision::Final);
    assert_eq!(share.decide(&square(4), &with(0, 0), MEGAPIXEL), Decision::Final);
    let absolute = QueriedMap {
        threshold: ChangeThreshold::Pixels(300.0),
        ..share
    };
    assert_eq!(absolute.decide(&square(4), &report(301), MEGAPIXEL), Decision::Split);
    assert_eq!(
        absolute.decide(&square(4), &report(301), 2 * MEGAPIXEL),
        Decision::Final
    );
    assert_eq!(absolute.decide(&square(4), &report(76), MEGAPIXEL / 4), Decision::Split);
    let nan = QueriedMap {
        threshold: ChangeThreshold::Pixels(f64::NAN),
        ..share
    };
    assert_eq!(nan.decide(&square(4), &report(u32::MAX), MEGAPIXEL), Decision::Final);
}

#[test]
fn the_first_split_can_be_forced() {
    let map = QueriedMap {
        force_first_split: true,
        ..small()
    };
    let refinement = map.refine(PixelRect::whole(PICTURE), |_| report(0));
    assert_eq!((refinement.tiles.len(), refinement.splits), (5, 1));
    // The practical lower bound of section 4.5: 5 + 1.
    let jumping = QueriedMap {
        maximum_jump: true,
        max_tiles_per_axis: 4,
        ..map
    };
    let one = jumping.refine(PixelRect::whole(PICTURE), |draw| {
        report(u32::from(draw.tile == square(2)))
    });
    assert_eq!((one.tiles.len(), one.jumps), (6, 1));
}

#[test]
fn full_levels_keep_the_splits_that_change_most() {
    let map = QueriedMap {
        max_tiles_per_level: 8,
        ..small()
    };
    let refinement = map.refine(PixelRect::whole(PICTURE), |draw| {
        report(1 + draw.tile.place.x + 10 * draw.tile.place.y)
    });
    for n in [2, 4, 8, 16, 32] {
        assert!(refinement.tiles.iter().filter(|tile| tile.tile.counts.x == n).count() <= 8);
    }
    let split = refinement
        .tiles
        .iter()
        .filter(|tile| tile.tile.counts.x == 2 && tile.decision == Some(Decision::Split));
    assert_eq!(
        split.map(|tile| tile.tile.place).collect::<Vec<_>>(),
        [UVec2::new(0, 1), UVec2::ONE]
    );
    let dropped = refinement
        .tiles
        .iter()
        .filter(|tile| tile.decision == Some(Decision::Dropped));
    assert_eq!(dropped.count(), refinement.dropped);
    assert!(refinement.dropped >= 2);
    assert_eq!(
        QueriedMap {
            max_tiles_per_level: 0,
            ..small()
        }
        .refine(PixelRect::whole(PICTURE), |_| report(1))
        .tiles
        .len(),
        1
    );
}

#[test]
fn unchanged_results_are_not_written() {
    assert_eq!(changed_result(1.0, 0.0, 0.0), Some(0.0));
    assert_eq!(changed_result(0.0, 1.0, 0.0), Some(1.0));
    assert_eq!(changed_result(0.5, 0.5, 0.0), None);
    assert_eq!(changed_result(0.5, 0.503, 1.0 / 255.0), None);
    assert_eq!(changed_result(0.5, 0.505, 1.0 / 255.0), Some(0.505));
    assert_eq!(changed_result(0.5, f32::NAN, 0.0), None);
}
