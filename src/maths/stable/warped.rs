//! Warped maps that are stable *and* sharp: hold the warp, slide the window.
//!
//! # What can be held
//!
//! A warped map takes a point of the light plane, x across and y along the warp axis from an anchor, to texels
//!
//! ```text
//! u = S_x x ÷ w      v = S_y y ÷ w      w = 1 + y ÷ n'
//! ```
//!
//! This is a grid over the whole half-plane before the projection centre, n' behind the anchor; the map is a window of
//! N × N of its texels. Let the camera move and ask which other maps have the same texels in the world. Texel borders
//! across the axis are lines through the projection centre, so the centre must stay, and with it n' and the axis;
//! shifting the anchor along the axis by a with the same centre gives
//!
//! ```text
//! n'₂ = n' + a     v₂ = S₂ (y − a) n'₂ ÷ (y + n') = (S₂ n'₂² ÷ (S_y n'²)) v − S₂ a n'₂ ÷ n'
//! ```
//!
//! which is v plus a constant when S₂ n'₂² = S_y n'²: it is the same grid, written differently. So for a warp there are
//! no small steps, as the snapping of uniform maps has them: either centre, axis and scales stay and the window slides
//! by whole texels, in both directions, exactly; or the whole grid changes. (Stingl, section 3.5, concludes that
//! snapping and warps exclude each other. They do for a map that is fitted anew each frame.)
//!
//! The price of holding a grid: the viewer walks away from its centre, where texels are larger (by w across and w²
//! along), and turns away from its axis, so that the window has to show more. [`LargestErrors`] measures both. Two
//! designs:
//!
//! - [`hold`] keeps the previous grid until its storage factor exceeds that of a fresh fit by a tolerance, or until the
//!   window no longer shows everything that is seen; then it takes the fresh fit with some room to spare. The grid
//!   depends on the path.
//! - [`lattice`] rounds everything: axis, n', anchor and scales. No memory: the same camera gets the same grid. It
//!   changes with each border that any of the rounded values crosses.
//!
//! # What it costs
//!
//! Measured on a walk (1.4 m/s, a quarter turn within 2 s, glances of 30° to both sides, a nodding head; 15 s at 60
//! frames per second) over wide ground under a sun at 63°, for slices of 0.3, 2.2, 16 and 120 m. Sharpness is texel ÷
//! pixel, the root of the storage factor, against a fresh fit (1 is as sharp) and against the sphere-snapped uniform
//! map of [`sphere`](super::sphere) (0.5 is twice as sharp):
//!
//! | design | frames with an unchanged grid | mean (largest) to a fresh fit | mean to the sphere |
//! |---|---|---|---|
//! | fitted anew, `room` 0.1 | 0, 0, 0 | 1.10 | 0.34, 0.31, 0.28 |
//! | [`hold`], `room` 0.1, `tolerance` 2 | 92 %, 98 %, 98 % | 1.25, 1.23, 1.16 (1.41) | 0.38, 0.35, 0.30 |
//! | [`hold`], `room` 0.2, `tolerance` 3 | 94 %, 99 %, 99 % | 1.45, 1.45, 1.28 (1.73) | 0.44, 0.41, 0.33 |
//! | [`lattice`] with its defaults | 84 %, 96 %, 96 % | 1.38, 1.35, 1.41 (1.73) | 0.42, 0.39, 0.36 |
//!
//! Holding beats the lattice in every column: rounding pays for the worst case all the time. The nearest slice changes
//! most often because its n' is a metre, which a walker passes within a second; weaker warps hold longer there, and
//! cost more than they win (twice n': 96 % of frames at 1.68).
//!
//! [`LargestErrors`]: crate::maths::error::LargestErrors

use bevy_math::{DMat4, DVec2, DVec3, DVec4};

use super::fixed_axes;
use crate::maths::{error::LargestErrors, fit::LightAxes};

/// A point that the camera sees, as stability needs it: the corners of H.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPoint {
    /// World space.
    pub position: DVec3,
    /// View depth, metres; 1 for orthographic cameras.
    pub depth: f64,
}

