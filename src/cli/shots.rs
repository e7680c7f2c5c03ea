//! Shots: reading files of them, checking them, and choosing which to take.

use std::path::{Path, PathBuf};

use bevy::math::Vec3;
use serde_json::{Map, Value};
use thiserror::Error;

use crate::level::shot::Shot;

/// Widest and tallest picture, in pixels.
pub const MAX_SIZE: u32 = 8192;
/// Largest number in a place or a direction: squares of larger ones leave single precision.
const LARGEST: f32 = 1.0e9;

/// Why shots cannot be taken.
#[derive(Debug, Error)]
pub enum ShotError {
    /// The file cannot be read.
    #[error("cannot read the shots file {}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not JSON.
    #[error("the shots file {} is not JSON: {source}", file.display())]
    Json {
        /// The file.
        file: PathBuf,
        /// What and where.
        source: serde_json::Error,
    },
    /// The file is JSON of another shape.
    #[error("the shots file {} has no list `shots`; it looks like {EXAMPLE}", file.display())]
    Shape {
        /// The file.
        file: PathBuf,
    },
    /// A shot in a file is wrong.
    #[error("{}: shot {shot}: {problem}", file.display())]
    InFile {
        /// The file.
        file: PathBuf,
        /// The name of the shot, or its place in the list.
        shot: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A shot of a level is wrong.
    #[error("shot {shot} of {scene}: {problem}")]
    InScene {
        /// The scene.
        scene: String,
        /// The name of the shot.
        shot: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// The file has shots for other scenes only.
    #[error("{} has no shots for {scene}; it has shots for {available}", file.display())]
    NoneForScene {
        /// The file.
        file: PathBuf,
        /// The scene asked for.
        scene: String,
        /// The scenes named in the file.
        available: String,
    },
    /// `--shot` names what is not there.
    #[error("{scene} has no shot `{shot}`; it has {available}")]
    Unknown {
        /// The scene.
        scene: String,
        /// The name asked for.
        shot: String,
        /// The names that there are.
        available: String,
    },
}

const EXAMPLE: &str = r#"{"shots":[{"name":"front","position":[0,2,9],"target":[0,1,0],"light_dir":[-1,-2,-1]}]}"#;

/// Reads and checks a shots file.
///
/// # Errors
/// Names the file, the shot and the field.
pub fn read_shots(file: &Path) -> Result<Vec<Shot>, ShotError> {
    let text = std::fs::read_to_string(file).map_err(|source| ShotError::Read {
        file: file.to_owned(),
        source,
    })?;
    parse_shots(file, &text)
}

/// [`read_shots`] from text that is already there; `file` is for the messages.
fn parse_shots(file: &Path, text: &str) -> Result<Vec<Shot>, ShotError> {
    let root: Value = serde_json::from_str(text).map_err(|source| ShotError::Json {
        file: file.to_owned(),
        source,
    })?;
    let Some(list) = root.get("shots").and_then(Value::as_array) else {
        return Err(ShotError::Shape { file: file.to_owned() });
    };
    let in_file = |shot: String, problem: String| ShotError::InFile {
        file: file.to_owned(),
        shot,
        problem,
    };
    let mut shots: Vec<Shot> = Vec::with_capacity(list.len());
    for (index, value) in list.iter().enumerate() {
        let label = match value.get("name").and_then(Value::as_str) {
            Some(name) => format!("`{name}`"),
            None => format!("number {}", index + 1),
        };
        let shot = shot_from(value).and_then(|shot| check(&shot).map(|()| shot));
        let shot = shot.map_err(|problem| in_file(label.clone(), problem))?;
        if shots
            .iter()
            .any(|other| other.name == shot.name && other.scene == shot.scene)
        {
            return Err(in_file(label, "the name is given twice".to_owned()));
        }
        shots.push(shot);
    }
    Ok(shots)
}

/// One shot from JSON, with messages that name the field.
fn shot_from(value: &Value) -> Result<Shot, String> {
    let Some(fields) = value.as_object() else {
        return Err(format!("it is {value}, not an object"));
    };
    for required in ["name", "position", "target", "light_dir"] {
        if !fields.contains_key(required) {
            return Err(format!("the field `{required}` is missing"));
        }
    }
    for vector in ["position", "target", "up", "light_dir"] {
        field(fields, vector, "three numbers, as in [0, 1.5, -2]", |value| {
            value
                .as_array()
                .is_some_and(|list| list.len() == 3 && list.iter().all(is_finite))
        })?;
    }
    for number in ["fov_y_deg", "near", "far"] {
        field(fields, number, "a number", is_finite)?;
    }
    for size in ["width", "height"] {
        field(fields, size, "a whole number of pixels", |value| {
            value.as_u64().is_some_and(|pixels| u32::try_from(pixels).is_ok())
        })?;
    }
    for text in ["name", "scene"] {
        field(fields, text, "a text", |value| {
            value.is_string() || (text == "scene" && value.is_null())
        })?;
    }
    serde_json::from_value(value.clone()).map_err(|error| error.to_string())
}

fn field(fields: &Map<String, Value>, name: &str, expected: &str, fits: impl Fn(&Value) -> bool) -> Result<(), String> {
    match fields.get(name) {
        Some(value) if !fits(value) => Err(format!("the field `{name}` is {value}, but must be {expected}")),
        _ => Ok(()),
    }
}

/// A number that stays finite in single precision.
fn is_finite(value: &Value) -> bool {
    #[expect(clippy::cast_possible_truncation, reason = "the overflow is what is tested")]
    value.as_f64().is_some_and(|number| (number as f32).is_finite())
}

/// Checks that a picture can be taken of a shot.
///
/// # Errors
/// One sentence that names the field.
pub fn check(shot: &Shot) -> Result<(), String> {
    for (name, vector) in [
        ("position", shot.position),
        ("target", shot.target),
        ("up", shot.up),
        ("light_dir", shot.light_dir),
    ] {
        if !Vec3::from(vector).is_finite() {
            return Err(format!("`{name}` is {vector:?}, but must be three finite numbers"));
        }
        if Vec3::from(vector).abs().max_element() > LARGEST {
            return Err(format!(
                "`{name}` is {vector:?}, but no number may be beyond ±{LARGEST}"
            ));
        }
    }
    for (name, number) in [("fov_y_deg", shot.fov_y_deg), ("near", shot.near), ("far", shot.far)] {
        if !number.is_finite() {
            return Err(format!("`{name}` is {number}, but must be a finite number"));
        }
    }
    if !(1.0..=170.0).contains(&shot.fov_y_deg) {
        return Err(format!("`fov_y_deg` is {}, but must be 1 to 170", shot.fov_y_deg));
    }
    if shot.near <= 0.0 {
        return Err(format!("`near` is {}, but must be above 0", shot.near));
    }
    if shot.near >= shot.far {
        return Err(format!(
            "`near` ({}) must be smaller than `far` ({})",
            shot.near, shot.far
        ));
    }
    for (name, pixels) in [("width", shot.width), ("height", shot.height)] {
        if !(1..=MAX_SIZE).contains(&pixels) {
            return Err(format!("`{name}` is {pixels}, but must be 1 to {MAX_SIZE} pixels"));
        }
    }
    let Some(_) = Vec3::from(shot.light_dir).try_normalize() else {
        return Err("`light_dir` is zero, but must be the direction in which sunlight travels".to_owned());
    };
    let Some(forward) = (Vec3::from(shot.target) - Vec3::from(shot.position)).try_normalize() else {
        return Err("`position` and `target` are the same point, so that there is no view direction".to_owned());
    };
    let Some(up) = Vec3::from(shot.up).try_normalize() else {
        return Err("`up` is zero, but must be a direction".to_owned());
    };
    if forward.cross(up).length() < 1e-4 {
        return Err(format!(
            "the view direction is parallel to `up` ({:?}); give another `up`, such as [0, 0, -1]",
            shot.up
        ));
    }
    Ok(())
}

/// The shots of `all` that are for a scene: those with its name and those without any.
#[must_use]
pub fn for_scene(all: &[Shot], scene: &str) -> Vec<Shot> {
    let fits = |shot: &&Shot| shot.scene.as_deref().is_none_or(|name| name == scene);
    all.iter().filter(fits).cloned().collect()
}

/// The shots with the given names, in the order of `shots`; all of them where no name is given.
///
/// # Errors
/// A name that is not there, with those that are.
pub fn named(shots: Vec<Shot>, names: &[String], scene: &str) -> Result<Vec<Shot>, ShotError> {
    if let Some(unknown) = names.iter().find(|name| !shots.iter().any(|shot| shot.name == **name)) {
        return Err(ShotError::Unknown {
            scene: scene.to_owned(),
            shot: unknown.clone(),
            available: list(shots.iter().map(|shot| shot.name.as_str())),
        });
    }
    let wanted = |shot: &Shot| names.is_empty() || names.contains(&shot.name);
    Ok(shots.into_iter().filter(wanted).collect())
}

/// Names for a sentence: `a, b and c`, or `none`.
pub fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<_> = names.collect();
    match names.split_last() {
        None => "none".to_owned(),
        Some((last, [])) => (*last).to_owned(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
    }
}

/// Every `count`-th item, beginning with number `index` (from 1): the part of a job array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which part, 1..=`count`.
    pub index: usize,
    /// How many parts.
    pub count: usize,
}

impl Shard {
    /// Everything.
    pub const ALL: Self = Self { index: 1, count: 1 };

