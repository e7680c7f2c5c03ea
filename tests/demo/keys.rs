//! What the keys do while playing.

use bevy::prelude::*;
use umbrage::{
    demo::{input::ROWS, outside::Outside, walker::Mode},
    lod::settings::{LodKind, LodSettings},
    shadow::{
        settings::ShadowPath,
        technique::{StockBias, Technique},
    },
};

use crate::game::Game;

#[test]
fn the_readme_has_the_same_table_of_keys() {
    let readme = include_str!("../../README.md");
    let table: Vec<&str> = readme
        .lines()
        .skip_while(|line| *line != "### Keys")
        .skip_while(|line| !line.starts_with("|---"))
        .skip(1)
        .take_while(|line| line.starts_with('|'))
        .collect();
    let rows: Vec<String> = ROWS
        .iter()
        .map(|row| format!("| {} | {} |", row.label(), row.does))
        .collect();
    assert_eq!(table, rows);
}

#[test]
fn wasd_walks_and_the_camera_follows() {
    let mut game = Game::playing();
    game.hold(KeyCode::KeyW);
    game.hold(KeyCode::KeyD);
    game.seconds(1.0);
    let walker = game.walker();
    assert!(
        walker.feet.x > 2.0 && walker.feet.z < -2.0 && walker.feet.y == 0.0,
        "{}",
        walker.feet
    );
    let world = game.0.world_mut();
    let camera = world
        .query_filtered::<&GlobalTransform, With<Camera3d>>()
        .single(world)
        .unwrap();
    assert!(
        camera.translation().abs_diff_eq(walker.camera().translation, 1e-4)
            && camera.translation().abs_diff_eq(walker.eye(), 0.05),
        "{} {}",
        camera.translation(),
        walker.eye()
    );
}

#[test]
fn the_mouse_turns_the_view() {
    let mut game = Game::playing();
    game.move_mouse(Vec2::new(200.0, 0.0));
    let right = game.walker();
    assert!(right.yaw < -0.3 && right.pitch.abs() < 1e-3, "{right:?}");
    game.move_mouse(Vec2::new(0.0, -100_000.0));
    assert!(game.walker().camera().is_finite());
    assert!(game.walker().pitch > 1.0, "upwards, but not over");
}

#[test]
fn f_flies_and_lands() {
    let mut game = Game::playing();
    game.tap(KeyCode::KeyF);
    assert_eq!(game.walker().mode, Mode::Fly);
    game.hold(KeyCode::KeyE);
    game.seconds(1.0);
    game.release(KeyCode::KeyE);
    assert!(game.walker().eye().y > 10.0, "{}", game.walker().eye());
    game.tap(KeyCode::KeyF);
    assert_eq!(game.walker().mode, Mode::Walk);
    game.seconds(3.0);
    assert_eq!(game.walker().feet.y, 0.0);
}

#[test]
fn t_goes_through_all_techniques_and_the_sun_gets_them() {
    let mut game = Game::playing();
    let all = Technique::all();
    let mut seen = Vec::new();
    for _ in 0..all.len() {
        game.tap(KeyCode::KeyT);
        let technique = game.technique();
        assert_eq!(game.hud().title, technique.to_string());
        match &technique {
            Technique::Bevy(_) => assert_eq!(game.sun_settings(), None),
            Technique::Umbrage(settings) => {
                assert_eq!(game.sun_settings().as_ref(), Some(settings))
            }
        }
        seen.push(technique);
    }
    assert!(all.iter().all(|technique| seen.contains(technique)), "{seen:?}");
    let last = game.technique();
    game.shift_tap(KeyCode::KeyT);
    assert_eq!(game.technique(), seen[seen.len() - 2], "Shift+T goes back");
    game.tap(KeyCode::KeyT);
    assert_eq!(game.technique(), last);
}

#[test]
fn digits_change_the_settings_of_the_sun() {
    let mut game = Game::playing();
    let before = game.sun_settings().unwrap();
    game.tap(KeyCode::Digit4);
    let bigger = game.sun_settings().unwrap();
    assert_eq!(bigger.map_size, 2 * before.map_size);
    assert!(game.hud().settings.contains("4096"), "{}", game.hud().settings);
    assert!(game.hud().notice.contains("4096"), "{}", game.hud().notice);
    game.shift_tap(KeyCode::Digit4);
    assert_eq!(game.sun_settings().unwrap(), before, "Shift steps back");
    game.tap(KeyCode::Digit8);
    assert_eq!(game.sun_settings().unwrap().path, ShadowPath::DropIn);
    game.seconds(5.0);
    assert_eq!(game.hud().notice, "", "a notice goes away");
}

#[test]
fn bevy_s_cascades_have_no_settings_and_say_so() {
    let mut game = Game::playing();
    while !matches!(game.technique(), Technique::Bevy(_)) {
        game.tap(KeyCode::KeyT);
    }
    game.tap(KeyCode::Digit1);
    assert_eq!(game.technique(), Technique::Bevy(StockBias::default()));
    assert!(game.hud().notice.contains("no settings"), "{}", game.hud().notice);
}

