//! Bark: colour and normals of a tile from a height field and a recipe per species.

use bevy_math::{Vec2, Vec3};

use super::{
    noise::{cells, octaves, ridges},
    picture::{Channels, Picture, quantised},
};
use crate::forge::portable::{mix, smooth, srgb_code};

/// Texels across and along the trunk.
const SIZE: (usize, usize) = (256, 512);
/// Steps per channel: fewer make smaller files, the noise hides them.
const COLOR_LEVELS: u32 = 52;
const NORMAL_LEVELS: u32 = 64;

/// Kinds of bark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bark {
    /// Deep interlaced ridges, grey-brown.
    Oak,
    /// White paper with dark cross marks, black cracks low down.
    Birch,
    /// Thick orange-brown plates between dark furrows.
    Pine,
    /// Small grey-brown scales.
    Spruce,
    /// Smooth and grey, with faint long furrows.
    Beech,
    /// Weathered wood without bark: grey, fibrous, with cracks.
    Dead,
}

/// A place on the bark: what it looks like.
struct Place {
    /// 0 low to 1 high.
    height: f32,
    /// Linear colour.
    color: Vec3,
}

impl Bark {
    /// How much deeper than wide the relief is drawn, as slope per unit of height.
    fn relief(self) -> f32 {
        match self {
            Self::Oak => 14.0,
            Self::Pine => 11.0,
            Self::Birch => 3.0,
            Self::Spruce => 7.0,
            Self::Beech => 6.0,
            Self::Dead => 7.0,
        }
    }

    fn place(self, p: Vec2) -> Place {
        let grain = octaves(91, p, (24, 24), 2);
        let patch = octaves(17, p, (2, 3), 3);
        // Wandering sideways makes ridges interlace.
        let wander = Vec2::new(0.06 * octaves(5, p, (3, 4), 2), 0.03 * octaves(6, p, (4, 4), 2));
        let q = p + wander;
        match self {
            Self::Oak => {
                let height = smooth(0.15, 0.95, ridges(11, q, (7, 2), 2) + 0.12 * grain);
                let color = tint(
                    [0.035, 0.026, 0.019],
                    [0.19, 0.155, 0.12],
                    height + 0.25 * patch + 0.2 * grain,
                );
                let moss = smooth(0.12, 0.4, patch) * 0.45;
                Place {
                    height,
                    color: color.lerp(Vec3::new(0.09, 0.10, 0.035), moss),
                }
            }
            Self::Birch => birch(p, grain, patch),
            Self::Pine => {
                let plate = cells(23, q, (5, 6));
                let edge = smooth(0.03, 0.3, plate.second - plate.nearest);
                let flakes = 0.5 + 0.5 * octaves(29, p, (10, 30), 2);
                let height = edge * (0.65 + 0.2 * plate.id + 0.25 * flakes);
                let warm = tint([0.16, 0.075, 0.035], [0.33, 0.18, 0.095], plate.id + 0.4 * grain);
                let color = Vec3::new(0.03, 0.02, 0.016).lerp(warm, edge * (0.6 + 0.5 * flakes));
                Place { height, color }
            }
            Self::Spruce => {
                let scale = cells(37, q, (12, 16));
                let edge = smooth(0.02, 0.25, scale.second - scale.nearest);
                let height = edge * (0.5 + 0.4 * scale.id) + 0.15 * grain + 0.2 * patch;
                let color = tint(
                    [0.05, 0.036, 0.028],
                    [0.185, 0.14, 0.115],
                    0.2 + 0.55 * height + 0.4 * patch,
                );
                Place { height, color }
            }
            Self::Beech => {
                let furrow = smooth(0.0, 0.75, ridges(43, q, (6, 1), 3));
                let height = 0.75 * furrow + 0.2 * grain;
                let color = tint(
                    [0.055, 0.047, 0.04],
                    [0.20, 0.18, 0.155],
                    0.15 + 0.65 * furrow + 0.5 * patch + 0.25 * grain,
                );
                Place { height, color }
            }
            Self::Dead => {
                let fibre = 0.5 + 0.5 * octaves(53, q, (32, 2), 3);
                let crack = smooth(0.97, 0.86, ridges(59, q, (5, 1), 2));
                let height = crack * (0.55 + 0.45 * fibre);
                let color = tint(
                    [0.06, 0.05, 0.042],
                    [0.29, 0.265, 0.235],
                    height * 0.8 + 0.6 * patch + 0.15 * grain,
                );
                Place { height, color }
            }
        }
    }

