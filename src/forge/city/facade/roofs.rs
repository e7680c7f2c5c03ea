//! Roofs and what stands on them. The origin is the middle of the plan at the top of the walls.

use bevy_math::{Vec2, Vec3};

use super::{
    Style,
    assemble::{Side, hash, lid, plan},
    atlas::{self, Strip},
    bays::Detail,
    brush::Brush,
};

/// Looks of roofs.
pub const LOOKS: u32 = 3;

/// Builds a roof.
pub fn roof(style: Style, bays: (u32, u32), look: u32, high: bool, detail: Detail) -> Brush {
    let mut brush = Brush::default();
    let size = plan(style, bays);
    let top = Top {
        size,
        bays,
        look,
        detail,
        seed: style as u32 * 16 + bays.0 * 5 + bays.1 * 3 + look,
    };
    match style {
        Style::Stucco => {
            lid(&mut brush, bays, size, 0.0, true);
            cornice(
                &mut brush,
                size,
                &[(-0.42, -0.24, 0.14), (-0.14, 0.14, 0.42)],
                atlas::STONE,
            );
            top.mansard(&mut brush);
        }
        Style::House => {
            lid(&mut brush, bays, size, 0.0, true);
            top.gable(&mut brush);
        }
        Style::Brick | Style::Concrete | Style::Office | Style::Ribbon => {
            gravel(&mut brush, bays, size);
            match style {
                Style::Brick => {
                    cornice(&mut brush, size, &[(-0.5, -0.2, 0.22)], atlas::STONE);
                    top.parapet(&mut brush, (0.85, 0.35), atlas::BRICK, atlas::STONE);
                }
                Style::Concrete => top.parapet(&mut brush, (0.6, 0.25), atlas::CONCRETE, atlas::ZINC),
                _ => top.parapet(&mut brush, (1.1, 0.3), atlas::CONCRETE, atlas::ZINC),
            }
            top.furnish(&mut brush, style, high);
        }
    }
    brush
}

/// A gravel surface that closes the walls, in one quadrilateral per bay.
fn gravel(brush: &mut Brush, bays: (u32, u32), size: Vec2) {
    let at = |i: u32, j: u32| {
        let share = Vec2::new(i as f32 / bays.0 as f32, j as f32 / bays.1 as f32);
        let p = (share - 0.5) * size;
        Vec3::new(p.x, 0.0, p.y)
    };
    for j in 0..bays.1 {
        for i in 0..bays.0 {
            brush.strip_face(
                [at(i, j + 1), at(i + 1, j + 1), at(i + 1, j), at(i, j)],
                atlas::GRAVEL,
                1.0,
            );
        }
    }
}

/// Bands around the whole plan: (foot, top, how far they stand out).
fn cornice(brush: &mut Brush, size: Vec2, bands: &[(f32, f32, f32)], strip: Strip) {
    for (foot, top, out) in bands {
        for (number, side) in Side::around(size).into_iter().enumerate() {
            // Front and back reach over the corners, the others butt against them.
            let over = if number % 2 == 0 { *out } else { -0.07 };
            let mut band = Brush::default();
            band.block(
                Vec3::new(-over, *foot, -0.07),
                Vec3::new(side.length + over, *top, *out),
                strip,
            );
            side.place(&mut brush.mesh, &band.mesh, 0.0);
        }
    }
}

struct Top {
    size: Vec2,
    bays: (u32, u32),
    look: u32,
    detail: Detail,
    seed: u32,
}

impl Top {
    fn dice(&self, i: u32) -> f32 {
        (hash(self.seed, i) >> 8) as f32 / (1 << 24) as f32
    }

    /// Steep slopes with dormers under a flat top, chimneys at both ends.
    fn mansard(&self, brush: &mut Brush) {
        let (rise, inset) = (2.5, 1.0);
        let foot = self.size - Vec2::splat(0.1);
        let ring = |plan: Vec2, y: f32| Side::around(plan).map(|side| side.start + Vec3::Y * y);
        brush.hexahedron(ring(foot, -0.1), ring(foot - 2.0 * inset, rise), atlas::ZINC);
        let ridge = foot - 2.0 * inset + 0.16;
        brush.hexahedron(ring(ridge, rise - 0.06), ring(ridge, rise + 0.06), atlas::ZINC);
        for (number, side) in Side::around(self.size).into_iter().enumerate() {
            if number % 2 == 1 {
                continue;
            }
            let width = side.length / self.bays.0 as f32;
            for i in 0..self.bays.0 {
                let mut dormer = Brush::default();
                let x = (i as f32 + 0.5) * width;
                dormer.block(
                    Vec3::new(x - 0.62, 0.1, -1.2),
                    Vec3::new(x + 0.62, 1.85, -0.18),
                    atlas::ZINC,
                );
                dormer.block(
                    Vec3::new(x - 0.74, 1.85, -1.25),
                    Vec3::new(x + 0.74, 1.97, -0.06),
                    atlas::STONE,
                );
                if self.detail != Detail::Far {
                    let pane = [(-0.52, 0.25), (0.52, 0.25), (0.52, 1.75), (-0.52, 1.75)];
                    dormer.plate(
                        pane.map(|(dx, y)| Vec3::new(x + dx, y, -0.17)),
                        atlas::window(((i + self.look) % 4) as usize),
                        (1.0, 0.85),
                    );
                }
                side.place(&mut brush.mesh, &dormer.mesh, 0.0);
            }
        }
        for (end, shift) in [(-1.0, 0.2), (1.0, -0.15)] {
            let x = end * (0.5 * self.size.x - 0.75);
            let z = (shift + 0.1 * self.look as f32) * self.size.y;
            self.chimney(brush, Vec3::new(x, 0.2, z), Vec2::new(0.6, 2.2), 4.0, 5);
        }
    }

