//! Virtual shadow maps: a map far larger than any texture, of which tiles are drawn, used and overwritten (Giegl 2007).
//!
//! The maths room has the forms and their reasons ([`maths::virtual_map`](crate::maths::virtual_map)); here their steps run.
//!
//! ```text
//! main world   one light view of the whole range, warped or not: the *map*
//! Core3d       depth prepass, plan of the caster phase
//!              └─► draw_virtual_maps, an exclusive system, for each camera:
//!                    lists of tiles                                            tiled, queried, fitted
//!                    └─► waves of up to 16 tiles: one culling dispatch         record
//!                        ├─► each tile: casters ─► a cell of a texture         textures
//!                        └─► all of them ─► result                             apply_tile.wgsl
//!                    └─► counts of changed pixels read back, next list         queried
//! ```
//!
//! - [`tiles::TileDraw`] is what a form produces: place in the map, texels, pixels that may look into it. Tiles live in the
//!   render world only and for one frame.
//! - [`TileFrame`] is what a form works with: it records lists of tiles and reads buffers back within the frame.
//! - The caster phase is that of all techniques. Its render views are slots here: before a wave their matrices are
//!   overwritten on the GPU, so tiles may be decided after the frame's views were prepared.
//! - A tile overwrites the shadow result of the pixels in it and touches no other, so the order of disjoint tiles, waves
//!   and the number of textures change no bit.
//!
//! # Limits
//! Surfaces that the depth prepass does not hold read Bevy's fallback map, but fading levels of detail, and transparent
//! ones where they have a [layer](super::transparent). `store=second|midpoint` needs two atlases and is
//! not drawn. Filters wider than the margins ([`tiles::margin`]) are cut at borders of tiles.

pub mod fitted;
pub mod overlay;
pub mod queried;
pub mod record;
pub mod report;
pub mod textures;
pub mod tiled;
pub mod tiles;

use bevy::{
    core_pipeline::schedule::Core3d,
    ecs::{schedule::ApplyDeferred, system::SystemState},
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        diagnostic::{DiagnosticsRecorder, RecordDiagnostics},
        render_resource::{
            Buffer, CommandEncoderDescriptor, LoadOp, Operations, RenderPassColorAttachment, RenderPassDescriptor,
            StoreOp, Texture, TextureView,
        },
        renderer::{CurrentView, RenderContext, RenderDevice},
        sync_world::MainEntity,
        view::ExtractedView,
    },
};

use self::{
    record::{Counting, TileList, record_tiles},
    report::{DrawnTile, VirtualMapReport, VirtualMapReports},
    textures::TileTextures,
    tiles::TileDraw,
};
use super::{
    SunShadowPasses,
    atlas::{RESULT_FORMAT, ShadowAtlas, ShadowResult, create_target},
    caster::{CasterStatistics, layers::FadingCasters, pass::storage_buffer, plan::CasterPlan, prepare::TILE_SLOTS},
    extract::ExtractedSun,
    gpu_types::GpuTileReport,
    read_back::{ReadBack, submit_now},
    receivers::receivers,
};
use crate::{
    maths::virtual_map::{memory::BYTES_PER_TEXEL, picture::PixelRect, queried::TileReport},
    shadow::{timing::SystemTimes, virtual_maps::ShadowMaps},
};

/// The name of the time span of a camera's virtual map, read-backs included.
pub const VIRTUAL_MAP: &str = "umbrage_virtual_map";

/// Draws virtual maps.
pub struct VirtualMapPlugin;

impl Plugin for VirtualMapPlugin {
    fn build(&self, app: &mut App) {
        let times = SystemTimes::of(app);
        let reports = VirtualMapReports::default();
        app.insert_resource(reports.clone())
            .add_plugins((overlay::plugin, fitted::FittedPlugin));
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .insert_resource(reports)
            .init_resource::<TileSchedule>()
            .add_systems(RenderStartup, record::init_tile_pipelines)
            .add_systems(Render, drop_virtual_maps.in_set(RenderSystems::PrepareResources))
            .add_systems(
                Core3d,
                (ApplyDeferred, times.clock("draw_virtual_maps", draw_virtual_maps))
                    .chain()
                    .in_set(SunShadowPasses::Apply),
            );
    }
}

/// How lists of tiles are drawn. For tests: nothing of it changes a bit of the picture.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileSchedule {
    /// Last tile of a list first.
    pub is_reversed: bool,
    /// Tiles culled together, 1 to [`TILE_SLOTS`].
    pub wave_size: u32,
}