    /// Colour and normals of one tile, in this order; both repeat in both directions.
    pub fn pictures(self) -> [Picture; 2] {
        let (width, height) = SIZE;
        let places: Vec<Place> = (0..width * height)
            .map(|i| {
                self.place(Vec2::new(
                    (i % width) as f32 / width as f32,
                    (i / width) as f32 / height as f32,
                ))
            })
            .collect();
        let color = Picture::from_fn("bark", width, height, Channels::Rgb, |x, y| {
            let [r, g, b] = places[y * width + x].color.to_array().map(|c| {
                let code = f32::from(srgb_code(c)) / 255.0;
                quantised(code, COLOR_LEVELS)
            });
            [r, g, b, 255]
        });
        let high = |x: usize, y: usize| places[(y % height) * width + x % width].height;
        let relief = self.relief() * 0.5;
        let normals = Picture::from_fn("bark_normal", width, height, Channels::Rgb, |x, y| {
            let across = high(x + 1, y) - high(x + width - 1, y);
            let down = high(x, y + 1) - high(x, y + height - 1);
            normal_code(Vec3::new(-across * relief, down * relief, 1.0).normalize())
        });
        [color, normals]
    }
}

/// A unit normal of tangent space (y up in the picture) as a texel.
pub fn normal_code(normal: Vec3) -> [u8; 4] {
    let [x, y, z] = normal.to_array().map(|c| quantised(0.5 + 0.5 * c, NORMAL_LEVELS));
    [x, y, z, 255]
}

/// Between a dark and a light colour.
fn tint(dark: [f32; 3], light: [f32; 3], t: f32) -> Vec3 {
    Vec3::from(dark).lerp(Vec3::from(light), t.clamp(0.0, 1.0))
}

fn birch(p: Vec2, grain: f32, patch: f32) -> Place {
    // Cross marks: short dark lines around the trunk, each in its own cell.
    let mark = cells(61, p + Vec2::new(0.02 * patch, 0.0), (4, 26));
    let line = smooth(0.16, 0.07, mark.nearest) * smooth(0.35, 0.5, mark.id);
    let fine = smooth(0.35, 0.55, octaves(67, p, (6, 60), 2)) * 0.35;
    let crack_field = ridges(71, p + Vec2::new(0.05 * patch, 0.02 * grain), (3, 3), 2);
    let crack = smooth(0.80, 0.93, crack_field) * smooth(-0.02, 0.2, octaves(73, p, (2, 2), 2));
    let paper = tint([0.52, 0.47, 0.41], [0.74, 0.71, 0.66], 0.6 + 0.9 * patch + 0.3 * grain);
    let dark = Vec3::new(0.045, 0.038, 0.034);
    let color = paper
        .lerp(Vec3::new(0.30, 0.24, 0.19), fine)
        .lerp(dark, line.max(crack));
    Place {
        height: mix(0.7 + 0.2 * grain, 0.15, line.max(crack)),
        color,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_have_no_seam() {
        for bark in [
            Bark::Oak,
            Bark::Birch,
            Bark::Pine,
            Bark::Spruce,
            Bark::Beech,
            Bark::Dead,
        ] {
            for i in 0..64 {
                let t = i as f32 / 64.0;
                let (left, right) = (bark.place(Vec2::new(0.0, t)), bark.place(Vec2::new(1.0, t)));
                assert!((left.height - right.height).abs() < 1e-3, "{bark:?} at {t}");
                let (top, bottom) = (bark.place(Vec2::new(t, 0.0)), bark.place(Vec2::new(t, 1.0)));
                assert!((top.color - bottom.color).length() < 1e-3, "{bark:?} at {t}");
            }
        }
    }

    #[test]
    fn a_flat_normal_is_the_middle_of_the_code() {
        let [x, y, z, _] = normal_code(Vec3::Z);
        assert!(x.abs_diff(128) <= 2 && y.abs_diff(128) <= 2 && z == 255, "{x} {y} {z}");
    }
}
