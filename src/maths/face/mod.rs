//! Face partitions: one light view per face of the view frustum that carries the narrowest pixels (Lloyd, section 5.1).
//!
//! A warp needs a trapezoid. Seen along the light from behind the viewer, the view frustum is a square and no warp helps;
//! yet each of its four sides is a trapezoid. [`face_partitions`] cuts what is visible with planes through the edges
//! between faces and along the light, so that each partition holds the light rays through one face, and gives each its own
//! warp axis. Their error is nearly the same for every direction of light: the peak of a single warped map where light and
//! view are parallel is gone. They pay for it in maps: 4 k for k slices, and one for the near face. These are the five maps
//! that Scherzer 2005, section 4.4, names against duelling frusta; its other proposal, up to four maps in one texture, is
//! what [`fill_atlas`](super::storage::fill_atlas) does with them.
//!
//! # Why there is no gap
//!
//! A line along the light that meets a convex body enters it through one face and leaves it through another. The faces
//! that look towards the light are those of entry, the others those of leaving; either set projects along the light onto
//! the whole outline of the body exactly once. So the columns of one set tile the view frustum, whatever its shape.
//! Only edges between two faces of the set need a plane: an edge between a face of the set and another face is on the
//! outline, with the whole frustum on one side of its plane. That holds for the far edges of all sides, which is why an
//! infinite far plane costs nothing here.
//!
//! Without a near partition the same holds for the infinite pyramid in front of the eye instead of the frustum: a line
//! along the light enters it through exactly one side (or leaves it through one). Its columns are the wedges between the
//! planes of two side edges, which all contain the line through the eye along the light; they tile everything that the
//! camera can see. That is the stretching of Lloyd's sections 5.2 and 5.3: the sides take over the near face's place by
//! reaching in to the projected eye.
//!
//! # Continuity
//!
//! A face enters the set when it turns edge-on to the light, with a column of no width; so the number of partitions
//! changes only where one of them is empty or almost so. The one jump is between the two sets, where light and view are
//! perpendicular: for a light that leans sideways the cuts then move from one pair of edges to the other.
//! [`FaceOptions::previous`] keeps the set of the picture before near that direction, where both are equally good, so that
//! it does not flicker. Faces keep their names: to keep maps in their place in an atlas, index them by
//! ([`FacePartition::face`], [`FacePartition::slice`]).

mod frustum;

use bevy_math::DVec3;

use self::frustum::Frustum;
use super::{
    body::adjusted_depths,
    error::{LargestErrors, LightSample, largest_errors},
    fit::LightAxes,
    polytope::{HalfSpace, Polytope},
    split::{SplitScheme, split_depths},
    view::ViewVolume,
    warp::{WarpSpan, guarded_eta},
};

/// A face of the view frustum. The far face never carries a partition: its pixels are the widest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrustumFace {
    /// All faces at once: the camera is orthographic, so every face has the same pixels, or the light has no direction.
    All,
    /// The near plane.
    Near,
    /// The side below.
    Bottom,
    /// The side to the right.
    Right,
    /// The side above.
    Top,
    /// The side to the left.
    Left,
}

impl FrustumFace {
    /// The sides in the order of [`ViewVolume::corners`]: side `i` lies between the corner lines `i` and `i + 1`.
    const SIDES: [Self; 4] = [Self::Bottom, Self::Right, Self::Top, Self::Left];
}

/// Which faces carry the partitions. Light beams should be as wide as possible but no wider than the narrowest pixel
/// beams that they meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FaceSet {
    /// Those that look towards the light, for light that travels with the view direction: it meets the narrow pixels where
    /// it enters the frustum.
    TowardsLight,
    /// Those that look away from it, for light that travels against the view direction: it meets them where it leaves.
    AwayFromLight,
}

/// Cosine between view and light direction below which [`FaceOptions::previous`] decides.
pub const FACE_SET_BAND: f64 = 0.02;

impl FaceSet {
    /// Lloyd's rule (section 5.1): the sign of v · y, where y points towards the light; that is light-space z here.
    ///
    /// Where it is less than [`FACE_SET_BAND`] the `previous` choice stays, unless the opening is so wide that light falls
    /// along a line of sight even there: then the other set would leave gaps.
    fn choose(view: &ViewVolume, towards_light: DVec3, previous: Option<Self>) -> Self {
        let cosine = view.forward().dot(towards_light);
        let sides = &view.half_spaces()[..4];
        let is_along_a_sight =
            [1.0, -1.0].map(|sign| sides.iter().all(|side| sign * side.normal.dot(towards_light) >= 0.0));
        match previous {
            Some(previous) if cosine.abs() < FACE_SET_BAND && is_along_a_sight == [false; 2] => previous,
            _ if cosine > 0.0 => Self::AwayFromLight,
            _ => Self::TowardsLight,
        }
    }
}

