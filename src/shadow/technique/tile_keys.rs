//! Keys of virtual maps: tiles, refinement, memory; and their text.

use std::ops::RangeInclusive;

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, number, switch, switch_text},
};
use crate::{
    maths::virtual_map::{
        queried::{ChangeThreshold, JumpExponent, OpportunityJump, QueriedMap, Splitting},
        tiled::MAX_TILES_PER_AXIS,
    },
    shadow::{
        settings::{ShadowPath, SunShadows},
        virtual_maps::{MAX_QUERIED_TILES, MEMORY, QueriedMaps, ShadowMaps, TILE_SIZES, TiledMaps},
    },
};

const TILE: Key = Key::full("tile", "texels per side of a tile, 16..=8192");
pub(super) const MEMORY_KEY: Key = Key::full("memory", "MiB of tiles alive at once, 1..=4096");

pub(super) const TILED: Topic = Topic {
    keys: &[
        Key::full("n", "tiles per axis, 1..=32"),
        TILE,
        Key::full("skip", "on|off, whether tiles without receivers are left out"),
        Key::full(
            "progressive",
            "on|off, whether tiles become more while the camera rests",
        ),
        MEMORY_KEY,
    ],
    read: read_tiled,
    changes: |settings, default| match (&settings.maps, &default.maps) {
        (ShadowMaps::Tiled(maps), ShadowMaps::Tiled(default)) => tiled_changes(maps, default),
        _ => Vec::new(),
    },
};

pub(super) const QUERIED: Topic = Topic {
    keys: &[
        Key::full(
            "min",
            "changed pixels >= 0 of 1024 x 1024 above which a tile is refined",
        ),
        Key::full("share", "0..=1, changed pixels of those in the tile; in place of min="),
        Key::full("max", "tiles per axis, 1..=256"),
        TILE,
        Key::full("tile_max", "texels per side after a jump, 16..=8192"),
        Key::full("parts", "quad|binary|grid3"),
        Key::full("jumps", "both|maximum|opportunity|none"),
        Key::full("decay", "0..=1, by which counts fall with each step"),
        Key::full("exponent", "measured|ratio|steps, of decay="),
        Key::full("split_first", "on|off, whatever the first tile changes"),
        MEMORY_KEY,
    ],
    read: read_queried,
    changes: |settings, default| match (&settings.maps, &default.maps) {
        (ShadowMaps::Queried(maps), ShadowMaps::Queried(default)) => queried_changes(maps, default),
        _ => Vec::new(),
    },
};

/// What every base of virtual maps refuses.
pub(super) fn check(settings: &SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    if settings.path == ShadowPath::DropIn {
        return Err(TechniqueError::together(
            "`path=dropin` has no virtual maps: Bevy looks up no tiles",
        ));
    }
    if pairs.has("size") {
        return Err(TechniqueError::together(
            "`size=` means nothing with virtual maps, whose tiles have a side of `tile=`",
        ));
    }
    if pairs.has("passes") {
        return Err(TechniqueError::together(
            "`passes=` means nothing with virtual maps: the casters of all tiles are those of one list",
        ));
    }
    let is_layered = pairs.read("store", |text| Some(["second", "midpoint"].contains(&text)))?;
    if is_layered == Some(true) {
        return Err(TechniqueError::together(
            "virtual maps hold one surface: `store=nearest` or `store=back`",
        ));
    }
    Ok(())
}

/// A whole number within a range.
pub(super) fn whole(text: &str, range: RangeInclusive<u32>) -> Option<u32> {
    text.parse().ok().filter(|value| range.contains(value))
}

/// Overwrites a value if the key was given.
pub(super) fn set<T>(
    target: &mut T,
    pairs: &Pairs,
    key: &str,
    parse: impl FnOnce(&str) -> Option<T>,
) -> Result<(), TechniqueError> {
    if let Some(value) = pairs.read(key, parse)? {
        *target = value;
    }
    Ok(())
}

fn read_tiled(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    check(settings, pairs)?;
    let ShadowMaps::Tiled(maps) = &mut settings.maps else {
        return Ok(());
    };
    set(&mut maps.tiles_per_axis, pairs, "n", |text| {
        whole(text, 1..=MAX_TILES_PER_AXIS)
    })?;
    set(&mut maps.tile_size, pairs, "tile", |text| whole(text, TILE_SIZES))?;
    set(&mut maps.skip_empty, pairs, "skip", switch)?;
    set(&mut maps.progressive, pairs, "progressive", switch)?;
    set(&mut maps.memory, pairs, "memory", |text| whole(text, MEMORY))
}

fn tiled_changes(maps: &TiledMaps, default: &TiledMaps) -> Vec<String> {
    let mut pairs = Vec::new();
    if maps.tiles_per_axis != default.tiles_per_axis {
        pairs.push(format!("n={}", maps.tiles_per_axis));
    }
    if maps.tile_size != default.tile_size {
        pairs.push(format!("tile={}", maps.tile_size));
    }
    if maps.skip_empty != default.skip_empty {
        pairs.push(format!("skip={}", switch_text(maps.skip_empty)));
    }
    if maps.progressive != default.progressive {
        pairs.push(format!("progressive={}", switch_text(maps.progressive)));
    }
    if maps.memory != default.memory {
        pairs.push(format!("memory={}", maps.memory));
    }
    pairs
}

