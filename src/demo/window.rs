//! The window: [`run`] opens it, or says in one sentence why it cannot.

use std::{
    env,
    panic::{self, AssertUnwindSafe},
    sync::Once,
};

use bevy::{
    app::AppExit,
    dev_tools::render_debug::RenderDebugOverlayPlugin,
    log::LogPlugin,
    prelude::*,
    render::{RenderPlugin, settings::RenderCreation},
    window::WindowResolution,
    winit::WinitPlugin,
};

use super::{
    DemoPlugin, Verdict,
    adapter::{self, NoAdapter},
};
use crate::{
    level::{LevelPlugin, find::AssetRoot, loader, scene::SceneSource},
    lod::settings::{LodKind, LodSettings},
    render::{UmbragePlugins, mask::MaskPlugin},
    shadow::technique::Technique,
};

/// What to play.
#[derive(Clone, Debug)]
pub struct PlayOptions {
    /// The scene to begin with; it must exist ([`SceneSource::check`]).
    pub scene: SceneSource,
    /// The technique to begin with.
    pub technique: Technique,
    /// How levels of detail take each other's place.
    pub lod: LodKind,
    /// Where levels and assets are.
    pub assets: AssetRoot,
}

/// Why the demo cannot be played. Each is one sentence; the caller prints it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlayError {
    /// No display, or no window system on it: [`flight::shots`](super::flight::shots) is what to show instead.
    #[error("no window can be opened: {0}")]
    NoDisplay(String),
    /// No graphics adapter.
    #[error(transparent)]
    NoAdapter(#[from] NoAdapter),
    /// The scene could not be loaded.
    #[error("{0}")]
    Scene(String),
    /// The app ended with this code.
    #[error("the window was closed with error code {0}")]
    Ended(u8),
}

/// Opens the window and plays until the player quits.
///
/// # Errors
/// No display, no adapter, or a scene that could not be loaded.
pub fn run(options: PlayOptions) -> Result<(), PlayError> {
    if let Some(reason) = missing_display(|name| env::var_os(name).is_some_and(|value| !value.is_empty())) {
        return Err(PlayError::NoDisplay(reason.to_owned()));
    }
    adapter::check()?;
    let mut app = windowed_app(&options)?;
    let verdict = app.world().resource::<Verdict>().clone();
    let exit = app.run();
    match (verdict.failure(), exit) {
        (_, AppExit::Success) => Ok(()),
        (Some(sentence), AppExit::Error(_)) => Err(PlayError::Scene(sentence.to_owned())),
        (None, AppExit::Error(code)) => Err(PlayError::Ended(code.get())),
    }
}

/// Why there is certainly no display, from the environment variables that are set; only X11 is built in.
fn missing_display(is_set: impl Fn(&str) -> bool) -> Option<&'static str> {
    let needs_x11 = cfg!(all(
        unix,
        not(any(target_os = "macos", target_os = "ios", target_os = "android"))
    ));
    if !needs_x11 || is_set("DISPLAY") {
        None
    } else if is_set("WAYLAND_DISPLAY") {
        Some("there is a Wayland display only, and this build needs X11: start Xwayland and set DISPLAY")
    } else {
        Some("there is no display, DISPLAY is not set")
    }
}

/// How Bevy's panic about a missing window system begins.
const NO_EVENT_LOOP: &str = "Failed to build event loop";

/// The app with its window, or why not: Bevy panics where there is no window system, and this is the border where
/// that becomes a sentence.
fn windowed_app(options: &PlayOptions) -> Result<App, PlayError> {
    silence_expected_panic();
    panic::catch_unwind(AssertUnwindSafe(|| build(options))).map_err(|payload| {
        if message_of(&*payload).starts_with(NO_EVENT_LOOP) {
            let display = env::var("DISPLAY").unwrap_or_default();
            PlayError::NoDisplay(format!("the display {display} does not answer"))
        } else {
            panic::resume_unwind(payload)
        }
    })
}

fn message_of(payload: &(dyn std::any::Any + Send)) -> &str {
    payload
        .downcast_ref::<String>()
        .map(String::as_str)
        .or_else(|| payload.downcast_ref::<&str>().copied())
        .unwrap_or_default()
}

/// Keeps the panic that becomes a sentence out of the terminal; all others are reported as before.
fn silence_expected_panic() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let report = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !message_of(info.payload()).starts_with(NO_EVENT_LOOP) {
                report(info);
            }
        }));
    });
}

fn build(options: &PlayOptions) -> App {
    let window = Window {
        title: format!("Umbrage: {}", options.scene),
        resolution: WindowResolution::new(1280, 720),
        ..default()
    };
    let defaults = DefaultPlugins
        .set(WindowPlugin {
            primary_window: Some(window),
            ..default()
        })
        .set(RenderPlugin {
            render_creation: RenderCreation::from(adapter::settings()),
            ..default()
        })
        .set(loader::asset_plugin(&options.assets))
        // It listens to F1 and F2.
        .disable::<RenderDebugOverlayPlugin>()
        // The window system is asked first, so that nothing is logged twice when it says no.
        .add_after::<WinitPlugin>(LogPlugin::default());
    let mut app = App::new();
    loader::register_sources(&mut app, &options.assets);
    app.add_plugins((
        defaults,
        LevelPlugin {
            assets: options.assets.clone(),
        },
        UmbragePlugins,
        // For judging the frozen frame; costs nothing before.
        MaskPlugin,
        DemoPlugin {
            scene: options.scene.clone(),
            scenes: playable(&options.assets),
            technique: options.technique.clone(),
        },
    ));
    app.world_mut().resource_mut::<LodSettings>().transition.kind = options.lod;
    app
}

/// All levels but the stress tests, which take long to load.
fn playable(assets: &AssetRoot) -> Vec<SceneSource> {
    let names = assets.level_names();
    let quick = names.iter().filter(|name| !name.starts_with("stress"));
    quick.map(SceneSource::level).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn a_missing_display_is_a_sentence() {
        let reason = |set: &[&str]| missing_display(|name| set.contains(&name));
        assert_eq!(reason(&["DISPLAY"]), None);
        assert_eq!(reason(&["DISPLAY", "WAYLAND_DISPLAY"]), None);
        assert!(reason(&["WAYLAND_DISPLAY"]).is_some_and(|reason| reason.contains("X11")));
        assert!(reason(&[]).is_some_and(|reason| reason.contains("DISPLAY")));
    }
}
