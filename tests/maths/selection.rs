//! Selection of light views against the oracles of Lloyd and Stingl, and the seams between them.

use bevy_math::{DMat4, DVec2, DVec3, UVec2};
use proptest::prelude::*;
use umbrage::maths::{
    fit::{FitInput, FitOptions, fit_light_view},
    selection::{
        BorderBand, SelectableView, Selected, Selection, border_weights, depth_seam, partition_of_depth, range_fade,
        select_view, selection_mask, view_weights,
    },
    split::{SplitScheme, split_depths},
    warp::Warp,
};

use crate::{
    properties::{direction, light_for, seen},
    support::bodies,
};

const DEPTHS: [f64; 5] = [1.0, 5.0, 20.0, 60.0, 100.0];

/// A map that contains the cube of this half side around the origin.
fn cube(half_side: f64, end_depth: f64, margin: f64) -> SelectableView {
    SelectableView {
        clip_from_world: DMat4::from_translation(DVec3::new(0.0, 0.0, 0.5))
            * DMat4::from_scale(DVec3::new(1.0, 1.0, 0.5) / half_side),
        end_depth,
        margin: DVec2::splat(margin),
        size: UVec2::splat(64),
        seam_depth: 0.0,
        stands_in: false,
    }
}

/// Lloyd, oracle 21: every depth of the range has one partition, split distances too.
#[test]
fn every_depth_has_one_partition() {
    for step in 0..=1000 {
        let depth = 1.0 + 0.099 * f64::from(step);
        let index = partition_of_depth(&DEPTHS, depth).unwrap();
        assert!(
            DEPTHS[index] <= depth && (depth < DEPTHS[index + 1] || index == 3),
            "{depth}"
        );
    }
    let splits = DEPTHS.map(|depth| partition_of_depth(&DEPTHS, depth));
    assert_eq!(splits, [Some(0), Some(1), Some(2), Some(3), Some(3)]);
    for outside in [0.999, 100.001, f64::NAN, f64::INFINITY] {
        assert_eq!(partition_of_depth(&DEPTHS, outside), None, "{outside}");
    }
    assert_eq!(partition_of_depth(&[], 1.0), None);
    assert_eq!(partition_of_depth(&[1.0], 1.0), None);
}

/// Lloyd, row 38 and oracle 21: the mask sums to 1 and picks the same partition.
#[test]
fn the_mask_picks_one() {
    let inner = (0..=1000).map(|step| 1.0 + 0.099 * f64::from(step));
    for depth in inner.chain(DEPTHS) {
        let mask = selection_mask(&DEPTHS, depth);
        let index = partition_of_depth(&DEPTHS, depth).unwrap();
        assert_eq!(mask.iter().sum::<f64>(), 1.0, "{depth}");
        assert_eq!(mask[index], 1.0, "{depth}");
    }
    for (outside, index) in [(0.0, 0), (f64::NAN, 0), (1.0e9, 3), (f64::INFINITY, 3)] {
        let mask = selection_mask(&DEPTHS, outside);
        assert_eq!((mask.iter().sum::<f64>(), mask[index]), (1.0, 1.0), "{outside}");
    }
    let sixteen = split_depths(&SplitScheme::Uniform, 0.0, 16.0, 16);
    assert_eq!(selection_mask(&sixteen, 15.5)[15], 1.0);
    assert_eq!(selection_mask(&[], 1.0), [0.0; 16]);
}

/// What the shader does: by depth the first map from the partition on that contains the point, by resolution the first
/// of all, as cascades the partition's even if it does not contain the point.
#[test]
fn selection_follows_the_shader() {
    let views = [cube(1.0, 5.0, 0.0), cube(2.0, 10.0, 0.0), cube(4.0, 20.0, 0.0)];
    let select = |selection, x, depth| select_view(&views, selection, DVec3::X * x, depth, 30.0);
    let (found, missed) = (
        |index| Selected { index, is_found: true },
        |index| Selected { index, is_found: false },
    );
    use Selection::{BestResolution, Cascades, Depth};
    for (selection, x, depth, expected) in [
        (Depth, 0.5, 1.0, found(0)),
        (Depth, 0.5, 5.0, found(1)),
        (Depth, 0.5, 12.0, found(2)),
        (Depth, 0.5, 25.0, found(2)),
        (Depth, 1.5, 1.0, found(1)),
        (Depth, 5.0, 1.0, missed(2)),
        (BestResolution, 0.5, 12.0, found(0)),
        (BestResolution, 1.5, 12.0, found(1)),
        (BestResolution, 5.0, 12.0, missed(2)),
        (Cascades, 0.5, 7.0, found(1)),
        (Cascades, 1.5, 1.0, missed(0)),
        (Depth, 0.5, 30.0, missed(0)),
        (BestResolution, 0.5, 31.0, missed(0)),
    ] {
        assert_eq!(select(selection, x, depth), expected, "{selection:?} {x} {depth}");
    }
    assert_eq!(select_view(&[], Depth, DVec3::ZERO, 1.0, 30.0), missed(0));
}

