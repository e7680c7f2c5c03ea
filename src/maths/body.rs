//! The bodies of focusing: H, LVS and B (Stingl, section 3.1.1; Wimmer and Scherzer 2006).

use bevy_math::DVec3;

use super::{
    bounds::Bounds,
    polytope::{HalfSpace, Polytope, PolytopeState, RELATIVE_TOLERANCE, magnitude},
    view::ViewVolume,
};

/// H = V ∩ S: what the camera can see of the scene. For the sun, whose light reaches everywhere, it is also the light
/// visible set LVS = L ∩ V ∩ S.
///
/// Built by clipping the scene's box, so that an infinite far plane is exact. Empty when the camera sees nothing of the
/// scene; NaN and huge boxes are named by [`Polytope::state`].
pub fn light_visible(view: &ViewVolume, scene: &Bounds) -> Polytope {
    view.half_spaces()
        .iter()
        .fold(Polytope::from_box(scene.min, scene.max), |body, half_space| {
            body.clip(half_space)
        })
}

/// The intersection body B of a directional light: everything in the scene that can cast a shadow into H, and H itself.
///
/// `light_travel` is the direction in which light travels. B is H swept towards the light past the scene, cut with the
/// scene's box (Stingl, section 3.1.1). It is computed without a hull: the sweep of H is bounded by those faces of H
/// that do not look towards the light, and by planes through the silhouette edges along the light. Every such
/// half-space contains the whole sweep whatever rounding does to its normal, because its distance is the support of H;
/// rounding can only make B larger.
pub fn intersection_body(visible: &Polytope, scene: &Bounds, light_travel: DVec3) -> Polytope {
    if visible.is_empty() {
        return visible.clone();
    }
    let Some(light) = light_travel.try_normalize() else {
        return Polytope::refused(PolytopeState::NotFinite);
    };
    let mut body = Polytope::from_box(scene.min, scene.max);
    for face in visible.faces() {
        if face.half_space.normal.dot(light) >= 0.0 {
            body = body.clip(&face.half_space);
        }
    }
    let tolerance = RELATIVE_TOLERANCE * magnitude(visible.vertices());
    let center = visible.center();
    for [a, b] in visible.silhouette(-light) {
        let [a, b] = [a, b].map(|index| visible.vertices()[index as usize]);
        let across = (b - a).cross(light);
        if across.length() <= tolerance {
            continue;
        }
        let normal = across.normalize();
        let inwards = normal.dot(center - a);
        if inwards <= tolerance {
            body = body.clip(&supporting(visible, normal));
        }
        if inwards >= -tolerance {
            body = body.clip(&supporting(visible, -normal));
        }
    }
    body
}

/// The tightest half-space with this normal that contains the body.
fn supporting(body: &Polytope, normal: DVec3) -> HalfSpace {
    HalfSpace {
        normal,
        distance: body
            .vertices()
            .iter()
            .map(|vertex| normal.dot(*vertex))
            .fold(f64::NEG_INFINITY, f64::max),
    }
}

/// Nearest and farthest view depth of H (Stingl, section 3.3.1), inside the view's own near and far. `None` when H is
/// empty. The interval is never empty: that of a flat body that faces the camera is widened by a millionth.
pub fn adjusted_depths(visible: &Polytope, view: &ViewVolume) -> Option<(f64, f64)> {
    if visible.is_empty() {
        return None;
    }
    let (nearest, farthest) = depth_range(visible, view);
    let near = nearest.max(view.near());
    let far = farthest.min(view.far());
    Some((near, far.max(near + 1.0e-6 * near.abs().max(1.0))))
}

fn depth_range(visible: &Polytope, view: &ViewVolume) -> (f64, f64) {
    visible
        .vertices()
        .iter()
        .map(|vertex| view.depth(*vertex))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), depth| {
            (near.min(depth), far.max(depth))
        })
}

/// View depth of the point of H that is nearest to the eye (e of the papers), never behind the near plane.
pub(super) fn nearest_depth(visible: &Polytope, view: &ViewVolume) -> f64 {
    depth_range(visible, view).0.max(view.near())
}
