//! Filters of shadow lookups.

use bevy_math::{IVec2, Mat2, Mat4, Vec2, Vec3, Vec4Swizzles};
use umbrage::maths::{
    bias::receiver_plane,
    depth_offset::DepthOffset,
    filter::{
        disc::{TAP_COUNTS, disc, disc_tap, pixel_angle},
        fading::fading_depth,
        kernel::{kernel_per_metre, scaled},
        lookup::{Lookup, WithFading, bilinear, compare, four_taps, hard, receiver_depth, receiver_texel},
        penumbra::{SUN_ANGULAR_DIAMETER, Soft, penumbra_radius, search_blockers, soft},
    },
    warp::Warp,
};

use crate::{
    overhead::{EXTENT, MILLIMETRE, SIZE, atlas, lookup, overhead, plane_at, slope_of, slope_scaled, tilted},
    support::{fit, huge_scene, light_at, papers_camera},
};

/// Taps are spread like a Poisson disc: equal areas, no two close together, none outside, centred.
#[test]
fn taps_fill_the_disc() {
    for count in TAP_COUNTS {
        let taps: Vec<Vec2> = (0..count).map(|index| disc_tap(index, count, 0.7)).collect();
        let mut nearest = f32::INFINITY;
        for (index, a) in taps.iter().enumerate() {
            assert!(a.length() < 1.0, "tap {index} of {count}");
            nearest = taps[..index].iter().map(|b| a.distance(*b)).fold(nearest, f32::min);
        }
        assert!(
            nearest * (count as f32).sqrt() > 1.5,
            "{nearest} between taps of {count}"
        );
        for radius in [0.3_f32, 0.6, 0.9] {
            let inside = taps.iter().filter(|tap| tap.length() < radius).count() as f32;
            let expected = radius * radius * count as f32;
            assert!((inside - expected).abs() <= 1.0, "{inside} of {count} within {radius}");
        }
        let mean = taps.iter().sum::<Vec2>() / count as f32;
        assert!(mean.length() < 1.5 / count as f32, "{mean} of {count}");
        let turned = disc_tap(3, count, 0.7 + 1.1);
        assert!(
            (turned - Vec2::from_angle(1.1).rotate(taps[3])).length() < 1e-5,
            "the angle turns the disc"
        );
    }
}

