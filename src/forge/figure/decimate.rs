//! Fewer triangles: edge collapse by quadric error metrics (Garland and Heckbert 1997).
//!
//! Collapses that fold a triangle over or change the topology (link condition, Dey et al. 1999) are left out. Points on
//! the seam of half a body stay in the plane x = 0.

use std::{cmp::Reverse, collections::BinaryHeap};

use bevy_math::{DVec3, Vec3};

/// Height of a triangle over its longest side, relative to that side, below which its normal says little.
const SLIVER: f64 = 0.10;

/// Triangles without normals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Metres.
    pub points: Vec<Vec3>,
    /// Is the point on the border in the plane x = 0, where the mirrored half joins?
    pub seam: Vec<bool>,
    /// Which piece of a figure the point belongs to.
    pub piece: Vec<usize>,
    /// Corners, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 3]>,
}

impl Surface {
    /// Adds the triangles of another surface as piece `piece`.
    pub fn append(&mut self, other: &Self, piece: usize) {
        let first = u32::try_from(self.points.len()).unwrap_or(u32::MAX);
        self.points.extend_from_slice(&other.points);
        self.seam.extend_from_slice(&other.seam);
        self.piece.extend(std::iter::repeat_n(piece, other.points.len()));
        self.faces
            .extend(other.faces.iter().map(|face| face.map(|i| i + first)));
    }

    /// Only the faces that are `alive`, without unused points.
    fn compacted(&self, alive: impl Fn(usize) -> bool) -> Self {
        let mut new_index = vec![u32::MAX; self.points.len()];
        let mut compact = Self::default();
        for face in self
            .faces
            .iter()
            .enumerate()
            .filter(|(i, _)| alive(*i))
            .map(|(_, face)| face)
        {
            let corners = face.map(|corner| {
                let old = corner as usize;
                if new_index[old] == u32::MAX {
                    new_index[old] = u32::try_from(compact.points.len()).unwrap_or(u32::MAX);
                    compact.points.push(self.points[old]);
                    compact.seam.push(self.seam[old]);
                    compact.piece.push(self.piece[old]);
                }
                new_index[old]
            });
            compact.faces.push(corners);
        }
        compact
    }

    /// Only the pieces that `keep` accepts.
    pub fn pieces(&self, keep: impl Fn(usize) -> bool) -> Self {
        self.compacted(|face| keep(self.piece[self.faces[face][0] as usize]))
    }
}

/// A sum of squared distances to planes: the symmetric matrix's upper half, row by row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Quadric([f64; 10]);

impl Quadric {
    fn plane(normal: DVec3, offset: f64, weight: f64) -> Self {
        let [a, b, c] = normal.to_array();
        let d = offset;
        Self([a * a, a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d, d * d].map(|part| part * weight))
    }

    fn plus(self, other: Self) -> Self {
        Self(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }

    fn error(&self, p: DVec3) -> f64 {
        let [aa, ab, ac, ad, bb, bc, bd, cc, cd, dd] = self.0;
        let DVec3 { x, y, z } = p;
        aa * x * x
            + bb * y * y
            + cc * z * z
            + dd
            + 2.0 * (ab * x * y + ac * x * z + bc * y * z + ad * x + bd * y + cd * z)
    }

    /// Where the error is least: in space, or in the plane x = 0. `None` where that is not well defined.
    fn best(&self, in_plane: bool) -> Option<DVec3> {
        let [aa, ab, ac, ad, bb, bc, bd, cc, cd, _] = self.0;
        let minor = bb * cc - bc * bc;
        if in_plane {
            let size = (bb + cc) * (bb + cc);
            return (minor > 1e-4 * size).then(|| DVec3::new(0.0, bc * cd - cc * bd, bc * bd - bb * cd) / minor);
        }
        let (m10, m20) = (ab * cc - ac * bc, ab * bc - ac * bb);
        let determinant = aa * minor - ab * m10 + ac * m20;
        let trace = aa + bb + cc;
        if determinant <= 1e-5 * trace * trace * trace {
            return None;
        }
        let x = -ad * minor + bd * m10 - cd * m20;
        let y = ad * m10 - bd * (aa * cc - ac * ac) + cd * (aa * bc - ab * ac);
        let z = -ad * m20 + bd * (aa * bc - ab * ac) - cd * (aa * bb - ab * ab);
        Some(DVec3::new(x, y, z) / determinant)
    }
}

/// A surface with at most about `faces` triangles; errors are weighed by `importance` (of a place and its piece).
pub fn decimated(surface: &Surface, faces: usize, importance: &dyn Fn(Vec3, usize) -> f32) -> Surface {
    Decimation::new(surface, importance).run(faces)
}

struct Decimation {
    surface: Surface,
    quadrics: Vec<Quadric>,
    /// Faces around each point, dead ones among them.
    around: Vec<Vec<u32>>,
    alive: Vec<bool>,
    /// How often a point has moved: collapses planned before are void.
    moves: Vec<u32>,
    queue: BinaryHeap<Reverse<Collapse>>,
    /// See [`SLIVER`]; smaller once nothing else is left.
    sliver: f64,
}

/// A planned collapse; the order is by error, then by points, so that it is the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Collapse {
    /// The error's bits: errors are not negative, so their order is that of the numbers.
    error: u64,
    ends: [u32; 2],
    moves: [u32; 2],
}

