//! Meshes of buildings: a dark glazed core, floor bands and piers that stand out of it in relief, a parapet or a
//! gabled roof, and on some balconies and roof railings of thin bars.

use bevy_math::Vec3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    meshes::{MeshData, Rgb},
    props::push_railing,
};

/// Height of a floor in metres.
pub const FLOOR: f32 = 3.2;
/// How far buildings reach below their foot.
const BASE: f32 = 0.1;

/// A building; equal values build equal meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Building {
    /// Extent along x in decimetres.
    pub width_dm: u16,
    /// Extent along z in decimetres.
    pub depth_dm: u16,
    /// Floors above ground.
    pub floors: u16,
    /// How it looks.
    pub style: Style,
    /// Index into [`PAINTS`], modulo its length.
    pub paint: u8,
    /// Seed of details.
    pub detail: u16,
}

/// How a façade is divided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Style {
    /// Bands and piers: rows of windows.
    Grid,
    /// Bands only: strips of glass.
    Strips,
    /// Piers only: upright lines.
    Piers,
    /// Bands, piers and balconies with railings.
    Balconies,
    /// A gabled roof over rows of windows.
    House,
}

/// Wall colours.
pub const PAINTS: [Rgb; 8] = [
    [0.46, 0.42, 0.35],
    [0.33, 0.16, 0.11],
    [0.42, 0.41, 0.40],
    [0.52, 0.46, 0.33],
    [0.25, 0.27, 0.29],
    [0.50, 0.34, 0.22],
    [0.36, 0.42, 0.40],
    [0.58, 0.56, 0.52],
];

impl Building {
    /// Extent along x and z in metres.
    pub fn plan(&self) -> (f32, f32) {
        (f32::from(self.width_dm) * 0.1, f32::from(self.depth_dm) * 0.1)
    }

    /// Height of the walls in metres; parapets and roofs come on top.
    pub fn wall_height(&self) -> f32 {
        f32::from(self.floors) * FLOOR + 0.8
    }
}

/// Builds the mesh; the foot is the middle of the plan.
pub fn build(building: &Building) -> MeshData {
    let mut mesh = MeshData::default();
    let mut rng = ChaCha8Rng::seed_from_u64(u64::from(building.detail));
    let wall = PAINTS[usize::from(building.paint) % PAINTS.len()];
    let (width, depth) = building.plan();
    let height = building.wall_height();
    // The outline of the plan is that of the piers; the core stands back.
    let relief = 0.35;
    let core = Vec3::new(width - 2.0 * relief, height + BASE, depth - 2.0 * relief);
    mesh.push_box(Vec3::Y * (0.5 * (height - BASE)), core, [0.045, 0.06, 0.075]);
    if !matches!(building.style, Style::Piers) {
        bands(&mut mesh, building, wall);
    }
    if !matches!(building.style, Style::Strips) {
        piers(&mut mesh, building, wall.map(|c| c * 0.93));
    }
    if matches!(building.style, Style::House) {
        let tiles = [[0.25, 0.09, 0.05], [0.12, 0.11, 0.11], [0.20, 0.12, 0.08]][rng.random_range(0..3)];
        house_roof(&mut mesh, building, tiles, wall);
    } else {
        parapet(&mut mesh, building, wall);
        roof_things(&mut mesh, building, &mut rng);
    }
    if matches!(building.style, Style::Balconies) {
        balconies(&mut mesh, building);
    }
    mesh
}

/// One box per floor, from sill to lintel of the floor below, and the ground floor's plinth.
fn bands(mesh: &mut MeshData, building: &Building, wall: Rgb) {
    let (width, depth) = building.plan();
    let out = 0.15;
    let plan = |height: f32| Vec3::new(width - 2.0 * out, height, depth - 2.0 * out);
    mesh.push_box(Vec3::Y * 0.35, plan(0.9), wall.map(|c| c * 0.7));
    let glass = if matches!(building.style, Style::House | Style::Balconies) {
        1.5
    } else {
        1.9
    };
    for floor in 1..=building.floors {
        let top_of_glass = 0.8 + f32::from(floor - 1) * FLOOR + glass;
        let band = FLOOR - glass;
        mesh.push_box(Vec3::Y * (top_of_glass + 0.5 * band), plan(band - 0.02), wall);
    }
}

