//! The original perspective shadow map (Stamminger and Drettakis 2002): the light's view of the camera's clip space.
//!
//! Where the warps of light space are a perspective across the light whose strength is chosen, here the camera's own
//! projection is the warp: it takes the visible body into the cube −1..=1 and the light with it, and the map is a plain
//! view of that cube from the transformed light. In homogeneous coordinates the direction to the sun (l, 0) becomes the
//! point λ = `clip_from_world` · (l, 0), with λ_w the part of l along the view:
//!
//! | λ_w | the sun shines | in the cube's space it is |
//! |---|---|---|
//! | 0 | across the view | a parallel light along λ_xyz |
//! | > 0 | towards the viewer | a point λ_xyz ÷ λ_w beyond the cube's far side |
//! | < 0 | from behind the viewer | the same kind of point, but rays run towards it, so depths are reversed |
//!
//! One projection serves all three. With a point c in the middle of the body, the view axis â from c towards (or, where
//! λ_w < 0, away from) the light, a = λ_xyz − c λ_w = |a| â, and two directions u and v across it, a point q of clip space
//! goes to
//!
//! ```text
//! X = u · (q_xyz − c q_w)        Y = v · (q_xyz − c q_w)        Z = â · (q_xyz − c q_w)
//! W = (â · λ_xyz) q_w − (â · q_xyz) λ_w
//! ```
//!
//! The light itself goes to (0, 0, |a|, 0). So X, Y and W stay the same along every light ray and depth is linear along it,
//! rising towards the light; for λ_w = 0 the projection is parallel, since W = |λ_xyz| q_w; for a point light, W ÷ q_w is
//! λ_w times the distance from the light along the axis. Casters behind the eye, whose q_w is negative, need no care: their
//! W is that of the receivers on the same ray. (The original, which divides by q_w first, moves the camera back until
//! everything lies in front of it.)
//!
//! # Limits
//!
//! - The light point always lies 2 n ÷ (f − n) beyond the plane of the cube's far side. With light from inside the view cone,
//!   from ahead or behind, that is right before the far side, and the cube fills a half-space as seen from there. That is refused as [`PostPerspectiveRefusal::TooWide`].
//!   Just outside of the cone the map is possible and bad. The light-space warps have no such case.
//! - The near plane rules everything: half of the cube's depth belongs to view depths below 2 n f ÷ (n + f). With a careless n
//!   most of the map goes to empty air before the viewer (Stingl, section 4.3). Here n and f are the nearest and farthest
//!   depth of H.
//! - Depths are a share of q_w ÷ W, so their precision falls towards the far plane, and slopes of surfaces are distorted:
//!   any bias has to be worked out in the world (Scherzer 2005, section 4.2).
//! - The quality follows the light's place beside the cube in ways that are hard to foresee, and the map turns and stretches
//!   as the camera moves (Scherzer 2005, section 2).
//!
//! For light across the view it equals [`Warp::Psm`](super::Warp::Psm) texel by texel; a test holds that.

use bevy_math::{DMat4, DVec2, DVec3, DVec4, UVec2, Vec4Swizzles};

use super::super::{
    fit::{FitInput, Unfit},
    polytope::Polytope,
    view::ViewVolume,
};

/// Where the sun stands in the camera's clip space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PostPerspectiveLight {
    /// Across the view: a parallel light.
    Parallel,
    /// Shining towards the viewer: a point light at this place beside or beyond the cube −1..=1.
    InFront(DVec3),
    /// Shining from behind the viewer: a point at this place to which the rays run.
    Behind(DVec3),
}

/// Why there is no post-perspective light view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PostPerspectiveRefusal {
    /// No light view of any kind exists.
    Unfit(Unfit),
    /// The camera is orthographic: its clip space is the world, up to scale.
    Orthographic,
    /// Seen from the light's place the body fills a half-space or nearly so: the light comes from inside the view cone,
    /// from ahead or behind, or hardly from outside.
    TooWide,
}

/// A light view of the camera's clip space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PostPerspectiveFit {
    /// World to light clip space: x and y in −1..=1 over the bodies, reverse z. Not a product of a rigid motion and a
    /// warp across the light, but x, y and w stay the same along light rays, and z ÷ w rises towards the light.
    pub clip_from_world: DMat4,
    /// The light in the camera's clip space.
    pub light: PostPerspectiveLight,
}

/// Smallest cosine between the axis of the light's view and any corner of the visible body: wider views than 87° to a
/// side are refused.
const SMALLEST_COSINE: f64 = 0.05;

/// |λ_w| of a unit direction below which the light is called parallel. The projection is the same on both sides of it.
const PARALLEL: f64 = 1.0e-9;

