//! What the full path asks of cameras: a depth and a normal prepass, and no multisampling.
//!
//! The normals let the bias know the receiver's plane where depths of neighbouring pixels cannot tell it: façades, grilles
//! and leaves whose parts are as wide as a pixel.

use bevy::{
    core_pipeline::prepass::{DepthPrepass, NormalPrepass},
    log::warn_once,
    prelude::*,
};

use crate::shadow::settings::{ShadowPath, SunShadows};

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
    cameras: Query<(Entity, &Msaa, Has<DepthPrepass>, Has<NormalPrepass>), With<Camera3d>>,
) {
    if !suns.iter().any(|settings| settings.path == ShadowPath::Full) {
        return;
    }
    for (camera, msaa, has_depth, has_normals) in &cameras {
        if !takes_full_path(*msaa) {
            warn_once!("{NEEDS_NO_MSAA}");
        } else if !(has_depth && has_normals) {
            commands.entity(camera).insert((DepthPrepass, NormalPrepass));
        }
    }
}