/// What a fresh fit of this frame wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WarpWish<'a> {
    /// Light space, y along the warp axis.
    pub axes: LightAxes,
    /// A world-space point at the near end of the warp, beside the projection centre and at its height: the origin of
    /// the fit's light space.
    pub near_point: DVec3,
    /// n', metres; infinite for no warp.
    pub warp_near: f64,
    /// Corners of H.
    pub seen: &'a [SeenPoint],
}

/// Limits of a stable map. The module's documentation has the cost of some choices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableSettings {
    /// Texels per side.
    pub map_size: u32,
    /// Texels left free on every side.
    pub guard_texels: f64,
    /// Part of the window that a new grid leaves free on each axis for turning: 0.1 makes texels 1.1 times as large.
    /// Good values: 0.1 to 0.2.
    pub room: f64,
    /// Factor by which the storage factor of a held grid may exceed that of a fresh fit; 2 is 1.4 per axis. Must exceed
    /// (1 + `room`)², the factor of a new grid; good values: 2 to 3.
    pub tolerance: f64,
}

/// An infinite grid of texels over the light plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WarpedGrid {
    /// Light space, y along the warp axis.
    pub axes: LightAxes,
    /// x and y of the anchor along the axes, metres.
    pub anchor: DVec2,
    /// n', metres; infinite for no warp.
    pub warp_near: f64,
    /// S: texels per metre at the anchor, across and along.
    pub texels_per_metre: DVec2,
    /// Light-space z of the projection centre, metres. No texel depends on it, but the depths of the map do, as
    /// [`fit_light_view`](crate::maths::fit::fit_light_view) explains.
    pub level: f64,
}

/// The texels of a grid that a map holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridWindow {
    /// The texel with the smallest coordinates, whole numbers.
    pub first: DVec2,
    /// Texels per side.
    pub map_size: u32,
}

/// A map of this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableMap {
    /// Its grid: the next frame's `previous`.
    pub grid: WarpedGrid,
    /// Its window.
    pub window: GridWindow,
}

/// Clip-space w below which a grid is not held any more: the viewer has come half the way to the projection centre.
const SMALLEST_WIDTH: f64 = 0.5;

impl WarpedGrid {
    fn width(&self, along: f64) -> f64 {
        1.0 + (along - self.anchor.y) / self.warp_near
    }

    /// Texel coordinates of a world-space point; `None` behind the projection centre.
    pub fn texel(&self, point: DVec3) -> Option<DVec2> {
        let place = DVec2::new(self.axes.x.dot(point), self.axes.y.dot(point));
        let width = self.width(place.y);
        (width > 0.0).then(|| (place - self.anchor) * self.texels_per_metre / width)
    }

    /// Least and greatest texel coordinates of points; `None` if one comes too near to the projection centre.
    fn range(&self, seen: &[SeenPoint]) -> Option<(DVec2, DVec2)> {
        let mut range = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in seen {
            if self.width(self.axes.y.dot(point.position)) < SMALLEST_WIDTH {
                return None;
            }
            let texel = self.texel(point.position)?;
            range = (range.0.min(texel), range.1.max(texel));
        }
        (range.0.is_finite() && range.1.is_finite()).then_some(range)
    }

    /// Largest texel ÷ view depth over the seen points, across and along the warp axis: the errors M_x and M_z for a
    /// picture that is as wide as deep. Exact for the hull of the points, as in
    /// [`largest_errors`](crate::maths::error::largest_errors).
    pub fn errors(&self, seen: &[SeenPoint]) -> LargestErrors {
        let mut largest = LargestErrors {
            across: 0.0,
            along: 0.0,
        };
        for point in seen {
            let width = self.width(self.axes.y.dot(point.position));
            let texel = DVec2::new(width, width * width) / self.texels_per_metre / point.depth;
            largest.across = largest.across.max(texel.x);
            largest.along = largest.along.max(texel.y);
        }
        largest
    }

