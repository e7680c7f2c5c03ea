//! **Umbrage**: sharp, stable sun shadows over large worlds for Bevy.
//!
//! The crate is a house of rooms; imports point down only (`tests/rooms.rs` holds it):
//!
//! ```text
//! cli ──► demo ──► ui, plot ──► level ──► render ──► shadow, lod ──► maths
//!  └────────────────────────────────────────────► forge (on its own)
//! ```
//!
//! | room | what it is | needs feature |
//! |---|---|---|
//! | [`maths`] | intersection bodies, splits, warps, fits, footprints: values in, values out | none |
//! | [`shadow`] | main-world ECS: settings, scene bounds, light views, the drop-in path, gizmos | `render` |
//! | [`lod`] | main-world ECS: chains of levels of detail, which level they show, transitions | `render` |
//! | [`render`] | render world: caster phase, shadow atlas, shadow result texture, bridge into Bevy, fading levels | `render` |
//! | [`forge`] | assets from code: trees, undergrowth, rocks as glTF files; no GPU | `forge` |
//! | [`level`] | levels: `.level.ron` assets, generators of forest, city and rooms | `demo` |
//! | [`ui`] | head-up display, help, menus | `demo` |
//! | [`plot`] | figures: curves, bars and maps of directions as pixels; the papers' figures | `plot` |
//! | [`demo`] | the playable demo: screens, walker, sun controls | `demo` |
//! | [`cli`] | the command line: `play`, `shoot`, `judge`, `bench`, `plot`, `forge`, `list` | `demo` |

#[cfg(feature = "forge")]
pub mod forge;
pub mod maths;
#[cfg(feature = "plot")]
pub mod plot;

#[cfg(feature = "render")]
pub mod lod;
#[cfg(feature = "render")]
pub mod render;
#[cfg(feature = "render")]
pub mod shadow;

#[cfg(feature = "demo")]
pub mod cli;
#[cfg(feature = "demo")]
pub mod demo;
#[cfg(feature = "demo")]
pub mod level;
#[cfg(feature = "demo")]
pub mod ui;

/// The types that an app using Umbrage names.
#[cfg(feature = "render")]
pub mod prelude {
    #[doc(hidden)]
    pub use crate::{
        lod::{
            chain::LodChain,
            eyes::LodView,
            settings::{LodDriver, LodKind, LodSettings, LodShadows, LodTransition},
        },
        maths::{split::SplitScheme, warp::Warp},
        render::UmbragePlugins,
        shadow::{
            fitted::FittedMaps,
            measured::{MeasureUse, MeasuredDepths, NearMeasurement},
            settings::{
                PartitionSelection, Partitions, ShadowBias, ShadowBlur, ShadowFilter, ShadowPath, ShadowStore,
                SunShadows, TransparentLayers, WithoutSunShadows,
            },
            stable::Stability,
            technique::Technique,
            virtual_maps::{QueriedMaps, ShadowMaps, TiledMaps},
        },
    };
}

/// The examples of the README, compiled.
#[cfg(all(doctest, feature = "demo"))]
#[doc = include_str!("../README.md")]
struct Readme;
