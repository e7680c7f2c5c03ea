//! Virtual maps against one large map, against themselves in other orders, and against their counts.

use bevy::{camera::Viewport, math::UVec2, prelude::*, render::RenderApp};
use umbrage::{
    maths::virtual_map::queried::{ChangeThreshold, Decision, QueriedMap},
    prelude::*,
    render::{
        capture,
        caster::drawn::casters_drawn,
        virtual_map::{
            TileSchedule, VirtualMap,
            overlay::{TileOverlay, tile_color},
            report::{VirtualMapReport, VirtualMapReports},
        },
    },
    shadow::fitted::NeedMapping,
};

use crate::{
    harness::{Harness, eye},
    identity::scene,
};

const PICTURE: UVec2 = UVec2::new(160, 90);
/// Of cameras that draw a part of it only, from a corner on.
const TARGET: UVec2 = UVec2::new(224, 150);
const CORNER: UVec2 = UVec2::new(40, 36);

/// A low light from the right behind the camera: long shadows over the ground.
const LIGHT: Vec3 = Vec3::new(-0.6, -0.3, -0.4);

/// One map of a whole view.
fn one_map(warp: Warp, filter: ShadowFilter) -> SunShadows {
    let mut settings = SunShadows {
        map_size: 2048,
        warp,
        filter,
        ..SunShadows::LOW
    };
    settings.partitions.count = 1;
    settings
}

fn tiled(tiles_per_axis: u32, tile_size: u32) -> TiledMaps {
    TiledMaps {
        tiles_per_axis,
        tile_size,
        ..TiledMaps::default()
    }
}

/// Without jumps.
fn queried(min: f64, max_tiles_per_axis: u32) -> QueriedMap {
    QueriedMap {
        threshold: ChangeThreshold::Pixels(min * 1024.0 * 1024.0 / f64::from(PICTURE.x * PICTURE.y)),
        max_tiles_per_axis,
        tile_size: 256,
        tile_size_max: 256,
        maximum_jump: false,
        opportunity_jump: None,
        ..QueriedMap::default()
    }
}

/// A scene with opaque, alpha-masked and skinned casters, whose sun can be changed.
struct Stage {
    harness: Harness,
    sun: Entity,
}

impl Stage {
    fn new(settings: SunShadows) -> Self {
        Self::with(settings, Harness::new(PICTURE, eye()))
    }

    /// The same picture in a part of a larger target.
    fn in_viewport(settings: SunShadows) -> Self {
        let mut harness = Harness::new(TARGET, eye());
        let world = harness.app.world_mut();
        let mut camera = world.get_mut::<Camera>(harness.camera).expect("a camera");
        camera.viewport = Some(Viewport {
            physical_position: CORNER,
            physical_size: PICTURE,
            ..default()
        });
        Self::with(settings, harness)
    }

    fn with(settings: SunShadows, mut harness: Harness) -> Self {
        let sun = harness.sun(LIGHT, settings);
        scene(&mut harness, 120);
        harness.start();
        Self { harness, sun }
    }

    /// The shadow result under other settings.
    fn result(&mut self, settings: SunShadows) -> Vec<f32> {
        self.harness.app.world_mut().entity_mut(self.sun).insert(settings);
        self.harness.frames(2);
        self.harness.shadow_result(self.harness.camera)
    }

    fn virtual_result(&mut self, maps: ShadowMaps) -> Vec<f32> {
        self.result(SunShadows {
            maps,
            ..one_map(Warp::Lispsm, ShadowFilter::Hard)
        })
    }

    fn queried_result(&mut self, refinement: QueriedMap) -> (Vec<f32>, VirtualMapReport) {
        let maps = ShadowMaps::Queried(QueriedMaps {
            refinement,
            ..QueriedMaps::default()
        });
        let result = self.virtual_result(maps);
        (result, self.report())
    }

