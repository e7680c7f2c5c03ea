//! Ground of forest and park: litter, trodden earth, rock, lawn.

use bevy_math::{Vec2, Vec3};

use super::sheet::{Place, Sheet};
use crate::forge::{
    portable::{Dice, TURN, mix, sin_cos, smooth},
    texture::noise::{cells, octaves, ridges},
};

fn toward(angle: f32) -> Vec2 {
    let (sin, cos) = sin_cos(angle);
    Vec2::new(cos, sin)
}

/// Somewhere on a tile, in metres.
fn anywhere(dice: &mut Dice, width: f32) -> Vec2 {
    Vec2::new(dice.unit(), dice.unit()) * width
}

/// One of several colours, a little lighter or darker.
fn pick(dice: &mut Dice, colors: &[[f32; 3]]) -> Vec3 {
    let index = dice.below(u32::try_from(colors.len()).unwrap_or(1)) as usize;
    Vec3::from(colors[index]) * dice.about(1.0, 0.22)
}

/// A fallen leaf: a pointed oval with a midrib, curled and tilted.
fn leaf(sheet: &mut Sheet, dice: &mut Dice, length: f32, color: Vec3) {
    let center = anywhere(dice, sheet.width);
    let along = toward(dice.between(0.0, TURN));
    let across = along.perp();
    let broad = dice.between(0.24, 0.36);
    let tilt = Vec2::new(dice.signed(), dice.signed()) * 0.25;
    let curl = dice.between(-0.5, 0.9);
    let lobes = dice.between(0.0, 0.10);
    let base = sheet.at(center).height + 0.0012;
    let soft = 0.03;
    sheet.paint(center, 0.5 * length, |offset, there| {
        let p = Vec2::new(offset.dot(along), offset.dot(across)) / (0.5 * length);
        // An oval that ends in points; lobes as on oak leaves.
        let edge = 2.0 * broad * (1.0 - p.x * p.x) * (1.0 + lobes * sin_cos(14.0 * p.x).0);
        let cover = smooth(edge + soft, edge - soft, p.y.abs());
        if cover <= 0.0 {
            return there;
        }
        let rib = smooth(0.075, 0.02, p.y.abs());
        let veins = smooth(0.55, 1.0, sin_cos(22.0 * (p.x - 0.8 * p.y.abs())).0) * 0.35;
        let rim = smooth(0.55, 1.0, p.y.abs() / edge.max(0.01));
        let light = 1.0 + 0.30 * rib - 0.22 * veins - 0.25 * rim;
        let bulge = curl * 0.006 * p.y * p.y / (broad * broad).max(0.01) * 0.5;
        Place {
            height: mix(there.height, base + tilt.dot(offset) + bulge - 0.0012 * rib, cover),
            color: there.color.lerp(color * light, cover),
        }
    });
}

/// A stone half in the ground.
fn pebble(sheet: &mut Sheet, center: Vec2, radius: f32, dice: &mut Dice, color: Vec3) {
    let along = toward(dice.between(0.0, TURN));
    let slim = dice.between(0.6, 0.95);
    let sunk = dice.between(0.15, 0.6);
    let angular = dice.between(0.0, TURN);
    let base = sheet.at(center).height;
    sheet.paint(center, radius, |offset, there| {
        let p = Vec2::new(offset.dot(along), offset.dot(along.perp()) / slim) / radius;
        let wobble = 1.0 + 0.06 * sin_cos(3.0 * p.x + 4.0 * p.y + angular).0;
        let d = (p * wobble).length();
        let cover = smooth(1.0, 0.86, d);
        if cover <= 0.0 {
            return there;
        }
        let round = (1.0 - d * d).max(0.0).sqrt();
        let height = base + radius * (0.75 * round - sunk * 0.4);
        Place {
            height: mix(there.height, height.max(there.height - 0.001), cover),
            color: there.color.lerp(color * mix(0.7, 1.08, round), cover),
        }
    });
}

