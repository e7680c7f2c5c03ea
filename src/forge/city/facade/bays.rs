//! Bays: one window's width of one floor, and what stands at the corners of a floor.
//!
//! A bay runs from x = 0 to its style's width, looks along +z, and its wall lies on z = 0. Its border is a rectangle
//! without corners in between, so that any bay meets any other without a gap. Corners have the same frame: walls run
//! along +x and along −z from the origin.

use bevy_math::{Vec2, Vec3};

use super::{
    Style,
    atlas::{self, Cell, Strip},
    brush::Brush,
    kit,
};
use crate::forge::mesh::Mesh;

/// Height of a floor in metres.
pub const FLOOR: f32 = 3.2;
/// Height of the ground floor above the foot in metres.
pub const GROUND_FLOOR: f32 = 4.0;
/// How far walls reach below the foot in metres.
pub const BELOW: f32 = 0.3;

/// Which floor of a building.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Storey {
    /// The one on the street.
    Ground,
    /// Those above.
    Upper,
}

impl Storey {
    /// Lowest and highest point of the wall in metres.
    pub fn reach(self) -> (f32, f32) {
        match self {
            Self::Ground => (-BELOW, GROUND_FLOOR),
            Self::Upper => (0.0, FLOOR),
        }
    }
}

/// What is in a bay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Bay {
    /// Wall.
    Blank,
    /// A window, in one of [`Bay::LOOKS`] looks.
    Window(u8),
    /// A tall window behind a railing, on a slab where the style has balconies.
    Balcony(u8),
    /// The front door.
    Door,
    /// A shop with its sign and awning.
    Shop(u8),
}

impl Bay {
    /// Looks of windows.
    pub const LOOKS: u8 = 3;

    /// All that a style has on a storey, blank walls aside.
    pub fn all(style: Style, storey: Storey) -> Vec<Self> {
        let looks = |make: fn(u8) -> Self, count: u8| (0..count).map(make);
        let windows = looks(Self::Window, Self::LOOKS);
        match storey {
            Storey::Upper if style.has_balconies() => windows.chain(looks(Self::Balcony, 2)).collect(),
            Storey::Upper => windows.collect(),
            Storey::Ground if style == Style::House => windows.chain([Self::Door]).collect(),
            Storey::Ground => windows.chain([Self::Door]).chain(looks(Self::Shop, 3)).collect(),
        }
    }

    /// Name of the piece's variant.
    pub fn name(self) -> String {
        match self {
            Self::Blank => "blank".into(),
            Self::Window(look) => format!("window{look}"),
            Self::Balcony(look) => format!("balcony{look}"),
            Self::Door => "door".into(),
            Self::Shop(look) => format!("shop{look}"),
        }
    }

    fn look(self) -> u8 {
        match self {
            Self::Blank | Self::Door => 0,
            Self::Window(look) | Self::Balcony(look) | Self::Shop(look) => look,
        }
    }
}

/// How much is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Detail {
    /// Reveals, sills, railings of bars.
    Near,
    /// Painted windows; slabs, rails and cornices.
    Middle,
    /// Painted windows; slabs and cornices.
    Far,
}

impl Detail {
    /// From fine to coarse.
    pub const ALL: [Self; 3] = [Self::Near, Self::Middle, Self::Far];
}

/// A rectangular hole in a wall.
#[derive(Clone, Copy, Debug)]
struct Hole {
    low: Vec2,
    high: Vec2,
    depth: f32,
    pane: Cell,
}

/// The wall of a bay: its strip and the part of it.
#[derive(Clone, Copy, Debug)]
struct Wall {
    width: f32,
    reach: (f32, f32),
    strip: Strip,
    /// Which bay of the strip.
    part: u8,
}

impl Wall {
    fn of(style: Style, storey: Storey, look: u8) -> Self {
        Self {
            width: style.bay(),
            reach: storey.reach(),
            strip: style.strip(storey),
            part: look,
        }
    }

    fn corner(&self, x: f32, y: f32) -> (Vec3, Vec2, f32) {
        let turn = atlas::STRIP_LENGTH / atlas::BAYS_PER_TURN as f32;
        let along = (f32::from(self.part) + x / self.width) * turn;
        let up = (y - self.reach.0) / (self.reach.1 - self.reach.0);
        (Vec3::new(x, y, 0.0), self.strip.at(along, up), 1.0)
    }

    fn blank(&self, brush: &mut Brush) {
        let (low, high) = self.reach;
        brush.face([
            self.corner(0.0, low),
            self.corner(self.width, low),
            self.corner(self.width, high),
            self.corner(0.0, high),
        ]);
    }

