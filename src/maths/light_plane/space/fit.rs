//! From a film to the matrix that draws its map.

use bevy_math::{DMat2, DMat3, DMat4, DVec2, DVec3, DVec4, UVec2};

use super::{BaseFilm, Film, FilmError, FilmHull};
use crate::maths::{
    body::nearest_depth,
    fit::{LightAxes, LightFit, padded_range},
    polytope::{HalfSpace, Polytope, PolytopeState},
    view::ViewVolume,
    warp::WarpSpan,
};

/// What a light view of the sun is made from.
#[derive(Clone, Copy, Debug)]
pub struct FilmFitInput<'a> {
    /// The camera's view volume, or a slice of it.
    pub view: &'a ViewVolume,
    /// H (= LVS): the depths of light space are counted from near its nearest point.
    pub visible: &'a Polytope,
    /// B: what casts shadows; decides the depth range.
    pub body: &'a Polytope,
    /// The base film, of the sun.
    pub base: &'a BaseFilm,
    /// The film on it.
    pub film: &'a Film,
    /// The hull that the film was solved for.
    pub hull: &'a FilmHull,
    /// Texels of the map along both sides.
    pub map_size: UVec2,
    /// Texels left free on every side, so that filter kernels read inside the map.
    pub guard_texels: f64,
}

/// The light view of the sun for a film: the same conventions and the same numbers as those of
/// [`fit_light_view`](crate::maths::fit::fit_light_view), with which it shares its users.
///
/// The warp axis y of its light space is the direction along which w rises: that of k, or the base film's where k is 0.
/// The frame may be turned and sheared against it. All receivers in the hull lie inside the clip box with `guard_texels`
/// to spare; all of B that can cast onto the film lies inside its depth range, with two texels to spare. Parts of B beside
/// the film are outside of the clip box, and w may be zero there: the rasteriser clips them.
pub fn fit_film(input: &FilmFitInput) -> Result<LightFit, FilmError> {
    for body in [input.visible, input.body] {
        match body.state() {
            PolytopeState::NotFinite | PolytopeState::Enormous => return Err(FilmError::NotFinite),
            PolytopeState::Empty => return Err(FilmError::NothingVisible),
            _ => {}
        }
    }
    if input.map_size.min_element() == 0 {
        return Err(FilmError::NoTexels);
    }
    if input.guard_texels.is_nan() || !input.film.bend.is_finite() {
        return Err(FilmError::NotFinite);
    }
    let space = FilmSpace::new(input);
    let [row_across, row_along, row_width] = space.rows;
    let caster_column = space.caster_column(input.body);
    if caster_column.is_empty() {
        return Err(FilmError::NothingVisible);
    }
    let smallest = (input.hull_size() * 1.0e-5).max(1.0e-6);
    let (farthest, nearest) = padded_range(
        caster_column.vertices().iter().flat_map(|vertex| {
            let point = space.light_from_world.transform_point3(*vertex);
            let width = row_width.dot(point.extend(1.0));
            let margin = 2.0 * space.texel_sides(*vertex, input).max_element() + smallest;
            [-margin, margin].map(|offset| (point.z + offset) / width)
        }),
        smallest,
    );
    let depth_per_metre = 1.0 / (nearest - farthest);
    let row_depth = (DVec4::Z - row_width * farthest) * depth_per_metre;
    let clip_from_light = DMat4::from_cols(row_across, row_along, row_depth, row_width).transpose();
    let clip_from_world = clip_from_light * space.light_from_world;
    if !clip_from_world.is_finite() {
        return Err(FilmError::NotFinite);
    }
    let at_width = |width: f64| {
        let points = space.hull_at_width(width, input);
        let sides = points.iter().map(|point| space.texel_sides(*point, input));
        sides.fold(DVec2::ZERO, DVec2::max).max_element()
    };
    let middle = caster_column.center();
    Ok(LightFit {
        world_from_light: space.world_from_light,
        clip_from_light,
        clip_from_world,
        axes: space.axes,
        warp_near: space.warp_near,
        eta: space.eta(input),
        texel_size: space.texel_steps(middle, input).determinant().abs().sqrt(),
        near_texel_size: at_width(1.0),
        relative_texel_size: at_width(space.far_width.sqrt()) / space.far_width.sqrt(),
        depth_per_metre,
    })
}