/// Fits a perspective shadow map in the camera's clip space (Stamminger and Drettakis 2002; see the module for the
/// projection and its limits).
///
/// [`FitInput::visible`] decides n, f, x and y, [`FitInput::body`] the depth range, `guard_texels` stay free on every side.
/// `warp`, `guard_metres` and `options` are not read.
pub fn fit_post_perspective(input: &FitInput) -> Result<PostPerspectiveFit, PostPerspectiveRefusal> {
    let to_light = checked_light(input).map_err(PostPerspectiveRefusal::Unfit)?;
    if input.view.is_orthographic() {
        return Err(PostPerspectiveRefusal::Orthographic);
    }
    let cube_from_world = cube_from_world(input.view, input.visible);
    let light = cube_from_world * to_light.extend(0.0);
    let in_cube = |body: &Polytope| -> Vec<DVec4> {
        let vertices = body.vertices().iter();
        vertices.map(|vertex| cube_from_world * vertex.extend(1.0)).collect()
    };
    let (visible, body) = (in_cube(input.visible), in_cube(input.body));
    let middle = middle(&visible);
    let refused = Err(PostPerspectiveRefusal::TooWide);
    let Some(axis) = (light.xyz() - middle * light.w).try_normalize() else {
        return refused;
    };
    let wide = visible.iter().any(|corner| {
        let to_light = light.xyz() * corner.w - corner.xyz() * light.w;
        !(to_light.dot(axis) > SMALLEST_COSINE * to_light.length())
    });
    let row = |across: DVec3| across.extend(-across.dot(middle));
    let row_width = (-axis * light.w).extend(axis.dot(light.xyz()));
    if wide || body.iter().any(|corner| !(row_width.dot(*corner) > 0.0)) {
        return refused;
    }

    let upwards = [DVec3::Z, DVec3::Y].map(|direction| direction.reject_from_normalized(axis));
    let along = if upwards[0].length() > 1.0e-6 {
        upwards[0]
    } else {
        upwards[1]
    }
    .normalize();
    // The cube is a mirror image of the world; which way round the light sees it depends on the side of the light.
    let across = along.cross(axis);
    let mirrored =
        rows(row(across), row(along), row(axis), row_width).determinant() * cube_from_world.determinant() < 0.0;
    let across = if mirrored { -across } else { across };

    let texels = input.map_size.max(UVec2::ONE).as_dvec2();
    let inner = 1.0 - (2.0 * input.guard_texels.max(0.0) / texels).min(DVec2::splat(0.5));
    let focus = |row: DVec4, low: f64, high: f64| {
        let range = visible
            .iter()
            .chain(&body)
            .map(|corner| row.dot(*corner) / row_width.dot(*corner));
        let (smallest, largest) = range.fold((f64::INFINITY, f64::NEG_INFINITY), |(smallest, largest), value| {
            (smallest.min(value), largest.max(value))
        });
        let scale = (high - low) / (largest - smallest).max(SMALLEST_RANGE);
        (row - row_width * ((smallest + largest) * 0.5)) * scale + row_width * ((low + high) * 0.5)
    };
    let clip_from_cube = rows(
        focus(row(across), -inner.x, inner.x),
        focus(row(along), -inner.y, inner.y),
        focus(row(axis), DEPTH_MARGIN, 1.0 - DEPTH_MARGIN),
        row_width,
    );
    let clip_from_world = clip_from_cube * cube_from_world;
    if !clip_from_world.is_finite() {
        return Err(PostPerspectiveRefusal::Unfit(Unfit::NotFinite));
    }
    Ok(PostPerspectiveFit {
        clip_from_world,
        light: if light.w.abs() < PARALLEL {
            PostPerspectiveLight::Parallel
        } else if light.w > 0.0 {
            PostPerspectiveLight::InFront(light.xyz() / light.w)
        } else {
            PostPerspectiveLight::Behind(light.xyz() / light.w)
        },
    })
}

/// Ranges of the body in the light's view below which it counts as flat, in units of the cube.
const SMALLEST_RANGE: f64 = 1.0e-6;

/// Share of the depth range that is left free at both ends.
const DEPTH_MARGIN: f64 = 0.005;

/// The direction towards the light, or why there is nothing to fit.
fn checked_light(input: &FitInput) -> Result<DVec3, Unfit> {
    input.checked_bodies()?;
    if !input.light_travel.is_finite() || input.guard_texels.is_nan() {
        return Err(Unfit::NotFinite);
    }
    let travel = input.light_travel.try_normalize();
    travel.map(|travel| -travel).ok_or(Unfit::NoLightDirection)
}

/// The camera's projection onto the cube −1..=1, x to the right, y up, z ahead, drawn in to the depths of H. Clip-space w
/// is the view depth.
fn cube_from_world(view: &ViewVolume, visible: &Polytope) -> DMat4 {
    let depths = visible.vertices().iter().map(|vertex| view.depth(*vertex));
    let (nearest, farthest) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), depth| {
        (near.min(depth), far.max(depth))
    });
    let near = nearest.max(view.near());
    let far = farthest.max(near * (1.0 + SMALLEST_RANGE));
    let eye = view.eye();
    let through = |direction: DVec3| direction.extend(-direction.dot(eye));
    let row_depth = through(view.forward());
    let [bottom_left, bottom_right, top_right, top_left, ..] = view.corners(1.0, 1.0).map(|corner| corner - eye);
    let center = (bottom_left + bottom_right + top_right + top_left) * 0.25;
    let row_of_side = |side: DVec3| {
        let scaled = side * (2.0 / side.length_squared());
        through(scaled) - row_depth * scaled.dot(center)
    };
    rows(
        row_of_side(bottom_right - bottom_left),
        row_of_side(top_left - bottom_left),
        row_depth * ((far + near) / (far - near)) - DVec4::W * (2.0 * far * near / (far - near)),
        row_depth,
    )
}

fn rows(x: DVec4, y: DVec4, z: DVec4, w: DVec4) -> DMat4 {
    DMat4::from_cols(x, y, z, w).transpose()
}

/// The middle of the box around the visible body in the cube.
fn middle(visible: &[DVec4]) -> DVec3 {
    let corners = visible.iter().map(|corner| corner.xyz() / corner.w);
    let (min, max) = corners.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), corner| {
        (min.min(corner), max.max(corner))
    });
    (min + max) * 0.5
}
