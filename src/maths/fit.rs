//! Body, warp and focus to matrices: [`fit_light_view`].
//!
//! Light space: z points towards the light, y along the projected view direction (the warp axis), x = y × z;
//! right-handed, never mirrored. Its origin lies on the near side of the warp frustum, on the projected view axis.
//! Light clip space: x and y in −1..=1 over the receivers, reverse z: 1 nearest to the light, 0 farthest. The warp is a
//! perspective along +y only, so a point keeps its x, y and w when it moves along the light.

use bevy_math::{DMat3, DMat4, DVec2, DVec3, DVec4, Mat4};

use super::{
    body::nearest_depth,
    bounds::Bounds,
    error::LightSample,
    polytope::{Polytope, PolytopeState},
    view::ViewVolume,
    warp::{Warp, WarpSpan, guarded_eta},
};

/// The axes of light space in the world: an orthonormal right-handed triple.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightAxes {
    /// x = y × z.
    pub x: DVec3,
    /// The warp axis: the view direction projected into the light plane.
    pub y: DVec3,
    /// Towards the light.
    pub z: DVec3,
}

/// Sine of the angle between light and view direction below which the camera's up direction takes over as warp axis.
const PARALLEL_SINE: f64 = 0.01;

impl LightAxes {
    /// Light space for a view direction and the direction in which light travels; none of them needs unit length.
    /// `None` when the light has no direction.
    ///
    /// Where light and view become parallel, the camera's up direction fades in as the warp axis, so that the axes turn
    /// steadily; at one single direction in the middle of the fade no continuous choice exists.
    pub fn new(forward: DVec3, up: DVec3, light_travel: DVec3) -> Option<Self> {
        let z = -light_travel.try_normalize()?;
        let in_light_plane = |direction: DVec3| {
            let direction = direction.normalize_or_zero();
            direction - z * direction.dot(z)
        };
        let ahead = in_light_plane(forward);
        let up = in_light_plane(up).normalize_or_zero();
        let fade = (PARALLEL_SINE - ahead.length()).max(0.0);
        let y = [ahead + up * fade, up, ahead]
            .into_iter()
            .find_map(|axis| (axis.length() > 1.0e-6).then(|| axis.normalize()))
            .unwrap_or_else(|| z.any_orthonormal_vector());
        // Once more, because rounding of a short vector leaves a part along z.
        let y = (y - z * y.dot(z)).normalize();
        Some(Self { x: y.cross(z), y, z })
    }

    fn coordinates(&self, point: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(point), self.y.dot(point), self.z.dot(point))
    }
}

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
    /// Texels per side of the map.
    pub map_size: u32,
    /// Texels left free on every side, so that filter kernels read inside the map.
    pub guard_texels: f64,
    /// Metres left free around the receivers, for lookups that move the receiver before they project it.
    pub guard_metres: f64,
}

