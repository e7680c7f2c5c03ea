//! Text to [`Technique`].

use std::str::FromStr;

use thiserror::Error;

use super::{StockBias, Technique, cells_per_side, default_map_size, lookup_keys};
use crate::{
    maths::{split::SplitScheme, warp::Warp},
    shadow::settings::{PartitionSelection, Partitions, ShadowPath, SunShadows},
};

/// The keys after the colon, with the values that they take.
pub const KEYS: [(&str, &str); 24] = [
    ("path", "full|dropin"),
    ("size", "texels per side of one map, 16..=8192"),
    ("split", "log|practical|uniform|manual"),
    ("lambda", "0..=1, for split=practical"),
    ("splits", "ascending metres, e.g. 10/30/80, for split=manual"),
    ("select", "depth|best"),
    ("filter", "hard|pcf2|poisson|pcss"),
    ("bias", "none|footprint|constant|slope|world-slope|receiver"),
    ("bias_m", "metres >= 0, for bias=constant and receiver"),
    ("bias_scale", "a factor >= 0, for bias=footprint, slope and world-slope"),
    ("near", "auto|metres > 0"),
    ("distance", "auto|metres > 0"),
    ("eta", "-1..=1, for the warp free"),
    ("focus", "0..=1, share of the range in focus, for the warp tsm"),
    ("fallback", "on|off"),
    ("depth_bias", "metres >= 0, for bevy"),
    ("normal_bias", "texels >= 0, for bevy"),
    ("bias_units", "smallest steps of depth >= 0, for bias=slope"),
    ("taps", "8..=64, for filter=poisson and pcss"),
    ("radius", "metres 0..=2 across the light, for filter=poisson and pcss"),
    ("sun_diameter", "degrees 0..=10, for filter=pcss"),
    ("store", "nearest|back|second|midpoint"),
    ("blur", "iterations on the screen, 0..=16"),
    ("blur_depth", "metres > 0 up to which pixels take part in all of blur="),
];

/// What is planned but not built yet; named so that the error can say so.
const LATER: [&str; 5] = ["fp", "tiled", "queried", "fitted", "optimal"];

/// Side of the largest texture that every desktop adapter has.
const MAX_ATLAS: u32 = 16_384;

/// Why a text is no technique.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TechniqueError {
    /// Planned, not built.
    #[error("`{0}` is not available in this version; available are {AVAILABLE}")]
    Later(String),
    /// No such base.
    #[error("there is no technique `{0}`; available are {AVAILABLE}")]
    Base(String),
    /// No such warp.
    #[error("there is no warp `{0}`; available are lispsm, repar, psm, tsm and free")]
    Warp(String),
    /// z-partitions out of range.
    #[error("`{0}`: z-partitions are counted 1 to 16, as in `zp4`")]
    Count(String),
    /// A base that takes no warp.
    #[error("`{base}` takes no {what}")]
    Takes {
        /// The base.
        base: &'static str,
        /// What was given to it.
        what: &'static str,
    },
    /// No such key.
    #[error("there is no key `{name}`; keys are {}", key_list())]
    Key {
        /// The key given.
        name: String,
    },
    /// A key that was given twice.
    #[error("the key `{0}` is given twice")]
    Twice(String),
    /// A value that the key does not take.
    #[error("`{key}={value}` is wrong: `{key}` takes {expected}")]
    Value {
        /// The key.
        key: &'static str,
        /// The value given.
        value: String,
        /// The values that it takes.
        expected: String,
    },
    /// Settings that contradict each other.
    #[error("{0}")]
    Together(String),
}

const AVAILABLE: &str =
    "bevy, uniform, zp1 to zp16 and the warps lispsm, repar, psm, tsm and free, alone or as in `zp4+lispsm`";

fn key_list() -> String {
    KEYS.map(|(key, _)| key).join(", ")
}

impl FromStr for Technique {
    type Err = TechniqueError;

