// Structures shared by the passes; `src/render/gpu_types.rs` has their twins in the same order, and
// `tests/shaders.rs` compares every offset.
#define_import_path umbrage::types

// One map: the light view that draws it and reads it.
struct LightView {
    // World to light clip space, reverse z, perspective along the warp axis only.
    clip_from_world: mat4x4<f32>,
    // Rectangle of the atlas in texels: x, y, width, height.
    atlas_rect: vec4<f32>,
    // Half-open interval of view depth that this map is meant for, in metres.
    depth_range: vec2<f32>,
    // Length of view depth before the end over which the next map takes over, in metres; for SELECTION_DEPTH.
    seam_depth: f32,
    // 1: it serves only points that lie in no other map; no seam leads into it.
    stands_in: u32,
}

// Everything that the apply pass reads besides textures.
struct ApplyParameters {
    light_views: array<LightView, 16>,
    // Unit vector towards the light, world space.
    direction_to_light: vec3<f32>,
    light_view_count: u32,
    // View depth from which everything is lit, in metres.
    shadow_distance: f32,
    // SELECTION_*
    selection: u32,
    // FILTER_*
    filter_kind: u32,
    // BIAS_*
    bias_kind: u32,
    // Metres for BIAS_CONSTANT and BIAS_RECEIVER, else a factor.
    bias_value: f32,
    // 0..1, for the heat map.
    opacity: f32,
    // Smallest steps of depth, for BIAS_SLOPE.
    bias_units: f32,
    // Lookups on the disc of FILTER_POISSON and FILTER_PCSS.
    filter_taps: u32,
    // The largest radius of the disc across the light, metres; 0 for filters of fixed size in texels.
    filter_radius: f32,
    // Taps of the blocker search, for FILTER_PCSS.
    search_taps: u32,
    // Tangent of half the sun's angular diameter, for FILTER_PCSS.
    sun_tangent: f32,
    // Width of the blend at the borders of maps: share of their sides, or metres across the light if above 0.
    seam_share: f32,
    seam_metres: f32,
    // 1: maps are blended where they meet.
    has_seams: u32,
    // View depth at which shadows have faded out, and length of the fade before it, in metres; 0: no fade.
    fade_end: f32,
    fade_length: f32,
    // 1: there are casters that fade, in maps of their own.
    has_fading: u32,
}

// One pass of the eye-space blur: half an iteration.
struct EyeBlur {
    // Iterations of near pixels, 0 to 16.
    iterations: u32,
    // View depth up to which pixels take part in all of them, metres.
    full_depth: f32,
    // This iteration, from 0.
    iteration: u32,
    // 0: along the rows, 1: along the columns.
    axis: u32,
}

// Depths of a picture, as bits: positive numbers ascend with theirs. All zero: the picture shows only sky.
struct DepthRange {
    // Bits of the greatest NDC depth: of the nearest surface.
    nearest: atomic<u32>,
    // 2^32 - 1 less the bits of the least NDC depth above 0: of the farthest surface.
    farthest: atomic<u32>,
    // Pixels with geometry.
    pixel_count: atomic<u32>,
    padding: u32,
}

// The frame before, for the history of the shadow result.
struct HistoryFrame {
    // World to clip space of the frame before, without jitter.
    clip_from_world: mat4x4<f32>,
    // View depth of the frame before: dot product with a world-space point and 1.
    view_depth_from_world: vec4<f32>,
    // Share of the new result in the blend, 0..1.
    new_share: f32,
    // 1: the history holds the frame before.
    is_valid: u32,
    padding: vec2<f32>,
}

const SELECTION_DEPTH: u32 = 0u;
const SELECTION_BEST_RESOLUTION: u32 = 1u;
// Bevy's: the first map that ends behind the pixel, whether it contains it or not.
const SELECTION_CASCADES: u32 = 2u;
// The map with the most texels around the point.
const SELECTION_FINEST: u32 = 3u;
const FILTER_HARD: u32 = 0u;
const FILTER_PCF2: u32 = 1u;
const FILTER_POISSON: u32 = 2u;
const FILTER_PCSS: u32 = 3u;
const BIAS_NONE: u32 = 0u;
const BIAS_CONSTANT: u32 = 1u;
const BIAS_FOOTPRINT: u32 = 2u;
const BIAS_SLOPE: u32 = 3u;
const BIAS_WORLD_SLOPE: u32 = 4u;
const BIAS_RECEIVER: u32 = 5u;

// One tile of a virtual map, as the pass that applies it reads it.
struct ShadowTile {
    // As `MapTexels` in visibility.wgsl, at this tile's resolution.
    rect: vec4<f32>,
    bounds: vec4<f32>,
    // Column and row from the top left of the map, and tiles per axis; whole numbers.
    place: vec2<f32>,
    counts: vec2<f32>,
    // Index of its report.
    report: u32,
    // Changes of the shadow result up to this are none.
    tolerance: f32,
    // Index of the light view that it is a part of.
    light_view: u32,
    padding: u32,
}

