//! Buildings of the city: which parts of the façade kit a building consists of, how they are stretched and painted.
//!
//! Buildings of equal style and bays share the meshes of their storeys and roofs ([`facade::assemble`]); the plan is
//! met by stretching them by some percent, and paint is the tint of the placement. So a few hundred meshes make all
//! buildings, and Bevy draws them in batches.

use std::ops::Range;

use bevy_math::{Vec2, Vec3};

use super::{
    meshes::MeshData,
    model::{AssetRef, Tint},
};
use crate::forge::{
    city::facade::{
        self,
        assemble::{self, Shared, SharedPart},
        bays::Detail,
    },
    mesh::Mesh,
};

pub use facade::Style;

/// How far walls stand back from the border of the plan, in metres: sills and cornices reach over them.
const SETBACK: f32 = 0.2;
/// Camera distances in metres up to which near and middle detail is drawn: there a reveal of 0.2 m and a rail of
/// 0.07 m are about as wide as three pixels and half a pixel of a picture of 720 rows.
const NEAR: f32 = 45.0;
const MIDDLE: f32 = 130.0;

/// A building; equal values look alike but for their paint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Building {
    /// Extent along x in decimetres: the front, which looks along +z.
    pub width_dm: u16,
    /// Extent along z in decimetres.
    pub depth_dm: u16,
    /// Floors above ground.
    pub floors: u16,
    /// How it looks.
    pub style: Style,
    /// No windows on the sides at +x and at −x: there a neighbour stands.
    pub blind: (bool, bool),
    /// Seed of details.
    pub detail: u16,
}

impl Building {
    /// Extent along x and z in metres.
    pub fn plan(&self) -> (f32, f32) {
        (f32::from(self.width_dm) * 0.1, f32::from(self.depth_dm) * 0.1)
    }

    /// Height of the walls in metres; parapets and roofs come on top.
    pub fn wall_height(&self) -> f32 {
        assemble::Building::wall_height(u32::from(self.floors))
    }

    /// The file of its material.
    pub fn asset() -> AssetRef {
        AssetRef {
            file: facade::FILE,
            variant: 0,
        }
    }

    /// Its parts, where each stands above the foot and how it is scaled.
    pub fn parts(&self) -> Vec<(Shared, Vec3, Vec3)> {
        let (width, depth) = self.plan();
        let walls = Vec2::new(width, depth) - 2.0 * SETBACK;
        let built = assemble::Building {
            style: self.style,
            bays: assemble::Building::bays_for(self.style, walls),
            storeys: u32::from(self.floors),
            blind: self.blind,
            look: u32::from(self.detail),
        };
        let stretch = built.stretch(walls);
        built
            .parts()
            .into_iter()
            .map(|(shared, height)| (shared, Vec3::Y * height, Vec3::new(stretch.x, 1.0, stretch.y)))
            .collect()
    }

    /// Is a part of the building painted? Cornices and mansards of stone and zinc are not.
    pub fn is_painted(part: &Shared) -> bool {
        !matches!((part.style, part.part), (Style::Stucco, SharedPart::Roof { .. }))
    }

    /// One of the paints that its style comes in.
    pub fn tint(&self, paint: u8) -> Tint {
        let paints = paints(self.style);
        Tint(paints[usize::from(paint) % paints.len()])
    }
}

/// What walls of a style are painted or burnt in; sRGB.
fn paints(style: Style) -> &'static [[u8; 3]] {
    match style {
        Style::Stucco => &[
            [240, 226, 196],
            [228, 196, 146],
            [230, 194, 176],
            [220, 214, 202],
            [242, 226, 172],
            [206, 212, 190],
            [246, 240, 230],
            [220, 172, 138],
        ],
        Style::Brick => &[[255, 250, 245], [240, 214, 200], [255, 236, 205], [206, 192, 188]],
        Style::Concrete => &[[236, 233, 228], [216, 218, 220], [230, 218, 200], [204, 214, 206]],
        Style::Office | Style::Ribbon => &[[226, 229, 232], [188, 197, 206], [222, 210, 192], [244, 241, 236]],
        Style::House => &[
            [246, 240, 228],
            [242, 224, 184],
            [230, 206, 188],
            [218, 224, 216],
            [240, 196, 160],
            [206, 214, 224],
        ],
    }
}

/// The meshes of a shared part from fine to coarse, with the camera distances in metres that they are meant for.
/// Levels that would not differ are one.
pub fn levels(shared: &Shared) -> Vec<(MeshData, Range<f32>)> {
    let ends = [
        (Detail::Near, NEAR),
        (Detail::Middle, MIDDLE),
        (Detail::Far, f32::INFINITY),
    ];
    let mut levels: Vec<(MeshData, Range<f32>)> = Vec::new();
    let mut from = 0.0;
    for (detail, to) in ends {
        let mesh = data(&shared.build(detail));
        match levels.last_mut() {
            Some((finer, range)) if finer.indices.len() == mesh.indices.len() => range.end = to,
            _ => levels.push((mesh, from..to)),
        }
        from = to;
    }
    levels
}

