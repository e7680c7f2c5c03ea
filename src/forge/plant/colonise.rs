//! Broad trees by competition for space: Runions, Lane and Prusinkiewicz 2007, *Modeling Trees with a Space Colonization
//! Algorithm*.
//!
//! Attraction points fill the crown's volume. In each step every point pulls at the nearest node within its reach; nodes
//! that are pulled grow by one step in the mean direction; points that a branch has come near to are removed. Radii follow
//! the pipe model (section 3, `r^n = Σ r_child^n`).

use bevy_math::Vec3;

use super::skeleton::{Joint, Skeleton, Stem};
use crate::forge::portable::{Dice, power};

/// Parameters; lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colony {
    /// Where the crown begins.
    pub crown_base: f32,
    /// Height of the tree.
    pub height: f32,
    /// Half the crown's width.
    pub crown_radius: f32,
    /// Share of the crown's height at which it is widest.
    pub widest: f32,
    /// Attraction points N.
    pub points: u32,
    /// Radius of influence `d_i`.
    pub reach: f32,
    /// Kill distance `d_k`.
    pub kill: f32,
    /// Length of a step D.
    pub step: f32,
    /// Exponent n of the pipe model, 2..=3.
    pub pipe: f32,
    /// Radius of the finest branches.
    pub twig_radius: f32,
    /// Tropism: added to each step's direction (negative: branches sag).
    pub lift: f32,
    /// How much branches wander, as a share of a step.
    pub wander: f32,
    /// How much wider the trunk is at the ground.
    pub flare: f32,
}

struct Node {
    at: Vec3,
    parent: usize,
    children: u32,
}

/// Clumps of leaves in a crown, and their radius as a share of the crown's.
const CLUMPS: u32 = 26;
const CLUMP_RADIUS: f32 = 0.33;
/// Most steps that are taken; crowns are full long before.
const MOST_STEPS: u32 = 400;

/// Grows the stems of a tree that stands at the origin. The leaves' seats are left empty.
pub fn grow(colony: &Colony, seed: u64) -> Skeleton {
    let mut dice = Dice::new(seed);
    let points = crown(colony, &mut dice);
    let nodes = colonise(colony, points, &mut dice);
    let radii = radii(colony, &nodes);
    stems(colony, &nodes, &radii)
}

/// Points inside the crown, which is a solid of revolution with lumps.
fn crown(colony: &Colony, dice: &mut Dice) -> Vec<Vec3> {
    let tall = colony.height - colony.crown_base;
    let lumps: Vec<(Vec3, f32)> = (0..9)
        .map(|_| (dice.in_ball().normalize_or(Vec3::X), dice.between(-0.22, 0.16)))
        .collect();
    // Leaves gather in clumps with gaps between them.
    let clumps: Vec<Vec3> = (0..CLUMPS)
        .map(|_| dice.in_ball().normalize_or(Vec3::Y) * dice.between(0.45, 0.9))
        .collect();
    let mut points = Vec::new();
    while points.len() < colony.points as usize {
        let p = dice.in_ball();
        let in_clump = clumps.iter().any(|clump| clump.distance(p) < CLUMP_RADIUS);
        // And in the outer shell, where the light is.
        let chance = (0.25 + 0.75 * p.length()) * if in_clump { 1.0 } else { 0.16 };
        if dice.unit() > chance {
            continue;
        }
        let direction = p.normalize_or(Vec3::Y);
        let lump: f32 = lumps
            .iter()
            .map(|(towards, size)| size * (direction.dot(*towards) * 2.0 - 1.0).max(0.0))
            .sum();
        let share = 0.5 + 0.5 * p.y;
        let y = if share < 0.5 {
            share * 2.0 * colony.widest
        } else {
            colony.widest + (share - 0.5) * 2.0 * (1.0 - colony.widest)
        };
        let around = Vec3::new(p.x, 0.0, p.z) * colony.crown_radius * (1.0 + lump);
        points.push(around + Vec3::Y * (colony.crown_base + tall * y * (1.0 + 0.5 * lump)));
    }
    points
}

fn colonise(colony: &Colony, points: Vec<Vec3>, dice: &mut Dice) -> Vec<Node> {
    let mut nodes = vec![Node {
        at: Vec3::ZERO,
        parent: 0,
        children: 0,
    }];
    // A slightly bent trunk up to the crown.
    let lean = Vec3::new(dice.signed(), 0.0, dice.signed()) * 0.12;
    while nodes[nodes.len() - 1].at.y < colony.crown_base {
        let parent = nodes.len() - 1;
        let bend = Vec3::new(dice.signed(), 0.0, dice.signed()) * 0.10;
        let at = nodes[parent].at + (Vec3::Y + lean + bend).normalize() * colony.step;
        nodes[parent].children += 1;
        nodes.push(Node {
            at,
            parent,
            children: 0,
        });
    }
    // Each point with its nearest node so far.
    let mut points: Vec<(Vec3, usize, f32)> = points.into_iter().map(|p| (p, 0, f32::MAX)).collect();
    let mut first_new = 0;
    for _ in 0..MOST_STEPS {
        for (p, nearest, distance) in &mut points {
            for (i, node) in nodes.iter().enumerate().skip(first_new) {
                let own = node.at.distance(*p);
                if own < *distance {
                    (*nearest, *distance) = (i, own);
                }
            }
        }
        points.retain(|(_, _, distance)| *distance > colony.kill);
        let mut pulls = vec![Vec3::ZERO; nodes.len()];
        for (p, nearest, distance) in &points {
            if *distance < colony.reach {
                pulls[*nearest] += (*p - nodes[*nearest].at) / *distance;
            }
        }
        first_new = nodes.len();
        for (parent, pull) in pulls.into_iter().enumerate() {
            // Pulls that cancel out would grow the same twig again and again.
            if pull.length_squared() < 1e-4 || nodes[parent].children >= 3 {
                continue;
            }
            let direction = pull.normalize() + Vec3::Y * colony.lift + dice.in_ball() * colony.wander;
            let at = nodes[parent].at + direction.normalize_or(Vec3::Y) * colony.step;
            if nodes[first_new..]
                .iter()
                .any(|node| node.at.distance_squared(at) < 1e-4)
            {
                continue;
            }
            nodes[parent].children += 1;
            nodes.push(Node {
                at,
                parent,
                children: 0,
            });
        }
        if nodes.len() == first_new {
            break;
        }
    }
    nodes
}