impl Decimation {
    fn new(surface: &Surface, importance: &dyn Fn(Vec3, usize) -> f32) -> Self {
        let count = surface.points.len();
        let mut quadrics = vec![Quadric::default(); count];
        let mut around = vec![Vec::new(); count];
        for (index, face) in surface.faces.iter().enumerate() {
            let [a, b, c] = face.map(|i| surface.points[i as usize].as_dvec3());
            let cross = (b - a).cross(c - a);
            let normal = cross.normalize_or_zero();
            let middle = ((a + b + c) / 3.0).as_vec3();
            let weight = cross.length() * f64::from(importance(middle, surface.piece[face[0] as usize]));
            // A little of the distance itself keeps points of flat regions in place.
            let quadric = Quadric::plane(normal, -normal.dot(a), weight);
            for corner in face {
                let corner = *corner as usize;
                let mut sum = quadrics[corner];
                sum = sum.plus(quadric);
                let p = surface.points[corner].as_dvec3();
                for axis in DVec3::AXES {
                    sum = sum.plus(Quadric::plane(axis, -axis.dot(p), weight * 1e-3));
                }
                quadrics[corner] = sum;
                around[corner].push(u32::try_from(index).unwrap_or(u32::MAX));
            }
        }
        let mut decimation = Self {
            surface: surface.clone(),
            quadrics,
            around,
            alive: vec![true; surface.faces.len()],
            moves: vec![0; count],
            queue: BinaryHeap::new(),
            sliver: SLIVER,
        };
        decimation.plan_all();
        decimation
    }

