//! Outlines and veins of single leaves.

use bevy_math::{Vec2, Vec3};

use super::canvas::{Canvas, Paint};
use crate::forge::portable::{Dice, TURN, cos, power, smooth};

/// The shape of a leaf, in shares of its length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeafShape {
    /// Half the greatest width.
    pub half_width: f32,
    /// Where along the leaf it is widest, 0 at the stalk to 1 at the tip.
    pub widest: f32,
    /// Above 1: slender towards the stalk; below 1: blunt.
    pub base: f32,
    /// Above 1: drawn out to a tip; below 1: blunt.
    pub tip: f32,
    /// Lobes or teeth per side.
    pub lobes: f32,
    /// How deep the bays between them are, 0..1.
    pub bay: f32,
    /// Side veins per side.
    pub veins: f32,
    /// Linear colour of the upper side.
    pub color: [f32; 3],
}

impl LeafShape {
    /// Pedunculate oak: obovate, round lobes.
    pub const OAK: Self = Self {
        half_width: 0.32,
        widest: 0.62,
        base: 0.9,
        tip: 0.5,
        lobes: 5.0,
        bay: 0.46,
        veins: 5.0,
        color: [0.075, 0.155, 0.025],
    };
    /// Silver birch: triangular, toothed, drawn out.
    pub const BIRCH: Self = Self {
        half_width: 0.40,
        widest: 0.28,
        base: 0.55,
        tip: 1.15,
        lobes: 9.0,
        bay: 0.14,
        veins: 6.0,
        color: [0.115, 0.215, 0.030],
    };
    /// Beech: oval, wavy rim, straight parallel veins.
    pub const BEECH: Self = Self {
        half_width: 0.33,
        widest: 0.45,
        base: 0.6,
        tip: 0.75,
        lobes: 8.0,
        bay: 0.05,
        veins: 8.0,
        color: [0.065, 0.165, 0.022],
    };
    /// Hazel: nearly round, coarsely toothed.
    pub const HAZEL: Self = Self {
        half_width: 0.43,
        widest: 0.5,
        base: 0.45,
        tip: 0.6,
        lobes: 11.0,
        bay: 0.09,
        veins: 7.0,
        color: [0.085, 0.175, 0.035],
    };
    /// Box-like evergreen: small, oval, smooth.
    pub const EVERGREEN: Self = Self {
        half_width: 0.26,
        widest: 0.5,
        base: 0.6,
        tip: 0.6,
        lobes: 0.0,
        bay: 0.0,
        veins: 5.0,
        color: [0.035, 0.095, 0.020],
    };

    /// Half the width at a place along the leaf, in shares of the length.
    pub fn half_width_at(&self, along: f32) -> f32 {
        if !(0.0..=1.0).contains(&along) {
            return 0.0;
        }
        let outline = if along < self.widest {
            power(1.0 - power(1.0 - along / self.widest, 2.0), self.base)
        } else {
            power(1.0 - power((along - self.widest) / (1.0 - self.widest), 2.0), self.tip)
        };
        let bay = 0.5 + 0.5 * cos(TURN * (along * self.lobes + 0.15));
        self.half_width * outline * (1.0 - self.bay * bay * bay)
    }

    /// What is at a place: `along` the midrib, `across` it, in shares of the length; `None` outside.
    fn at(&self, along: f32, across: f32, tone: Vec3) -> Option<Paint> {
        let half = self.half_width_at(along);
        if across.abs() >= half {
            return None;
        }
        let rib = smooth(0.022, 0.006, across.abs());
        // Side veins leave the midrib at about 45°, and reach the rim in the middle of a lobe.
        let place = (along - 0.75 * across.abs()) * self.veins;
        let off_vein = (place - place.floor() - 0.5).abs() * 2.0;
        let vein = smooth(0.80, 1.0, off_vein) * 0.55;
        let rim = smooth(0.75, 1.0, across.abs() / half);
        let puff = 1.0 + 0.10 * (1.0 - off_vein) - 0.16 * rim;
        // The two halves are folded: one faces the light more.
        let fold = if across > 0.0 { 1.10 } else { 0.90 };
        let green = tone * puff * fold * (0.88 + 0.2 * along);
        let pale = tone * 1.5 + Vec3::new(0.035, 0.04, 0.015);
        Some(Paint {
            color: green.lerp(pale, rib.max(vein) * 0.75),
            thickness: 0.45 + 0.5 * rib.max(vein * 0.6),
        })
    }

