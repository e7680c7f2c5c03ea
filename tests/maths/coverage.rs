//! `src/maths/COVERAGE.md` names every feature once, and nothing that is not there.

use std::{
    fs,
    path::{Path, PathBuf},
};

const COVERAGE: &str = include_str!("../../src/maths/COVERAGE.md");

/// Papers whose features are numbered, and how many they have.
const PAPERS: [(&str, usize); 3] = [("## Stingl 2011", 91), ("## Lloyd, Tuft", 42), ("## Scherzer 2005", 31)];

/// The oracles of Chong 2003.
const ORACLES: &str = "## Oracles of light planes";

/// Rows that may stay visualisations of another issue.
const VISUALISATIONS: std::ops::RangeInclusive<usize> = 67..=91;

struct Row {
    paper: &'static str,
    number: String,
    state: String,
    code: String,
    tests: String,
}

/// The cells of a table's line.
fn cells(line: &str) -> Vec<String> {
    let line = line.trim().trim_start_matches('|').trim_end_matches('|');
    line.split('|').map(|cell| cell.trim().to_owned()).collect()
}

/// Rows of the section that begins with `heading`, without the table's head.
fn rows(heading: &'static str) -> Vec<Row> {
    let start = COVERAGE.find(heading).unwrap_or_else(|| panic!("no section {heading}"));
    let section = &COVERAGE[start + heading.len()..];
    let section = &section[..section.find("\n## ").unwrap_or(section.len())];
    let lines = section.lines().filter(|line| line.starts_with('|')).skip(2);
    lines
        .map(|line| match cells(line).as_slice() {
            [number, _, state, code, tests] => Row {
                paper: heading,
                number: number.clone(),
                state: state.clone(),
                code: code.clone(),
                tests: tests.clone(),
            },
            [what, state, code, tests] => Row {
                paper: heading,
                number: what.clone(),
                state: state.clone(),
                code: code.clone(),
                tests: tests.clone(),
            },
            other => panic!("{heading}: {} cells in {line}", other.len()),
        })
        .collect()
}

fn numbered_rows() -> impl Iterator<Item = Row> {
    PAPERS.into_iter().flat_map(|(heading, _)| rows(heading))
}

fn all_rows() -> impl Iterator<Item = Row> {
    numbered_rows()
        .chain(rows("## Beyond these three"))
        .chain(rows(ORACLES))
}

/// What stands between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

fn crate_folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every file below some folders with one of some endings.
fn files(folders: &[&str], endings: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders: Vec<PathBuf> = folders.iter().map(|folder| crate_folder().join(folder)).collect();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path
                .extension()
                .is_some_and(|ending| endings.iter().any(|wanted| ending == *wanted))
            {
                found.push(path);
            }
        }
    }
    found
}

fn text_of(folders: &[&str], endings: &[&str]) -> String {
    let texts = files(folders, endings);
    texts.iter().filter_map(|path| fs::read_to_string(path).ok()).collect()
}

#[test]
fn every_feature_has_one_row() {
    for (heading, count) in PAPERS {
        let numbers: Vec<String> = rows(heading).into_iter().map(|row| row.number).collect();
        let expected: Vec<String> = (1..=count).map(|number| number.to_string()).collect();
        assert_eq!(numbers, expected, "{heading}");
    }
}

#[test]
fn every_oracle_of_light_planes_has_one_row() {
    let numbers: Vec<String> = rows(ORACLES).into_iter().map(|row| row.number).collect();
    let expected: Vec<String> = (1..=23).map(|number| format!("O{number}")).collect();
    assert_eq!(numbers, expected);
}

/// Tests of light planes are named without their folder, several as `file::{a, b}`: every word with underscores in the last
/// column is a test or a file of tests.
#[test]
fn tests_of_light_planes_exist() {
    let text = text_of(&["src", "tests"], &["rs"]);
    let mut names = 0;
    for heading in ["## Light planes in flatland", "## Light planes in space"] {
        for row in rows(heading) {
            let words = row
                .tests
                .split(|character: char| !(character.is_alphanumeric() || "_*.".contains(character)));
            for word in words.filter(|word| word.contains('_') && !word.contains(['*', '.'])) {
                let exists = ["fn", "mod"].into_iter().any(|kind| {
                    [format!("{kind} {word}("), format!("{kind} {word};")]
                        .iter()
                        .any(|declared| text.contains(declared))
                });
                assert!(exists, "{heading} {}: no test {word}", row.number);
                names += 1;
            }
        }
    }
    assert!(names > 80, "{names} tests are named");
}

#[test]
fn states_are_those_that_the_page_explains() {
    for row in all_rows() {
        let Row {
            paper, number, state, ..
        } = &row;
        let kind = ["done", "replaced", "not applicable", "open", "later"]
            .into_iter()
            .find(|kind| state.starts_with(kind));
        let kind = kind.unwrap_or_else(|| panic!("{paper} {number}: state {state}"));
        let says_why = state.len() > kind.len() + 10;
        match kind {
            "done" | "replaced" => assert!(row.tests.contains("::"), "{paper} {number} has no test"),
            "later" => assert!(
                row.number.parse().is_ok_and(|number| VISUALISATIONS.contains(&number)) || says_why,
                "{paper} {number} is late without a reason"
            ),
            _ => {}
        }
        assert!(kind == "done" || kind == "later" || says_why, "{paper} {number}: why?");
    }
    for (heading, count) in PAPERS {
        let left_out = rows(heading)
            .iter()
            .filter(|row| row.state.starts_with("not applicable"))
            .count();
        assert!(
            left_out * 10 <= count,
            "{heading}: {left_out} of {count} are not applicable"
        );
    }
}

/// `folder/file::test` is a function in `tests/folder/file.rs`; `src/…` in a file of the crate.
#[test]
fn every_named_test_exists() {
    let mut names = 0;
    for row in all_rows() {
        for name in quoted(&row.tests) {
            let (file, test) = name.split_once("::").unwrap_or_else(|| panic!("{name} is no test"));
            let folder = if file.starts_with("src/") { "" } else { "tests" };
            let path = crate_folder().join(folder).join(file).with_extension("rs");
            let text = fs::read_to_string(&path).unwrap_or_else(|_| panic!("{}: no file {file}", row.number));
            assert!(
                text.contains(&format!("fn {test}(")),
                "{} {}: no test {name}",
                row.paper,
                row.number
            );
            names += 1;
        }
    }
    assert!(names > 150, "{names} tests are named");
}

/// Paths, keys, file names and figures in the column of code are there.
#[test]
fn every_named_piece_of_code_exists() {
    let text = text_of(&["src", "shaders"], &["rs", "wgsl"]);
    let words: std::collections::HashSet<&str> = text
        .split(|character: char| !(character.is_alphanumeric() || character == '_'))
        .collect();
    for row in all_rows() {
        for name in quoted(&row.code) {
            let exists = if name.ends_with(".wgsl") || name.ends_with(".ron") {
                crate_folder().join(name).is_file()
            } else if name.contains("::") {
                name.split("::").all(|word| words.contains(word))
            } else {
                // Keys, texts of techniques, commands, figures and single names: each of their words.
                let parts = name.split(|character: char| !(character.is_alphanumeric() || "_-".contains(character)));
                let mut parts = parts.filter(|part| part.len() > 2 && !part.starts_with("zp"));
                parts.all(|part| words.contains(part) || text.contains(&format!("\"{part}\"")) || text.contains(part))
            };
            assert!(exists, "{} {}: no {name}", row.paper, row.number);
        }
    }
}
