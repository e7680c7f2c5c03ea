//! The near plane from the least depth, one frame late or not.

use bevy_math::{DVec3, UVec2};
use proptest::prelude::*;
use umbrage::maths::{
    body::light_visible,
    bounds::Bounds,
    near_plane::{DepthChain, Motion, NOTHING, entering_angle, late_near, near_limits},
    view::ViewVolume,
};

use crate::support::{close, papers_camera};

/// Stingl, oracle 26: the chain ends in the brute-force least and greatest, for every size up to 33 and every place of
/// the extreme.
#[test]
fn the_chain_finds_the_extremes_of_any_size() {
    for width in 1..=33_u32 {
        for height in [1, 2, 3, 5, 8, 17, 33] {
            let count = (width * height) as usize;
            for place in [0, count / 3, count / 2, count - width as usize, count - 1] {
                let mut depths = vec![50.0; count];
                depths[place] = 0.5;
                depths[count - 1 - place] = if place == count - 1 - place { 0.5 } else { 900.0 };
                let chain = DepthChain::new(UVec2::new(width, height), &depths).expect("a picture");
                let expected = depths
                    .iter()
                    .fold((f32::INFINITY, 0.0_f32), |(least, greatest), depth| {
                        (least.min(*depth), greatest.max(*depth))
                    });
                assert_eq!(chain.range(), Some(expected), "{width} × {height}, {place}");
                let last = chain.levels.last().expect("a level");
                assert_eq!(last.size, UVec2::ONE);
            }
        }
    }
    let sizes: Vec<u32> = DepthChain::new(UVec2::new(13, 1), &[1.0; 13])
        .expect("a picture")
        .levels
        .iter()
        .map(|level| level.size.x)
        .collect();
    assert_eq!(sizes, [13, 6, 3, 1]);
}

#[test]
fn sky_is_no_depth() {
    let chain = |depths: &[f32]| DepthChain::new(UVec2::new(2, 2), depths);
    assert_eq!(
        chain(&[0.0, f32::NAN, f32::INFINITY, -1.0]).expect("a picture").range(),
        None
    );
    assert_eq!(
        chain(&[0.0, 7.0, f32::NAN, 0.0]).expect("a picture").range(),
        Some((7.0, 7.0))
    );
    assert_eq!(chain(&[0.0; 3]), None, "too few depths");
    assert_eq!(DepthChain::new(UVec2::ZERO, &[]), None);
    let level = &chain(&[0.0, 7.0, 3.0, 0.0]).expect("a picture").levels[0];
    assert_eq!(level.depths, [NOTHING, [7.0; 2], [3.0; 2], NOTHING]);
}

/// Stingl, section 4.3.
#[test]
fn limits_of_the_control() {
    let scene = Bounds::new(DVec3::new(-50.0, -2.0, -80.0), DVec3::new(50.0, 20.0, 10.0));
    let inside = papers_camera(0.1, 1000.0);
    let limits = near_limits(&inside, &scene, &light_visible(&inside, &scene), 0.05);
    let (low, high) = limits.expect("sees the scene");
    close(low, 0.05, 1.0e-12);
    close(high, 80.0, 1.0e-9);
    let view =
        ViewVolume::perspective(DVec3::Z * 40.0, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 0.1, 1000.0).expect("a camera");
    let (low, high) = near_limits(&view, &scene, &light_visible(&view, &scene), 0.05).expect("sees the scene");
    close(low, 30.0, 1.0e-9);
    close(high, 120.0, 1.0e-9);
    let away = ViewVolume::perspective(DVec3::Z * 40.0, DVec3::Z, DVec3::Y, 1.0, 1.0, 0.1, 1000.0).expect("a camera");
    assert_eq!(near_limits(&away, &scene, &light_visible(&away, &scene), 0.05), None);
}

fn camera(eye: DVec3, forward: DVec3) -> ViewVolume {
    ViewVolume::perspective(eye, forward, DVec3::Y, 1.0, 16.0 / 9.0, 0.1, 500.0).expect("a proper camera")
}

