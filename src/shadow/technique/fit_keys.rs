//! Keys of the fit: the range of depths and the strength of the warp; and their text.

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, auto_or_metres, number},
};
use crate::{
    maths::warp::Warp,
    shadow::settings::{ShadowPath, SunShadows},
};

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::new("near", "auto|metres > 0"),
        Key::new("distance", "auto|metres > 0"),
        Key::new("eta", "-1..=1, for the warp free"),
        Key::new("focus", "0..=1, share of the range in focus, for the warp tsm"),
    ],
    read,
    changes,
};

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    settings.warp = warp_of(settings.warp, pairs)?;
    if settings.path == ShadowPath::DropIn && settings.warp.eta() > Warp::Lispsm.eta() {
        return Err(TechniqueError::together(
            "`path=dropin` takes no warp stronger than lispsm: Bevy's bias cannot follow its texels",
        ));
    }
    if let Some(near) = pairs.read("near", auto_or_metres)? {
        settings.near = near;
    }
    if let Some(distance) = pairs.read("distance", auto_or_metres)? {
        settings.distance = distance;
    }
    Ok(())
}

fn warp_of(warp: Warp, pairs: &Pairs) -> Result<Warp, TechniqueError> {
    let eta = pairs.read("eta", |text| number(text, -1.0..=1.0))?;
    let focus = pairs.read("focus", |text| number(text, 0.0..=1.0))?;
    if eta.is_some() && !matches!(warp, Warp::Free { .. }) {
        return Err(TechniqueError::together("`eta=` belongs to the warp `free`"));
    }
    if focus.is_some() && !matches!(warp, Warp::Tsm { .. }) {
        return Err(TechniqueError::together("`focus=` belongs to the warp `tsm`"));
    }
    Ok(match warp {
        Warp::Free { eta: default } => Warp::Free {
            eta: eta.unwrap_or(default),
        },
        Warp::Tsm { focus: default } => Warp::Tsm {
            focus: focus.unwrap_or(default),
        },
        warp => warp,
    })
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    let mut pairs = Vec::new();
    if settings.near != default.near {
        pairs.push(format!("near={}", auto_text(settings.near)));
    }
    if settings.distance != default.distance {
        pairs.push(format!("distance={}", auto_text(settings.distance)));
    }
    match (settings.warp, default.warp) {
        (Warp::Free { eta }, Warp::Free { eta: default }) if eta != default => pairs.push(format!("eta={eta}")),
        (Warp::Tsm { focus }, Warp::Tsm { focus: default }) if focus != default => {
            pairs.push(format!("focus={focus}"));
        }
        _ => {}
    }
    pairs
}

/// The text of [`auto_or_metres`].
fn auto_text(metres: Option<f32>) -> String {
    metres.map_or_else(|| "auto".to_owned(), |metres| metres.to_string())
}