/// Leaf litter on dark soil, with moss, needles and twigs.
pub(super) fn forest_floor() -> Sheet {
    const WIDTH: f32 = 2.2;
    const LITTER: [[f32; 3]; 6] = [
        [0.185, 0.098, 0.045],
        [0.140, 0.080, 0.042],
        [0.110, 0.072, 0.045],
        [0.210, 0.135, 0.070],
        [0.070, 0.045, 0.028],
        [0.155, 0.112, 0.068],
    ];
    let mut sheet = Sheet::new(WIDTH, |p| {
        let bump = octaves(301, p, (4, 4), 4);
        let crumb = octaves(302, p, (48, 48), 3);
        Place {
            height: 0.03 * bump + 0.006 * crumb,
            color: Vec3::new(0.050, 0.034, 0.022) * (1.0 + 0.6 * bump + 0.8 * crumb),
        }
    });
    let mut dice = Dice::new(3010);
    for _ in 0..1500 {
        let (length, color) = (dice.between(0.045, 0.10), pick(&mut dice, &LITTER) * 0.62);
        leaf(&mut sheet, &mut dice, length, color);
    }
    moss(&mut sheet);
    for layer in 0..3 {
        for _ in 0..300 {
            let (length, color) = (dice.between(0.05, 0.105), pick(&mut dice, &LITTER));
            leaf(&mut sheet, &mut dice, length, color * mix(0.8, 1.1, 0.5 * layer as f32));
        }
        for _ in 0..220 {
            let from = anywhere(&mut dice, WIDTH);
            let to = from + toward(dice.between(0.0, TURN)) * dice.between(0.03, 0.06);
            let color = pick(&mut dice, &[[0.17, 0.10, 0.05], [0.11, 0.075, 0.04]]);
            sheet.stroke(from, to, (0.0014, 0.0010), 0.001, (color, color));
        }
        for _ in 0..10 {
            twig(&mut sheet, &mut dice);
        }
    }
    sheet
}

/// Green cushions where the ground is damp.
fn moss(sheet: &mut Sheet) {
    let width = sheet.width;
    sheet.paint(Vec2::splat(0.5 * width), 0.4999 * width, |offset, there| {
        let p = offset / width + 0.5;
        let damp = smooth(0.12, 0.30, octaves(305, p, (3, 3), 4));
        let tuft = octaves(306, p, (90, 90), 2);
        let color = Vec3::new(0.060, 0.085, 0.020) * (1.0 + 1.1 * tuft);
        Place {
            height: there.height + damp * (0.010 + 0.006 * tuft),
            color: there.color.lerp(color, 0.85 * damp),
        }
    });
}

/// A fallen twig with a side shoot.
fn twig(sheet: &mut Sheet, dice: &mut Dice) {
    let color = pick(
        dice,
        &[[0.085, 0.060, 0.042], [0.15, 0.125, 0.10], [0.055, 0.040, 0.03]],
    );
    let from = anywhere(dice, sheet.width);
    let heading = dice.between(0.0, TURN);
    let length = dice.between(0.12, 0.42);
    let radius = dice.between(0.0028, 0.0055);
    let bend = from + toward(heading) * (0.55 * length);
    let to = bend + toward(heading + dice.about(0.0, 0.4)) * (0.45 * length);
    sheet.stroke(from, bend, (radius, 0.8 * radius), 0.003, (color, color));
    sheet.stroke(bend, to, (0.8 * radius, 0.4 * radius), 0.003, (color, color));
    let shoot = bend + toward(heading + dice.about(0.0, 1.0)) * (0.4 * length);
    sheet.stroke(bend, shoot, (0.6 * radius, 0.3 * radius), 0.003, (color, color));
}

/// Trodden earth: smooth where feet go, with pebbles and a few leaves.
pub(super) fn path() -> Sheet {
    const WIDTH: f32 = 2.5;
    let mut sheet = Sheet::new(WIDTH, |p| {
        let wander = Vec2::new(octaves(311, p, (5, 5), 3), octaves(312, p, (5, 5), 3));
        let bump = octaves(313, p + 0.03 * wander, (3, 3), 4);
        let crumb = octaves(314, p, (40, 40), 3);
        let grit = octaves(315, p, (140, 140), 1);
        let dust = smooth(-0.2, 0.3, octaves(316, p, (3, 3), 4));
        let earth = Vec3::new(0.125, 0.086, 0.056).lerp(Vec3::new(0.225, 0.170, 0.120), dust);
        Place {
            height: 0.035 * bump + 0.005 * crumb + 0.003 * grit,
            color: earth * (1.0 + 0.35 * crumb + 0.45 * grit),
        }
    });
    let mut dice = Dice::new(3110);
    for _ in 0..900 {
        let share = dice.unit();
        let radius = mix(0.006, 0.034, share * share * share);
        let color = pick(
            &mut dice,
            &[
                [0.22, 0.20, 0.175],
                [0.16, 0.14, 0.12],
                [0.26, 0.21, 0.155],
                [0.12, 0.105, 0.09],
            ],
        );
        let center = anywhere(&mut dice, WIDTH);
        pebble(&mut sheet, center, radius, &mut dice, color);
    }
    for _ in 0..34 {
        let (length, color) = (
            dice.between(0.04, 0.08),
            pick(&mut dice, &[[0.13, 0.08, 0.045], [0.18, 0.12, 0.065]]),
        );
        leaf(&mut sheet, &mut dice, length, color);
    }
    for _ in 0..130 {
        let from = anywhere(&mut dice, WIDTH);
        let to = from + toward(dice.between(0.0, TURN)) * dice.between(0.03, 0.09);
        let color = pick(&mut dice, &[[0.13, 0.09, 0.055], [0.20, 0.16, 0.10]]);
        sheet.stroke(from, to, (0.0018, 0.0012), 0.001, (color, color));
    }
    sheet
}

