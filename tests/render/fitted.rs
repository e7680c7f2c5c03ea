//! Fitted maps drawn: against tiled ones, against themselves, and where there is nothing to draw.

use bevy::{prelude::*, render::RenderApp};
use umbrage::{
    maths::virtual_map::memory::TextureMode,
    prelude::*,
    render::virtual_map::{
        TileSchedule,
        report::{VirtualMapReport, VirtualMapReports},
    },
    shadow::fitted::{FittedMaps, NeedFeedback, NeedMapping},
};

use crate::{
    fitted_needs::{planned, planned_partitions, scene},
    harness::{Harness, eye},
};

const SIZE: UVec2 = UVec2::new(160, 90);

/// Small tiles, so that there are many.
fn fitted() -> FittedMaps {
    FittedMaps {
        tiles_per_axis: 16,
        tile_size_max: 256,
        tile_cost: Some(4096),
        ..default()
    }
}

/// Draws the scene of `fitted_needs` with other maps; hard lookups, so that a texel is all that counts.
fn redrawn(harness: &mut Harness, maps: ShadowMaps) -> Vec<f32> {
    let world = harness.app.world_mut();
    let mut suns = world.query::<&mut SunShadows>();
    for mut sun in suns.iter_mut(world) {
        sun.maps = maps.clone();
        sun.filter = ShadowFilter::Hard;
    }
    harness.frames(3);
    harness.shadow_result(harness.camera)
}

fn report(harness: &Harness) -> VirtualMapReport {
    let reports = harness.app.world().resource::<VirtualMapReports>();
    reports.get(harness.camera).expect("the camera has a virtual map")
}

