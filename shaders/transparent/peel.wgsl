// Lets the next nearest transparent surfaces of every pixel into a layer (depth peeling): those in front of what is opaque,
// and behind the layer before.
//
// Bevy's draw function of materials binds groups 0 to 3; the pass binds this one.

@group(4) @binding(0) var opaque_depth: texture_depth_2d;
@group(4) @binding(1) var depth_before: texture_depth_2d;

// NOTE: depths are compared as they are. Both come from the same vertices by the same arithmetic; with a tolerance, surfaces
// as near to each other as it is would be missing.
@fragment
fn fragment(@builtin(position) position: vec4<f32>) {
    let pixel = vec2<i32>(position.xy);
    if position.z < textureLoad(opaque_depth, pixel, 0) {
        discard;
    }
#ifndef FIRST
    if position.z >= textureLoad(depth_before, pixel, 0) {
        discard;
    }
#endif
}
