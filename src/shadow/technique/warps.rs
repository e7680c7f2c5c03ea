//! Names of the warps.

use super::error::TechniqueError;
use crate::maths::warp::Warp;

/// Every warp that has a name, as it is without keys.
const WARPS: [(&str, Warp); 5] = [
    ("lispsm", Warp::Lispsm),
    ("repar", Warp::Repar),
    ("psm", Warp::Psm),
    ("tsm", Warp::Tsm { focus: Warp::TSM_FOCUS }),
    ("free", Warp::Free { eta: 0.0 }),
];

/// `lispsm, repar, …`
pub(super) fn names() -> String {
    WARPS.map(|(name, _)| name).join(", ")
}

/// The warp with this name.
pub(super) fn read(text: &str) -> Result<Warp, TechniqueError> {
    match WARPS.into_iter().find(|(name, _)| *name == text) {
        Some((_, warp)) => Ok(warp),
        None => Err(TechniqueError::Warp { name: text.to_owned() }),
    }
}

/// The name of a warp; no warp has none.
pub(super) fn name(warp: Warp) -> Option<&'static str> {
    match warp {
        Warp::Uniform => None,
        Warp::Lispsm => Some("lispsm"),
        Warp::Repar => Some("repar"),
        Warp::Psm => Some("psm"),
        Warp::Tsm { .. } => Some("tsm"),
        Warp::Free { .. } => Some("free"),
    }
}

/// What the name of a warp means.
pub(super) fn without_keys(warp: Warp) -> Warp {
    match warp {
        Warp::Tsm { .. } => Warp::Tsm { focus: Warp::TSM_FOCUS },
        Warp::Free { .. } => Warp::Free { eta: 0.0 },
        Warp::Uniform | Warp::Lispsm | Warp::Repar | Warp::Psm => warp,
    }
}
