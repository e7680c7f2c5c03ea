//! [`slice_by_depth`]: films for intervals of view depth, which any renderer of cascades can use.

use bevy_math::DVec2;

use super::{FilmBin, FilmBlock, FilmError, FilmFrustum, FilmObjective, FilmPartition, FilmSample, tiles::MergeLimits};

/// Samples sorted into intervals of view depth, evenly in its logarithm.
#[derive(Clone, Debug)]
pub struct DepthSlices {
    near: f64,
    far: f64,
    bins: Vec<FilmBin>,
}

impl DepthSlices {
    /// So many slices between two view depths of a perspective camera, or `None` if there is nothing between them.
    pub fn new(count: usize, near: f64, far: f64) -> Option<Self> {
        (count > 0 && near > 0.0 && far > near && far.is_finite()).then(|| Self {
            near,
            far,
            bins: vec![FilmBin::default(); count],
        })
    }

    /// View depth at which a slice begins; `index` may be the number of slices.
    pub fn start(&self, index: usize) -> f64 {
        self.near * (self.far / self.near).powf(index as f64 / self.bins.len() as f64)
    }

    /// Adds a sample: to each slice that its pixel reaches into the part that lies there, and to all of them its corners,
    /// so that no film ends inside a pixel. Depths outside count to the ends.
    pub fn add(&mut self, sample: &FilmSample) {
        let count = self.bins.len();
        let place = |depth: f64| {
            let share = (depth / self.near).ln() / (self.far / self.near).ln();
            (share * count as f64).clamp(0.0, count as f64 * (1.0 - f64::EPSILON))
        };
        let [low, high] = sample.depths.map(place);
        let (first, last) = (low as usize, high as usize);
        let starts: Vec<f64> = (first..=last + 1).map(|index| self.start(index)).collect();
        for (index, ends) in (first..=last).zip(starts.windows(2)) {
            let inside = high.min(index as f64 + 1.0) - low.max(index as f64);
            let share = if last > first { inside / (high - low) } else { 1.0 };
            let [near, far] = sample.depths;
            let near = if index > first { ends[0] } else { near };
            let far = if index < last { ends[1] } else { far };
            self.bins[index].add(sample, share, &sample.corners, [near, far]);
        }
    }

    /// Adds a block of a camera's picture: to each slice the part that lies there. Depths outside count to the ends.
    pub fn add_block(&mut self, block: &FilmBlock) {
        let count = self.bins.len();
        for index in 0..count {
            let near = if index == 0 {
                f64::NEG_INFINITY
            } else {
                self.start(index)
            };
            let far = if index + 1 == count {
                f64::INFINITY
            } else {
                self.start(index + 1)
            };
            let Some(part) = block.between(near, far) else {
                continue;
            };
            if let Some(sample) = &part.sample {
                self.bins[index].add(sample, 1.0, &[], sample.depths);
            }
            self.bins[index].extend(&part.points(), part.depths);
        }
    }

    /// Adds the hull of some points to what has to be covered in a slice.
    pub fn cover(&mut self, index: usize, points: &[DVec2]) {
        let depths = [self.start(index), self.start(index + 1)];
        self.bins[index].extend(points, depths);
    }

    /// Moves the outlines of all slices outwards by a distance on the base film.
    pub fn dilate(&mut self, distance: f64) {
        for bin in &mut self.bins {
            bin.dilate(distance);
        }
    }

    /// The samples of a run of slices.
    pub(super) fn run(&self, start: usize, end: usize) -> FilmBin {
        let mut run = FilmBin::default();
        for bin in &self.bins[start..end] {
            run.merge(bin);
        }
        run
    }
}

/// Films for intervals of view depth, at most as many as the limits allow: always in order of view depth.
///
/// The total error with the best allocation is (Σ √e_i)², so the best intervals are a shortest path: with
/// D[j, b] = min_i D[i, b − 1] + √e(i, j) the intervals are exactly the best of all that begin and end at slices, in the
/// error of balanced bends. In flatland more films never hurt; here films of neighbouring slices overlap on the light
/// plane, so that fewer films than allowed may be better. A film has to gain [`MergeLimits::pass_cost`].
pub fn slice_by_depth(
    slices: &DepthSlices,
    limits: &MergeLimits,
    objective: FilmObjective,
) -> Result<FilmPartition, FilmError> {
    let runs = best_runs(slices, limits, objective)?;
    let films = runs
        .into_iter()
        .map(|[start, end]| FilmFrustum::of_bin(&slices.run(start, end), objective, &[]));
    Ok(FilmPartition {
        frusta: films.collect::<Result<_, _>>()?,
    })
}

/// First slice and the one beyond the last of the films of [`slice_by_depth`], near to far, those without samples left out.
pub(super) fn best_runs(
    slices: &DepthSlices,
    limits: &MergeLimits,
    objective: FilmObjective,
) -> Result<Vec<[usize; 2]>, FilmError> {
    let count = slices.bins.len();
    let needs: Vec<Vec<f64>> = (0..count)
        .map(|start| {
            (start + 1..=count)
                .map(|end| slices.run(start, end).need(objective))
                .collect()
        })
        .collect();
    let need = |start: usize, end: usize| needs[start][end - start - 1];
    // Per number of films: for every end, least sum of needs and the start of the last film.
    let mut tables: Vec<Vec<(f64, usize)>> = vec![(1..=count).map(|end| (need(0, end), 0)).collect()];
    for _ in 1..limits.frusta.clamp(1, count) {
        let before = &tables[tables.len() - 1];
        let ends = 1..=count;
        let table = ends.map(|end| {
            let sums = (1..end).map(|start| (before[start - 1].0 + need(start, end), start));
            sums.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0))
        });
        let table = table.collect();
        tables.push(table);
    }
    let mut films = 1;
    for more in 2..=tables.len() {
        let total = |films: usize| tables[films - 1][count - 1].0.powi(2);
        if total(more) < total(films) * (1.0 - limits.pass_cost).powi((more - films) as i32) {
            films = more;
        }
    }
    let mut runs = Vec::with_capacity(films);
    let mut end = count;
    for table in tables[..films].iter().rev() {
        let start = table[end - 1].1;
        if !slices.run(start, end).is_empty() {
            runs.push([start, end]);
        }
        end = start;
    }
    runs.reverse();
    if runs.is_empty() {
        return Err(FilmError::NothingVisible);
    }
    Ok(runs)
}
