//! From the text of a `.level.ron` file to a checked [`Level`].

use ron::extensions::Extensions;

use super::{format::Level, validate::LevelError};

/// Reads and checks a level.
///
/// # Errors
/// What is wrong with the text, with line, column and field; or the first value that is out of its limits.
pub fn parse(bytes: &[u8]) -> Result<Level, LevelError> {
    let text = std::str::from_utf8(bytes).map_err(|_| LevelError::NotText)?;
    let options =
        ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME | Extensions::UNWRAP_VARIANT_NEWTYPES);
    let level: Level = options.from_str(text).map_err(|error| {
        let (line, column) = (error.span.end.line, error.span.end.col);
        LevelError::Syntax {
            line,
            column,
            field: field_before(text, line, column),
            message: error.code.to_string(),
        }
    })?;
    level.validate()?;
    Ok(level)
}

/// The last `field:` at or before a place in the text; comments do not count.
fn field_before(text: &str, line: usize, column: usize) -> String {
    let mut field = "the start of the file";
    for (i, content) in text.lines().take(line).enumerate() {
        let code = content.split("//").next().unwrap_or(content);
        for (at, _) in code.match_indices(':') {
            let head = &code[..at];
            let start = head
                .rfind(|letter: char| !(letter.is_alphanumeric() || letter == '_'))
                .map_or(0, |before| {
                    before + head[before..].chars().next().map_or(1, char::len_utf8)
                });
            let reached = i + 1 < line || head[..start].chars().count() < column;
            if start < at && reached {
                field = &head[start..];
            }
        }
    }
    field.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"Level(
    name: "test",
    about: "A test.",
    seed: 1,
    generator: Room(PlaneBox(side: 2.0)),
    terrain: (size: (60, 60)),
    sun: (
        light_dir: (1, -1, 0), day: 172,
        air: (aerosol_depth: 0.1),
    ),
    spawn: (position: (0, 2, 9), look_at: (0, 1, 0)),
    shots: [(name: "front", position: (0, 2, 9), target: (0, 1, 0), fov_y_deg: 60, near: 0.1, far: 100)],
)"#;

    #[test]
    fn a_small_level_is_read() {
        let level = parse(SMALL.as_bytes()).unwrap();
        assert_eq!(level.shots()[0].light_dir, [1.0, -1.0, 0.0]);
        assert_eq!(level.shots()[0].scene.as_deref(), Some("test"));
        assert_eq!((level.shots()[0].width, level.shots()[0].height), (1280, 720));
    }

    /// (what is replaced, by what, line, field, part of the message)
    const BROKEN: [(&str, &str, usize, &str, &str); 6] = [
        ("seed: 1", "seed: x", 4, "seed", "integer"),
        ("seed: 1", "seeed: 1", 4, "seeed", "seed"),
        ("seed: 1,", "", 13, "far", "seed"),
        ("near: 0.1", "near: 0.1, shadow: 1", 12, "shadow", "shadow"),
        ("PlaneBox(side: 2.0)", "PlaneBox(height: 2.0)", 5, "height", "side"),
        ("Room(PlaneBox", "Room(Cellar", 5, "generator", "Cellar"),
    ];

    #[test]
    fn syntax_errors_name_line_and_field() {
        for (from, to, at, named, part) in BROKEN {
            let text = SMALL.replace(from, to);
            match parse(text.as_bytes()) {
                Err(LevelError::Syntax {
                    line, field, message, ..
                }) => {
                    assert_eq!((line, field.as_str()), (at, named), "{to}: {message}");
                    assert!(message.contains(part), "{to}: {message}");
                }
                other => panic!("{to}: {other:?}"),
            }
        }
    }

    #[test]
    fn empty_and_binary_files_are_errors() {
        assert!(matches!(parse(b""), Err(LevelError::Syntax { line: 1, .. })));
        assert_eq!(parse(&[0xff, 0xfe, 0x00]), Err(LevelError::NotText));
    }
}
