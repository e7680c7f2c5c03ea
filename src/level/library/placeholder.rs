//! What stands in for a model whose file is missing or broken.

use bevy_math::Vec3;

use crate::level::meshes::{MeshData, Rgb};

/// Stripes of the box.
const STRIPES: [Rgb; 2] = [[0.9, 0.02, 0.75], [0.02, 0.02, 0.02]];
/// How many.
const COUNT: u32 = 6;

/// A box of side 1 that stands on the origin, in magenta and black stripes that nothing else has.
pub fn striped_box() -> MeshData {
    let mut mesh = MeshData::default();
    let height = 1.0 / COUNT as f32;
    for stripe in 0..COUNT {
        let middle = Vec3::Y * (stripe as f32 + 0.5) * height;
        mesh.push_box(middle, Vec3::new(1.0, height, 1.0), STRIPES[stripe as usize % 2]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_stands_on_the_ground_and_has_side_one() {
        let (min, max) = striped_box().bounds().unwrap();
        assert!((min - Vec3::new(-0.5, 0.0, -0.5)).length() < 1e-6 && (max - Vec3::new(0.5, 1.0, 0.5)).length() < 1e-6);
    }
}