    fn from_str(text: &str) -> Result<Self, TechniqueError> {
        let (head, settings) = match text.split_once(':') {
            Some((head, settings)) => (head, Some(settings)),
            None => (text, None),
        };
        let (base, warp) = match head.split_once('+') {
            Some((base, warp)) => (base, Some(parse_warp(warp)?)),
            None => (head, None),
        };
        let what = warp.map(|_| "warp");
        let (count, base_warp) = match base {
            "bevy" => {
                return match what {
                    Some(what) => Err(TechniqueError::Takes { base: "bevy", what }),
                    None => stock_bias(&Pairs::parse(settings.unwrap_or_default())?).map(Self::Bevy),
                };
            }
            "uniform" => match what {
                Some(what) => return Err(TechniqueError::Takes { base: "uniform", what }),
                None => (1, Warp::Uniform),
            },
            _ => match (partition_count(base)?, warp) {
                (Some(count), warp) => (count, warp.unwrap_or(Warp::Uniform)),
                (None, None) => (1, parse_warp(base).map_err(|_| base_error(base))?),
                (None, Some(_)) => return Err(base_error(base)),
            },
        };
        let pairs = Pairs::parse(settings.unwrap_or_default())?;
        settings_of(count, base_warp, &pairs).map(Self::Umbrage)
    }
}

fn base_error(base: &str) -> TechniqueError {
    let stem = base.trim_end_matches(|letter: char| letter.is_ascii_digit());
    if LATER.contains(&stem) {
        TechniqueError::Later(base.to_owned())
    } else {
        TechniqueError::Base(base.to_owned())
    }
}

fn parse_warp(text: &str) -> Result<Warp, TechniqueError> {
    match text {
        "lispsm" => Ok(Warp::Lispsm),
        "repar" => Ok(Warp::Repar),
        "psm" => Ok(Warp::Psm),
        "tsm" => Ok(Warp::Tsm { focus: Warp::TSM_FOCUS }),
        "free" => Ok(Warp::Free { eta: 0.0 }),
        _ if LATER.contains(&text) => Err(TechniqueError::Later(text.to_owned())),
        _ => Err(TechniqueError::Warp(text.to_owned())),
    }
}

/// `zp4` is 4, other bases are `None`.
fn partition_count(base: &str) -> Result<Option<u32>, TechniqueError> {
    let Some(digits) = base.strip_prefix("zp") else {
        return Ok(None);
    };
    match digits.parse() {
        Ok(count @ 1..=SunShadows::MAX_PARTITIONS) => Ok(Some(count)),
        _ => Err(TechniqueError::Count(base.to_owned())),
    }
}

/// What `zpN` or a warp alone means without keys.
pub(super) fn defaults(count: u32, warp: Warp) -> SunShadows {
    SunShadows {
        partitions: Partitions {
            count,
            ..Partitions::default()
        },
        warp,
        map_size: default_map_size(count),
        ..SunShadows::HIGH
    }
}

/// Keys with their values, checked against [`KEYS`].
pub(super) struct Pairs<'a>(Vec<(&'static str, &'a str)>);

impl<'a> Pairs<'a> {
    fn parse(text: &'a str) -> Result<Self, TechniqueError> {
        let mut pairs: Vec<(&'static str, &'a str)> = Vec::new();
        for pair in text.split(',').map(str::trim).filter(|pair| !pair.is_empty()) {
            let (name, value) = pair.split_once('=').unwrap_or((pair, ""));
            let Some((key, _)) = KEYS.into_iter().find(|(key, _)| *key == name) else {
                return Err(TechniqueError::Key { name: name.to_owned() });
            };
            if pairs.iter().any(|(given, _)| *given == key) {
                return Err(TechniqueError::Twice(key.to_owned()));
            }
            pairs.push((key, value));
        }
        Ok(Self(pairs))
    }

    /// Whether a key was given.
    pub(super) fn has(&self, name: &str) -> bool {
        self.0.iter().any(|(key, _)| *key == name)
    }

