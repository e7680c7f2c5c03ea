//! The four strategies for semitransparent surfaces (row F20 of Giegl).

use bevy_math::UVec2;
use umbrage::maths::virtual_map::{
    fitted::FittedMap,
    grid::{NeedCell, NeedGrid},
    picture::PixelRect,
    transparent::{ShadowSource, TransparentShadows, TransparentWork, shadow_source},
};

use TransparentShadows::{MultiPass, SecondLayer, SingleMap, Unshadowed};

#[test]
fn fragments_know_where_their_shadow_is() {
    let source = |strategy, depth, nearest| shadow_source(strategy, depth, 0.5, nearest, 1.0e-4);
    for (strategy, in_front, nearest) in [
        (Unshadowed, ShadowSource::Lit, ShadowSource::Lit),
        (SingleMap, ShadowSource::SingleMap, ShadowSource::SingleMap),
        (SecondLayer, ShadowSource::SingleMap, ShadowSource::SecondLayer),
        (MultiPass, ShadowSource::LiveTile, ShadowSource::LiveTile),
    ] {
        assert_eq!(source(strategy, 0.7, 0.9), in_front);
        assert_eq!(source(strategy, 0.9, 0.9), nearest);
        // On the opaque surface itself: decals, fading levels of detail.
        assert_eq!(source(strategy, 0.500_01, 0.9), ShadowSource::Opaque);
        assert_eq!(source(strategy, f64::NAN, 0.9), in_front);
    }
    // Before the sky there is no opaque surface to agree with, and depth 0 is no layer.
    assert_eq!(
        shadow_source(SecondLayer, 0.0, 0.0, 0.0, 1.0e-4),
        ShadowSource::SingleMap
    );
}

#[test]
fn only_multi_pass_draws_again() {
    let rect = |x: u32| PixelRect {
        min: UVec2::new(x, 0),
        max: UVec2::new(x + 10, 10),
    };
    let cells: Vec<NeedCell> = (0..4)
        .map(|index| NeedCell {
            levels: [13, 13],
            pixels: 1,
            rect: rect(index * 10),
        })
        .collect();
    let plan = FittedMap {
        tiles_per_axis: 2,
        ..FittedMap::default()
    }
    .plan(&NeedGrid::from_cells(cells).unwrap());
    assert_eq!(plan.tiles.len(), 4);
    let object = PixelRect {
        min: UVec2::new(15, 5),
        max: UVec2::new(25, 6),
    };
    assert_eq!(MultiPass.passes(&plan, object).collect::<Vec<_>>(), [1, 2]);
    assert_eq!(SingleMap.passes(&plan, object).count(), 0);
    assert_eq!(MultiPass.passes(&plan, PixelRect::EMPTY).count(), 0);
    let work = |need_layers, results, single_maps, draws| TransparentWork {
        need_layers,
        results,
        single_maps,
        draws,
    };
    for (strategy, expected) in [
        (Unshadowed, work(1, 1, 0, 1)),
        (SingleMap, work(1, 1, 1, 1)),
        (SecondLayer, work(2, 2, 0, 1)),
        (MultiPass, work(1, 1, 0, 2)),
    ] {
        assert_eq!(strategy.work(&plan, object), expected);
    }
    assert_eq!(TransparentShadows::default(), SingleMap);
}
