//! Kernels of constant size in the world.
//!
//! Stingl, section 3.6.1, equation 3.9, scales a kernel by the extent of each partition's map, which makes shadows
//! equally soft over unwarped partitions, and names warped maps as the case where that fails, because their texels
//! differ. Here the kernel is a disc in the plane across the light *at the receiver*; the Jacobian of the map there
//! takes it to an ellipse of texture coordinates. For an unwarped map that is equation 3.9, s_i = r_l l_sc ÷ (max − min);
//! for a warped one it follows the texels. Two corrections to the equation: its factor of 2 belongs to clip space
//! (−1..=1), so that its s_i as a radius in texture coordinates makes r_l a diameter, and here radii are radii; and it
//! leaves out m = 1, where the atlas is one map and l_sc = 1. The map's rectangle in the atlas holds l_sc.
//!
//! The Jacobian is taken at the receiver. At a distance r along the warp axis texels differ by r ÷ (n' + y), 2 % for a
//! kernel of 10 cm and 5 m from the projection centre, and so does the kernel's shape. The depth of the receiver's
//! plane has no such error: planes stay planes.

use bevy_math::{Mat4, Vec2, Vec3};

use crate::maths::bias::{ReceiverPlane, ndc_step};

/// The image in a map of a disc across the light: its two axes in texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// Image of one axis of the disc.
    pub across: Vec2,
    /// Image of the other.
    pub along: Vec2,
}

/// The image of a disc of one metre radius around the receiver, in the plane across the light.
pub fn kernel_per_metre(clip_from_world: Mat4, plane: &ReceiverPlane, to_light: Vec3) -> Kernel {
    let ndc = ((plane.uv - 0.5) * Vec2::new(2.0, -2.0)).extend(plane.depth_ndc);
    let helper = if to_light.x.abs() > 0.7 { Vec3::Y } else { Vec3::X };
    let right = to_light.cross(helper).normalize();
    let up = to_light.cross(right);
    let to_uv = Vec2::new(0.5, -0.5);
    Kernel {
        across: ndc_step(clip_from_world, ndc, plane.w, right).truncate() * to_uv,
        along: ndc_step(clip_from_world, ndc, plane.w, up).truncate() * to_uv,
    }
}

/// A kernel for another radius.
pub fn scaled(kernel: &Kernel, factor: f32) -> Kernel {
    Kernel {
        across: kernel.across * factor,
        along: kernel.along * factor,
    }
}