    /// The window around points; `None` if they do not fit.
    pub fn window(&self, seen: &[SeenPoint], settings: &StableSettings) -> Option<GridWindow> {
        let (low, high) = self.range(seen)?;
        let size = f64::from(settings.map_size);
        let first = ((low + high - size) * 0.5).round();
        let guard = settings.guard_texels;
        let is_inside = (low - first).min_element() >= guard && (high - first).max_element() <= size - guard;
        is_inside.then_some(GridWindow {
            first,
            map_size: settings.map_size,
        })
    }

    /// Least and greatest (z − `level`) ÷ w over the corners of B, with two local texels to spare: what
    /// [`WarpedGrid::clip_from_world`] maps to depths 0 and 1. Rounded outwards to a 32nd of the power of two below
    /// their distance, so that most frames with one grid have one range (86 % walking straight on). `None` for no
    /// corners, or one behind the projection centre.
    pub fn depth_range(&self, body: &[DVec3]) -> Option<(f64, f64)> {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for point in body {
            let width = self.width(self.axes.y.dot(*point));
            if !(width > 0.0) {
                return None;
            }
            let margin = 2.0 * (DVec2::new(width, width * width) / self.texels_per_metre).max_element();
            let height = self.axes.z.dot(*point) - self.level;
            range = (
                range.0.min((height - margin) / width),
                range.1.max((height + margin) / width),
            );
        }
        let step = (range.1 - range.0).log2().floor().exp2() / 32.0;
        let rounded = ((range.0 / step).floor() * step, (range.1 / step).ceil() * step);
        (rounded.0.is_finite() && rounded.0 < rounded.1).then_some(rounded)
    }

    /// World to clip space, reverse z. `farthest` and `nearest` from [`WarpedGrid::depth_range`].
    pub fn clip_from_world(&self, window: &GridWindow, farthest: f64, nearest: f64) -> DMat4 {
        let bend = 1.0 / self.warp_near;
        let row_width = (self.axes.y * bend).extend(1.0 - self.anchor.y * bend);
        let ndc_per_texel = 2.0 / f64::from(window.map_size);
        let row = |axis: DVec3, anchor: f64, scale: f64, first: f64| {
            axis.extend(-anchor) * (scale * ndc_per_texel) - row_width * (first * ndc_per_texel + 1.0)
        };
        let depth_per_metre = 1.0 / (nearest - farthest);
        let row_depth: DVec4 = (self.axes.z.extend(-self.level) - row_width * farthest) * depth_per_metre;
        let rows = DMat4::from_cols(
            row(self.axes.x, self.anchor.x, self.texels_per_metre.x, window.first.x),
            row(self.axes.y, self.anchor.y, self.texels_per_metre.y, window.first.y),
            row_depth,
            row_width,
        );
        rows.transpose()
    }
}

/// The grid with the scales that show everything seen, `room` of the window left free.
fn fitting(mut grid: WarpedGrid, wish: &WarpWish, settings: &StableSettings, room: f64) -> Option<WarpedGrid> {
    grid.texels_per_metre = DVec2::ONE;
    let (low, high) = grid.range(wish.seen)?;
    // Rounding the window to whole texels takes one.
    let texels = f64::from(settings.map_size) - 2.0 * settings.guard_texels - 1.0;
    let smallest = 1.0e-6 * (high - low).max_element().max(1.0e-6);
    grid.texels_per_metre = DVec2::splat(texels / (1.0 + room)) / (high - low).max(DVec2::splat(smallest));
    (texels > 0.0 && grid.texels_per_metre.is_finite()).then_some(grid)
}

/// The grid of this frame's fresh fit, without room to spare: the sharpest, and never the same twice. `None` when
/// nothing is seen or the map has no texels.
pub fn fresh(wish: &WarpWish, settings: &StableSettings) -> Option<WarpedGrid> {
    fitting(wished(wish), wish, settings, 0.0)
}

fn wished(wish: &WarpWish) -> WarpedGrid {
    WarpedGrid {
        axes: wish.axes,
        anchor: DVec2::new(wish.axes.x.dot(wish.near_point), wish.axes.y.dot(wish.near_point)),
        warp_near: wish.warp_near,
        texels_per_metre: DVec2::ONE,
        level: wish.axes.z.dot(wish.near_point),
    }
}

