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
    /// Unused.
    pub padding: f32,
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
    /// Unused.
    pub padding: u32,
}
