//! The shape of a body as a signed distance: tapered capsules along bones, joined smoothly.
//!
//! A soft object in the sense of Wyvill, `McPheeters` and Wyvill 1986, with line segments as skeleton like the convolution
//! surfaces of Bloomenthal and Shoemake 1991; the blend is a polynomial smooth minimum of distances (Quilez), which
//! bulges less than a sum of fields.

use bevy_math::Vec3;

use crate::forge::{
    portable::{mix, power},
    rig::{INFLUENCES, Influence},
};

/// Distance over which the influence of a farther bone halves, in metres.
const HALVING: f32 = 0.012;
/// Step of numerical gradients in metres.
const STEP: f32 = 1e-3;

/// A tapered capsule that goes with one or two joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flesh {
    /// Its axis, in metres.
    pub ends: [Vec3; 2],
    /// Radii at the ends, in metres.
    pub radii: [f32; 2],
    /// Factors on the radii along x, y and z.
    pub stretch: Vec3,
    /// Joints at the ends; between them the weight runs evenly.
    pub joints: [usize; 2],
    /// How far the seam with what came before is rounded, in metres.
    pub blend: f32,
    /// Takes away instead of adding.
    pub carve: bool,
}

impl Flesh {
    /// Distance to the surface in metres, negative inside (a lower bound where stretched), and the place along the axis.
    fn distance(&self, p: Vec3) -> (f32, f32) {
        let [a, b] = self.ends.map(|end| end / self.stretch);
        let from = p / self.stretch - a;
        let axis = b - a;
        let t = (from.dot(axis) / axis.length_squared().max(1e-12)).clamp(0.0, 1.0);
        let radius = mix(self.radii[0], self.radii[1], t);
        (((from - axis * t).length() - radius) * self.stretch.min_element(), t)
    }
}

/// A body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Field(pub Vec<Flesh>);

impl Field {
    /// Signed distance in metres, negative inside; a lower bound of its size far from the surface.
    pub fn distance(&self, p: Vec3) -> f32 {
        self.0.iter().fold(f32::MAX, |sum, flesh| {
            let own = flesh.distance(p).0;
            if flesh.carve {
                -smooth_minimum(-sum, own, flesh.blend)
            } else {
                smooth_minimum(sum, own, flesh.blend)
            }
        })
    }

    /// The outward unit normal of the surface near `p`.
    pub fn normal(&self, p: Vec3) -> Vec3 {
        let along = |step: Vec3| self.distance(p + step) - self.distance(p - step);
        Vec3::new(along(Vec3::X * STEP), along(Vec3::Y * STEP), along(Vec3::Z * STEP)).normalize_or(Vec3::Y)
    }

    /// The point of the surface near `p`, by Newton steps along the gradient of at most `reach` metres in all.
    pub fn on_surface(&self, p: Vec3, reach: f32) -> Vec3 {
        let mut at = p;
        for _ in 0..4 {
            at -= self.normal(at) * self.distance(at).clamp(-0.4 * reach, 0.4 * reach);
        }
        if (at - p).length() <= reach { at } else { p }
    }

    /// Box around everything, with a margin in metres beside what blends may add.
    pub fn bounds(&self, margin: f32) -> (Vec3, Vec3) {
        let (mut low, mut high) = (Vec3::MAX, Vec3::MIN);
        for flesh in self.0.iter().filter(|flesh| !flesh.carve) {
            for (end, radius) in flesh.ends.into_iter().zip(flesh.radii) {
                let reach = flesh.stretch * radius + Vec3::splat(margin + 0.5 * flesh.blend);
                low = low.min(end - reach);
                high = high.max(end + reach);
            }
        }
        (low, high)
    }

    /// Which joints move a point of the surface: the nearer a bone, the more.
    pub fn influence(&self, p: Vec3) -> Influence {
        let solid = || self.0.iter().filter(|flesh| !flesh.carve);
        let nearest = solid().map(|flesh| flesh.distance(p).0).fold(f32::MAX, f32::min);
        let mut shares: Vec<(usize, f32)> = Vec::new();
        for flesh in solid() {
            let (distance, t) = flesh.distance(p);
            let share = power(2.0, (nearest - distance) / HALVING);
            for (joint, part) in [(flesh.joints[0], 1.0 - t), (flesh.joints[1], t)] {
                match shares.iter_mut().find(|(known, _)| *known == joint) {
                    Some((_, sum)) => *sum = sum.max(share * part),
                    None => shares.push((joint, share * part)),
                }
            }
        }
        shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        shares.truncate(INFLUENCES);
        quantised(&shares)
    }
}

