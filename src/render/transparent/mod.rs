//! Transparent surfaces with shadow results of their own (Giegl 2007, section 5.13), where
//! [`SunShadows::transparent_layers`](crate::shadow::settings::SunShadows) asks for them: pictures of the nearest ones of
//! every pixel, a layer each, with their depths and shadow results.
//!
//! ```text
//! queue    variants of the pipelines of transparent things                                          pipelines
//! Core3d   └─► draw_nearest: the nearest depth in every pixel, then the nearest behind it, …          nearest
//!          └─► apply: the shadow results of these depths, as for the depth prepass         apply, virtual_map
//!          └─► bridge: depth and result of the first into one layer of the sun's shadow maps           bridge
//!          transparent things: fragments whose depth is that of the layer take its result    fetch_shadow.wgsl
//! ```
//!
//! That is the third strategy of the thesis, [`Nearest`](TransparentLayers::Nearest). For the fourth, multi-pass,
//! [`All`](TransparentLayers::All), Bevy's own pass leaves out what materials draw, and after it
//!
//! ```text
//! Core3d   from the farthest layer to the nearest                                                       draw
//!          └─► bridge: its depth and result into the same layer of the sun's shadow maps               bridge
//!          └─► transparent things, against its depth: only fragments at just this depth are drawn
//! ```
//!
//! The thesis draws them once per tile of the shadow map, within the tile's rectangle on the screen. Drawn once per layer, the
//! surfaces of a pixel are blended from far to near whatever the order of tiles and objects is, for maps of any kind. The
//! depth test chooses the layer, so that unlit materials are drawn once per fragment, too.
//!
//! # Limits
//! Transmissive materials have no result. Layers know meshes, not materials: fragments that a material discards or makes fully
//! clear take up a place. The results have neither blur nor history. Planes come from depths alone: there are no normals. Needs `Msaa::Off`,
//! as all of the full path.
//!
//! Nearest: what is behind the nearest one reads the fallback map.
//!
//! All: what is behind the last layer is not drawn. What is transparent but no material (gizmos, for one), materials with a
//! depth test of their own (forward decals) and fading levels of detail are drawn in Bevy's own pass, as if they were
//! behind all layers. What is not compiled yet is drawn there, too. A vertex shader must put its vertices at the same depths in two pipelines: Bevy's are made to promise it, others need
//! `@invariant` positions.

mod draw;
pub(super) mod items;
mod nearest;
mod pipelines;

use bevy::{
    camera::MainPassResolutionOverride,
    core_pipeline::{
        core_3d::{Transparent3d, main_transparent_pass_3d},
        oit::OrderIndependentTransparencySettings,
        prepass::DepthPrepass,
        schedule::{Core3d, Core3dSystems},
    },
    ecs::query::QueryData,
    log::warn_once,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        render_phase::{AddRenderCommand, ViewSortedRenderPhases},
        render_resource::{PipelineCache, Texture, TextureFormat, TextureUsages, TextureView},
        renderer::RenderDevice,
        view::ExtractedView,
    },
};

use self::{
    items::{DrawInLayers, MaterialFunctions},
    pipelines::TransparentPipelines,
};
use super::{
    SunShadowPasses,
    atlas::{RESULT_FORMAT, create_target},
    caster::prepare::skip_idle_fallback,
    extract::ExtractedSun,
    unpop::draw::{FadingItems, draw_by_own_function},
};
use crate::shadow::settings::TransparentLayers;

/// Format of a layer's depth.
const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// Groups that pipelines of layers bind: Bevy's four and one more.
const GROUPS: u32 = 5;

/// Gives transparent surfaces sharp shadows where the sun's settings ask for it.
pub struct TransparentPlugin;

impl Plugin for TransparentPlugin {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .add_render_command::<Transparent3d, DrawInLayers>()
            .add_systems(RenderStartup, pipelines::init_pipelines)
            .add_systems(
                Render,
                (pipelines::build_pipelines, prepare_surfaces)
                    .chain()
                    .in_set(RenderSystems::PhaseSort)
                    .after(draw_by_own_function)
                    .before(skip_idle_fallback),
            )
            .add_systems(
                Core3d,
                (
                    nearest::draw_nearest
                        .after(Core3dSystems::Prepass)
                        .before(SunShadowPasses::Plan)
                        .before(Core3dSystems::MainPass),
                    draw::draw_layers
                        .in_set(Core3dSystems::MainPass)
                        .after(main_transparent_pass_3d),
                ),
            );
    }
}

/// On a camera's render entity: its nearest transparent surfaces, while there are some.
#[derive(Component, Clone, Debug)]
pub struct TransparentSurfaces {
    /// The nearest first.
    pub layers: Vec<TransparentLayer>,
    /// The depth that transparent things are drawn against, if they are drawn layer by layer: 4 bytes per pixel.
    pub depth_test: Option<(Texture, TextureView)>,
    /// Pixels.
    pub size: UVec2,
}

