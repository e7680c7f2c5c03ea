//! A canvas for strokes and leaves with holes between them, painted at twice its resolution.

use bevy_math::{Vec2, Vec3};

use super::picture::{Channels, Picture, quantised};
use crate::forge::portable::srgb_code;

/// Painted points per texel and axis.
const OVERSAMPLING: usize = 2;
/// Steps per colour channel in the file.
const COLOR_LEVELS: u32 = 52;
/// Steps of alpha in the file.
const ALPHA_LEVELS: u32 = 18;
/// How far colours spread into transparent texels, in texels.
const SPREAD: usize = 3;

/// What is painted at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paint {
    /// Linear colour.
    pub color: Vec3,
    /// 0 thin to 1 thick.
    pub thickness: f32,
}

/// Square cells side by side: cell coordinates run over 0..1, x right, y *up*.
#[derive(Clone, Debug)]
pub struct Canvas {
    /// Cells per side.
    grid: usize,
    /// Painted points per side of a cell.
    cell_points: usize,
    points: Vec<Option<Paint>>,
}

impl Canvas {
    /// An empty canvas of `grid` × `grid` cells with `cell_texels` texels each way.
    pub fn new(grid: usize, cell_texels: usize) -> Self {
        let cell_points = cell_texels * OVERSAMPLING;
        Self {
            grid,
            cell_points,
            points: vec![None; (grid * cell_points).pow(2)],
        }
    }

    /// Cells in all.
    pub fn cell_count(&self) -> usize {
        self.grid * self.grid
    }

    /// Calls `paint` with every point of the box `low..=high` of a cell, and what is there already; keeps what it returns.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to the cell"
    )]
    pub fn paint(&mut self, cell: usize, low: Vec2, high: Vec2, paint: impl Fn(Vec2, Option<Paint>) -> Option<Paint>) {
        let size = self.cell_points as f32;
        let (low, high) = (
            low.clamp(Vec2::ZERO, Vec2::ONE) * size,
            high.clamp(Vec2::ZERO, Vec2::ONE) * size,
        );
        let (left, bottom) = (low.x as usize, low.y as usize);
        let right = (high.x.ceil() as usize).min(self.cell_points);
        let top = (high.y.ceil() as usize).min(self.cell_points);
        let (column, row) = (cell % self.grid, cell / self.grid);
        let stride = self.grid * self.cell_points;
        for y in bottom..top {
            for x in left..right {
                let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / size;
                let line = row * self.cell_points + self.cell_points - 1 - y;
                let point = &mut self.points[line * stride + column * self.cell_points + x];
                *point = paint(p, *point);
            }
        }
    }

    /// A straight stroke whose width shrinks from `widths.0` to `widths.1`.
    pub fn stroke(&mut self, cell: usize, from: Vec2, to: Vec2, widths: (f32, f32), color: Vec3, thickness: f32) {
        let margin = Vec2::splat(widths.0.max(widths.1));
        let along = to - from;
        let length_squared = along.length_squared().max(1e-12);
        self.paint(cell, from.min(to) - margin, from.max(to) + margin, |p, there| {
            let t = ((p - from).dot(along) / length_squared).clamp(0.0, 1.0);
            let half = 0.5 * (widths.0 + (widths.1 - widths.0) * t);
            let off = (p - from - along * t).length();
            if off > half {
                return there;
            }
            // Round: darker towards the rim.
            let round = 1.0 - 0.45 * (off / half) * (off / half);
            Some(Paint {
                color: color * round,
                thickness,
            })
        });
    }

    /// Colour with alpha, and thickness at half the resolution.
    pub fn pictures(&self, name: &str) -> [Picture; 2] {
        let side = self.grid * self.cell_points / OVERSAMPLING;
        let mut texels: Vec<(Vec3, f32)> = (0..side * side).map(|i| self.average(i % side, i / side)).collect();
        spread_colors(&mut texels, side);
        let color = Picture::from_fn(name, side, side, Channels::Rgba, |x, y| {
            let (color, alpha) = texels[y * side + x];
            let [r, g, b] = color
                .to_array()
                .map(|c| quantised(f32::from(srgb_code(c)) / 255.0, COLOR_LEVELS));
            [r, g, b, quantised(alpha, ALPHA_LEVELS)]
        });
        let half = side / 2;
        let step = 2 * OVERSAMPLING;
        let stride = self.grid * self.cell_points;
        let thickness = Picture::from_fn(&format!("{name}_thickness"), half, half, Channels::Gray, |x, y| {
            let (mut sum, mut count) = (0.0, 0.0);
            for i in 0..step * step {
                let point = (y * step + i / step) * stride + x * step + i % step;
                if let Some(paint) = self.points[point] {
                    sum += paint.thickness;
                    count += 1.0;
                }
            }
            let code = quantised(if count > 0.0 { sum / count } else { 0.0 }, 16);
            [code, code, code, 255]
        });
        [color, thickness]
    }

    /// Mean colour of the painted points under a texel, and their share.
    fn average(&self, x: usize, y: usize) -> (Vec3, f32) {
        let stride = self.grid * self.cell_points;
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for i in 0..OVERSAMPLING * OVERSAMPLING {
            let point = (y * OVERSAMPLING + i / OVERSAMPLING) * stride + x * OVERSAMPLING + i % OVERSAMPLING;
            if let Some(paint) = self.points[point] {
                sum += paint.color;
                count += 1.0;
            }
        }
        let share = count / (OVERSAMPLING * OVERSAMPLING) as f32;
        (if count > 0.0 { sum / count } else { Vec3::ZERO }, share)
    }
}

