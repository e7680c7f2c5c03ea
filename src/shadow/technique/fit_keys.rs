//! Keys of the fit: the distance and the strength of the warp; and their text.

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, auto_or_metres, number, switch, switch_text},
};
use crate::{
    maths::{
        fit::ProjectionCenter,
        warp::{OptimumRule, Warp},
    },
    shadow::settings::{FitSettings, ShadowPath, SunShadows, WarpDirection},
};

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::new("distance", "auto|metres > 0"),
        Key::new("eta", "-1..=1, for the warp free"),
        Key::new("focus", "0..=1, share of the range in focus, for the warp tsm"),
        Key::new("center", "continuous|vertex: the projection centre of the warp"),
        Key::new("axis", "view|middle: the axis of the warp"),
        Key::new("optimum", "derived|literal|demo: how the formula of lispsm is read"),
        Key::new("pseudo_near", "auto|metres > 0 from which on the warp is at its best"),
        Key::new("pseudo_far", "auto|metres > 0 up to which the warp is at its best"),
        Key::new("guard", "on|off: weaker warps for light from inside the view cone"),
        Key::new("align", "on|off: whether light space turns with the view"),
    ],
    read,
    changes,
};

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    settings.warp = warp_of(settings.warp, pairs)?;
    read_variants(&mut settings.fit, pairs)?;
    if !settings.fit.align && settings.warp != Warp::Uniform {
        return Err(TechniqueError::together(
            "`align=off` takes no warp: a warp follows the view",
        ));
    }
    if settings.path == ShadowPath::DropIn && settings.largest_eta() > Warp::Lispsm.eta() {
        return Err(TechniqueError::together(
            "`path=dropin` takes no warp stronger than lispsm: Bevy's bias cannot follow its texels",
        ));
    }
    if let Some(distance) = pairs.read("distance", auto_or_metres)? {
        settings.distance = distance;
    }
    Ok(())
}

/// The papers' variants of the fit.
fn read_variants(fit: &mut FitSettings, pairs: &Pairs) -> Result<(), TechniqueError> {
    if let Some(center) = pairs.read("center", |text| find(&CENTERS, text))? {
        fit.center = center;
    }
    if let Some(axis) = pairs.read("axis", |text| find(&AXES, text))? {
        fit.axis = axis;
    }
    if let Some(optimum) = pairs.read("optimum", |text| find(&OPTIMA, text))? {
        fit.optimum = optimum;
    }
    if let Some(near) = pairs.read("pseudo_near", auto_or_metres)? {
        fit.pseudo_near = near;
    }
    if let Some(far) = pairs.read("pseudo_far", auto_or_metres)? {
        fit.pseudo_far = far;
    }
    if let Some(guard) = pairs.read("guard", switch)? {
        fit.guard = guard;
    }
    if let Some(align) = pairs.read("align", switch)? {
        fit.align = align;
    }
    Ok(())
}

const CENTERS: [(&str, ProjectionCenter); 2] = [
    ("continuous", ProjectionCenter::Continuous),
    ("vertex", ProjectionCenter::NearestVertex),
];

const AXES: [(&str, WarpDirection); 2] = [("view", WarpDirection::View), ("middle", WarpDirection::Middle)];

const OPTIMA: [(&str, OptimumRule); 3] = [
    ("derived", OptimumRule::Derived),
    ("literal", OptimumRule::Literal),
    ("demo", OptimumRule::Demo),
];

/// The value with this name.
fn find<T: Copy>(names: &[(&str, T)], text: &str) -> Option<T> {
    names.iter().find(|(name, _)| *name == text).map(|(_, value)| *value)
}

/// `key=name` where a value is not the default.
fn named<T: PartialEq>(key: &str, names: &[(&str, T)], value: T, default: T) -> Option<String> {
    let (name, _) = names.iter().find(|(_, named)| *named == value && value != default)?;
    Some(format!("{key}={name}"))
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
    pairs.extend(variant_changes(settings.fit, default.fit));
    pairs
}

fn variant_changes(fit: FitSettings, default: FitSettings) -> Vec<String> {
    let mut pairs = Vec::new();
    pairs.extend(named("center", &CENTERS, fit.center, default.center));
    pairs.extend(named("axis", &AXES, fit.axis, default.axis));
    pairs.extend(named("optimum", &OPTIMA, fit.optimum, default.optimum));
    for (key, depth, default) in [
        ("pseudo_near", fit.pseudo_near, default.pseudo_near),
        ("pseudo_far", fit.pseudo_far, default.pseudo_far),
    ] {
        if depth != default {
            pairs.push(format!("{key}={}", auto_text(depth)));
        }
    }
    for (key, is_on, default) in [("guard", fit.guard, default.guard), ("align", fit.align, default.align)] {
        if is_on != default {
            pairs.push(format!("{key}={}", switch_text(is_on)));
        }
    }
    pairs
}

/// The text of [`auto_or_metres`].
fn auto_text(metres: Option<f32>) -> String {
    metres.map_or_else(|| "auto".to_owned(), |metres| metres.to_string())
}
