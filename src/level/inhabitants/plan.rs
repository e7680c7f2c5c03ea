//! Who goes where: from rules, ground and seed, the same on every machine.

use bevy_math::Vec2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    route::{Pace, Route},
    rule::{Figure, InhabitantRule, Places},
};
use crate::level::{
    ground::{Ground, Step},
    model::{AssetRef, Tint},
};

/// Metres per second of people in a street.
const STROLL: f32 = 1.3;
/// Metres per second of deer between two tufts.
const AMBLE: f32 = 0.95;
/// Seconds of a stop: a whole number of loops of the clip `graze`.
const REST: f32 = 28.0;
/// Distances of walkers' lanes from the kerb, in metres: one way, and the other.
const LANES: [(f32, f32); 2] = [(1.75, 1.0), (2.6, -1.0)];
/// Room that a figure needs on both sides of its way, in metres.
const ELBOWS: f32 = 0.4;
/// Radius of the way round a block's corner in metres.
const CORNER: f32 = 1.2;
/// Ways that are tried for one deer.
const TRIES: usize = 200;
/// Distance between the ways of two deer in metres: each is 2 m long and turns about its middle.
const BODY: f32 = 2.2;

/// Colours of coats and jackets.
const CLOTHES: [[u8; 3]; 8] = [
    [170, 62, 52],
    [58, 82, 120],
    [84, 104, 72],
    [196, 176, 134],
    [70, 68, 74],
    [128, 54, 82],
    [206, 150, 62],
    [176, 182, 188],
];

/// One figure's life.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Who.
    pub figure: Figure,
    /// Which model.
    pub asset: AssetRef,
    /// Colour of clothes.
    pub tint: Tint,
    /// Against the model's size.
    pub scale: f32,
    /// Where it goes.
    pub route: Route,
    /// How it goes.
    pub pace: Pace,
}

/// Plans for all rules of a level.
pub fn plans(rules: &[InhabitantRule], ground: &Ground, seed: u64) -> Vec<Plan> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x1a4a_b17e);
    let mut plans: Vec<Plan> = Vec::new();
    for rule in rules {
        match rule.places {
            Places::Pavements { within } => pavements(&mut rng, rule, ground, within, &mut plans),
            Places::Area { center, radius } => area(&mut rng, rule, ground, (center, radius), &mut plans),
        }
    }
    plans
}

/// Evenly round the blocks near the middle, on both lanes: who shares a lane goes at the same speed.
fn pavements(rng: &mut ChaCha8Rng, rule: &InhabitantRule, ground: &Ground, within: f32, plans: &mut Vec<Plan>) {
    let mut blocks: Vec<&Step> = ground.steps().iter().collect();
    let distance = |block: &Step| ((block.min + block.max) * 0.5).length();
    blocks.retain(|block| distance(block) < within);
    blocks.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    let lanes = blocks.iter().flat_map(|block| {
        LANES.into_iter().filter_map(|(inset, way)| {
            let route = Route::around(block.min + inset, block.max - inset, CORNER)?;
            is_free(&route, ground).then_some((route, way))
        })
    });
    let lanes: Vec<(Route, f32)> = lanes.collect();
    if lanes.is_empty() {
        return;
    }
    let count = rule.count as usize;
    for (lane, (route, way)) in lanes.iter().enumerate() {
        let here = count / lanes.len() + usize::from(lane < count % lanes.len());
        let speed = STROLL * way * rng.random_range(0.88..1.12);
        let first = rng.random_range(0.0..route.length());
        for place in 0..here {
            let spacing = route.length() / here as f32;
            let start = first + spacing * (place as f32 + rng.random_range(-0.3..0.3));
            let pace = Pace::Steady { speed, start };
            plans.push(figure(rng, rule.figure, route.clone(), pace));
        }
    }
}

/// Each on its own round of a few metres, apart from the others.
fn area(
    rng: &mut ChaCha8Rng,
    rule: &InhabitantRule,
    ground: &Ground,
    (center, radius): (Vec2, f32),
    plans: &mut Vec<Plan>,
) {
    for _ in 0..rule.count {
        for _ in 0..TRIES {
            let round = rng.random_range(0.2..0.33) * radius;
            let middle = center
                + Vec2::from_angle(rng.random_range(0.0..std::f32::consts::TAU))
                    * (radius - 1.3 * round)
                    * rng.random_range(0.0_f32..1.0).sqrt();
            let skew = rng.random_range(0.0..std::f32::consts::TAU);
            let points = (0..48).map(|i| {
                let angle = i as f32 / 48.0 * std::f32::consts::TAU;
                middle + Vec2::from_angle(angle) * round * (1.0 + 0.25 * (2.0 * angle + skew).sin())
            });
            let Some(route) = Route::new(points.collect()) else {
                continue;
            };
            let apart = |other: &Plan| other.route.gap(&route) > BODY;
            if !is_free(&route, ground) || !plans.iter().all(apart) {
                continue;
            }
            let leg = route.length() / 3.0;
            let pace = Pace::Browsing {
                speed: AMBLE,
                leg,
                rest: REST,
                head_start: rng.random_range(0.0..100.0),
            };
            plans.push(figure(rng, rule.figure, route, pace));
            break;
        }
    }
}

