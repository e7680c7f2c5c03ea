//! Mips of alpha-tested pictures that keep their coverage (Castaño 2010, *Computing Alpha Mipmaps*).
//!
//! Averaging alpha and testing it against the same cutoff lets leaves vanish with distance. Here the alpha of each mip is
//! scaled so that the share of texels that pass the test is that of mip 0. PNG and glTF cannot hold mips, so loaders call
//! this on the picture that they read; colours are averaged in linear light and weighted by alpha, so that what lies
//! under transparent texels does not bleed.

use crate::forge::{
    portable::{linear_light, srgb_code},
    texture::picture::Picture,
};

/// Share of texels whose alpha is at least `cutoff` (0..=1).
pub fn coverage(texels: &[[u8; 4]], cutoff: f32) -> f32 {
    let passing = texels
        .iter()
        .filter(|texel| f32::from(texel[3]) >= cutoff * 255.0)
        .count();
    passing as f32 / texels.len().max(1) as f32
}

/// All mips of a colour picture, from itself down to 1 × 1; each has half the columns and rows, rounded down, at least 1.
pub fn coverage_preserving_mips(picture: &Picture, cutoff: f32) -> Vec<Picture> {
    let wanted = coverage(&picture.texels, cutoff);
    let mut linear = Level::from_picture(picture);
    let mut mips = vec![picture.clone()];
    while linear.width > 1 || linear.height > 1 {
        linear = linear.half();
        mips.push(linear.to_picture(picture, cutoff, wanted));
    }
    mips
}

/// All mips of a colour picture without alpha test: averages in linear light.
pub fn color_mips(picture: &Picture) -> Vec<Picture> {
    let mut linear = Level::from_picture(picture);
    let mut mips = vec![picture.clone()];
    while linear.width > 1 || linear.height > 1 {
        linear = linear.half();
        let texels = linear.texels.iter().map(|[r, g, b, a]| {
            let [r, g, b] = [r, g, b].map(|light| srgb_code(*light));
            [r, g, b, unit_code(*a)]
        });
        mips.push(Picture {
            name: picture.name.clone(),
            width: linear.width,
            texels: texels.collect(),
            channels: picture.channels,
        });
    }
    mips
}

