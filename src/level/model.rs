//! [`Model`] and [`Placement`]: what generators hand to the spawner.

use bevy_math::{Quat, Vec2, Vec3};

use super::{
    buildings::Building,
    format::Species,
    ground::{Blocker, BlockerShape},
    made::{Foot, Made},
    meshes::{MeshData, Rgb},
    props,
    simple_trees::{self, SimpleTree},
    species,
};

/// Something that may stand in many places; equal models share their meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Model {
    /// A plant, rock or piece of dead wood in one of its shapes, any number.
    Plant(Species, u32),
    /// A tree of few triangles in one of its shapes.
    SimpleTree(SimpleTree, u32),
    /// A plain fence post of 1 m.
    FencePost,
    /// Plain fence rails of 1 m along +x.
    FenceRails,
    /// Something that people put up.
    Made(Made),
    /// A building.
    Building(Building),
    /// A cube of side 1 on the ground; the index of its paint in [`PRIMITIVE_PAINTS`].
    Cube(u8),
    /// A ball of diameter 1 on the ground.
    Ball(u8),
    /// An upright cylinder of diameter 1 and height 1 on the ground.
    Pole(u8),
}

/// Colours of cubes, balls and poles.
pub const PRIMITIVE_PAINTS: [Rgb; 4] = [[0.55, 0.2, 0.12], [0.2, 0.32, 0.5], [0.5, 0.47, 0.4], [0.1, 0.1, 0.1]];

/// One variant of a model file, `assets/models/FILE.glb`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AssetRef {
    /// The file's name without extension.
    pub file: &'static str,
    /// Index of the variant in the file, modulo how many there are.
    pub variant: u32,
}

/// A colour that multiplies an asset's own where its materials take one; sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tint(pub [u8; 3]);

impl Tint {
    /// Leaves an asset as it is.
    pub const WHITE: Self = Self([255; 3]);
}

/// One thing in the level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// What.
    pub model: Model,
    /// Where its foot is.
    pub position: Vec3,
    /// How it is turned.
    pub rotation: Quat,
    /// How it is scaled; positive.
    pub scale: Vec3,
    /// Colour of an asset's paint or leaves; models that are built here have their own colours.
    pub tint: Tint,
}

impl Placement {
    /// Something upright at its own size.
    pub fn upright(model: Model, position: Vec3, yaw: f32) -> Self {
        Self {
            model,
            position,
            rotation: Quat::from_rotation_y(yaw),
            scale: Vec3::ONE,
            tint: Tint::WHITE,
        }
    }

    /// What a walker bumps into here.
    pub fn blocker(&self) -> Option<Blocker> {
        let center = Vec2::new(self.position.x, self.position.z);
        let turned = |half_x: f32, half_z: f32| BlockerShape::Box {
            half: Vec2::new(half_x * self.scale.x, half_z * self.scale.z),
            yaw: self.rotation.to_euler(bevy_math::EulerRot::YXZ).0,
        };
        let round = |radius: f32| BlockerShape::Cylinder {
            radius: radius * self.scale.x,
        };
        let (shape, height) = match self.model {
            Model::Plant(species, _) => {
                let radius = species::foot_radius(species)?;
                (round(radius), species::height(species))
            }
            Model::SimpleTree(tree, _) => (round(simple_trees::foot_radius(tree)), simple_trees::height(tree)),
            // The rails between posts are what stops a walker; see the generators, which know both ends.
            Model::FencePost => (round(0.1), 1.0),
            Model::FenceRails => return Some(self.wall(1.0, 1.0)),
            Model::Made(made) => {
                let shape = match made.foot() {
                    Foot::Free => return None,
                    Foot::Round(radius) => round(radius),
                    Foot::Box(half_x, half_z) => turned(half_x, half_z),
                    Foot::Wall(length) => return Some(self.wall(length, made.height())),
                };
                (shape, made.height())
            }
            Model::Building(building) => {
                let (width, depth) = building.plan();
                (turned(0.5 * width, 0.5 * depth), building.wall_height())
            }
            Model::Cube(_) => (turned(0.5, 0.5), 1.0),
            Model::Ball(_) | Model::Pole(_) => (round(0.5), 1.0),
        };
        Some(Blocker {
            center,
            shape,
            bottom: self.position.y - 1.0,
            top: self.position.y + height * self.scale.y,
        })
    }

