//! Depths that range over the receivers alone, casters clamped (Lloyd, section 6.4).

use bevy_math::{DVec3, UVec2};
use proptest::prelude::*;
use umbrage::maths::{
    fit::{DepthRange, FitInput, FitOptions, LightFit, fit_light_view},
    warp::Warp,
};

use crate::{
    partition_properties::inside,
    properties::{direction, light_for, seen},
    support::{bodies, close, fit_with, light_at, papers_camera, roomy_scene},
};

const ROOM: f64 = 0.1;

fn receivers() -> FitOptions {
    FitOptions {
        depths: DepthRange::Receivers { room: ROOM },
        ..FitOptions::default()
    }
}

/// What the map holds of a caster whose depth the rasteriser clamps.
fn stored(fit: &LightFit, caster: DVec3) -> f64 {
    fit.clip_from_world.project_point3(caster).z.clamp(0.0, 1.0)
}

/// What a lookup compares a receiver with that is moved towards the light by a bias in metres.
fn compared(fit: &LightFit, receiver: DVec3, bias: f64) -> f64 {
    fit.clip_from_world.project_point3(receiver).z + bias * fit.depth_per_metre_at(receiver)
}

/// Lloyd, oracle 23: a caster may move towards the light by any distance, out of the depth range too, and shades the same
/// receivers; texels and the warp are those of the whole body.
#[test]
fn clamped_casters_keep_their_shadow() {
    let view = papers_camera(1.0, 100.0);
    for degrees in [20.0, 60.0, 90.0, 130.0] {
        let light = light_at(degrees) + DVec3::X * 0.2;
        let towards_light = -light.normalize();
        for warp in [Warp::Uniform, Warp::Lispsm, Warp::Psm] {
            let whole = fit_with(&view, &roomy_scene(), light, warp, FitOptions::default());
            let fit = fit_with(&view, &roomy_scene(), light, warp, receivers());
            assert_eq!((fit.warp_near, fit.eta), (whole.warp_near, whole.eta));
            for row in [0, 1, 3] {
                assert_eq!(fit.clip_from_world.row(row), whole.clip_from_world.row(row), "texels");
            }
            let finer = fit.depth_per_metre / whole.depth_per_metre;
            assert!(finer > 3.0, "{degrees}° {warp:?}: steps of depth {finer} times finer");
            let (mut clamped, mut beside) = (0, 0);
            for depth in [1.0, 1.5, 7.0, 40.0, 99.0] {
                for across in [-0.5, 0.0, 0.55] {
                    let receiver = DVec3::new(across, 0.3 * across, -1.0) * depth;
                    let level = compared(&fit, receiver, ROOM);
                    assert!(level > 0.0 && level < 1.0, "{receiver}: {level}");
                    for distance in [1.0e-3, 0.05, 0.2, 1.0, 50.0, 1.0e3, 1.0e5] {
                        let caster = receiver + towards_light * distance;
                        let shades = stored(&fit, caster) > level;
                        assert_eq!(shades, distance > ROOM, "{caster} over {receiver}, {degrees}° {warp:?}");
                        clamped += i32::from(fit.clip_from_world.project_point3(caster).z > 1.0);
                        beside += i32::from(stored(&fit, receiver - towards_light * distance) > level);
                    }
                }
            }
            assert!(
                clamped > 20 && beside == 0,
                "{clamped} casters were clamped, {beside} shade from below"
            );
        }
    }
}

/// Without room a receiver at the border of H that is moved by its bias passes every clamped caster: what the room is for.
#[test]
fn without_room_bias_eats_the_shadow() {
    let view = papers_camera(1.0, 100.0);
    let bias = 60.0;
    let border = DVec3::new(0.0, 57.0, -99.9);
    let caster = border + DVec3::Y * 500.0;
    for (room, shades) in [(0.0, false), (-3.0, false), (bias, true)] {
        let options = FitOptions {
            depths: DepthRange::Receivers { room },
            ..FitOptions::default()
        };
        let fit = fit_with(&view, &roomy_scene(), DVec3::NEG_Y, Warp::Uniform, options);
        assert_eq!(
            stored(&fit, caster) > compared(&fit, border, bias),
            shades,
            "room of {room} m"
        );
    }
    let range = |options| {
        let fit = fit_with(&view, &roomy_scene(), DVec3::NEG_Y, Warp::Uniform, options);
        1.0 / fit.depth_per_metre
    };
    // H is 2 · 57.735 m high; B reaches up to the scene's 1000 m. Two texels at both ends, and the room at one.
    let texels = 4.0 * 2.0 * 57.735 / 1024.0;
    close(range(receivers()), 2.0 * 57.735 + texels + ROOM, 1.0e-3);
    close(range(FitOptions::default()), 1000.0 + 57.735 + texels, 1.0e-3);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// For random cameras, scenes and lights: H lies between the depths, nothing of B behind them, and casters in B shade
    /// what they shade with the whole range.
    #[test]
    fn receivers_have_the_whole_range(
        (scene, view) in seen(), direction in direction(), along in 0_u8..8, warped in any::<bool>(),
        shares in prop::collection::vec(0.0..1.0, 7), distance in 0.2..500.0,
    ) {
        let light_travel = light_for(&view, direction, along);
        let (visible, body) = bodies(&view, &scene, light_travel);
        prop_assume!(!visible.is_empty());
        let warp = if warped { Warp::Lispsm } else { Warp::Uniform };
        let fit = fit_light_view(&FitInput { view: &view, visible: &visible, body: &body, light_travel, warp, map_size: UVec2::splat(512), guard_texels: 2.0, guard_metres: 0.0, options: receivers() }).fitted();
        prop_assert!(fit.is_some());
        let fit = fit.unwrap();
        let single = fit.clip_from_world_f32();
        for vertex in visible.vertices() {
            let depth = compared(&fit, *vertex, ROOM);
            prop_assert!(depth > 0.0 && depth < 1.0, "{vertex} at {depth}");
            let depth = single.project_point3(vertex.as_vec3()).z;
            prop_assert!((0.0..=1.0).contains(&depth), "{vertex} at {depth} in single precision");
        }
        for vertex in body.vertices() {
            let clip = fit.clip_from_world * vertex.extend(1.0);
            prop_assert!(clip.w > 0.0 && clip.z > 0.0, "{vertex} at {clip}");
        }
        let receiver = inside(&visible, &shares);
        let caster = receiver - light_travel.normalize() * distance;
        prop_assert!(stored(&fit, caster) > compared(&fit, receiver, ROOM), "{caster} over {receiver}");
    }
}