/// All mips of a picture of normals: averages of the vectors, made unit length again; alpha is averaged.
pub fn normal_mips(picture: &Picture) -> Vec<Picture> {
    let vector = |code: u8| f32::from(code) / 127.5 - 1.0;
    let mut level = Level {
        width: picture.width,
        height: picture.height(),
        texels: (picture.texels.iter())
            .map(|[x, y, z, a]| [vector(*x), vector(*y), vector(*z), f32::from(*a) / 255.0])
            .collect(),
    };
    let mut mips = vec![picture.clone()];
    while level.width > 1 || level.height > 1 {
        level = level.half_unweighted();
        let texels = level.texels.iter().map(|[x, y, z, a]| {
            let length = (x * x + y * y + z * z).sqrt().max(1e-6);
            let [x, y, z] = [x, y, z].map(|v| unit_code(v / length * 0.5 + 0.5));
            [x, y, z, unit_code(*a)]
        });
        mips.push(Picture {
            name: picture.name.clone(),
            width: level.width,
            texels: texels.collect(),
            channels: picture.channels,
        });
    }
    mips
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..=255"
)]
fn unit_code(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// Linear light and alpha, or vectors and alpha.
struct Level {
    width: usize,
    height: usize,
    texels: Vec<[f32; 4]>,
}

impl Level {
    fn from_picture(picture: &Picture) -> Self {
        let light: Vec<f32> = (0..=255).map(linear_light).collect();
        let texels = picture.texels.iter().map(|[r, g, b, a]| {
            let [r, g, b] = [r, g, b].map(|code| light[usize::from(*code)]);
            [r, g, b, f32::from(*a) / 255.0]
        });
        Self {
            width: picture.width,
            height: picture.height(),
            texels: texels.collect(),
        }
    }

    fn half(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                texels.push(self.average(x, y));
            }
        }
        Self { width, height, texels }
    }

    /// As [`half`](Self::half), but all four channels alike.
    fn half_unweighted(&self) -> Self {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let texel = |x: usize, y: usize| {
            let mut sum = [0.0; 4];
            for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let column = (2 * x + dx).min(self.width - 1);
                let row = (2 * y + dy).min(self.height - 1);
                let own = self.texels[row * self.width + column];
                sum = std::array::from_fn(|channel| sum[channel] + 0.25 * own[channel]);
            }
            sum
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self {
            width,
            height,
            texels: places.map(|(x, y)| texel(x, y)).collect(),
        }
    }

    /// The mean of the 2 × 2 texels under a texel of the next level, weighted by alpha.
    fn average(&self, x: usize, y: usize) -> [f32; 4] {
        let (mut weighted, mut plain, mut alpha) = ([0.0; 3], [0.0; 3], 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let column = (2 * x + dx).min(self.width - 1);
            let row = (2 * y + dy).min(self.height - 1);
            let [r, g, b, a] = self.texels[row * self.width + column];
            for (channel, light) in [r, g, b].into_iter().enumerate() {
                weighted[channel] += light * a;
                plain[channel] += light;
            }
            alpha += a;
        }
        let [r, g, b] = if alpha > 0.0 {
            weighted.map(|sum| sum / alpha)
        } else {
            plain.map(|sum| sum / 4.0)
        };
        [r, g, b, alpha / 4.0]
    }

    /// Texels of the next file level: alpha is scaled so that `wanted` of them pass the test. Where many have the same
    /// alpha at the border, some of them are moved to just above and the others to just below.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to 0..=255 or 0..=length"
    )]
    fn to_picture(&self, like: &Picture, cutoff: f32, wanted: f32) -> Picture {
        let mut ranks: Vec<usize> = (0..self.texels.len()).collect();
        let scattered = |i: usize| (i as u32).wrapping_mul(0x9e37_79b1);
        ranks.sort_by(|a, b| {
            let alphas = self.texels[*b][3].total_cmp(&self.texels[*a][3]);
            alphas.then(scattered(*a).cmp(&scattered(*b)))
        });
        let count = (wanted * ranks.len() as f32 + 0.5) as usize;
        let alpha_at = |rank: Option<&usize>| rank.map(|i| self.texels[*i][3]);
        let last_inside = count.checked_sub(1).and_then(|rank| alpha_at(ranks.get(rank)));
        let border = match (last_inside, alpha_at(ranks.get(count))) {
            (Some(last), Some(first)) => 0.5 * (last + first),
            (Some(last), None) => last,
            (None, first) => first.unwrap_or(1.0) + cutoff,
        };
        let scale = if border > 0.0 { cutoff / border } else { 1.0 };
        let passing_code = (cutoff * 255.0).ceil().clamp(1.0, 255.0) as u8;
        let mut texels: Vec<[u8; 4]> = self
            .texels
            .iter()
            .map(|[r, g, b, a]| {
                let alpha = ((a * scale).clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
                [srgb_code(*r), srgb_code(*g), srgb_code(*b), alpha]
            })
            .collect();
        for (rank, i) in ranks.into_iter().enumerate() {
            let alpha = &mut texels[i][3];
            *alpha = if rank < count {
                (*alpha).max(passing_code)
            } else {
                (*alpha).min(passing_code - 1)
            };
        }
        Picture {
            name: like.name.clone(),
            width: self.width,
            texels,
            channels: like.channels,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forge::texture::picture::Channels;

    /// Thin diagonal lines that plain averaging would lose: alpha 1 on 1 of 8 texels.
    fn lines() -> Picture {
        Picture::from_fn("lines", 64, 64, Channels::Rgba, |x, y| {
            if (x + 2 * y + x * y / 16) % 8 == 0 {
                [0, 200, 0, 255]
            } else {
                [255, 0, 255, 0]
            }
        })
    }

    #[test]
    fn every_mip_covers_as_much_as_the_first() {
        let mips = coverage_preserving_mips(&lines(), 0.5);
        assert_eq!(
            mips.iter().map(|mip| mip.width).collect::<Vec<_>>(),
            [64, 32, 16, 8, 4, 2, 1]
        );
        let wanted = coverage(&mips[0].texels, 0.5);
        assert!((0.1..0.15).contains(&wanted), "{wanted}");
        for mip in &mips[1..] {
            let texel = 1.0 / mip.texels.len() as f32;
            let own = coverage(&mip.texels, 0.5);
            assert!(
                (own - wanted).abs() <= texel.max(0.01),
                "{} texels wide: {own} for {wanted}",
                mip.width
            );
        }
    }

    #[test]
    fn colours_under_transparent_texels_do_not_bleed() {
        let mips = coverage_preserving_mips(&lines(), 0.5);
        for texel in mips[1].texels.iter().filter(|texel| texel[3] > 0) {
            assert_eq!(texel[..3], [0, 200, 0]);
        }
    }

    #[test]
    fn colors_are_averaged_in_linear_light_and_normals_as_vectors() {
        let halves = |left: [u8; 4], right: [u8; 4]| {
            Picture::from_fn(
                "halves",
                2,
                1,
                Channels::Rgba,
                move |x, _| if x == 0 { left } else { right },
            )
        };
        let mips = color_mips(&halves([0, 0, 255, 255], [255, 0, 255, 255]));
        assert_eq!(mips.len(), 2);
        assert_eq!(mips[1].texels, [[188, 0, 255, 255]]);
        // Leaning 90 degrees to each other, at 45 degrees from z: their mean is z; depths are averaged.
        let mips = normal_mips(&halves([218, 128, 218, 0], [38, 128, 218, 200]));
        assert_eq!(mips[1].texels, [[128, 128, 255, 100]]);
    }

    #[test]
    fn opaque_and_empty_pictures_stay_so() {
        for alpha in [0, 255] {
            let picture = Picture::from_fn("flat", 8, 4, Channels::Rgba, |_, _| [9, 9, 9, alpha]);
            for mip in coverage_preserving_mips(&picture, 0.5) {
                assert_eq!(
                    coverage(&mip.texels, 0.5),
                    f32::from(alpha) / 255.0,
                    "{} wide",
                    mip.width
                );
            }
        }
    }
}