impl Default for TileSchedule {
    fn default() -> Self {
        Self {
            is_reversed: false,
            wave_size: TILE_SLOTS as u32,
        }
    }
}

/// On a camera's render entity: what its virtual map keeps from frame to frame; nothing of it shows in the picture.
#[derive(Component, Debug, Default)]
pub struct VirtualMap {
    textures: TileTextures,
    /// For copies of the results of all receivers, to count by.
    old_results: Vec<(Texture, TextureView)>,
    rest: Rest,
}

impl VirtualMap {
    /// The tile texture with the largest cells; each holds the tile that was drawn into it last.
    pub fn texture(&self) -> Option<&Texture> {
        self.textures.largest()
    }
}

/// Since when camera and light stand still.
#[derive(Debug, Default)]
struct Rest {
    pose: Option<(Mat4, GlobalTransform, Mat4)>,
    still_frames: u32,
}

impl Rest {
    /// Frames since the last change of a pose.
    fn count(&mut self, pose: (Mat4, GlobalTransform, Mat4)) -> u32 {
        if self.pose == Some(pose) {
            self.still_frames = self.still_frames.saturating_add(1);
        } else {
            *self = Self {
                pose: Some(pose),
                still_frames: 0,
            };
        }
        self.still_frames
    }
}

/// One camera's virtual map while its frame is recorded.
pub struct TileFrame<'a> {
    world: &'a mut World,
    context: &'a mut SystemState<RenderContext<'static, 'static>>,
    camera: Entity,
    map: &'a mut VirtualMap,
    /// The sun of the camera.
    pub sun: &'a ExtractedSun,
    /// Pixels of the shadow result: those of the camera's target.
    pub picture: UVec2,
    /// Those that the camera draws.
    pub viewport: PixelRect,
    /// Frames since camera, light view and lens last changed.
    pub still_frames: u32,
    /// What was drawn so far.
    pub report: VirtualMapReport,
}