impl FilmFitInput<'_> {
    /// Extent of the hull, in metres.
    fn hull_size(&self) -> f64 {
        let lengths = self.hull.points().iter().map(|point| point.length());
        2.0 * self.base.scale() * lengths.fold(0.0, f64::max)
    }
}

/// Light space of a film.
struct FilmSpace {
    axes: LightAxes,
    world_from_light: DMat4,
    light_from_world: DMat4,
    /// Rows across, along and w, in light space.
    rows: [DVec4; 3],
    warp_near: f64,
    /// w at the near end of the hull before it was scaled to 1 there.
    near_width: f64,
    far_width: f64,
    extent: f64,
}

impl FilmSpace {
    fn new(input: &FilmFitInput) -> Self {
        let (base, bend) = (input.base, input.film.bend);
        let base_axes = base.axes();
        let steepness = bend.length();
        let uphill = bend.try_normalize().unwrap_or(DVec2::Y);
        let y = (base_axes.x * uphill.x + base_axes.y * uphill.y).normalize();
        let axes = LightAxes {
            x: y.cross(base_axes.z),
            y,
            z: base_axes.z,
        };
        let (start, end) = padded_range(input.hull.points().iter().map(|point| point.dot(uphill)), 1.0e-9);
        let (near_width, far_width) = (1.0 + steepness * start, 1.0 + steepness * end);
        let view = input.view;
        let beside = view.eye() + view.forward() * nearest_depth(input.visible, view);
        let on_film = base.center() + y * (start * base.scale());
        let origin = on_film + axes.z * axes.z.dot(beside - on_film);
        let rotation = DMat3::from_cols(axes.x, axes.y, axes.z);
        let world_from_light = DMat4::from_mat3_translation(rotation, origin);
        let light_from_world = DMat4::from_mat3_translation(rotation.transpose(), -(rotation.transpose() * origin));
        let warp_near = if steepness > 0.0 {
            near_width * base.scale() / steepness
        } else {
            f64::INFINITY
        };
        let rows = clip_rows(base, input.film, guard(input.map_size, input.guard_texels)).map(|row| {
            let at_origin = row.dot(origin.extend(1.0));
            (rotation.transpose() * row.truncate()).extend(at_origin) / near_width
        });
        // w is exactly 1 at the origin and has no part along the light.
        let [across, along, _] = rows.map(|row| DVec4 { z: 0.0, ..row });
        Self {
            axes,
            world_from_light,
            light_from_world,
            rows: [across, along, DVec4::new(0.0, 1.0 / warp_near, 0.0, 1.0)],
            warp_near,
            near_width,
            far_width: far_width / near_width,
            extent: (end - start) * base.scale(),
        }
    }

    /// The part of a body that is in the column of light of the map: there w > 0.
    fn caster_column(&self, body: &Polytope) -> Polytope {
        let [across, along, width] = self.rows.map(|row| {
            let normal = self.axes.x * row.x + self.axes.y * row.y;
            normal.extend(row.w - normal.dot(self.world_from_light.w_axis.truncate()))
        });
        let sides = [across - width, -across - width, along - width, -along - width];
        sides.iter().fold(body.clone(), |body, side| {
            body.clip(&HalfSpace {
                normal: side.truncate(),
                distance: -side.w,
            })
        })
    }

    /// Steps of one texel in the light plane, in metres, at a point of the world.
    fn texel_steps(&self, point: DVec3, input: &FilmFitInput) -> DMat2 {
        let film = input.base.film(point).unwrap_or_default();
        let inner = guard(input.map_size, input.guard_texels);
        let steps = input.film.texel_steps(film, input.map_size);
        DMat2::from_cols(steps.x_axis / inner.x, steps.y_axis / inner.y) * input.base.scale()
    }

