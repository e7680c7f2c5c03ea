//! The loading screen: a heading, a bar, what is being loaded, or why it failed.

use bevy::prelude::*;

use super::{ACCENT, FAINT, TEXT, WARNING, text};

/// What the loading screen shows.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct Progress {
    /// The scene's name.
    pub title: String,
    /// Share done, 0..=1; `None` before it is known.
    pub fraction: Option<f32>,
    /// What is being loaded, or the sentence that says what went wrong.
    pub line: String,
    /// Whether it went wrong.
    pub failed: bool,
}

#[derive(Component, Clone, Copy)]
enum Part {
    Title,
    Bar,
    Line,
}

/// The loading screen over the whole window.
pub fn loading() -> impl Bundle {
    (
        Name::new("Loading screen"),
        GlobalZIndex(30),
        Node {
            width: percent(100),
            height: percent(100),
            position_type: PositionType::Absolute,
            flex_direction: FlexDirection::Column,
            justify_content: JustifyContent::Center,
            align_items: AlignItems::Center,
            row_gap: px(14),
            padding: UiRect::all(px(20)),
            ..default()
        },
        BackgroundColor(Color::srgb(0.05, 0.06, 0.08)),
        children![
            (text(28.0, TEXT, ""), Part::Title),
            (
                Node {
                    width: percent(50),
                    height: px(8),
                    border_radius: BorderRadius::all(px(4)),
                    ..default()
                },
                BackgroundColor(Color::srgb(0.16, 0.18, 0.22)),
                children![(
                    Node {
                        width: percent(0),
                        height: percent(100),
                        border_radius: BorderRadius::all(px(4)),
                        ..default()
                    },
                    BackgroundColor(ACCENT),
                    Part::Bar,
                )],
            ),
            (
                text(15.0, FAINT, ""),
                TextLayout::justify(Justify::Center),
                Node {
                    max_width: percent(90),
                    ..default()
                },
                Part::Line,
            ),
            text(13.0, FAINT, "Esc quits"),
        ],
    )
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Progress>()
        .add_systems(PostUpdate, show.before(bevy::ui::UiSystems::Prepare));
}

fn show(
    progress: Res<Progress>,
    mut texts: Query<(Ref<Part>, &mut Text, &mut TextColor)>,
    mut bars: Query<(Ref<Part>, &mut Node), Without<Text>>,
) {
    for (part, mut text, mut color) in &mut texts {
        if progress.is_changed() || part.is_added() {
            match *part {
                Part::Title => text.0.clone_from(&progress.title),
                Part::Line => {
                    text.0.clone_from(&progress.line);
                    color.0 = if progress.failed { WARNING } else { FAINT };
                }
                Part::Bar => {}
            }
        }
    }
    for (part, mut node) in &mut bars {
        if progress.is_changed() || part.is_added() {
            node.width = percent(100.0 * progress.fraction.unwrap_or(0.0).clamp(0.0, 1.0));
        }
    }
}
