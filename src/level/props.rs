//! Meshes of made things: fences, huts, street furniture, cars, the lattice tower. Feet at the origin, +y up.

use bevy_math::{Quat, Vec3};

use super::meshes::{MeshData, Rgb};

const WOOD: Rgb = [0.23, 0.15, 0.085];
const STEEL: Rgb = [0.09, 0.1, 0.11];

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

/// Half the plan of [`hut`], roof excluded.
pub const HUT_HALF: (f32, f32) = (3.0, 2.4);

/// A log cabin; its door looks along +z.
pub fn hut() -> MeshData {
    let mut mesh = MeshData::default();
    let (half_x, half_z) = HUT_HALF;
    let dark = [0.14, 0.085, 0.05];
    // A stone foot that reaches into the slope.
    mesh.push_box(
        Vec3::Y * -0.3,
        Vec3::new(2.0 * half_x + 0.3, 1.2, 2.0 * half_z + 0.3),
        [0.22, 0.21, 0.19],
    );
    mesh.push_box(
        Vec3::Y * 1.6,
        Vec3::new(2.0 * half_x - 0.1, 2.7, 2.0 * half_z - 0.1),
        dark,
    );
    for i in 0..9 {
        let y = 0.45 + 0.29 * i as f32;
        for side in [-1.0, 1.0] {
            let logs = [
                ([0.0, 0.0, half_z], Vec3::X * (half_x + 0.25)),
                ([half_x, 0.145, 0.0], Vec3::Z * (half_z + 0.25)),
            ];
            for (at, along) in logs {
                let middle = Vec3::from(at) * Vec3::new(side, 1.0, side) + Vec3::Y * y;
                mesh.push_round((middle - along, 0.155), (middle + along, 0.155), 8, (WOOD, WOOD));
            }
        }
    }
    let roof = [0.16, 0.07, 0.05];
    mesh.push_gable(
        Vec3::Y * 3.05,
        Vec3::new(2.0 * half_x + 1.2, 2.1, 2.0 * half_z + 1.5),
        roof,
        dark,
    );
    mesh.push_box(Vec3::new(1.6, 4.6, -0.9), Vec3::new(0.7, 2.6, 0.7), [0.25, 0.23, 0.21]);
    mesh.push_box(
        Vec3::new(0.0, 1.35, half_z + 0.1),
        Vec3::new(1.0, 2.1, 0.25),
        [0.30, 0.20, 0.11],
    );
    for x in [-1.9, 1.9] {
        mesh.push_box(
            Vec3::new(x, 1.75, half_z + 0.1),
            Vec3::new(0.9, 0.8, 0.22),
            [0.05, 0.06, 0.075],
        );
        mesh.push_box(
            Vec3::new(x, 1.28, half_z + 0.16),
            Vec3::new(1.15, 0.09, 0.3),
            [0.30, 0.20, 0.11],
        );
    }
    mesh
}

/// A street lamp of 6.5 m whose arm reaches along +x.
pub fn lamp() -> MeshData {
    let mut mesh = MeshData::default();
    let steel = (STEEL, STEEL);
    mesh.push_round((Vec3::Y * -0.3, 0.13), (Vec3::Y * 0.9, 0.1), 8, steel);
    mesh.push_round((Vec3::Y * 0.5, 0.07), (Vec3::Y * 6.3, 0.045), 8, steel);
    mesh.push_round((Vec3::Y * 6.2, 0.035), (Vec3::new(1.5, 6.5, 0.0), 0.03), 6, steel);
    mesh.push_box(
        Vec3::new(1.65, 6.47, 0.0),
        Vec3::new(0.75, 0.12, 0.26),
        [0.4, 0.4, 0.38],
    );
    mesh
}

/// A slatted bench, 1.8 m along x, looking along +z.
pub fn bench() -> MeshData {
    let mut mesh = MeshData::default();
    for x in [-0.7, 0.7] {
        mesh.push_box(Vec3::new(x, 0.2, 0.0), Vec3::new(0.06, 0.5, 0.42), STEEL);
        mesh.push_bar(Vec3::new(x, 0.3, -0.2), Vec3::new(x, 0.95, -0.33), 0.05, STEEL);
    }
    for i in 0..4 {
        mesh.push_box(
            Vec3::new(0.0, 0.47, -0.165 + 0.11 * i as f32),
            Vec3::new(1.8, 0.035, 0.085),
            WOOD,
        );
    }
    for y in [0.65, 0.82] {
        let lean = Quat::from_rotation_x(-0.2);
        mesh.push_oriented_box(
            Vec3::new(0.0, y, -0.23 - 0.2 * (y - 0.55)),
            Vec3::new(1.8, 0.11, 0.03),
            lean,
            WOOD,
        );
    }
    mesh
}

/// Paints of [`car`].
pub const CAR_PAINTS: [Rgb; 6] = [
    [0.42, 0.03, 0.03],
    [0.04, 0.09, 0.3],
    [0.5, 0.5, 0.48],
    [0.05, 0.05, 0.055],
    [0.62, 0.62, 0.6],
    [0.05, 0.2, 0.12],
];

