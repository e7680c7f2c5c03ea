//! What a walker can reach within one step: heights and obstacles, and how a body slides along them.

use bevy::math::{Vec2, Vec3, Vec3Swizzles};

use super::{BODY_HEIGHT, EDGE, MIN_NORMAL_Y, RADIUS, STEP_HEIGHT, TOUCH, WORLD_LIMIT};
use crate::level::ground::{Blocker, Ground};

/// Heights and the obstacles within reach of one step.
pub(super) struct Surroundings<'a> {
    ground: &'a Ground,
    blockers: Vec<Blocker>,
    /// Largest absolute x and z.
    limit: Vec2,
}

impl<'a> Surroundings<'a> {
    pub(super) fn of(ground: &'a Ground, at: Vec2, reach: f32) -> Self {
        let limit = ground
            .extent()
            .map_or(Vec2::splat(WORLD_LIMIT), |extent| 0.5 * extent - EDGE);
        Self {
            ground,
            limit: limit.max(Vec2::ZERO),
            blockers: ground.blockers_near(at, reach + RADIUS),
        }
    }

    /// Height of the terrain, or `otherwise` where it has none.
    fn terrain(&self, at: Vec2, otherwise: f32) -> f32 {
        let height = self.ground.height(at.x, at.y);
        if height.is_finite() { height } else { otherwise }
    }

    /// Height of what carries a body at `feet`: the terrain, or the top of an obstacle that is low enough to step on.
    pub(super) fn support(&self, feet: Vec3) -> f32 {
        let tops = self
            .blockers
            .iter()
            .filter(|blocker| blocker.top <= feet.y + STEP_HEIGHT && blocker.outwards(feet.xz()).0 < RADIUS)
            .map(|blocker| blocker.top);
        tops.fold(self.terrain(feet.xz(), feet.y), f32::max)
    }

    /// The obstacle that a body at `feet` reaches deepest into: how deep, and the way out.
    fn deepest(&self, feet: Vec3) -> Option<(f32, Vec2)> {
        self.blockers
            .iter()
            .filter(|blocker| blocker.top > feet.y + STEP_HEIGHT && blocker.bottom < feet.y + BODY_HEIGHT)
            .map(|blocker| {
                let (distance, way_out) = blocker.outwards(feet.xz());
                (RADIUS - distance, way_out)
            })
            .filter(|(depth, _)| *depth > 0.0)
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }

    pub(super) fn depth(&self, feet: Vec3) -> f32 {
        self.deepest(feet).map_or(0.0, |(depth, _)| depth)
    }

    /// One piece of a path: along the contour where the slope is too steep, along the sides of obstacles, within the
    /// ground's extent; or not at all. The feet come out on top of what carries them, never below.
    pub(super) fn slide(&self, feet: Vec3, piece: Vec2) -> Vec3 {
        let Some(mut at) = self.climb(feet, piece) else {
            return feet;
        };
        for _ in 0..4 {
            let Some((depth, way_out)) = self.deepest(self.lifted(feet, at)) else {
                break;
            };
            at += way_out * (depth + 0.1 * TOUCH);
        }
        at = at.clamp(-self.limit, self.limit);
        let moved = self.lifted(feet, at);
        let climbed = self.is_climbable(feet, at) && moved.is_finite();
        if climbed && self.depth(moved) <= self.depth(feet).max(TOUCH) {
            moved
        } else {
            feet
        }
    }

    /// A body that goes from `feet` to `at`, raised onto what carries it there.
    fn lifted(&self, feet: Vec3, at: Vec2) -> Vec3 {
        let moved = Vec3::new(at.x, feet.y, at.y);
        moved.with_y(feet.y.max(self.support(moved)))
    }

    /// Where `piece` leads on slopes: straight, or along the contour.
    fn climb(&self, feet: Vec3, piece: Vec2) -> Option<Vec2> {
        let straight = feet.xz() + piece;
        if self.is_climbable(feet, straight) {
            return Some(straight);
        }
        let downhill = self.ground.normal(straight.x, straight.y).xz().try_normalize()?;
        let along = feet.xz() + piece - downhill * piece.dot(downhill).min(0.0);
        self.is_climbable(feet, along).then_some(along)
    }

    fn is_climbable(&self, feet: Vec3, to: Vec2) -> bool {
        let rise = self.terrain(to, feet.y) - self.terrain(feet.xz(), feet.y).max(feet.y);
        rise <= TOUCH || (rise <= STEP_HEIGHT && self.ground.normal(to.x, to.y).y >= MIN_NORMAL_Y)
    }
}
