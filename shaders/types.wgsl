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
    padding: f32,
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
    padding: u32,
}