    /// The wall around a hole, the hole's reveals and what closes it.
    fn pierced(&self, brush: &mut Brush, hole: Hole) {
        let (low, high) = self.reach;
        let outer = [(0.0, low), (self.width, low), (self.width, high), (0.0, high)];
        let Hole {
            low: l,
            high: h,
            depth,
            pane,
        } = hole;
        let inner = [(l.x, l.y), (h.x, l.y), (h.x, h.y), (l.x, h.y)];
        for k in 0..4 {
            let next = (k + 1) % 4;
            let [a, b, c, d] = [outer[k], outer[next], inner[next], inner[k]].map(|(x, y)| self.corner(x, y));
            brush.face([a, b, c, d]);
            // The reveal: lit below, in shade above.
            let dim = [0.85, 0.75, 0.55, 0.75][k];
            let back = |(p, uv, _): (Vec3, Vec2, f32)| (p - Vec3::Z * depth, uv, dim * 0.75);
            let front = |(p, uv, _): (Vec3, Vec2, f32)| (p, uv, dim);
            brush.face([front(d), front(c), back(c), back(d)]);
        }
        let at = |(x, y): (f32, f32)| Vec3::new(x, y, -depth);
        brush.cell_face(inner.map(at), pane, (1.0, 0.78));
    }
}

/// Builds a bay.
pub fn bay(style: Style, storey: Storey, bay: Bay, detail: Detail) -> Brush {
    let mut brush = Brush::default();
    let wall = Wall::of(style, storey, bay.look());
    match (view_index(style, storey, bay), detail) {
        (None, _) => wall.blank(&mut brush),
        (Some(_), Detail::Near) => pierced(&mut brush, wall, style, storey, bay),
        (Some(index), _) => {
            let (low, high) = wall.reach;
            let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
            let corners = [at(0.0, low), at(wall.width, low), at(wall.width, high), at(0.0, high)];
            brush.cell_face(corners, atlas::view(index), (1.0, 1.0));
        }
    }
    if detail == Detail::Near {
        along(&mut brush, style, storey, detail, wall.width);
    }
    if let Bay::Balcony(_) = bay {
        balcony(&mut brush, style, detail);
    }
    if let (Bay::Shop(look), true) = (bay, detail != Detail::Far) {
        awning(&mut brush, style.bay(), look);
    }
    brush
}

/// What the far view of a bay shows: all but what hangs in front.
pub fn front(style: Style, storey: Storey, bay: Bay) -> Brush {
    let mut brush = Brush::default();
    let wall = Wall::of(style, storey, bay.look());
    pierced(&mut brush, wall, style, storey, bay);
    along(&mut brush, style, storey, Detail::Near, wall.width);
    brush
}

