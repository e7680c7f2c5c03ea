//! [`FilmTiles`]: a grid over the base film whose tiles are merged into rectangles, each with a film of its own.

use std::collections::HashMap;

use bevy_math::{DVec2, USizeVec2};

use super::{
    Film, FilmBin, FilmBlock, FilmError, FilmFrustum, FilmHull, FilmObjective, FilmPartition, FilmSample,
    hull::clip_polygon,
};

/// When to stop merging (Chong, section 3.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MergeLimits {
    /// The most films.
    pub frusta: usize,
    /// The relative gain that pays for one more film; with less, merging goes on below the limit.
    pub pass_cost: f64,
}

impl Default for MergeLimits {
    /// Two or three films bring most of the gain in the thesis; 3 % is about what another pass over the casters costs
    /// in resolution elsewhere.
    fn default() -> Self {
        Self {
            frusta: 3,
            pass_cost: 0.03,
        }
    }
}

/// First tile and the one beyond the last, along both axes.
pub(super) type TileRect = [USizeVec2; 2];

/// Samples sorted into a grid of tiles over the base film or over another one; tiles at the border have no end.
///
/// k means the same in every tile, so that their sums need no rescaling: unlike the sub-frusta of flatland.
#[derive(Clone, Debug)]
pub struct FilmTiles {
    pub(super) size: USizeVec2,
    ground: Option<Film>,
    bins: Vec<FilmBin>,
}

/// Where a point of the base film lies in the grid, 0..1 along both axes: (u + 1) ÷ 2, or (ξ, η) of a film; and its w.
fn grid_place(ground: Option<&Film>, film: DVec2) -> (DVec2, f64) {
    match ground {
        None => (film * 0.5 + 0.5, 1.0),
        Some(ground) => {
            let width = 1.0 + ground.bend.dot(film);
            (ground.frame.place(film / width), width)
        }
    }
}

impl FilmTiles {
    /// A grid of so many tiles along both axes over the base film, −1..1; 8 × 8 are plenty.
    pub fn new(size: USizeVec2) -> Self {
        Self::over(size, None)
    }

    /// A grid over a film, 0..1 of (ξ, η), that must be valid wherever something is added.
    ///
    /// On the base film of a large scene nearly all that is seen lies in one tile, before the camera's feet. The film that is
    /// best for all of it spreads the pixels evenly, and so its tiles. Its tiles are quadrangles of the base film, which
    /// need no other algebra: their borders are straight.
    pub fn over(size: USizeVec2, ground: Option<Film>) -> Self {
        let size = size.max(USizeVec2::ONE);
        Self {
            size,
            ground,
            bins: vec![FilmBin::default(); size.element_product()],
        }
    }

    /// Adds a block of a camera's picture: its sample to the tile in which the sample lies, and all that it covers to all
    /// tiles that it reaches into.
    pub fn add_block(&mut self, block: &FilmBlock) {
        if let Some(sample) = &block.sample {
            let tile = self.tile_of(sample.film);
            self.bin(tile).add(sample, 1.0, &[], sample.depths);
        }
        self.cover(&block.points(), block.depths);
    }

    /// Adds the hull of some points to what has to be covered in all tiles that it reaches into.
    pub fn cover(&mut self, points: &[DVec2], depths: [f64; 2]) {
        let tiles = || points.iter().map(|point| self.tile_of(*point));
        let first = tiles().reduce(USizeVec2::min).unwrap_or_default();
        let last = tiles().reduce(USizeVec2::max).unwrap_or_default();
        if first == last {
            return self.bin(first).extend(points, depths);
        }
        let Ok(hull) = FilmHull::new(points.iter().copied()) else {
            // One ray, or one plane of light.
            for point in points {
                let tile = self.tile_of(*point);
                self.bin(tile).extend(&[*point], depths);
            }
            return;
        };
        for row in first.y..=last.y {
            for column in first.x..=last.x {
                let tile = USizeVec2::new(column, row);
                let part = self.part_inside(hull.points(), tile);
                if !part.is_empty() {
                    self.bin(tile).extend(&part, depths);
                }
            }
        }
    }

    /// Moves the outlines of all tiles outwards by a distance on the base film.
    pub fn dilate(&mut self, distance: f64) {
        for bin in &mut self.bins {
            bin.dilate(distance);
        }
    }

    fn tile_of(&self, film: DVec2) -> USizeVec2 {
        tile_at(self.size, grid_place(self.ground.as_ref(), film).0)
    }

