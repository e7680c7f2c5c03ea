//! Every level file is usable, and every limit is a typed error that names its field.

use std::{fs, path::Path};

use bevy::math::{Vec2, Vec3};
use umbrage::level::{
    find,
    format::*,
    parse::parse,
    scenery,
    validate::{LevelError, MAX_COUNT},
};

pub(crate) fn level(name: &str) -> Level {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("levels/{name}.{}", find::EXTENSION));
    parse(&fs::read(&path).unwrap()).unwrap_or_else(|error| panic!("{name}: {error}"))
}

pub(crate) fn names() -> Vec<String> {
    find::asset_root(Some(Path::new(env!("CARGO_MANIFEST_DIR"))))
        .unwrap()
        .level_names()
}

#[test]
fn every_level_is_read_and_calls_itself_by_its_path() {
    let names = names();
    for expected in [
        "city",
        "forest",
        "room/dueling_light",
        "room/fence",
        "room/glass",
        "room/grazed_card",
        "room/light_from_top",
        "room/long_plane",
        "room/one_plane",
        "room/plane_box",
        "room/two_planes",
        "room/wires",
        "stress_trees",
    ] {
        assert!(
            names.iter().any(|name| name == expected),
            "{expected} is not among {names:?}"
        );
    }
    for name in names {
        assert_eq!(level(&name).name, name);
    }
}

#[test]
fn shots_stand_in_the_air_above_the_ground() {
    for name in names() {
        let level = level(&name);
        let ground = scenery::generate(&level).ground;
        let mut eyes: Vec<(String, Vec3)> = level
            .shots
            .iter()
            .chain(&level.tuning_shots)
            .chain(&level.views)
            .map(|shot| (shot.name.clone(), shot.position))
            .collect();
        eyes.push(("spawn".into(), level.spawn.position));
        for path in &level.camera_paths {
            for step in 0..=100 {
                let seconds = path.duration() * step as f32 / 100.0;
                eyes.push((format!("{} at {seconds} s", path.name), path.sample(seconds).unwrap().0));
            }
        }
        for (what, eye) in eyes {
            let above = eye.y - ground.height(eye.x, eye.z);
            assert!(above > 1.0, "{name}, {what}: only {above} m above the ground");
            let half = level.terrain.size * 0.5;
            assert!(
                eye.x.abs() < half.x && eye.z.abs() < half.y,
                "{name}, {what}: off the terrain"
            );
        }
    }
}

#[test]
fn shots_have_the_asked_variety() {
    for name in ["forest", "city"] {
        let level = level(name);
        assert!(level.shots.len() >= 4, "{name}");
        assert!(!level.camera_paths.is_empty(), "{name}");
        let mut from_behind = false;
        let mut from_ahead = false;
        let mut low = false;
        for shot in level.shots() {
            assert_eq!((shot.width, shot.height), (1280, 720), "{name} {}", shot.name);
            assert!(
                (500.0..=600.0).contains(&shot.far) && (0.1..=0.5).contains(&shot.near),
                "{name} {}",
                shot.name
            );
            let view = (Vec3::from(shot.target) - Vec3::from(shot.position))
                .with_y(0.0)
                .normalize();
            let light = Vec3::from(shot.light_dir).normalize();
            from_behind |= view.dot(light.with_y(0.0).normalize()) > 0.8;
            from_ahead |= view.dot(light.with_y(0.0).normalize()) < -0.8;
            low |= light.y > -0.35;
        }
        assert!(
            from_behind && from_ahead && low,
            "{name}: behind {from_behind}, ahead {from_ahead}, low {low}"
        );
    }
}

/// Every kind of difficulty has a fixed shot in forest and city, and is what it says; tuning shots stand elsewhere, under
/// other suns.
#[test]
fn fixed_shots_have_their_kinds_and_tuning_shots_are_others() {
    use ShotKind::{LightAhead, LightBehind, LongView, LowSun, Ordinary, Overhead, ThinNear};
    for name in ["forest", "city"] {
        let level = level(name);
        let ground = scenery::generate(&level).ground;
        for kind in [LowSun, Overhead, LightBehind, LightAhead, LongView, ThinNear] {
            assert!(
                level.shots.iter().any(|shot| shot.kind == Some(kind)),
                "{name}: {kind:?}"
            );
        }
        for shot in &level.shots {
            let what = format!("{name} {}", shot.name);
            let light = level.light_dir(shot).normalize();
            let view = shot.target - shot.position;
            let along = |vector: Vec3| vector.with_y(0.0).normalize();
            let height = shot.position.y - ground.height(shot.position.x, shot.position.z);
            match shot.kind.unwrap_or_else(|| panic!("{what} has no kind")) {
                LowSun => assert!(
                    light.y > -(20.0_f32.to_radians().sin()) - 0.01 && height < 3.0,
                    "{what}: {height}"
                ),
                Overhead => assert!(light.y < -(60.0_f32.to_radians().sin()), "{what}"),
                LightBehind => assert!(along(view).dot(along(light)) > 0.8, "{what}"),
                LightAhead => assert!(along(view).dot(along(light)) < -0.8, "{what}"),
                LongView => assert!(view.length() >= 80.0, "{what}: {} m", view.length()),
                ThinNear => assert!(shot.near <= 0.1 && height < 4.0, "{what}: {height}"),
                Ordinary => {}
            }
        }
        assert!(level.tuning_shots.len() >= 3, "{name}");
        for tuning in &level.tuning_shots {
            for shot in &level.shots {
                let apart = tuning.position.distance(shot.position);
                let suns = [tuning, shot].map(|shot| level.light_dir(shot).normalize());
                assert!(
                    apart > 5.0,
                    "{name}: {} and {} are {apart} m apart",
                    tuning.name,
                    shot.name
                );
                assert!(
                    suns[0].dot(suns[1]) < 0.99,
                    "{name}: {} and {} have one sun",
                    tuning.name,
                    shot.name
                );
            }
        }
    }
}