// One tile of a virtual map, as the overlay shows it.
struct TileMark {
    place: vec2<f32>,
    counts: vec2<f32>,
    color: vec4<f32>,
    // Index of the light view that it is a part of.
    light_view: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// What applying a tile did.
struct TileReport {
    // Pixels whose shadow result changed.
    changed: atomic<u32>,
    // Pixels inside the tile.
    inside: atomic<u32>,
    // First and last pixel inside the tile.
    min_x: atomic<u32>,
    min_y: atomic<u32>,
    max_x: atomic<u32>,
    max_y: atomic<u32>,
}

// One bin of the caster phase: instances that share mesh, material and pipeline.
struct CasterBin {
    // First instance in the mesh uniform buffer.
    first_instance: u32,
    instance_count: u32,
    first_index: u32,
    index_count: u32,
    base_vertex: u32,
    // 1: never culled (skinned, unbounded).
    unbounded: u32,
    padding_a: u32,
    padding_b: u32,
    // Local bounds of the mesh: center and half extents, metres.
    center_local: vec4<f32>,
    half_extents_local: vec4<f32>,
}

// One indirect draw, as the GPU reads it.
struct DrawIndexedArguments {
    index_count: u32,
    instance_count: u32,
    first_index: u32,
    base_vertex: u32,
    first_instance: u32,
}

struct CullParameters {
    // Instances in all bins: the stride of one light view in `arguments` and `counts`.
    instance_total: u32,
    bin_count: u32,
    light_view_count: u32,
    // Counter of the first light view in `drawn`.
    first_counter: u32,
}

// What the passes of a fitted map read.
struct NeedParameters {
    // Clip space of the picture to that of the map: takes places and depths of the prepass there in one projective step.
    map_from_picture: mat4x4<f32>,
    // World to clip space of the map: the very matrix that the lookup has, so that both find a pixel in the same place.
    clip_from_world: mat4x4<f32>,
    // The row of the camera's world_from_clip that gives 1 ÷ view depth for clip-space places and depths.
    inverse_depth: vec4<f32>,
    // Pixels of the picture.
    picture_size: vec2<u32>,
    // The picture's first pixel in its target.
    picture_origin: vec2<u32>,
    // Texels of the mapping map.
    map_size: vec2<u32>,
    // n: cells of the grid.
    cells_per_axis: u32,
    // MEASURE_*
    measure: u32,
    // PICK_*
    pick: u32,
    // Factor on needs before they are rounded up to levels: 2^(- bias).
    need_scale: f32,
    // View depths of the pixels whose needs count, in metres: from the first one up to, without, the second.
    depth_range: vec2<f32>,
    // 1: neighbours are a texel of the mapping map away, 0: a pixel.
    wide_steps: u32,
    // Motion of the camera for which the needs have to hold: metres; negative: none.
    motion_step: f32,
    // By how much turning can raise a need.
    motion_turn_factor: f32,
    // Pixels per unit of tangent.
    motion_focal: f32,
    // Tangent of the angle to the corner of the picture.
    motion_corner: f32,
}

// Needs of the pixels that look into one cell of the map. Zeros are a cell without pixels.
struct NeedCell {
    // Largest log2 of the texels per axis of the whole map.
    level_u: atomic<u32>,
    level_v: atomic<u32>,
    pixels: atomic<u32>,
    // Complement of the first column and row: the largest one is that of the smallest column.
    first_column_complement: atomic<u32>,
    first_row_complement: atomic<u32>,
    // One after the last column and row.
    end_column: atomic<u32>,
    end_row: atomic<u32>,
}

// Counts over the whole picture.
struct NeedTotals {
    // Pixels by the larger level of both axes.
    pixels_by_level: array<atomic<u32>, 32>,
    // Pixels whose surface lies beside the map.
    outside: atomic<u32>,
}

// A texel of the mapping map.
struct MappingTexel {
    // Place in the map, v down.
    uv: vec2<f32>,
    // Half the box, in the map, of the pixels that the texel stands for.
    reach: vec2<f32>,
    // Bits 0 to 7: level along u, 8 to 15: along v, 16 to 17: FOUND_*
    levels: u32,
    padding: u32,
}

const MEASURE_SIDES: u32 = 0u;
const MEASURE_EXTENT: u32 = 1u;
const MEASURE_BOX: u32 = 2u;
const PICK_SMALLER: u32 = 0u;
const PICK_LARGER: u32 = 1u;
const FOUND_NOTHING: u32 = 0u;
const FOUND_OUTSIDE: u32 = 1u;
const FOUND_SURFACE: u32 = 2u;

// What the overlay of needs shows.
struct NeedOverlay {
    // Tiles whose screen rectangles are outlined.
    rectangle_count: u32,
    // log2 of the largest need that the tiles can meet.
    cap: f32,
    // 0..1
    opacity: f32,
    padding: f32,
}

// One block of a picture that was reduced to samples for light planes.
struct SeenBlock {
    // Of the surface in the chosen pixel, world space.
    position: vec3<f32>,
    // NDC depth of the nearest pixel; 0: only sky.
    nearest_ndc: f32,
    // Towards the camera; zero where unknown.
    normal: vec3<f32>,
    farthest_ndc: f32,
    // The chosen pixel, from the corner of the viewport.
    pixel: vec2<u32>,
    // Pixels that see a surface.
    pixel_count: u32,
    // NDC depth at the chosen pixel.
    plane_ndc: f32,
    // Change of NDC depth per pixel there, to the right and down.
    slope: vec2<f32>,
    // Least and greatest NDC depth of a pixel less that of the plane through the chosen one.
    offsets: vec2<f32>,
}

// How a picture is divided into blocks.
struct BlockGrid {
    // Of the viewport in the target, pixels.
    origin: vec2<u32>,
    // Of the viewport, pixels.
    picture_size: vec2<u32>,
    // Blocks across and down.
    block_count: vec2<u32>,
    padding: vec2<u32>,
}
