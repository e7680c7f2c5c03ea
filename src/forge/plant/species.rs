//! The trees: parameters of five species and a dead one.
//!
//! Sizes follow forest trees of middle age. The parameters are our own, set by eye on the previews; the papers' tables
//! were the starting point for their orders of magnitude.

use bevy_math::Vec2;

use super::{
    colonise::Colony,
    tree::{Foliage, Growth, Habit, Tree},
    weber_penn::{Level, Shape, Species},
};
use crate::forge::texture::{bark::Bark, leaf::LeafShape, sprigs::Sprig};

/// Pedunculate oak: broad, with bent boughs; by competition for space.
pub const OAK: Tree = Tree {
    name: "oak",
    growth: Growth::Space(Colony {
        crown_base: 2.3,
        height: 12.5,
        crown_radius: 6.6,
        widest: 0.36,
        points: 1150,
        reach: 4.0,
        kill: 0.75,
        step: 0.34,
        pipe: 2.12,
        twig_radius: 0.0125,
        lift: 0.02,
        wander: 0.22,
        flare: 0.9,
    }),
    bark: (Bark::Oak, Vec2::new(0.9, 1.8)),
    foliage: Some(Foliage {
        sprig: Sprig::Leaves {
            shape: LeafShape::OAK,
            length: 0.165,
            count: 46,
        },
        habit: Habit::Spreading,
        thinner_than: 0.034,
        spacing: 0.19,
        length: (0.80, 0.14),
        angle: 50.0,
        round: 0.55,
        fold: 0.0,
        thickness: 0.000_25,
        transmission: 0.35,
    }),
    seeds: &[11, 12],
};

/// Silver birch: slender, with thin hanging twigs.
pub const BIRCH: Tree = Tree {
    name: "birch",
    growth: Growth::Parameters(Species {
        shape: Shape::TendFlame,
        base_size: 0.22,
        scale: (13.5, 1.2),
        ratio: 0.0115,
        ratio_power: 1.25,
        flare: 0.35,
        attraction_up: -0.35,
        whorl: 0,
        levels: &[
            Level {
                segments: 12,
                curve: (0.0, 35.0),
                taper: 1.0,
                ..Level::PLAIN
            },
            Level {
                down_angle: (46.0, -12.0),
                rotate: (140.0, 25.0),
                branches: 40.0,
                length: (0.30, 0.05),
                segments: 6,
                curve: (-12.0, 50.0),
                curve_back: 55.0,
                ..Level::PLAIN
            },
            Level {
                down_angle: (48.0, 12.0),
                rotate: (140.0, 30.0),
                branches: 15.0,
                length: (0.38, 0.10),
                segments: 4,
                curve: (35.0, 50.0),
                ..Level::PLAIN
            },
        ],
    }),
    bark: (Bark::Birch, Vec2::new(0.5, 1.0)),
    foliage: Some(Foliage {
        sprig: Sprig::Leaves {
            shape: LeafShape::BIRCH,
            length: 0.115,
            count: 60,
        },
        habit: Habit::Hanging,
        thinner_than: 0.010,
        spacing: 0.27,
        length: (0.58, 0.12),
        angle: 50.0,
        round: 0.45,
        fold: 0.0,
        thickness: 0.000_18,
        transmission: 0.45,
    }),
    seeds: &[21, 22],
};

/// Beech: dense and round, on a smooth trunk that forks.
pub const BEECH: Tree = Tree {
    name: "beech",
    growth: Growth::Parameters(Species {
        shape: Shape::TendFlame,
        base_size: 0.15,
        scale: (13.5, 1.0),
        ratio: 0.0165,
        ratio_power: 1.35,
        flare: 0.7,
        attraction_up: 0.25,
        whorl: 0,
        levels: &[
            Level {
                segments: 10,
                curve: (0.0, 40.0),
                splits: 0.07,
                split_angle: (20.0, 6.0),
                ..Level::PLAIN
            },
            Level {
                down_angle: (52.0, -22.0),
                rotate: (140.0, 30.0),
                branches: 34.0,
                length: (0.40, 0.06),
                segments: 8,
                curve: (-28.0, 70.0),
                splits: 0.06,
                split_angle: (28.0, 10.0),
                ..Level::PLAIN
            },
            Level {
                down_angle: (48.0, 12.0),
                rotate: (140.0, 30.0),
                branches: 20.0,
                length: (0.40, 0.08),
                segments: 4,
                curve: (-10.0, 60.0),
                ..Level::PLAIN
            },
        ],
    }),
    bark: (Bark::Beech, Vec2::new(0.9, 1.8)),
    foliage: Some(Foliage {
        sprig: Sprig::Leaves {
            shape: LeafShape::BEECH,
            length: 0.14,
            count: 54,
        },
        habit: Habit::Spreading,
        thinner_than: 0.017,
        spacing: 0.31,
        length: (0.74, 0.12),
        angle: 48.0,
        round: 0.5,
        fold: 0.0,
        thickness: 0.000_2,
        transmission: 0.45,
    }),
    seeds: &[31, 32],
};

