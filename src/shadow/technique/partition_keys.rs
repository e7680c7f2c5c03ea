//! Keys of the partitions: where the view is split and which map a point reads; and their text.

use super::{
    error::TechniqueError,
    pairs::{Key, Pairs, Topic, metres, number},
};
use crate::{
    maths::{split::SplitScheme, warp::Warp},
    shadow::settings::{Faces, MapResolution, PartitionSelection, Partitions, SunShadows},
};

pub(super) const TOPIC: Topic = Topic {
    keys: &[
        Key::new("split", "log|self|practical|uniform|manual; self is log"),
        Key::new("lambda", "0..=1, for split=practical"),
        Key::new(
            "splits",
            "ascending metres, e.g. 10/30/80, for split=manual; or visible: between the depths in the picture",
        ),
        Key::new("etas", "a strength -1..=1 per slice, e.g. 0/-0.5/-1, for the warp free"),
        Key::full("resolution", "equal|balanced: how texels are divided among maps"),
        Key::full("select", "depth|best|finest: the map that a point reads"),
    ],
    read,
    changes,
};

fn read(settings: &mut SunShadows, pairs: &Pairs) -> Result<(), TechniqueError> {
    let partitions = &mut settings.partitions;
    partitions.scheme = scheme_of(partitions.count, partitions.scheme.clone(), pairs)?;
    if let Some(is_visible) = pairs.read("splits", |text| Some(text == VISIBLE))? {
        settings.measured.splits = is_visible;
    }
    if let Some(etas) = pairs.read("etas", strengths)? {
        if !matches!(settings.warp, Warp::Free { .. }) {
            return Err(TechniqueError::together("`etas=` belongs to the warp `free`"));
        }
        if etas.len() != settings.partitions.count as usize {
            return Err(TechniqueError::together(format!(
                "`etas=` takes a strength per slice, {} of them between slashes",
                settings.partitions.count
            )));
        }
        settings.partitions.etas = etas;
    }
    if let Some(resolution) = pairs.read("resolution", |text| match text {
        "equal" => Some(MapResolution::Equal),
        "balanced" => Some(MapResolution::Balanced),
        _ => None,
    })? {
        settings.partitions.resolution = resolution;
    }
    if pairs.has("select") && settings.partitions.faces != Faces::Together {
        return Err(TechniqueError::together(
            "`select=` means nothing with `fp`: face partitions take the finest map",
        ));
    }
    if let Some(selection) = pairs.read("select", |text| match text {
        "depth" => Some(PartitionSelection::Depth),
        "best" => Some(PartitionSelection::BestResolution),
        "finest" => Some(PartitionSelection::Finest),
        _ => None,
    })? {
        settings.selection = selection;
    }
    Ok(())
}

/// `splits=` for splits of any scheme between the depths that the picture shows.
const VISIBLE: &str = "visible";

/// Ascending lengths between slashes, or nothing for [`VISIBLE`].
fn split_list(text: &str) -> Option<Option<Vec<f32>>> {
    if text == VISIBLE {
        return Some(None);
    }
    let splits: Vec<f32> = text.split('/').map(metres).collect::<Option<_>>()?;
    splits.is_sorted_by(|a, b| a < b).then_some(Some(splits))
}

/// Strengths of warps between slashes.
fn strengths(text: &str) -> Option<Vec<f32>> {
    text.split('/').map(|eta| number(eta, -1.0..=1.0)).collect()
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
        // Lloyd's self-similar splits are the logarithmic ones.
        "log" | "self" => Some(Kind::Log),
        "practical" => Some(Kind::Practical),
        "uniform" => Some(Kind::Uniform),
        "manual" => Some(Kind::Manual),
        _ => None,
    })?;
    let lambda = pairs.read("lambda", |text| number(text, 0.0..=1.0))?;
    let splits = pairs.read("splits", split_list)?.flatten();
    let kind = kind
        .or(lambda.map(|_| Kind::Practical))
        .or(splits.as_ref().map(|_| Kind::Manual));
    if lambda.is_some() && kind != Some(Kind::Practical) {
        return Err(TechniqueError::together("`lambda=` belongs to `split=practical`"));
    }
    if splits.is_some() && kind != Some(Kind::Manual) {
        return Err(TechniqueError::together("`splits=` belongs to `split=manual`"));
    }
    match kind {
        None => Ok(default),
        Some(Kind::Log) => Ok(SplitScheme::Logarithmic),
        Some(Kind::Uniform) => Ok(SplitScheme::Uniform),
        Some(Kind::Practical) => Ok(SplitScheme::Practical {
            lambda: lambda.unwrap_or(match Partitions::SCHEME {
                SplitScheme::Practical { lambda } => lambda,
                _ => 0.5,
            }),
        }),
        Some(Kind::Manual) if count == 1 => Err(TechniqueError::together(
            "`split=manual` and `splits=` mean nothing with one slice: there is nothing to split",
        )),
        Some(Kind::Manual) => match splits {
            Some(splits) if splits.len() + 1 == count as usize => Ok(SplitScheme::Manual(splits)),
            _ => Err(TechniqueError::together(format!(
                "`split=manual` with {count} z-partitions takes `splits=` with {} distances in metres between slashes",
                count - 1
            ))),
        },
    }
}

fn changes(settings: &SunShadows, default: &SunShadows) -> Vec<String> {
    let mut pairs = Vec::new();
    if settings.partitions.scheme != Partitions::scheme_of(settings.path) {
        pairs.push(match &settings.partitions.scheme {
            SplitScheme::Logarithmic => "split=log".to_owned(),
            SplitScheme::Uniform => "split=uniform".to_owned(),
            SplitScheme::Practical { lambda } => format!("lambda={lambda}"),
            SplitScheme::Manual(splits) => {
                let splits: Vec<_> = splits.iter().map(ToString::to_string).collect();
                format!("splits={}", splits.join("/"))
            }
        });
    }
    if settings.measured.splits && !default.measured.splits {
        pairs.push(format!("splits={VISIBLE}"));
    }
    if settings.partitions.etas != default.partitions.etas {
        let etas: Vec<_> = settings.partitions.etas.iter().map(ToString::to_string).collect();
        pairs.push(format!("etas={}", etas.join("/")));
    }
    if settings.partitions.resolution != default.partitions.resolution {
        pairs.push(match settings.partitions.resolution {
            MapResolution::Equal => "resolution=equal".to_owned(),
            MapResolution::Balanced => "resolution=balanced".to_owned(),
        });
    }
    if settings.selection != default.selection {
        pairs.push(match settings.selection {
            PartitionSelection::Depth => "select=depth".to_owned(),
            PartitionSelection::BestResolution => "select=best".to_owned(),
            PartitionSelection::Finest => "select=finest".to_owned(),
        });
    }
    pairs
}