/// Radii by the pipe model, from the tips down.
fn radii(colony: &Colony, nodes: &[Node]) -> Vec<f32> {
    let mut pipes = vec![0.0_f32; nodes.len()];
    let twig = power(colony.twig_radius, colony.pipe);
    for i in (1..nodes.len()).rev() {
        // Branches thicken a little along themselves.
        pipes[i] = (pipes[i] * 1.01).max(twig);
        pipes[nodes[i].parent] += pipes[i];
    }
    pipes
        .into_iter()
        .map(|pipe| power(pipe.max(twig), 1.0 / colony.pipe))
        .collect()
}

/// Chains of nodes: at each fork the thickest child goes on, the others begin stems of the next level.
fn stems(colony: &Colony, nodes: &[Node], radii: &[f32]) -> Skeleton {
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
    for (i, node) in nodes.iter().enumerate().skip(1) {
        children[node.parent].push(i);
    }
    let mut skeleton = Skeleton::default();
    let mut starts = vec![(0, None, 0)];
    let mut next = 0;
    while let Some((start, parent, level)) = starts.get(next).copied() {
        next += 1;
        let mut joints: Vec<Joint> = Vec::new();
        if let Some(parent) = parent {
            let node: &Node = &nodes[parent];
            joints.push(Joint {
                at: node.at,
                radius: radii[start],
            });
        }
        let mut at = start;
        loop {
            let flare = if level == 0 {
                let share = (nodes[at].at.y / colony.height).clamp(0.0, 1.0);
                1.0 + colony.flare * (power(100.0, (1.0 - 9.0 * share).max(0.0)) - 1.0) / 100.0
            } else {
                1.0
            };
            joints.push(Joint {
                at: nodes[at].at,
                radius: radii[at] * flare,
            });
            let Some(thickest) = children[at]
                .iter()
                .copied()
                .max_by(|a, b| radii[*a].total_cmp(&radii[*b]))
            else {
                break;
            };
            starts.extend(
                children[at]
                    .iter()
                    .filter(|child| **child != thickest)
                    .map(|child| (*child, Some(at), level + 1)),
            );
            at = thickest;
        }
        if joints.len() > 1 {
            let joints = smoothed(joints);
            skeleton.stems.push(Stem { level, joints });
        }
    }
    skeleton
}

/// Joints moved half way to the middle of their neighbours, the ends kept: steps of one length zigzag.
fn smoothed(joints: Vec<Joint>) -> Vec<Joint> {
    let mut smooth = joints.clone();
    for i in 1..joints.len().saturating_sub(1) {
        let middle = (joints[i - 1].at + joints[i + 1].at) * 0.5;
        smooth[i].at = joints[i].at.lerp(middle, 0.5);
    }
    smooth
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Colony = Colony {
        crown_base: 2.0,
        height: 7.0,
        crown_radius: 3.0,
        widest: 0.5,
        points: 300,
        reach: 3.0,
        kill: 0.5,
        step: 0.25,
        pipe: 2.0,
        twig_radius: 0.01,
        lift: 0.0,
        wander: 0.1,
        flare: 0.0,
    };

    #[test]
    fn branches_come_near_to_every_point() {
        let mut dice = Dice::new(5);
        let points = crown(&SMALL, &mut dice);
        let nodes = colonise(&SMALL, points.clone(), &mut dice);
        let far = points
            .iter()
            .filter(|p| nodes.iter().all(|node| node.at.distance(**p) > SMALL.kill))
            .count();
        assert!(far * 50 < points.len(), "{far} of {} points are left", points.len());
        assert!(nodes.len() < 4000, "{} nodes", nodes.len());
    }

    #[test]
    fn the_area_of_a_trunk_is_that_of_its_twigs() {
        // A fork of two twigs over one step of trunk: with n = 2, areas add up (and grow by 1 % per step).
        let node = |parent, children| Node {
            at: Vec3::ZERO,
            parent,
            children,
        };
        let radii = radii(&SMALL, &[node(0, 1), node(0, 2), node(1, 0), node(1, 0)]);
        assert!((radii[2] - 0.01).abs() < 1e-6);
        assert!((radii[1] * radii[1] / 2.0e-4 - 1.01).abs() < 1e-3, "{radii:?}");
    }

    #[test]
    fn stems_begin_on_their_parents() {
        let skeleton = grow(&SMALL, 8);
        assert!(skeleton.stems.len() > 40);
        let joints: Vec<Vec3> = skeleton
            .stems
            .iter()
            .flat_map(|stem| &stem.joints)
            .map(|j| j.at)
            .collect();
        for stem in &skeleton.stems[1..] {
            let foot = stem.joints[0].at;
            let near = joints.iter().filter(|at| at.distance(foot) < 0.2).count();
            assert!(near > 1, "a stem floats at {foot}");
        }
    }
}