/// Upright bars around the façade, corners included.
fn piers(mesh: &mut MeshData, building: &Building, wall: Rgb) {
    let (width, depth) = building.plan();
    let (wide, spacing): (f32, f32) = match building.style {
        Style::Piers => (0.35, 1.6),
        Style::House => (1.5, 3.0),
        _ => (0.8, 2.9),
    };
    let height = building.wall_height() + 0.02;
    let thick = 0.5;
    // Corner posts, then whole bays between them along each side.
    let corner = wide.max(thick);
    for (x, z) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
        let middle = Vec3::new(
            x * 0.5 * (width - corner),
            0.5 * (height - BASE),
            z * 0.5 * (depth - corner),
        );
        mesh.push_box(middle, Vec3::new(corner, height + BASE, corner), wall);
    }
    for (along, across, axis) in [(width, depth, Vec3::X), (depth, width, Vec3::Z)] {
        let bays = ((along - corner) / spacing).round().max(1.0);
        let other = Vec3::new(axis.z, 0.0, axis.x);
        for i in 1..bays as u32 {
            let at = (i as f32 / bays - 0.5) * (along - corner);
            for side in [-1.0, 1.0] {
                let middle = axis * at
                    + other * (side * 0.5 * (across - thick - 0.06))
                    + Vec3::Y * (0.5 * (height - BASE) - 0.02);
                let size = axis * wide + other * thick + Vec3::Y * (height + BASE - 0.04);
                mesh.push_box(middle, size, wall);
            }
        }
    }
}

/// Four low walls around a flat roof.
fn parapet(mesh: &mut MeshData, building: &Building, wall: Rgb) {
    let (width, depth) = building.plan();
    let (low, high, thick) = (building.wall_height() - 0.3, building.wall_height() + 0.9, 0.4);
    let (y, size_y) = (0.5 * (low + high), high - low);
    let (out_x, out_z) = (0.5 * (width + 0.1), 0.5 * (depth + 0.1));
    for side in [-1.0, 1.0] {
        let middle = Vec3::new(0.0, y, side * (out_z - 0.5 * thick));
        mesh.push_box(middle, Vec3::new(2.0 * out_x, size_y, thick), wall);
        // Butted against the long ones: they reach a little into them and are a little lower.
        let middle = Vec3::new(side * (out_x - 0.5 * thick - 0.01), y - 0.01, 0.0);
        mesh.push_box(
            middle,
            Vec3::new(thick, size_y - 0.04, 2.0 * (out_z - thick) + 0.2),
            wall,
        );
    }
}

/// Lift houses, machines, railings and masts.
fn roof_things(mesh: &mut MeshData, building: &Building, rng: &mut ChaCha8Rng) {
    let (width, depth) = building.plan();
    let roof = building.wall_height();
    let grey = [0.3, 0.3, 0.31];
    let mut place = |reach: f32| {
        let (x, z) = (0.5 * width - 1.2 - reach, 0.5 * depth - 1.2 - reach);
        Vec3::new(
            rng.random_range(-1.0..1.0) * x.max(0.0),
            roof,
            rng.random_range(-1.0..1.0) * z.max(0.0),
        )
    };
    let lift = place(2.0);
    mesh.push_box(lift + Vec3::Y * 1.3, Vec3::new(3.6, 3.0, 3.2), [0.36, 0.35, 0.33]);
    for size in [1.4, 1.1, 1.7] {
        let at = place(0.5 * size);
        if (at - lift).abs().max_element() > 3.2 {
            mesh.push_box(at + Vec3::Y * 0.5, Vec3::new(size, 1.3, size), grey);
        }
    }
    if building.detail.is_multiple_of(3) {
        let steel = [0.2, 0.2, 0.21];
        let (x, z) = (0.5 * width - 0.8, 0.5 * depth - 0.8);
        let corners = [(x, z), (-x, z), (-x, -z), (x, -z)].map(|(x, z)| Vec3::new(x, roof, z));
        for k in 0..4 {
            push_railing(mesh, corners[k], corners[(k + 1) % 4], 1.9, steel);
        }
    }
    if building.floors > 14 {
        mesh.push_round(
            (lift + Vec3::Y * 2.0, 0.12),
            (lift + Vec3::Y * 11.0, 0.03),
            6,
            (grey, grey),
        );
    }
}

/// A gabled roof along the longer side, and a chimney.
fn house_roof(mesh: &mut MeshData, building: &Building, tiles: Rgb, wall: Rgb) {
    let (width, depth) = building.plan();
    let (long, short) = (width.max(depth), width.min(depth));
    let foot = building.wall_height() - 0.05;
    let rise = 0.38 * short;
    let mut roof = MeshData::default();
    roof.push_gable(Vec3::Y * foot, Vec3::new(long + 0.8, rise, short + 1.0), tiles, wall);
    let brick = [0.25, 0.1, 0.07];
    roof.push_box(
        Vec3::new(0.28 * long, foot + 0.8 * rise, 0.12 * short),
        Vec3::new(0.7, rise + 1.0, 0.7),
        brick,
    );
    let turn = if width >= depth {
        0.0
    } else {
        std::f32::consts::FRAC_PI_2
    };
    mesh.append(&roof, bevy_math::Affine3A::from_rotation_y(turn));
}

