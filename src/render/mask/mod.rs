//! [`ShadowMask`]: what the sun's shadow lookup returns at every pixel, as pictures.
//!
//! A full-screen pass after the main pass takes position and normal from the prepass and calls the function that Bevy's
//! own lighting calls. With stock cascades and on the drop-in path that is Bevy's unpatched lookup; on the full path the
//! same function reads the shadow result. One pass therefore measures every technique.

mod pass;

use std::path::{Path, PathBuf};

use bevy::{
    asset::io::embedded::EmbeddedAssetRegistry,
    core_pipeline::{
        core_3d::main_opaque_pass_3d,
        prepass::{DepthPrepass, NormalPrepass},
        schedule::{Core3d, Core3dSystems},
    },
    pbr::MeshPipelineSystems,
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        render_resource::{SpecializedRenderPipelines, TextureFormat},
    },
};

/// On a camera: draws the sun's shadow mask, the view depth and the normal of every pixel into three images.
///
/// For pictures, measurements and tests; costs one full-screen pass.
///
/// # Limits
/// The camera needs `Msaa::Off`. Only what is in the prepass is seen: transparent surfaces are not. Normals have the ten
/// bits of Bevy's prepass and include normal maps. The images must have the size of the camera's target and the formats
/// named below; otherwise the pass is left out with a warning.
#[derive(Component, Clone, Debug, ExtractComponent)]
#[require(DepthPrepass, NormalPrepass)]
pub struct ShadowMask {
    /// The entity of the [`DirectionalLight`].
    pub light: Entity,
    /// [`Self::MASK_FORMAT`]: 1 lit, 0 in shadow or where normal and plane face away from the light, fractions where
    /// filtered; sky 1.
    pub mask: Handle<Image>,
    /// [`Self::DEPTH_FORMAT`]: metres along the view direction; sky 0.
    pub depth: Handle<Image>,
    /// [`Self::NORMAL_FORMAT`]: normals in world space, 0..=1 for −1..=1; sky 0.
    pub normal: Handle<Image>,
}

impl ShadowMask {
    /// Format of [`mask`](Self::mask).
    pub const MASK_FORMAT: TextureFormat = TextureFormat::R8Unorm;
    /// Format of [`depth`](Self::depth).
    pub const DEPTH_FORMAT: TextureFormat = TextureFormat::R32Float;
    /// Format of [`normal`](Self::normal).
    pub const NORMAL_FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;
}

/// Makes [`ShadowMask`] work. Needs Bevy's PBR plugin.
pub struct MaskPlugin;

impl Plugin for MaskPlugin {
    fn build(&self, app: &mut App) {
        let Some(registry) = app.world().get_resource::<EmbeddedAssetRegistry>() else {
            return;
        };
        registry.insert_asset(
            PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/mask/mask.wgsl")),
            Path::new(pass::SHADER),
            include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/mask/mask.wgsl")),
        );
        app.add_plugins(ExtractComponentPlugin::<ShadowMask>::default());
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_gpu_resource::<SpecializedRenderPipelines<pass::MaskPipeline>>()
            .add_systems(RenderStartup, pass::init_pipeline.after(MeshPipelineSystems))
            .add_systems(Render, pass::prepare_views.in_set(RenderSystems::Prepare))
            .add_systems(
                Core3d,
                pass::draw_mask
                    .in_set(Core3dSystems::MainPass)
                    .after(main_opaque_pass_3d),
            );
    }
}
