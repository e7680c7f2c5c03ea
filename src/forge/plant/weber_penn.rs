//! Trees by parameters: Weber and Penn 1995, *Creation and Rendering of Realistic Trees* (section 4; names as in their
//! appendix).
//!
//! Left out: lobes of the trunk (4.4), tapers above 1 (4.4), pruning (4.6) and wind (4.7). Angles are in degrees in the
//! parameters, as in the paper, and turns are about the stem's own axes.

use bevy_math::Vec3;

use super::skeleton::{Frame, Joint, Skeleton, Stem};
use crate::forge::portable::{Dice, TURN, any_normal, declination, power, sin, turn};

/// Outline of the crown (the paper's `Shape`): share of the greatest branch length, by height.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// 0: a cone.
    Conical,
    /// 1: a ball.
    Spherical,
    /// 2: half a ball.
    Hemispherical,
    /// 4: a cone without its tip.
    TaperedCylindrical,
    /// 5: a flame.
    Flame,
    /// 7: nearly a flame.
    TendFlame,
}

impl Shape {
    /// `ShapeRatio`: 0.2..=1 for a place in the crown, 0 at its top to 1 at its base.
    pub fn ratio(self, place: f32) -> f32 {
        let place = place.clamp(0.0, 1.0);
        match self {
            Self::Conical => 0.2 + 0.8 * place,
            Self::Spherical => 0.2 + 0.8 * sin(0.5 * TURN * place),
            Self::Hemispherical => 0.2 + 0.8 * sin(0.25 * TURN * place),
            Self::TaperedCylindrical => 0.5 + 0.5 * place,
            Self::Flame if place <= 0.7 => place / 0.7,
            Self::Flame => (1.0 - place) / 0.3,
            Self::TendFlame if place <= 0.7 => 0.5 + 0.5 * place / 0.7,
            Self::TendFlame => 0.5 + 0.5 * (1.0 - place) / 0.3,
        }
    }
}

/// Parameters of one level of stems. Pairs are value and variation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// `nDownAngle`: from the parent's axis; a negative variation widens it towards the crown's base.
    pub down_angle: (f32, f32),
    /// `nRotate`: from one child to the next about the parent.
    pub rotate: (f32, f32),
    /// `nBranches`: children of a parent of full length; for level 0, trunks.
    pub branches: f32,
    /// `nLength`: share of the parent's length.
    pub length: (f32, f32),
    /// `nTaper`, 0..=1: how much thinner the tip is than the base.
    pub taper: f32,
    /// `nCurveRes`: segments.
    pub segments: u32,
    /// `nCurve`, `nCurveV`: bend over the stem's length.
    pub curve: (f32, f32),
    /// `nCurveBack`: bend of the upper half, where it differs.
    pub curve_back: f32,
    /// `nSegSplits`: forks per segment.
    pub splits: f32,
    /// `nSplitAngle`.
    pub split_angle: (f32, f32),
}

impl Level {
    /// A straight stem with three segments and no children of its own.
    pub const PLAIN: Self = Self {
        down_angle: (45.0, 10.0),
        rotate: (140.0, 20.0),
        branches: 1.0,
        length: (1.0, 0.0),
        taper: 1.0,
        segments: 3,
        curve: (0.0, 0.0),
        curve_back: 0.0,
        splits: 0.0,
        split_angle: (0.0, 0.0),
    };
}

/// Parameters of a species.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Species {
    /// Outline of the crown.
    pub shape: Shape,
    /// `BaseSize`: share of the trunk without branches.
    pub base_size: f32,
    /// `Scale`, `ScaleV`: height in metres.
    pub scale: (f32, f32),
    /// `Ratio`: radius over length of the trunk.
    pub ratio: f32,
    /// `RatioPower`: how fast children are thinner than parents.
    pub ratio_power: f32,
    /// `Flare`: how much wider the trunk is at the ground.
    pub flare: f32,
    /// `AttractionUp`: of level 2 and above; negative: hanging.
    pub attraction_up: f32,
    /// Children stand in whorls of this many at one height, 0: one by one (not in the paper; for conifers).
    pub whorl: u32,
    /// Trunk, boughs, branches: at most four.
    pub levels: &'static [Level],
}