#[test]
fn maps_contain_what_their_filter_reaches() {
    assert!(cube(1.0, 5.0, 0.0).contains(DVec3::new(1.0, -1.0, 1.0)));
    assert!(!cube(1.0, 5.0, 0.01).contains(DVec3::new(1.0, -1.0, 1.0)));
    assert!(cube(1.0, 5.0, 0.01).contains(DVec3::new(0.98, -0.98, 1.0)));
    // Lloyd and Stingl alike: a point behind the map's far end may have occluders that were never drawn.
    assert!(!cube(1.0, 5.0, 0.0).contains(DVec3::new(0.0, 0.0, -1.001)));
    assert!(!cube(1.0, 5.0, 0.0).contains(DVec3::new(0.0, 0.0, 1.001)));
    let mut behind = cube(1.0, 5.0, 0.0);
    behind.clip_from_world = DMat4::from_diagonal(DVec3::ONE.extend(-1.0));
    assert!(!behind.contains(DVec3::ZERO) && !behind.contains(DVec3::NAN));
}

#[test]
fn seams_rise_from_one_partition_to_the_next() {
    let seam = |depth| depth_seam(&DEPTHS, depth, 0.25).unwrap();
    let parts = |depth| (seam(depth).first, seam(depth).second, seam(depth).weight);
    assert_eq!(parts(1.0), (0, 1, 0.0));
    assert_eq!(parts(4.0), (0, 1, 0.0));
    assert_eq!(parts(4.5), (0, 1, 0.5));
    assert_eq!(parts(5.0), (1, 2, 0.0));
    assert_eq!(parts(18.125), (1, 2, 0.5));
    // The cubic at a quarter.
    assert_eq!(parts(4.25), (0, 1, 0.15625));
    assert_eq!(parts(99.9), (3, 3, 0.0));
    for share in [0.0, -1.0, f64::NAN] {
        assert_eq!(depth_seam(&DEPTHS, 4.999, share).unwrap().weight, 0.0);
    }
    assert_eq!(depth_seam(&DEPTHS, 0.5, 0.25), None);
}

/// Any quantity that is blended over a seam is continuous, at the splits too.
#[test]
fn seams_are_continuous() {
    let values = [3.0, -1.0, 10.0, 4.0];
    let blend = |depth: f64| {
        let seam = depth_seam(&DEPTHS, depth, 0.3).unwrap();
        values[seam.first] * (1.0 - seam.weight) + values[seam.second] * seam.weight
    };
    let step = 1.0e-4;
    let mut depth = 1.0;
    while depth + step < 100.0 {
        // The steepest seam goes from 3 to −1 in 1.2 m; the cubic's slope is 1.5.
        assert!(
            (blend(depth + step) - blend(depth)).abs() < 6.0 * step,
            "a jump at {depth}"
        );
        depth += step * 7.0;
    }
    for split in &DEPTHS[1..4] {
        assert!(
            (blend(split - 1.0e-9) - blend(*split)).abs() < 1.0e-6,
            "a jump at {split}"
        );
    }
}

