//! [`SunShadows`]: everything a user sets, on the entity of the directional light.

mod fit;
mod partitions;
mod seams;
mod transparent;

pub use fit::{FitSettings, WarpDirection};
pub use partitions::{Faces, MapResolution, Partitions};
pub use seams::{SeamWidth, Seams};
pub use transparent::TransparentLayers;

use bevy::{light::DirectionalLight, prelude::*};

use super::{
    light_plane::LightPlanes,
    measured::{MeasuredDepths, NearMeasurement},
    stable::Stability,
    virtual_maps::ShadowMaps,
};
use crate::maths::warp::Warp;

/// Sharp sun shadows for a [`DirectionalLight`]: add it to the light's entity.
///
/// The defaults are the best all-round values: four warped z-partitions of 2048² texels over the whole view.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
#[require(DirectionalLight)]
pub struct SunShadows {
    /// How shadows reach the picture. Full is the default; drop-in touches no shader but is limited to four partitions.
    pub path: ShadowPath,
    /// Partitions in an atlas, or one virtual map. The first is the default: it waits for nothing and costs the same in
    /// every frame.
    pub maps: ShadowMaps,
    /// What the view frustum is cut into.
    pub partitions: Partitions,
    /// The perspective warp of every partition. On the drop-in path none stronger than `LiSPSM`.
    pub warp: Warp,
    /// Perspective-optimal light planes instead of partitions and warp, which then mean nothing.
    pub light_planes: Option<LightPlanes>,
    /// How light views are fitted.
    pub fit: FitSettings,
    /// Texels per side of one partition's map; of balanced maps: on average; of light planes: of the square that all maps
    /// share. Memory: 4 bytes per texel and partition
    /// (2048²: 16 MiB each). Useful 256..=4096; default 2048, Bevy's own.
    pub map_size: u32,
    /// Which map a point reads where several cover it. Means nothing on the drop-in path, where Bevy picks by view depth.
    pub selection: PartitionSelection,
    /// Blends between maps and at the end of the range.
    pub seams: Seams,
    /// How the depth comparison is filtered. Means nothing on the drop-in path, where the camera's
    /// [`ShadowFilteringMethod`](bevy::light::ShadowFilteringMethod) decides.
    pub filter: ShadowFilter,
    /// How self-shadowing is avoided.
    pub bias: ShadowBias,
    /// How casters get into the maps. Means nothing on the drop-in path and for virtual maps.
    pub caster_passes: CasterPasses,
    /// What the maps store. Means nothing on the drop-in path, which stores the nearest surface.
    pub store: ShadowStore,
    /// Blur of the shadow result on the screen. Means nothing on the drop-in path, which has no shadow result.
    pub blur: ShadowBlur,
    /// View depth up to which shadows are computed, in metres. `None`: up to the camera's far plane.
    pub distance: Option<f32>,
    /// View depth from which shadows are computed, in metres. `None`: the camera's near plane, moved to the nearest
    /// point of the scene's bounds. A larger value sharpens; surfaces nearer than it have no guarantee.
    pub near: Option<f32>,
    /// Which planes come from the depths that the picture shows. Means nothing on the drop-in path.
    pub measured: MeasuredDepths,
    /// How shadows are kept from crawling. Means nothing on the drop-in path, where every frame is fitted anew.
    pub stable: Stability,
    /// Draws Bevy's own fallback map on the full path, in frames in which the camera sees a transparent surface: such
    /// surfaces read it. Costs one more map of [`DirectionalLightShadowMap`](bevy::light::DirectionalLightShadowMap)
    /// size.
    pub fallback_map: bool,
    /// Which transparent surfaces have shadow results of their own. Means nothing on the drop-in path.
    pub transparent_layers: TransparentLayers,
}

/// How casters get into the maps of an atlas: changes no texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum CasterPasses {
    /// One culling dispatch over casters × maps, then one render pass draws all maps from one set of instances (the
    /// geometry cloning of Stingl 2011, section 3.3.6, without a geometry shader). The default.
    #[default]
    Shared,
    /// A culling dispatch and a render pass per map, as renderers without cloning do: for comparison.
    PerMap,
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

