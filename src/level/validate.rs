//! Limits of [`Level`] and of the `key=value` settings that change one, as typed errors.

use std::collections::BTreeSet;

use bevy_math::{Vec2, Vec3};

use super::{
    format::*,
    inhabitants::{InhabitantRule, Places},
};

/// Why a level cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LevelError {
    /// The text is not a level.
    #[error("line {line}, column {column}, near `{field}`: {message}")]
    Syntax {
        /// Counted from 1.
        line: usize,
        /// Counted from 1.
        column: usize,
        /// The field whose value was being read, or the last one before.
        field: String,
        /// What is wrong.
        message: String,
    },
    /// The file is not text.
    #[error("the file is not UTF-8 text")]
    NotText,
    /// A value out of its limits.
    #[error("`{field}` is {value}, but must be {expected}")]
    Value {
        /// Path of the field, for example `scatter[2].count`.
        field: String,
        /// What it is.
        value: String,
        /// What it may be.
        expected: String,
    },
    /// Two things of one name.
    #[error("`{field}` uses the name `{name}` twice, but names must differ")]
    Duplicate {
        /// The list.
        field: String,
        /// The name.
        name: String,
    },
    /// A setting that this level does not have.
    #[error("the level `{level}` has no setting `{key}`; it has: {known}")]
    UnknownSetting {
        /// The level.
        level: String,
        /// The setting that was asked for.
        key: String,
        /// The settings that it has.
        known: String,
    },
}

/// A value out of its limits.
fn wrong(field: impl Into<String>, value: impl ToString, expected: impl Into<String>) -> LevelError {
    LevelError::Value {
        field: field.into(),
        value: value.to_string(),
        expected: expected.into(),
    }
}

fn number(field: &str, value: f32, min: f32, max: f32) -> Result<(), LevelError> {
    // NaN is in no range.
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(wrong(field, value, format!("between {min} and {max}")))
    }
}

fn count(field: &str, value: u32, min: u32, max: u32) -> Result<(), LevelError> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(wrong(field, value, format!("between {min} and {max}")))
    }
}

fn interval(field: &str, value: (f32, f32), min: f32, max: f32) -> Result<(), LevelError> {
    number(&format!("{field}.0"), value.0, min, max)?;
    number(&format!("{field}.1"), value.1, value.0, max)
}

fn point(field: &str, value: Vec3) -> Result<(), LevelError> {
    if value.is_finite() && value.abs().max_element() <= 1e6 {
        Ok(())
    } else {
        Err(wrong(field, value, "a point within 1000 km"))
    }
}

fn inside(field: &str, value: Vec2, size: Vec2) -> Result<(), LevelError> {
    if value.is_finite() && value.abs().cmple(size * 0.5).all() {
        Ok(())
    } else {
        Err(wrong(
            field,
            value,
            format!("on the terrain of {} x {} m", size.x, size.y),
        ))
    }
}

fn light_dir(field: &str, value: Vec3) -> Result<(), LevelError> {
    if value.is_finite() && value.length_squared() > 1e-12 && value.length_squared() < 1e12 {
        Ok(())
    } else {
        Err(wrong(field, value, "a direction of finite length other than zero"))
    }
}

/// Where a sun stands: a direction, an hour, or neither.
fn sun_stand(field: &str, direction: Option<Vec3>, hour: Option<f32>) -> Result<(), LevelError> {
    match (direction, hour) {
        (Some(_), Some(hour)) => Err(wrong(format!("{field}.hour"), hour, "absent where light_dir is given")),
        (Some(direction), None) => light_dir(&format!("{field}.light_dir"), direction),
        (None, Some(hour)) => number(&format!("{field}.hour"), hour, 0.0, 24.0),
        (None, None) => Ok(()),
    }
}

fn name<'a>(field: &str, value: &'a str, seen: &mut BTreeSet<&'a str>) -> Result<(), LevelError> {
    if value.trim().is_empty() {
        return Err(wrong(format!("{field}.name"), "empty", "a name"));
    }
    if !seen.insert(value) {
        return Err(LevelError::Duplicate {
            field: field.split('[').next().unwrap_or(field).into(),
            name: value.into(),
        });
    }
    Ok(())
}

fn view(field: &str, position: Vec3, target: Vec3) -> Result<(), LevelError> {
    point(&format!("{field}.position"), position)?;
    point(&format!("{field}.target"), target)?;
    let forward = target - position;
    // Looking straight up or down leaves no upright picture; so does looking nowhere.
    if forward.reject_from(Vec3::Y).length_squared() > 1e-8 * forward.length_squared() {
        Ok(())
    } else {
        Err(wrong(
            format!("{field}.target"),
            target,
            "a point that is not straight above, below or at the position",
        ))
    }
}

