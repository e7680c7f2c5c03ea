//! The material of a fading level: the base material, blended, without depth writes.

use bevy::{
    mesh::MeshVertexBufferLayoutRef,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline},
    prelude::*,
    render::render_resource::{AsBindGroup, CompareFunction, RenderPipelineDescriptor, SpecializedMeshPipelineError},
    shader::ShaderRef,
};

use super::surfaces::bind_group_layout;

/// A [`StandardMaterial`] that fades.
pub type FadingMaterial = ExtendedMaterial<StandardMaterial, Fading>;

/// How a level fades; alpha comes per instance ([`super::tag`]).
#[derive(Asset, AsBindGroup, TypePath, Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[bind_group_data(FadingKey)]
pub struct Fading {
    /// Whether it is drawn over the opaque level where depths are equal.
    pub wins_ties: bool,
    /// Whether its shadow is always dithered ([`LodCoat::dithers_shadow`](crate::lod::chain::LodCoat)).
    pub dithers_shadow: bool,
}

impl Fading {
    /// All of them.
    pub(super) const ALL: [Self; 4] = [
        Self::new(false, false),
        Self::new(false, true),
        Self::new(true, false),
        Self::new(true, true),
    ];

    const fn new(wins_ties: bool, dithers_shadow: bool) -> Self {
        Self {
            wins_ties,
            dithers_shadow,
        }
    }
}

/// What pipelines depend on.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct FadingKey {
    wins_ties: bool,
    dithers_shadow: bool,
}

impl From<&Fading> for FadingKey {
    fn from(fading: &Fading) -> Self {
        Self {
            wins_ties: fading.wins_ties,
            dithers_shadow: fading.dithers_shadow,
        }
    }
}

/// Depth bias of a level that wins ties, and with the other sign of one that loses them, in smallest steps of depth:
/// surfaces that both levels share, but in other triangles, differ by a few steps of rounding. 16 steps are two millionths
/// of the distance.
const TIE_STEPS: i32 = 16;

/// Shader definition by which pipelines are known whose casters take a share of the light.
pub(in crate::render) const CASTS_SHARE: &str = "UMBRAGE_CASTS_SHARE";

impl MaterialExtension for Fading {
    fn fragment_shader() -> ShaderRef {
        "embedded://umbrage/unpop/fade.wgsl".into()
    }

    fn prepass_fragment_shader() -> ShaderRef {
        "embedded://umbrage/unpop/cast.wgsl".into()
    }

    fn alpha_mode() -> Option<AlphaMode> {
        Some(AlphaMode::Blend)
    }

    // The depth prepass is the opaque level's.
    fn enable_prepass() -> bool {
        false
    }

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        // Shadow maps take the material's own depth. Base materials put words before the name.
        let label = descriptor.label.as_deref();
        let is_shadow = label.is_some_and(|label| label.ends_with("prepass_pipeline"));
        let (Some(depth), Some(fragment)) = (&mut descriptor.depth_stencil, &mut descriptor.fragment) else {
            return Ok(());
        };
        if is_shadow {
            if !key.bind_group_data.dithers_shadow {
                fragment.shader_defs.push(CASTS_SHARE.into());
            }
            return Ok(());
        }
        depth.depth_write_enabled = Some(false);
        let wins_ties = key.bind_group_data.wins_ties;
        depth.depth_compare = Some(if wins_ties {
            CompareFunction::GreaterEqual
        } else {
            CompareFunction::Greater
        });
        depth.bias.constant += if wins_ties { TIE_STEPS } else { -TIE_STEPS };
        // Cut-outs are cut before they are blended.
        fragment.shader_defs.push("MAY_DISCARD".into());
        fragment.shader_defs.push("UMBRAGE_FADING".into());
        descriptor.layout.push(bind_group_layout());
        Ok(())
    }
}
