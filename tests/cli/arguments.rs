//! Wrong arguments, help and lists: nothing here needs a graphics adapter.

use crate::{assert_sentence, run_in};

#[test]
fn wrong_arguments_exit_with_two_and_say_what_there_is() {
    let folder = tempfile::tempdir().expect("a folder");
    for (arguments, parts) in [
        ("dance", &["dance", "--help"][..]),
        ("shoot", &["SCENE"]),
        ("shoot a.glb --size 0x9", &["0x9", "1280x720"]),
        ("shoot a.glb --size 9000x9", &["9000x9", "8192"]),
        ("shoot a.glb --technique blur", &["blur", "zp16", "lispsm"]),
        ("shoot a.glb --technique optimum", &["no technique `optimum`", "fitted"]),
        ("shoot a.glb --technique zp4:colour=1", &["colour", "lambda", "filter"]),
        ("shoot a.glb --passes beauty,glow", &["glow", "mask"]),
        ("shoot a.glb --shard 3/2", &["3/2", "I/N"]),
        ("shoot what?", &["what?", "level name"]),
        ("bench", &["SCENE"]),
        ("bench forest --frames 0", &["0", "1..=100000"]),
        ("bench forest --frames some", &["some"]),
        ("bench forest --against stock", &["stock", "bevy", "lispsm"]),
        ("bench forest --size 1x9000", &["1x9000", "8192"]),
        ("play --preset best", &["best", "ultra"]),
        ("list", &["techniques"]),
    ] {
        assert_sentence(&run_in(folder.path(), arguments), 2, parts);
    }
}

#[test]
fn help_and_version_exit_with_zero() {
    let folder = tempfile::tempdir().expect("a folder");
    for arguments in ["--help", "--version", "shoot --help", "help list"] {
        let output = run_in(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments}");
        assert!(!output.stdout.is_empty(), "{arguments}");
    }
}

#[test]
fn lists_are_complete() {
    let folder = tempfile::tempdir().expect("a folder");
    for (what, names) in [
        ("passes", &["beauty", "lit", "mask", "depth", "normal"][..]),
        ("plots", &["lloyd-fig7-hemisphere", "stingl-fig2-8-error-of-warps"]),
        (
            "techniques",
            &["bevy", "uniform", "lispsm", "zp4+lispsm", "ultra", "bias_scale"],
        ),
    ] {
        let output = run_in(folder.path(), &format!("list {what}"));
        let text = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{what}");
        for name in names {
            let listed = text.lines().any(|line| line.split_whitespace().next() == Some(name));
            assert!(listed, "{what} lacks {name}: {text}");
        }
    }
}

#[test]
fn listed_techniques_are_accepted() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = run_in(folder.path(), "list techniques");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for line in text.lines().take_while(|line| !line.is_empty()) {
        let technique = line.split_whitespace().next().expect("a name");
        // The scene is missing, which is only noticed once the arguments are understood.
        assert_sentence(
            &run_in(folder.path(), &format!("shoot none.glb --technique {technique}")),
            1,
            &["none.glb"],
        );
    }
}
