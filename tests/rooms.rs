//! Imports between the rooms of the crate point down only, and `maths` knows nothing of Bevy's engine.
//!
//! ```text
//! cli ──► demo, ui ──► level ──► render ──► shadow, lod ──► maths
//! ```

use std::{fs, path::Path};

/// Rooms from the ground floor up. A room may import from those on lower floors; rooms on one floor are strangers.
const FLOORS: &[&[&str]] = &[
    &["maths"],
    &["shadow", "lod", "shaders", "forge"],
    &["render"],
    &["level"],
    &["ui", "plot"],
    &["demo"],
    &["cli"],
];

/// `lib.rs` and `main.rs` stand outside the house.
const OUTSIDE: &[&str] = &["lib", "main"];

fn floor(room: &str) -> Option<usize> {
    FLOORS.iter().position(|rooms| rooms.contains(&room))
}

/// What is wrong with a source file of a room: one sentence per forbidden reference.
fn complaints(room: &str, source: &str) -> Vec<String> {
    let code = without_comments(source);
    let mut complaints = Vec::new();
    let Some(own_floor) = floor(room) else {
        return vec![format!("room `{room}` has no floor in tests/rooms.rs")];
    };
    for target in referenced_rooms(&code) {
        if target == room {
            continue;
        }
        match floor(&target) {
            None => complaints.push(format!("`{room}` refers to `crate::{target}`, which is no room")),
            Some(target_floor) if target_floor >= own_floor => {
                complaints.push(format!("`{room}` must not import from `{target}`"));
            }
            Some(_) => {}
        }
    }
    if room == "maths" {
        let derive = "derive(bevy::reflect::Reflect)";
        for (number, line) in code.lines().enumerate() {
            let rest = line.replace(derive, "");
            if rest.contains("bevy::") || rest.trim_start().starts_with("use bevy;") {
                complaints.push(format!(
                    "`maths` refers to Bevy's engine in line {}: {}",
                    number + 1,
                    line.trim()
                ));
            }
        }
    }
    complaints
}

fn without_comments(source: &str) -> String {
    source
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default())
        .collect::<Vec<_>>()
        .join("\n")
}

/// First path segments after every `crate::`, those inside braces included.
fn referenced_rooms(code: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    for (position, path) in code.match_indices("crate::") {
        let is_own_word = !code[..position].ends_with(|before: char| before.is_alphanumeric() || before == '_');
        if !is_own_word {
            continue;
        }
        let rest = code[position + path.len()..].trim_start();
        if let Some(group) = rest.strip_prefix('{') {
            rooms.extend(group_heads(group));
        } else {
            rooms.push(identifier(rest));
        }
    }
    rooms.retain(|room| !room.is_empty());
    rooms
}

/// First segments of the paths in a `use` group, whose opening brace has been read.
fn group_heads(group: &str) -> Vec<String> {
    let mut heads = Vec::new();
    let mut depth = 0;
    let mut at_head = true;
    for (position, character) in group.char_indices() {
        match character {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => at_head = true,
            _ if at_head && !character.is_whitespace() => {
                heads.push(identifier(&group[position..]));
                at_head = false;
            }
            _ => {}
        }
    }
    heads
}

fn identifier(text: &str) -> String {
    text.chars()
        .take_while(|character| character.is_alphanumeric() || *character == '_')
        .collect()
}

/// Every source file with the room it stands in.
fn sources(folder: &Path, room: Option<&str>, found: &mut Vec<(String, String, String)>) {
    for entry in fs::read_dir(folder).expect("the source folder is readable") {
        let path = entry.expect("the source folder is readable").path();
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let own_room = room.unwrap_or(&name).to_owned();
        if path.is_dir() {
            sources(&path, Some(&own_room), found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = fs::read_to_string(&path).expect("sources are UTF-8");
            found.push((own_room, path.display().to_string(), text));
        }
    }
}

#[test]
fn imports_point_down() {
    let mut found = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), None, &mut found);
    found.retain(|(room, ..)| !OUTSIDE.contains(&room.as_str()));
    assert!(found.len() > 10, "the sources are found: {} files", found.len());
    let complaints: Vec<String> = found
        .iter()
        .flat_map(|(room, path, text)| {
            complaints(room, text)
                .into_iter()
                .map(move |complaint| format!("{path}: {complaint}"))
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn forbidden_imports_are_noticed() {
    for (room, source) in [
        ("maths", "use crate::shadow::settings::SunShadows;"),
        ("maths", "use crate::{maths::warp::Warp, render::UmbragePlugins};"),
        ("maths", "use bevy::prelude::*;"),
        ("maths", "fn f(x: bevy::math::Vec3) {}"),
        (
            "shadow",
            "use crate::{\n    maths::{split::SplitScheme, warp::Warp},\n    level::shot::Shot,\n};",
        ),
        ("shadow", "use crate::lod::Chain;"),
        ("render", "fn f() { crate::cli::main(); }"),
        ("level", "pub(crate) use crate::demo::run;"),
        ("ui", "use crate::demo::run;"),
        ("attic", ""),
        ("shadow", "use crate::attic::Box;"),
    ] {
        assert_eq!(complaints(room, source).len(), 1, "{room}: {source}");
    }
}

#[test]
fn allowed_imports_are_not_complained_about() {
    for (room, source) in [
        (
            "maths",
            "use bevy_math::DVec3;\n#[cfg_attr(feature = \"render\", derive(bevy::reflect::Reflect))]",
        ),
        ("maths", "use crate::maths::{split::SplitScheme, warp::Warp};"),
        ("maths", "//! See crate::render for bevy::render."),
        (
            "shadow",
            "use crate::{maths::{split::SplitScheme, warp::Warp}, shadow::views::SunViews};",
        ),
        (
            "render",
            "use crate::{maths::fit, shadow::settings::SunShadows, shaders};\nuse bevy::prelude::*;",
        ),
        ("demo", "pub(crate) fn f() { crate::ui::show(); }"),
        (
            "cli",
            "use crate::{demo, level, render, shadow, maths, ui, plot, forge};",
        ),
    ] {
        assert_eq!(complaints(room, source), Vec::<String>::new(), "{room}: {source}");
    }
}
