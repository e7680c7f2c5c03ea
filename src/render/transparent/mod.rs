//! The nearest transparent surface of every pixel: a second picture with its own depths and shadow result (Giegl 2007,
//! section 5.13, third strategy), where [`SunShadows::transparent_layer`](crate::shadow::settings::SunShadows) asks for it.
//!
//! ```text
//! queue    pipelines of transparent things; of each a variant that writes depth only                    nearest
//! Core3d   └─► draw_nearest_transparent: their nearest depth in every pixel                             nearest
//!          └─► apply: the shadow result of these depths, as for the depth prepass            apply, virtual_map
//!          └─► bridge: depth and result into one layer of the sun's shadow maps                          bridge
//!          transparent things: fragments whose depth is that of the layer take its result   fetch_shadow.wgsl
//! ```
//!
//! # Limits
//! Surfaces behind the nearest transparent one, transmissive materials and fragments that a material discards or makes
//! fully clear have no place in the layer: what lies behind those reads the fallback map. The result has neither blur nor
//! history. Planes come from depths alone: there are no normals. Needs `Msaa::Off`, as all of the full path.

pub(super) mod items;
mod nearest;

use bevy::{
    core_pipeline::{
        core_3d::Transparent3d,
        schedule::{Core3d, Core3dSystems},
    },
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        camera::ExtractedCamera,
        render_phase::ViewSortedRenderPhases,
        render_resource::{Texture, TextureFormat, TextureView},
        renderer::RenderDevice,
        view::ExtractedView,
    },
};

use super::{
    SunShadowPasses,
    atlas::{RESULT_FORMAT, create_target},
    caster::prepare::skip_idle_fallback,
    extract::ExtractedSun,
    unpop::draw::{FadingItems, draw_by_own_function},
};

/// Format of the layer's depth.
const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// Gives transparent surfaces sharp shadows where the sun's settings ask for it.
pub struct TransparentPlugin;

impl Plugin for TransparentPlugin {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_resource::<nearest::DepthPipelines>()
            .add_systems(
                Render,
                (prepare_layers, nearest::build_pipelines)
                    .chain()
                    .in_set(RenderSystems::PhaseSort)
                    .after(draw_by_own_function)
                    .before(skip_idle_fallback),
            )
            .add_systems(
                Core3d,
                nearest::draw_nearest_transparent
                    .after(Core3dSystems::Prepass)
                    .before(SunShadowPasses::Plan)
                    .before(Core3dSystems::MainPass),
            );
    }
}

/// On a camera's render entity: its nearest transparent surfaces. 6 bytes per pixel, while there are some.
#[derive(Component, Clone, Debug)]
pub struct TransparentLayer {
    /// Reverse z; 0 where nothing is transparent.
    pub depth: (Texture, TextureView),
    /// The shadow result of that surface: 1 lit, 0 in shadow.
    pub result: (Texture, TextureView),
    /// Pixels.
    pub size: UVec2,
}

/// Makes and keeps the layers of cameras that see something transparent and whose sun asks for one.
fn prepare_layers(
    mut commands: Commands,
    device: Res<RenderDevice>,
    phases: Res<ViewSortedRenderPhases<Transparent3d>>,
    items: FadingItems,
    cameras: Query<(
        Entity,
        &ExtractedCamera,
        &ExtractedView,
        Option<&ExtractedSun>,
        Option<&TransparentLayer>,
    )>,
) {
    for (entity, camera, view, sun, layer) in &cameras {
        let is_wanted = sun.is_some_and(|sun| sun.settings.transparent_layer)
            && phases
                .get(&view.retained_view_entity)
                .is_some_and(|phase| phase.items.values().any(|item| !items.has(item)));
        let size = camera.physical_target_size.filter(|size| size.min_element() > 0);
        match (size.filter(|_| is_wanted), layer) {
            (Some(size), Some(layer)) if layer.size == size => {}
            (Some(size), _) => {
                commands.entity(entity).insert(TransparentLayer {
                    depth: create_target(&device, "umbrage_transparent_depth", size, DEPTH_FORMAT),
                    result: create_target(&device, "umbrage_transparent_result", size, RESULT_FORMAT),
                    size,
                });
            }
            (None, Some(_)) => {
                commands.entity(entity).remove::<TransparentLayer>();
            }
            (None, None) => {}
        }
    }
}
