//! Patches, needs and their encodings: oracles 14 to 18 of Giegl, and the findings about the listing.

use bevy_math::{DMat3, DMat4, DVec2, DVec3, UVec2};
use umbrage::maths::{
    bounds::Bounds,
    polytope::HalfSpace,
    view::ViewVolume,
    virtual_map::{
        bytes::{byte_level, byte_need, byte_place, place_of_byte, stored_byte},
        mapping::{
            MappingOptions, NeedMeasure, NeighbourPick, TileMappingMap, need_level, picked_slope, pixel_need,
            pixel_patch,
        },
        picture::DepthPicture,
    },
};

use super::scene::{Numbers, Picture};
use crate::support::{close, papers_camera};

const SIDE: u32 = 1024;

/// A parallel light view of `width` metres around the origin, x and y of the map along two axes of the world.
fn light(width: f64, x: DVec3, y: DVec3) -> DMat4 {
    let towards_light = x.cross(y);
    let clip_from_light =
        DMat4::from_translation(DVec3::Z * 0.5) * DMat4::from_scale(DVec3::new(2.0 / width, 2.0 / width, 0.5 / width));
    clip_from_light * DMat4::from_mat3(DMat3::from_cols(x, y, towards_light).transpose())
}

/// log2 of the needs at the middle pixel of a picture of 1024² whose view depth is a formula of the column.
fn middle_levels(depth_of_column: impl Fn(u32) -> f64, light: &DMat4, column: u32, options: &MappingOptions) -> DVec2 {
    let near = 0.1;
    let clip_from_world = DMat4::perspective_infinite_reverse_rh(60.0_f64.to_radians(), 1.0, near);
    let depths: Vec<f32> = (0..SIDE * SIDE)
        .map(|index| (near / depth_of_column(index % SIDE)) as f32)
        .collect();
    let picture = DepthPicture::new(UVec2::splat(SIDE), &depths, clip_from_world.inverse()).expect("a picture");
    let need = pixel_need(&picture, light, UVec2::new(column, SIDE / 2), options).expect("geometry");
    DVec2::new(need.x.log2(), need.y.log2())
}

fn options(measure: NeedMeasure, pick: NeighbourPick) -> MappingOptions {
    MappingOptions {
        measure,
        pick,
        ..MappingOptions::default()
    }
}

/// Oracle 14: a receiver that faces the camera and the light.
#[test]
fn facing_receivers() {
    let light = light(400.0, DVec3::X, DVec3::Y);
    for measure in [NeedMeasure::Sides, NeedMeasure::Extent, NeedMeasure::Box] {
        for (depth, expected) in [(10.0, 15.11), (20.0, 14.11), (40.0, 13.11)] {
            let levels = middle_levels(|_| depth, &light, SIDE / 2, &options(measure, NeighbourPick::Smaller));
            assert!(
                (levels - expected).abs().max_element() < 0.01,
                "{measure:?} {depth}: {levels}"
            );
        }
    }
    let exact = 400.0 * 1024.0 / (20.0 * 30.0_f64.to_radians().tan());
    close(exact, 35_472.4, 1.0e-6);
    let levels = middle_levels(|_| 10.0, &light, SIDE / 2, &MappingOptions::default());
    close(levels.x.exp2(), exact, 1.0e-4);
}

/// Oracle 15: light turned by 60° about the v axis needs one level more on u and none on v.
#[test]
fn projection_aliasing_is_one_axis() {
    let turned = DVec3::new(0.5, 0.0, -(0.75_f64.sqrt()));
    let [front, oblique] = [DVec3::X, turned].map(|x| light(400.0, x, DVec3::Y));
    for measure in [NeedMeasure::Sides, NeedMeasure::Box] {
        let options = options(measure, NeighbourPick::Smaller);
        let [front, oblique] = [&front, &oblique].map(|light| middle_levels(|_| 10.0, light, SIDE / 2, &options));
        let more = oblique - front;
        assert!(
            (more.x - 1.0).abs() < 0.02 && more.y.abs() < 0.02,
            "{measure:?}: {more}"
        );
    }
}

