//! [`Correction`]: what is said about a setting out of range.

use bevy::prelude::*;
use thiserror::Error;

/// What was wrong with a setting and what is used instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum Correction {
    /// `partitions.count` on the full path.
    #[error("SunShadows::partitions.count must be 1 to 16: the nearest is used")]
    Count,
    /// `partitions.count` on the drop-in path.
    #[error(
        "SunShadows::partitions.count must be 1 to 4 on the drop-in path, because Bevy looks up no more: the nearest is used"
    )]
    DropInCount,
    /// `partitions.count` with face partitions.
    #[error("SunShadows::partitions.count must be 1 to 4 with face partitions: the nearest is used")]
    FaceCount,
    /// `partitions.faces`.
    #[error("SunShadows::partitions.faces: four slices leave no map for the near face: it gets none")]
    NearMap,
    /// `partitions.faces`, `partitions.resolution` or `seams` on the drop-in path.
    #[error(
        "SunShadows::partitions must have no faces and equal maps, and SunShadows::seams be empty, on the drop-in path, because Bevy looks shadows up by depth in equal maps: the defaults are used"
    )]
    DropInPartitions,
    /// `map_size`.
    #[error("SunShadows::map_size must be 16 to 8192: the nearest is used")]
    MapSize,
    /// `map_size` on the drop-in path.
    #[error("SunShadows::map_size must be a power of two on the drop-in path: the next larger is used")]
    DropInMapSize,
    /// `partitions.scheme`.
    #[error("SunShadows::partitions.scheme: lambda must be 0 to 1: the nearest is used, 0.5 for NaN")]
    Lambda,
    /// `warp` or `partitions.etas`.
    #[error("SunShadows::warp and partitions.etas: eta must be -1 to 1: the nearest is used, -1 for NaN")]
    Eta,
    /// `fit`.
    #[error(
        "SunShadows::fit: pseudo_near and pseudo_far must be finite numbers above 0: the planes of the view are used"
    )]
    PseudoPlanes,
    /// `seams`.
    #[error(
        "SunShadows::seams: shares must be 0 to 0.5, fade 0 to 1 and metres finite: the nearest are used, 0 for NaN"
    )]
    Seams,
    /// `warp`.
    #[error("SunShadows::warp: focus must be 0 to 1: the nearest is used, the default for NaN")]
    Focus,
    /// `warp` on the drop-in path.
    #[error(
        "SunShadows::warp must not be stronger than LiSPSM on the drop-in path, because Bevy's bias cannot follow its texels: LiSPSM is used"
    )]
    DropInWarp,
    /// `light_planes`.
    #[error(
        "SunShadows::light_planes: frusta must be 1 to 8, damping 0 to 10 s; films of tiles cover what was seen, films of the drop-in path (at most 4, by depth) what may be seen: the nearest is used"
    )]
    LightPlanes,
    /// `light_planes` and `maps`.
    #[error("SunShadows::light_planes: films are maps of an atlas, virtual maps have none: the virtual map is used")]
    VirtualLightPlanes,
    /// `bias`.
    #[error("SunShadows::bias must be a finite number, 0 or more: 0 is used")]
    Bias,
    /// `distance`.
    #[error("SunShadows::distance must be more than 0: the camera's far plane is used")]
    Distance,
    /// `near`.
    #[error("SunShadows::near must be a finite number, 0 or more: the camera's near plane is used")]
    Near,
    /// `bias` on the drop-in path.
    #[error("SunShadows::bias must be none, constant or footprint on the drop-in path: the default is used")]
    DropInBias,
    /// `filter`.
    #[error(
        "SunShadows::filter: taps must be 8 to 64, radius 0 to 2 m, the sun's diameter 0 to 10 degrees: the nearest are used"
    )]
    Filter,
    /// `maps` on the drop-in path.
    #[error("SunShadows::maps: virtual maps need the full path: partitions are used")]
    DropInVirtual,
    /// `maps`.
    #[error(
        "SunShadows::maps: a number of tiles, a size, a threshold or the memory is out of range: the nearest is used"
    )]
    VirtualNumbers,
    /// `store` of virtual maps.
    #[error("SunShadows::store: virtual maps hold one surface: the nearest is used")]
    VirtualStore,
    /// `blur`.
    #[error("SunShadows::blur: iterations must be 0 to 16 and full_depth more than 0: the nearest, or 10 m, are used")]
    Blur,
    /// `transparent_layers`.
    #[error("SunShadows::transparent_layers: all takes 1 to 8 layers: the nearest is used")]
    TransparentLayers,
    /// `stable` and `warp`.
    #[error(
        "SunShadows::stable: bounding spheres and quantised scales take no warp, because a warped grid cannot be shifted by whole texels: the warp is left out"
    )]
    StableWarp,
    /// `stable` and `partitions`.
    #[error(
        "SunShadows::stable: maps that are held need z-partitions of equal resolution, which are the same from frame to frame: nothing is held"
    )]
    StablePartitions,
    /// `stable` and `measured`.
    #[error(
        "SunShadows::stable: bounding spheres take no measured depths, which change from frame to frame: they are left out"
    )]
    StableMeasured,
    /// `stable`.
    #[error("SunShadows::stable: sharp takes 2 to 32 frames: the nearest is used")]
    StableFrames,
}

/// Warns of every kind of correction once.
pub(super) fn warn_of(corrections: Vec<Correction>, known: &mut Vec<Correction>) {
    for correction in corrections {
        if !known.contains(&correction) {
            known.push(correction);
            warn!("{correction}");
        }
    }
}
