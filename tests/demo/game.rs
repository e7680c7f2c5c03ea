//! The harness: an app with the demo's plugin, where scenes load when the test says so.

use std::time::Duration;

use bevy::{
    input::{
        ButtonState, InputPlugin,
        keyboard::{Key, KeyboardInput, NativeKey},
        mouse::MouseMotion,
    },
    prelude::*,
    state::app::StatesPlugin,
    time::TimeUpdateStrategy,
    transform::TransformPlugin,
    window::{CursorOptions, PrimaryWindow},
};
use umbrage::{
    demo::{
        DemoPlugin,
        player::Player,
        screens::{Activity, Screen},
        sun::{Day, SunAngles},
        technique::Chosen,
        walker::Walker,
    },
    level::{
        LoadedScene, RequestedScene, SceneStatus, Sun,
        format::{Spawn, SunSettings},
        ground::Ground,
        scene::SceneSource,
    },
    shadow::{settings::SunShadows, technique::Technique},
    ui::{hud::HudText, loading::Progress},
};

/// A game that is stepped by hand.
pub(crate) struct Game(pub(crate) App);

impl Game {
    /// One frame of game time.
    pub(crate) const FRAME: Duration = Duration::from_millis(16);

    /// A game that waits for its first scene, `forest`.
    pub(crate) fn new() -> Self {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, StatesPlugin, InputPlugin, TransformPlugin))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Self::FRAME))
            .init_resource::<RequestedScene>()
            .init_resource::<SceneStatus>()
            .add_message::<bevy::window::WindowFocused>()
            .add_plugins(DemoPlugin {
                scene: SceneSource::level("forest"),
                scenes: ["city", "forest"].map(SceneSource::level).to_vec(),
                technique: Technique::default(),
            });
        app.world_mut()
            .spawn((Window::default(), CursorOptions::default(), PrimaryWindow));
        let mut game = Self(app);
        game.frames(2);
        game
    }

    /// A game that plays on a plane, looking along −z from the origin, with a sun at 45 degrees from the east.
    pub(crate) fn playing() -> Self {
        let mut game = Self::new();
        game.finish_loading();
        game
    }

    /// What the level room does when a scene is there.
    pub(crate) fn finish_loading(&mut self) {
        let world = self.0.world_mut();
        let name = world
            .resource::<RequestedScene>()
            .0
            .as_ref()
            .map_or_else(String::new, SceneSource::name);
        let scene = LoadedScene {
            name,
            shots: vec![],
            named_only: vec![],
            spawn: Spawn {
                position: Vec3::new(0.0, 1.7, 0.0),
                look_at: Vec3::new(0.0, 1.7, -1.0),
            },
            sun: SunSettings::default(),
            ground: Ground::flat(0.0),
            paths: vec![],
            notes: vec![],
        };
        let old: Vec<Entity> = world.query_filtered::<Entity, With<Sun>>().iter(world).collect();
        for sun in old {
            world.despawn(sun);
        }
        world.spawn((
            Sun,
            DirectionalLight::default(),
            Transform::default().looking_to(Vec3::new(-1.0, -1.0, 0.0), Vec3::Y),
        ));
        world.insert_resource(scene);
        *world.resource_mut::<SceneStatus>() = SceneStatus::Ready;
        self.frames(4);
    }

    /// Runs some frames; none after the one in which the app wants to end.
    pub(crate) fn frames(&mut self, count: usize) {
        for _ in 0..count {
            if self.exit().is_some() {
                break;
            }
            self.0.update();
        }
    }

    /// Runs frames for this much game time.
    pub(crate) fn seconds(&mut self, seconds: f32) {
        self.frames((seconds / Self::FRAME.as_secs_f32()).round() as usize);
    }

    /// Presses a key until [`Game::release`].
    pub(crate) fn hold(&mut self, key: KeyCode) {
        self.send(key, ButtonState::Pressed);
    }

    /// Releases a key.
    pub(crate) fn release(&mut self, key: KeyCode) {
        self.send(key, ButtonState::Released);
    }

    /// Presses and releases a key, with frames for what follows from it.
    pub(crate) fn tap(&mut self, key: KeyCode) {
        self.hold(key);
        self.frames(1);
        self.release(key);
        self.frames(2);
    }

    /// Taps a key with Shift held.
    pub(crate) fn shift_tap(&mut self, key: KeyCode) {
        self.hold(KeyCode::ShiftLeft);
        self.tap(key);
        self.release(KeyCode::ShiftLeft);
        self.frames(1);
    }

    fn send(&mut self, key_code: KeyCode, state: ButtonState) {
        let world = self.0.world_mut();
        let window = world
            .query_filtered::<Entity, With<PrimaryWindow>>()
            .single(world)
            .unwrap();
        world.write_message(KeyboardInput {
            key_code,
            logical_key: Key::Unidentified(NativeKey::Unidentified),
            state,
            text: None,
            repeat: false,
            window,
        });
    }

    /// Moves the mouse, in pixels to the right and down, within one frame.
    pub(crate) fn move_mouse(&mut self, delta: Vec2) {
        self.0.world_mut().write_message(MouseMotion { delta });
        self.frames(1);
    }

    /// The screen.
    pub(crate) fn screen(&self) -> Screen {
        *self.0.world().resource::<State<Screen>>().get()
    }

    /// Running or paused; `None` while loading.
    pub(crate) fn activity(&self) -> Option<Activity> {
        self.0
            .world()
            .get_resource::<State<Activity>>()
            .map(|state| *state.get())
    }

    /// The player's walker.
    pub(crate) fn walker(&mut self) -> Walker {
        self.only::<Player, _>(|player| player.walker)
    }

    /// The chosen technique.
    pub(crate) fn technique(&self) -> Technique {
        self.0.world().resource::<Chosen>().0.clone()
    }

    /// Settings on the sun's entity.
    pub(crate) fn sun_settings(&mut self) -> Option<SunShadows> {
        let world = self.0.world_mut();
        world
            .query_filtered::<Option<&SunShadows>, With<Sun>>()
            .single(world)
            .unwrap()
            .cloned()
    }

    /// The hour of a day that runs.
    pub(crate) fn hour(&self) -> f32 {
        self.0.world().resource::<Day>().hour.expect("the day runs")
    }

    /// The direction of sunlight at that hour, by the course of the level's day.
    pub(crate) fn light_dir_of_hour(&self) -> Vec3 {
        let course = self.0.world().resource::<LoadedScene>().sun.course();
        course.light_dir(self.hour())
    }

    /// Where the sun stands.
    pub(crate) fn sun(&mut self) -> SunAngles {
        let world = self.0.world_mut();
        let sun = world.query_filtered::<&Transform, With<Sun>>().single(world).unwrap();
        SunAngles::from_light_dir(sun.forward().as_vec3())
    }

    /// What the head-up display says.
    pub(crate) fn hud(&self) -> HudText {
        self.0.world().resource::<HudText>().clone()
    }

    /// What the loading screen says.
    pub(crate) fn progress(&self) -> Progress {
        self.0.world().resource::<Progress>().clone()
    }

    /// How many entities have this component.
    pub(crate) fn count<C: Component>(&mut self) -> usize {
        let world = self.0.world_mut();
        world.query::<&C>().iter(world).count()
    }

    /// Reads the only entity with this component.
    pub(crate) fn only<C: Component, R>(&mut self, read: impl FnOnce(&C) -> R) -> R {
        let world = self.0.world_mut();
        read(world.query::<&C>().single(world).expect("exactly one"))
    }

    /// How the app wants to end, if it does.
    pub(crate) fn exit(&self) -> Option<AppExit> {
        self.0.should_exit()
    }
}
