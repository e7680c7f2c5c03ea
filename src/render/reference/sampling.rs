//! Texel ÷ pixel of every valid pixel.
//!
//! The Jacobians and their split are in [`maths::footprint`](crate::maths::footprint). Both numbers that are reported are
//! lengths, so that 2 means twice as coarse:
//!
//! * the *mean size* m = √(texel area ÷ pixel area), both on the receiver's plane. It is exactly perspective × projection
//!   (m_persp = √(w_l² ÷ w_i²), m_proj = √(cos θ_i ÷ cos θ_l), Lloyd et al. 2006, equation 1, in area), it does not depend on
//!   how map and picture are turned, and 1 ÷ m² is the number of texels per pixel that a budget pays for. It is the headline.
//! * the *largest extent*: the longest side of a texel in the picture, whatever its direction (the largest singular value).
//!   An edge may run across it, so it bounds how far a shadow edge is displaced; it has no split into factors.
//!
//! With r the ratio of both singular values, the largest extent is √r times the mean size.

use bevy::math::{DMat4, UVec2};
use serde::{Deserialize, Serialize};

use super::pixels::{PixelRays, SurfacePoint, Traced, rows};
use crate::{
    maths::{
        footprint::{Footprint, texel_footprint, texels_on_pixels},
        sampling_rate::TexelsPerPixel,
    },
    render::light_maps::LightMaps,
};

/// Texel ÷ pixel at one pixel, in the map in which its shadow is looked up. All but `texels_per_pixel` are ratios of lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Index of the map.
    pub map: usize,
    /// m: the root of texel area ÷ pixel area.
    pub mean_size: f64,
    /// The longest extent of a texel in the picture, in pixels.
    pub largest: f64,
    /// The part of `mean_size` that perspective causes.
    pub perspective: f64,
    /// The part that the surface's orientation causes.
    pub projection: f64,
    /// The other way round, and along the axes of the map.
    pub texels_per_pixel: TexelsPerPixel,
}

/// One per pixel; `None` where the pixel does not count or has no map.
pub fn samples(maps: &LightMaps, rays: &PixelRays, traced: &Traced) -> Vec<Option<Sample>> {
    let camera = Camera::new(rays);
    let (width, height) = (rays.size.x as usize, rays.size.y as usize);
    if traced.truth.len() < width * height {
        return Vec::new();
    }
    rows(
        width,
        height,
        |x, y| sample(maps, &camera, traced.valid_point(y * width + x)?),
        &|| {},
    )
}

fn sample(maps: &LightMaps, camera: &Camera, point: &SurfacePoint) -> Option<Sample> {
    let map = maps.select(point.position_world, point.view_depth)?;
    let light_map = maps.maps[map];
    let texel = texel_footprint(&light_map.clip_from_world, light_map.size, point.position_world)?;
    let ratio = texels_on_pixels(&texel, &camera.footprint(point)?, point.normal_world)?;
    Some(Sample {
        map,
        mean_size: ratio.area.sqrt(),
        largest: ratio.largest,
        perspective: ratio.perspective.sqrt(),
        projection: ratio.projection.sqrt(),
        texels_per_pixel: ratio.per_pixel(),
    })
}

/// The picture as a map of its own.
pub(super) struct Camera {
    clip_from_world: DMat4,
    size: UVec2,
}

impl Camera {
    pub(super) fn new(rays: &PixelRays) -> Self {
        Self {
            clip_from_world: rays.clip_from_world(),
            size: rays.size,
        }
    }

    /// The footprint of the pixel that sees a point.
    pub(super) fn footprint(&self, point: &SurfacePoint) -> Option<Footprint> {
        texel_footprint(&self.clip_from_world, self.size, point.position_world)
    }
}

/// Middle and upper end of a distribution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// Half of the values are at most this.
    pub median: f64,
    /// 95 % are.
    pub p95: f64,
    /// 99 % are.
    pub p99: f64,
    /// All are.
    pub max: f64,
}

