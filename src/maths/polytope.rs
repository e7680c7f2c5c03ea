//! [`Polytope`]: the convex bodies of focusing, as faces with vertex loops.
//!
//! Robustness: planes are stored, never recomputed from vertices; vertices within a tolerance relative to the size of
//! the coordinates count as lying on a clipping plane; new vertices are made once per edge, so that the surface stays
//! closed. Nothing panics: inputs that have no body give a [`PolytopeState`].

use bevy_math::DVec3;

/// Coordinates beyond this many metres are refused as [`PolytopeState::Enormous`]: double precision could no longer
/// resolve a millimetre.
pub const LARGEST_COORDINATE: f64 = 1.0e12;

/// Distance below which a point counts as lying on a plane, relative to the largest coordinate.
pub const RELATIVE_TOLERANCE: f64 = 1.0e-9;

/// One side of a plane: the points with `normal · x <= distance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Points out of the half-space; of unit length wherever a [`Polytope`] hands it out.
    pub normal: DVec3,
    /// Signed distance of the plane from the origin along the normal, in metres.
    pub distance: f64,
}

impl HalfSpace {
    /// The half-space whose plane passes through `point`.
    pub fn through(point: DVec3, normal: DVec3) -> Self {
        Self {
            normal,
            distance: normal.dot(point),
        }
    }

    /// How far outside the point is (negative: inside), in metres for unit normals.
    pub fn excess(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.distance
    }
}

/// What a [`Polytope`] is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PolytopeState {
    /// No point: nothing to see or to fit.
    #[default]
    Empty,
    /// A polygon without thickness, such as the body of a ground plane.
    Flat,
    /// A body with volume.
    Solid,
    /// Built from NaN.
    NotFinite,
    /// Built from coordinates beyond [`LARGEST_COORDINATE`].
    Enormous,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FaceRange {
    pub(super) half_space: HalfSpace,
    pub(super) start: u32,
    pub(super) end: u32,
}

/// One face of a [`Polytope`].
#[derive(Clone, Copy, Debug)]
pub struct Face<'a> {
    /// The half-space that the face bounds; its normal has unit length and points outwards.
    pub half_space: HalfSpace,
    /// Indices into [`Polytope::vertices`], counter-clockwise seen from outside.
    pub indices: &'a [u32],
}

/// A convex body: empty by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polytope {
    pub(super) vertices: Vec<DVec3>,
    pub(super) indices: Vec<u32>,
    pub(super) faces: Vec<FaceRange>,
    refused: Option<PolytopeState>,
}

impl Polytope {
    /// A body without points that says why.
    pub(super) fn refused(state: PolytopeState) -> Self {
        Self {
            refused: Some(state),
            ..Self::default()
        }
    }

    /// Names inputs that cannot be worked with.
    fn refusal(points: &[DVec3]) -> Option<PolytopeState> {
        if points.iter().any(|point| point.is_nan()) {
            Some(PolytopeState::NotFinite)
        } else if magnitude(points) > LARGEST_COORDINATE {
            Some(PolytopeState::Enormous)
        } else {
            None
        }
    }

