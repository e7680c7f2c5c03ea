//! Pictures side by side with a line below: technique, truth and their difference.

use bevy::prelude::*;

use super::{ACCENT, TEXT, text};

/// Marks the pictures of a judgement.
#[derive(Component)]
pub struct JudgeRoot;

/// A picture and what it shows.
#[derive(Clone, Debug)]
pub struct Panel {
    /// The picture.
    pub image: Handle<Image>,
    /// Its heading.
    pub title: String,
}

/// Pictures beside each other over a darkened window, and a line of text below.
pub fn panels(panels: Vec<Panel>, line: String) -> impl Bundle {
    let share = 100.0 / panels.len().max(1) as f32;
    let columns: Vec<_> = panels.into_iter().map(|panel| column(panel, share)).collect();
    (
        Name::new("Judgement"),
        JudgeRoot,
        GlobalZIndex(15),
        Node {
            width: percent(100),
            height: percent(100),
            position_type: PositionType::Absolute,
            flex_direction: FlexDirection::Column,
            justify_content: JustifyContent::Center,
            align_items: AlignItems::Center,
            row_gap: px(14),
            ..default()
        },
        BackgroundColor(Color::srgb(0.02, 0.025, 0.035)),
        children![
            (
                Node {
                    width: percent(100),
                    flex_direction: FlexDirection::Row,
                    align_items: AlignItems::End,
                    ..default()
                },
                Children::spawn(SpawnIter(columns.into_iter())),
            ),
            text(16.0, TEXT, line),
        ],
    )
}

fn column(panel: Panel, share: f32) -> impl Bundle {
    (
        Node {
            width: percent(share),
            flex_direction: FlexDirection::Column,
            align_items: AlignItems::Center,
            row_gap: px(6),
            padding: UiRect::horizontal(px(4)),
            ..default()
        },
        children![
            text(13.0, ACCENT, panel.title),
            (
                Node {
                    width: percent(100),
                    ..default()
                },
                ImageNode::new(panel.image),
            ),
        ],
    )
}