    /// The value of a key, if it was given, as `parse` reads it; `None` from `parse` is a wrong value.
    pub(super) fn read<T>(
        &self,
        name: &str,
        parse: impl FnOnce(&str) -> Option<T>,
    ) -> Result<Option<T>, TechniqueError> {
        let Some(&(key, value)) = self.0.iter().find(|(key, _)| *key == name) else {
            return Ok(None);
        };
        let expected = KEYS
            .into_iter()
            .find(|(key, _)| *key == name)
            .map_or("", |(_, values)| values);
        parse(value).map(Some).ok_or_else(|| TechniqueError::Value {
            key,
            value: value.to_owned(),
            expected: expected.to_owned(),
        })
    }
}

/// A finite number within a range.
pub(super) fn number(text: &str, range: impl std::ops::RangeBounds<f32>) -> Option<f32> {
    text.parse::<f32>()
        .ok()
        .filter(|value| value.is_finite() && range.contains(value))
}

/// A length: above zero.
pub(super) fn metres(text: &str) -> Option<f32> {
    number(text, f32::MIN_POSITIVE..)
}

/// `auto` or a length.
fn auto_or_metres(text: &str) -> Option<Option<f32>> {
    if text == "auto" {
        Some(None)
    } else {
        metres(text).map(Some)
    }
}

/// Ascending lengths between slashes.
fn split_list(text: &str) -> Option<Vec<f32>> {
    let splits: Vec<f32> = text.split('/').map(metres).collect::<Option<_>>()?;
    splits.is_sorted_by(|a, b| a < b).then_some(splits)
}

/// Keys of stock cascades.
const STOCK_KEYS: [&str; 2] = ["depth_bias", "normal_bias"];

fn stock_bias(pairs: &Pairs) -> Result<StockBias, TechniqueError> {
    if let Some((key, _)) = pairs.0.iter().find(|(key, _)| !STOCK_KEYS.contains(key)) {
        return Err(TechniqueError::Together(format!(
            "`bevy` takes no key `{key}`, only {}",
            STOCK_KEYS.join(" and ")
        )));
    }
    let not_negative = |text: &str| number(text, 0.0..);
    let default = StockBias::default();
    Ok(StockBias {
        depth: pairs.read("depth_bias", not_negative)?.unwrap_or(default.depth),
        normal: pairs.read("normal_bias", not_negative)?.unwrap_or(default.normal),
    })
}

/// Keys of what only the full path does.
const FULL_PATH_KEYS: [&str; 10] = [
    "select",
    "filter",
    "fallback",
    "bias_units",
    "taps",
    "radius",
    "sun_diameter",
    "store",
    "blur",
    "blur_depth",
];