/// How the view frustum is cut.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceOptions {
    /// z-slices of each side, 1..=16. The near face is never sliced, since its pixels have one width.
    pub slices: usize,
    /// Where the slices end, on the adjusted range of view depth.
    pub scheme: SplitScheme,
    /// True: a partition of its own for the near face. False: the sides stretch over it, which makes
    /// the error of the innermost slices √α ÷ (√α − 1) times as large along the warp axis, α being their depth ratio:
    /// 1.03 for 1000, 1.5 for 10. Keep it where slices are short.
    pub near_partition: bool,
    /// False: no partition is warped (FP and FP+ZP instead of FP+W and FP+ZP+W).
    pub warp: bool,
    /// The set of the picture before, if there was one.
    pub previous: Option<FaceSet>,
}

impl Default for FaceOptions {
    /// One warped map per face.
    fn default() -> Self {
        Self {
            slices: 1,
            scheme: SplitScheme::Logarithmic,
            near_partition: true,
            warp: true,
            previous: None,
        }
    }
}

/// What is visible in the column of light rays through one face, or through a slice of one.
#[derive(Clone, Debug, PartialEq)]
pub struct FacePartition {
    /// The face.
    pub face: FrustumFace,
    /// The set that the face was chosen from.
    pub set: FaceSet,
    /// 0 next to the near plane.
    pub slice: usize,
    /// The receivers: H inside the column.
    pub receivers: Polytope,
    /// The column inside the view frustum: a visible point belongs to the partition if it is in all of these. Shared
    /// planes appear once with each sign.
    pub column: Vec<HalfSpace>,
    /// Light space of the partition: y is its warp axis.
    pub axes: LightAxes,
    /// True where a warp helps.
    pub warped: bool,
    /// Smallest and largest view depth of the receivers, in metres.
    pub depths: [f64; 2],
    /// Distances from the projected eye along the warp axis, in metres: where the receivers begin.
    pub start_along: f64,
    /// Where the face, cut to the receivers, begins: larger than `start_along` for a side that is stretched.
    pub near_along: f64,
    /// Where both end.
    pub far_along: f64,
}

impl FacePartition {
    /// n' for a strength eta (see [`WarpSpan::warp_near`]), in metres from the near end of the receivers; infinite where
    /// the partition is not warped.
    ///
    /// On a face view depth is proportional to the distance from the projected eye, because the face passes through the
    /// eye. So the optimum of Lloyd, section 4.1, holds on it with n and f in light space, n' = n + √(n f): its centre
    /// lies √(n f) behind the projected eye. A stretched partition keeps this centre, and only begins earlier.
    pub fn warp_near(&self, eta: f64) -> f64 {
        if !self.warped {
            return f64::INFINITY;
        }
        let span = self.span();
        let stretched = span.warp_near(eta) - (self.near_along - self.start_along);
        if stretched > 0.0 { stretched } else { f64::INFINITY }
    }

    /// The face along the warp axis; view depths are replaced by the distances from the projected eye that they are
    /// proportional to.
    fn span(&self) -> WarpSpan {
        WarpSpan::directional(self.far_along - self.near_along, self.near_along, 1.0)
    }

    /// The strength that is left of `target` where the receivers lie far behind the face, so that its pixels are not theirs:
    /// a ground seen with light from behind, in the column of the bottom face. Without the guard such maps need up to ten
    /// times the texels of unwarped ones; over a whole frustum it changes next to nothing. See [`guarded_eta`].
    ///
    /// A stretched side is judged as if its warp began at its own near end; such maps may need a fifth more texels than
    /// unwarped ones.
    pub fn guarded_eta(&self, view: &ViewVolume, target: f64) -> f64 {
        if !self.warped {
            return -1.0;
        }
        guarded_eta(target, &self.samples(view), &self.span())
    }

    /// The largest errors of a map fitted to the receivers with this strength, relative to pixels of `view`: multiply by the
    /// picture's height ÷ the map's texels across and along. Evaluated at the vertices of the receivers, which is exact
    /// (see [`largest_errors`]); the paper takes the vertices of the face, on the same rays with the narrowest pixels.
    pub fn largest_errors(&self, view: &ViewVolume, eta: f64) -> LargestErrors {
        let opening = if view.is_orthographic() { 1.0 } else { view.opening().y };
        largest_errors(&self.samples(view), self.warp_near(eta), opening)
    }

    fn samples(&self, view: &ViewVolume) -> Vec<LightSample> {
        let sample = |vertex: &DVec3| LightSample {
            across: self.axes.x.dot(vertex - view.eye()),
            along: self.axes.y.dot(vertex - view.eye()),
            depth: if view.is_orthographic() {
                1.0
            } else {
                view.depth(*vertex)
            },
        };
        self.receivers.vertices().iter().map(sample).collect()
    }

