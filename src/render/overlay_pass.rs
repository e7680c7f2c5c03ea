//! What overlays of the whole picture share: a full-screen triangle that is blended over it.

use bevy::{
    core_pipeline::FullscreenShader,
    prelude::*,
    render::render_resource::{
        BindGroupLayoutDescriptor, BlendState, ColorTargetState, ColorWrites, FragmentState, RenderPipelineDescriptor,
        TextureFormat,
    },
    shader::ShaderDefVal,
};

/// The pipeline of an overlay on pictures of a format. Alpha of the picture stays.
pub(super) fn overlay_pipeline(
    label: &'static str,
    layout: &BindGroupLayoutDescriptor,
    fullscreen: &FullscreenShader,
    (shader, shader_defs): (&Handle<Shader>, Vec<ShaderDefVal>),
    format: TextureFormat,
) -> RenderPipelineDescriptor {
    RenderPipelineDescriptor {
        label: Some(label.into()),
        layout: vec![layout.clone()],
        vertex: fullscreen.to_vertex_state(),
        fragment: Some(FragmentState {
            shader: shader.clone(),
            shader_defs,
            targets: vec![Some(ColorTargetState {
                format,
                blend: Some(BlendState::ALPHA_BLENDING),
                write_mask: ColorWrites::COLOR,
            })],
            ..default()
        }),
        ..default()
    }
}
