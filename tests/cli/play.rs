//! `play` where no window can be opened.

use std::{fs, path::Path};

use crate::{assert_sentence, stderr, umbrage};

fn play_without_display(folder: &Path, arguments: &[&str]) -> std::process::Output {
    let mut command = umbrage();
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command.current_dir(folder).arg("play").args(arguments);
    command.output().expect("the executable starts")
}

#[test]
#[cfg(target_os = "linux")]
fn without_a_display_a_flight_is_rendered() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = play_without_display(folder.path(), &["room/plane_box", "--technique", "lispsm:size=512"]);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{text}");
    assert!(text.contains("DISPLAY is not set") && text.contains("out/"), "{text}");
    let picture = |number: u32| {
        let name = format!("room-plane-box_flight-{number:02}_lispsm-size-512_beauty.png");
        let path = folder.path().join("out").join(name);
        image::open(&path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
            .into_rgb8()
    };
    for number in 1..=8 {
        assert_eq!(picture(number).dimensions(), (480, 270));
    }
    assert_ne!(picture(1), picture(4), "the camera does not move");
    let pictures = fs::read_dir(folder.path().join("out")).expect("a folder").count();
    assert_eq!(pictures, 9, "eight pictures and stats.json");
}

#[test]
fn a_scene_that_does_not_exist_is_a_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = play_without_display(folder.path(), &["nowhere"]);
    assert_sentence(&output, 1, &["nowhere", "forest"]);
    assert!(!folder.path().join("out").exists(), "nothing is rendered");
}