fn read_queried(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    check(settings, pairs)?;
    let ShadowMaps::Queried(maps) = &mut settings.maps else {
        return Ok(());
    };
    let map = &mut maps.refinement;
    if pairs.has("min") && pairs.has("share") {
        return Err(TechniqueError::together(
            "`min=` and `share=` are two measures of one threshold",
        ));
    }
    let not_negative = |text: &str| number(text, 0.0..).map(f64::from);
    set(&mut map.threshold, pairs, "min", |text| {
        not_negative(text).map(ChangeThreshold::Pixels)
    })?;
    let share = |text: &str| number(text, 0.0..=1.0).map(f64::from);
    set(&mut map.threshold, pairs, "share", |text| {
        share(text).map(ChangeThreshold::Share)
    })?;
    set(&mut map.max_tiles_per_axis, pairs, "max", |text| {
        whole(text, 1..=MAX_QUERIED_TILES)
    })?;
    set(&mut map.tile_size, pairs, "tile", |text| whole(text, TILE_SIZES))?;
    match pairs.read("tile_max", |text| whole(text, TILE_SIZES))? {
        Some(size) if size < map.tile_size => {
            return Err(TechniqueError::together(format!(
                "`tile_max={size}` is less than `tile={}`: tiles grow with a jump",
                map.tile_size
            )));
        }
        Some(size) => map.tile_size_max = size,
        None => map.tile_size_max = map.tile_size_max.max(map.tile_size),
    }
    set(&mut map.splitting, pairs, "parts", |text| by_name(&SPLITTINGS, text))?;
    read_jumps(map, pairs)?;
    set(&mut map.force_first_split, pairs, "split_first", switch)?;
    set(&mut maps.memory, pairs, "memory", |text| whole(text, MEMORY))
}

const SPLITTINGS: [(&str, Splitting); 3] = [
    ("quad", Splitting::Quad),
    ("binary", Splitting::Binary),
    ("grid3", Splitting::Grid3),
];

const EXPONENTS: [(&str, JumpExponent); 3] = [
    ("measured", JumpExponent::Measured),
    ("ratio", JumpExponent::Ratio),
    ("steps", JumpExponent::Steps),
];

/// Maximum and opportunity jumps.
const JUMPS: [(&str, (bool, bool)); 4] = [
    ("both", (true, true)),
    ("maximum", (true, false)),
    ("opportunity", (false, true)),
    ("none", (false, false)),
];

fn by_name<T: Copy>(table: &[(&str, T)], name: &str) -> Option<T> {
    table.iter().find(|(known, _)| *known == name).map(|(_, value)| *value)
}

fn name_of<'a, T: PartialEq>(table: &[(&'a str, T)], value: &T) -> &'a str {
    table
        .iter()
        .find(|(_, known)| known == value)
        .map_or("", |(name, _)| *name)
}

/// What an opportunity jump assumes when nothing is said.
fn default_jump() -> OpportunityJump {
    QueriedMap::default().opportunity_jump.unwrap_or(OpportunityJump {
        decay: 0.25,
        exponent: JumpExponent::Measured,
    })
}

fn read_jumps(map: &mut QueriedMap, pairs: &Pairs) -> Result<(), TechniqueError> {
    let (maximum, opportunity) = pairs
        .read("jumps", |text| by_name(&JUMPS, text))?
        .unwrap_or((map.maximum_jump, map.opportunity_jump.is_some()));
    if !opportunity && (pairs.has("decay") || pairs.has("exponent")) {
        return Err(TechniqueError::together(
            "`decay=` and `exponent=` belong to `jumps=both` and `jumps=opportunity`",
        ));
    }
    map.maximum_jump = maximum;
    let mut jump = map.opportunity_jump.unwrap_or(default_jump());
    set(&mut jump.decay, pairs, "decay", |text| {
        number(text, 0.0..=1.0).map(f64::from)
    })?;
    set(&mut jump.exponent, pairs, "exponent", |text| by_name(&EXPONENTS, text))?;
    map.opportunity_jump = opportunity.then_some(jump);
    Ok(())
}

