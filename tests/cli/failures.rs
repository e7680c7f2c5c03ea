//! What cannot be done: exit code 1 and one sentence, no panic, no half-written file.

use std::fs;

use crate::{assert_sentence, glb, run_in, umbrage};

const SHOT: &str = r#"{"name":"front","position":[6,5,8],"target":[0,1,0],"light_dir":[-1,-2,-0.5]}"#;

#[test]
fn wrong_scene_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = glb::bytes(&glb::box_on_plane());
    fs::write(folder.path().join("short.glb"), &whole[..whole.len() / 2]).expect("written");
    fs::write(folder.path().join("empty.glb"), b"").expect("written");
    fs::write(folder.path().join("text.glb"), b"these are not the bytes of a scene").expect("written");
    for (scene, parts) in [
        ("missing.glb", &["missing.glb", "no such file"][..]),
        ("short.glb", &["short.glb", "truncated"]),
        ("empty.glb", &["empty.glb", "empty"]),
        ("text.glb", &["text.glb", "glTF"]),
        ("no_such_level", &["no_such_level", "forest"]),
    ] {
        assert_sentence(&run_in(folder.path(), &format!("shoot {scene}")), 1, parts);
        assert!(!folder.path().join("out").exists(), "{scene}: nothing is begun");
    }
}

#[test]
fn wrong_shots_files() {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("box.glb"), &glb::box_on_plane());
    for (text, parts) in [
        ("{\"shots\":[".to_owned(), &["shots.json", "not JSON"][..]),
        ("{\"shots\":7}".to_owned(), &["no list `shots`"]),
        (
            format!("{{\"shots\":[{}]}}", SHOT.replace("[6,5,8]", "[NaN,5,8]")),
            &["not JSON"],
        ),
        (
            format!("{{\"shots\":[{}]}}", SHOT.replace("[6,5,8]", "[1e99,5,8]")),
            &["`front`", "`position`"],
        ),
        (
            format!("{{\"shots\":[{}]}}", SHOT.replace("[6,5,8]", "[0,1,0]")),
            &["`front`", "same point"],
        ),
        (
            format!("{{\"shots\":[{}]}}", SHOT.replace("[-1,-2,-0.5]", "[0,0,0]")),
            &["`front`", "`light_dir` is zero"],
        ),
        (
            format!("{{\"shots\":[{}]}}", SHOT.replace("light_dir", "sun")),
            &["`front`", "`light_dir` is missing"],
        ),
    ] {
        fs::write(folder.path().join("shots.json"), &text).expect("written");
        assert_sentence(&run_in(folder.path(), "shoot box.glb --shots shots.json"), 1, parts);
    }
    assert_sentence(
        &run_in(folder.path(), "shoot box.glb --shots none.json"),
        1,
        &["none.json"],
    );
}

#[test]
fn the_output_folder_is_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("box.glb"), &glb::box_on_plane());
    fs::write(folder.path().join("taken"), b"kept").expect("written");
    let output = run_in(folder.path(), "shoot box.glb --out taken");
    assert_sentence(&output, 1, &["taken", "is a file"]);
    assert_eq!(fs::read(folder.path().join("taken")).expect("there"), b"kept");
}

#[test]
#[cfg(target_os = "linux")]
fn no_graphics_adapter() {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("box.glb"), &glb::box_on_plane());
    let mut command = umbrage();
    command
        .current_dir(folder.path())
        .args(["shoot", "box.glb"])
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env("VK_ICD_FILENAMES", "/nonexistent");
    let output = command.output().expect("the executable starts");
    assert_sentence(
        &output,
        1,
        &["no graphics adapter", "mesa-vulkan-drivers", "VK_DRIVER_FILES"],
    );
}

#[test]
fn shots_that_are_not_there() {
    let folder = tempfile::tempdir().expect("a folder");
    glb::write(&folder.path().join("box.glb"), &glb::box_on_plane());
    fs::write(folder.path().join("shots.json"), format!("{{\"shots\":[{SHOT}]}}")).expect("written");
    let output = run_in(folder.path(), "shoot box.glb --shots shots.json --shot back");
    assert_sentence(&output, 2, &["no shot `back`", "front"]);
    let other = SHOT.replace("{\"name\"", "{\"scene\":\"tower\",\"name\"");
    fs::write(folder.path().join("other.json"), format!("{{\"shots\":[{other}]}}")).expect("written");
    let output = run_in(folder.path(), "shoot box.glb --shots other.json");
    assert_sentence(&output, 1, &["no shots for box", "tower"]);
}
