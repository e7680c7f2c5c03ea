//! Settings out of range are corrected, with one warning each.

use std::ops::RangeInclusive;

use super::{
    correction::Correction,
    measured::MeasuredDepths,
    settings::{
        Faces, MapResolution, SeamWidth, Seams, ShadowBias, ShadowBlur, ShadowFilter, ShadowPath, SunShadows,
        TransparentLayers,
    },
    stable::Stability,
    virtual_maps,
};
use crate::maths::{split::SplitScheme, warp::Warp};

/// Sides of maps that can be asked for, in texels.
pub const MAP_SIZES: RangeInclusive<u32> = 16..=8192;

/// Lookups on a disc that can be asked for.
pub const TAPS: RangeInclusive<u32> = 8..=64;

/// The settings with every value in range, and what had to be corrected.
pub fn checked(settings: &SunShadows) -> (SunShadows, Vec<Correction>) {
    let mut settings = settings.clone();
    let mut corrections = Vec::new();
    let wrong = virtual_maps::check(&mut settings);
    let kinds = [
        (wrong.path, Correction::DropInVirtual),
        (wrong.numbers, Correction::VirtualNumbers),
        (wrong.store, Correction::VirtualStore),
        (wrong.light_planes, Correction::VirtualLightPlanes),
    ];
    corrections.extend(
        kinds
            .into_iter()
            .filter(|(is_wrong, _)| *is_wrong)
            .map(|(_, kind)| kind),
    );
    let is_drop_in = settings.path == ShadowPath::DropIn;
    if is_drop_in && !is_for_drop_in(&settings) {
        settings.partitions.faces = Faces::Together;
        settings.partitions.resolution = MapResolution::Equal;
        settings.seams = Seams::NONE;
        corrections.push(Correction::DropInPartitions);
    }
    let mut clamp = |value: &mut u32, range: RangeInclusive<u32>, correction| {
        if !range.contains(value) {
            *value = (*value).clamp(*range.start(), *range.end());
            corrections.push(correction);
        }
    };
    clamp(&mut settings.map_size, MAP_SIZES, Correction::MapSize);
    if let TransparentLayers::All { count } = &mut settings.transparent_layers {
        clamp(count, TransparentLayers::COUNTS, Correction::TransparentLayers);
    }
    match (settings.path, settings.partitions.faces) {
        (ShadowPath::Full, Faces::Together) => clamp(
            &mut settings.partitions.count,
            1..=SunShadows::MAX_PARTITIONS,
            Correction::Count,
        ),
        (ShadowPath::Full, Faces::Apart { .. }) => clamp(
            &mut settings.partitions.count,
            1..=SunShadows::MAX_FACE_SLICES,
            Correction::FaceCount,
        ),
        (ShadowPath::DropIn, _) => clamp(
            &mut settings.partitions.count,
            1..=SunShadows::MAX_DROP_IN_PARTITIONS,
            Correction::DropInCount,
        ),
    }
    if settings.partitions.maps() > SunShadows::MAX_PARTITIONS {
        settings.partitions.faces = Faces::Apart { near_map: false };
        corrections.push(Correction::NearMap);
    }
    if is_drop_in && !settings.map_size.is_power_of_two() {
        settings.map_size = settings.map_size.next_power_of_two();
        corrections.push(Correction::DropInMapSize);
    }
    if let SplitScheme::Practical { lambda } = &mut settings.partitions.scheme
        && !(0.0..=1.0).contains(lambda)
    {
        *lambda = if lambda.is_nan() { 0.5 } else { lambda.clamp(0.0, 1.0) };
        corrections.push(Correction::Lambda);
    }
    let free = match &mut settings.warp {
        Warp::Free { eta } => Some(eta),
        _ => None,
    };
    let mut is_eta_wrong = false;
    for eta in free.into_iter().chain(&mut settings.partitions.etas) {
        if !(-1.0..=1.0).contains(eta) {
            *eta = if eta.is_nan() { -1.0 } else { eta.clamp(-1.0, 1.0) };
            is_eta_wrong = true;
        }
    }
    if is_eta_wrong {
        corrections.push(Correction::Eta);
    }
    if let Warp::Tsm { focus } = &mut settings.warp
        && !(0.0..=1.0).contains(focus)
    {
        *focus = if focus.is_nan() {
            Warp::TSM_FOCUS
        } else {
            focus.clamp(0.0, 1.0)
        };
        corrections.push(Correction::Focus);
    }
    if is_drop_in && settings.largest_eta() > Warp::Lispsm.eta() {
        settings.warp = Warp::Lispsm;
        settings.partitions.etas.clear();
        corrections.push(Correction::DropInWarp);
    }
    if let Some(planes) = &mut settings.light_planes {
        let right = planes.checked(settings.path);
        if *planes != right {
            *planes = right;
            corrections.push(Correction::LightPlanes);
        }
    }
    if is_drop_in && !settings.bias.is_for_drop_in() {
        settings.bias = ShadowBias::default();
        corrections.push(Correction::DropInBias);
    }
    let is_of_equal_slices =
        settings.partitions.faces == Faces::Together && settings.partitions.resolution == MapResolution::Equal;
    if settings.stable.holds_maps() && !is_of_equal_slices {
        settings.stable = Stability::Off;
        corrections.push(Correction::StablePartitions);
    }
    if settings.path == ShadowPath::Full && settings.stable.is_uniform() && settings.warp != Warp::Uniform {
        settings.warp = Warp::Uniform;
        corrections.push(Correction::StableWarp);
    }
    if settings.stable == Stability::Sphere && settings.measured.is_on() {
        settings.measured = MeasuredDepths::BEST;
        corrections.push(Correction::StableMeasured);
    }
    if let Stability::Sharp { frames } = &mut settings.stable
        && !Stability::FRAMES.contains(frames)
    {
        *frames = (*frames).clamp(*Stability::FRAMES.start(), *Stability::FRAMES.end());
        corrections.push(Correction::StableFrames);
    }
    let is_size = |value: f32| value.is_finite() && value >= 0.0;
    let mut is_biased_wrongly = false;
    for number in bias_numbers(&mut settings.bias) {
        if !is_size(*number) {
            *number = 0.0;
            is_biased_wrongly = true;
        }
    }
    if is_biased_wrongly {
        corrections.push(Correction::Bias);
    }
    let filter = checked_filter(settings.filter);
    if filter != settings.filter {
        settings.filter = filter;
        corrections.push(Correction::Filter);
    }
    let blur = ShadowBlur {
        iterations: settings.blur.iterations.min(ShadowBlur::MAX_ITERATIONS),
        full_depth: if settings.blur.full_depth > 0.0 {
            settings.blur.full_depth
        } else {
            ShadowBlur::NONE.full_depth
        },
    };
    if blur != settings.blur {
        settings.blur = blur;
        corrections.push(Correction::Blur);
    }
    let is_depth = |depth: Option<f32>| depth.is_none_or(|depth| depth.is_finite() && depth > 0.0);
    if !is_depth(settings.fit.pseudo_near) || !is_depth(settings.fit.pseudo_far) {
        settings.fit.pseudo_near = settings.fit.pseudo_near.filter(|depth| is_depth(Some(*depth)));
        settings.fit.pseudo_far = settings.fit.pseudo_far.filter(|depth| is_depth(Some(*depth)));
        corrections.push(Correction::PseudoPlanes);
    }
    let seams = checked_seams(settings.seams);
    if seams != settings.seams {
        settings.seams = seams;
        corrections.push(Correction::Seams);
    }
    if settings.distance.is_some_and(|distance| !(distance > 0.0)) {
        settings.distance = None;
        corrections.push(Correction::Distance);
    }
    if settings.near.is_some_and(|near| !is_size(near)) {
        settings.near = None;
        corrections.push(Correction::Near);
    }
    (settings, corrections)
}

