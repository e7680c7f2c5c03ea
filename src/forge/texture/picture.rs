//! Pictures of 8 bits per channel, as PNG or JPEG.

use bevy_math::Vec2;
use image::{
    ExtendedColorType, ImageEncoder,
    codecs::{
        jpeg::JpegEncoder,
        png::{CompressionType, FilterType, PngEncoder},
    },
};

/// Quality of JPEG pictures, 1..=100: losses stay below the grain of rough ground.
const JPEG_QUALITY: u8 = 76;

/// Which channels of a picture are kept in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// The first only.
    Gray,
    /// Without alpha.
    Rgb,
    /// All four.
    Rgba,
    /// Without alpha, as JPEG: a third of PNG's bytes for rough ground. Every texel changes a little.
    RgbJpeg,
}

impl Channels {
    fn count(self) -> usize {
        match self {
            Self::Gray => 1,
            Self::Rgb | Self::RgbJpeg => 3,
            Self::Rgba => 4,
        }
    }

    /// Media type of the file.
    pub fn mime(self) -> &'static str {
        match self {
            Self::Gray | Self::Rgb | Self::Rgba => "image/png",
            Self::RgbJpeg => "image/jpeg",
        }
    }
}

/// Texels, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Unique within the model.
    pub name: String,
    /// Texels per row.
    pub width: usize,
    /// `width` × height texels.
    pub texels: Vec<[u8; 4]>,
    /// What the file holds.
    pub channels: Channels,
}

impl Picture {
    /// A picture whose texels come from their column and row.
    pub fn from_fn(
        name: &str,
        width: usize,
        height: usize,
        channels: Channels,
        mut texel: impl FnMut(usize, usize) -> [u8; 4],
    ) -> Self {
        let texels = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| texel(x, y))
            .collect();
        Self {
            name: name.to_owned(),
            width,
            texels,
            channels,
        }
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.texels.len().checked_div(self.width).unwrap_or(0)
    }

    /// The texel nearest to texture coordinates; the picture repeats outside 0..1. `None` for an empty picture.
    pub fn nearest(&self, uv: Vec2) -> Option<[u8; 4]> {
        let place = |coordinate: f32, size: usize| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..=size")]
            let index = ((coordinate - coordinate.floor()) * size as f32) as usize;
            index.min(size.saturating_sub(1))
        };
        let (x, y) = (place(uv.x, self.width), place(uv.y, self.height()));
        self.texels.get(y * self.width + x).copied()
    }

    /// The bytes of a PNG file.
    ///
    /// # Panics
    /// Never with texels in memory: there is no I/O, and sizes fit.
    pub fn png(&self) -> Vec<u8> {
        let mut png = Vec::new();
        self.write(PngEncoder::new_with_quality(
            &mut png,
            CompressionType::Best,
            FilterType::Adaptive,
        ));
        png
    }

    /// The bytes of the file that [`Channels::mime`] names.
    ///
    /// # Panics
    /// With more than 65535 columns or rows as JPEG.
    pub fn bytes(&self) -> Vec<u8> {
        match self.channels {
            Channels::Gray | Channels::Rgb | Channels::Rgba => self.png(),
            Channels::RgbJpeg => {
                let mut jpeg = Vec::new();
                self.write(JpegEncoder::new_with_quality(&mut jpeg, JPEG_QUALITY));
                jpeg
            }
        }
    }

    fn write(&self, encoder: impl ImageEncoder) {
        let kept = self.channels.count();
        let bytes: Vec<u8> = self
            .texels
            .iter()
            .flat_map(|texel| texel.iter().take(kept).copied())
            .collect();
        let color = match self.channels {
            Channels::Gray => ExtendedColorType::L8,
            Channels::Rgb | Channels::RgbJpeg => ExtendedColorType::Rgb8,
            Channels::Rgba => ExtendedColorType::Rgba8,
        };
        let size = |texels: usize| u32::try_from(texels).expect("a picture has fewer than 2³² columns and rows");
        encoder
            .write_image(&bytes, size(self.width), size(self.height()), color)
            .expect("texels in memory can be encoded");
    }
}

/// A number in 0..=1 as 8 bits, rounded to a multiple of 255 / (`levels` − 1): fewer levels make smaller files.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..=255"
)]
pub fn quantised(value: f32, levels: u32) -> u8 {
    let steps = levels.saturating_sub(1).max(1) as f32;
    let step = (value.clamp(0.0, 1.0) * steps + 0.5).floor();
    (step * 255.0 / steps + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checks() -> Picture {
        Picture::from_fn("checks", 2, 3, Channels::Rgb, |x, y| {
            [10 * x as u8, 20 * y as u8, 7, 255]
        })
    }

    #[test]
    fn coordinates_begin_on_top_and_repeat() {
        let picture = checks();
        assert_eq!(picture.height(), 3);
        assert_eq!(picture.nearest(Vec2::new(0.9, 0.1)), Some([10, 0, 7, 255]));
        assert_eq!(picture.nearest(Vec2::new(-0.9, 1.9)), Some([0, 40, 7, 255]));
    }

    #[test]
    fn a_png_holds_the_kept_channels() {
        let read = image::load_from_memory(&checks().png()).expect("a PNG file");
        assert_eq!(read.color(), image::ColorType::Rgb8);
        assert_eq!(
            read.into_rgb8().into_raw(),
            [0, 0, 7, 10, 0, 7, 0, 20, 7, 10, 20, 7, 0, 40, 7, 10, 40, 7]
        );
    }

    #[test]
    fn a_jpeg_stays_near_its_texels() {
        let slope = Picture::from_fn("slope", 16, 16, Channels::RgbJpeg, |x, y| {
            [8 * x as u8, 60 + 8 * y as u8, 90, 255]
        });
        assert_eq!(slope.channels.mime(), "image/jpeg");
        let bytes = slope.bytes();
        assert_eq!(bytes[..3], [0xff, 0xd8, 0xff], "the mark of a JPEG file");
        let read = image::load_from_memory(&bytes).expect("a JPEG file").into_rgb8();
        for (pixel, texel) in read.pixels().zip(&slope.texels) {
            for (there, here) in pixel.0.iter().zip(texel) {
                assert!(there.abs_diff(*here) <= 8, "{there} for {here}");
            }
        }
    }

    #[test]
    fn levels_spread_over_the_whole_range() {
        assert_eq!(
            [0.0, 0.3, 0.5, 1.0, 7.0].map(|v| quantised(v, 3)),
            [0, 128, 128, 255, 255]
        );
        assert_eq!(
            (0..=255).map(|c| quantised(c as f32 / 255.0, 256)).collect::<Vec<_>>(),
            (0..=255).collect::<Vec<u8>>()
        );
    }
}
