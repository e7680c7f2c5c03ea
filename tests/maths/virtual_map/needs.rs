//! The point of fitted maps: every pixel gets its texels, and few others are drawn. Oracle 25 of Giegl, measured by
//! footprints, which know nothing of patches.

use bevy_math::{DVec2, DVec3, UVec2};
use proptest::prelude::*;
use umbrage::maths::{
    bounds::Bounds,
    fit::LightFit,
    footprint::{TexelsOnPixels, texel_footprint, texels_on_pixels},
    polytope::HalfSpace,
    view::ViewVolume,
    virtual_map::{
        fitted::{FittedMap, FittedPlan},
        grid::{GridOptions, NeedGrid},
        mapping::{MappingOptions, NeedMeasure, TileMappingMap},
        tile::map_uv,
        tiled::TiledMap,
    },
    warp::Warp,
};

use super::scene::{Picture, Seen};
use crate::{
    properties::{direction, light_for, seen},
    support::{bodies, fit},
};

fn planned(
    picture: &Picture,
    light: &LightFit,
    settings: &FittedMap,
    options: &MappingOptions,
    size: UVec2,
) -> (FittedPlan, TileMappingMap) {
    let map = TileMappingMap::new(&picture.depths(), &light.clip_from_world, size, options);
    let grid = GridOptions {
        tiles_per_axis: settings.grid_tiles_per_axis(),
        ..GridOptions::default()
    };
    (settings.plan(&NeedGrid::new(&map, &grid)), map)
}

/// Texel against pixel where a pixel looks into the plan; `None` without a tile and for edge-on surfaces.
fn measured(plan: &FittedPlan, picture: &Picture, light: &LightFit, seen: &Seen) -> Option<TexelsOnPixels> {
    let uv = map_uv(&light.clip_from_world, seen.point)?.as_vec2().as_dvec2();
    let tile = plan.tiles.iter().find(|tile| tile.tile.contains(uv))?;
    let texel = texel_footprint(
        &tile.clip_from_world(&light.clip_from_world),
        tile.window.size,
        seen.point,
    )?;
    let pixel = texel_footprint(&picture.clip_from_world, picture.size, seen.point)?;
    texels_on_pixels(&texel, &pixel, seen.normal)
}