/// A parked car, 4.3 m along z.
pub fn car(paint: Rgb) -> MeshData {
    let mut mesh = MeshData::default();
    mesh.push_box(Vec3::new(0.0, 0.55, 0.0), Vec3::new(1.72, 0.5, 4.3), paint);
    let glass = [0.03, 0.04, 0.05];
    prism(
        &mut mesh,
        [(0.78, -1.95, 1.15), (0.62, -1.35, 0.35)],
        [0.75, 1.32],
        glass,
    );
    prism(&mut mesh, [(0.64, -1.4, 0.4), (0.6, -1.3, 0.3)], [1.28, 1.4], paint);
    for (x, z) in [(-0.78, -1.35), (0.78, -1.35), (-0.78, 1.35), (0.78, 1.35)] {
        let (inner, outer) = (Vec3::new(x * 0.8, 0.32, z), Vec3::new(x * 1.13, 0.32, z));
        let rubber = ([0.02; 3], [0.02; 3]);
        mesh.push_round((inner, 0.33), (outer, 0.33), 10, rubber);
    }
    for x in [-0.6, 0.6] {
        mesh.push_box(Vec3::new(x, 0.6, 2.13), Vec3::new(0.35, 0.16, 0.1), [0.7, 0.68, 0.6]);
        mesh.push_box(Vec3::new(x, 0.62, -2.13), Vec3::new(0.3, 0.14, 0.1), [0.35, 0.02, 0.02]);
    }
    mesh
}

/// A block with a smaller top: plans are (half width, smallest z, largest z) at two heights.
fn prism(mesh: &mut MeshData, plans: [(f32, f32, f32); 2], heights: [f32; 2], color: Rgb) {
    let ring = |k: usize| {
        let ((x, low, high), y) = (plans[k], heights[k]);
        [
            Vec3::new(-x, y, low),
            Vec3::new(x, y, low),
            Vec3::new(x, y, high),
            Vec3::new(-x, y, high),
        ]
    };
    let (a, b) = (ring(0), ring(1));
    for i in 0..4 {
        let j = (i + 1) % 4;
        mesh.push_quad([a[j], a[i], b[i], b[j]], color);
    }
    mesh.push_quad(a, color);
    mesh.push_quad([b[3], b[2], b[1], b[0]], color);
}

/// A tower of thin struts: four legs that close in on a mast, braced crosswise, with two platforms. The foot is a
/// square of `0.2 * height`.
pub fn lattice_tower(height: f32) -> MeshData {
    let mut mesh = MeshData::default();
    let paint = [0.28, 0.12, 0.07];
    let crown = height * 0.88;
    let storeys = 22;
    // Storeys shorten upwards; legs close in faster below.
    let level = |i: u32| {
        let t = i as f32 / storeys as f32;
        let y = crown * (1.6 * t - 0.6 * t * t);
        let narrow = 1.0 - y / crown;
        (y, height * (0.012 + 0.088 * narrow.powf(1.7)))
    };
    let corner = |i: u32, k: u32| {
        let (y, half) = level(i);
        let (x, z) = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)][k as usize % 4];
        Vec3::new(half * x, y, half * z)
    };
    for k in 0..4 {
        let foot = corner(0, k);
        mesh.push_box(foot.with_y(0.3), Vec3::new(3.2, 1.6, 3.2), [0.3, 0.29, 0.27]);
    }
    for i in 0..storeys {
        let thin = 1.0 - 0.6 * i as f32 / storeys as f32;
        for k in 0..4 {
            let (a, b, c, d) = (corner(i, k), corner(i, k + 1), corner(i + 1, k), corner(i + 1, k + 1));
            mesh.push_bar(a, c, 0.55 * thin, paint);
            mesh.push_bar(c, d, 0.24 * thin, paint);
            mesh.push_bar(a, d, 0.18 * thin, paint);
            mesh.push_bar(b, c, 0.18 * thin, paint);
        }
    }
    for i in [6, 13] {
        let (y, half) = level(i);
        let deck = half + 1.2;
        mesh.push_box(Vec3::Y * (y + 0.4), Vec3::new(2.0 * deck, 0.3, 2.0 * deck), paint);
        railing_ring(&mut mesh, y + 0.55, deck - 0.15, paint);
    }
    let (y, half) = level(storeys);
    mesh.push_box(
        Vec3::Y * (y + 0.2),
        Vec3::new(2.0 * half + 0.8, 0.3, 2.0 * half + 0.8),
        paint,
    );
    mesh.push_round((Vec3::Y * y, 0.22), (Vec3::Y * height, 0.05), 6, (paint, paint));
    mesh
}

/// Thin railings around a square deck.
fn railing_ring(mesh: &mut MeshData, y: f32, half: f32, color: Rgb) {
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(x * half, y, z * half));
    for k in 0..4 {
        push_railing(mesh, corners[k], corners[(k + 1) % 4], 1.1, color);
    }
}

/// A railing of thin bars between two points of the same height: two long bars, uprights about every 0.5 m but none
/// at the end, where the next railing begins.
pub fn push_railing(mesh: &mut MeshData, from: Vec3, to: Vec3, height: f32, color: Rgb) {
    let uprights = ((to - from).length() / 0.5).ceil().max(1.0) as u32;
    for i in 0..uprights {
        let foot = from + (to - from) * (i as f32 / uprights as f32);
        mesh.push_bar(foot - Vec3::Y * 0.05, foot + Vec3::Y * height, 0.025, color);
    }
    // Short of the corners, so that the bars of two railings do not share faces.
    let trim = (to - from).normalize_or_zero() * 0.021;
    let (from, to) = (from + trim, to - trim);
    for y in [0.5 * height, height] {
        mesh.push_bar(from + Vec3::Y * y, to + Vec3::Y * y, 0.04, color);
    }
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
            ("hut", hut()),
            ("lamp", lamp()),
            ("bench", bench()),
            ("car", car(CAR_PAINTS[0])),
            ("tower", lattice_tower(120.0)),
            ("wire", wire(Vec3::Y, Vec3::new(20.0, 1.0, 3.0), 0.5, 0.02)),
        ] {
            assert_solid(&mesh, name);
        }
    }

    #[test]
    fn the_tower_has_its_height() {
        let (_, max) = lattice_tower(118.0).bounds().unwrap();
        assert!((max.y - 118.0).abs() < 0.1, "{}", max.y);
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
