//! Shadows that stand still while the camera moves (Stingl 2011, section 3.5): [`Stability`] chooses how,
//! [`HeldMaps`] remembers what the next frame must keep. [`maths::stable`](crate::maths::stable) has the derivations.

use bevy::{
    ecs::entity::EntityHashMap,
    math::{DMat3, DMat4, DVec2, DVec3},
    prelude::*,
};

use crate::maths::{
    bounds::Bounds,
    fit::{FitInput, LightAxes, LightFit, fit_light_view},
    stable::{
        fixed_axes,
        levels::{ScaleLevels, Spacing},
        sphere::{SnappedMap, bounding_sphere},
        warped::{SeenPoint, StableMap, StableSettings, WarpWish, WarpedGrid, hold},
    },
};

/// How shadows are kept from crawling when the camera moves. Only on the full path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum Stability {
    /// Every frame is fitted anew: the sharpest maps; shadow edges crawl by parts of a texel.
    #[default]
    Off,
    /// Bounding spheres of fixed slices, moved by whole texels: nothing crawls, and maps are the coarsest. Takes no warp,
    /// no measured depths, and a camera with a far plane or a shadow distance.
    Sphere,
    /// Focused maps of fixed orientation whose scale has 64 steps: nothing crawls between two steps. Takes no warp.
    Quantised,
    /// A warped grid is held, and its window moved by whole texels, until it is no longer sharp enough or no longer shows
    /// everything.
    Held,
    /// Every frame is fitted anew, and its shadow result blended with that of the frame before, carried along with the
    /// surfaces. As sharp as [`Off`](Self::Off), with smoother edges; shadows that move lag behind by about as many
    /// frames, at their edges only. Costs one screen-sized pass and 8 bytes per pixel.
    Sharp {
        /// Frames over which the result is averaged, 2..=32; useful 3..=8. With more, less crawls, and what is thinner than
        /// a pixel fades.
        frames: u32,
    },
}

impl Stability {
    /// [`Stability::Sharp`] with the frames that measured best: see the table of
    /// [`maths::stable`](crate::maths::stable).
    pub const SHARP: Self = Self::Sharp { frames: 4 };
    /// Frames of [`Stability::Sharp`] that can be asked for.
    pub const FRAMES: std::ops::RangeInclusive<u32> = 2..=32;

    /// Frames over which the shadow result is averaged; 1: it is not.
    #[must_use]
    pub fn frames(self) -> u32 {
        match self {
            Self::Sharp { frames } => frames,
            _ => 1,
        }
    }

    /// Whether maps of one frame are bound to those of the frame before: such maps must be of one size, and of z-partitions.
    #[must_use]
    pub fn holds_maps(self) -> bool {
        matches!(self, Self::Sphere | Self::Quantised | Self::Held)
    }

    /// Whether its maps are uniform: snapping a map to its texels needs texels of one size.
    #[must_use]
    pub fn is_uniform(self) -> bool {
        matches!(self, Self::Sphere | Self::Quantised)
    }
}

/// What a map of the frame before leaves to the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeldMap {
    /// Levels of scale in use, by axis.
    Levels([u32; 2]),
    /// The grid in use.
    Grid(WarpedGrid),
}

/// On the entity of a light: what its maps leave to the next frame, by camera and map.
#[derive(Component, Clone, Debug, Default)]
pub struct HeldMaps {
    /// One entry per map, near to far; `None` where nothing is held.
    pub cameras: EntityHashMap<Vec<Option<HeldMap>>>,
}

/// Part of the window that a new grid leaves free for turning, and factor by which its storage factor may exceed that of
/// a fresh fit: the sharper of the choices measured in [`warped`](crate::maths::stable::warped).
const ROOM: f64 = 0.1;
/// See [`ROOM`].
const TOLERANCE: f64 = 2.0;
/// The smallest half extent of a map with quantised scale, as a share of the scene's: smaller ones all look the same.
const SMALLEST_SHARE: f64 = 1.0 / 4096.0;

