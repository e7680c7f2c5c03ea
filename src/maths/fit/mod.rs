//! Body, warp and focus to matrices: [`fit_light_view`].
//!
//! Light space: z points towards the light, y along the projected view direction (the warp axis), x = y × z;
//! right-handed, never mirrored. Its origin lies on the near side of the warp frustum, on the projected view axis.
//! Light clip space: x and y in −1..=1 over the receivers, reverse z: 1 nearest to the light, 0 farthest. The warp is a
//! perspective along +y only, so a point keeps its x, y and w when it moves along the light.

mod axes;
mod bodies;
mod focus;
mod options;

use bevy_math::{DMat3, DMat4, DVec3, Mat4, UVec2};

use super::{
    body::nearest_depth,
    polytope::{Polytope, PolytopeState},
    view::ViewVolume,
    warp::Warp,
};
use axes::light_axes;
use bodies::Bodies;
use focus::Focus;
pub(in crate::maths) use focus::padded_range;

pub use axes::LightAxes;
pub use options::{DepthRange, FitOptions, ProjectionCenter, WarpAxis};

/// What a light view is fitted to.
#[derive(Clone, Copy, Debug)]
pub struct FitInput<'a> {
    /// The camera's view volume, or a slice of it.
    pub view: &'a ViewVolume,
    /// H (= LVS) of that slice: what receives shadows; decides x, y and the warp.
    pub visible: &'a Polytope,
    /// B of that slice: what casts them; decides the depth range.
    pub body: &'a Polytope,
    /// Direction in which light travels.
    pub light_travel: DVec3,
    /// Strength of the warp. Orthographic cameras always get a uniform map.
    pub warp: Warp,
    /// Texels of the map across and along the warp axis.
    pub map_size: UVec2,
    /// Texels left free on every side, so that filter kernels read inside the map.
    pub guard_texels: f64,
    /// Metres left free around the receivers, for lookups that move the receiver before they project it.
    pub guard_metres: f64,
    /// Variants of the papers.
    pub options: FitOptions,
}

impl FitInput<'_> {
    /// Names bodies that cannot be fitted.
    pub(super) fn checked_bodies(&self) -> Result<(), Unfit> {
        for body in [self.visible, self.body] {
            match (body.is_empty(), body.state()) {
                (_, PolytopeState::NotFinite) => return Err(Unfit::NotFinite),
                (_, PolytopeState::Enormous) => return Err(Unfit::Enormous),
                (true, _) => return Err(Unfit::NothingVisible),
                _ => {}
            }
        }
        Ok(())
    }
}

/// Why there is no light view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfit {
    /// H is empty: the camera sees nothing of the scene, everything is lit.
    NothingVisible,
    /// The light has no direction.
    NoLightDirection,
    /// [`WarpAxis::Direction`] has no length across the light.
    NoWarpAxis,
    /// NaN among the inputs.
    NotFinite,
    /// The scene is too large for the numbers.
    Enormous,
}

/// The outcome of [`fit_light_view`].
#[derive(Clone, Debug, PartialEq)]
pub enum Fit {
    /// A light view.
    Fitted(LightFit),
    /// None, and why.
    Degenerate(Unfit),
}

impl Fit {
    /// The light view, if there is one.
    pub fn fitted(self) -> Option<LightFit> {
        match self {
            Self::Fitted(fit) => Some(fit),
            Self::Degenerate(_) => None,
        }
    }
}

/// A light view: the matrices that draw and read one map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightFit {
    /// Rigid: the axes of light space as columns, and its origin.
    pub world_from_light: DMat4,
    /// Warp and focus together.
    pub clip_from_light: DMat4,
    /// `clip_from_light · light_from_world`.
    pub clip_from_world: DMat4,
    /// The axes of light space.
    pub axes: LightAxes,
    /// n': distance from the projection centre to the near side of the warp frustum, in metres. Infinite: uniform.
    pub warp_near: f64,
    /// The strength that was used, after the guard: −1 uniform, 0 `LiSPSM`, 1 `PSM`.
    pub eta: f64,
    /// Mean side of a texel at the middle of B, in metres in the light plane.
    pub texel_size: f64,
    /// The larger side of a texel at the near end of the warp, in metres.
    pub near_texel_size: f64,
    /// The larger side of a texel divided by its clip-space w, in metres, where w is the geometric mean of its values at
    /// both ends of the map (1 at the near end). Across the warp axis a texel is w times as wide as at the near end, along
    /// it w² times as long.
    pub relative_texel_size: f64,
    /// Depth per metre along the light, times w: at a point with clip-space w, one metre towards the light raises the
    /// depth by `depth_per_metre / w`.
    pub depth_per_metre: f64,
}

impl LightFit {
    /// [`Self::world_from_light`] in single precision.
    pub fn world_from_light_f32(&self) -> Mat4 {
        self.world_from_light.as_mat4()
    }