impl TileFrame<'_> {
    /// The render world, with this camera's components besides the virtual map.
    pub fn world(&self) -> &World {
        self.world
    }

    /// The camera's render entity.
    pub fn camera(&self) -> Entity {
        self.camera
    }

    /// Bytes of tile textures that may be alive at once: what the settings allow, and no texture larger than the device has.
    /// Half of it where levels of detail may fade: then every texture has a second one for their casters.
    pub fn texture_budget(&self) -> u64 {
        let side = u64::from(self.world.resource::<RenderDevice>().limits().max_texture_dimension_2d);
        let copies = 1 + u64::from(self.world.resource::<FadingCasters>().sometimes);
        (self.sun.settings.maps.memory_bytes() / copies).min(side * side * BYTES_PER_TEXEL)
    }

    /// Makes textures for tiles of some sizes, within [`texture_budget`](Self::texture_budget).
    pub fn prepare_textures(&mut self, sizes: &[UVec2]) {
        let budget = self.texture_budget();
        let atlas = self.world.get::<ShadowAtlas>(self.camera);
        let fades = atlas.is_some_and(|atlas| atlas.fades);
        self.map
            .textures
            .prepare(self.world.resource::<RenderDevice>(), sizes, budget, fades);
        self.report.texture_bytes = self.map.textures.bytes();
    }

    /// Draws and applies tiles, in their order where they overlap.
    pub fn draw(&mut self, tiles: &[TileDraw]) {
        let list = TileList {
            tiles,
            textures: &self.map.textures,
            first_tile: self.report.tiles.len() as u32,
            counting: None,
        };
        let (world, camera) = (&*self.world, self.camera);
        if let Ok(mut ctx) = self.context.get(world) {
            record_tiles(world, &mut ctx, camera, &list);
        }
        self.context.apply(self.world);
        self.report.tiles.extend(tiles.iter().map(|draw| DrawnTile {
            draw: *draw,
            report: None,
            decision: None,
        }));
    }

    /// Draws and applies disjoint tiles, only where a shadow result changes by more than a tolerance, and counts those
    /// pixels, of all receivers together. Waits for the GPU. One report per tile; empty ones while pipelines are compiled.
    pub fn draw_counted(&mut self, tiles: &[TileDraw], tolerance: f32) -> Vec<TileReport> {
        self.prepare_old_results();
        let nothing = GpuTileReport {
            min_x: u32::MAX,
            min_y: u32::MAX,
            ..default()
        };
        let device = self.world.resource::<RenderDevice>();
        let reports = storage_buffer(device, "umbrage_tile_reports", &vec![nothing; tiles.len()]);
        let (world, camera) = (&*self.world, self.camera);
        let old_results = &self.map.old_results;
        if let Ok(mut ctx) = self.context.get(world) {
            for (receiver, (old, _)) in receivers(world, camera).iter().zip(old_results) {
                let (texture, layer) = receiver.result_texture;
                let mut source = texture.as_image_copy();
                source.origin.z = layer;
                ctx.command_encoder()
                    .copy_texture_to_texture(source, old.as_image_copy(), old.size());
            }
            let list = TileList {
                tiles,
                textures: &self.map.textures,
                first_tile: self.report.tiles.len() as u32,
                counting: Some(Counting {
                    old_results,
                    reports: &reports,
                    tolerance,
                }),
            };
            record_tiles(world, &mut ctx, camera, &list);
        }
        let bytes = self.read_back(&reports).unwrap_or_default();
        let mut found = read_reports(&bytes);
        found.resize(tiles.len(), TileReport::EMPTY);
        let old_bytes = u64::from(self.picture.x) * u64::from(self.picture.y) * 2 * self.map.old_results.len() as u64;
        self.report.buffer_bytes = self.report.buffer_bytes.max(old_bytes + 2 * reports.size());
        self.report
            .tiles
            .extend(tiles.iter().zip(&found).map(|(draw, report)| DrawnTile {
                draw: *draw,
                report: Some(*report),
                decision: None,
            }));
        found
    }

    /// The bytes of a buffer with the usage `COPY_SRC` after everything recorded so far. Hands all commands in and waits
    /// for the GPU; `None` if it is lost.
    pub fn read_back(&mut self, source: &Buffer) -> Option<Vec<u8>> {
        self.context.apply(self.world);
        let device = self.world.resource::<RenderDevice>().clone();
        let memory = ReadBack::new(&device, &[source.size()]);
        let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor {
            label: Some("umbrage_read_back"),
        });
        memory.copy(&mut encoder, std::slice::from_ref(source));
        submit_now(self.world, encoder);
        self.report.read_backs += 1;
        memory.read(&device)?.pop()
    }

    /// Textures for copies of all shadow results.
    fn prepare_old_results(&mut self) {
        let count = receivers(self.world, self.camera).len();
        let (device, picture) = (self.world.resource::<RenderDevice>(), self.picture);
        let old_results = &mut self.map.old_results;
        old_results.retain(|(texture, _)| UVec2::new(texture.width(), texture.height()) == picture);
        let create = || create_target(device, "umbrage_old_result", picture, RESULT_FORMAT);
        old_results.resize_with(count, create);
    }

    /// Everything is lit, no caster is drawn.
    fn clear(&mut self) {
        let (world, camera) = (&*self.world, self.camera);
        if let Ok(mut ctx) = self.context.get(world) {
            if let Some(drawn) = world.get::<CasterPlan>(camera).and_then(|plan| plan.drawn.as_ref()) {
                ctx.command_encoder().clear_buffer(drawn, 0, None);
            }
            for receiver in receivers(world, camera) {
                ctx.begin_tracked_render_pass(RenderPassDescriptor {
                    label: Some("umbrage_clear_result"),
                    color_attachments: &[Some(RenderPassColorAttachment {
                        view: receiver.result,
                        depth_slice: None,
                        resolve_target: None,
                        ops: Operations {
                            load: LoadOp::Clear(LinearRgba::WHITE.into()),
                            store: StoreOp::Store,
                        },
                    })],
                    depth_stencil_attachment: None,
                    timestamp_writes: None,
                    occlusion_query_set: None,
                    multiview_mask: None,
                });
            }
        }
        self.context.apply(self.world);
    }

    /// Begins or ends the time span.
    fn mark(&mut self, is_begin: bool) {
        let world = &*self.world;
        if let (Ok(mut ctx), Some(recorder)) = (self.context.get(world), world.get_resource::<DiagnosticsRecorder>()) {
            if is_begin {
                recorder.begin_time_span(ctx.command_encoder(), VIRTUAL_MAP.into());
            } else {
                recorder.end_time_span(ctx.command_encoder());
            }
        }
        self.context.apply(self.world);
    }
}

/// Reports as the GPU left them.
fn read_reports(bytes: &[u8]) -> Vec<TileReport> {
    let (numbers, _) = bytes.as_chunks();
    let numbers: Vec<u32> = numbers.iter().copied().map(u32::from_le_bytes).collect();
    let (reports, _) = numbers.as_chunks();
    let report = |&[changed, inside, min_x, min_y, max_x, max_y]: &[u32; 6]| match inside {
        0 => TileReport::EMPTY,
        _ => TileReport {
            changed,
            inside,
            rect: PixelRect {
                min: UVec2::new(min_x, min_y),
                max: UVec2::new(max_x, max_y) + 1,
            },
        },
    };
    reports.iter().map(report).collect()
}

