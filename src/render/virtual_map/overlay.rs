//! [`TileOverlay`]: the tiles of a virtual map in color over a camera's picture.

use bevy::{
    core_pipeline::{
        FullscreenShader,
        prepass::{DepthPrepass, ViewPrepassTextures},
        schedule::{Core3d, Core3dSystems},
        tonemapping::tonemapping,
    },
    prelude::*,
    render::{
        GpuResourceAppExt, Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        extract_component::{ExtractComponent, ExtractComponentPlugin},
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId, PipelineCache,
            RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages, SpecializedRenderPipeline,
            SpecializedRenderPipelines, TextureFormat, TextureSampleType,
            binding_types::{
                storage_buffer_read_only, storage_buffer_read_only_sized, texture_2d, texture_depth_2d, uniform_buffer,
            },
        },
        renderer::{RenderContext, ViewQuery},
        sync_world::MainEntity,
        texture::FallbackImage,
        view::{ViewTarget, ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use super::report::{DrawnTile, VirtualMapReports};
use crate::render::{
    apply::ApplyBuffer,
    caster::pass::storage_buffer,
    gpu_types::{ApplyParameters, GpuTileMark},
    heat_map::color::STOPS,
    overlay_pass::overlay_pipeline,
    shaders,
};

/// On a camera: shows the tiles of its sun's virtual map, dark lines between them. Colors go from that of the coarsest tile
/// of the frame (blue) up by one for each doubling of its resolution, to red. Nothing without a virtual map.
#[derive(Component, Clone, Copy, Debug, PartialEq, ExtractComponent)]
#[require(DepthPrepass)]
pub struct TileOverlay {
    /// 0 shows the picture only, 1 the colors only.
    pub opacity: f32,
}

/// Makes [`TileOverlay`] work; costs nothing without one.
pub(super) fn plugin(app: &mut App) {
    app.add_plugins(ExtractComponentPlugin::<TileOverlay>::default());
    let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
        return;
    };
    render_app
        .init_gpu_resource::<SpecializedRenderPipelines<OverlayPipeline>>()
        .add_systems(RenderStartup, init_pipeline)
        .add_systems(Render, prepare.in_set(RenderSystems::PrepareResources))
        .add_systems(Core3d, draw.in_set(Core3dSystems::PostProcess).after(tonemapping));
}

/// The color of a tile `levels` doublings finer than the coarsest.
pub fn tile_color(levels: u32) -> LinearRgba {
    STOPS[(levels as usize + 1).min(STOPS.len() - 1)]
}

/// What the shader reads.
fn marks(tiles: &[DrawnTile], opacity: f32) -> Vec<GpuTileMark> {
    let texels = |tile: &DrawnTile| {
        let map = tile.draw.tile.counts.as_u64vec2() * tile.draw.window.core().as_u64vec2();
        map.max_element().max(1)
    };
    let coarsest = tiles.iter().map(texels).min().unwrap_or(1);
    let marks = tiles.iter().map(|tile| GpuTileMark {
        place: tile.draw.tile.place.as_vec2(),
        counts: tile.draw.tile.counts.as_vec2(),
        color: tile_color((texels(tile) / coarsest).ilog2())
            .with_alpha(opacity)
            .to_vec4(),
        light_view: tile.draw.light_view,
        ..default()
    });
    marks.collect()
}

#[derive(Resource)]
struct OverlayPipeline {
    layout: BindGroupLayoutDescriptor,
    fullscreen: FullscreenShader,
    shader: Handle<Shader>,
}

#[derive(Component)]
struct PreparedOverlay(CachedRenderPipelineId);

fn init_pipeline(mut commands: Commands, fullscreen: Res<FullscreenShader>, server: Res<AssetServer>) {
    commands.insert_resource(OverlayPipeline {
        layout: BindGroupLayoutDescriptor::new(
            "umbrage_show_tiles",
            &BindGroupLayoutEntries::sequential(
                ShaderStages::FRAGMENT,
                (
                    uniform_buffer::<ViewUniform>(true),
                    texture_depth_2d(),
                    texture_2d(TextureSampleType::Float { filterable: false }),
                    storage_buffer_read_only::<ApplyParameters>(false),
                    storage_buffer_read_only_sized(false, None),
                ),
            ),
        ),
        fullscreen: fullscreen.clone(),
        shader: shaders::load(&server, "virtual_map/show_tiles.wgsl"),
    });
}

impl SpecializedRenderPipeline for OverlayPipeline {
    type Key = TextureFormat;

    fn specialize(&self, format: TextureFormat) -> RenderPipelineDescriptor {
        overlay_pipeline(
            "umbrage_show_tiles",
            &self.layout,
            &self.fullscreen,
            (&self.shader, Vec::new()),
            format,
        )
    }
}

fn prepare(
    mut commands: Commands,
    cameras: Query<(Entity, &ViewTarget), (With<TileOverlay>, With<ApplyBuffer>)>,
    left: Query<Entity, (With<PreparedOverlay>, Without<TileOverlay>)>,
    overlay_pipeline: Res<OverlayPipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<OverlayPipeline>>,
    cache: Res<PipelineCache>,
) {
    for entity in &left {
        commands.entity(entity).remove::<PreparedOverlay>();
    }
    for (entity, target) in &cameras {
        let id = pipelines.specialize(&cache, &overlay_pipeline, target.main_texture_format());
        commands.entity(entity).insert(PreparedOverlay(id));
    }
}

fn draw(
    view: ViewQuery<(
        &ExtractedCamera,
        &ViewTarget,
        &TileOverlay,
        &PreparedOverlay,
        &ApplyBuffer,
        &ViewPrepassTextures,
        &ViewUniformOffset,
        &MainEntity,
    )>,
    (overlay_pipeline, cache): (Res<OverlayPipeline>, Res<PipelineCache>),
    (view_uniforms, fallback): (Res<ViewUniforms>, Res<FallbackImage>),
    reports: Res<VirtualMapReports>,
    mut ctx: RenderContext,
) {
    let (camera, target, overlay, prepared, parameters, prepass, view_offset, main_entity) = view.into_inner();
    let report = reports.get(**main_entity).filter(|report| !report.tiles.is_empty());
    let (Some(report), Some(pipeline), Some(depth), Some(view_binding), Some(parameters)) = (
        report,
        cache.get_render_pipeline(prepared.0),
        prepass.depth_view(),
        view_uniforms.uniforms.binding(),
        parameters.0.binding(),
    ) else {
        return;
    };
    let normals = prepass.normal_view().unwrap_or(&fallback.d2.texture_view);
    let marks = storage_buffer(
        ctx.render_device(),
        "umbrage_tile_marks",
        &marks(&report.tiles, overlay.opacity),
    );
    let bind_group = ctx.render_device().create_bind_group(
        "umbrage_show_tiles",
        &cache.get_bind_group_layout(&overlay_pipeline.layout),
        &BindGroupEntries::sequential((view_binding, depth, normals, parameters, marks.as_entire_binding())),
    );
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("umbrage_show_tiles"),
        color_attachments: &[Some(target.get_unsampled_color_attachment())],
        depth_stencil_attachment: None,
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    });
    if let Some(viewport) = &camera.viewport {
        pass.set_camera_viewport(viewport);
    }
    pass.set_render_pipeline(pipeline);
    pass.set_bind_group(0, &bind_group, &[view_offset.offset]);
    pass.draw(0..3, 0..1);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        maths::virtual_map::{
            picture::PixelRect,
            tile::{Tile, TileWindow},
        },
        render::virtual_map::tiles::TileDraw,
    };

    #[test]
    fn each_doubling_has_the_next_color() {
        let tile = |counts: u32, size: u32| DrawnTile {
            draw: TileDraw::filling(
                Tile {
                    place: UVec2::ZERO,
                    counts: UVec2::splat(counts),
                },
                TileWindow::of_size(UVec2::splat(size), 0),
                PixelRect::EMPTY,
            ),
            report: None,
            decision: None,
        };
        let marks = marks(&[tile(1, 64), tile(2, 64), tile(2, 128), tile(64, 8192)], 0.5);
        let colors: Vec<Vec4> = marks.iter().map(|mark| mark.color).collect();
        let of = |stop: usize| STOPS[stop].with_alpha(0.5).to_vec4();
        assert_eq!(colors, [of(1), of(2), of(3), of(6)]);
    }
}
