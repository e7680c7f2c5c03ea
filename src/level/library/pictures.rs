//! Mips for pictures from files that hold none.

use bevy::{
    asset::RenderAssetUsages,
    image::{ImageFilterMode, ImageSampler},
    prelude::*,
    render::render_resource::TextureFormat,
};

use crate::forge::texture::{
    mips,
    picture::{Channels, Picture},
};

/// What a picture is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Purpose {
    /// Colour: averaged in linear light; alpha keeps its coverage under a cutoff.
    Color {
        /// Alpha below this is not there.
        cutoff: Option<f32>,
        /// At most so many mips, the picture itself included.
        levels: u32,
    },
    /// Normals: averaged as vectors.
    Normal {
        /// At most so many mips, the picture itself included.
        levels: u32,
    },
}

/// The picture with mips, filtered between them, for both worlds. Formats of other than four channels of 8 bits stay as
/// they are.
pub fn with_mips(mut image: Image, purpose: Purpose) -> Image {
    image.asset_usage = RenderAssetUsages::default();
    let is_rgba = matches!(
        image.texture_descriptor.format,
        TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb
    );
    let data = image.data.as_deref().unwrap_or_default();
    let texels: Vec<[u8; 4]> = data.as_chunks::<4>().0.to_vec();
    if !is_rgba || texels.len() != (image.width() * image.height()) as usize {
        return image;
    }
    let picture = Picture {
        name: String::new(),
        width: image.width() as usize,
        texels,
        channels: Channels::Rgba,
    };
    let (mut mips, levels) = match purpose {
        Purpose::Color {
            cutoff: Some(cutoff),
            levels,
        } => (mips::coverage_preserving_mips(&picture, cutoff), levels),
        Purpose::Color { cutoff: None, levels } => (mips::color_mips(&picture), levels),
        Purpose::Normal { levels } => (mips::normal_mips(&picture), levels),
    };
    mips.truncate(levels as usize);
    image.texture_descriptor.mip_level_count = mips.len() as u32;
    image.data = Some(mips.iter().flat_map(|mip| mip.texels.as_flattened()).copied().collect());
    let sampler = image.sampler.get_or_init_descriptor();
    sampler.set_filter(ImageFilterMode::Linear);
    image.sampler = ImageSampler::Descriptor(sampler.clone());
    image
}

#[cfg(test)]
mod tests {
    use bevy::render::render_resource::{Extent3d, TextureDimension};

    use super::*;

    fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
        let data = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let data = data.flat_map(|(x, y)| texel(x, y)).collect();
        let extent = Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let format = TextureFormat::Rgba8UnormSrgb;
        Image::new(
            extent,
            TextureDimension::D2,
            data,
            format,
            RenderAssetUsages::MAIN_WORLD,
        )
    }

    #[test]
    fn mips_follow_the_picture_level_by_level() {
        let black_and_white = image(4, 2, |x, _| if x % 2 == 0 { [0, 0, 0, 255] } else { [255; 4] });
        let purpose = Purpose::Color {
            cutoff: None,
            levels: 9,
        };
        let with = with_mips(black_and_white, purpose);
        assert_eq!(with.texture_descriptor.mip_level_count, 3);
        let data = with.data.unwrap();
        assert_eq!(data.len(), 4 * (8 + 2 + 1));
        // Half the light is 188 in sRGB.
        assert_eq!(data[32..36], [188, 188, 188, 255]);
        assert_eq!(with.asset_usage, RenderAssetUsages::default());
    }

    #[test]
    fn the_number_of_mips_has_a_limit() {
        let normals = image(8, 8, |_, _| [128, 128, 255, 10]);
        let with = with_mips(normals, Purpose::Normal { levels: 2 });
        assert_eq!(with.texture_descriptor.mip_level_count, 2);
        let data = with.data.unwrap();
        assert_eq!(data.len(), 4 * (64 + 16));
        assert_eq!(data[256..260], [128, 128, 255, 10]);
    }
}