    /// Paints a leaf that begins at `stalk` and points along `direction` (length in cell units), over a shadow on what
    /// lies below it.
    pub fn paint(&self, canvas: &mut Canvas, cell: usize, stalk: Vec2, direction: Vec2, dice: &mut Dice) {
        let length = direction.length();
        if length < 1e-4 {
            return;
        }
        let along_axis = direction / length;
        let across_axis = Vec2::new(-along_axis.y, along_axis.x);
        let brightness = dice.between(0.72, 1.22);
        let yellow = dice.between(-0.08, 0.16);
        let tone =
            Vec3::from(self.color) * brightness * Vec3::new(1.0 + 2.0 * yellow, 1.0 + 0.6 * yellow, 1.0 - yellow);
        // Seen obliquely, leaves are narrower.
        let turned = dice.between(0.62, 1.0);
        let reach = Vec2::splat(length * 0.5);
        let middle = stalk + direction * 0.5;
        let place = |p: Vec2| {
            let from = (p - stalk) / length;
            (from.dot(along_axis), from.dot(across_axis) / turned)
        };
        let drop = Vec2::new(0.012, -0.018);
        canvas.paint(
            cell,
            middle - reach * 1.3 + drop,
            middle + reach * 1.3 + drop,
            |p, there| {
                let (along, across) = place(p - drop);
                match there {
                    Some(below) if self.at(along, across, tone).is_some() => Some(Paint {
                        color: below.color * 0.62,
                        ..below
                    }),
                    _ => there,
                }
            },
        );
        canvas.paint(cell, middle - reach * 1.3, middle + reach * 1.3, |p, there| {
            let (along, across) = place(p);
            self.at(along, across, tone).or(there)
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_are_widest_where_they_say_and_end_at_their_tips() {
        let smooth_rim = LeafShape {
            bay: 0.0,
            ..LeafShape::OAK
        };
        assert!((smooth_rim.half_width_at(0.62) - 0.32).abs() < 1e-6);
        assert!(smooth_rim.half_width_at(0.5) < 0.32 && smooth_rim.half_width_at(0.75) < 0.32);
        for outside in [-0.1, 0.0, 1.0, 1.1] {
            assert_eq!(smooth_rim.half_width_at(outside), 0.0, "at {outside}");
        }
    }

    #[test]
    fn an_oak_leaf_has_bays_between_its_lobes() {
        let widths: Vec<f32> = (20..=98)
            .map(|i| LeafShape::OAK.half_width_at(i as f32 / 100.0))
            .collect();
        let bays = widths.windows(3).filter(|w| w[1] < w[0] && w[1] < w[2]).count();
        assert_eq!(bays, 3, "between the lobes at 0.37, 0.57 and 0.77 of its length");
    }

    #[test]
    fn a_painted_leaf_covers_about_its_area() {
        let mut canvas = Canvas::new(1, 64);
        let shape = LeafShape {
            lobes: 0.0,
            bay: 0.0,
            ..LeafShape::BEECH
        };
        shape.paint(
            &mut canvas,
            0,
            Vec2::new(0.5, 0.1),
            Vec2::new(0.0, 0.8),
            &mut Dice::new(1),
        );
        let area: f32 = (0..1000)
            .map(|i| 2.0 * shape.half_width_at(i as f32 / 1000.0) * 0.8 * 0.8 / 1000.0)
            .sum();
        let [picture, _] = canvas.pictures("leaf");
        let covered = picture.texels.iter().map(|t| f32::from(t[3]) / 255.0).sum::<f32>() / 4096.0;
        assert!(
            covered < area * 1.02 && covered > area * 0.6,
            "{covered} of {area}: between 62 % and 100 % turned"
        );
    }
}