/// Row F5 and reconstruction 8, by the listing: beside a silhouette (10 m before 50 m) the smaller difference is right,
/// the larger one is 1.3 levels low; with light across the view 12 levels and more.
#[test]
fn picks_at_a_silhouette() {
    let step = |column| if column < SIDE / 2 { 10.0 } else { 50.0 };
    let front = light(400.0, DVec3::X, DVec3::Y);
    let column = SIDE / 2 - 1;
    let levels = |pick, light: &DMat4| middle_levels(step, light, column, &options(NeedMeasure::Box, pick)).x;
    assert!((levels(NeighbourPick::Smaller, &front) - 15.11).abs() < 0.01);
    let larger = levels(NeighbourPick::Larger, &front);
    assert!((larger - 13.79).abs() < 0.01, "{larger}");
    // u along the view, light along x.
    let across = light(400.0, DVec3::Z, DVec3::Y);
    assert!(levels(NeighbourPick::Smaller, &across) > 28.0);
    let larger = levels(NeighbourPick::Larger, &across);
    assert!((larger - 3.32).abs() < 0.02, "{larger}");
    // The Jacobian at the pixel itself does not extrapolate behind the eye; it depends on the pick too.
    let smaller = middle_levels(
        step,
        &front,
        column,
        &options(NeedMeasure::Sides, NeighbourPick::Smaller),
    );
    assert!((smaller - 15.114).abs().max_element() < 0.01, "{smaller}");
}

#[test]
fn picks_are_signed() {
    use NeighbourPick::{Larger, Smaller};
    assert_eq!(picked_slope(10.0, Some(9.0), Some(13.0), Smaller), 1.0);
    assert_eq!(picked_slope(10.0, Some(9.0), Some(13.0), Larger), 3.0);
    assert_eq!(picked_slope(10.0, Some(14.0), Some(9.5), Smaller), -0.5);
    assert_eq!(picked_slope(10.0, Some(14.0), Some(9.5), Larger), -4.0);
    // Reconstruction 23: at the border the inner neighbour counts, not the pixel itself.
    assert_eq!(picked_slope(10.0, None, Some(13.0), Smaller), 3.0);
    assert_eq!(picked_slope(10.0, Some(9.0), None, Larger), 1.0);
    assert_eq!(picked_slope(10.0, None, None, Smaller), 0.0);
}

/// The ground of the specification's table: camera 2 m above it, 60°, 1024².
fn ground(elevation: f64, azimuth: f64) -> (ViewVolume, DMat4, HalfSpace) {
    let view = papers_camera(0.1, 2000.0);
    let (elevation, azimuth) = (elevation.to_radians(), azimuth.to_radians());
    let travel = DVec3::new(
        -elevation.cos() * azimuth.sin(),
        -elevation.sin(),
        elevation.cos() * azimuth.cos(),
    );
    let x = DVec3::Y.cross(-travel).normalize();
    let light = light(400.0, x, (-travel).cross(x));
    (
        view,
        light,
        HalfSpace {
            normal: DVec3::Y,
            distance: -2.0,
        },
    )
}

/// The listing on the ground plane, light along an axis of the map: within 0.03 levels of the exact box of a pixel
/// above (smaller), within 0.04 below (larger). Turned by 30° it is up to a level high; it asks for half a diamond.
#[test]
fn the_listing_on_the_ground() {
    for elevation in [20.0, 45.0, 80.0] {
        for (azimuth, low, high) in [(0.0, -0.04, 0.04), (90.0, -0.04, 0.04), (30.0, -0.05, 1.0)] {
            let (view, light, ground) = ground(elevation, azimuth);
            let world_from_clip = super::scene::camera_clip_from_world(&view).inverse();
            for row in [563_u32, 717, 973] {
                let corner = |x: f64, y: f64| {
                    let place = (DVec2::new(512.5 + x, f64::from(row) + 0.5 + y)) / 1024.0;
                    let place = DVec2::new(2.0 * place.x - 1.0, 1.0 - 2.0 * place.y);
                    let [start, end] = [1.0, 0.5].map(|depth| world_from_clip.project_point3(place.extend(depth)));
                    let share = -ground.excess(start) / (end - start).dot(ground.normal);
                    light.project_point3(start + (end - start) * share).truncate() * 0.5
                };
                let corners = [
                    corner(-0.5, -0.5),
                    corner(0.5, -0.5),
                    corner(-0.5, 0.5),
                    corner(0.5, 0.5),
                ];
                let low_corner = corners.iter().fold(DVec2::INFINITY, |low, corner| low.min(*corner));
                let high_corner = corners
                    .iter()
                    .fold(DVec2::NEG_INFINITY, |high, corner| high.max(*corner));
                let exact = -(high_corner - low_corner).map(f64::log2);
                let depth_of_row = |row: u32| {
                    let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / 1024.0;
                    -2.0 / (y * 30.0_f64.to_radians().tan())
                };
                let depths: Vec<f32> = (0..SIDE * SIDE)
                    .map(|index| {
                        if index / SIDE > 513 {
                            (0.1 / depth_of_row(index / SIDE)) as f32
                        } else {
                            0.0
                        }
                    })
                    .collect();
                let picture = DepthPicture::new(UVec2::splat(SIDE), &depths, world_from_clip).unwrap();
                for (pick, low, high) in [
                    (NeighbourPick::Smaller, -0.01, high),
                    (NeighbourPick::Larger, low, high - 0.01),
                ] {
                    let need =
                        pixel_need(&picture, &light, UVec2::new(512, row), &options(NeedMeasure::Box, pick)).unwrap();
                    let error = need.map(f64::log2) - exact;
                    assert!(
                        error.min_element() > low && error.max_element() < high,
                        "{elevation} {azimuth} {row} {pick:?}: {error}"
                    );
                }
            }
        }
    }
}

