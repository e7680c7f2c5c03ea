//! Keys of perspective-optimal light planes, and their text.

use super::{
    default_map_size,
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, number},
};
use crate::{
    maths::light_plane::space::{FilmCover, FilmDivision, FilmMetric, FilmShape},
    shadow::{
        light_plane::LightPlanes,
        settings::{ShadowPath, SunShadows},
    },
};

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::new("frusta", "films, 1..=8; at most 4 with path=dropin"),
        Key::new("metric", "area|stretch, or l1|l2 for the same"),
        Key::new("film", "parallelogram|rectangle"),
        Key::full("divide", "depth|tiles, for frusta=2 and more"),
        Key::full("cover", "seen|body: what was seen, or all that may be seen"),
        Key::new("damping", "seconds 0..=10 in which films follow what is seen"),
    ],
    read,
    changes,
};

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    let Some(mut planes) = settings.light_planes else {
        return Ok(());
    };
    if let Some(frusta) = pairs.read("frusta", |text| {
        text.parse()
            .ok()
            .filter(|count| (1..=LightPlanes::MAX_FRUSTA).contains(count))
    })? {
        planes.frusta = frusta;
    }
    if let Some(metric) = pairs.read("metric", |text| match text {
        "area" | "l1" => Some(FilmMetric::Area),
        "stretch" | "l2" => Some(FilmMetric::Stretch),
        _ => None,
    })? {
        planes.metric = metric;
    }
    if let Some(film) = pairs.read("film", |text| match text {
        "parallelogram" => Some(FilmShape::Parallelogram),
        "rectangle" => Some(FilmShape::Rectangle),
        _ => None,
    })? {
        planes.film = film;
    }
    if let Some(division) = pairs.read("divide", |text| match text {
        "depth" => Some(FilmDivision::Depth),
        "tiles" => Some(FilmDivision::Tiles),
        _ => None,
    })? {
        planes.division = division;
    }
    if let Some(cover) = pairs.read("cover", |text| match text {
        "seen" => Some(FilmCover::Seen),
        "body" => Some(FilmCover::Body),
        _ => None,
    })? {
        planes.cover = cover;
    }
    if let Some(seconds) = pairs.read("damping", |text| number(text, 0.0..=LightPlanes::LONGEST_DAMPING))? {
        planes.damping = seconds;
    }
    if planes.division == FilmDivision::Tiles && planes.frusta == 1 {
        return Err(TechniqueError::together(
            "`divide=tiles` needs more than one film to divide: say frusta=2..8",
        ));
    }
    if planes.cover == FilmCover::Body && planes.division == FilmDivision::Tiles {
        return Err(TechniqueError::together(
            "`cover=body` does not go with `divide=tiles`: where nothing was seen there would be no map",
        ));
    }
    if settings.path == ShadowPath::DropIn {
        if planes.frusta > SunShadows::MAX_DROP_IN_PARTITIONS {
            return Err(TechniqueError::together(format!(
                "`path=dropin` has at most {} films, not {}",
                SunShadows::MAX_DROP_IN_PARTITIONS,
                planes.frusta
            )));
        }
        // One map for each film, and none for what was not seen.
        planes.cover = FilmCover::Body;
        if !pairs.has("size") {
            settings.map_size = default_map_size(planes.frusta);
        }
    }
    settings.light_planes = Some(planes);
    Ok(())
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    let (Some(planes), Some(default)) = (&settings.light_planes, &default.light_planes) else {
        return Vec::new();
    };
    let mut pairs = Vec::new();
    if planes.frusta != default.frusta {
        pairs.push(format!("frusta={}", planes.frusta));
    }
    if planes.metric != default.metric {
        pairs.push("metric=stretch".to_owned());
    }
    if planes.film != default.film {
        pairs.push("film=rectangle".to_owned());
    }
    if planes.division != default.division {
        pairs.push("divide=tiles".to_owned());
    }
    if planes.cover != default.cover && settings.path == ShadowPath::Full {
        pairs.push("cover=body".to_owned());
    }
    if planes.damping != default.damping {
        pairs.push(format!("damping={}", planes.damping));
    }
    pairs
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::shadow::technique::Technique;

    fn planes(text: &str) -> LightPlanes {
        match text.parse() {
            Ok(Technique::Umbrage(settings)) => settings.light_planes.expect("light planes"),
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn keys_reach_the_light_planes() {
        assert_eq!(planes("optimal"), LightPlanes::default());
        let all = planes("optimal:frusta=4,metric=l2,film=rectangle,divide=tiles,damping=0");
        let expected = LightPlanes {
            frusta: 4,
            metric: FilmMetric::Stretch,
            film: FilmShape::Rectangle,
            division: FilmDivision::Tiles,
            cover: FilmCover::Seen,
            damping: 0.0,
        };
        assert_eq!(all, expected);
        assert_eq!(planes("optimal:metric=l1"), planes("optimal:metric=area"));
        assert_eq!(planes("optimal:path=dropin").cover, FilmCover::Body);
    }

    #[test]
    fn nonsense_is_refused() {
        for (text, part) in [
            ("optimal+lispsm", "takes no warp"),
            ("optimal:frusta=0", "1..=8"),
            ("optimal:frusta=9", "1..=8"),
            ("optimal:metric=linf", "area|stretch"),
            ("optimal:divide=tiles", "more than one film"),
            ("optimal:frusta=4,divide=tiles,cover=body", "no map"),
            ("optimal:path=dropin,frusta=5", "at most 4"),
            ("optimal:path=dropin,frusta=2,divide=tiles", "path=dropin"),
            ("optimal:damping=-1", "0..=10"),
            ("optimal:lambda=0.5", "means nothing"),
            ("zp4:frusta=2", "means nothing"),
        ] {
            let message = text.parse::<Technique>().expect_err(text).to_string();
            assert!(message.contains(part), "{text}: {message:?} lacks {part:?}");
        }
    }

    #[test]
    fn texts_are_short() {
        for text in [
            "optimal",
            "optimal:frusta=4",
            "optimal:frusta=2,divide=tiles",
            "optimal:path=dropin",
        ] {
            let technique: Technique = text.parse().unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(technique.to_string(), text);
        }
    }

    proptest! {
        #[test]
        fn text_round_trips(
            frusta in 1u32..=8,
            metric in prop_oneof![Just(FilmMetric::Area), Just(FilmMetric::Stretch)],
            film in prop_oneof![Just(FilmShape::Parallelogram), Just(FilmShape::Rectangle)],
            (division, cover) in prop_oneof![
                Just((FilmDivision::Depth, FilmCover::Seen)),
                Just((FilmDivision::Depth, FilmCover::Body)),
                Just((FilmDivision::Tiles, FilmCover::Seen)),
            ],
            damping in 0.0f32..=10.0,
            map_size in 16u32..=4096,
        ) {
            prop_assume!(frusta > 1 || division == FilmDivision::Depth);
            let planes = LightPlanes { frusta, metric, film, division, cover, damping };
            let technique = Technique::Umbrage(SunShadows { light_planes: Some(planes), map_size, ..SunShadows::HIGH });
            prop_assert_eq!(technique.to_string().parse(), Ok(technique));
        }
    }
}
