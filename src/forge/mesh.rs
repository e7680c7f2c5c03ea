//! What an asset consists of before it becomes a file: meshes, materials, pictures, variants with levels of detail.
//!
//! Metres, right-handed, +y up, the foot at the origin; triangles turn counter-clockwise seen from outside.

use bevy_math::{Vec2, Vec3};

use super::{
    rig::{Influence, Rig},
    texture::picture::Picture,
};

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Metres.
    pub position: Vec3,
    /// Unit vector.
    pub normal: Vec3,
    /// Texture coordinates; (0, 0) is the upper left corner of the picture.
    pub uv: Vec2,
    /// Direction of growing u, a unit vector at right angles to the normal; kept only where [`Mesh::tangents`] says so.
    pub tangent: Vec3,
    /// Factor on the base colour, 0..=1; kept only where [`Mesh::shades`] says so.
    pub shade: f32,
}

/// Triangles of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners.
    pub vertices: Vec<Vertex>,
    /// Three per triangle.
    pub indices: Vec<u32>,
    /// Are tangents part of the file? Pictures are never mirrored: normal × tangent points up in the picture.
    pub tangents: bool,
    /// Are shades part of the file, as vertex colours?
    pub shades: bool,
    /// One per vertex for a mesh that a rig moves; else empty.
    pub skin: Vec<Influence>,
}

impl Mesh {
    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.indices.len() / 3
    }

    /// Adds a vertex and gives its index.
    ///
    /// # Panics
    /// With more than 2³² vertices.
    pub fn push(&mut self, vertex: Vertex) -> u32 {
        let index = u32::try_from(self.vertices.len()).expect("fewer than 2³² vertices");
        self.vertices.push(vertex);
        index
    }

    /// Adds a quadrilateral: corners counter-clockwise.
    pub fn push_quad(&mut self, corners: [u32; 4]) {
        let [a, b, c, d] = corners;
        self.indices.extend([a, b, c, a, c, d]);
    }

    /// Adds the triangles of another mesh.
    pub fn append(&mut self, other: &Self) {
        let first = u32::try_from(self.vertices.len()).unwrap_or(u32::MAX);
        self.vertices.extend_from_slice(&other.vertices);
        self.skin.extend_from_slice(&other.skin);
        self.indices.extend(other.indices.iter().map(|index| index + first));
    }

    /// Lowest and highest corner of the box around all vertices; `None` for an empty mesh.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let mut positions = self.vertices.iter().map(|vertex| vertex.position);
        let first = positions.next()?;
        Some(positions.fold((first, first), |(low, high), p| (low.min(p), high.max(p))))
    }
}

/// How a surface looks: the metallic-roughness model of glTF. Pictures are indices into [`Model::pictures`].
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Unique within the model.
    pub name: String,
    /// Linear factor on the base picture.
    pub base_color: [f32; 3],
    /// Colour (sRGB) and alpha.
    pub base_picture: Option<usize>,
    /// Normals in tangent space.
    pub normal_picture: Option<usize>,
    /// 0 smooth to 1 rough.
    pub roughness: f32,
    /// Alpha below this is not there; `None`: opaque.
    pub cutoff: Option<f32>,
    /// Both sides are drawn.
    pub double_sided: bool,
    /// Thin and translucent, as leaves are.
    pub leaf: Option<Leaf>,
    /// How the pictures hold many views, for impostors.
    pub views: Option<Views>,
}

/// Light that shines through a leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Metres.
    pub thickness: f32,
    /// Picture whose green channel scales the thickness.
    pub thickness_picture: Option<usize>,
    /// Share of the diffuse light that leaves on the other side.
    pub transmission: f32,
}

/// Layout of an impostor's pictures: `grid` × `grid` views on a hemi-octahedron.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Views {
    /// Views per side.
    pub grid: u32,
    /// Centre of all views in metres.
    pub center: Vec3,
    /// Half the width and height of a view in metres.
    pub half: Vec2,
    /// Depth runs from −radius to +radius, in metres.
    pub radius: f32,
}

impl Material {
    /// An opaque, rough material without pictures.
    pub fn plain(name: &str, base_color: [f32; 3]) -> Self {
        Self {
            name: name.to_owned(),
            base_color,
            base_picture: None,
            normal_picture: None,
            roughness: 0.9,
            cutoff: None,
            double_sided: false,
            leaf: None,
            views: None,
        }
    }
}

/// A mesh with its material, an index into [`Model::materials`].
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The triangles.
    pub mesh: Mesh,
    /// Their material.
    pub material: usize,
}

/// One level of detail.
#[derive(Clone, Debug, PartialEq)]
pub struct Lod {
    /// What is drawn.
    pub parts: Vec<Part>,
    /// Height on the screen, as a share of the picture's height, down to which this level is meant.
    pub screen_coverage: f32,
}

impl Lod {
    /// Number of triangles of all parts.
    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.mesh.triangle_count()).sum()
    }

    /// Lowest and highest corner of the box around all parts; `None` without vertices.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        self.parts
            .iter()
            .filter_map(|part| part.mesh.bounds())
            .reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))
    }
}

/// One shape of an asset, in several levels of detail from fine to coarse.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// Unique within the model; nodes are called `NAME_LOD0`, `NAME_LOD1`, …
    pub name: String,
    /// At least one.
    pub lods: Vec<Lod>,
}

/// An asset: variants that share materials and pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Pictures.
    pub pictures: Vec<Picture>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Shapes; the first is the default scene.
    pub variants: Vec<Variant>,
    /// What moves the shapes.
    pub rig: Option<Rig>,
}

impl Model {
    /// Adds a picture and gives its index.
    pub fn add_picture(&mut self, picture: Picture) -> usize {
        self.pictures.push(picture);
        self.pictures.len() - 1
    }

    /// Adds a material and gives its index.
    pub fn add_material(&mut self, material: Material) -> usize {
        self.materials.push(material);
        self.materials.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn appended_triangles_keep_their_corners() {
        let mut one = Mesh::default();
        for x in 0..4 {
            one.push(Vertex {
                position: Vec3::new(x as f32, 0.0, 0.0),
                normal: Vec3::Y,
                uv: Vec2::ZERO,
                tangent: Vec3::X,
                shade: 1.0,
            });
        }
        one.push_quad([0, 1, 2, 3]);
        let mut two = one.clone();
        two.append(&one);
        assert_eq!(two.indices, [0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7]);
        assert_eq!(two.bounds(), Some((Vec3::ZERO, Vec3::new(3.0, 0.0, 0.0))));
        assert_eq!(Mesh::default().bounds(), None);
    }
}