/// Shares as bytes that sum to 255; the largest share takes what rounding leaves.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "shares of 255; rigs have far fewer than 256 joints"
)]
fn quantised(shares: &[(usize, f32)]) -> Influence {
    let total: f32 = shares.iter().map(|(_, share)| share).sum();
    let mut influence = Influence::default();
    let mut rest = 255_u8;
    for (slot, (joint, share)) in shares.iter().enumerate().skip(1) {
        let weight = (share / total * 255.0 + 0.5) as u8;
        if weight > 0 {
            influence.joints[slot] = *joint as u8;
            influence.weights[slot] = weight;
            rest -= weight;
        }
    }
    influence.joints[0] = shares.first().map_or(0, |(joint, _)| *joint as u8);
    influence.weights[0] = rest;
    influence
}

/// The smaller of two distances, rounded where they differ by less than `blend` (polynomial, Quilez).
fn smooth_minimum(a: f32, b: f32, blend: f32) -> f32 {
    let overlap = (blend - (a - b).abs()).max(0.0);
    a.min(b)
        - if blend > 0.0 {
            overlap * overlap * 0.25 / blend
        } else {
            0.0
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(x: f32, joint: usize) -> Flesh {
        Flesh {
            ends: [Vec3::X * x; 2],
            radii: [1.0; 2],
            stretch: Vec3::ONE,
            joints: [joint; 2],
            blend: 0.0,
            carve: false,
        }
    }

    #[test]
    fn distances_to_a_cone_and_a_stretched_ball() {
        let cone = Flesh {
            ends: [Vec3::ZERO, Vec3::X * 4.0],
            radii: [1.0, 0.5],
            ..ball(0.0, 0)
        };
        let (distance, t) = cone.distance(Vec3::new(2.0, 3.0, 0.0));
        assert_eq!((distance, t), (2.25, 0.5), "the radius is 0.75 half way");
        let long = Flesh {
            stretch: Vec3::new(3.0, 1.0, 1.0),
            ..ball(0.0, 0)
        };
        assert!(long.distance(Vec3::X * 3.0).0.abs() < 1e-6);
        assert!((long.distance(Vec3::Y * 3.0).0 - 2.0).abs() < 1e-6);
    }

    #[test]
    fn blends_add_a_quarter_of_their_width_at_most() {
        assert_eq!(smooth_minimum(1.0, 1.0, 0.4), 0.9);
        assert_eq!(smooth_minimum(1.0, 1.4, 0.4), 1.0);
        assert_eq!(smooth_minimum(2.0, 1.0, 0.0), 1.0);
    }

    #[test]
    fn carving_takes_away() {
        let hollow = Field(vec![
            ball(0.0, 0),
            Flesh {
                carve: true,
                ..ball(1.0, 0)
            },
        ]);
        assert!(hollow.distance(Vec3::X * 0.9) > 0.0);
        assert!(hollow.distance(Vec3::X * -0.5) < 0.0);
    }

    #[test]
    fn points_are_pulled_to_the_surface_and_not_beyond_reach() {
        let field = Field(vec![ball(0.0, 0)]);
        let at = field.on_surface(Vec3::new(0.0, 1.05, 0.0), 0.1);
        assert!((at - Vec3::Y).length() < 1e-4, "{at}");
        let far = Vec3::Y * 2.0;
        assert_eq!(field.on_surface(far, 0.1), far);
    }

    #[test]
    fn weights_sum_to_one_and_halve_with_distance() {
        let field = Field(vec![ball(0.0, 3), ball(2.0 + HALVING, 5)]);
        let between = field.influence(Vec3::X);
        assert_eq!(between.joints[..2], [3, 5]);
        assert_eq!(between.weights, [170, 85, 0, 0], "two thirds and one third");
        let away = field.influence(Vec3::NEG_X);
        assert_eq!((away.joints[0], away.weights), (3, [255, 0, 0, 0]));
    }
}