/// From the middle outwards: the finest map alone, then both, then the next alone; the sum stays 1.
#[test]
fn border_weights_sum_to_one_and_are_continuous() {
    let views = [cube(1.0, 5.0, 0.02), cube(2.0, 10.0, 0.02), cube(4.0, 20.0, 0.02)];
    let band = 0.1;
    let weights = |x: f64| border_weights(&views, DVec3::new(x, 0.3 * x, 0.1), band);
    assert_eq!(weights(0.5), [1.0, 0.0, 0.0]);
    assert_eq!(weights(1.5), [0.0, 1.0, 0.0]);
    let middle = weights(0.86);
    assert!(
        (middle[0] - 0.5).abs() < 1.0e-9 && (middle[1] - 0.5).abs() < 1.0e-9,
        "{middle:?}"
    );
    let step = 1.0e-4;
    for index in 0..37_000 {
        let x = f64::from(index) * step;
        let (here, next) = (weights(x), weights(x + step));
        assert!((here.iter().sum::<f64>() - 1.0).abs() < 1.0e-12, "{here:?} at {x}");
        let change = here.iter().zip(&next).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(change < 1.0e-3, "a jump at {x}: {here:?} {next:?}");
    }
    assert_eq!(weights(5.0), [0.0; 3]);
    assert_eq!(border_weights(&views, DVec3::X * 0.95, 0.0), [1.0, 0.0, 0.0]);
}

/// The finest map is that with the most texels per square metre, wherever it stands.
#[test]
fn the_finest_map_is_found_in_any_order() {
    let mut views = [cube(4.0, 20.0, 0.0), cube(1.0, 5.0, 0.0), cube(2.0, 10.0, 0.0)];
    let select = |views: &[SelectableView], x| select_view(views, Selection::Finest, DVec3::X * x, 12.0, 30.0);
    for (x, index) in [(0.5, 1), (1.5, 2), (3.0, 0)] {
        assert_eq!(select(&views, x), Selected { index, is_found: true }, "{x}");
    }
    assert!(!select(&views, 5.0).is_found);
    // 64² texels on 2 m are 1024 per square metre; 8 m need more than 256² for as many.
    views[0].size = UVec2::new(256, 255);
    assert_eq!(select(&views, 0.5).index, 1);
    views[0].size = UVec2::new(256, 257);
    assert_eq!(select(&views, 0.5).index, 0);
}

/// The weights of the shader are those of the formulas for each rule.
#[test]
fn weights_of_views_follow_the_formulas() {
    let share = 0.25;
    let mut by_depth = [5.0, 20.0, 60.0, 100.0].map(|end| cube(1.0e3, end, 0.0));
    for (view, range) in by_depth.iter_mut().zip(DEPTHS.windows(2)) {
        view.seam_depth = (range[1] - range[0]) * share;
    }
    for step in 0..990 {
        let depth = 1.0 + 0.1 * f64::from(step);
        let weights = view_weights(&by_depth, Selection::Depth, BorderBand::None, DVec3::ZERO, depth, 200.0);
        let seam = depth_seam(&DEPTHS, depth, share).unwrap();
        let mut expected = [0.0; 4];
        expected[seam.second] += seam.weight;
        expected[seam.first] += 1.0 - seam.weight;
        for (weight, expected) in weights.iter().zip(expected) {
            assert!(
                (weight - expected).abs() < 1.0e-12,
                "{depth}: {weights:?}, not {expected:?}"
            );
        }
    }
    let views = [cube(1.0, 5.0, 0.02), cube(2.0, 10.0, 0.02), cube(4.0, 20.0, 0.02)];
    for step in 0..500 {
        let point = DVec3::new(0.01 * f64::from(step), 0.003 * f64::from(step), 0.1);
        for selection in [Selection::BestResolution, Selection::Finest] {
            let weights = view_weights(&views, selection, BorderBand::Share(0.1), point, 1.0, 200.0);
            let expected = border_weights(&views, point, 0.1);
            for (weight, expected) in weights.iter().zip(&expected) {
                assert!(
                    (weight - expected).abs() < 1.0e-12,
                    "{point}: {weights:?}, not {expected:?}"
                );
            }
        }
    }
    // A band of half a metre is a quarter of the first map's texture coordinates on each side, an eighth of the next one's.
    let metres = |x: f64| {
        view_weights(
            &views,
            Selection::BestResolution,
            BorderBand::Metres(0.5),
            DVec3::X * x,
            1.0,
            9.0,
        )
    };
    assert_eq!(metres(0.4)[0], 1.0);
    assert!((metres(0.71)[0] - 0.5).abs() < 1.0e-9, "the middle of 0.96 and 0.46 m");
    assert_eq!(
        view_weights(&views, Selection::Depth, BorderBand::None, DVec3::ZERO, 9.0, 9.0),
        [0.0; 3]
    );
}

