//! Filter kernels of one size in the world, whatever map they are read from (Stingl, section 3.6.1).
//!
//! A kernel of constant size in texture coordinates is as wide in the world as the map is: penumbrae jump at the border of
//! two partitions. Stingl's equation 3.9 divides by the width of the focused map. For a warped map that is not enough,
//! since its texels grow along the map; here the gradient of the texture coordinates at the receiver is used instead,
//! which is the same for unwarped maps.
//!
//! Corrections to equation 3.9: its factor of 2 belongs to clip space (−1..=1), so a kernel that uses its result as a
//! radius in texture coordinates has the world-space *radius* 2 r_l; here radii are radii. And it leaves out m = 1, where
//! the atlas is one map and l_sc = 1.

use bevy_math::{DMat2, DMat4, DVec2, DVec3, UVec2};

use super::footprint::texel_footprint;

/// s_i of Stingl, equation 3.9, as a radius: the radius in texture coordinates of the atlas for a radius in metres.
///
/// `map_extent` is max − min of the focused, unwarped map in metres of the light plane (after focusing all of the map is
/// used), `cell_share` l_sc, the map's share of the atlas in each direction: ½ for 2 × 2 cells. Not finite for maps
/// without extent.
pub fn uniform_kernel_radius(world_radius: f64, map_extent: DVec2, cell_share: DVec2) -> DVec2 {
    world_radius * cell_share / map_extent
}

/// The columns of the matrix take a step in the light plane, in metres along two perpendicular axes, to texture coordinates
/// of the atlas (v down): multiply it with points of a unit disc and the world-space radius to get the taps of a filter.
///
/// In a warped map the disc becomes a sheared ellipse. `plane` are those two axes, unit vectors across the light: light
/// space's x and y. `cell_share` is the map's share of the atlas in each direction. `None` behind the projection centre and
/// for singular matrices.
pub fn kernel_transform(clip_from_world: &DMat4, cell_share: DVec2, point: DVec3, plane: [DVec3; 2]) -> Option<DMat2> {
    // One texel per map: steps of a texel are steps of a texture coordinate, with v up.
    let step = texel_footprint(clip_from_world, UVec2::ONE, point)?;
    let plane_from_map =
        DMat2::from_cols_array_2d(&[step.across, -step.along].map(|step| plane.map(|axis| axis.dot(step))));
    let map_from_plane = plane_from_map.inverse();
    let kernel = DMat2::from_diagonal(cell_share) * map_from_plane;
    kernel.is_finite().then_some(kernel)
}

/// Half the size of the box around a kernel of a world-space radius, in texture coordinates of the atlas, at a world-space
/// point: what a filter must keep free at a map's border, and its kernel where a box will do.
///
/// Each is the radius times the length of the coordinate's gradient in the light plane; for an unwarped map it is
/// [`uniform_kernel_radius`]. `None` where [`kernel_transform`] is.
pub fn kernel_radius(clip_from_world: &DMat4, cell_share: DVec2, point: DVec3, world_radius: f64) -> Option<DVec2> {
    let step = texel_footprint(clip_from_world, UVec2::ONE, point)?;
    // The steps' dual basis: a gradient is as long as the other step, divided by the area of both.
    let gradients = DVec2::new(step.along.length(), step.across.length()) / step.area();
    let radius = cell_share * gradients * world_radius;
    radius.is_finite().then_some(radius)
}