/// Whether the drop-in path can draw what the view is cut into.
fn is_for_drop_in(settings: &SunShadows) -> bool {
    let partitions = &settings.partitions;
    (partitions.faces, partitions.resolution) == (Faces::Together, MapResolution::Equal)
        && settings.seams == Seams::NONE
}

/// NaN becomes 0.
fn checked_seams(seams: Seams) -> Seams {
    let within = |value: f32, largest: f32| if value > 0.0 { value.min(largest) } else { 0.0 };
    Seams {
        width: match seams.width {
            SeamWidth::None => SeamWidth::None,
            SeamWidth::Share(share) => SeamWidth::Share(within(share, SeamWidth::LARGEST_SHARE)),
            SeamWidth::Metres(metres) => SeamWidth::Metres(within(metres, f32::MAX)),
        },
        fade: within(seams.fade, 1.0),
    }
}

/// The lengths and factors of a bias.
fn bias_numbers(bias: &mut ShadowBias) -> Vec<&mut f32> {
    match bias {
        ShadowBias::None => Vec::new(),
        ShadowBias::Constant { metres: number }
        | ShadowBias::ReceiverPlane { metres: number }
        | ShadowBias::Footprint { scale: number }
        | ShadowBias::WorldSlope { factor: number } => vec![number],
        ShadowBias::Slope { factor, units } => vec![factor, units],
    }
}