/// A coarse map under all others serves only what lies in none of them: no seam leads into it.
#[test]
fn a_map_that_stands_in_takes_no_part_in_seams() {
    let mut views = [cube(1.0, 5.0, 0.0), cube(2.0, 10.0, 0.0), cube(4.0, 20.0, 0.0)];
    views[2].stands_in = true;
    let weights = |x: f64| {
        view_weights(
            &views,
            Selection::Finest,
            BorderBand::Share(0.25),
            DVec3::X * x,
            1.0,
            200.0,
        )
    };
    assert_eq!(weights(0.2), [1.0, 0.0, 0.0]);
    let blended = weights(0.9);
    assert!(blended[0] > 0.0 && blended[1] > 0.0 && blended[2] == 0.0, "{blended:?}");
    assert_eq!(weights(1.9), [0.0, 1.0, 0.0], "nothing else holds it");
    assert_eq!(weights(3.0), [0.0, 0.0, 1.0]);
}

#[test]
fn shadows_fade_at_the_end_of_their_range() {
    let fade = |depth| range_fade(depth, 100.0, 0.2);
    assert_eq!([fade(0.0), fade(80.0), fade(100.0), fade(500.0)], [1.0, 1.0, 0.0, 0.0]);
    assert_eq!([fade(85.0), fade(90.0), fade(95.0)], [0.84375, 0.5, 0.15625]);
    // Its slope is 0 at both ends.
    assert!(fade(80.1) > 0.9999 && fade(99.9) < 1.0e-4);
    let mut last = 1.0;
    for step in 0..=2000 {
        let next = fade(f64::from(step) * 0.1);
        assert!(next <= last && last - next < 0.01, "{step}");
        last = next;
    }
    for share in [0.0, f64::NAN] {
        assert_eq!(
            [range_fade(99.9, 100.0, share), range_fade(100.0, 100.0, share)],
            [1.0, 0.0]
        );
    }
    assert_eq!(range_fade(f64::NAN, 100.0, 0.2), 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Stingl, oracle 25: selection by resolution never finds a coarser map than selection by depth, and both find one.
    #[test]
    fn best_resolution_is_no_coarser((scene, view) in seen(), direction in direction(), along in 0_u8..8, share in 0.0..1.0, warped in any::<bool>()) {
        let light_travel = light_for(&view, direction, along);
        let (visible, _) = bodies(&view, &scene, light_travel);
        prop_assume!(!visible.is_empty());
        let depths = split_depths(&SplitScheme::Practical { lambda: 0.7 }, view.near(), view.far(), 4);
        let mut views = Vec::new();
        for range in depths.windows(2) {
            let slice = view.split(range[0], range[1]);
            let (visible, body) = bodies(&slice, &scene, light_travel);
            let warp = if warped { Warp::Lispsm } else { Warp::Uniform };
            let fit = fit_light_view(&FitInput { view: &slice, visible: &visible, body: &body, light_travel, warp, map_size: UVec2::splat(512), guard_texels: 2.0, guard_metres: 0.0, options: FitOptions::default() }).fitted();
            views.push(SelectableView {
                clip_from_world: fit.map_or(DMat4::ZERO, |fit| fit.clip_from_world),
                end_depth: range[1],
                margin: DVec2::splat(1.0 / 512.0),
                size: UVec2::splat(512),
                seam_depth: 0.0,
                stands_in: false,
            });
        }
        let vertices = visible.vertices();
        let pick = |share: f64| vertices[((share * vertices.len() as f64) as usize).min(vertices.len() - 1)];
        let point = pick(share) * (1.0 - share) + visible.center() * share;
        let depth = view.depth(point);
        prop_assume!(depth > view.near() && depth < view.far());
        let by = |selection| select_view(&views, selection, point, depth, f64::INFINITY);
        let (by_depth, by_resolution, cascade) = (by(Selection::Depth), by(Selection::BestResolution), by(Selection::Cascades));
        prop_assert!(by_depth.is_found && by_resolution.is_found && by_resolution.index <= by_depth.index, "{by_depth:?} {by_resolution:?}");
        prop_assert_eq!(Some(cascade.index), partition_of_depth(&depths, depth));
        prop_assert_eq!(by_depth, cascade, "a point lies in the map of its own partition");
    }
}
