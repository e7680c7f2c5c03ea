//! What the command line writes for a scene, and files that are not glTF.

use std::{fs, path::Path};

use umbrage::level::{
    find::{self, AssetRoot},
    scene::{SceneError, SceneSource},
};

pub(crate) fn root() -> AssetRoot {
    find::asset_root(Some(Path::new(env!("CARGO_MANIFEST_DIR")))).unwrap()
}

#[test]
fn every_form_is_read_and_written_back() {
    for (text, name) in [
        ("forest", "forest"),
        ("room/fence", "room/fence"),
        ("stress_trees:count=1000", "stress_trees"),
        ("forest:count=500,seed=3", "forest"),
        ("some/path to/My Model.glb", "My Model"),
        ("../x.GLTF", "x"),
    ] {
        let source: SceneSource = text.parse().unwrap();
        assert_eq!(source.name(), name);
        assert_eq!(source.to_string(), text);
        assert_eq!(source.to_string().parse::<SceneSource>().unwrap(), source);
    }
}

#[test]
fn nonsense_is_an_error_that_quotes_it() {
    for text in [
        "",
        ":",
        "forest:",
        "a//b",
        "/forest",
        "forest ",
        "x.obj",
        "../forest",
        "forêt",
    ] {
        let error = text.parse::<SceneSource>().unwrap_err();
        assert!(error.to_string().contains(&format!("`{text}`")), "{error}");
    }
    for text in [
        "forest:count",
        "forest:=3",
        "forest:count=",
        "forest:count=1,count=2",
        "forest:count=1,,seed=2",
    ] {
        let error = text.parse::<SceneSource>().unwrap_err();
        assert!(matches!(error, SceneError::Setting { .. }), "{text}: {error}");
    }
}

#[test]
fn an_unknown_level_lists_what_there_is() {
    let error = SceneSource::level("forrest").check(&root()).unwrap_err().to_string();
    for name in ["forrest", "forest", "city", "room/plane_box", ".glb"] {
        assert!(error.contains(name), "{error}");
    }
    assert_eq!(SceneSource::level("room/wires").check(&root()), Ok(()));
}

/// A glb with these bytes as its JSON, padded; the declared length can be wrong by `lie`.
pub(crate) fn glb(json: &str, binary: &[u8], lie: i64) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut body = Vec::new();
    body.extend((json.len() as u32).to_le_bytes());
    body.extend(b"JSON");
    body.extend(&json);
    if !binary.is_empty() {
        body.extend((binary.len() as u32).to_le_bytes());
        body.extend(b"BIN\0");
        body.extend(binary);
    }
    let length = (12 + body.len() as i64 + lie) as u32;
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend(body);
    bytes
}

const JSON: &str = r#"{"asset":{"version":"2.0"}}"#;

#[test]
fn files_that_are_not_gltf_get_one_clear_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let good = glb(JSON, &[], 0);
    let mut old = good.clone();
    old[4] = 1;
    let mut chunk = good.clone();
    chunk[12..16].copy_from_slice(&9999u32.to_le_bytes());
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("empty.glb", vec![], "it is empty"),
        (
            "text.glb",
            b"hello, this is no model".to_vec(),
            "does not start with the letters glTF",
        ),
        ("magic.glb", b"glTF".to_vec(), "truncated"),
        ("short.glb", good[..good.len() - 4].to_vec(), "truncated"),
        ("lie.glb", glb(JSON, &[], 1000), "but has only"),
        ("old.glb", old, "its version is 1"),
        ("chunk.glb", chunk, "not a whole JSON chunk"),
        ("empty.gltf", vec![], "it is empty"),
        ("half.gltf", br#"{"asset": {"version""#.to_vec(), "truncated"),
        ("text.gltf", b"hello".to_vec(), "it is not JSON"),
        ("other.gltf", b"{}".to_vec(), "no `asset`"),
    ];
    for (file, bytes, part) in cases {
        let path = folder.path().join(file);
        fs::write(&path, bytes).unwrap();
        let error = SceneSource::Gltf(path).check(&root()).unwrap_err().to_string();
        assert!(error.contains(part) && error.contains(file), "{file}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    let missing = SceneSource::Gltf(folder.path().join("none.glb"))
        .check(&root())
        .unwrap_err()
        .to_string();
    assert!(missing.contains("there is no such file"), "{missing}");
    fs::create_dir(folder.path().join("folder.glb")).unwrap();
    let error = SceneSource::Gltf(folder.path().join("folder.glb"))
        .check(&root())
        .unwrap_err()
        .to_string();
    assert!(error.contains("folder"), "{error}");
    let path = folder.path().join("good.glb");
    fs::write(&path, good).unwrap();
    assert_eq!(SceneSource::Gltf(path).check(&root()), Ok(()));
}
