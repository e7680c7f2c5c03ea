//! Remembering and restoring what Bevy's shadows were set to before [`SunShadows`] took over.

use bevy::{
    light::{CascadeShadowConfig, DirectionalLightShadowMap},
    prelude::*,
};

use super::{
    checked::checked,
    drop_in, full,
    light_plane::LightPlaneStates,
    settings::{ShadowPath, SunShadows},
    stable::HeldMaps,
    views::SunViews,
};

/// A light's own settings while [`SunShadows`] overwrites them.
#[derive(Component, Clone, Debug)]
pub(super) struct StockSettings {
    config: CascadeShadowConfig,
    depth_bias: f32,
    normal_bias: f32,
}

impl StockSettings {
    fn restore(&self, light: &mut DirectionalLight, config: &mut CascadeShadowConfig) {
        *config = self.config.clone();
        light.shadow_depth_bias = self.depth_bias;
        light.shadow_normal_bias = self.normal_bias;
    }
}

/// The app's own [`DirectionalLightShadowMap::size`] while a light with [`SunShadows`] overwrites it.
#[derive(Resource, Default)]
pub(super) struct StockMapSize(Option<usize>);

/// Remembers the settings of lights that have just got [`SunShadows`].
pub(super) fn remember_stock_settings(
    mut commands: Commands,
    lights: Query<(Entity, &DirectionalLight, &CascadeShadowConfig), (With<SunShadows>, Without<StockSettings>)>,
) {
    for (entity, light, config) in &lights {
        commands.entity(entity).insert(StockSettings {
            config: config.clone(),
            depth_bias: light.shadow_depth_bias,
            normal_bias: light.shadow_normal_bias,
        });
    }
}

/// Gives a light that loses [`SunShadows`] its own settings back. Bevy rebuilds its cascades in the same frame.
pub(super) fn restore_stock_settings(
    removed: On<Remove, SunShadows>,
    mut commands: Commands,
    mut lights: Query<(&mut DirectionalLight, &mut CascadeShadowConfig, &StockSettings)>,
) {
    if let Ok((mut light, mut config, stock)) = lights.get_mut(removed.entity) {
        stock.restore(&mut light, &mut config);
    }
    commands
        .entity(removed.entity)
        .try_remove::<(StockSettings, SunViews, HeldMaps, LightPlaneStates)>();
}

/// Sets the biases that a light's path needs: the drop-in path replaces Bevy's, the full path leaves them alone.
pub(super) fn set_biases(settings: &SunShadows, stock: &StockSettings, light: &mut Mut<DirectionalLight>) {
    let (depth_bias, normal_bias) = match settings.path {
        ShadowPath::Full => (stock.depth_bias, stock.normal_bias),
        ShadowPath::DropIn => drop_in::biases(settings.bias),
    };
    if (light.shadow_depth_bias, light.shadow_normal_bias) != (depth_bias, normal_bias) {
        light.shadow_depth_bias = depth_bias;
        light.shadow_normal_bias = normal_bias;
    }
}

/// Sets the size of Bevy's shadow maps: the drop-in path's `map_size`, or large enough for the full path's mask layer to
/// hold the largest picture; the app's own size again when the last [`SunShadows`] is gone.
pub(super) fn set_shadow_map_size(
    lights: Query<(&DirectionalLight, &SunShadows)>,
    cameras: Query<&Camera, With<Camera3d>>,
    mut stock: ResMut<StockMapSize>,
    mut shadow_map: ResMut<DirectionalLightShadowMap>,
) {
    let own = stock.0.unwrap_or(shadow_map.size);
    let picture = cameras
        .iter()
        .filter(|camera| camera.is_active)
        .filter_map(Camera::physical_viewport_size)
        .fold(UVec2::ONE, UVec2::max);
    let needed = lights
        .iter()
        .filter(|(light, _)| light.shadow_maps_enabled)
        .map(|(_, settings)| match settings.path {
            ShadowPath::Full => own.max(full::mask_size(picture)),
            ShadowPath::DropIn => checked(settings).0.map_size as usize,
        })
        .max();
    stock.0 = needed.map(|_| own);
    let size = needed.unwrap_or(own);
    if shadow_map.size != size {
        shadow_map.size = size;
    }
}