/// Which map a point reads where several cover it (Stingl, section 3.3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum PartitionSelection {
    /// By view depth, in half-open intervals. Face partitions have none of their own: they take the finest map.
    Depth,
    /// The first map that contains the point, of z-partitions: the finest without a warp. Face partitions take the one with
    /// the most texels there.
    BestResolution,
    /// The map with the most texels around the point: along a warp the first map that contains it may be coarser there than
    /// the next one. Costs a look at every map. Four warped maps on two tuning shots of each level, wrong pixels in percent
    /// for those of [`BestResolution`](Self::BestResolution): forest 3.09 for 3.57, city 0.224 for 0.221 (240x135).
    #[default]
    Finest,
}

/// How the depth comparison is filtered (Stingl, section 3.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Reflect)]
pub enum ShadowFilter {
    /// One comparison: blocky at magnification, exact for measurements.
    Hard,
    /// Bilinear weights of four comparisons.
    #[default]
    Pcf2,
    /// Bilinear lookups on a disc of constant size in the world, whatever the partition and the warp, turned by another
    /// angle in every pixel ([`maths::filter`](crate::maths::filter)). Hides texels that are smaller than the disc.
    Poisson {
        /// Lookups, 8..=64; they cost as much each as [`ShadowFilter::Pcf2`].
        taps: u32,
        /// Radius in metres across the light, up to 2; useful 0.01..=0.2.
        radius: f32,
    },
    /// The same with the radius of the sun's penumbra, from a search for blockers (percentage-closer soft shadows).
    /// Where the search meets none, the four texels around the point decide.
    Pcss {
        /// Lookups of the filter, 8..=64; the search takes as many single comparisons.
        taps: u32,
        /// Radius of the search and of the widest penumbra, metres across the light, up to 2.
        radius: f32,
        /// Angular diameter of the sun in degrees, up to 10; from the earth 0.53.
        sun_diameter: f32,
    },
}

impl ShadowFilter {
    /// Lookups on a disc when nothing else is said.
    pub const TAPS: u32 = 16;
    /// Radius in metres of [`ShadowFilter::Poisson`] when nothing else is said.
    pub const POISSON_RADIUS: f32 = 0.05;
    /// Radius in metres of [`ShadowFilter::Pcss`] when nothing else is said: the penumbra of an edge 54 m away.
    pub const PCSS_RADIUS: f32 = 0.25;
    /// Angular diameter of the sun in degrees from the earth.
    pub const SUN_DIAMETER: f32 = 0.53;
    /// The largest radius in metres.
    pub const LARGEST_RADIUS: f32 = 2.0;
    /// The largest angular diameter in degrees.
    pub const LARGEST_SUN: f32 = 10.0;

    /// How far around a point, in metres across the light, the filter reads beyond its own texels.
    #[must_use]
    pub fn world_radius(self) -> f32 {
        match self {
            Self::Hard | Self::Pcf2 => 0.0,
            Self::Poisson { radius, .. } | Self::Pcss { radius, .. } => radius,
        }
    }
}

/// What the maps store (Scherzer 2005, section 4.2). All but the first move the stored depth into the casters, where no
/// lit surface is near it, and need closed meshes: light leaks where they touch or are thin.
///
/// Linear depth is not among them: the warp's w is the same all along a light ray, so comparing depths decides the same
/// with and without the division by it, and the offsets that differ, those by a constant distance, are taken in metres
/// (`ShadowBias::Constant`) and turned into depth at the point where they are used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum ShadowStore {
    /// The nearest surface.
    #[default]
    Nearest,
    /// The nearest face that looks away from the light. Casters with two-sided materials, such as leaves, store the nearest.
    BackFaces,
    /// The second surface from the light (Wang, Molnar 1994), by drawing the casters twice. Casters whose material
    /// discards pixels, such as leaves, store the nearest. Doubles the memory of the maps.
    SecondDepth,
    /// The middle between the first two (Woo 1992), likewise.
    Midpoint,
}

impl ShadowStore {
    /// Whether the casters are drawn twice, into a second atlas.
    #[must_use]
    pub fn is_layered(self) -> bool {
        matches!(self, Self::SecondDepth | Self::Midpoint)
    }
}

/// Blur of the shadow result on the screen, within each surface, less with distance (Scherzer 2005, section 4.3;
/// [`maths::filter::eye_blur`](crate::maths::filter::eye_blur)). Hides stripes on surfaces that the light grazes, and detail.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
pub struct ShadowBlur {
    /// Iterations of near pixels, 0..=16; 0: none. Each costs two screen-sized passes.
    pub iterations: u32,
    /// View depth in metres up to which pixels take part in all of them; infinite: everywhere.
    pub full_depth: f32,
}

