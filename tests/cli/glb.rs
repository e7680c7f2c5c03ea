//! Tiny .glb files.

use std::path::Path;

use serde_json::{Value, json};

/// A node: which mesh, where, how large.
#[derive(Clone, Copy)]
pub(crate) struct Node {
    pub(crate) mesh: Mesh,
    pub(crate) translation: [f32; 3],
    pub(crate) scale: [f32; 3],
}

/// The meshes in the file.
#[derive(Clone, Copy)]
pub(crate) enum Mesh {
    /// −0.5..=0.5 on x and z, facing up.
    Plane = 0,
    /// −0.5..=0.5 on all axes.
    Cube = 1,
}

/// A plane of 20 m with a cube of 2 m on it.
pub(crate) fn box_on_plane() -> Vec<Node> {
    vec![
        Node {
            mesh: Mesh::Plane,
            translation: [0.0; 3],
            scale: [20.0, 1.0, 20.0],
        },
        Node {
            mesh: Mesh::Cube,
            translation: [0.0, 1.0, 0.0],
            scale: [2.0; 3],
        },
    ]
}

/// The bytes of a file with these nodes, which share the two meshes and one material.
pub(crate) fn bytes(nodes: &[Node]) -> Vec<u8> {
    let mut bin = Vec::new();
    let mut accessors = Vec::new();
    let mut views = Vec::new();
    let mut meshes = Vec::new();
    for faces in [vec![([0.0, 1.0, 0.0], 0.0)], cube_faces()] {
        let (positions, normals, indices) = mesh(&faces);
        let first = accessors.len();
        push(
            &mut bin,
            &mut views,
            positions.iter().flatten().flat_map(|number| number.to_le_bytes()),
        );
        push(
            &mut bin,
            &mut views,
            normals.iter().flatten().flat_map(|number| number.to_le_bytes()),
        );
        push(
            &mut bin,
            &mut views,
            indices.iter().flat_map(|index| index.to_le_bytes()),
        );
        let low: Vec<f32> = (0..3)
            .map(|axis| positions.iter().map(|p| p[axis]).fold(f32::MAX, f32::min))
            .collect();
        let high: Vec<f32> = (0..3)
            .map(|axis| positions.iter().map(|p| p[axis]).fold(f32::MIN, f32::max))
            .collect();
        accessors.push(json!({"bufferView": first, "componentType": 5126, "count": positions.len(), "type": "VEC3", "min": low, "max": high}));
        accessors.push(json!({"bufferView": first + 1, "componentType": 5126, "count": normals.len(), "type": "VEC3"}));
        accessors
            .push(json!({"bufferView": first + 2, "componentType": 5123, "count": indices.len(), "type": "SCALAR"}));
        meshes.push(json!({"primitives": [{
            "attributes": {"POSITION": first, "NORMAL": first + 1}, "indices": first + 2, "material": 0,
        }]}));
    }
    let json_nodes: Vec<Value> = nodes
        .iter()
        .map(|node| json!({"mesh": node.mesh as u32, "translation": node.translation, "scale": node.scale}))
        .collect();
    let json = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}],
        "nodes": json_nodes,
        "meshes": meshes,
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.8, 0.8, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0}}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": bin.len()}],
    });
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + bin.len();
    let mut file = Vec::with_capacity(total);
    file.extend_from_slice(b"glTF");
    for word in [2, total as u32, text.len() as u32] {
        file.extend_from_slice(&word.to_le_bytes());
    }
    file.extend_from_slice(b"JSON");
    file.extend_from_slice(&text);
    file.extend_from_slice(&(bin.len() as u32).to_le_bytes());
    file.extend_from_slice(b"BIN\0");
    file.extend_from_slice(&bin);
    file
}

/// Writes a file.
pub(crate) fn write(path: &Path, nodes: &[Node]) {
    std::fs::write(path, bytes(nodes)).expect("the .glb is written");
}

/// Normal and distance of the faces of the unit cube.
fn cube_faces() -> Vec<([f32; 3], f32)> {
    let mut faces = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut normal = [0.0; 3];
            normal[axis] = sign;
            faces.push((normal, 0.5));
        }
    }
    faces
}

/// Unit squares with these normals at these distances from the origin, counter-clockwise seen from outside.
fn mesh(faces: &[([f32; 3], f32)]) -> (Vec<[f32; 3]>, Vec<[f32; 3]>, Vec<u16>) {
    let (mut positions, mut normals, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for (normal, distance) in faces {
        let axis = normal.iter().position(|number| *number != 0.0).expect("a unit axis");
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let first = u16::try_from(positions.len()).expect("few vertices");
        for (a, b) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
            let mut corner = normal.map(|number| number * distance);
            // For a negative normal the square is walked the other way round.
            corner[u] = a * normal[axis];
            corner[v] = b;
            positions.push(corner);
            normals.push(*normal);
        }
        indices.extend([0, 1, 2, 0, 2, 3].map(|index| first + index));
    }
    (positions, normals, indices)
}

/// Appends bytes to the buffer as a view of their own.
fn push(bin: &mut Vec<u8>, views: &mut Vec<Value>, bytes: impl Iterator<Item = u8>) {
    let start = bin.len();
    bin.extend(bytes);
    views.push(json!({"buffer": 0, "byteOffset": start, "byteLength": bin.len() - start}));
    bin.resize(bin.len().next_multiple_of(4), 0);
}
