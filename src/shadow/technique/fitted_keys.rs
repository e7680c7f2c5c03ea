//! Keys of fitted maps, and their text.

use std::ops::RangeInclusive;

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, number},
    tile_keys::{MEMORY_KEY, check, set, whole},
};
use crate::{
    maths::virtual_map::{
        mapping::{NeedMeasure, NeighbourPick},
        memory::TextureMode,
    },
    shadow::{
        fitted::{FittedMaps, NeedFeedback, NeedMapping},
        settings::SunShadows,
        virtual_maps::{MEMORY, ShadowMaps},
    },
};

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::full("slices", "z-partitions with a map each, 1..=16"),
        Key::full("xi", "levels off every need, -4..=5; less is finer"),
        Key::full("n", "most tiles per axis, a power of two 1..=64"),
        Key::full(
            "tile_max",
            "texels per side of the largest tile, a power of two 64..=8192",
        ),
        Key::full("map", "full|texels per side of the mapping map, 16..=1024"),
        Key::full("encoding", "log2|bytes, for a mapping map"),
        Key::full("pick", "smaller|larger"),
        Key::full("need", "sides|extent|box"),
        Key::full("discard", "share of a cell's pixels, 0..=1"),
        Key::full("mode", "0 full|1 corner|2 squares|3 exact textures"),
        Key::full("tile_cost", "texels, or off"),
        Key::full("feedback", "same|next"),
        Key::full("step", "metres per frame 0..=10, for feedback=next"),
        Key::full("turn", "degrees per frame 0..=45, for feedback=next"),
        MEMORY_KEY,
    ],
    read,
    changes,
};

const MODES: [TextureMode; 4] = [
    TextureMode::Full,
    TextureMode::Corner,
    TextureMode::SquareSeries,
    TextureMode::Exact,
];

/// A power of two within a range.
fn power(text: &str, range: RangeInclusive<u32>) -> Option<u32> {
    whole(text, range).filter(|value| value.is_power_of_two())
}

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    check(settings, pairs)?;
    for key in ["select", "resolution"] {
        if pairs.has(key) {
            return Err(TechniqueError::together(format!(
                "`{key}=` means nothing with `fitted`: pixels find their map by depth, and each is as fine as they need it"
            )));
        }
    }
    set(&mut settings.partitions.count, pairs, "slices", |text| {
        whole(text, 1..=SunShadows::MAX_PARTITIONS)
    })?;
    let ShadowMaps::Fitted(fitted) = &mut settings.maps else {
        return Ok(());
    };
    set(&mut fitted.quality_drop, pairs, "xi", |text| {
        text.parse()
            .ok()
            .filter(|levels| FittedMaps::QUALITY_DROPS.contains(levels))
    })?;
    set(&mut fitted.tiles_per_axis, pairs, "n", |text| {
        power(text, FittedMaps::TILES_PER_AXIS)
    })?;
    set(&mut fitted.tile_size_max, pairs, "tile_max", |text| {
        power(text, FittedMaps::TILE_SIZES)
    })?;
    fitted.mapping = mapping_of(fitted.mapping, pairs)?;
    set(&mut fitted.pick, pairs, "pick", |text| match text {
        "smaller" => Some(NeighbourPick::Smaller),
        "larger" => Some(NeighbourPick::Larger),
        _ => None,
    })?;
    set(&mut fitted.measure, pairs, "need", |text| match text {
        "sides" => Some(NeedMeasure::Sides),
        "extent" => Some(NeedMeasure::Extent),
        "box" => Some(NeedMeasure::Box),
        _ => None,
    })?;
    set(&mut fitted.discard, pairs, "discard", |text| number(text, 0.0..=1.0))?;
    set(&mut fitted.texture_mode, pairs, "mode", |text| {
        text.parse::<usize>().ok().and_then(|mode| MODES.get(mode).copied())
    })?;
    set(&mut fitted.tile_cost, pairs, "tile_cost", |text| match text {
        "off" => Some(None),
        text => text.parse::<u32>().ok().map(Some),
    })?;
    fitted.feedback = feedback_of(fitted.feedback, pairs)?;
    set(&mut fitted.memory, pairs, "memory", |text| whole(text, MEMORY))
}

fn mapping_of(default: NeedMapping, pairs: &Pairs) -> Result<NeedMapping, TechniqueError> {
    let bytes = pairs.read("encoding", |text| match text {
        "log2" => Some(false),
        "bytes" => Some(true),
        _ => None,
    })?;
    let mapping = pairs.read("map", |text| match text {
        "full" => Some(NeedMapping::Full),
        text => {
            let size = text
                .parse::<u32>()
                .ok()
                .filter(|size| FittedMaps::MAP_SIZES.contains(size))?;
            Some(NeedMapping::Low {
                size,
                bytes: bytes.unwrap_or(false),
            })
        }
    })?;
    let mapping = mapping.unwrap_or(default);
    if bytes.is_some() && mapping == NeedMapping::Full {
        return Err(TechniqueError::together(
            "`encoding=` belongs to a mapping map, as in `map=256`",
        ));
    }
    Ok(mapping)
}

