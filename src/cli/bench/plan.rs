//! What is measured in which order: the camera's route, and blocks of frames.

use std::{f32::consts::TAU, ops::Range};

use bevy::math::{Quat, UVec2, Vec3};

use crate::{
    demo::flight,
    level::{format::CameraPath, shot::Shot},
};

/// Measured frames between two changes of the technique.
const BLOCK: usize = 5;
/// Seconds of one round about a scene without paths.
const ROUND_SECONDS: f32 = 20.0;

/// Where the camera is in every measured frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Route {
    /// The path's name.
    pub(super) name: String,
    /// One camera per frame.
    pub(super) shots: Vec<Shot>,
    /// Seconds from the path's start, per frame.
    pub(super) seconds: Vec<f32>,
}

impl Route {
    /// Frames at equal times along a path, its ends included.
    pub(super) fn along(path: &CameraPath, light_dir: Vec3, frames: u32, size: UVec2) -> Self {
        let shots = flight::shots(path, light_dir, frames, size);
        let steps = shots.len().saturating_sub(1).max(1) as f32;
        Self {
            name: path.name.clone(),
            seconds: (0..shots.len())
                .map(|frame| path.duration() * frame as f32 / steps)
                .collect(),
            shots,
        }
    }

    /// One round about what a shot looks at, at the shot's height and distance.
    pub(super) fn orbit(shot: &Shot, frames: u32, size: UVec2) -> Self {
        let target = Vec3::from(shot.target);
        let arm = Vec3::from(shot.position) - target;
        let turned = |frame: u32| {
            let turn = Quat::from_rotation_y(TAU * frame as f32 / frames as f32);
            Shot {
                position: (target + turn * arm).to_array(),
                width: size.x,
                height: size.y,
                ..shot.clone()
            }
        };
        Self {
            name: "orbit".to_owned(),
            shots: (0..frames).map(turned).collect(),
            seconds: (0..frames)
                .map(|frame| ROUND_SECONDS * frame as f32 / frames as f32)
                .collect(),
        }
    }
}

/// Frames that are measured one after the other with one technique.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Block {
    /// Index of the technique.
    pub(super) technique: usize,
    /// Frames of the route.
    pub(super) frames: Range<usize>,
    /// The technique was not on before: its pipelines have to be built.
    pub(super) is_first: bool,
}

/// Takes the route in blocks of a few frames, every block with every technique before the next block begins: what
/// drifts over a run (temperature, other programs) hits all techniques alike. The technique that begins changes from
/// block to block.
pub(super) fn blocks(techniques: usize, frames: usize) -> Vec<Block> {
    let starts = (0..frames).step_by(BLOCK).enumerate();
    starts
        .flat_map(|(round, start)| {
            (0..techniques).map(move |place| Block {
                technique: (place + round) % techniques,
                frames: start..(start + BLOCK).min(frames),
                is_first: round == 0,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::format::PathKey;

    #[test]
    fn every_technique_gets_every_frame_once() {
        let plan = blocks(3, 12);
        for technique in 0..3 {
            let own = plan.iter().filter(|block| block.technique == technique);
            let frames: Vec<usize> = own.flat_map(|block| block.frames.clone()).collect();
            assert_eq!(frames, (0..12).collect::<Vec<_>>(), "technique {technique}");
        }
        let order: Vec<usize> = plan.iter().map(|block| block.technique).collect();
        assert_eq!(order, [0, 1, 2, 1, 2, 0, 2, 0, 1]);
        assert_eq!(plan.iter().filter(|block| block.is_first).count(), 3);
        assert_eq!(plan[8].frames, 10..12, "the last block is as long as the rest");
    }

    #[test]
    fn a_route_has_the_times_of_its_path() {
        let key = |time, x| PathKey {
            time,
            position: Vec3::X * x,
            target: Vec3::X * x + Vec3::Z,
        };
        let path = CameraPath {
            name: "walk".into(),
            keys: vec![key(1.0, 0.0), key(9.0, 16.0)],
        };
        let route = Route::along(&path, Vec3::NEG_Y, 5, UVec2::new(64, 36));
        assert_eq!(route.seconds, [0.0, 2.0, 4.0, 6.0, 8.0]);
        let along: Vec<f32> = route.shots.iter().map(|shot| shot.position[0].round()).collect();
        assert_eq!(along, [0.0, 4.0, 8.0, 12.0, 16.0]);
        assert_eq!(Route::along(&path, Vec3::NEG_Y, 1, UVec2::ONE).seconds, [0.0]);
    }

    #[test]
    fn an_orbit_keeps_height_and_distance() {
        let shot = Shot {
            scene: None,
            name: "overview".into(),
            position: [5.0, 4.0, 1.0],
            target: [1.0, 1.0, 1.0],
            up: [0.0, 1.0, 0.0],
            fov_y_deg: 45.0,
            near: 0.5,
            far: 50.0,
            width: 1,
            height: 1,
            light_dir: [0.0, -1.0, 0.0],
        };
        let route = Route::orbit(&shot, 4, UVec2::new(64, 36));
        // A quarter of a turn to the left about the vertical through (1, 1, 1): +x becomes −z.
        let expected = [[5.0, 4.0, 1.0], [1.0, 4.0, -3.0], [-3.0, 4.0, 1.0], [1.0, 4.0, 5.0]];
        for (shot, expected) in route.shots.iter().zip(expected) {
            assert!(
                Vec3::from(shot.position).abs_diff_eq(expected.into(), 1e-5),
                "{:?}",
                shot.position
            );
            assert_eq!((shot.target, shot.width, shot.far), ([1.0, 1.0, 1.0], 64, 50.0));
        }
        assert_eq!(route.seconds, [0.0, 5.0, 10.0, 15.0]);
    }
}
