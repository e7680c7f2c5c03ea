//! Levels of detail in glTF files that know nothing of this project.

use std::fs;

use bevy::prelude::*;
use umbrage::{
    level::{
        LoadedScene,
        gltf_lods::{DEFAULT_COVERAGE, NodeChain, chains},
        scene::SceneSource,
    },
    lod::chain::LodChain,
};

use crate::{
    loading::{app_with, count, positions, request, wait},
    sources::{glb, root},
};

fn document(nodes: &str) -> gltf_json::Root {
    serde_json::from_str(&format!(r#"{{"asset":{{"version":"2.0"}},"nodes":{nodes}}}"#)).expect("a document")
}

/// The only chain, or the only sentence.
fn read(nodes: &str) -> Result<NodeChain, String> {
    let (mut chains, mut notes) = chains(&document(nodes));
    assert_eq!(chains.len() + notes.len(), 1, "{chains:?} {notes:?}");
    chains.pop().ok_or_else(|| notes.pop().expect("a sentence"))
}

#[test]
fn the_extension_names_coarser_nodes() {
    let chain = read(
        r#"[{"name":"far"},{"name":"near","extensions":{"MSFT_lod":{"ids":[2,0]}},
            "extras":{"MSFT_screencoverage":[0.5,0.2,0.01]}},{"name":"middle"}]"#,
    );
    let expected = NodeChain {
        nodes: vec![1, 2, 0],
        coverages: vec![0.5, 0.2, 0.01],
    };
    assert_eq!(chain, Ok(expected));
}

#[test]
fn endings_of_names_make_chains_of_nodes_beside_each_other() {
    let (found, notes) = chains(&document(
        r#"[{"name":"Oak_LOD1"},{"name":"Oak_LOD0"},{"name":"house","children":[3,4]},
            {"name":"door_lod0"},{"name":"door_lod1"},{"name":"Oak_LOD2"},{"name":"lamp_LOD0"},{"name":"x_LODs"}]"#,
    ));
    assert!(notes.is_empty(), "{notes:?}");
    let nodes: Vec<Vec<usize>> = found.iter().map(|chain| chain.nodes.clone()).collect();
    assert_eq!(nodes, [vec![1, 0, 5], vec![3, 4]]);
    assert_eq!(found[0].coverages, [DEFAULT_COVERAGE, DEFAULT_COVERAGE / 3.0, 0.0]);
    assert_eq!(found[1].coverages, [DEFAULT_COVERAGE, 0.0]);
}

