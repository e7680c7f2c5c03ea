//! Main-world ECS of sun shadows: settings, scene bounds, light views, the drop-in path, gizmos.
//!
//! Every frame, for every sun with [`SunShadows`](settings::SunShadows) and every active 3D camera:
//!
//! ```text
//! meshes ─► SceneBounds ─┐
//! camera ─► view volume ─┼─► H, adjusted depths ─► slices ─► B ─► warp, focus ─► SunViews ─► Cascades (both paths)
//! sun ───► direction ────┘                                                          └─► gizmos, render room, games
//! ```

use bevy::{
    camera::visibility::VisibilitySystems, light::SimulationLightSystems, prelude::*, transform::TransformSystems,
};

pub mod checked;
pub mod compute;
pub mod correction;
pub mod drop_in;
pub mod fitted;
pub mod full;
pub mod gizmos;
pub mod layout;
pub mod light_plane;
pub mod measured;
mod parts;
pub mod scene_bounds;
pub mod settings;
pub mod stable;
mod stock;
mod systems;
pub mod technique;
pub mod timing;
pub mod view_volume;
pub mod views;
pub mod virtual_maps;

/// Computes the light views of all suns with [`SunShadows`](settings::SunShadows) and hands them to Bevy's cascades.
///
/// The drop-in path's bias of casters and the full path need the render room too. Needs Bevy's `LightPlugin`,
/// `CameraPlugin` and `TransformPlugin`, which `DefaultPlugins` contain.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShadowPlugin;

/// The sets of [`ShadowPlugin`], in [`PostUpdate`], in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ShadowSystems {
    /// Brings [`SceneBounds`](scene_bounds::SceneBounds) up to date; after transforms, visibility and mesh bounds are.
    UpdateSceneBounds,
    /// Computes [`SunViews`](views::SunViews) and overwrites Bevy's cascades; after Bevy has built them, before it
    /// derives light frusta from them. Read the light views after this set.
    UpdateLightViews,
}

impl Plugin for ShadowPlugin {
    fn build(&self, app: &mut App) {
        let times = timing::SystemTimes::of(app);
        app.register_required_components::<settings::SunShadows, views::SunViews>()
            .register_required_components::<settings::SunShadows, stable::HeldMaps>()
            .register_required_components::<settings::SunShadows, light_plane::LightPlaneStates>()
            .add_systems(PreUpdate, light_plane::ask_cameras)
            .init_resource::<scene_bounds::SceneBounds>()
            .init_resource::<scene_bounds::MeshBounds>()
            .init_resource::<stock::StockMapSize>()
            .add_observer(stock::restore_stock_settings)
            .configure_sets(
                PostUpdate,
                (
                    ShadowSystems::UpdateSceneBounds
                        .after(TransformSystems::Propagate)
                        .after(VisibilitySystems::VisibilityPropagate)
                        .after(VisibilitySystems::CalculateBounds),
                    ShadowSystems::UpdateLightViews
                        .after(SimulationLightSystems::UpdateDirectionalLightCascades)
                        .before(SimulationLightSystems::UpdateLightFrusta),
                )
                    .chain(),
            )
            .add_systems(
                PostUpdate,
                (
                    times
                        .clock("update_scene_bounds", scene_bounds::update_scene_bounds)
                        .in_set(ShadowSystems::UpdateSceneBounds),
                    (
                        stock::remember_stock_settings,
                        stock::set_shadow_map_size,
                        times.clock("update_sun_views", systems::update_sun_views),
                        times.clock("write_cascades", systems::write_cascades),
                    )
                        .chain()
                        .in_set(ShadowSystems::UpdateLightViews),
                ),
            )
            .add_plugins(gizmos::plugin);
    }
}