/// Neighbouring pixels turn differently, and all angles are as frequent.
#[test]
fn pixels_turn_their_discs() {
    let mut histogram = [0; 8];
    for x in 0..128 {
        for y in 0..128 {
            let angle = pixel_angle(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
            assert!((0.0..std::f32::consts::TAU + 1e-5).contains(&angle), "{angle}");
            histogram[((angle / std::f32::consts::TAU * 8.0) as usize).min(7)] += 1;
            let right = pixel_angle(Vec2::new(x as f32 + 1.5, y as f32 + 0.5));
            assert!((angle - right).abs() > 0.1, "neighbours at {x}, {y}");
        }
    }
    assert!(
        histogram.iter().all(|count| (1900..2200).contains(count)),
        "{histogram:?}"
    );
}

/// Half of the ground is under a roof `height` metres up, whose edge lies at x = 0.
fn roof(height: f32) -> impl Fn(IVec2) -> f32 {
    atlas(move |x, _| if x < 0.0 { height } else { 0.0 })
}

fn ground_at(x: f32) -> Lookup {
    lookup(plane_at(Vec3::new(x, 0.0, 0.3), Vec3::Y), MILLIMETRE)
}

/// Scherzer, oracle 21.
#[test]
fn two_by_two() {
    let map = roof(5.0);
    let mut last = None;
    for step in 0..400 {
        let at = ground_at(step as f32 * 0.005 - 1.0);
        let texel = receiver_texel(&at);
        let equal = four_taps(&map, &at, texel);
        assert!([0.0, 0.25, 0.5, 0.75, 1.0].contains(&equal), "{equal}");
        let smooth = bilinear(&map, &at, texel);
        assert!((smooth - last.unwrap_or(smooth)).abs() < 0.02, "a jump at {step}");
        last = Some(smooth);
        // No filter: the one texel that holds the receiver. The roof's edge lies between two texels.
        let x = step as f32 * 0.005 - 1.0;
        if x.abs() > 1e-3 {
            assert_eq!(hard(&map, &at), if x < 0.0 { 0.0 } else { 1.0 }, "at {x}");
        }
    }
    // Beside the middle of a texel that is half covered the unfiltered edge is a whole texel's, the filtered one is not.
    let shifted = atlas(|x, _| if x < 0.3 { 5.0 } else { 0.0 });
    for (x, expected) in [(0.05, 0.0), (0.45, 0.0), (0.55, 1.0)] {
        assert_eq!(hard(&shifted, &ground_at(x)), expected, "at {x}");
    }
    assert_eq!(bilinear(&map, &ground_at(-3.0), receiver_texel(&ground_at(-3.0))), 0.0);
    assert_eq!(last, Some(1.0));
    // Half-way between two texel centres.
    let at = ground_at(0.0);
    assert!((bilinear(&map, &at, receiver_texel(&at)) - 0.5).abs() < 1e-4);
    // A corner of four texels of which one is in shadow, a quarter of the way to the middle of it.
    let corner = atlas(|x, z| if x < 0.0 && z < 0.0 { 5.0 } else { 0.0 });
    let at = lookup(plane_at(Vec3::ZERO, Vec3::Y), MILLIMETRE);
    assert_eq!(four_taps(&corner, &at, Vec2::splat(SIZE / 2.0)), 0.75);
    let weighted = bilinear(&corner, &at, Vec2::splat(SIZE / 2.0 - 0.25));
    assert!((weighted - (1.0 - 0.75 * 0.75)).abs() < 1e-6, "{weighted}");
}

/// Casters that fade take their share of the light from what nothing opaque shades, whatever filter looks.
#[test]
fn fading_casters_take_their_share() {
    let settings = Soft {
        sun_tangent: 0.2,
        largest_radius: 4.0,
        smallest_radius: 0.3,
        search_taps: 32,
        filter_taps: 64,
    };
    let kernel = kernel_per_metre(overhead(), &plane_at(Vec3::ZERO, Vec3::Y), Vec3::Y);
    let metre = scaled(&kernel, 1.0);
    // Opaque from x = 8 on; left of the middle something fades.
    let opaque = atlas(|x, _| if x > 8.0 { 5.0 } else { 0.0 });
    let fading_depths = roof(5.0);
    for share in [0.0, 0.2, 0.6, 1.0] {
        let maps = WithFading {
            atlas: &opaque,
            fading: |texel: IVec2| fading_depth(fading_depths(texel), share),
        };
        let solid = roof(5.0);
        for x in [-6.0, -1.2, -0.1, 0.0, 0.3, 1.5, 5.0] {
            let at = ground_at(x);
            let texel = receiver_texel(&at);
            let expected = |lit: f32| 1.0 - share * (1.0 - lit);
            for (name, lit, of_solid) in [
                ("hard", hard(&maps, &at), hard(&solid, &at)),
                ("bilinear", bilinear(&maps, &at, texel), bilinear(&solid, &at, texel)),
                (
                    "disc",
                    disc(&maps, &at, &metre, 32, 0.4, true),
                    disc(&solid, &at, &metre, 32, 0.4, true),
                ),
            ] {
                assert!(
                    (lit - expected(of_solid)).abs() < 0.003,
                    "{name}: {lit} at {x}, share {share}"
                );
            }
        }
        // Under the opaque roof nothing is left to take, and the penumbra of a share is a share of the penumbra.
        assert_eq!(hard(&maps, &ground_at(9.0)), 0.0);
        if share > 0.0 {
            let (part, whole) = (
                soft(&maps, &ground_at(-0.5), &kernel, &settings, 0.3),
                soft(&solid, &ground_at(-0.5), &kernel, &settings, 0.3),
            );
            assert!(
                (part - (1.0 - share * (1.0 - whole))).abs() < 0.01,
                "{part}, solid {whole}"
            );
        }
    }
}

/// Taps beside the map read its border: the map's neighbours in the atlas (which [`atlas`] refuses) do not shine in.
#[test]
fn taps_stay_in_their_cell() {
    let map = roof(5.0);
    let kernel = scaled(
        &kernel_per_metre(overhead(), &plane_at(Vec3::ZERO, Vec3::Y), Vec3::Y),
        3.0,
    );
    for (x, expected) in [(-15.9, 0.0), (15.9, 1.0)] {
        assert_eq!(disc(&map, &ground_at(x), &kernel, 32, 0.4, true), expected, "at {x}");
    }
    let at = ground_at(0.0);
    assert_eq!(compare(&map, &at, Vec2::splat(-100.0)), 0.0);
    assert_eq!(compare(&map, &at, Vec2::splat(1000.0)), 1.0);
}

/// Wide kernels on tilted planes: every tap compares with the plane at its own texel.
#[test]
fn wide_kernels_do_not_shade_their_receiver() {
    for normal in [slope_of(70.0), Vec3::new(0.5, 0.6, -0.6).normalize()] {
        let height = tilted(normal);
        let map = atlas(tilted(normal));
        for step in 0..50 {
            let (x, z) = (step as f32 * 0.1 - 2.5, 1.0 - step as f32 * 0.03);
            let plane = plane_at(Vec3::new(x, height(x, z), z), normal);
            let kernel = scaled(&kernel_per_metre(overhead(), &plane, Vec3::Y), 2.0);
            let angle = step as f32;
            let filtered = |offset| disc(&map, &lookup(plane, offset), &kernel, 32, angle, true);
            assert_eq!(filtered(MILLIMETRE), 1.0, "step {step}");
            let enough_for_one_texel = slope_scaled(1.0, 16.0);
            assert!(
                filtered(enough_for_one_texel) < 0.8,
                "slope-scaled bias serves one texel only"
            );
            let blockers = search_blockers(&map, &lookup(plane, MILLIMETRE), &kernel, 16, angle);
            assert_eq!(blockers.weight, 0.0, "step {step}");
        }
    }
}

/// Stingl, oracle 23 and equation 3.9: kernels have one size in the world, over maps of different extents and in a
/// warped map; ours is a radius.
#[test]
fn kernels_have_their_size_in_the_world() {
    let uniform = |extent: f32| {
        let zoom = Mat4::from_scale(Vec3::new(EXTENT / extent, EXTENT / extent, 1.0)) * overhead();
        let plane = receiver_plane(zoom, Vec3::ZERO, Vec3::Y, Vec3::Y).expect("in the map");
        scaled(&kernel_per_metre(zoom, &plane, Vec3::Y), 0.25)
    };
    for extent in [4.0, 16.0, 50.0] {
        let kernel = uniform(extent);
        for side in [kernel.across, kernel.along] {
            assert!(
                (side.length() * 2.0 * extent - 0.25).abs() < 1e-5,
                "{kernel:?} in a map of {extent}"
            );
        }
    }
    let light_view = fit(&papers_camera(1.0, 100.0), &huge_scene(), light_at(75.0), Warp::Lispsm);
    let matrix = light_view.clip_from_world_f32();
    let to_light = light_view.axes.z.as_vec3();
    let (right, up) = to_light.any_orthonormal_pair();
    for depth in [1.5_f32, 5.0, 40.0] {
        let position = Vec3::new(0.2, -0.5, -1.0) * depth;
        let normal = Vec3::new(0.2, 0.9, 0.3).normalize();
        let plane = receiver_plane(matrix, position, normal, to_light).expect("in the map");
        let kernel = scaled(&kernel_per_metre(matrix, &plane, to_light), 0.1);
        // The Jacobian takes texture coordinates back to the light plane.
        let jacobian = Mat2::from_cols(kernel.across, kernel.along);
        for step in 0..12 {
            let (sine, cosine) = (step as f32 * 0.5).sin_cos();
            let moved = position + (right * cosine + up * sine) * 0.1;
            let there = receiver_plane(matrix, moved, normal, to_light).expect("in the map").uv;
            let on_disc = jacobian.inverse() * (there - plane.uv);
            assert!((on_disc.length() - 1.0).abs() < 0.02, "{on_disc} at {depth} m");
        }
    }
}

/// The filtered edge of a roof is the kernel's integral: half at the edge, nothing beyond the radius.
#[test]
fn discs_blur_by_their_radius() {
    let map = roof(5.0);
    let kernel = scaled(
        &kernel_per_metre(overhead(), &plane_at(Vec3::ZERO, Vec3::Y), Vec3::Y),
        4.0,
    );
    let lit = |x: f32| {
        let angles = (0..64).map(|step| step as f32 * 0.3);
        angles
            .map(|angle| disc(&map, &ground_at(x), &kernel, 64, angle, true))
            .sum::<f32>()
            / 64.0
    };
    assert!((lit(0.0) - 0.5).abs() < 0.01, "{}", lit(0.0));
    assert_eq!((lit(-4.6), lit(4.6)), (0.0, 1.0));
    for x in [-2.0_f32, 1.0, 3.0] {
        // Share of a disc on one side of a chord at x / 4.
        let share = x / 4.0;
        let expected = 0.5 + (share * (1.0 - share * share).sqrt() + share.asin()) / std::f32::consts::PI;
        assert!(
            (lit(x) - expected).abs() < 0.02,
            "{} instead of {expected} at {x}",
            lit(x)
        );
    }
}

/// Stingl, section 3.5: filters hide crawl. A map that moves by parts of a texel changes the result of a standing receiver;
/// the energy of that change (the square of it, metres of edge) falls from no filter to 2 x 2 taps to a wide disc.
#[test]
fn filters_hide_crawl() {
    let kernel = scaled(
        &kernel_per_metre(overhead(), &plane_at(Vec3::ZERO, Vec3::Y), Vec3::Y),
        2.0,
    );
    let texel = 2.0 * EXTENT / SIZE;
    let energy = |filter: &dyn Fn(f32, f32) -> f32| {
        let mut sum = 0.0;
        for shift in 1..8 {
            for place in -300..300 {
                let (moved, x) = (shift as f32 / 8.0 * texel, place as f32 * 0.01 + 0.005);
                sum += (filter(moved, x) - filter(0.0, x)).powi(2);
            }
        }
        sum / 7.0 * 0.01
    };
    // The roof and the receiver move instead of the map.
    let map = |moved: f32| atlas(move |x, _| if x < moved { 5.0 } else { 0.0 });
    let unfiltered = energy(&|moved, x| hard(&map(moved), &ground_at(x + moved)));
    let smooth = energy(&|moved, x| {
        let at = ground_at(x + moved);
        bilinear(&map(moved), &at, receiver_texel(&at))
    });
    let wide = energy(&|moved, x| disc(&map(moved), &ground_at(x + moved), &kernel, 32, 0.4, true));
    // The unfiltered edge is off by the shift or by the rest of a texel: the mean of 1, 2, 3, 4, 3, 2, 1 eighths of half a metre.
    assert!((unfiltered - 1.0 / 7.0).abs() < 2.0e-3, "{unfiltered}");
    let (smooth, wide) = (smooth / unfiltered, wide / unfiltered);
    assert!((0.27..0.33).contains(&smooth), "{smooth} is left by 2 x 2 taps");
    assert!((0.03..0.07).contains(&wide), "{wide} is left by a disc of four texels");
}

/// A sun with a size: the width of the penumbra follows the height of the roof.
#[test]
fn penumbrae_grow_with_distance() {
    let sun_tangent = 0.2;
    let settings = Soft {
        sun_tangent,
        largest_radius: 4.0,
        smallest_radius: 0.3,
        search_taps: 32,
        filter_taps: 64,
    };
    let kernel = kernel_per_metre(overhead(), &plane_at(Vec3::ZERO, Vec3::Y), Vec3::Y);
    for height in [5.0_f32, 10.0, 15.0] {
        let map = roof(height);
        let search = scaled(&kernel, settings.largest_radius);
        let blockers = search_blockers(&map, &ground_at(-0.5), &search, 32, 0.3);
        assert!((blockers.distance - height).abs() < 0.01, "{blockers:?}");
        let radius = penumbra_radius(blockers.distance, sun_tangent);
        assert!((radius - height * 0.2).abs() < 0.01, "{radius}");
        let lit = |x: f32| soft(&map, &ground_at(x), &kernel, &settings, 0.3);
        assert_eq!(
            (lit(-radius - 0.8), lit(radius + 0.8)),
            (0.0, 1.0),
            "beyond the penumbra of {height} m"
        );
        for x in [-0.6 * radius, 0.0, 0.6 * radius] {
            let share = x / radius;
            let expected = 0.5 + (share * (1.0 - share * share).sqrt() + share.asin()) / std::f32::consts::PI;
            assert!(
                (lit(x) - expected).abs() < 0.08,
                "{} instead of {expected} at {x}",
                lit(x)
            );
        }
    }
    // The early-out reads only the search's taps and the texels around the pixel.
    let reads = std::cell::Cell::new(0);
    let open = atlas(|_, _| 0.0);
    let counted = |texel: IVec2| {
        reads.set(reads.get() + 1);
        open(texel)
    };
    assert_eq!(soft(&counted, &ground_at(0.0), &kernel, &settings, 0.3), 1.0);
    assert_eq!(reads.get(), 36);
    // The sun's penumbra, 10 m behind an edge: 9 cm wide.
    let width = 2.0 * penumbra_radius(10.0, (0.5 * SUN_ANGULAR_DIAMETER).tan());
    assert!((width - 0.0925).abs() < 1e-4, "{width}");
}

/// The depth of the plane at texel centres is what the plane itself stores there.
#[test]
fn receiver_depths_are_those_of_the_plane() {
    let normal = Vec3::new(0.4, 0.8, -0.3).normalize();
    let map = atlas(tilted(normal));
    let at = lookup(
        plane_at(Vec3::new(1.0, tilted(normal)(1.0, -2.0), -2.0), normal),
        DepthOffset::ReceiverPlane { metres: 0.0 },
    );
    let own = receiver_texel(&at).floor();
    for offset in [Vec2::ZERO, Vec2::new(5.0, -3.0), Vec2::new(-9.0, 8.0)] {
        let tap = own + offset;
        let stored = map((tap + at.rect.xy()).as_ivec2());
        assert!((receiver_depth(&at, tap) - stored).abs() < 1e-5, "{offset}");
    }
}
