// The second surface from the light: draws what lies behind the first atlas (depth peeling), without colour.
//
// The first atlas is bound in place of the prepass's empty group 1; both have the same cells, so that pixels correspond.

@group(1) @binding(0) var first_atlas: texture_depth_2d;

// Depths nearer to the first one than this share of it are the first surface, drawn again.
const SAME_SHARE: f32 = 1e-6;

@fragment
fn fragment(@builtin(position) position: vec4<f32>) -> @builtin(frag_depth) f32 {
    let first = textureLoad(first_atlas, vec2<i32>(position.xy), 0);
    if position.z >= first * (1.0 - SAME_SHARE) {
        discard;
    }
#ifdef MIDPOINT
    // Nearest to the light for the nearest second surface, so that the depth test still picks the right one.
    return 0.5 * (first + position.z);
#else
    return position.z;
#endif
}
