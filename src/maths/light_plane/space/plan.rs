//! [`plan_films`]: from what a camera sees to the films of its sun.

use bevy_math::{DMat4, DVec2, DVec3, DVec4, USizeVec2};

use super::{
    BaseFilm, Damping, DepthSlices, FilmBin, FilmBlock, FilmError, FilmFrustum, FilmHull, FilmObjective, FilmPartition,
    FilmTiles, MergeLimits, SeenPicture,
    slices::best_runs,
    tiles::{TileRect, sort_rects},
};
use crate::maths::{body::light_visible, bounds::Bounds, fit::LightAxes, view::ViewVolume};

/// How the films of one sun divide what is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum FilmDivision {
    /// By intervals of view depth: [`slice_by_depth`](super::slice_by_depth).
    #[default]
    Depth,
    /// Into rectangles of tiles over the film that is best for all of it: [`FilmTiles::cut`].
    Tiles,
}

/// What a film has to cover.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum FilmCover {
    /// The surfaces that the camera saw: all pixels of them, not only the samples, and where a camera that has moved since
    /// may have them. Nothing is known of what comes into sight in the meantime: it needs another map.
    #[default]
    Seen,
    /// All that the camera may see: nothing is lost, and texels are spent on what is empty of it. Films of tiles cover only
    /// those tiles of it in which something was seen.
    Body,
}

/// The choices of [`plan_films`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmPlanOptions {
    /// What is made small.
    pub objective: FilmObjective,
    /// How many films, and what one has to gain.
    pub limits: MergeLimits,
    /// What they divide.
    pub division: FilmDivision,
    /// What each covers.
    pub cover: FilmCover,
    /// How they follow their optimum from picture to picture.
    pub damping: Damping,
}

/// What [`plan_films`] works from.
#[derive(Clone, Copy, Debug)]
pub struct FilmPlanInput<'a> {
    /// The part of the camera's view volume that gets shadows.
    pub view: &'a ViewVolume,
    /// The box of everything that shadows may fall on.
    pub receivers: &'a Bounds,
    /// Direction in which light travels.
    pub light_travel: DVec3,
    /// What the camera saw, this picture or one before.
    pub picture: &'a SeenPicture,
    /// The camera's matrix now.
    pub clip_from_world: DMat4,
    /// How far around a point lookups go, metres across the light.
    pub margin: f64,
    /// The choices.
    pub options: &'a FilmPlanOptions,
    /// What the plan before left; the default without one.
    pub last: &'a FilmMemory,
    /// Seconds since then.
    pub seconds: f64,
}

/// What is kept from picture to picture, while the same is asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FilmMemory {
    /// What was asked for.
    options: Option<FilmPlanOptions>,
    /// w of every film as a form of world-space points ([`BaseFilm::width_form`]).
    /// `None` for a part that had no film.
    widths: Vec<Option<DVec4>>,
    /// The parts of the films: rectangles of tiles, or runs of slices as rectangles of one row.
    parts: Vec<TileRect>,
}

/// Films for one sun and one camera.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmPlan {
    /// The base film of all.
    pub base: BaseFilm,
    /// The films; near to far where they divide view depth.
    pub partition: FilmPartition,
    /// What damping costs: the total error over that of the optima, less 1.
    pub damping_cost: f64,
    /// One film without a bend over all that the films cover.
    pub unbent: FilmFrustum,
    /// The total error of that film over that of this plan.
    pub gain: f64,
    /// What the next plan goes on from.
    pub memory: FilmMemory,
}

/// Tiles along both axes: all their rectangles are solved for. On 6 × 6 the cut takes five times as long.
const TILES: USizeVec2 = USizeVec2::splat(4);

/// Intervals of view depth: all runs of them are solved for.
const SLICES: usize = 8;

/// Depths of surfaces at the end of the view volume are rounded.
const DEPTH_SLACK: f64 = 1.0e-5;