/// A mesh of the forge with its shades as grey colours.
fn data(mesh: &Mesh) -> MeshData {
    let each = || mesh.vertices.iter();
    MeshData {
        positions: each().map(|vertex| vertex.position).collect(),
        normals: each().map(|vertex| vertex.normal).collect(),
        colors: each().map(|vertex| [vertex.shade; 3]).collect(),
        uvs: each().map(|vertex| vertex.uv).collect(),
        indices: mesh.indices.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::meshes::tests::{assert_sane, assert_solid};

    fn building(style: Style) -> Building {
        Building {
            width_dm: 164,
            depth_dm: 121,
            floors: 4,
            style,
            blind: (true, false),
            detail: 3,
        }
    }

    /// All parts of one detail in one mesh, in metres.
    fn whole(building: &Building, level: usize) -> MeshData {
        let mut whole = MeshData::default();
        for (shared, offset, scale) in building.parts() {
            let levels = levels(&shared);
            let (mesh, _) = &levels[level.min(levels.len() - 1)];
            let place = bevy_math::Affine3A::from_scale_rotation_translation(scale, bevy_math::Quat::IDENTITY, offset);
            whole.append(mesh, place);
        }
        whole
    }

    #[test]
    fn every_style_is_solid_and_has_its_size() {
        for style in Style::ALL {
            for level in 0..3 {
                let building = building(style);
                let mesh = whole(&building, level);
                let name = format!("{style:?} {level}");
                assert_solid(&mesh, &name);
                let (min, max) = mesh.bounds().unwrap();
                assert!(min.y < 0.0 && max.y > building.wall_height(), "{name}: {min} {max}");
                // Walls stand back; eaves, balconies and awnings reach over the plan.
                let over = max.x - 8.2;
                assert!((-0.21..0.5).contains(&over), "{name}: {over} along x");
                let over = max.z - 6.05;
                assert!((-0.21..1.4).contains(&over), "{name}: {over} along z");
            }
        }
    }

    #[test]
    fn walls_are_as_high_as_their_floors() {
        assert_eq!(building(Style::Brick).wall_height(), 4.0 + 3.0 * 3.2);
        let heights: Vec<f32> = building(Style::Brick).parts().iter().map(|(_, at, _)| at.y).collect();
        assert_eq!(heights, [0.0, 4.0, 7.2, 10.4, 13.6]);
    }

    #[test]
    fn levels_follow_each_other_without_gaps() {
        for style in Style::ALL {
            for (shared, ..) in building(style).parts() {
                let levels = levels(&shared);
                assert_eq!(levels[0].1.start, 0.0);
                assert_eq!(levels[levels.len() - 1].1.end, f32::INFINITY);
                for pair in levels.windows(2) {
                    assert_eq!(pair[0].1.end, pair[1].1.start);
                    assert!(pair[1].0.indices.len() < pair[0].0.indices.len(), "{shared:?}");
                }
                for (mesh, _) in &levels {
                    assert_sane(mesh, &format!("{shared:?}"));
                }
            }
        }
    }

    #[test]
    fn no_two_faces_lie_on_each_other() {
        for style in Style::ALL {
            for level in 0..3 {
                let pairs = overlapping_faces(&whole(&building(style), level));
                assert!(
                    pairs.is_empty(),
                    "{style:?} {level}: {} pairs, such as {:?}",
                    pairs.len(),
                    &pairs[..pairs.len().min(4)]
                );
            }
        }
    }

    /// Pairs of axis-aligned, equally facing rectangles in one plane that overlap by more than what is hidden in walls,
    /// but for undersides below ground.
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
            // The four parts of a wall around a hole are no rectangles: they meet at slanted edges.
            let [a, b, c, d] = corners;
            let (area, extent) = (0.5 * (c - a).cross(d - b).length(), max - min);
            let around = extent.x * extent.y + extent.y * extent.z + extent.z * extent.x;
            let is_rectangle = (area - around).abs() < 1e-3 * around;
            if let (Some(axis), false, true) = (axis, below, is_rectangle) {
                let side = if normal[axis] > 0.0 { axis } else { axis + 3 };
                faces.push((side, min[axis], min, max));
            }
        }
        let hidden = 0.08;
        let mut pairs = Vec::new();
        for i in 0..faces.len() {
            for j in i + 1..faces.len() {
                let (a, b) = (faces[i], faces[j]);
                let overlap = (a.3.min(b.3) - a.2.max(b.2)).to_array();
                let flat = a.0 % 3;
                let same_plane = a.0 == b.0 && (a.1 - b.1).abs() < 1e-4;
                if same_plane && (0..3).filter(|k| *k != flat).all(|k| overlap[k] > hidden) {
                    pairs.push([a.2, a.3, b.2, b.3]);
                }
            }
        }
        pairs
    }
}
