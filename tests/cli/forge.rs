//! `umbrage forge` writes and compares models; nothing here needs a graphics adapter.

use std::{fs, path::Path};

use crate::{assert_sentence, run_in};

/// A folder that counts as a root: it has levels/.
fn root() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::create_dir(folder.path().join("levels")).expect("levels/");
    folder
}

#[test]
fn one_model_is_written_compared_and_found_stale() {
    let folder = root();
    let model = folder.path().join("assets/models/fern.glb");
    assert_sentence(
        &run_in(folder.path(), "forge --only fern --check"),
        1,
        &["fern.glb", "umbrage forge"],
    );
    assert!(!model.exists(), "--check writes nothing");
    let written = run_in(folder.path(), "forge --only fern --preview look");
    assert_eq!(written.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&written.stdout).starts_with("fern "));
    let committed = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/models/fern.glb");
    assert!(fs::read(&model).expect("written") == fs::read(committed).expect("committed"));
    for picture in ["look/fern_a.png", "look/fern_b.png"] {
        let (_, height) = image::image_dimensions(folder.path().join(picture)).expect("a picture");
        assert_eq!(height, 512);
    }
    assert_eq!(
        run_in(folder.path(), "forge --only fern --check").status.code(),
        Some(0)
    );
    let mut bytes = fs::read(&model).expect("written");
    *bytes.last_mut().expect("not empty") ^= 1;
    fs::write(&model, bytes).expect("changed");
    assert_sentence(
        &run_in(folder.path(), "forge --only fern --check"),
        1,
        &["fern.glb", "commit"],
    );
}

#[test]
fn unknown_models_and_impossible_folders_are_said() {
    let folder = root();
    assert_sentence(
        &run_in(folder.path(), "forge --only baobab"),
        2,
        &["baobab", "oak", "deadwood"],
    );
    fs::write(folder.path().join("assets"), "a file").expect("written");
    let output = run_in(folder.path(), "forge --only fern");
    assert_sentence(&output, 1, &["models"]);
}
