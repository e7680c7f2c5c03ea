//! Plain meshes of made things: a fence, wires. What is worth a closer look has a file ([`Made`](super::made)).

use bevy_math::Vec3;

use super::meshes::{MeshData, Rgb};

const WOOD: Rgb = [0.23, 0.15, 0.085];

/// A fence post of 1 m, to be scaled to its height; its foot is 0.4 below the origin.
pub fn fence_post() -> MeshData {
    let mut mesh = MeshData::default();
    mesh.push_box(Vec3::Y * 0.3, Vec3::new(0.1, 1.4, 0.1), WOOD);
    mesh
}

/// Three rails of 1 m along +x from the origin, for a fence of 1 m: to be scaled to length and height.
pub fn fence_rails() -> MeshData {
    let mut mesh = MeshData::default();
    for y in [0.3, 0.6, 0.88] {
        mesh.push_box(Vec3::new(0.5, y, 0.0), Vec3::new(1.0, 0.08, 0.035), [0.29, 0.2, 0.115]);
    }
    mesh
}

/// A wire that sags between two points, as a parabola of round bars.
pub fn wire(from: Vec3, to: Vec3, sag: f32, diameter: f32) -> MeshData {
    let mut mesh = MeshData::default();
    let parts = 16;
    let at = |i: u32| {
        let t = i as f32 / parts as f32;
        from.lerp(to, t) - Vec3::Y * (sag * 4.0 * t * (1.0 - t))
    };
    for i in 0..parts {
        let black = ([0.02; 3], [0.02; 3]);
        mesh.push_round((at(i), 0.5 * diameter), (at(i + 1), 0.5 * diameter), 6, black);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::meshes::tests::assert_solid;

    #[test]
    fn every_prop_is_solid() {
        for (name, mesh) in [
            ("post", fence_post()),
            ("rails", fence_rails()),
            ("wire", wire(Vec3::Y, Vec3::new(20.0, 1.0, 3.0), 0.5, 0.02)),
        ] {
            assert_solid(&mesh, name);
        }
    }

    #[test]
    fn a_wire_sags_in_its_middle() {
        let mesh = wire(Vec3::Y * 5.0, Vec3::new(20.0, 5.0, 0.0), 0.8, 0.02);
        let (min, max) = mesh.bounds().unwrap();
        assert!(
            (min.y - (4.2 - 0.01)).abs() < 0.005 && (max.y - 5.01).abs() < 0.005,
            "{min} {max}"
        );
    }
}
