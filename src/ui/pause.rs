//! The pause menu.

use bevy::prelude::*;

use super::{ACCENT, PANEL, TEXT, text};

/// A button of the pause menu; pressed when its [`Interaction`] is.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(Button)]
pub enum PauseButton {
    /// Go on.
    Resume,
    /// Leave.
    Quit,
}

const IDLE: Color = Color::srgb(0.13, 0.15, 0.19);
const HOVERED: Color = Color::srgb(0.22, 0.25, 0.31);

/// The pause menu over a darkened window.
pub fn pause() -> impl Bundle {
    (
        Name::new("Pause menu"),
        GlobalZIndex(20),
        Node {
            width: percent(100),
            height: percent(100),
            position_type: PositionType::Absolute,
            flex_direction: FlexDirection::Column,
            justify_content: JustifyContent::Center,
            align_items: AlignItems::Center,
            row_gap: px(12),
            ..default()
        },
        BackgroundColor(PANEL.with_alpha(0.55)),
        children![
            text(28.0, ACCENT, "Paused"),
            button(PauseButton::Resume, "Resume (Esc)"),
            button(PauseButton::Quit, "Quit (Q)"),
        ],
    )
}

fn button(button: PauseButton, label: &'static str) -> impl Bundle {
    (
        button,
        Node {
            width: px(220),
            justify_content: JustifyContent::Center,
            padding: UiRect::axes(px(16), px(9)),
            border_radius: BorderRadius::all(px(6)),
            ..default()
        },
        BackgroundColor(IDLE),
        children![text(17.0, TEXT, label)],
    )
}

pub(super) fn plugin(app: &mut App) {
    app.add_systems(Update, tint);
}

fn tint(mut buttons: Query<(&Interaction, &mut BackgroundColor), (Changed<Interaction>, With<PauseButton>)>) {
    for (interaction, mut color) in &mut buttons {
        color.0 = if *interaction == Interaction::None {
            IDLE
        } else {
            HOVERED
        };
    }
}
