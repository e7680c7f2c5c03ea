//! [`SunSettings`]: what a level file says about sun and air. [`validate`](crate::level::validate) holds the limits.

use bevy_math::Vec3;
use serde::{Deserialize, Serialize};

use super::course::DayCourse;

/// Where the sun stands, and the air that it shines through: light, sky, fog and exposure follow from both.
///
/// Exactly one of `light_dir` and `hour` says where the sun stands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SunSettings {
    /// Direction in which sunlight travels; any length but zero.
    #[serde(default)]
    pub light_dir: Option<Vec3>,
    /// Local solar time, 0..=24: the sun stands highest at 12.
    #[serde(default)]
    pub hour: Option<f32>,
    /// Degrees north of the equator, for the course of the day.
    #[serde(default = "default_latitude")]
    pub latitude_deg: f32,
    /// Day of the year, 1..=365.
    #[serde(default = "default_day")]
    pub day: u32,
    /// What light passes through.
    #[serde(default)]
    pub air: Air,
}

/// Air and what keeps the sky's light away.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Air {
    /// Optical depth of dust and droplets straight up, in green light: 0.02 over mountains, 0.1 on a clear day, 0.4 in
    /// haze. More makes the sun weaker and the sky around it paler.
    pub aerosol_depth: f32,
    /// How far one sees through the haze near the ground, in metres: there a dark thing has lost 95 % of its contrast.
    pub visibility: f32,
    /// Share of the light of sky and ground that arrives, 0..=1: crowns and houses keep the rest.
    pub sky_share: f32,
}

impl Default for Air {
    /// A clear day in the lowlands under an open sky.
    fn default() -> Self {
        Self {
            aerosol_depth: 0.1,
            visibility: 6_000.0,
            sky_share: 1.0,
        }
    }
}

impl Default for SunSettings {
    /// A sun at 45° from the side.
    fn default() -> Self {
        Self {
            light_dir: Some(Vec3::new(-0.5, -std::f32::consts::FRAC_1_SQRT_2, -0.5)),
            hour: None,
            latitude_deg: default_latitude(),
            day: default_day(),
            air: Air::default(),
        }
    }
}

impl SunSettings {
    /// The sun's path over the level.
    #[must_use]
    pub fn course(&self) -> DayCourse {
        DayCourse {
            latitude_deg: self.latitude_deg,
            day: self.day,
        }
    }

    /// Direction in which sunlight travels, as given or at the hour; at noon where neither is given.
    #[must_use]
    pub fn light_dir(&self) -> Vec3 {
        self.light_dir
            .unwrap_or_else(|| self.course().light_dir(self.hour.unwrap_or(12.0)))
    }
}

/// Of middle Europe.
fn default_latitude() -> f32 {
    48.0
}

/// The longest one, 21 June.
fn default_day() -> u32 {
    172
}
