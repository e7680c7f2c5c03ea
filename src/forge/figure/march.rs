//! Triangles of a field's surface: marching tetrahedra (Doi and Koide 1991) on a lattice of cubes cut into six.

use std::collections::HashMap;

use bevy_math::Vec3;

use super::{decimate::Surface, field::Field};

/// Cubes per side of a block that is skipped as a whole far from the surface.
const BLOCK: usize = 6;

/// The tetrahedra around a cube's diagonal from corner 0 to corner 7 (Freudenthal): the same on both sides of a face.
const TETRAHEDRA: [[usize; 4]; 6] = [
    [0, 1, 3, 7],
    [0, 1, 5, 7],
    [0, 2, 3, 7],
    [0, 2, 6, 7],
    [0, 4, 5, 7],
    [0, 4, 6, 7],
];

/// Values of a field on a lattice.
struct Lattice {
    low: Vec3,
    cell: f32,
    size: [usize; 3],
    values: Vec<f32>,
}

/// The surface where a field is zero, in cubes of `cell` metres. Of a `mirrored` body only the half x ≥ 0 is made: its
/// border lies in the plane x = 0 and is marked as seam.
pub fn surface(field: &Field, cell: f32, mirrored: bool) -> Surface {
    Lattice::new(field, cell, mirrored).march(mirrored)
}

impl Lattice {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a body of some metres"
    )]
    fn new(field: &Field, cell: f32, mirrored: bool) -> Self {
        let (mut low, high) = field.bounds(2.0 * cell);
        if mirrored {
            low.x = 0.0;
        }
        let size = ((high - low) / cell)
            .to_array()
            .map(|count| count.max(1.0) as usize + 2);
        let mut lattice = Self {
            low,
            cell,
            size,
            values: vec![1.0; size[0] * size[1] * size[2]],
        };
        let blocks = size.map(|count| count.div_ceil(BLOCK));
        let reach = cell * BLOCK as f32;
        for block in 0..blocks[0] * blocks[1] * blocks[2] {
            let first = [
                block % blocks[0],
                block / blocks[0] % blocks[1],
                block / blocks[0] / blocks[1],
            ]
            .map(|index| index * BLOCK);
            let middle = lattice.place(first) + Vec3::splat(reach * 0.5);
            let there = field.distance(middle);
            let far = there.abs() > reach * 1.2;
            for offset in 0..BLOCK * BLOCK * BLOCK {
                let at = [
                    first[0] + offset % BLOCK,
                    first[1] + offset / BLOCK % BLOCK,
                    first[2] + offset / BLOCK / BLOCK,
                ];
                if (0..3).all(|axis| at[axis] < size[axis]) {
                    let value = if far { there } else { field.distance(lattice.place(at)) };
                    let index = lattice.index(at);
                    lattice.values[index] = value;
                }
            }
        }
        lattice
    }

    fn place(&self, at: [usize; 3]) -> Vec3 {
        self.low + Vec3::new(at[0] as f32, at[1] as f32, at[2] as f32) * self.cell
    }

    fn index(&self, at: [usize; 3]) -> usize {
        at[0] + self.size[0] * (at[1] + self.size[1] * at[2])
    }

    fn march(&self, mirrored: bool) -> Surface {
        let mut surface = Surface::default();
        let mut known: HashMap<(usize, usize), u32> = HashMap::new();
        let [nx, ny, nz] = self.size.map(|count| count - 1);
        for cube in 0..nx * ny * nz {
            let first = [cube % nx, cube / nx % ny, cube / nx / ny];
            let corners: [([usize; 3], usize); 8] = std::array::from_fn(|corner| {
                let at = [
                    first[0] + (corner & 1),
                    first[1] + (corner >> 1 & 1),
                    first[2] + (corner >> 2),
                ];
                (at, self.index(at))
            });
            let inside = corners.iter().filter(|(_, index)| self.values[*index] < 0.0).count();
            if inside == 0 || inside == 8 {
                continue;
            }
            for tetrahedron in TETRAHEDRA {
                let corners = tetrahedron.map(|corner| corners[corner]);
                let mut edge = |a: usize, b: usize| {
                    let (a, b) = (corners[a.min(b)], corners[a.max(b)]);
                    *known.entry((a.1, b.1)).or_insert_with(|| {
                        let (from, to) = (self.values[a.1], self.values[b.1]);
                        // Not too near to the lattice, for slivers collapse badly.
                        let t = (from / (from - to)).clamp(0.15, 0.85);
                        surface.points.push(self.place(a.0).lerp(self.place(b.0), t));
                        surface.seam.push(mirrored && a.0[0] == 0 && b.0[0] == 0);
                        surface.piece.push(0);
                        u32::try_from(surface.points.len() - 1).unwrap_or(u32::MAX)
                    })
                };
                let solid: Vec<usize> = (0..4).filter(|i| self.values[corners[*i].1] < 0.0).collect();
                let empty: Vec<usize> = (0..4).filter(|i| !solid.contains(i)).collect();
                let faces = match (&solid[..], &empty[..]) {
                    ([a], [b, c, d]) | ([b, c, d], [a]) => vec![[edge(*a, *b), edge(*a, *c), edge(*a, *d)]],
                    ([a, b], [c, d]) => {
                        let quad = [edge(*a, *c), edge(*a, *d), edge(*b, *d), edge(*b, *c)];
                        vec![[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
                    }
                    _ => Vec::new(),
                };
                let middle = |which: &[usize]| {
                    which.iter().map(|i| self.place(corners[*i].0)).sum::<Vec3>() / which.len().max(1) as f32
                };
                let outward = middle(&empty) - middle(&solid);
                for [a, b, c] in faces {
                    let [p, q, r] = [a, b, c].map(|i| surface.points[i as usize]);
                    let turned = (q - p).cross(r - p).dot(outward) < 0.0;
                    surface.faces.push(if turned { [a, c, b] } else { [a, b, c] });
                }
            }
        }
        surface
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forge::figure::field::Flesh;

    fn ball() -> Field {
        Field(vec![Flesh {
            ends: [Vec3::ZERO; 2],
            radii: [1.0; 2],
            stretch: Vec3::ONE,
            joints: [0; 2],
            blend: 0.0,
            carve: false,
        }])
    }

    fn volume(surface: &Surface) -> f32 {
        let corners = surface
            .faces
            .iter()
            .map(|face| face.map(|i| surface.points[i as usize]));
        corners.map(|[a, b, c]| a.cross(b).dot(c) / 6.0).sum()
    }

    #[test]
    fn a_ball_is_closed_and_has_its_volume() {
        let surface = surface(&ball(), 0.1, false);
        assert_eq!(
            surface.points.len() * 2,
            surface.faces.len() + 4,
            "Euler: closed without handles"
        );
        // 4.18879 m³, less what chords cut off.
        assert!((4.10..4.19).contains(&volume(&surface)), "{}", volume(&surface));
    }

    #[test]
    fn half_a_ball_ends_in_the_plane() {
        let half = surface(&ball(), 0.1, true);
        assert!(half.points.iter().all(|p| p.x >= 0.0));
        for (p, seam) in half.points.iter().zip(&half.seam) {
            assert_eq!(p.x == 0.0, *seam, "{p}");
        }
        assert!(
            (2.04..2.10).contains(&volume(&half)),
            "{}: the missing lid adds nothing",
            volume(&half)
        );
    }
}
