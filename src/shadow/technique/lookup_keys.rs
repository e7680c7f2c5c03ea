//! Keys of the lookup: filter, bias, what maps store, blur; and their text.

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, metres, number},
};
use crate::shadow::{
    checked::TAPS,
    settings::{ShadowBias, ShadowBlur, ShadowFilter, ShadowPath, ShadowStore, SunShadows},
};

/// Metres of `bias=constant` when `bias_m` is not given.
const CONSTANT_BIAS: f32 = 0.05;

/// Metres of `bias=receiver` when `bias_m` is not given.
const RECEIVER_BIAS: f32 = 0.01;

/// Factor of `bias=slope` and `bias=world-slope` when `bias_scale` is not given (Scherzer 2005, section 4.2).
const SLOPE_FACTOR: f32 = 2.0;

/// Smallest steps of `bias=slope` when `bias_units` is not given (ditto).
const SLOPE_UNITS: f32 = 4.0;

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::full("filter", "hard|pcf2|poisson|pcss"),
        Key::full("taps", "8..=64, for filter=poisson and pcss"),
        Key::full("radius", "metres 0..=2 across the light, for filter=poisson and pcss"),
        Key::full("sun_diameter", "degrees 0..=10, for filter=pcss"),
        Key::new("bias", "none|footprint|constant|slope|world-slope|receiver"),
        Key::new("bias_m", "metres >= 0, for bias=constant and receiver"),
        Key::new("bias_scale", "a factor >= 0, for bias=footprint, slope and world-slope"),
        Key::full("bias_units", "smallest steps of depth >= 0, for bias=slope"),
        Key::full("store", "nearest|back|second|midpoint"),
        Key::full("blur", "iterations on the screen, 0..=16"),
        Key::full("blur_depth", "metres > 0 up to which pixels take part in all of blur="),
    ],
    read,
    changes,
};

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    settings.filter = filter_of(settings.filter, pairs)?;
    settings.bias = bias_of(settings.bias, settings.path, pairs)?;
    if let Some(store) = pairs.read("store", |text| match text {
        "nearest" => Some(ShadowStore::Nearest),
        "back" => Some(ShadowStore::BackFaces),
        "second" => Some(ShadowStore::SecondDepth),
        "midpoint" => Some(ShadowStore::Midpoint),
        _ => None,
    })? {
        settings.store = store;
    }
    if let Some(iterations) = pairs.read("blur", |text| {
        text.parse::<u32>()
            .ok()
            .filter(|count| *count <= ShadowBlur::MAX_ITERATIONS)
    })? {
        settings.blur.iterations = iterations;
    }
    if let Some(full_depth) = pairs.read("blur_depth", metres)? {
        settings.blur.full_depth = full_depth;
    }
    Ok(())
}

fn filter_of(default: ShadowFilter, pairs: &Pairs) -> Result<ShadowFilter, TechniqueError> {
    let taps = pairs
        .read("taps", |text| {
            text.parse::<u32>().ok().filter(|taps| TAPS.contains(taps))
        })?
        .unwrap_or(ShadowFilter::TAPS);
    let radius = pairs.read("radius", |text| number(text, 0.0..=ShadowFilter::LARGEST_RADIUS))?;
    let sun_diameter = pairs.read("sun_diameter", |text| number(text, 0.0..=ShadowFilter::LARGEST_SUN))?;
    let filter = pairs.read("filter", |text| match text {
        "hard" => Some(ShadowFilter::Hard),
        "pcf2" => Some(ShadowFilter::Pcf2),
        "poisson" => Some(ShadowFilter::Poisson {
            taps,
            radius: radius.unwrap_or(ShadowFilter::POISSON_RADIUS),
        }),
        "pcss" => Some(ShadowFilter::Pcss {
            taps,
            radius: radius.unwrap_or(ShadowFilter::PCSS_RADIUS),
            sun_diameter: sun_diameter.unwrap_or(ShadowFilter::SUN_DIAMETER),
        }),
        _ => None,
    })?;
    let filter = filter.unwrap_or(default);
    if matches!(filter, ShadowFilter::Hard | ShadowFilter::Pcf2) && (pairs.has("taps") || pairs.has("radius")) {
        return Err(TechniqueError::together(
            "`taps=` and `radius=` belong to `filter=poisson` and `filter=pcss`",
        ));
    }
    if sun_diameter.is_some() && !matches!(filter, ShadowFilter::Pcss { .. }) {
        return Err(TechniqueError::together("`sun_diameter=` belongs to `filter=pcss`"));
    }
    Ok(filter)
}

