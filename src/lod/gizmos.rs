//! [`LodGizmos`]: levels and crossings in color.

use bevy::{
    color::palettes::basic,
    gizmos::{AppGizmoBuilder, GizmoPlugin},
    prelude::*,
};

use super::{
    LodSystems,
    casters::CastsFor,
    chain::{LodChain, LodState},
};
use crate::maths::lod::crossing::Shown;

/// Draws a post on every chain in the color of what it shows, when its [`GizmoConfig`] is enabled (it is not by default).
#[derive(Clone, Debug, Reflect, GizmoConfigGroup)]
#[reflect(Clone, Default, Debug)]
pub struct LodGizmos {
    /// Height of the posts in metres; default 3, which shows above undergrowth.
    pub height: f32,
}

impl Default for LodGizmos {
    fn default() -> Self {
        Self { height: 3.0 }
    }
}

/// White, green, yellow, red from fine to coarse; magenta while levels cross, black where Bevy's dither decides.
#[must_use]
pub fn color(shown: Option<Shown>) -> Color {
    let levels = [basic::WHITE, basic::LIME, basic::YELLOW, basic::RED];
    match shown {
        Some(Shown::Level(level)) => levels[level.min(levels.len() - 1)].into(),
        Some(Shown::Crossing(_)) => basic::FUCHSIA.into(),
        None => Color::BLACK,
    }
}

/// Draws [`LodGizmos`] in apps that have Bevy's gizmos.
pub(super) fn plugin(app: &mut App) {
    if !app.is_plugin_added::<GizmoPlugin>() {
        return;
    }
    let disabled = GizmoConfig {
        enabled: false,
        ..default()
    };
    app.insert_gizmo_config(LodGizmos::default(), disabled)
        .add_systems(PostUpdate, draw.after(LodSystems::Select).run_if(is_enabled));
}

fn is_enabled(store: Res<GizmoConfigStore>) -> bool {
    store.config::<LodGizmos>().0.enabled
}

fn draw(
    chains: Query<(&LodState, &Transform, &GlobalTransform, Has<ChildOf>), (With<LodChain>, Without<CastsFor>)>,
    mut gizmos: Gizmos<LodGizmos>,
) {
    let height = gizmos.config_ext.height;
    for (state, local, global, is_child) in &chains {
        let foot = if is_child {
            global.translation()
        } else {
            local.translation
        };
        let color = color(state.shown());
        gizmos.line(foot, foot + Vec3::Y * height, color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maths::lod::crossing::Crossing;

    #[test]
    fn what_differs_has_different_colors() {
        let crossing = Crossing { from: 0, to: 1, t: 0.5 };
        let mut colors: Vec<Color> = (0..4).map(|level| color(Some(Shown::Level(level)))).collect();
        colors.extend([color(Some(Shown::Crossing(crossing))), color(None)]);
        for (i, one) in colors.iter().enumerate() {
            assert!(!colors[..i].contains(one), "{one:?} twice");
        }
        assert_eq!(color(Some(Shown::Level(9))), colors[3]);
    }
}