/// Changes something in a valid forest and gives the field that is then complained about.
fn complaint(change: impl FnOnce(&mut Level)) -> String {
    let mut level = level("forest");
    change(&mut level);
    match level.validate() {
        Err(LevelError::Value { field, .. } | LevelError::Duplicate { field, .. }) => field,
        other => panic!("{other:?}"),
    }
}

#[test]
fn wrong_values_are_named() {
    let nan = f32::NAN;
    let cases: Vec<(&str, Box<dyn FnOnce(&mut Level)>)> = vec![
        ("name", Box::new(|l| l.name = " ".into())),
        ("terrain.size.x", Box::new(move |l| l.terrain.size.x = nan)),
        ("terrain.size.y with hills", Box::new(|l| l.terrain.size.y = 5000.0)),
        (
            "terrain.hills.amplitude",
            Box::new(|l| l.terrain.hills.as_mut().unwrap().amplitude = -1.0),
        ),
        (
            "terrain.hills.octaves",
            Box::new(|l| l.terrain.hills.as_mut().unwrap().octaves = 0),
        ),
        (
            "terrain.clearings[0].center",
            Box::new(|l| l.terrain.clearings[0].center = Vec2::splat(500.0)),
        ),
        (
            "terrain.clearings[1].radius",
            Box::new(|l| l.terrain.clearings[1].radius = 0.0),
        ),
        (
            "terrain.clearings[0].pond.depth",
            Box::new(|l| {
                l.terrain.clearings[0].pond = Some(Pond {
                    radius: 4.0,
                    depth: -1.0,
                });
            }),
        ),
        (
            "terrain.tracks[0].width",
            Box::new(|l| l.terrain.tracks[0].width = f32::INFINITY),
        ),
        (
            "terrain.tracks[0].points",
            Box::new(|l| l.terrain.tracks[0].points.truncate(1)),
        ),
        (
            "terrain.tracks[0].points[2]",
            Box::new(|l| l.terrain.tracks[0].points[2] = l.terrain.tracks[0].points[1]),
        ),
        (
            "terrain.tracks[0].fence.post_spacing",
            Box::new(|l| {
                l.terrain.tracks[0].fence.as_mut().unwrap().post_spacing = 0.0;
            }),
        ),
        (
            "generator.huts[0].position",
            Box::new(|l| {
                l.generator = Generator::Forest(Forest {
                    huts: vec![HutSite {
                        position: Vec2::NAN,
                        yaw_deg: 0.0,
                    }],
                });
            }),
        ),
        (
            "generator.side",
            Box::new(|l| l.generator = Generator::Room(Room::PlaneBox { side: 0.0 })),
        ),
        (
            "generator.count",
            Box::new(|l| {
                l.generator = Generator::StressTrees(StressTrees {
                    count: 0,
                    spacing: 5.0,
                    cells: true,
                    wind: 0.0,
                });
            }),
        ),
        ("scatter[0].count", Box::new(|l| l.scatter[0].count = MAX_COUNT + 1)),
        ("scatter[1].spacing", Box::new(|l| l.scatter[1].spacing = 0.0)),
        (
            "scatter[1].slope_deg.1",
            Box::new(|l| l.scatter[1].slope_deg = (30.0, 10.0)),
        ),
        ("scatter[2].scale.0", Box::new(|l| l.scatter[2].scale.0 = -1.0)),
        ("scatter[2].clumping", Box::new(move |l| l.scatter[2].clumping = nan)),
        ("sun.light_dir", Box::new(|l| l.sun.light_dir = Some(Vec3::ZERO))),
        ("sun", Box::new(|l| l.sun.light_dir = None)),
        ("sun.hour", Box::new(|l| l.sun.hour = Some(9.0))),
        (
            "sun.hour",
            Box::new(|l| (l.sun.light_dir, l.sun.hour) = (None, Some(24.5))),
        ),
        ("sun.latitude_deg", Box::new(|l| l.sun.latitude_deg = 91.0)),
        ("sun.day", Box::new(|l| l.sun.day = 0)),
        (
            "sun.air.aerosol_depth",
            Box::new(move |l| l.sun.air.aerosol_depth = nan),
        ),
        ("sun.air.visibility", Box::new(|l| l.sun.air.visibility = 0.0)),
        ("sun.air.sky_share", Box::new(|l| l.sun.air.sky_share = 2.0)),
        ("views[1].hour", Box::new(|l| l.views[1].hour = Some(-1.0))),
        ("views", Box::new(|l| l.views[0].name = "path".into())),
        ("spawn.position", Box::new(|l| l.spawn.position = Vec3::INFINITY)),
        ("spawn.look_at", Box::new(|l| l.spawn.look_at = l.spawn.position)),
        ("shots", Box::new(|l| l.shots.clear())),
        ("shots", Box::new(|l| l.shots[1].name = l.shots[0].name.clone())),
        ("shots[0].name", Box::new(|l| l.shots[0].name.clear())),
        (
            "tuning_shots",
            Box::new(|l| l.tuning_shots[1].name = l.shots[0].name.clone()),
        ),
        ("tuning_shots[0].far", Box::new(|l| l.tuning_shots[0].far = 0.0)),
        ("shots[1].position", Box::new(move |l| l.shots[1].position.x = nan)),
        (
            "shots[1].target",
            Box::new(|l| l.shots[1].target = l.shots[1].position - Vec3::Y),
        ),
        ("shots[1].fov_y_deg", Box::new(|l| l.shots[1].fov_y_deg = 180.0)),
        ("shots[1].near", Box::new(|l| l.shots[1].near = 0.0)),
        ("shots[1].far", Box::new(|l| l.shots[1].far = l.shots[1].near)),
        ("shots[1].size.1", Box::new(|l| l.shots[1].size.1 = 0)),
        (
            "shots[1].light_dir",
            Box::new(|l| l.shots[1].light_dir = Some(Vec3::ZERO)),
        ),
        ("camera_paths[0].keys", Box::new(|l| l.camera_paths[0].keys.truncate(1))),
        (
            "camera_paths[0].keys[1].time",
            Box::new(|l| l.camera_paths[0].keys[1].time = 0.0),
        ),
        (
            "camera_paths",
            Box::new(|l| l.camera_paths[1].name = l.camera_paths[0].name.clone()),
        ),
    ];
    for (field, change) in cases {
        assert_eq!(complaint(change), field);
    }
}