    fn report(&self) -> VirtualMapReport {
        let reports = self.harness.app.world().resource::<VirtualMapReports>();
        reports.get(self.harness.camera).expect("the camera has a virtual map")
    }

    fn schedule(&mut self, schedule: TileSchedule) {
        self.harness.app.sub_app_mut(RenderApp).insert_resource(schedule);
    }
}

fn shadowed(result: &[f32]) -> usize {
    result.iter().filter(|value| **value < 0.5).count()
}

fn differing(a: &[f32], b: &[f32]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

/// Oracle 4 of Giegl: 4 × 4 tiles of 512 are one map of 2048, pixel by pixel, with and without a warp and a filter.
#[test]
fn tiles_give_the_result_of_one_map() {
    let mut stage = Stage::new(one_map(Warp::Lispsm, ShadowFilter::Hard));
    for (warp, filter, tile_size) in [
        (Warp::Lispsm, ShadowFilter::Hard, 512),
        (Warp::Uniform, ShadowFilter::Hard, 512),
        // A margin of a texel on each side leaves 512 texels for the tile itself.
        (Warp::Uniform, ShadowFilter::Pcf2, 514),
    ] {
        let one = one_map(warp, filter);
        let maps = ShadowMaps::Tiled(tiled(4, tile_size));
        let name = format!("{warp:?} {filter:?}");
        // The guard of texels at the map's border depends on the map's nominal size.
        let expected = stage.result(SunShadows {
            map_size: 4 * tile_size,
            ..one.clone()
        });
        let found = stage.result(SunShadows { maps, ..one });
        let share = shadowed(&found) as f32 / found.len() as f32;
        assert!((0.03..0.9).contains(&share), "{name}: {share} in shadow");
        if tile_size == 512 {
            assert_eq!(differing(&found, &expected), 0, "{name}: pixels differ from one map");
        } else {
            // 2056 texels against 4 × 512: edges lie up to half a texel elsewhere.
            let wrong = found
                .iter()
                .zip(&expected)
                .filter(|(a, b)| (*a - *b).abs() > 0.5)
                .count();
            assert!(wrong * 200 < found.len(), "{name}: {wrong} pixels differ from one map");
        }
    }
}

/// With every warp, filter and blur tiles show what one map of their resolution shows; edges lie up to a texel elsewhere, as
/// margins are no part of a tile.
#[test]
fn warps_filters_and_blur_work_in_tiles() {
    let poisson = ShadowFilter::Poisson { taps: 16, radius: 0.15 };
    let pcss = ShadowFilter::Pcss {
        taps: 16,
        radius: 0.15,
        sun_diameter: 0.53,
    };
    let blur = ShadowBlur {
        iterations: 3,
        full_depth: 10.0,
    };
    let mut stage = Stage::new(one_map(Warp::Lispsm, ShadowFilter::Hard));
    for (warp, filter, blur) in [
        (Warp::Psm, ShadowFilter::Pcf2, ShadowBlur::NONE),
        (Warp::Tsm { focus: 0.2 }, ShadowFilter::Pcf2, ShadowBlur::NONE),
        (Warp::Repar, ShadowFilter::Pcf2, ShadowBlur::NONE),
        (Warp::Lispsm, poisson, ShadowBlur::NONE),
        (Warp::Uniform, pcss, ShadowBlur::NONE),
        (Warp::Lispsm, ShadowFilter::Pcf2, blur),
    ] {
        let one = SunShadows {
            blur,
            ..one_map(warp, filter)
        };
        let expected = stage.result(one.clone());
        for maps in [
            ShadowMaps::Tiled(tiled(4, 560)),
            ShadowMaps::Queried(QueriedMaps {
                refinement: queried(0.0, 8),
                ..default()
            }),
            ShadowMaps::Fitted(FittedMaps {
                tiles_per_axis: 8,
                tile_size_max: 256,
                ..default()
            }),
        ] {
            let name = format!("{warp:?}, {filter:?}, {} iterations, {maps:?}", blur.iterations);
            let found = stage.result(SunShadows { maps, ..one.clone() });
            let share = shadowed(&found) as f32 / found.len() as f32;
            assert!((0.03..0.9).contains(&share), "{name}: {share} in shadow");
            let pairs = found.iter().zip(&expected);
            let wrong = pairs.filter(|(a, b)| (*a - *b).abs() > 0.5).count();
            println!("{name}: {wrong}");
            assert!(wrong * 100 < found.len(), "{name}: {wrong} pixels differ from one map");
        }
    }
}

/// A camera that draws a part of its target has the same tiles and pixels there as one that draws all of it.
#[test]
fn viewports_have_virtual_maps() {
    let settings = one_map(Warp::Lispsm, ShadowFilter::Hard);
    let (mut whole, mut part) = (Stage::new(settings.clone()), Stage::in_viewport(settings));
    let fitted = |mapping| {
        ShadowMaps::Fitted(FittedMaps {
            tiles_per_axis: 8,
            tile_size_max: 256,
            mapping,
            ..default()
        })
    };
    for maps in [
        ShadowMaps::Tiled(tiled(4, 256)),
        ShadowMaps::Queried(QueriedMaps {
            refinement: queried(20.0, 8),
            ..default()
        }),
        fitted(NeedMapping::Full),
        fitted(NeedMapping::Low { size: 64, bytes: false }),
    ] {
        let (expected, found) = (whole.virtual_result(maps.clone()), part.virtual_result(maps.clone()));
        let rows = found
            .chunks(TARGET.x as usize)
            .skip(CORNER.y as usize)
            .take(PICTURE.y as usize);
        let columns = CORNER.x as usize..(CORNER.x + PICTURE.x) as usize;
        let inside: Vec<f32> = rows.flat_map(|row| row[columns.clone()].to_vec()).collect();
        assert!(shadowed(&expected) > 500, "there are shadows");
        assert_eq!(
            shadowed(&inside),
            shadowed(&found),
            "{maps:?}: nothing beside the viewport is in shadow"
        );
        // Positions of pixels are rounded otherwise.
        let wrong = differing(&inside, &expected);
        assert!(wrong * 300 < expected.len(), "{maps:?}: {wrong} pixels differ");
        let tiles = [&whole, &part].map(|stage| stage.report().tiles.len());
        assert_eq!(tiles[0], tiles[1], "{maps:?}: tiles");
    }
}

/// The depths of a tile are those of the map at the same texels, up to the rounding of another projection.
#[test]
fn tiles_have_the_depths_of_one_map() {
    let mut stage = Stage::new(one_map(Warp::Uniform, ShadowFilter::Hard));
    let whole = stage.harness.atlas();
    let depths = whole.to_f32();
    let mut compared = 0;
    for is_reversed in [false, true] {
        stage.schedule(TileSchedule {
            is_reversed,
            ..default()
        });
        stage.result(SunShadows {
            maps: ShadowMaps::Tiled(TiledMaps {
                // One texture: it holds the tile that was drawn last.
                memory: 1,
                ..tiled(4, 512)
            }),
            ..one_map(Warp::Uniform, ShadowFilter::Hard)
        });
        let tile = stage
            .harness
            .camera_texture::<VirtualMap>(stage.harness.camera, |map| map.texture().expect("a texture"));
        let corner = if is_reversed { 0 } else { 3 * 512 };
        let mut off = 0;
        for (index, depth) in tile.to_f32().iter().enumerate() {
            let (x, y) = (index % 512 + corner, index / 512 + corner);
            let expected = depths[y * 2048 + x];
            compared += usize::from(expected > 0.0);
            off += usize::from((depth - expected).abs() > 1e-6);
        }
        // A sample within rounding of a triangle's edge may fall on its other side.
        assert!(
            off * 20_000 <= 512 * 512,
            "{off} texels differ, reversed: {is_reversed}"
        );
    }
    assert!(compared > 1000, "only {compared} texels hold a caster");
}

#[test]
fn order_waves_and_skipped_tiles_change_no_bit() {
    let mut stage = Stage::new(one_map(Warp::Lispsm, ShadowFilter::Pcf2));
    let settings = |maps: TiledMaps| SunShadows {
        maps: ShadowMaps::Tiled(maps),
        ..one_map(Warp::Lispsm, ShadowFilter::Pcf2)
    };
    let expected = stage.result(settings(tiled(5, 300)));
    assert!(shadowed(&expected) > 500, "there are shadows");
    for (is_reversed, wave_size) in [(true, 16), (false, 1), (true, 3)] {
        stage.schedule(TileSchedule { is_reversed, wave_size });
        let found = stage.result(settings(tiled(5, 300)));
        assert_eq!(
            differing(&found, &expected),
            0,
            "reversed {is_reversed}, waves of {wave_size}"
        );
    }
    let refined = stage.queried_result(queried(0.0, 8));
    assert!(refined.1.splits > 4, "{} splits", refined.1.splits);
    stage.schedule(TileSchedule::default());
    let again = stage.queried_result(queried(0.0, 8));
    assert_eq!(differing(&refined.0, &again.0), 0, "queried, reversed in waves of 3");
    assert_eq!(refined.1, again.1, "queried: the same counts and tiles");
    let found = stage.result(settings(TiledMaps {
        skip_empty: true,
        ..tiled(5, 300)
    }));
    let drawn = stage.report().tiles.len();
    assert_eq!(
        differing(&found, &expected),
        0,
        "tiles without receivers change nothing"
    );
    assert!(drawn < 25, "{drawn} tiles: none was skipped");
}

#[test]
fn tiles_are_culled() {
    let mut stage = Stage::new(one_map(Warp::Uniform, ShadowFilter::Hard));
    stage.virtual_result(ShadowMaps::Tiled(tiled(4, 128)));
    let camera = stage
        .harness
        .app
        .world()
        .get::<bevy::render::sync_world::RenderEntity>(stage.harness.camera)
        .expect("the camera is drawn")
        .id();
    let counts = casters_drawn(stage.harness.app.sub_app(RenderApp).world(), camera).expect("counts are read");
    let total: u32 = counts.iter().sum();
    assert_eq!(counts.len(), 16, "one count per tile");
    // The skinned caster is in every tile; the others in few.
    assert!(counts.iter().all(|count| *count >= 1), "{counts:?}");
    assert!((60..121 * 8).contains(&total), "{total} of {} draws", 121 * 16);
}

/// Smaller tiles when asked for less memory; the resolution, and with it the result, stays.
#[test]
fn the_memory_of_tiles_is_bounded() {
    let mut stage = Stage::new(one_map(Warp::Uniform, ShadowFilter::Hard));
    let expected = stage.virtual_result(ShadowMaps::Tiled(tiled(2, 1024)));
    assert_eq!(
        stage.report().texture_bytes,
        16 * (4 << 20),
        "sixteen textures of 4 MiB"
    );
    let found = stage.virtual_result(ShadowMaps::Tiled(TiledMaps {
        memory: 1,
        ..tiled(2, 1024)
    }));
    let report = stage.report();
    assert_eq!((report.tiles.len(), report.texture_bytes), (16, 1 << 20));
    assert_eq!(report.effective_resolution(), 2048);
    assert_eq!(differing(&found, &expected), 0, "pixels differ");
}

#[test]
fn maps_grow_while_the_camera_rests() {
    let mut stage = Stage::new(one_map(Warp::Uniform, ShadowFilter::Hard));
    stage.virtual_result(ShadowMaps::Tiled(TiledMaps {
        progressive: true,
        ..tiled(4, 64)
    }));
    stage.harness.frames(4);
    assert_eq!(stage.report().tiles.len(), 16, "all tiles at rest");
    let camera = stage.harness.camera;
    let mut counts = Vec::new();
    for frame in 0..4 {
        if frame == 0 {
            let mut transform = stage
                .harness
                .app
                .world_mut()
                .get_mut::<Transform>(camera)
                .expect("a camera");
            transform.translation.x += 0.5;
        }
        stage.harness.frames(1);
        counts.push(stage.report().tiles.len());
    }
    assert_eq!(counts, [1, 4, 16, 16]);
}

/// Oracle 9: what the GPU counts is what a comparison of results finds. The changes of one level are those between the
/// map without it and with it.
#[test]
fn counts_are_the_pixels_that_changed() {
    let mut stage = Stage::new(one_map(Warp::Lispsm, ShadowFilter::Hard));
    let mut before = vec![1.0; (PICTURE.x * PICTURE.y) as usize];
    // The light view depends on the finest resolution, so all have the same; thresholds end the refinement.
    for (count, min, force_first_split) in [(1, 1e9, false), (2, 1e9, true), (4, 0.0, true)] {
        let (result, report) = stage.queried_result(QueriedMap {
            force_first_split,
            ..queried(min, 4)
        });
        assert!(report.tiles.iter().all(|tile| tile.draw.tile.counts.x <= count));
        let level = report.tiles.iter().filter(|tile| tile.draw.tile.counts.x == count);
        let (mut changed, mut inside) = (0, 0);
        for tile in level {
            let counted = tile.report.expect("every tile is counted");
            assert!(counted.changed <= counted.inside);
            assert!(u64::from(counted.inside) <= counted.rect.pixels());
            changed += counted.changed as usize;
            inside += counted.inside as usize;
        }
        assert_eq!(changed, differing(&result, &before), "level of {count} tiles per axis");
        assert!(changed > 10, "the level of {count} tiles per axis changes nothing");
        assert!(inside > 2000, "{inside} pixels in the map");
        before = result;
    }
}

/// The tiles of a larger threshold are among those of a smaller, and at 0 the picture is that of the tiled map to the eye.
#[test]
fn larger_thresholds_draw_less() {
    let mut stage = Stage::new(one_map(Warp::Lispsm, ShadowFilter::Hard));
    let tiled_result = stage.virtual_result(ShadowMaps::Tiled(tiled(8, 256)));
    let tiled_texels = stage.report().texels();
    let mut last: Option<VirtualMapReport> = None;
    for min in [0.0, 5.0, 20.0, 80.0, 1e6] {
        let (result, report) = stage.queried_result(queried(min, 8));
        assert_eq!(report.tiles.len() as u32, 1 + 4 * report.splits, "min {min}");
        assert_eq!(report.jumps, 0);
        if min == 0.0 {
            let wrong = differing(&result, &tiled_result);
            assert!(wrong * 100 < result.len(), "{wrong} pixels differ from the tiled map");
            assert!(
                report.texels() < tiled_texels,
                "{} texels, tiled {tiled_texels}",
                report.texels()
            );
        }
        if let Some(last) = &last {
            let mut tiles = report.tiles.iter().map(|tile| tile.draw.tile);
            assert!(
                tiles.all(|tile| last.tiles.iter().any(|other| other.draw.tile == tile)),
                "min {min}: a tile that a smaller threshold does not draw"
            );
            assert!(report.tiles.len() <= last.tiles.len());
        }
        last = Some(report);
    }
    assert_eq!(
        last.map(|report| report.tiles.len()),
        Some(1),
        "nothing changes so much"
    );
}

/// A jump takes the place of the last splits: as fine, and final.
#[test]
fn jumps_reach_the_same_resolution() {
    let mut stage = Stage::new(one_map(Warp::Lispsm, ShadowFilter::Hard));
    let (split, split_report) = stage.queried_result(queried(0.0, 4));
    let (jumped, report) = stage.queried_result(QueriedMap {
        tile_size_max: 512,
        maximum_jump: true,
        ..queried(0.0, 4)
    });
    assert!(report.jumps > 0, "no jump");
    assert_eq!(report.tiles.len() as u32, 1 + 4 * report.splits + report.jumps);
    let jumps = report.tiles.iter().filter(|tile| tile.decision.is_none());
    assert!(
        jumps
            .clone()
            .all(|tile| tile.draw.window.size == UVec2::splat(512) && tile.draw.tile.counts.x == 2)
    );
    let jumping = report
        .tiles
        .iter()
        .filter(|tile| tile.decision == Some(Decision::MaximumJump));
    assert_eq!(jumping.count(), jumps.count(), "each jump was decided");
    assert_eq!(report.effective_resolution(), split_report.effective_resolution());
    let wrong = differing(&split, &jumped);
    assert!(wrong * 200 < split.len(), "{wrong} pixels differ");
}

/// The overlay gives every surface in the map the color of its tile's resolution.
#[test]
fn the_overlay_shows_tiles() {
    let mut stage = Stage::new(one_map(Warp::Lispsm, ShadowFilter::Hard));
    stage.queried_result(queried(5.0, 8));
    let camera = stage.harness.camera;
    stage
        .harness
        .app
        .world_mut()
        .entity_mut(camera)
        .insert(TileOverlay { opacity: 1.0 });
    stage.harness.frames(3);
    let picture = capture::read_image(&stage.harness.app, &stage.harness.target).expect("the picture can be read");
    let mut pixels = [0_usize; 7];
    for pixel in picture.bytes.chunks_exact(4) {
        for (level, count) in (0..).zip(&mut pixels) {
            let color = Srgba::from(tile_color(level)).to_u8_array();
            *count += usize::from(color.iter().zip(pixel).take(3).all(|(a, b)| a.abs_diff(*b) <= 2));
        }
    }
    // Levels of 1, 2, 4 and 8 tiles per axis; the coarsest is overwritten at least in part.
    let finer: usize = pixels[1..4].iter().sum();
    assert!(finer > 3000, "{pixels:?} pixels by level");
    assert!(pixels[3] > 100, "{pixels:?}: the finest level");
    assert_eq!(pixels[4], 0, "{pixels:?}: no tile is so fine");
}

/// Nothing of a virtual map is left after a change back.
#[test]
fn cameras_return_to_partitions() {
    let mut stage = Stage::new(one_map(Warp::Lispsm, ShadowFilter::Pcf2));
    let before = stage.harness.shadow_result(stage.harness.camera);
    stage.virtual_result(ShadowMaps::Tiled(tiled(2, 64)));
    let after = stage.result(one_map(Warp::Lispsm, ShadowFilter::Pcf2));
    assert_eq!(differing(&before, &after), 0);
    let reports = stage.harness.app.world().resource::<VirtualMapReports>();
    assert_eq!(reports.get(stage.harness.camera), None);
}

/// Software drivers compile a shader for every value of a uniform that decides a branch, and keep them all: a frame of many
/// tiles took gigabytes. Each compiled one has mappings of memory of its own.
#[cfg(target_os = "linux")]
#[test]
fn tiles_compile_no_shaders() {
    let mappings = || std::fs::read_to_string("/proc/self/maps").map_or(0, |maps| maps.lines().count());
    let mut stage = Stage::new(SunShadows {
        maps: ShadowMaps::Tiled(tiled(16, 64)),
        ..one_map(Warp::Lispsm, ShadowFilter::Pcf2)
    });
    stage.harness.frames(2);
    let before = mappings();
    stage.harness.frames(2);
    assert_eq!(stage.report().tiles.len(), 256);
    let more = mappings().saturating_sub(before);
    assert!(before > 0 && more < 100, "{more} mappings of memory in two frames");
}