    /// A chimney with pots: foot, plan, height, pots.
    fn chimney(&self, brush: &mut Brush, foot: Vec3, plan: Vec2, height: f32, pots: u32) {
        let half = Vec3::new(0.5 * plan.x, 0.0, 0.5 * plan.y);
        brush.block(foot - half, foot + half + Vec3::Y * height, atlas::BRICK);
        let cap = half + Vec3::new(0.07, 0.0, 0.07);
        brush.block(
            foot - cap + Vec3::Y * (height - 0.02),
            foot + cap + Vec3::Y * (height + 0.12),
            atlas::STONE,
        );
        if self.detail == Detail::Far {
            return;
        }
        for k in 0..pots {
            let share = (k as f32 + 0.5) / pots as f32 - 0.5;
            let along = if plan.x > plan.y {
                Vec3::X * plan.x
            } else {
                Vec3::Z * plan.y
            };
            let at = foot + along * share + Vec3::Y * (height + 0.1);
            brush.drum(
                at,
                (0.13, 0.1),
                0.5,
                if self.detail == Detail::Near { 6 } else { 3 },
                atlas::TILES,
            );
        }
    }

    /// A gabled roof along the longer side, gutters, a chimney, a roof window.
    fn gable(&self, brush: &mut Brush) {
        let long_x = self.size.x >= self.size.y;
        let (long, short) = if long_x {
            (self.size.x, self.size.y)
        } else {
            (self.size.y, self.size.x)
        };
        // In a frame whose x runs along the ridge.
        let frame = |p: Vec3| if long_x { p } else { Vec3::new(p.z, p.y, -p.x) };
        let (rise, eaves, verge, thick) = (0.4 * short, 0.55, 0.4, 0.16);
        let slope = rise / (0.5 * short);
        let mut own = Brush::default();
        // The gable walls: a prism under the roof.
        let (x, z) = (0.5 * long, 0.5 * short);
        let wall = [
            Vec3::new(-x, -0.05, z),
            Vec3::new(x, -0.05, z),
            Vec3::new(x, -0.05, -z),
            Vec3::new(-x, -0.05, -z),
        ];
        let (left, right) = (Vec3::new(-x, rise - 0.05, 0.0), Vec3::new(x, rise - 0.05, 0.0));
        own.strip_face([wall[0], wall[1], right, left], atlas::PLASTER, 0.8);
        own.strip_face([wall[2], wall[3], left, right], atlas::PLASTER, 0.8);
        own.strip_face([wall[3], wall[2], wall[1], wall[0]], atlas::PLASTER, 0.7);
        let gable = |a: Vec3, b: Vec3, c: Vec3| {
            let uv = |p: Vec3| atlas::PLASTER.at(p.z + 20.0, (p.y + 0.05) / 6.0);
            [(a, uv(a), 1.0), (b, uv(b), 1.0), (c, uv(c), 1.0)]
        };
        own.triangle(gable(wall[1], wall[2], right));
        own.triangle(gable(wall[3], wall[0], left));
        // Two slabs of tiles that meet at the ridge.
        let (far, drop) = (x + verge, eaves * slope);
        for side in [1.0, -1.0] {
            let edge = side * (z + eaves);
            let ring = |lift: f32| {
                let (low, high) = (-drop + lift, rise + lift);
                let foot = [Vec3::new(-far * side, low, edge), Vec3::new(far * side, low, edge)];
                let ridge = [Vec3::new(far * side, high, 0.0), Vec3::new(-far * side, high, 0.0)];
                [foot[0], foot[1], ridge[0], ridge[1]]
            };
            own.hexahedron(ring(0.0), ring(thick), atlas::TILES);
            if self.detail != Detail::Far {
                let gutter = Vec3::new(0.0, -drop + 0.02, edge + 0.05 * side);
                own.bar(gutter - Vec3::X * far, gutter + Vec3::X * far, 0.08, atlas::ZINC);
            }
        }
        let ridge = Vec3::Y * (rise + thick - 0.02);
        own.bar(
            ridge - Vec3::X * (far + 0.02),
            ridge + Vec3::X * (far + 0.02),
            0.13,
            atlas::TILES,
        );
        let at = Vec3::new((0.15 + 0.14 * self.look as f32) * long, 0.3 * rise, -0.16 * short);
        self.chimney(&mut own, at, Vec2::new(0.9, 0.6), rise + 0.4, 2);
        self.roof_window(&mut own, Vec3::new(-0.22 * long, 0.0, 0.26 * short), rise, slope, thick);
        for vertex in &mut own.mesh.vertices {
            vertex.position = frame(vertex.position);
            vertex.normal = frame(vertex.normal);
        }
        brush.mesh.append(&own.mesh);
    }

