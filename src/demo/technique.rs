//! Techniques and their settings, switched while playing.

use bevy::prelude::*;

use super::{
    DemoSystems,
    hud::Notice,
    input::{Action, Intent},
    screens::Activity,
};
use crate::{
    level::Sun,
    maths::{split::SplitScheme, warp::Warp},
    shadow::{
        measured::{MeasuredDepths, NearMeasurement},
        settings::{
            Faces, MapResolution, PartitionSelection, Partitions, SeamWidth, Seams, ShadowBias, ShadowFilter,
            ShadowPath, SunShadows,
        },
        stable::Stability,
        technique::Technique,
    },
};

/// What the player has chosen; the sun of every level gets it.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Chosen(pub Technique);

/// One of the settings that the keys of [`Setting::KEYS`] step through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Number of z-partitions, or face partitions.
    Partitions,
    /// Split scheme.
    Split,
    /// Warp.
    Warp,
    /// Texels per side of a map, and whether they are divided by need.
    MapSize,
    /// Which map a point reads, and how wide maps are blended.
    Selection,
    /// Filter of the depth comparison.
    Filter,
    /// Bias.
    Bias,
    /// Full or drop-in.
    Path,
    /// View depth up to which there are shadows.
    Distance,
    /// Which planes come from depths in the picture.
    Depths,
    /// How shadows are kept from crawling.
    Stable,
}

const CUTS: &[(u32, Faces)] = &[
    (1, Faces::Together),
    (2, Faces::Together),
    (3, Faces::Together),
    (4, Faces::Together),
    (6, Faces::Together),
    (8, Faces::Together),
    (12, Faces::Together),
    (16, Faces::Together),
    (1, Faces::Apart { near_map: true }),
    (2, Faces::Apart { near_map: true }),
    (3, Faces::Apart { near_map: true }),
    (4, Faces::Apart { near_map: false }),
];
const SCHEMES: &[SplitScheme] = &[
    Partitions::SCHEME,
    SplitScheme::Logarithmic,
    SplitScheme::Uniform,
    SplitScheme::Practical { lambda: 0.5 },
];
const WARPS: &[Warp] = &[
    Warp::Lispsm,
    Warp::Uniform,
    Warp::Repar,
    Warp::Free { eta: -0.5 },
    Warp::Psm,
    Warp::Tsm { focus: Warp::TSM_FOCUS },
];
const MAPS: &[(u32, MapResolution)] = &[
    (512, MapResolution::Equal),
    (1024, MapResolution::Equal),
    (2048, MapResolution::Equal),
    (4096, MapResolution::Equal),
    (1024, MapResolution::Balanced),
    (2048, MapResolution::Balanced),
];
const SELECTIONS: &[(PartitionSelection, SeamWidth)] = &[
    (PartitionSelection::Finest, SeamWidth::None),
    (PartitionSelection::Finest, SeamWidth::Share(0.05)),
    (PartitionSelection::BestResolution, SeamWidth::None),
    (PartitionSelection::Depth, SeamWidth::None),
    (PartitionSelection::Depth, SeamWidth::Share(0.1)),
];
const FILTERS: &[ShadowFilter] = &[
    ShadowFilter::Pcf2,
    ShadowFilter::Hard,
    ShadowFilter::Poisson {
        taps: ShadowFilter::TAPS,
        radius: ShadowFilter::POISSON_RADIUS,
    },
    ShadowFilter::Pcss {
        taps: ShadowFilter::TAPS,
        radius: ShadowFilter::PCSS_RADIUS,
        sun_diameter: ShadowFilter::SUN_DIAMETER,
    },
];
const BIASES: &[ShadowBias] = &[
    ShadowBias::Footprint { scale: 1.0 },
    ShadowBias::Constant { metres: 0.05 },
    ShadowBias::None,
    ShadowBias::Slope {
        factor: 2.0,
        units: 4.0,
    },
    ShadowBias::WorldSlope { factor: 2.0 },
    ShadowBias::ReceiverPlane { metres: 0.01 },
];
const PATHS: &[ShadowPath] = &[ShadowPath::Full, ShadowPath::DropIn];
const DISTANCES: &[Option<f32>] = &[None, Some(50.0), Some(100.0), Some(200.0), Some(400.0)];
const DEPTHS: &[MeasuredDepths] = &[
    MeasuredDepths::BEST,
    MeasuredDepths {
        splits: true,
        ..MeasuredDepths::OFF
    },
    MeasuredDepths {
        near: NearMeasurement::On,
        far: true,
        splits: true,
        ..MeasuredDepths::OFF
    },
    MeasuredDepths::OFF,
];
const STABILITIES: &[Stability] = &[
    Stability::Off,
    Stability::SHARP,
    Stability::Held,
    Stability::Quantised,
    Stability::Sphere,
];

