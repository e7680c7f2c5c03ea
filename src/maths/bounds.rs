//! [`Bounds`]: axis-aligned boxes of the scene S, its casters and its receivers.

use bevy_math::DVec3;

/// An axis-aligned box in world space, in metres. S of the papers is the box of the whole scene.
///
/// Empty when `min` exceeds `max` on an axis; see [`Bounds::EMPTY`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: DVec3,
    /// Largest coordinates.
    pub max: DVec3,
}

impl Default for Bounds {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Bounds {
    /// Contains nothing; the neutral element of [`Bounds::union`].
    pub const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The box between two opposite corners, `min` being the smaller on every axis.
    pub const fn new(min: DVec3, max: DVec3) -> Self {
        Self { min, max }
    }

    /// The smallest box around points; [`Bounds::EMPTY`] for none.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| Self {
            min: bounds.min.min(point),
            max: bounds.max.max(point),
        })
    }

    /// True when it contains no point. A box with a NaN corner counts as empty too.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The box grown by `margin` metres on every side.
    pub fn expanded(&self, margin: f64) -> Self {
        Self {
            min: self.min - margin,
            max: self.max + margin,
        }
    }

    /// The middle.
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// Lengths of the sides.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// True when the point is inside or on the surface, give or take `tolerance` metres.
    pub fn contains(&self, point: DVec3, tolerance: f64) -> bool {
        point.cmpge(self.min - tolerance).all() && point.cmple(self.max + tolerance).all()
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|index| {
            DVec3::new(
                if index & 1 == 0 { self.min.x } else { self.max.x },
                if index & 2 == 0 { self.min.y } else { self.max.y },
                if index & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }
}