fn figure(rng: &mut ChaCha8Rng, figure: Figure, route: Route, pace: Pace) -> Plan {
    let (variant, tint, scale) = match figure {
        Figure::Stag => (0, Tint::WHITE, rng.random_range(0.96..1.04)),
        Figure::Hind => (1, Tint::WHITE, rng.random_range(0.84..0.92)),
        Figure::Walker => (
            rng.random_range(0..3),
            Tint(CLOTHES[rng.random_range(0..CLOTHES.len())]),
            rng.random_range(0.94..1.06),
        ),
    };
    Plan {
        figure,
        asset: AssetRef {
            file: figure.file(),
            variant,
        },
        tint,
        scale,
        route,
        pace,
    }
}

/// Is nothing in the way?
fn is_free(route: &Route, ground: &Ground) -> bool {
    let steps = (route.length() / 0.5).ceil() as usize;
    (0..steps).all(|step| ground.blockers_near(route.at(step as f32 * 0.5), ELBOWS).is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::ground::{Blocker, BlockerShape, Surface};

    fn rule(figure: Figure, count: u32, places: Places) -> InhabitantRule {
        InhabitantRule { figure, count, places }
    }

    fn block(x: f32) -> Step {
        Step {
            min: Vec2::new(x, 0.0),
            max: Vec2::new(x + 40.0, 50.0),
            top: 0.15,
        }
    }

    fn pole(x: f32, z: f32) -> Blocker {
        Blocker {
            center: Vec2::new(x, z),
            shape: BlockerShape::Cylinder { radius: 0.1 },
            bottom: 0.0,
            top: 3.0,
        }
    }

    #[test]
    fn walkers_share_the_lanes_of_near_blocks_evenly() {
        let ground = Ground::new(Surface::Flat(0.0), vec![block(0.0), block(400.0)], Vec::new());
        let rules = [rule(Figure::Walker, 10, Places::Pavements { within: 100.0 })];
        let plans = plans(&rules, &ground, 1);
        assert_eq!(plans.len(), 10);
        let speeds: Vec<f32> = plans
            .iter()
            .map(|plan| match plan.pace {
                Pace::Steady { speed, .. } => speed,
                Pace::Browsing { .. } => 0.0,
            })
            .collect();
        assert!(
            speeds[..5].iter().all(|speed| *speed == speeds[0] && *speed > 1.0),
            "{speeds:?}"
        );
        assert!(
            speeds[5..].iter().all(|speed| *speed == speeds[5] && *speed < -1.0),
            "{speeds:?}"
        );
        for (i, plan) in plans.iter().enumerate() {
            assert!((0.9..1.1).contains(&plan.scale));
            for other in plans[..i].iter().filter(|other| other.route == plan.route) {
                for t in [0.0, 1000.0] {
                    let at = |plan: &Plan| plan.route.at(plan.pace.at(t).metres);
                    assert!(at(plan).distance(at(other)) > 1.5, "nobody walks into another");
                }
            }
        }
        assert_eq!(plans, super::plans(&rules, &ground, 1), "the same for the same seed");
        assert_ne!(plans, super::plans(&rules, &ground, 2));
    }

    #[test]
    fn a_lane_with_something_in_the_way_is_left_out() {
        let ground = Ground::new(Surface::Flat(0.0), vec![block(0.0)], vec![pole(20.0, 1.9)]);
        let rules = [rule(Figure::Walker, 4, Places::Pavements { within: 100.0 })];
        let plans = plans(&rules, &ground, 1);
        assert_eq!(plans.len(), 4);
        assert!(
            plans.iter().all(|plan| plan.route == plans[0].route),
            "all on the other lane"
        );
        let none = plans_without_blocks();
        assert!(none.is_empty(), "no pavement, no walkers");
    }

    fn plans_without_blocks() -> Vec<Plan> {
        plans(
            &[rule(Figure::Walker, 4, Places::Pavements { within: 100.0 })],
            &Ground::flat(0.0),
            1,
        )
    }

    #[test]
    fn deer_stay_in_their_area_and_apart() {
        let center = Vec2::new(30.0, -5.0);
        let places = Places::Area { center, radius: 12.0 };
        let rules = [rule(Figure::Stag, 1, places), rule(Figure::Hind, 3, places)];
        let ground = Ground::new(Surface::Flat(0.0), Vec::new(), vec![pole(30.0, -5.0)]);
        let plans = plans(&rules, &ground, 3);
        assert_eq!(plans.len(), 4);
        let variants: Vec<u32> = plans.iter().map(|plan| plan.asset.variant).collect();
        assert_eq!(variants, [0, 1, 1, 1]);
        for (i, plan) in plans.iter().enumerate() {
            for t in 0..400 {
                let at = |plan: &Plan| plan.route.at(plan.pace.at(f64::from(t)).metres);
                assert!(at(plan).distance(center) <= 12.0, "{}", at(plan));
                assert!(at(plan).distance(center) > 0.4, "the pole is in the way");
                assert!(plans[..i].iter().all(|other| at(other).distance(at(plan)) > 2.0));
            }
        }
    }
}