fn warp(choice: u8) -> Warp {
    match choice {
        0 => Warp::Uniform,
        1 => Warp::Psm,
        2 => Warp::Tsm { focus: 0.5 },
        _ => Warp::Lispsm,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    /// At most 1 texel ÷ pixel at ξ = 0, 1/8 at ξ = −3, and as said for every ξ, on every axis and in area, for all
    /// pixels that are not capped: any camera, light, warp and margin. With `Extent` in every direction.
    #[test]
    fn every_uncapped_pixel_gets_its_texels(
        (scene, view) in seen(), direction in direction(), along in 0_u8..8, choice in 0_u8..4,
        planes in prop::collection::vec(([0.0..1.0, 0.0..1.0, 0.0..1.0], direction()), 1..4),
        quality_drop in prop_oneof![Just(0), Just(-3), -4..3_i32], margin in 0_u32..4, is_extent in any::<bool>(),
        tile_cost in prop::option::of(0_u32..20_000),
    ) {
        let light_travel = light_for(&view, direction, along);
        prop_assume!(!bodies(&view, &scene, light_travel).0.is_empty());
        let planes: Vec<HalfSpace> = planes.iter()
            .map(|(place, normal)| HalfSpace::through(scene.min + scene.size() * DVec3::from_array(*place), *normal))
            .collect();
        let picture = Picture::of_planes(&view, UVec2::new(40, 32), &planes, &scene);
        let light = fit(&view, &scene, light_travel, warp(choice));
        let settings = FittedMap { quality_drop, margin, tile_size_max: 256, tile_size_min: 16, tiles_per_axis: 16, tile_cost };
        let measure = if is_extent { NeedMeasure::Extent } else { NeedMeasure::Sides };
        let options = MappingOptions { measure, ..MappingOptions::default() };
        let (plan, map) = planned(&picture, &light, &settings, &options, picture.size);
        let most = f64::from(quality_drop).exp2() * (1.0 + 2.0e-3);
        for (pixel, seen) in picture.inner() {
            let index = (pixel.y * picture.size.x + pixel.x) as usize;
            let Some(texel) = map.texels[index] else { continue };
            let is_capped = texel.levels.iter().any(|level| u32::from(*level) > plan.cap);
            let ray = (seen.point - view.eye()).normalize().dot(seen.normal).abs();
            let is_grazing = ray < 0.02 || light_travel.normalize().dot(seen.normal).abs() < 1.0e-3;
            if is_capped || (is_grazing && !view.is_orthographic()) || view.forward().dot(seen.normal).abs() < 0.02 { continue; }
            let ratio = measured(&plan, &picture, &light, &seen);
            prop_assert!(ratio.is_some(), "{pixel} has no tile");
            let ratio = ratio.unwrap();
            prop_assert!(ratio.across <= most && ratio.along <= most, "{pixel}: {ratio:?}, levels {:?}", texel.levels);
            prop_assert!(ratio.area <= most * most, "{ratio:?}");
            prop_assert!(!is_extent || ratio.largest <= most, "{ratio:?}");
            // Oracle 23: the pixel lies in the rectangle of its tile.
            let tile = plan.tiles.iter().find(|tile| tile.tile.contains(texel.uv.as_dvec2()));
            prop_assert!(tile.is_some_and(|tile| tile.rect.contains(pixel)), "{pixel} outside of {:?}", tile);
        }
    }
}

/// A meadow of 400 m with a wall, seen from eye height.
fn meadow(size: UVec2) -> (ViewVolume, Bounds, Picture) {
    let view = ViewVolume::perspective(
        DVec3::new(0.0, 1.7, 0.0),
        DVec3::new(0.1, -0.05, -1.0),
        DVec3::Y,
        1.0,
        16.0 / 9.0,
        0.1,
        1000.0,
    )
    .expect("a camera");
    let scene = Bounds::new(DVec3::new(-200.0, 0.0, -400.0), DVec3::new(200.0, 20.0, 5.0));
    let planes = [
        HalfSpace::through(DVec3::new(0.0, 1.0e-9, 0.0), DVec3::Y),
        HalfSpace::through(DVec3::new(12.0, 0.0, -30.0), DVec3::new(-1.0, 0.0, 0.4).normalize()),
    ];
    let picture = Picture::of_planes(&view, size, &planes, &scene);
    (view, scene, picture)
}

/// Texels drawn against the tiled map of the same effective resolution: at least 10 times fewer, with every warp.
#[test]
fn far_fewer_texels_than_tiled() {
    let (view, scene, picture) = meadow(UVec2::new(480, 270));
    let light_travel = DVec3::new(0.5, -0.7, 0.3);
    // As the thesis splits, and the cheapest plan: few texels per pixel need both a warp and thrift.
    for (warp, tile_cost, least, most_per_pixel) in [
        (Warp::Uniform, None, 200.0, 700.0),
        (Warp::Uniform, Some(65_536), 500.0, 310.0),
        (Warp::Lispsm, None, 200.0, 700.0),
        (Warp::Lispsm, Some(65_536), 3000.0, 50.0),
    ] {
        let light = fit(&view, &scene, light_travel, warp);
        let settings = FittedMap {
            tile_cost,
            ..FittedMap::default()
        };
        let (plan, map) = planned(&picture, &light, &settings, &MappingOptions::default(), picture.size);
        let resolution = plan.effective_resolution();
        let tiled = TiledMap::new(32, (resolution / 32) as u32, 0);
        assert_eq!(tiled.effective_resolution(), resolution);
        let ratio = tiled.texels() as f64 / plan.texels() as f64;
        let per_pixel = plan.texels() as f64 / f64::from(map.valid_texels());
        assert!(
            ratio >= least && per_pixel < most_per_pixel,
            "{warp:?} {tile_cost:?}: {ratio:.0}, {per_pixel:.1} per pixel"
        );
        assert!(plan.tiles.len() < 50, "{} tiles", plan.tiles.len());
        assert!(plan.capped_share(&map) < 1.0e-3, "{}", plan.capped_share(&map));
    }
}

/// 99 % of *all* uncapped valid pixels, silhouettes and borders of the picture too.
#[test]
fn nearly_all_pixels_of_a_scene() {
    let (view, scene, picture) = meadow(UVec2::new(320, 180));
    let light = fit(&view, &scene, DVec3::new(0.5, -0.7, 0.3), Warp::Lispsm);
    for (quality_drop, most) in [(0, 1.0), (-3, 0.125)] {
        let settings = FittedMap {
            quality_drop,
            margin: 2,
            ..FittedMap::default()
        };
        let (plan, map) = planned(&picture, &light, &settings, &MappingOptions::default(), picture.size);
        let (mut right, mut all) = (0, 0);
        for (index, texel) in map.texels.iter().enumerate() {
            let (Some(texel), Some(seen)) = (texel, picture.seen[index]) else {
                continue;
            };
            if texel.levels.iter().any(|level| u32::from(*level) > plan.cap) {
                continue;
            }
            let ratio = measured(&plan, &picture, &light, &seen).expect("a tile");
            right += u32::from(ratio.across.max(ratio.along) <= most);
            all += 1;
        }
        let share = f64::from(right) / f64::from(all);
        assert!(share >= 0.99 && all > 20_000, "ξ = {quality_drop}: {share} of {all}");
    }
}

/// Row F3 and reconstruction 14: with a smaller mapping map, guarded and spread, nearly every pixel still has its tile
/// and lies in its rectangle; without both there are holes.
#[test]
fn smaller_mapping_maps_leave_few_holes() {
    let (view, scene, picture) = meadow(UVec2::new(320, 180));
    let light = fit(&view, &scene, DVec3::new(0.5, -0.7, 0.3), Warp::Lispsm);
    let settings = FittedMap::default();
    let holes = |spread, rect_guard| {
        let map = TileMappingMap::new(
            &picture.depths(),
            &light.clip_from_world,
            picture.size / 4,
            &MappingOptions::default(),
        );
        let plan = settings.plan(&NeedGrid::new(
            &map,
            &GridOptions {
                spread,
                rect_guard,
                ..GridOptions::default()
            },
        ));
        let seen = picture
            .seen
            .iter()
            .enumerate()
            .filter_map(|(index, seen)| Some((index as u32, (*seen)?)));
        seen.filter(|(index, seen)| {
            let uv = map_uv(&light.clip_from_world, seen.point).unwrap_or(DVec2::NAN);
            let pixel = UVec2::new(index % picture.size.x, index / picture.size.x);
            !plan
                .tiles
                .iter()
                .any(|tile| tile.tile.contains(uv) && tile.rect.contains(pixel))
        })
        .count()
    };
    let (bare, guarded) = (holes(0, 0), holes(2, 4));
    let all = picture.seen.iter().flatten().count();
    assert!(
        bare > 20 && guarded * 2000 < all && guarded * 10 < bare,
        "{bare} and {guarded} of {all}"
    );
}
