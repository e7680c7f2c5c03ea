//! [`FilmFrame`]: the rectangle or parallelogram of a film that becomes the map.

use bevy_math::{DMat2, DVec2};

/// What outlines a film may have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum FilmShape {
    /// A rectangle in v, turned in its plane. Texels are rectangles on the ray u = 0 only, since a bent film shears them
    /// everywhere else; so it depends on the middle of the base film what a rectangle is.
    Rectangle,
    /// A parallelogram. A projection shears for nothing, so this is never worse. What counts as one does not depend on the
    /// base film, and one plane that fills the picture fills the map only with it.
    #[default]
    Parallelogram,
}

/// A parallelogram on the film v: corner + sides · (ξ, η) with ξ and η from 0 to 1 over the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmFrame {
    /// Where ξ = η = 0.
    pub corner: DVec2,
    /// E: its sides as columns. Never mirrored.
    pub sides: DMat2,
}

/// Sine of the angle between two edges of the hull below which they make no parallelogram.
const LEAST_SINE: f64 = 0.05;

impl FilmFrame {
    /// The frame of least cost around a convex polygon, and its cost; `cost` is a function of the sides E.
    ///
    /// Tried are all rectangles with a side along an edge of the polygon, or all parallelograms with sides along two edges.
    /// The least *area* is always among them (Freeman and Shapira 1975 for rectangles, Schwarz et al. 1995 for
    /// parallelograms); for other costs they are candidates. `None` for polygons without area.
    pub fn around(polygon: &[DVec2], shape: FilmShape, cost: impl Fn(&DMat2) -> f64) -> Option<(Self, f64)> {
        let mut best: Option<(DMat2, f64)> = None;
        let mut propose = |sides: DMat2| {
            let cost = cost(&sides);
            if cost.is_finite() && best.is_none_or(|(_, least)| cost < least) {
                best = Some((sides, cost));
            }
        };
        let edges = || polygon.iter().zip(polygon.iter().cycle().skip(1));
        let directions = edges().filter_map(|(a, b)| Some((*a, (b - a).try_normalize()?)));
        match shape {
            FilmShape::Rectangle => {
                for (_, along) in directions {
                    let up = along.perp();
                    let extent = |axis: DVec2| {
                        let places = || polygon.iter().map(|point| axis.dot(*point));
                        places().fold(f64::NEG_INFINITY, f64::max) - places().fold(f64::INFINITY, f64::min)
                    };
                    propose(DMat2::from_cols(along * extent(along), up * extent(up)));
                }
            }
            FilmShape::Parallelogram => {
                // How far the polygon reaches from each edge.
                let reaching: Vec<(DVec2, f64)> = directions
                    .map(|(from, along)| {
                        let reaches = polygon.iter().map(|point| along.perp_dot(point - from));
                        (along, reaches.fold(0.0, f64::max))
                    })
                    .collect();
                for (index, (first, first_reach)) in reaching.iter().enumerate() {
                    for (second, second_reach) in &reaching[index + 1..] {
                        let sine = first.perp_dot(*second);
                        if sine.abs() >= LEAST_SINE {
                            let along_first = first * (second_reach / sine.abs());
                            let along_second = second * (first_reach / sine);
                            propose(DMat2::from_cols(along_first, along_second));
                        }
                    }
                }
            }
        }
        let (sides, cost) = best?;
        Some((Self::placed(upright(sides), polygon), cost))
    }

    /// The frame with sides of these directions that touches a polygon on all four.
    pub(super) fn placed(sides: DMat2, polygon: &[DVec2]) -> Self {
        let map_from_film = sides.inverse();
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in polygon {
            let place = map_from_film * *point;
            (low, high) = (low.min(place), high.max(place));
        }
        let size = high - low;
        Self {
            corner: sides * low,
            sides: DMat2::from_cols(sides.x_axis * size.x, sides.y_axis * size.y),
        }
    }

    /// Area on the film.
    pub fn area(&self) -> f64 {
        self.sides.determinant()
    }

    /// (ξ, η) of a point of the film.
    pub fn place(&self, film: DVec2) -> DVec2 {
        self.sides.inverse() * (film - self.corner)
    }
}

/// Of the four ways to begin counting the sides, the one whose first side looks most along +x: the map does not turn by a
/// quarter when the polygon's edges change.
fn upright(sides: DMat2) -> DMat2 {
    let (a, b) = (sides.x_axis, sides.y_axis);
    let turns = [(a, b), (b, -a), (-a, -b), (-b, a)];
    let slant = |(first, second): &(DVec2, DVec2)| {
        let lean = |along: DVec2, axis: DVec2| along.normalize_or_zero().dot(axis);
        lean(*first, DVec2::X) + lean(*second, DVec2::Y)
    };
    let upright = turns.into_iter().max_by(|a, b| slant(a).total_cmp(&slant(b)));
    upright.map_or(sides, |(first, second)| DMat2::from_cols(first, second))
}
