//! [`FitSettings`]: how light views are fitted.

use bevy::{math::DVec3, prelude::*};

use crate::maths::{
    fit::{FitOptions, ProjectionCenter, WarpAxis},
    split::PseudoPlanes,
    warp::OptimumRule,
};

/// How light views are fitted: the defaults are best for almost everything, the rest are the papers' own variants, to
/// compare. They cost nothing.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[reflect(Default)]
pub struct FitSettings {
    /// Where the projection centre of a warp lies (Stingl, sections 3.2.1 and 4.1).
    pub center: ProjectionCenter,
    /// The axis of the warp. Face partitions have their own.
    pub axis: WarpDirection,
    /// How n_opt is read for light that is not perpendicular to the view.
    pub optimum: OptimumRule,
    /// Pseudo-near plane: the view depth in metres from which on warps and splits are at their best; what is nearer stays
    /// covered, with larger errors (Stingl, section 4.2). `None`: the near plane.
    pub pseudo_near: Option<f32>,
    /// Pseudo-far plane: the view depth in metres up to which they are. `None`: the far plane.
    pub pseudo_far: Option<f32>,
    /// Weakens a warp where light from inside the view cone makes it harmful. Off: the papers' parameters as they stand.
    pub guard: bool,
    /// Turns light space with the view (Stingl, section 3.2.1). Off: its axes are fixed in the world, and nothing is
    /// warped, since a warp needs the view's direction.
    pub align: bool,
}

/// The axis of the warp, before it is projected across the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Reflect)]
pub enum WarpDirection {
    /// The view direction.
    #[default]
    View,
    /// From the eye to the middle of what receives and casts shadows (Scherzer 2005, section 4.4).
    Middle,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self::BEST
    }
}

impl FitSettings {
    /// What is best.
    pub const BEST: Self = Self {
        center: ProjectionCenter::Continuous,
        axis: WarpDirection::View,
        optimum: OptimumRule::Derived,
        pseudo_near: None,
        pseudo_far: None,
        guard: true,
        align: true,
    };

    /// The options of the fit.
    pub fn options(&self, light_travel: DVec3) -> FitOptions {
        FitOptions {
            center: self.center,
            optimum: self.optimum,
            pseudo_near: self.pseudo_near.map(f64::from),
            pseudo_far: self.pseudo_far.map(f64::from),
            axis: match self.axis {
                _ if !self.align => WarpAxis::Direction(fixed_axis(light_travel)),
                WarpDirection::View => WarpAxis::View,
                WarpDirection::Middle => WarpAxis::Middle,
            },
            guard: self.guard,
            ..FitOptions::default()
        }
    }

    /// The planes between which splits are at their best. NaN: none.
    pub fn pseudo_planes(&self) -> PseudoPlanes {
        let depth = |metres: Option<f32>| metres.map_or(f64::NAN, f64::from);
        PseudoPlanes {
            near: depth(self.pseudo_near),
            far: depth(self.pseudo_far),
        }
    }
}

/// An axis of the world that is not along the light: the one that it has least of.
fn fixed_axis(light_travel: DVec3) -> DVec3 {
    let along = light_travel.abs();
    if along.z <= along.x.max(along.y) {
        DVec3::NEG_Z
    } else {
        DVec3::X
    }
}
