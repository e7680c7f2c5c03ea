//! [`Receiver`]: pictures of surfaces that shadow results are made for.

use bevy::{
    core_pipeline::prepass::ViewPrepassTextures,
    prelude::*,
    render::{
        render_resource::{Texture, TextureView},
        texture::FallbackImage,
    },
};

use super::{
    atlas::ShadowResult,
    transparent::TransparentSurfaces,
    unpop::{layers::ExtractedLayers, surfaces::FadingSurfaces},
};

/// A picture of surfaces and the shadow result of theirs, all of the size of the camera's target.
#[derive(Clone, Copy)]
pub(super) struct Receiver<'a> {
    /// Reverse z; 0 where there is no surface.
    pub(super) depth: &'a TextureView,
    /// As the normal prepass holds them; white where they are not known.
    pub(super) normals: &'a TextureView,
    /// 1 lit, 0 in shadow.
    pub(super) result: &'a TextureView,
    /// The texture of the result, and the layer of it.
    pub(super) result_texture: (&'a Texture, u32),
}

/// The pictures of a camera in this frame: that of the depth prepass first, then the nearest fading levels of detail by
/// layer, then transparent surfaces by layer. Empty while something is missing.
pub(super) fn receivers(world: &World, camera: Entity) -> Vec<Receiver<'_>> {
    let all = || {
        let prepass = world.get::<ViewPrepassTextures>(camera)?;
        let result = world.get::<ShadowResult>(camera)?;
        // White is no normal.
        let no_normals = &world.get_resource::<FallbackImage>()?.d2.texture_view;
        let opaque = Receiver {
            depth: prepass.depth_view()?,
            normals: prepass.normal_view().unwrap_or(no_normals),
            result: &result.view,
            result_texture: (&result.texture, 0),
        };
        let in_use = world.get_resource::<ExtractedLayers>().map_or(0, |layers| layers.0);
        let fading = world.get::<FadingSurfaces>(camera);
        let fading = fading
            .filter(|surfaces| surfaces.is_current)
            .into_iter()
            .flat_map(|surfaces| {
                let pictures = surfaces.depth.each.iter().zip(&surfaces.normal.each);
                let results = surfaces.result.each.iter().zip(0..);
                pictures
                    .zip(results)
                    .map(|((depth, normals), (result, layer))| Receiver {
                        depth,
                        normals,
                        result,
                        result_texture: (&surfaces.result.texture, layer),
                    })
            })
            .take(in_use as usize);
        let transparent = world.get::<TransparentSurfaces>(camera);
        let transparent = transparent
            .into_iter()
            .flat_map(|surfaces| &surfaces.layers)
            .map(|layer| Receiver {
                depth: &layer.depth.1,
                normals: no_normals,
                result: &layer.result.1,
                result_texture: (&layer.result.0, 0),
            });
        Some(std::iter::once(opaque).chain(fading).chain(transparent).collect())
    };
    all().unwrap_or_default()
}
