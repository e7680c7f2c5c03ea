//! What is painted into the picture of all façades, in linear light.

mod openings;
mod shops;
mod walls;

use bevy_math::{Vec2, Vec3};

use super::atlas::{self, Cell, Strip};

/// Points per texel and axis of windows, doors, shops and signs.
const OVERSAMPLING: usize = 2;

/// All texels row by row; far views are still black.
pub fn painting() -> Vec<Vec3> {
    let mut light = vec![Vec3::ZERO; atlas::WIDTH * atlas::HEIGHT];
    let strips: [(Strip, fn(Vec2) -> Vec3); 12] = [
        (atlas::PLASTER, walls::plaster),
        (atlas::ASHLAR, walls::ashlar),
        (atlas::BRICK, walls::brick),
        (atlas::CONCRETE, walls::concrete),
        (atlas::TILES, walls::tiles),
        (atlas::STONE, walls::stone),
        (atlas::GRAVEL, walls::gravel),
        (atlas::ZINC, walls::zinc),
        (atlas::IRON, walls::iron),
        (atlas::WOOD, walls::wood),
        (atlas::CLOTH_RED, |p| walls::cloth(p, Vec3::new(0.42, 0.045, 0.04))),
        (atlas::CLOTH_GREEN, |p| walls::cloth(p, Vec3::new(0.03, 0.17, 0.09))),
    ];
    for (strip, paint) in strips {
        let cell = Cell {
            left: 0,
            top: strip.top,
            columns: atlas::WIDTH,
            rows: strip.rows,
        };
        fill(&mut light, cell, 1, paint);
    }
    for kind in 0..atlas::WINDOWS {
        fill(&mut light, atlas::window(kind), OVERSAMPLING, |p| {
            openings::window(kind, p)
        });
    }
    for kind in 0..atlas::DOORS {
        fill(&mut light, atlas::door(kind), OVERSAMPLING, |p| openings::door(kind, p));
    }
    for kind in 0..atlas::SHOPS {
        fill(&mut light, atlas::shop(kind), OVERSAMPLING, |p| shops::shop(kind, p));
    }
    for kind in 0..atlas::SIGNS {
        fill(&mut light, atlas::sign(kind), OVERSAMPLING, |p| shops::sign(kind, p));
    }
    light
}

/// Paints a cell; `paint` gets shares of it, x right, y *up*.
fn fill(light: &mut [Vec3], cell: Cell, points: usize, paint: impl Fn(Vec2) -> Vec3) {
    for y in 0..cell.rows {
        for x in 0..cell.columns {
            let mut sum = Vec3::ZERO;
            for i in 0..points * points {
                let offset = Vec2::new((i % points) as f32 + 0.5, (i / points) as f32 + 0.5) / points as f32;
                let p = (Vec2::new(x as f32, y as f32) + offset) / Vec2::new(cell.columns as f32, cell.rows as f32);
                sum += paint(Vec2::new(p.x, 1.0 - p.y));
            }
            light[(cell.top + y) * atlas::WIDTH + cell.left + x] = sum / (points * points) as f32;
        }
    }
}

/// A number in 0..=1 that belongs to two whole numbers.
fn random(seed: u32, x: i32, y: i32) -> f32 {
    let mix = super::assemble::hash(seed ^ x.cast_unsigned().wrapping_mul(0x27d4_eb2f), y.cast_unsigned());
    (mix >> 8) as f32 / (1 << 24) as f32
}

/// 1 within `low..high`, 0 outside.
fn within(x: f32, low: f32, high: f32) -> f32 {
    if (low..high).contains(&x) { 1.0 } else { 0.0 }
}
