//! Keys of the seams between maps and of the end of the range; and their text.

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, metres, number},
};
use crate::shadow::settings::{SeamWidth, SunShadows};

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::full(
            "seam",
            "off|a share 0..=0.5|metres as in 2m: width of the blend between maps",
        ),
        Key::full(
            "fade",
            "0..=1: share of the distance over which shadows fade out at its end",
        ),
    ],
    read,
    changes,
};

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    if let Some(width) = pairs.read("seam", width)? {
        settings.seams.width = width;
    }
    if let Some(fade) = pairs.read("fade", |text| number(text, 0.0..=1.0))? {
        settings.seams.fade = fade;
    }
    Ok(())
}

fn width(text: &str) -> Option<SeamWidth> {
    match text.strip_suffix('m') {
        _ if text == "off" => Some(SeamWidth::None),
        Some(length) => metres(length).map(SeamWidth::Metres),
        None => number(text, 0.0..=SeamWidth::LARGEST_SHARE).map(SeamWidth::Share),
    }
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    let mut pairs = Vec::new();
    if settings.seams.width != default.seams.width {
        pairs.push(match settings.seams.width {
            SeamWidth::None => "seam=off".to_owned(),
            SeamWidth::Share(share) => format!("seam={share}"),
            SeamWidth::Metres(metres) => format!("seam={metres}m"),
        });
    }
    if settings.seams.fade != default.seams.fade {
        pairs.push(format!("fade={}", settings.seams.fade));
    }
    pairs
}
