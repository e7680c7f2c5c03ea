//! Binary glTF 2.0 files from models.
//!
//! * One scene per variant; the first is the default. Its node is `NAME_LOD0`; the coarser nodes `NAME_LOD1`, … belong to
//!   no scene and are named by `MSFT_lod` of the first, with `MSFT_screencoverage` in its extras. Tools that know neither
//!   show the finest level.
//! * Pictures are PNG (rough ground: JPEG) inside the file. Texture coordinates are of 16 bits where they stay inside the picture, shades 8-bit vertex colours, indices of 16
//!   bits where they suffice.
//! * A rig's joints are nodes below one node `rig`, which every scene names beside its mesh; all meshes share one skin. Its
//!   extras say how far a clip walks in one loop: `umbrage_metres`. Clips are animations with linear key frames.
//! * Leaves carry `KHR_materials_volume` (thickness) and `KHR_materials_diffuse_transmission`; impostor materials say
//!   in `extras.umbrage_views` how their views lie in their pictures.

use std::collections::BTreeMap;

use bevy_math::Vec3;
use gltf_json::{
    Accessor, Asset, Buffer, Extras, Index, Material as JsonMaterial, Mesh as JsonMesh, Node, Root, Scene, Texture,
    accessor::{ComponentType, GenericComponentType, Type},
    buffer::{Target, View},
    extensions,
    image::MimeType,
    material::{AlphaCutoff, AlphaMode, NormalTexture, PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor},
    mesh::{Mode, Primitive, Semantic},
    texture::{Info, MagFilter, MinFilter, Sampler, WrappingMode},
    validation::Checked::Valid,
};
use serde_json::{Map, Value, json};

use self::skin::Skeleton;
use super::mesh::{Leaf, Material, Mesh, Model, Part, Variant, Views};

mod skin;

const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// The bytes of the file.
///
/// # Panics
/// With more than 4 GiB of data.
pub fn bytes(model: &Model) -> Vec<u8> {
    let mut file = File::default();
    file.pictures(model);
    for material in &model.materials {
        let json = file.material(material);
        file.root.materials.push(json);
    }
    let skeleton = model.rig.as_ref().map(|rig| file.rig(rig));
    for variant in &model.variants {
        file.variant(variant, skeleton);
    }
    file.root.scene = (!model.variants.is_empty()).then(|| Index::new(0));
    file.finish()
}

/// A file that is being built: JSON, and the binary chunk that it refers to.
#[derive(Default)]
struct File {
    root: Root,
    binary: Vec<u8>,
}

impl File {
    fn pictures(&mut self, model: &Model) {
        for picture in &model.pictures {
            let view = self.view(&picture.bytes(), None);
            let source = Index::push(
                &mut self.root.images,
                gltf_json::Image {
                    buffer_view: Some(view),
                    mime_type: Some(MimeType(picture.channels.mime().into())),
                    name: Some(picture.name.clone()),
                    uri: None,
                    extensions: None,
                    extras: None,
                },
            );
            self.root.textures.push(Texture {
                name: Some(picture.name.clone()),
                sampler: Some(Index::new(0)),
                source,
                extensions: None,
                extras: None,
            });
        }
        if !model.pictures.is_empty() {
            self.root.samplers.push(Sampler {
                mag_filter: Some(Valid(MagFilter::Linear)),
                min_filter: Some(Valid(MinFilter::LinearMipmapLinear)),
                wrap_s: Valid(WrappingMode::Repeat),
                wrap_t: Valid(WrappingMode::Repeat),
                ..Default::default()
            });
        }
    }

