//! Structures shared with shaders: one per structure in `shaders/types.wgsl`, in the same order.
//!
//! `tests/shaders.rs` compares sizes and offsets with what the shader compiler sees.

use bevy::{math::prelude::*, render::render_resource::ShaderType};

/// The largest number of light views of one camera and light.
pub const MAX_LIGHT_VIEWS: usize = 16;

/// One map: the light view that draws it and reads it.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct GpuLightView {
    /// World to light clip space, reverse z.
    pub clip_from_world: Mat4,
    /// Rectangle of the atlas in texels: x, y, width, height.
    pub atlas_rect: Vec4,
    /// Half-open interval of view depth, metres.
    pub depth_range: Vec2,
    /// Length of view depth before its end over which the next map takes over, metres.
    pub seam_depth: f32,
    /// 1: it serves only points that lie in no other map; no seam leads into it.
    pub stands_in: u32,
}

/// Everything that the apply pass reads besides textures.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct ApplyParameters {
    /// The first `light_view_count` are in use.
    pub light_views: [GpuLightView; MAX_LIGHT_VIEWS],
    /// Unit vector towards the light, world space.
    pub direction_to_light: Vec3,
    /// Number of light views.
    pub light_view_count: u32,
    /// View depth from which everything is lit, metres.
    pub shadow_distance: f32,
    /// 0 by depth, 1 the first that contains the point, 2 as Bevy's cascades, 3 the finest.
    pub selection: u32,
    /// 0 hard, 1 bilinear, 2 disc, 3 penumbra.
    pub filter_kind: u32,
    /// 0 none, 1 constant, 2 footprint, 3 slope, 4 slope in the world, 5 receiver plane.
    pub bias_kind: u32,
    /// Metres (constant, receiver plane) or factor.
    pub bias_value: f32,
    /// 0..=1, for the heat map.
    pub opacity: f32,
    /// Smallest steps of depth (slope).
    pub bias_units: f32,
    /// Lookups on the disc.
    pub filter_taps: u32,
    /// The largest radius of the disc, metres across the light; 0 for filters of fixed size in texels.
    pub filter_radius: f32,
    /// Taps of the blocker search.
    pub search_taps: u32,
    /// Tangent of half the sun's angular diameter.
    pub sun_tangent: f32,
    /// Width of the blend at the borders of maps: share of their sides.
    pub seam_share: f32,
    /// The same in metres across the light, if above 0.
    pub seam_metres: f32,
    /// 1: maps are blended where they meet.
    pub has_seams: u32,
    /// View depth at which shadows have faded out, metres.
    pub fade_end: f32,
    /// Length of the fade before it, metres; 0: none.
    pub fade_length: f32,
    /// 1: there are casters that fade, in maps of their own.
    pub has_fading: u32,
}

/// One pass of the eye-space blur.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct GpuEyeBlur {
    /// Iterations of near pixels.
    pub iterations: u32,
    /// View depth up to which pixels take part in all of them, metres.
    pub full_depth: f32,
    /// This iteration, from 0.
    pub iteration: u32,
    /// 0 along the rows, 1 along the columns.
    pub axis: u32,
}

/// Depths of a picture, as bits: positive numbers ascend with theirs. All zero: the picture shows only sky.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ShaderType)]
pub struct GpuDepthRange {
    /// Bits of the greatest NDC depth: of the nearest surface.
    pub nearest: u32,
    /// 2³² − 1 less the bits of the least NDC depth above 0: of the farthest surface.
    pub farthest: u32,
    /// Pixels with geometry.
    pub pixel_count: u32,
    /// Unused.
    pub padding: u32,
}

/// The frame before, for the history of the shadow result.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct GpuHistoryFrame {
    /// World to clip space of the frame before, without jitter.
    pub clip_from_world: Mat4,
    /// View depth of the frame before: dot product with a world-space point and 1.
    pub view_depth_from_world: Vec4,
    /// Share of the new result in the blend, 0..=1.
    pub new_share: f32,
    /// 1: the history holds the frame before.
    pub is_valid: u32,
    /// Unused.
    pub padding: Vec2,
}

/// One tile of a virtual map, as the pass that applies it reads it.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct GpuShadowTile {
    /// Texel of the texture that holds the map's first one, and texels of the whole map, at this tile's resolution.
    pub rect: Vec4,
    /// First and last texel of the map that the texture holds.
    pub bounds: Vec4,
    /// Column and row from the top left of the map.
    pub place: Vec2,
    /// Tiles per axis.
    pub counts: Vec2,
    /// Index of its report.
    pub report: u32,
    /// Changes of the shadow result up to this are none.
    pub tolerance: f32,
    /// Index of the light view that it is a part of.
    pub light_view: u32,
    /// Unused.
    pub padding: u32,
}

/// One tile of a virtual map, as the overlay shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct GpuTileMark {
    /// Column and row from the top left of the map.
    pub place: Vec2,
    /// Tiles per axis.
    pub counts: Vec2,
    /// Linear color with opacity.
    pub color: Vec4,
    /// Index of the light view that it is a part of.
    pub light_view: u32,
    /// Unused.
    pub padding_a: u32,
    /// Unused.
    pub padding_b: u32,
    /// Unused.
    pub padding_c: u32,
}

/// What applying a tile did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ShaderType)]
pub struct GpuTileReport {
    /// Pixels whose shadow result changed.
    pub changed: u32,
    /// Pixels inside the tile.
    pub inside: u32,
    /// First column of the pixels inside.
    pub min_x: u32,
    /// First row.
    pub min_y: u32,
    /// Last column.
    pub max_x: u32,
    /// Last row.
    pub max_y: u32,
}