/// The light view of a map that stands still. `None`: nothing is seen, or this way has no map for it (a sphere around an
/// infinite slice).
///
/// `scene` is the box around everything, the fixed reference of quantised scales.
pub(super) fn stable_fit(
    input: &FitInput,
    stability: Stability,
    scene: &Bounds,
    held: &mut Option<HeldMap>,
) -> Option<LightFit> {
    let before = held.take();
    match stability {
        Stability::Off | Stability::Sharp { .. } => fit_light_view(input).fitted(),
        Stability::Sphere => sphere_fit(input),
        Stability::Quantised => {
            let previous = match before {
                Some(HeldMap::Levels(levels)) => Some(levels),
                _ => None,
            };
            let (fit, levels) = quantised_fit(input, scene, previous)?;
            *held = Some(HeldMap::Levels(levels));
            Some(fit)
        }
        Stability::Held => {
            let previous = match before {
                Some(HeldMap::Grid(grid)) => Some(grid),
                _ => None,
            };
            let (fit, grid) = held_fit(input, previous)?;
            *held = Some(HeldMap::Grid(grid));
            Some(fit)
        }
    }
}

fn sphere_fit(input: &FitInput) -> Option<LightFit> {
    let axes = fixed_axes(input.light_travel)?;
    let mut sphere = bounding_sphere(input.view)?;
    sphere.radius = (sphere.radius + input.guard_metres) / inner_share(input);
    snapped_fit(input, &SnappedMap::around(&sphere, &axes, side(input)), axes)
}

fn quantised_fit(input: &FitInput, scene: &Bounds, previous: Option<[u32; 2]>) -> Option<(LightFit, [u32; 2])> {
    let axes = fixed_axes(input.light_travel)?;
    let place = |point: DVec3| DVec2::new(axes.x.dot(point), axes.y.dot(point));
    let (low, high) = range(input.visible.vertices().iter().map(|vertex| place(*vertex)))?;
    let (scene_low, scene_high) = range(scene.corners().into_iter().map(place))?;
    let guard = DVec2::splat(input.guard_metres);
    let half = ((high - low) * 0.5 + guard) / inner_share(input);
    let middle = (low + high) * 0.5;
    // The guards may reach beyond the scene.
    let reference = 2.0 * ((scene_high - scene_low).max_element() * 0.5 + input.guard_metres) / inner_share(input);
    let levels = ScaleLevels {
        reference,
        spacing: Spacing::Geometric {
            smallest: reference * SMALLEST_SHARE,
        },
    };
    let (map, levels) = levels.stabilised(previous, middle - half, middle + half, side(input))?;
    Some((snapped_fit(input, &map, axes)?, levels))
}

fn held_fit(input: &FitInput, previous: Option<WarpedGrid>) -> Option<(LightFit, WarpedGrid)> {
    let fit = fit_light_view(input).fitted()?;
    let seen = seen_points(input);
    let wish = WarpWish {
        axes: fit.axes,
        near_point: fit.world_from_light.w_axis.truncate(),
        warp_near: fit.warp_near,
        seen: &seen,
    };
    let settings = StableSettings {
        map_size: side(input),
        guard_texels: input.guard_texels,
        room: ROOM,
        tolerance: TOLERANCE,
    };
    let map = hold(previous.as_ref(), &wish, &settings)?;
    Some((grid_fit(input, &map, fit.eta)?, map.grid))
}

/// Texels per side: maps that are held are square.
fn side(input: &FitInput) -> u32 {
    input.map_size.min_element().max(1)
}

/// Share of a map's side between its guard texels.
fn inner_share(input: &FitInput) -> f64 {
    1.0 - (2.0 * input.guard_texels / f64::from(side(input))).min(0.5)
}