    /// An axis-aligned box. Empty when `min` exceeds `max` on an axis; flat boxes keep all six faces.
    pub fn from_box(min: DVec3, max: DVec3) -> Self {
        if let Some(PolytopeState::NotFinite) = Self::refusal(&[min, max]) {
            return Self::refused(PolytopeState::NotFinite);
        }
        if !min.cmple(max).all() {
            return Self::default();
        }
        if let Some(state) = Self::refusal(&[min, max]) {
            return Self::refused(state);
        }
        let corner = |x: bool, y: bool, z: bool| {
            DVec3::new(
                if x { max.x } else { min.x },
                if y { max.y } else { min.y },
                if z { max.z } else { min.z },
            )
        };
        // A frustum that looks along -z: near is the side of large z.
        let corners = [
            corner(false, false, true),
            corner(true, false, true),
            corner(true, true, true),
            corner(false, true, true),
            corner(false, false, false),
            corner(true, false, false),
            corner(true, true, false),
            corner(false, true, false),
        ];
        let normals = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y];
        let mut body = Self {
            vertices: corners.to_vec(),
            ..Self::default()
        };
        for (quad, normal) in FRUSTUM_QUADS.iter().zip(normals) {
            body.push_face(quad, HalfSpace::through(corners[quad[0] as usize], normal));
        }
        body
    }

    /// A frustum from its corners: near bottom left, bottom right, top right, top left, then the far ones in the same
    /// order. Either handedness; corners that make no proper frustum (an apex, a flat one) give their [hull](Self::hull).
    pub fn from_frustum_corners(corners: &[DVec3; 8]) -> Self {
        if let Some(state) = Self::refusal(corners) {
            return Self::refused(state);
        }
        let scale = magnitude(corners);
        let center = mean(corners);
        let mut body = Self {
            vertices: corners.to_vec(),
            ..Self::default()
        };
        for quad in &FRUSTUM_QUADS {
            let points = quad.map(|index| corners[index as usize]);
            let normal = (points[2] - points[0]).cross(points[3] - points[1]).normalize_or_zero();
            let mut half_space = HalfSpace::through(mean(&points), normal);
            let mut quad = *quad;
            if half_space.excess(center) > 0.0 {
                half_space.normal = -half_space.normal;
                half_space.distance = -half_space.distance;
                quad.reverse();
            }
            let proper = half_space.excess(center) < -RELATIVE_TOLERANCE * scale
                && points
                    .iter()
                    .all(|point| half_space.excess(*point).abs() <= RELATIVE_TOLERANCE * scale);
            if !proper {
                return Self::hull(corners);
            }
            body.push_face(&quad, half_space);
        }
        body
    }

    pub(super) fn push_face(&mut self, indices: &[u32], half_space: HalfSpace) {
        let start = self.indices.len() as u32;
        self.indices.extend_from_slice(indices);
        self.faces.push(FaceRange {
            half_space,
            start,
            end: self.indices.len() as u32,
        });
    }

    /// The body moved along `direction` for `distance` metres, with everything that it passes through.
    pub fn sweep(&self, direction: DVec3, distance: f64) -> Self {
        if self.is_empty() {
            return self.clone();
        }
        let offset = direction.normalize_or_zero() * distance;
        let moved: Vec<DVec3> = self.vertices.iter().map(|vertex| vertex + offset).collect();
        if let Some(state) = Self::refusal(&moved) {
            return Self::refused(state);
        }
        let count = self.vertices.len() as u32;
        let mut body = Self {
            vertices: self.vertices.iter().chain(&moved).copied().collect(),
            ..Self::default()
        };
        for face in self.faces() {
            let shift = if face.half_space.normal.dot(offset) > 0.0 {
                count
            } else {
                0
            };
            let indices: Vec<u32> = face.indices.iter().map(|index| index + shift).collect();
            let first = body.vertices[indices[0] as usize];
            body.push_face(&indices, HalfSpace::through(first, face.half_space.normal));
        }
        for [a, b] in self.silhouette(offset) {
            let edge = self.vertices[a as usize] - self.vertices[b as usize];
            if let Some(normal) = edge.cross(offset).try_normalize() {
                let half_space = HalfSpace::through(self.vertices[a as usize], normal);
                body.push_face(&[b, a, a + count, b + count], half_space);
            }
        }
        body.without_unused_vertices()
    }

    /// The edges between faces that look along `direction` and faces that do not, as vertex indices in the order of the
    /// latter.
    pub fn silhouette(&self, direction: DVec3) -> Vec<[u32; 2]> {
        self.border(|half_space| half_space.normal.dot(direction) > 0.0)
    }

    /// The edges between faces that are chosen and faces that are not, as vertex indices in the order of the latter.
    pub(super) fn border(&self, is_chosen: impl Fn(&HalfSpace) -> bool) -> Vec<[u32; 2]> {
        let mut chosen = Vec::new();
        let mut rest = Vec::new();
        for face in self.faces() {
            let edges = if is_chosen(&face.half_space) {
                &mut chosen
            } else {
                &mut rest
            };
            for (index, a) in face.indices.iter().enumerate() {
                edges.push([*a, face.indices[(index + 1) % face.indices.len()]]);
            }
        }
        rest.retain(|[a, b]| chosen.contains(&[*b, *a]));
        rest
    }

    /// Corner points, each once.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// The faces.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = Face<'_>> {
        self.faces.iter().map(|face| Face {
            half_space: face.half_space,
            indices: &self.indices[face.start as usize..face.end as usize],
        })
    }

    /// The edges, each once, as pairs of end points.
    pub fn edges(&self) -> Vec<[DVec3; 2]> {
        let mut pairs = Vec::with_capacity(self.indices.len());
        for face in self.faces() {
            for (index, a) in face.indices.iter().enumerate() {
                let b = face.indices[(index + 1) % face.indices.len()];
                pairs.push([*a.min(&b), *a.max(&b)]);
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        pairs
            .into_iter()
            .map(|pair| pair.map(|index| self.vertices[index as usize]))
            .collect()
    }

    /// True when it has no points, for whatever reason; [`Polytope::state`] tells which.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// What it is.
    pub fn state(&self) -> PolytopeState {
        if let Some(state) = self.refused {
            return state;
        }
        if self.is_empty() {
            return PolytopeState::Empty;
        }
        let tolerance = 4.0 * RELATIVE_TOLERANCE * magnitude(&self.vertices);
        let flat = self.faces().any(|face| {
            self.vertices
                .iter()
                .all(|vertex| face.half_space.excess(*vertex) > -tolerance)
        });
        if flat {
            PolytopeState::Flat
        } else {
            PolytopeState::Solid
        }
    }

    /// True when the point is inside or on the surface, give or take `tolerance` metres.
    pub fn contains(&self, point: DVec3, tolerance: f64) -> bool {
        !self.faces.is_empty() && self.faces.iter().all(|face| face.half_space.excess(point) <= tolerance)
    }

    /// Volume in cubic metres.
    pub fn volume(&self) -> f64 {
        let center = self.center();
        self.faces()
            .map(|face| {
                let area: DVec3 = (1..face.indices.len().saturating_sub(1))
                    .map(|index| {
                        let [a, b, c] = [0, index, index + 1].map(|index| self.vertices[face.indices[index] as usize]);
                        (b - a).cross(c - a) * 0.5
                    })
                    .sum();
                area.dot(face.half_space.normal) * -face.half_space.excess(center) / 3.0
            })
            .sum()
    }

    /// Mean of the vertices, a point inside; the origin for an empty body.
    pub fn center(&self) -> DVec3 {
        mean(&self.vertices)
    }

    /// The axis-aligned box around it.
    pub fn bounds(&self) -> super::bounds::Bounds {
        super::bounds::Bounds::from_points(self.vertices.iter().copied())
    }

    /// Drops vertices that no face uses.
    pub(super) fn without_unused_vertices(mut self) -> Self {
        let mut renamed = vec![u32::MAX; self.vertices.len()];
        let mut vertices = Vec::with_capacity(self.vertices.len());
        for index in &mut self.indices {
            let name = &mut renamed[*index as usize];
            if *name == u32::MAX {
                *name = vertices.len() as u32;
                vertices.push(self.vertices[*index as usize]);
            }
            *index = *name;
        }
        self.vertices = vertices;
        self
    }
}

/// Vertex loops of near, far, right, left, top and bottom, counter-clockwise from outside.
const FRUSTUM_QUADS: [[u32; 4]; 6] = [
    [0, 1, 2, 3],
    [5, 4, 7, 6],
    [1, 5, 6, 2],
    [4, 0, 3, 7],
    [3, 2, 6, 7],
    [4, 5, 1, 0],
];

/// The largest coordinate, by absolute value.
pub(super) fn magnitude(points: &[DVec3]) -> f64 {
    points
        .iter()
        .fold(DVec3::ZERO, |largest, point| largest.max(point.abs()))
        .max_element()
}

pub(super) fn mean(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len().max(1) as f64
}
