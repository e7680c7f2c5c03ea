// Collects the needs of all pixels in the cells of a grid over the map, at the full resolution of the picture.
//
// The CPU twins are `src/maths/virtual_map/mapping.rs` (need and place of a pixel) and `grid.rs` (what a cell holds).

#import umbrage::needs::{depth_at, is_in_map, is_shadowed, need_at, need_level, parameters, patch_at}
#import umbrage::types::{NeedCell, NeedTotals}

@group(0) @binding(4) var<storage, read_write> cells: array<NeedCell>;
@group(0) @binding(5) var<storage, read_write> totals: NeedTotals;
#ifdef HISTOGRAM
// 32 counters along u and 32 along v for every cell.
@group(0) @binding(6) var<storage, read_write> histograms: array<atomic<u32>>;
#endif

// Share of the map by which a pixel beside the border of a cell counts in both: the lookup, compiled into another shader,
// may round the pixel's place to the other side.
const BORDER: f32 = 1e-6;

const LAST: u32 = 0xffffffffu;

@compute @workgroup_size(8, 8, 1)
fn collect_needs(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = vec2<i32>(id.xy);
    let depth = depth_at(pixel);
    if !is_shadowed(pixel, depth) {
        return;
    }
    let found = patch_at(pixel, depth, vec2<i32>(1));
    if !is_in_map(found) {
        atomicAdd(&totals.outside, 1u);
        return;
    }
    let texels = need_at(pixel, found, vec2<i32>(1));
    let levels = vec2<u32>(need_level(texels.x), need_level(texels.y));
    atomicAdd(&totals.pixels_by_level[max(levels.x, levels.y)], 1u);
    let first = cell_of(found.uv - BORDER);
    let last = cell_of(found.uv + BORDER);
    for (var y = first.y; y <= last.y; y += 1u) {
        for (var x = first.x; x <= last.x; x += 1u) {
            add_to_cell(y * parameters.cells_per_axis + x, id.xy, levels);
        }
    }
}

fn cell_of(uv: vec2<f32>) -> vec2<u32> {
    let n = parameters.cells_per_axis;
    return min(vec2<u32>(max(uv, vec2<f32>(0.0)) * f32(n)), vec2<u32>(n - 1u));
}

// Most pixels change no maximum, and reading one is cheaper than an atomic maximum.
fn add_to_cell(index: u32, pixel: vec2<u32>, levels: vec2<u32>) {
    let cell = &cells[index];
    atomicAdd(&(*cell).pixels, 1u);
    if levels.x > atomicLoad(&(*cell).level_u) {
        atomicMax(&(*cell).level_u, levels.x);
    }
    if levels.y > atomicLoad(&(*cell).level_v) {
        atomicMax(&(*cell).level_v, levels.y);
    }
    let complement = LAST - pixel;
    if complement.x > atomicLoad(&(*cell).first_column_complement) {
        atomicMax(&(*cell).first_column_complement, complement.x);
    }
    if complement.y > atomicLoad(&(*cell).first_row_complement) {
        atomicMax(&(*cell).first_row_complement, complement.y);
    }
    if pixel.x >= atomicLoad(&(*cell).end_column) {
        atomicMax(&(*cell).end_column, pixel.x + 1u);
    }
    if pixel.y >= atomicLoad(&(*cell).end_row) {
        atomicMax(&(*cell).end_row, pixel.y + 1u);
    }
#ifdef HISTOGRAM
    atomicAdd(&histograms[index * 64u + levels.x], 1u);
    atomicAdd(&histograms[index * 64u + 32u + levels.y], 1u);
#endif
}
