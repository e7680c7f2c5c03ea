//! H and B in light space, and the warp that suits them.

use bevy_math::{DVec2, DVec3};

use super::{FitInput, FitOptions, LightAxes, WarpAxis};
use crate::maths::{
    bounds::Bounds,
    error::LightSample,
    polytope::{HalfSpace, Polytope},
    view::ViewVolume,
    warp::{Warp, WarpSpan, guarded_eta_by},
};

/// H and B in light space, relative to its origin.
pub(super) struct Bodies {
    pub(super) visible: Vec<DVec3>,
    pub(super) body: Vec<DVec3>,
    /// Light-space y of the near end, in the axes' coordinates.
    pub(super) start: f64,
    /// The point beside which the projection centre lies, in the axes' coordinates.
    center: DVec3,
    /// d: extent along the warp axis.
    pub(super) extent: f64,
    /// Lengths below this count as zero and are padded to it.
    pub(super) smallest: f64,
}

impl Bodies {
    pub(super) fn new(input: &FitInput, axes: &LightAxes, center: DVec3) -> Self {
        let guard = Bounds::new(DVec3::ZERO, DVec3::ZERO).expanded(input.guard_metres.max(0.0));
        let corners = guard.corners();
        let offsets = if input.guard_metres > 0.0 {
            &corners[..]
        } else {
            &corners[..1]
        };
        let in_light = |body: &Polytope| -> Vec<DVec3> {
            let coordinates = body.vertices().iter().map(|vertex| axes.coordinates(*vertex));
            coordinates
                .flat_map(|point| offsets.iter().map(move |offset| point + offset))
                .collect()
        };
        let (mut visible, mut body) = (in_light(input.visible), in_light(input.body));
        let bounds = Bounds::from_points(visible.iter().chain(&body).copied());
        let smallest = (bounds.size().max_element() * 1.0e-5).max(1.0e-6);
        let extent = bounds.size().y;
        let padding = (smallest - extent).max(0.0) * 0.5;
        let start = bounds.min.y - padding;
        for point in visible.iter_mut().chain(&mut body) {
            *point -= DVec3::new(center.x, start, center.z);
        }
        Self {
            visible,
            body,
            start,
            center,
            extent: extent.max(smallest),
            smallest,
        }
    }

    pub(super) fn warp(&self, input: &FitInput, axes: &LightAxes, near_depth: f64) -> ChosenWarp {
        if input.view.is_orthographic() || self.extent <= self.smallest {
            return ChosenWarp::UNIFORM;
        }
        let span = self.span(input, axes, near_depth);
        let target = match (input.warp, input.options.axis) {
            // Over one face of the frustum the light always comes from the side, so nothing needs to fade.
            (Warp::Repar, WarpAxis::Direction(_)) => Warp::Lispsm.eta(),
            (warp, _) => {
                let (light_angle, half_opening) = light_angle(input.view, axes.z);
                warp.eta_in(&span, light_angle, half_opening)
            }
        };
        let eta = if input.options.guard {
            let fitted = self.samples(input.visible, input, axes, near_depth);
            let judged = match levelled_part(input) {
                Some(part) => &self.samples(&part, input, axes, near_depth),
                None => &fitted,
            };
            let guarded = |target| guarded_eta_by(input.options.guard_norm, target, &fitted, judged, &span);
            match input.warp {
                // It fades by itself: the guard is a ceiling only.
                Warp::Repar => guarded(0.0).min(target),
                _ => guarded(target),
            }
        } else {
            target
        };
        match span.warp_near(eta) {
            f64::INFINITY => ChosenWarp::UNIFORM,
            near => ChosenWarp { near, eta },
        }
    }

    fn span(&self, input: &FitInput, axes: &LightAxes, near_depth: f64) -> WarpSpan {
        let FitOptions {
            axis,
            optimum,
            face_start,
            ..
        } = input.options;
        let span = if let WarpAxis::Direction(_) = axis {
            let start = self.start - axes.y.dot(input.view.eye());
            let lead = face_start.map_or(0.0, |face_start| face_start - start);
            if lead > 0.0 && lead < self.extent {
                return WarpSpan::directional(self.extent - lead, start + lead, 1.0).led_by(lead);
            }
            WarpSpan::directional(self.extent, start, 1.0)
        } else {
            let sine = input.view.forward().dot(axes.y);
            WarpSpan::directional_by(optimum, self.extent, near_depth, sine)
        };
        // Spans that do not count in view depths scale them.
        let scale = span.near_depth / near_depth;
        let (pseudo_near, pseudo_far) = input.options.levelled_depths();
        span.levelled_between(pseudo_near * scale, pseudo_far * scale)
    }

    fn samples(&self, part: &Polytope, input: &FitInput, axes: &LightAxes, near_depth: f64) -> Vec<LightSample> {
        let vertices = part.vertices().iter();
        vertices
            .map(|vertex| LightSample {
                across: axes.x.dot(*vertex) - self.center.x,
                along: axes.y.dot(*vertex),
                depth: input.view.depth(*vertex).max(near_depth),
            })
            .collect()
    }
}

/// The part of H between the pseudo planes; `None` where that is all of it, or nothing.
fn levelled_part(input: &FitInput) -> Option<Polytope> {
    let view = input.view;
    let (near, far) = input.options.levelled_depths();
    let place = |depth: f64| view.eye() + view.forward() * depth;
    let mut part = None;
    for (depth, normal) in [(near, -view.forward()), (far, view.forward())] {
        let half_space = HalfSpace::through(place(depth), normal);
        let mut vertices = input.visible.vertices().iter();
        if depth.is_finite() && vertices.any(|vertex| half_space.excess(*vertex) > 0.0) {
            part = Some(part.unwrap_or_else(|| input.visible.clone()).clip(&half_space));
        }
    }
    part.filter(|part| !part.is_empty())
}

/// γ, folded to at most a right angle, and Θ: how far the view opens from its axis towards the light (or away from it),
/// so that the light is inside the view cone exactly while γ < Θ. In radians.
fn light_angle(view: &ViewVolume, to_light: DVec3) -> (f64, f64) {
    let forward = view.forward();
    let up = view.up().reject_from_normalized(forward).normalize_or_zero();
    let across = DVec2::new(to_light.dot(forward.cross(up)), to_light.dot(up));
    let angle = across.length().atan2(to_light.dot(forward).abs());
    let direction = across.try_normalize().unwrap_or(DVec2::Y).abs();
    let reach = view.opening() * 0.5 / direction;
    (angle, reach.min_element().atan())
}

/// n' and the strength that it has.
pub(super) struct ChosenWarp {
    pub(super) near: f64,
    pub(super) eta: f64,
}

impl ChosenWarp {
    const UNIFORM: Self = Self {
        near: f64::INFINITY,
        eta: -1.0,
    };

    /// Clip-space w at a light-space y: 1 at the near end.
    pub(super) fn width(&self, along: f64) -> f64 {
        1.0 + along / self.near
    }
}