fn feedback_of(default: NeedFeedback, pairs: &Pairs) -> Result<NeedFeedback, TechniqueError> {
    let (step, turn) = (
        pairs.read("step", |text| number(text, 0.0..=10.0))?,
        pairs.read("turn", |text| number(text, 0.0..=45.0))?,
    );
    let next = NeedFeedback::NextFrame {
        step: step.unwrap_or(NeedFeedback::STEP),
        turn: turn.unwrap_or(NeedFeedback::TURN),
    };
    let feedback = pairs.read("feedback", |text| match text {
        "same" => Some(NeedFeedback::SameFrame),
        "next" => Some(next),
        _ => None,
    })?;
    let feedback = feedback.unwrap_or(default);
    if (step.is_some() || turn.is_some()) && feedback == NeedFeedback::SameFrame {
        return Err(TechniqueError::together(
            "`step=` and `turn=` belong to `feedback=next`",
        ));
    }
    Ok(feedback)
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    let (ShadowMaps::Fitted(found), ShadowMaps::Fitted(default)) = (&settings.maps, &default.maps) else {
        return Vec::new();
    };
    let mut pairs = Vec::new();
    let mut push = |is_changed: bool, text: String| {
        if is_changed {
            pairs.push(text);
        }
    };
    let slices = settings.partitions.count;
    push(slices != 1, format!("slices={slices}"));
    push(
        found.quality_drop != default.quality_drop,
        format!("xi={}", found.quality_drop),
    );
    push(
        found.tiles_per_axis != default.tiles_per_axis,
        format!("n={}", found.tiles_per_axis),
    );
    push(
        found.tile_size_max != default.tile_size_max,
        format!("tile_max={}", found.tile_size_max),
    );
    push(
        found.mapping != default.mapping,
        match found.mapping {
            NeedMapping::Full => "map=full".to_owned(),
            NeedMapping::Low { size, bytes: false } => format!("map={size}"),
            NeedMapping::Low { size, bytes: true } => format!("map={size},encoding=bytes"),
        },
    );
    push(
        found.pick != default.pick,
        match found.pick {
            NeighbourPick::Smaller => "pick=smaller".to_owned(),
            NeighbourPick::Larger => "pick=larger".to_owned(),
        },
    );
    push(
        found.measure != default.measure,
        match found.measure {
            NeedMeasure::Sides => "need=sides".to_owned(),
            NeedMeasure::Extent => "need=extent".to_owned(),
            NeedMeasure::Box => "need=box".to_owned(),
        },
    );
    push(found.discard != default.discard, format!("discard={}", found.discard));
    let mode = MODES
        .iter()
        .position(|mode| *mode == found.texture_mode)
        .unwrap_or_default();
    push(found.texture_mode != default.texture_mode, format!("mode={mode}"));
    push(
        found.tile_cost != default.tile_cost,
        match found.tile_cost {
            Some(cost) => format!("tile_cost={cost}"),
            None => "tile_cost=off".to_owned(),
        },
    );
    if let NeedFeedback::NextFrame { step, turn } = found.feedback {
        push(true, "feedback=next".to_owned());
        push(step != NeedFeedback::STEP, format!("step={step}"));
        push(turn != NeedFeedback::TURN, format!("turn={turn}"));
    }
    push(found.memory != default.memory, format!("memory={}", found.memory));
    pairs
}

#[cfg(test)]
mod tests {
    use crate::shadow::technique::Technique;

    use super::*;

    fn fitted(text: &str) -> FittedMaps {
        match text.parse() {
            Ok(Technique::Umbrage(SunShadows {
                maps: ShadowMaps::Fitted(fitted),
                ..
            })) => fitted,
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn every_key_reaches_its_setting_and_comes_back() {
        assert_eq!(fitted("fitted"), FittedMaps::default());
        let all = "fitted+lispsm:xi=-3,n=16,tile_max=2048,map=256,encoding=bytes,pick=larger,need=box,discard=0.005,\
            mode=3,tile_cost=off,feedback=next,step=0.5,turn=3,memory=16";
        let expected = FittedMaps {
            quality_drop: -3,
            tiles_per_axis: 16,
            tile_size_max: 2048,
            mapping: NeedMapping::Low { size: 256, bytes: true },
            pick: NeighbourPick::Larger,
            measure: NeedMeasure::Box,
            discard: 0.005,
            texture_mode: TextureMode::Exact,
            tile_cost: None,
            feedback: NeedFeedback::NextFrame { step: 0.5, turn: 3.0 },
            memory: 16,
        };
        assert_eq!(fitted(all), expected);
        for text in [
            all,
            "fitted",
            "fitted+psm:xi=5",
            "fitted:map=64",
            "fitted:need=extent,tile_cost=1000",
            "fitted:feedback=next",
            "fitted+lispsm:slices=4,split=log",
            "fitted:slices=2,xi=1,splits=20",
        ] {
            let technique: Technique = text.parse().unwrap_or_else(|error| panic!("{text}: {error}"));
            assert_eq!(technique.to_string(), text.replace(' ', ""));
        }
    }

    #[test]
    fn wrong_values_are_refused_with_a_sentence() {
        for (text, part) in [
            ("fitted:xi=-5", "-4..=5"),
            ("fitted:n=24", "power of two"),
            ("fitted:tile_max=100", "`tile_max=100`"),
            ("fitted:map=8", "16..=1024"),
            ("fitted:encoding=bytes", "`map=256`"),
            ("fitted:step=1", "feedback=next"),
            ("fitted:mode=4", "exact"),
            ("fitted:size=512", "virtual maps"),
            ("fitted:slices=17", "1..=16"),
            ("fitted:slices=2,select=best", "by depth"),
            ("fitted:slices=3,splits=20", "2 distances"),
            ("tiled:slices=2", "`tiled`"),
            ("fitted:min=300", "`fitted`"),
            ("zp4:xi=0", "`zp4`"),
        ] {
            let message = text.parse::<Technique>().expect_err(text).to_string();
            assert!(message.contains(part), "{text}: {message:?} lacks {part:?}");
        }
    }
}
