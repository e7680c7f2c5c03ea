//! What the forge writes, read back by the `gltf` crate.

use bevy_math::{Vec2, Vec3};
use gltf::{Glb, Gltf, Semantic, material::AlphaMode};
use umbrage::forge::{
    glb,
    mesh::{Leaf, Lod, Material, Mesh, Model, Part, Variant, Vertex, Views},
    texture::picture::{Channels, Picture},
};

/// A square of 2 m in the plane z = 0.5, and the same with one corner less.
fn model() -> Model {
    let mut mesh = Mesh {
        tangents: true,
        shades: true,
        ..Mesh::default()
    };
    for (x, y) in [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)] {
        mesh.push(Vertex {
            position: Vec3::new(x, y, 0.5),
            normal: Vec3::Z,
            uv: Vec2::new(x / 2.0, 1.0 - y / 2.0),
            tangent: Vec3::X,
            shade: 0.5,
        });
    }
    let mut triangle = mesh.clone();
    triangle.tangents = false;
    triangle.indices = vec![0, 1, 2];
    mesh.push_quad([0, 1, 2, 3]);
    let mut model = Model::default();
    let picture = model.add_picture(Picture::from_fn("leaf", 4, 2, Channels::Rgba, |x, y| {
        [x as u8, y as u8, 9, 200]
    }));
    let leaf = model.add_material(Material {
        base_picture: Some(picture),
        normal_picture: Some(picture),
        cutoff: Some(0.4),
        double_sided: true,
        leaf: Some(Leaf {
            thickness: 0.25,
            thickness_picture: Some(picture),
            transmission: 0.5,
        }),
        views: Some(Views {
            grid: 5,
            center: Vec3::new(0.0, 1.5, 0.0),
            half: Vec2::new(1.0, 2.0),
            radius: 2.0,
        }),
        ..Material::plain("leaf", [1.0, 0.5, 0.25])
    });
    let bark = model.add_material(Material::plain("bark", [0.5; 3]));
    let part = |mesh: &Mesh, material| Part {
        mesh: mesh.clone(),
        material,
    };
    for name in ["a", "b"] {
        model.variants.push(Variant {
            name: name.into(),
            lods: vec![
                Lod {
                    parts: vec![part(&mesh, leaf), part(&triangle, bark)],
                    screen_coverage: 0.5,
                },
                Lod {
                    parts: vec![part(&triangle, bark)],
                    screen_coverage: 0.25,
                },
            ],
        });
    }
    model
}

fn read(bytes: &[u8]) -> Gltf {
    Gltf::from_slice(bytes).expect("a valid file")
}

#[test]
fn the_file_has_the_length_that_its_header_says() {
    let bytes = glb::bytes(&model());
    assert_eq!(&bytes[..4], b"glTF");
    assert_eq!(bytes[8..12], (bytes.len() as u32).to_le_bytes());
    let parts = Glb::from_slice(&bytes).expect("two chunks");
    assert_eq!(parts.json.len() % 4, 0);
    assert_eq!(parts.bin.expect("a binary chunk").len() % 4, 0);
}