    /// A flat window in the slope that looks along +z.
    fn roof_window(&self, brush: &mut Brush, at: Vec3, rise: f32, slope: f32, thick: f32) {
        if self.detail == Detail::Far {
            return;
        }
        let (wide, deep) = (0.5, 0.6);
        let height = |z: f32| rise - z * slope + thick;
        let ring = |lift: f32| {
            [(-wide, deep), (wide, deep), (wide, -deep), (-wide, -deep)]
                .map(|(dx, dz)| Vec3::new(at.x + dx, height(at.z + dz) + lift, at.z + dz))
        };
        brush.hexahedron(ring(-0.05), ring(0.1), atlas::IRON);
        let pane = ring(0.11).map(|p| p + (Vec3::new(at.x, p.y, at.z) - p) * 0.12);
        brush.plate(pane, atlas::window(8), (1.0, 1.0));
    }

    /// Low walls around a flat roof with copings: (height, thickness).
    fn parapet(&self, brush: &mut Brush, (height, thick): (f32, f32), strip: Strip, coping: Strip) {
        for (number, side) in Side::around(self.size + 0.06).into_iter().enumerate() {
            let cut = if number % 2 == 0 { 0.0 } else { thick };
            let mut wall = Brush::default();
            wall.block(
                Vec3::new(cut, -0.1, -thick),
                Vec3::new(side.length - cut, height, 0.0),
                strip,
            );
            wall.block(
                Vec3::new(
                    if cut > 0.0 { thick + 0.06 } else { -0.06 },
                    height - 0.02,
                    -thick - 0.06,
                ),
                Vec3::new(
                    if cut > 0.0 {
                        side.length - thick - 0.06
                    } else {
                        side.length + 0.06
                    },
                    height + 0.1,
                    0.06,
                ),
                coping,
            );
            side.place(&mut brush.mesh, &wall.mesh, 0.0);
        }
    }

    /// Machines, tanks, masts and railings on a flat roof.
    fn furnish(&self, brush: &mut Brush, style: Style, high: bool) {
        let free = self.size * 0.5 - 1.6;
        let place = |i: u32, reach: f32| {
            let share = Vec2::new(self.dice(i), self.dice(i + 50)) * 2.0 - 1.0;
            let p = share * (free - reach).max(Vec2::ZERO);
            Vec3::new(p.x, 0.0, p.y)
        };
        // The lift house, in a corner that depends on the look.
        let corner = [Vec2::new(0.6, -0.5), Vec2::new(-0.6, -0.4), Vec2::new(0.1, -0.6)][(self.look % LOOKS) as usize];
        let lift = Vec3::new(corner.x * free.x, 0.0, corner.y * free.y);
        let big = matches!(style, Style::Office | Style::Ribbon);
        let half = if big { Vec2::new(3.2, 2.4) } else { Vec2::new(1.9, 1.6) }.min(free);
        let tall = if big { 3.4 } else { 2.7 };
        let wall = if style == Style::Brick {
            atlas::BRICK
        } else {
            atlas::CONCRETE
        };
        brush.block(
            lift + Vec3::new(-half.x, -0.1, -half.y),
            lift + Vec3::new(half.x, tall, half.y),
            wall,
        );
        brush.block(
            lift + Vec3::new(-half.x - 0.15, tall - 0.02, -half.y - 0.15),
            lift + Vec3::new(half.x + 0.15, tall + 0.14, half.y + 0.15),
            atlas::ZINC,
        );
        if self.detail != Detail::Far {
            let door = [(-0.5, 0.02), (0.5, 0.02), (0.5, 2.1), (-0.5, 2.1)]
                .map(|(x, y)| lift + Vec3::new(x, y, half.y + 0.015));
            brush.plate(door, atlas::door(2), (0.9, 0.8));
        }
        let clear = |p: Vec3, reach: f32| {
            let gap = (p - lift).abs() - Vec3::new(half.x, 0.0, half.y) - reach;
            gap.x > 0.3 || gap.z > 0.3
        };
        if matches!(style, Style::Brick) && self.look != 1 {
            let at = place(7, 1.6);
            if clear(at, 1.7) {
                self.tank(brush, at);
            }
        }
        for i in 0..4 {
            let size = 0.5 + 0.4 * self.dice(20 + i);
            let at = place(30 + i, size);
            if clear(at, size) && (self.detail != Detail::Far || i < 2) {
                self.machine(brush, at, size);
            }
        }
        if high {
            brush.drum(lift + Vec3::Y * tall, (0.14, 0.05), 9.0, 5, atlas::ZINC);
        }
        if self.detail != Detail::Far && matches!(style, Style::Concrete | Style::Brick) {
            self.aerial(brush, lift + Vec3::new(-half.x + 0.4, tall, -half.y + 0.4));
        }
        if matches!(style, Style::Concrete | Style::Ribbon) && self.look == 0 {
            self.railing(brush);
        }
    }

