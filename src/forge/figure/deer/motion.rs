//! How a deer moves.

use bevy_math::Vec3;

use crate::forge::{
    figure::{
        joint,
        limb::{Bone, Step, pitch, reach, roll, track, wave, yaw},
    },
    portable::{TURN, sin},
    rig::{Clip, Joint, Pose},
};

const WALK_KEYS: u16 = 30;
const WALK_SECONDS: f32 = 1.2;
const GRAZE_KEYS: u16 = 60;
const GRAZE_SECONDS: f32 = 14.0;

/// Phase of the cycle at which each hoof touches down: left hind, left fore, right hind, right fore (the lateral sequence
/// of four beats, Hildebrand 1965).
const TOUCH_DOWN: [(&str, bool, f32); 4] = [
    ("l", false, 0.0),
    ("l", true, 0.25),
    ("r", false, 0.5),
    ("r", true, 0.75),
];

/// Where the tips of the hooves stand in the bind pose: fore and hind, of the left side.
const TIPS: [Vec3; 2] = [Vec3::new(0.10, 0.0, 0.36), Vec3::new(0.11, 0.0, -0.49)];

/// Four beats; every hoof is on the ground for 64 % of the cycle.
pub(super) fn walk(joints: &[Joint]) -> Clip {
    let step = Step {
        metres: 1.26,
        duty: 0.64,
        lift: 0.085,
        peak: 0.42,
    };
    let pose = |phase: f32| {
        let mut pose = Pose::bind(joints);
        let mut turn = |name: &str, rotation| pose.turns[joint(joints, name)] = rotation;
        // The back sways a little, the head nods with every fore step.
        let sway = wave(phase, 0.30);
        turn("hips", yaw(0.030 * sway) * roll(0.02 * wave(phase, 0.4)));
        turn("spine", yaw(-0.035 * sway));
        turn("chest", yaw(-0.02 * sway) * pitch(0.01 * wave(2.0 * phase, 0.1)));
        turn(
            "neck_low",
            pitch(0.26 + 0.05 * wave(2.0 * phase, 0.72)) * yaw(0.02 * sway),
        );
        turn("neck_high", pitch(0.10 + 0.03 * wave(2.0 * phase, 0.80)));
        turn("head", pitch(-0.26 - 0.05 * wave(2.0 * phase, 0.78)));
        turn("ear_l", roll(0.08 * wave(phase, 0.2)) * yaw(0.15));
        turn("ear_r", roll(-0.08 * wave(phase, 0.2)) * yaw(-0.15));
        turn("tail", roll(0.12 * wave(phase, 0.6)) * pitch(0.06));
        pose.root += Vec3::new(0.010 * wave(phase, 0.28), -0.035 + 0.008 * wave(2.0 * phase, 0.3), 0.0);
        for (side, fore, touch) in TOUCH_DOWN {
            let own = phase - touch;
            let own = own - own.floor();
            let foot = step.foot(own);
            let bent = foot
                .swing
                .map_or(0.0, |s| track(&[(0.0, 0.0), (0.40, 1.0), (0.92, 0.0)], s));
            // The hoof leaves the ground over its tip.
            let lift_off = 0.85 * step.duty;
            let hoof = track(
                &[
                    (0.0, 0.0),
                    (lift_off, 0.0),
                    (step.duty, 0.45),
                    (0.76, 1.15),
                    (0.93, 0.0),
                    (1.0, 0.0),
                ],
                own,
            );
            let ahead = if fore { -0.03 } else { 0.06 };
            leg(
                &mut pose,
                joints,
                side,
                fore,
                Vec3::new(0.0, foot.up, foot.forward + ahead),
                bent,
                hoof,
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

/// Stands and grazes, looks up once, listens, goes on.
pub(super) fn graze(joints: &[Joint]) -> Clip {
    let pose = |phase: f32| {
        let down = track(&[(0.0, 1.0), (0.58, 1.0), (0.68, 0.0), (0.90, 0.0), (1.0, 1.0)], phase);
        let search = sin(TURN * 2.0 * phase) * down;
        let nibble = sin(TURN * 21.0 * phase) * down;
        let look = track(
            &[
                (0.68, 0.0),
                (0.72, 1.0),
                (0.79, 1.0),
                (0.83, -0.6),
                (0.88, -0.6),
                (0.92, 0.0),
            ],
            phase,
        );
        let mut pose = Pose::bind(joints);
        let mut turn = |name: &str, rotation| pose.turns[joint(joints, name)] = rotation;
        turn("spine", pitch(0.04 * down) * yaw(0.02 * search));
        turn("chest", pitch(0.12 * down) * yaw(0.03 * search));
        turn("neck_low", yaw(0.13 * search + 0.15 * look) * pitch(1.62 * down));
        turn("neck_high", yaw(0.08 * search + 0.25 * look) * pitch(0.55 * down));
        turn(
            "head",
            yaw(0.10 * search + 0.35 * look) * pitch(-1.0 * down + 0.03 * nibble),
        );
        let prick = 0.35 * (1.0 - down);
        let flick = track(&[(0.20, 0.0), (0.22, 0.5), (0.24, 0.0)], phase);
        turn("ear_l", yaw(-prick) * roll(0.25 * (1.0 - down) + flick));
        turn("ear_r", yaw(prick) * roll(-0.25 * (1.0 - down)));
        let wag = track(&[(0.36, 0.0), (0.40, 1.0), (0.47, 1.0), (0.51, 0.0)], phase);
        turn(
            "tail",
            roll(0.5 * wag * sin(TURN * 25.0 * phase)) * pitch(0.05 + 0.2 * wag),
        );
        pose.root += Vec3::new(0.012 * sin(TURN * phase), -0.012, 0.0);
        for (side, fore, ahead) in [
            ("l", true, 0.10),
            ("r", true, -0.07),
            ("l", false, -0.05),
            ("r", false, 0.06),
        ] {
            leg(&mut pose, joints, side, fore, Vec3::Z * ahead, 0.0, 0.0);
        }
        pose
    };
    Clip {
        name: "graze".into(),
        seconds: GRAZE_SECONDS,
        metres: 0.0,
        poses: (0..GRAZE_KEYS)
            .map(|key| pose(f32::from(key) / f32::from(GRAZE_KEYS)))
            .collect(),
    }
}

/// Puts the tip of a hoof at its bind place + `moved`. `bent` lifts the knee, `hoof` is the hoof's angle, heel up.
fn leg(pose: &mut Pose, joints: &[Joint], side: &str, fore: bool, moved: Vec3, bent: f32, hoof: f32) {
    let index = |stem: &str| joint(joints, &format!("{stem}_{side}"));
    let bone = |stem: &str, liked: f32, ease: f32| Bone {
        joint: index(stem),
        liked,
        ease,
    };
    // What hangs 1 m below the shoulder moves by about its angle.
    let swing = -moved.z;
    let (bones, end) = if fore {
        let bones = vec![
            bone("scapula", 0.35 * swing, 0.25),
            bone("humerus", 0.60 * swing - 0.35 * bent, 1.0),
            bone("radius", 0.95 * swing - 0.55 * bent - 0.02, 0.5),
            bone("cannon", 0.95 * swing + 0.75 * bent + 0.02, 0.5),
        ];
        (bones, index("hoof"))
    } else {
        let bones = vec![
            bone("femur", 0.65 * swing - 0.30 * bent, 0.6),
            bone("tibia", 0.85 * swing + 0.25 * bent, 1.0),
            bone("metatarsus", 0.85 * swing + 0.15 * bent, 0.8),
        ];
        (bones, index("hind_hoof"))
    };
    let tip = TIPS[usize::from(!fore)].with_x(joints[end].position.x);
    let ankle = tip + moved + pitch(hoof) * (joints[end].position - tip);
    reach(pose, joints, &bones, end, ankle);
    pose.orient(joints, end, pitch(hoof));
}
