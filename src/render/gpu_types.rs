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
    /// Cell of the atlas in texels: x, y, width, height.
    pub atlas_rect: Vec4,
    /// Half-open interval of view depth, metres.
    pub depth_range: Vec2,
    /// Unused.
    pub padding: Vec2,
}

/// Everything that the apply pass reads besides textures.
#[derive(Clone, Copy, Debug, ShaderType)]
pub struct ApplyParameters {
    /// The first `light_view_count` are in use.
    pub light_views: [GpuLightView; MAX_LIGHT_VIEWS],
    /// Unit vector towards the light, world space.
    pub direction_to_light: Vec3,
    /// Number of light views.
    pub light_view_count: u32,
    /// View depth from which everything is lit, metres.
    pub shadow_distance: f32,
    /// 0 by depth, 1 best resolution, 2 as Bevy's cascades.
    pub selection: u32,
    /// 0 hard, 1 bilinear.
    pub filter_kind: u32,
    /// 0 none, 1 constant, 2 footprint.
    pub bias_kind: u32,
    /// Metres (constant) or factor (footprint).
    pub bias_value: f32,
    /// 0..=1, for the heat map.
    pub opacity: f32,
    /// Unused.
    pub padding_a: f32,
    /// Unused.
    pub padding_b: f32,
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
