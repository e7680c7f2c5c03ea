//! [`FilmPartition`]: several films for one light, and the texels that each deserves.

use bevy_math::{DVec2, DVec3};

use super::{BaseFilm, Film, FilmError, FilmHull, FilmMoments, FilmObjective, FilmProblem, FilmSample};
use crate::maths::{
    error::LargestErrors,
    storage::{Packing, SizeLimits, fill_atlas},
};

/// Samples that share a map: everything about them that can be added up.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmBin {
    /// Sums over the samples.
    pub moments: FilmMoments,
    /// Points whose convex hull has to be covered.
    pub points: Vec<DVec2>,
    /// Least and greatest view depth; the first exceeds the second when there is none.
    pub depths: [f64; 2],
    /// Points that were left when the others were last sorted out.
    settled: usize,
}

/// Points from which on a bin keeps their hull only: so many more than the last hull had, and as many again.
const MANY_POINTS: usize = 64;

impl Default for FilmBin {
    fn default() -> Self {
        Self {
            moments: FilmMoments::default(),
            points: Vec::new(),
            depths: [f64::INFINITY, f64::NEG_INFINITY],
            settled: 0,
        }
    }
}

impl FilmBin {
    /// All of these samples.
    pub fn of_samples<'a>(samples: impl IntoIterator<Item = &'a FilmSample>) -> Self {
        let mut bin = Self::default();
        for sample in samples {
            bin.add(sample, 1.0, &sample.corners, sample.depths);
        }
        bin
    }

    /// A share of a sample, with the points of the film that it brings and its view depths.
    pub(super) fn add(&mut self, sample: &FilmSample, share: f64, points: &[DVec2], depths: [f64; 2]) {
        self.moments += FilmMoments::of(&FilmSample {
            pixels: sample.pixels * share,
            ..*sample
        });
        self.extend(points, depths);
    }

    /// Adds what another bin holds.
    pub fn merge(&mut self, other: &Self) {
        self.moments += other.moments;
        self.extend(&other.points, other.depths);
    }

    /// Adds what must be covered, and nothing to the sums.
    pub(super) fn extend(&mut self, points: &[DVec2], depths: [f64; 2]) {
        self.points.extend_from_slice(points);
        self.depths = [self.depths[0].min(depths[0]), self.depths[1].max(depths[1])];
        if self.points.len() >= MANY_POINTS + 2 * self.settled
            && let Ok(hull) = FilmHull::new(self.points.iter().copied())
        {
            self.points = hull.points().to_vec();
            self.settled = self.points.len();
        }
    }

    /// Moves the outline of what has to be covered outwards by a distance on the film: for lookups beside a point.
    pub(super) fn dilate(&mut self, distance: f64) {
        if distance > 0.0
            && let Ok(hull) = FilmHull::new(self.points.iter().copied())
        {
            self.points = hull.dilated(distance).points().to_vec();
        }
    }

    /// Cuts off what lies outside of a hull, as far as that leaves an area.
    pub(super) fn clip(&mut self, outer: &FilmHull) {
        if let Ok(hull) = FilmHull::new(self.points.iter().copied()).and_then(|hull| hull.intersection(outer)) {
            self.points = hull.points().to_vec();
        }
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        !(self.moments.pixels > 0.0)
    }

    /// The problem of one film for all of it.
    pub fn problem(&self, objective: FilmObjective) -> Result<FilmProblem, FilmError> {
        FilmProblem::new(&self.moments, &FilmHull::new(self.points.iter().copied())?, objective)
    }

    /// √e of the film at the balanced bend: what allocation and merging go by. Zero without samples, or without a film.
    pub(super) fn need(&self, objective: FilmObjective) -> f64 {
        let problem = (!self.is_empty()).then(|| self.problem(objective).ok()).flatten();
        problem
            .and_then(|problem| problem.balanced())
            .map_or(0.0, |film| film.error.sqrt())
    }
}

/// One of several films.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmFrustum {
    /// The film.
    pub film: Film,
    /// What it covers.
    pub hull: FilmHull,
    /// Least and greatest view depth of what it covers.
    pub depths: [f64; 2],
}

