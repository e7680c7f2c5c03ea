//! Errors of the maps of face partitions, for the analysis (Lloyd et al. 2006, section 5.1).

use bevy_math::DVec3;

use super::direction::opening;
use crate::maths::{
    error::LargestErrors,
    face::{FacePartition, FrustumFace},
    fit::LightAxes,
    view::ViewVolume,
};

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

/// The largest errors of the map of a face partition. The near face has pixels of one width and no warp.
///
/// Limit: next to a light direction along a frustum edge that edge's projection is short and may point anywhere, so the
/// bisector stands slantwise in the face, z0 comes close to zero and the warp grows far too strong: 0.0001 rad beside it S̄
/// is 11 times that from behind for α = 10, and more nearer to it. The spike is narrow; the tables of the literature step
/// over it. The bisector without unit lengths, the plain sum of the projected edges, is worse in a wide region (40
/// times for α = 100 on a grid of 2.5°). [`FaceWarp::Guarded`] has no spike: the longer edge is the right axis there.
pub fn face_errors(view: &ViewVolume, partition: &FacePartition, warp: FaceWarp) -> LargestErrors {
    // Pictures that are not square: relative to the root of a pixel's area, as for the other maps.
    let pixel_shape = view.opening().y / opening(view);
    let errors = |partition: &FacePartition, eta| {
        let errors = partition.largest_errors(view, eta);
        LargestErrors {
            across: errors.across * pixel_shape,
            along: errors.along * pixel_shape,
        }
    };
    match warp {
        FaceWarp::None => errors(partition, UNWARPED),
        FaceWarp::Bisector => errors(partition, PUBLISHED),
        FaceWarp::Guarded => {
            let along_edge = along_longer_edge(view, partition);
            let axes = [Some(partition), along_edge.as_ref()];
            let candidates = axes
                .into_iter()
                .flatten()
                .flat_map(|partition| [PUBLISHED, UNWARPED].map(|eta| errors(partition, eta)));
            let best = candidates.min_by(|a, b| a.storage_factor().total_cmp(&b.storage_factor()));
            best.unwrap_or_else(|| errors(partition, UNWARPED))
        }
    }
}

const UNWARPED: f64 = -1.0;
const PUBLISHED: f64 = 0.0;

/// A side's partition with the longer of its two projected corner lines as the warp axis.
fn along_longer_edge(view: &ViewVolume, partition: &FacePartition) -> Option<FacePartition> {
    let corners = match partition.face {
        FrustumFace::Bottom => [0, 1],
        FrustumFace::Right => [1, 2],
        FrustumFace::Top => [2, 3],
        FrustumFace::Left => [3, 0],
        FrustumFace::All | FrustumFace::Near => return None,
    };
    let z = partition.axes.z;
    let points = view.corners(view.near(), view.near());
    let edges = corners.map(|corner| {
        let edge = (points[corner] - view.eye()).normalize_or_zero();
        edge - z * edge.dot(z)
    });
    let longer = if edges[0].length() > edges[1].length() {
        edges[0]
    } else {
        edges[1]
    };
    let y = longer.try_normalize()?;
    let along = |vertex: &DVec3| y.dot(vertex - view.eye());
    let ends = partition.receivers.vertices().iter().map(along);
    let (start, end) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(start, end), along| {
        (start.min(along), end.max(along))
    });
    Some(FacePartition {
        axes: LightAxes { x: y.cross(z), y, z },
        warped: start > 0.0,
        start_along: start,
        near_along: start,
        far_along: end,
        ..partition.clone()
    })
}
