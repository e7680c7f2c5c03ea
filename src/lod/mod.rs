//! Main-world ECS of levels of detail: chains, which level each shows, and how one takes another's place.
//!
//! ```text
//! cameras ─► LodEyes ─┐
//! LodChain, borders ──┼─► wanted level ─► LodState (at rest, or crossing) ─► parts: Visibility, LodCoat while they fade
//! LodSettings ────────┘
//! ```
//!
//! An object is an entity with a [`LodChain`](chain::LodChain); each level has entities of its own that are drawn, its
//! parts. All views see the same level of an object: the finest that one of them asks for. Parts with a
//! [`LodCoat`](chain::LodCoat) are drawn by the render room ([`crate::lod`] itself draws nothing); without it they switch
//! at once.
//!
//! Cost: chains at rest are compared with a number per frame, until an eye has moved as far as the nearest border is away.
//! Settled chains have no components but their own; a part in a crossing costs one extra drawn instance.

use bevy::{asset::AssetEventSystems, prelude::*};

pub mod casters;
pub mod chain;
pub mod eyes;
pub mod gizmos;
mod select;
pub mod settings;

/// Levels of detail. Needs Bevy's `TransformPlugin`, `CameraPlugin` and `TimePlugin`, which `DefaultPlugins` contain.
#[derive(Clone, Copy, Debug, Default)]
pub struct LodPlugin;

/// The sets of [`LodPlugin`] in [`PostUpdate`], before Bevy looks at changed meshes, materials and visibility.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LodSystems {
    /// Finds the eyes.
    Look,
    /// Decides what every chain shows.
    Select,
    /// Gives fading parts what they are drawn with.
    Dress,
}

/// What the chains did in the last frame.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LodCounts {
    /// Chains there are, without those that only cast shadows.
    pub chains: u32,
    /// Chains whose distance was compared with their borders.
    pub compared: u32,
    /// Chains that show two levels.
    pub crossings: u32,
    /// Parts that fade: instances drawn beside those of a level at rest.
    pub fading_parts: u32,
}

impl Plugin for LodPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<settings::LodSettings>()
            .register_type::<settings::LodSettings>()
            .register_type::<chain::LodMorph>()
            .init_resource::<eyes::LodEyes>()
            .init_resource::<LodCounts>()
            .configure_sets(
                PostUpdate,
                (LodSystems::Look, LodSystems::Select, LodSystems::Dress)
                    .chain()
                    .before(AssetEventSystems),
            )
            .add_systems(
                PostUpdate,
                (
                    eyes::update_eyes.in_set(LodSystems::Look),
                    select::select_levels.in_set(LodSystems::Select),
                ),
            )
            .add_plugins((casters::plugin, gizmos::plugin));
    }
}
