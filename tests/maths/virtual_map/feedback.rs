//! Needs of an earlier frame hold for every camera within the motion.

use bevy_math::{DMat4, DQuat, DVec3, UVec2};
use proptest::prelude::*;
use umbrage::maths::{
    footprint::{texel_footprint, texels_on_pixels},
    near_plane::Motion,
    polytope::HalfSpace,
    view::ViewVolume,
    virtual_map::{
        feedback::PictureMotion,
        mapping::{MappingOptions, NeedMeasure, pixel_need},
    },
    warp::Warp,
};

use super::scene::{Picture, camera_clip_from_world};
use crate::{
    properties::{direction, point},
    support::{fit, papers_camera, roomy_scene},
};

const PIXELS: UVec2 = UVec2::new(48, 32);

fn camera(eye: DVec3, forward: DVec3, up: DVec3, fov: f64) -> ViewVolume {
    ViewVolume::perspective(eye, forward, up, fov, 1.5, 0.1, 500.0).expect("a camera")
}

/// What a map of one texel would need to have a side of one pixel at a point: the need, from footprints alone.
fn need_at(view: &ViewVolume, light: &DMat4, point: DVec3, normal: DVec3) -> Option<[f64; 2]> {
    let texel = texel_footprint(light, UVec2::ONE, point)?;
    let pixel = texel_footprint(&camera_clip_from_world(view), PIXELS, point)?;
    texels_on_pixels(&texel, &pixel, normal).map(|ratio| [ratio.across, ratio.along])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn dilated_needs_hold_after_motion(
        fov in 0.4..1.8, normal in direction(), distance in 2.0..60.0, light_travel in direction(), warped in any::<bool>(),
        speed in 0.0..8.0, turning in 0.0..9.0, time in 0.005..0.1, way in point(1.0), axis in direction(), share in 0.0..1.0,
    ) {
        let before = camera(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, fov);
        let plane = HalfSpace::through(DVec3::NEG_Z * distance, normal);
        let picture = Picture::of_planes(&before, PIXELS, &[plane], &roomy_scene());
        let light = fit(&before, &roomy_scene(), light_travel, if warped { Warp::Lispsm } else { Warp::Uniform });
        let motion = Motion { speed, turning, time };
        let bound = PictureMotion::new(&before, &motion, f64::from(PIXELS.y)).unwrap();
        let exact = MappingOptions::default();
        let dilated = MappingOptions { motion: Some(bound), ..exact };

        let step = way.clamp_length_max(1.0) * (speed * time);
        let turn = DQuat::from_axis_angle(axis, (turning * time).min(1.5) * share);
        let after = camera(step, turn * DVec3::NEG_Z, turn * DVec3::Y, fov);
        let clip_after = camera_clip_from_world(&after);
        for (pixel, seen) in picture.inner() {
            let clip = clip_after * seen.point.extend(1.0);
            let place = clip.truncate().truncate() / clip.w;
            if clip.w < 0.1 || place.abs().max_element() > 1.0 || seen.point.normalize().dot(seen.normal).abs() < 0.02 { continue; }
            let Some(need) = need_at(&after, &light.clip_from_world, seen.point, seen.normal) else { continue };
            let allowed = pixel_need(&picture.depths(), &light.clip_from_world, pixel, &dilated).unwrap();
            let still = pixel_need(&picture.depths(), &light.clip_from_world, pixel, &exact).unwrap();
            prop_assert!(allowed.cmpge(still).all());
            for axis in 0..2 {
                prop_assert!(need[axis] <= allowed[axis] * (1.0 + 2.0e-3), "{pixel}: {need:?} exceeds {allowed}, before {still}");
            }
            // It moved no farther over the picture than the flow.
            let depth = before.depth(seen.point);
            let pixels = |ndc: bevy_math::DVec2| ndc * PIXELS.as_dvec2() * 0.5;
            let was = camera_clip_from_world(&before).project_point3(seen.point).truncate();
            let moved = pixels(place).distance(pixels(was));
            prop_assert!(moved <= bound.flow(depth) * (1.0 + 1.0e-6), "moved by {moved}, flow {}", bound.flow(depth));
        }
    }
}

