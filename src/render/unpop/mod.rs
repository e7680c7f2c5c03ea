//! Unpopping: draws levels of detail that take each other's place (Giegl 2007, section 7.2;
//! [`maths::lod::blend`](crate::maths::lod::blend)).
//!
//! ```text
//! main world  LodCoat ──► fading material, shared per base material; alpha, shadow and level in the mesh tag     dress
//! queue       Bevy queues fading parts as transparent things; they get a draw function with one more group        draw
//! Core3d      depth prepass: opaque levels
//!             └─► nearest: depth, normal and level of the nearest fading surface of every pixel,
//!                 in layers of objects that may stand before each other                               layers, nearest
//!             └─► casters: fading levels into maps of their own, depth and share; into Bevy's
//!                 through as many texels as they are opaque                     caster::layers, shaders/unpop/cast
//!             └─► apply: shadow results of opaque surfaces, and of the nearest fading ones                      apply
//!             opaque levels, sky
//!             └─► transparent things from far to near, fading levels among them: depth test, no depth writes, alpha
//!                 per instance, the nearest layer of each level only                                  shaders/unpop/fade
//! ```
//!
//! A fading part costs one extra drawn instance in each of these passes; parts of one mesh and material that are neighbours
//! in depth share a draw call. Parts at rest are untouched: their own material, in their own batches.

pub mod draw;
mod dress;
pub mod layers;
pub mod material;
pub mod nearest;
pub mod surfaces;
pub mod tag;

use bevy::{
    asset::AssetEventSystems,
    core_pipeline::{
        core_3d::Transparent3d,
        schedule::{Core3d, Core3dSystems},
    },
    log::warn,
    prelude::*,
    render::{
        Extract, ExtractSchedule, GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        render_phase::AddRenderCommand, renderer::RenderDevice,
    },
};

use super::{SunShadowPasses, caster::layers::FadingCasters};
use crate::lod::{
    LodSystems,
    chain::{LodChain, LodCoat},
    settings::{LodKind, LodSettings, LodShadows, LodTransition},
};

/// Draws fading levels of detail. Needs [`LodPlugin`](crate::lod::LodPlugin), [`RenderPlugin`](super::RenderPlugin) and
/// Bevy's PBR plugins.
pub struct UnpopPlugin;

/// Groups that fading pipelines bind: Bevy's four and one more.
const GROUPS: u32 = 5;

impl Plugin for UnpopPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<dress::FadingMaterials>()
            .init_resource::<layers::FadingLayers>();
        if app.get_sub_app(RenderApp).is_none() {
            return;
        }
        app.add_plugins(MaterialPlugin::<material::FadingMaterial>::default());
        if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
            render_app
                .init_gpu_resource::<nearest::NearestPipelines>()
                .init_resource::<layers::ExtractedLayers>()
                .add_render_command::<Transparent3d, draw::DrawFading>()
                .add_systems(ExtractSchedule, (layers::extract_layers, extract_fading_casters))
                .add_systems(
                    RenderStartup,
                    (surfaces::init_no_surfaces, layers::init_layer_bind_groups),
                )
                .add_systems(
                    Render,
                    (
                        draw::draw_by_own_function,
                        surfaces::prepare_surfaces,
                        nearest::build_pipelines,
                    )
                        .chain()
                        .in_set(RenderSystems::PhaseSort)
                        .before(super::caster::prepare::skip_idle_fallback),
                )
                .add_systems(
                    Core3d,
                    nearest::draw_nearest
                        .after(Core3dSystems::Prepass)
                        .before(SunShadowPasses::Plan)
                        .before(Core3dSystems::MainPass),
                );
        }
    }

    fn finish(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app(RenderApp) else {
            return;
        };
        let device = render_app.world().get_resource::<RenderDevice>();
        let groups = device.map_or(0, |device| device.limits().max_bind_groups);
        if groups < GROUPS {
            warn!("levels of detail cannot fade: the device binds {groups} groups, but {GROUPS} are needed");
            return;
        }
        app.add_systems(
            PostUpdate,
            (
                dress::follow_base_materials,
                dress::undress_parts,
                layers::choose_layers,
                dress::dress_parts,
            )
                .chain()
                .in_set(LodSystems::Dress)
                .before(AssetEventSystems),
        );
    }
}

/// Tells the render world whether a caster takes a share of the light, now or at some time.
fn extract_fading_casters(
    settings: Extract<Res<LodSettings>>,
    chains: Extract<Query<(), With<LodChain>>>,
    own_transitions: Extract<Query<&LodTransition, With<LodChain>>>,
    parts: Extract<Query<&LodCoat, With<MeshMaterial3d<material::FadingMaterial>>>>,
    mut fading: ResMut<FadingCasters>,
) {
    let now = parts.iter().any(|coat| coat.shadow > 0.0 && !coat.dithers_shadow);
    let common = [Some(settings.transition.kind), settings.right_half];
    let sometimes = settings.shadows != LodShadows::Solid
        && ((common.into_iter().flatten().any(LodKind::shares_shadow) && !chains.is_empty())
            || own_transitions.iter().any(|own| own.kind.shares_shadow()));
    *fading = FadingCasters {
        now,
        sometimes: now || sometimes,
    };
}