    fn plan_all(&mut self) {
        for index in 0..self.surface.faces.len() {
            if !self.alive[index] {
                continue;
            }
            let face = self.surface.faces[index];
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                // An inner edge is seen from both sides; it is planned once, a border edge always.
                let ends = [face[a].min(face[b]), face[a].max(face[b])];
                if face[a] < face[b] || ends.iter().all(|end| self.surface.seam[*end as usize]) {
                    self.plan(ends);
                }
            }
        }
    }

    /// Where a collapsed edge's point goes, and what that costs.
    fn merged(&self, [a, b]: [u32; 2]) -> (DVec3, f64) {
        let quadric = self.quadrics[a as usize].plus(self.quadrics[b as usize]);
        let [p, q] = [a, b].map(|end| self.surface.points[end as usize].as_dvec3());
        let seam = [a, b].map(|end| self.surface.seam[end as usize]);
        let (low, high) = (p.min(q), p.max(q));
        let slack = (q - p).length();
        let inside = |best: &DVec3| (best.clamp(low, high) - *best).length() < slack;
        let fallback = || match seam {
            [true, false] => p,
            [false, true] => q,
            _ => {
                let middle = (p + q) * 0.5;
                [p, q].into_iter().fold(middle, |best, end| {
                    if quadric.error(end) < quadric.error(best) {
                        end
                    } else {
                        best
                    }
                })
            }
        };
        let at = quadric.best(seam[0] || seam[1]).filter(inside).unwrap_or_else(fallback);
        (at, quadric.error(at).max(0.0))
    }

    fn plan(&mut self, ends: [u32; 2]) {
        let (_, error) = self.merged(ends);
        let moves = ends.map(|end| self.moves[end as usize]);
        self.queue.push(Reverse(Collapse {
            error: error.to_bits(),
            ends,
            moves,
        }));
    }

    fn run(mut self, target: usize) -> Surface {
        let mut left = self.surface.faces.len();
        loop {
            let before = left;
            while left > target {
                let Some(Reverse(collapse)) = self.queue.pop() else {
                    break;
                };
                let [a, b] = collapse.ends;
                if collapse.moves == [a, b].map(|end| self.moves[end as usize])
                    && let Some(at) = self.allowed(a, b)
                {
                    left -= self.collapse(a, b, at);
                }
            }
            if left <= target || (left == before && self.sliver < SLIVER / 100.0) {
                break;
            }
            // What was not allowed may be by now, or with thinner triangles.
            if left * 100 > before * 95 {
                self.sliver *= 0.25;
            }
            self.plan_all();
        }
        self.surface.compacted(|face| self.alive[face])
    }

    fn living(&self, point: u32) -> impl Iterator<Item = u32> + '_ {
        let faces = self.around[point as usize].iter().copied();
        faces.filter(|face| self.alive[*face as usize])
    }

    fn neighbours(&self, point: u32) -> Vec<u32> {
        let mut found: Vec<u32> = self
            .living(point)
            .flat_map(|face| self.surface.faces[face as usize])
            .filter(|other| *other != point)
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Where an edge may collapse to: the best place, else an end. `None` where it must not collapse.
    fn allowed(&self, a: u32, b: u32) -> Option<DVec3> {
        let shared = self
            .living(a)
            .filter(|face| self.surface.faces[*face as usize].contains(&b))
            .count();
        let of_a = self.neighbours(a);
        let common = self.neighbours(b).iter().filter(|other| of_a.contains(other)).count();
        let both_on_seam = self.surface.seam[a as usize] && self.surface.seam[b as usize];
        // The link condition; a border edge has one face, and an inner edge must not join two borders.
        if common != shared || shared != if both_on_seam { 1 } else { 2 } {
            return None;
        }
        // A tetrahedron, or a last triangle on the seam, stays as it is.
        let least = if both_on_seam { 2 } else { 3 };
        if of_a.len() <= least && self.neighbours(b).len() <= least {
            return None;
        }
        let seam = [a, b].map(|end| self.surface.seam[end as usize]);
        let ends = [a, b].map(|end| self.surface.points[end as usize].as_dvec3());
        let (best, _) = self.merged([a, b]);
        let mut places = vec![best];
        places.extend((0..2).filter(|i| seam[*i] || !seam[1 - *i]).map(|i| ends[i]));
        places.into_iter().find(|at| {
            [(a, b), (b, a)].into_iter().all(|(moving, other)| {
                self.living(moving)
                    .map(|face| self.surface.faces[face as usize])
                    .filter(|face| !face.contains(&other))
                    .all(|face| self.stays_upright(face, moving, *at))
            })
        })
    }

    /// Does a face keep its side and some width when one of its corners moves? Slivers may do as they like, unless they
    /// become worse.
    fn stays_upright(&self, face: [u32; 3], moving: u32, at: DVec3) -> bool {
        let place = |corner: u32| self.surface.points[corner as usize].as_dvec3();
        let cross = |[p, q, r]: [DVec3; 3]| (q - p).cross(r - p);
        let width = |[p, q, r]: [DVec3; 3]| {
            let longest = (q - p)
                .length_squared()
                .max((r - q).length_squared())
                .max((p - r).length_squared());
            cross([p, q, r]).length() / longest.max(1e-18)
        };
        let old = face.map(place);
        let new = face.map(|corner| if corner == moving { at } else { place(corner) });
        let (before, after) = (cross(old), cross(new));
        let sliver = width(old) < self.sliver;
        let turned = after.dot(before) < 0.2 * after.length() * before.length();
        (sliver || !turned) && width(new) > self.sliver.min(0.9 * width(old))
    }

    /// Moves `b` into `a`, and both to `at`; gives the number of faces that vanish.
    fn collapse(&mut self, a: u32, b: u32, at: DVec3) -> usize {
        let (ai, bi) = (a as usize, b as usize);
        let seam = self.surface.seam[ai] || self.surface.seam[bi];
        self.surface.points[ai] = at.as_vec3();
        if seam {
            self.surface.points[ai].x = 0.0;
        }
        self.surface.seam[ai] = seam;
        self.quadrics[ai] = self.quadrics[ai].plus(self.quadrics[bi]);
        let mut vanished = 0;
        for face in std::mem::take(&mut self.around[bi]) {
            let corners = &mut self.surface.faces[face as usize];
            if !self.alive[face as usize] {
                continue;
            }
            if corners.contains(&a) {
                self.alive[face as usize] = false;
                vanished += 1;
            } else {
                *corners = corners.map(|corner| if corner == b { a } else { corner });
                self.around[ai].push(face);
            }
        }
        let alive = &self.alive;
        self.around[ai].retain(|face| alive[*face as usize]);
        self.moves[ai] += 1;
        self.moves[bi] += 1;
        for other in self.neighbours(a) {
            self.plan([a.min(other), a.max(other)]);
        }
        vanished
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forge::figure::{
        field::{Field, Flesh},
        march,
    };

    fn capsule() -> Field {
        Field(vec![Flesh {
            ends: [Vec3::Y * -1.0, Vec3::Y],
            radii: [0.5; 2],
            stretch: Vec3::ONE,
            joints: [0; 2],
            blend: 0.0,
            carve: false,
        }])
    }

    fn edges(surface: &Surface) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = surface
            .faces
            .iter()
            .flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]])
            .collect();
        edges.sort_unstable();
        edges
    }

    #[test]
    fn the_least_error_is_where_planes_meet() {
        let corner = DVec3::new(1.0, -2.0, 3.0);
        let planes = [DVec3::X, DVec3::new(0.6, 0.8, 0.0), DVec3::new(0.0, 0.6, 0.8)];
        let sum = planes.into_iter().fold(Quadric::default(), |sum, normal| {
            sum.plus(Quadric::plane(normal, -normal.dot(corner), 2.0))
        });
        let best = sum.best(false).expect("three planes meet");
        assert!((best - corner).length() < 1e-9, "{best}");
        assert!(sum.error(corner).abs() < 1e-9);
        assert!((Quadric::plane(DVec3::X, -1.0, 2.0).error(DVec3::X * 4.0) - 18.0).abs() < 1e-9);
        let flat = Quadric::plane(DVec3::Y, -2.0, 1.0).plus(Quadric::plane(DVec3::Z, -3.0, 1.0));
        assert_eq!(flat.best(false), None, "a line has no single best point");
        assert_eq!(
            flat.best(true),
            Some(DVec3::new(0.0, 2.0, 3.0)),
            "but meets the seam's plane"
        );
    }

    #[test]
    fn a_coarse_capsule_is_closed_and_keeps_its_shape() {
        let fine = march::surface(&capsule(), 0.08, false);
        let coarse = decimated(&fine, 200, &|_, _| 1.0);
        assert!(coarse.faces.len() <= 200, "{}", coarse.faces.len());
        let edges = edges(&coarse);
        assert!(
            edges.windows(2).all(|pair| pair[0] != pair[1]),
            "no edge twice in one direction"
        );
        assert!(
            edges.iter().all(|[a, b]| edges.binary_search(&[*b, *a]).is_ok()),
            "closed"
        );
        let field = capsule();
        for p in &coarse.points {
            assert!(field.distance(*p).abs() < 0.03, "{p}");
        }
    }

    #[test]
    fn the_seam_stays_in_its_plane() {
        let fine = march::surface(&capsule(), 0.08, true);
        let coarse = decimated(&fine, 100, &|_, _| 1.0);
        assert!(coarse.faces.len() <= 100);
        let edges = edges(&coarse);
        for [a, b] in &edges {
            let open = edges.binary_search(&[*b, *a]).is_err();
            let on_seam = [a, b].iter().all(|end| coarse.seam[**end as usize]);
            assert!(!open || on_seam, "open only at the seam");
        }
        for (p, seam) in coarse.points.iter().zip(&coarse.seam) {
            assert!(!seam || p.x == 0.0);
        }
        let highest = coarse.points.iter().map(|p| p.y).fold(0.0, f32::max);
        assert!((highest - 1.5).abs() < 0.03, "{highest}");
    }
}
