//! [`FilmSample`]: a pixel of the picture as the base film sees it.

use bevy_math::{DMat2, DMat3, DMat4, DVec2, DVec3, UVec2, Vec4Swizzles};
use thiserror::Error;

use super::BaseFilm;
use crate::maths::footprint::texel_footprint;

/// Surfaces are treated as if they met the light at this cosine at least (87.1°). A texel on grazed surfaces covers any
/// number of pixels, and a few of them would decide everything, though they get little light.
pub const LEAST_COSINE: f64 = 0.05;

/// A corner of a pixel whose view depth exceeds the sample's by this factor is taken from the sample's derivatives: the
/// plane of the surface runs out of the picture there.
const LARGEST_DEPTH_RATIO: f64 = 4.0;

/// A regular grid of samples in the camera's picture, such as every 16th pixel of a depth buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleGrid {
    /// The camera's matrix.
    pub clip_from_world: DMat4,
    /// Pixels of the whole picture: footprints are counted in these.
    pub picture_size: UVec2,
    /// Samples across and down the picture. Each stands for its share of the pixels.
    pub samples: UVec2,
}

/// Why a pixel is no sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Unsampled {
    /// NaN or an infinity in position, normal or matrix.
    #[error("position or normal are not finite")]
    NotFinite,
    /// Behind the camera, or beside or behind the light.
    #[error("the point is not in front of camera and light")]
    NotInFront,
    /// The surface looks away from the light: it is dark without a shadow map.
    #[error("the surface faces away from the light")]
    FacesAway,
    /// The surface is edge-on to the camera.
    #[error("the surface is edge-on to the camera")]
    EdgeOn,
}

/// A pixel of the picture on the base film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmSample {
    /// u: where its middle lies on the film.
    pub film: DVec2,
    /// J: pixels per unit of film.
    pub pixels_from_film: DMat2,
    /// Corners of what the sample stands for, on the film.
    pub corners: [DVec2; 4],
    /// Pixels that the sample stands for.
    pub pixels: f64,
    /// Least and greatest view depth of its middle and corners: w of the camera's matrix.
    pub depths: [f64; 2],
}

impl FilmSample {
    /// The sample at a surface point with a normal that looks to the viewer; the normal need not have unit length.
    ///
    /// A step of one pixel on the surface is that of [`Footprint::on_plane`](crate::maths::footprint::Footprint::on_plane),
    /// exact for the surface's plane: unlike the thesis's step (section 2.1.3) it follows the depth of the surface. Corners
    /// are where the rays of the pixel's corners meet that plane, so that the samples of a plane leave no gap.
    pub fn new(base: &BaseFilm, grid: &SampleGrid, position: DVec3, normal: DVec3) -> Result<Self, Unsampled> {
        let normal = match normal.try_normalize() {
            Some(normal) if position.is_finite() => normal,
            _ => return Err(Unsampled::NotFinite),
        };
        let to_light = base.light().xyz() - position * base.light().w;
        let normal = limited_normal(normal, to_light.normalize_or_zero()).ok_or(Unsampled::FacesAway)?;
        let film = base.film(position).ok_or(Unsampled::NotInFront)?;
        let pixel = texel_footprint(&grid.clip_from_world, grid.picture_size, position).ok_or(Unsampled::NotInFront)?;
        let steps = pixel.on_plane(normal);
        let gradients = base.film_gradients(position);
        let film_from_pixels =
            DMat2::from_cols_array_2d(&steps.map(|step| gradients.map(|gradient| gradient.dot(step))));
        let pixels_from_film = film_from_pixels.inverse();
        if !film_from_pixels.is_finite() || !pixels_from_film.is_finite() {
            return Err(Unsampled::EdgeOn);
        }
        let share = grid.picture_size.as_dvec2() / grid.samples.max(UVec2::ONE).as_dvec2();
        let depth = (grid.clip_from_world * position.extend(1.0)).w;
        let mut depths = [depth; 2];
        let corners = CORNERS.map(|corner| {
            let offset = corner * share * 0.5;
            let exact = point_at_pixel(grid, position, normal, offset)
                .and_then(|(point, depth)| Some((base.film(point)?, depth)));
            let (corner, depth) = exact.unwrap_or((film + film_from_pixels * offset, depth));
            depths = [depths[0].min(depth), depths[1].max(depth)];
            corner
        });
        Ok(Self {
            film,
            pixels_from_film,
            corners,
            pixels: share.element_product(),
            depths,
        })
    }
}

const CORNERS: [DVec2; 4] = [
    DVec2::new(-1.0, -1.0),
    DVec2::new(1.0, -1.0),
    DVec2::new(1.0, 1.0),
    DVec2::new(-1.0, 1.0),
];

/// The normal, turned towards the light where it meets it at less than [`LEAST_COSINE`]; `None` if it looks away.
fn limited_normal(normal: DVec3, to_light: DVec3) -> Option<DVec3> {
    let cosine = normal.dot(to_light);
    if cosine >= LEAST_COSINE {
        return Some(normal);
    }
    let across = (normal - to_light * cosine).normalize_or_zero();
    (cosine > 0.0).then(|| across * (1.0 - LEAST_COSINE * LEAST_COSINE).sqrt() + to_light * LEAST_COSINE)
}

/// The point of a plane that appears some pixels beside a point of it, and its view depth. With rows m of the camera's matrix and the picture
/// coordinate X of the wanted point, (m_x − X m_w) · p = 0, likewise for Y, and n · (p − position) = 0.
fn point_at_pixel(grid: &SampleGrid, position: DVec3, normal: DVec3, pixels: DVec2) -> Option<(DVec3, f64)> {
    let clip = grid.clip_from_world * position.extend(1.0);
    let wanted = clip.xy() / clip.w + pixels * 2.0 / grid.picture_size.as_dvec2();
    let row_w = grid.clip_from_world.row(3);
    let [x, y] = [0, 1].map(|axis| grid.clip_from_world.row(axis) - row_w * wanted[axis]);
    let matrix = DMat3::from_cols(x.xyz(), y.xyz(), normal).transpose();
    let excess = DVec3::new(x.dot(position.extend(1.0)), y.dot(position.extend(1.0)), 0.0);
    let point = position - matrix.inverse() * excess;
    let depth = row_w.dot(point.extend(1.0));
    (point.is_finite() && depth > 0.0 && depth < LARGEST_DEPTH_RATIO * clip.w).then_some((point, depth))
}
