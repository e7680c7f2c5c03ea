//! Blur of the shadow result on the screen (Scherzer 2005, section 4.3), before Bevy's lighting sees it.
//!
//! Every iteration is two full-screen passes, along the rows into a second texture and along the columns back, so the
//! result stays where it was. [`maths::filter::eye_blur`](crate::maths::filter::eye_blur) is the CPU twin and says why.

use bevy::{
    core_pipeline::{FullscreenShader, prepass::ViewPrepassTextures, schedule::Core3d},
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        camera::ExtractedCamera,
        diagnostic::RecordDiagnostics,
        render_resource::{
            BindGroupEntries, BindGroupLayoutDescriptor, BindGroupLayoutEntries, CachedRenderPipelineId,
            ColorTargetState, ColorWrites, DynamicUniformBuffer, FragmentState, LoadOp, Operations, PipelineCache,
            RenderPassColorAttachment, RenderPassDescriptor, RenderPipelineDescriptor, ShaderStages, StoreOp, Texture,
            TextureSampleType, TextureView,
            binding_types::{texture_2d, texture_depth_2d, uniform_buffer},
        },
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        texture::FallbackImage,
        view::{ViewUniform, ViewUniformOffset, ViewUniforms},
    },
};

use super::{
    SunShadowPasses,
    atlas::{RESULT_FORMAT, ShadowResult, create_target},
    extract::ExtractedSun,
    gpu_types::GpuEyeBlur,
    shaders,
};
use crate::shadow::{settings::ShadowBlur, timing::SystemTimes};

/// The name of the span of all passes together.
pub const EYE_BLUR: &str = "umbrage_eye_blur";

/// The blur.
pub struct BlurPlugin;

impl Plugin for BlurPlugin {
    fn build(&self, app: &mut App) {
        let times = SystemTimes::of(app);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else {
            return;
        };
        render_app
            .add_systems(RenderStartup, init_blur_pipeline)
            .add_systems(Render, prepare_blur.in_set(RenderSystems::PrepareResources))
            .add_systems(
                Core3d,
                times
                    .clock("blur_shadow_result", blur_shadow_result)
                    .in_set(SunShadowPasses::Blur),
            );
    }
}

/// On a camera's render entity whose sun asks for a blur: the texture that the shadow result goes to and fro between.
#[derive(Component, Clone, Debug)]
pub struct BlurTarget {
    /// As large as the shadow result.
    pub texture: Texture,
    /// Default view of the texture.
    pub view: TextureView,
}

/// On the same entity: the uniforms of the passes.
#[derive(Component)]
struct BlurPasses {
    buffer: DynamicUniformBuffer<GpuEyeBlur>,
    offsets: Vec<u32>,
    blur: ShadowBlur,
}

#[derive(Resource)]
struct BlurPipeline {
    layout: BindGroupLayoutDescriptor,
    id: CachedRenderPipelineId,
}

fn init_blur_pipeline(
    mut commands: Commands,
    cache: Res<PipelineCache>,
    fullscreen: Res<FullscreenShader>,
    server: Res<AssetServer>,
) {
    let layout = BindGroupLayoutDescriptor::new(
        EYE_BLUR,
        &BindGroupLayoutEntries::sequential(
            ShaderStages::FRAGMENT,
            (
                uniform_buffer::<ViewUniform>(true),
                texture_depth_2d(),
                texture_2d(TextureSampleType::Float { filterable: false }),
                uniform_buffer::<GpuEyeBlur>(true),
                texture_2d(TextureSampleType::Float { filterable: false }),
            ),
        ),
    );
    let id = cache.queue_render_pipeline(RenderPipelineDescriptor {
        label: Some(EYE_BLUR.into()),
        layout: vec![layout.clone()],
        vertex: fullscreen.to_vertex_state(),
        fragment: Some(FragmentState {
            shader: shaders::load(&server, "blur/eye_blur.wgsl"),
            targets: vec![Some(ColorTargetState {
                format: RESULT_FORMAT,
                blend: None,
                write_mask: ColorWrites::ALL,
            })],
            ..default()
        }),
        ..default()
    });
    commands.insert_resource(BlurPipeline { layout, id });
}

