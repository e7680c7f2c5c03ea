//! `tiled`, `queried` and `fitted`: virtual maps of one light view, with any warp; `fitted` also of one per z-partition.

use super::Base;
use crate::{
    maths::warp::Warp,
    shadow::{
        fitted::FittedMaps,
        settings::{Partitions, SunShadows},
        technique::{fitted_keys, partition_keys, tile_keys, warps},
        virtual_maps::{QueriedMaps, ShadowMaps, TiledMaps},
    },
};

pub(super) const TILED: Base = Base {
    names: "tiled",
    read: |text, warp| Ok((text == "tiled").then(|| settings(ShadowMaps::Tiled(TiledMaps::default()), warp))),
    owns: |settings| matches!(settings.maps, ShadowMaps::Tiled(_)),
    text: |settings| text("tiled", settings),
    topics: &[&tile_keys::TILED],
};

pub(super) const QUERIED: Base = Base {
    names: "queried",
    read: |text, warp| Ok((text == "queried").then(|| settings(ShadowMaps::Queried(QueriedMaps::default()), warp))),
    owns: |settings| matches!(settings.maps, ShadowMaps::Queried(_)),
    text: |settings| text("queried", settings),
    topics: &[&tile_keys::QUERIED],
};

pub(super) const FITTED: Base = Base {
    names: "fitted",
    read: |text, warp| Ok((text == "fitted").then(|| settings(ShadowMaps::Fitted(FittedMaps::default()), warp))),
    owns: |settings| matches!(settings.maps, ShadowMaps::Fitted(_)),
    text: |settings| text("fitted", settings),
    topics: &[&fitted_keys::TOPIC, &partition_keys::TOPIC],
};

/// What a base of virtual maps means without keys.
fn settings(maps: ShadowMaps, warp: Option<Warp>) -> SunShadows {
    SunShadows {
        maps,
        partitions: Partitions {
            count: 1,
            ..Partitions::default()
        },
        warp: warp.unwrap_or(Warp::Uniform),
        ..SunShadows::HIGH
    }
}

fn text(name: &str, settings: &SunShadows) -> (String, Option<Warp>) {
    (name.to_owned(), warps::name(settings.warp).map(|_| settings.warp))
}