/// A stem while it grows.
#[derive(Clone, Copy)]
struct Plan {
    level: usize,
    length: f32,
    radius: f32,
    /// Length of the parent, and how far along it the stem begins.
    parent_length: f32,
    offset: f32,
    /// Segments that are left to grow, for forks.
    first_segment: u32,
}

/// Grows the stems of a tree that stands at the origin. The leaves' seats are left empty.
pub fn grow(species: &Species, seed: u64) -> Skeleton {
    let mut grower = Grower {
        species,
        dice: Dice::new(seed),
        skeleton: Skeleton::default(),
        split_errors: [0.0; 4],
    };
    let Some(trunk) = species.levels.first() else {
        return grower.skeleton;
    };
    let scale = grower.dice.about(species.scale.0, species.scale.1);
    let length = scale * grower.dice.about(trunk.length.0, trunk.length.1);
    let heading = grower.dice.unit() * TURN;
    let frame = Frame {
        at: Vec3::ZERO,
        forward: Vec3::Y,
        side: turn(Vec3::X, Vec3::Y, heading),
    };
    let plan = Plan {
        level: 0,
        length,
        radius: length * species.ratio,
        parent_length: length,
        offset: 0.0,
        first_segment: 0,
    };
    grower.stem(frame, plan);
    grower.skeleton
}

struct Grower<'a> {
    species: &'a Species,
    dice: Dice,
    skeleton: Skeleton,
    /// Rounding errors of forks are carried on within a level (4.2).
    split_errors: [f32; 4],
}