impl Setting {
    /// The keys of all settings, in their order.
    pub const KEYS: [&str; 11] = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "0", "-"];

    /// In the order of their keys.
    pub const ALL: [Self; 11] = [
        Self::Partitions,
        Self::Split,
        Self::Warp,
        Self::MapSize,
        Self::Selection,
        Self::Filter,
        Self::Bias,
        Self::Path,
        Self::Distance,
        Self::Depths,
        Self::Stable,
    ];

    /// The setting of the n-th key, from 1.
    pub fn of_key(number: u8) -> Option<Self> {
        usize::from(number)
            .checked_sub(1)
            .and_then(|index| Self::ALL.get(index))
            .copied()
    }

    /// Its name on screen.
    pub fn name(self) -> &'static str {
        match self {
            Self::Partitions => "partitions",
            Self::Split => "split",
            Self::Warp => "warp",
            Self::MapSize => "map size",
            Self::Selection => "select",
            Self::Filter => "filter",
            Self::Bias => "bias",
            Self::Path => "path",
            Self::Distance => "distance",
            Self::Depths => "depths",
            Self::Stable => "stable",
        }
    }

    /// Its value on screen.
    pub fn value(self, settings: &SunShadows) -> String {
        match self {
            Self::Partitions => match (settings.partitions.faces, settings.partitions.count) {
                (Faces::Together, count) => count.to_string(),
                (Faces::Apart { .. }, 1) => "faces".into(),
                (Faces::Apart { .. }, count) => format!("faces x {count}"),
            },
            Self::Split => match &settings.partitions.scheme {
                SplitScheme::Uniform => "uniform".into(),
                SplitScheme::Logarithmic => "logarithmic".into(),
                SplitScheme::Practical { lambda } => format!("practical {lambda}"),
                SplitScheme::Manual(depths) => format!("manual {depths:?}"),
            },
            Self::Warp => match settings.warp {
                Warp::Uniform => "uniform".into(),
                Warp::Lispsm => "LiSPSM".into(),
                Warp::Repar => "re-parametrised LiSPSM".into(),
                Warp::Psm => "PSM".into(),
                Warp::Tsm { focus } => format!("TSM {focus}"),
                Warp::Free { eta } => format!("free {eta}"),
            },
            Self::MapSize => match settings.partitions.resolution {
                MapResolution::Equal => format!("{} texels", settings.map_size),
                MapResolution::Balanced => format!("{} texels on average", settings.map_size),
            },
            Self::Selection => {
                let rule = match (settings.partitions.faces, settings.selection) {
                    (Faces::Apart { .. }, _) => "finest map",
                    (_, PartitionSelection::Depth) => "by depth",
                    (_, PartitionSelection::BestResolution) => "best resolution",
                    (_, PartitionSelection::Finest) => "finest map",
                };
                match settings.seams.width {
                    SeamWidth::None => rule.into(),
                    SeamWidth::Share(share) => format!("{rule}, seams of {share}"),
                    SeamWidth::Metres(metres) => format!("{rule}, seams of {metres} m"),
                }
            }
            Self::Filter => match settings.filter {
                ShadowFilter::Hard => "hard".into(),
                ShadowFilter::Pcf2 => "2x2 PCF".into(),
                ShadowFilter::Poisson { taps, radius } => format!("disc of {taps}, {radius} m"),
                ShadowFilter::Pcss { sun_diameter, .. } => format!("penumbra of a sun of {sun_diameter} degrees"),
            },
            Self::Bias => match settings.bias {
                ShadowBias::None => "none".into(),
                ShadowBias::Constant { metres } => format!("constant {metres} m"),
                ShadowBias::Footprint { scale } => format!("footprint x {scale}"),
                ShadowBias::Slope { factor, units } => format!("slope x {factor} + {units} steps"),
                ShadowBias::WorldSlope { factor } => format!("slope in the world x {factor}"),
                ShadowBias::ReceiverPlane { metres } => format!("receiver plane + {metres} m"),
            },
            Self::Path => match settings.path {
                ShadowPath::Full => "full".into(),
                ShadowPath::DropIn => "drop-in".into(),
            },
            Self::Distance => match settings.distance {
                None => "to the far plane".into(),
                Some(metres) => format!("{metres} m"),
            },
            Self::Depths => {
                let MeasuredDepths { near, far, splits, .. } = settings.measures();
                let parts = [(near == NearMeasurement::On, "near"), (far, "far"), (splits, "splits")];
                let measured: Vec<_> = parts.into_iter().filter(|part| part.0).map(|part| part.1).collect();
                match measured[..] {
                    [] => "of bounding boxes".into(),
                    _ => format!("in the picture: {}", measured.join(", ")),
                }
            }
            Self::Stable => match settings.stable {
                Stability::Off => "off".into(),
                Stability::Sphere => "bounding spheres".into(),
                Stability::Quantised => "quantised scale".into(),
                Stability::Held => "held grids".into(),
                Stability::Sharp { frames } => format!("sharp, over {frames} frames"),
            },
        }
    }

    /// False where the setting means nothing on the chosen path or with the chosen maps.
    pub fn applies_to(self, settings: &SunShadows) -> bool {
        let is_of_atlas = matches!(
            self,
            Self::Partitions | Self::Split | Self::MapSize | Self::Selection | Self::Path
        );
        let is_of_full_path = matches!(self, Self::Selection | Self::Filter | Self::Depths | Self::Stable);
        !(settings.maps.is_virtual() && is_of_atlas || settings.path == ShadowPath::DropIn && is_of_full_path)
    }

    /// Steps to the next value, or back; a value that is not in the list goes to its first. The drop-in path keeps
    /// at most [`SunShadows::MAX_DROP_IN_PARTITIONS`] partitions, warps no stronger than `LiSPSM`, and its own biases.
    pub fn step(self, settings: &mut SunShadows, back: bool) {
        let partitions = &mut settings.partitions;
        match self {
            Self::Partitions => {
                let cut = (partitions.count, partitions.faces);
                (partitions.count, partitions.faces) = neighbor(CUTS, &cut, back);
            }
            Self::Split => partitions.scheme = neighbor(SCHEMES, &partitions.scheme, back),
            Self::Warp => settings.warp = neighbor(WARPS, &settings.warp, back),
            Self::MapSize => {
                let maps = (settings.map_size, partitions.resolution);
                (settings.map_size, partitions.resolution) = neighbor(MAPS, &maps, back);
            }
            Self::Selection => {
                let selection = (settings.selection, settings.seams.width);
                (settings.selection, settings.seams.width) = neighbor(SELECTIONS, &selection, back);
            }
            Self::Filter => settings.filter = neighbor(FILTERS, &settings.filter, back),
            Self::Bias => settings.bias = neighbor(BIASES, &settings.bias, back),
            Self::Path => {
                let is_usual = settings.partitions.scheme == Partitions::scheme_of(settings.path);
                settings.path = neighbor(PATHS, &settings.path, back);
                if is_usual {
                    settings.partitions.scheme = Partitions::scheme_of(settings.path);
                }
            }
            Self::Distance => settings.distance = neighbor(DISTANCES, &settings.distance, back),
            Self::Depths => settings.measured = neighbor(DEPTHS, &settings.measured, back),
            Self::Stable => settings.stable = neighbor(STABILITIES, &settings.stable, back),
        }
        self.settle_stability(settings);
        if settings.path == ShadowPath::DropIn && settings.warp.eta() > Warp::Lispsm.eta() {
            settings.warp = match (self, back) {
                (Self::Warp, true) => {
                    let mut weak = WARPS.iter().rev().filter(|warp| warp.eta() <= Warp::Lispsm.eta());
                    *weak.next().unwrap_or(&Warp::Lispsm)
                }
                _ => Warp::Lispsm,
            };
        }
        while settings.path == ShadowPath::DropIn && !settings.bias.is_for_drop_in() {
            settings.bias = neighbor(BIASES, &settings.bias, back);
        }
        if settings.path == ShadowPath::DropIn {
            settings.seams = Seams::NONE;
            if settings.partitions.resolution != MapResolution::Equal {
                settings.partitions.resolution = MapResolution::Equal;
                settings.map_size = MAPS[if back { 3 } else { 0 }].0;
            }
            if settings.partitions.faces != Faces::Together {
                settings.partitions.faces = Faces::Together;
                settings.partitions.count = SunShadows::MAX_DROP_IN_PARTITIONS;
            }
        }
        let count = &mut settings.partitions.count;
        if settings.path == ShadowPath::DropIn && *count > SunShadows::MAX_DROP_IN_PARTITIONS {
            *count = match (self, back) {
                (Self::Partitions, false) => 1,
                _ => SunShadows::MAX_DROP_IN_PARTITIONS,
            };
        }
    }
}

