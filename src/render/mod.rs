//! Render world: the passes that draw light views and apply them.
//!
//! One frame of a camera whose sun takes the full path ([`ShadowPath::Full`](crate::shadow::settings::ShadowPath)):
//!
//! ```text
//! extract     SunViews of the main world ──► ExtractedSun on the camera                      extract
//! prepare     atlas and result textures, caster phase, one render view per light view        atlas, caster::prepare
//! queue       casters into one binned phase, shared by all light views                       caster::queue
//! Core3d      depth prepass, Bevy's own shadow passes
//!             └─► reduce: range of view depths, read back for later frames, if asked for depth_range
//!             └─► see:   what the camera sees, for light planes, if asked for                light_plane
//!             └─► plan:  bins of the phase, buffers                                          caster::plan
//!             └─► cull and draw all light views into the atlas                               caster::pass
//!             └─► apply: shadow result of every pixel                                        apply
//!                 or, for virtual maps, in place of both: tile by tile                       virtual_map
//!             └─► history: the same, blended with the frame before, if asked for         history
//!             └─► blur:  the same, to and fro, if asked for                                  blur
//!             └─► bridge: result ──► the sun's extra shadow layer                            bridge
//!             Bevy's main pass, forward or deferred, any material, reads the layer
//!             └─► transparent layers: what is transparent, layer by layer, if asked for      transparent
//! ```
//!
//! Suns on the drop-in path only get their casters biased ([`drop_in`]).
//!
//! Levels of detail that take each other's place are drawn by [`unpop`].
//!
//! All contact with Bevy's semi-internal types sits in [`bridge`], [`caster`], [`cost`], [`drop_in`], [`mask`], [`spans`],
//! [`transparent`] and [`unpop`].

pub mod apply;
pub mod atlas;
pub mod blur;
pub mod bridge;
pub mod camera;
pub mod capabilities;
pub mod capture;
pub mod caster;
pub mod cost;
pub mod depth_range;
pub mod drop_in;
pub mod extract;
pub mod gpu_types;
pub mod heat_map;
pub mod history;
pub mod light_maps;
pub mod light_plane;
pub mod mask;
mod overlay_pass;
mod read_back;
mod receivers;
#[cfg(feature = "demo")]
pub mod reference;
mod shaders;
pub mod spans;
pub mod transparent;
pub mod unpop;
pub mod virtual_map;

use bevy::{
    app::PluginGroupBuilder,
    core_pipeline::schedule::{Core3d, Core3dSystems},
    pbr::{LATE_SHADOW_PASS, per_view_shadow_pass},
    prelude::*,
    render::{Render, RenderApp, RenderSystems},
};

use crate::shadow::timing::SystemTimes;

/// Sharp sun shadows, and levels of detail that do not pop: add this group after Bevy's default plugins.
///
/// | member | what it does |
/// |---|---|
/// | [`ShadowPlugin`](crate::shadow::ShadowPlugin) | scene bounds, light views, the drop-in path, gizmos |
/// | [`RenderPlugin`] | the full path: caster phase, atlas, apply pass, bridge into Bevy's lighting; the drop-in path's bias of casters; heat maps |
/// | [`LodPlugin`](crate::lod::LodPlugin) | levels of detail: which one each chain shows |
/// | [`UnpopPlugin`](unpop::UnpopPlugin) | draws levels that fade |
pub struct UmbragePlugins;

impl PluginGroup for UmbragePlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(crate::shadow::ShadowPlugin)
            .add(RenderPlugin)
            .add(crate::lod::LodPlugin)
            .add(unpop::UnpopPlugin)
    }
}

/// The passes of the full path, in the order of [`Core3d`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub enum SunShadowPasses {
    /// Reads the bins of the caster phase and sizes buffers.
    Plan,
    /// Culls and draws all light views into the atlas.
    DrawCasters,
    /// Writes the shadow result of every pixel.
    Apply,
    /// Blends the shadow result with that of the frame before, if the sun's settings say so.
    History,
    /// Blurs the shadow result, if the sun's settings say so.
    Blur,
    /// Hands the result to Bevy's lighting.
    Bridge,
}

/// The full path. Needs [`ShadowPlugin`](crate::shadow::ShadowPlugin) and Bevy's PBR plugins.
pub struct RenderPlugin;

impl Plugin for RenderPlugin {
    fn build(&self, app: &mut App) {
        shaders::embed(app);
        app.add_systems(PreUpdate, camera::prepare_cameras).add_plugins((
            extract::ExtractPlugin,
            bridge::BridgePlugin,
            caster::CasterPlugin,
            depth_range::DepthRangePlugin,
            apply::ApplyPlugin,
            virtual_map::VirtualMapPlugin,
            transparent::TransparentPlugin,
            history::HistoryPlugin,
            blur::BlurPlugin,
            drop_in::DropInPlugin,
            heat_map::HeatMapPlugin,
            light_plane::LightPlanePlugin,
        ));
        let times = SystemTimes::of(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        use SunShadowPasses::{Apply, Blur, Bridge, DrawCasters, History, Plan};
        render_app
            .add_systems(
                Render,
                times
                    .clock("prepare_atlas", atlas::prepare_atlas)
                    .in_set(RenderSystems::PrepareViews)
                    .before(caster::prepare::prepare_caster_views),
            )
            .configure_sets(
                Core3d,
                (Plan, DrawCasters, Apply, History, Blur, Bridge)
                    .chain()
                    .after(Core3dSystems::Prepass)
                    .after(per_view_shadow_pass::<LATE_SHADOW_PASS>)
                    .before(Core3dSystems::MainPass),
            );
    }

    fn finish(&self, app: &mut App) {
        capabilities::limit_to_device(app);
    }
}