#[test]
fn f5_shows_the_player_from_outside() {
    let mut game = Game::playing();
    let cameras = |game: &mut Game| {
        let world = game.0.world_mut();
        let mut cameras = world.query_filtered::<(&Camera, &Transform), With<Outside>>();
        let found: Vec<_> = cameras
            .iter(world)
            .map(|(camera, place)| (camera.viewport.clone(), place.translation))
            .collect();
        found
    };
    assert!(cameras(&mut game).is_empty());
    game.tap(KeyCode::F5);
    game.frames(2);
    let seen = cameras(&mut game);
    let [(Some(viewport), place)] = seen.as_slice() else {
        panic!("one camera with a viewport, not {seen:?}");
    };
    assert!(
        viewport.physical_size.x < 1280 && place.y > 50.0,
        "{viewport:?} {place}"
    );
    game.hold(KeyCode::KeyW);
    game.seconds(1.0);
    game.release(KeyCode::KeyW);
    assert_ne!(cameras(&mut game)[0].1, *place, "it follows");
    game.tap(KeyCode::F5);
    game.frames(2);
    assert!(cameras(&mut game).is_empty());
}

#[test]
fn arrows_move_the_sun_while_held() {
    let mut game = Game::playing();
    let start = game.sun();
    assert!((start.azimuth.to_degrees() - 90.0).abs() < 0.1 && (start.elevation.to_degrees() - 45.0).abs() < 0.1);
    game.hold(KeyCode::ArrowUp);
    let mut last = start.elevation;
    for _ in 0..30 {
        game.frames(1);
        let now = game.sun().elevation;
        assert!(now > last && now - last < 0.02, "a small step each frame: {last} {now}");
        last = now;
    }
    game.seconds(6.0);
    assert!(
        (game.sun().elevation.to_degrees() - 89.5).abs() < 0.1,
        "the top: {:?}",
        game.sun()
    );
    game.release(KeyCode::ArrowUp);
    game.hold(KeyCode::ArrowRight);
    game.seconds(1.0);
    assert!(game.sun().azimuth > start.azimuth + 0.2, "clockwise: {:?}", game.sun());
    game.release(KeyCode::ArrowRight);
    game.hold(KeyCode::ArrowDown);
    game.seconds(6.0);
    assert!(
        (game.sun().elevation.to_degrees() - 2.0).abs() < 0.1,
        "the bottom: {:?}",
        game.sun()
    );
}

/// An hour takes six seconds; in an hour of a morning the sun turns by 10 to 20 degrees and rises by about 10.
#[test]
fn k_lets_the_day_run_until_it_is_pressed_again_or_the_sun_is_moved() {
    let mut game = Game::playing();
    let still = game.sun();
    game.seconds(1.0);
    assert_eq!(game.sun(), still, "days stand still at first");
    game.tap(KeyCode::KeyK);
    game.frames(2);
    let start = game.sun();
    let step = start.light_dir().angle_between(still.light_dir()).to_degrees();
    assert!(step < 2.0, "{step} degrees at once");
    // The level's sun does not stand on its course: it glides there.
    game.seconds(12.0);
    let hour = game.hour();
    game.seconds(6.0);
    assert!((game.hour() - hour - 1.0).abs() < 0.02, "an hour in six seconds");
    let off = game.sun().light_dir().angle_between(game.light_dir_of_hour());
    assert!(off.to_degrees() < 0.5, "{} degrees off the course", off.to_degrees());
    game.tap(KeyCode::KeyK);
    game.frames(1);
    let stopped = game.sun();
    game.seconds(1.0);
    assert_eq!(game.sun(), stopped, "pressed again");

    game.tap(KeyCode::KeyK);
    game.seconds(1.0);
    assert_ne!(game.sun(), stopped, "it runs");
    game.hold(KeyCode::ArrowUp);
    game.frames(2);
    game.release(KeyCode::ArrowUp);
    game.frames(1);
    let moved = game.sun();
    game.seconds(1.0);
    assert_eq!(game.sun(), moved, "moved by hand");
}

#[test]
fn b_switches_the_sway_of_the_view() {
    let mut game = Game::playing();
    assert!(game.walker().head_bob, "on at first");
    game.tap(KeyCode::KeyB);
    assert!(!game.walker().head_bob, "off");
}

#[test]
fn l_gives_the_mouse_to_the_sun() {
    let mut game = Game::playing();
    let (sun, walker) = (game.sun(), game.walker());
    game.hold(KeyCode::KeyL);
    game.move_mouse(Vec2::new(100.0, -50.0));
    assert!(
        game.sun().azimuth > sun.azimuth && game.sun().elevation > sun.elevation,
        "{:?}",
        game.sun()
    );
    assert_eq!(game.walker(), walker, "the view stands still");
}

#[test]
fn v_and_shift_v_choose_levels_of_detail_for_both_halves() {
    let mut game = Game::playing();
    game.0.init_resource::<LodSettings>();
    let kinds = |game: &Game| {
        let settings = game.0.world().resource::<LodSettings>();
        (settings.transition.kind, settings.right_half)
    };
    let dividers = |game: &mut Game| {
        let world = game.0.world_mut();
        let mut names = world.query::<&Name>();
        names.iter(world).filter(|name| name.as_str() == "divider").count()
    };
    game.shift_tap(KeyCode::KeyV);
    game.frames(2);
    assert_eq!(kinds(&game), (LodKind::Unpopping, Some(LodKind::Hard)));
    assert_eq!(dividers(&mut game), 1);
    assert_eq!(game.hud().notice, "levels of detail: left unpopping, right hard");
    game.tap(KeyCode::KeyV);
    game.shift_tap(KeyCode::KeyV);
    assert_eq!(kinds(&game), (LodKind::Hard, Some(LodKind::Late)));
    for _ in 0..5 {
        game.shift_tap(KeyCode::KeyV);
    }
    game.frames(2);
    assert_eq!(kinds(&game), (LodKind::Hard, None), "all kinds came round");
    assert_eq!(dividers(&mut game), 0);
}
