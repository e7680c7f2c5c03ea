//! What the GPU measures for fitted maps, against the CPU twins.

use bevy::{
    camera::Camera3dDepthTextureUsage,
    math::DVec2,
    prelude::*,
    render::{RenderApp, render_resource::TextureUsages, sync_world::RenderEntity, view::ViewDepthTexture},
};
use umbrage::{
    maths::virtual_map::{
        grid::NeedCell,
        mapping::{
            MappingOptions, NeedMeasure, NeighbourPick, PixelPatch, TileMappingMap, need_level, pixel_need, pixel_patch,
        },
        picture::{DepthPicture, PixelRect},
        tile::Tile,
    },
    maths::warp::Warp,
    prelude::*,
    render::{
        capture,
        virtual_map::fitted::{
            cells::{self, need_cells, words},
            measure::NeedBuffers,
            plan::{FittedFrame, FittedFrames},
        },
    },
    shadow::{
        fitted::{FittedMaps, NeedMapping},
        virtual_maps::ShadowMaps,
    },
};

use crate::harness::{Harness, eye};

const SIZE: UVec2 = UVec2::new(160, 90);
const LIGHT: Vec3 = Vec3::new(-0.7, -0.45, -0.3);

/// Ground, boxes near and far, and a board that the light grazes, under a fitted map.
pub(crate) fn scene(warp: Warp, fitted: FittedMaps) -> Harness {
    let mut harness = Harness::new(SIZE, eye());
    let material = harness.material(Color::srgb(0.6, 0.6, 0.6));
    let plane = harness.mesh(Plane3d::default().mesh().size(120.0, 120.0));
    let cuboid = harness.mesh(Cuboid::new(2.0, 2.0, 2.0));
    let world = harness.app.world_mut();
    world.spawn((Mesh3d(plane), MeshMaterial3d(material.clone())));
    for (x, z) in [(-2.0, 0.0), (4.0, -8.0), (-6.0, -25.0), (9.0, -40.0)] {
        world.spawn((
            Mesh3d(cuboid.clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_xyz(x, 1.0, z),
        ));
    }
    let board = Transform::from_xyz(2.5, 1.5, 3.0).looking_to(LIGHT + Vec3::X * 0.02, Vec3::Y);
    world.spawn((
        Mesh3d(cuboid),
        MeshMaterial3d(material),
        board.with_scale(Vec3::new(0.02, 0.7, 0.7)),
    ));
    let mut settings = SunShadows {
        maps: ShadowMaps::Fitted(fitted),
        warp,
        ..default()
    };
    settings.partitions.count = 1;
    harness.sun(LIGHT, settings);
    let mut camera = harness.app.world_mut().entity_mut(harness.camera);
    if let Some(mut camera) = camera.get_mut::<Camera3d>() {
        let usages = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        camera.depth_texture_usages = Camera3dDepthTextureUsage::from(usages);
    }
    harness.start();
    harness
}

/// The tiles of the last frame, of its first z-partition.
pub(crate) fn planned(harness: &Harness) -> FittedFrame {
    planned_partitions(harness).swap_remove(0)
}

/// The tiles of the last frame by z-partition.
pub(crate) fn planned_partitions(harness: &Harness) -> Vec<FittedFrame> {
    let entity = harness.app.world().get::<RenderEntity>(harness.camera);
    let entity = entity.expect("the camera is drawn").id();
    let frames = harness.app.sub_app(RenderApp).world().get::<FittedFrames>(entity);
    frames.expect("the frame is planned").0.clone()
}

/// The frame's tiles, the depths that they were planned from, and the words of the buffers.
fn measured(harness: &Harness) -> (FittedFrame, Vec<f32>, Vec<Vec<u32>>) {
    let depths = harness.camera_texture::<ViewDepthTexture>(harness.camera, |depth| &depth.texture);
    let entity = harness
        .app
        .world()
        .get::<RenderEntity>(harness.camera)
        .expect("it is drawn")
        .id();
    let render_world = harness.app.sub_app(RenderApp).world();
    let frame = planned(harness);
    let buffers = render_world.get::<NeedBuffers>(entity).expect("needs were measured");
    let contents = buffers.outputs().into_iter().map(|buffer| {
        let bytes = capture::read_buffer(render_world, &buffer).expect("the buffer can be read");
        words(&bytes)
    });
    let contents = contents.collect();
    (frame, depths.to_f32(), contents)
}

/// What a cell may hold at least and at most when places and needs are rounded as single precision rounds them.
struct Bounds {
    least: Vec<NeedCell>,
    most: Vec<NeedCell>,
}

/// Relative error of a need in single precision. Depths are the same numbers on both sides and their differences exact, so a
/// step over the map is off by a few roundings (2^-24) of terms that are some times larger than their sum. The inverse of two
/// steps loses what they lose, times their product over the area between them: patches that the light grazes lose more.
fn need_error(patch: &PixelPatch) -> f64 {
    let [right, down] = patch.steps;
    5.0e-5 * (right.length() * down.length() / patch.facing().abs())
}

/// Error of a place: rounding of world positions (120 m, 2^-24) and of two matrices, and the border that counts in both
/// cells.
const PLACE_ERROR: f64 = 4.0e-6;

fn bounds(picture: &DepthPicture, frame: &FittedFrame, n: u32, options: &MappingOptions) -> Bounds {
    let light = frame.request.light_view.clip_from_world.as_dmat4();
    let mut bounds = Bounds {
        least: vec![NeedCell::EMPTY; (n * n) as usize],
        most: vec![NeedCell::EMPTY; (n * n) as usize],
    };
    for y in 0..SIZE.y {
        for x in 0..SIZE.x {
            let pixel = UVec2::new(x, y);
            let (Some(patch), Some(need)) = (
                pixel_patch(picture, &light, pixel, options),
                pixel_need(picture, &light, pixel, options),
            ) else {
                continue;
            };
            let cell = |error: f64| {
                let place = (patch.uv + error).clamp(DVec2::ZERO, DVec2::ONE) * f64::from(n);
                place.as_uvec2().min(UVec2::splat(n - 1))
            };
            let is_inside = |slack: f64| (patch.uv - 0.5).abs().max_element() <= 0.5 + slack;
            let (first, last) = (cell(-PLACE_ERROR), cell(PLACE_ERROR));
            let seen = |factor: f64| NeedCell {
                levels: [need.x, need.y].map(|need| need_level(need * factor, 0.0)),
                pixels: 1,
                rect: PixelRect {
                    min: pixel,
                    max: pixel + 1,
                },
            };
            for y in first.y..=last.y {
                for x in first.x..=last.x {
                    let most = &mut bounds.most[(y * n + x) as usize];
                    if is_inside(PLACE_ERROR) {
                        *most = most.merged(seen(1.0 + need_error(&patch)));
                    }
                }
            }
            if first == last && is_inside(-PLACE_ERROR) {
                let least = &mut bounds.least[(first.y * n + first.x) as usize];
                *least = least.merged(seen(1.0 - need_error(&patch)));
            }
        }
    }
    bounds
}

#[test]
fn cells_hold_what_the_cpu_finds() {
    let coarse = FittedMaps {
        tiles_per_axis: 8,
        ..default()
    };
    let finer = FittedMaps {
        quality_drop: -2,
        measure: NeedMeasure::Extent,
        pick: NeighbourPick::Larger,
        ..coarse
    };
    for (technique, warp, fitted) in [
        ("uniform", Warp::Uniform, coarse),
        ("warped", Warp::Lispsm, FittedMaps::default()),
        ("finer", Warp::Lispsm, finer),
    ] {
        let harness = scene(warp, fitted);
        let (frame, depths, contents) = measured(&harness);
        let request = &frame.request;
        let world_from_clip = request.camera.world_from_clip();
        let picture = DepthPicture::new(SIZE, &depths, world_from_clip).expect("a picture");
        let n = request.map.grid_tiles_per_axis();
        let cells = need_cells(&contents[0]);
        assert_eq!(cells.len(), (n * n) as usize, "{technique}");
        let bounds = bounds(&picture, &frame, n, &request.settings.mapping_options());
        let (mut filled, mut wrong) = (0, Vec::new());
        for (index, cell) in cells.iter().enumerate() {
            let (least, most) = (&bounds.least[index], &bounds.most[index]);
            let is_between = (0..2).all(|axis| (least.levels[axis]..=most.levels[axis]).contains(&cell.levels[axis]))
                && (least.pixels..=most.pixels).contains(&cell.pixels)
                && least.rect.union(cell.rect) == cell.rect
                && cell.rect.union(most.rect) == most.rect;
            if !is_between {
                wrong.push(format!("cell {index}: {cell:?} is not between {least:?} and {most:?}"));
            }
            filled += usize::from(cell.pixels > 0);
        }
        assert!(
            wrong.is_empty(),
            "{technique}: {} cells, {:#?}",
            wrong.len(),
            &wrong[..wrong.len().min(4)]
        );
        let pixels: u32 = bounds.least.iter().map(|cell| cell.pixels).sum();
        println!("{technique}: {filled} of {} cells with {pixels} pixels", cells.len());
        assert!(
            filled > 12 && pixels > 5_000,
            "{technique}: {filled} cells, {pixels} pixels"
        );
        let totals = cells::totals(&contents[1]);
        let seen = depths.iter().filter(|depth| **depth > 0.0).count() as u64;
        // All but those at the far end of the shadows.
        let counted = totals.pixels() + u64::from(totals.outside);
        assert!(
            (seen * 98 / 100..=seen).contains(&counted),
            "{technique}: {counted} of {seen} pixels count"
        );
        assert!(
            u64::from(totals.outside) * 100 < seen,
            "{technique}: {} beside the map",
            totals.outside
        );
    }
}

/// Oracles 20 and 23 of Giegl on a real frame: every pixel that looks into the map lies in one tile, and in its rectangle,
/// and the tile is as fine as the pixel needs it.
#[test]
fn every_pixel_has_a_tile_that_is_fine_enough() {
    let harness = scene(Warp::Lispsm, FittedMaps::default());
    let (frame, depths, _) = measured(&harness);
    let request = &frame.request;
    let picture = DepthPicture::new(SIZE, &depths, request.camera.world_from_clip()).expect("a picture");
    let light = request.light_view.clip_from_world.as_dmat4();
    let options = request.settings.mapping_options();
    let (mut checked, mut capped) = (0, 0);
    for index in 0..SIZE.x * SIZE.y {
        let pixel = UVec2::new(index % SIZE.x, index / SIZE.x);
        let (Some(patch), Some(need)) = (
            pixel_patch(&picture, &light, pixel, &options),
            pixel_need(&picture, &light, pixel, &options),
        ) else {
            continue;
        };
        // Places that rounding may put into another tile, or beside the map.
        let is_clear = |tile: &Tile| {
            let place = tile.tile_uv(patch.uv);
            let slack = PLACE_ERROR * tile.counts.as_dvec2();
            place.cmpgt(slack).all() && place.cmplt(1.0 - slack).all()
        };
        let mut tiles = frame.plan.tiles.iter().filter(|tile| tile.tile.contains(patch.uv));
        let Some(tile) = tiles.next() else {
            let is_inside = (patch.uv - 0.5).abs().max_element() < 0.5 - PLACE_ERROR;
            let is_far =
                depths[index as usize] * 0.98 < request.camera.clip_from_view.w_axis.z as f32 / request.depths[1];
            assert!(!is_inside || is_far, "{pixel} at {} has no tile", patch.uv);
            continue;
        };
        assert!(tiles.next().is_none(), "{pixel} has two tiles");
        if !is_clear(&tile.tile) {
            continue;
        }
        assert!(tile.rect.contains(pixel), "{pixel} is not in the rectangle of {tile:?}");
        let texels = tile.effective_resolution();
        for axis in 0..2 {
            let is_capped = need[axis] > f64::from(frame.plan.cap).exp2();
            capped += usize::from(is_capped);
            assert!(
                is_capped || texels[axis] as f64 >= need[axis] * (1.0 - need_error(&patch)),
                "{pixel} needs {need}, {tile:?} has {texels:?}"
            );
        }
        checked += 1;
    }
    println!("{checked} pixels, {capped} capped, {} tiles", frame.plan.tiles.len());
    assert!(
        checked > 5_000 && capped * 20 < checked,
        "{checked} pixels, {capped} capped"
    );
}

#[test]
fn histograms_count_the_pixels_of_a_cell() {
    let fitted = FittedMaps {
        tiles_per_axis: 8,
        discard: 0.01,
        ..default()
    };
    let harness = scene(Warp::Lispsm, fitted);
    let (frame, _, contents) = measured(&harness);
    let cells = need_cells(&contents[0]);
    let histograms = cells::histograms(&contents[2]);
    assert_eq!(histograms.len(), cells.len());
    for (index, (cell, histogram)) in cells.iter().zip(&histograms).enumerate() {
        for axis in 0..2 {
            let sum: u32 = histogram[axis].iter().sum();
            let highest = histogram[axis].iter().rposition(|pixels| *pixels > 0).unwrap_or(0);
            assert_eq!(
                (sum, highest),
                (cell.pixels, usize::from(cell.levels[axis])),
                "cell {index}, axis {axis}"
            );
        }
    }
    let counts = frame.counts;
    assert!(
        counts.discarded > 0 && counts.discarded * 50 <= counts.pixels,
        "{counts:?}: at most 1 % per axis"
    );
}

/// Texels of a mapping map that differ from the CPU's: found or not, place, level by level (at most one).
fn compare_maps(technique: &str, warp: Warp, fitted: FittedMaps) {
    let harness = scene(warp, fitted);
    let (frame, depths, contents) = measured(&harness);
    let request = &frame.request;
    let picture = DepthPicture::new(SIZE, &depths, request.camera.world_from_clip()).expect("a picture");
    let light = request.light_view.clip_from_world.as_dmat4();
    let measurement = request.measurement();
    let options = request.settings.mapping_options();
    let expected = TileMappingMap::new(&picture, &light, measurement.map_size, &options);
    let found = if options.bytes {
        cells::byte_mapping_map(&contents[0], measurement.map_size, SIZE)
    } else {
        cells::mapping_map(&contents[0], measurement.map_size, SIZE)
    };
    assert_eq!(found.texels.len(), expected.texels.len(), "{technique}");
    let (mut compared, mut rounded) = (0, 0);
    for (index, (found, expected)) in found.texels.iter().zip(&expected.texels).enumerate() {
        let (Some(found), Some(expected)) = (found, expected) else {
            // Texels on the very border of the map may be inside or outside.
            assert_eq!(found.is_some(), expected.is_some(), "{technique}, texel {index}");
            continue;
        };
        // A byte is 1/256 of the map.
        let place_error = if options.bytes {
            1.01 / 256.0
        } else {
            PLACE_ERROR as f32
        };
        assert!(
            (found.uv - expected.uv).abs().max_element() <= place_error,
            "{technique}, texel {index}: {found:?}, {expected:?}"
        );
        let apart = (0..2)
            .map(|axis| found.levels[axis].abs_diff(expected.levels[axis]))
            .max();
        assert!(apart <= Some(1), "{technique}, texel {index}: {found:?}, {expected:?}");
        let reach = (found.reach - expected.reach).abs() - expected.reach * 1.0e-4;
        assert!(
            reach.max_element() <= 1.0e-6,
            "{technique}, texel {index}: {found:?}, {expected:?}"
        );
        compared += 1;
        rounded += usize::from(apart == Some(1));
    }
    println!("{technique}: {rounded} of {compared} texels are rounded to the other level");
    assert!(compared > 500, "{technique}: {compared}");
    // Needs that lie so near to a whole level that rounding decides are few.
    assert!(rounded * 50 < compared, "{technique}: {rounded} of {compared}");
}

#[test]
fn mapping_maps_are_those_of_the_cpu() {
    let low = |bytes, measure| FittedMaps {
        mapping: NeedMapping::Low { size: 64, bytes },
        measure,
        ..default()
    };
    compare_maps("numbers", Warp::Lispsm, low(false, NeedMeasure::Sides));
    let larger = FittedMaps {
        pick: NeighbourPick::Larger,
        ..low(false, NeedMeasure::Box)
    };
    compare_maps("larger", Warp::Uniform, larger);
    compare_maps("bytes", Warp::Lispsm, low(true, NeedMeasure::Box));
}
