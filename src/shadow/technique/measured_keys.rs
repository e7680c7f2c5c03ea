//! Keys of the planes that depths in the picture decide; and their text. `splits=visible` is with the other splits.

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, metres},
};
use crate::shadow::{
    measured::{MeasureUse, NearMeasurement},
    settings::{ShadowPath, SunShadows},
};

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::new(
            "near",
            "bounds|auto|metres > 0, of warps; left out: auto for warps of two z-partitions or more",
        ),
        Key::full("far", "bounds|auto"),
        Key::full("measure", "late|same, for near=auto, far=auto and splits=visible"),
    ],
    read,
    changes,
};

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    if let Some(near) = pairs.read("near", near_of)? {
        (settings.measured.near, settings.near) = near;
    }
    if let Some(far) = pairs.read("far", |text| match text {
        "bounds" => Some(false),
        "auto" => Some(true),
        _ => None,
    })? {
        settings.measured.far = far;
    }
    if let Some(measure) = pairs.read("measure", |text| match text {
        "late" => Some(MeasureUse::Late),
        "same" => Some(MeasureUse::Same),
        _ => None,
    })? {
        settings.measured.measure = measure;
        if !settings.measures().is_on() {
            return Err(TechniqueError::together(
                "`measure=` belongs to `near=auto`, `far=auto` and `splits=visible`",
            ));
        }
    }
    if settings.path == ShadowPath::DropIn && settings.measured.is_on() {
        return Err(TechniqueError::together(
            "`path=dropin` takes no measured depths (near=auto, far=auto, splits=visible): they are read from the full \
             path's prepass",
        ));
    }
    Ok(())
}

/// Whether the near plane is measured, and its metres.
fn near_of(text: &str) -> Option<(NearMeasurement, Option<f32>)> {
    match text {
        "bounds" => Some((NearMeasurement::Off, None)),
        "auto" => Some((NearMeasurement::On, None)),
        _ => metres(text).map(|near| (NearMeasurement::Slices, Some(near))),
    }
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    let mut pairs = Vec::new();
    let near_text = |settings: &SunShadows| match (settings.measured.near, settings.near) {
        (NearMeasurement::On, _) => Some("auto".to_owned()),
        (_, Some(near)) => Some(near.to_string()),
        (NearMeasurement::Off, None) => Some("bounds".to_owned()),
        (NearMeasurement::Slices, None) => None,
    };
    if let Some(near) = near_text(settings).filter(|near| near_text(default).as_ref() != Some(near)) {
        pairs.push(format!("near={near}"));
    }
    if settings.measured.far != default.measured.far {
        pairs.push(format!("far={}", if settings.measured.far { "auto" } else { "bounds" }));
    }
    if settings.measured.measure != default.measured.measure && settings.measures().is_on() {
        pairs.push(match settings.measured.measure {
            MeasureUse::Late => "measure=late".to_owned(),
            MeasureUse::Same => "measure=same".to_owned(),
        });
    }
    pairs
}