    /// [`Self::clip_from_light`] in single precision.
    pub fn clip_from_light_f32(&self) -> Mat4 {
        self.clip_from_light.as_mat4()
    }

    /// [`Self::clip_from_world`] in single precision, rounded once at the end.
    pub fn clip_from_world_f32(&self) -> Mat4 {
        self.clip_from_world.as_mat4()
    }

    /// Depth change per metre towards the light at a world-space point, in units of the depth range 0..=1. Zero behind
    /// the projection centre.
    pub fn depth_per_metre_at(&self, point: DVec3) -> f64 {
        let w = (self.clip_from_world * point.extend(1.0)).w;
        if w > 0.0 { self.depth_per_metre / w } else { 0.0 }
    }
}

/// Fits a light view: align light space with the view, warp, focus on the bodies (Stingl, sections 3.1.2 and 3.2.1).
///
/// The projection centre is the continuous one of Stingl, section 4.1, unless [`FitOptions::center`] says otherwise: beside the point of the view axis at the depth of
/// the nearest point of LVS. It has the light-space z of that point of the view axis too. Texels do not depend on z; Lloyd and
/// Stingl leave it open, and Scherzer 2005, section 4.4, takes that of the eye, which is n cos γ away. Depths do depend on
/// it: they are (z − z_c) ÷ w, and a step dy along the warp axis on a surface with slope m changes them by
/// (m − (z − z_c) ÷ (n' + y)) dy ÷ w. With z_c at the viewer the second term is the slope of a line from about the eye to
/// the surface, which the view frustum bounds; with z_c in the middle of B, tens of metres above the receivers, it would
/// demand many times the bias. The guard of [`guarded_eta`](super::warp::guarded_eta) weakens the warp where it would do harm. Bodies that are flat
/// along an axis are padded. All of B lies inside the clip box, with `guard_texels` to spare in x and y, and in depth with
/// two local texels (in world space) on both sides; with [`DepthRange::Receivers`] H alone does in depth, and what of B is
/// nearer to the light has depths above 1.
pub fn fit_light_view(input: &FitInput) -> Fit {
    match fitted(input) {
        Ok(fit) => Fit::Fitted(fit),
        Err(unfit) => Fit::Degenerate(unfit),
    }
}

fn fitted(input: &FitInput) -> Result<LightFit, Unfit> {
    input.checked_bodies()?;
    let guards_are_nan = input.guard_texels.is_nan() || input.guard_metres.is_nan();
    if !input.light_travel.is_finite() || guards_are_nan || input.options.is_nan() {
        return Err(Unfit::NotFinite);
    }
    let axes = light_axes(input)?;
    let near_depth = nearest_depth(input.visible, input.view);
    let center = projection_center(input, &axes, near_depth);
    let bodies = Bodies::new(input, &axes, center);
    let warp = bodies.warp(input, &axes, near_depth);
    let focus = Focus::new(input, &bodies, &warp);

    let origin = axes.x * center.x + axes.y * bodies.start + axes.z * center.z;
    let rotation = DMat3::from_cols(axes.x, axes.y, axes.z);
    let world_from_light = DMat4::from_mat3_translation(rotation, origin);
    let light_from_world = DMat4::from_mat3_translation(rotation.transpose(), -(rotation.transpose() * origin));
    let clip_from_light = focus.clip_from_light;
    let clip_from_world = clip_from_light * light_from_world;
    if !clip_from_world.is_finite() {
        return Err(Unfit::NotFinite);
    }
    Ok(LightFit {
        world_from_light,
        clip_from_light,
        clip_from_world,
        axes,
        warp_near: warp.near,
        eta: warp.eta,
        texel_size: focus.texel_size,
        near_texel_size: focus.near_texel_size,
        relative_texel_size: focus.relative_texel_size,
        depth_per_metre: focus.depth_per_metre,
    })
}

/// The point beside which the projection centre lies, in the axes' coordinates: its x and z count.
fn projection_center(input: &FitInput, axes: &LightAxes, near_depth: f64) -> DVec3 {
    let view = input.view;
    let on_view_axis = axes.coordinates(view.eye() + view.forward() * near_depth);
    match (input.options.center, input.options.axis) {
        (ProjectionCenter::Continuous, WarpAxis::View) => on_view_axis,
        (ProjectionCenter::Continuous, _) => on_view_axis.with_x(axes.coordinates(view.eye()).x),
        (ProjectionCenter::NearestVertex, _) => {
            let vertices = input.visible.vertices().iter();
            let nearest = vertices.min_by(|a, b| view.depth(**a).total_cmp(&view.depth(**b)));
            nearest.map_or(on_view_axis, |vertex| axes.coordinates(*vertex))
        }
    }
}
