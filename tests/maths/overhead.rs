//! A map under a light from straight above, for lookups.

use bevy_math::{IVec2, Mat4, Vec2, Vec3, Vec4};
use umbrage::maths::{
    bias::{ReceiverPlane, receiver_plane},
    depth_offset::{DepthFormat, DepthOffset},
    filter::lookup::Lookup,
};

pub(crate) const SIZE: f32 = 64.0;

/// Metres from the middle of the map to its border, and from depth 0 to 1.
pub(crate) const EXTENT: f32 = 16.0;

pub(crate) const HEIGHT: f32 = 40.0;

/// A uniform map under a light from straight above: x right, −z up, depth from −20 m to 20 m.
pub(crate) fn overhead() -> Mat4 {
    let rows = [
        [1.0 / EXTENT, 0.0, 0.0, 0.0],
        [0.0, 0.0, -1.0 / EXTENT, 0.0],
        [0.0, 1.0 / HEIGHT, 0.0, 0.5],
        [0.0, 0.0, 0.0, 1.0],
    ];
    Mat4::from_cols_array_2d(&rows).transpose()
}

pub(crate) fn plane_at(position: Vec3, normal: Vec3) -> ReceiverPlane {
    receiver_plane(overhead(), position, normal.normalize(), Vec3::Y).expect("before the light")
}

pub(crate) fn lookup(plane: ReceiverPlane, offset: DepthOffset) -> Lookup {
    // A square metre of the light plane has the same texture coordinates on any plane above it.
    let cosine = plane.uv_area_per_square_metre * 4.0 * EXTENT * EXTENT;
    let offset = offset.at(&plane, Vec2::splat(SIZE), cosine);
    Lookup {
        plane,
        rect: Vec4::new(128.0, 64.0, SIZE, SIZE),
        bounds: Vec4::new(0.0, 0.0, SIZE - 1.0, SIZE - 1.0),
        offset: offset.depth,
        follows_plane: offset.follows_plane,
    }
}

pub(crate) const MILLIMETRE: DepthOffset = DepthOffset::ReceiverPlane { metres: 0.001 };

/// The height of the nearest surface under a world-space x and z, as the map stores it.
pub(crate) fn atlas(height: impl Fn(f32, f32) -> f32) -> impl Fn(IVec2) -> f32 {
    move |texel| {
        let cell = texel.as_vec2() - Vec2::new(128.0, 64.0);
        assert!(
            cell.min_element() >= 0.0 && cell.max_element() < SIZE,
            "texel {texel} is in another map"
        );
        let place = (cell + 0.5) / SIZE * 2.0 - 1.0;
        height(place.x * EXTENT, place.y * EXTENT) / HEIGHT + 0.5
    }
}

/// The height of a tilted plane through the origin.
pub(crate) fn tilted(normal: Vec3) -> impl Fn(f32, f32) -> f32 {
    move |x, z| -(normal.x * x + normal.z * z) / normal.y
}

pub(crate) fn slope_of(degrees: f32) -> Vec3 {
    let angle = degrees.to_radians();
    Vec3::new(angle.sin(), angle.cos(), 0.0)
}

pub(crate) fn slope_scaled(factor: f32, units: f32) -> DepthOffset {
    DepthOffset::SlopeScaled {
        factor,
        units,
        format: DepthFormat::Float32,
    }
}
