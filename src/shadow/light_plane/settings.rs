//! [`LightPlanes`]: what is asked of films.

use bevy::prelude::*;

use crate::{
    maths::light_plane::space::{
        Damping, FilmCover, FilmDivision, FilmMetric, FilmObjective, FilmPlanOptions, FilmShape, MapSides, MergeLimits,
    },
    shadow::settings::{ShadowPath, SunShadows},
};

/// Perspective-optimal light planes instead of z-partitions and warps.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Default, Debug, Clone, PartialEq)]
pub struct LightPlanes {
    /// The most films, 1..=8 (drop-in: 1..=4); one that gains less than 3 % is not drawn. Each costs a pass over its casters.
    pub frusta: u32,
    /// What is made small: the mean area of texels in pixels (default), or the mean of their squared sides, which avoids
    /// long thin texels.
    pub metric: FilmMetric,
    /// Outline of the maps: a parallelogram (default) is never worse than a rectangle.
    pub film: FilmShape,
    /// What several films divide: view depth (default), or the light plane.
    pub division: FilmDivision,
    /// What they cover: what was seen (default, with a coarse map for the rest), or all that may be seen.
    pub cover: FilmCover,
    /// Seconds in which the bend of films follows 63 % of a change, 0..=10; 0: at once. Bends that are within 5 % of the
    /// best stay as they are. What films cover follows the picture at once, so that nothing is lost: shadow edges crawl
    /// with it, whatever is said here, and least with [`FilmCover::Body`].
    pub damping: f32,
}

impl Default for LightPlanes {
    fn default() -> Self {
        Self {
            frusta: 1,
            metric: FilmMetric::Area,
            film: FilmShape::Parallelogram,
            division: FilmDivision::Depth,
            cover: FilmCover::Seen,
            damping: Self::DAMPING,
        }
    }
}

impl LightPlanes {
    /// The largest number of films.
    pub const MAX_FRUSTA: u32 = 8;
    /// Seconds of damping when nothing else is said.
    pub const DAMPING: f32 = 0.5;
    /// The longest damping in seconds.
    pub const LONGEST_DAMPING: f32 = 10.0;

    /// Whether a coarse map is drawn for what was not seen.
    #[must_use]
    pub fn has_rest_map(&self) -> bool {
        self.cover == FilmCover::Seen
    }

    /// With every value in range: NaN becomes the default, films of tiles cover what was seen, those of the drop-in path what
    /// may be seen, by view depth.
    #[must_use]
    pub fn checked(&self, path: ShadowPath) -> Self {
        let mut planes = *self;
        planes.damping = if planes.damping.is_nan() {
            Self::DAMPING
        } else {
            planes.damping.clamp(0.0, Self::LONGEST_DAMPING)
        };
        match path {
            ShadowPath::Full => planes.frusta = planes.frusta.clamp(1, Self::MAX_FRUSTA),
            ShadowPath::DropIn => {
                planes.frusta = planes.frusta.clamp(1, SunShadows::MAX_DROP_IN_PARTITIONS);
                planes.division = FilmDivision::Depth;
                planes.cover = FilmCover::Body;
            }
        }
        if planes.division == FilmDivision::Tiles {
            planes.cover = FilmCover::Seen;
        }
        planes
    }

    pub(super) fn plan_options(&self) -> FilmPlanOptions {
        FilmPlanOptions {
            objective: FilmObjective {
                metric: self.metric,
                shape: self.film,
                // One film has a square; several share one.
                map_sides: if self.frusta == 1 {
                    MapSides::Equal
                } else {
                    MapSides::Free
                },
            },
            limits: MergeLimits {
                frusta: self.frusta as usize,
                ..MergeLimits::default()
            },
            division: self.division,
            cover: self.cover,
            damping: match self.damping {
                0.0 => Damping {
                    tolerance: 0.0,
                    settle_seconds: 0.0,
                },
                seconds => Damping {
                    settle_seconds: f64::from(seconds),
                    ..Damping::default()
                },
            },
        }
    }
}