fn settings_of(count: u32, warp: Warp, pairs: &Pairs) -> Result<SunShadows, TechniqueError> {
    if let Some(key) = STOCK_KEYS.into_iter().find(|key| pairs.has(key)) {
        return Err(TechniqueError::Together(format!(
            "`{key}=` belongs to `bevy`; other techniques take `bias=`"
        )));
    }
    let mut settings = defaults(count, warp);
    if let Some(path) = pairs.read("path", |text| match text {
        "full" => Some(ShadowPath::Full),
        "dropin" => Some(ShadowPath::DropIn),
        _ => None,
    })? {
        settings.path = path;
    }
    if settings.path == ShadowPath::DropIn && count > SunShadows::MAX_DROP_IN_PARTITIONS {
        return Err(TechniqueError::Together(format!(
            "`path=dropin` has at most {} z-partitions, not {count}",
            SunShadows::MAX_DROP_IN_PARTITIONS
        )));
    }
    if settings.path == ShadowPath::DropIn
        && let Some(key) = FULL_PATH_KEYS.into_iter().find(|key| pairs.has(key))
    {
        return Err(TechniqueError::Together(format!(
            "`{key}=` means nothing with `path=dropin`, where Bevy looks shadows up"
        )));
    }
    if let Some(size) = pairs.read("size", |text| {
        text.parse::<u32>().ok().filter(|size| (16..=8192).contains(size))
    })? {
        let largest = MAX_ATLAS / cells_per_side(count);
        if size > largest {
            return Err(TechniqueError::Together(format!(
                "`size={size}` is too large for {count} maps: at most {largest}"
            )));
        }
        if settings.path == ShadowPath::DropIn && !size.is_power_of_two() {
            return Err(TechniqueError::Together(format!(
                "`path=dropin` needs a power of two as size, not {size}: Bevy draws no other maps"
            )));
        }
        settings.map_size = size;
    }
    settings.partitions.scheme = scheme_of(count, settings.partitions.scheme, pairs)?;
    settings.warp = warp_of(warp, pairs)?;
    if settings.path == ShadowPath::DropIn && settings.warp.eta() > Warp::Lispsm.eta() {
        return Err(TechniqueError::Together(
            "`path=dropin` takes no warp stronger than lispsm: Bevy's bias cannot follow its texels".to_owned(),
        ));
    }
    if let Some(selection) = pairs.read("select", |text| match text {
        "depth" => Some(PartitionSelection::Depth),
        "best" => Some(PartitionSelection::BestResolution),
        _ => None,
    })? {
        settings.selection = selection;
    }
    lookup_keys::read(&mut settings, pairs)?;
    if let Some(near) = pairs.read("near", auto_or_metres)? {
        settings.near = near;
    }
    if let Some(distance) = pairs.read("distance", auto_or_metres)? {
        settings.distance = distance;
    }
    if let Some(fallback) = pairs.read("fallback", |text| match text {
        "on" => Some(true),
        "off" => Some(false),
        _ => None,
    })? {
        settings.fallback_map = fallback;
    }
    Ok(settings)
}

fn scheme_of(count: u32, default: SplitScheme, pairs: &Pairs) -> Result<SplitScheme, TechniqueError> {
    #[derive(Clone, Copy, PartialEq)]
    enum Kind {
        Log,
        Practical,
        Uniform,
        Manual,
    }
    let kind = pairs.read("split", |text| match text {
        "log" => Some(Kind::Log),
        "practical" => Some(Kind::Practical),
        "uniform" => Some(Kind::Uniform),
        "manual" => Some(Kind::Manual),
        _ => None,
    })?;
    let lambda = pairs.read("lambda", |text| number(text, 0.0..=1.0))?;
    let splits = pairs.read("splits", split_list)?;
    let kind = kind
        .or(lambda.map(|_| Kind::Practical))
        .or(splits.as_ref().map(|_| Kind::Manual));
    if lambda.is_some() && kind != Some(Kind::Practical) {
        return Err(TechniqueError::Together(
            "`lambda=` belongs to `split=practical`".to_owned(),
        ));
    }
    if splits.is_some() && kind != Some(Kind::Manual) {
        return Err(TechniqueError::Together(
            "`splits=` belongs to `split=manual`".to_owned(),
        ));
    }
    match kind {
        None => Ok(default),
        Some(Kind::Log) => Ok(SplitScheme::Logarithmic),
        Some(Kind::Uniform) => Ok(SplitScheme::Uniform),
        Some(Kind::Practical) => Ok(SplitScheme::Practical {
            lambda: lambda.unwrap_or(match default {
                SplitScheme::Practical { lambda } => lambda,
                _ => 0.5,
            }),
        }),
        Some(Kind::Manual) => match splits {
            Some(splits) if splits.len() + 1 == count as usize => Ok(SplitScheme::Manual(splits)),
            _ => Err(TechniqueError::Together(format!(
                "`split=manual` with {count} z-partitions takes `splits=` with {} distances in metres between slashes",
                count - 1
            ))),
        },
    }
}

