//! The view frustum as a face partition sees it: which faces are chosen, and the planes between them.

use bevy_math::DVec3;

use super::{
    super::{
        fit::LightAxes,
        polytope::{HalfSpace, Polytope},
        view::ViewVolume,
    },
    FaceSet,
};

/// Sine of the angle between light and face below which a face is edge-on: its column is then thinner than a millionth of
/// its length, and its neighbours take it over.
const EDGE_ON: f64 = 1.0e-6;

/// A perspective frustum and the direction of light.
pub(super) struct Frustum<'a> {
    view: &'a ViewVolume,
    near: f64,
    towards_light: DVec3,
    /// Corner lines: change of position per metre of view depth.
    slopes: [DVec3; 4],
    /// Whether each side carries a partition; side `i` lies between the corner lines `i` and `i + 1`.
    chosen: [bool; 4],
    near_chosen: bool,
}

impl<'a> Frustum<'a> {
    pub(super) fn new(view: &'a ViewVolume, near: f64, far: f64, towards_light: DVec3, set: FaceSet) -> Self {
        let sign = match set {
            FaceSet::TowardsLight => 1.0,
            FaceSet::AwayFromLight => -1.0,
        };
        let corners = view.corners(near, far);
        let chosen = |normal: DVec3| sign * normal.dot(towards_light) > EDGE_ON;
        let half_spaces = view.half_spaces();
        Self {
            view,
            near,
            towards_light,
            slopes: std::array::from_fn(|index| (corners[index + 4] - corners[index]) / (far - near)),
            chosen: std::array::from_fn(|side| chosen(half_spaces[side].normal)),
            near_chosen: chosen(-view.forward()),
        }
    }

    pub(super) fn is_near_chosen(&self) -> bool {
        self.near_chosen
    }

    pub(super) fn chosen_sides(&self) -> impl Iterator<Item = usize> {
        (0..4).filter(|side| self.chosen[*side])
    }

    /// The half-spaces of a side's column: beside its neighbours, and behind `start` and in front of `end`, which are view
    /// depths on the face.
    pub(super) fn side_column(&self, side: usize, start: Option<f64>, end: Option<f64>) -> Vec<HalfSpace> {
        let mut column = Vec::with_capacity(4);
        if self.chosen[(side + 3) % 4] {
            column.extend(self.between_sides(side).map(flipped));
        }
        if self.chosen[(side + 1) % 4] {
            column.extend(self.between_sides((side + 1) % 4));
        }
        column.extend(start.and_then(|depth| self.across(side, depth)).map(flipped));
        column.extend(end.and_then(|depth| self.across(side, depth)));
        column
    }

    /// The half-spaces of the near face's column.
    pub(super) fn near_column(&self) -> Vec<HalfSpace> {
        self.chosen_sides()
            .filter_map(|side| self.across(side, self.near))
            .collect()
    }

    /// The plane along the light through the corner line between side `corner − 1` and side `corner`, with the former
    /// inside.
    ///
    /// With m = slope_c × light the sides lie where slope_(c−1) · m and slope_(c+1) · m are; the former is
    /// (slope_(c−1) × slope_c) · light, the latter −(slope_c × slope_(c+1)) · light. Both cross products are normals of
    /// chosen faces, either both outwards or both inwards, so the signs always differ. `None` for light along the line,
    /// where both faces are edge-on.
    fn between_sides(&self, corner: usize) -> Option<HalfSpace> {
        let normal = self.slopes[corner].cross(self.towards_light).try_normalize()?;
        let before = self.slopes[(corner + 3) % 4].dot(normal);
        let after = self.slopes[(corner + 1) % 4].dot(normal);
        let outwards = if after >= before { normal } else { -normal };
        Some(HalfSpace::through(self.corner(corner, self.near), outwards))
    }

    /// The plane along the light through a face's cross edge at a view depth, with what is nearer inside. `None` for light
    /// along the edge, where the face is edge-on.
    fn across(&self, side: usize, depth: f64) -> Option<HalfSpace> {
        let [left, right] = [side, (side + 1) % 4].map(|corner| self.corner(corner, depth));
        let normal = (right - left).cross(self.towards_light).try_normalize()?;
        let outwards = self.slopes[side] + self.slopes[(side + 1) % 4];
        Some(HalfSpace::through(
            left,
            if outwards.dot(normal) >= 0.0 { normal } else { -normal },
        ))
    }

    fn corner(&self, corner: usize, depth: f64) -> DVec3 {
        self.view.corners(depth, depth)[corner]
    }

    /// The warp axis of a side: the bisector of its corner lines, projected along the light (Lloyd, section 5.1). The paper
    /// adds the projected edges; only unit vectors give the bisector. A line along the light has no projection and leaves
    /// the axis to the other one. `None` when both point against each other: the light lies in the face.
    pub(super) fn bisector(&self, side: usize) -> Option<DVec3> {
        [side, (side + 1) % 4]
            .map(|corner| self.in_light_plane(self.slopes[corner]))
            .map(DVec3::normalize_or_zero)
            .iter()
            .sum::<DVec3>()
            .try_normalize()
    }

    /// Light space with a warp axis.
    pub(super) fn axes(&self, axis: DVec3) -> LightAxes {
        // Once more, because rounding of a short projection leaves a part along the light.
        let y = self.in_light_plane(axis).normalize();
        LightAxes {
            x: y.cross(self.towards_light),
            y,
            z: self.towards_light,
        }
    }

    /// The axis of the near face's map, which is not warped: of the projections of the camera's right and up direction the
    /// one that gives the smaller box around the face.
    pub(super) fn near_axis(&self, visible: &Polytope) -> DVec3 {
        let face = self.near_column().iter().fold(visible.clone(), Polytope::clip);
        let right = self.view.forward().cross(self.view.up());
        let axes = [self.view.up(), right].map(|axis| self.in_light_plane(axis).normalize_or_zero());
        let area = |axis: DVec3| {
            let extent = |axis: DVec3| {
                let along = face.vertices().iter().map(|vertex| axis.dot(*vertex));
                let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), along| {
                    (low.min(along), high.max(along))
                });
                high - low
            };
            extent(axis) * extent(axis.cross(self.towards_light))
        };
        let [up, right] = axes;
        if up == DVec3::ZERO || (right != DVec3::ZERO && area(right) < area(up)) {
            right
        } else {
            up
        }
    }

    /// Distance from the projected eye along an axis at which a side begins at a view depth.
    pub(super) fn along(&self, side: usize, depth: f64, axis: DVec3) -> f64 {
        [side, (side + 1) % 4]
            .map(|corner| axis.dot(self.corner(corner, depth) - self.view.eye()))
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }

    fn in_light_plane(&self, direction: DVec3) -> DVec3 {
        direction - self.towards_light * direction.dot(self.towards_light)
    }
}

/// The other side of the same plane: its excess is exactly the negative.
fn flipped(half_space: HalfSpace) -> HalfSpace {
    HalfSpace {
        normal: -half_space.normal,
        distance: -half_space.distance,
    }
}
