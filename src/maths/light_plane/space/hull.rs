//! [`FilmHull`]: the convex region of the base film that must be covered.

use bevy_math::{DMat2, DVec2};

use super::{BaseFilm, FilmError, FilmSample};
use crate::maths::polytope::Polytope;

/// The least w of a film over the hull, relative to the greatest: beyond it single-precision matrices lose texels.
const LEAST_WIDTH: f64 = 1.0e-4;

/// Area below which a hull counts as flat, relative to that of its box.
const FLATTEST: f64 = 1.0e-12;

/// A convex polygon on the base film, counter-clockwise. Perspectives with w > 0 keep it convex, so its corners bound the
/// film for every bend.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmHull {
    points: Vec<DVec2>,
}

/// Area of the hull's image and its first two moments: ∫ dv, ∫ v dv ÷ P, ∫ v vᵀ dv ÷ P.
pub(super) struct ImageArea {
    pub(super) total: f64,
    pub(super) mean: DVec2,
    pub(super) square: DMat2,
}

impl FilmHull {
    /// The convex hull of points (monotone chain).
    pub fn new(points: impl IntoIterator<Item = DVec2>) -> Result<Self, FilmError> {
        let mut sorted: Vec<DVec2> = points.into_iter().collect();
        if sorted.is_empty() {
            return Err(FilmError::NothingVisible);
        }
        if sorted.iter().any(|point| !point.is_finite()) {
            return Err(FilmError::NotFinite);
        }
        sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        let half = |sorted: &mut dyn Iterator<Item = &DVec2>| {
            let mut side: Vec<DVec2> = Vec::new();
            for point in sorted {
                while let [.., a, b] = side[..] {
                    if (b - a).perp_dot(point - a) > 1.0e-13 * (b - a).length() * (point - a).length() {
                        break;
                    }
                    side.pop();
                }
                side.push(*point);
            }
            side.pop();
            side
        };
        let mut hull = half(&mut sorted.iter());
        hull.extend(half(&mut sorted.iter().rev()));
        Self::checked(hull)
    }

    fn checked(points: Vec<DVec2>) -> Result<Self, FilmError> {
        let hull = Self { points };
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in &hull.points {
            (low, high) = (low.min(*point), high.max(*point));
        }
        let size = (high - low).max_element();
        if hull.points.len() < 3 || !(hull.area() > FLATTEST * size * size) {
            return Err(FilmError::NoArea);
        }
        Ok(hull)
    }

    /// The hull of everything that the samples stand for. It loses what their grid does not see.
    pub fn of_samples(samples: &[FilmSample]) -> Result<Self, FilmError> {
        Self::new(samples.iter().flat_map(|sample| sample.corners))
    }

    /// The hull of a body, such as all that the camera may see: nothing that is in it is lost, but texels are spent on
    /// what is empty of it.
    pub fn of_body(base: &BaseFilm, body: &Polytope) -> Result<Self, FilmError> {
        let points: Option<Vec<DVec2>> = body.vertices().iter().map(|vertex| base.film(*vertex)).collect();
        Self::new(points.ok_or(FilmError::TooWide)?)
    }

    /// The polygon whose sides touch the points in evenly spread directions: what a GPU reduction by maxima gives.
    /// `supports[i]` is the maximum of u · (cos α, sin α) with α = i ÷ count of the full circle. It contains the hull.
    pub fn from_supports(supports: &[f64]) -> Result<Self, FilmError> {
        let count = supports.len();
        let normal = |index: usize| DVec2::from_angle(index as f64 / count as f64 * std::f64::consts::TAU);
        let corners = (0..count).map(|index| {
            let (a, b) = (normal(index), normal(index + 1));
            let [at_a, at_b] = [supports[index], supports[(index + 1) % count]];
            (a.perp() * at_b - b.perp() * at_a) / a.perp_dot(b)
        });
        if count < 3 {
            return Err(FilmError::NothingVisible);
        }
        Self::new(corners)
    }

    /// The corners, counter-clockwise.
    pub fn points(&self) -> &[DVec2] {
        &self.points
    }

    /// Area in units of the base film.
    pub fn area(&self) -> f64 {
        let pairs = self.points.iter().zip(self.points.iter().cycle().skip(1));
        pairs.map(|(a, b)| a.perp_dot(*b)).sum::<f64>() * 0.5
    }

