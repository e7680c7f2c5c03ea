//! Wind in a grove: near trees lean and come back.
//!
//! A tree leans about its foot as a whole, so that its shadow and its levels of detail lean with it and no material has to
//! know. Gusts run over the grove with the wind; each tree swings in its own time besides. Leaning ends where trees enter
//! their last level, which is that of blocks and stands still.

use bevy::prelude::*;

use crate::{
    level::{model::Placement, simple_trees::LEVEL_ENDS},
    lod::eyes::LodEyes,
    maths::lod::selection::LodMetric,
};

/// Lean in radians per metre per second.
const LEAN: f32 = 0.004;
/// Distance of gusts in metres.
const GUSTS: f32 = 45.0;
/// A tree's own swings, radians per second.
const SWING: f32 = 2.1;
/// From this share of the distance at which it ends, leaning grows less.
const CALM_FROM: f32 = 0.6;

/// On a part of a tree in the wind.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Swaying {
    foot: Vec3,
    upright: Quat,
    /// Metres per second.
    speed: f32,
}

impl Swaying {
    /// Of a tree in wind of so many metres per second.
    #[must_use]
    pub fn new(tree: &Placement, speed: f32) -> Self {
        Self {
            foot: tree.position,
            upright: tree.rotation,
            speed,
        }
    }
}

/// How a tree at a place leans in wind of so many metres per second at a time in seconds, seen from a distance in metres.
#[must_use]
pub fn lean(speed: f32, foot: Vec3, seconds: f64, distance: f32) -> Quat {
    let away = distance / LEVEL_ENDS[1];
    let calm = ((away - CALM_FROM) / (1.0 - CALM_FROM)).clamp(0.0, 1.0);
    // Whole turns would be lost in the precision of long times.
    let turns = |per_second: f32, offset: f32| {
        let turns = seconds * f64::from(per_second) + f64::from(offset);
        (turns.fract() as f32 * std::f32::consts::TAU).sin()
    };
    let gust = turns(speed / GUSTS, -foot.x / GUSTS + foot.z / (7.0 * GUSTS));
    let swing = turns(SWING / std::f32::consts::TAU, foot.x * 0.37 + foot.z * 0.71);
    let angle = LEAN * speed * (1.0 - calm) * (0.55 + 0.3 * gust + 0.15 * swing);
    // About z by a negative angle: towards +x.
    Quat::from_rotation_z(-angle)
}

/// Bends near trees.
pub(super) fn plugin(app: &mut App) {
    app.add_systems(Update, sway.run_if(resource_exists::<LodEyes>));
}

fn sway(time: Res<Time>, eyes: Res<LodEyes>, mut parts: Query<(&Swaying, &mut Transform)>) {
    let seconds = time.elapsed_secs_f64();
    for (swaying, mut transform) in &mut parts {
        let distance = eyes.distance(swaying.foot, LodMetric::Distance) as f32;
        let rotation = lean(swaying.speed, swaying.foot, seconds, distance) * swaying.upright;
        if transform.rotation != rotation {
            transform.rotation = rotation;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn top(seconds: f64, distance: f32) -> Vec3 {
        lean(10.0, Vec3::new(30.0, 0.0, -12.0), seconds, distance) * (Vec3::Y * 10.0)
    }

    #[test]
    fn trees_lean_with_the_wind_and_never_much() {
        let tops: Vec<f32> = (0..400).map(|step| top(f64::from(step) * 0.05, 5.0).x).collect();
        let (low, high) = tops
            .iter()
            .fold((f32::MAX, f32::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
        assert!(
            low >= 0.0 && (0.2..0.5).contains(&high) && high - low > 0.2,
            "{low}..{high}"
        );
        let step = tops
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .fold(0.0, f32::max);
        assert!(step < 0.03, "{step} m in 50 ms");
    }

    #[test]
    fn leaning_ends_where_blocks_begin() {
        for seconds in [0.0, 1.7, 1e6] {
            assert_eq!(top(seconds, LEVEL_ENDS[1]), Vec3::Y * 10.0);
            assert!(top(seconds, 58.0).x < 0.06, "hardly any");
        }
        assert_eq!(lean(0.0, Vec3::ONE, 3.0, 1.0), Quat::IDENTITY);
    }
}