impl FilmFrustum {
    /// The film of least error for a bin.
    pub fn of_bin(bin: &FilmBin, objective: FilmObjective, proposals: &[DVec2]) -> Result<Self, FilmError> {
        let problem = bin.problem(objective)?;
        Ok(Self {
            film: problem.solve(proposals)?,
            hull: problem.hull().clone(),
            depths: bin.depths,
        })
    }
}

/// Films that share a budget of texels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmPartition {
    /// The films.
    pub frusta: Vec<FilmFrustum>,
}

impl FilmPartition {
    /// The share of the budget that each film deserves: proportional to √e.
    ///
    /// Films with n_i texels have the error Σ e_i ÷ n_i (Chong, section 3.2, with texels of two dimensions: both metrics
    /// fall with the *number* of texels). For a fixed Σ n_i that is least where e_i ÷ n_i² is the same for all.
    pub fn shares(&self) -> Vec<f64> {
        let total = self.needs().sum::<f64>();
        self.needs().map(|need| need / total).collect()
    }

    fn needs(&self) -> impl Iterator<Item = f64> {
        self.frusta.iter().map(|frustum| frustum.film.error.sqrt())
    }

    /// The metric's mean over all pixels with the best allocation of a budget: (Σ √e_i)² ÷ (budget · |Ω|).
    pub fn mean_error(&self, texels: f64) -> f64 {
        let pixels: f64 = self.frusta.iter().map(|frustum| frustum.film.pixels).sum();
        self.needs().sum::<f64>().powi(2) / (texels * pixels)
    }

    /// The same for given numbers of texels.
    pub fn mean_error_of(&self, texels: &[f64]) -> f64 {
        let pixels: f64 = self.frusta.iter().map(|frustum| frustum.film.pixels).sum();
        let errors = self.frusta.iter().zip(texels);
        errors.map(|(frustum, texels)| frustum.film.error / texels).sum::<f64>() / pixels
    }

    /// Needs in the form in which [`allocate`](crate::maths::storage::allocate) takes them: it gives every map texels in
    /// proportion to across · along = √e, with sides in the proportion across ÷ along = n_x ÷ n_y.
    pub fn needed_sizes(&self) -> Vec<LargestErrors> {
        let frusta = self.frusta.iter();
        let sizes = frusta.map(|FilmFrustum { film, .. }| LargestErrors {
            across: (film.error.sqrt() * film.aspect).sqrt(),
            along: (film.error.sqrt() / film.aspect).sqrt(),
        });
        sizes.collect()
    }

    /// Sizes and places of all maps in a square atlas.
    pub fn fill_atlas(&self, side: u32, limits: &SizeLimits) -> Packing {
        fill_atlas(&self.needed_sizes(), side, limits)
    }

    /// The order by view depth, if there is one: see [`depth_order`].
    pub fn depth_order(&self) -> Option<Vec<usize>> {
        let depths: Vec<[f64; 2]> = self.frusta.iter().map(|frustum| frustum.depths).collect();
        depth_order(&depths)
    }

    /// The first film whose map contains a point of the world.
    pub fn containing(&self, base: &BaseFilm, point: DVec3) -> Option<usize> {
        let film = base.film(point)?;
        let inside = |frustum: &FilmFrustum| {
            let place = frustum.film.place(film);
            place.is_some_and(|place| place.min_element() >= 0.0 && place.max_element() <= 1.0)
        };
        self.frusta.iter().position(inside)
    }
}

/// Overlap of view depths that counts as none, relative to the greater depth.
const DEPTH_SLACK: f64 = 1.0e-9;

/// Indices from near to far, when no interval of view depth overlaps another; `None` when some do. Only then can maps be
/// chosen by view depth alone, as Bevy's cascades are: films that divide the light plane mostly overlap in depth, films of
/// [`slice_by_depth`](super::slice_by_depth) never do.
pub fn depth_order(depths: &[[f64; 2]]) -> Option<Vec<usize>> {
    let mut order: Vec<usize> = (0..depths.len()).collect();
    order.sort_by(|a, b| depths[*a][0].total_cmp(&depths[*b][0]));
    let apart = order.windows(2).all(|pair| {
        let (end, start) = (depths[pair[0]][1], depths[pair[1]][0]);
        end <= start + DEPTH_SLACK * end.abs().max(start.abs())
    });
    apart.then_some(order)
}
