//! Tiles, crops, margins, tiled maps: oracles 1, 3 to 6 and 34 of Giegl.

use bevy_math::{DMat4, DVec2, DVec3, UVec2};
use proptest::prelude::*;
use umbrage::maths::{
    cull::receivers_in_map,
    polytope::Polytope,
    virtual_map::{
        picture::{PixelRect, view_from_picture},
        tile::{Tile, TileWindow, filter_margin, map_uv},
        tiled::TiledMap,
    },
    warp::Warp,
};

use super::scene::Numbers;
use crate::{
    properties::{direction, light_for, seen},
    support::{bodies, fit, papers_camera, roomy_scene},
};

/// Oracle 1: both forms of equation 3.1, and the printed signs.
#[test]
fn unprojection_inverts_projection() {
    let mut numbers = Numbers(1);
    let mut random = |low: f64, high: f64| low + (high - low) * numbers.unit();
    let (mut worst, mut worst_single, mut worst_printed) = (0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..10_000 {
        let scale = DVec2::new(random(0.5, 3.0), random(0.5, 3.0));
        let offset = DVec2::new(random(-0.3, 0.3), random(-0.3, 0.3));
        let depth = random(0.1, 1000.0);
        let point = DVec3::new(random(-5.0, 5.0), random(-5.0, 5.0), -depth);
        // Right-handed: w = −z, offsets in the third column.
        let place = (scale * point.truncate() + offset * point.z) / depth;
        let uv = DVec2::new(0.5 + 0.5 * place.x, 0.5 - 0.5 * place.y);
        worst = worst.max(view_from_picture(uv, depth, scale, offset).distance(point) / depth);
        // Coordinates in single precision; their rounding counts d ÷ a times, against the point's own size.
        let single = view_from_picture(uv.as_vec2().as_dvec2(), f64::from(depth as f32), scale, offset);
        worst_single = worst_single.max(single.distance(point) / point.length() / (1.0 + uv.length()));
        // Left-handed, w = z: the same with the other sign of b.
        let place = (scale * point.truncate() + offset * depth) / depth;
        let uv = DVec2::new(0.5 + 0.5 * place.x, 0.5 - 0.5 * place.y);
        worst = worst.max(view_from_picture(uv, depth, scale, -offset).distance(point) / depth);
        // As printed: rows (2 0 1), (0 2 −1).
        let printed = depth * ((2.0 * uv.x + 1.0) - offset.x) / scale.x;
        worst_printed = worst_printed.max((printed - point.x).abs() / depth);
    }
    assert!(worst < 1.0e-14, "{worst}");
    assert!(worst_single < 1.0e-5, "{worst_single}");
    assert!(worst_printed > 0.5, "the printed form must fail: {worst_printed}");
}

/// Oracle 3: the crop's coordinates, and one tile for each place, borders too.
#[test]
fn crops_have_the_tiles_coordinates() {
    let mut numbers = Numbers(2);
    for counts in [UVec2::ONE, UVec2::new(4, 2), UVec2::new(3, 5), UVec2::splat(32)] {
        let tiles: Vec<Tile> = Tile::WHOLE.children(counts).collect();
        assert_eq!(tiles.len() as u32, counts.element_product());
        for step in 0..500 {
            let uv = match step {
                0..=32 => DVec2::splat(f64::from(step) / 32.0),
                _ => DVec2::new(numbers.unit(), numbers.unit()),
            };
            let tile = Tile::at(counts, uv).unwrap();
            assert_eq!(tiles.iter().filter(|tile| tile.contains(uv)).count(), 1, "{uv}");
            assert!(tile.contains(uv));
            let window = TileWindow::of_size(UVec2::splat(512), 0);
            // With any w: crops come before the division.
            let w = 0.5 + 3.0 * numbers.unit();
            let clip = DVec3::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.25).extend(1.0) * w;
            let cropped = tile.clip_from_map_clip(&window) * clip;
            assert_eq!((cropped.z, cropped.w), (clip.z, clip.w));
            let local = DVec2::new(0.5 + 0.5 * cropped.x / w, 0.5 - 0.5 * cropped.y / w);
            let expected = uv * counts.as_dvec2() - tile.place.as_dvec2();
            assert!(local.distance(expected) < 1.0e-6 && tile.tile_uv(uv).distance(expected) < 1.0e-12);
            assert!(tile.texture_uv(&window, uv).distance(expected) < 1.0e-12);
        }
    }
    for outside in [DVec2::new(-1.0e-12, 0.5), DVec2::new(0.5, 1.000_001), DVec2::NAN] {
        assert_eq!(Tile::at(UVec2::splat(4), outside), None, "{outside}");
    }
    assert_eq!(Tile::at(UVec2::new(0, 4), DVec2::ZERO), None);
}