impl Setting {
    /// Uniform maps that stand still take no warp, and those around spheres no measured depths: what was chosen last wins.
    fn settle_stability(self, settings: &mut SunShadows) {
        if settings.path != ShadowPath::Full {
            return;
        }
        let is_chosen = self == Self::Stable;
        if settings.stable.is_uniform() && settings.warp != Warp::Uniform {
            if is_chosen {
                settings.warp = Warp::Uniform;
            } else {
                settings.stable = Stability::Off;
            }
        }
        if settings.stable == Stability::Sphere && settings.measured.is_on() {
            if is_chosen {
                settings.measured = MeasuredDepths::BEST;
            } else {
                settings.stable = Stability::Off;
            }
        }
    }
}

/// The value after `current` (or before), going round; the first where `current` is not among them.
fn neighbor<T: Clone + PartialEq>(values: &[T], current: &T, back: bool) -> T {
    let step = if back { values.len() - 1 } else { 1 };
    let index = values
        .iter()
        .position(|value| value == current)
        .map_or(0, |index| (index + step) % values.len());
    values[index].clone()
}

pub(super) fn plugin(app: &mut App) {
    app.add_systems(
        Update,
        (
            (switch_technique, switch_setting).run_if(in_state(Activity::Running)),
            apply.run_if(any_with_component::<Sun>),
        )
            .chain()
            .in_set(DemoSystems::Act),
    );
}