#[test]
fn an_error_says_field_value_and_limits() {
    let mut level = level("forest");
    level.scatter[0].spacing = f32::NAN;
    let sentence = level.validate().unwrap_err().to_string();
    assert_eq!(
        sentence,
        "`scatter[0].spacing` is NaN, but must be between 0.1 and 1000"
    );
}

#[test]
fn settings_change_a_level() {
    let trees = |level: &Level| -> u32 {
        level
            .scatter
            .iter()
            .filter(|rule| rule.species.is_tree())
            .map(|rule| rule.count)
            .sum()
    };
    let mut forest = level("forest");
    let bushes = forest
        .scatter
        .iter()
        .find(|rule| rule.species == Species::Bush)
        .unwrap()
        .count;
    forest.set("count", "501").unwrap();
    assert_eq!(trees(&forest), 501);
    assert_eq!(
        forest
            .scatter
            .iter()
            .find(|rule| rule.species == Species::Bush)
            .unwrap()
            .count,
        bushes
    );
    forest.set("seed", "18446744073709551615").unwrap();
    assert_eq!(forest.seed, u64::MAX);
    let mut stress = level("stress_trees");
    stress.set("count", "100000").unwrap();
    stress.set("wind", "7.5").unwrap();
    stress.set("cells", "off").unwrap();
    assert!(matches!(
        stress.generator,
        Generator::StressTrees(StressTrees {
            count: 100_000,
            cells: false,
            wind: 7.5,
            ..
        })
    ));
}

#[test]
fn wrong_settings_are_errors_that_name_them() {
    for (name, key, value, part) in [
        ("forest", "height", "3", "no setting `height`; it has: count, seed"),
        ("room/fence", "count", "3", "no setting `count`; it has: seed"),
        ("forest", "count", "-1", "`count` is -1"),
        ("forest", "count", "many", "`count` is many"),
        ("stress_trees", "count", "0", "`generator.count` is 0"),
        ("stress_trees", "count", "99999999999", "`count` is 99999999999"),
        (
            "stress_trees",
            "cells",
            "some",
            "`cells` is some, but must be on or off",
        ),
        ("stress_trees", "wind", "strong", "`wind` is strong"),
        ("stress_trees", "wind", "NaN", "`generator.wind` is NaN"),
        ("stress_trees", "wind", "31", "`generator.wind` is 31"),
        ("city", "floors", "0", "`generator.max_floors` is 0"),
    ] {
        let error = level(name).set(key, value).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}
