//! The head-up display: one panel of text and one line of notice.

use bevy::prelude::*;

use super::{ACCENT, FAINT, PANEL, TEXT, text};

/// What the head-up display shows.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct HudText {
    /// The heading.
    pub title: String,
    /// The table of settings, one line each.
    pub settings: String,
    /// Frame time, scene, place.
    pub status: String,
    /// What just happened; empty: nothing.
    pub notice: String,
}

#[derive(Component, Clone, Copy)]
enum Part {
    Title,
    Settings,
    Status,
    Notice,
}

/// Root of the head-up display, so that it can be hidden for a photo.
#[derive(Component)]
pub struct HudRoot;

/// The head-up display over the whole window.
pub fn hud() -> impl Bundle {
    (
        Name::new("Head-up display"),
        HudRoot,
        Node {
            width: percent(100),
            height: percent(100),
            position_type: PositionType::Absolute,
            flex_direction: FlexDirection::Column,
            justify_content: JustifyContent::SpaceBetween,
            align_items: AlignItems::FlexStart,
            padding: UiRect::all(px(10)),
            ..default()
        },
        Pickable::IGNORE,
        children![
            (
                panel(FlexDirection::Column),
                children![
                    (text(17.0, ACCENT, ""), Part::Title),
                    (text(13.0, TEXT, ""), Part::Settings),
                    (text(13.0, FAINT, ""), Part::Status),
                ],
            ),
            (
                panel(FlexDirection::Row),
                children![(text(15.0, ACCENT, ""), Part::Notice)]
            ),
        ],
    )
}

fn panel(flex_direction: FlexDirection) -> impl Bundle {
    (
        Node {
            flex_direction,
            row_gap: px(6),
            padding: UiRect::axes(px(10), px(7)),
            border_radius: BorderRadius::all(px(6)),
            ..default()
        },
        BackgroundColor(PANEL),
        Pickable::IGNORE,
    )
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<HudText>()
        .add_systems(PostUpdate, show.before(bevy::ui::UiSystems::Prepare));
}

fn show(hud: Res<HudText>, mut parts: Query<(Ref<Part>, &mut Text, &ChildOf)>, mut panels: Query<&mut Node>) {
    for (part, mut text, parent) in &mut parts {
        if !hud.is_changed() && !part.is_added() {
            continue;
        }
        let wanted = match *part {
            Part::Title => &hud.title,
            Part::Settings => &hud.settings,
            Part::Status => &hud.status,
            Part::Notice => &hud.notice,
        };
        if text.0 != *wanted {
            text.0.clone_from(wanted);
        }
        if let (Part::Notice, Ok(mut panel)) = (*part, panels.get_mut(parent.parent())) {
            panel.display = if wanted.is_empty() {
                Display::None
            } else {
                Display::Flex
            };
        }
    }
}
