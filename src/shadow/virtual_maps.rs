//! [`ShadowMaps`]: whether a sun draws its partitions into an atlas, or one virtual map tile by tile (Giegl 2007).

use bevy::prelude::*;

use super::{
    fitted::FittedMaps,
    settings::{Faces, MapResolution, Partitions, ShadowPath, SunShadows},
};
use crate::maths::virtual_map::{
    memory::DEFAULT_BUDGET,
    queried::{ChangeThreshold, OpportunityJump, QueriedMap},
    tiled::MAX_TILES_PER_AXIS,
};

/// The maps of a sun. Virtual maps are for the full path and have one light view for the whole range, with any warp; fitted
/// ones may have one per z-partition, each with a map of its own. `map_size` means nothing for them, and they store the
/// nearest surface or back faces.
#[derive(Clone, Debug, Default, PartialEq, Reflect)]
pub enum ShadowMaps {
    /// One map per partition, in an atlas.
    #[default]
    Partitions,
    /// Every tile of one huge map, each drawn, used and overwritten by another. Costs as many texels as the map has: for
    /// pictures and for comparison.
    Tiled(TiledMaps),
    /// Tiles of one huge map, coarse to fine, as long as finer ones change the picture. Waits for the GPU after each of up
    /// to six levels.
    Queried(QueriedMaps),
    /// Tiles of one huge map, as fine as the depths of the picture say that they are needed. Waits for the GPU once.
    Fitted(FittedMaps),
}

/// Settings of a tiled map.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub struct TiledMaps {
    /// Tiles per axis, 1..=32. Texels grow with its square; what the eye sees grows with its logarithm.
    pub tiles_per_axis: u32,
    /// Texels per side of a tile's texture, margins for filters included; 16..=8192.
    pub tile_size: u32,
    /// Leaves out tiles in which no visible surface can lie. Changes no pixel; off, so that the reference relies on nothing.
    pub skip_empty: bool,
    /// One tile while the camera or the sun moves, then 2, 4, 8 … per axis, one step per frame: for viewers that rest most
    /// of the time. Casters that move keep the number that is reached, unless they
    /// change the bounds of the scene.
    pub progressive: bool,
    /// MiB of tile textures alive at once, 1..=4096; half of it is kept for casters that fade where there are levels of
    /// detail. Where one tile needs more, tiles are smaller and more.
    pub memory: u32,
}

/// Settings of a queried map.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub struct QueriedMaps {
    /// When and how tiles are refined; texel counts are those of textures, margins for filters included.
    pub refinement: QueriedMap,
    /// MiB of tile textures alive at once, 1..=4096; half of it is kept for casters that fade where there are levels of
    /// detail. Where the largest tile needs more, jumps are smaller, then tiles are.
    pub memory: u32,
}

impl Default for TiledMaps {
    /// 32 768 texels per axis.
    fn default() -> Self {
        Self {
            tiles_per_axis: 16,
            tile_size: 2048,
            skip_empty: false,
            progressive: false,
            memory: DEFAULT_MEMORY,
        }
    }
}

impl Default for QueriedMaps {
    /// 32 768 texels per axis at most.
    fn default() -> Self {
        Self {
            refinement: QueriedMap::default(),
            memory: DEFAULT_MEMORY,
        }
    }
}

/// MiB.
pub(super) const DEFAULT_MEMORY: u32 = (DEFAULT_BUDGET >> 20) as u32;

/// Texels per side of a tile's texture that can be asked for.
pub const TILE_SIZES: std::ops::RangeInclusive<u32> = 16..=8192;

/// MiB of tile textures that can be asked for.
pub const MEMORY: std::ops::RangeInclusive<u32> = 1..=4096;

/// Most tiles per axis of the finest level of a queried map.
pub const MAX_QUERIED_TILES: u32 = 256;

impl ShadowMaps {
    /// Whether tiles are drawn instead of an atlas.
    #[must_use]
    pub fn is_virtual(&self) -> bool {
        *self != Self::Partitions
    }

    /// Texels per axis of a virtual map at its finest, margins not taken off.
    #[must_use]
    pub fn texels_per_axis(&self) -> Option<u32> {
        match self {
            Self::Partitions => None,
            Self::Tiled(tiled) => Some(tiled.tiles_per_axis * tiled.tile_size),
            Self::Queried(queried) => Some(queried.refinement.max_tiles_per_axis * queried.refinement.tile_size),
            Self::Fitted(fitted) => Some(fitted.texels_per_axis()),
        }
    }

    /// Bytes of tile textures that may be alive at once; 0 without.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        match self {
            Self::Partitions => 0,
            Self::Tiled(TiledMaps { memory, .. })
            | Self::Queried(QueriedMaps { memory, .. })
            | Self::Fitted(FittedMaps { memory, .. }) => u64::from(*memory) << 20,
        }
    }
}

/// What is wrong with the settings of virtual maps, and now right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct VirtualCorrections {
    /// Virtual maps on the drop-in path.
    pub(super) path: bool,
    /// A number out of range.
    pub(super) numbers: bool,
    /// A store that needs two atlases.
    pub(super) store: bool,
    /// Light planes besides.
    pub(super) light_planes: bool,
}