/// Corners of H with their view depths; with a guard in metres, the corners of a box around each.
fn seen_points(input: &FitInput) -> Vec<SeenPoint> {
    let guard = Bounds::new(DVec3::ZERO, DVec3::ZERO).expanded(input.guard_metres.max(0.0));
    let corners = guard.corners();
    let offsets = if input.guard_metres > 0.0 {
        &corners[..]
    } else {
        &corners[..1]
    };
    let view = input.view;
    let points = input.visible.vertices().iter().flat_map(|vertex| {
        let depth = if view.is_orthographic() {
            1.0
        } else {
            view.depth(*vertex).max(view.near())
        };
        offsets.iter().map(move |offset| SeenPoint {
            position: *vertex + *offset,
            depth,
        })
    });
    points.collect()
}

fn range(points: impl Iterator<Item = DVec2>) -> Option<(DVec2, DVec2)> {
    let (low, high) = points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), point| {
        (low.min(point), high.max(point))
    });
    (low.is_finite() && high.is_finite()).then_some((low, high))
}

/// Corners of everything that the depth range must hold.
fn all_corners(input: &FitInput) -> Vec<DVec3> {
    let bodies = input.visible.vertices().iter().chain(input.body.vertices());
    bodies.copied().collect()
}

fn snapped_fit(input: &FitInput, map: &SnappedMap, axes: LightAxes) -> Option<LightFit> {
    // Only for its rounding of the depth range.
    let grid = WarpedGrid {
        axes,
        anchor: DVec2::ZERO,
        warp_near: f64::INFINITY,
        texels_per_metre: DVec2::ONE / map.texel,
        level: 0.0,
    };
    let (farthest, nearest) = grid.depth_range(&all_corners(input))?;
    let clip_from_world = map.clip_from_world(&axes, farthest, nearest);
    let origin = axes.x * map.center.x + axes.y * map.center.y;
    let side = map.texel.max_element();
    finite(LightFit {
        clip_from_world,
        texel_size: map.texel.element_product().sqrt(),
        near_texel_size: side,
        relative_texel_size: side,
        depth_per_metre: 1.0 / (nearest - farthest),
        warp_near: f64::INFINITY,
        eta: -1.0,
        ..placed(axes, origin, clip_from_world)
    })
}

fn grid_fit(input: &FitInput, map: &StableMap, eta: f64) -> Option<LightFit> {
    let StableMap { grid, window } = map;
    let (farthest, nearest) = grid.depth_range(&all_corners(input))?;
    let clip_from_world = grid.clip_from_world(window, farthest, nearest);
    let axes = grid.axes;
    let origin = axes.x * grid.anchor.x + axes.y * grid.anchor.y + axes.z * grid.level;
    let along = input
        .visible
        .vertices()
        .iter()
        .map(|vertex| axes.y.dot(*vertex) - grid.anchor.y);
    let (near, far) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), y| {
        (near.min(y), far.max(y))
    });
    let sides = |along: f64| {
        let width = 1.0 + along / grid.warp_near;
        DVec2::new(width, width * width) / grid.texels_per_metre
    };
    let relative = sides(0.0);
    finite(LightFit {
        clip_from_world,
        texel_size: sides((near + far) * 0.5).element_product().sqrt(),
        near_texel_size: sides(near).max_element(),
        relative_texel_size: relative.x.max(relative.y * (1.0 + far / grid.warp_near).sqrt()),
        depth_per_metre: 1.0 / (nearest - farthest),
        warp_near: grid.warp_near,
        eta,
        ..placed(axes, origin, clip_from_world)
    })
}

/// The rigid part of a light view.
fn placed(axes: LightAxes, origin: DVec3, clip_from_world: DMat4) -> LightFit {
    let world_from_light = DMat4::from_mat3_translation(DMat3::from_cols(axes.x, axes.y, axes.z), origin);
    LightFit {
        world_from_light,
        clip_from_light: clip_from_world * world_from_light,
        clip_from_world,
        axes,
        warp_near: f64::INFINITY,
        eta: -1.0,
        texel_size: 0.0,
        near_texel_size: 0.0,
        relative_texel_size: 0.0,
        depth_per_metre: 0.0,
    }
}

fn finite(fit: LightFit) -> Option<LightFit> {
    (fit.clip_from_world.is_finite() && fit.clip_from_light.is_finite()).then_some(fit)
}