/// The passes of a blur, in order: rows and columns of every iteration.
fn passes_of(blur: ShadowBlur) -> impl Iterator<Item = GpuEyeBlur> {
    (0..blur.iterations).flat_map(move |iteration| {
        [0, 1].map(|axis| GpuEyeBlur {
            iterations: blur.iterations,
            full_depth: blur.full_depth,
            iteration,
            axis,
        })
    })
}

/// Makes, keeps or drops what the blur of every camera needs.
fn prepare_blur(
    mut commands: Commands,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    cameras: Query<(
        Entity,
        Option<&ExtractedSun>,
        Option<&ShadowResult>,
        Option<&BlurTarget>,
        Option<&BlurPasses>,
    )>,
) {
    for (entity, sun, result, target, passes) in &cameras {
        let blur = sun.map_or(ShadowBlur::NONE, |sun| sun.settings.blur);
        let (Some(result), true) = (result, blur.iterations > 0) else {
            if target.is_some() {
                commands.entity(entity).remove::<(BlurTarget, BlurPasses)>();
            }
            continue;
        };
        let size_of = |texture: &Texture| UVec2::new(texture.width(), texture.height());
        if target.is_none_or(|target| size_of(&target.texture) != result.size) {
            let (texture, view) = create_target(&device, EYE_BLUR, result.size, RESULT_FORMAT);
            commands.entity(entity).insert(BlurTarget { texture, view });
        }
        if passes.is_none_or(|passes| passes.blur != blur) {
            let mut buffer = DynamicUniformBuffer::default();
            let offsets = passes_of(blur).map(|pass| buffer.push(&pass)).collect();
            buffer.write_buffer(&device, &queue);
            commands.entity(entity).insert(BlurPasses { buffer, offsets, blur });
        }
    }
}

fn blur_shadow_result(
    view: ViewQuery<(
        &ExtractedCamera,
        &ShadowResult,
        &BlurTarget,
        &BlurPasses,
        &ViewPrepassTextures,
        &ViewUniformOffset,
    )>,
    pipeline: Res<BlurPipeline>,
    cache: Res<PipelineCache>,
    (view_uniforms, fallback): (Res<ViewUniforms>, Res<FallbackImage>),
    mut ctx: RenderContext,
) {
    let (camera, result, target, passes, prepass, view_offset) = view.into_inner();
    let (Some(render_pipeline), Some(depth), Some(view_binding), Some(blur)) = (
        cache.get_render_pipeline(pipeline.id),
        prepass.depth_view(),
        view_uniforms.uniforms.binding(),
        passes.buffer.binding(),
    ) else {
        return;
    };
    // White is no normal.
    let normals = prepass.normal_view().unwrap_or(&fallback.d2.texture_view);
    let bind_group_reading = |ctx: &RenderContext, source: &TextureView| {
        ctx.render_device().create_bind_group(
            EYE_BLUR,
            &cache.get_bind_group_layout(&pipeline.layout),
            &BindGroupEntries::sequential((view_binding.clone(), depth, normals, blur.clone(), source)),
        )
    };
    let to_and_fro = [
        (bind_group_reading(&ctx, &result.view), &target.view),
        (bind_group_reading(&ctx, &target.view), &result.view),
    ];
    let diagnostics = ctx.diagnostic_recorder();
    let diagnostics = diagnostics.as_deref();
    let span = diagnostics.time_span(ctx.command_encoder(), EYE_BLUR);
    for (offset, (bind_group, written)) in passes.offsets.iter().zip(to_and_fro.iter().cycle()) {
        let mut pass = ctx.begin_tracked_render_pass(RenderPassDescriptor {
            label: Some(EYE_BLUR),
            color_attachments: &[Some(RenderPassColorAttachment {
                view: written,
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
        if let Some(viewport) = &camera.viewport {
            pass.set_camera_viewport(viewport);
        }
        pass.set_render_pipeline(render_pipeline);
        pass.set_bind_group(0, bind_group, &[view_offset.offset, *offset]);
        pass.draw(0..3, 0..1);
    }
    span.end(ctx.command_encoder());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_iteration_goes_there_and_back() {
        let blur = ShadowBlur {
            iterations: 3,
            full_depth: 5.0,
        };
        let order: Vec<(u32, u32)> = passes_of(blur).map(|pass| (pass.iteration, pass.axis)).collect();
        assert_eq!(order, [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]);
        assert_eq!(passes_of(ShadowBlur::NONE).count(), 0);
    }
}
