// What a camera sees, block by block of its picture: one workgroup per block reduces the depths of its pixels and takes
// the surface of the pixel nearest to its middle.
//
// The CPU twin of the reduction is `reduce_block` of `src/maths/light_plane/space/seen.rs`.

#import umbrage::surface::{load_depth, surface_at}
#import umbrage::types::{BlockGrid, SeenBlock}

@group(0) @binding(3) var<storage, read> grid: BlockGrid;
@group(0) @binding(4) var<storage, read_write> blocks: array<SeenBlock>;

const WORKGROUP_SIZE: u32 = 64u;
const NONE: u32 = 0xffffffffu;

// Bits of depths: those of positive numbers are in the order of the numbers.
var<workgroup> nearest: atomic<u32>;
var<workgroup> farthest: atomic<u32>;
var<workgroup> pixel_count: atomic<u32>;
// Squared distance of the chosen pixel from the middle of the block in half pixels, and its number in the block.
var<workgroup> least_distance: atomic<u32>;
var<workgroup> chosen: atomic<u32>;

struct Pixel {
    place: vec2<u32>,
    depth_ndc: f32,
    distance: u32,
}

// First pixel of a block; the next block's is the end of this one.
fn border(index: vec2<u32>) -> vec2<u32> {
    return index * grid.picture_size / grid.block_count;
}

fn pixel_of(first: vec2<u32>, end: vec2<u32>, number: u32) -> Pixel {
    var pixel: Pixel;
    let width = end.x - first.x;
    pixel.place = first + vec2<u32>(number % width, number / width);
    pixel.depth_ndc = load_depth(vec2<i32>(grid.origin + pixel.place));
    let off = vec2<i32>(2u * pixel.place + 1u) - vec2<i32>(first + end);
    pixel.distance = u32(off.x * off.x + off.y * off.y);
    return pixel;
}

@compute @workgroup_size(64)
fn see_blocks(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(local_invocation_index) invocation: u32,
) {
    let first = border(workgroup.xy);
    let end = border(workgroup.xy + 1u);
    let total = (end.x - first.x) * (end.y - first.y);
    if invocation == 0u {
        atomicStore(&nearest, 0u);
        atomicStore(&farthest, NONE);
        atomicStore(&pixel_count, 0u);
        atomicStore(&least_distance, NONE);
        atomicStore(&chosen, NONE);
    }
    workgroupBarrier();
    for (var number = invocation; number < total; number += WORKGROUP_SIZE) {
        let pixel = pixel_of(first, end, number);
        if pixel.depth_ndc > 0.0 {
            let bits = bitcast<u32>(pixel.depth_ndc);
            atomicMax(&nearest, bits);
            atomicMin(&farthest, bits);
            atomicAdd(&pixel_count, 1u);
            atomicMin(&least_distance, pixel.distance);
        }
    }
    workgroupBarrier();
    for (var number = invocation; number < total; number += WORKGROUP_SIZE) {
        let pixel = pixel_of(first, end, number);
        if pixel.depth_ndc > 0.0 && pixel.distance == atomicLoad(&least_distance) {
            atomicMin(&chosen, number);
        }
    }
    workgroupBarrier();
    if invocation == 0u {
        blocks[workgroup.y * grid.block_count.x + workgroup.x] = seen_block(first, end);
    }
}

fn seen_block(first: vec2<u32>, end: vec2<u32>) -> SeenBlock {
    var block: SeenBlock;
    let number = atomicLoad(&chosen);
    if number == NONE {
        return block;
    }
    let pixel = pixel_of(first, end, number);
    // No normal where the prepass has none: such a block stands for no film, but it is covered.
    let surface = surface_at(vec2<f32>(grid.origin + pixel.place) + 0.5, pixel.depth_ndc, vec3<f32>(0.0));
    block.position = surface.position;
    block.normal = surface.normal;
    block.nearest_ndc = bitcast<f32>(atomicLoad(&nearest));
    block.farthest_ndc = bitcast<f32>(atomicLoad(&farthest));
    block.pixel = pixel.place;
    block.pixel_count = atomicLoad(&pixel_count);
    return block;
}