/// Films for a camera and its sun, from what the camera has seen.
///
/// The sums over samples only steer: what is covered follows from [`FilmCover`] and holds whatever the samples say. The
/// division stays as it was while its error is within the damping's tolerance, so that films do not change places. Nothing
/// stays of films with other options.
///
/// # Errors
/// Nothing seen in the view volume, no area, or numbers that are not finite: a uniform map must do.
pub fn plan_films(input: &FilmPlanInput) -> Result<FilmPlan, FilmError> {
    let FilmPlanOptions {
        objective,
        limits,
        division,
        cover,
        damping,
    } = *input.options;
    let nothing = FilmMemory::default();
    let last = if input.last.options.as_ref() == Some(input.options) {
        input.last
    } else {
        &nothing
    };
    let view = input.view;
    let axes = LightAxes::new(view.forward(), view.up(), input.light_travel).ok_or(FilmError::NotFinite)?;
    let visible = light_visible(view, input.receivers);
    let base = match cover {
        FilmCover::Seen => BaseFilm::of_sun(axes, &positions(input.picture, view))?,
        FilmCover::Body => BaseFilm::of_sun(axes, visible.vertices())?,
    };
    let body: Vec<DVec2> = visible
        .vertices()
        .iter()
        .filter_map(|point| base.film(*point))
        .collect();
    let blocks = blocks(input, &base);
    let margin = input.margin.max(0.0) / base.scale();
    // Flat where light, view and receivers share a plane: then it cuts nothing off.
    let outer = FilmHull::new(body.iter().copied()).map(|hull| hull.dilated(margin));
    let mut whole = FilmBin::of_blocks(&blocks, cover);
    if cover == FilmCover::Body {
        whole.extend(&body, [view.near(), view.far()]);
    }
    whole.dilate(margin);
    if let Ok(outer) = &outer {
        whole.clip(outer);
    }
    let problem = whole.problem(objective)?;
    let whole_depths = whole.depths;
    let unbent = problem.film_at(DVec2::ZERO).ok_or(FilmError::NoArea)?;
    let known = |parts: &[TileRect], need: &mut dyn FnMut(&TileRect) -> f64| {
        let last = &last.parts;
        let total = |parts: &[TileRect], need: &mut dyn FnMut(&TileRect) -> f64| parts.iter().map(need).sum::<f64>();
        let is_kept = !last.is_empty()
            && last.len() <= limits.frusta
            && total(last, need).powi(2) <= total(parts, need).powi(2) * (1.0 + damping.tolerance);
        if is_kept { last.clone() } else { parts.to_vec() }
    };
    let (parts, mut bins): (Vec<TileRect>, Vec<FilmBin>) = match division {
        _ if limits.frusta <= 1 => (Vec::new(), vec![whole]),
        FilmDivision::Tiles => {
            let mut tiles = FilmTiles::over(TILES, problem.balanced());
            for block in &blocks {
                tiles.add_block(block);
            }
            tiles.dilate(margin);
            let mut rects = tiles.cut_rects(&limits, objective)?;
            sort_rects(&mut rects);
            let holds_all = tiles.are_all_in(&last.parts);
            let rects = if holds_all {
                known(&rects, &mut |rect| tiles.gathered(*rect).need(objective))
            } else {
                rects
            };
            let bins = rects.iter().map(|rect| tiles.gathered(*rect)).collect();
            (rects, bins)
        }
        FilmDivision::Depth => {
            let (near, far) = match cover {
                FilmCover::Body => (view.near(), view.far()),
                FilmCover::Seen => depth_range(&blocks),
            };
            let mut slices = DepthSlices::new(SLICES, near, far).ok_or(FilmError::NoArea)?;
            for block in &blocks {
                slices.add_block(block);
            }
            if cover == FilmCover::Body {
                for index in 0..SLICES {
                    let slice = light_visible(
                        &view.split(slices.start(index), slices.start(index + 1)),
                        input.receivers,
                    );
                    let points: Vec<DVec2> = slice.vertices().iter().filter_map(|point| base.film(*point)).collect();
                    slices.cover(index, &points);
                }
            }
            slices.dilate(margin);
            let runs = without_gaps(best_runs(&slices, &limits, objective)?);
            let runs = known(&runs, &mut |run| slices.run(run[0].x, run[1].x).need(objective));
            let bins = runs.iter().map(|run| slices.run(run[0].x, run[1].x)).collect();
            (runs, bins)
        }
    };
    let mut plan = FilmPlan {
        base,
        partition: FilmPartition::default(),
        damping_cost: 0.0,
        unbent: FilmFrustum {
            film: unbent,
            hull: problem.hull().clone(),
            depths: whole_depths,
        },
        gain: 1.0,
        memory: FilmMemory {
            options: Some(*input.options),
            widths: Vec::new(),
            parts,
        },
    };
    let has_memory = last.widths.len() == bins.len();
    let mut optimal_need = 0.0;
    let mut refusal = FilmError::NothingVisible;
    for (index, bin) in bins.iter_mut().enumerate() {
        if let Ok(outer) = &outer {
            bin.clip(outer);
        }
        let last = if has_memory { last.widths[index] } else { None };
        let solved = bin.problem(objective).and_then(|problem| {
            let proposals: Vec<DVec2> = last.and_then(|form| base.bend_of(form)).into_iter().collect();
            let optimum = problem.solve(&proposals)?;
            Ok((
                damping.step(&base, &problem, last, &optimum, input.seconds),
                optimum,
                problem,
            ))
        });
        match solved {
            Ok((damped, optimum, problem)) => {
                optimal_need += optimum.error.sqrt();
                plan.memory.widths.push(Some(base.width_form(damped.film.bend)));
                plan.partition.frusta.push(FilmFrustum {
                    film: damped.film,
                    hull: problem.hull().clone(),
                    depths: bin.depths,
                });
            }
            Err(error) => {
                refusal = error;
                plan.memory.widths.push(None);
            }
        }
    }
    if plan.partition.frusta.is_empty() {
        return Err(refusal);
    }
    let need: f64 = plan
        .partition
        .frusta
        .iter()
        .map(|frustum| frustum.film.error.sqrt())
        .sum();
    plan.damping_cost = ((need / optimal_need).powi(2) - 1.0).max(0.0);
    plan.gain = unbent.error / need.powi(2);
    Ok(plan)
}

