//! Which casters a map needs (Lloyd, section 6.2; Stingl, section 3.3.6).
//!
//! A map is read at receivers, and only what lies between a receiver and the light casts a shadow on it. So the casters of
//! a map are those that touch its receivers swept towards the light without end: there is no plane on the light's side,
//! because casters in front of the map's depth range are clamped onto it, not cut.
//!
//! Which receivers a map has depends on the selection: the partition's with selection by depth (with the band of
//! [`depth_seam`](super::selection::depth_seam), if there is one); everything visible inside the map with selection by
//! best resolution ([`receivers_in_map`]). With the smaller body for the second rule casters would be missing.

use bevy_math::{DMat4, DVec3, Vec4Swizzles};

use super::{
    bounds::Bounds,
    polytope::{HalfSpace, Polytope, RELATIVE_TOLERANCE, magnitude},
};

/// All points from which light that travels on can reach a body of receivers.
#[derive(Clone, Debug, PartialEq)]
pub struct CasterVolume {
    half_spaces: Vec<HalfSpace>,
    /// Directions on which a box and the volume can be seen apart, besides the normals of `half_spaces`: interval of the
    /// volume, infinite on the light's side.
    slabs: Vec<Slab>,
    is_empty: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Slab {
    axis: DVec3,
    low: f64,
    high: f64,
}

impl CasterVolume {
    /// The volume of a body. Nothing touches that of an empty body. Light without a direction gives one that everything
    /// touches.
    pub fn new(receivers: &Polytope, light_travel: DVec3) -> Self {
        let mut volume = Self {
            half_spaces: Vec::new(),
            slabs: Vec::new(),
            is_empty: receivers.is_empty(),
        };
        let Some(light) = light_travel.try_normalize().filter(|_| !volume.is_empty) else {
            return volume;
        };
        let vertices = receivers.vertices();
        let tolerance = RELATIVE_TOLERANCE * magnitude(vertices);
        let slab = |axis: DVec3| {
            let projected = vertices.iter().map(|vertex| axis.dot(*vertex));
            let (low, high) = projected.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
            let towards_light = -axis.dot(light);
            Slab {
                axis,
                low: if towards_light < -PARALLEL {
                    f64::NEG_INFINITY
                } else {
                    low - tolerance
                },
                high: if towards_light > PARALLEL {
                    f64::INFINITY
                } else {
                    high + tolerance
                },
            }
        };
        let edges: Vec<DVec3> = receivers.edges().iter().map(|[a, b]| *b - *a).collect();
        let faces = receivers.faces().map(|face| face.half_space.normal);
        let sides = edges.iter().filter_map(|edge| edge.cross(light).try_normalize());
        for slab in faces.chain(sides).map(slab) {
            volume.push_sides(slab);
        }
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            volume.slabs.push(slab(axis));
            for edge in edges.iter().chain([&light]) {
                volume.slabs.extend(axis.cross(*edge).try_normalize().map(slab));
            }
        }
        volume
    }

    /// Adds the finite sides of a slab to the half-spaces, each once.
    fn push_sides(&mut self, slab: Slab) {
        for (normal, distance) in [(slab.axis, slab.high), (-slab.axis, -slab.low)] {
            let half_space = HalfSpace { normal, distance };
            let is_new = self
                .half_spaces
                .iter()
                .all(|known| known.normal.distance(normal) > 1.0e-9);
            if distance.is_finite() && is_new {
                self.half_spaces.push(half_space);
            }
        }
    }

    /// Half-spaces around the volume, for a GPU that culls with planes: none towards the light. They are its own faces and
    /// some that only touch it. Empty for an empty body.
    pub fn half_spaces(&self) -> &[HalfSpace] {
        &self.half_spaces
    }

    /// Whether a box may cast a shadow onto the receivers: false only if a plane separates it from the volume.
    ///
    /// Tests all planes that can separate two convex bodies (normals of both, and of every pair of edges), so it is exact
    /// up to rounding, which errs on the side of true. Boxes that are [empty](Bounds::is_empty) touch nothing.
    pub fn touches(&self, caster: &Bounds) -> bool {
        if self.is_empty || caster.is_empty() {
            return false;
        }
        let (center, half) = (caster.center(), caster.size() * 0.5);
        let interval = |axis: DVec3| {
            let (middle, reach) = (axis.dot(center), axis.abs().dot(half));
            (middle - reach, middle + reach)
        };
        // Comparisons with NaN are false: boxes without bounds are never apart.
        let is_apart = self
            .half_spaces
            .iter()
            .any(|half_space| interval(half_space.normal).0 > half_space.distance)
            || self.slabs.iter().any(|slab| {
                let (low, high) = interval(slab.axis);
                low > slab.high || high < slab.low
            });
        !is_apart
    }
}

/// Sine of the angle between a plane and the light below which the plane counts as parallel to it.
const PARALLEL: f64 = 1.0e-12;

/// What is visible and inside a map: the receivers of a map with selection by best resolution. `visible` is H of the whole
/// view, `clip_from_world` the map's matrix with reverse z.
pub fn receivers_in_map(visible: &Polytope, clip_from_world: &DMat4) -> Polytope {
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| clip_from_world.row(row));
    // Each row r stands for r · p >= 0.
    [w, w + x, w - x, w + y, w - y, z, w - z]
        .iter()
        .fold(visible.clone(), |body, row| {
            body.clip(&HalfSpace {
                normal: -row.xyz(),
                distance: row.w,
            })
        })
}

/// The first and the last partition whose volume a caster touches: firstSplit..lastSplit of Stingl, section 3.3.6, for
/// drawing a caster once with an instance per partition. `None` if it touches none. The range may hold volumes that it
/// does not touch, for bodies between which it lies.
pub fn partition_range(volumes: &[CasterVolume], caster: &Bounds) -> Option<(usize, usize)> {
    let first = volumes.iter().position(|volume| volume.touches(caster))?;
    let last = volumes.iter().rposition(|volume| volume.touches(caster))?;
    Some((first, last))
}
