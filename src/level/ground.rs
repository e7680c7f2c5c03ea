//! [`Ground`]: what a walker stands on and bumps into.

use std::collections::HashMap;

use bevy_math::{Rot2, Vec2, Vec3};

use super::{grove::Grove, land::Land, terrain::Terrain};

/// Side of a cell of the look-up grid in metres.
const GRID: f32 = 8.0;

/// Height, normal and obstacles of a level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    surface: Surface,
    /// Extent along x and z, centred on the origin; absent: endless.
    extent: Option<Vec2>,
    steps: Vec<Step>,
    blockers: Vec<Blocker>,
    steps_at: HashMap<[i32; 2], Vec<u32>>,
    blockers_at: HashMap<[i32; 2], Vec<u32>>,
    /// Trees whose trunks are worked out where a walker is.
    grove: Option<Grove>,
}

/// The ground itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// A plane at this height.
    Flat(f32),
    /// Hills.
    Hills(Box<Terrain>),
    /// Rolling ground of any size.
    Land(Land),
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
    /// Signed distance of (x, z) from the side of the outline, negative inside, and the unit direction that increases
    /// it most.
    pub fn outwards(&self, p: Vec2) -> (f32, Vec2) {
        let offset = p - self.center;
        match self.shape {
            // Dead center: any way out is as good.
            BlockerShape::Cylinder { radius } => (offset.length() - radius, offset.try_normalize().unwrap_or(Vec2::X)),
            BlockerShape::Box { half, yaw } => {
                // A turn about +y takes x towards -z.
                let turn = Rot2::radians(-yaw);
                let local = turn.inverse() * offset;
                let beyond = local.abs() - half;
                let signs = Vec2::new(1f32.copysign(local.x), 1f32.copysign(local.y));
                let outside = beyond.max(Vec2::ZERO);
                let (distance, way_out) = match outside.try_normalize() {
                    Some(direction) => (outside.length(), direction),
                    None if beyond.x > beyond.y => (beyond.x, Vec2::X),
                    None => (beyond.y, Vec2::Y),
                };
                (distance, turn * (way_out * signs))
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

    /// The same with an end: `extent` metres along x and z, centred on the origin.
    #[must_use]
    pub fn within(mut self, extent: Vec2) -> Self {
        self.extent = Some(extent);
        self
    }

    /// The same with a grove on it.
    #[must_use]
    pub fn with_grove(mut self, grove: Grove) -> Self {
        self.grove = Some(grove);
        self
    }

    /// Extent along x and z, centred on the origin; `None` where there is no end.
    pub fn extent(&self) -> Option<Vec2> {
        let own = || match &self.surface {
            Surface::Flat(_) => None,
            Surface::Hills(terrain) => Some(terrain.size()),
            Surface::Land(land) => Some(land.size()),
        };
        self.extent.or_else(own)
    }

    /// A plane without obstacles.
    pub fn flat(height: f32) -> Self {
        Self::new(Surface::Flat(height), Vec::new(), Vec::new())
    }

    /// The hills, where there are any.
    pub fn terrain(&self) -> Option<&Terrain> {
        match &self.surface {
            Surface::Flat(_) | Surface::Land(_) => None,
            Surface::Hills(terrain) => Some(terrain),
        }
    }

    /// Height of the ground at (x, z), pavements included.
    pub fn height(&self, x: f32, z: f32) -> f32 {
        let p = Vec2::new(x, z);
        let ground = match &self.surface {
            Surface::Flat(height) => *height,
            Surface::Hills(terrain) => terrain.height(p),
            Surface::Land(land) => land.height(p),
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
            Surface::Land(land) => land.normal(Vec2::new(x, z)),
        }
    }

    /// All pavements.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// All obstacles, without the trunks of a grove.
    pub fn blockers(&self) -> &[Blocker] {
        &self.blockers
    }

    /// The obstacles whose outlines come nearer to (x, z) than `reach` metres, each once, in the order of
    /// [`Ground::blockers`], then the trunks of a grove. Their heights are not asked.
    pub fn blockers_near(&self, p: Vec2, reach: f32) -> Vec<Blocker> {
        let corner = Vec2::splat(reach);
        let in_cells = cells(p - corner, p + corner).filter_map(|cell| self.blockers_at.get(&cell));
        let mut indices: Vec<u32> = in_cells.flatten().copied().collect();
        indices.sort_unstable();
        indices.dedup();
        let blockers = indices.into_iter().map(|i| self.blockers[i as usize]);
        let trunks = self.grove.iter().flat_map(|grove| grove.blockers_near(p, reach));
        let near = blockers.filter(|blocker| blocker.outwards(p).0 < reach);
        near.chain(trunks).collect()
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
    fn the_way_out_of_a_cylinder_is_to_its_rim() {
        let trunk = blocker(Vec2::new(20.0, 5.0), BlockerShape::Cylinder { radius: 0.5 });
        for (p, distance) in [(Vec2::new(20.2, 5.0), -0.3), (Vec2::new(21.5, 5.0), 1.0)] {
            let (found, way_out) = trunk.outwards(p);
            assert!((found - distance).abs() < 1e-5, "{p}: {found}");
            assert!((way_out - Vec2::X).length() < 1e-5, "{p}: {way_out}");
        }
        assert_eq!(trunk.outwards(trunk.center).0, -0.5);
        assert!(trunk.outwards(trunk.center).1.is_normalized(), "dead center");
    }

    #[test]
    fn the_way_out_of_a_turned_box_is_along_its_own_axes() {
        let yaw = 0.5;
        let half = Vec2::new(4.0, 1.0);
        let wall = blocker(Vec2::ZERO, BlockerShape::Box { half, yaw });
        let rotation = bevy_math::Quat::from_rotation_y(yaw);
        for (local, distance, expected) in [
            (Vec3::new(2.0, 0.0, 0.8), -0.2, Vec3::Z),
            (Vec3::new(-2.0, 0.0, -1.2), 0.2, Vec3::NEG_Z),
            (Vec3::new(3.9, 0.0, 0.1), -0.1, Vec3::X),
            (Vec3::new(-7.0, 0.0, 5.0), 5.0, Vec3::new(-0.6, 0.0, 0.8)),
        ] {
            let p = rotation * local;
            let (found, way_out) = wall.outwards(Vec2::new(p.x, p.z));
            assert!((found - distance).abs() < 1e-4, "{local}: {found}");
            let way_out = rotation.inverse() * Vec3::new(way_out.x, 0.0, way_out.y);
            assert!((way_out - expected).length() < 1e-4, "{local}: {way_out}");
        }
    }

    #[test]
    fn nearby_obstacles_are_found_once_and_far_ones_not() {
        let long = BlockerShape::Box {
            half: Vec2::new(40.0, 0.1),
            yaw: 0.8,
        };
        let trunk = BlockerShape::Cylinder { radius: 0.5 };
        let blockers = vec![
            blocker(Vec2::ZERO, long),
            blocker(Vec2::new(3.0, 0.0), trunk),
            blocker(Vec2::new(90.0, 0.0), trunk),
        ];
        let ground = Ground::new(Surface::Flat(0.0), vec![], blockers.clone());
        let near = |p: Vec2, reach| ground.blockers_near(p, reach);
        assert_eq!(near(Vec2::ZERO, 10.0), blockers[..2]);
        assert_eq!(near(Vec2::new(89.0, 0.0), 0.6), blockers[2..]);
        assert_eq!(near(Vec2::new(89.0, 0.0), 0.4), []);
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