    /// Whether the item at this place (from 0) belongs to the part.
    #[must_use]
    pub fn takes(self, place: usize) -> bool {
        place % self.count == self.index - 1
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text
            .split_once('/')
            .map(|(index, count)| (index.parse(), count.parse()));
        match parts {
            Some((Ok(index), Ok(count))) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err("a shard is I/N with I from 1 to N, as in 2/8".to_owned()),
        }
    }
}

/// A picture size in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text
            .split_once(['x', 'X'])
            .map(|(width, height)| (width.parse(), height.parse()));
        match parts {
            Some((Ok(width), Ok(height))) if [width, height].iter().all(|side| (1..=MAX_SIZE).contains(side)) => {
                Ok(Self { width, height })
            }
            _ => Err(format!(
                "a size is WIDTHxHEIGHT in pixels, each 1 to {MAX_SIZE}, as in 1280x720"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Vec<Shot>, String> {
        parse_shots(Path::new("dir/shots.json"), text).map_err(|error| error.to_string())
    }

    /// A file with one shot in which one field is replaced.
    fn with(field: &str, value: &str) -> Result<Vec<Shot>, String> {
        let mut fields = vec![
            ("name", "\"front\""),
            ("position", "[0, 2, 9]"),
            ("target", "[0, 1, 0]"),
            ("light_dir", "[-1, -2, -1]"),
        ];
        fields.retain(|(name, _)| *name != field);
        if !value.is_empty() {
            fields.push((field, value));
        }
        let fields: Vec<_> = fields
            .iter()
            .map(|(name, value)| format!("\"{name}\":{value}"))
            .collect();
        parse(&format!("{{\"shots\":[{{{}}}]}}", fields.join(",")))
    }

    #[test]
    fn the_example_of_the_message_is_valid() {
        let shots = parse(EXAMPLE).expect("valid");
        assert_eq!(
            (shots[0].name.as_str(), shots[0].width, shots[0].far),
            ("front", 1280, 1000.0)
        );
    }

    #[test]
    fn unknown_fields_are_ignored() {
        assert_eq!(with("colour", "7").map(|shots| shots.len()), Ok(1));
    }

    #[test]
    fn errors_name_file_shot_and_field() {
        for (field, value, part) in [
            ("position", "", "`position` is missing"),
            ("light_dir", "", "`light_dir` is missing"),
            ("position", "[0, null, 9]", "`position` is [0,null,9]"),
            ("position", "[1e300, 0, 9]", "`position`"),
            ("position", "[1e30, 0, 9]", "±1000000000"),
            ("up", "[0, -1e30, 0]", "`up` is [0.0, -1e30, 0.0]"),
            ("target", "[0, 1]", "`target`"),
            ("near", "\"x\"", "`near` is \"x\""),
            ("near", "-1", "`near` is -1"),
            ("near", "2000", "smaller than `far` (1000)"),
            ("fov_y_deg", "180", "`fov_y_deg`"),
            ("width", "0", "`width` is 0"),
            ("height", "100000", "1 to 8192"),
            ("width", "1.5", "whole number"),
            ("light_dir", "[0, 0, 0]", "`light_dir` is zero"),
            ("target", "[0, 2, 9]", "same point"),
            ("target", "[0, 0, 9]", "parallel to `up`"),
            ("up", "[0, 0, 0]", "`up` is zero"),
        ] {
            let message = with(field, value).expect_err(field);
            assert!(message.contains(part), "{field}={value}: {message:?} lacks {part:?}");
            assert!(message.starts_with("dir/shots.json: shot `front`:"), "{message:?}");
        }
        assert!(with("name", "").is_err_and(|message| message.contains("shot number 1: the field `name`")));
    }

    #[test]
    fn wrong_files_are_sentences() {
        assert!(parse("{").is_err_and(|message| message.contains("not JSON")));
        assert!(parse("[]").is_err_and(|message| message.contains("no list `shots`")));
        assert!(parse("{\"shots\":[7]}").is_err_and(|message| message.contains("not an object")));
        let missing = read_shots(Path::new("/nonexistent/shots.json")).map_err(|error| error.to_string());
        assert!(missing.is_err_and(|message| message.contains("/nonexistent/shots.json")));
    }

    #[test]
    fn not_a_number_is_refused_where_json_cannot_say_it() {
        let mut shot = parse(EXAMPLE).expect("valid").remove(0);
        shot.position[1] = f32::NAN;
        assert!(check(&shot).is_err_and(|problem| problem.contains("`position`")));
    }

    #[test]
    fn scenes_take_their_own_shots_and_those_of_none() {
        let shot = |name: &str, scene: Option<&str>| Shot {
            name: name.to_owned(),
            scene: scene.map(str::to_owned),
            ..parse(EXAMPLE).expect("valid").remove(0)
        };
        let all = [shot("a", None), shot("b", Some("forest")), shot("c", Some("city"))];
        let names = |shots: Vec<Shot>| shots.into_iter().map(|shot| shot.name).collect::<Vec<_>>();
        assert_eq!(names(for_scene(&all, "forest")), ["a", "b"]);
        let forest = for_scene(&all, "forest");
        assert_eq!(
            named(forest.clone(), &["b".to_owned()], "forest").map(names).ok(),
            Some(vec!["b".to_owned()])
        );
        let unknown = named(forest, &["z".to_owned()], "forest").map_err(|error| error.to_string());
        assert_eq!(unknown, Err("forest has no shot `z`; it has a and b".to_owned()));
    }

    #[test]
    fn shards_take_every_item_once() {
        for place in 0..20 {
            let takers = (1..=3).filter(|&index| Shard { index, count: 3 }.takes(place)).count();
            assert_eq!(takers, 1, "place {place}");
        }
        for wrong in ["0/4", "5/4", "1", "a/b", "1/0"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
        assert_eq!("2/4".parse(), Ok(Shard { index: 2, count: 4 }));
    }

    #[test]
    fn sizes_are_checked() {
        assert_eq!(
            "480x270".parse(),
            Ok(Size {
                width: 480,
                height: 270
            })
        );
        for wrong in ["0x10", "10x9000", "10", "x", "-1x5", "10x", "1e3x5"] {
            assert!(wrong.parse::<Size>().is_err(), "{wrong}");
        }
    }
}