/// Wall, hole and trimmings without what hangs in front: what far views show.
fn pierced(brush: &mut Brush, wall: Wall, style: Style, storey: Storey, bay: Bay) {
    let hole = hole(style, storey, bay);
    wall.pierced(brush, hole);
    let (l, h) = (hole.low, hole.high);
    let mut block = |x: (f32, f32), y: (f32, f32), out: f32, strip: Strip| {
        brush.block(Vec3::new(x.0, y.0, -0.06), Vec3::new(x.1, y.1, out), strip);
    };
    match bay {
        Bay::Shop(look) => {
            let board = (h.y + 0.1, h.y + 0.62);
            block((l.x, h.x), board, 0.1, atlas::IRON);
            let face = [(l.x, board.0), (h.x, board.0), (h.x, board.1), (l.x, board.1)]
                .map(|(x, y)| Vec3::new(x + if x < 1.0 { 0.04 } else { -0.04 }, y, 0.11));
            let kind = (style as usize * 3 + usize::from(look)) % atlas::SIGNS;
            brush.plate(face, atlas::sign(kind), (1.0, 1.0));
        }
        Bay::Door => {
            block((l.x - 0.3, h.x + 0.3), (-0.1, l.y), 0.45, atlas::STONE);
            block((l.x - 0.2, h.x + 0.2), (h.y, h.y + 0.18), 0.12, atlas::STONE);
            for (x0, x1) in [(l.x - 0.2, l.x), (h.x, h.x + 0.2)] {
                block((x0, x1), (l.y, h.y), 0.08, atlas::STONE);
            }
        }
        Bay::Window(_) | Bay::Balcony(_) => match style {
            Style::Stucco => {
                for (x0, x1) in [(l.x - 0.16, l.x), (h.x, h.x + 0.16)] {
                    block((x0, x1), (l.y, h.y), 0.05, atlas::STONE);
                }
                block((l.x - 0.16, h.x + 0.16), (h.y, h.y + 0.16), 0.05, atlas::STONE);
                block((l.x - 0.26, h.x + 0.26), (h.y + 0.16, h.y + 0.28), 0.2, atlas::STONE);
                block((l.x - 0.22, h.x + 0.22), (l.y - 0.12, l.y), 0.14, atlas::STONE);
            }
            Style::Brick => {
                block((l.x - 0.2, h.x + 0.2), (h.y, h.y + 0.3), 0.03, atlas::STONE);
                block((l.x - 0.12, h.x + 0.12), (l.y - 0.1, l.y), 0.12, atlas::STONE);
            }
            Style::House => {
                block((l.x - 0.1, h.x + 0.1), (l.y - 0.08, l.y), 0.12, atlas::STONE);
                let leaf = 0.46 * (h.x - l.x);
                for x in [l.x - leaf - 0.03, h.x + 0.03] {
                    block((x, x + leaf), (l.y - 0.03, h.y + 0.03), 0.05, atlas::WOOD);
                }
            }
            Style::Concrete => block((l.x - 0.05, h.x + 0.05), (l.y - 0.06, l.y), 0.09, atlas::ZINC),
            Style::Office => {
                for share in [1.0 / 3.0, 2.0 / 3.0] {
                    let x = l.x + share * (h.x - l.x);
                    let (low, high) = wall.reach;
                    let foot = if storey == Storey::Ground { l.y } else { low };
                    brush.block(
                        Vec3::new(x - 0.06, foot, -0.17),
                        Vec3::new(x + 0.06, high - 0.01, 0.16),
                        atlas::ZINC,
                    );
                }
            }
            Style::Ribbon => {
                for k in 1..4 {
                    let x = l.x + 0.25 * k as f32 * (h.x - l.x);
                    let foot = Vec3::new(x, l.y - 0.02, -0.12);
                    brush.bar(foot, foot.with_y(h.y + 0.02), 0.06, atlas::IRON);
                }
            }
        },
        Bay::Blank => {}
    }
}

fn hole(style: Style, storey: Storey, bay: Bay) -> Hole {
    let width = style.bay();
    let middle = |wide: f32, low: f32, high: f32, depth: f32, pane: Cell| Hole {
        low: Vec2::new(0.5 * (width - wide), low),
        high: Vec2::new(0.5 * (width + wide), high),
        depth,
        pane,
    };
    let look = usize::from(bay.look());
    match bay {
        Bay::Shop(_) => middle(width - 0.4, 0.08, 2.95, 0.35, atlas::shop(look + style as usize)),
        Bay::Door => {
            let high = if style == Style::House { 2.45 } else { 2.9 };
            middle(1.3, 0.14, high, 0.3, atlas::door(style as usize))
        }
        Bay::Balcony(_) => match style {
            Style::Stucco => middle(1.2, 0.12, 2.66, 0.2, atlas::window(4 + look)),
            _ => middle(2.3, 0.1, 2.35, 0.18, atlas::window(6 + look)),
        },
        Bay::Blank | Bay::Window(_) => {
            let lift = if storey == Storey::Ground { 0.55 } else { 0.0 };
            let place = |wide: f32, low: f32, high: f32, depth: f32, pane: usize| {
                middle(wide, low + lift, high + lift, depth, atlas::window(pane))
            };
            match style {
                Style::Stucco => place(1.2, 0.72, 2.66, 0.2, look),
                Style::Brick => place(1.3, 0.9, 2.55, 0.18, (look + 1) % 4),
                Style::House => place(1.2, 0.85, 2.2, 0.14, (look + 2) % 4),
                Style::Concrete => place(1.8, 0.95, 2.4, 0.14, 6 + look % 2),
                Style::Office => place(width - 0.4, 0.7, 3.0, 0.19, 8 + look % 2),
                Style::Ribbon => place(width - 0.4, 0.95, 2.6, 0.19, 9 - look % 2),
            }
        }
    }
}

/// Bands along a storey: (foot, top, how far they stand out), for sides and for corners alike.
fn bands(style: Style, storey: Storey, detail: Detail) -> &'static [(f32, f32, f32)] {
    match (style, storey, detail) {
        (Style::Stucco, Storey::Ground, Detail::Near) => &[(-BELOW, 0.5, 0.06), (3.72, 3.95, 0.16)],
        (Style::Stucco, Storey::Upper, Detail::Near) => &[(3.04, 3.16, 0.08)],
        (Style::Stucco, Storey::Ground, _) => &[(3.72, 3.95, 0.16)],
        (Style::Brick, Storey::Ground, Detail::Near) => &[(-BELOW, 0.45, 0.05), (3.7, 3.95, 0.1)],
        (Style::House, Storey::Ground, Detail::Near) => &[(-BELOW, 0.35, 0.04)],
        (Style::Concrete, Storey::Ground | Storey::Upper, Detail::Near) => &[(0.0, 0.2, 0.03)],
        (Style::Ribbon, Storey::Upper, Detail::Near) => &[(0.8, 0.9, 0.06), (2.66, 2.74, 0.4)],
        (Style::Ribbon, Storey::Upper, _) => &[(2.66, 2.74, 0.4)],
        (Style::Office, Storey::Ground, _) => &[(3.65, 3.97, 0.25)],
        _ => &[],
    }
}

