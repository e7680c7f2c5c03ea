//! The playable demo: screens, walker, sun and techniques by keys.
//!
//! [`run`] opens a window; [`DemoPlugin`] is the same game without one, for tests.

use std::sync::{Arc, OnceLock};

use bevy::prelude::*;

use crate::{
    level::{LevelSystems, LoadedScene, RequestedScene, inhabitants::LevelTime, scene::SceneSource},
    shadow::technique::Technique,
    ui,
};

pub mod adapter;
pub mod flight;
mod heat_map;
mod hud;
pub mod input;
mod judge;
mod levels_of_detail;
pub mod outside;
pub mod overlay;
mod photo;
pub mod player;
pub mod screens;
pub mod sun;
pub mod technique;
pub mod walker;
mod window;

pub use hud::Notice;
pub use window::{PlayError, PlayOptions, run};

/// The game without window, renderer and levels: states, input, player, head-up display.
///
/// Needs [`LevelPlugin`](crate::level::LevelPlugin), or a stand-in that answers [`RequestedScene`] with
/// [`SceneStatus`](crate::level::SceneStatus) and [`LoadedScene`](crate::level::LoadedScene).
pub struct DemoPlugin {
    /// The scene to begin with.
    pub scene: SceneSource,
    /// The scenes that a key steps through.
    pub scenes: Vec<SceneSource>,
    /// The technique to begin with.
    pub technique: Technique,
}

/// The order of the demo's systems in [`Update`]; they run while there is a scene.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DemoSystems {
    /// Intent becomes movement, settings, screens.
    Act,
    /// The head-up display is written.
    Show,
}

/// The scenes that a key steps through.
#[derive(Resource, Clone, Debug, Default)]
pub struct Scenes(pub Vec<SceneSource>);

impl Scenes {
    /// The one after `current`; the first where `current` is not in the list, none for an empty list.
    pub fn after(&self, current: Option<&SceneSource>) -> Option<SceneSource> {
        let name = current.map(SceneSource::name);
        let index = self.0.iter().position(|scene| Some(scene.name()) == name);
        let next = index.map_or(0, |index| (index + 1) % self.0.len());
        self.0.get(next).cloned()
    }
}

/// Why the demo could not do what it was asked for, kept beyond the life of the app.
#[derive(Resource, Clone, Debug, Default)]
pub struct Verdict(Arc<OnceLock<String>>);

impl Verdict {
    /// Notes the first failure.
    pub fn fail(&self, sentence: &str) {
        let _ = self.0.set(sentence.to_owned());
    }

    /// The first failure, if any.
    pub fn failure(&self) -> Option<&str> {
        self.0.get().map(String::as_str)
    }
}

impl Plugin for DemoPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(RequestedScene(Some(self.scene.clone())))
            .insert_resource(Scenes(self.scenes.clone()))
            .insert_resource(LevelTime {
                runs: true,
                ..default()
            })
            .insert_resource(technique::Chosen(self.technique.clone()))
            .init_resource::<Verdict>()
            .configure_sets(
                Update,
                (DemoSystems::Act, DemoSystems::Show)
                    .chain()
                    .after(LevelSystems)
                    .run_if(resource_exists::<LoadedScene>),
            )
            .add_plugins((
                ui::plugin,
                screens::plugin,
                input::plugin,
                player::plugin,
                sun::plugin,
                technique::plugin,
                overlay::plugin,
                outside::plugin,
                photo::plugin,
                judge::plugin,
                heat_map::plugin,
                levels_of_detail::plugin,
                hud::plugin,
            ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_go_round() {
        let scenes = Scenes(["city", "forest", "room/fence"].map(SceneSource::level).to_vec());
        let after = |name: &str| scenes.after(Some(&SceneSource::level(name))).map(|scene| scene.name());
        assert_eq!(after("city").as_deref(), Some("forest"));
        assert_eq!(after("room/fence").as_deref(), Some("city"));
        assert_eq!(after("elsewhere").as_deref(), Some("city"), "not in the list");
        assert_eq!(scenes.after(None).map(|scene| scene.name()).as_deref(), Some("city"));
        assert_eq!(
            Scenes::default().after(Some(&SceneSource::level("city"))),
            None,
            "an empty list"
        );
    }

    #[test]
    fn the_first_failure_stays() {
        let verdict = Verdict::default();
        assert_eq!(verdict.failure(), None);
        verdict.clone().fail("no such level");
        verdict.fail("something else");
        assert_eq!(verdict.failure(), Some("no such level"));
    }
}