/// Why the box is not the default: a sliver of a pixel across both axes has a small box in texels and a huge texel in
/// pixels.
#[test]
fn slivers_across_the_axes_need_more_than_their_box() {
    // A wall that faces the camera; the map's axes are turned by 45° and light grazes the wall.
    let grazing = DVec3::new(0.0, 0.02, 1.0).normalize();
    let towards_light = DVec3::new(0.999_8, 0.0, 0.02).normalize();
    let [a, b] = [towards_light.cross(grazing).normalize(), towards_light];
    let third = a.cross(b);
    let turned = light(
        400.0,
        (a + third).normalize(),
        (a - third)
            .normalize()
            .cross((a + third).normalize())
            .cross((a + third).normalize()),
    );
    assert!(turned.is_finite());
    let column = SIDE / 2;
    let boxed = middle_levels(
        |_| 10.0,
        &turned,
        column,
        &options(NeedMeasure::Box, NeighbourPick::Smaller),
    );
    let sides = middle_levels(
        |_| 10.0,
        &turned,
        column,
        &options(NeedMeasure::Sides, NeighbourPick::Smaller),
    );
    let extent = middle_levels(
        |_| 10.0,
        &turned,
        column,
        &options(NeedMeasure::Extent, NeighbourPick::Smaller),
    );
    assert!((sides - boxed).min_element() > 3.0, "{sides} {boxed}");
    assert!(
        (extent - sides).min_element() > 0.4 && (extent - sides).max_element() <= 0.5,
        "{extent} {sides}"
    );
}

#[test]
fn levels_round_up_and_saturate() {
    for (need, level) in [
        (0.0, 0),
        (0.3, 0),
        (1.0, 0),
        (1.001, 1),
        (2.0, 1),
        (65_536.0, 16),
        (65_537.0, 17),
        (1.0e12, 31),
    ] {
        assert_eq!(need_level(need, 0.0), level, "{need}");
    }
    for edge_on in [f64::INFINITY, f64::NAN] {
        assert_eq!(need_level(edge_on, 0.0), 31);
    }
    // A bias of ½ rounds to the nearest level.
    assert_eq!((need_level(1.41, 0.5), need_level(1.42, 0.5)), (0, 1));
    assert_eq!(need_level(-1.0, 0.0), 31, "no need is negative: NaN");
}

/// Exponent of frexp: x = m 2^e with 0.5 <= m < 1.
fn exponent(x: f64) -> i32 {
    ((x.to_bits() >> 52) & 0x7ff) as i32 - 1022
}

/// Oracle 16: the encoder is the rounded logarithm minus one.
#[test]
fn the_encoder_is_a_level_low() {
    let mut numbers = Numbers(16);
    for _ in 0..100_000 {
        let extent = (-30.0 * numbers.unit()).exp2();
        let listed = -exponent(2.0_f64.sqrt() * extent);
        assert_eq!(i32::from(byte_need(extent)), listed.max(0), "{extent}");
    }
    assert_eq!(byte_need(1.0 / 65_536.0), 15);
    // Reconstruction 24: no extent has the largest need, not none.
    assert_eq!((byte_need(0.0), byte_need(1.0e-300)), (29, 29));
    assert_eq!((byte_need(f64::NAN), byte_need(1.0), byte_need(100.0)), (29, 0, 0));
    // Reconstruction 10: the formula of the text, literally, is 0 for every extent below 1.
    assert_eq!(-(1.0e-5_f64 + 0.5).round().max(1.0).log2(), 0.0);
}

/// Oracle 17.
#[test]
fn stored_bytes_hold_needs_up_to_127() {
    assert!((0..=127).all(|need| stored_byte(need) == need));
    assert_eq!(stored_byte(129), 128);
}