fn switch_technique(intent: Res<Intent>, mut chosen: ResMut<Chosen>, mut notice: ResMut<Notice>) {
    let back = intent.started(Action::PreviousTechnique);
    if back || intent.started(Action::NextTechnique) {
        chosen.0 = neighbor(&Technique::all(), &chosen.0, back);
        notice.show(format!("technique {}", chosen.0));
    }
}

fn switch_setting(intent: Res<Intent>, mut chosen: ResMut<Chosen>, mut notice: ResMut<Notice>) {
    let Some((setting, back)) = intent
        .setting()
        .and_then(|(digit, back)| Some((Setting::of_key(digit)?, back)))
    else {
        return;
    };
    if let Technique::Umbrage(settings) = &mut chosen.0 {
        if setting.applies_to(settings) {
            setting.step(settings, back);
            notice.show(format!("{}: {}", setting.name(), setting.value(settings)));
        } else {
            notice.show(format!("{} means nothing with {}", setting.name(), chosen.0));
        }
    } else {
        notice.show("Bevy's stock cascades have no settings here: press T for the next technique");
    }
}

/// Gives the chosen technique to the sun, when either is new.
fn apply(mut commands: Commands, chosen: Res<Chosen>, suns: Query<(Entity, Ref<Sun>)>) {
    for (entity, sun) in &suns {
        if chosen.is_changed() || sun.is_added() {
            chosen.0.apply(&mut commands.entity(entity));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shadow::virtual_maps::{ShadowMaps, TiledMaps};

    #[test]
    fn every_setting_comes_round_in_both_directions() {
        for setting in Setting::ALL {
            let mut settings = SunShadows::default();
            let first = setting.value(&settings);
            let mut forward = vec![first.clone()];
            loop {
                setting.step(&mut settings, false);
                if setting.value(&settings) == first {
                    break;
                }
                forward.push(setting.value(&settings));
                assert!(forward.len() < 20, "{setting:?} does not come round: {forward:?}");
            }
            assert!(forward.len() > 1, "{setting:?} has one value only");
            setting.step(&mut settings, true);
            assert_eq!(Some(&setting.value(&settings)), forward.last(), "{setting:?} backwards");
            assert!(
                forward.iter().all(|value| value.is_ascii()),
                "the font has ASCII only: {forward:?}"
            );
        }
    }

    #[test]
    fn drop_in_never_has_more_than_four_partitions() {
        let mut settings = SunShadows::default();
        settings.partitions.count = 16;
        Setting::Path.step(&mut settings, false);
        assert_eq!((settings.path, settings.partitions.count), (ShadowPath::DropIn, 4));
        Setting::Partitions.step(&mut settings, false);
        assert_eq!(settings.partitions.count, 1, "four is followed by one");
        Setting::Partitions.step(&mut settings, true);
        assert_eq!(settings.partitions.count, 4, "one is preceded by four");
    }

    #[test]
    fn drop_in_never_warps_more_than_lispsm() {
        let mut settings = SunShadows {
            warp: Warp::Psm,
            ..Default::default()
        };
        Setting::Path.step(&mut settings, false);
        assert_eq!((settings.path, settings.warp), (ShadowPath::DropIn, Warp::Lispsm));
        for back in [false, true] {
            let mut seen = Vec::new();
            for _ in 0..WARPS.len() {
                Setting::Warp.step(&mut settings, back);
                assert!(settings.warp.eta() <= 0.0, "{:?}", settings.warp);
                seen.push(settings.warp);
            }
            assert!(seen.contains(&Warp::Uniform), "{seen:?}");
        }
    }

    #[test]
    fn drop_in_keeps_to_its_own_biases() {
        let mut settings = SunShadows {
            bias: ShadowBias::WorldSlope { factor: 2.0 },
            ..Default::default()
        };
        Setting::Path.step(&mut settings, false);
        for back in [false, true] {
            let mut seen = Vec::new();
            for _ in 0..3 {
                assert!(settings.bias.is_for_drop_in(), "{:?}", settings.bias);
                assert!(!seen.contains(&settings.bias), "{seen:?}");
                seen.push(settings.bias);
                Setting::Bias.step(&mut settings, back);
            }
        }
    }

    #[test]
    fn drop_in_has_no_filter_of_its_own() {
        let mut settings = SunShadows::default();
        assert!(Setting::ALL.iter().all(|setting| setting.applies_to(&settings)));
        settings.maps = ShadowMaps::Tiled(TiledMaps::default());
        assert!(!Setting::Partitions.applies_to(&settings) && Setting::Warp.applies_to(&settings));
        settings.maps = ShadowMaps::Partitions;
        settings.path = ShadowPath::DropIn;
        assert!(!Setting::Filter.applies_to(&settings) && !Setting::Selection.applies_to(&settings));
        assert!(!Setting::Stable.applies_to(&settings) && !Setting::Depths.applies_to(&settings));
    }

    #[test]
    fn what_was_chosen_last_wins() {
        let mut settings = SunShadows::default();
        while settings.stable != Stability::Sphere {
            Setting::Stable.step(&mut settings, false);
        }
        assert_eq!(settings.warp, Warp::Uniform);
        Setting::Depths.step(&mut settings, false);
        assert_eq!(settings.stable, Stability::Off);
        assert!(settings.measured.is_on());
        settings.stable = Stability::Quantised;
        Setting::Warp.step(&mut settings, false);
        assert_eq!(settings.stable, Stability::Off);
        assert_ne!(settings.warp, Warp::Uniform);
    }

    #[test]
    fn a_value_from_the_command_line_goes_to_the_first_of_the_list() {
        let mut settings = SunShadows {
            map_size: 3000,
            ..Default::default()
        };
        Setting::MapSize.step(&mut settings, false);
        assert_eq!(settings.map_size, MAPS[0].0);
    }

    #[test]
    fn digits_name_the_settings_in_order() {
        assert_eq!(Setting::of_key(1), Some(Setting::Partitions));
        assert_eq!(Setting::of_key(9), Some(Setting::Distance));
        assert_eq!(Setting::of_key(0), None);
        assert_eq!(Setting::of_key(11), Some(Setting::Stable));
        assert_eq!(Setting::of_key(12), None);
    }
}
