//! Several frusta.

use proptest::prelude::*;
use umbrage::maths::light_plane::flat::{
    Degenerate, Exposure, Light, Metric, Moments, Sample,
    allocation::weight,
    split::{Frustum, Slice, SliceExtent, exact_partition, greedy_merge, merged, slices},
    total_badness,
};

use super::{Dice, at, floor, lamp, near, pitched_camera, samples};

const BORDERS: SliceExtent = SliceExtent::Borders;

/// A slice from its samples.
fn slice(all: &[Sample], low: f64, high: f64, metric: Metric) -> Slice {
    let members = all.iter().filter(|sample| sample.place >= low && sample.place <= high);
    let rescaled: Vec<Sample> = members.map(|sample| sample.rescaled(low, high)).collect();
    Slice {
        low,
        high,
        moments: Moments::of(&rescaled, metric),
    }
}

/// The closed form of an interval's error.
fn closed_error(all: &[Sample], low: f64, high: f64) -> f64 {
    let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
        let members = all.iter().filter(|sample| sample.place >= low && sample.place <= high);
        members.map(|sample| sample.badness * of(sample.place)).sum()
    };
    let (below, above) = (
        sum(&|place| (place - low).powi(2)),
        sum(&|place| (high - place).powi(2)),
    );
    let across = sum(&|place| (place - low) * (high - place));
    2.0 / (high - low) * ((below * above).sqrt() + across)
}

/// O15.
#[test]
fn slice_errors_have_the_published_values() {
    let all = samples(&[-1.0, -0.6, -0.2, 0.2, 0.6, 1.0], &[1.0, 1.0, 8.0, 8.0, 2.0, 2.0]);
    let error = |low, high| {
        Frustum::over(&slice(&all, low, high, Metric::L1), Metric::L1)
            .unwrap()
            .error
    };
    for (low, high, expected) in [
        (-1.0, 1.0, 43.807_691_2),
        (-1.0, 0.0, 8.996_643_4),
        (0.0, 1.0, 11.653_289_6),
    ] {
        near(error(low, high), expected, 1.0e-7);
        near(closed_error(&all, low, high), expected, 1.0e-7);
    }
    let parts = slices(&all, &[-1.0, 0.0, 1.0], Metric::L1, BORDERS).unwrap();
    let split = greedy_merge(&parts, 2, 0.0, Metric::L1).unwrap();
    near(split.total_error(1.0), 41.128_262_1, 1.0e-7);
    let one = greedy_merge(&parts, 1, 0.0, Metric::L1).unwrap();
    near(one.total_error(1.0), 43.807_691_2, 1.0e-7);
    near(one.frusta[0].low, -1.0, 0.0);
}

/// O15: with real texels no split ever hurts.
#[test]
fn splits_never_hurt() {
    let mut dice = Dice(8);
    let places: Vec<f64> = (0..1000).map(|_| dice.between(-1.0, 1.0)).collect();
    let wavy = |place: f64| (2.0 * f64::from(u8::from(place > 0.3)) + 1.5 * (6.0 * place).sin()).exp();
    let badness: Vec<f64> = places.iter().map(|place| wavy(*place)).collect();
    let all = samples(&places, &badness);
    for _ in 0..1000 {
        let mut borders = [0; 3].map(|_| dice.between(-1.0, 1.0));
        borders.sort_by(f64::total_cmp);
        if borders[2] - borders[0] < 0.02 {
            continue;
        }
        for metric in [Metric::L1, Metric::L2] {
            let cost = |low, high| {
                let over = Frustum::over(&slice(&all, low, high, metric), metric);
                over.map_or(0.0, |frustum| weight(frustum.error, metric))
            };
            let (whole, split) = (
                cost(borders[0], borders[2]),
                cost(borders[0], borders[1]) + cost(borders[1], borders[2]),
            );
            assert!(split <= whole * (1.0 + 1.0e-9), "{borders:?}");
        }
    }
}