/// Oracle 18: rounding halves up gives the rounded log2 of the need of a picture pixel; halves to even would be one
/// less.
#[test]
fn the_rounding_pays_the_level_back() {
    for level in [16.0, 16.26, 16.49, 16.58, 16.99] {
        let need = f64::exp2(level);
        let stored = byte_need(4.0 / need);
        assert_eq!(byte_level(stored, 4.0), level.round(), "{level}");
        let halves_to_even = f64::from(stored) + (4.0_f64.log2() + 0.5).round_ties_even();
        assert_eq!(halves_to_even, level.round() - 1.0);
    }
}

/// Reconstructions 12 and 22: a byte of a position finds the tile by its highest bits; 2.9 % find the neighbour.
#[test]
fn bytes_of_places_miss_some_tiles() {
    let (mut missed, mut farthest, count) = (0, 0.0_f64, 100_000);
    for index in 0..count {
        let uv = (f64::from(index) + 0.5) / f64::from(count);
        let byte = byte_place(uv);
        let tile = (place_of_byte(byte) * 32.0) as u32;
        assert_eq!(tile, u32::from(byte) >> 3);
        if tile != (uv * 32.0) as u32 {
            missed += 1;
            farthest = farthest.max((uv * 32.0 - (uv * 32.0).round()).abs());
        }
    }
    let share = f64::from(missed) / f64::from(count);
    assert!((share - 0.029).abs() < 0.001, "{share}");
    assert!((farthest - 0.059).abs() < 0.001, "{farthest}");
}

fn two_walls() -> Picture {
    let view = papers_camera(0.5, 200.0);
    let planes = [
        HalfSpace {
            normal: DVec3::Z,
            distance: -20.0,
        },
        HalfSpace {
            normal: DVec3::Y,
            distance: -3.0,
        },
    ];
    let scene = Bounds::new(DVec3::new(-30.0, -10.0, -30.0), DVec3::new(30.0, 8.0, 0.0));
    Picture::of_planes(&view, UVec2::splat(64), &planes, &scene)
}

/// Rows F4 and F6: sizes, sky, places outside, and the thesis's settings beside the exact ones.
#[test]
fn mapping_maps() {
    let picture = two_walls();
    let travel = DVec3::new(0.1, -1.0, -1.0).normalize();
    let x = DVec3::Y.cross(-travel).normalize();
    let light = light(100.0, x, (-travel).cross(x));
    let full = TileMappingMap::new(
        &picture.depths(),
        &light,
        UVec2::splat(1000),
        &MappingOptions::default(),
    );
    assert_eq!(
        (full.size, full.picture, full.outside),
        (UVec2::splat(64), UVec2::splat(64), 0)
    );
    let with_geometry = picture.seen.iter().flatten().count() as u32;
    assert_eq!(full.valid_texels(), with_geometry);
    assert!(with_geometry < 64 * 64, "some sky");
    for (index, texel) in full.texels.iter().enumerate() {
        assert_eq!(texel.is_some(), picture.seen[index].is_some());
        if let (Some(texel), Some(seen)) = (texel, picture.seen[index]) {
            let ndc = light.project_point3(seen.point);
            assert!(
                texel
                    .uv
                    .as_dvec2()
                    .distance(DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y))
                    < 1.0e-5
            );
        }
    }
    // A quarter of the size looks at pixels 4 i + 2 and sees the same there.
    let quarter = TileMappingMap::new(&picture.depths(), &light, UVec2::splat(16), &MappingOptions::default());
    for y in 0..16 {
        for x in 0..16 {
            let [small, large] = [quarter.texels[y * 16 + x], full.texels[(4 * y + 2) * 64 + 4 * x + 2]];
            assert_eq!(
                small.map(|texel| (texel.uv, texel.levels)),
                large.map(|texel| (texel.uv, texel.levels))
            );
        }
    }
    // The thesis rounds to the nearest level and takes the box, which these unturned slopes fill.
    let paper = TileMappingMap::new(&picture.depths(), &light, UVec2::splat(16), &MappingOptions::PAPER);
    let pairs = paper
        .texels
        .iter()
        .zip(&quarter.texels)
        .filter_map(|(paper, exact)| Some((paper.as_ref()?, exact.as_ref()?)));
    let mut near = 0;
    for (paper, exact) in pairs.clone() {
        assert!(paper.uv.distance(exact.uv) <= 1.0 / 255.0);
        near += u32::from((0..2).all(|axis| paper.levels[axis].abs_diff(exact.levels[axis]) <= 1));
    }
    assert!(near * 10 >= pairs.count() as u32 * 9, "{near}");
    // Beside the map nothing is needed.
    let beside = DMat4::from_translation(DVec3::X * 1.5) * light;
    let map = TileMappingMap::new(&picture.depths(), &beside, UVec2::splat(64), &MappingOptions::default());
    assert!(map.outside > 0 && map.outside + map.valid_texels() == with_geometry);
}

