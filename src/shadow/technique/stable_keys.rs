//! Keys of stability; and their text.

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic},
};
use crate::{
    maths::warp::Warp,
    shadow::{
        settings::{Faces, MapResolution, SunShadows},
        stable::Stability,
    },
};

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::full("stable", "off|sphere|quantised|held|sharp"),
        Key::full("frames", "2..=32, over which stable=sharp averages the shadow result"),
    ],
    read,
    changes,
};

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    if let Some(stable) = pairs.read("stable", |text| ALL.into_iter().find(|stable| name(*stable) == text))? {
        settings.stable = stable;
    }
    if let Some(given) = pairs.read("frames", |text| {
        text.parse::<u32>()
            .ok()
            .filter(|frames| Stability::FRAMES.contains(frames))
    })? {
        match &mut settings.stable {
            Stability::Sharp { frames } => *frames = given,
            _ => return Err(TechniqueError::together("`frames=` belongs to `stable=sharp`")),
        }
    }
    let stable = name(settings.stable);
    if settings.stable.is_uniform() && settings.warp != Warp::Uniform {
        return Err(TechniqueError::together(format!(
            "`stable={stable}` takes no warp: only texels of one size can be snapped to; `stable=held` and `stable=sharp` take \
             every warp"
        )));
    }
    let is_of_equal_slices =
        settings.partitions.faces == Faces::Together && settings.partitions.resolution == MapResolution::Equal;
    if settings.stable.holds_maps() && !is_of_equal_slices {
        return Err(TechniqueError::together(format!(
            "`stable={stable}` takes z-partitions with resolution=equal: its maps must be the same from frame to frame; \
             `stable=sharp` takes all"
        )));
    }
    if settings.stable == Stability::Sphere && settings.measured.is_on() {
        return Err(TechniqueError::together(format!(
            "`stable={stable}` takes no measured depths (near=auto, far=auto, splits=visible): they change from frame to \
             frame"
        )));
    }
    Ok(())
}

const ALL: [Stability; 5] = [
    Stability::Off,
    Stability::Sphere,
    Stability::Quantised,
    Stability::Held,
    Stability::SHARP,
];

fn name(stable: Stability) -> &'static str {
    match stable {
        Stability::Off => "off",
        Stability::Sphere => "sphere",
        Stability::Quantised => "quantised",
        Stability::Held => "held",
        Stability::Sharp { .. } => "sharp",
    }
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    let mut pairs = Vec::new();
    if settings.stable != default.stable {
        pairs.push(format!("stable={}", name(settings.stable)));
        if let Stability::Sharp { frames } = settings.stable
            && settings.stable != Stability::SHARP
        {
            pairs.push(format!("frames={frames}"));
        }
    }
    pairs
}
