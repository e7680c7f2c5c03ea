//! [`Technique`] to text.

use std::fmt;

use super::{Technique, base, pairs::topics, stock_keys, warps};

/// The shortest text that means the same: only what differs from the defaults of its base.
impl fmt::Display for Technique {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let settings = match self {
            Self::Bevy(bias) => return write!(f, "bevy{}", keys(&stock_keys::changes(*bias))),
            Self::Umbrage(settings) => settings,
        };
        let base = base::of(settings);
        let (name, warp) = (base.text)(settings);
        let warp = warp.map(warps::without_keys);
        f.write_str(&name)?;
        if let Some(warp) = warp.and_then(warps::name) {
            write!(f, "+{warp}")?;
        }
        let Ok(Some(default)) = (base.read)(&name, warp) else {
            return Err(fmt::Error);
        };
        let pairs: Vec<String> = topics(base.topics)
            .flat_map(|topic| (topic.changes)(settings, &default))
            .collect();
        f.write_str(&keys(&pairs))
    }
}

/// `:key=value,key=value`, or nothing.
fn keys(pairs: &[String]) -> String {
    if pairs.is_empty() {
        String::new()
    } else {
        format!(":{}", pairs.join(","))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{
        maths::{
            fit::ProjectionCenter,
            split::SplitScheme,
            warp::{OptimumRule, Warp},
        },
        shadow::{
            measured::{MeasureUse, MeasuredDepths, NearMeasurement},
            settings::{
                CasterPasses, Faces, FitSettings, MapResolution, PartitionSelection, Partitions, SeamWidth, Seams,
                ShadowBias, ShadowBlur, ShadowFilter, ShadowPath, ShadowStore, SunShadows, TransparentLayers,
                WarpDirection,
            },
            stable::Stability,
            technique::StockBias,
            virtual_maps::ShadowMaps,
        },
    };

    #[test]
    fn every_listed_technique_round_trips() {
        for technique in Technique::all().into_iter().chain([Technique::Bevy(StockBias::TUNED)]) {
            assert_eq!(technique.to_string().parse(), Ok(technique));
        }
    }

    prop_compose! {
        fn any_fit()(
            center in prop_oneof![Just(ProjectionCenter::Continuous), Just(ProjectionCenter::NearestVertex)],
            axis in prop_oneof![Just(WarpDirection::View), Just(WarpDirection::Middle)],
            optimum in prop_oneof![Just(OptimumRule::Derived), Just(OptimumRule::Literal), Just(OptimumRule::Demo)],
            pseudo_near in prop::option::of(0.001f32..1e6),
            pseudo_far in prop::option::of(0.001f32..1e6),
            guard in any::<bool>(),
            align in any::<bool>(),
        ) -> FitSettings {
            FitSettings { center, axis, optimum, pseudo_near, pseudo_far, guard, align }
        }
    }

    prop_compose! {
        fn any_seams()(
            width in prop_oneof![
                Just(SeamWidth::None),
                (0.0f32..=0.5).prop_map(SeamWidth::Share),
                (0.001f32..1e6).prop_map(SeamWidth::Metres),
            ],
            fade in 0.0f32..=1.0,
        ) -> Seams {
            Seams { width, fade }
        }
    }

    prop_compose! {
        fn any_settings()(count in 1u32..=16)(
            path in if count <= 4 { prop_oneof![Just(ShadowPath::Full), Just(ShadowPath::DropIn)].boxed() } else { Just(ShadowPath::Full).boxed() },
            scheme in prop_oneof![
                Just(SplitScheme::Logarithmic),
                Just(SplitScheme::Uniform),
                (0.0f32..=1.0).prop_map(|lambda| SplitScheme::Practical { lambda }),
                Just(Partitions::default().scheme),
                prop::collection::vec(0.1f32..1000.0, count as usize - 1).prop_map(move |mut splits| {
                    splits.sort_by(f32::total_cmp);
                    splits.dedup();
                    if splits.is_empty() || splits.len() + 1 < count as usize { SplitScheme::Uniform } else { SplitScheme::Manual(splits) }
                }),
            ],
            warp in prop_oneof![
                Just(Warp::Uniform),
                Just(Warp::Lispsm),
                Just(Warp::Repar),
                Just(Warp::Psm),
                (0.0f32..=1.0).prop_map(|focus| Warp::Tsm { focus }),
                (-1.0f32..=1.0).prop_map(|eta| Warp::Free { eta }),
            ],
            map_size in 16u32..=4096,
            selection in prop_oneof![
                Just(PartitionSelection::Depth),
                Just(PartitionSelection::BestResolution),
                Just(PartitionSelection::Finest),
            ],
            filter in prop_oneof![
                Just(ShadowFilter::Hard),
                Just(ShadowFilter::Pcf2),
                (8u32..=64, 0.0f32..=2.0).prop_map(|(taps, radius)| ShadowFilter::Poisson { taps, radius }),
                (8u32..=64, 0.0f32..=2.0, 0.0f32..=10.0)
                    .prop_map(|(taps, radius, sun_diameter)| ShadowFilter::Pcss { taps, radius, sun_diameter }),
            ],
            bias in prop_oneof![
                Just(ShadowBias::None),
                (0.0f32..10.0).prop_map(|metres| ShadowBias::Constant { metres }),
                (0.0f32..10.0).prop_map(|scale| ShadowBias::Footprint { scale }),
                (0.0f32..10.0, 0.0f32..1e6).prop_map(|(factor, units)| ShadowBias::Slope { factor, units }),
                (0.0f32..10.0).prop_map(|factor| ShadowBias::WorldSlope { factor }),
                (0.0f32..10.0).prop_map(|metres| ShadowBias::ReceiverPlane { metres }),
            ],
            (store, blur) in (
                prop_oneof![
                    Just(ShadowStore::Nearest),
                    Just(ShadowStore::BackFaces),
                    Just(ShadowStore::SecondDepth),
                    Just(ShadowStore::Midpoint),
                ],
                (0u32..=16, 0.001f32..1e6).prop_map(|(iterations, full_depth)| ShadowBlur { iterations, full_depth }),
            ),
            (faces, near_map, etas, resolution, fit, seams) in (
                any::<bool>(),
                any::<bool>(),
                prop::option::of(prop::collection::vec(-1.0f32..=0.0, count as usize)),
                prop_oneof![Just(MapResolution::Equal), Just(MapResolution::Balanced)],
                any_fit(),
                any_seams(),
            ),
            (distance, (near_is_measured, near)) in (
                prop::option::of(0.001f32..1e6),
                // `near=` says one or the other.
                prop_oneof![
                    Just((NearMeasurement::Slices, None)),
                    Just((NearMeasurement::On, None)),
                    Just((NearMeasurement::Off, None)),
                    (0.001f32..1e6).prop_map(|near| (NearMeasurement::Slices, Some(near))),
                ],
            ),
            (fallback_map, is_each, far, splits, is_same) in any::<(bool, bool, bool, bool, bool)>(),
            (count, stable, transparent_layers) in (
                Just(count),
                prop_oneof![
                    Just(Stability::Off),
                    Just(Stability::Held),
                    Just(Stability::Quantised),
                    Just(Stability::Sphere),
                    Stability::FRAMES.prop_map(|frames| Stability::Sharp { frames }),
                ],
                prop_oneof![
                    Just(TransparentLayers::Off),
                    Just(TransparentLayers::Nearest),
                    TransparentLayers::COUNTS.prop_map(|count| TransparentLayers::All { count }),
                ],
            ),
        ) -> SunShadows {
            let has_faces = faces && count <= SunShadows::MAX_FACE_SLICES && path == ShadowPath::Full;
            let faces = if has_faces { Faces::Apart { near_map: near_map && count < 4 } } else { Faces::Together };
            let stable = if has_faces && stable.holds_maps() { Stability::Off } else { stable };
            let resolution = if stable.holds_maps() { MapResolution::Equal } else { resolution };
            let warp = if fit.align && !stable.is_uniform() { warp } else { Warp::Uniform };
            let etas = if matches!(warp, Warp::Free { .. }) { etas.unwrap_or_default() } else { Vec::new() };
            let selection = if has_faces { SunShadows::HIGH.selection } else { selection };
            let mut measured = MeasuredDepths {
                near: near_is_measured,
                far,
                // Splits by hand have the same key.
                splits: splits && !matches!(scheme, SplitScheme::Manual(_)),
                measure: MeasureUse::Late,
            };
            if stable == Stability::Sphere {
                measured = MeasuredDepths::BEST;
            }
            if measured.is_on() && is_same {
                measured.measure = MeasureUse::Same;
            }
            let partitions = Partitions { count, scheme, faces, etas, resolution };
            let caster_passes = if is_each { CasterPasses::PerMap } else { CasterPasses::Shared };
            let full = SunShadows {
                path, maps: ShadowMaps::Partitions, partitions, warp, light_planes: None, fit, map_size, selection, seams, filter, bias, caster_passes, store, blur, distance, near, measured, stable, fallback_map, transparent_layers,
            };
            match path {
                ShadowPath::Full => full,
                // What only the full path does keeps its default, Bevy draws maps of powers of two, and no warp is
                // stronger than LiSPSM.
                ShadowPath::DropIn => SunShadows {
                    map_size: map_size.next_power_of_two(),
                    warp: if full.warp.eta() > Warp::Lispsm.eta() { Warp::Lispsm } else { full.warp },
                    partitions: Partitions {
                        resolution: MapResolution::Equal,
                        etas: if full.warp.eta() > Warp::Lispsm.eta() { Vec::new() } else { full.partitions.etas },
                        ..full.partitions
                    },
                    seams: SunShadows::HIGH.seams,
                    selection: SunShadows::HIGH.selection,
                    filter: SunShadows::HIGH.filter,
                    bias: if full.bias.is_for_drop_in() { full.bias } else { SunShadows::HIGH.bias },
                    caster_passes: SunShadows::HIGH.caster_passes,
                    store: SunShadows::HIGH.store,
                    blur: SunShadows::HIGH.blur,
                    fallback_map: SunShadows::HIGH.fallback_map,
                    transparent_layers: SunShadows::HIGH.transparent_layers,
                    measured: SunShadows::HIGH.measured,
                    stable: SunShadows::HIGH.stable,
                    ..full
                },
            }
        }
    }

    proptest! {
        #[test]
        fn text_round_trips(settings in any_settings()) {
            let technique = Technique::Umbrage(settings);
            prop_assert_eq!(technique.to_string().parse(), Ok(technique));
        }

        #[test]
        fn stock_biases_round_trip(depth in 0.0f32..10.0, normal in 0.0f32..10.0) {
            let technique = Technique::Bevy(StockBias { depth, normal });
            prop_assert_eq!(technique.to_string().parse(), Ok(technique));
        }
    }
}
