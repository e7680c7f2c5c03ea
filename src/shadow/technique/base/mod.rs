//! Bases of techniques: what stands before `+` and `:`.
//!
//! A base is a file of this folder and a line of [`BASES`]. Keys that only some bases take belong to their topics.

mod faces;
mod optimal;
mod virtual_maps;
mod z_partitions;

pub(super) use faces::settings as faces_of;

use super::{error::TechniqueError, pairs::Topic, warps};
use crate::{maths::warp::Warp, shadow::settings::SunShadows};

/// Every base but `bevy`; the last takes all settings that are no other's.
pub(super) const BASES: [&Base; 6] = [
    &virtual_maps::TILED,
    &virtual_maps::QUERIED,
    &virtual_maps::FITTED,
    &optimal::BASE,
    &faces::BASE,
    &z_partitions::BASE,
];

/// One kind of technique.
pub(super) struct Base {
    /// Its names in a list, such as `zp1 to zp16`.
    pub(super) names: &'static str,
    /// The settings that its text and a warp mean without keys; nothing where the text is another base's.
    pub(super) read: fn(&str, Option<Warp>) -> Result<Option<SunShadows>, TechniqueError>,
    /// Whether settings are this base's.
    pub(super) owns: fn(&SunShadows) -> bool,
    /// Its text and the warp after the `+`, for settings of its own.
    pub(super) text: fn(&SunShadows) -> (String, Option<Warp>),
    /// Keys that it takes besides those of every base.
    pub(super) topics: &'static [&'static Topic],
}

/// The base and the settings that the text before the colon means.
pub(super) fn read(text: &str, warp: Option<Warp>) -> Result<(&'static Base, SunShadows), TechniqueError> {
    for base in BASES {
        if let Some(settings) = (base.read)(text, warp)? {
            return Ok((base, settings));
        }
    }
    Err(TechniqueError::Base { name: text.to_owned() })
}

/// The base that settings belong to.
pub(super) fn of(settings: &SunShadows) -> &'static Base {
    BASES
        .into_iter()
        .find(|base| (base.owns)(settings))
        .unwrap_or(&z_partitions::BASE)
}

/// All that can stand before the colon, for messages.
pub(super) fn available() -> String {
    let names: Vec<_> = BASES.iter().map(|base| base.names).collect();
    format!(
        "bevy, {} and the warps {}, alone or as in `zp4+lispsm`",
        names.join(", "),
        warps::names()
    )
}