    fn material(&mut self, material: &Material) -> JsonMaterial {
        let [r, g, b] = material.base_color;
        JsonMaterial {
            name: Some(material.name.clone()),
            alpha_mode: Valid(if material.cutoff.is_some() {
                AlphaMode::Mask
            } else {
                AlphaMode::Opaque
            }),
            alpha_cutoff: material.cutoff.map(AlphaCutoff),
            double_sided: material.double_sided,
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor([r, g, b, 1.0]),
                base_color_texture: material.base_picture.map(texture_info),
                metallic_factor: StrengthFactor(0.0),
                roughness_factor: StrengthFactor(material.roughness),
                ..Default::default()
            },
            normal_texture: material.normal_picture.map(|picture| NormalTexture {
                index: texture_info(picture).index,
                scale: 1.0,
                tex_coord: 0,
                extensions: None,
                extras: None,
            }),
            extensions: material.leaf.map(|leaf| self.leaf(leaf)),
            extras: material.views.and_then(views_extras),
            ..Default::default()
        }
    }

    fn leaf(&mut self, leaf: Leaf) -> extensions::material::Material {
        let mut volume = Map::new();
        volume.insert("thicknessFactor".into(), json!(leaf.thickness));
        if let Some(picture) = leaf.thickness_picture {
            volume.insert("thicknessTexture".into(), json!({ "index": picture }));
        }
        let mut others = Map::new();
        others.insert(
            "KHR_materials_diffuse_transmission".into(),
            json!({ "diffuseTransmissionFactor": leaf.transmission }),
        );
        others.insert("KHR_materials_volume".into(), Value::Object(volume));
        for name in others.keys() {
            self.uses(name);
        }
        extensions::material::Material {
            others,
            ..Default::default()
        }
    }

    fn uses(&mut self, extension: &str) {
        if !self.root.extensions_used.iter().any(|used| used == extension) {
            self.root.extensions_used.push(extension.to_owned());
        }
    }

    fn variant(&mut self, variant: &Variant, skeleton: Option<Skeleton>) {
        let first = self.root.nodes.len();
        for (level, lod) in variant.lods.iter().enumerate() {
            let name = format!("{}_LOD{level}", variant.name);
            let primitives = lod.parts.iter().map(|part| self.primitive(part)).collect();
            let mesh = Index::push(
                &mut self.root.meshes,
                JsonMesh {
                    name: Some(name.clone()),
                    primitives,
                    weights: None,
                    extensions: None,
                    extras: None,
                },
            );
            self.root.nodes.push(Node {
                name: Some(name),
                mesh: Some(mesh),
                skin: skeleton.map(|skeleton| skeleton.skin),
                ..Default::default()
            });
        }
        if variant.lods.len() > 1 {
            let coarser: Vec<usize> = (first + 1..first + variant.lods.len()).collect();
            let coverages: Vec<f32> = variant.lods.iter().map(|lod| lod.screen_coverage).collect();
            let mut others = Map::new();
            others.insert("MSFT_lod".into(), json!({ "ids": coarser }));
            self.uses("MSFT_lod");
            let node = &mut self.root.nodes[first];
            node.extensions = Some(extensions::scene::Node {
                others,
                ..Default::default()
            });
            node.extras = raw(&json!({ "MSFT_screencoverage": coverages }));
        }
        self.root.scenes.push(Scene {
            name: Some(variant.name.clone()),
            nodes: skeleton
                .map(|skeleton| skeleton.root)
                .into_iter()
                .chain([index(first)])
                .collect(),
            extensions: None,
            extras: None,
        });
    }

    fn primitive(&mut self, part: &Part) -> Primitive {
        let mesh = &part.mesh;
        let mut attributes = BTreeMap::new();
        let mut add = |semantic: Semantic, accessor: Index<Accessor>| {
            attributes.insert(Valid(semantic), accessor);
        };
        let vertices = &mesh.vertices;
        add(Semantic::Positions, self.positions(mesh));
        add(
            Semantic::Normals,
            self.floats(Type::Vec3, vertices.iter().map(|v| v.normal.to_array())),
        );
        add(Semantic::TexCoords(0), self.coordinates(mesh));
        if mesh.tangents {
            let tangents = vertices.iter().map(|v| [v.tangent.x, v.tangent.y, v.tangent.z, 1.0]);
            add(Semantic::Tangents, self.floats(Type::Vec4, tangents));
        }
        if mesh.shades {
            add(Semantic::Colors(0), self.shades(mesh));
        }
        if !mesh.skin.is_empty() {
            add(
                Semantic::Joints(0),
                self.bytes4(mesh.skin.iter().map(|influence| influence.joints), false),
            );
            add(
                Semantic::Weights(0),
                self.bytes4(mesh.skin.iter().map(|influence| influence.weights), true),
            );
        }
        Primitive {
            attributes,
            indices: Some(self.indices(mesh)),
            material: Some(index(part.material)),
            mode: Valid(Mode::Triangles),
            targets: None,
            extensions: None,
            extras: None,
        }
    }

    fn positions(&mut self, mesh: &Mesh) -> Index<Accessor> {
        let accessor = self.floats(Type::Vec3, mesh.vertices.iter().map(|v| v.position.to_array()));
        let (low, high) = mesh.bounds().unwrap_or((Vec3::ZERO, Vec3::ZERO));
        if let Some(last) = self.root.accessors.last_mut() {
            last.min = Some(json!(low.to_array()));
            last.max = Some(json!(high.to_array()));
        }
        accessor
    }

    fn floats<const N: usize>(&mut self, type_: Type, values: impl Iterator<Item = [f32; N]>) -> Index<Accessor> {
        let bytes: Vec<u8> = values.flatten().flat_map(f32::to_le_bytes).collect();
        let count = bytes.len() / (4 * N);
        self.accessor(&bytes, Some(Target::ArrayBuffer), ComponentType::F32, type_, count)
    }

    /// 16 bits where all coordinates are inside the picture, else floats.
    fn coordinates(&mut self, mesh: &Mesh) -> Index<Accessor> {
        let uvs = || mesh.vertices.iter().flat_map(|v| v.uv.to_array());
        if uvs().any(|coordinate| !(0.0..=1.0).contains(&coordinate)) {
            return self.floats(Type::Vec2, mesh.vertices.iter().map(|v| v.uv.to_array()));
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..=65535")]
        let code = |coordinate: f32| (coordinate * 65535.0 + 0.5) as u16;
        let bytes: Vec<u8> = uvs().flat_map(|coordinate| code(coordinate).to_le_bytes()).collect();
        let count = mesh.vertices.len();
        let accessor = self.accessor(&bytes, Some(Target::ArrayBuffer), ComponentType::U16, Type::Vec2, count);
        if let Some(last) = self.root.accessors.last_mut() {
            last.normalized = true;
        }
        accessor
    }

    fn shades(&mut self, mesh: &Mesh) -> Index<Accessor> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to 0..=255"
        )]
        let code = |shade: f32| (shade.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        let colors = mesh.vertices.iter().map(|v| code(v.shade));
        self.bytes4(colors.map(|shade| [shade, shade, shade, 255]), true)
    }

    /// Four bytes per vertex; `normalized` ones stand for 0..=1.
    fn bytes4(&mut self, values: impl Iterator<Item = [u8; 4]>, normalized: bool) -> Index<Accessor> {
        let bytes: Vec<u8> = values.flatten().collect();
        let accessor = self.accessor(
            &bytes,
            Some(Target::ArrayBuffer),
            ComponentType::U8,
            Type::Vec4,
            bytes.len() / 4,
        );
        if let Some(last) = self.root.accessors.last_mut() {
            last.normalized = normalized;
        }
        accessor
    }

    fn indices(&mut self, mesh: &Mesh) -> Index<Accessor> {
        let small: Result<Vec<u16>, _> = mesh.indices.iter().map(|index| u16::try_from(*index)).collect();
        // The largest number of 16 bits is left out: it restarts primitives.
        let (bytes, component): (Vec<u8>, _) = match small {
            Ok(small) if !small.contains(&u16::MAX) => (
                small.into_iter().flat_map(u16::to_le_bytes).collect(),
                ComponentType::U16,
            ),
            _ => {
                let large = mesh.indices.iter().copied();
                (large.flat_map(u32::to_le_bytes).collect(), ComponentType::U32)
            }
        };
        self.accessor(
            &bytes,
            Some(Target::ElementArrayBuffer),
            component,
            Type::Scalar,
            mesh.indices.len(),
        )
    }

    fn accessor(
        &mut self,
        bytes: &[u8],
        target: Option<Target>,
        component: ComponentType,
        type_: Type,
        count: usize,
    ) -> Index<Accessor> {
        let view = self.view(bytes, target);
        Index::push(
            &mut self.root.accessors,
            Accessor {
                buffer_view: Some(view),
                byte_offset: None,
                count: count.into(),
                component_type: Valid(GenericComponentType(component)),
                type_: Valid(type_),
                min: None,
                max: None,
                name: None,
                normalized: false,
                sparse: None,
                extensions: None,
                extras: None,
            },
        )
    }

    /// Appends bytes to the binary chunk, at a multiple of four.
    fn view(&mut self, bytes: &[u8], target: Option<Target>) -> Index<View> {
        let offset = self.binary.len();
        self.binary.extend_from_slice(bytes);
        pad(&mut self.binary, 0);
        Index::push(
            &mut self.root.buffer_views,
            View {
                buffer: Index::new(0),
                byte_length: bytes.len().into(),
                byte_offset: Some(offset.into()),
                byte_stride: None,
                name: None,
                target: target.map(Valid),
                extensions: None,
                extras: None,
            },
        )
    }

    fn finish(mut self) -> Vec<u8> {
        self.root.asset = Asset {
            generator: Some(concat!("umbrage forge ", env!("CARGO_PKG_VERSION")).into()),
            copyright: Some("MIT OR Apache-2.0".into()),
            ..Default::default()
        };
        self.root.extensions_used.sort();
        self.root.buffers.push(Buffer {
            byte_length: self.binary.len().into(),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        let mut json = serde_json::to_vec(&self.root).expect("numbers are finite and keys are strings");
        pad(&mut json, b' ');
        let length = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + json.len() + self.binary.len();
        let word = |number: usize| u32::try_from(number).expect("less than 4 GiB").to_le_bytes();
        let mut bytes = Vec::with_capacity(length);
        bytes.extend_from_slice(MAGIC);
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(word(length));
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &self.binary)] {
            bytes.extend(word(chunk.len()));
            bytes.extend_from_slice(kind);
            bytes.extend_from_slice(chunk);
        }
        bytes
    }
}

fn pad(bytes: &mut Vec<u8>, with: u8) {
    bytes.resize(bytes.len().next_multiple_of(4), with);
}

fn index<T>(number: usize) -> Index<T> {
    Index::new(u32::try_from(number).expect("fewer than 2³² things"))
}

fn texture_info(picture: usize) -> Info {
    Info {
        index: index(picture),
        tex_coord: 0,
        extensions: None,
        extras: None,
    }
}

fn views_extras(views: Views) -> Extras {
    raw(&json!({ "umbrage_views": {
        "mapping": "hemi-octahedral",
        "grid": views.grid,
        "center": views.center.to_array(),
        "half": views.half.to_array(),
        "radius": views.radius,
        "depth": "alpha of the normal picture: 1 at +radius towards the viewer, 0 at -radius",
    } }))
}

fn raw(value: &Value) -> Extras {
    serde_json::value::to_raw_value(value).ok()
}
