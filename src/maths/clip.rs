//! Cutting a [`Polytope`] with a plane.

use bevy_math::DVec3;

use super::polytope::{FaceRange, HalfSpace, Polytope, PolytopeState, RELATIVE_TOLERANCE, magnitude, mean};

impl Polytope {
    /// What is left inside a half-space. A body that merely touches it from outside is empty.
    pub fn clip(self, half_space: &HalfSpace) -> Self {
        if self.is_empty() {
            return self;
        }
        let length = half_space.normal.length();
        if !length.is_finite() || half_space.distance.is_nan() {
            return Self::refused(PolytopeState::NotFinite);
        }
        if length == 0.0 {
            return if half_space.distance >= 0.0 {
                self
            } else {
                Self::default()
            };
        }
        let half_space = HalfSpace {
            normal: half_space.normal / length,
            distance: half_space.distance / length,
        };
        let tolerance = RELATIVE_TOLERANCE * magnitude(&self.vertices);
        let excess: Vec<f64> = self.vertices.iter().map(|vertex| half_space.excess(*vertex)).collect();
        if excess.iter().all(|excess| *excess <= tolerance) {
            return self;
        }
        if excess.iter().all(|excess| *excess >= -tolerance) {
            return Self::default();
        }
        Clip {
            source: &self,
            excess: &excess,
            tolerance,
            kept: vec![u32::MAX; self.vertices.len()],
            cuts: Vec::new(),
            result: Self::default(),
        }
        .run(half_space)
    }
}

/// The state of one [`Polytope::clip`].
struct Clip<'a> {
    source: &'a Polytope,
    /// Signed distances of the source's vertices from the plane.
    excess: &'a [f64],
    tolerance: f64,
    /// New index of every vertex of the source, `u32::MAX` until it is used.
    kept: Vec<u32>,
    /// New vertices on cut edges: both ends (the smaller index first) and the new index.
    cuts: Vec<(u32, u32, u32)>,
    result: Polytope,
}

impl Clip<'_> {
    fn run(mut self, half_space: HalfSpace) -> Polytope {
        let mut cap = Vec::new();
        let source = self.source;
        for face in source.faces() {
            let start = self.result.indices.len();
            self.clip_face(face.indices, &mut cap);
            if self.result.indices.len() - start >= 3 {
                self.result.faces.push(FaceRange {
                    half_space: face.half_space,
                    start: start as u32,
                    end: self.result.indices.len() as u32,
                });
            } else {
                self.result.indices.truncate(start);
            }
        }
        let outline = chain(&cap).unwrap_or_else(|| self.sorted_by_angle(&cap, half_space.normal));
        if outline.len() >= 3 {
            self.result.push_face(&outline, half_space);
        }
        self.result.without_unused_vertices()
    }

    fn is_outside(&self, vertex: u32) -> bool {
        self.excess[vertex as usize] > self.tolerance
    }

    /// Appends what is left of a face, and the edges that the cap needs to close the surface.
    fn clip_face(&mut self, indices: &[u32], cap: &mut Vec<[u32; 2]>) {
        let mut left_at = None;
        let mut entered_first = None;
        for (position, a) in indices.iter().copied().enumerate() {
            let b = indices[(position + 1) % indices.len()];
            let (a_outside, b_outside) = (self.is_outside(a), self.is_outside(b));
            if !a_outside {
                let index = self.keep(a);
                self.result.indices.push(index);
            }
            if !a_outside && b_outside {
                left_at = Some(self.crossing(a, b));
            } else if a_outside && !b_outside {
                let entered = self.crossing(b, a);
                match left_at.take() {
                    Some(left) => cap.push([entered, left]),
                    None => entered_first = Some(entered),
                }
            }
        }
        if let (Some(left), Some(entered)) = (left_at, entered_first) {
            cap.push([entered, left]);
        }
    }

    fn keep(&mut self, vertex: u32) -> u32 {
        let kept = &mut self.kept[vertex as usize];
        if *kept == u32::MAX {
            *kept = self.result.vertices.len() as u32;
            self.result.vertices.push(self.source.vertices[vertex as usize]);
        }
        *kept
    }

    /// Where an edge meets the plane: the end that is not outside when it lies on the plane, else a new vertex, which is
    /// also appended to the current face.
    fn crossing(&mut self, not_outside: u32, outside: u32) -> u32 {
        if self.excess[not_outside as usize] >= -self.tolerance {
            return self.keep(not_outside);
        }
        let (a, b) = (not_outside.min(outside), not_outside.max(outside));
        let known = self.cuts.iter().find(|cut| (cut.0, cut.1) == (a, b)).map(|cut| cut.2);
        let index = known.unwrap_or_else(|| {
            let index = self.result.vertices.len() as u32;
            let (from, to) = (self.source.vertices[a as usize], self.source.vertices[b as usize]);
            let (from_excess, to_excess) = (self.excess[a as usize], self.excess[b as usize]);
            let share = from_excess / (from_excess - to_excess);
            self.result.vertices.push(from + (to - from) * share);
            self.cuts.push((a, b, index));
            index
        });
        self.result.indices.push(index);
        index
    }

    /// The outline of the cap when its edges do not chain up, as rounding may cause in nearly flat bodies.
    fn sorted_by_angle(&self, cap: &[[u32; 2]], normal: DVec3) -> Vec<u32> {
        let mut outline: Vec<u32> = cap.iter().flatten().copied().collect();
        outline.sort_unstable();
        outline.dedup();
        let points: Vec<DVec3> = outline
            .iter()
            .map(|index| self.result.vertices[*index as usize])
            .collect();
        let center = mean(&points);
        let (right, up) = normal.any_orthonormal_pair();
        outline.sort_by(|a, b| {
            let angle = |index: &u32| {
                let offset = self.result.vertices[*index as usize] - center;
                offset.dot(up).atan2(offset.dot(right))
            };
            angle(a).total_cmp(&angle(b))
        });
        outline
    }
}

/// Joins directed edges to one closed loop; `None` when they do not form exactly one.
fn chain(edges: &[[u32; 2]]) -> Option<Vec<u32>> {
    let mut edges: Vec<[u32; 2]> = edges.iter().filter(|[from, to]| from != to).copied().collect();
    let [first, mut end] = edges.pop()?;
    let mut outline = vec![first];
    while end != first {
        outline.push(end);
        let next = edges.iter().position(|[from, _]| *from == end)?;
        end = edges.swap_remove(next)[1];
    }
    edges.is_empty().then_some(outline)
}
