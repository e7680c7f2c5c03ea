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
const NORMAL_LEVELS: u32 = 28;

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
        let grain = octaves(91, p, (28, 36), 3);
        let patch = octaves(17, p, (2, 3), 3);
        // Wandering sideways makes ridges interlace and plates irregular.
        let wander = Vec2::new(octaves(5, p, (4, 6), 3), 0.5 * octaves(6, p, (4, 6), 3));
        match self {
            Self::Oak => {
                let q = p + 0.14 * wander;
                let ridge = smooth(0.35, 0.80, ridges(11, q, (8, 2), 1));
                let step = smooth(0.25, 0.55, ridges(13, q + 0.05 * wander, (6, 7), 1));
                let height = ridge * (0.55 + 0.45 * step) * (0.85 + 0.5 * grain);
                let color = tint(
                    [0.030, 0.022, 0.016],
                    [0.21, 0.17, 0.13],
                    0.9 * height + 0.35 * patch + 0.55 * grain,
                );
                let moss = smooth(0.10, 0.4, patch) * 0.35 * height;
                Place {
                    height,
                    color: color.lerp(Vec3::new(0.09, 0.10, 0.035), moss),
                }
            }
            Self::Birch => birch(p, grain, patch),
            Self::Pine => {
                let plate = cells(23, p + 0.13 * wander, (5, 5));
                let edge = smooth(0.02, 0.34, plate.second - plate.nearest + 0.15 * grain);
                let flakes = 0.5 + 0.8 * octaves(29, p + 0.05 * wander, (9, 22), 3);
                let layers = (flakes * 4.0).floor() * 0.25;
                let height = edge * (0.5 + 0.2 * plate.id + 0.35 * layers) + 0.1 * grain;
                let warm = tint(
                    [0.13, 0.062, 0.032],
                    [0.36, 0.20, 0.11],
                    0.6 * plate.id + 0.5 * flakes - 0.1 + 0.5 * grain,
                );
                let color = Vec3::new(0.028, 0.019, 0.015).lerp(warm, edge * (0.55 + 0.55 * layers));
                Place { height, color }
            }
            Self::Spruce => {
                let scale = cells(37, p + 0.09 * wander, (9, 13));
                let edge = smooth(0.0, 0.30, scale.second - scale.nearest + 0.35 * grain);
                let height = edge * (0.45 + 0.45 * scale.id) + 0.3 * grain + 0.2 * patch;
                let color = tint(
                    [0.045, 0.032, 0.025],
                    [0.20, 0.15, 0.12],
                    0.15 + 0.5 * height + 0.5 * patch + 0.45 * grain,
                );
                Place { height, color }
            }
            Self::Beech => {
                let furrow = smooth(0.1, 0.7, ridges(43, p + 0.06 * wander, (6, 1), 3));
                let wrinkle = smooth(0.75, 0.95, ridges(47, p + 0.04 * wander, (2, 24), 2));
                let height = 0.6 * furrow + 0.35 * grain - 0.25 * wrinkle;
                let pale = smooth(0.12, 0.3, octaves(49, p, (5, 8), 3));
                let color = tint(
                    [0.055, 0.048, 0.042],
                    [0.20, 0.185, 0.165],
                    0.2 + 0.5 * furrow + 0.6 * patch + 0.4 * grain,
                );
                let color = color.lerp(Vec3::new(0.26, 0.27, 0.245), 0.5 * pale);
                Place {
                    height,
                    color: color * (1.0 - 0.35 * wrinkle),
                }
            }
            Self::Dead => {
                let fibre = 0.5 + 0.7 * octaves(53, p + 0.03 * wander, (34, 2), 3);
                let crack = smooth(0.97, 0.84, ridges(59, p + 0.06 * wander, (5, 1), 2));
                let height = crack * (0.5 + 0.5 * fibre) + 0.15 * grain;
                let color = tint(
                    [0.05, 0.042, 0.035],
                    [0.30, 0.27, 0.24],
                    height * 0.8 + 0.6 * patch + 0.3 * grain,
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
    let mark = cells(61, p + Vec2::new(0.02 * patch, 0.0), (3, 40));
    let line = smooth(0.30 * mark.id, 0.15 * mark.id, mark.nearest + 0.1 * grain) * smooth(0.25, 0.4, mark.id);
    let fine = smooth(0.35, 0.55, octaves(67, p, (6, 60), 2)) * 0.35;
    let crack_field = ridges(71, p + Vec2::new(0.05 * patch, 0.02 * grain), (3, 3), 2);
    let crack = smooth(0.74, 0.90, crack_field + 0.15 * grain) * smooth(0.0, 0.16, octaves(73, p, (2, 2), 2));
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
        assert!(x.abs_diff(128) <= 5 && y.abs_diff(128) <= 5 && z == 255, "{x} {y} {z}");
    }
}
