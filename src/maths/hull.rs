//! The convex hull of a few points.

use bevy_math::{DVec2, DVec3};

use super::polytope::{HalfSpace, LARGEST_COORDINATE, Polytope, PolytopeState, RELATIVE_TOLERANCE, magnitude};

impl Polytope {
    /// The convex hull. Points in one plane give a [flat](PolytopeState::Flat) body, points on one line an empty one.
    ///
    /// Tries every triple of points, so that coplanar points end in one face: meant for up to a hundred points.
    pub fn hull(points: &[DVec3]) -> Self {
        if points.iter().any(|point| point.is_nan()) {
            return Self::refused(PolytopeState::NotFinite);
        }
        let scale = magnitude(points);
        if scale > LARGEST_COORDINATE {
            return Self::refused(PolytopeState::Enormous);
        }
        let tolerance = RELATIVE_TOLERANCE * scale;
        let mut body = Self::default();
        for point in points {
            if body.vertices.iter().all(|other| other.distance(*point) > tolerance) {
                body.vertices.push(*point);
            }
        }
        let points = body.vertices.clone();
        let mut members: Vec<(DVec3, Vec<u32>)> = Vec::new();
        for i in 0..points.len() {
            for j in i + 1..points.len() {
                for k in j + 1..points.len() {
                    for half_space in supporting_planes([points[i], points[j], points[k]], &points, tolerance) {
                        let triple = [i as u32, j as u32, k as u32];
                        let known = members.iter().any(|(normal, indices)| {
                            normal.dot(half_space.normal) > 0.0 && triple.iter().all(|index| indices.contains(index))
                        });
                        if known {
                            continue;
                        }
                        let on_plane: Vec<u32> = (0..points.len() as u32)
                            .filter(|index| half_space.excess(points[*index as usize]) >= -tolerance)
                            .collect();
                        let outline = outline(&points, &on_plane, half_space.normal, tolerance);
                        if outline.len() >= 3 {
                            body.push_face(&outline, half_space);
                        }
                        members.push((half_space.normal, on_plane));
                    }
                }
            }
        }
        body.without_unused_vertices()
    }
}

/// The half-spaces bounded by the plane of a triangle that contain all points: none, one, or two for flat clouds.
fn supporting_planes(triangle: [DVec3; 3], points: &[DVec3], tolerance: f64) -> Vec<HalfSpace> {
    let [a, b, c] = triangle;
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    if normal.length() <= 1.0e-6 * ab.length() * ac.length() {
        return Vec::new();
    }
    let front = HalfSpace::through((a + b + c) / 3.0, normal.normalize());
    let back = HalfSpace {
        normal: -front.normal,
        distance: -front.distance,
    };
    [front, back]
        .into_iter()
        .filter(|half_space| points.iter().all(|point| half_space.excess(*point) <= tolerance))
        .collect()
}

/// The convex outline of points in a plane, counter-clockwise seen from the tip of the normal (monotone chain).
fn outline(points: &[DVec3], indices: &[u32], normal: DVec3, tolerance: f64) -> Vec<u32> {
    let (right, up) = normal.any_orthonormal_pair();
    let mut flat: Vec<(DVec2, u32)> = indices
        .iter()
        .map(|index| {
            let point = points[*index as usize];
            (DVec2::new(point.dot(right), point.dot(up)), *index)
        })
        .collect();
    flat.sort_by(|a, b| a.0.x.total_cmp(&b.0.x).then(a.0.y.total_cmp(&b.0.y)));
    let half = |sorted: &mut dyn Iterator<Item = &(DVec2, u32)>| {
        let mut side: Vec<(DVec2, u32)> = Vec::new();
        for point in sorted {
            while let [.., a, b] = side[..] {
                let edge = point.0 - a.0;
                if edge.perp_dot(b.0 - a.0) < -tolerance * edge.length() {
                    break;
                }
                side.pop();
            }
            side.push(*point);
        }
        side.pop();
        side
    };
    let lower = half(&mut flat.iter());
    let upper = half(&mut flat.iter().rev());
    lower.into_iter().chain(upper).map(|(_, index)| index).collect()
}
