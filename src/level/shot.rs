//! [`Shot`]: one named camera and sun, as levels and shots files write it.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// A camera, a sun and a picture size. Right-handed, y up, metres; unknown fields of files are ignored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shot {
    /// The scene it belongs to (level name or file stem); absent: any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// Unique within its scene.
    pub name: String,
    /// Eye in world space.
    pub position: [f32; 3],
    /// Point looked at.
    pub target: [f32; 3],
    /// Up direction; default +y.
    #[serde(default = "default_up")]
    pub up: [f32; 3],
    /// Full vertical field of view in degrees.
    #[serde(default = "default_fov")]
    pub fov_y_deg: f32,
    /// Near plane in metres.
    #[serde(default = "default_near")]
    pub near: f32,
    /// Far plane in metres.
    #[serde(default = "default_far")]
    pub far: f32,
    /// Picture width in pixels.
    #[serde(default = "default_width")]
    pub width: u32,
    /// Picture height in pixels.
    #[serde(default = "default_height")]
    pub height: u32,
    /// Direction in which sunlight travels; any length but zero.
    pub light_dir: [f32; 3],
}

impl Shot {
    /// Where the camera stands and looks; an up direction without length is +y.
    pub fn camera(&self) -> Transform {
        let up = Vec3::from(self.up).normalize_or(Vec3::Y);
        Transform::from_translation(self.position.into()).looking_at(self.target.into(), up)
    }
}

fn default_up() -> [f32; 3] {
    [0.0, 1.0, 0.0]
}
fn default_fov() -> f32 {
    60.0
}
fn default_near() -> f32 {
    0.1
}
fn default_far() -> f32 {
    1000.0
}
fn default_width() -> u32 {
    1280
}
fn default_height() -> u32 {
    720
}