/// Tiles share their sides exactly: no gap, no overlap, in any grid.
#[test]
fn tiles_fill_the_map() {
    for n in [1, 2, 3, 7, 32] {
        let counts = UVec2::new(n, 2 * n);
        let mut area = 0.0;
        for tile in Tile::WHOLE.children(counts) {
            let [min, max] = tile.map_rect();
            area += (max - min).element_product();
            let right = Tile {
                place: tile.place + UVec2::X,
                counts,
            };
            assert_eq!(max.x, right.map_rect()[0].x);
            for (parts, count) in [(UVec2::splat(2), 4), (UVec2::new(1, 2), 2), (UVec2::splat(3), 9)] {
                let children: Vec<Tile> = tile.children(parts).collect();
                assert_eq!(children.len(), count);
                assert!(children.iter().all(|child| tile.covers(child) && !child.covers(&tile)));
                assert_eq!(children[0].map_rect()[0], tile.map_rect()[0]);
                assert!(children[count - 1].map_rect()[1].distance(tile.map_rect()[1]) < 1.0e-15);
            }
        }
        assert!((area - 1.0).abs() < 1.0e-12);
    }
    let counts = UVec2::splat(4);
    let [left, right] = [0, 1].map(|x| Tile {
        place: UVec2::new(x, 0),
        counts,
    });
    assert!(!left.covers(&right) && left.covers(&left));
}

/// Oracles 4 and 5, in single precision as the GPU has it: 4 × 4 tiles of 512 texels against one map of 2048, a plane
/// of casters at the centres of texels, for warped and unwarped light views.
#[test]
fn tiles_have_the_depths_of_one_large_map() {
    let view = papers_camera(0.5, 60.0);
    for warp in [Warp::Uniform, Warp::Lispsm] {
        let light = fit(&view, &roomy_scene(), DVec3::new(0.4, -1.0, 0.3), warp);
        let world_from_clip = light.clip_from_world.inverse();
        let mut worst = 0.0_f64;
        for (n, step) in [(4, 37), (1, 97)] {
            let size = 2048 / n;
            let window = TileWindow::of_size(UVec2::splat(size), 0);
            for y in (0..2048).step_by(step) {
                for x in (0..2048).step_by(step) {
                    let texel = UVec2::new(x, y);
                    let uv = (texel.as_dvec2() + 0.5) / 2048.0;
                    let ndc = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
                    let point = world_from_clip.project_point3(ndc.extend(0.3 + 0.4 * ndc.x));
                    let tile = Tile::at(UVec2::splat(n), uv).unwrap();
                    assert_eq!(tile.place, texel / size);
                    let tile_matrix = tile.clip_from_world(&light.clip_from_world, &window).as_mat4();
                    let [large, small] = [light.clip_from_world.as_mat4(), tile_matrix]
                        .map(|matrix| matrix.project_point3(point.as_vec3()).as_dvec3());
                    worst = worst.max((large.z - small.z).abs());
                    let place = DVec2::new(0.5 + 0.5 * small.x, 0.5 - 0.5 * small.y) * f64::from(size);
                    let centre = (texel % size).as_dvec2() + 0.5;
                    assert!(place.distance(centre) < 0.03, "{place} is not {centre}");
                    if n == 1 {
                        assert_eq!(large, small, "one tile is the map");
                    }
                }
            }
        }
        assert!(worst <= 1.0e-6, "{worst}");
    }
}

