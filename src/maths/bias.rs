//! The receiver's plane in a light view: the CPU twin of `shaders/bias.wgsl`, in the same single precision.
//!
//! A texel of a shadow map covers a patch of the receiver; over that patch the receiver's own depth changes. Comparing
//! with the depth of the receiver's *plane* at the texel's center removes this error for planar receivers at any warp,
//! partition and resolution, without a tuned constant.

use bevy_math::{Mat4, Vec2, Vec3, Vec3Swizzles, Vec4Swizzles};

/// Surfaces are treated as if they met the light at this cosine at least (89.4°): beyond it the depth span of a texel
/// grows without limit, while direct light is below a hundredth.
pub const MIN_COS_LIGHT: f32 = 0.01;

/// The receiver's plane in a light view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverPlane {
    /// Texture coordinates in the map, 0..1; y down.
    pub uv: Vec2,
    /// Depth of the receiver, NDC, 1 nearest to the light.
    pub depth_ndc: f32,
    /// Change of depth over the map on the receiver's plane.
    pub depth_per_uv: Vec2,
    /// Change of depth for one metre towards the light.
    pub depth_per_metre: f32,
    /// Area of texture coordinates per square metre of the receiver's plane.
    pub uv_area_per_square_metre: f32,
    /// Perspective divisor.
    pub w: f32,
}

/// The unit normal of the plane's side that looks to the light, turned so far towards it that their cosine is at least
/// [`MIN_COS_LIGHT`]. A plane has no side: light falls through a leaf whose lit side the viewer does not see.
pub fn limited_normal(normal: Vec3, to_light: Vec3) -> Vec3 {
    let cosine = normal.dot(to_light);
    if cosine.abs() >= MIN_COS_LIGHT {
        return normal * cosine.signum();
    }
    let across = normal - cosine * to_light;
    let length = across.length();
    if length < 1e-6 {
        return to_light;
    }
    across / length * (1.0 - MIN_COS_LIGHT * MIN_COS_LIGHT).sqrt() + to_light * MIN_COS_LIGHT
}

/// The plane through a point with a unit normal, seen by a light view; `None` behind its projection centre.
///
/// With clip = M p and ndc = clip.xyz / w, a step t in the world changes ndc by (M t − ndc (row_w · t)) / w. Two steps
/// that span the plane give a 2×2 system for the gradient of depth over (u, v).
pub fn receiver_plane(clip_from_world: Mat4, position: Vec3, normal: Vec3, to_light: Vec3) -> Option<ReceiverPlane> {
    let clip = clip_from_world * position.extend(1.0);
    if clip.w <= 0.0 {
        return None;
    }
    let ndc = clip.xyz() / clip.w;
    let ndc_step = |step: Vec3| ndc_step(clip_from_world, ndc, clip.w, step);
    let to_uv = Vec2::new(0.5, -0.5);
    let n = limited_normal(normal, to_light);
    let helper = if n.x.abs() > 0.7 { Vec3::Y } else { Vec3::X };
    let tangent = n.cross(helper).normalize();
    let bitangent = n.cross(tangent);
    let (step_t, step_b) = (ndc_step(tangent), ndc_step(bitangent));
    let (uv_t, uv_b) = (step_t.xy() * to_uv, step_b.xy() * to_uv);
    let determinant = uv_t.x * uv_b.y - uv_b.x * uv_t.y;
    Some(ReceiverPlane {
        uv: ndc.xy() * to_uv + 0.5,
        depth_ndc: ndc.z,
        depth_per_uv: Vec2::new(
            (step_t.z * uv_b.y - step_b.z * uv_t.y) / determinant,
            (step_b.z * uv_t.x - step_t.z * uv_b.x) / determinant,
        ),
        depth_per_metre: ndc_step(to_light).z,
        uv_area_per_square_metre: determinant.abs(),
        w: clip.w,
    })
}

/// Change of NDC per step t in the world at a point with this NDC and w: (M t − ndc (row_w · t)) ÷ w.
pub(super) fn ndc_step(clip_from_world: Mat4, ndc: Vec3, w: f32, step: Vec3) -> Vec3 {
    let clip_step = clip_from_world * step.extend(0.0);
    (clip_step.xyz() - ndc * clip_step.w) / w
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A warped light view: light from straight above, warp axis −z, eye 5 m behind the origin.
    fn warped() -> Mat4 {
        let rows = [
            [0.2, 0.0, 0.0, 0.0],
            [0.0, 0.0, -1.2, -4.0],
            [0.0, 0.05, 0.0, 0.3],
            [0.0, 0.0, -0.2, 1.0],
        ];
        Mat4::from_cols_array_2d(&rows).transpose()
    }

    #[test]
    fn gradient_predicts_depth_on_the_plane() {
        let m = warped();
        let to_light = Vec3::Y;
        let normal = Vec3::new(0.3, 1.0, -0.4).normalize();
        let position = Vec3::new(0.7, 0.4, -3.0);
        let plane = receiver_plane(m, position, normal, to_light).expect("in front of the centre");
        for step in [
            Vec3::new(0.01, 0.0, 0.0),
            Vec3::new(0.0, 0.0, 0.01),
            Vec3::new(-0.004, 0.0, 0.007),
        ] {
            // Move across the plane: solve the height that keeps the point on it.
            let lifted = step - Vec3::Y * (step.xz().dot(normal.xz()) / normal.y);
            let moved = m.project_point3(position + lifted);
            let uv = Vec2::new(moved.x * 0.5 + 0.5, 0.5 - moved.y * 0.5);
            let predicted = plane.depth_ndc + plane.depth_per_uv.dot(uv - plane.uv);
            let change = (moved.z - plane.depth_ndc).abs();
            assert!(
                (predicted - moved.z).abs() < 0.02 * change + 1e-7,
                "predicted {predicted}, is {}",
                moved.z
            );
        }
    }

    #[test]
    fn metres_towards_the_light_are_depth() {
        let m = warped();
        let position = Vec3::new(0.2, 0.1, -2.0);
        let plane = receiver_plane(m, position, Vec3::Y, Vec3::Y).expect("in front of the centre");
        let moved = m.project_point3(position + Vec3::Y * 0.5);
        assert!(
            (moved.z - plane.depth_ndc - 0.5 * plane.depth_per_metre).abs() < 1e-6,
            "depth is linear along the light"
        );
    }

    #[test]
    fn grazing_and_averted_normals_are_limited() {
        for normal in [
            Vec3::X,
            -Vec3::Y,
            Vec3::new(1.0, -0.5, 0.2).normalize(),
            Vec3::new(1.0, 0.01, 0.0).normalize(),
        ] {
            let limited = limited_normal(normal, Vec3::Y);
            assert!(
                limited.dot(Vec3::Y) >= MIN_COS_LIGHT - 1e-6,
                "{normal} became {limited}"
            );
            assert!((limited.length() - 1.0).abs() < 1e-5, "{limited} is not a unit vector");
        }
        assert!(
            receiver_plane(warped(), Vec3::Z * 6.0, Vec3::Y, Vec3::Y).is_none(),
            "behind the centre"
        );
    }
}