fn bias_of(default: ShadowBias, path: ShadowPath, pairs: &Pairs) -> Result<ShadowBias, TechniqueError> {
    let not_negative = |text: &str| number(text, 0.0..);
    let metres = pairs.read("bias_m", not_negative)?;
    let scale = pairs.read("bias_scale", not_negative)?;
    let units = pairs.read("bias_units", not_negative)?;
    let constant = ShadowBias::Constant {
        metres: metres.unwrap_or(CONSTANT_BIAS),
    };
    let footprint = ShadowBias::Footprint {
        scale: scale.unwrap_or(1.0),
    };
    let factor = scale.unwrap_or(SLOPE_FACTOR);
    let slope = ShadowBias::Slope {
        factor,
        units: units.unwrap_or(SLOPE_UNITS),
    };
    let bias = pairs.read("bias", |text| match text {
        "none" => Some(ShadowBias::None),
        "constant" => Some(constant),
        "footprint" => Some(footprint),
        "slope" => Some(slope),
        "world-slope" => Some(ShadowBias::WorldSlope { factor }),
        "receiver" => Some(ShadowBias::ReceiverPlane {
            metres: metres.unwrap_or(RECEIVER_BIAS),
        }),
        _ => None,
    })?;
    let bias = bias
        .or(metres.map(|_| constant))
        .or(scale.map(|_| footprint))
        .or(units.map(|_| slope))
        .unwrap_or(default);
    if path == ShadowPath::DropIn && !bias.is_for_drop_in() {
        return Err(TechniqueError::together(format!(
            "`{}` means nothing with `path=dropin`, where Bevy looks shadows up",
            bias_text(bias)
        )));
    }
    if metres.is_some() && !matches!(bias, ShadowBias::Constant { .. } | ShadowBias::ReceiverPlane { .. }) {
        return Err(TechniqueError::together(
            "`bias_m=` belongs to `bias=constant` and `bias=receiver`",
        ));
    }
    let is_factor = matches!(
        bias,
        ShadowBias::Footprint { .. } | ShadowBias::Slope { .. } | ShadowBias::WorldSlope { .. }
    );
    if scale.is_some() && !is_factor {
        return Err(TechniqueError::together(
            "`bias_scale=` belongs to `bias=footprint`, `bias=slope` and `bias=world-slope`",
        ));
    }
    if units.is_some() && !matches!(bias, ShadowBias::Slope { .. }) {
        return Err(TechniqueError::together("`bias_units=` belongs to `bias=slope`"));
    }
    Ok(bias)
}

/// `bias=` of a bias.
fn bias_text(bias: ShadowBias) -> &'static str {
    match bias {
        ShadowBias::None => "bias=none",
        ShadowBias::Constant { .. } => "bias=constant",
        ShadowBias::Footprint { .. } => "bias=footprint",
        ShadowBias::Slope { .. } => "bias=slope",
        ShadowBias::WorldSlope { .. } => "bias=world-slope",
        ShadowBias::ReceiverPlane { .. } => "bias=receiver",
    }
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    let mut pairs = Vec::new();
    if settings.filter != default.filter {
        let disc = |taps: u32, radius: f32| [format!("taps={taps}"), format!("radius={radius}")];
        match settings.filter {
            ShadowFilter::Hard => pairs.push("filter=hard".to_owned()),
            ShadowFilter::Pcf2 => pairs.push("filter=pcf2".to_owned()),
            ShadowFilter::Poisson { taps, radius } => {
                pairs.push("filter=poisson".to_owned());
                pairs.extend(disc(taps, radius));
            }
            ShadowFilter::Pcss {
                taps,
                radius,
                sun_diameter,
            } => {
                pairs.push("filter=pcss".to_owned());
                pairs.extend(disc(taps, radius));
                pairs.push(format!("sun_diameter={sun_diameter}"));
            }
        }
    }
    if settings.bias != default.bias {
        match settings.bias {
            ShadowBias::None => pairs.push(bias_text(settings.bias).to_owned()),
            ShadowBias::Constant { metres } => pairs.push(format!("bias_m={metres}")),
            ShadowBias::Footprint { scale } => pairs.push(format!("bias_scale={scale}")),
            ShadowBias::ReceiverPlane { metres } => pairs.push(format!("bias=receiver,bias_m={metres}")),
            ShadowBias::WorldSlope { factor } => pairs.push(format!("bias=world-slope,bias_scale={factor}")),
            ShadowBias::Slope { factor, units } => {
                pairs.push(format!("bias=slope,bias_scale={factor},bias_units={units}"));
            }
        }
    }
    if settings.store != default.store {
        pairs.push(format!("store={}", store_name(settings.store)));
    }
    if settings.blur.iterations != default.blur.iterations {
        pairs.push(format!("blur={}", settings.blur.iterations));
    }
    if settings.blur.full_depth != default.blur.full_depth {
        pairs.push(format!("blur_depth={}", settings.blur.full_depth));
    }
    pairs
}

/// The value of `store=`.
fn store_name(store: ShadowStore) -> &'static str {
    match store {
        ShadowStore::Nearest => "nearest",
        ShadowStore::BackFaces => "back",
        ShadowStore::SecondDepth => "second",
        ShadowStore::Midpoint => "midpoint",
    }
}
