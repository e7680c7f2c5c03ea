//! Buildings from bays: storeys and roofs that many buildings share.
//!
//! A building stands on the origin, its front looks along +z. Storeys of one building have the same plan, so that a
//! stack of them with its roof is closed. Pure functions; what differs from building to building (size, paint) is left
//! to the placement: stretch by [`Building::stretch`], tint.

use bevy_math::{Vec2, Vec3};

use super::{
    Style, atlas,
    bays::{self, BELOW, Bay, Detail, FLOOR, GROUND_FLOOR, Storey},
    brush::Brush,
    roofs,
};
use crate::forge::mesh::Mesh;

/// What a building is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Building {
    /// How it is built.
    pub style: Style,
    /// Bays along the front and along the sides; at least one.
    pub bays: (u32, u32),
    /// Storeys, the one on the street included; at least one.
    pub storeys: u32,
    /// No windows on the right and on the left side, seen from the street.
    pub blind: (bool, bool),
    /// Which of several looks.
    pub look: u32,
}

/// A part that buildings share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Shared {
    /// How it is built.
    pub style: Style,
    /// Bays along the front and along the sides.
    pub bays: (u32, u32),
    /// Which part.
    pub part: SharedPart,
}

/// Which part of a building.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SharedPart {
    /// A storey.
    Storey {
        /// Shops and doors, or not.
        storey: Storey,
        /// As in [`Building::blind`].
        blind: (bool, bool),
        /// A row of balconies along the front.
        noble: bool,
        /// Which of [`LOOKS`] looks.
        look: u32,
    },
    /// The roof and what stands on it, in one of [`roofs::LOOKS`] looks.
    Roof {
        /// Which look.
        look: u32,
        /// With masts: a high building.
        high: bool,
    },
}

/// Looks of storeys.
pub const LOOKS: u32 = 2;
/// From so many storeys on roofs carry masts.
const HIGH: u32 = 12;

impl Building {
    /// The bays that fit best into a plan, in metres along the front and along the sides: two at least.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "rounded and at least 2"
    )]
    pub fn bays_for(style: Style, plan: Vec2) -> (u32, u32) {
        let count = |metres: f32| (metres / style.bay()).round().max(2.0) as u32;
        (count(plan.x), count(plan.y))
    }

    /// Extent of the walls in metres along x and z before stretching.
    pub fn plan(&self) -> Vec2 {
        plan(self.style, self.bays)
    }

    /// Scale along x and z that makes the walls as long as `plan`.
    pub fn stretch(&self, plan: Vec2) -> Vec2 {
        plan / self.plan()
    }

    /// Height of the walls in metres.
    pub fn wall_height(storeys: u32) -> f32 {
        GROUND_FLOOR + storeys.saturating_sub(1) as f32 * FLOOR
    }

    /// Its parts and the height of each above the foot in metres.
    pub fn parts(&self) -> Vec<(Shared, f32)> {
        let shared = |part: SharedPart| Shared {
            style: self.style,
            bays: self.bays,
            part,
        };
        let mut parts = Vec::new();
        for number in 0..self.storeys.max(1) {
            let last = number + 1 == self.storeys;
            let noble = self.style == Style::Stucco && (number == 1 || last && number > 2);
            let part = SharedPart::Storey {
                storey: if number == 0 { Storey::Ground } else { Storey::Upper },
                blind: self.blind,
                noble,
                look: (self.look + number) % LOOKS,
            };
            let height = if number == 0 { 0.0 } else { Self::wall_height(number) };
            parts.push((shared(part), height));
        }
        let roof = SharedPart::Roof {
            look: self.look % roofs::LOOKS,
            high: self.storeys >= HIGH,
        };
        parts.push((shared(roof), Self::wall_height(self.storeys)));
        parts
    }

    /// The whole building in one mesh.
    pub fn whole(&self, detail: Detail) -> Mesh {
        let mut whole = Brush::default().mesh;
        for (shared, height) in self.parts() {
            let mut mesh = shared.build(detail);
            for vertex in &mut mesh.vertices {
                vertex.position.y += height;
            }
            whole.append(&mesh);
        }
        whole
    }

    /// A small building that shows a style.
    pub fn sample(style: Style) -> Self {
        let (bays, storeys) = match style {
            Style::Stucco => ((5, 4), 5),
            Style::Brick => ((4, 4), 6),
            Style::Concrete => ((5, 4), 5),
            Style::Office => ((5, 5), 12),
            Style::Ribbon => ((5, 4), 9),
            Style::House => ((4, 3), 2),
        };
        Self {
            style,
            bays,
            storeys,
            blind: (false, false),
            look: 0,
        }
    }
}