/// Errors of a split are those of its frusta's own samples with their texels.
#[test]
fn errors_of_a_split_are_badness() {
    let camera = pitched_camera();
    for light in [lamp(4.0, -3.0), Light::Directional { travel: at(-0.6, -1.0) }] {
        let exposure = Exposure::half_angle(light, &camera.see(&[floor()])).unwrap();
        for metric in [Metric::L1, Metric::L2] {
            let parts = slices(&exposure.samples, &exposure.even_borders(8), metric, BORDERS).unwrap();
            let split = greedy_merge(&parts, 3, 0.0, metric).unwrap();
            assert_eq!(split.frusta.len(), 3);
            for frustum in &split.frusta {
                let own = exposure.samples.iter().filter_map(|sample| frustum.sample(*sample));
                let own: Vec<Sample> = own.collect();
                // 2 ÷ N of a place is a texel; N = 1.
                let sum = total_badness(&own, Default::default(), metric) * 2.0_f64.powi(metric.power());
                near(frustum.error / sum, 1.0, 1.0e-9);
            }
        }
    }
}

/// Test data of the specification: 1000 pixels, a step and waves.
fn waves() -> Vec<Sample> {
    let mut dice = Dice(9);
    let mut places = vec![-1.0, 1.0];
    places.extend((0..998).map(|_| dice.between(-1.0, 1.0)));
    let badness: Vec<f64> = places
        .iter()
        .map(|place| (0.2 * dice.normal() + 2.0 * f64::from(u8::from(*place > 0.3)) + 1.5 * (6.0 * place).sin()).exp())
        .collect();
    samples(&places, &badness)
}

/// Factors over one frustum of 32 even slices, from a second implementation that recomputes every interval from its
/// samples. The specification's own (1.216, 1.216; 1.345, 1.353; 1.374, 1.381 and for L2 2.31, 2.52; 3.45, 3.57; 3.77,
/// 3.86) are of other random data: greedy is good, exact is better.
#[test]
fn exact_partitions_are_best() {
    let all = waves();
    let borders: Vec<f64> = (0..=32).map(|index| f64::from(index) / 16.0 - 1.0).collect();
    for (metric, expected) in [
        (
            Metric::L1,
            [
                (1.153_886_032, 1.195_250_184),
                (1.288_426_514, 1.297_943_992),
                (1.320_507_411, 1.322_063_985),
            ],
        ),
        (
            Metric::L2,
            [
                (2.017_854_175, 2.491_815_229),
                (3.299_990_915, 3.354_624_970),
                (3.571_905_303, 3.593_496_999),
            ],
        ),
    ] {
        let parts = slices(&all, &borders, metric, BORDERS).unwrap();
        let total = |count| {
            let (greedy, exact) = (
                greedy_merge(&parts, count, 0.0, metric).unwrap(),
                exact_partition(&parts, count, metric).unwrap(),
            );
            assert!(exact.frusta.len() <= count);
            assert_eq!(exact.frusta[0].low, -1.0);
            assert_eq!(exact.frusta.last().unwrap().high, 1.0);
            (greedy.total_error(1.0), exact.total_error(1.0))
        };
        let one = total(1);
        near(one.0 / one.1, 1.0, 1.0e-12);
        for (count, (greedy, exact)) in (2..=4).zip(expected) {
            let found = total(count);
            assert!(found.1 <= found.0 * (1.0 + 1.0e-12));
            near(one.0 / found.0, greedy, 1.0e-8);
            near(one.0 / found.1, exact, 1.0e-8);
        }
    }
}

proptest! {
    /// No choice of borders beats the exact partition.
    #[test]
    fn exact_partitions_beat_all_borders(seed in 0..1000_u64, first in 1..9_usize, second in 1..9_usize) {
        let mut dice = Dice(seed);
        let all = dice.problem();
        let borders: Vec<f64> = (0..=10).map(|index| f64::from(index) / 5.0 - 1.0).collect();
        for metric in [Metric::L1, Metric::L2] {
            let parts = slices(&all, &borders, metric, BORDERS).expect("samples");
            let count = parts.len();
            let (first, second) = (first.min(count - 2), second.min(count - 2));
            let (first, second) = (first.min(second).max(1), first.max(second) + 1);
            let cost = |range: std::ops::Range<usize>| {
                let all = merged(&parts[range]).expect("some");
                weight(Frustum::over(&all, metric).expect("badness").error, metric)
            };
            let by_hand = cost(0..first) + cost(first..second) + cost(second..count);
            let best = exact_partition(&parts, 3, metric).expect("slices");
            let sum: f64 = best.errors().iter().map(|error| weight(*error, metric)).sum();
            prop_assert!(sum <= by_hand * (1.0 + 1.0e-9));
        }
    }
}

