//! The focus matrix.

use bevy_math::{DMat4, DVec2, DVec3, DVec4, UVec2};

use super::{
    FitInput,
    bodies::{Bodies, ChosenWarp},
    options::DepthRange,
};

/// The focus matrix A_fit (Stingl, equation 3.1) multiplied with the warp, written out so that the uniform map is the
/// exact limit of an infinite n'.
pub(super) struct Focus {
    pub(super) clip_from_light: DMat4,
    pub(super) texel_size: f64,
    pub(super) near_texel_size: f64,
    pub(super) relative_texel_size: f64,
    pub(super) depth_per_metre: f64,
}

impl Focus {
    pub(super) fn new(input: &FitInput, bodies: &Bodies, warp: &ChosenWarp) -> Self {
        let map_size = input.map_size.max(UVec2::ONE).as_dvec2();
        let inner = 1.0 - (2.0 * input.guard_texels.max(0.0) / map_size).min(DVec2::splat(0.5));
        let bend = 1.0 / warp.near;

        let projected = |point: &DVec3| point.x / warp.width(point.y);
        let (left, right) = padded_range(
            bodies.visible.iter().chain(&bodies.body).map(projected),
            bodies.smallest,
        );
        let scale_across = 2.0 * inner.x / (right - left);
        let scale_along = inner.y * (2.0 / bodies.extent + bend);
        let row_across =
            DVec4::new(scale_across, 0.0, 0.0, 0.0) - row_of_width(bend) * (scale_across * (left + right) * 0.5);
        let row_along = DVec4::new(0.0, scale_along, 0.0, -inner.y);

        let texel_sides = |width: f64| {
            DVec2::new(
                2.0 * width / (scale_across * map_size.x),
                width * width / (map_size.y * inner.y * (1.0 / bodies.extent + bend)),
            )
        };
        let near_sides = texel_sides(1.0);
        let middle = bodies.body.iter().map(|point| point.y).sum::<f64>() / bodies.body.len() as f64;
        let texel_size = texel_sides(warp.width(middle)).element_product().sqrt();

        let (casters, room) = match input.options.depths {
            DepthRange::Bodies => (&bodies.body[..], 0.0),
            DepthRange::Receivers { room } => (&[][..], room.max(0.0)),
        };
        let (farthest, nearest) = padded_range(
            bodies.visible.iter().chain(casters).flat_map(|point| {
                let width = warp.width(point.y);
                let margin = 2.0 * texel_sides(width).max_element() + bodies.smallest;
                [-margin, margin + room].map(|offset| (point.z + offset) / width)
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
pub(in crate::maths) fn padded_range(values: impl Iterator<Item = f64>, smallest: f64) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let padding = (smallest - (high - low)).max(0.0) * 0.5;
    (low - padding, high + padding)
}
