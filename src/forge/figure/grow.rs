//! From pieces of a body to skinned levels of detail.

use bevy_math::{Vec2, Vec3};

use super::{
    decimate::{Surface, decimated},
    field::{Field, Flesh},
    march,
};
use crate::forge::{
    mesh::{Lod, Mesh, Part, Vertex},
    portable::mix,
    rig::Joint,
};

/// Distances in metres at which a surface looks for others that keep light from it.
const LOOKS: [f32; 3] = [0.03, 0.08, 0.16];

/// A closed surface of a figure: a body, a garment, an antler.
pub struct Piece {
    /// Its shape in the bind pose.
    pub field: Field,
    /// Side of the lattice's cubes in metres: smaller than the thinnest part.
    pub cell: f32,
    /// Left and right are alike: half is made, and mirrored.
    pub mirrored: bool,
    /// Index of its material.
    pub material: usize,
    /// Texture coordinates of a place.
    pub coordinates: Box<dyn Fn(Vec3) -> Vec2>,
    /// How much finer than elsewhere the triangles at a place are.
    pub importance: Box<dyn Fn(Vec3) -> f32>,
    /// In how many levels of detail it is, from the finest.
    pub levels: usize,
}

/// Triangles of one level, and down to which height on the screen it is meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Triangles of the whole figure, about.
    pub triangles: usize,
    /// See [`Lod::screen_coverage`].
    pub screen_coverage: f32,
}

/// A place on the left as it is on the right, and the other way round.
pub fn mirror(p: Vec3) -> Vec3 {
    Vec3::new(-p.x, p.y, p.z)
}

/// The joint of the other side: `_l` and `_r` are exchanged.
pub fn opposite(joints: &[Joint], joint: usize) -> usize {
    let name = &joints[joint].name;
    let other = match (name.strip_suffix("_l"), name.strip_suffix("_r")) {
        (Some(stem), _) => format!("{stem}_r"),
        (_, Some(stem)) => format!("{stem}_l"),
        _ => return joint,
    };
    joints.iter().position(|known| known.name == other).unwrap_or(joint)
}

/// Flesh of the left side, and the same on the right.
pub fn pair(joints: &[Joint], left: Flesh) -> [Flesh; 2] {
    let right = Flesh {
        ends: left.ends.map(mirror),
        joints: left.joints.map(|joint| opposite(joints, joint)),
        ..left
    };
    [left, right]
}

/// The levels of detail of all pieces together: every triangle goes where it helps most.
pub fn levels(joints: &[Joint], pieces: &[Piece], levels: &[Level]) -> Vec<Lod> {
    let mut surface = Surface::default();
    for (index, piece) in pieces.iter().enumerate() {
        surface.append(&march::surface(&piece.field, piece.cell, piece.mirrored), index);
    }
    let importance = |p: Vec3, piece: usize| (pieces[piece].importance)(p);
    let mut lods = Vec::new();
    for (number, level) in levels.iter().enumerate() {
        surface = surface.pieces(|piece| number < pieces[piece].levels);
        surface = decimated(&surface, level.triangles / 2, &importance);
        lods.push(Lod {
            parts: parts(joints, pieces, &surface),
            screen_coverage: level.screen_coverage,
        });
    }
    lods
}

/// One part per material.
fn parts(joints: &[Joint], pieces: &[Piece], surface: &Surface) -> Vec<Part> {
    let materials = pieces
        .iter()
        .map(|piece| piece.material)
        .max()
        .map_or(0, |last| last + 1);
    let mut parts: Vec<Part> = (0..materials)
        .map(|material| Part {
            mesh: Mesh {
                shades: true,
                ..Mesh::default()
            },
            material,
        })
        .collect();
    let reaches = reaches(surface);
    let mut places: Vec<[u32; 2]> = Vec::with_capacity(surface.points.len());
    for (index, p) in surface.points.iter().enumerate() {
        let piece = &pieces[surface.piece[index]];
        let seam = surface.seam[index];
        let mut at = piece.field.on_surface(*p, reaches[index] * 0.25);
        let mut normal = piece.field.normal(at);
        if seam {
            at.x = 0.0;
            normal = normal.with_x(0.0).normalize_or(Vec3::Y);
        }
        let mesh = &mut parts[piece.material].mesh;
        let vertex = Vertex {
            position: at,
            normal,
            uv: (piece.coordinates)(at),
            tangent: Vec3::X,
            shade: openness(pieces, at, normal),
        };
        let influence = piece.field.influence(at);
        let left = mesh.push(vertex);
        mesh.skin.push(influence);
        let right = if piece.mirrored && !seam {
            let mut other = influence;
            other.joints = influence
                .joints
                .map(|joint| u8::try_from(opposite(joints, usize::from(joint))).unwrap_or(joint));
            mesh.skin.push(other);
            mesh.push(Vertex {
                position: mirror(at),
                normal: mirror(normal),
                ..vertex
            })
        } else {
            left
        };
        places.push([left, right]);
    }
    for face in &surface.faces {
        let piece = &pieces[surface.piece[face[0] as usize]];
        let mesh = &mut parts[piece.material].mesh;
        let [a, b, c] = face.map(|corner| places[corner as usize]);
        mesh.indices.extend([a[0], b[0], c[0]]);
        if piece.mirrored {
            mesh.indices.extend([a[1], c[1], b[1]]);
        }
    }
    parts.retain(|part| part.mesh.triangle_count() > 0);
    parts
}

/// Length of the shortest edge at every point.
fn reaches(surface: &Surface) -> Vec<f32> {
    let mut shortest = vec![f32::MAX; surface.points.len()];
    for face in &surface.faces {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let [a, b] = [face[a] as usize, face[b] as usize];
            let length = (surface.points[a] - surface.points[b]).length();
            shortest[a] = shortest[a].min(length);
            shortest[b] = shortest[b].min(length);
        }
    }
    shortest
}

/// 1 in the open, less where other parts are near: ambient occlusion from distances (Evans 2006).
fn openness(pieces: &[Piece], at: Vec3, normal: Vec3) -> f32 {
    let closed: f32 = LOOKS
        .into_iter()
        .map(|look| {
            let p = at + normal * look;
            let distance = pieces.iter().map(|piece| piece.field.distance(p)).fold(look, f32::min);
            (look - distance).clamp(0.0, look) / look
        })
        .sum();
    mix(1.0, 0.55, closed / LOOKS.len() as f32)
}