    /// The blocker of something thin, `length` metres along +x from its foot at scale 1.
    fn wall(&self, length: f32, height: f32) -> Blocker {
        let half = 0.5 * length * self.scale.x;
        let middle = self.position + self.rotation * (Vec3::X * half);
        Blocker {
            center: Vec2::new(middle.x, middle.z),
            shape: BlockerShape::Box {
                half: Vec2::new(half, 0.05 * self.scale.z),
                yaw: self.rotation.to_euler(bevy_math::EulerRot::YXZ).0,
            },
            bottom: middle.y - 1.0,
            top: middle.y + height * self.scale.y,
        }
    }
}

impl Model {
    /// The file that it is drawn with; `None`: [`build`](Self::build) makes its mesh.
    pub fn asset(&self) -> Option<AssetRef> {
        match *self {
            Self::Plant(species, variant) => Some(species::asset(species, variant)),
            // Only its material: a building's meshes are put together from the kit.
            Self::Building(_) => Some(Building::asset()),
            Self::Made(made) => Some(made.asset()),
            _ => None,
        }
    }

    /// Half the extent in metres of a box that may stand in for its file, at scale 1.
    pub fn half_extent(&self) -> Vec3 {
        match *self {
            Self::Plant(species, _) => species::half_extent(species),
            Self::Building(building) => {
                let (width, depth) = building.plan();
                Vec3::new(width, building.wall_height(), depth) * 0.5
            }
            Self::Made(made) => made.half_extent(),
            _ => Vec3::splat(0.5),
        }
    }

    /// Builds the mesh that all placements of this model share; empty for models with an [`asset`](Self::asset).
    pub fn build(&self) -> MeshData {
        match *self {
            Self::Plant(..) | Self::Building(_) | Self::Made(_) => MeshData::default(),
            Self::SimpleTree(tree, variant) => simple_trees::build(tree, variant),
            Self::FencePost => props::fence_post(),
            Self::FenceRails => props::fence_rails(),
            Self::Cube(paint) => {
                let mut mesh = MeshData::default();
                mesh.push_box(Vec3::Y * 0.5, Vec3::ONE, primitive_paint(paint));
                mesh
            }
            Self::Ball(paint) => ball(primitive_paint(paint)),
            Self::Pole(paint) => {
                let mut mesh = MeshData::default();
                let color = primitive_paint(paint);
                mesh.push_round((Vec3::ZERO, 0.5), (Vec3::Y, 0.5), 16, (color, color));
                mesh
            }
        }
    }
}

fn primitive_paint(index: u8) -> Rgb {
    PRIMITIVE_PAINTS[usize::from(index) % PRIMITIVE_PAINTS.len()]
}

/// A smooth ball of diameter 1 on the ground.
fn ball(color: Rgb) -> MeshData {
    let (rings, sides) = (16, 32);
    let mut mesh = MeshData::default();
    for ring in 0..=rings {
        let (ring_sin, ring_cos) = (ring as f32 / rings as f32 * std::f32::consts::PI).sin_cos();
        for side in 0..=sides {
            let (sin, cos) = ((side % sides) as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
            let sin_ring = if ring == rings { 0.0 } else { ring_sin };
            let normal = Vec3::new(sin_ring * cos, ring_cos, sin_ring * sin).normalize();
            mesh.push_vertex(Vec3::Y * 0.5 + normal * 0.5, normal, color, Vec2::ZERO);
        }
    }
    for ring in 0..rings {
        for side in 0..sides {
            let a = ring * (sides + 1) + side;
            let (b, c, d) = (a + 1, a + sides + 1, a + sides + 2);
            if ring > 0 {
                mesh.indices.extend([a, b, d]);
            }
            if ring + 1 < rings {
                mesh.indices.extend([a, d, c]);
            }
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::meshes::tests::assert_solid;

    #[test]
    fn primitives_are_solid_and_of_unit_size() {
        for model in [Model::Cube(0), Model::Ball(1), Model::Pole(2)] {
            let mesh = model.build();
            assert_solid(&mesh, &format!("{model:?}"));
            let (min, max) = mesh.bounds().unwrap();
            assert!((min - Vec3::new(-0.5, 0.0, -0.5)).length() < 1e-3, "{model:?} {min}");
            assert!((max - Vec3::new(0.5, 1.0, 0.5)).length() < 1e-3, "{model:?} {max}");
        }
    }
}