    fn texel_sides(&self, point: DVec3, input: &FilmFitInput) -> DVec2 {
        let steps = self.texel_steps(point, input);
        DVec2::new(steps.x_axis.length(), steps.y_axis.length())
    }

    /// Points of the hull's outline where w, scaled to 1 at the near end, has a value; all corners if it is the same
    /// everywhere.
    fn hull_at_width(&self, width: f64, input: &FilmFitInput) -> Vec<DVec3> {
        let (base, bend) = (input.base, input.film.bend);
        let corners = input.hull.points();
        let excess = |point: DVec2| (1.0 + bend.dot(point)) - width * self.near_width;
        let crossings = corners.iter().zip(corners.iter().cycle().skip(1)).filter_map(|(a, b)| {
            let (at_a, at_b) = (excess(*a), excess(*b));
            let share = at_a / (at_a - at_b);
            (share.is_finite() && (-1.0e-9..=1.0 + 1.0e-9).contains(&share)).then(|| a.lerp(*b, share))
        });
        let mut points: Vec<DVec2> = crossings.collect();
        if points.is_empty() {
            points.extend(corners);
        }
        let axes = base.axes();
        let in_world = |point: DVec2| base.center() + (axes.x * point.x + axes.y * point.y) * base.scale();
        points.into_iter().map(in_world).collect()
    }

    /// η of this n' for the span along the warp axis.
    fn eta(&self, input: &FilmFitInput) -> f64 {
        let view = input.view;
        if view.is_orthographic() || self.warp_near.is_infinite() {
            return -1.0;
        }
        let near_depth = nearest_depth(input.visible, view);
        let span = WarpSpan::directional(self.extent, near_depth, view.forward().dot(self.axes.y));
        let eta = span.eta(self.warp_near);
        if eta.is_finite() { eta } else { -1.0 }
    }
}

/// Part of the clip box that the film fills.
fn guard(map_size: UVec2, guard_texels: f64) -> DVec2 {
    1.0 - (2.0 * guard_texels.max(0.0) / map_size.as_dvec2()).min(DVec2::splat(0.5))
}

/// Clip rows across, along and w of a film, as linear forms of a world-space point. With v = c + E (ξ, η) and the base
/// film's forms (X, Y) = u w₀ and W = w w₀: (ξ, η) W = E⁻¹ ((X, Y) − c W), and the clip coordinate is 2 ξ − 1 in the inner
/// part.
fn clip_rows(base: &BaseFilm, film: &Film, inner: DVec2) -> [DVec4; 3] {
    let [across, along, _] = base.forms();
    let width = base.width_form(film.bend);
    let frame = &film.frame;
    let [x, y] = [across - width * frame.corner.x, along - width * frame.corner.y];
    let map_from_film = frame.sides.inverse();
    let row = |axis: usize| {
        let places = x * map_from_film.x_axis[axis] + y * map_from_film.y_axis[axis];
        (places * 2.0 - width) * inner[axis]
    };
    [row(0), row(1), width]
}

/// The matrix of a film of a light at a point: a tilted perspective from the light, reverse z.
///
/// Clip-space w is the distance from the plane w = 0, in metres at k = 0; depth is 1 where w is `near_width` and 0 where it
/// is `far_width`, and rises along every ray towards the light. `None` unless 0 < `near_width` < `far_width` and both are
/// finite, and for the sun ([`fit_film`]).
pub fn point_light_clip_from_world(
    base: &BaseFilm,
    film: &Film,
    map_size: UVec2,
    guard_texels: f64,
    near_width: f64,
    far_width: f64,
) -> Option<DMat4> {
    let in_range = near_width > 0.0 && near_width < far_width && far_width.is_finite();
    if base.light().w == 0.0 || !in_range || map_size.min_element() == 0 {
        return None;
    }
    let [across, along, width] = clip_rows(base, film, guard(map_size, guard_texels));
    // near (far − w) ÷ ((far − near) w).
    let depth = (DVec4::W * far_width - width) * (near_width / (far_width - near_width));
    let clip_from_world = DMat4::from_cols(across, along, depth, width).transpose();
    clip_from_world.is_finite().then_some(clip_from_world)
}
