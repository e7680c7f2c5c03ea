//! Text to [`Technique`].

use std::str::FromStr;

use super::{
    Technique,
    base::{self, Base},
    error::TechniqueError,
    pairs::{Pairs, topics},
    stock_keys, warps,
};
use crate::shadow::settings::SunShadows;

impl FromStr for Technique {
    type Err = TechniqueError;

    fn from_str(text: &str) -> Result<Self, TechniqueError> {
        let (head, keys) = text.split_once(':').unwrap_or((text, ""));
        let (name, warp) = match head.split_once('+') {
            Some((name, warp)) => (name, Some(warps::read(warp)?)),
            None => (head, None),
        };
        if name == "bevy" {
            return match warp {
                Some(_) => Err(TechniqueError::Takes {
                    base: "bevy",
                    what: "warp",
                }),
                None => stock_keys::read(&Pairs::parse(keys, &[])?).map(Self::Bevy),
            };
        }
        let (base, settings) = base::read(name, warp)?;
        with_keys(name, base, settings, &Pairs::parse(keys, base.topics)?).map(Self::Umbrage)
    }
}

/// Writes the keys over the settings of a base.
fn with_keys(name: &str, base: &Base, mut settings: SunShadows, pairs: &Pairs) -> Result<SunShadows, TechniqueError> {
    for key in pairs.keys() {
        if stock_keys::is_stock(key) {
            return Err(TechniqueError::together(format!(
                "`{}=` belongs to `bevy`; other techniques take `bias=`",
                key.name
            )));
        }
        let is_taken = topics(base.topics).any(|topic| topic.keys.iter().any(|taken| taken.name == key.name));
        if !is_taken {
            return Err(TechniqueError::together(format!(
                "`{}=` means nothing with `{name}`",
                key.name
            )));
        }
    }
    for topic in topics(base.topics) {
        (topic.read)(&mut settings, pairs)?;
    }
    Ok(settings)
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
                Faces, FitSettings, MapResolution, PartitionSelection, Partitions, SeamWidth, ShadowBias, ShadowBlur,
                ShadowFilter, ShadowPath, ShadowStore, TransparentLayers, WarpDirection,
            },
            stable::Stability,
            technique::StockBias,
            virtual_maps::ShadowMaps,
        },
    };

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
            "zp3+free:path=full,size=500,splits=10/30.5,select=depth,filter=hard,bias_m=0.2,near=1.5,far=auto,stable=sharp,frames=8,distance=300,eta=-0.25,fallback=off",
        );
        let expected = SunShadows {
            path: ShadowPath::Full,
            maps: ShadowMaps::Partitions,
            partitions: Partitions {
                scheme: SplitScheme::Manual(vec![10.0, 30.5]),
                ..Partitions::slices(3)
            },
            warp: Warp::Free { eta: -0.25 },
            light_planes: None,
            map_size: 500,
            selection: PartitionSelection::Depth,
            filter: ShadowFilter::Hard,
            bias: ShadowBias::Constant { metres: 0.2 },
            store: ShadowStore::Nearest,
            blur: ShadowBlur::NONE,
            distance: Some(300.0),
            near: Some(1.5),
            measured: MeasuredDepths {
                far: true,
                ..MeasuredDepths::BEST
            },
            stable: Stability::Sharp { frames: 8 },
            fallback_map: false,
            ..SunShadows::HIGH
        };
        assert_eq!(all, expected);
        assert_eq!(settings("zp4:path=dropin").path, ShadowPath::DropIn);
        assert_eq!(settings("zp4:split=log").partitions.scheme, SplitScheme::Logarithmic);
        assert_eq!(
            settings("zp4:lambda=0.3").partitions.scheme,
            SplitScheme::Practical { lambda: 0.3 }
        );
        let measured = |text: &str| settings(text).measured;
        let near = MeasuredDepths {
            near: NearMeasurement::On,
            ..MeasuredDepths::BEST
        };
        assert_eq!(measured("zp4:near=auto"), near);
        let same = MeasuredDepths {
            splits: true,
            measure: MeasureUse::Same,
            ..near
        };
        assert_eq!(measured("zp4:near=auto,splits=visible,measure=same"), same);
        assert_eq!(
            settings("zp4:split=log,splits=visible").partitions.scheme,
            SplitScheme::Logarithmic
        );
        assert_eq!(settings("zp4:bias=none").bias, ShadowBias::None);
        assert_eq!(settings("zp4:far=bounds,distance=auto,stable=off"), settings("zp4"));
        let by_bounds = settings("zp4+lispsm:near=bounds");
        assert_eq!((by_bounds.measured, by_bounds.near), (MeasuredDepths::OFF, None));
        assert!(!by_bounds.measures().is_on() && settings("zp4+lispsm").measures().is_on());
        assert_eq!(settings("zp4:split=self"), settings("zp4:split=log"));
        let fit = settings(
            "zp2+free:etas=0/-0.5,center=vertex,axis=middle,optimum=demo,pseudo_near=2,pseudo_far=90,guard=off",
        );
        assert_eq!(fit.partitions.etas, [0.0, -0.5]);
        let expected = FitSettings {
            center: ProjectionCenter::NearestVertex,
            axis: WarpDirection::Middle,
            optimum: OptimumRule::Demo,
            pseudo_near: Some(2.0),
            pseudo_far: Some(90.0),
            guard: false,
            align: true,
        };
        assert_eq!(fit.fit, expected);
        assert!(!settings("zp4:align=off").fit.align);
        let seams = settings("zp4:seam=2.5m,fade=0.1,resolution=balanced");
        assert_eq!((seams.seams.width, seams.seams.fade), (SeamWidth::Metres(2.5), 0.1));
        assert_eq!(seams.partitions.resolution, MapResolution::Balanced);
        assert_eq!(settings("zp4:seam=0.1").seams.width, SeamWidth::Share(0.1));
    }

    #[test]
    fn face_partitions_share_one_budget() {
        for (text, slices, near_map, maps, size) in [
            ("fp", 1, true, 5, 1365),
            ("fp2", 2, true, 9, 1365),
            ("fp3+lispsm", 3, true, 13, 1024),
            ("fp4", 4, false, 16, 1024),
            ("fp2:near_map=off", 2, false, 8, 1365),
        ] {
            let faces = settings(text);
            assert_eq!(faces.partitions.faces, Faces::Apart { near_map }, "{text}");
            assert_eq!(
                (faces.partitions.count, faces.partitions.maps(), faces.map_size),
                (slices, maps, size)
            );
        }
        assert_eq!(settings("fp1"), settings("fp"));
        assert_eq!(settings("fp+lispsm").warp, Warp::Lispsm);
        assert_eq!(settings("fp2:split=log").partitions.scheme, SplitScheme::Logarithmic);
    }

    #[test]
    fn transparent_layers_are_counted_where_there_are_several() {
        for (text, layers, expected) in [
            (
                "lispsm:transparent_layer=on",
                TransparentLayers::Nearest,
                "lispsm:transparent_layer=nearest",
            ),
            ("lispsm:transparent_layer=off", TransparentLayers::Off, "lispsm"),
            (
                "lispsm:transparent_layer=all,transparent_layers=4",
                TransparentLayers::All { count: 4 },
                "lispsm:transparent_layer=all",
            ),
            (
                "lispsm:transparent_layers=8,transparent_layer=all",
                TransparentLayers::All { count: 8 },
                "lispsm:transparent_layer=all,transparent_layers=8",
            ),
        ] {
            let settings = settings(text);
            assert_eq!(settings.transparent_layers, layers, "{text}");
            assert_eq!(Technique::Umbrage(settings).to_string(), expected);
        }
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
                "optimum",
                &["no technique `optimum`", "optimal", "fitted", "zp16", "lispsm"][..],
            ),
            ("fp5", &["`fp5`", "1 to 4"]),
            ("fp0", &["`fp0`", "1 to 4"]),
            ("fpx", &["`fpx`", "1 to 4"]),
            ("fp4:near_map=on", &["`fp4`", "no room"]),
            ("fp:path=dropin", &["face partitions", "view depth"]),
            ("fp:select=depth", &["`select=`", "finest"]),
            ("zp4:near_map=on", &["`near_map=`", "`zp4`"]),
            ("zp4:path=dropin,resolution=balanced", &["`resolution=`", "path=dropin"]),
            ("zp4:path=dropin,seam=0.1", &["`seam=`", "path=dropin"]),
            ("zp4:seam=0.6", &["`seam=0.6`", "0..=0.5"]),
            ("zp4:seam=-1m", &["`seam=-1m`"]),
            ("zp4:fade=2", &["`fade=2`", "0..=1"]),
            ("zp4+lispsm:etas=0/0/0/0", &["`etas=`", "free"]),
            ("zp4+free:etas=0/0", &["`etas=`", "4 of them"]),
            ("zp2+free:etas=0/0.5,path=dropin", &["stronger than lispsm"]),
            ("lispsm:align=off", &["align=off", "no warp"]),
            ("lispsm:center=edge", &["`center=edge`", "vertex"]),
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
            (
                "zp4:colour=red",
                &["no key `colour`", "path, size, fallback", "depth_bias"],
            ),
            ("zp4:size=0", &["`size=0`", "16..=8192"]),
            ("zp16:size=8192", &["16 maps", "4096"]),
            ("zp4:size", &["`size=`"]),
            ("zp4:size=256,size=512", &["twice"]),
            ("zp8:path=dropin", &["at most 4"]),
            ("zp4:path=dropin,filter=hard", &["`filter=`", "path=dropin"]),
            ("zp4:path=dropin,select=depth", &["`select=`"]),
            ("lispsm:path=dropin,fallback=off", &["`fallback=`"]),
            (
                "lispsm:transparent_layer=both",
                &["`transparent_layer=both`", "off|nearest|all"],
            ),
            (
                "lispsm:transparent_layer=all,transparent_layers=9",
                &["`transparent_layers=9`", "1..=8"],
            ),
            (
                "lispsm:transparent_layer=on,transparent_layers=2",
                &["`transparent_layer=all`"],
            ),
            ("lispsm:transparent_layers=2", &["`transparent_layer=all`"]),
            ("lispsm:path=dropin,transparent_layer=all", &["`transparent_layer=`"]),
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
            ("zp4:near=-1", &["bounds|auto|metres"]),
            ("zp4:far=100", &["bounds|auto"]),
            ("zp4:path=dropin,near=auto", &["`path=dropin`", "near=auto"]),
            ("zp4:path=dropin,splits=visible", &["`path=dropin`", "splits=visible"]),
            ("zp4:split=manual,splits=visible", &["`splits=` with 3"]),
            ("zp4:measure=same", &["near=auto"]),
            ("zp4:measure=soon,near=auto", &["late|same"]),
            ("zp4+lispsm:stable=sphere", &["`stable=sphere`", "no warp"]),
            ("lispsm:stable=quantised", &["`stable=quantised`", "no warp"]),
            ("zp4:stable=sphere,near=auto", &["no measured depths"]),
            ("fp:stable=held", &["`stable=held`", "z-partitions"]),
            (
                "zp4:stable=sphere,resolution=balanced",
                &["`stable=sphere`", "resolution=equal"],
            ),
            ("zp4:stable=still", &["off|sphere|quantised|held|sharp"]),
            ("zp4:frames=8", &["stable=sharp"]),
            ("zp4:stable=sharp,frames=33", &["`frames=33`", "2..=32"]),
            ("zp4:path=dropin,stable=held", &["`stable=`", "path=dropin"]),
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
