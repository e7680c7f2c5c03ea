//! [`SunShadows`]: everything a user sets, on the entity of the directional light.

use bevy::{light::DirectionalLight, prelude::*};

use crate::maths::{split::SplitScheme, warp::Warp};

/// Sharp sun shadows for a [`DirectionalLight`]: add it to the light's entity.
///
/// The defaults are the best all-round values: four warped z-partitions of 2048² texels over the whole view.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(DirectionalLight)]
pub struct SunShadows {
    /// How shadows reach the picture. Full is the default; drop-in touches no shader but is limited to four partitions.
    pub path: ShadowPath,
    /// Number of z-partitions and where they are split.
    pub partitions: Partitions,
    /// The perspective warp of every partition. On the drop-in path none stronger than `LiSPSM`.
    pub warp: Warp,
    /// Texels per side of one partition's map. Memory: 4 bytes per texel and partition
    /// (2048²: 16 MiB each). Useful 256..=4096; default 2048, Bevy's own.
    pub map_size: u32,
    /// Which map a point reads where several cover it. Means nothing on the drop-in path, where Bevy picks by view depth.
    pub selection: PartitionSelection,
    /// How the depth comparison is filtered. Means nothing on the drop-in path, where the camera's
    /// [`ShadowFilteringMethod`](bevy::light::ShadowFilteringMethod) decides.
    pub filter: ShadowFilter,
    /// How self-shadowing is avoided.
    pub bias: ShadowBias,
    /// View depth up to which shadows are computed, in metres. `None`: up to the camera's far plane.
    pub distance: Option<f32>,
    /// View depth from which shadows are computed, in metres. `None`: the camera's near plane, moved to the nearest
    /// point of the scene's bounds. A larger value sharpens; surfaces nearer than it have no guarantee.
    pub near: Option<f32>,
    /// Draws Bevy's own fallback map on the full path, in frames in which the camera sees a transparent surface: such
    /// surfaces read it. Costs one more map of [`DirectionalLightShadowMap`](bevy::light::DirectionalLightShadowMap)
    /// size.
    pub fallback_map: bool,
}

/// On a camera that gets no sun shadows of Umbrage's: everything that it sees is lit, and no light view is computed for it.
/// For views of the whole world, such as maps, where shadows are not worth their time.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct WithoutSunShadows;

/// How shadows reach the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum ShadowPath {
    /// Own caster pass into an atlas, applied into a screen-sized shadow result that Bevy's lighting reads.
    #[default]
    Full,
    /// Bevy's own shadow passes and lookup with better matrices; at most four partitions.
    DropIn,
}

/// z-partitions: slices of the view frustum, one map each.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub struct Partitions {
    /// 1..=16 (drop-in: 1..=4); other values are clamped with a warning.
    pub count: u32,
    /// Where the view frustum is split.
    pub scheme: SplitScheme,
}

/// Which map a point reads where several cover it (Stingl, section 3.3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum PartitionSelection {
    /// By view depth, in half-open intervals.
    Depth,
    /// The first (finest) map that contains the point.
    #[default]
    BestResolution,
}

/// How the depth comparison is filtered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum ShadowFilter {
    /// One comparison: blocky at magnification, exact for measurements.
    Hard,
    /// Bilinear weights of four comparisons.
    #[default]
    Pcf2,
}

/// How self-shadowing is avoided.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub enum ShadowBias {
    /// No bias: for measurements.
    None,
    /// A constant distance towards the light.
    Constant {
        /// Metres.
        metres: f32,
    },
    /// Every comparison uses the depth of the receiver's plane at the texel that it reads, and a share of the depth that
    /// this plane spans over the local texel footprint: needs no tuning at any warp, partition or resolution. On the
    /// drop-in path: a number of local texels for casters and of near texels along the receiver's normal.
    Footprint {
        /// Share of the span, in halves: 1 keeps half a texel's span between a surface and its own shadow. On the drop-in
        /// path a factor on both numbers.
        scale: f32,
    },
}

impl Default for ShadowBias {
    fn default() -> Self {
        Self::Footprint { scale: 1.0 }
    }
}

impl Default for Partitions {
    fn default() -> Self {
        Self {
            count: 4,
            scheme: Self::SCHEME,
        }
    }
}

impl Partitions {
    /// The default split. Measured with four warped maps on the tuning shots of forest and city (far plane 500 m, 480x270;
    /// wrong pixels in percent): lambda 0.8 0.386 and 1.654, 0.9 0.390 and 0.905, 0.94 0.375 and 0.968, 0.97 0.345 and
    /// 1.073, 0.99 0.337 and 1.107.
    pub const SCHEME: SplitScheme = SplitScheme::Practical { lambda: 0.9 };
}

impl Default for SunShadows {
    fn default() -> Self {
        Self::HIGH
    }
}

impl SunShadows {
    /// The largest number of partitions on the full path.
    pub const MAX_PARTITIONS: u32 = 16;
    /// The largest number of partitions that Bevy's own lookup can take.
    pub const MAX_DROP_IN_PARTITIONS: u32 = 4;

    /// One warped map of 2048²: the cheapest, 16 MiB.
    pub const LOW: Self = Self::preset(1, 2048);
    /// Two warped maps of 2048², 32 MiB.
    pub const MEDIUM: Self = Self::preset(2, 2048);
    /// Four warped maps of 2048², 64 MiB: the budget of Bevy's default cascades.
    pub const HIGH: Self = Self::preset(4, 2048);
    /// Four warped maps of 4096², 256 MiB.
    pub const ULTRA: Self = Self::preset(4, 4096);

    const fn preset(count: u32, map_size: u32) -> Self {
        Self {
            path: ShadowPath::Full,
            partitions: Partitions {
                count,
                scheme: Partitions::SCHEME,
            },
            warp: Warp::Lispsm,
            map_size,
            selection: PartitionSelection::BestResolution,
            filter: ShadowFilter::Pcf2,
            bias: ShadowBias::Footprint { scale: 1.0 },
            distance: None,
            near: None,
            fallback_map: true,
        }
    }
}
