//! How people walk and stand.

use bevy_math::{Mat3, Vec3};

use crate::forge::{
    figure::{
        joint,
        limb::{Bone, Step, pitch, reach, roll, track, wave, yaw},
    },
    portable::{TURN, sin},
    rig::{Clip, Joint, Pose},
};

const WALK_KEYS: u16 = 30;
const WALK_SECONDS: f32 = 1.04;
const STAND_KEYS: u16 = 32;
const STAND_SECONDS: f32 = 8.0;

/// Below the ankle: where the heel and the ball touch the ground, in metres from the middle of the body.
const HEEL_Z: f32 = -0.075;
const BALL_Z: f32 = 0.10;

/// Heel strike, roll-off over the ball, swing; the arms go against the legs.
pub(super) fn walk(joints: &[Joint]) -> Clip {
    let step = Step {
        metres: 1.28,
        duty: 0.61,
        lift: 0.045,
        peak: 0.30,
    };
    let pose = |phase: f32| {
        let mut pose = Pose::bind(joints);
        let mut turn = |name: &str, rotation| pose.turns[joint(joints, name)] = rotation;
        // The left foot touches down at phase 0: its hip is in front, and the pelvis is lowest soon after.
        let front = wave(phase, 0.02);
        let lean = wave(phase, 0.30);
        turn(
            "hips",
            yaw(-0.10 * front) * roll(0.045 * wave(phase, 0.22)) * pitch(0.02),
        );
        turn(
            "spine",
            yaw(0.08 * front) * roll(-0.03 * wave(phase, 0.22)) * pitch(0.02),
        );
        turn("chest", yaw(0.11 * front) * roll(-0.015 * wave(phase, 0.22)));
        turn("neck", yaw(-0.05 * front) * pitch(-0.02));
        turn(
            "head",
            yaw(-0.04 * front) * pitch(-0.015 + 0.012 * wave(2.0 * phase, 0.2)),
        );
        for (side, sign) in [("l", 1.0), ("r", -1.0)] {
            arm(
                &mut pose,
                joints,
                side,
                sign,
                0.27 * sign * front - 0.02,
                -0.14 + 0.09 * sign * front,
            );
        }
        let height = -0.042 - 0.020 * wave(2.0 * phase, 0.12);
        pose.root += Vec3::new(0.020 * lean, height, 0.008 * wave(2.0 * phase, 0.5));
        for (side, start) in [("l", 0.0), ("r", 0.5)] {
            let own = phase - start - (phase - start).floor();
            let foot = step.foot(own);
            // Toes up at touch-down, flat, heel up before lift-off.
            let heel_up = track(
                &[
                    (0.0, -0.30),
                    (0.09, 0.0),
                    (0.34, 0.0),
                    (step.duty, 0.92),
                    (0.70, 0.80),
                    (0.90, -0.26),
                    (1.0, -0.30),
                ],
                own,
            );
            let bent = foot
                .swing
                .map_or(0.0, |s| track(&[(0.0, 0.5), (0.28, 1.0), (0.85, 0.0)], s));
            leg(
                &mut pose,
                joints,
                side,
                Vec3::new(0.0, foot.up, foot.forward),
                bent,
                heel_up,
            );
        }
        pose
    };
    Clip {
        name: "walk".into(),
        seconds: WALK_SECONDS,
        metres: step.metres,
        poses: (0..WALK_KEYS)
            .map(|key| pose(f32::from(key) / f32::from(WALK_KEYS)))
            .collect(),
    }
}

/// Stands, shifts the weight from leg to leg, looks around.
pub(super) fn stand(joints: &[Joint]) -> Clip {
    let pose = |phase: f32| {
        let weight = track(
            &[(0.0, -1.0), (0.12, 1.0), (0.55, 1.0), (0.68, -1.0), (1.0, -1.0)],
            phase,
        );
        let look = track(
            &[
                (0.2, 0.0),
                (0.28, 0.55),
                (0.42, 0.45),
                (0.5, -0.2),
                (0.8, -0.35),
                (0.95, 0.0),
            ],
            phase,
        );
        let breath = sin(TURN * 2.0 * phase);
        let mut pose = Pose::bind(joints);
        let mut turn = |name: &str, rotation| pose.turns[joint(joints, name)] = rotation;
        turn("hips", roll(0.055 * weight) * yaw(0.03 * weight));
        turn("spine", roll(-0.045 * weight) * pitch(0.01));
        turn("chest", roll(-0.02 * weight) * pitch(0.008 * breath) * yaw(0.12 * look));
        turn("neck", yaw(0.25 * look));
        turn("head", yaw(0.55 * look) * roll(0.02 * weight) * pitch(0.03));
        for (side, sign) in [("l", 1.0), ("r", -1.0)] {
            arm(&mut pose, joints, side, sign, 0.03 * breath - 0.02, -0.16);
        }
        pose.root += Vec3::new(0.038 * weight, -0.014, 0.0);
        for (side, forward) in [("l", 0.04), ("r", -0.03)] {
            leg(&mut pose, joints, side, Vec3::Z * forward, 0.0, 0.0);
        }
        pose
    };
    Clip {
        name: "stand".into(),
        seconds: STAND_SECONDS,
        metres: 0.0,
        poses: (0..STAND_KEYS)
            .map(|key| pose(f32::from(key) / f32::from(STAND_KEYS)))
            .collect(),
    }
}

/// Lets an arm hang beside the body and swing: angles about x in radians, `sign` 1 for the left.
fn arm(pose: &mut Pose, joints: &[Joint], side: &str, sign: f32, swing: f32, elbow: f32) {
    let index = |stem: &str| joint(joints, &format!("{stem}_{side}"));
    let (upper, lower, hand) = (index("upper_arm"), index("lower_arm"), index("hand"));
    let down = roll(-0.30 * sign);
    pose.turns[upper] = pitch(swing) * down;
    // The elbow's axis stays across the body.
    pose.turns[lower] = down.transpose() * pitch(elbow) * down * roll(0.05 * sign);
    pose.turns[hand] = roll(-0.04 * sign) * pitch(-0.10);
}

/// Puts a foot at its bind place + `moved`, rolled over heel or ball by `heel_up` radians; `bent` lifts the knee.
fn leg(pose: &mut Pose, joints: &[Joint], side: &str, moved: Vec3, bent: f32, heel_up: f32) {
    let index = |stem: &str| joint(joints, &format!("{stem}_{side}"));
    let swing = -moved.z;
    let bones = [
        Bone {
            joint: index("thigh"),
            liked: swing - 0.12 - 0.5 * bent,
            ease: 1.0,
        },
        Bone {
            joint: index("shin"),
            liked: swing + 0.12 + 0.5 * bent,
            ease: 1.0,
        },
    ];
    let (foot, toe) = (index("foot"), index("toe"));
    let ankle = joints[foot].position;
    let pivot = Vec3::new(ankle.x, 0.0, if heel_up > 0.0 { BALL_Z } else { HEEL_Z });
    let target = pivot + moved + pitch(heel_up) * (ankle - pivot);
    reach(pose, joints, &bones, foot, target);
    pose.orient(joints, foot, pitch(heel_up));
    // The toes stay flat while the heel rises.
    pose.orient(joints, toe, if heel_up > 0.0 { Mat3::IDENTITY } else { pitch(heel_up) });
}