impl Level {
    /// Checks every value.
    ///
    /// # Errors
    /// The first field that is out of its limits, with its value and the limits.
    pub fn validate(&self) -> Result<(), LevelError> {
        if self.name.trim().is_empty() {
            return Err(wrong(
                "name",
                "empty",
                "the file's path below levels/ without .level.ron",
            ));
        }
        self.terrain.validate()?;
        self.generator.validate(self.terrain.size)?;
        for (i, rule) in self.scatter.iter().enumerate() {
            rule.validate(&format!("scatter[{i}]"))?;
        }
        for (i, rule) in self.inhabitants.iter().enumerate() {
            rule.validate(&format!("inhabitants[{i}]"))?;
        }
        self.sun.validate()?;
        point("spawn.position", self.spawn.position)?;
        point("spawn.look_at", self.spawn.look_at)?;
        if self.spawn.position == self.spawn.look_at {
            return Err(wrong(
                "spawn.look_at",
                self.spawn.look_at,
                "another point than spawn.position",
            ));
        }
        if self.shots.is_empty() {
            return Err(wrong("shots", "empty", "a list of at least one shot"));
        }
        let mut names = BTreeSet::new();
        for (i, shot) in self.shots.iter().enumerate() {
            let field = format!("shots[{i}]");
            name(&field, &shot.name, &mut names)?;
            shot.validate(&field)?;
        }
        for (i, shot) in self.tuning_shots.iter().enumerate() {
            let field = format!("tuning_shots[{i}]");
            name(&field, &shot.name, &mut names)?;
            shot.validate(&field)?;
        }
        for (i, shot) in self.views.iter().enumerate() {
            let field = format!("views[{i}]");
            name(&field, &shot.name, &mut names)?;
            shot.validate(&field)?;
        }
        let mut names = BTreeSet::new();
        for (i, path) in self.camera_paths.iter().enumerate() {
            let field = format!("camera_paths[{i}]");
            name(&field, &path.name, &mut names)?;
            path.validate(&field)?;
        }
        Ok(())
    }

    /// Names of the settings that [`Level::set`] takes.
    pub fn settings(&self) -> &'static [&'static str] {
        match self.generator {
            Generator::Forest(_) => &["count", "seed"],
            Generator::StressTrees(_) => &["cells", "count", "seed", "wind"],
            Generator::City(_) => &["cars", "floors", "seed"],
            Generator::Room(_) => &["seed"],
        }
    }

    /// Changes one setting, as in `forest:count=500`. Settings: `seed`; `count` (trees of a forest or of the
    /// instancing test; a forest keeps the shares of its species); `cells` (`on` or `off`) and `wind` (metres per second) of
    /// the instancing test; `cars` and `floors` of a city.
    ///
    /// # Errors
    /// A setting that the level does not have, or a value out of its limits.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), LevelError> {
        let whole = |max: u64| {
            value
                .parse::<u64>()
                .ok()
                .filter(|value| *value <= max)
                .ok_or_else(|| wrong(key, value, format!("a whole number between 0 and {max}")))
        };
        let small = |max: u32| whole(max.into()).map(|value| u32::try_from(value).unwrap_or(max));
        match (key, &mut self.generator) {
            ("seed", _) => self.seed = whole(u64::MAX)?,
            ("count", Generator::StressTrees(trees)) => trees.count = small(MAX_COUNT)?,
            ("cells", Generator::StressTrees(trees)) => {
                trees.cells = match value {
                    "on" => true,
                    "off" => false,
                    _ => return Err(wrong(key, value, "on or off")),
                }
            }
            ("wind", Generator::StressTrees(trees)) => {
                trees.wind = value
                    .parse()
                    .map_err(|_| wrong(key, value, "a number between 0 and 30"))?;
            }
            ("count", Generator::Forest(_)) => {
                let wanted = u64::from(small(MAX_COUNT)?);
                let trees = |rule: &&mut ScatterRule| rule.species.is_tree();
                let total: u64 = self
                    .scatter
                    .iter_mut()
                    .filter(trees)
                    .map(|rule| u64::from(rule.count))
                    .sum();
                let (mut left_total, mut left) = (total, wanted);
                for rule in self.scatter.iter_mut().filter(trees) {
                    // The rest goes to the rules that are left, so that the sum is exact.
                    let share = (left * u64::from(rule.count)).checked_div(left_total).unwrap_or(0);
                    left_total -= u64::from(rule.count);
                    left -= share;
                    rule.count = u32::try_from(share).unwrap_or(MAX_COUNT);
                }
            }
            ("cars", Generator::City(city)) => city.cars = small(MAX_COUNT)?,
            ("floors", Generator::City(city)) => city.max_floors = small(200)?,
            _ => {
                return Err(LevelError::UnknownSetting {
                    level: self.name.clone(),
                    key: key.into(),
                    known: self.settings().join(", "),
                });
            }
        }
        self.validate()
    }
}

