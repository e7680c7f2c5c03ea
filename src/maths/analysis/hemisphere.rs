//! S̄ over all light directions above a viewer: the pictures of Lloyd et al. 2006, figure 7, and the worst direction.

use std::f64::consts::{FRAC_PI_2, TAU};

use bevy_math::DVec3;

use super::direction::{Scheme, Unanalysable};
use crate::maths::view::ViewVolume;

/// A direction to the light, relative to the viewer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightDirection {
    /// Angle from overhead (the camera's up direction), in radians: 0..=π/2 above the horizon.
    pub polar: f64,
    /// Angle about that from straight ahead, towards the right, in radians: π is behind the viewer.
    pub azimuth: f64,
}

impl LightDirection {
    /// The direction in which light travels, in the world, of unit length.
    pub fn light_travel(&self, view: &ViewVolume) -> DVec3 {
        let right = view.forward().cross(view.up());
        let (sine, cosine) = self.polar.sin_cos();
        -(view.up() * cosine + (view.forward() * self.azimuth.cos() + right * self.azimuth.sin()) * sine)
    }
}

/// S̄ for a grid of light directions: rings around overhead, from it down to the horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct StorageHemisphere {
    rings: usize,
    sectors: usize,
    /// The value overhead, then ring after ring.
    values: Vec<f64>,
}

impl StorageHemisphere {
    /// Evaluates a scheme. `rings` is the number of rings below the zenith (the last one is the horizon), `sectors` that of
    /// directions on each, the first of them straight ahead; both are at least 1.
    pub fn new(view: &ViewVolume, scheme: &Scheme, rings: usize, sectors: usize) -> Result<Self, Unanalysable> {
        let (rings, sectors) = (rings.max(1), sectors.max(1));
        let directions = (0..=rings).flat_map(|ring| {
            let count = if ring == 0 { 1 } else { sectors };
            (0..count).map(move |sector| direction(ring, rings, sector, sectors))
        });
        let values = directions
            .map(|direction| scheme.storage_factor(view, direction.light_travel(view)))
            .collect::<Result<_, _>>()?;
        Ok(Self { rings, sectors, values })
    }

    /// The number of rings below the zenith.
    pub fn rings(&self) -> usize {
        self.rings
    }

    /// The number of directions on every ring.
    pub fn sectors(&self) -> usize {
        self.sectors
    }

    /// The value on a ring (0 is the zenith) and in a sector, which wraps round. NaN below the horizon.
    pub fn value(&self, ring: usize, sector: usize) -> f64 {
        let index = match ring {
            0 => 0,
            _ => 1 + (ring - 1) * self.sectors + sector % self.sectors,
        };
        self.values.get(index).copied().unwrap_or(f64::NAN)
    }

    /// The largest value and where it is.
    pub fn largest(&self) -> (f64, LightDirection) {
        let (mut largest, mut place) = (f64::NEG_INFINITY, (0, 0));
        for (index, value) in self.values.iter().enumerate() {
            if *value > largest {
                largest = *value;
                place = match index {
                    0 => (0, 0),
                    _ => (1 + (index - 1) / self.sectors, (index - 1) % self.sectors),
                };
            }
        }
        (largest, direction(place.0, self.rings, place.1, self.sectors))
    }

    /// Geometric mean over the directions of the grid, each counted once.
    pub fn geometric_mean(&self) -> f64 {
        let logarithms: f64 = self.values.iter().map(|value| value.ln()).sum();
        (logarithms / self.values.len() as f64).exp()
    }
}

impl StorageHemisphere {
    /// Mean of the largest error √S̄ over all suns, each direction counted with its share of the sky: the error on both axes
    /// of maps that have as many texels in all as the picture has pixels (Lloyd, section 4.2); with r times as many it is
    /// √r times smaller.
    ///
    /// For a square picture of 60°, 18 rings of 36 directions:
    ///
    /// | f ÷ n | uniform | W | FP+W | ZP4+W |
    /// |---|---|---|---|---|
    /// | 10 | 11.2 | 5.59 | 4.23 | 3.34 |
    /// | 100 | 114 | 28.2 | 13.5 | 5.25 |
    /// | 1000 | 1144 | 216 | 42.8 | 7.72 |
    /// | 10 000 | 11 446 | 2218 | 135 | 11.2 |
    pub fn mean_error(&self) -> f64 {
        let half_step = 0.5 * FRAC_PI_2 / self.rings as f64;
        let share = |ring: usize| {
            let polar = FRAC_PI_2 * ring as f64 / self.rings as f64;
            let [upper, lower] = [polar - half_step, polar + half_step].map(|angle| angle.clamp(0.0, FRAC_PI_2).cos());
            (upper - lower) / if ring == 0 { 1.0 } else { self.sectors as f64 }
        };
        let rings = (0..=self.rings).map(|ring| {
            let count = if ring == 0 { 1 } else { self.sectors };
            let errors = (0..count).map(|sector| self.value(ring, sector).sqrt());
            share(ring) * errors.sum::<f64>()
        });
        rings.sum()
    }
}

fn direction(ring: usize, rings: usize, sector: usize, sectors: usize) -> LightDirection {
    LightDirection {
        polar: FRAC_PI_2 * ring as f64 / rings as f64,
        azimuth: TAU * sector as f64 / sectors as f64,
    }
}

/// The worst light direction of a scheme above the horizon and its S̄: the largest value of a grid, then a compass search
/// from there with halved steps. Finds the peak of the hill that the grid's largest value lies on; peaks narrower than the
/// grid can be missed.
pub fn worst_direction(view: &ViewVolume, scheme: &Scheme) -> Result<(f64, LightDirection), Unanalysable> {
    const RINGS: usize = 18;
    const SECTORS: usize = 36;
    let (mut largest, mut place) = StorageHemisphere::new(view, scheme, RINGS, SECTORS)?.largest();
    let mut step = FRAC_PI_2 / RINGS as f64;
    while step > 1.0e-5 {
        let mut is_better = false;
        for (down, round) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let candidate = LightDirection {
                polar: (place.polar + down * step).clamp(0.0, FRAC_PI_2),
                azimuth: place.azimuth + round * step,
            };
            let storage = scheme.storage_factor(view, candidate.light_travel(view))?;
            if storage > largest {
                (largest, place, is_better) = (storage, candidate, true);
            }
        }
        if !is_better {
            step *= 0.5;
        }
    }
    Ok((largest, place))
}