/// Bare rock: crags and broken faces, lichen, moss in the hollows.
pub(super) fn rock() -> Sheet {
    const WIDTH: f32 = 3.0;
    Sheet::new(WIDTH, |p| {
        let wander = Vec2::new(octaves(321, p, (4, 4), 4), octaves(322, p, (4, 4), 4));
        let q = p + 0.07 * wander;
        let crag = ridges(324, q, (3, 5), 5);
        // Broken faces: each cell leans its own way.
        let face = cells(323, q + 0.04 * wander.perp(), (7, 10));
        let lean = (face.id - 0.5) * smooth(0.0, 0.3, face.second - face.nearest) - 0.45 * face.nearest;
        let chip = octaves(330, q, (14, 18), 4);
        let grain = octaves(326, p, (110, 110), 2);
        let patch = octaves(327, p, (2, 2), 5);
        let speck = cells(328, p, (160, 160)).id;
        let height = 0.11 * crag + 0.05 * lean + 0.035 * chip + 0.005 * grain;
        let open = smooth(0.35, 0.85, crag + 0.25 * lean + 0.3 * chip);
        let gray = Vec3::new(0.085, 0.080, 0.075).lerp(
            Vec3::new(0.325, 0.308, 0.284),
            (0.10 + 0.55 * open + 0.5 * patch + 0.4 * chip + 0.30 * grain + 0.26 * (speck - 0.5)).clamp(0.0, 1.0),
        );
        let pale = smooth(0.20, 0.27, octaves(329, p + 0.02 * wander, (9, 9), 4)) * smooth(0.0, 0.1, patch);
        let mossy = smooth(0.15, 0.60, 0.45 - open + 1.1 * wander.y + 0.5 * grain);
        let color = gray
            .lerp(Vec3::new(0.34, 0.35, 0.28), 0.55 * pale)
            .lerp(Vec3::new(0.075, 0.086, 0.034) * (1.0 + 0.8 * grain), 0.65 * mossy);
        Place { height, color }
    })
}

/// A mown lawn: blades lying all ways, clover, a little straw.
pub(super) fn grass() -> Sheet {
    const WIDTH: f32 = 1.5;
    let mut sheet = Sheet::new(WIDTH, |p| {
        let crumb = octaves(331, p, (30, 30), 3);
        Place {
            height: 0.008 * crumb,
            color: Vec3::new(0.042, 0.046, 0.018) * (1.0 + 0.7 * crumb),
        }
    });
    let mut dice = Dice::new(3310);
    let rounds = 5;
    for round in 0..rounds {
        let high = round as f32 / (rounds - 1) as f32;
        for _ in 0..2100 {
            let root = anywhere(&mut dice, WIDTH);
            let tuft = octaves(332, root / WIDTH, (6, 6), 2);
            let heading = TURN * (1.4 * tuft + 0.35 * dice.signed());
            let tip = root + toward(heading) * dice.between(0.025, 0.065);
            let fresh = octaves(333, root / WIDTH, (3, 3), 3);
            let green = Vec3::new(0.105, 0.165, 0.040).lerp(
                Vec3::new(0.190, 0.235, 0.070),
                (0.5 + fresh + 0.5 * dice.signed()).clamp(0.0, 1.0),
            );
            let straw = dice.unit() < 0.05;
            let color = if straw { Vec3::new(0.30, 0.25, 0.12) } else { green } * mix(0.55, 1.05, high);
            let radius = dice.between(0.0013, 0.0024);
            sheet.stroke(root, tip, (radius, 0.4 * radius), 0.004 * high, (color * 0.6, color));
        }
        if round == 3 {
            for _ in 0..70 {
                clover(&mut sheet, &mut dice);
            }
        }
    }
    sheet
}

/// Three round leaflets.
fn clover(sheet: &mut Sheet, dice: &mut Dice) {
    let center = anywhere(dice, sheet.width);
    let heading = dice.between(0.0, TURN);
    let radius = dice.between(0.006, 0.010);
    let color = Vec3::new(0.085, 0.165, 0.045) * dice.about(1.0, 0.2);
    for leaflet in 0..3 {
        let at = center + toward(heading + TURN / 3.0 * leaflet as f32) * radius;
        let base = sheet.at(at).height + 0.004;
        sheet.paint(at, radius, |offset, there| {
            let d = offset.length() / radius;
            let cover = smooth(1.0, 0.75, d);
            Place {
                height: mix(there.height, base, cover),
                color: there.color.lerp(color * mix(1.15, 0.8, d), cover),
            }
        });
    }
}