/// The most things that one rule or generator places.
pub const MAX_COUNT: u32 = 1_000_000;
/// Most inhabitants of one rule: each has a skeleton.
const MAX_INHABITANTS: u32 = 1_000;

impl TerrainShape {
    fn validate(&self) -> Result<(), LevelError> {
        number("terrain.size.x", self.size.x, 4.0, 20_000.0)?;
        number("terrain.size.y", self.size.y, 4.0, 20_000.0)?;
        if let Some(hills) = self.hills {
            for (axis, size) in [("x", self.size.x), ("y", self.size.y)] {
                // Hills are a grid of 2 m: 2 km are a million heights.
                number(&format!("terrain.size.{axis} with hills"), size, 4.0, 2_000.0)?;
            }
            number("terrain.hills.amplitude", hills.amplitude, 0.0, 500.0)?;
            number("terrain.hills.wavelength", hills.wavelength, 4.0, 20_000.0)?;
            count("terrain.hills.octaves", hills.octaves, 1, 8)?;
            number("terrain.hills.rim_height", hills.rim_height, 0.0, 500.0)?;
            number(
                "terrain.hills.rim_width",
                hills.rim_width,
                0.0,
                0.5 * self.size.min_element(),
            )?;
        }
        for (i, clearing) in self.clearings.iter().enumerate() {
            inside(&format!("terrain.clearings[{i}].center"), clearing.center, self.size)?;
            number(&format!("terrain.clearings[{i}].radius"), clearing.radius, 0.1, 1_000.0)?;
            if let Some(pond) = clearing.pond {
                number(
                    &format!("terrain.clearings[{i}].pond.radius"),
                    pond.radius,
                    1.0,
                    clearing.radius,
                )?;
                number(&format!("terrain.clearings[{i}].pond.depth"), pond.depth, 0.1, 10.0)?;
            }
        }
        for (i, track) in self.tracks.iter().enumerate() {
            let field = format!("terrain.tracks[{i}]");
            number(&format!("{field}.width"), track.width, 0.2, 50.0)?;
            if track.points.len() < 2 || track.points.len() > 1_000 {
                return Err(wrong(
                    format!("{field}.points"),
                    format!("a list of {}", track.points.len()),
                    "a list of 2 to 1000 points",
                ));
            }
            for (j, point) in track.points.iter().enumerate() {
                inside(&format!("{field}.points[{j}]"), *point, self.size)?;
                if j > 0 && point.distance(track.points[j - 1]) < 0.1 {
                    return Err(wrong(
                        format!("{field}.points[{j}]"),
                        point,
                        "at least 0.1 m from the point before",
                    ));
                }
            }
            if let Some(fence) = track.fence {
                number(&format!("{field}.fence.post_spacing"), fence.post_spacing, 0.2, 50.0)?;
                number(&format!("{field}.fence.height"), fence.height, 0.2, 10.0)?;
                number(&format!("{field}.fence.offset"), fence.offset, 0.0, 50.0)?;
            }
        }
        Ok(())
    }
}

impl Generator {
    fn validate(&self, size: Vec2) -> Result<(), LevelError> {
        match self {
            Self::Forest(forest) => {
                for (i, hut) in forest.huts.iter().enumerate() {
                    inside(&format!("generator.huts[{i}].position"), hut.position, size)?;
                    number(&format!("generator.huts[{i}].yaw_deg"), hut.yaw_deg, -360.0, 360.0)?;
                }
                Ok(())
            }
            Self::City(city) => {
                count("generator.blocks.0", city.blocks.0, 3, 16)?;
                count("generator.blocks.1", city.blocks.1, 3, 16)?;
                interval("generator.block_side", city.block_side, 20.0, 200.0)?;
                number("generator.street", city.street, 4.0, 60.0)?;
                number("generator.avenue", city.avenue, 4.0, 100.0)?;
                number("generator.pavement", city.pavement, 1.5, 0.2 * city.block_side.0)?;
                count("generator.max_floors", city.max_floors, 1, 200)?;
                number("generator.tower_height", city.tower_height, 20.0, 1_000.0)?;
                count("generator.cars", city.cars, 0, MAX_COUNT)
            }
            Self::Room(Room::PlaneBox { side }) => number("generator.side", *side, 0.01, 1_000.0),
            Self::Room(Room::Poles {
                spacing,
                height,
                radius,
                gap,
            }) => {
                number("generator.spacing", *spacing, 0.5, 1_000.0)?;
                number("generator.height", *height, 0.01, 1_000.0)?;
                number("generator.radius", *radius, 0.001, 0.4 * spacing)?;
                number("generator.gap", *gap, 3.0 * radius, size.x)
            }
            Self::Room(Room::Fence { post_spacing, height }) => {
                number("generator.post_spacing", *post_spacing, 0.2, 100.0)?;
                number("generator.height", *height, 0.2, 100.0)
            }
            Self::Room(Room::Wires {
                spacing,
                height,
                diameter,
                sag,
            }) => {
                number("generator.spacing", *spacing, 1.0, 1_000.0)?;
                number("generator.height", *height, 1.0, 1_000.0)?;
                number("generator.diameter", *diameter, 0.0005, 1.0)?;
                number("generator.sag", *sag, 0.0, 0.9 * height)
            }
            Self::Room(Room::Glass { panes, spacing, height }) => {
                count("generator.panes", *panes, 1, 100)?;
                number("generator.spacing", *spacing, 0.1, 100.0)?;
                number("generator.height", *height, 0.1, 100.0)
            }
            Self::Room(Room::Wall {
                place,
                height,
                spacing,
                card,
            }) => {
                number("generator.place", *place, -0.5 * size.y, 0.5 * size.y)?;
                number("generator.height", *height, 0.1, 1_000.0)?;
                number("generator.spacing", *spacing, 0.5, 1_000.0)?;
                number("generator.card", *card, 0.0, 100.0)
            }
            Self::StressTrees(trees) => {
                count("generator.count", trees.count, 1, MAX_COUNT)?;
                number("generator.spacing", trees.spacing, 0.5, 1_000.0)?;
                number("generator.wind", trees.wind, 0.0, 30.0)
            }
        }
    }
}