/// Extent of walls in metres along x and z.
pub fn plan(style: Style, bays: (u32, u32)) -> Vec2 {
    Vec2::new(bays.0 as f32, bays.1 as f32) * style.bay()
}

impl Shared {
    /// Builds the part; its foot is the middle of its floor, a roof's that of the top of the walls.
    pub fn build(&self, detail: Detail) -> Mesh {
        let size = plan(self.style, self.bays);
        match self.part {
            SharedPart::Roof { look, high } => roofs::roof(self.style, self.bays, look, high, detail).mesh,
            SharedPart::Storey {
                storey,
                blind,
                noble,
                look,
            } => {
                let mut brush = Brush::default();
                for (number, side) in Side::around(size).into_iter().enumerate() {
                    let count = if number % 2 == 0 { self.bays.0 } else { self.bays.1 };
                    let is_blind = number == 1 && blind.0 || number == 3 && blind.1;
                    for i in 0..count {
                        let bay = if is_blind {
                            Bay::Blank
                        } else {
                            self.bay_at(storey, number, i, count, noble, look)
                        };
                        let piece = bays::bay(self.style, storey, bay, detail);
                        side.place(&mut brush.mesh, &piece.mesh, i as f32 * self.style.bay());
                    }
                    for piece in [
                        bays::side(self.style, storey, detail, side.length),
                        bays::corner(self.style, storey, detail),
                    ] {
                        side.place(&mut brush.mesh, &piece.mesh, 0.0);
                    }
                }
                if storey == Storey::Ground {
                    lid(&mut brush, self.bays, size, -BELOW, false);
                }
                brush.mesh
            }
        }
    }

    /// Which bay stands where: sides are 0 front, 1 right, 2 back, 3 left.
    fn bay_at(&self, storey: Storey, side: usize, i: u32, count: u32, noble: bool, look: u32) -> Bay {
        let dice = hash(self.style as u32 * 64 + side as u32 * 16 + look * 4 + count, i);
        let window = Bay::Window((dice % u32::from(Bay::LOOKS)) as u8);
        let shops = self.style != Style::House && (self.style != Style::Concrete || look == 0);
        match (storey, side) {
            (Storey::Ground, 0) if i == count / 2 => Bay::Door,
            // Neighbours differ.
            (Storey::Ground, 0) if shops => Bay::Shop(((i + look) % 3) as u8),
            (Storey::Ground, 2) if i == 0 => Bay::Door,
            (Storey::Upper, 0) if noble => Bay::Balcony((dice % 2) as u8),
            // Above each other on all floors.
            (Storey::Upper, 0 | 2) if self.style == Style::Concrete && i % 2 == 1 => Bay::Balcony((dice % 2) as u8),
            _ => window,
        }
    }
}

/// One side of a plan.
#[derive(Clone, Copy, Debug)]
pub struct Side {
    /// Its left end, seen from outside.
    pub start: Vec3,
    /// To the right, a unit vector.
    pub along: Vec3,
    /// Outward, a unit vector.
    pub out: Vec3,
    /// Metres.
    pub length: f32,
}

impl Side {
    /// Front, right, back and left of a plan around the origin.
    pub fn around(plan: Vec2) -> [Self; 4] {
        let half = plan * 0.5;
        let side = |x: f32, z: f32, along: Vec3, length: f32| Self {
            start: Vec3::new(x * half.x, 0.0, z * half.y),
            along,
            out: along.cross(Vec3::Y),
            length,
        };
        [
            side(-1.0, 1.0, Vec3::X, plan.x),
            side(1.0, 1.0, Vec3::NEG_Z, plan.y),
            side(1.0, -1.0, Vec3::NEG_X, plan.x),
            side(-1.0, -1.0, Vec3::Z, plan.y),
        ]
    }

    /// A point of a piece on this side.
    pub fn point(&self, p: Vec3) -> Vec3 {
        self.start + self.along * p.x + Vec3::Y * p.y + self.out * p.z
    }

