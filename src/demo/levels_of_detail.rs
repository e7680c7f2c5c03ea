//! The keys that step through the ways in which levels of detail take each other's place, in the whole picture or side by
//! side, and the overlay that shows them.

use std::any::TypeId;

use bevy::prelude::*;

use super::{
    DemoSystems,
    hud::Notice,
    input::{Action, Intent},
    overlay::Overlay,
    screens::{Activity, Screen},
};
use crate::lod::{
    gizmos::LodGizmos,
    settings::{LodKind, LodSettings},
};

pub(super) fn plugin(app: &mut App) {
    app.add_systems(
        Update,
        (
            cycle.run_if(in_state(Activity::Running).and_then(resource_exists::<LodSettings>)),
            show_divider.run_if(in_state(Screen::Play).and_then(resource_exists::<LodSettings>)),
            show_posts.run_if(resource_exists::<GizmoConfigStore>.and_then(resource_changed::<Overlay>)),
        )
            .chain()
            .in_set(DemoSystems::Act),
    );
}

/// The one that follows.
fn next(kind: LodKind) -> LodKind {
    match kind {
        LodKind::Unpopping => LodKind::Hard,
        LodKind::Hard => LodKind::Late,
        LodKind::Late => LodKind::Plain,
        LodKind::Plain => LodKind::Dither,
        LodKind::Dither => LodKind::Geomorph,
        LodKind::Geomorph => LodKind::Unpopping,
    }
}

fn what(kind: LodKind) -> &'static str {
    match kind {
        LodKind::Unpopping => "unpopping: one level opaque, the other faded over it",
        LodKind::Hard => "hard: switched at once",
        LodKind::Late => "late: switched at once, twice as far away",
        LodKind::Plain => "plain: both semitransparent",
        LodKind::Dither => "dither: Bevy's visibility ranges",
        LodKind::Geomorph => "geomorph: vertices move where levels correspond",
    }
}

/// Between two ways side by side.
#[derive(Component)]
struct Divider;

fn cycle(intent: Res<Intent>, mut settings: ResMut<LodSettings>, mut notice: ResMut<Notice>) {
    let left = intent.started(Action::NextLod);
    let right = intent.started(Action::NextLodOnTheRight);
    if left {
        settings.transition.kind = next(settings.transition.kind);
    }
    if right {
        settings.right_half = match settings.right_half.map(next) {
            None => Some(LodKind::Hard),
            Some(kind) => Some(kind).filter(|kind| *kind != LodKind::Hard),
        };
    }
    if left || right {
        let kind = settings.transition.kind;
        notice.show(match settings.right_half {
            Some(other) => format!("levels of detail: left {}, right {}", kind.name(), other.name()),
            None => format!("levels of detail {}", what(kind)),
        });
    }
}

/// Draws a line where the halves meet.
fn show_divider(mut commands: Commands, settings: Res<LodSettings>, dividers: Query<Entity, With<Divider>>) {
    match (settings.right_half, dividers.is_empty()) {
        (Some(_), true) => {
            commands.spawn((
                Name::new("divider"),
                Divider,
                Node {
                    position_type: PositionType::Absolute,
                    left: percent(50),
                    width: px(2),
                    height: percent(100),
                    ..default()
                },
                BackgroundColor(Color::srgba(1.0, 1.0, 1.0, 0.6)),
                DespawnOnExit(Screen::Play),
            ));
        }
        (None, false) => dividers.iter().for_each(|divider| commands.entity(divider).despawn()),
        _ => {}
    }
}

fn show_posts(overlay: Res<Overlay>, mut store: ResMut<GizmoConfigStore>) {
    if let Some((config, _)) = store.get_config_mut_dyn(&TypeId::of::<LodGizmos>()) {
        config.enabled = overlay.has_posts();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_ways_come_round() {
        let mut seen = vec![LodKind::default()];
        while seen.len() < 20 && next(seen[seen.len() - 1]) != LodKind::default() {
            seen.push(next(seen[seen.len() - 1]));
        }
        assert_eq!(seen.len(), LodKind::ALL.len(), "{seen:?}");
        assert!(
            LodKind::ALL.iter().all(|kind| what(*kind).is_ascii()),
            "the font has ASCII only"
        );
    }
}
