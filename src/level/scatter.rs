//! Throws plants and rocks on a terrain by rules: dart throwing with a free distance around each.

use std::collections::HashMap;

use bevy_math::Vec2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{
    format::{ScatterRule, Species},
    noise,
    terrain::{Terrain, Track},
};

/// Darts per thing wanted before a rule gives up.
const DARTS: u32 = 40;

/// Something thrown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thrown {
    /// What.
    pub species: Species,
    /// Where (x, z).
    pub position: Vec2,
    /// Turn about +y in radians.
    pub yaw: f32,
    /// Uniform scale.
    pub scale: f32,
    /// Which of the species' shapes: any number.
    pub variant: u32,
    /// The rule's spacing.
    pub spacing: f32,
}

/// Throws all rules in order. Two things keep the mean of their rules' spacings between them; trees stay out of
/// clearings, and everything stays off tracks and where `is_free` says no.
pub fn scatter(terrain: &Terrain, rules: &[ScatterRule], is_free: impl Fn(Vec2) -> bool, seed: u64) -> Vec<Thrown> {
    let cell = rules.iter().map(|rule| rule.spacing).fold(1.0, f32::max);
    let mut near = Grid::new(cell);
    let mut thrown = Vec::new();
    for (i, rule) in rules.iter().enumerate() {
        // A stream per rule: changing one rule leaves the darts of the others where they are.
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(i as u64 + 1);
        let patches = seed as u32 ^ (0x51ed_270b_u32.wrapping_mul(i as u32 + 1));
        let mut left = rule.count;
        for _ in 0..u64::from(rule.count) * u64::from(DARTS) {
            if left == 0 {
                break;
            }
            let half = terrain.size() * 0.5 - 1.0;
            let dart = Thrown {
                species: rule.species,
                position: Vec2::new(
                    rng.random_range(-1.0..1.0) * half.x,
                    rng.random_range(-1.0..1.0) * half.y,
                ),
                yaw: rng.random_range(0.0..std::f32::consts::TAU),
                scale: rule.scale.0 + (rule.scale.1 - rule.scale.0) * rng.random::<f32>(),
                variant: rng.random(),
                spacing: rule.spacing,
            };
            let in_patch =
                rng.random::<f32>() >= rule.clumping * (0.55 - 1.6 * noise::octaves(patches, dart.position / 34.0, 2));
            if in_patch
                && is_free(dart.position)
                && allowed(terrain, rule, dart.position)
                && near.is_free(&thrown, &dart)
            {
                near.add(thrown.len(), dart.position);
                thrown.push(dart);
                left -= 1;
            }
        }
    }
    thrown
}

/// How far from the middle of a track a species stays.
pub fn track_distance(species: Species, track: &Track) -> f32 {
    track.free + if species.is_tree() { 1.2 } else { 1.0 }
}

fn allowed(terrain: &Terrain, rule: &ScatterRule, p: Vec2) -> bool {
    let height = terrain.height(p);
    let slope = terrain.normal(p).y.clamp(-1.0, 1.0).acos().to_degrees();
    (rule.height.0..=rule.height.1).contains(&height)
        && (rule.slope_deg.0..=rule.slope_deg.1).contains(&slope)
        && !(rule.species.is_tree() && terrain.clearings().iter().any(|c| p.distance(c.center) < c.radius))
        && terrain
            .tracks()
            .iter()
            .all(|track| track.distance(p) > track_distance(rule.species, track))
        && terrain.clearings().iter().all(|clearing| {
            let shore = clearing.pond.map_or(0.0, |pond| pond.radius + 1.0);
            p.distance(clearing.center) > shore
        })
}

/// Things by square cells.
struct Grid {
    cell: f32,
    things: HashMap<[i32; 2], Vec<usize>>,
}

impl Grid {
    fn new(cell: f32) -> Self {
        Self {
            cell,
            things: HashMap::new(),
        }
    }

    fn key(&self, p: Vec2) -> [i32; 2] {
        (p / self.cell).floor().as_ivec2().to_array()
    }

    fn add(&mut self, index: usize, p: Vec2) {
        self.things.entry(self.key(p)).or_default().push(index);
    }

    fn is_free(&self, thrown: &[Thrown], dart: &Thrown) -> bool {
        let [x, y] = self.key(dart.position);
        (-1..=1)
            .flat_map(|dy| (-1..=1).map(move |dx| [x + dx, y + dy]))
            .all(|key| {
                self.things.get(&key).into_iter().flatten().all(|i| {
                    let other = &thrown[*i];
                    dart.position.distance(other.position) >= 0.5 * (dart.spacing + other.spacing)
                })
            })
    }
}