impl ScatterRule {
    fn validate(&self, field: &str) -> Result<(), LevelError> {
        count(&format!("{field}.count"), self.count, 0, MAX_COUNT)?;
        number(&format!("{field}.spacing"), self.spacing, 0.1, 1_000.0)?;
        interval(&format!("{field}.slope_deg"), self.slope_deg, 0.0, 90.0)?;
        interval(&format!("{field}.height"), self.height, -10_000.0, 10_000.0)?;
        interval(&format!("{field}.scale"), self.scale, 0.01, 100.0)?;
        number(&format!("{field}.clumping"), self.clumping, 0.0, 1.0)
    }
}

impl InhabitantRule {
    fn validate(&self, field: &str) -> Result<(), LevelError> {
        count(&format!("{field}.count"), self.count, 0, MAX_INHABITANTS)?;
        match self.places {
            Places::Pavements { within } => number(&format!("{field}.places.within"), within, 1.0, 10_000.0),
            Places::Area { center, radius } => {
                point(&format!("{field}.places.center"), center.extend(0.0))?;
                number(&format!("{field}.places.radius"), radius, 2.0, 1_000.0)
            }
        }
    }
}

impl SunSettings {
    fn validate(&self) -> Result<(), LevelError> {
        sun_stand("sun", self.light_dir, self.hour)?;
        if self.light_dir.is_none() && self.hour.is_none() {
            return Err(wrong("sun", "without light_dir and hour", "given one of them"));
        }
        number("sun.latitude_deg", self.latitude_deg, -90.0, 90.0)?;
        count("sun.day", self.day, 1, 365)?;
        number("sun.air.aerosol_depth", self.air.aerosol_depth, 0.0, 2.0)?;
        number("sun.air.visibility", self.air.visibility, 10.0, 1e6)?;
        number("sun.air.sky_share", self.air.sky_share, 0.0, 1.0)
    }
}

impl LevelShot {
    fn validate(&self, field: &str) -> Result<(), LevelError> {
        view(field, self.position, self.target)?;
        number(&format!("{field}.fov_y_deg"), self.fov_y_deg, 1.0, 170.0)?;
        number(&format!("{field}.near"), self.near, 0.001, 1_000.0)?;
        number(&format!("{field}.far"), self.far, 1.01 * self.near, 1e6)?;
        count(&format!("{field}.size.0"), self.size.0, 1, 16_384)?;
        count(&format!("{field}.size.1"), self.size.1, 1, 16_384)?;
        sun_stand(field, self.light_dir, self.hour)
    }
}

impl CameraPath {
    fn validate(&self, field: &str) -> Result<(), LevelError> {
        if self.keys.len() < 2 {
            return Err(wrong(
                format!("{field}.keys"),
                format!("a list of {}", self.keys.len()),
                "a list of at least two keys",
            ));
        }
        for (i, key) in self.keys.iter().enumerate() {
            let field = format!("{field}.keys[{i}]");
            view(&field, key.position, key.target)?;
            let earliest = if i == 0 { 0.0 } else { self.keys[i - 1].time + 1e-3 };
            number(&format!("{field}.time"), key.time, earliest, 1e6)?;
        }
        Ok(())
    }
}