/// Norway spruce: a cone of whorls, boughs that hang and rise at their tips.
pub const SPRUCE: Tree = Tree {
    name: "spruce",
    growth: Growth::Parameters(Species {
        shape: Shape::Conical,
        base_size: 0.07,
        scale: (16.5, 1.5),
        ratio: 0.0125,
        ratio_power: 1.1,
        flare: 0.5,
        attraction_up: 0.0,
        whorl: 6,
        levels: &[
            Level {
                segments: 12,
                curve: (0.0, 6.0),
                ..Level::PLAIN
            },
            Level {
                down_angle: (76.0, -28.0),
                rotate: (64.0, 14.0),
                branches: 132.0,
                length: (0.205, 0.03),
                segments: 5,
                curve: (14.0, 20.0),
                curve_back: -38.0,
                ..Level::PLAIN
            },
        ],
    }),
    bark: (Bark::Spruce, Vec2::new(0.7, 1.4)),
    foliage: Some(Foliage {
        sprig: Sprig::Spray,
        habit: Habit::Flat,
        thinner_than: 0.022,
        spacing: 0.115,
        length: (0.72, 0.12),
        angle: 52.0,
        round: 0.4,
        fold: 0.0,
        thickness: 0.001,
        transmission: 0.12,
    }),
    seeds: &[41, 42],
};

/// Scots pine: a bare trunk, a loose crown of tufts.
pub const PINE: Tree = Tree {
    name: "pine",
    growth: Growth::Parameters(Species {
        shape: Shape::TendFlame,
        base_size: 0.42,
        scale: (15.0, 1.2),
        ratio: 0.0125,
        ratio_power: 1.25,
        flare: 0.4,
        attraction_up: 0.55,
        whorl: 4,
        levels: &[
            Level {
                segments: 12,
                curve: (0.0, 35.0),
                taper: 0.95,
                ..Level::PLAIN
            },
            Level {
                down_angle: (72.0, -20.0),
                rotate: (96.0, 22.0),
                branches: 34.0,
                length: (0.26, 0.07),
                segments: 7,
                curve: (-30.0, 80.0),
                ..Level::PLAIN
            },
            Level {
                down_angle: (52.0, 12.0),
                rotate: (140.0, 30.0),
                branches: 16.0,
                length: (0.36, 0.10),
                segments: 3,
                curve: (-30.0, 60.0),
                ..Level::PLAIN
            },
        ],
    }),
    bark: (Bark::Pine, Vec2::new(0.9, 1.8)),
    foliage: Some(Foliage {
        sprig: Sprig::Tufts,
        habit: Habit::Upright,
        thinner_than: 0.012,
        spacing: 0.22,
        length: (0.50, 0.08),
        angle: 42.0,
        round: 0.35,
        fold: 0.0,
        thickness: 0.001,
        transmission: 0.12,
    }),
    seeds: &[51, 52],
};

/// A standing dead tree: grey wood, few broken boughs.
pub const DEAD_TREE: Tree = Tree {
    name: "dead_tree",
    growth: Growth::Parameters(Species {
        shape: Shape::TaperedCylindrical,
        base_size: 0.32,
        scale: (8.5, 1.0),
        ratio: 0.028,
        ratio_power: 1.2,
        flare: 0.8,
        attraction_up: 0.0,
        whorl: 0,
        levels: &[
            Level {
                segments: 10,
                curve: (0.0, 50.0),
                taper: 0.75,
                ..Level::PLAIN
            },
            Level {
                down_angle: (66.0, -18.0),
                rotate: (140.0, 40.0),
                branches: 17.0,
                length: (0.34, 0.16),
                taper: 0.8,
                segments: 6,
                curve: (10.0, 120.0),
                ..Level::PLAIN
            },
            Level {
                down_angle: (50.0, 15.0),
                rotate: (140.0, 40.0),
                branches: 8.0,
                length: (0.42, 0.2),
                taper: 0.9,
                segments: 4,
                curve: (0.0, 100.0),
                ..Level::PLAIN
            },
        ],
    }),
    bark: (Bark::Dead, Vec2::new(0.8, 1.6)),
    foliage: None,
    seeds: &[61, 62],
};

/// Hazel bush: many shoots from the ground.
pub const BUSH: Tree = Tree {
    name: "bush",
    growth: Growth::Space(Colony {
        crown_base: 0.12,
        height: 1.9,
        crown_radius: 1.15,
        widest: 0.5,
        points: 190,
        reach: 1.6,
        kill: 0.24,
        step: 0.10,
        pipe: 2.3,
        twig_radius: 0.0042,
        lift: 0.05,
        wander: 0.25,
        flare: 0.0,
    }),
    bark: (Bark::Beech, Vec2::new(0.3, 0.6)),
    foliage: Some(Foliage {
        sprig: Sprig::Leaves {
            shape: LeafShape::HAZEL,
            length: 0.21,
            count: 26,
        },
        habit: Habit::Spreading,
        thinner_than: 0.012,
        spacing: 0.09,
        length: (0.40, 0.08),
        angle: 50.0,
        round: 0.5,
        fold: 0.0,
        thickness: 0.000_2,
        transmission: 0.4,
    }),
    seeds: &[71, 72],
};
