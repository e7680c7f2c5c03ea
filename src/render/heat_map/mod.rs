//! [`TexelHeatMap`]: texel ÷ pixel of a technique in color over a camera's picture, live.
//!
//! A full-screen pass at the end of post-processing takes position and plane from the prepass, finds the map in which the
//! shadow is looked up, and compares both footprints on the receiver: as one ratio of lengths, or as texels per pixel in the
//! measures and colors of Stingl 2011; or it shows which map that is.

pub mod color;

use bevy::{
    core_pipeline::{
        FullscreenShader,
        prepass::{DepthPrepass, NormalPrepass, ViewPrepassTextures},
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
            SpecializedRenderPipelines, StorageBuffer, TextureFormat, TextureSampleType,
            binding_types::{storage_buffer_read_only, texture_2d, texture_depth_2d, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        texture::FallbackImage,
        view::{ViewTarget, ViewUniform, ViewUniformOffset, ViewUniforms},
    },
    shader::ShaderDefVal,
};

use super::{
    gpu_types::{ApplyParameters, GpuLightView, MAX_LIGHT_VIEWS},
    light_maps::{LightMap, LightMaps, Selection},
    overlay_pass::overlay_pipeline,
    shaders,
};
use crate::maths::sampling_rate::RateMeasure;

/// What the colors say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum HeatColors {
    /// Texel ÷ pixel (root of the ratio of areas): blue 1/8 and less, green 1, yellow 2, red 8 and more.
    #[default]
    TexelRatio,
    /// Texels per pixel, by area or along an axis of the map: dark red 0, yellow 1/3.25, green 1, light blue 3.25, dark blue 10
    /// and more ([`rate_color`](crate::maths::sampling_rate::rate_color)). Large is fine, other than in [`Self::TexelRatio`].
    SamplingRate(RateMeasure),
    /// The map that is read: red, yellow, green, blue and again, in the order of the maps.
    Maps,
}

/// On a camera: shows [`HeatColors`] where a shadow is looked up. Sky and what is in no map stay as they are.
///
/// # Limits
/// At most [`MAX_LIGHT_VIEWS`] maps count; of a virtual map the resolution of its finest tile counts everywhere. The camera needs `Msaa::Off`; with multisampling nothing is drawn.
#[derive(Component, Clone, Debug, PartialEq, ExtractComponent)]
#[require(DepthPrepass, NormalPrepass)]
pub struct TexelHeatMap {
    /// The maps of the frame, and how pixels find theirs.
    pub light_maps: LightMaps,
    /// Unit vector towards the light, world space.
    pub direction_to_light: Vec3,
    /// What the colors say.
    pub colors: HeatColors,
    /// 0 shows the picture only, 1 the colors only.
    pub opacity: f32,
}

impl TexelHeatMap {
    /// The maps; a virtual map as a whole, at its finest.
    fn shown(&self) -> &[LightMap] {
        match &self.light_maps.virtual_maps {
            Some(wholes) => &wholes.maps,
            None => &self.light_maps.maps,
        }
    }

    fn parameters(&self) -> ApplyParameters {
        let mut light_views = [GpuLightView::default(); MAX_LIGHT_VIEWS];
        for (target, map) in light_views.iter_mut().zip(self.shown()) {
            *target = GpuLightView {
                clip_from_world: map.clip_from_world.as_mat4(),
                atlas_rect: UVec4::new(0, 0, map.size.x, map.size.y).as_vec4(),
                depth_range: Vec2::new(0.0, map.far_depth as f32),
                ..default()
            };
        }
        ApplyParameters {
            light_views,
            direction_to_light: self.direction_to_light,
            light_view_count: self.shown().len().min(MAX_LIGHT_VIEWS) as u32,
            shadow_distance: self.light_maps.distance as f32,
            selection: match self.light_maps.selection {
                Selection::Depth => 0,
                Selection::BestResolution => 1,
                Selection::Cascades => 2,
                Selection::Finest => 3,
                // Virtual maps are chosen by depth.
                Selection::LastTile => 0,
            },
            opacity: self.opacity,
            ..default()
        }
    }
}

/// Makes [`TexelHeatMap`] work; costs nothing without one.
pub struct HeatMapPlugin;

impl Plugin for HeatMapPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(ExtractComponentPlugin::<TexelHeatMap>::default());
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .init_gpu_resource::<SpecializedRenderPipelines<HeatMapPipeline>>()
            .add_systems(RenderStartup, init_pipeline)
            .add_systems(Render, prepare.in_set(RenderSystems::PrepareResources))
            .add_systems(Core3d, draw.in_set(Core3dSystems::PostProcess).after(tonemapping));
    }
}

#[derive(Resource)]
struct HeatMapPipeline {
    layout: BindGroupLayoutDescriptor,
    fullscreen: FullscreenShader,
    texel_ratio: Handle<Shader>,
    sampling_rate: Handle<Shader>,
    map_colors: Handle<Shader>,
}

