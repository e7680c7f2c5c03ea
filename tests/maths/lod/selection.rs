//! Levels by distance, and crossings.

use proptest::prelude::*;
use umbrage::maths::lod::{
    crossing::{Crossing, Shown},
    selection::{LodBorders, LodEye, LodMetric, REFERENCE_HALF_VIEW, distance_of_share},
};

const HYSTERESIS: f64 = 0.05;

fn borders() -> LodBorders {
    LodBorders::new([10.0, 20.0, 40.0])
}

#[test]
fn levels_lie_between_borders() {
    let levels = [0.0, 9.9, 10.0, 19.9, 20.0, 39.9, 40.0, 1e9].map(|distance| borders().level_at(distance));
    assert_eq!(levels, [0, 0, 1, 1, 2, 2, 3, 3]);
    assert_eq!(borders().range(1), 10.0..20.0);
    assert_eq!(borders().range(3), 40.0..f64::INFINITY);
    assert_eq!(borders().level_count(), 4);
}

#[test]
fn wrong_borders_are_raised() {
    let borders = LodBorders::new([5.0, 3.0, f64::NAN, 8.0, -1.0]);
    assert_eq!(borders.as_slice(), [5.0, 5.0, 5.0, 8.0, 8.0]);
    assert_eq!(borders.level_at(6.0), 3, "empty levels are skipped");
}

/// 11.547 m at 10 m fill a picture of 60 degrees, and a picture of half the tangent at 20 m.
#[test]
fn projected_sizes_are_distances() {
    assert!((distance_of_share(11.547_005, 1.0) - 10.0).abs() < 1e-5);
    assert_eq!(distance_of_share(3.0, 0.0), f64::INFINITY);
    let zoomed = LodEye {
        half_view: REFERENCE_HALF_VIEW / 2.0,
        bias: 1.0,
    };
    assert_eq!(zoomed.factor(LodMetric::ProjectedSize), 0.5);
    assert_eq!(zoomed.factor(LodMetric::Distance), 1.0);
    let broken = LodEye {
        half_view: f64::NAN,
        bias: -1.0,
    };
    assert_eq!(broken.factor(LodMetric::ProjectedSize), 1.0);
}

/// An eye that sways by less than the hysteresis around a border changes the level once.
#[test]
fn swaying_at_a_border_switches_once() {
    let borders = borders();
    let mut level = 0;
    let mut changes = 0;
    for step in 0..1000 {
        let distance = 20.0 + 0.4 * if step % 2 == 0 { 1.0 } else { -1.0 };
        let next = borders.held_level(level, distance, HYSTERESIS);
        changes += usize::from(next != level);
        level = next;
    }
    assert_eq!((level, changes), (2, 1));
    let without = |distance| borders.held_level(2, distance, 0.0);
    assert_eq!(
        (without(20.4), without(19.6)),
        (2, 1),
        "without hysteresis it would switch"
    );
}

/// Giegl, oracle O33: twice the distance, four times as many objects in the finest level.
#[test]
fn late_switching_costs_the_square_of_the_distance() {
    let count = |factor: f64| {
        let borders = LodBorders::new([30.0 * factor]);
        let near = (0..600 * 600).filter(|i| {
            let (x, z) = (f64::from(i % 600) - 299.5, f64::from(i / 600) - 299.5);
            borders.level_at(x.hypot(z)) == 0
        });
        near.count() as f64
    };
    let (early, late) = (count(2.0), count(4.0));
    assert!(
        early > 1e4 && (late / early - 4.0).abs() < 0.05 * 4.0,
        "{early} and {late}"
    );
}

#[test]
fn crossings_in_time_turn_back_where_they_are() {
    let third = Shown::Level(0).advanced(1, 0.3);
    assert_eq!(third, Shown::Crossing(Crossing { from: 0, to: 1, t: 0.3 }));
    let Shown::Crossing(back) = third.advanced(0, 0.1) else {
        panic!("a crossing turns back gradually");
    };
    assert_eq!((back.from, back.to), (1, 0));
    assert!(
        (back.t - 0.8).abs() < 1e-12,
        "0.7 is left to undo, 0.1 of it done: {back:?}"
    );
    assert_eq!(third.advanced(0, 0.3), Shown::Level(0));
    // A third level waits until the crossing has ended.
    let on = third.advanced(2, 0.3);
    assert_eq!(on.goal(), 1);
    let ended = on.advanced(2, 0.5);
    assert_eq!(ended, Shown::Level(1));
    assert_eq!(ended.advanced(2, 0.1).goal(), 2);
    assert_eq!(
        Shown::Level(3).advanced(0, 1.0),
        Shown::Level(0),
        "a whole step is a hard switch"
    );
    assert_eq!(Shown::Level(3).advanced(3, 0.1), Shown::Level(3));
}

#[test]
fn crossings_over_distance_follow_the_eye() {
    let borders = borders();
    assert_eq!(borders.blend_at(8.0, 2.0), (0, None));
    assert_eq!(borders.blend_at(9.0, 2.0), (0, Some(0.5)));
    assert_eq!(borders.blend_at(10.0, 2.0), (1, None));
    // A band as wide as a level begins at its near border.
    assert_eq!(borders.blend_at(15.0, 100.0), (1, Some(0.5)));
    assert_eq!(borders.blend_at(50.0, 2.0), (3, None));
    assert_eq!(borders.blend_at(9.99, 0.0), (0, None));
}

proptest! {
    #[test]
    fn held_levels_are_levels_near_by(
        mut raw in proptest::collection::vec(1.0..100.0_f64, 0..5),
        distances in proptest::collection::vec(0.0..120.0_f64, 1..40),
    ) {
        raw.sort_by(f64::total_cmp);
        let borders = LodBorders::new(raw);
        let mut level = borders.level_at(distances[0]);
        for distance in distances {
            level = borders.held_level(level, distance, HYSTERESIS);
            let finest = borders.level_at(distance);
            let coarsest = borders.level_at(distance / (1.0 - HYSTERESIS) * (1.0 + 1e-12));
            prop_assert!((finest..=coarsest).contains(&level), "{level} not in {finest}..={coarsest}");
        }
    }

    #[test]
    fn within_the_slack_nothing_changes(distance in 0.0..60.0_f64, before in 0_usize..4, share in -0.999..0.999_f64) {
        let borders = borders();
        let level = borders.held_level(before, distance, HYSTERESIS);
        let slack = borders.slack(level, distance, HYSTERESIS).min(1e6);
        let moved = (distance + share * slack).max(0.0);
        prop_assert_eq!(borders.held_level(level, moved, HYSTERESIS), level);
        // Just beyond it something does.
        if slack < 1e6 {
            let beyond = [1.0, -1.0].map(|side| distance + side * (slack + 1e-9));
            prop_assert!(beyond.iter().any(|d| borders.held_level(level, *d, HYSTERESIS) != level));
        }
    }

    #[test]
    fn distance_driven_crossings_are_continuous(distance in 0.0..60.0_f64, band in 0.1..30.0_f64) {
        // The coarser level's share, in levels: no step of a millimetre changes it by more than its slope.
        let place = |distance: f64| {
            let (level, t) = borders().blend_at(distance, band);
            level as f64 + t.unwrap_or(0.0)
        };
        let step = 1e-3;
        let narrowest = band.min(10.0);
        prop_assert!((place(distance + step) - place(distance)).abs() <= step / narrowest + 1e-9);
    }
}