/// Gives transparent texels the colour of painted ones nearby, and the mean colour further away: filters then find no
/// dark rim.
pub fn spread_colors(texels: &mut [(Vec3, f32)], width: usize) {
    let height = texels.len() / width.max(1);
    let mut known: Vec<bool> = texels.iter().map(|(_, alpha)| *alpha > 0.0).collect();
    let (sum, count) = texels
        .iter()
        .filter(|(_, alpha)| *alpha > 0.0)
        .fold((Vec3::ZERO, 0.0), |(sum, count), (color, _)| {
            (sum + *color, count + 1.0)
        });
    let mean = if count > 0.0 { sum / count } else { Vec3::ZERO };
    for _ in 0..SPREAD {
        let before = known.clone();
        for i in 0..texels.len() {
            if before[i] {
                continue;
            }
            let (x, y) = (i % width, i / width);
            let (mut sum, mut count) = (Vec3::ZERO, 0.0);
            for (dx, dy) in [(0, 1), (2, 1), (1, 0), (1, 2)] {
                let (column, row) = (x + dx, y + dy);
                if column >= 1 && row >= 1 && column <= width && row <= height {
                    let near = (row - 1) * width + column - 1;
                    if before[near] {
                        sum += texels[near].0;
                        count += 1.0;
                    }
                }
            }
            if count > 0.0 {
                texels[i].0 = sum / count;
                known[i] = true;
            }
        }
    }
    for (texel, known) in texels.iter_mut().zip(known) {
        if !known {
            texel.0 = mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_lands_in_its_cell_upright() {
        let mut canvas = Canvas::new(2, 16);
        // Cell 1 is the upper right one; the stroke runs along its lower edge.
        let (from, to) = (Vec2::new(0.0, 0.125), Vec2::new(1.0, 0.125));
        canvas.stroke(1, from, to, (0.125, 0.125), Vec3::ONE, 1.0);
        let [color, thickness] = canvas.pictures("test");
        let painted = |x: usize, y: usize| color.texels[y * color.width + x][3] > 128;
        assert_eq!((color.width, thickness.width), (32, 16));
        assert!(painted(24, 13) && painted(24, 14));
        assert!(!painted(24, 5) && !painted(8, 13) && !painted(24, 29));
        assert_eq!(thickness.texels[6 * 16 + 12][0], 255, "painted points only count");
        assert_eq!(thickness.texels[2 * 16 + 12][0], 0);
    }

    #[test]
    fn transparent_texels_take_the_colour_beside_them() {
        let mut texels = vec![(Vec3::ZERO, 0.0); 12];
        texels[5] = (Vec3::X, 1.0);
        spread_colors(&mut texels, 12);
        assert!(texels.iter().all(|(color, _)| *color == Vec3::X));
        assert_eq!(texels[6].1, 0.0, "alpha stays");
    }
}
