//! The bodies of focusing: H, LVS and B (Stingl, section 3.1.1; Wimmer and Scherzer 2006).

use bevy_math::DVec3;

use super::{
    bounds::Bounds,
    light::{Light, LightError},
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

/// LVS = L ∩ V ∩ S: what the camera can see of the scene inside the light's volume (Stingl, section 3.2.1). Equal to
/// [`light_visible`] for the sun. Empty when the light reaches nothing that is seen.
pub fn lit_visible(view: &ViewVolume, scene: &Bounds, light: &Light) -> Result<Polytope, LightError> {
    let visible = light_visible(view, scene);
    Ok(light.half_spaces()?.iter().fold(visible, Polytope::clip))
}

/// The intersection body B of a directional light: everything in the scene that can cast a shadow into H, and H itself.
///
/// `light_travel` is the direction in which light travels. B is H swept towards the light past the scene, cut with the
/// scene's box (Stingl, section 3.1.1). It is computed without a hull: the sweep of H is bounded by those faces of H
/// that do not look towards the light, and by planes through the silhouette edges along the light. Every such
/// half-space contains the whole sweep whatever rounding does to its normal, because its distance is the support of H;
/// rounding can only make B larger.
pub fn intersection_body(visible: &Polytope, scene: &Bounds, light_travel: DVec3) -> Polytope {
    match light_travel.try_normalize() {
        _ if visible.is_empty() => visible.clone(),
        Some(travel) => swept_inside(visible, scene, &RayEnd::Direction(-travel)),
        None => Polytope::refused(PolytopeState::NotFinite),
    }
}

/// The intersection body B = hull(H ∪ {l}) ∩ S ∩ L of any light (Stingl, section 3.1.1); that of [`intersection_body`]
/// for the sun.
///
/// The hull is bounded by those faces of H that have the light on their inner side, and by planes through the
/// silhouette edges and the light: the same construction as for the sun, and as safe against rounding. The order
/// matters (section 2.2.1 there): hull first, clip last. The hull of the points where the shadow rays of H's corners
/// leave the box is smaller, because it misses the corners of the box between them. L's near plane, where the light has
/// one, cuts the light itself off: a light view of the rest has no point behind its centre.
pub fn intersection_body_of_light(visible: &Polytope, scene: &Bounds, light: &Light) -> Result<Polytope, LightError> {
    let half_spaces = light.half_spaces()?;
    let Some(position) = light.position() else {
        return Ok(intersection_body(visible, scene, -light.towards(DVec3::ZERO)));
    };
    if visible.is_empty() {
        return Ok(visible.clone());
    }
    let body = swept_inside(visible, scene, &RayEnd::Position(position));
    Ok(half_spaces.iter().fold(body, Polytope::clip))
}

/// The body of Stamminger and Drettakis 2002 (Stingl, section 3.1.1, figure 3.1), for comparison: the hull of the whole
/// view volume and the light, regardless of the scene. For the sun, the volume swept towards it for `reach` metres; a
/// far plane farther than `reach` is drawn in to it.
pub fn unfocused_body(view: &ViewVolume, light: &Light, reach: f64) -> Result<Polytope, LightError> {
    let volume = view.polytope(reach);
    light.check()?;
    Ok(match light.position() {
        None => volume.sweep(light.towards(DVec3::ZERO), reach),
        Some(position) => {
            let points: Vec<DVec3> = volume.vertices().iter().copied().chain([position]).collect();
            Polytope::hull(&points)
        }
    })
}

/// Where shadow rays end.
enum RayEnd {
    /// Infinitely far in this unit direction.
    Direction(DVec3),
    /// At a point.
    Position(DVec3),
}

impl RayEnd {
    /// Whether all rays from inside a half-space stay inside.
    fn is_inside(&self, half_space: &HalfSpace) -> bool {
        match self {
            Self::Direction(direction) => half_space.normal.dot(*direction) <= 0.0,
            Self::Position(position) => half_space.excess(*position) <= 0.0,
        }
    }

    /// Unit direction of the ray from a point; zero where the point is the end.
    fn ray_from(&self, point: DVec3) -> DVec3 {
        match self {
            Self::Direction(direction) => *direction,
            Self::Position(position) => (position - point).normalize_or_zero(),
        }
    }

    /// The tightest half-space with this normal that contains a body and, if it lies at a point, the end of its rays.
    fn supporting(&self, body: &Polytope, normal: DVec3) -> HalfSpace {
        let end = match self {
            Self::Direction(_) => f64::NEG_INFINITY,
            Self::Position(position) => normal.dot(*position),
        };
        let distances = body.vertices().iter().map(|vertex| normal.dot(*vertex));
        HalfSpace {
            normal,
            distance: distances.fold(end, f64::max),
        }
    }
}

/// All shadow rays from a body, as far as they lie in the scene.
fn swept_inside(visible: &Polytope, scene: &Bounds, end: &RayEnd) -> Polytope {
    let mut body = Polytope::from_box(scene.min, scene.max);
    for face in visible.faces() {
        if end.is_inside(&face.half_space) {
            body = body.clip(&face.half_space);
        }
    }
    let tolerance = RELATIVE_TOLERANCE * magnitude(visible.vertices());
    let center = visible.center();
    for [a, b] in visible.border(|half_space| !end.is_inside(half_space)) {
        let [a, b] = [a, b].map(|index| visible.vertices()[index as usize]);
        let across = end.ray_from(a).cross(b - a);
        if across.length() <= tolerance {
            continue;
        }
        let normal = across.normalize();
        let inwards = normal.dot(center - a);
        if inwards <= tolerance {
            body = body.clip(&end.supporting(visible, normal));
        }
        if inwards >= -tolerance {
            body = body.clip(&end.supporting(visible, -normal));
        }
    }
    body
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