/// Row V13: all taps of a kernel anywhere in a tile lie in its texture, at the neighbours' own texels.
#[test]
fn margins_hold_the_kernel() {
    let (counts, kernel) = (UVec2::new(8, 4), 5.0);
    let margin = filter_margin(kernel);
    assert_eq!((margin, filter_margin(4.0), filter_margin(0.0)), (3, 2, 0));
    assert_eq!(
        (filter_margin(f64::NAN), filter_margin(-3.0), filter_margin(1.0e9)),
        (0, 0, 256)
    );
    for window in [
        TileWindow::of_size(UVec2::new(256, 512), margin),
        TileWindow::around(UVec2::new(250, 506), margin),
    ] {
        assert_eq!(
            (window.size, window.core()),
            (UVec2::new(256, 512), UVec2::new(250, 506))
        );
        let tile = Tile {
            place: UVec2::new(5, 2),
            counts,
        };
        let [min, max] = tile.map_rect();
        let texel = (max - min) / window.core().as_dvec2();
        for corner in [min, max, DVec2::new(min.x, max.y), (min + max) * 0.5] {
            for tap in [-0.5, 0.5] {
                let uv = corner + texel * kernel * tap;
                let texture = tile.texture_uv(&window, uv);
                assert!(
                    texture.cmpge(DVec2::ZERO).all() && texture.cmple(DVec2::ONE).all(),
                    "{texture}"
                );
                let clip = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
                let cropped = tile.clip_from_map_clip(&window) * clip.extend(0.0).extend(1.0);
                let drawn = DVec2::new(0.5 + 0.5 * cropped.x, 0.5 - 0.5 * cropped.y);
                assert!(drawn.distance(texture) < 1.0e-12, "drawn at {drawn}, read at {texture}");
            }
        }
    }
    // No room for a margin: some core is left.
    assert_eq!(
        TileWindow::of_size(UVec2::new(4, 9), 50),
        TileWindow {
            size: UVec2::new(4, 9),
            margin: 1
        }
    );
    assert_eq!(TileWindow::of_size(UVec2::ZERO, 3).core(), UVec2::ONE);
}

/// Oracle 6, and the price of brute force (section 3.6).
#[test]
fn effective_resolutions() {
    let of = |n, size| TiledMap::new(n, size, 0);
    assert_eq!(
        (of(16, 4096).effective_resolution(), of(32, 2048).effective_resolution()),
        (65_536, 65_536)
    );
    assert_eq!(of(16, 4096).texels() / of(1, 4096).texels(), 256);
    assert_eq!(of(16, 4096).texels(), 4_294_967_296);
    assert_eq!(of(16, 4096).texels() * 4, 16 << 30);
    assert_eq!(of(32, 4096).texels() * 4, 64 << 30);
    assert_eq!(of(32, 4096).effective_resolution(), 131_072);
    assert_eq!(TiledMap::new(16, 2048, 2).effective_resolution(), 16 * 2044);
    assert_eq!((of(0, 64).tiles_per_axis, of(1000, 64).tiles_per_axis), (1, 32));
    assert_eq!(of(3, 64).tiles().count(), 9);
}

#[test]
fn progress_doubles_while_the_camera_rests() {
    let steps = |n| {
        (0..8)
            .map(|frame| TiledMap::new(n, 512, 0).progressive_tiles_per_axis(frame))
            .collect::<Vec<_>>()
    };
    assert_eq!(steps(16), [1, 2, 4, 8, 16, 16, 16, 16]);
    assert_eq!(steps(12), [1, 2, 4, 8, 12, 12, 12, 12]);
    assert_eq!(steps(1), [1; 8]);
    assert_eq!(TiledMap::new(16, 512, 0).progressive_tiles_per_axis(u32::MAX), 16);
}

/// Oracle 34: places beside a tile never belong to it, so they never change the result.
#[test]
fn places_beside_a_tile_are_not_its_own() {
    let tile = Tile {
        place: UVec2::new(1, 2),
        counts: UVec2::splat(4),
    };
    let [min, max] = tile.map_rect();
    assert!(tile.contains(min) && !tile.contains(max));
    for beside in [
        min - 1.0e-12,
        max,
        max + 0.1,
        DVec2::new(min.x - 1.0, min.y),
        DVec2::splat(2.0),
        DVec2::NAN,
    ] {
        assert!(!tile.contains(beside), "{beside}");
    }
}

