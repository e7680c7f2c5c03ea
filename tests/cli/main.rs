//! The command line as its users meet it: exit codes, sentences, files.

mod arguments;
mod bench;
mod failures;
mod forge;
mod glb;
mod judge;
mod pictures;
mod play;
mod stability;

use std::{
    path::Path,
    process::{Command, Output},
};

/// The executable under test.
fn umbrage() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbrage"));
    command.env_remove("UMBRAGE_ASSETS");
    // Mesa's device selection layer complains on stderr where there is no Wayland session.
    command.env("NODEVICE_SELECT", "1");
    command
}

/// Runs `umbrage` with arguments separated by spaces, in a folder.
fn run_in(folder: &Path, arguments: &str) -> Output {
    let mut command = umbrage();
    command.current_dir(folder).args(arguments.split_whitespace());
    command.output().expect("the executable starts")
}

/// What was written to stderr.
fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Asserts an exit code and that stderr is one sentence with these parts.
#[track_caller]
fn assert_sentence(output: &Output, code: i32, parts: &[&str]) {
    let text = stderr(output);
    assert_eq!(output.status.code(), Some(code), "{text}");
    for part in parts {
        assert!(text.contains(part), "{text:?} lacks {part:?}");
    }
    assert!(!text.contains("panicked"), "{text}");
    if code == 1 {
        assert_eq!(text.trim_end().lines().count(), 1, "more than a sentence: {text}");
        assert!(text.starts_with("umbrage: "), "{text}");
    }
}
