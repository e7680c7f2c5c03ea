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
// Ordered bits of how far pixels are off the plane through the chosen one.
var<workgroup> lowest_offset: atomic<u32>;
var<workgroup> highest_offset: atomic<u32>;

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
        atomicStore(&lowest_offset, NONE);
        atomicStore(&highest_offset, 0u);
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
    let plane = plane_of(first, end);
    for (var number = invocation; number < total; number += WORKGROUP_SIZE) {
        let pixel = pixel_of(first, end, number);
        if pixel.depth_ndc > 0.0 {
            let step = vec2<f32>(pixel.place) - vec2<f32>(plane.place);
            let bits = ordered_bits(pixel.depth_ndc - (plane.depth_ndc + dot(plane.slope, step)));
            atomicMin(&lowest_offset, bits);
            atomicMax(&highest_offset, bits);
        }
    }
    workgroupBarrier();
    if invocation == 0u {
        blocks[workgroup.y * grid.block_count.x + workgroup.x] = seen_block(first, end, plane);
    }
}

struct Plane {
    place: vec2<u32>,
    depth_ndc: f32,
    slope: vec2<f32>,
}

// The plane through the chosen pixel.
fn plane_of(first: vec2<u32>, end: vec2<u32>) -> Plane {
    var plane: Plane;
    let number = atomicLoad(&chosen);
    if number == NONE {
        return plane;
    }
    let pixel = pixel_of(first, end, number);
    plane.place = pixel.place;
    plane.depth_ndc = pixel.depth_ndc;
    plane.slope = vec2<f32>(
        slope_along(pixel, vec2<i32>(1, 0), first, end), slope_along(pixel, vec2<i32>(0, 1), first, end));
    return plane;
}

// The smaller step to both neighbours in the block that see a surface; 0 without any.
fn slope_along(pixel: Pixel, axis: vec2<i32>, first: vec2<u32>, end: vec2<u32>) -> f32 {
    let place = vec2<i32>(pixel.place);
    let before = depth_in_block(place - axis, first, end);
    let after = depth_in_block(place + axis, first, end);
    let step_before = pixel.depth_ndc - before;
    let step_after = after - pixel.depth_ndc;
    if before > 0.0 && (after <= 0.0 || abs(step_before) <= abs(step_after)) {
        return step_before;
    }
    return select(0.0, step_after, after > 0.0);
}

fn depth_in_block(place: vec2<i32>, first: vec2<u32>, end: vec2<u32>) -> f32 {
    if any(place < vec2<i32>(first)) || any(place >= vec2<i32>(end)) {
        return 0.0;
    }
    return load_depth(vec2<i32>(grid.origin) + place);
}

// Bits in the order of the numbers, negative ones too.
fn ordered_bits(value: f32) -> u32 {
    let bits = bitcast<u32>(value);
    return select(bits | 0x80000000u, ~bits, bits >= 0x80000000u);
}

fn value_of_ordered(bits: u32) -> f32 {
    return bitcast<f32>(select(~bits, bits & 0x7fffffffu, bits >= 0x80000000u));
}

fn seen_block(first: vec2<u32>, end: vec2<u32>, plane: Plane) -> SeenBlock {
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
    block.plane_ndc = plane.depth_ndc;
    block.slope = plane.slope;
    block.offsets = vec2<f32>(
        value_of_ordered(atomicLoad(&lowest_offset)), value_of_ordered(atomicLoad(&highest_offset)));
    return block;
}