#[test]
fn a_node_belongs_to_one_chain() {
    let chain = read(r#"[{"name":"a_LOD0","extensions":{"MSFT_lod":{"ids":[1]}}},{"name":"a_LOD1"}]"#);
    assert_eq!(chain.map(|chain| chain.nodes), Ok(vec![0, 1]));
    let (none, notes) = chains(&document(r#"[{"name":"a"},{"extensions":{"MSFT_lod":{"ids":[]}}}]"#));
    assert!(none.is_empty() && notes.is_empty(), "{notes:?}");
}

#[test]
fn what_is_wrong_is_said_in_a_sentence() {
    for (nodes, parts) in [
        (
            r#"[{"name":"a","extensions":{"MSFT_lod":{"ids":[7]}}}]"#,
            ["node a", "the node 7"],
        ),
        (r#"[{"extensions":{"MSFT_lod":{"ids":[0]}}}]"#, ["GltfNode0", "twice"]),
        (
            r#"[{"name":"a","extensions":{"MSFT_lod":{"ids":"b"}}}]"#,
            ["node a", "no list"],
        ),
        (
            r#"[{"name":"a_LOD0"},{"name":"a_LOD2"}]"#,
            ["a_LOD0", "no single node of level 1"],
        ),
        (
            r#"[{"name":"a_LOD0"},{"name":"a_LOD0"}]"#,
            ["a_LOD0", "no single node of level 1"],
        ),
        (
            r#"[{"name":"a_LOD0","extras":{"MSFT_screencoverage":[0.5]}},{"name":"a_LOD1"}]"#,
            ["2 levels", "[0.5]"],
        ),
        (
            r#"[{"name":"a_LOD0","extras":{"MSFT_screencoverage":[5,0]}},{"name":"a_LOD1"}]"#,
            ["2 levels", "between 0 and 1"],
        ),
    ] {
        let sentence = read(nodes).expect_err(nodes);
        for part in parts {
            assert!(sentence.contains(part), "{sentence} lacks {part}");
        }
        assert_eq!(sentence.lines().count(), 1, "{sentence}");
    }
}

/// Nodes with the same triangle of 2 m, of which the scene holds some.
fn file(nodes: &str, scene: &str) -> Vec<u8> {
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["MSFT_lod"],"scene":0,"scenes":[{{"nodes":{scene}}}],
        "nodes":{nodes},
        "materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[1,0,0,1]}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[2,2,0]}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36}}]}}"#
    );
    glb(&json, &positions(), 0)
}

/// Loads a file; its chains as numbers of parts per level, borders in metres and middles.
fn load(bytes: &[u8]) -> (App, Vec<(Vec<usize>, Vec<f64>, Vec3)>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.glb");
    fs::write(&path, bytes).unwrap();
    let mut app = app_with(&root());
    request(&mut app, SceneSource::Gltf(path));
    wait(&mut app).unwrap();
    app.update();
    let world = app.world_mut();
    let mut query = world.query::<(&LodChain, &Transform)>();
    let chains = query
        .iter(world)
        .map(|(chain, place)| {
            let parts = chain.levels.iter().map(Vec::len).collect();
            assert!(
                chain
                    .levels
                    .iter()
                    .flatten()
                    .all(|part| world.get::<Mesh3d>(*part).is_some())
            );
            (parts, chain.borders.as_slice().to_vec(), place.translation)
        })
        .collect();
    (app, chains)
}

#[test]
fn an_ordinary_file_with_names_gets_its_chain() {
    let nodes = r#"[{"name":"tree_LOD0","children":[2],"translation":[10,0,0]},{"name":"tree_LOD1","mesh":0,
        "translation":[10,0,0]},{"name":"crown","mesh":0},{"name":"rock","mesh":0}]"#;
    let (mut app, chains) = load(&file(nodes, "[0,1,3]"));
    // 2 m cover 0.35 of a picture of 60 degrees at 4.95 m: whole metres.
    assert_eq!(chains, [(vec![1, 1], vec![5.0], Vec3::new(11.0, 1.0, 0.0))]);
    assert_eq!(count::<Mesh3d>(&mut app), 3);
    assert_eq!(
        app.world().resource::<LoadedScene>().notes.len(),
        1,
        "only that of the shot"
    );
}

/// Nodes of coarser levels that stand in no scene are spawned beside the finest.
#[test]
fn the_extension_brings_nodes_from_outside_the_scene() {
    let nodes = r#"[{"name":"a","mesh":0,"extensions":{"MSFT_lod":{"ids":[1,2]}},
        "extras":{"MSFT_screencoverage":[0.5,0.25,0.1]}},
        {"name":"b","mesh":0,"scale":[2,2,2]},{"name":"c","children":[3]},{"name":"d","mesh":0,"translation":[0,3,0]},
        {"name":"town","translation":[0,0,5],"children":[0]}]"#;
    let (mut app, chains) = load(&file(nodes, "[4]"));
    // 2 m at 0.5, 0.25 and 0.1: 3.46, 6.93 and 17.3 m.
    assert_eq!(
        chains,
        [(vec![1, 1, 1], vec![4.0, 7.0, 18.0], Vec3::new(1.0, 1.0, 5.0))]
    );
    assert_eq!(count::<Mesh3d>(&mut app), 3);
    let world = app.world_mut();
    let mut parts = world.query::<(&GlobalTransform, &MeshMaterial3d<StandardMaterial>)>();
    let places: Vec<Vec3> = parts.iter(world).map(|(place, _)| place.translation()).collect();
    assert!(places.contains(&Vec3::new(0.0, 3.0, 5.0)), "{places:?}");
}

#[test]
fn a_wrong_file_is_shown_as_it_is_with_a_sentence() {
    let (app, chains) = load(&file(r#"[{"mesh":0,"extensions":{"MSFT_lod":{"ids":[9]}}}]"#, "[0]"));
    assert_eq!(chains, []);
    let notes = &app.world().resource::<LoadedScene>().notes;
    assert!(notes.iter().any(|note| note.contains("the node 9")), "{notes:?}");
}
