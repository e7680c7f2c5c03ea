// Copies the shadow result into the sun's extra shadow layer, where Bevy's lighting finds it.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput

@group(0) @binding(0) var shadow_result: texture_2d<f32>;

@fragment
fn fragment(in: FullscreenVertexOutput) -> @builtin(frag_depth) f32 {
    return textureLoad(shadow_result, vec2<i32>(in.position.xy), 0).r;
}
