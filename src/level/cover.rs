//! Ground covers: tiles of ground mixed by weights, drawn by [`shaders/level/cover.wgsl`](CoverTiles).

use std::path::{Path, PathBuf};

use bevy::{
    asset::{RenderAssetUsages, io::embedded::EmbeddedAssetRegistry},
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::{
        RenderApp,
        render_resource::{AsBindGroup, Extent3d, TextureViewDescriptor, TextureViewDimension},
    },
    shader::ShaderRef,
};

/// Most tiles that one cover mixes.
pub const TILES: usize = 4;
/// File of the tiles, below `assets/models`; its materials have the tiles' names.
pub const FILE: &str = "surfaces";

/// What lies on a mesh in world space.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// Names of materials of [`FILE`].
    pub tiles: [&'static str; TILES],
    /// One per vertex and tile; their sum is the brightness.
    pub weights: Vec<[f32; TILES]>,
}

/// A material that mixes tiles.
pub type CoverMaterial = ExtendedMaterial<StandardMaterial, CoverTiles>;

/// The tiles of a [`CoverMaterial`].
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct CoverTiles {
    #[texture(100, dimension = "2d_array")]
    #[sampler(101)]
    colors: Handle<Image>,
    #[texture(102, dimension = "2d_array")]
    normals: Handle<Image>,
    #[uniform(103)]
    tiles_per_metre: Vec4,
}

const SHADER: &str = "umbrage/level/cover.wgsl";

impl MaterialExtension for CoverTiles {
    fn fragment_shader() -> ShaderRef {
        "embedded://umbrage/level/cover.wgsl".into()
    }
}

/// Makes [`CoverMaterial`]s drawable where there is a renderer, and storable everywhere.
pub(super) fn plugin(app: &mut App) {
    app.init_asset::<CoverMaterial>();
    let has_renderer = app.get_sub_app(RenderApp).is_some();
    let Some(registry) = app
        .world()
        .get_resource::<EmbeddedAssetRegistry>()
        .filter(|_| has_renderer)
    else {
        return;
    };
    registry.insert_asset(
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/level/cover.wgsl")),
        Path::new(SHADER),
        include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/level/cover.wgsl")),
    );
    app.add_plugins(MaterialPlugin::<CoverMaterial>::default());
}

/// One tile: colour, normals, width in metres.
pub struct Tile<'a> {
    /// Colour with mips.
    pub color: &'a Image,
    /// Normals with mips.
    pub normal: &'a Image,
    /// Metres.
    pub width: f32,
}

/// Tiles as layers, before they are assets.
pub struct Layers {
    colors: Image,
    normals: Image,
    tiles_per_metre: Vec4,
}

/// Stacks the pictures of tiles.
///
/// # Errors
/// One clause: pictures that differ in size or format.
pub fn layers(tiles: &[Tile; TILES]) -> Result<Layers, String> {
    Ok(Layers {
        tiles_per_metre: Vec4::from(tiles.each_ref().map(|tile| 1.0 / tile.width.max(0.01))),
        colors: stack(tiles.each_ref().map(|tile| tile.color))?,
        normals: stack(tiles.each_ref().map(|tile| tile.normal))?,
    })
}

impl Layers {
    /// The material that mixes them.
    pub fn material(self, images: &mut Assets<Image>) -> CoverMaterial {
        CoverMaterial {
            base: StandardMaterial {
                perceptual_roughness: 0.95,
                reflectance: 0.2,
                ..default()
            },
            extension: CoverTiles {
                colors: images.add(self.colors),
                normals: images.add(self.normals),
                tiles_per_metre: self.tiles_per_metre,
            },
        }
    }
}

/// Pictures as the layers of one, which only the renderer keeps.
fn stack(pictures: [&Image; TILES]) -> Result<Image, String> {
    let first = pictures[0];
    let about = |image: &Image| {
        let descriptor = &image.texture_descriptor;
        (descriptor.size, descriptor.format, descriptor.mip_level_count)
    };
    if pictures.iter().any(|picture| about(picture) != about(first)) {
        return Err("its pictures differ in size or format".into());
    }
    let mut stacked = first.clone();
    stacked.texture_descriptor.size = Extent3d {
        depth_or_array_layers: TILES as u32,
        ..first.texture_descriptor.size
    };
    stacked.data = Some(
        pictures
            .iter()
            .flat_map(|picture| picture.data.as_deref().unwrap_or_default())
            .copied()
            .collect(),
    );
    stacked.texture_view_descriptor = Some(TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2Array),
        ..default()
    });
    stacked.asset_usage = RenderAssetUsages::RENDER_WORLD;
    Ok(stacked)
}

#[cfg(test)]
mod tests {
    use bevy::render::render_resource::{TextureDimension, TextureFormat};

    use super::*;

    fn flat(side: u32, code: u8) -> Image {
        let extent = Extent3d {
            width: side,
            height: side,
            depth_or_array_layers: 1,
        };
        let format = TextureFormat::Rgba8UnormSrgb;
        Image::new_fill(
            extent,
            TextureDimension::D2,
            &[code; 4],
            format,
            RenderAssetUsages::default(),
        )
    }

    #[test]
    fn layers_follow_each_other_and_must_fit() {
        let pictures = [1, 2, 3, 4].map(|code| flat(2, code));
        let stacked = stack(pictures.each_ref()).unwrap();
        assert_eq!(stacked.texture_descriptor.size.depth_or_array_layers, 4);
        let data = stacked.data.unwrap();
        assert_eq!((data.len(), data[0], data[16], data[48]), (64, 1, 2, 4));
        let other = flat(4, 1);
        assert!(stack([&pictures[0], &pictures[1], &pictures[2], &other]).is_err());
    }
}