/// Why there is no light view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfit {
    /// H is empty: the camera sees nothing of the scene, everything is lit.
    NothingVisible,
    /// The light has no direction.
    NoLightDirection,
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
/// The projection centre is the continuous one of Stingl, section 4.1: beside the point of the view axis at the depth of
/// the nearest point of LVS. It has that point's light-space z too. The papers leave z open, since texels do not depend on
/// it, but depths do: they are (z − z_c) ÷ w, and a step dy along the warp axis on a surface with slope m changes them by
/// (m − (z − z_c) ÷ (n' + y)) dy ÷ w. With z_c at the viewer the second term is the slope of a line from about the eye to
/// the surface, which the view frustum bounds; with z_c in the middle of B, tens of metres above the receivers, it would
/// demand many times the bias. The guard of [`guarded_eta`] weakens the warp where it would do harm. Bodies that are flat
/// along an axis are padded. All of B lies inside the clip box, with `guard_texels` to spare in x and y, and in depth with
/// two local texels (in world space) on both sides.
pub fn fit_light_view(input: &FitInput) -> Fit {
    for body in [input.visible, input.body] {
        match (body.is_empty(), body.state()) {
            (_, PolytopeState::NotFinite) => return Fit::Degenerate(Unfit::NotFinite),
            (_, PolytopeState::Enormous) => return Fit::Degenerate(Unfit::Enormous),
            (true, _) => return Fit::Degenerate(Unfit::NothingVisible),
            _ => {}
        }
    }
    if !input.light_travel.is_finite() || input.guard_texels.is_nan() || input.guard_metres.is_nan() {
        return Fit::Degenerate(Unfit::NotFinite);
    }
    let Some(axes) = LightAxes::new(input.view.forward(), input.view.up(), input.light_travel) else {
        return Fit::Degenerate(Unfit::NoLightDirection);
    };
    let near_depth = nearest_depth(input.visible, input.view);
    let center = axes.coordinates(input.view.eye() + input.view.forward() * near_depth);
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
        return Fit::Degenerate(Unfit::NotFinite);
    }
    Fit::Fitted(LightFit {
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

/// H and B in light space, relative to its origin.
struct Bodies {
    visible: Vec<DVec3>,
    body: Vec<DVec3>,
    /// Light-space y of the near end, in the axes' coordinates.
    start: f64,
    /// The point beside which the projection centre lies, in the axes' coordinates.
    center: DVec3,
    /// d: extent along the warp axis.
    extent: f64,
    /// Lengths below this count as zero and are padded to it.
    smallest: f64,
}

impl Bodies {
    fn new(input: &FitInput, axes: &LightAxes, center: DVec3) -> Self {
        let guard = Bounds::new(DVec3::ZERO, DVec3::ZERO).expanded(input.guard_metres.max(0.0));
        let corners = guard.corners();
        let offsets = if input.guard_metres > 0.0 {
            &corners[..]
        } else {
            &corners[..1]
        };
        let in_light = |body: &Polytope| -> Vec<DVec3> {
            let coordinates = body.vertices().iter().map(|vertex| axes.coordinates(*vertex));
            coordinates
                .flat_map(|point| offsets.iter().map(move |offset| point + offset))
                .collect()
        };
        let (mut visible, mut body) = (in_light(input.visible), in_light(input.body));
        let bounds = Bounds::from_points(visible.iter().chain(&body).copied());
        let smallest = (bounds.size().max_element() * 1.0e-5).max(1.0e-6);
        let extent = bounds.size().y;
        let padding = (smallest - extent).max(0.0) * 0.5;
        let start = bounds.min.y - padding;
        for point in visible.iter_mut().chain(&mut body) {
            *point -= DVec3::new(center.x, start, center.z);
        }
        Self {
            visible,
            body,
            start,
            center,
            extent: extent.max(smallest),
            smallest,
        }
    }

    fn warp(&self, input: &FitInput, axes: &LightAxes, near_depth: f64) -> ChosenWarp {
        if input.view.is_orthographic() || self.extent <= self.smallest {
            return ChosenWarp::UNIFORM;
        }
        let sine = input.view.forward().dot(axes.y);
        let span = WarpSpan::directional(self.extent, near_depth, sine);
        let samples: Vec<LightSample> = input
            .visible
            .vertices()
            .iter()
            .map(|vertex| LightSample {
                across: axes.x.dot(*vertex) - self.center.x,
                along: axes.y.dot(*vertex),
                depth: input.view.depth(*vertex).max(near_depth),
            })
            .collect();
        let eta = guarded_eta(input.warp.eta(), &samples, &span);
        match span.warp_near(eta) {
            f64::INFINITY => ChosenWarp::UNIFORM,
            near => ChosenWarp { near, eta },
        }
    }
}

struct ChosenWarp {
    near: f64,
    eta: f64,
}

impl ChosenWarp {
    const UNIFORM: Self = Self {
        near: f64::INFINITY,
        eta: -1.0,
    };

    /// Clip-space w at a light-space y: 1 at the near end.
    fn width(&self, along: f64) -> f64 {
        1.0 + along / self.near
    }
}

/// The focus matrix A_fit (Stingl, equation 3.1) multiplied with the warp, written out so that the uniform map is the
/// exact limit of an infinite n'.
struct Focus {
    clip_from_light: DMat4,
    texel_size: f64,
    near_texel_size: f64,
    relative_texel_size: f64,
    depth_per_metre: f64,
}

impl Focus {
    fn new(input: &FitInput, bodies: &Bodies, warp: &ChosenWarp) -> Self {
        let map_size = f64::from(input.map_size.max(1));
        let inner = 1.0 - (2.0 * input.guard_texels.max(0.0) / map_size).min(0.5);
        let bend = 1.0 / warp.near;

        let projected = |point: &DVec3| point.x / warp.width(point.y);
        let (left, right) = padded_range(
            bodies.visible.iter().chain(&bodies.body).map(projected),
            bodies.smallest,
        );
        let scale_across = 2.0 * inner / (right - left);
        let scale_along = inner * (2.0 / bodies.extent + bend);
        let row_across =
            DVec4::new(scale_across, 0.0, 0.0, 0.0) - row_of_width(bend) * (scale_across * (left + right) * 0.5);
        let row_along = DVec4::new(0.0, scale_along, 0.0, -inner);

        let texel_sides = |width: f64| {
            DVec2::new(
                2.0 * width / (scale_across * map_size),
                width * width / (map_size * inner * (1.0 / bodies.extent + bend)),
            )
        };
        let near_sides = texel_sides(1.0);
        let middle = bodies.body.iter().map(|point| point.y).sum::<f64>() / bodies.body.len() as f64;
        let texel_size = texel_sides(warp.width(middle)).element_product().sqrt();

        let (farthest, nearest) = padded_range(
            bodies.visible.iter().chain(&bodies.body).flat_map(|point| {
                let width = warp.width(point.y);
                let margin = 2.0 * texel_sides(width).max_element() + bodies.smallest;
                [-margin, margin].map(|offset| (point.z + offset) / width)
            }),
            bodies.smallest,
        );
        let depth_per_metre = 1.0 / (nearest - farthest);
        let row_depth = (DVec4::new(0.0, 0.0, 1.0, 0.0) - row_of_width(bend) * farthest) * depth_per_metre;

        let rows = DMat4::from_cols(row_across, row_along, row_depth, row_of_width(bend));
        Self {
            clip_from_light: rows.transpose(),
            texel_size,
            near_texel_size: near_sides.max_element(),
            relative_texel_size: near_sides.x.max(near_sides.y * warp.width(bodies.extent).sqrt()),
            depth_per_metre,
        }
    }
}

/// w = 1 + y ÷ n'.
fn row_of_width(bend: f64) -> DVec4 {
    DVec4::new(0.0, bend, 0.0, 1.0)
}

/// Smallest and largest value, at least `smallest` apart.
fn padded_range(values: impl Iterator<Item = f64>, smallest: f64) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let padding = (smallest - (high - low)).max(0.0) * 0.5;
    (low - padding, high + padding)
}
