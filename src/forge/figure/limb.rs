//! Legs that reach for a place: planar chains and the path of a foot.

use bevy_math::{Mat3, Vec2, Vec3};

use crate::forge::{
    portable::{TURN, cos, mix, power, sin, sin_cos, smooth},
    rig::{Joint, Pose},
};

/// Rounds of the solver; it is within micrometres after a third of them.
const ROUNDS: usize = 60;

/// Rotation about x: counter-clockwise seen from +x, so what points down goes backward.
pub fn pitch(angle: f32) -> Mat3 {
    let (sin, cos) = sin_cos(angle);
    Mat3::from_cols(Vec3::X, Vec3::new(0.0, cos, sin), Vec3::new(0.0, -sin, cos))
}

/// Rotation about y: what looks forward turns to the left.
pub fn yaw(angle: f32) -> Mat3 {
    let (sin, cos) = sin_cos(angle);
    Mat3::from_cols(Vec3::new(cos, 0.0, -sin), Vec3::Y, Vec3::new(sin, 0.0, cos))
}

/// Rotation about z: the left side goes up.
pub fn roll(angle: f32) -> Mat3 {
    let (sin, cos) = sin_cos(angle);
    Mat3::from_cols(Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0), Vec3::Z)
}

/// A bone of a leg: which joint turns it, how it likes to be turned, and how readily it gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bone {
    /// Index of the joint.
    pub joint: usize,
    /// Angle about x against the bind pose in radians, if the foot's place leaves the choice.
    pub liked: f32,
    /// How readily it turns away from there, relative to the others.
    pub ease: f32,
}

/// Angles of a chain of `segments` (z, y of the bind pose) that ends at `target`: nearest to the liked angles, each
/// deviation divided by its ease. Newton's method on the constraint with weighted least norm (Whitney 1969). A target out
/// of reach is approached.
fn solve(segments: &[Vec2], bones: &[Bone], target: Vec2) -> Vec<f32> {
    let mut angles: Vec<f32> = bones.iter().map(|bone| bone.liked).collect();
    for _ in 0..ROUNDS {
        let (mut end, mut slopes) = (Vec2::ZERO, Vec::new());
        for (segment, angle) in segments.iter().zip(&angles) {
            let (sin, cos) = sin_cos(*angle);
            let turned = Vec2::new(segment.x * cos + segment.y * sin, segment.y * cos - segment.x * sin);
            end += turned;
            slopes.push(Vec2::new(turned.y, -turned.x));
        }
        // What is missing if all angles were the liked ones, to first order.
        let mut missing = target - end;
        let (mut a, mut b, mut d) = (1e-6, 0.0, 1e-6);
        for ((slope, angle), bone) in slopes.iter().zip(&angles).zip(bones) {
            missing += *slope * (angle - bone.liked);
            a += bone.ease * slope.x * slope.x;
            b += bone.ease * slope.x * slope.y;
            d += bone.ease * slope.y * slope.y;
        }
        let push = Vec2::new(d * missing.x - b * missing.y, a * missing.y - b * missing.x) / (a * d - b * b);
        for ((slope, angle), bone) in slopes.iter().zip(&mut angles).zip(bones) {
            let wanted = bone.liked + bone.ease * slope.dot(push);
            *angle += (wanted - *angle).clamp(-0.15, 0.15);
        }
    }
    angles
}

/// Turns the bones of a leg so that the next joint, `end`, is at `target` in model space. The leg stays in the plane through
/// its first joint, the target and the z direction.
pub fn reach(pose: &mut Pose, joints: &[Joint], bones: &[Bone], end: usize, target: Vec3) {
    let Some(first) = bones.first() else { return };
    let hip = pose.frames(joints)[first.joint].1;
    let to = target - hip;
    let down = Vec2::new(to.x, to.y).length();
    let tilt = Mat3::from_cols(
        Vec3::new(-to.y, to.x, 0.0) / down,
        Vec3::new(-to.x, -to.y, 0.0) / down,
        Vec3::Z,
    );
    let places = bones
        .iter()
        .map(|bone| bone.joint)
        .chain([end])
        .map(|joint| joints[joint].position);
    let places: Vec<Vec3> = places.collect();
    let segments: Vec<Vec2> = places
        .windows(2)
        .map(|pair| Vec2::new(pair[1].z - pair[0].z, pair[1].y - pair[0].y))
        .collect();
    let angles = solve(&segments, bones, Vec2::new(to.z, -down));
    for (bone, angle) in bones.iter().zip(angles) {
        pose.orient(joints, bone.joint, tilt * pitch(angle));
    }
}

/// How a foot goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Metres that the body goes in one cycle.
    pub metres: f32,
    /// Share of the cycle in which the foot is on the ground.
    pub duty: f32,
    /// How high it is lifted in metres.
    pub lift: f32,
    /// When it is highest, as a share of the swing: 0.5 in the middle.
    pub peak: f32,
}

/// A foot's place against its bind place, and how far its swing is: `None` on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Metres forward.
    pub forward: f32,
    /// Metres above the ground.
    pub up: f32,
    /// 0..1 from lift-off to touch-down.
    pub swing: Option<f32>,
}

