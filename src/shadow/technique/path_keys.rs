//! Keys of the path and of its maps, their text, and what the drop-in path refuses.

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, switch, switch_text},
};
use crate::shadow::{
    checked::MAP_SIZES,
    layout::cells_per_side,
    settings::{CasterPasses, Faces, Partitions, ShadowPath, SunShadows, TransparentLayers},
};

/// Side of the largest texture that every desktop adapter has.
const MAX_ATLAS: u32 = 16_384;

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::new("path", "full|dropin"),
        Key::new("size", "texels per side of one map, 16..=8192"),
        Key::full("fallback", "on|off"),
        Key::full(
            "transparent_layer",
            "off|nearest|all: which transparent surfaces of a pixel have sharp shadows; on: the nearest",
        ),
        Key::full(
            "transparent_layers",
            "1..=8, the most that are drawn one behind the other with transparent_layer=all",
        ),
        Key::full("passes", "shared|each, of the casters"),
    ],
    read,
    changes,
};

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    if let Some(path) = pairs.read("path", |text| match text {
        "full" => Some(ShadowPath::Full),
        "dropin" => Some(ShadowPath::DropIn),
        _ => None,
    })? {
        if settings.path != path {
            settings.partitions.scheme = Partitions::scheme_of(path);
        }
        settings.path = path;
    }
    if settings.path == ShadowPath::DropIn {
        if settings.partitions.faces != Faces::Together {
            return Err(TechniqueError::together(
                "`path=dropin` has no face partitions: Bevy selects maps by view depth",
            ));
        }
        let count = settings.partitions.count;
        if count > SunShadows::MAX_DROP_IN_PARTITIONS {
            return Err(TechniqueError::together(format!(
                "`path=dropin` has at most {} z-partitions, not {count}",
                SunShadows::MAX_DROP_IN_PARTITIONS
            )));
        }
        if let Some(key) = pairs.keys().find(|key| key.is_full_only) {
            return Err(TechniqueError::together(format!(
                "`{}=` means nothing with `path=dropin`, where Bevy looks shadows up",
                key.name
            )));
        }
    }
    if let Some(size) = pairs.read("size", |text| {
        text.parse::<u32>().ok().filter(|size| MAP_SIZES.contains(size))
    })? {
        let count = settings.partitions.maps();
        let largest = MAX_ATLAS / cells_per_side(count);
        if size > largest {
            return Err(TechniqueError::together(format!(
                "`size={size}` is too large for {count} maps: at most {largest}"
            )));
        }
        if settings.path == ShadowPath::DropIn && !size.is_power_of_two() {
            return Err(TechniqueError::together(format!(
                "`path=dropin` needs a power of two as size, not {size}: Bevy draws no other maps"
            )));
        }
        settings.map_size = size;
    }
    if let Some(fallback) = pairs.read("fallback", switch)? {
        settings.fallback_map = fallback;
    }
    settings.transparent_layers = transparent_layers_of(settings.transparent_layers, pairs)?;
    if let Some(passes) = pairs.read("passes", |text| match text {
        "shared" => Some(CasterPasses::Shared),
        "each" => Some(CasterPasses::PerMap),
        _ => None,
    })? {
        settings.caster_passes = passes;
    }
    Ok(())
}

fn transparent_layers_of(default: TransparentLayers, pairs: &Pairs) -> Result<TransparentLayers, TechniqueError> {
    let count = pairs.read("transparent_layers", |text| {
        text.parse()
            .ok()
            .filter(|count| TransparentLayers::COUNTS.contains(count))
    })?;
    let layers = pairs.read("transparent_layer", |text| match text {
        "off" => Some(TransparentLayers::Off),
        "nearest" | "on" => Some(TransparentLayers::Nearest),
        "all" => Some(TransparentLayers::All {
            count: count.unwrap_or(TransparentLayers::COUNT),
        }),
        _ => None,
    })?;
    let layers = layers.unwrap_or(default);
    if count.is_some() && !matches!(layers, TransparentLayers::All { .. }) {
        return Err(TechniqueError::together(
            "`transparent_layers=` belongs to `transparent_layer=all`",
        ));
    }
    Ok(layers)
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    let mut pairs = Vec::new();
    if settings.path != default.path {
        pairs.push("path=dropin".to_owned());
    }
    if settings.map_size != default.map_size {
        pairs.push(format!("size={}", settings.map_size));
    }
    if settings.fallback_map != default.fallback_map {
        pairs.push(format!("fallback={}", switch_text(settings.fallback_map)));
    }
    if settings.transparent_layers != default.transparent_layers {
        let (name, count) = match settings.transparent_layers {
            TransparentLayers::Off => ("off", None),
            TransparentLayers::Nearest => ("nearest", None),
            TransparentLayers::All { count } => ("all", Some(count)),
        };
        pairs.push(format!("transparent_layer={name}"));
        if let Some(count) = count.filter(|count| *count != TransparentLayers::COUNT) {
            pairs.push(format!("transparent_layers={count}"));
        }
    }
    if settings.caster_passes != default.caster_passes {
        pairs.push("passes=each".to_owned());
    }
    pairs
}
