//! Exactly stable uniform maps: focus on the bounding sphere of a view slice, snap to whole texels (Stingl 2011,
//! section 3.5, exact solution; Lloyd et al. 2006, section 7, after J. Blow).
//!
//! A sphere looks the same from every side, so its size on the map does not change when the camera turns or walks, and
//! the map follows the camera in steps of whole texels. Scene bounds and adjusted depths must not enter: they change
//! with the camera.

use bevy_math::{DMat4, DVec2, DVec3, DVec4};

use crate::maths::{fit::LightAxes, view::ViewVolume};

/// A sphere in world space, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its middle.
    pub center: DVec3,
    /// Its radius.
    pub radius: f64,
}

/// Radii are rounded up to one of this many steps per power of two, so that rounding errors of the camera's place do
/// not change them.
const RADIUS_STEPS: f64 = 1024.0;

/// A sphere around a view slice whose radius depends on the shape of the slice alone. `None` for an infinite far plane.
///
/// Its middle lies on the axis of the slice, as far from the near corners as from the far ones: with R their distances
/// from the axis, at depth (f² + R_f² − n² − R_n²) ÷ 2 (f − n), or at the far plane if that is nearer.
pub fn bounding_sphere(slice: &ViewVolume) -> Option<Sphere> {
    let (near, far) = (slice.near(), slice.far());
    if !far.is_finite() {
        return None;
    }
    let corners = slice.corners(near, far).map(|corner| corner - slice.eye());
    let widest = |corners: &[DVec3]| {
        let distances = corners
            .iter()
            .map(|corner| corner.reject_from(slice.forward()).length());
        distances.fold(0.0, f64::max)
    };
    let (near_width, far_width) = (widest(&corners[..4]), widest(&corners[4..]));
    let even = (far * far + far_width * far_width - near * near - near_width * near_width) / (2.0 * (far - near));
    let depth = even.clamp(near, far);
    let radius = (far_width.hypot(far - depth)).max(near_width.hypot(depth - near));
    let step = radius.log2().floor().exp2() / RADIUS_STEPS;
    Some(Sphere {
        center: slice.eye() + slice.forward() * depth,
        radius: (radius * (1.0 - 1.0e-9) / step).ceil() * step,
    })
}

/// A uniform map whose texels lie on a fixed grid of the light plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SnappedMap {
    /// Middle in the light plane (x and y of the axes), a multiple of the texel.
    pub center: DVec2,
    /// Sides of a texel, metres.
    pub texel: DVec2,
    /// Texels per side.
    pub map_size: u32,
}

impl SnappedMap {
    /// The map around `center` that shows at least `half_extent` metres to each side. At least two texels per side.
    ///
    /// Snapping moves the middle by up to half a texel, so a map of N texels shows N − 1: texel = 2 h ÷ (N − 1).
    pub fn new(center: DVec2, half_extent: DVec2, map_size: u32) -> Self {
        let map_size = map_size.max(2);
        let texel = half_extent * (2.0 / f64::from(map_size - 1));
        Self {
            center: (center / texel + 0.5).floor() * texel,
            texel,
            map_size,
        }
    }

    /// Of a sphere: square texels, the same wherever the sphere is.
    pub fn around(sphere: &Sphere, axes: &LightAxes, map_size: u32) -> Self {
        let center = DVec2::new(axes.x.dot(sphere.center), axes.y.dot(sphere.center));
        Self::new(center, DVec2::splat(sphere.radius), map_size)
    }

    /// World to clip space, reverse z: depth 0 and 1 at these light-space z.
    pub fn clip_from_world(&self, axes: &LightAxes, farthest: f64, nearest: f64) -> DMat4 {
        let scale = DVec2::splat(2.0 / f64::from(self.map_size)) / self.texel;
        let depth_per_metre = 1.0 / (nearest - farthest);
        let rows = DMat4::from_cols(
            (axes.x * scale.x).extend(-self.center.x * scale.x),
            (axes.y * scale.y).extend(-self.center.y * scale.y),
            (axes.z * depth_per_metre).extend(-farthest * depth_per_metre),
            DVec4::W,
        );
        rows.transpose()
    }
}