#[test]
fn coarser_levels_hang_on_the_first_and_stand_in_no_scene() {
    let file = read(&glb::bytes(&model()));
    let names: Vec<_> = file.nodes().filter_map(|node| node.name().map(str::to_owned)).collect();
    assert_eq!(names, ["a_LOD0", "a_LOD1", "b_LOD0", "b_LOD1"]);
    let scenes: Vec<(_, Vec<_>)> = file
        .scenes()
        .map(|scene| (scene.name(), scene.nodes().map(|node| node.index()).collect()))
        .collect();
    assert_eq!(scenes, [(Some("a"), vec![0]), (Some("b"), vec![2])]);
    assert_eq!(file.default_scene().and_then(|scene| scene.name()), Some("a"));
    let last = file.nodes().nth(2).expect("four nodes");
    let lod = last.extension_value("MSFT_lod").expect("the extension");
    assert_eq!(lod["ids"], serde_json::json!([3]));
    let extras = last.extras().as_ref().expect("extras").get();
    assert_eq!(extras, r#"{"MSFT_screencoverage":[0.5,0.25]}"#);
    assert!(file.extensions_used().any(|name| name == "MSFT_lod"));
    assert_eq!(file.extensions_required().count(), 0, "any tool may read the file");
}

#[test]
fn vertices_come_back_as_they_went() {
    let file = read(&glb::bytes(&model()));
    let binary = file.blob.clone().expect("a binary chunk");
    let mesh = file.meshes().next().expect("a mesh");
    let primitive = mesh.primitives().next().expect("a primitive");
    let reader = primitive.reader(|_| Some(&binary));
    let positions: Vec<_> = reader.read_positions().expect("positions").collect();
    assert_eq!(
        positions,
        [[0.0, 0.0, 0.5], [2.0, 0.0, 0.5], [2.0, 2.0, 0.5], [0.0, 2.0, 0.5]]
    );
    let bounds = primitive.bounding_box();
    assert_eq!((bounds.min, bounds.max), ([0.0, 0.0, 0.5], [2.0, 2.0, 0.5]));
    let tangents: Vec<_> = reader.read_tangents().expect("tangents").collect();
    assert_eq!(tangents, [[1.0, 0.0, 0.0, 1.0]; 4]);
    let colors: Vec<_> = reader.read_colors(0).expect("colours").into_rgba_u8().collect();
    assert_eq!(colors, [[128, 128, 128, 255]; 4]);
    let uvs: Vec<_> = reader.read_tex_coords(0).expect("coordinates").into_f32().collect();
    assert_eq!(uvs, [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    let indices: Vec<_> = reader.read_indices().expect("indices").into_u32().collect();
    assert_eq!(indices, [0, 1, 2, 0, 2, 3]);
    let second = mesh.primitives().nth(1).expect("two primitives");
    assert!(second.get(&Semantic::Tangents).is_none(), "left out where it says so");
}

#[test]
fn materials_come_back_as_they_went() {
    let file = read(&glb::bytes(&model()));
    let leaf = file.materials().next().expect("a material");
    assert_eq!((leaf.name(), leaf.alpha_mode()), (Some("leaf"), AlphaMode::Mask));
    assert_eq!((leaf.alpha_cutoff(), leaf.double_sided()), (Some(0.4), true));
    let surface = leaf.pbr_metallic_roughness();
    assert_eq!(surface.base_color_factor(), [1.0, 0.5, 0.25, 1.0]);
    assert_eq!((surface.metallic_factor(), surface.roughness_factor()), (0.0, 0.9));
    assert!(surface.base_color_texture().is_some() && leaf.normal_texture().is_some());
    let volume = leaf.volume().expect("thickness");
    assert_eq!(volume.thickness_factor(), 0.25);
    assert_eq!(volume.thickness_texture().map(|info| info.texture().index()), Some(0));
    let transmission = leaf
        .extension_value("KHR_materials_diffuse_transmission")
        .expect("transmission");
    assert_eq!(transmission["diffuseTransmissionFactor"], 0.5);
    let extras = leaf.extras().as_ref().expect("views").get();
    assert!(
        extras.contains(r#""grid":5"#) && extras.contains(r#""center":[0.0,1.5,0.0]"#),
        "{extras}"
    );
    let bark = file.materials().nth(1).expect("two materials");
    assert_eq!((bark.alpha_mode(), bark.double_sided()), (AlphaMode::Opaque, false));
}

#[test]
fn pictures_come_back_as_they_went() {
    let file = read(&glb::bytes(&model()));
    let binary = file.blob.clone().expect("a binary chunk");
    let gltf::image::Source::View { view, mime_type } = file.images().next().expect("an image").source() else {
        panic!("pictures are inside the file");
    };
    assert_eq!(mime_type, "image/png");
    let png = &binary[view.offset()..view.offset() + view.length()];
    let picture = image::load_from_memory(png).expect("a PNG file").into_rgba8();
    assert_eq!(picture.dimensions(), (4, 2));
    assert_eq!(picture.get_pixel(3, 1).0, [3, 1, 9, 200]);
}

#[test]
fn large_meshes_have_large_indices() {
    let mut model = model();
    let mesh = &mut model.variants[0].lods[0].parts[0].mesh;
    mesh.vertices = vec![mesh.vertices[0]; 70_000];
    mesh.indices = vec![0, 65_535, 69_999];
    let file = read(&glb::bytes(&model));
    let binary = file.blob.clone().expect("a binary chunk");
    let primitive = file
        .meshes()
        .next()
        .and_then(|mesh| mesh.primitives().next())
        .expect("a primitive");
    let indices: Vec<_> = primitive
        .reader(|_| Some(&binary))
        .read_indices()
        .expect("indices")
        .into_u32()
        .collect();
    assert_eq!(indices, [0, 65_535, 69_999]);
}