/// Brings the settings of virtual maps into range.
pub(super) fn check(settings: &mut SunShadows) -> VirtualCorrections {
    let mut corrections = VirtualCorrections::default();
    if !settings.maps.is_virtual() {
        return corrections;
    }
    if settings.path == ShadowPath::DropIn {
        settings.maps = ShadowMaps::Partitions;
        corrections.path = true;
        return corrections;
    }
    let count = match settings.maps {
        ShadowMaps::Fitted(_) => settings.partitions.count,
        _ => 1,
    };
    settings.partitions = Partitions {
        count,
        faces: Faces::Together,
        resolution: MapResolution::Equal,
        ..settings.partitions.clone()
    };
    if settings.store.is_layered() {
        settings.store = super::settings::ShadowStore::Nearest;
        corrections.store = true;
    }
    corrections.light_planes = settings.light_planes.take().is_some();
    let before = settings.maps.clone();
    match &mut settings.maps {
        ShadowMaps::Partitions => {}
        ShadowMaps::Tiled(tiled) => {
            tiled.tiles_per_axis = tiled.tiles_per_axis.clamp(1, MAX_TILES_PER_AXIS);
            tiled.tile_size = tiled.tile_size.clamp(*TILE_SIZES.start(), *TILE_SIZES.end());
            tiled.memory = tiled.memory.clamp(*MEMORY.start(), *MEMORY.end());
        }
        ShadowMaps::Queried(queried) => {
            queried.memory = queried.memory.clamp(*MEMORY.start(), *MEMORY.end());
            check_refinement(&mut queried.refinement);
        }
        ShadowMaps::Fitted(fitted) => fitted.clamp(),
    }
    corrections.numbers = settings.maps != before;
    corrections
}

fn check_refinement(map: &mut QueriedMap) {
    let sizes = |size: u32| size.clamp(*TILE_SIZES.start(), *TILE_SIZES.end());
    (map.tile_size, map.tile_size_max) = (sizes(map.tile_size), sizes(map.tile_size_max));
    map.max_tiles_per_axis = map.max_tiles_per_axis.clamp(1, MAX_QUERIED_TILES);
    // NaN and negative thresholds refine everything that changes at all.
    match &mut map.threshold {
        ChangeThreshold::Pixels(pixels) => *pixels = pixels.max(0.0),
        ChangeThreshold::Share(share) => *share = share.max(0.0).min(1.0),
    }
    if let Some(OpportunityJump { decay, .. }) = &mut map.opportunity_jump
        && !(0.0..=1.0).contains(decay)
    {
        *decay = if decay.is_nan() { 0.25 } else { decay.clamp(0.0, 1.0) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shadow::{light_plane::LightPlanes, settings::ShadowStore};

    #[test]
    fn defaults_need_no_correction() {
        for maps in [
            ShadowMaps::Tiled(TiledMaps::default()),
            ShadowMaps::Queried(QueriedMaps::default()),
        ] {
            let mut settings = SunShadows {
                maps: maps.clone(),
                ..SunShadows::LOW
            };
            assert_eq!(check(&mut settings), VirtualCorrections::default());
            assert_eq!(settings.maps, maps);
            assert_eq!(maps.texels_per_axis(), Some(32_768));
            assert_eq!(maps.memory_bytes(), 64 << 20);
        }
    }

    #[test]
    fn numbers_are_limited() {
        let mut settings = SunShadows {
            maps: ShadowMaps::Queried(QueriedMaps {
                refinement: QueriedMap {
                    threshold: ChangeThreshold::Pixels(f64::NAN),
                    max_tiles_per_axis: 0,
                    tile_size: 1,
                    tile_size_max: 100_000,
                    ..QueriedMap::default()
                },
                memory: 0,
            }),
            store: ShadowStore::Midpoint,
            light_planes: Some(LightPlanes::default()),
            ..SunShadows::HIGH
        };
        let corrections = check(&mut settings);
        assert!(corrections.numbers && corrections.store && corrections.light_planes && !corrections.path);
        assert_eq!((settings.partitions.count, settings.store), (1, ShadowStore::Nearest));
        let ShadowMaps::Queried(queried) = &settings.maps else {
            panic!("the kind of maps stays");
        };
        let map = queried.refinement;
        assert_eq!(
            (map.tile_size, map.tile_size_max, map.max_tiles_per_axis),
            (16, 8192, 1)
        );
        assert_eq!((map.threshold, queried.memory), (ChangeThreshold::Pixels(0.0), 1));
        assert_eq!(check(&mut settings), VirtualCorrections::default(), "right now");
    }

    #[test]
    fn the_drop_in_path_has_none() {
        let mut settings = SunShadows {
            path: ShadowPath::DropIn,
            maps: ShadowMaps::Tiled(TiledMaps::default()),
            ..SunShadows::HIGH
        };
        assert!(check(&mut settings).path);
        assert_eq!((settings.maps, settings.partitions.count), (ShadowMaps::Partitions, 4));
    }
}
