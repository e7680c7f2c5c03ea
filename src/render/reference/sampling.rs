//! Texel ÷ pixel of every valid pixel, and the texels that visible receivers touch.
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

use bevy::math::{DMat2, DMat4, DVec2, DVec3, UVec2};

use serde::{Deserialize, Serialize};

use super::{
    light_maps::LightMaps,
    pixels::{PixelRays, SurfacePoint, Traced, rows},
};
use crate::maths::footprint::{Footprint, texel_footprint, texels_on_pixels};

/// Texel ÷ pixel at one pixel, in the map in which its shadow is looked up. All are ratios of lengths.
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
    let texel = texel_footprint(
        &light_map.clip_from_world,
        UVec2::splat(light_map.size),
        point.position_world,
    )?;
    let ratio = texels_on_pixels(&texel, &camera.footprint(point)?, point.normal_world)?;
    Some(Sample {
        map,
        mean_size: ratio.area.sqrt(),
        largest: ratio.largest,
        perspective: ratio.perspective.sqrt(),
        projection: ratio.projection.sqrt(),
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

/// Texels of all maps that the footprint of at least one visible receiver's pixel touches.
///
/// A visible receiver is a surface that a pixel sees and that faces the light, valid or not: what is left out of accuracy
/// needs its shadow all the same. The pixel's footprint on the receiver's plane is a parallelogram in the map.
pub fn touched_texels(maps: &LightMaps, rays: &PixelRays, traced: &Traced, to_light: DVec3) -> u64 {
    let camera = Camera::new(rays);
    let mut grids: Vec<Grid> = maps.maps.iter().map(|map| Grid::new(map.size)).collect();
    for point in traced.points.iter().flatten() {
        if point.normal_world.dot(to_light) <= 0.0 {
            continue;
        }
        let Some(index) = maps.select(point.position_world, point.view_depth) else {
            continue;
        };
        let map = &maps.maps[index];
        let Some(pixel) = camera.footprint(point) else {
            continue;
        };
        let middle = map.texel(point.position_world);
        // Steps of one pixel on the receiver's plane, as steps in the map: exact for their ends.
        let steps = pixel
            .on_plane(point.normal_world)
            .map(|step| map.texel(point.position_world + step * 0.5) - map.texel(point.position_world - step * 0.5));
        grids[index].touch(middle, steps);
    }
    grids.iter().map(Grid::count).sum()
}

/// Overlaps below it, in texels or pixels, are rounding.
const ROUNDING: f64 = 1.0e-6;

/// Texels of one map, row by row.
struct Grid {
    size: u32,
    touched: Vec<bool>,
}

impl Grid {
    fn new(size: u32) -> Self {
        Self {
            size,
            touched: vec![false; size as usize * size as usize],
        }
    }

    /// Marks every texel whose square shares an area with the parallelogram around `middle` with the sides `steps`.
    fn touch(&mut self, middle: DVec2, steps: [DVec2; 2]) {
        let half = (steps[0].abs() + steps[1].abs()) * 0.5 - ROUNDING;
        if !middle.is_finite() || !half.is_finite() {
            return;
        }
        let last = f64::from(self.size) - 1.0;
        let low = (middle - half).floor().clamp(DVec2::ZERO, DVec2::splat(last));
        let high = ((middle + half).ceil() - 1.0)
            .clamp(DVec2::ZERO, DVec2::splat(last))
            .max(low);
        // Separating axes: those of the squares are the bounds above, those of the parallelogram are these.
        let sides = DMat2::from_cols(steps[0], steps[1]);
        let from_map = (sides.determinant().abs() > 1.0e-12).then(|| sides.inverse());
        let reach = from_map
            .map(|from_map| DVec2::splat(0.5 - ROUNDING) + (from_map.x_axis.abs() + from_map.y_axis.abs()) * 0.5);
        for y in low.y as usize..=high.y as usize {
            for x in low.x as usize..=high.x as usize {
                let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let is_touched = match (from_map, reach) {
                    (Some(from_map), Some(reach)) => (from_map * (center - middle)).abs().cmplt(reach).all(),
                    // Seen edge-on it is a line: all of its bounds count.
                    _ => true,
                };
                if is_touched {
                    self.touched[y * self.size as usize + x] = true;
                }
            }
        }
    }

    fn count(&self) -> u64 {
        self.touched.iter().filter(|touched| **touched).count() as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::reference::{
        light_maps::{LightMap, Selection},
        pixels::PixelTruth,
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
                size,
                far_depth: 100.0,
            }],
            selection: Selection::Depth,
            distance: 100.0,
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

    #[test]
    fn footprints_touch_texels() {
        let touched = |middle: [f64; 2], steps: [[f64; 2]; 2]| {
            let mut grid = Grid::new(8);
            grid.touch(middle.into(), steps.map(DVec2::from));
            grid.count()
        };
        assert_eq!(touched([2.5, 2.5], [[0.2, 0.0], [0.0, 0.2]]), 1, "inside one texel");
        assert_eq!(touched([3.0, 2.5], [[0.2, 0.0], [0.0, 0.2]]), 2, "across a border");
        assert_eq!(touched([3.0, 3.0], [[2.0, 0.0], [0.0, 2.0]]), 4, "exactly four");
        // A diamond with corners 2 from its middle: all of the inner 2 × 2, and two texels beyond each side, as the corners
        // of 4 × 4 stay free.
        assert_eq!(touched([4.0, 4.0], [[2.0, 2.0], [-2.0, 2.0]]), 12, "a diamond");
        assert_eq!(
            touched([0.0, 0.0], [[2.0, 0.0], [0.0, 2.0]]),
            1,
            "at the border of the map"
        );
        assert_eq!(touched([f64::NAN, 0.0], [[2.0, 0.0], [0.0, 2.0]]), 0);
    }

    #[test]
    fn receivers_touch_what_pixels_cover() {
        // 100 pixels of 0.1 m × 0.1 m in a row, half of them facing away; texels of 0.2 m in a map of 40 m.
        let size = UVec2::new(100, 1);
        let rays = PixelRays {
            size,
            tan_half_fov_y: 0.005,
            ..from_above()
        };
        let points = (0..100).map(|x| {
            Some(SurfacePoint {
                position_world: DVec3::new(f64::from(x) * 0.1 - 4.95, 0.0, 0.1),
                normal_world: if x < 50 { DVec3::Y } else { DVec3::NEG_Y },
                view_depth: 10.0,
            })
        });
        let traced = Traced {
            truth: vec![PixelTruth::Unsure; 100],
            points: points.collect(),
        };
        let maps = map(40.0, 40.0, 200);
        assert_eq!(touched_texels(&maps, &rays, &traced, DVec3::Y), 25);
        assert_eq!(maps.texels(), 40_000);
    }
}