    /// Adds a piece `along` metres from the start.
    pub fn place(&self, mesh: &mut Mesh, piece: &Mesh, along: f32) {
        let mut piece = piece.clone();
        for vertex in &mut piece.vertices {
            let n = vertex.normal;
            vertex.position = self.point(vertex.position + Vec3::X * along);
            vertex.normal = self.along * n.x + Vec3::Y * n.y + self.out * n.z;
            vertex.tangent = self.along;
        }
        mesh.append(&piece);
    }
}

/// Closes a stack of storeys with a fan whose border has a corner at every bay.
pub fn lid(brush: &mut Brush, bays: (u32, u32), plan: Vec2, y: f32, up: bool) {
    let middle = Vec3::Y * y;
    let uv = |p: Vec3| atlas::GRAVEL.at(p.x + p.z, 0.5);
    for (number, side) in Side::around(plan).into_iter().enumerate() {
        let count = if number % 2 == 0 { bays.0 } else { bays.1 };
        for i in 0..count {
            let at = |k: u32| side.point(Vec3::new(side.length * k as f32 / count as f32, y, 0.0));
            let (a, b) = if up { (at(i), at(i + 1)) } else { (at(i + 1), at(i)) };
            brush.triangle([(middle, uv(middle), 0.8), (a, uv(a), 0.8), (b, uv(b), 0.8)]);
        }
    }
}

/// A number that belongs to a place.
pub fn hash(seed: u32, i: u32) -> u32 {
    let mut h = seed.wrapping_mul(0x9e37_79b1) ^ i.wrapping_add(1).wrapping_mul(0x85eb_ca77);
    for factor in [0x85eb_ca6b_u32, 0xc2b2_ae35] {
        h ^= h >> 16;
        h = h.wrapping_mul(factor);
    }
    h ^ (h >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forge::city::facade::brush::tests::assert_closed;

    #[test]
    fn buildings_are_closed_at_every_detail() {
        for style in Style::ALL {
            for (bays, storeys, blind) in [
                ((5, 4), 5, (false, false)),
                ((3, 6), 14, (true, false)),
                ((2, 2), 1, (false, true)),
            ] {
                for look in 0..roofs::LOOKS {
                    let building = Building {
                        style,
                        bays,
                        storeys,
                        blind,
                        look,
                    };
                    for detail in Detail::ALL {
                        let volume = assert_closed(&building.whole(detail), &format!("{building:?} {detail:?}"));
                        let plan = building.plan();
                        let walls = plan.x * plan.y * (Building::wall_height(storeys) + BELOW);
                        assert!(
                            (0.9..1.7).contains(&(volume / walls)),
                            "{building:?}: {volume} of {walls} m³"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn walls_fill_the_plan() {
        let building = Building {
            storeys: 3,
            ..Building::sample(Style::Brick)
        };
        let ground = building.parts()[0].0.build(Detail::Far);
        let (low, high) = ground.bounds().expect("triangles");
        // Four bays of 3 m each way.
        assert!(low.distance(Vec3::new(-6.0, -0.3, -6.0)) < 1e-4, "{low}");
        assert!(high.distance(Vec3::new(6.0, 4.0, 6.0)) < 1e-4, "{high}");
        assert_eq!(building.stretch(Vec2::new(15.0, 11.0)), Vec2::new(1.25, 11.0 / 12.0));
        let heights: Vec<f32> = building.parts().iter().map(|(_, height)| *height).collect();
        assert_eq!(heights, [0.0, 4.0, 7.2, 10.4]);
    }

    #[test]
    fn bays_are_as_many_as_fit_best() {
        assert_eq!(Building::bays_for(Style::Brick, Vec2::new(16.4, 13.0)), (5, 4));
        assert_eq!(Building::bays_for(Style::Brick, Vec2::new(16.6, 1.0)), (6, 2));
    }

    #[test]
    fn coarser_levels_have_far_fewer_triangles() {
        for style in Style::ALL {
            let counts = Detail::ALL.map(|detail| Building::sample(style).whole(detail).triangle_count());
            println!("{style:?}: {counts:?} triangles");
            assert!(
                counts[1] * 3 < counts[0] && counts[2] <= counts[1],
                "{style:?}: {counts:?}"
            );
        }
    }
}
