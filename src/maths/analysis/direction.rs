//! Any light direction: errors of maps by evaluation at vertices (Lloyd et al. 2006, section 4.4).
//!
//! m_x is linear-fractional over the frustum and m_z a square of a linear function over a positive linear one: both are
//! quasi-convex, so their largest values are at vertices.

use bevy_math::DVec3;
use thiserror::Error;

use super::faces::{FaceWarp, face_errors};
use crate::maths::{
    error::{AxisErrors, FittedMap, LargestErrors, LightSample, largest_errors, largest_errors_at},
    face::{FaceOptions, face_partitions},
    fit::LightAxes,
    split::{SplitScheme, split_depths},
    view::ViewVolume,
    warp::{WarpSpan, reparametrised_eta},
};

/// Why a configuration has no errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Unanalysable {
    /// The light has no direction, or it is NaN.
    #[error("the light has no direction")]
    NoLightDirection,
    /// The camera is orthographic: all pixels are alike, there is no perspective aliasing.
    #[error("an orthographic camera has no perspective aliasing")]
    Orthographic,
    /// The view frustum has no end, and no body bounds it.
    #[error("the view frustum has no far plane")]
    Endless,
    /// Fewer than two points, or none in front of the eye.
    #[error("there is nothing in front of the camera")]
    NothingVisible,
}

/// How the map of a body is warped for any light direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TiltedWarp {
    /// No warp.
    Uniform,
    /// n_opt as published, everywhere: inside the view cone it bends far too much.
    Lispsm,
    /// `LiSPSM` re-parametrised over the angle γ between light and view: [`reparametrised_eta`].
    Reparametrised,
    /// n_opt, or no warp where that needs less storage.
    Guarded,
    /// The n' with the smallest S̄ of all, by search.
    Best,
    /// The normalised strength: −1 uniform, 0 n_opt, 1 `PSM` (Lloyd, equation 11).
    Strength {
        /// −1..=1.
        eta: f64,
    },
}

/// A map around a body, for a light direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TiltedMap {
    /// M_x and M_z over the body.
    pub largest: LargestErrors,
    /// n' in metres, infinite for no warp.
    pub warp_near: f64,
    map: FittedMap,
    axes: LightAxes,
}

impl TiltedMap {
    /// m_x and m_z at a world-space point. Not finite or negative at and behind the eye.
    pub fn errors(&self, view: &ViewVolume, point: DVec3) -> AxisErrors {
        self.map.at(&light_sample(view, &self.axes, point))
    }
}

/// The map around points of a body: the eight corners of the view frustum, of a slice of it, or the vertices of H.
///
/// Points at and behind the eye are left out. For pictures that are not square, errors are relative to the root of a
/// pixel's area, so that S̄ counts texels per pixel.
pub fn map_around(
    view: &ViewVolume,
    points: &[DVec3],
    light_travel: DVec3,
    warp: TiltedWarp,
) -> Result<TiltedMap, Unanalysable> {
    let axes = checked_axes(view, light_travel)?;
    let samples: Vec<LightSample> = points
        .iter()
        .map(|point| light_sample(view, &axes, *point))
        .filter(|sample| sample.depth > 0.0)
        .collect();
    if samples.len() < 2 {
        return Err(Unanalysable::NothingVisible);
    }
    let warp_near = tilted_warp_near(view, &axes, &samples, warp);
    let map = FittedMap::around(&samples, warp_near, opening(view));
    Ok(TiltedMap {
        largest: largest_errors_at(&map, &samples),
        warp_near,
        map,
        axes,
    })
}

/// [`map_around`] the corners of the whole view frustum.
pub fn frustum_map(view: &ViewVolume, light_travel: DVec3, warp: TiltedWarp) -> Result<TiltedMap, Unanalysable> {
    if view.far().is_infinite() {
        return Err(Unanalysable::Endless);
    }
    map_around(view, &view.corners(view.near(), view.far()), light_travel, warp)
}

/// A whole scheme: how the frustum is divided and how every map is warped.
#[derive(Clone, Debug, PartialEq)]
pub struct Scheme {
    /// Slices of view depth, or of the side faces: 1..=16.
    pub slices: usize,
    /// Where they meet.
    pub splits: SplitScheme,
    /// The warp of every map. Face partitions have their own n': [`TiltedWarp::Uniform`] switches it off,
    /// [`TiltedWarp::Guarded`] is [`FaceWarp::Guarded`], and all others mean the published rule.
    pub warp: TiltedWarp,
    /// Face partitions, sides and, where the light meets it, the near face in a small unwarped map of its own; false: the
    /// frustum as a whole.
    pub faces: bool,
}

impl Scheme {
    /// ZP or ZP+W with self-similar slices.
    pub fn depth(slices: usize, warp: TiltedWarp) -> Self {
        Self {
            slices,
            splits: SplitScheme::Logarithmic,
            warp,
            faces: false,
        }
    }

    /// FP+ZP+W with self-similar slices and the near face.
    pub fn faces(slices: usize) -> Self {
        Self {
            faces: true,
            ..Self::depth(slices, TiltedWarp::Lispsm)
        }
    }

