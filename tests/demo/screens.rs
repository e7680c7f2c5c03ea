//! Loading, playing, paused, and back.

use bevy::{
    prelude::*,
    ui::Interaction,
    window::{CursorGrabMode, CursorOptions, WindowFocused},
};
use umbrage::{
    demo::{
        outside::Outside,
        player::Player,
        screens::{Activity, Screen},
    },
    level::{LoadedScene, RequestedScene, SceneStatus, scene::SceneSource},
    ui::{help::HelpRoot, hud::HudRoot, pause::PauseButton},
};

use crate::game::Game;

fn set_status(game: &mut Game, status: SceneStatus) {
    *game.0.world_mut().resource_mut::<SceneStatus>() = status;
    game.frames(3);
}

#[test]
fn the_outside_view_makes_room_for_the_help() {
    let mut game = Game::playing();
    let is_active = |game: &mut Game| {
        let world = game.0.world_mut();
        let mut cameras = world.query_filtered::<&Camera, With<Outside>>();
        cameras.single(world).is_ok_and(|camera| camera.is_active)
    };
    game.tap(KeyCode::F5);
    assert!(is_active(&mut game), "it is shown");
    game.tap(KeyCode::F1);
    assert!(!is_active(&mut game), "it would cover the help");
    game.tap(KeyCode::F1);
    assert!(is_active(&mut game), "it is back");
}

#[test]
fn judging_without_a_picture_says_so_and_ends() {
    let mut game = Game::playing();
    game.tap(KeyCode::KeyJ);
    assert_eq!(game.activity(), Some(Activity::Judging));
    assert!(game.hud().notice.contains("nothing to judge"), "{}", game.hud().notice);
    assert!(game.0.world().resource::<Time<Virtual>>().is_paused());
    game.tap(KeyCode::Escape);
    assert_eq!(game.activity(), Some(Activity::Running));
    assert!(!game.0.world().resource::<Time<Virtual>>().is_paused());
}

#[test]
fn loading_shows_progress_and_ends_in_play() {
    let mut game = Game::new();
    assert_eq!(game.screen(), Screen::Loading);
    assert_eq!(
        game.0.world().resource::<RequestedScene>().0,
        Some(SceneSource::level("forest"))
    );
    set_status(
        &mut game,
        SceneStatus::Loading {
            done: 3,
            total: 12,
            what: "meshes".into(),
        },
    );
    let progress = game.progress();
    assert_eq!(
        (progress.title.as_str(), progress.fraction, progress.failed),
        ("forest", Some(0.25), false)
    );
    assert!(progress.line.contains("meshes"), "{}", progress.line);
    assert_eq!(
        (game.count::<Player>(), game.count::<Camera>()),
        (0, 1),
        "only the camera of the interface"
    );

    game.finish_loading();
    assert_eq!(
        (game.screen(), game.activity()),
        (Screen::Play, Some(Activity::Running))
    );
    assert_eq!(
        (game.count::<Player>(), game.count::<Camera>()),
        (1, 1),
        "only the player's camera"
    );
    assert_eq!(game.count::<HudRoot>(), 1);
    assert_eq!(game.walker().eye(), Vec3::new(0.0, 1.7, 0.0), "at the spawn");
}

#[test]
fn a_scene_that_fails_is_a_sentence_and_escape_leaves_with_an_error() {
    let mut game = Game::new();
    set_status(&mut game, SceneStatus::Failed("there is no level `forest`".into()));
    assert_eq!(game.screen(), Screen::Loading, "nothing to play");
    let progress = game.progress();
    assert!(
        progress.failed && progress.line.contains("there is no level `forest`"),
        "{progress:?}"
    );
    assert!(progress.line.contains("Esc"), "says how to leave: {progress:?}");
    assert_eq!(game.exit(), None);
    game.tap(KeyCode::Escape);
    assert!(game.exit().is_some_and(|exit| exit.is_error()));
}

#[test]
fn escape_leaves_while_loading() {
    let mut game = Game::new();
    game.tap(KeyCode::Escape);
    assert_eq!(game.exit(), Some(AppExit::Success));
}