/// The bound is no guess: walking straight at a wall it is met, and without motion it is the need itself.
#[test]
fn dilation_is_tight() {
    let view = camera(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0);
    let wall = HalfSpace::through(DVec3::NEG_Z * 10.0, DVec3::Z);
    let picture = Picture::of_planes(&view, PIXELS, &[wall], &roomy_scene());
    let light = fit(&view, &roomy_scene(), DVec3::new(0.3, -0.4, -1.0), Warp::Uniform);
    let need = |speed, turning| {
        let motion = Motion {
            speed,
            turning,
            time: 1.0,
        };
        let motion = PictureMotion::new(&view, &motion, 32.0);
        let options = MappingOptions {
            motion,
            ..MappingOptions::default()
        };
        pixel_need(&picture.depths(), &light.clip_from_world, UVec2::new(24, 16), &options).unwrap()
    };
    let still = pixel_need(
        &picture.depths(),
        &light.clip_from_world,
        UVec2::new(24, 16),
        &MappingOptions::default(),
    )
    .unwrap();
    assert!(need(0.0, 0.0).distance(still) < 1.0e-9 * still.length());
    assert!(
        (need(2.0, 0.0) / still - 1.25).abs().max_element() < 1.0e-4,
        "10 m ÷ 8 m"
    );
    // A frame of a brisk walk and turn: a fifth of a level.
    let motion = Motion {
        speed: 1.5,
        turning: 2.0,
        time: 1.0 / 60.0,
    };
    let bound = PictureMotion::new(&view, &motion, 32.0).unwrap();
    assert!(bound.turn_factor().log2() < 0.1, "{}", bound.turn_factor());
    assert_eq!(
        need(10.5, 0.0),
        bevy_math::DVec2::INFINITY,
        "the camera may stand at the wall"
    );
}

/// Oblique surfaces gain by being seen from another side: scaling by distance alone would not be enough.
#[test]
fn sideways_motion_counts_for_oblique_surfaces() {
    let view = camera(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0);
    let plane = HalfSpace::through(DVec3::NEG_Z * 10.0, DVec3::new(1.0, 0.0, 0.1).normalize());
    let picture = Picture::of_planes(&view, PIXELS, &[plane], &roomy_scene());
    let light = fit(&view, &roomy_scene(), DVec3::new(-1.0, -0.2, -0.1), Warp::Uniform);
    let moved = camera(DVec3::X, DVec3::NEG_Z, DVec3::Y, 1.0);
    let middle = UVec2::new(24, 16);
    let seen = picture.at(24, 16).unwrap();
    let after = need_at(&moved, &light.clip_from_world, seen.point, seen.normal).unwrap();
    let depth = view.depth(seen.point);
    let still = pixel_need(
        &picture.depths(),
        &light.clip_from_world,
        middle,
        &MappingOptions::default(),
    )
    .unwrap();
    assert!(
        (0..2).any(|axis| after[axis] > 1.3 * still[axis] * depth / (depth - 1.0)),
        "{after:?} {still}"
    );
}

#[test]
fn motions_without_an_answer() {
    let flat = ViewVolume::orthographic(
        DVec3::ZERO,
        DVec3::NEG_Z,
        DVec3::Y,
        bevy_math::DVec2::splat(-1.0),
        bevy_math::DVec2::ONE,
        0.0,
        10.0,
    );
    let motion = Motion {
        speed: 1.0,
        turning: 1.0,
        time: 1.0,
    };
    assert_eq!(PictureMotion::new(&flat.unwrap(), &motion, 100.0), None);
    let view = papers_camera(1.0, 100.0);
    let odd = Motion {
        speed: f64::NAN,
        turning: -3.0,
        time: 1.0,
    };
    let bound = PictureMotion::new(&view, &odd, 100.0).unwrap();
    assert_eq!((bound.step, bound.turn, bound.turn_factor()), (0.0, 0.0, 1.0));
    assert!((bound.corner - 2.0_f64.sqrt() * 30.0_f64.to_radians().tan()).abs() < 1.0e-9);
    assert_eq!(bound.flow(5.0), 0.0);
    // Turned farther than the corner: the factor is that of the corner seen from the axis, and a little.
    let spun = PictureMotion { turn: 1.5, ..bound };
    assert!(spun.turn_factor() >= (1.0 + bound.corner * bound.corner).sqrt());
}

/// The extent measure is dilated too, and no measure shrinks.
#[test]
fn all_measures_dilate() {
    let view = camera(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0);
    let plane = HalfSpace::through(DVec3::NEG_Z * 10.0, DVec3::new(0.5, 0.2, 1.0).normalize());
    let picture = Picture::of_planes(&view, PIXELS, &[plane], &roomy_scene());
    let light = fit(&view, &roomy_scene(), DVec3::new(0.3, -1.0, -0.2), Warp::Lispsm);
    let motion = PictureMotion::new(
        &view,
        &Motion {
            speed: 3.0,
            turning: 1.0,
            time: 0.05,
        },
        32.0,
    );
    for measure in [NeedMeasure::Sides, NeedMeasure::Extent, NeedMeasure::Box] {
        let still = MappingOptions {
            measure,
            ..MappingOptions::default()
        };
        let [still, moving] = [still, MappingOptions { motion, ..still }].map(|options| {
            pixel_need(&picture.depths(), &light.clip_from_world, UVec2::new(30, 20), &options).unwrap()
        });
        assert!(
            moving.cmpgt(still).all() && moving.cmplt(still * 1.5).all(),
            "{measure:?}: {still} {moving}"
        );
    }
}
