//! Skeletons, skins and clips: what makes a model move.
//!
//! In the bind pose no joint is turned: a joint's frame is a translation, and so is its inverse bind matrix. Joints stand
//! after their parents in every list.

use bevy_math::{Mat3, Vec3};

/// Joints that may move one vertex.
pub const INFLUENCES: usize = 4;

/// A joint in the bind pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Unique within the rig; left ones end in `_l`, right ones in `_r`.
    pub name: String,
    /// An earlier joint; `None` for the first.
    pub parent: Option<usize>,
    /// Metres in model space.
    pub position: Vec3,
}

/// How much joints move a vertex: weights in 1/255, which sum to 255.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Influence {
    /// Indices of joints; 0 where the weight is 0.
    pub joints: [u8; INFLUENCES],
    /// In 1/255.
    pub weights: [u8; INFLUENCES],
}

/// A moment of a movement: turns against the bind pose, in the parents' frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Where the first joint is, in metres in model space.
    pub root: Vec3,
    /// One rotation per joint.
    pub turns: Vec<Mat3>,
}

/// A loop of key poses at even times; the first follows on the last.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Unique within the rig.
    pub name: String,
    /// Duration of the loop.
    pub seconds: f32,
    /// Metres that the figure walks along +z in one loop; 0 for a clip on the spot.
    pub metres: f32,
    /// Key poses.
    pub poses: Vec<Pose>,
}

/// A skeleton with its movements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rig {
    /// Joints, parents first; figures look along +z.
    pub joints: Vec<Joint>,
    /// Movements.
    pub clips: Vec<Clip>,
}

impl Pose {
    /// The bind pose.
    pub fn bind(joints: &[Joint]) -> Self {
        Self {
            root: joints.first().map_or(Vec3::ZERO, |joint| joint.position),
            turns: vec![Mat3::IDENTITY; joints.len()],
        }
    }

    /// Orientation and place of every joint in model space.
    pub fn frames(&self, joints: &[Joint]) -> Vec<(Mat3, Vec3)> {
        let mut frames: Vec<(Mat3, Vec3)> = Vec::with_capacity(joints.len());
        for (joint, turn) in joints.iter().zip(&self.turns) {
            let frame = match joint.parent.and_then(|parent| Some((frames.get(parent)?, parent))) {
                Some((&(orientation, place), parent)) => (
                    orientation * *turn,
                    place + orientation * (joint.position - joints[parent].position),
                ),
                None => (*turn, self.root),
            };
            frames.push(frame);
        }
        frames
    }

    /// Turns a joint so that its orientation in model space is `orientation`.
    pub fn orient(&mut self, joints: &[Joint], joint: usize, orientation: Mat3) {
        let parent = joints[joint]
            .parent
            .map_or(Mat3::IDENTITY, |parent| self.frames(joints)[parent].0);
        self.turns[joint] = parent.transpose() * orientation;
    }
}

/// The unit quaternion (x, y, z, w ≥ 0) of a rotation of less than half a turn (Shepperd 1978, by the largest element).
pub fn quaternion(rotation: Mat3) -> [f32; 4] {
    let [m00, m10, m20, m01, m11, m21, m02, m12, m22] = rotation.to_cols_array();
    let squares = [
        1.0 + m00 - m11 - m22,
        1.0 - m00 + m11 - m22,
        1.0 - m00 - m11 + m22,
        1.0 + m00 + m11 + m22,
    ];
    let largest = (0..4).fold(3, |best, i| if squares[i] > squares[best] { i } else { best });
    let q = match largest {
        0 => [squares[0], m10 + m01, m02 + m20, m21 - m12],
        1 => [m10 + m01, squares[1], m21 + m12, m02 - m20],
        2 => [m02 + m20, m21 + m12, squares[2], m10 - m01],
        _ => [m21 - m12, m02 - m20, m10 - m01, squares[3]],
    };
    let length = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    let scale = if q[3] < 0.0 { -1.0 / length } else { 1.0 / length };
    q.map(|part| part * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forge::portable::{TURN, turn};

    fn rotation(axis: Vec3, angle: f32) -> Mat3 {
        Mat3::from_cols(
            turn(Vec3::X, axis, angle),
            turn(Vec3::Y, axis, angle),
            turn(Vec3::Z, axis, angle),
        )
    }

    #[test]
    fn quaternions_are_half_angles_about_the_axis() {
        // 120° about the diagonal: (sin 60° / √3, same, same, cos 60°).
        let third = quaternion(rotation(Vec3::ONE.normalize(), TURN / 3.0));
        assert!(third.iter().all(|part| (part - 0.5).abs() < 1e-6), "{third:?}");
        // 170° about −y: the largest element is not w.
        let [x, y, z, w] = quaternion(rotation(Vec3::NEG_Y, 170.0_f32.to_radians()));
        assert!(x.abs() < 1e-6 && z.abs() < 1e-6);
        assert!(
            (y + 0.996_194_7).abs() < 1e-5 && (w - 0.087_155_74).abs() < 1e-5,
            "{y} {w}"
        );
    }

    #[test]
    fn children_go_with_their_parents() {
        let joint = |parent: Option<usize>, y: f32| Joint {
            name: format!("at {y}"),
            parent,
            position: Vec3::Y * y,
        };
        let joints = [joint(None, 1.0), joint(Some(0), 2.0), joint(Some(1), 4.0)];
        let mut pose = Pose::bind(&joints);
        pose.turns[0] = rotation(Vec3::X, TURN / 4.0);
        pose.orient(&joints, 1, Mat3::IDENTITY);
        let frames = pose.frames(&joints);
        assert!((frames[1].1 - Vec3::new(0.0, 1.0, 1.0)).length() < 1e-6, "y went to z");
        assert!(
            (frames[2].1 - Vec3::new(0.0, 3.0, 1.0)).length() < 1e-6,
            "upright again"
        );
    }
}