impl Step {
    /// The foot at a phase of its cycle; 0 is touch-down. On the ground it moves backward as fast as the body forward; in
    /// the air on a cubic with the same speed at both ends.
    pub fn foot(&self, phase: f32) -> Foot {
        let phase = phase - phase.floor();
        let half = 0.5 * self.duty * self.metres;
        if phase < self.duty {
            return Foot {
                forward: half - phase * self.metres,
                up: 0.0,
                swing: None,
            };
        }
        let s = (phase - self.duty) / (1.0 - self.duty);
        let slope = -self.metres * (1.0 - self.duty);
        let (s2, s3) = (s * s, s * s * s);
        let forward =
            -half * (2.0 * s3 - 3.0 * s2 + 1.0) + half * (3.0 * s2 - 2.0 * s3) + slope * (2.0 * s3 - 3.0 * s2 + s);
        // s^warp is one half at the peak.
        let warped = power(s, -1.0 / log2(self.peak));
        let bump = sin(0.5 * TURN * warped);
        Foot {
            forward,
            up: self.lift * bump * bump,
            swing: Some(s),
        }
    }
}

fn log2(x: f32) -> f32 {
    libm::log2f(x)
}

/// 0 to 1 while a phase (with its turns) goes from `from` to `to`, 0 before, 1 after; smooth.
pub fn ramp(phase: f32, from: f32, to: f32) -> f32 {
    smooth(from, to, phase - phase.floor())
}

/// A wave of one cycle that is highest at phase `top`.
pub fn wave(phase: f32, top: f32) -> f32 {
    cos(TURN * (phase - top))
}

/// Values at phases 0..=1, joined smoothly; phases grow.
pub fn track(keys: &[(f32, f32)], phase: f32) -> f32 {
    let after = keys.iter().position(|(at, _)| *at > phase).unwrap_or(keys.len());
    match (after.checked_sub(1).map(|before| keys[before]), keys.get(after)) {
        (Some((from, a)), Some((to, b))) => mix(a, *b, smooth(from, *to, phase)),
        (Some((_, last)), None) => last,
        (None, Some((_, first))) => *first,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bone(joint: usize, liked: f32) -> Bone {
        Bone {
            joint,
            liked,
            ease: 1.0,
        }
    }

    #[test]
    fn rotations_turn_the_way_their_names_say() {
        assert!((pitch(TURN / 4.0) * Vec3::NEG_Y - Vec3::NEG_Z).length() < 1e-6);
        assert!((yaw(TURN / 4.0) * Vec3::Z - Vec3::X).length() < 1e-6);
        assert!((roll(TURN / 4.0) * Vec3::X - Vec3::Y).length() < 1e-6);
    }

    #[test]
    fn a_leg_of_two_bones_bends_by_the_law_of_cosines() {
        // Lengths 4 and 3, the foot 5 below the hip: a right angle at the knee.
        let joint = |parent: Option<usize>, y: f32| Joint {
            name: String::new(),
            parent,
            position: Vec3::new(0.2, y, 0.0),
        };
        let joints = [joint(None, 7.0), joint(Some(0), 3.0), joint(Some(1), 0.0)];
        let mut pose = Pose::bind(&joints);
        reach(
            &mut pose,
            &joints,
            &[bone(0, -0.3), bone(1, 0.3)],
            2,
            Vec3::new(0.2, 2.0, 0.0),
        );
        let frames = pose.frames(&joints);
        assert!(
            (frames[2].1 - Vec3::new(0.2, 2.0, 0.0)).length() < 1e-4,
            "{}",
            frames[2].1
        );
        let (thigh, shin) = (frames[1].1 - frames[0].1, frames[2].1 - frames[1].1);
        assert!(thigh.dot(shin).abs() < 1e-3);
        assert!(frames[1].1.z > 0.0, "the knee goes forward, as liked");
    }

    #[test]
    fn a_leg_tilts_to_a_foot_beside_it() {
        let joint = |parent: Option<usize>, y: f32| Joint {
            name: String::new(),
            parent,
            position: Vec3::Y * y,
        };
        let joints = [joint(None, 5.0), joint(Some(0), 2.0), joint(Some(1), 0.0)];
        let mut pose = Pose::bind(&joints);
        let target = Vec3::new(1.0, 0.5, -0.5);
        reach(&mut pose, &joints, &[bone(0, -0.2), bone(1, 0.2)], 2, target);
        assert!((pose.frames(&joints)[2].1 - target).length() < 1e-4);
    }

    #[test]
    fn feet_on_the_ground_go_with_the_ground() {
        let step = Step {
            metres: 1.2,
            duty: 0.6,
            lift: 0.1,
            peak: 0.4,
        };
        assert!((step.foot(0.0).forward - 0.36).abs() < 1e-6);
        assert!((step.foot(0.5).forward - step.foot(0.25).forward + 0.3).abs() < 1e-6);
        assert!((step.foot(0.6).forward + 0.36).abs() < 1e-5);
        let top = step.foot(0.6 + 0.4 * 0.4);
        assert!((top.up - 0.1).abs() < 1e-5, "{top:?}");
        let (before, after) = (step.foot(0.9999), step.foot(1.0));
        assert!((before.forward - after.forward).abs() < 1e-3 && before.up < 1e-3);
    }

    #[test]
    fn tracks_go_through_their_keys() {
        let keys = [(0.0, 1.0), (0.5, 3.0), (1.0, 1.0)];
        assert_eq!(track(&keys, 0.5), 3.0);
        assert_eq!(track(&keys, 0.25), 2.0);
        assert_eq!((track(&keys, -1.0), track(&keys, 2.0)), (1.0, 1.0));
    }
}
