//! The key that steps through the ways in which levels of detail take each other's place, and the overlay that shows them.

use std::any::TypeId;

use bevy::prelude::*;

use super::{
    DemoSystems,
    hud::Notice,
    input::{Action, Intent},
    overlay::Overlay,
    screens::Activity,
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
            show_posts.run_if(resource_exists::<GizmoConfigStore>.and_then(resource_changed::<Overlay>)),
        )
            .chain()
            .in_set(DemoSystems::Act),
    );
}

/// The one that follows, of those that differ from each other here.
fn next(kind: LodKind) -> LodKind {
    match kind {
        LodKind::Unpopping => LodKind::Hard,
        LodKind::Hard => LodKind::Late,
        LodKind::Late => LodKind::Plain,
        LodKind::Plain => LodKind::Dither,
        LodKind::Dither | LodKind::Geomorph => LodKind::Unpopping,
    }
}

fn what(kind: LodKind) -> &'static str {
    match kind {
        LodKind::Unpopping => "unpopping: one level opaque, the other faded over it",
        LodKind::Hard | LodKind::Geomorph => "hard: switched at once",
        LodKind::Late => "late: switched at once, twice as far away",
        LodKind::Plain => "plain: both semitransparent",
        LodKind::Dither => "dither: Bevy's visibility ranges",
    }
}

fn cycle(intent: Res<Intent>, mut settings: ResMut<LodSettings>, mut notice: ResMut<Notice>) {
    if intent.started(Action::NextLod) {
        settings.transition.kind = next(settings.transition.kind);
        notice.show(format!("levels of detail {}", what(settings.transition.kind)));
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
        assert_eq!(seen.len(), LodKind::ALL.len() - 1, "all but geomorph: {seen:?}");
        assert!(
            LodKind::ALL.iter().all(|kind| what(*kind).is_ascii()),
            "the font has ASCII only"
        );
    }
}