/// Depth is affine over a plane, so all patches of a plane have one slope: at the borders of the picture too.
#[test]
fn slopes_at_the_border() {
    let tilted = HalfSpace::through(DVec3::NEG_Z * 10.0, DVec3::new(0.4, 0.3, 1.0).normalize());
    let scene = Bounds::new(DVec3::splat(-100.0), DVec3::splat(100.0));
    let picture = Picture::of_planes(&papers_camera(0.5, 200.0), UVec2::splat(64), &[tilted], &scene);
    let light = light(100.0, DVec3::X, DVec3::Y);
    let options = MappingOptions::default();
    let slopes = |x, y| {
        pixel_patch(&picture.depths(), &light, UVec2::new(x, y), &options)
            .unwrap()
            .slopes
    };
    let inner = slopes(30, 30);
    for (x, y) in [(0, 30), (63, 30), (30, 0), (30, 63), (0, 0), (63, 63)] {
        assert!(
            slopes(x, y).distance(inner) < 1.0e-3 * inner.length(),
            "{x} {y}: {}",
            slopes(x, y)
        );
    }
}

/// Surfaces that face away from the light can be left out; the sign says which they are.
#[test]
fn facing_away() {
    let picture = two_walls();
    let travel = DVec3::new(0.1, -1.0, 0.6).normalize();
    let x = DVec3::Y.cross(-travel).normalize();
    let light = light(100.0, x, (-travel).cross(x));
    let skip = MappingOptions {
        skip_facing_away: true,
        ..MappingOptions::default()
    };
    let map = TileMappingMap::new(&picture.depths(), &light, UVec2::splat(64), &skip);
    let mut counts = [0; 2];
    for (pixel, seen) in picture.inner() {
        let is_lit = travel.dot(seen.normal) < 0.0;
        let patch = pixel_patch(&picture.depths(), &light, pixel, &skip).unwrap();
        assert_eq!(patch.facing() > 0.0, is_lit, "{pixel}");
        assert_eq!(map.texels[(pixel.y * 64 + pixel.x) as usize].is_some(), is_lit);
        counts[usize::from(is_lit)] += 1;
    }
    assert!(counts[0] > 100 && counts[1] > 100, "{counts:?}");
}

#[test]
fn pictures_without_an_answer() {
    let size = UVec2::splat(2);
    assert!(DepthPicture::new(UVec2::ZERO, &[], DMat4::IDENTITY).is_none());
    assert!(DepthPicture::new(size, &[0.5; 3], DMat4::IDENTITY).is_none());
    assert!(DepthPicture::new(size, &[0.5; 4], DMat4::NAN).is_none());
    let depths = [0.0, f32::NAN, -1.0, f32::INFINITY];
    let picture = DepthPicture::new(size, &depths, DMat4::IDENTITY).unwrap();
    let map = TileMappingMap::new(&picture, &DMat4::IDENTITY, UVec2::ZERO, &MappingOptions::default());
    assert_eq!((map.size, map.valid_texels()), (UVec2::ONE, 0));
    // A single pixel has no neighbours: it counts as facing the camera.
    let one = DepthPicture::new(UVec2::ONE, &[0.5], DMat4::IDENTITY).unwrap();
    for measure in [NeedMeasure::Sides, NeedMeasure::Box] {
        let need = pixel_need(
            &one,
            &DMat4::IDENTITY,
            UVec2::ZERO,
            &options(measure, NeighbourPick::Smaller),
        )
        .unwrap();
        assert!(need.distance(DVec2::ONE) < 1.0e-12, "{need}");
    }
    // A light view without extent: everything is edge-on.
    let map = TileMappingMap::new(
        &one,
        &DMat4::from_diagonal(DVec3::ZERO.extend(1.0)),
        UVec2::ONE,
        &MappingOptions::default(),
    );
    assert_eq!(map.texels[0].unwrap().levels, [31, 31]);
    assert_eq!(
        pixel_need(&one, &DMat4::NAN, UVec2::ZERO, &MappingOptions::default()),
        None
    );
    assert_eq!(
        pixel_patch(&one, &DMat4::IDENTITY, UVec2::ONE, &MappingOptions::default()),
        None
    );
}