fn differing(a: &[f32], b: &[f32]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

fn shadowed(result: &[f32]) -> usize {
    result.iter().filter(|value| **value < 0.5).count()
}

#[test]
fn nothing_but_the_settings_changes_a_bit() {
    let mut harness = scene(Warp::Lispsm, fitted());
    let first = redrawn(&mut harness, ShadowMaps::Fitted(fitted()));
    let tiles = planned(&harness).plan;
    assert!(tiles.tiles.len() > 4, "{} tiles", tiles.tiles.len());
    assert!(
        (100..SIZE.element_product() as usize / 2).contains(&shadowed(&first)),
        "{} in shadow",
        shadowed(&first)
    );
    let again = redrawn(&mut harness, ShadowMaps::Fitted(fitted()));
    assert_eq!(
        (differing(&first, &again), planned(&harness).plan),
        (0, tiles),
        "drawn again"
    );
    for texture_mode in [TextureMode::Corner, TextureMode::Exact] {
        let other = redrawn(
            &mut harness,
            ShadowMaps::Fitted(FittedMaps {
                texture_mode,
                ..fitted()
            }),
        );
        assert_eq!(differing(&first, &other), 0, "{texture_mode:?}");
    }
    let schedule = TileSchedule {
        is_reversed: true,
        wave_size: 3,
    };
    harness.app.sub_app_mut(RenderApp).insert_resource(schedule);
    let other = redrawn(&mut harness, ShadowMaps::Fitted(fitted()));
    assert_eq!(differing(&first, &other), 0, "another order");
}

/// Texels of at most a pixel: what differs from a map that is finer everywhere are pixels at shadow edges, at most as many
/// as an edge passes through; and far fewer texels are drawn.
#[test]
fn fitted_tiles_are_as_good_as_all_of_them() {
    let mut harness = scene(Warp::Lispsm, fitted());
    let fine = TiledMaps {
        tiles_per_axis: 16,
        tile_size: 512,
        ..default()
    };
    let expected = redrawn(&mut harness, ShadowMaps::Tiled(fine));
    let tiled_texels = report(&harness).texels();
    let edges = edge_pixels(&expected);
    for (name, maps) in [
        ("full", fitted()),
        (
            "map of 64",
            FittedMaps {
                mapping: NeedMapping::Low { size: 64, bytes: false },
                ..fitted()
            },
        ),
        (
            "next frame",
            FittedMaps {
                feedback: NeedFeedback::NextFrame { step: 0.1, turn: 1.0 },
                ..fitted()
            },
        ),
    ] {
        let found = redrawn(&mut harness, ShadowMaps::Fitted(maps));
        let (wrong, report) = (differing(&found, &expected), report(&harness));
        println!(
            "{name}: {wrong} of {edges} edge pixels differ; {} tiles, {} texels",
            report.tiles.len(),
            report.texels()
        );
        assert!(wrong <= edges, "{name}: {wrong} pixels differ, {edges} lie at edges");
        assert!(
            report.texels() * 10 < tiled_texels,
            "{name}: {} of {tiled_texels} texels",
            report.texels()
        );
    }
}

/// A map per z-partition: each pixel looks into that of its depth, and all of them together are as good as one.
#[test]
fn every_partition_has_a_map_of_its_own() {
    let mut harness = scene(Warp::Lispsm, fitted());
    let fine = TiledMaps {
        tiles_per_axis: 16,
        tile_size: 512,
        ..default()
    };
    let expected = redrawn(&mut harness, ShadowMaps::Tiled(fine));
    let edges = edge_pixels(&expected);
    redrawn(&mut harness, ShadowMaps::Fitted(fitted()));
    let pixels = planned(&harness).counts.pixels;
    let world = harness.app.world_mut();
    let mut suns = world.query::<&mut SunShadows>();
    for mut sun in suns.iter_mut(world) {
        sun.partitions.count = 3;
    }
    for feedback in [
        NeedFeedback::SameFrame,
        NeedFeedback::NextFrame { step: 0.1, turn: 1.0 },
    ] {
        let maps = ShadowMaps::Fitted(FittedMaps { feedback, ..fitted() });
        let found = redrawn(&mut harness, maps.clone());
        let (drawn, frames) = (report(&harness), planned_partitions(&harness));
        for partition in 0..3 {
            let own = drawn.tiles.iter().filter(|tile| tile.draw.light_view == partition);
            assert!(own.count() > 0, "partition {partition} has no tile");
        }
        let counts = drawn.fitted.expect("counts");
        let sum: u64 = frames.iter().map(|frame| frame.counts.pixels).sum();
        assert_eq!(counts.pixels, sum);
        // Pixels within rounding of a split count in both partitions.
        assert!(
            sum.abs_diff(pixels) * 100 < pixels,
            "{sum} pixels in three maps, {pixels} in one"
        );
        let wrong = differing(&found, &expected);
        println!(
            "{feedback:?}: {wrong} of {edges} edge pixels differ, {} texels",
            drawn.texels()
        );
        assert!(
            wrong <= edges,
            "{feedback:?}: {wrong} pixels differ, {edges} lie at edges"
        );
        let schedule = TileSchedule {
            is_reversed: true,
            wave_size: 3,
        };
        harness.app.sub_app_mut(RenderApp).insert_resource(schedule);
        let other = redrawn(&mut harness, maps);
        assert_eq!(differing(&found, &other), 0, "another order");
        harness
            .app
            .sub_app_mut(RenderApp)
            .insert_resource(TileSchedule::default());
    }
}

/// Pixels beside one of the other state.
fn edge_pixels(result: &[f32]) -> usize {
    let at = |x: u32, y: u32| result[(y * SIZE.x + x) as usize] < 0.5;
    let is_edge = |x: u32, y: u32| {
        let columns = x.saturating_sub(1)..=(x + 1).min(SIZE.x - 1);
        columns.into_iter().any(|column| {
            let rows = y.saturating_sub(1)..=(y + 1).min(SIZE.y - 1);
            rows.into_iter().any(|row| at(column, row) != at(x, y))
        })
    };
    let pixels = (0..SIZE.y).flat_map(|y| (0..SIZE.x).map(move |x| (x, y)));
    pixels.filter(|(x, y)| is_edge(*x, *y)).count()
}

/// ξ: each level costs quality and saves texels; log2 n levels leave one map (oracle 22).
#[test]
fn quality_drops_down_to_one_map() {
    let mut harness = scene(Warp::Lispsm, fitted());
    let mut least = u64::MAX;
    for quality_drop in 0..=4 {
        let maps = FittedMaps {
            quality_drop,
            ..fitted()
        };
        redrawn(&mut harness, ShadowMaps::Fitted(maps));
        let (frame, report) = (planned(&harness), report(&harness));
        println!(
            "xi {quality_drop}: {} tiles, {} texels",
            report.tiles.len(),
            report.texels()
        );
        // What the plan minimises. Every plan is a plan for the next level too, with tiles no larger.
        let cost = report.texels() + 4096 * report.tiles.len() as u64;
        assert!(
            cost <= least,
            "xi {quality_drop} costs {cost}, the level before {least}"
        );
        least = cost;
        assert_eq!(frame.plan.quality_drop, quality_drop);
    }
    // Where a tile costs nothing but its texels, one map may be cut into fewer texels; where it is split only for want of
    // texels, it is not.
    let maps = FittedMaps {
        quality_drop: 4,
        tile_cost: None,
        ..fitted()
    };
    redrawn(&mut harness, ShadowMaps::Fitted(maps));
    let report = report(&harness);
    assert!(
        report.tiles.len() == 1 && report.texels() <= 256 * 256,
        "one map of at most 256²: {} tiles of {} texels",
        report.tiles.len(),
        report.texels()
    );
}

#[test]
fn tile_textures_fit_the_memory() {
    let mut harness = scene(Warp::Lispsm, fitted());
    for memory in [1, 4] {
        let maps = FittedMaps {
            memory,
            tile_size_max: 4096,
            ..fitted()
        };
        redrawn(&mut harness, ShadowMaps::Fitted(maps));
        let report = report(&harness);
        assert!(
            report.texture_bytes <= u64::from(memory) << 20,
            "{memory} MiB: {} bytes",
            report.texture_bytes
        );
        assert!(!report.tiles.is_empty(), "{memory} MiB: something is drawn");
    }
}

/// Needs of the frame before hold while the camera moves, and a cut waits for its own.
#[test]
fn the_next_frame_follows_a_moving_camera() {
    let maps = FittedMaps {
        feedback: NeedFeedback::NextFrame { step: 0.2, turn: 2.0 },
        ..fitted()
    };
    let mut harness = scene(Warp::Lispsm, maps.clone());
    redrawn(&mut harness, ShadowMaps::Fitted(maps.clone()));
    assert_eq!(report(&harness).read_backs, 0, "a still camera waits for nothing");
    let camera = harness.camera;
    let place = |harness: &mut Harness, transform: Transform| {
        harness.app.world_mut().entity_mut(camera).insert(transform);
        harness.frames(1);
        (harness.shadow_result(camera), report(harness))
    };
    let mut moved = eye();
    let mut seen = Vec::new();
    for _ in 0..3 {
        moved.translation += Vec3::new(0.1, 0.0, -0.1);
        let (result, report) = place(&mut harness, moved);
        assert_eq!(report.read_backs, 0, "within the motion");
        seen.push((moved, result));
    }
    moved.translation += Vec3::X * 3.0;
    let (result, report) = place(&mut harness, moved);
    assert_eq!(report.read_backs, 1, "a cut waits");
    let expected = redrawn(&mut harness, ShadowMaps::Fitted(maps));
    assert_eq!(differing(&result, &expected), 0, "and is what it will be");
    // The same way with needs of the same frame: edges lie up to a texel elsewhere.
    redrawn(&mut harness, ShadowMaps::Fitted(fitted()));
    for (transform, result) in seen {
        let (expected, report) = place(&mut harness, transform);
        assert_eq!(report.read_backs, 1, "needs of the same frame are waited for");
        let (wrong, edges) = (differing(&result, &expected), edge_pixels(&expected));
        println!("{wrong} pixels differ, {edges} lie at edges");
        assert!(shadowed(&expected) > 80, "{} in shadow", shadowed(&expected));
        assert!(wrong <= edges, "{wrong} pixels differ, {edges} lie at edges");
    }
}

#[test]
fn nothing_to_see_is_lit() {
    // Only sky: away from everything.
    let mut harness = scene(Warp::Lispsm, fitted());
    redrawn(&mut harness, ShadowMaps::Fitted(fitted()));
    let up = Transform::from_xyz(0.0, 3.0, 14.0).looking_to(Vec3::Y, Vec3::Z);
    harness.app.world_mut().entity_mut(harness.camera).insert(up);
    harness.frames(3);
    assert_eq!(shadowed(&harness.shadow_result(harness.camera)), 0, "the sky is lit");
    assert_eq!(report(&harness).tiles, [], "no tiles for the sky");
    // Nothing at all.
    let mut empty = Harness::new(SIZE, eye());
    let mut settings = SunShadows {
        maps: ShadowMaps::Fitted(fitted()),
        ..default()
    };
    settings.partitions.count = 1;
    empty.sun(Vec3::new(-0.5, -0.8, -0.4), settings);
    empty.start();
    assert_eq!(shadowed(&empty.shadow_result(empty.camera)), 0, "an empty scene is lit");
}