/// Even in angle under a lamp, even in width under the sun.
#[test]
fn borders_are_even() {
    let camera = pitched_camera();
    let exposure = |light| Exposure::half_angle(light, &camera.see(&[floor()])).unwrap();
    let under_lamp = exposure(lamp(4.0, -3.0));
    let borders = under_lamp.even_borders(5);
    let angles: Vec<f64> = borders
        .iter()
        .map(|place| under_lamp.hull.coordinate(*place).atan())
        .collect();
    for pair in angles.windows(2) {
        near(pair[1] - pair[0], (angles[5] - angles[0]) / 5.0, 1.0e-12);
    }
    assert_eq!((borders[0], borders[5]), (-1.0, 1.0));
    let in_sun = exposure(Light::Directional { travel: at(-0.6, -1.0) });
    for (border, expected) in in_sun.even_borders(4).iter().zip([-1.0, -0.5, 0.0, 0.5, 1.0]) {
        near(*border, expected, 1.0e-12);
    }
    assert_eq!(in_sun.even_borders(0), [-1.0, 1.0]);
}

/// A pixel on a border is in one slice; empty slices are no slices; gaps cost nothing with the pixels' extent.
#[test]
fn slices_hold_every_pixel_once() {
    let all = samples(&[-1.0, -0.5, 0.5, 1.0], &[8.0, 8.0, 8.0, 8.0]);
    let borders = [-1.0, -0.5, 0.0, 0.5, 1.0];
    let parts = slices(&all, &borders, Metric::L1, BORDERS).unwrap();
    let lows: Vec<f64> = parts.iter().map(|part| part.low).collect();
    assert_eq!(lows, [-1.0, -0.5, 0.5]);
    let whole = merged(&parts).unwrap();
    let sums = Moments::of(&all, Metric::L1);
    for (found, expected) in whole.moments.sums().iter().zip(sums.sums()) {
        near(*found, *expected, 1.0e-12);
    }

    let covered = slices(&all, &borders, Metric::L1, SliceExtent::Pixels).unwrap();
    near(covered[0].low, -1.0, 0.0);
    near(covered[0].high, -1.0 + 1.0 / 16.0, 1.0e-12);
    near(covered[1].low, -0.5, 0.0);
    near(covered[1].high, -0.5 + 1.0 / 16.0, 1.0e-12);
    let two = |parts: &[Slice]| greedy_merge(parts, 2, 0.0, Metric::L1).unwrap().total_error(1.0);
    assert!(two(&covered) < two(&parts));

    assert_eq!(merged(&[]), None);
    let none = slices(&[], &borders, Metric::L1, BORDERS);
    assert_eq!(none, Err(Degenerate::NothingVisible));
    assert_eq!(slices(&all, &[], Metric::L1, BORDERS), Err(Degenerate::NothingVisible));
    assert_eq!(greedy_merge(&[], 2, 0.0, Metric::L1), Err(Degenerate::NothingVisible));
    assert_eq!(exact_partition(&[], 2, Metric::L1), Err(Degenerate::NothingVisible));
}

/// Section 3.2: merging may go on below the budget where a frustum hardly helps.
#[test]
fn cheap_merges_go_on() {
    let parts = slices(&waves(), &[-1.0, -0.5, 0.0, 0.5, 1.0], Metric::L1, BORDERS).unwrap();
    let count = |frusta, cheap| greedy_merge(&parts, frusta, cheap, Metric::L1).unwrap().frusta.len();
    assert_eq!(count(4, 0.0), 4);
    assert_eq!(count(3, 0.0), 3);
    assert_eq!(count(4, 10.0), 1);
    let counts = [0.0, 0.03, 0.1, 0.3].map(|cheap| count(4, cheap));
    assert!(counts.is_sorted_by(|a, b| a >= b), "{counts:?}");
    assert!(counts[3] < 4);
    // One plane: nothing is gained by a second frustum.
    let flat = samples(&[-1.0, -0.6, -0.2, 0.2, 0.6, 1.0].map(|place: f64| place), &[1.0; 6]);
    let parts = slices(&flat, &[-1.0, 0.0, 1.0], Metric::L1, SliceExtent::Pixels).unwrap();
    assert_eq!(greedy_merge(&parts, 2, 0.03, Metric::L1).unwrap().frusta.len(), 1);
}