impl Grower<'_> {
    /// Grows a stem segment by segment (4.1, 4.2), then its children (4.3).
    fn stem(&mut self, mut frame: Frame, plan: Plan) {
        let level = self.species.levels[plan.level];
        let segments = level.segments.max(1);
        let step = plan.length / segments as f32;
        let first = plan.first_segment;
        let mut frames = vec![frame];
        let mut joints = vec![self.joint(&frame, &plan, first, segments)];
        for segment in first..segments {
            self.bend(&mut frame, &level, plan.level, segment, segments);
            frame.at += frame.forward * step;
            joints.push(self.joint(&frame, &plan, segment + 1, segments));
            frames.push(frame);
            if segment + 1 < segments && segment >= 1 {
                self.forks(&mut frame, &plan, segment + 1);
            }
        }
        self.skeleton.stems.push(Stem {
            level: plan.level,
            joints,
        });
        if plan.level + 1 < self.species.levels.len().min(4) {
            self.children(&frames, &plan, segments);
        }
    }

    /// Radius by taper and flare (4.4).
    fn joint(&self, frame: &Frame, plan: &Plan, segment: u32, segments: u32) -> Joint {
        let level = &self.species.levels[plan.level];
        let share = segment as f32 / segments as f32;
        let mut radius = plan.radius * (1.0 - level.taper.clamp(0.0, 1.0) * 0.97 * share);
        if plan.level == 0 {
            radius *= 1.0 + self.species.flare * (power(100.0, (1.0 - 8.0 * share).max(0.0)) - 1.0) / 100.0;
        }
        Joint { at: frame.at, radius }
    }

    fn bend(&mut self, frame: &mut Frame, level: &Level, number: usize, segment: u32, segments: u32) {
        let count = segments as f32;
        let degrees = if level.curve_back == 0.0 {
            level.curve.0 / count
        } else if segment * 2 < segments {
            level.curve.0 / (count * 0.5)
        } else {
            level.curve_back / (count * 0.5)
        };
        let wander = self.dice.signed() * level.curve.1 / count;
        frame.forward = turn(frame.forward, frame.side, (degrees + wander).to_radians());
        // Sideways too: stems wander in space, not in a plane.
        let over = frame.over();
        let sideways = (self.dice.signed() * level.curve.1 * 0.6 / count).to_radians();
        frame.forward = turn(frame.forward, over, sideways).normalize();
        frame.side = (frame.side - frame.forward * frame.side.dot(frame.forward)).normalize();
        if number >= 2 && self.species.attraction_up != 0.0 {
            // 4.8: turns towards the zenith, the more the further the stem is from it.
            let down = declination(frame.forward);
            let axis = frame.forward.cross(Vec3::Y);
            if axis.length_squared() > 1e-6 {
                let lift = (self.species.attraction_up * down / count).clamp(-0.9, 0.9);
                frame.forward = turn(frame.forward, axis.normalize(), lift).normalize();
                frame.side = (frame.side - frame.forward * frame.side.dot(frame.forward)).normalize();
            }
        }
    }

    /// 4.2: at a joint the stem may go on as two or more.
    fn forks(&mut self, frame: &mut Frame, plan: &Plan, segment: u32) {
        let level = self.species.levels[plan.level];
        if level.splits <= 0.0 {
            return;
        }
        let wanted = level.splits + self.split_errors[plan.level];
        let clones = wanted.round().max(0.0);
        self.split_errors[plan.level] = wanted - clones;
        let mut clone = 0.0;
        while clone < clones {
            let angle = self.dice.about(level.split_angle.0, level.split_angle.1).to_radians();
            let mut other = *frame;
            let around = self.dice.unit() * TURN;
            let axis = turn(frame.side, frame.forward, around);
            other.forward = turn(frame.forward, axis, angle).normalize();
            other.side = any_normal(other.forward);
            frame.forward = turn(frame.forward, axis, -angle * 0.5).normalize();
            frame.side = any_normal(frame.forward);
            let length = plan.length * self.dice.between(0.85, 1.0);
            self.stem(
                other,
                Plan {
                    first_segment: segment,
                    radius: plan.radius * 0.85,
                    length,
                    ..*plan
                },
            );
            clone += 1.0;
        }
    }

    /// 4.3: children along the stem.
    fn children(&mut self, frames: &[Frame], plan: &Plan, segments: u32) {
        let species = self.species;
        let level = species.levels[plan.level + 1];
        let grown = (segments - plan.first_segment) as f32 / segments as f32;
        let bare = if plan.level == 0 { species.base_size } else { 0.08 };
        let full = match plan.level {
            0 => level.branches,
            1 => {
                let longest = species.levels[1].length.0.max(1e-3);
                level.branches * (0.2 + 0.8 * (plan.length / plan.parent_length.max(1e-3)) / longest)
            }
            _ => level.branches * (1.0 - 0.5 * plan.offset / plan.parent_length.max(1e-3)),
        };
        let count = (full * grown).round().max(0.0);
        let mut around = self.dice.unit() * TURN;
        let whorl = if plan.level == 0 { species.whorl } else { 0 };
        let mut child = 0.0;
        while child < count {
            let mut place = (child + 0.5) / count;
            if whorl > 0 {
                let rows = (count / whorl as f32).max(1.0);
                place = ((child / whorl as f32).floor() + 0.5) / rows + self.dice.signed() * 0.12 / rows;
            }
            let share = bare + (1.0 - bare) * place.clamp(0.0, 1.0);
            if share < plan.first_segment as f32 / segments as f32 {
                child += 1.0;
                continue;
            }
            let variation = self.dice.signed() * level.rotate.1;
            around += (level.rotate.0 + variation).to_radians();
            self.child(frames, plan, segments, share, around, &level);
            child += 1.0;
        }
    }

    fn child(&mut self, frames: &[Frame], plan: &Plan, segments: u32, share: f32, around: f32, level: &Level) {
        let species = self.species;
        let offset = share * plan.length;
        let place = share * segments as f32 - plan.first_segment as f32;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..=segments")]
        let first = (place.max(0.0) as usize).min(frames.len() - 2);
        let (a, b) = (frames[first], frames[first + 1]);
        let at = a.at.lerp(b.at, (place - first as f32).clamp(0.0, 1.0));
        let bare_length = if plan.level == 0 {
            species.base_size * plan.length
        } else {
            0.0
        };
        let in_crown = (plan.length - offset) / (plan.length - bare_length).max(1e-3);
        let longest = self.dice.about(level.length.0, level.length.1);
        let length = if plan.level == 0 {
            plan.length * longest * species.shape.ratio(in_crown)
        } else {
            longest * (plan.length - 0.6 * offset)
        };
        let down = if level.down_angle.1 < 0.0 {
            let widening = 1.0 - 2.0 * Shape::Conical.ratio(in_crown);
            level.down_angle.0 + level.down_angle.1 * widening + 4.0 * self.dice.signed()
        } else {
            self.dice.about(level.down_angle.0, level.down_angle.1)
        };
        let taper = 1.0 - species.levels[plan.level].taper * 0.97 * share;
        let parent_radius = plan.radius * taper;
        let radius = (plan.radius * power(length / plan.length, species.ratio_power)).min(parent_radius * 0.9);
        if length < 0.05 || radius <= 0.0 {
            return;
        }
        let axis = turn(b.side, b.forward, around);
        let forward = turn(b.forward, axis, down.to_radians()).normalize();
        // Bends of children go towards and away from their parent.
        let frame = Frame {
            at,
            forward,
            side: (axis - forward * axis.dot(forward)).normalize_or(any_normal(forward)),
        };
        self.stem(
            frame,
            Plan {
                level: plan.level + 1,
                length,
                radius,
                parent_length: plan.length,
                offset,
                first_segment: 0,
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const POLE: Species = Species {
        shape: Shape::Conical,
        base_size: 0.25,
        scale: (8.0, 0.0),
        ratio: 0.02,
        ratio_power: 1.0,
        flare: 0.0,
        attraction_up: 0.0,
        whorl: 0,
        levels: &[
            Level {
                segments: 4,
                ..Level::PLAIN
            },
            Level {
                branches: 12.0,
                down_angle: (90.0, 0.0),
                length: (0.5, 0.0),
                ..Level::PLAIN
            },
        ],
    };

    #[test]
    fn a_pole_with_level_branches_is_as_long_as_its_parameters_say() {
        let skeleton = grow(&POLE, 1);
        assert_eq!(skeleton.stems.len(), 13);
        let trunk = &skeleton.stems[0];
        assert!((trunk.length() - 8.0).abs() < 1e-4 && (trunk.base_radius() - 0.16).abs() < 1e-6);
        for branch in &skeleton.stems[1..] {
            let foot = branch.joints[0].at.y;
            // Conical: half the trunk's length times 0.2 + 0.8 × the share of the crown that is above.
            let wanted = 8.0 * 0.5 * (0.2 + 0.8 * (8.0 - foot) / 6.0);
            assert!((branch.length() - wanted).abs() < 1e-3, "{} at {foot}", branch.length());
            let rise = (branch.joints[1].at - branch.joints[0].at).normalize().y;
            assert!(rise.abs() < 1e-3, "level");
            assert!(foot > 2.0, "the lowest quarter is bare");
        }
    }

    #[test]
    fn shapes_have_the_ratios_of_the_paper() {
        assert!((Shape::Spherical.ratio(0.5) - 1.0).abs() < 1e-6);
        assert!((Shape::Hemispherical.ratio(1.0 / 3.0) - 0.6).abs() < 1e-6);
        assert!((Shape::Flame.ratio(0.35) - 0.5).abs() < 1e-6);
        assert!((Shape::TendFlame.ratio(0.85) - 0.75).abs() < 1e-6);
        assert!((Shape::TaperedCylindrical.ratio(1.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn forks_come_as_often_as_asked_for() {
        let levels = [Level {
            segments: 9,
            splits: 0.25,
            split_angle: (20.0, 0.0),
            ..Level::PLAIN
        }];
        let species = Species {
            levels: Box::leak(Box::new(levels)),
            ..POLE
        };
        let forked = grow(&species, 3).stems.len();
        assert!(forked >= 3, "{forked} stems");
        assert_eq!(grow(&POLE, 3), grow(&POLE, 3), "the same seed, the same tree");
        assert_ne!(grow(&species, 3), grow(&species, 4));
    }
}
