//! What a level file says about inhabitants.

use bevy_math::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// Some figures of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InhabitantRule {
    /// Who.
    pub figure: Figure,
    /// How many; fewer where there is no room.
    pub count: u32,
    /// Where they go.
    pub places: Places,
}

/// Kinds of figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Figure {
    /// A red deer with antlers.
    Stag,
    /// A red deer without.
    Hind,
    /// A person on foot.
    Walker,
}

impl Figure {
    /// Their model file, without extension.
    pub fn file(self) -> &'static str {
        match self {
            Self::Stag | Self::Hind => "deer",
            Self::Walker => "walker",
        }
    }

    /// Width, height and length in metres of a box that may stand in for it, at scale 1.
    pub fn size(self) -> Vec3 {
        match self {
            Self::Stag => Vec3::new(0.6, 2.0, 1.9),
            Self::Hind => Vec3::new(0.5, 1.5, 1.8),
            Self::Walker => Vec3::new(0.5, 1.75, 0.35),
        }
    }
}

/// Where figures go.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Places {
    /// Round blocks, on their pavements, without a stop.
    Pavements {
        /// Blocks whose middle is nearer than this to the origin.
        within: f32,
    },
    /// Here and there in a round area, with long stops.
    Area {
        /// Middle (x, z).
        center: Vec2,
        /// Nobody leaves it.
        radius: f32,
    },
}
