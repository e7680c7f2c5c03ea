//! [`FitOptions`]: the papers' variants of the fit. The defaults are what is best.

use bevy_math::DVec3;

use crate::maths::warp::{GuardNorm, OptimumRule};

/// Variants of [`fit_light_view`](super::fit_light_view). The default is best for almost everything; the others are the
/// papers' own, to compare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Where the projection centre lies, seen along the warp axis.
    pub center: ProjectionCenter,
    /// How n_opt is computed for tilted light. Not used with [`WarpAxis::Direction`].
    pub optimum: OptimumRule,
    /// The pseudo-near plane n_p: the view depth in metres from which on the warp is at its best; what is nearer gets
    /// larger errors but stays covered (Stingl, section 4.2). `None`: no such plane.
    pub pseudo_near: Option<f64>,
    /// The pseudo-far plane f_p: the view depth in metres up to which the warp is at its best (Stingl, section 4.2).
    pub pseudo_far: Option<f64>,
    /// The view depth in metres of the farthest visible surface, as a visibility pass finds it (Scherzer 2005, section
    /// 4.4). It enters n_opt only, as Δz: what lies beyond it can still cast shadows into view, so the bodies stay as they
    /// are. To the warp it is a second pseudo-far plane: the nearer of both counts.
    pub visible_far: Option<f64>,
    /// The axis along which the map is warped.
    pub axis: WarpAxis,
    /// Only with [`WarpAxis::Direction`]: where the face begins, in metres from the projected eye along the axis, if the
    /// receivers begin before it: a side that is stretched over the near face (Lloyd, section 5.3). The warp is at its best
    /// from there on. `None`: where the receivers begin.
    pub face_start: Option<f64>,
    /// Whether [`guarded_eta`](crate::maths::warp::guarded_eta) weakens the warp where light from inside the view cone
    /// makes it harmful. Without it the papers' parameters are used as they stand.
    pub guard: bool,
    /// What the guard keeps small. What lies in front of the pseudo-near plane or behind the pseudo-far one does not count.
    pub guard_norm: GuardNorm,
    /// What the depths of the map range over.
    pub depths: DepthRange,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            center: ProjectionCenter::Continuous,
            optimum: OptimumRule::Derived,
            pseudo_near: None,
            pseudo_far: None,
            visible_far: None,
            axis: WarpAxis::View,
            face_start: None,
            guard: true,
            guard_norm: GuardNorm::Storage,
            depths: DepthRange::Bodies,
        }
    }
}

impl FitOptions {
    /// The view depths between which errors are made equal, or all depths.
    pub(super) fn levelled_depths(&self) -> (f64, f64) {
        let far = |depth: Option<f64>| depth.unwrap_or(f64::INFINITY);
        (
            self.pseudo_near.unwrap_or(f64::NEG_INFINITY),
            far(self.pseudo_far).min(far(self.visible_far)),
        )
    }

    /// True when a depth is NaN.
    pub(super) fn is_nan(&self) -> bool {
        let room = match self.depths {
            DepthRange::Bodies => None,
            DepthRange::Receivers { room } => Some(room),
        };
        [
            self.pseudo_near,
            self.pseudo_far,
            self.visible_far,
            self.face_start,
            room,
        ]
        .into_iter()
        .flatten()
        .any(f64::is_nan)
    }
}

/// What lies between the depths 0 and 1 of a map. Neither texels nor the warp depend on it: B has the outline of H.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum DepthRange {
    /// All of B: every caster has a depth of its own, as filters that measure the distance of casters need it.
    #[default]
    Bodies,
    /// The receivers H alone (Lloyd, section 6.4). Whatever lies nearer to the light than they do has to be drawn with its
    /// depth clamped to 1, by the rasteriser: w is constant along a light ray, so it still shades all of H below it, and
    /// nothing else is lost. The steps of depth become finer by the height of B ÷ that of H, which matters for maps of 16
    /// or 24 bits; single precision with reverse z, whose steps near 0 are far finer than a texel anyway, hardly gains.
    ///
    /// Not for casters that are told apart among each other: a second surface in front of H is clamped like the first, and
    /// a search for blockers finds all of them at the border of H.
    Receivers {
        /// Metres left free towards the light, at least what lookups add to a receiver (the bias): a receiver that is moved
        /// beyond depth 1 would pass every clamped caster.
        room: f64,
    },
}

/// Where the projection centre of the warp lies, across the warp axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "render", derive(bevy::reflect::Reflect))]
pub enum ProjectionCenter {
    /// Beside the point of the view axis at the depth of the nearest point of LVS (Stingl, section 4.1): continuous under
    /// motion, symmetric under a sun overhead. With an axis other than [`WarpAxis::View`] it is beside the eye.
    #[default]
    Continuous,
    /// Beside that nearest point of LVS itself (Wimmer and Scherzer 2006; Stingl, section 3.2.1). The point is a vertex and
    /// jumps to another when camera or light move: the map shears from one frame to the next. Of several equally near
    /// vertices the first one counts, so the map is askew even under a sun overhead.
    NearestVertex,
}

/// The axis along which a light view is warped, before it is projected into the light plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WarpAxis {
    /// V_P from the view direction (Scherzer 2005, equation 3).
    #[default]
    View,
    /// From the eye to the middle of B (Scherzer 2005, section 4.4), for views in which B lies to one side.
    ///
    /// The paper adds up the vectors to all vertices of B, so that many vertices on one side draw the axis there, and it
    /// jumps whenever clipping adds a vertex. Here the middle is the mean of B's surface: it moves steadily, keeps the
    /// heavier weight of what is far (which has the larger faces), and is the same for boxes and other symmetric bodies.
    /// Where it is parallel to the light, or the eye is in the middle, the view direction takes over.
    ///
    /// The paper reads γ as the angle to this vector. What n_opt needs is the change of view depth per metre along the
    /// axis, v · y, and that is used; it equals the sine of the paper's angle only if the axis lies in the plane of view and
    /// light. An axis that points away from the view direction gives a uniform map.
    Middle,
    /// A given direction in the world, such as the bisector of a face partition's side edges (Lloyd, section 5.1).
    ///
    /// The receivers are then a column of light over one face of the view frustum. Its plane contains the eye, so view
    /// depth on it is proportional to the distance from the eye along the axis: z1/z0 is taken as the ratio of these
    /// distances, n_opt = z_n + √(z_n z_f) with both measured along the axis from the eye, and
    /// [`OptimumRule`] does not enter. Where the receivers reach beside or behind the eye there is no warp.
    /// With [`Warp::Uniform`](crate::maths::warp::Warp::Uniform), a direction that does not follow the camera gives
    /// texel grids that do not turn with it.
    Direction(DVec3),
}