    /// Adds a sample: its pixel is cut at the borders of the tiles, so that films of neighbouring tiles meet without a gap
    /// and nothing counts twice.
    pub fn add(&mut self, sample: &FilmSample) {
        let corners = sample.corners.map(|corner| self.tile_of(corner));
        let first = corners.iter().copied().reduce(USizeVec2::min).unwrap_or_default();
        let last = corners.iter().copied().reduce(USizeVec2::max).unwrap_or_default();
        let whole = doubled_area(&sample.corners);
        if first == last || !(whole > 0.0) {
            let tile = self.tile_of(sample.film);
            return self.bin(tile).add(sample, 1.0, &sample.corners, sample.depths);
        }
        for row in first.y..=last.y {
            for column in first.x..=last.x {
                let tile = USizeVec2::new(column, row);
                let part = self.part_inside(&sample.corners, tile);
                let share = doubled_area(&part) / whole;
                if share > 0.0 {
                    self.bin(tile).add(sample, share, &part, sample.depths);
                }
            }
        }
    }

    fn bin(&mut self, tile: USizeVec2) -> &mut FilmBin {
        &mut self.bins[tile.y * self.size.x + tile.x]
    }

    /// The part of a convex polygon that lies in a tile.
    fn part_inside(&self, polygon: &[DVec2], tile: USizeVec2) -> Vec<DVec2> {
        let border = |index: USizeVec2| index.as_dvec2() / self.size.as_dvec2();
        let (low, high) = (border(tile), border(tile + 1));
        // Times w a place is linear in the point.
        let beyond = |point: DVec2, border: f64, axis: usize| {
            let (place, width) = grid_place(self.ground.as_ref(), point);
            (place[axis] - border) * width
        };
        let mut part = polygon.to_vec();
        for axis in 0..2 {
            if tile[axis] > 0 {
                part = clip_polygon(&part, |point| beyond(point, low[axis], axis));
            }
            if tile[axis] + 1 < self.size[axis] {
                part = clip_polygon(&part, |point| -beyond(point, high[axis], axis));
            }
        }
        part
    }

    pub(super) fn gathered(&self, [first, end]: TileRect) -> FilmBin {
        let mut gathered = FilmBin::default();
        for row in first.y..end.y {
            for bin in &self.bins[row * self.size.x + first.x..row * self.size.x + end.x] {
                gathered.merge(bin);
            }
        }
        gathered
    }

    /// Whether every tile with samples lies in one of the rectangles.
    pub(super) fn are_all_in(&self, rects: &[TileRect]) -> bool {
        let mut filled = (0..self.bins.len()).filter(|index| !self.bins[*index].is_empty());
        filled.all(|index| {
            let tile = self.tile(index);
            rects.iter().any(|rect| is_inside(&[tile, tile + 1], rect))
        })
    }

