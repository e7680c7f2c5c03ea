//! Faces of the view frustum as a light sees them, for the analysis of face partitions (Lloyd et al. 2006, section 5.1).
//!
//! A light beam should be as wide as it can be, yet not wider than the narrowest image beam that it meets. Light from
//! behind the viewer meets those where it enters the frustum, light from ahead where it leaves it. So the faces that carry
//! them are the ones turned to the light, or away from it.

use bevy_math::DVec3;

use super::direction::{light_sample, opening};
use crate::maths::{
    error::{LargestErrors, LightSample, largest_errors},
    fit::LightAxes,
    view::ViewVolume,
};

/// A face of the view frustum, named from the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrustumFace {
    /// The near plane's.
    Near,
    /// The far plane's.
    Far,
    /// Below.
    Bottom,
    /// To the right.
    Right,
    /// Above.
    Top,
    /// To the left.
    Left,
}

impl FrustumFace {
    /// All faces.
    pub const ALL: [Self; 6] = [Self::Near, Self::Far, Self::Bottom, Self::Right, Self::Top, Self::Left];

    /// Its corners among [`ViewVolume::corners`]; of a side two near ones, then the far ones of the same edges in reverse.
    fn corners(self) -> [usize; 4] {
        match self {
            Self::Near => [0, 1, 2, 3],
            Self::Far => [4, 5, 6, 7],
            Self::Bottom => [0, 1, 5, 4],
            Self::Right => [1, 2, 6, 5],
            Self::Top => [2, 3, 7, 6],
            Self::Left => [3, 0, 4, 7],
        }
    }

    fn points(self, view: &ViewVolume) -> [DVec3; 4] {
        let corners = view.corners(view.near(), view.far());
        self.corners().map(|index| corners[index])
    }

    /// Area in square metres and unit normal, outwards.
    fn plane(self, view: &ViewVolume) -> (f64, DVec3) {
        let [a, b, c, d] = self.points(view);
        let twice = (c - a).cross(d - b);
        let center = view.corners(view.near(), view.far()).iter().sum::<DVec3>() / 8.0;
        let outwards = if twice.dot(a - center) < 0.0 { -twice } else { twice };
        (outwards.length() * 0.5, outwards.normalize_or_zero())
    }

    /// Area of the face as the light sees it, in square metres.
    pub fn area_from_light(self, view: &ViewVolume, light_travel: DVec3) -> f64 {
        let (area, normal) = self.plane(view);
        area * normal.dot(light_travel.normalize_or_zero()).abs()
    }
}

/// Cosines below this count as edge-on.
const EDGE_ON: f64 = 1.0e-9;

/// The faces whose light beams meet the narrowest image beams: those turned to the light when it comes from behind the
/// viewer or from exactly across, those turned away when it comes from ahead (Lloyd, section 5.1; there the sign of v · y
/// with y towards the light). Their outlines cover that of the frustum exactly once. The far face is never among them.
pub fn selected_faces(view: &ViewVolume, light_travel: DVec3) -> Vec<FrustumFace> {
    let to_light = -light_travel.normalize_or_zero();
    let is_from_ahead = view.forward().dot(to_light) > EDGE_ON;
    let selected = FrustumFace::ALL.into_iter().filter(|face| {
        let cosine = face.plane(view).1.dot(to_light);
        if is_from_ahead {
            cosine < -EDGE_ON
        } else {
            cosine > EDGE_ON
        }
    });
    selected.collect()
}

/// How the map of a side face is warped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaceWarp {
    /// Not at all.
    None,
    /// Along the bisector with n' = z0 + √(z0 z1), as published.
    Bisector,
    /// The best of four: along the bisector or along the longer projected edge, each with that n' and without a warp.
    Guarded,
}

/// The largest errors of the map of a face; deeper points under the same light beam have wider image beams, so the four
/// corners decide.
///
/// A side face is warped along the bisector of its two side edges, projected into the light plane (of unit length each,
/// which the paper does not say; a bisector needs it), with n' = z0 + √(z0 z1) over its extent z0..z1 along that axis from
/// the eye: as under light from overhead. The near face has pixels of one width and gets no warp, only the better of two
/// axes. Faces that are edge-on to the light have nearly no area and errors near zero.
///
/// Limit: next to a light direction along a frustum edge that edge's projection is short and may point anywhere, so the
/// bisector stands slantwise in the face, z0 comes close to zero and the warp grows far too strong: 0.0001 rad beside it S̄
/// is 11 times that from behind for α = 10, and more nearer to it. The spike is narrow; the tables of the literature step
/// over it. The bisector without unit lengths, the plain sum of the projected edges, is worse in a wide region (40
/// times for α = 100 on a grid of 2.5°). [`FaceWarp::Guarded`] has no spike: the longer edge is the right axis there.
pub fn face_errors(view: &ViewVolume, face: FrustumFace, light_travel: DVec3, warp: FaceWarp) -> LargestErrors {
    let points = face.points(view);
    let to_light = -light_travel.normalize_or_zero();
    let in_light_plane = |direction: DVec3| direction - to_light * direction.dot(to_light);
    let around = |axis: DVec3, is_warped: bool| {
        let y = in_light_plane(axis).normalize_or_zero();
        let axes = LightAxes {
            x: y.cross(to_light),
            y,
            z: to_light,
        };
        let samples = points.map(|point| light_sample(view, &axes, point));
        let warp_near = if is_warped {
            face_warp_near(&samples)
        } else {
            f64::INFINITY
        };
        largest_errors(&samples, warp_near, opening(view))
    };
    let best = |candidates: &[(DVec3, bool)]| {
        let visible = candidates
            .iter()
            .filter(|(axis, _)| in_light_plane(*axis).length() > EDGE_ON);
        let errors = visible.map(|(axis, is_warped)| around(*axis, *is_warped));
        let best = errors.min_by(|a, b| a.storage_factor().total_cmp(&b.storage_factor()));
        best.unwrap_or_else(|| around(view.up(), false))
    };
    if matches!(face, FrustumFace::Near | FrustumFace::Far) {
        let right = view.forward().cross(view.up());
        return best(&[(right, false), (view.up(), false)]);
    }
    let edges = [points[0], points[1]].map(|corner| in_light_plane((corner - view.eye()).normalize_or_zero()));
    let sum = edges[0].normalize_or_zero() + edges[1].normalize_or_zero();
    let bisector = if sum.length() > EDGE_ON { sum } else { view.forward() };
    match warp {
        FaceWarp::None => around(bisector, false),
        FaceWarp::Bisector => around(bisector, true),
        FaceWarp::Guarded => {
            let is_first_longer = edges[0].length() > edges[1].length();
            let longer = if is_first_longer { edges[0] } else { edges[1] };
            best(&[(bisector, true), (longer, true), (bisector, false), (longer, false)])
        }
    }
}

/// n' of a face from its extent along the warp axis, measured from the eye; infinite where the eye is inside of it.
fn face_warp_near(samples: &[LightSample]) -> f64 {
    let along = || samples.iter().map(|sample| sample.along);
    let (near, far) = (
        along().fold(f64::INFINITY, f64::min),
        along().fold(f64::NEG_INFINITY, f64::max),
    );
    if near > 0.0 {
        near + (near * far).sqrt()
    } else {
        f64::INFINITY
    }
}