#[test]
fn pause_freezes_the_walker_and_frees_the_mouse() {
    let mut game = Game::playing();
    let cursor = |game: &mut Game| game.only::<CursorOptions, _>(|cursor| (cursor.visible, cursor.grab_mode));
    assert_eq!(cursor(&mut game), (false, CursorGrabMode::Locked));
    game.hold(KeyCode::KeyW);
    game.seconds(0.5);
    let moving = game.walker();
    assert!(moving.feet.z < -1.0, "{}", moving.feet);

    game.tap(KeyCode::Escape);
    assert_eq!(game.activity(), Some(Activity::Paused));
    assert_eq!(cursor(&mut game), (true, CursorGrabMode::None));
    assert_eq!(game.count::<PauseButton>(), 2);
    let paused = game.walker();
    game.seconds(0.5);
    game.move_mouse(Vec2::new(50.0, 20.0));
    game.tap(KeyCode::KeyF);
    game.tap(KeyCode::KeyT);
    assert_eq!(game.walker(), paused, "nothing moves");
    assert_eq!(game.technique().to_string(), "zp4+lispsm", "T does nothing here");
    assert_eq!(game.exit(), None);

    game.tap(KeyCode::Escape);
    assert_eq!(game.activity(), Some(Activity::Running));
    assert_eq!(cursor(&mut game), (false, CursorGrabMode::Locked));
    assert_eq!(game.count::<PauseButton>(), 0);
    game.seconds(0.5);
    assert!(game.walker().feet.z < paused.feet.z - 1.0, "W is still held");
}

#[test]
fn q_quits_from_the_pause_menu_only() {
    let mut game = Game::playing();
    game.tap(KeyCode::KeyQ);
    assert_eq!(game.exit(), None);
    game.tap(KeyCode::Escape);
    game.tap(KeyCode::KeyQ);
    assert_eq!(game.exit(), Some(AppExit::Success));
}

#[test]
fn the_buttons_of_the_pause_menu_work() {
    let click = |game: &mut Game, wanted: PauseButton| {
        let world = game.0.world_mut();
        let mut buttons = world.query::<(&PauseButton, &mut Interaction)>();
        for (button, mut interaction) in buttons.iter_mut(world) {
            if *button == wanted {
                *interaction = Interaction::Pressed;
            }
        }
        game.frames(3);
    };
    let mut game = Game::playing();
    game.tap(KeyCode::Escape);
    click(&mut game, PauseButton::Resume);
    assert_eq!((game.activity(), game.exit()), (Some(Activity::Running), None));
    game.tap(KeyCode::Escape);
    click(&mut game, PauseButton::Quit);
    assert_eq!(game.exit(), Some(AppExit::Success));
}

#[test]
fn losing_the_focus_pauses() {
    let mut game = Game::playing();
    game.0.world_mut().write_message(WindowFocused {
        window: Entity::PLACEHOLDER,
        focused: false,
    });
    game.frames(3);
    assert_eq!(game.activity(), Some(Activity::Paused));
}

#[test]
fn n_goes_to_the_next_level_and_keeps_the_technique() {
    let mut game = Game::playing();
    game.tap(KeyCode::KeyT);
    let technique = game.technique();
    game.tap(KeyCode::KeyN);
    assert_eq!(game.screen(), Screen::Loading);
    assert_eq!(
        game.0.world().resource::<RequestedScene>().0,
        Some(SceneSource::level("city"))
    );
    assert_eq!(
        (game.count::<Player>(), game.count::<HudRoot>(), game.count::<Camera>()),
        (0, 0, 1)
    );
    game.frames(5);
    assert_eq!(game.screen(), Screen::Loading, "the old scene does not count");

    game.finish_loading();
    assert_eq!(game.screen(), Screen::Play);
    assert_eq!(game.technique(), technique);
    assert_eq!(
        game.sun_settings().map(umbrage::shadow::technique::Technique::Umbrage),
        Some(technique)
    );
    game.seconds(0.4);
    assert!(game.hud().status.contains("city"), "{}", game.hud().status);
}

#[test]
fn a_scene_that_is_loaded_again_while_playing_shows_the_loading_screen() {
    let mut game = Game::playing();
    game.0.world_mut().remove_resource::<LoadedScene>();
    set_status(&mut game, SceneStatus::default());
    assert_eq!(game.screen(), Screen::Loading);
    game.finish_loading();
    assert_eq!((game.screen(), game.count::<Player>()), (Screen::Play, 1));
}

#[test]
fn f1_shows_every_key_and_hides_them_again() {
    let mut game = Game::playing();
    game.tap(KeyCode::F1);
    assert_eq!(game.count::<HelpRoot>(), 1);
    let world = game.0.world_mut();
    let texts: Vec<String> = world.query::<&Text>().iter(world).map(|text| text.0.clone()).collect();
    for row in umbrage::demo::input::ROWS {
        assert!(texts.contains(&row.label()), "{} is not shown", row.label());
        assert!(texts.iter().any(|text| text == row.does), "{} is not shown", row.does);
    }
    game.tap(KeyCode::F1);
    assert_eq!(game.count::<HelpRoot>(), 0);
}

#[test]
fn a_window_without_area_does_no_harm() {
    let mut game = Game::playing();
    let world = game.0.world_mut();
    let mut window = world.query::<&mut Window>().single_mut(world).unwrap();
    window.resolution.set_physical_resolution(0, 0);
    game.hold(KeyCode::KeyW);
    game.seconds(0.2);
    assert_eq!(game.activity(), Some(Activity::Running));
}
