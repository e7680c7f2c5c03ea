// Least and greatest depth of the depth prepass, over all pixels with geometry, whatever the picture's size.
//
// The CPU twin is `DepthChain` in `src/maths/near_plane.rs`. Least and greatest do not depend on the order, so the chain
// of halved pictures (Stingl 2011, appendix A.2) is one pass here: tiles in workgroups, then one atomic per tile. Depths
// stay NDC depths, which ascend towards the viewer; the CPU turns the two of them into metres.

#import umbrage::types::DepthRange

@group(0) @binding(0) var depth_prepass: texture_depth_2d;
// Zero at the beginning.
@group(0) @binding(1) var<storage, read_write> range: DepthRange;

// Pixels per side that one invocation reads; a workgroup reads 8 x 8 times as many.
const PIXELS: u32 = 4u;
const ALL_BITS: u32 = 0xffffffffu;

var<workgroup> tile_nearest: atomic<u32>;
var<workgroup> tile_farthest: atomic<u32>;
var<workgroup> tile_count: atomic<u32>;

@compute @workgroup_size(8, 8)
fn reduce_depths(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) local_index: u32,
) {
    let size = textureDimensions(depth_prepass);
    var nearest = 0u;
    var farthest = 0u;
    var count = 0u;
    for (var i = 0u; i < PIXELS * PIXELS; i += 1u) {
        let pixel = id.xy * PIXELS + vec2<u32>(i % PIXELS, i / PIXELS);
        if any(pixel >= size) {
            continue;
        }
        let depth_ndc = textureLoad(depth_prepass, vec2<i32>(pixel), 0);
        // Reverse z: nothing was drawn where it is 0.
        if depth_ndc > 0.0 {
            // Positive numbers ascend with their bits.
            let bits = bitcast<u32>(depth_ndc);
            nearest = max(nearest, bits);
            farthest = max(farthest, ALL_BITS - bits);
            count += 1u;
        }
    }
    if count > 0u {
        atomicMax(&tile_nearest, nearest);
        atomicMax(&tile_farthest, farthest);
        atomicAdd(&tile_count, count);
    }
    workgroupBarrier();
    if local_index == 0u {
        let tile_pixels = atomicLoad(&tile_count);
        if tile_pixels > 0u {
            atomicMax(&range.nearest, atomicLoad(&tile_nearest));
            atomicMax(&range.farthest, atomicLoad(&tile_farthest));
            atomicAdd(&range.pixel_count, tile_pixels);
        }
    }
}
