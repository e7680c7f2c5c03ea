//! [`Ground`]: what a walker stands on and bumps into.

use std::collections::HashMap;

use bevy_math::{Rot2, Vec2, Vec3};

use super::terrain::Terrain;

/// Side of a cell of the look-up grid in metres.
const GRID: f32 = 8.0;

/// Height, normal and obstacles of a level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    surface: Surface,
    steps: Vec<Step>,
    blockers: Vec<Blocker>,
    steps_at: HashMap<[i32; 2], Vec<u32>>,
    blockers_at: HashMap<[i32; 2], Vec<u32>>,
}

/// The ground itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// A plane at this height.
    Flat(f32),
    /// Hills.
    Hills(Box<Terrain>),
}

impl Default for Surface {
    fn default() -> Self {
        Self::Flat(0.0)
    }
}

/// An upright box that can be stepped on, such as a pavement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Smallest (x, z).
    pub min: Vec2,
    /// Largest (x, z).
    pub max: Vec2,
    /// Height of its top.
    pub top: f32,
}

/// An upright obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocker {
    /// Middle (x, z).
    pub center: Vec2,
    /// Outline.
    pub shape: BlockerShape,
    /// Lowest point; a walker whose head is lower passes below.
    pub bottom: f32,
    /// Highest point; a walker whose feet are higher passes above.
    pub top: f32,
}

/// Outline of a [`Blocker`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BlockerShape {
    /// An upright cylinder.
    Cylinder {
        /// Radius in metres.
        radius: f32,
    },
    /// An upright box.
    Box {
        /// Half its sides along its own axes.
        half: Vec2,
        /// Turn about +y in radians (as in `Quat::from_rotation_y`).
        yaw: f32,
    },
}

impl Blocker {
    /// The way out of the outline grown by `radius` for a point inside it; zero outside.
    fn push_out(&self, p: Vec2, radius: f32) -> Vec2 {
        match self.shape {
            BlockerShape::Cylinder { radius: own } => {
                let (offset, reach) = (p - self.center, own + radius);
                if offset.length_squared() >= reach * reach {
                    return Vec2::ZERO;
                }
                // Dead centre: any way out is as good.
                let out = offset.try_normalize().unwrap_or(Vec2::X);
                out * reach - offset
            }
            BlockerShape::Box { half, yaw } => {
                // A turn about +y takes x towards -z.
                let turn = Rot2::radians(-yaw);
                let local = turn.inverse() * (p - self.center);
                let nearest = local.clamp(-half, half);
                let offset = local - nearest;
                if offset != Vec2::ZERO {
                    let depth = radius - offset.length();
                    return if depth > 0.0 {
                        turn * (offset.normalize() * depth)
                    } else {
                        Vec2::ZERO
                    };
                }
                let room = half + radius - local.abs();
                let out = if room.x < room.y {
                    Vec2::new(room.x.copysign(local.x), 0.0)
                } else {
                    Vec2::new(0.0, room.y.copysign(local.y))
                };
                turn * out
            }
        }
    }

    /// Half the side of a square around the middle that contains the outline.
    fn reach(&self) -> f32 {
        match self.shape {
            BlockerShape::Cylinder { radius } => radius,
            BlockerShape::Box { half, .. } => half.length(),
        }
    }
}

/// Grid cells that a rectangle touches.
fn cells(min: Vec2, max: Vec2) -> impl Iterator<Item = [i32; 2]> {
    let (low, high) = ((min / GRID).floor().as_ivec2(), (max / GRID).floor().as_ivec2());
    (low.y..=high.y).flat_map(move |y| (low.x..=high.x).map(move |x| [x, y]))
}

impl Ground {
    /// A ground with steps and obstacles on it.
    pub fn new(surface: Surface, steps: Vec<Step>, blockers: Vec<Blocker>) -> Self {
        let mut ground = Self {
            surface,
            ..Self::default()
        };
        for (i, step) in steps.iter().enumerate() {
            for cell in cells(step.min, step.max) {
                ground.steps_at.entry(cell).or_default().push(i as u32);
            }
        }
        for (i, blocker) in blockers.iter().enumerate() {
            let reach = Vec2::splat(blocker.reach());
            for cell in cells(blocker.center - reach, blocker.center + reach) {
                ground.blockers_at.entry(cell).or_default().push(i as u32);
            }
        }
        Self {
            steps,
            blockers,
            ..ground
        }
    }

    /// A plane without obstacles.
    pub fn flat(height: f32) -> Self {
        Self::new(Surface::Flat(height), Vec::new(), Vec::new())
    }

    /// The hills, where there are any.
    pub fn terrain(&self) -> Option<&Terrain> {
        match &self.surface {
            Surface::Flat(_) => None,
            Surface::Hills(terrain) => Some(terrain),
        }
    }

