//! The table of keys.

use bevy::prelude::*;

use super::{ACCENT, PANEL, TEXT, text};

/// Marks the help overlay.
#[derive(Component)]
pub struct HelpRoot;

/// An overlay in the middle of the window: a row of keys and what they do for each of `rows`.
pub fn help(rows: Vec<(String, String)>) -> impl Bundle {
    let cells = rows
        .into_iter()
        .flat_map(|(keys, does)| [(keys, ACCENT), (does, TEXT)])
        .collect::<Vec<_>>();
    (
        Name::new("Help"),
        HelpRoot,
        GlobalZIndex(10),
        Node {
            width: percent(100),
            height: percent(100),
            position_type: PositionType::Absolute,
            justify_content: JustifyContent::Center,
            align_items: AlignItems::Center,
            ..default()
        },
        Pickable::IGNORE,
        children![(
            Node {
                display: Display::Grid,
                grid_template_columns: vec![GridTrack::auto(), GridTrack::auto()],
                column_gap: px(24),
                row_gap: px(5),
                padding: UiRect::axes(px(24), px(16)),
                border_radius: BorderRadius::all(px(8)),
                ..default()
            },
            BackgroundColor(PANEL.with_alpha(0.97)),
            Pickable::IGNORE,
            Children::spawn(SpawnIter(
                cells.into_iter().map(|(content, color)| text(15.0, color, content))
            )),
        )],
    )
}
