//! `fp` and `fpN`: face partitions.

use super::Base;
use crate::{
    maths::warp::Warp,
    shadow::{
        settings::{Faces, MapResolution, Partitions, SunShadows},
        technique::{
            default_map_size,
            error::TechniqueError,
            pairs::{Key, Pairs, Topic, switch, switch_text},
            partition_keys,
        },
    },
};

pub(super) const BASE: Base = Base {
    names: "fp, fp2 to fp4",
    read,
    owns: |settings| settings.partitions.faces != Faces::Together,
    text,
    topics: &[&TOPIC, &partition_keys::TOPIC],
};

const TOPIC: Topic = Topic {
    keys: &[Key::full("near_map", "on|off: whether the near face has a map, for fp")],
    read: read_keys,
    changes,
};

/// What `fpN` means without keys: maps balanced, because the faces need very different numbers of texels, and one of the
/// near face where 16 maps leave room for it.
pub(in super::super) fn settings(slices: u32, warp: Warp) -> SunShadows {
    let faces = [true, false]
        .map(|near_map| Faces::Apart { near_map })
        .into_iter()
        .find(|faces| faces.maps(slices) <= SunShadows::MAX_PARTITIONS)
        .unwrap_or_default();
    SunShadows {
        partitions: Partitions {
            faces,
            resolution: MapResolution::Balanced,
            ..Partitions::slices(slices)
        },
        warp,
        map_size: default_map_size(faces.maps(slices)),
        ..SunShadows::HIGH
    }
}

fn read(text: &str, warp: Option<Warp>) -> Result<Option<SunShadows>, TechniqueError> {
    let Some(digits) = text.strip_prefix("fp") else {
        return Ok(None);
    };
    let slices = match (digits, digits.parse()) {
        ("", _) => 1,
        (_, Ok(slices @ 1..=SunShadows::MAX_FACE_SLICES)) => slices,
        _ => {
            return Err(TechniqueError::Count {
                text: text.to_owned(),
                expected: "the slices of face partitions are counted 1 to 4, as in `fp2`, because 16 maps are the most",
            });
        }
    };
    Ok(Some(settings(slices, warp.unwrap_or(Warp::Uniform))))
}

fn text(settings: &SunShadows) -> (String, Option<Warp>) {
    let name = match settings.partitions.count {
        1 => "fp".to_owned(),
        slices => format!("fp{slices}"),
    };
    (name, Some(settings.warp).filter(|warp| *warp != Warp::Uniform))
}

fn read_keys(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    let Some(near_map) = pairs.read("near_map", switch)? else {
        return Ok(());
    };
    let faces = Faces::Apart { near_map };
    let slices = settings.partitions.count;
    if faces.maps(slices) > SunShadows::MAX_PARTITIONS {
        return Err(TechniqueError::together(format!(
            "`fp{slices}` has 16 maps for the sides alone: `near_map=on` has no room"
        )));
    }
    settings.partitions.faces = faces;
    Ok(())
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    match (settings.partitions.faces, default.partitions.faces) {
        (faces @ Faces::Apart { near_map }, default) if faces != default => {
            vec![format!("near_map={}", switch_text(near_map))]
        }
        _ => Vec::new(),
    }
}
