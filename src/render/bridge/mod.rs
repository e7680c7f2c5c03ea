//! The bridge into Bevy's lighting: materials stay unmodified.
//!
//! Bevy's lighting calls `fetch_directional_shadow` of the shader module `bevy_pbr::shadows`. The bridge renames that
//! function and appends one of the same name that reads the shadow result from an extra layer of the sun's shadow
//! map array (the main world gives the sun a second cascade that no stock light can have, see
//! [`shadow::full`](crate::shadow::full)). Fragments that are not in the depth prepass (transparent ones) are looked for in
//! a third layer, if there is one ([`transparent`](super::transparent), which writes it anew for every layer that it draws);
//! those in neither, multisampled cameras and all
//! other lights take Bevy's own lookup.

pub(super) mod layer;
pub mod patch;

use bevy::{
    core_pipeline::schedule::Core3d,
    prelude::*,
    render::{RenderApp, RenderStartup},
};

use super::SunShadowPasses;
use crate::shadow::timing::SystemTimes;

/// The bridge.
pub struct BridgePlugin;

impl Plugin for BridgePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PreUpdate, patch::patch_modules.after(bevy::asset::AssetTrackingSystems));
        let times = SystemTimes::of(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .add_systems(RenderStartup, layer::init_layer_pipelines)
            .add_systems(
                Core3d,
                times
                    .clock("write_layers", layer::write_layers)
                    .in_set(SunShadowPasses::Bridge),
            );
    }
}