/// One transparent surface of every pixel: 6 bytes per pixel.
#[derive(Clone, Debug)]
pub struct TransparentLayer {
    /// Reverse z; 0 where nothing is transparent.
    pub depth: (Texture, TextureView),
    /// The shadow result of that surface: 1 lit, 0 in shadow.
    pub result: (Texture, TextureView),
}

impl TransparentSurfaces {
    fn new(device: &RenderDevice, size: UVec2, layers: TransparentLayers) -> Self {
        let layer = |_| TransparentLayer {
            depth: create_target(device, "umbrage_transparent_depth", size, DEPTH_FORMAT),
            result: create_target(device, "umbrage_transparent_result", size, RESULT_FORMAT),
        };
        Self {
            layers: (0..layer_count(layers)).map(layer).collect(),
            depth_test: draws_layers(layers)
                .then(|| create_target(device, "umbrage_transparent_depth_test", size, DEPTH_FORMAT)),
            size,
        }
    }

    fn is_for(&self, size: UVec2, layers: TransparentLayers) -> bool {
        (self.size, self.layers.len(), self.depth_test.is_some()) == (size, layer_count(layers), draws_layers(layers))
    }
}

fn layer_count(layers: TransparentLayers) -> usize {
    match layers {
        TransparentLayers::Off => 0,
        TransparentLayers::Nearest => 1,
        TransparentLayers::All { count } => count as usize,
    }
}

/// Whether transparent things are drawn layer by layer.
fn draws_layers(layers: TransparentLayers) -> bool {
    matches!(layers, TransparentLayers::All { .. })
}

/// What the layers of a camera depend on.
#[derive(QueryData)]
struct TransparentCamera {
    camera: &'static ExtractedCamera,
    view: &'static ExtractedView,
    sun: Option<&'static ExtractedSun>,
    camera_3d: Option<&'static Camera3d>,
    has_prepass: Has<DepthPrepass>,
    has_oit: Has<OrderIndependentTransparencySettings>,
    has_other_resolution: Has<MainPassResolutionOverride>,
}

impl TransparentCameraItem<'_, '_> {
    /// What the sun's settings ask for, as far as the camera can have it.
    fn layers(&self, device: &RenderDevice) -> TransparentLayers {
        let asked = self
            .sun
            .map_or(TransparentLayers::Off, |sun| sun.settings.transparent_layers);
        if !draws_layers(asked) {
            return asked;
        }
        if self.has_oit || self.has_other_resolution || device.limits().max_bind_groups < GROUPS {
            warn_once!(
                "transparent things are not drawn layer by layer, because the camera sorts them itself or has another \
                resolution, or the device binds less than {GROUPS} groups: the nearest ones have sharp shadows"
            );
            return TransparentLayers::Nearest;
        }
        // A camera that is new in this frame has not what `prepare_cameras` gives it.
        let usages = self
            .camera_3d
            .map(|camera| TextureUsages::from(camera.depth_texture_usages));
        let is_readable = usages.is_some_and(|usages| usages.contains(TextureUsages::TEXTURE_BINDING));
        if self.has_prepass && is_readable {
            asked
        } else {
            TransparentLayers::Nearest
        }
    }
}

/// Makes and keeps the layers of cameras that see something transparent and whose sun asks for them, and takes what is drawn
/// layer by layer out of Bevy's own pass.
fn prepare_surfaces(
    mut commands: Commands,
    (device, cache): (Res<RenderDevice>, Res<PipelineCache>),
    mut phases: ResMut<ViewSortedRenderPhases<Transparent3d>>,
    (fading, functions): (FadingItems, MaterialFunctions),
    pipelines: Res<TransparentPipelines>,
    cameras: Query<(Entity, TransparentCamera, Option<&TransparentSurfaces>)>,
) {
    for (entity, camera, surfaces) in &cameras {
        let layers = camera.layers(&device);
        let draws_layers = draws_layers(layers);
        let mut has_receivers = false;
        if let (Some(phase), Some((bevys, in_layers))) =
            (phases.get_mut(&camera.view.retained_view_entity), functions.get())
        {
            let can_select = draws_layers && pipelines.can_select(&cache, camera.view.target_format);
            for item in phase.items.values_mut() {
                let is_material = item.draw_function == bevys || item.draw_function == in_layers;
                if is_material {
                    let is_layered = can_select && pipelines.draws_layers_of(&cache, item.pipeline);
                    item.draw_function = if is_layered { in_layers } else { bevys };
                }
                has_receivers |= is_material || (!draws_layers && !fading.has(item));
            }
        }
        let is_wanted = has_receivers && layers != TransparentLayers::Off;
        let size = camera.camera.physical_target_size.filter(|size| size.min_element() > 0);
        match (size.filter(|_| is_wanted), surfaces) {
            (Some(size), Some(surfaces)) if surfaces.is_for(size, layers) => {}
            (Some(size), _) => {
                let surfaces = TransparentSurfaces::new(&device, size, layers);
                commands.entity(entity).insert(surfaces);
            }
            (None, Some(_)) => {
                commands.entity(entity).remove::<TransparentSurfaces>();
            }
            (None, None) => {}
        }
    }
}