    /// The hull with every side moved outwards by a distance on the film: for lookups that move receivers.
    pub fn dilated(&self, distance: f64) -> Self {
        let count = self.points.len();
        let normals: Vec<DVec2> = (0..count)
            .map(|index| {
                -(self.points[(index + 1) % count] - self.points[index])
                    .perp()
                    .normalize_or_zero()
            })
            .collect();
        let points = (0..count).map(|index| {
            let (before, after) = (normals[(index + count - 1) % count], normals[index]);
            self.points[index] + (before + after) * (distance.max(0.0) / (1.0 + before.dot(after)).max(0.02))
        });
        Self {
            points: points.collect(),
        }
    }

    /// What both hulls hold.
    pub fn intersection(&self, other: &Self) -> Result<Self, FilmError> {
        let sides = other.points.iter().zip(other.points.iter().cycle().skip(1));
        let common = sides.fold(self.points.clone(), |polygon, (a, b)| {
            clip_polygon(&polygon, |point| (b - a).perp_dot(point - a))
        });
        Self::new(common)
    }

    /// A polygon of at most `sides` sides (at least 4) around it: sides are taken out one by one, always the one
    /// without which least area is added on the film of a valid bend. On the base film an added corner of no area may lie
    /// where a bent film is spread widest.
    pub fn simplified(&self, sides: usize, bend: DVec2) -> Self {
        if self.points.len() <= sides.max(4) {
            return self.clone();
        }
        let mut image = Vec::with_capacity(self.points.len());
        self.project_into(bend, &mut image);
        let (low, high) = self.widths(bend);
        // w = 1 ÷ (1 − k · v).
        let keeps_width = |corner: DVec2| {
            let width = 1.0 / (1.0 - bend.dot(corner));
            width > 0.5 * low && width < 2.0 * high
        };
        while image.len() > sides.max(4) {
            let count = image.len();
            let candidates = (0..count).filter_map(|index| {
                let [a, b, c, d] = [0, 1, 2, 3].map(|step| image[(index + step) % count]);
                // a b and d c, made longer beyond b and c, meet at b + t (b − a).
                let cross = (b - a).perp_dot(d - c);
                let share = (c - b).perp_dot(d - c) / cross;
                let corner = b + (b - a) * share;
                let added = (corner - b).perp_dot(c - corner);
                (cross > 0.0 && share >= 0.0 && keeps_width(corner)).then_some((added, index, corner))
            });
            let Some((_, index, corner)) = candidates.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                break;
            };
            image[(index + 1) % count] = corner;
            image.remove((index + 2) % count);
        }
        Self {
            points: image.into_iter().map(|point| point / (1.0 - bend.dot(point))).collect(),
        }
    }

    /// Whether a bend keeps w > 0 on the hull, by a margin relative to its greatest w.
    pub fn is_valid(&self, bend: DVec2) -> bool {
        let (low, high) = self.widths(bend);
        low > LEAST_WIDTH * high
    }

    /// Least and greatest w on the hull.
    pub fn widths(&self, bend: DVec2) -> (f64, f64) {
        let widths = self.points.iter().map(|point| 1.0 + bend.dot(*point));
        widths.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), w| {
            (low.min(w), high.max(w))
        })
    }

    /// The hull on the film v = u ÷ w.
    pub(super) fn project_into(&self, bend: DVec2, image: &mut Vec<DVec2>) {
        image.clear();
        image.extend(self.points.iter().map(|point| point / (1.0 + bend.dot(*point))));
    }

    /// Area and moments of the hull's image, by the sums over the triangles from the origin to its sides.
    pub(super) fn image_area(image: &[DVec2]) -> ImageArea {
        let (mut double, mut first, mut square) = (0.0, DVec2::ZERO, DMat2::ZERO);
        for (a, b) in image.iter().zip(image.iter().cycle().skip(1)) {
            let cross = a.perp_dot(*b);
            let sum = *a + *b;
            double += cross;
            first += sum * cross;
            // ∫ v vᵀ over a triangle (0, a, b) is cross ÷ 24 · (a aᵀ + b bᵀ + (a + b)(a + b)ᵀ).
            for part in [*a, *b, sum] {
                square += DMat2::from_cols(part * part.x, part * part.y) * cross;
            }
        }
        ImageArea {
            total: double * 0.5,
            mean: first / (3.0 * double),
            square: square * (1.0 / (12.0 * double)),
        }
    }
}

/// The part of a convex polygon where a linear function is not negative.
pub(super) fn clip_polygon(polygon: &[DVec2], excess: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut part = Vec::with_capacity(polygon.len() + 1);
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (at_a, at_b) = (excess(*a), excess(*b));
        if at_a >= 0.0 {
            part.push(*a);
        }
        if (at_a >= 0.0) != (at_b >= 0.0) {
            part.push(*a + (*b - *a) * (at_a / (at_a - at_b)));
        }
    }
    part
}