/// NaN becomes the default.
fn checked_filter(filter: ShadowFilter) -> ShadowFilter {
    let within = |value: f32, largest: f32, default: f32| {
        if value.is_nan() {
            default
        } else {
            value.clamp(0.0, largest)
        }
    };
    let taps_of = |taps: u32| taps.clamp(*TAPS.start(), *TAPS.end());
    match filter {
        ShadowFilter::Hard | ShadowFilter::Pcf2 => filter,
        ShadowFilter::Poisson { taps, radius } => ShadowFilter::Poisson {
            taps: taps_of(taps),
            radius: within(radius, ShadowFilter::LARGEST_RADIUS, ShadowFilter::POISSON_RADIUS),
        },
        ShadowFilter::Pcss {
            taps,
            radius,
            sun_diameter,
        } => ShadowFilter::Pcss {
            taps: taps_of(taps),
            radius: within(radius, ShadowFilter::LARGEST_RADIUS, ShadowFilter::PCSS_RADIUS),
            sun_diameter: within(sun_diameter, ShadowFilter::LARGEST_SUN, ShadowFilter::SUN_DIAMETER),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        maths::light_plane::space::{FilmCover, FilmDivision},
        shadow::{
            light_plane::LightPlanes,
            measured::NearMeasurement,
            settings::{FitSettings, Partitions},
        },
    };

    #[test]
    fn presets_need_no_correction() {
        for preset in [SunShadows::LOW, SunShadows::MEDIUM, SunShadows::HIGH, SunShadows::ULTRA] {
            for path in [ShadowPath::Full, ShadowPath::DropIn] {
                let preset = SunShadows { path, ..preset.clone() };
                assert_eq!(checked(&preset), (preset, Vec::new()));
            }
        }
    }

    #[test]
    fn the_focus_of_trapezoidal_maps_is_a_share() {
        for (focus, expected) in [(f32::NAN, Warp::TSM_FOCUS), (-1.0, 0.0), (2.0, 1.0)] {
            let (right, corrections) = checked(&SunShadows {
                warp: Warp::Tsm { focus },
                ..SunShadows::HIGH
            });
            assert_eq!(right.warp, Warp::Tsm { focus: expected });
            assert_eq!(corrections, [Correction::Focus]);
        }
    }

    #[test]
    fn light_planes_are_limited() {
        let wrong = LightPlanes {
            frusta: 9,
            division: FilmDivision::Tiles,
            cover: FilmCover::Body,
            damping: f32::NAN,
            ..LightPlanes::default()
        };
        for (path, frusta, division, cover) in [
            (ShadowPath::Full, 8, FilmDivision::Tiles, FilmCover::Seen),
            (ShadowPath::DropIn, 4, FilmDivision::Depth, FilmCover::Body),
        ] {
            let (right, corrections) = checked(&SunShadows {
                path,
                light_planes: Some(wrong),
                ..SunShadows::HIGH
            });
            let expected = LightPlanes {
                frusta,
                division,
                cover,
                ..LightPlanes::default()
            };
            assert_eq!(
                (right.light_planes, corrections),
                (Some(expected), vec![Correction::LightPlanes])
            );
        }
    }

    #[test]
    fn everything_wrong_at_once() {
        let wrong = SunShadows {
            path: ShadowPath::DropIn,
            partitions: Partitions {
                count: 9,
                scheme: SplitScheme::Practical { lambda: f32::NAN },
                faces: Faces::Apart { near_map: true },
                etas: vec![f32::NAN],
                ..Partitions::default()
            },
            fit: FitSettings {
                pseudo_near: Some(-1.0),
                pseudo_far: Some(80.0),
                ..FitSettings::BEST
            },
            warp: Warp::Free { eta: 2.0 },
            map_size: 1000,
            bias: ShadowBias::Footprint { scale: f32::INFINITY },
            distance: Some(f32::NAN),
            near: Some(-1.0),
            ..SunShadows::HIGH
        };
        let (right, corrections) = checked(&wrong);
        assert_eq!(right.partitions.count, 4);
        assert_eq!(right.partitions.scheme, SplitScheme::Practical { lambda: 0.5 });
        assert_eq!(right.warp, Warp::Lispsm);
        assert_eq!(right.map_size, 1024);
        assert_eq!(right.bias, ShadowBias::Footprint { scale: 0.0 });
        assert_eq!((right.distance, right.near), (None, None));
        assert_eq!(right.partitions.faces, Faces::Together);
        assert_eq!((right.fit.pseudo_near, right.fit.pseudo_far), (None, Some(80.0)));
        assert_eq!(corrections.len(), 10, "{corrections:?}");
        assert_eq!(checked(&right).1, Vec::new(), "corrected settings are right");
    }

    #[test]
    fn filters_biases_and_blurs_are_limited() {
        let (right, corrections) = checked(&SunShadows {
            filter: ShadowFilter::Pcss {
                taps: 1,
                radius: f32::NAN,
                sun_diameter: 400.0,
            },
            bias: ShadowBias::Slope {
                factor: 2.0,
                units: f32::NAN,
            },
            blur: ShadowBlur {
                iterations: 17,
                full_depth: f32::NAN,
            },
            ..SunShadows::HIGH
        });
        let filter = ShadowFilter::Pcss {
            taps: 8,
            radius: ShadowFilter::PCSS_RADIUS,
            sun_diameter: 10.0,
        };
        assert_eq!(right.filter, filter);
        assert_eq!(
            right.bias,
            ShadowBias::Slope {
                factor: 2.0,
                units: 0.0
            }
        );
        assert_eq!((right.blur.iterations, right.blur.full_depth), (16, 10.0));
        assert_eq!(corrections, [Correction::Bias, Correction::Filter, Correction::Blur]);
        let (right, corrections) = checked(&SunShadows {
            path: ShadowPath::DropIn,
            bias: ShadowBias::ReceiverPlane { metres: 0.1 },
            ..SunShadows::HIGH
        });
        assert_eq!(
            (right.bias, corrections),
            (ShadowBias::default(), vec![Correction::DropInBias])
        );
    }

    #[test]
    fn transparent_layers_are_limited() {
        for (count, nearest) in [(0, 1), (99, 8)] {
            let (right, corrections) = checked(&SunShadows {
                transparent_layers: TransparentLayers::All { count },
                ..SunShadows::HIGH
            });
            assert_eq!(right.transparent_layers, TransparentLayers::All { count: nearest });
            assert_eq!(corrections, [Correction::TransparentLayers]);
        }
    }

    #[test]
    fn stable_maps_take_what_they_can() {
        for stable in [Stability::Sphere, Stability::Quantised] {
            let (right, corrections) = checked(&SunShadows {
                stable,
                ..SunShadows::HIGH
            });
            assert_eq!((right.warp, corrections), (Warp::Uniform, vec![Correction::StableWarp]));
        }
        for (frames, nearest) in [(0, 2), (99, 32)] {
            let (right, corrections) = checked(&SunShadows {
                stable: Stability::Sharp { frames },
                ..SunShadows::HIGH
            });
            assert_eq!(right.stable, Stability::Sharp { frames: nearest });
            assert_eq!(corrections, [Correction::StableFrames]);
        }
        let measured = MeasuredDepths {
            near: NearMeasurement::On,
            ..MeasuredDepths::OFF
        };
        let (right, corrections) = checked(&SunShadows {
            stable: Stability::Sphere,
            warp: Warp::Uniform,
            measured,
            ..SunShadows::HIGH
        });
        assert_eq!(
            (right.measured, corrections),
            (MeasuredDepths::BEST, vec![Correction::StableMeasured])
        );
        let (right, corrections) = checked(&SunShadows {
            stable: Stability::Held,
            measured,
            ..SunShadows::HIGH
        });
        assert_eq!(
            (right.warp, right.measured, corrections),
            (Warp::Lispsm, measured, Vec::new())
        );
    }

    #[test]
    fn the_full_path_has_its_own_limits() {
        let wrong = SunShadows {
            partitions: Partitions {
                count: 0,
                ..Partitions::default()
            },
            map_size: 1,
            ..SunShadows::HIGH
        };
        let (right, corrections) = checked(&wrong);
        assert_eq!((right.partitions.count, right.map_size), (1, 16));
        assert_eq!(corrections, [Correction::MapSize, Correction::Count]);
        let odd = SunShadows {
            map_size: 1000,
            ..SunShadows::HIGH
        };
        assert_eq!(checked(&odd).1, Vec::new(), "the atlas takes any size");
    }

    #[test]
    fn faces_and_seams_are_limited() {
        let apart = Partitions {
            faces: Faces::Apart { near_map: true },
            ..Partitions::slices(9)
        };
        let (right, corrections) = checked(&SunShadows {
            partitions: apart,
            seams: Seams {
                width: SeamWidth::Share(0.9),
                fade: f32::NAN,
            },
            ..SunShadows::HIGH
        });
        assert_eq!(right.partitions.count, 4);
        assert_eq!(
            right.partitions.faces,
            Faces::Apart { near_map: false },
            "16 maps are the most"
        );
        assert_eq!((right.seams.width, right.seams.fade), (SeamWidth::Share(0.5), 0.0));
        assert_eq!(
            corrections,
            [Correction::FaceCount, Correction::NearMap, Correction::Seams]
        );
    }
}
