//! Leaves on cards: where they are, which of them a level of detail keeps, and how they catch light.
//!
//! Coarser levels keep a random subset and enlarge it, so that the total area of leaves stays the same (Cook, Halstead,
//! Planck and Ryu 2007, *Stochastic Simplification of Aggregate Detail*, section 2).

use bevy_math::{Vec2, Vec3};

use super::skeleton::Seat;
use crate::forge::{
    mesh::{Mesh, Vertex},
    portable::{Dice, mix, smooth},
    texture::sprigs::GRID,
};

/// Height bands in which the crown's width is known.
const BANDS: usize = 12;

/// The crown's outline, for light and shade.
#[derive(Clone, Debug, PartialEq)]
pub struct Crown {
    low: f32,
    high: f32,
    /// Greatest distance of leaves from the axis, per band from low to high.
    radii: [f32; BANDS],
    /// Where the axis is in each band.
    axes: [Vec2; BANDS],
}

impl Crown {
    /// The outline of seats; everything is open where there are none.
    pub fn new(seats: &[Seat]) -> Self {
        let heights = || seats.iter().map(|seat| seat.at.y);
        let (low, high) = (heights().fold(f32::MAX, f32::min), heights().fold(f32::MIN, f32::max));
        let mut crown = Self {
            low,
            high: high.max(low + 0.1),
            radii: [0.3; BANDS],
            axes: [Vec2::ZERO; BANDS],
        };
        if seats.is_empty() {
            return crown;
        }
        let mut sums = [(Vec2::ZERO, 0.0); BANDS];
        for seat in seats {
            let band = crown.band(seat.at.y);
            sums[band].0 += Vec2::new(seat.at.x, seat.at.z);
            sums[band].1 += 1.0;
        }
        for (axis, (sum, count)) in crown.axes.iter_mut().zip(sums) {
            if count > 0.0 {
                *axis = sum / count;
            }
        }
        for seat in seats {
            let band = crown.band(seat.at.y);
            let reach = Vec2::new(seat.at.x, seat.at.z).distance(crown.axes[band]);
            crown.radii[band] = crown.radii[band].max(reach);
        }
        crown
    }

    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the bands"
    )]
    fn band(&self, height: f32) -> usize {
        let share = ((height - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        ((share * BANDS as f32) as usize).min(BANDS - 1)
    }

    /// 0 deep inside to 1 at the outline.
    pub fn openness(&self, at: Vec3) -> f32 {
        let band = self.band(at.y);
        let sideways = Vec2::new(at.x, at.z).distance(self.axes[band]) / self.radii[band];
        let upwards = (at.y - self.low) / (self.high - self.low);
        (sideways * sideways + 0.35 * (upwards.max(0.0))).min(1.0)
    }

    /// Factor on the base colour for the light that the crown keeps off.
    pub fn shade(&self, at: Vec3) -> f32 {
        mix(0.66, 1.0, smooth(0.0, 0.9, self.openness(at)))
    }

    /// Away from the middle of the crown, a unit vector.
    pub fn outward(&self, at: Vec3) -> Vec3 {
        let axis = self.axes[self.band(at.y)];
        let middle = mix(self.low, self.high, 0.4);
        let flat = Vec3::new(at.x - axis.x, 0.0, at.z - axis.y);
        (flat + Vec3::Y * (0.6 * (at.y - middle))).normalize_or(Vec3::Y)
    }
}

/// Seats in an order of which every beginning is a fair sample.
pub fn shuffled(mut seats: Vec<Seat>, seed: u64) -> Vec<Seat> {
    let mut dice = Dice::new(seed ^ 0x5eed);
    for i in (1..seats.len()).rev() {
        let other = dice.below(u32::try_from(i + 1).unwrap_or(u32::MAX)) as usize;
        seats.swap(i, other);
    }
    seats
}

/// Cards of the first `share` of the seats, enlarged to the same total area.
///
/// `round` bends normals outward, 0 (flat cards) to 1 (a ball of leaves); `fold` raises the two halves of a card against
/// each other, as a share of its width (0: two triangles per card, else four).
pub fn cards(seats: &[Seat], share: f32, crown: &Crown, round: f32, fold: f32) -> Mesh {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..=length")]
    let count = (seats.len() as f32 * share + 0.5) as usize;
    let kept = &seats[..count.min(seats.len())];
    let scale = if kept.is_empty() {
        1.0
    } else {
        (seats.len() as f32 / kept.len() as f32).sqrt()
    };
    let mut mesh = Mesh {
        shades: true,
        ..Mesh::default()
    };
    for seat in kept {
        card(&mut mesh, seat, scale, crown, round, fold);
    }
    mesh
}

fn card(mesh: &mut Mesh, seat: &Seat, scale: f32, crown: &Crown, round: f32, fold: f32) {
    let length = seat.length * scale;
    // Larger cards grow about their middle, not from their stalk.
    let from = seat.at - seat.along * (0.5 * (length - seat.length));
    let middle = from + seat.along * (0.5 * length);
    let outward = crown.outward(middle);
    let upper = if seat.upper.dot(outward) < 0.0 {
        -seat.upper
    } else {
        seat.upper
    };
    let right = seat.along.cross(upper);
    let shade = crown.shade(middle) * seat.tone;
    let grid = GRID as u32;
    let (column, row) = (seat.cell % grid, seat.cell / grid % grid);
    let mut corner = |across: f32, along: f32| {
        let lift = if across == 0.0 { 0.0 } else { fold };
        let position = from + right * (across * length) + seat.along * (along * length) + upper * (lift * length);
        let bulge = (upper + right * (across * 0.7) + seat.along * ((along - 0.5) * 0.7)).normalize();
        let u = (column as f32 + 0.5 + across) / grid as f32;
        let v = (row as f32 + 1.0 - along) / grid as f32;
        mesh.push(Vertex {
            position,
            normal: bulge.lerp(outward, round).normalize_or(upper),
            uv: Vec2::new(u, v),
            tangent: right,
            shade: shade * mix(0.86, 1.0, along),
        })
    };
    if fold == 0.0 {
        let corners = [corner(-0.5, 0.0), corner(0.5, 0.0), corner(0.5, 1.0), corner(-0.5, 1.0)];
        mesh.push_quad(corners);
    } else {
        let [a, b, c] = [corner(-0.5, 0.0), corner(0.0, 0.0), corner(0.5, 0.0)];
        let [d, e, f] = [corner(-0.5, 1.0), corner(0.0, 1.0), corner(0.5, 1.0)];
        mesh.push_quad([a, b, e, d]);
        mesh.push_quad([b, c, f, e]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seats() -> Vec<Seat> {
        let mut dice = Dice::new(3);
        (0..400)
            .map(|_| Seat {
                at: dice.in_ball() * 3.0 + Vec3::Y * 6.0,
                along: Vec3::X,
                upper: Vec3::Y,
                length: 0.5,
                cell: 3,
                tone: 1.0,
            })
            .collect()
    }

    fn area(mesh: &Mesh) -> f32 {
        let corner = |i: u32| mesh.vertices[i as usize].position;
        mesh.indices
            .chunks(3)
            .map(|t| {
                0.5 * (corner(t[1]) - corner(t[0]))
                    .cross(corner(t[2]) - corner(t[0]))
                    .length()
            })
            .sum()
    }

    #[test]
    fn fewer_cards_have_the_same_area() {
        let seats = shuffled(seats(), 1);
        let crown = Crown::new(&seats);
        let full = cards(&seats, 1.0, &crown, 0.5, 0.0);
        assert_eq!(full.triangle_count(), 800);
        assert!(
            (area(&full) - 100.0).abs() < 0.01,
            "400 squares of 0.5 m: {}",
            area(&full)
        );
        for (share, count) in [(0.5, 200), (0.1, 40)] {
            let fewer = cards(&seats, share, &crown, 0.5, 0.0);
            assert_eq!(fewer.triangle_count(), 2 * count);
            assert!((area(&fewer) - 100.0).abs() < 0.01, "{}", area(&fewer));
        }
    }

    #[test]
    fn cards_turn_their_faces_outward_and_show_their_own_cell() {
        let seats = seats();
        let crown = Crown::new(&seats);
        let mesh = cards(&seats, 1.0, &crown, 0.0, 0.0);
        for corners in mesh.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|i| mesh.vertices[corners[i] as usize]);
            let face = (b.position - a.position).cross(c.position - a.position);
            assert!(face.dot(a.normal) > 0.0 && face.dot(crown.outward(a.position)) > -0.05);
            assert!(
                a.uv.x >= 0.5 && a.uv.y >= 0.5,
                "cell 3 is the lower right one: {}",
                a.uv
            );
        }
    }

    #[test]
    fn it_is_darker_inside() {
        let crown = Crown::new(&seats());
        assert!(crown.shade(Vec3::Y * 5.0) < crown.shade(Vec3::new(2.9, 6.0, 0.0)));
    }
}