fn warp_of(warp: Warp, pairs: &Pairs) -> Result<Warp, TechniqueError> {
    let eta = pairs.read("eta", |text| number(text, -1.0..=1.0))?;
    let focus = pairs.read("focus", |text| number(text, 0.0..=1.0))?;
    if eta.is_some() && !matches!(warp, Warp::Free { .. }) {
        return Err(TechniqueError::Together("`eta=` belongs to the warp `free`".to_owned()));
    }
    if focus.is_some() && !matches!(warp, Warp::Tsm { .. }) {
        return Err(TechniqueError::Together(
            "`focus=` belongs to the warp `tsm`".to_owned(),
        ));
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::shadow::settings::{ShadowBias, ShadowBlur, ShadowFilter, ShadowStore};

    fn settings(text: &str) -> SunShadows {
        match text.parse() {
            Ok(Technique::Umbrage(settings)) => settings,
            other => panic!("{text}: {other:?}"),
        }
    }

    fn error(text: &str) -> String {
        text.parse::<Technique>().expect_err(text).to_string()
    }

    #[test]
    fn the_default_text_is_the_default_preset() {
        assert_eq!(settings("zp4+lispsm"), SunShadows::HIGH);
        assert_eq!(Technique::default().to_string(), "zp4+lispsm");
        assert_eq!(settings("zp4+lispsm:size=4096"), SunShadows::ULTRA);
    }

    #[test]
    fn a_warp_alone_means_one_map_of_the_whole_budget() {
        for text in ["lispsm", "zp1+lispsm"] {
            let one = settings(text);
            assert_eq!(
                (one.partitions.count, one.map_size, one.warp),
                (1, 4096, Warp::Lispsm),
                "{text}"
            );
        }
        assert_eq!(settings("zp1"), settings("uniform"));
        assert_eq!(settings("zp4").warp, Warp::Uniform);
        assert_eq!(settings("zp4+repar").warp, Warp::Repar);
        assert_eq!(settings("tsm:focus=0.5").warp, Warp::Tsm { focus: 0.5 });
        assert_eq!(settings("tsm"), settings("tsm:focus=0.2"));
    }

    #[test]
    fn keys_reach_their_settings() {
        let all = settings(
            "zp3+free:path=full,size=500,splits=10/30.5,select=depth,filter=hard,bias_m=0.2,near=1.5,distance=300,eta=-0.25,fallback=off",
        );
        let expected = SunShadows {
            path: ShadowPath::Full,
            partitions: Partitions {
                count: 3,
                scheme: SplitScheme::Manual(vec![10.0, 30.5]),
            },
            warp: Warp::Free { eta: -0.25 },
            map_size: 500,
            selection: PartitionSelection::Depth,
            filter: ShadowFilter::Hard,
            bias: ShadowBias::Constant { metres: 0.2 },
            store: ShadowStore::Nearest,
            blur: ShadowBlur::NONE,
            distance: Some(300.0),
            near: Some(1.5),
            fallback_map: false,
        };
        assert_eq!(all, expected);
        assert_eq!(settings("zp4:path=dropin").path, ShadowPath::DropIn);
        assert_eq!(settings("zp4:split=log").partitions.scheme, SplitScheme::Logarithmic);
        assert_eq!(
            settings("zp4:lambda=0.3").partitions.scheme,
            SplitScheme::Practical { lambda: 0.3 }
        );
        assert_eq!(settings("zp4:bias=none").bias, ShadowBias::None);
        assert_eq!(settings("zp4:near=auto,distance=auto"), settings("zp4"));
    }

    #[test]
    fn stock_cascades_take_biases() {
        let bias = StockBias {
            depth: 0.1,
            normal: 0.5,
        };
        assert_eq!("bevy:normal_bias=0.5,depth_bias=0.1".parse(), Ok(Technique::Bevy(bias)));
        assert_eq!("bevy".parse(), Ok(Technique::Bevy(StockBias::default())));
        assert_eq!("bevy:depth_bias=0.02".parse(), "bevy".parse::<Technique>());
    }

    #[test]
    fn errors_say_what_is_wrong_and_what_there_is() {
        for (text, parts) in [
            (
                "tiled",
                &["`tiled`", "not available in this version", "zp16", "lispsm"][..],
            ),
            ("fp4", &["`fp4`", "not available"]),
            ("blur", &["no technique `blur`", "uniform"]),
            ("zp4+blur", &["no warp `blur`", "repar, psm, tsm"]),
            ("zp0", &["1 to 16"]),
            ("zp17", &["1 to 16"]),
            ("zp", &["1 to 16"]),
            ("", &["no technique"]),
            ("bevy+lispsm", &["`bevy` takes no warp"]),
            (
                "bevy:size=512",
                &["`bevy` takes no key `size`", "depth_bias and normal_bias"],
            ),
            ("bevy:normal_bias=-1", &["`normal_bias=-1`", "texels >= 0"]),
            ("bevy:depth_bias=inf", &["`depth_bias=inf`", "metres >= 0"]),
            ("lispsm:depth_bias=1", &["belongs to `bevy`", "`bias=`"]),
            ("uniform+psm", &["`uniform` takes no warp"]),
            ("zp4:colour=red", &["no key `colour`", "path, size, split"]),
            ("zp4:size=0", &["`size=0`", "16..=8192"]),
            ("zp16:size=8192", &["16 maps", "4096"]),
            ("zp4:size", &["`size=`"]),
            ("zp4:size=256,size=512", &["twice"]),
            ("zp8:path=dropin", &["at most 4"]),
            ("zp4:path=dropin,filter=hard", &["`filter=`", "path=dropin"]),
            ("zp4:path=dropin,select=depth", &["`select=`"]),
            ("lispsm:path=dropin,fallback=off", &["`fallback=`"]),
            ("psm:path=dropin", &["stronger than lispsm"]),
            ("tsm:path=dropin", &["stronger than lispsm"]),
            ("zp2+free:eta=0.5,path=dropin", &["stronger than lispsm"]),
            ("zp4:path=dropin,size=1000", &["power of two", "1000"]),
            ("zp4:lambda=nan", &["`lambda=nan`", "0..=1"]),
            ("zp4:split=log,lambda=0.5", &["split=practical"]),
            ("zp4:split=manual", &["`splits=` with 3"]),
            ("zp4:splits=10/5/20", &["ascending"]),
            ("zp4+lispsm:eta=1", &["free"]),
            ("zp4+tsm:eta=1", &["free"]),
            ("free:focus=0.5", &["tsm"]),
            ("repar:focus=0.5", &["tsm"]),
            ("tsm:focus=1.5", &["`focus=1.5`", "0..=1"]),
            ("zp4:bias=none,bias_m=1", &["bias=constant"]),
            ("zp4:bias=constant,bias_scale=1", &["bias=footprint"]),
            ("zp4:bias=footprint,bias_units=1", &["bias=slope"]),
            ("zp4:path=dropin,bias=slope", &["`bias=slope`", "path=dropin"]),
            ("zp4:path=dropin,store=back", &["`store=`", "path=dropin"]),
            ("zp4:path=dropin,blur=2", &["`blur=`", "path=dropin"]),
            ("zp4:taps=8", &["poisson", "pcss"]),
            ("zp4:filter=hard,radius=1", &["poisson", "pcss"]),
            ("zp4:filter=poisson,taps=7", &["`taps=7`", "8..=64"]),
            ("zp4:filter=poisson,radius=2.5", &["`radius=2.5`", "0..=2"]),
            ("zp4:filter=poisson,sun_diameter=1", &["filter=pcss"]),
            ("zp4:blur=17", &["`blur=17`", "0..=16"]),
            ("zp4:blur_depth=0", &["`blur_depth=0`"]),
            ("zp4:store=linear", &["`store=linear`", "midpoint"]),
            ("zp4:near=-1", &["auto|metres"]),
        ] {
            let message = error(text);
            for part in parts {
                assert!(message.contains(part), "{text}: {message:?} lacks {part:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[a-z0-9+:=,./-]{0,40}") {
            let _ = text.parse::<Technique>();
        }
    }
}