/// What one camera needs to be drawn.
#[derive(Component)]
struct PreparedHeatMap {
    pipeline: CachedRenderPipelineId,
    parameters: StorageBuffer<ApplyParameters>,
}

fn init_pipeline(mut commands: Commands, fullscreen: Res<FullscreenShader>, server: Res<AssetServer>) {
    commands.insert_resource(HeatMapPipeline {
        layout: BindGroupLayoutDescriptor::new(
            "umbrage_heat_map",
            &BindGroupLayoutEntries::sequential(
                ShaderStages::FRAGMENT,
                (
                    uniform_buffer::<ViewUniform>(true),
                    texture_depth_2d(),
                    texture_2d(TextureSampleType::Float { filterable: false }),
                    storage_buffer_read_only::<ApplyParameters>(false),
                ),
            ),
        ),
        fullscreen: fullscreen.clone(),
        texel_ratio: shaders::load(&server, "heat_map/texel_ratio.wgsl"),
        sampling_rate: shaders::load(&server, "heat_map/sampling_rate.wgsl"),
        map_colors: shaders::load(&server, "heat_map/map_colors.wgsl"),
    });
}

impl SpecializedRenderPipeline for HeatMapPipeline {
    type Key = (TextureFormat, HeatColors);

    fn specialize(&self, (format, colors): Self::Key) -> RenderPipelineDescriptor {
        let shader = match colors {
            HeatColors::TexelRatio => &self.texel_ratio,
            HeatColors::SamplingRate(_) => &self.sampling_rate,
            HeatColors::Maps => &self.map_colors,
        };
        let definition = match colors {
            HeatColors::SamplingRate(RateMeasure::Across) => Some("UMBRAGE_RATE_ACROSS"),
            HeatColors::SamplingRate(RateMeasure::Along) => Some("UMBRAGE_RATE_ALONG"),
            HeatColors::SamplingRate(RateMeasure::Area) | HeatColors::TexelRatio | HeatColors::Maps => None,
        };
        overlay_pipeline(
            "umbrage_heat_map",
            &self.layout,
            &self.fullscreen,
            (shader, definition.map(ShaderDefVal::from).into_iter().collect()),
            format,
        )
    }
}

fn prepare(
    mut commands: Commands,
    cameras: Query<(Entity, &TexelHeatMap, &ViewTarget, &Msaa)>,
    left: Query<Entity, (With<PreparedHeatMap>, Without<TexelHeatMap>)>,
    heat_map_pipeline: Res<HeatMapPipeline>,
    mut pipelines: ResMut<SpecializedRenderPipelines<HeatMapPipeline>>,
    cache: Res<PipelineCache>,
    (device, queue): (Res<RenderDevice>, Res<RenderQueue>),
) {
    for entity in &left {
        commands.entity(entity).remove::<PreparedHeatMap>();
    }
    for (entity, heat_map, target, msaa) in &cameras {
        if *msaa != Msaa::Off {
            warn_once!("A camera with TexelHeatMap needs Msaa::Off; its heat map is not drawn.");
            commands.entity(entity).remove::<PreparedHeatMap>();
            continue;
        }
        let mut parameters = StorageBuffer::from(heat_map.parameters());
        parameters.write_buffer(&device, &queue);
        commands.entity(entity).insert(PreparedHeatMap {
            pipeline: pipelines.specialize(
                &cache,
                &heat_map_pipeline,
                (target.main_texture_format(), heat_map.colors),
            ),
            parameters,
        });
    }
}

fn draw(
    view: ViewQuery<(
        &ExtractedCamera,
        &ViewTarget,
        &PreparedHeatMap,
        &ViewPrepassTextures,
        &ViewUniformOffset,
    )>,
    heat_map_pipeline: Res<HeatMapPipeline>,
    cache: Res<PipelineCache>,
    (view_uniforms, fallback): (Res<ViewUniforms>, Res<FallbackImage>),
    mut ctx: RenderContext,
) {
    let (camera, target, prepared, prepass, view_offset) = view.into_inner();
    let (Some(pipeline), Some(depth), Some(view_binding), Some(parameters)) = (
        cache.get_render_pipeline(prepared.pipeline),
        prepass.depth_view(),
        view_uniforms.uniforms.binding(),
        prepared.parameters.binding(),
    ) else {
        return;
    };
    let normals = prepass.normal_view().unwrap_or(&fallback.d2.texture_view);
    let bind_group = ctx.render_device().create_bind_group(
        "umbrage_heat_map",
        &cache.get_bind_group_layout(&heat_map_pipeline.layout),
        &BindGroupEntries::sequential((view_binding, depth, normals, parameters)),
    );
    let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
        label: Some("umbrage_heat_map"),
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