    /// Height of the ground at (x, z), pavements included.
    pub fn height(&self, x: f32, z: f32) -> f32 {
        let p = Vec2::new(x, z);
        let ground = match &self.surface {
            Surface::Flat(height) => *height,
            Surface::Hills(terrain) => terrain.height(p),
        };
        let cell = (p / GRID).floor().as_ivec2().to_array();
        let near = self
            .steps_at
            .get(&cell)
            .into_iter()
            .flatten()
            .map(|i| self.steps[*i as usize]);
        near.filter(|step| p.cmpge(step.min).all() && p.cmple(step.max).all())
            .fold(ground, |height, step| height.max(step.top))
    }

    /// Unit normal of the ground at (x, z).
    pub fn normal(&self, x: f32, z: f32) -> Vec3 {
        match &self.surface {
            Surface::Flat(_) => Vec3::Y,
            Surface::Hills(terrain) => terrain.normal(Vec2::new(x, z)),
        }
    }

    /// All obstacles.
    pub fn blockers(&self) -> &[Blocker] {
        &self.blockers
    }

    /// Where an upright walker of this radius and height, with its feet at `feet`, ends up after obstacles have
    /// pushed it aside. The height is kept; ask [`Ground::height`] for the new one.
    pub fn push_out(&self, feet: Vec3, radius: f32, height: f32) -> Vec3 {
        let mut p = Vec2::new(feet.x, feet.z);
        // Out of one may be into another: three rounds settle corners, and more would not settle a crowd.
        for _ in 0..3 {
            let before = p;
            let reach = Vec2::splat(radius);
            for cell in cells(p - reach, p + reach) {
                for i in self.blockers_at.get(&cell).into_iter().flatten() {
                    let blocker = &self.blockers[*i as usize];
                    if blocker.bottom < feet.y + height && blocker.top > feet.y {
                        p += blocker.push_out(p, radius);
                    }
                }
            }
            if p == before {
                break;
            }
        }
        Vec3::new(p.x, feet.y, p.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocker(center: Vec2, shape: BlockerShape) -> Blocker {
        Blocker {
            center,
            shape,
            bottom: 0.0,
            top: 3.0,
        }
    }

    #[test]
    fn a_cylinder_pushes_out_to_its_rim() {
        let trunk = blocker(Vec2::new(20.0, 5.0), BlockerShape::Cylinder { radius: 0.5 });
        let ground = Ground::new(Surface::Flat(0.0), vec![], vec![trunk]);
        let out = ground.push_out(Vec3::new(20.2, 0.0, 5.0), 0.3, 1.8);
        assert!((out - Vec3::new(20.8, 0.0, 5.0)).length() < 1e-5, "{out}");
        let free = Vec3::new(21.0, 0.0, 5.0);
        assert_eq!(ground.push_out(free, 0.3, 1.8), free);
        let above = Vec3::new(20.2, 3.5, 5.0);
        assert_eq!(ground.push_out(above, 0.3, 1.8), above);
        assert!(ground.push_out(Vec3::new(20.0, 0.0, 5.0), 0.3, 1.8).is_finite());
    }

    #[test]
    fn a_turned_box_pushes_out_along_its_own_axes() {
        let yaw = 0.5;
        let half = Vec2::new(4.0, 1.0);
        let wall = blocker(Vec2::ZERO, BlockerShape::Box { half, yaw });
        let ground = Ground::new(Surface::Flat(0.0), vec![], vec![wall]);
        let rotation = bevy_math::Quat::from_rotation_y(yaw);
        for (local, expected) in [
            (Vec3::new(2.0, 0.0, 0.8), Vec3::new(2.0, 0.0, 1.3)),
            (Vec3::new(-2.0, 0.0, -1.2), Vec3::new(-2.0, 0.0, -1.3)),
            (Vec3::new(3.9, 0.0, 0.1), Vec3::new(4.3, 0.0, 0.1)),
            (Vec3::new(2.0, 0.0, 1.4), Vec3::new(2.0, 0.0, 1.4)),
        ] {
            let out = ground.push_out(rotation * local, 0.3, 1.8);
            assert!(
                (out - rotation * expected).length() < 1e-4,
                "{local} to {}",
                rotation.inverse() * out
            );
        }
    }

    #[test]
    fn steps_raise_the_ground_where_they_are() {
        let step = Step {
            min: Vec2::new(-3.0, -3.0),
            max: Vec2::new(30.0, 3.0),
            top: 0.15,
        };
        let ground = Ground::new(Surface::Flat(0.0), vec![step], vec![]);
        assert_eq!(ground.height(29.0, 2.9), 0.15);
        assert_eq!(ground.height(29.0, 3.1), 0.0);
        assert_eq!(ground.normal(0.0, 0.0), Vec3::Y);
    }
}