/// The bound is reached: a point in the corner of the picture, the camera turning and walking towards it.
#[test]
fn late_near_planes_are_tight() {
    let motion = Motion {
        speed: 3.0,
        turning: 2.0,
        time: 1.0 / 30.0,
    };
    let view = camera(DVec3::ZERO, DVec3::NEG_Z);
    let corner = view.corners(5.0, 5.0)[2];
    let near = late_near(5.0, &view, &motion);
    // Turn away from the corner, about the axis across both, and step towards where the camera then looks.
    let axis = view.forward().cross(corner).normalize();
    let forward = bevy_math::DQuat::from_axis_angle(axis, -2.0 / 30.0) * view.forward();
    let later = camera(forward * 0.1, forward);
    close(later.depth(corner), near, 1.0e-9);
    assert!(near < 5.0 - 0.1 && near > 4.5, "{near}");
    // Standing still: no margin. Too fast, or too near: the view's own near plane.
    let still = Motion {
        speed: 0.0,
        turning: 0.0,
        time: 1.0,
    };
    close(late_near(5.0, &view, &still), 5.0, 1.0e-12);
    for wild in [
        Motion {
            speed: 1000.0,
            ..motion
        },
        Motion {
            turning: 60.0,
            ..motion
        },
        Motion {
            turning: f64::NAN,
            ..motion
        },
        Motion {
            turning: 190.0,
            ..motion
        },
    ] {
        assert_eq!(late_near(5.0, &view, &wild), 0.1, "{wild:?}");
    }
    assert_eq!(late_near(0.15, &view, &motion), 0.1);
    close(entering_angle(5.0, &motion), 2.0 / 30.0 + (0.02_f64).asin(), 1.0e-12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// No receiver that lies in the earlier picture's frustum beyond its least depth is nearer than the late near
    /// plane. What is seen later but was not in the earlier frustum lies within the entering angle of its border.
    #[test]
    fn late_near_planes_lose_nothing_that_was_in_view(
        place in [-1.0_f64..1.0, -1.0_f64..1.0], depth in 2.0_f64..60.0, least in 0.5_f64..2.0,
        turn in [-1.0..1.0, -1.0..1.0, -1.0..1.0], step in [-1.0..1.0, -1.0..1.0, -1.0..1.0], aside in 0.0_f64..0.3,
    ) {
        let motion = Motion { speed: 6.0, turning: 3.0, time: 1.0 / 60.0 };
        let view = camera(DVec3::ZERO, DVec3::NEG_Z);
        let corners = view.corners(1.0, 1.0);
        let (right, up) = ((corners[1] - corners[0]) * 0.5, (corners[3] - corners[0]) * 0.5);
        let (turn, step) = (DVec3::from_array(turn), DVec3::from_array(step));
        let rotation = bevy_math::DQuat::from_scaled_axis(turn.clamp_length_max(1.0) * 0.05);
        let later = ViewVolume::perspective(
            step.clamp_length_max(1.0) * 0.1, rotation * DVec3::NEG_Z, rotation * DVec3::Y, 1.0, 16.0 / 9.0, 0.1, 500.0,
        ).expect("a proper camera");
        let seen = (DVec3::NEG_Z + right * place[0] + up * place[1]) * (least * depth * 0.5);
        prop_assert!(later.depth(seen) >= late_near(least, &view, &motion) - 1.0e-9, "{}", later.depth(seen));
        // A little beside the earlier picture.
        let beside = (DVec3::NEG_Z + right * (1.0 + aside) + up * place[1]) * least;
        let is_seen_later = later.half_spaces().iter().all(|plane| plane.excess(beside) <= 0.0);
        let border: DVec3 = (DVec3::NEG_Z + right + up * place[1]).cross(up).normalize();
        let angle_beside = (-border.dot(beside) / beside.length()).abs().asin();
        if is_seen_later {
            prop_assert!(angle_beside <= entering_angle(beside.length(), &motion) + 1.0e-9, "{angle_beside}");
        }
    }
}