impl ShadowBlur {
    /// No blur.
    pub const NONE: Self = Self {
        iterations: 0,
        full_depth: 10.0,
    };
    /// The largest number of iterations.
    pub const MAX_ITERATIONS: u32 = 16;
}

impl Default for ShadowBlur {
    fn default() -> Self {
        Self::NONE
    }
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
    /// The change of depth over one texel on the receiver's plane, along the map's axis where it is larger, times a
    /// factor, and a number of smallest steps: the polygon offset of graphics hardware (Scherzer 2005, section 4.2, takes
    /// 2 and 4). Not on the drop-in path.
    Slope {
        /// Depth spans of a texel.
        factor: f32,
        /// Smallest steps of single precision.
        units: f32,
    },
    /// A factor times the tangent between normal and light times the local side of a texel, in metres: the same in the
    /// world instead of the map (Kozlov 2004, after Scherzer). Not on the drop-in path.
    WorldSlope {
        /// Sides of a texel.
        factor: f32,
    },
    /// Every comparison uses the depth of the receiver's plane at the texel that it reads, and a constant distance. Not on
    /// the drop-in path.
    ReceiverPlane {
        /// Metres.
        metres: f32,
    },
}

impl Default for ShadowBias {
    fn default() -> Self {
        Self::Footprint { scale: 1.0 }
    }
}

impl ShadowBias {
    /// Whether the drop-in path has it: Bevy's lookup knows no receiver plane.
    #[must_use]
    pub fn is_for_drop_in(self) -> bool {
        matches!(self, Self::None | Self::Constant { .. } | Self::Footprint { .. })
    }
}

impl Default for SunShadows {
    fn default() -> Self {
        Self::HIGH
    }
}

impl SunShadows {
    /// The largest strength eta of a warp in any partition.
    #[must_use]
    pub fn largest_eta(&self) -> f64 {
        let own = match self.warp {
            Warp::Free { .. } => &self.partitions.etas[..],
            _ => &[],
        };
        own.iter()
            .fold(self.warp.eta(), |largest, eta| largest.max(f64::from(*eta)))
    }

    /// What of the picture's depths is measured: [`measured`](Self::measured) with the decision whether the near plane is.
    #[must_use]
    pub fn measures(&self) -> MeasuredDepths {
        let is_sliced = self.partitions.faces == Faces::Together && self.partitions.count > 1;
        let is_warped = self.warp != Warp::Uniform && self.fit.align && self.light_planes.is_none();
        let is_new = matches!(self.stable, Stability::Off | Stability::Sharp { .. });
        let helps = self.path == ShadowPath::Full && is_sliced && is_warped && is_new && self.near.is_none();
        MeasuredDepths {
            near: match self.measured.near {
                NearMeasurement::Slices if helps => NearMeasurement::On,
                NearMeasurement::Slices => NearMeasurement::Off,
                known => known,
            },
            ..self.measured
        }
    }

    /// The largest number of partitions on the full path.
    pub const MAX_PARTITIONS: u32 = 16;
    /// The largest number of slices with face partitions.
    pub const MAX_FACE_SLICES: u32 = 4;
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

    /// Four warped maps of 2048² on the drop-in path, which splits the view in its own way ([`Partitions::scheme_of`]).
    pub const DROP_IN: Self = Self::preset_of(ShadowPath::DropIn, 4, 2048);

    const fn preset(count: u32, map_size: u32) -> Self {
        Self::preset_of(ShadowPath::Full, count, map_size)
    }

    const fn preset_of(path: ShadowPath, count: u32, map_size: u32) -> Self {
        Self {
            path,
            maps: ShadowMaps::Partitions,
            partitions: Partitions::slices_of(path, count),
            warp: Warp::Lispsm,
            light_planes: None,
            fit: FitSettings::BEST,
            map_size,
            selection: PartitionSelection::Finest,
            seams: Seams::NONE,
            filter: ShadowFilter::Pcf2,
            bias: ShadowBias::Footprint { scale: 1.0 },
            caster_passes: CasterPasses::Shared,
            store: ShadowStore::Nearest,
            blur: ShadowBlur::NONE,
            distance: None,
            near: None,
            measured: MeasuredDepths::BEST,
            stable: Stability::Off,
            fallback_map: true,
            transparent_layers: TransparentLayers::Off,
        }
    }
}