    /// S̄: texels per pixel so that no perspective error exceeds 1, each map as large as its own errors demand.
    pub fn storage_factor(&self, view: &ViewVolume, light_travel: DVec3) -> Result<f64, Unanalysable> {
        checked_axes(view, light_travel)?;
        if view.far().is_infinite() {
            return Err(Unanalysable::Endless);
        }
        if self.faces {
            return Ok(self.storage_factor_of_faces(view, light_travel));
        }
        let depths = split_depths(&self.splits, view.near(), view.far(), self.slices);
        let slices = depths.windows(2).map(|ends| view.split(ends[0], ends[1]));
        let maps = slices.map(|slice| frustum_map(&slice, light_travel, self.warp));
        maps.map(|map| map.map(|map| map.largest.storage_factor())).sum()
    }

    fn storage_factor_of_faces(&self, view: &ViewVolume, light_travel: DVec3) -> f64 {
        let warp = match self.warp {
            TiltedWarp::Uniform => FaceWarp::None,
            TiltedWarp::Guarded => FaceWarp::Guarded,
            _ => FaceWarp::Bisector,
        };
        let options = FaceOptions {
            slices: self.slices,
            scheme: self.splits.clone(),
            ..FaceOptions::default()
        };
        let partitions = face_partitions(view, &view.polytope(view.far()), light_travel, &options);
        let maps = partitions.iter().map(|partition| face_errors(view, partition, warp));
        maps.map(|errors| errors.storage_factor()).sum()
    }
}

/// The root of a pixel's area per metre of view depth, the picture being one pixel: 2 tan Θ of square pictures.
pub(super) fn opening(view: &ViewVolume) -> f64 {
    view.opening().element_product().sqrt()
}

fn light_sample(view: &ViewVolume, axes: &LightAxes, point: DVec3) -> LightSample {
    let offset = point - view.eye();
    LightSample {
        across: axes.x.dot(offset),
        along: axes.y.dot(offset),
        depth: view.depth(point),
    }
}

fn checked_axes(view: &ViewVolume, light_travel: DVec3) -> Result<LightAxes, Unanalysable> {
    if view.is_orthographic() {
        return Err(Unanalysable::Orthographic);
    }
    let finite = light_travel.is_finite().then_some(light_travel);
    let axes = finite.and_then(|travel| LightAxes::new(view.forward(), view.up(), travel));
    axes.ok_or(Unanalysable::NoLightDirection)
}

fn tilted_warp_near(view: &ViewVolume, axes: &LightAxes, samples: &[LightSample], warp: TiltedWarp) -> f64 {
    let (start, end, near, far) = samples.iter().fold(
        (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY),
        |(start, end, near, far), sample| {
            (
                start.min(sample.along),
                end.max(sample.along),
                near.min(sample.depth),
                far.max(sample.depth),
            )
        },
    );
    let sine = view.forward().dot(axes.y);
    let span = WarpSpan::directional(end - start, near, sine);
    let storage = |warp_near: f64| largest_errors(samples, warp_near, 1.0).storage_factor();
    match warp {
        TiltedWarp::Uniform => f64::INFINITY,
        TiltedWarp::Lispsm => span.optimal_warp_near(),
        TiltedWarp::Reparametrised => {
            let half_opening = (opening(view) * 0.5).atan();
            // The published form takes α from the depths of the body, not from the ends of the warp axis.
            let span = WarpSpan::new(end - start, near, far);
            span.warp_near(reparametrised_eta(sine.clamp(0.0, 1.0).asin(), half_opening))
        }
        TiltedWarp::Guarded => {
            let optimal = span.optimal_warp_near();
            if storage(optimal) < storage(f64::INFINITY) {
                optimal
            } else {
                f64::INFINITY
            }
        }
        TiltedWarp::Best => best_warp_near(near, end - start, &storage),
        TiltedWarp::Strength { eta } => span.warp_near(eta.clamp(-1.0, 1.0)),
    }
}

/// The n' with the smallest storage: 80 values in equal ratios from a tenth of the near depth to a hundred times the
/// extent, then the golden section around the best; no warp where nothing is better.
fn best_warp_near(near: f64, extent: f64, storage: &impl Fn(f64) -> f64) -> f64 {
    const STEPS: i32 = 80;
    const GOLDEN: f64 = 0.381_966_011_250_105;
    let (low, high) = ((near * 0.1).ln(), (extent * 100.0).max(near).ln());
    let step = (high - low) / f64::from(STEPS);
    let place = |index: i32| low + step * f64::from(index);
    let Some(best) = (0..=STEPS)
        .map(place)
        .min_by(|a, b| storage(a.exp()).total_cmp(&storage(b.exp())))
    else {
        return f64::INFINITY;
    };
    let (mut left, mut right) = (best - step, best + step);
    for _ in 0..30 {
        let (inner_left, inner_right) = (left + (right - left) * GOLDEN, right - (right - left) * GOLDEN);
        if storage(inner_left.exp()) <= storage(inner_right.exp()) {
            right = inner_right;
        } else {
            left = inner_left;
        }
    }
    let found = (0.5 * (left + right)).exp();
    if storage(found) < storage(f64::INFINITY) {
        found
    } else {
        f64::INFINITY
    }
}
