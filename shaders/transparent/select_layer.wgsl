// Fills the depth that transparent things are drawn against with one layer: only its surfaces are at that depth. The picture
// has opaque things by now, also such as no prepass draws: none of the layer is left behind them.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput

@group(0) @binding(0) var opaque_depth: texture_depth_2d;
@group(0) @binding(1) var layer_depth: texture_depth_2d;

@fragment
fn fragment(in: FullscreenVertexOutput) -> @builtin(frag_depth) f32 {
    let pixel = vec2<i32>(in.position.xy);
    let depth = textureLoad(layer_depth, pixel, 0);
    return select(0.0, depth, depth >= textureLoad(opaque_depth, pixel, 0));
}
