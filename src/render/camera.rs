//! What the full path asks of cameras: a depth and a normal prepass, no multisampling, and a depth texture that can be read
//! where transparent things are drawn layer by layer.
//!
//! The normals let the bias know the receiver's plane where depths of neighbouring pixels cannot tell it: façades, grilles
//! and leaves whose parts are as wide as a pixel.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, NormalPrepass},
    log::warn_once,
    prelude::*,
    render::render_resource::TextureUsages,
};

use crate::shadow::settings::{ShadowPath, SunShadows, TransparentLayers};

/// Why a camera cannot take the full path; it keeps the fallback map.
pub const NEEDS_NO_MSAA: &str = "a camera with multisampling keeps the coarse fallback shadows: the full path needs \
    `Msaa::Off` (SMAA, FXAA and TAA work), or choose `ShadowPath::DropIn`";

/// Whether a camera can take the full path.
pub fn takes_full_path(msaa: Msaa) -> bool {
    msaa == Msaa::Off
}

/// Gives the prepasses to cameras that need it, and says once what keeps others from the full path.
pub(super) fn prepare_cameras(
    mut commands: Commands,
    suns: Query<&SunShadows>,
    mut cameras: Query<(Entity, &mut Camera3d, &Msaa, Has<DepthPrepass>, Has<NormalPrepass>)>,
) {
    let mut full_path_suns = suns
        .iter()
        .filter(|settings| settings.path == ShadowPath::Full)
        .peekable();
    if full_path_suns.peek().is_none() {
        return;
    }
    let draws_layers =
        full_path_suns.any(|settings| matches!(settings.transparent_layers, TransparentLayers::All { .. }));
    for (camera, mut camera_3d, msaa, has_depth, has_normals) in &mut cameras {
        if !takes_full_path(*msaa) {
            warn_once!("{NEEDS_NO_MSAA}");
            continue;
        }
        if !(has_depth && has_normals) {
            commands.entity(camera).insert((DepthPrepass, NormalPrepass));
        }
        let usages = TextureUsages::from(camera_3d.depth_texture_usages);
        if draws_layers && !usages.contains(TextureUsages::TEXTURE_BINDING) {
            camera_3d.depth_texture_usages = (usages | TextureUsages::TEXTURE_BINDING).into();
        }
    }
}
