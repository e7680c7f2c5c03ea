//! Head-up display, help, judgement, loading screen and pause menu, made with Bevy's UI.
//!
//! This room only shows: what it shows is written into its view models ([`hud::HudText`], [`loading::Progress`]),
//! and each screen is a function that returns a bundle to spawn. Texts are ASCII, as the built-in font is.

use bevy::{prelude::*, window::PrimaryWindow};

pub mod help;
pub mod hud;
pub mod judge;
pub mod loading;
pub mod pause;

/// The systems that bring view models to the screen and scale the interface with the window.
pub(crate) fn plugin(app: &mut App) {
    app.add_plugins((hud::plugin, loading::plugin, pause::plugin));
    app.add_systems(Update, scale.run_if(resource_exists::<UiScale>));
}

const PANEL: Color = Color::srgba(0.02, 0.025, 0.035, 0.88);
const TEXT: Color = Color::srgb(0.93, 0.94, 0.95);
const FAINT: Color = Color::srgb(0.74, 0.77, 0.81);
const ACCENT: Color = Color::srgb(1.0, 0.82, 0.42);
const WARNING: Color = Color::srgb(1.0, 0.55, 0.42);

fn text(size: f32, color: Color, content: impl Into<String>) -> impl Bundle {
    (Text::new(content), TextFont::from_font_size(size), TextColor(color))
}

/// The window height, in logical pixels, for which sizes are given.
const DESIGN_HEIGHT: f32 = 720.0;
/// The window width below which the interface shrinks.
const DESIGN_WIDTH: f32 = 1000.0;

/// The interface's scale in a window of this logical size: it grows with large windows and shrinks with small
/// ones, as far as the text stays readable. A window without area (minimized) has the smallest scale.
pub fn scale_of(size: Vec2) -> f32 {
    let fit = (size.x / DESIGN_WIDTH).min(size.y / DESIGN_HEIGHT);
    if fit.is_finite() { fit.clamp(0.7, 2.0) } else { 1.0 }
}

// Reads the size every frame: the window system writes it outside of change detection.
fn scale(windows: Query<&Window, With<PrimaryWindow>>, mut scale: ResMut<UiScale>) {
    if let Ok(window) = windows.single() {
        let wanted = scale_of(window.resolution.size());
        if scale.0 != wanted {
            scale.0 = wanted;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interface_follows_the_window_within_limits() {
        assert_eq!(scale_of(Vec2::new(1280.0, 720.0)), 1.0);
        assert_eq!(scale_of(Vec2::new(3840.0, 2160.0)), 2.0);
        assert_eq!(scale_of(Vec2::new(320.0, 180.0)), 0.7);
        assert_eq!(scale_of(Vec2::ZERO), 0.7);
        assert_eq!(scale_of(Vec2::NAN), 1.0);
    }
}