impl FilmBin {
    fn of_blocks(blocks: &[FilmBlock], cover: FilmCover) -> Self {
        let mut bin = Self::default();
        for block in blocks {
            if let Some(sample) = &block.sample {
                bin.add(sample, 1.0, &[], sample.depths);
            }
            if cover == FilmCover::Seen {
                bin.extend(&block.points(), block.depths);
            }
        }
        bin
    }
}

/// The seen surfaces in the view volume.
fn positions(picture: &SeenPicture, view: &ViewVolume) -> Vec<DVec3> {
    let range = view.near()..=view.far() * (1.0 + DEPTH_SLACK);
    let seen = picture.blocks.iter().flatten().map(|block| block.position);
    seen.filter(|position| range.contains(&view.depth(*position))).collect()
}

/// What was seen within the depths of the view volume, and where the camera may have it now.
fn blocks(input: &FilmPlanInput, base: &BaseFilm) -> Vec<FilmBlock> {
    let (near, far) = (input.view.near(), input.view.far() * (1.0 + DEPTH_SLACK));
    let within = |block: FilmBlock| block.between(near, far);
    let mut blocks: Vec<FilmBlock> = input.picture.on_film(base).filter_map(within).collect();
    if input.clip_from_world != input.picture.clip_from_world && input.options.cover == FilmCover::Seen {
        blocks.extend(
            input
                .picture
                .moved_on_film(base, input.clip_from_world)
                .filter_map(within),
        );
    }
    blocks
}

fn depth_range(blocks: &[FilmBlock]) -> (f64, f64) {
    let depths = blocks.iter().map(|block| block.depths);
    depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), depths| {
        (near.min(depths[0]), far.max(depths[1]))
    })
}

/// Runs of slices that follow each other from the first slice to the last, as rectangles of one row.
fn without_gaps(runs: Vec<[usize; 2]>) -> Vec<TileRect> {
    let starts: Vec<usize> = std::iter::once(0).chain(runs[1..].iter().map(|run| run[0])).collect();
    let ends = starts[1..].iter().copied().chain([SLICES]);
    let pairs = starts.iter().copied().zip(ends);
    pairs
        .map(|(start, end)| [USizeVec2::new(start, 0), USizeVec2::new(end, 1)])
        .collect()
}
