//! Figures that live in a level: people on pavements, deer in clearings.
//!
//! ```text
//! rules of the level ─ plan ─► who, where, when ─ spawn ─► joints and levels of detail ─ stir, every frame ─► poses
//! ```
//!
//! Place and pose are functions of [`LevelTime`] alone. It stands still unless somebody lets it run: pictures are the
//! same every time, and a game moves.

use bevy::prelude::*;

pub mod plan;
pub mod route;
pub mod rule;
mod spawn;

pub use rule::{Figure, InhabitantRule, Places};
pub(super) use spawn::spawn;

use super::{LevelSystems, LoadedScene};
use plan::Plan;

/// The time that inhabitants live by.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelTime {
    /// Seconds since the beginning; kept in double precision, so that steps stay even for days.
    pub seconds: f64,
    /// Goes with [`Time`].
    pub runs: bool,
}

/// A figure: the root of its joints and meshes.
#[derive(Component)]
pub struct Inhabitant {
    plan: Plan,
    /// `None` where a box stands in for the figure.
    gaits: Option<Gaits>,
}

/// How a figure moves its limbs.
#[derive(Clone, Copy)]
struct Gaits {
    walk: Gait,
    rest: Gait,
    /// Metres of one loop of `walk`, at the figure's own size.
    metres: f32,
}

/// A clip of a figure's graph.
#[derive(Clone, Copy)]
struct Gait {
    node: AnimationNodeIndex,
    seconds: f32,
}

pub(super) fn plugin(app: &mut App) {
    app.init_resource::<LevelTime>().add_systems(
        Update,
        (pass_time, stir)
            .chain()
            .after(LevelSystems)
            .run_if(resource_exists::<LoadedScene>),
    );
}

fn pass_time(time: Res<Time>, mut level_time: ResMut<LevelTime>) {
    if level_time.runs {
        level_time.seconds += time.delta_secs_f64();
    }
}

/// Puts all figures where they are now, in the pose that they have now.
fn stir(
    time: Res<LevelTime>,
    scene: Res<LoadedScene>,
    mut figures: Query<(&Inhabitant, &mut Transform, Option<&mut AnimationPlayer>)>,
) {
    for (inhabitant, mut transform, player) in &mut figures {
        let plan = &inhabitant.plan;
        let moment = plan.pace.at(time.seconds);
        let at = plan.route.at(moment.metres);
        let backward = matches!(plan.pace, route::Pace::Steady { speed, .. } if speed < 0.0);
        let ahead = plan.route.direction(moment.metres) * if backward { -1.0 } else { 1.0 };
        let placed = Transform {
            translation: Vec3::new(at.x, scene.ground.height(at.x, at.y), at.y),
            rotation: Quat::from_rotation_y(ahead.x.atan2(ahead.y)),
            scale: Vec3::splat(plan.scale),
        };
        transform.set_if_neq(placed);
        let (Some(gaits), Some(mut player)) = (inhabitant.gaits, player) else {
            continue;
        };
        let loops = moment.metres.abs() / gaits.metres;
        let walked = loops.fract() * gaits.walk.seconds;
        let rested = moment.rested % gaits.rest.seconds;
        for (gait, seek, weight) in [
            (gaits.walk, walked, moment.walk),
            (gaits.rest, rested, 1.0 - moment.walk),
        ] {
            if let Some(active) = player.animation_mut(gait.node) {
                active.set_seek_time(seek).set_weight(weight);
            }
        }
    }
}
