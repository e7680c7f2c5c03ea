//! `uniform`, a warp alone, and `zpN`: z-partitions, one or more.

use super::Base;
use crate::{
    maths::warp::Warp,
    shadow::{
        settings::{Partitions, SunShadows},
        technique::{default_map_size, error::TechniqueError, partition_keys, warps},
    },
};

pub(super) const BASE: Base = Base {
    names: "uniform, zp1 to zp16",
    read,
    owns: |_| true,
    text,
    topics: &[&partition_keys::TOPIC],
};

fn read(text: &str, warp: Option<Warp>) -> Result<Option<SunShadows>, TechniqueError> {
    let (count, warp) = match (text, warp) {
        ("uniform", None) => (1, Warp::Uniform),
        ("uniform", Some(_)) => {
            return Err(TechniqueError::Takes {
                base: "uniform",
                what: "warp",
            });
        }
        _ => match text.strip_prefix("zp") {
            Some(digits) => (count(text, digits)?, warp.unwrap_or(Warp::Uniform)),
            None => match (warp, warps::read(text)) {
                (None, Ok(warp)) => (1, warp),
                _ => return Ok(None),
            },
        },
    };
    Ok(Some(SunShadows {
        partitions: Partitions::slices(count),
        warp,
        map_size: default_map_size(count),
        ..SunShadows::HIGH
    }))
}

fn count(text: &str, digits: &str) -> Result<u32, TechniqueError> {
    match digits.parse() {
        Ok(count @ 1..=SunShadows::MAX_PARTITIONS) => Ok(count),
        _ => Err(TechniqueError::Count {
            text: text.to_owned(),
            expected: "z-partitions are counted 1 to 16, as in `zp4`",
        }),
    }
}

fn text(settings: &SunShadows) -> (String, Option<Warp>) {
    match (settings.partitions.count, settings.warp) {
        (1, warp) => (warps::name(warp).unwrap_or("uniform").to_owned(), None),
        (count, Warp::Uniform) => (format!("zp{count}"), None),
        (count, warp) => (format!("zp{count}"), Some(warp)),
    }
}
