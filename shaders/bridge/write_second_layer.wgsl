// Packs transparent surfaces into a layer of the sun's shadow maps: depth, and the shadow result in its last
// eight bits. `fetch_shadow.wgsl` takes both apart.

#import bevy_core_pipeline::fullscreen_vertex_shader::FullscreenVertexOutput

@group(0) @binding(0) var shadow_result: texture_2d<f32>;
@group(0) @binding(1) var transparent_depth: texture_depth_2d;

@fragment
fn fragment(in: FullscreenVertexOutput) -> @builtin(frag_depth) f32 {
    let pixel = vec2<i32>(in.position.xy);
    let depth = bitcast<u32>(textureLoad(transparent_depth, pixel, 0));
    let result = u32(round(saturate(textureLoad(shadow_result, pixel, 0).r) * 255.0));
    // Nothing is transparent: a depth of zero, whatever the result is.
    return bitcast<f32>(select((depth & 0xffffff00u) | result, 0u, depth == 0u));
}