    /// A water tank on legs.
    fn tank(&self, brush: &mut Brush, at: Vec3) {
        let sides = if self.detail == Detail::Near { 12 } else { 7 };
        for (x, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)] {
            let leg = at + Vec3::new(x * 0.95, 0.0, z * 0.95);
            brush.bar(leg - Vec3::Y * 0.05, leg + Vec3::Y * 2.05, 0.09, atlas::IRON);
            if self.detail == Detail::Near {
                let next = at + Vec3::new(-z * 0.95, 0.0, x * 0.95);
                brush.bar(leg + Vec3::Y * 0.2, next + Vec3::Y * 1.9, 0.04, atlas::IRON);
            }
        }
        brush.block(
            at + Vec3::new(-1.15, 1.95, -1.15),
            at + Vec3::new(1.15, 2.1, 1.15),
            atlas::WOOD,
        );
        brush.drum(at + Vec3::Y * 2.1, (1.3, 1.22), 2.3, sides, atlas::WOOD);
        brush.drum(at + Vec3::Y * 4.4, (1.42, 0.0), 0.9, sides, atlas::ZINC);
    }

    /// A machine of the air conditioning with its fan's rim.
    fn machine(&self, brush: &mut Brush, at: Vec3, size: f32) {
        let high = 0.35 + 0.9 * size;
        brush.block(
            at + Vec3::new(-size, 0.12, -size * 0.7),
            at + Vec3::new(size, high, size * 0.7),
            atlas::ZINC,
        );
        if self.detail == Detail::Near {
            for x in [-0.7, 0.7] {
                brush.block(
                    at + Vec3::new(x * size - 0.06, -0.05, -size * 0.6),
                    at + Vec3::new(x * size + 0.06, 0.13, size * 0.6),
                    atlas::IRON,
                );
            }
            brush.drum(
                at + Vec3::Y * (high - 0.02),
                (size * 0.5, size * 0.5),
                0.12,
                8,
                atlas::IRON,
            );
        }
    }

    /// A television aerial.
    fn aerial(&self, brush: &mut Brush, foot: Vec3) {
        let top = foot + Vec3::Y * 3.2;
        brush.bar(foot - Vec3::Y * 0.05, top, 0.035, atlas::IRON);
        if self.detail == Detail::Near {
            brush.bar(
                top - Vec3::new(0.7, 0.15, 0.0),
                top + Vec3::new(0.7, -0.15, 0.0),
                0.02,
                atlas::IRON,
            );
            for k in 0..5 {
                let at = top + Vec3::new(-0.6 + 0.3 * k as f32, -0.15, 0.0);
                brush.bar(at - Vec3::Z * 0.4, at + Vec3::Z * 0.4, 0.012, atlas::IRON);
            }
        }
    }

    /// A railing of bars behind the parapet.
    fn railing(&self, brush: &mut Brush) {
        let (top, spacing) = match self.detail {
            Detail::Near => (1.9, 0.25),
            Detail::Middle => (1.9, 1.6),
            Detail::Far => return,
        };
        for side in Side::around(self.size - 1.2) {
            let at = |x: f32, y: f32| side.point(Vec3::new(x, y, 0.0));
            for y in [0.75, top] {
                brush.bar(at(0.0, y), at(side.length, y), 0.03, atlas::IRON);
            }
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "some hundred bars"
            )]
            let bars = (side.length / spacing) as u32;
            for k in 0..bars {
                let x = side.length * k as f32 / bars as f32;
                let post = (k % 8 == 0) as u32 as f32;
                brush.bar(at(x, 0.75 - 0.8 * post), at(x, top), 0.015 + 0.015 * post, atlas::IRON);
            }
        }
    }
}
