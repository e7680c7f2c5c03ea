//! Wood as stems: what growth models make, and what tubes and crowns are made from.

use bevy_math::Vec3;

/// A place on a stem's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Metres.
    pub at: Vec3,
    /// Metres.
    pub radius: f32,
}

/// A stem from its base to its tip.
#[derive(Clone, Debug, PartialEq)]
pub struct Stem {
    /// 0 trunk, 1 bough, 2 branch, …
    pub level: usize,
    /// At least two joints.
    pub joints: Vec<Joint>,
}

impl Stem {
    /// Length along the axis in metres.
    pub fn length(&self) -> f32 {
        self.joints.windows(2).map(|pair| pair[0].at.distance(pair[1].at)).sum()
    }

    /// Radius at the base in metres.
    pub fn base_radius(&self) -> f32 {
        self.joints.first().map_or(0.0, |joint| joint.radius)
    }

    /// Place and direction at a share of the joints, 0 base to 1 tip.
    pub fn at(&self, share: f32) -> (Vec3, Vec3) {
        let last = self.joints.len().saturating_sub(1);
        let place = share.clamp(0.0, 1.0) * last as f32;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..=last")]
        let first = (place as usize).min(last.saturating_sub(1));
        let (a, b) = (self.joints[first].at, self.joints[(first + 1).min(last)].at);
        let direction = (b - a).normalize_or(Vec3::Y);
        (a.lerp(b, place - first as f32), direction)
    }
}

/// A twig with leaves that is too fine for wood of its own: a card.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seat {
    /// Where its stalk stands, in metres.
    pub at: Vec3,
    /// Where it grows to, a unit vector.
    pub along: Vec3,
    /// The upper side of its leaves, a unit vector at right angles to `along`.
    pub upper: Vec3,
    /// Metres.
    pub length: f32,
    /// Which of the painted twigs it is.
    pub cell: u32,
    /// How bright it is among its like, 0..=1.
    pub tone: f32,
}

/// A plant without skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// Stems; parents come before their children.
    pub stems: Vec<Stem>,
    /// Twigs with leaves.
    pub seats: Vec<Seat>,
}

/// A local frame that grows along `forward`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Where it is, in metres.
    pub at: Vec3,
    /// The stem's axis, a unit vector.
    pub forward: Vec3,
    /// A unit vector at right angles to it.
    pub side: Vec3,
}

impl Frame {
    /// At right angles to both: stems bend from `forward` towards it.
    pub fn over(&self) -> Vec3 {
        self.side.cross(self.forward)
    }
}