fn mouldings(
    brush: &mut Brush,
    style: Style,
    storey: Storey,
    detail: Detail,
    place: impl Fn(f32, f32, f32) -> (Vec3, Vec3),
) {
    let strip = match style {
        Style::Concrete | Style::House => atlas::CONCRETE,
        Style::Office | Style::Ribbon => atlas::ZINC,
        Style::Stucco | Style::Brick => atlas::STONE,
    };
    for (y0, y1, out) in bands(style, storey, detail) {
        let (low, high) = place(*y0, *y1, *out);
        brush.block(low, high, strip);
    }
}

/// Bands along a wall of this length.
fn along(brush: &mut Brush, style: Style, storey: Storey, detail: Detail, length: f32) {
    mouldings(brush, style, storey, detail, |y0, y1, out| {
        (Vec3::new(0.0, y0, -0.05), Vec3::new(length, y1, out))
    });
}

/// What runs along a whole side: bands, where bays have none of their own.
pub fn side(style: Style, storey: Storey, detail: Detail, length: f32) -> Brush {
    let mut brush = Brush::default();
    if detail != Detail::Near {
        along(&mut brush, style, storey, detail, length);
    }
    brush
}

/// What closes bands at a corner, and quoins.
pub fn corner(style: Style, storey: Storey, detail: Detail) -> Brush {
    let mut brush = Brush::default();
    mouldings(&mut brush, style, storey, detail, |y0, y1, out| {
        (Vec3::new(-out, y0, 0.0), Vec3::new(0.0, y1, out))
    });
    if detail == Detail::Near && matches!((style, storey), (Style::Stucco, _) | (Style::Brick, Storey::Upper)) {
        let (low, high) = match storey {
            Storey::Ground => (0.5, 3.72),
            Storey::Upper => (0.0, 3.04),
        };
        let count = 5;
        let pitch = (high - low) / count as f32;
        for k in 0..count {
            let (x, z) = if k % 2 == 0 { (0.5, 0.3) } else { (0.3, 0.5) };
            let y = low + pitch * k as f32;
            brush.block(
                Vec3::new(-0.045, y + 0.02, -z),
                Vec3::new(x, y + pitch - 0.02, 0.045),
                atlas::STONE,
            );
        }
    }
    brush
}

/// Slab and railing before a tall window.
fn balcony(brush: &mut Brush, style: Style, detail: Detail) {
    let width = style.bay();
    let (x0, x1, out, slab, strip, spacing) = match style {
        Style::Stucco => (0.45, width - 0.45, 0.42, (-0.04, 0.1), atlas::STONE, 0.13),
        _ => (0.1, width - 0.1, 1.3, (-0.14, 0.06), atlas::CONCRETE, 0.2),
    };
    brush.block(Vec3::new(x0, slab.0, -0.05), Vec3::new(x1, slab.1, out), strip);
    if detail == Detail::Far {
        return;
    }
    let (left, right, edge) = (x0 + 0.05, x1 - 0.05, out - 0.05);
    let (foot, top) = (slab.1 + 0.1, slab.1 + 1.0);
    let path = [
        Vec3::new(left, 0.0, 0.0),
        Vec3::new(left, 0.0, edge),
        Vec3::new(right, 0.0, edge),
        Vec3::new(right, 0.0, 0.0),
    ];
    for pair in path.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        brush.bar(a + Vec3::Y * top, b + Vec3::Y * top, 0.035, atlas::IRON);
        if detail == Detail::Near {
            brush.bar(a + Vec3::Y * foot, b + Vec3::Y * foot, 0.025, atlas::IRON);
        }
    }
    for x in [left, right] {
        let p = Vec3::new(x, slab.1 - 0.02, edge);
        brush.bar(p, p.with_y(top), 0.03, atlas::IRON);
    }
    if detail == Detail::Near {
        for pair in path.windows(2) {
            let length = (pair[1] - pair[0]).length();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few bars")]
            let bars = (length / spacing) as u32;
            for k in 1..bars {
                let p = pair[0] + (pair[1] - pair[0]) * (k as f32 / bars as f32);
                brush.bar(p + Vec3::Y * foot, p + Vec3::Y * top, 0.014, atlas::IRON);
            }
        }
    }
}

