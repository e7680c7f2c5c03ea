//! How much of its maps a technique uses: [`touched_texels`], [`texels_in_view`].
//!
//! The first counts the texels that pixels need; what no pixel sees (ground behind trees, roofs from the street) is wasted.
//! The second is the ideal of a fit that knows the view but not what hides what: texels in the projection of H, the part of
//! the scene's box in the slice of the view that a map is meant for. For Bevy's cascades it is about a third.

use bevy::math::{DMat2, DVec2, DVec3, UVec2};

use super::{
    pixels::{PixelRays, Traced},
    sampling::Camera,
};
use crate::{
    maths::{body::light_visible, bounds::Bounds, view::ViewVolume},
    render::light_maps::{LightMap, LightMaps},
};

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

/// Texels of one map, row by row, a bit each; none of its memory is used before the first is touched.
struct Grid {
    size: UVec2,
    touched: Vec<u64>,
}

impl Grid {
    fn new(size: UVec2) -> Self {
        Self {
            size,
            touched: Vec::new(),
        }
    }

    /// Marks every texel whose square shares an area with the parallelogram around `middle` with the sides `steps`.
    fn touch(&mut self, middle: DVec2, steps: [DVec2; 2]) {
        let half = (steps[0].abs() + steps[1].abs()) * 0.5 - ROUNDING;
        if !middle.is_finite() || !half.is_finite() {
            return;
        }
        let texels = self.size.x as usize * self.size.y as usize;
        self.touched.resize(texels.div_ceil(64), 0);
        let last = (self.size.as_dvec2() - 1.0).max(DVec2::ZERO);
        let low = (middle - half).floor().clamp(DVec2::ZERO, last);
        let high = ((middle + half).ceil() - 1.0).clamp(DVec2::ZERO, last).max(low);
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
                    let texel = y * self.size.x as usize + x;
                    self.touched[texel / 64] |= 1 << (texel % 64);
                }
            }
        }
    }

    fn count(&self) -> u64 {
        self.touched.iter().map(|texels| u64::from(texels.count_ones())).sum()
    }
}

/// Texels of all maps in the projection of the visible part of the scene's box, each map with the slice of the view that it
/// is meant for. Slices that overlap count in every map.
pub fn texels_in_view(maps: &LightMaps, view: &ViewVolume, scene: &Bounds) -> f64 {
    maps.maps.iter().map(|map| area_in_view(map, view, scene)).sum()
}

fn area_in_view(map: &LightMap, view: &ViewVolume, scene: &Bounds) -> f64 {
    let slice = view.split(map.near_depth.max(view.near()), map.far_depth.min(view.far()));
    let visible = light_visible(&slice, scene);
    let corners: Vec<DVec2> = visible.vertices().iter().map(|corner| map.texel(*corner)).collect();
    // Where w is positive, the projection of a convex body is convex.
    let size = map.size.as_dvec2();
    let mut outline = hull(corners);
    for (normal, limit) in [
        (DVec2::X, size.x),
        (DVec2::Y, size.y),
        (DVec2::NEG_X, 0.0),
        (DVec2::NEG_Y, 0.0),
    ] {
        outline = cut(&outline, normal, limit);
    }
    let edges = outline.iter().zip(outline.iter().cycle().skip(1));
    edges.map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs() * 0.5
}

/// The convex hull, counter-clockwise (monotone chain: Andrew 1979).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.retain(|point| point.is_finite());
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain.as_slice()
                && (*b - *a).perp_dot(point - *a) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter().copied());
    outline.extend(half(&mut points.iter().rev().copied()));
    outline
}

/// The part of a convex outline where `point · normal` is at most `limit`.
fn cut(outline: &[DVec2], normal: DVec2, limit: f64) -> Vec<DVec2> {
    let mut kept = Vec::new();
    for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
        let (excess_a, excess_b) = (a.dot(normal) - limit, b.dot(normal) - limit);
        if excess_a <= 0.0 {
            kept.push(*a);
        }
        if (excess_a < 0.0) != (excess_b < 0.0) && excess_a != excess_b {
            kept.push(a.lerp(*b, excess_a / (excess_a - excess_b)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use bevy::math::DMat4;

    use super::*;
    use crate::render::{
        light_maps::Selection,
        reference::pixels::{PixelTruth, SurfacePoint},
    };

    /// A camera 10 m above the ground that looks straight down.
    fn above(tan_half_fov_y: f64) -> PixelRays {
        PixelRays {
            size: UVec2::splat(100),
            eye: DVec3::Y * 10.0,
            right: DVec3::X,
            up: DVec3::NEG_Z,
            forward: DVec3::NEG_Y,
            tan_half_fov_y,
        }
    }

    /// A light straight above: 40 m × 40 m in a map of 200², for a slice of the view.
    fn map(near_depth: f64, far_depth: f64) -> LightMap {
        LightMap {
            clip_from_world: DMat4::from_cols_array_2d(&[
                [0.05, 0.0, 0.0, 0.0],
                [0.0, 0.0, 0.01, 0.0],
                [0.0, -0.05, 0.0, 0.0],
                [0.0, 0.0, 0.5, 1.0],
            ]),
            size: UVec2::splat(200),
            near_depth,
            far_depth,
        }
    }

    fn maps(maps: Vec<LightMap>) -> LightMaps {
        LightMaps {
            maps,
            selection: Selection::Depth,
            distance: 100.0,
            virtual_maps: None,
        }
    }

    #[test]
    fn footprints_touch_texels() {
        let touched = |middle: [f64; 2], steps: [[f64; 2]; 2]| {
            let mut grid = Grid::new(UVec2::splat(8));
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
        let rays = PixelRays { size, ..above(0.005) };
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
        let maps = maps(vec![map(0.1, 100.0)]);
        assert_eq!(touched_texels(&maps, &rays, &traced, DVec3::Y), 25);
        assert_eq!(maps.texels(), 40_000);
    }

    /// From 10 m the slice from 5 m to 8 m is 8 m wide at its far end, which hides its near end: 40² texels of 0.2 m. The
    /// slice down to 100 m is cut by the scene's floor, 30 m below, where it is 30 m wide; and by the map where it is wider.
    #[test]
    fn slices_fill_a_part_of_their_maps() {
        let view = |tan: f64| {
            ViewVolume::perspective(
                DVec3::Y * 10.0,
                DVec3::NEG_Y,
                DVec3::NEG_Z,
                2.0 * f64::atan(tan),
                1.0,
                1.0,
                100.0,
            )
            .expect("a camera")
        };
        let scene = Bounds::new(DVec3::new(-500.0, -20.0, -500.0), DVec3::new(500.0, 9.0, 500.0));
        let texels = |list: Vec<LightMap>, tan: f64| texels_in_view(&maps(list), &view(tan), &scene);
        assert!((texels(vec![map(5.0, 8.0)], 0.5) - 1600.0).abs() < 1.0e-6);
        assert!((texels(vec![map(5.0, 100.0)], 0.5) - 22_500.0).abs() < 1.0e-6);
        assert!((texels(vec![map(5.0, 8.0), map(5.0, 100.0)], 0.5) - 24_100.0).abs() < 1.0e-6);
        assert!(
            (texels(vec![map(5.0, 100.0)], 2.0) - 40_000.0).abs() < 1.0e-6,
            "all of the map"
        );
        let beside = Bounds::new(DVec3::new(400.0, -20.0, 400.0), DVec3::new(500.0, 9.0, 500.0));
        assert_eq!(texels_in_view(&maps(vec![map(5.0, 8.0)]), &view(0.5), &beside), 0.0);
    }
}