    /// Whether a visible point belongs to the partition, give or take `tolerance` metres. Points on a shared plane belong
    /// to both sides: take the first, as [`partition_of_point`] does.
    pub fn contains(&self, point: DVec3, tolerance: f64) -> bool {
        self.column
            .iter()
            .all(|half_space| half_space.excess(point) <= tolerance)
    }
}

/// The partition of a visible point: the first whose column contains it (Lloyd, section 6.3, for faces). With a shared
/// plane both sides compute the same number with opposite signs, so that no point falls between; where three columns meet,
/// rounding could still lose one, so the nearest column is taken. `None` for no partitions.
pub fn partition_of_point(partitions: &[FacePartition], point: DVec3) -> Option<usize> {
    let excess = |partition: &FacePartition| {
        let excesses = partition.column.iter().map(|half_space| half_space.excess(point));
        excesses.fold(0.0, f64::max)
    };
    let keyed = partitions.iter().map(excess).enumerate();
    keyed.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
}

/// Cuts what a camera sees into face partitions; sides first, counter-clockwise from the bottom and each from near to
/// far, then the near face. Partitions that hold no receivers are left out.
///
/// `visible` is H of the whole view; its depths adjust the frustum first (Stingl, section 3.3.1), so that the near face
/// lies where the first receivers are. `light_travel` is the direction in which light travels, of any length. Empty when
/// `visible` is. Orthographic cameras and lights without direction give one partition of [`FrustumFace::All`].
pub fn face_partitions(
    view: &ViewVolume,
    visible: &Polytope,
    light_travel: DVec3,
    options: &FaceOptions,
) -> Vec<FacePartition> {
    let Some((near, far)) = adjusted_depths(visible, view) else {
        return Vec::new();
    };
    let towards_light = (-light_travel).try_normalize();
    let set = FaceSet::choose(view, towards_light.unwrap_or_default(), options.previous);
    let cut = Cut { view, visible, set };
    let Some(towards_light) = towards_light.filter(|_| !view.is_orthographic()) else {
        let axes = LightAxes::new(view.forward(), view.up(), light_travel).unwrap_or(LightAxes {
            x: view.forward().cross(view.up()),
            y: view.up(),
            z: -view.forward(),
        });
        return cut
            .partition(FrustumFace::All, 0, Vec::new(), axes)
            .into_iter()
            .collect();
    };
    let frustum = Frustum::new(view, near, far, towards_light, set);
    let has_near_partition = options.near_partition && frustum.is_near_chosen();
    let depths = split_depths(&options.scheme, near, far, options.slices);
    let count = depths.len().saturating_sub(1);
    let mut partitions = Vec::new();
    for side in frustum.chosen_sides() {
        let Some(axes) = frustum.bisector(side).map(|axis| frustum.axes(axis)) else {
            continue;
        };
        for (slice, range) in depths.windows(2).enumerate() {
            let start = (slice > 0 || has_near_partition).then_some(range[0]);
            let end = (slice + 1 < count).then_some(range[1]);
            let column = frustum.side_column(side, start, end);
            let face = FrustumFace::SIDES[side];
            let Some(mut partition) = cut.partition(face, slice, column, axes) else {
                continue;
            };
            let face_along = frustum.along(side, range[0], axes.y);
            partition.near_along = partition.start_along.max(face_along).min(partition.far_along);
            partition.warped = options.warp && partition.near_along > 0.0;
            partitions.push(partition);
        }
    }
    if has_near_partition {
        let axes = frustum.axes(frustum.near_axis(visible));
        partitions.extend(cut.partition(FrustumFace::Near, 0, frustum.near_column(), axes));
    }
    partitions
}

struct Cut<'a> {
    view: &'a ViewVolume,
    visible: &'a Polytope,
    set: FaceSet,
}

impl Cut<'_> {
    /// The part of H in a column, without a warp; `None` when there is none.
    fn partition(
        &self,
        face: FrustumFace,
        slice: usize,
        column: Vec<HalfSpace>,
        axes: LightAxes,
    ) -> Option<FacePartition> {
        let receivers = column.iter().fold(self.visible.clone(), Polytope::clip);
        let range = |value: &dyn Fn(DVec3) -> f64| {
            let values = receivers.vertices().iter().map(|vertex| value(*vertex));
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            })
        };
        let depths = range(&|vertex| self.view.depth(vertex));
        let [start_along, far_along] = range(&|vertex| axes.y.dot(vertex - self.view.eye()));
        (!receivers.is_empty()).then_some(FacePartition {
            face,
            set: self.set,
            slice,
            receivers,
            column,
            axes,
            warped: false,
            depths,
            start_along,
            near_along: start_along,
            far_along,
        })
    }
}