/// The previous grid as long as it shows everything seen and is sharp enough, else a fresh one with room to spare.
/// `None` when nothing is seen.
///
/// A grid is dropped when the light has moved, because it lies in the plane across the light.
pub fn hold(previous: Option<&WarpedGrid>, wish: &WarpWish, settings: &StableSettings) -> Option<StableMap> {
    let fresh = fresh(wish, settings)?;
    let allowed = fresh.errors(wish.seen).storage_factor() * settings.tolerance;
    let same_light = |grid: &&WarpedGrid| grid.axes.z.distance(wish.axes.z) < 1.0e-9;
    let held = previous.filter(same_light).and_then(|grid| {
        let window = grid.window(wish.seen, settings)?;
        (grid.errors(wish.seen).storage_factor() <= allowed).then_some(StableMap { grid: *grid, window })
    });
    held.or_else(|| {
        let grid = fitting(fresh, wish, settings, settings.room)?;
        let window = grid.window(wish.seen, settings)?;
        Some(StableMap { grid, window })
    })
}

/// Steps of [`lattice`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeSteps {
    /// Directions of the warp axis.
    pub directions: u32,
    /// Ratio of neighbouring n'.
    pub warp_ratio: f64,
    /// Distance of neighbouring anchors, as a share of n'.
    pub anchor_share: f64,
    /// Ratio of neighbouring scales.
    pub scale_ratio: f64,
}

impl Default for LatticeSteps {
    /// Steps of 11° and factors that together make texels at most 1.8 times as large as a fresh fit's, 1.4 times on
    /// average.
    fn default() -> Self {
        Self {
            directions: 32,
            warp_ratio: 1.5,
            anchor_share: 0.3,
            scale_ratio: 1.3,
        }
    }
}

/// The grid of a lattice of grids that suits this frame, without memory. `None` when nothing is seen.
///
/// The axis is rounded to the nearest direction, n' up to the next power of its ratio (a weaker warp suits a longer
/// extent), the anchor back along the axis and to the nearest across it, the scales down.
pub fn lattice(wish: &WarpWish, steps: &LatticeSteps, settings: &StableSettings) -> Option<StableMap> {
    let fixed = fixed_axes(-wish.axes.z)?;
    let step = std::f64::consts::TAU / f64::from(steps.directions.max(1));
    let angle = wish.axes.y.dot(fixed.x).atan2(wish.axes.y.dot(fixed.y));
    let (sine, cosine) = ((angle / step).round() * step).sin_cos();
    let y = fixed.x * sine + fixed.y * cosine;
    let mut grid = wished(&WarpWish {
        axes: LightAxes {
            x: y.cross(fixed.z),
            y,
            z: fixed.z,
        },
        ..*wish
    });
    let along = wish.seen.iter().map(|point| y.dot(point.position));
    grid.anchor.y = along.fold(grid.anchor.y, f64::min);
    if grid.warp_near.is_finite() {
        grid.warp_near = power_at_least(grid.warp_near, steps.warp_ratio);
        let spacing = grid.warp_near * steps.anchor_share;
        grid.anchor.x = (grid.anchor.x / spacing).round() * spacing;
        grid.anchor.y = (grid.anchor.y / spacing).floor() * spacing;
        grid.level = (grid.level / spacing).round() * spacing;
    } else {
        grid.anchor = DVec2::ZERO;
        grid.level = 0.0;
    }
    let mut grid = fitting(grid, wish, settings, 0.0)?;
    grid.texels_per_metre = DVec2::new(
        1.0 / power_at_least(1.0 / grid.texels_per_metre.x, steps.scale_ratio),
        1.0 / power_at_least(1.0 / grid.texels_per_metre.y, steps.scale_ratio),
    );
    let window = grid.window(wish.seen, settings)?;
    Some(StableMap { grid, window })
}

/// The smallest power of `ratio` that is at least `value`.
fn power_at_least(value: f64, ratio: f64) -> f64 {
    ratio.powf((value.ln() / ratio.ln() - 1.0e-9).ceil())
}
