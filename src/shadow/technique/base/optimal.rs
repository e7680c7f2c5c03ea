//! `optimal`: perspective-optimal light planes.

use super::Base;
use crate::{
    maths::warp::Warp,
    shadow::{
        light_plane::LightPlanes,
        settings::SunShadows,
        technique::{default_map_size, error::TechniqueError, optimal_keys},
    },
};

pub(super) const BASE: Base = Base {
    names: "optimal",
    read,
    owns: |settings| settings.light_planes.is_some(),
    text: |_| ("optimal".to_owned(), None),
    topics: &[&optimal_keys::TOPIC],
};

fn read(text: &str, warp: Option<Warp>) -> Result<Option<SunShadows>, TechniqueError> {
    match (text, warp) {
        ("optimal", None) => Ok(Some(SunShadows {
            light_planes: Some(LightPlanes::default()),
            map_size: default_map_size(1),
            ..SunShadows::HIGH
        })),
        ("optimal", Some(_)) => Err(TechniqueError::Takes {
            base: "optimal",
            what: "warp",
        }),
        _ => Ok(None),
    }
}
