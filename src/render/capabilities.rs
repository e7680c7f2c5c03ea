//! What the device must be able to do, asked once.

use bevy::{
    log::warn_once,
    prelude::*,
    render::{RenderApp, render_resource::WgpuFeatures, renderer::RenderDevice},
};

use crate::{maths::warp::Warp, shadow::settings::SunShadows};

/// Makes all maps uniform where casters cannot be clamped to a map's depth range by the hardware.
///
/// Bevy emulates the clamp in the vertex shader with `min(z, 1)`, which is only right where w = 1, that is without a
/// warp.
pub(super) fn limit_to_device(app: &mut App) {
    let Some(device) = app
        .get_sub_app(RenderApp)
        .and_then(|render_app| render_app.world().get_resource::<RenderDevice>())
    else {
        return;
    };
    if !can_warp(device.features()) {
        app.add_systems(PreUpdate, use_uniform_maps);
    }
}

/// Whether warped maps come out right.
pub fn can_warp(features: WgpuFeatures) -> bool {
    features.contains(WgpuFeatures::DEPTH_CLIP_CONTROL)
}

fn use_uniform_maps(mut suns: Query<&mut SunShadows>) {
    for mut settings in &mut suns {
        if settings.warp != Warp::Uniform {
            warn_once!("this device cannot clamp depth (DEPTH_CLIP_CONTROL): sun shadows are drawn without a warp");
            settings.warp = Warp::Uniform;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warps_need_depth_clip_control() {
        assert!(can_warp(WgpuFeatures::DEPTH_CLIP_CONTROL), "with the feature");
        assert!(!can_warp(WgpuFeatures::empty()), "without it");
        let mut app = App::new();
        app.add_systems(Update, use_uniform_maps);
        let sun = app.world_mut().spawn(SunShadows::HIGH).id();
        app.update();
        let settings = app.world().get::<SunShadows>(sun).expect("the sun is there");
        assert_eq!(settings.warp, Warp::Uniform, "the warp is taken away");
    }
}