/// Slabs with railings on the sides that look along z.
fn balconies(mesh: &mut MeshData, building: &Building) {
    let (width, depth) = building.plan();
    let (wide, deep) = (3.2, 1.3);
    let columns = ((width - 3.0) / 6.0).floor().max(1.0) as u32;
    for side in [-1.0, 1.0] {
        let face = side * (0.5 * depth - 0.3);
        for column in 0..columns {
            let x = ((column as f32 + 0.5) / columns as f32 - 0.5) * (width - 2.0);
            for floor in 1..building.floors {
                let y = 0.5 + f32::from(floor) * FLOOR;
                let edge = face + side * (deep + 0.2);
                let slab = Vec3::new(wide, 0.16, deep + 0.3);
                mesh.push_box(
                    Vec3::new(x, y, face + side * 0.5 * (deep + 0.3)),
                    slab,
                    [0.4, 0.39, 0.37],
                );
                let steel = [0.08, 0.085, 0.09];
                let (left, right) = (x - 0.5 * wide + 0.06, x + 0.5 * wide - 0.06);
                let (near, far) = (face + side * 0.35, edge);
                let y = y + 0.08;
                push_railing(mesh, Vec3::new(left, y, near), Vec3::new(left, y, far), 1.0, steel);
                push_railing(mesh, Vec3::new(left, y, far), Vec3::new(right, y, far), 1.0, steel);
                push_railing(mesh, Vec3::new(right, y, far), Vec3::new(right, y, near), 1.0, steel);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::meshes::tests::assert_solid;

    #[test]
    fn every_style_is_solid_and_has_its_size() {
        for style in [Style::Grid, Style::Strips, Style::Piers, Style::Balconies, Style::House] {
            for (width_dm, depth_dm, floors) in [(140, 120, 5), (200, 260, 18), (90, 101, 2)] {
                let building = Building {
                    width_dm,
                    depth_dm,
                    floors,
                    style,
                    paint: 3,
                    detail: 9,
                };
                let mesh = build(&building);
                let name = format!("{building:?}");
                assert_solid(&mesh, &name);
                let (min, max) = mesh.bounds().unwrap();
                assert!(min.y < 0.0 && max.y > building.wall_height(), "{name}: {min} {max}");
                // Eaves and balconies reach over the plan, walls do not.
                let over = (max.x - 0.5 * building.plan().0).max(max.z - 0.5 * building.plan().1);
                assert!(over < 1.6, "{name}: {over}");
            }
        }
    }

    #[test]
    fn no_two_faces_lie_on_each_other() {
        for style in [Style::Grid, Style::Strips, Style::Piers, Style::Balconies, Style::House] {
            let building = Building {
                width_dm: 146,
                depth_dm: 121,
                floors: 4,
                style,
                paint: 1,
                detail: 3,
            };
            let mesh = build(&building);
            let pairs = overlapping_faces(&mesh);
            assert!(
                pairs.is_empty(),
                "{style:?}: {} pairs, such as {:?}",
                pairs.len(),
                &pairs[..pairs.len().min(4)]
            );
        }
    }

    /// Pairs of axis-aligned, equally facing quadrilaterals in one plane whose rectangles overlap, but for undersides
    /// below ground.
    fn overlapping_faces(mesh: &MeshData) -> Vec<[Vec3; 4]> {
        let mut faces: Vec<(usize, f32, Vec3, Vec3)> = Vec::new();
        for quad in mesh
            .indices
            .chunks(6)
            .filter(|quad| quad.len() == 6 && quad[0] == quad[3] && quad[2] == quad[4])
        {
            let corners = [0, 1, 2, 5].map(|k| mesh.positions[quad[k] as usize]);
            let normal = mesh.normals[quad[0] as usize];
            let axis = (0..3).find(|k| normal[*k].abs() > 0.9999);
            let (min, max) = corners
                .iter()
                .fold((corners[0], corners[0]), |(a, b), p| (a.min(*p), b.max(*p)));
            let below = max.y < 0.0;
            if let (Some(axis), false) = (axis, below) {
                let side = if normal[axis] > 0.0 { axis } else { axis + 3 };
                faces.push((side, min[axis], min, max));
            }
        }
        let mut pairs = Vec::new();
        for i in 0..faces.len() {
            for j in i + 1..faces.len() {
                let (a, b) = (faces[i], faces[j]);
                let overlap = (a.3.min(b.3) - a.2.max(b.2)).to_array();
                let flat = a.0 % 3;
                let same_plane = a.0 == b.0 && (a.1 - b.1).abs() < 1e-4;
                if same_plane && (0..3).filter(|k| *k != flat).all(|k| overlap[k] > 1e-3) {
                    pairs.push([a.2, a.3, b.2, b.3]);
                }
            }
        }
        pairs
    }
}
