//! The committed models, as any tool would read them.

use std::{fs, path::PathBuf};

use gltf::{Gltf, Mesh, Primitive, material::AlphaMode, mesh::Mode};
use umbrage::forge::{assets, texture::mips::coverage};

/// All models together, in bytes.
const BUDGET: usize = 20_000_000;

/// Trees with the levels of detail that trees need.
const TREES: [&str; 5] = ["oak", "birch", "beech", "spruce", "pine"];

fn path(name: &str) -> PathBuf {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    root.join("assets/models").join(format!("{name}.glb"))
}

fn committed(name: &str) -> Vec<u8> {
    fs::read(path(name)).unwrap_or_else(|error| panic!("{name}: {error}; run `umbrage forge`"))
}

fn read(name: &str) -> (Gltf, Vec<u8>) {
    let mut file = Gltf::from_slice(&committed(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    let binary = file.blob.take().expect("a binary chunk");
    (file, binary)
}

fn triangles(mesh: &Mesh) -> usize {
    let counts = mesh
        .primitives()
        .map(|primitive| primitive.indices().map_or(0, |indices| indices.count() / 3));
    counts.sum()
}

/// Everything that a validator would complain about.
fn check(name: &str, primitive: &Primitive, binary: &[u8]) {
    let reader = primitive.reader(|_| Some(binary));
    assert_eq!(primitive.mode(), Mode::Triangles);
    let positions: Vec<[f32; 3]> = reader.read_positions().expect("positions").collect();
    assert!(!positions.is_empty(), "{name}");
    let bounds = primitive.bounding_box();
    for axis in 0..3 {
        let along = || positions.iter().map(|p| p[axis]);
        assert!(along().all(f32::is_finite), "{name}");
        assert_eq!(
            along().fold(f32::MAX, f32::min),
            bounds.min[axis],
            "{name}: lowest on axis {axis}"
        );
        assert_eq!(
            along().fold(f32::MIN, f32::max),
            bounds.max[axis],
            "{name}: highest on axis {axis}"
        );
    }
    let length = |v: [f32; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let normals: Vec<[f32; 3]> = reader.read_normals().expect("normals").collect();
    assert_eq!(normals.len(), positions.len());
    assert!(
        normals.iter().all(|n| (length(*n) - 1.0).abs() < 1e-3),
        "{name}: unit normals"
    );
    if let Some(tangents) = reader.read_tangents() {
        let mut count = 0;
        for [x, y, z, sign] in tangents {
            assert!(
                (length([x, y, z]) - 1.0).abs() < 1e-3 && sign == 1.0,
                "{name}: unit tangents"
            );
            count += 1;
        }
        assert_eq!(count, positions.len());
    }
    if primitive.material().normal_texture().is_some() {
        assert!(
            reader.read_tangents().is_some(),
            "{name}: a normal picture without tangents"
        );
    }
    let uvs = reader.read_tex_coords(0).expect("coordinates").into_f32();
    assert!(uvs.flatten().all(f32::is_finite), "{name}");
    let indices: Vec<u32> = reader.read_indices().expect("indices").into_u32().collect();
    assert_eq!(indices.len() % 3, 0);
    assert!(
        indices.iter().all(|index| (*index as usize) < positions.len()),
        "{name}: indices in range"
    );
}

#[test]
fn all_files_are_there_sound_and_small_enough() {
    let mut total = 0;
    for asset in assets() {
        total += committed(asset.name).len();
        let (file, binary) = read(asset.name);
        for mesh in file.meshes() {
            for primitive in mesh.primitives() {
                check(mesh.name().unwrap_or(asset.name), &primitive, &binary);
            }
        }
        for texture in file.textures() {
            assert!(file.images().nth(texture.source().index()).is_some());
        }
    }
    assert!(total < BUDGET, "{total} bytes");
}

#[test]
fn no_other_models_lie_about() {
    let folder = path("x").parent().expect("a folder").to_owned();
    for entry in fs::read_dir(folder).expect("the folder of models") {
        let file = entry.expect("readable").path();
        let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let known = assets().iter().any(|asset| asset.name == name);
        let is_model = file.extension().is_some_and(|extension| extension == "glb");
        assert!(known || !is_model, "{} is made by no recipe", file.display());
    }
}

#[test]
fn the_code_makes_the_committed_bytes() {
    for name in ["fern", "deadwood", "facades"] {
        let asset = assets().iter().find(|asset| asset.name == name).expect("the asset");
        assert!(asset.forge() == committed(name), "{name} is stale: run `umbrage forge`");
    }
}

#[test]
fn levels_of_detail_grow_coarser() {
    for asset in assets() {
        let (file, _) = read(asset.name);
        let mut before: Option<(String, usize)> = None;
        for node in file.nodes().filter(|node| node.mesh().is_some()) {
            let name = node.name().expect("a name");
            let (variant, level) = name.split_once("_LOD").expect("a level in the name");
            let count = triangles(&node.mesh().expect("a mesh"));
            assert!(count > 0, "{name}");
            match &before {
                Some((last, finer)) if last == variant => {
                    assert!(count * 3 < finer * 2, "{name} has {count} triangles after {finer}");
                }
                _ => assert_eq!(level, "0"),
            }
            before = Some((variant.to_owned(), count));
        }
    }
}

#[test]
fn trees_have_two_shapes_of_four_levels_with_an_impostor() {
    for name in TREES {
        let (file, binary) = read(name);
        assert_eq!(file.scenes().count(), 2, "{name}");
        assert_eq!(file.nodes().count(), 8, "{name}");
        for (index, node) in file.nodes().enumerate() {
            let mesh = node.mesh().expect("a mesh");
            match index % 4 {
                0 => {
                    let count = triangles(&mesh);
                    assert!((3_000..=15_000).contains(&count), "{name}: {count} triangles");
                    assert_eq!(mesh.primitives().count(), 2, "{name}: wood and leaves");
                    let reader = mesh.primitives().next().expect("wood");
                    let wood = reader.reader(|_| Some(&binary));
                    let height = wood
                        .read_positions()
                        .expect("positions")
                        .map(|p| p[1])
                        .fold(0.0, f32::max);
                    assert!((8.0..22.0).contains(&height), "{name} is {height} m high");
                }
                3 => {
                    let material = mesh.primitives().next().expect("cards").material();
                    let views = material.extras().as_ref().expect("views").get();
                    assert!(views.contains("hemi-octahedral"), "{name}: {views}");
                    assert!(material.normal_texture().is_some());
                }
                _ => {}
            }
        }
    }
}

#[test]
fn leaves_are_masked_cards_with_thickness() {
    for name in TREES.into_iter().chain(["bush", "fern", "grass"]) {
        let (file, binary) = read(name);
        let leaves: Vec<_> = file
            .materials()
            .filter(|material| material.volume().is_some())
            .collect();
        assert!(!leaves.is_empty(), "{name}");
        for material in leaves {
            assert_eq!(material.alpha_mode(), AlphaMode::Mask);
            assert!(material.double_sided());
            let volume = material.volume().expect("checked");
            let metres = volume.thickness_factor();
            assert!(metres > 0.0 && metres < 0.01, "{name}: {metres}");
            assert!(volume.thickness_texture().is_some(), "{name}");
            let texture = material
                .pbr_metallic_roughness()
                .base_color_texture()
                .expect("a picture");
            let gltf::image::Source::View { view, .. } = texture.texture().source().source() else {
                panic!("{name}: pictures are inside the file");
            };
            let png = &binary[view.offset()..view.offset() + view.length()];
            let picture = image::load_from_memory(png).expect("a PNG file").into_rgba8();
            assert!(picture.width() <= 512 && picture.height() <= 512, "{name}");
            let texels: Vec<[u8; 4]> = picture.pixels().map(|pixel| pixel.0).collect();
            let covered = coverage(&texels, material.alpha_cutoff().unwrap_or(0.5));
            assert!(
                (0.12..0.6).contains(&covered),
                "{name}: leaves cover {covered} of their cards"
            );
        }
    }
}
