//! How far filters of constant width in the world reach over a map, in texels: the margins of tiles.

use bevy_math::{DMat4, DVec2, DVec3, DVec4};

/// Most texels that a metre spans anywhere in the clip box of a light view, in any direction, if the whole map has
/// `map_texels` per axis. Infinite where the projection has no inverse or a centre inside its box.
///
/// With clip = M p, a step t moves texture coordinates by J t, J = (A − ndc bᵀ) ÷ w (A the upper two rows of M, b the
/// lowest). ‖A − ndc bᵀ‖ is convex in ndc, and 1 ÷ w is affine in it, because (ndc, 1) ÷ w is an affine image of points;
/// so the product of both largest values over the corners of the box bounds ‖J‖ everywhere in it. For affine views it is
/// exact.
pub fn texels_per_metre(clip_from_world: &DMat4, map_texels: DVec2) -> f64 {
    let world_from_clip = clip_from_world.inverse();
    let row = |index: usize| clip_from_world.row(index).truncate();
    let (mut largest_step, mut largest_inverse_w) = (0.0_f64, 0.0_f64);
    for corner in 0..8_u32 {
        let bit = |position: u32| f64::from(corner >> position & 1);
        let ndc = DVec4::new(bit(0) * 2.0 - 1.0, bit(1) * 2.0 - 1.0, bit(2), 1.0);
        let inverse_w = (world_from_clip * ndc).w;
        let steps = [0, 1].map(|axis| (row(axis) - ndc[axis] * row(3)) * (0.5 * map_texels[axis]));
        if !(inverse_w > 0.0) {
            return f64::INFINITY;
        }
        largest_inverse_w = largest_inverse_w.max(inverse_w);
        largest_step = largest_step.max(largest_singular_value(steps));
    }
    largest_step * largest_inverse_w
}

/// Of a matrix with two rows.
fn largest_singular_value([first, second]: [DVec3; 2]) -> f64 {
    let (a, b, c) = (first.length_squared(), first.dot(second), second.length_squared());
    let middle = 0.5 * (a + c);
    (middle + (0.25 * (a - c).powi(2) + b * b).sqrt()).sqrt()
}