    /// Merges tiles until the limits hold, and solves for the film of each rectangle. [`FilmTiles::cut`] is better and
    /// slower.
    ///
    /// Greedy (Chong, section 3.2, Algorithm 2, with the data gathered anew for every candidate and every decision made by
    /// the candidate's own film; the printed listing reuses both): of all pairs of neighbours the one is merged after which
    /// the total (Σ √e)² is least. What is merged is the rectangle around the pair, with all rectangles that it cuts, so
    /// that films stay rectangles of tiles: the thesis's quad-tree is one way to that, and it can never be stuck. Tiles
    /// without samples cost nothing and belong to nobody. Errors are those of balanced bends.
    pub fn merged(
        &self,
        limits: &MergeLimits,
        objective: FilmObjective,
    ) -> Result<(FilmPartition, TileOwners), FilmError> {
        let mut known: HashMap<TileRect, f64> = HashMap::new();
        let mut need = |rect: TileRect| *known.entry(rect).or_insert_with(|| self.gathered(rect).need(objective));
        let mut rects: Vec<TileRect> = (0..self.bins.len())
            .filter(|index| !self.bins[*index].is_empty())
            .map(|index| [self.tile(index), self.tile(index) + 1])
            .collect();
        if rects.is_empty() {
            return Err(FilmError::NothingVisible);
        }
        while rects.len() > 1 {
            let needs: Vec<f64> = rects.iter().map(|rect| need(*rect)).collect();
            let total: f64 = needs.iter().sum();
            let candidates = neighbours(&rects).into_iter().map(|pair| {
                let rect = grown(&rects, around(rects[pair[0]], rects[pair[1]]));
                let swallowed = rects.iter().zip(&needs).filter(|(other, _)| is_inside(other, &rect));
                let sum = total - swallowed.map(|(_, need)| need).sum::<f64>() + need(rect);
                (sum, rect)
            });
            let Some((sum, rect)) = candidates.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                break;
            };
            let gain = 1.0 - (total / sum).powi(2);
            if rects.len() <= limits.frusta.max(1) && gain > limits.pass_cost {
                break;
            }
            rects.retain(|other| !is_inside(other, &rect));
            rects.push(rect);
        }
        self.partitioned(rects, objective)
    }

    /// The films of rectangles of tiles, in the order of their first tiles.
    pub(super) fn partitioned(
        &self,
        mut rects: Vec<TileRect>,
        objective: FilmObjective,
    ) -> Result<(FilmPartition, TileOwners), FilmError> {
        sort_rects(&mut rects);
        let frusta = rects
            .iter()
            .map(|rect| FilmFrustum::of_bin(&self.gathered(*rect), objective, &[]))
            .collect::<Result<_, _>>()?;
        let owner = |tile| rects.iter().position(|rect| is_inside(&[tile, tile + 1], rect));
        let owners = TileOwners {
            size: self.size,
            ground: self.ground,
            owners: (0..self.bins.len()).map(|index| owner(self.tile(index))).collect(),
        };
        Ok((FilmPartition { frusta }, owners))
    }

    fn tile(&self, index: usize) -> USizeVec2 {
        USizeVec2::new(index % self.size.x, index / self.size.x)
    }
}

/// Which film each tile belongs to: the lookup of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct TileOwners {
    /// Tiles along both axes.
    pub size: USizeVec2,
    /// The film that the tiles divide; `None`: the base film.
    pub ground: Option<Film>,
    /// Row by row the index of the film, `None` where there were no samples.
    pub owners: Vec<Option<usize>>,
}

impl TileOwners {
    /// The film of a point of the base film.
    pub fn owner(&self, film: DVec2) -> Option<usize> {
        let place = tile_at(self.size, grid_place(self.ground.as_ref(), film).0);
        self.owners[place.y * self.size.x + place.x]
    }
}

/// The tile of a place in 0..1.
fn tile_at(size: USizeVec2, place: DVec2) -> USizeVec2 {
    let tiles = size.as_dvec2();
    (place * tiles).clamp(DVec2::ZERO, tiles - 1.0).as_usizevec2()
}

/// By their first tiles, row by row.
pub(super) fn sort_rects(rects: &mut [TileRect]) {
    rects.sort_by_key(|[first, _]| (first.y, first.x));
}

/// Twice the area of a polygon, whichever way it turns.
fn doubled_area(polygon: &[DVec2]) -> f64 {
    let pairs = polygon.iter().zip(polygon.iter().cycle().skip(1));
    pairs.map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs()
}

fn around(a: TileRect, b: TileRect) -> TileRect {
    [a[0].min(b[0]), a[1].max(b[1])]
}

fn is_inside(inner: &TileRect, outer: &TileRect) -> bool {
    inner[0].cmpge(outer[0]).all() && inner[1].cmple(outer[1]).all()
}

/// The rectangle, grown until it cuts no other.
fn grown(rects: &[TileRect], mut rect: TileRect) -> TileRect {
    loop {
        let cut = rects.iter().find(|other| {
            let meets = other[0].cmplt(rect[1]).all() && other[1].cmpgt(rect[0]).all();
            meets && !is_inside(other, &rect)
        });
        match cut {
            Some(other) => rect = around(rect, *other),
            None => return rect,
        }
    }
}

/// Pairs of rectangles that touch; all pairs when none do.
fn neighbours(rects: &[TileRect]) -> Vec<[usize; 2]> {
    let pairs = (0..rects.len()).flat_map(|a| (a + 1..rects.len()).map(move |b| [a, b]));
    let touch = |[a, b]: &[usize; 2]| {
        let (a, b) = (rects[*a], rects[*b]);
        let overlap = a[1].min(b[1]).as_ivec2() - a[0].max(b[0]).as_ivec2();
        overlap.min_element() >= 0 && overlap.max_element() > 0
    };
    let touching: Vec<[usize; 2]> = pairs.clone().filter(touch).collect();
    if touching.is_empty() { pairs.collect() } else { touching }
}