/// Draws the virtual map of the current camera, if its sun has one.
pub fn draw_virtual_maps(world: &mut World, context: &mut SystemState<RenderContext<'static, 'static>>) {
    let Some(camera) = world.get_resource::<CurrentView>().map(|view| view.0) else {
        return;
    };
    let Some(sun) = world
        .get::<ExtractedSun>(camera)
        .filter(|sun| sun.settings.maps.is_virtual())
    else {
        return;
    };
    let sun = sun.clone();
    let (Some(result), Some(view)) = (world.get::<ShadowResult>(camera), world.get::<ExtractedView>(camera)) else {
        return;
    };
    let picture = result.size;
    let (first, size) = (view.viewport.xy(), view.viewport.zw());
    let viewport = PixelRect {
        min: first,
        max: first + size,
    };
    let map_pose = sun.light_views.first().map(|light_view| light_view.clip_from_world);
    let pose = (map_pose.unwrap_or_default(), view.world_from_view, view.clip_from_view);
    let main_camera = world.get::<MainEntity>(camera).map(|main| **main);
    let mut map = world.entity_mut(camera).take::<VirtualMap>().unwrap_or_default();
    let still_frames = map.rest.count(pose);
    let mut frame = TileFrame {
        world,
        context,
        camera,
        map: &mut map,
        sun: &sun,
        picture,
        viewport: viewport.intersection(PixelRect::whole(picture)),
        still_frames,
        report: VirtualMapReport::default(),
    };
    frame.mark(true);
    frame.clear();
    // Without a light view nothing can be in shadow.
    if let Some(light_view) = sun.light_views.first() {
        let map_clip_from_world = light_view.clip_from_world.as_dmat4();
        match &sun.settings.maps {
            ShadowMaps::Partitions => {}
            ShadowMaps::Tiled(settings) => tiled::draw(&mut frame, settings, &map_clip_from_world),
            ShadowMaps::Queried(settings) => queried::draw(&mut frame, settings, &map_clip_from_world),
            ShadowMaps::Fitted(settings) => fitted::draw(&mut frame, settings),
        }
    }
    frame.mark(false);
    let report = frame.report;
    if let Some(counts) = world.resource_mut::<CasterStatistics>().0.get_mut(&camera) {
        counts.light_views = report.tiles.len() as u32;
    }
    if let Some(main_camera) = main_camera {
        world.resource::<VirtualMapReports>().set(main_camera, report);
    }
    world.entity_mut(camera).insert(map);
}

/// Drops what cameras without a virtual map no longer need.
fn drop_virtual_maps(
    mut commands: Commands,
    cameras: Query<
        (Entity, &MainEntity, Option<&ExtractedSun>, Has<VirtualMap>),
        Or<(With<ExtractedSun>, With<VirtualMap>)>,
    >,
    reports: Res<VirtualMapReports>,
) {
    let is_virtual = |sun: Option<&ExtractedSun>| sun.is_some_and(|sun| sun.settings.maps.is_virtual());
    let mut kept = Vec::new();
    for (entity, main_entity, sun, has_map) in &cameras {
        if is_virtual(sun) {
            kept.push(**main_entity);
        } else if has_map {
            commands.entity(entity).remove::<VirtualMap>();
        }
    }
    reports.retain(|camera| kept.contains(&camera));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_read_as_they_were_written() {
        let bytes: Vec<u8> = [[3, 5, 1, 2, 7, 8], [0, 0, u32::MAX, u32::MAX, 0, 0]]
            .concat()
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect();
        let rect = PixelRect {
            min: UVec2::new(1, 2),
            max: UVec2::new(8, 9),
        };
        let first = TileReport {
            changed: 3,
            inside: 5,
            rect,
        };
        assert_eq!(read_reports(&bytes), [first, TileReport::EMPTY]);
    }

    #[test]
    fn rest_begins_anew_with_every_change() {
        let mut rest = Rest::default();
        let pose = |x: f32| (Mat4::IDENTITY, GlobalTransform::from_xyz(x, 0.0, 0.0), Mat4::IDENTITY);
        let counts: Vec<u32> = [1.0, 1.0, 1.0, 2.0, 2.0].map(|x| rest.count(pose(x))).to_vec();
        assert_eq!(counts, [0, 1, 2, 0, 1]);
    }
}