/// One bin of the caster phase.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct CasterBin {
    /// First instance in the mesh uniform buffer.
    pub first_instance: u32,
    /// Instances in the bin.
    pub instance_count: u32,
    /// First index in the index buffer.
    pub first_index: u32,
    /// Indices of one instance.
    pub index_count: u32,
    /// Added to every index.
    pub base_vertex: u32,
    /// 1: never culled.
    pub unbounded: u32,
    /// Unused.
    pub padding_a: u32,
    /// Unused.
    pub padding_b: u32,
    /// Center of the mesh's local bounds.
    pub center_local: Vec4,
    /// Half extents of the mesh's local bounds.
    pub half_extents_local: Vec4,
}

/// One indirect draw, as the GPU reads it.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct DrawIndexedArguments {
    /// Indices of one instance.
    pub index_count: u32,
    /// Always 1.
    pub instance_count: u32,
    /// First index in the index buffer.
    pub first_index: u32,
    /// Added to every index.
    pub base_vertex: u32,
    /// The instance in the mesh uniform buffer.
    pub first_instance: u32,
}

/// Parameters of the culling dispatch.
#[derive(Clone, Copy, Debug, Default, ShaderType)]
pub struct CullParameters {
    /// Instances in all bins.
    pub instance_total: u32,
    /// Number of bins.
    pub bin_count: u32,
    /// Number of light views.
    pub light_view_count: u32,
    /// Counter of the first light view in `drawn`.
    pub first_counter: u32,
}

/// What the passes of a fitted map read.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct NeedParameters {
    /// Clip space of the picture to that of the map.
    pub map_from_picture: Mat4,
    /// World to clip space of the map.
    pub clip_from_world: Mat4,
    /// The row of the camera's `world_from_clip` that gives 1 ÷ view depth.
    pub inverse_depth: Vec4,
    /// Pixels of the picture.
    pub picture_size: UVec2,
    /// The picture's first pixel in its target.
    pub picture_origin: UVec2,
    /// Texels of the mapping map.
    pub map_size: UVec2,
    /// n: cells of the grid.
    pub cells_per_axis: u32,
    /// 0 sides, 1 extent, 2 box.
    pub measure: u32,
    /// 0 smaller, 1 larger.
    pub pick: u32,
    /// Factor on needs before they are rounded up to levels.
    pub need_scale: f32,
    /// View depths of the pixels whose needs count, metres: from the first one up to, without, the second.
    pub depth_range: Vec2,
    /// 1: neighbours are a texel of the mapping map away, 0: a pixel.
    pub wide_steps: u32,
    /// Motion of the camera for which the needs have to hold, metres; negative: none.
    pub motion_step: f32,
    /// By how much turning can raise a need.
    pub motion_turn_factor: f32,
    /// Pixels per unit of tangent.
    pub motion_focal: f32,
    /// Tangent of the angle to the corner of the picture.
    pub motion_corner: f32,
}

/// Needs of the pixels that look into one cell of the map. Zeros are a cell without pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ShaderType)]
pub struct GpuNeedCell {
    /// Largest log2 of the texels along u.
    pub level_u: u32,
    /// The same along v.
    pub level_v: u32,
    /// Pixels.
    pub pixels: u32,
    /// Complement of the first column.
    pub first_column_complement: u32,
    /// Complement of the first row.
    pub first_row_complement: u32,
    /// One after the last column.
    pub end_column: u32,
    /// One after the last row.
    pub end_row: u32,
}

/// Counts over the whole picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ShaderType)]
pub struct NeedTotals {
    /// Pixels by the larger level of both axes.
    pub pixels_by_level: [u32; 32],
    /// Pixels whose surface lies beside the map.
    pub outside: u32,
}

/// A texel of the mapping map.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct GpuMappingTexel {
    /// Place in the map, v down.
    pub uv: Vec2,
    /// Half the box, in the map, of the pixels that the texel stands for.
    pub reach: Vec2,
    /// Bits 0 to 7: level along u, 8 to 15: along v, 16 to 17: what was found.
    pub levels: u32,
    /// Unused.
    pub padding: u32,
}

/// What the overlay of needs shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct GpuNeedOverlay {
    /// Tiles whose screen rectangles are outlined.
    pub rectangle_count: u32,
    /// log2 of the largest need that the tiles can meet.
    pub cap: f32,
    /// 0..=1.
    pub opacity: f32,
    /// Unused.
    pub padding: f32,
}

/// One block of a picture that was reduced to samples for light planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, ShaderType)]
pub struct GpuSeenBlock {
    /// Of the surface in the chosen pixel, world space.
    pub position: Vec3,
    /// NDC depth of the nearest pixel; 0: only sky.
    pub nearest_ndc: f32,
    /// Towards the camera; zero where unknown.
    pub normal: Vec3,
    /// NDC depth of the farthest pixel.
    pub farthest_ndc: f32,
    /// The chosen pixel, from the corner of the viewport.
    pub pixel: UVec2,
    /// Pixels that see a surface.
    pub pixel_count: u32,
    /// NDC depth at the chosen pixel.
    pub plane_ndc: f32,
    /// Change of NDC depth per pixel there, to the right and down.
    pub slope: Vec2,
    /// Least and greatest NDC depth of a pixel less that of the plane through the chosen one.
    pub offsets: Vec2,
}

/// How a picture is divided into blocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ShaderType)]
pub struct BlockGrid {
    /// Of the viewport in the target, pixels.
    pub origin: UVec2,
    /// Of the viewport, pixels.
    pub picture_size: UVec2,
    /// Blocks across and down.
    pub block_count: UVec2,
    /// Unused.
    pub padding: UVec2,
}