/// A cloth over the shop window.
fn awning(brush: &mut Brush, width: f32, look: u8) {
    let strip = match look {
        0 => atlas::CLOTH_RED,
        1 => atlas::CLOTH_GREEN,
        _ => return,
    };
    let ring = |lift: f32| {
        [
            Vec3::new(0.2, 2.45 + lift, 1.15),
            Vec3::new(width - 0.2, 2.45 + lift, 1.15),
            Vec3::new(width - 0.2, 2.95 + lift, 0.02),
            Vec3::new(0.2, 2.95 + lift, 0.02),
        ]
    };
    brush.hexahedron(ring(0.0), ring(0.05), strip);
}

/// Number of a bay's far view; `None` where the wall's strip serves.
pub fn view_index(style: Style, storey: Storey, bay: Bay) -> Option<usize> {
    kit().iter().position(|piece| *piece == (style, storey, bay))
}

/// A bay at falling detail: as many levels as differ by a third of their triangles at least.
pub fn levels(style: Style, storey: Storey, bay: Bay) -> Vec<Mesh> {
    let mut levels: Vec<Mesh> = Vec::new();
    for detail in Detail::ALL {
        let mesh = self::bay(style, storey, bay, detail).mesh;
        let coarser = |finer: &Mesh| mesh.triangle_count() * 3 < finer.triangle_count() * 2;
        if levels.last().is_none_or(coarser) {
            levels.push(mesh);
        }
    }
    levels
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Triangles of a bay at near, middle and far detail, at most.
    const BUDGETS: [usize; 3] = [330, 70, 14];

    /// Edges that are used once, without their direction, in millimetres.
    fn open_edges(mesh: &Mesh) -> Vec<[[i32; 3]; 2]> {
        let key = |index: u32| {
            (mesh.vertices[index as usize].position * 1000.0)
                .round()
                .as_ivec3()
                .to_array()
        };
        let mut edges: BTreeMap<[[i32; 3]; 2], i32> = BTreeMap::new();
        for triangle in mesh.indices.chunks_exact(3) {
            for k in 0..3 {
                let (a, b) = (key(triangle[k]), key(triangle[(k + 1) % 3]));
                *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        edges
            .into_iter()
            .filter(|(_, sum)| *sum != 0)
            .map(|(edge, _)| edge)
            .collect()
    }

    #[test]
    fn every_bay_ends_in_the_same_four_edges() {
        for (style, storey, bay) in kit() {
            for detail in Detail::ALL {
                let found = open_edges(&self::bay(style, storey, bay, detail).mesh);
                let (low, high) = match storey {
                    Storey::Ground => (-300, 4000),
                    Storey::Upper => (0, 3200),
                };
                let right = (style.bay() * 1000.0) as i32;
                let [a, b, c, d] = [[0, low, 0], [0, high, 0], [right, low, 0], [right, high, 0]];
                assert_eq!(
                    found,
                    [[a, b], [a, c], [b, d], [c, d]],
                    "{style:?} {storey:?} {bay:?} {detail:?}"
                );
            }
        }
    }

    #[test]
    fn bays_keep_to_their_budgets() {
        for (style, storey, bay) in kit() {
            for (detail, budget) in Detail::ALL.into_iter().zip(BUDGETS) {
                let count = self::bay(style, storey, bay, detail).mesh.triangle_count();
                assert!(count <= budget, "{style:?} {storey:?} {bay:?} {detail:?}: {count}");
            }
        }
    }

    #[test]
    fn far_views_have_room_and_numbers_of_their_own() {
        assert!(kit().len() <= atlas::VIEWS);
        assert_eq!(view_index(Style::Stucco, Storey::Ground, Bay::Window(0)), Some(0));
        assert_eq!(
            view_index(Style::House, Storey::Upper, Bay::Window(2)),
            Some(kit().len() - 1)
        );
        assert_eq!(view_index(Style::House, Storey::Upper, Bay::Blank), None);
    }

    #[test]
    fn a_window_lies_behind_its_wall() {
        let near = bay(Style::Brick, Storey::Upper, Bay::Window(0), Detail::Near).mesh;
        let (low, high) = near.bounds().expect("triangles");
        assert!((low.z + 0.18).abs() < 1e-5, "a recess of 0.18 m, found {}", low.z);
        assert!((high.z - 0.12).abs() < 1e-5, "a sill of 0.12 m, found {}", high.z);
    }
}