fn queried_changes(maps: &QueriedMaps, default_maps: &QueriedMaps) -> Vec<String> {
    let (map, default) = (&maps.refinement, &default_maps.refinement);
    let mut pairs = Vec::new();
    if map.threshold != default.threshold {
        pairs.push(match map.threshold {
            ChangeThreshold::Pixels(pixels) => format!("min={pixels}"),
            ChangeThreshold::Share(share) => format!("share={share}"),
        });
    }
    for (key, value, default) in [
        ("max", map.max_tiles_per_axis, default.max_tiles_per_axis),
        ("tile", map.tile_size, default.tile_size),
        ("tile_max", map.tile_size_max, default.tile_size_max),
        ("memory", maps.memory, default_maps.memory),
    ] {
        if value != default {
            pairs.push(format!("{key}={value}"));
        }
    }
    if map.splitting != default.splitting {
        pairs.push(format!("parts={}", name_of(&SPLITTINGS, &map.splitting)));
    }
    let jumps = |map: &QueriedMap| (map.maximum_jump, map.opportunity_jump.is_some());
    if jumps(map) != jumps(default) {
        pairs.push(format!("jumps={}", name_of(&JUMPS, &jumps(map))));
    }
    if let Some(jump) = map.opportunity_jump {
        let default = default_jump();
        if jump.decay != default.decay {
            pairs.push(format!("decay={}", jump.decay));
        }
        if jump.exponent != default.exponent {
            pairs.push(format!("exponent={}", name_of(&EXPONENTS, &jump.exponent)));
        }
    }
    if map.force_first_split != default.force_first_split {
        pairs.push(format!("split_first={}", switch_text(map.force_first_split)));
    }
    pairs
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{maths::warp::Warp, shadow::technique::Technique};

    fn settings(text: &str) -> SunShadows {
        match text.parse() {
            Ok(Technique::Umbrage(settings)) => settings,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn bases_have_their_defaults() {
        let tiled = settings("tiled");
        assert_eq!(tiled.maps, ShadowMaps::Tiled(TiledMaps::default()));
        assert_eq!((tiled.partitions.count, tiled.warp), (1, Warp::Uniform));
        assert_eq!(
            settings("tiled:n=16,tile=2048,skip=off,progressive=off,memory=64"),
            tiled
        );
        assert_eq!(settings("tiled+lispsm").warp, Warp::Lispsm);
        assert_eq!(
            settings("queried:tile=8192"),
            settings("queried:tile=8192,tile_max=8192")
        );
        let queried = settings("queried");
        assert_eq!(queried.maps, ShadowMaps::Queried(QueriedMaps::default()));
        assert_eq!(
            settings("queried:min=300,max=32,tile=1024,tile_max=4096,jumps=both"),
            queried
        );
    }

    #[test]
    fn what_virtual_maps_do_not_have_is_said() {
        for (text, parts) in [
            ("tiled:n=33", &["`n=33`", "1..=32"][..]),
            ("tiled:size=512", &["`size=`", "`tile=`"]),
            ("tiled:path=dropin", &["path=dropin"]),
            ("tiled:store=second", &["one surface"]),
            ("tiled:split=log", &["`split=`", "`tiled`"]),
            ("tiled:min=3", &["`min=`", "`tiled`"]),
            ("zp4:tile=512", &["`tile=`", "`zp4`"]),
            ("queried:min=1,share=0.5", &["two measures"]),
            ("queried:jumps=maximum,decay=0.5", &["jumps=opportunity"]),
            ("queried:min=-1", &["`min=-1`"]),
            ("queried:tile=512,tile_max=256", &["`tile_max=256`", "`tile=512`"]),
            ("tiled:passes=each", &["`passes=`"]),
            ("fitted:passes=shared", &["`passes=`"]),
        ] {
            let message = text.parse::<Technique>().expect_err(text).to_string();
            for part in parts {
                assert!(message.contains(part), "{text}: {message:?} lacks {part:?}");
            }
        }
    }

    prop_compose! {
        fn any_maps()(
            size in TILE_SIZES,
            size_max in TILE_SIZES,
            memory in MEMORY,
            tiles in 1..=MAX_TILES_PER_AXIS,
            finest in 1..=MAX_QUERIED_TILES,
            threshold in prop_oneof![
                (0.0f32..1e6).prop_map(|pixels| ChangeThreshold::Pixels(f64::from(pixels))),
                (0.0f32..=1.0).prop_map(|share| ChangeThreshold::Share(f64::from(share))),
            ],
            splitting in prop::sample::select(SPLITTINGS.map(|(_, splitting)| splitting).to_vec()),
            jump in prop::option::of((0.0f32..=1.0, prop::sample::select(EXPONENTS.map(|(_, exponent)| exponent).to_vec()))),
            [is_tiled, a, b] in any::<[bool; 3]>(),
        ) -> ShadowMaps {
            if is_tiled {
                return ShadowMaps::Tiled(TiledMaps {
                    tiles_per_axis: tiles, tile_size: size, skip_empty: a, progressive: b, memory,
                });
            }
            ShadowMaps::Queried(QueriedMaps {
                refinement: QueriedMap {
                    threshold,
                    max_tiles_per_axis: finest,
                    tile_size: size,
                    tile_size_max: size_max.max(size),
                    splitting,
                    maximum_jump: a,
                    opportunity_jump: jump.map(|(decay, exponent)| OpportunityJump { decay: f64::from(decay), exponent }),
                    force_first_split: b,
                    ..QueriedMap::default()
                },
                memory,
            })
        }
    }

    proptest! {
        #[test]
        fn text_round_trips(maps in any_maps()) {
            let base = if matches!(maps, ShadowMaps::Tiled(_)) { "tiled+lispsm" } else { "queried" };
            let technique = Technique::Umbrage(SunShadows { maps, ..settings(base) });
            prop_assert_eq!(technique.to_string().parse(), Ok(technique));
        }
    }
}