#[test]
fn places_in_the_map_need_a_projection() {
    let view = papers_camera(1.0, 100.0);
    let light = fit(&view, &roomy_scene(), DVec3::NEG_Y, Warp::Lispsm);
    assert_eq!(map_uv(&light.clip_from_world, DVec3::Z * 1.0e4), None);
    assert_eq!(map_uv(&light.clip_from_world, DVec3::NAN), None);
    assert_eq!(map_uv(&DMat4::ZERO, DVec3::ZERO), None);
    assert_eq!(map_uv(&DMat4::IDENTITY, DVec3::new(-1.0, 1.0, 0.0)), Some(DVec2::ZERO));
}

#[test]
fn rectangles() {
    let rect = PixelRect {
        min: UVec2::new(2, 3),
        max: UVec2::new(5, 4),
    };
    assert_eq!((rect.pixels(), PixelRect::EMPTY.pixels()), (3, 0));
    assert_eq!(rect.union(PixelRect::EMPTY), rect);
    assert!(PixelRect::EMPTY.is_empty() && !rect.is_empty());
    assert!(rect.contains(UVec2::new(4, 3)) && !rect.contains(UVec2::new(5, 3)) && !rect.contains(UVec2::new(2, 2)));
    let picture = UVec2::new(6, 6);
    assert_eq!(
        rect.grown(2, picture),
        PixelRect {
            min: UVec2::new(0, 1),
            max: UVec2::new(6, 6)
        }
    );
    assert!(PixelRect::EMPTY.grown(2, picture).is_empty());
    let apart = PixelRect {
        min: UVec2::new(5, 3),
        max: UVec2::new(6, 4),
    };
    assert!(rect.intersection(apart).is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    /// Tiles without receivers are those in which clipping H leaves nothing; none with a visible point is left out.
    #[test]
    fn tiles_with_receivers_are_those_of_the_outline((scene, view) in seen(), direction in direction(), along in 0_u8..8, warped in any::<bool>(), shares in [0.0..1.0, 0.0..1.0, 0.0..1.0]) {
        let light_travel = light_for(&view, direction, along);
        let (visible, _) = bodies(&view, &scene, light_travel);
        prop_assume!(!visible.is_empty());
        let light = fit(&view, &scene, light_travel, if warped { Warp::Lispsm } else { Warp::Uniform });
        let map = TiledMap::new(8, 64, 0);
        let drawn = map.tiles_with_receivers(&light.clip_from_world, &visible);
        let vertices = visible.vertices();
        let pick = |share: f64| vertices[((share * vertices.len() as f64) as usize).min(vertices.len() - 1)];
        let inner = (pick(shares[0]) + pick(shares[1]) + pick(shares[2])) / 3.0;
        let uv = map_uv(&light.clip_from_world, inner).unwrap();
        let tile = Tile::at(UVec2::splat(8), uv.clamp(DVec2::ZERO, DVec2::ONE)).unwrap();
        prop_assert!(drawn.contains(&tile), "{tile:?} holds the visible {inner}");
        for tile in map.tiles() {
            let is_drawn = drawn.contains(&tile);
            let left = receivers_in_map(&visible, &tile.clip_from_world(&light.clip_from_world, &map.window));
            prop_assert!(is_drawn || left.volume() < 1.0e-6, "{tile:?} is skipped with {left:?}");
            // Half a percent wider, for rounding.
            let wide = tile.clip_from_world(&light.clip_from_world, &TileWindow::of_size(UVec2::splat(400), 1));
            prop_assert!(!is_drawn || !receivers_in_map(&visible, &wide).is_empty(), "{tile:?} is drawn for nothing");
        }
    }
}

#[test]
fn tiles_beside_the_outline_are_skipped() {
    // The outline of a camera's pyramid seen from above is a triangle: half of the map is empty.
    let view = papers_camera(0.5, 60.0);
    let (visible, _) = bodies(&view, &roomy_scene(), DVec3::NEG_Y);
    let light = fit(&view, &roomy_scene(), DVec3::NEG_Y, Warp::Uniform);
    let map = TiledMap::new(32, 64, 0);
    let drawn = map.tiles_with_receivers(&light.clip_from_world, &visible).len();
    assert!((512..620).contains(&drawn), "{drawn} of 1024");
    assert!(
        map.tiles_with_receivers(&light.clip_from_world, &Polytope::default())
            .is_empty()
    );
    // Behind the projection centre nothing is left out.
    assert_eq!(map.tiles_with_receivers(&-light.clip_from_world, &visible).len(), 1024);
}