impl Quantiles {
    /// By nearest rank: each is one of the values. `None` without values.
    pub fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut values: Vec<f64> = values.collect();
        values.sort_by(f64::total_cmp);
        let rank = |share: f64| {
            let rank = (share * values.len() as f64).ceil() as usize;
            values.get(rank.clamp(1, values.len().max(1)) - 1).copied()
        };
        Some(Self {
            median: rank(0.5)?,
            p95: rank(0.95)?,
            p99: rank(0.99)?,
            max: rank(1.0)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{DVec2, DVec3};

    use super::*;
    use crate::{
        maths::sampling_rate::RateMeasure,
        render::{
            light_maps::{LightMap, Selection},
            reference::pixels::PixelTruth,
        },
    };

    /// A camera 10 m above the ground that looks straight down: a pixel covers 0.1 m × 0.1 m.
    fn from_above() -> PixelRays {
        PixelRays {
            size: UVec2::splat(100),
            eye: DVec3::Y * 10.0,
            right: DVec3::X,
            up: DVec3::NEG_Z,
            forward: DVec3::NEG_Y,
            tan_half_fov_y: 0.5,
        }
    }

    /// A light straight above: `width` × `depth` metres in a map of `size`².
    fn map(width: f64, depth: f64, size: u32) -> LightMaps {
        LightMaps {
            maps: vec![LightMap {
                clip_from_world: DMat4::from_cols_array_2d(&[
                    [2.0 / width, 0.0, 0.0, 0.0],
                    [0.0, 0.0, 0.01, 0.0],
                    [0.0, -2.0 / depth, 0.0, 0.0],
                    [0.0, 0.0, 0.5, 1.0],
                ]),
                size: UVec2::splat(size),
                near_depth: 0.1,
                far_depth: 100.0,
            }],
            selection: Selection::Depth,
            distance: 100.0,
            virtual_maps: None,
        }
    }

    fn ground(normal: DVec3) -> SurfacePoint {
        SurfacePoint {
            position_world: DVec3::ZERO,
            normal_world: normal.normalize(),
            view_depth: 10.0,
        }
    }

    #[test]
    fn the_camera_is_its_rays() {
        let rays = PixelRays {
            size: UVec2::new(160, 90),
            eye: DVec3::new(3.0, -2.0, 5.0),
            right: DVec3::X,
            up: DVec3::new(0.0, 0.8, -0.6),
            forward: DVec3::new(0.0, -0.6, -0.8),
            tan_half_fov_y: 0.7,
        };
        for (x, y) in [(0.0, 0.0), (12.5, 80.5), (160.0, 45.0)] {
            let ndc = rays
                .clip_from_world()
                .project_point3(rays.eye + rays.direction(x, y) * 30.0);
            let back = DVec2::new((ndc.x + 1.0) * 80.0, (1.0 - ndc.y) * 45.0);
            assert!(back.distance(DVec2::new(x, y)) < 1.0e-9, "{back}");
        }
    }

    #[test]
    fn texels_are_measured_in_pixels() {
        // 40 m and 10 m in 50 texels: 0.8 m × 0.2 m, on pixels of 0.1 m.
        let found = sample(&map(40.0, 10.0, 50), &Camera::new(&from_above()), &ground(DVec3::Y)).expect("a texel");
        assert!((found.mean_size - 4.0).abs() < 1.0e-9, "{found:?}");
        assert!((found.largest - 8.0).abs() < 1.0e-9, "{found:?}");
        assert!((found.perspective - 4.0).abs() < 1.0e-9 && (found.projection - 1.0).abs() < 1.0e-9);
        let per_pixel = RateMeasure::ALL.map(|measure| found.texels_per_pixel.get(measure));
        for (found, wanted) in per_pixel.into_iter().zip([1.0 / 16.0, 1.0 / 8.0, 1.0 / 2.0]) {
            assert!((found - wanted).abs() < 1.0e-9, "{per_pixel:?}");
        }
        let slope = ground(DVec3::new(1.0, 1.0, 0.0));
        let found = sample(&map(40.0, 10.0, 50), &Camera::new(&from_above()), &slope).expect("a texel");
        assert!(
            (found.mean_size - 4.0).abs() < 1.0e-9,
            "light and viewer see the slope from the same side: {found:?}"
        );
        let outside = SurfacePoint {
            position_world: DVec3::X * 30.0,
            ..ground(DVec3::Y)
        };
        assert_eq!(
            sample(&map(40.0, 10.0, 50), &Camera::new(&from_above()), &outside),
            None
        );
    }

    #[test]
    fn only_valid_pixels_have_samples() {
        let size = UVec2::new(2, 1);
        let rays = PixelRays { size, ..from_above() };
        let traced = Traced {
            truth: vec![PixelTruth::Lit, PixelTruth::Edge],
            points: vec![Some(ground(DVec3::Y)); 2],
        };
        let found = samples(&map(40.0, 10.0, 50), &rays, &traced);
        assert!(
            found.len() == 2 && found[0].is_some() && found[1].is_none(),
            "{found:?}"
        );
    }

    #[test]
    fn quantiles_are_ranks() {
        let found = Quantiles::of((1..=200).rev().map(f64::from)).expect("values");
        assert_eq!(
            (found.median, found.p95, found.p99, found.max),
            (100.0, 190.0, 198.0, 200.0)
        );
        assert_eq!(Quantiles::of([7.0].into_iter()).map(|found| found.p99), Some(7.0));
        assert_eq!(Quantiles::of(std::iter::empty()), None);
    }
}
