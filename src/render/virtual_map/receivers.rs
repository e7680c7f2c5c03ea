//! [`Receiver`]: pictures of surfaces that tiles are applied to.

use bevy::{
    core_pipeline::prepass::ViewPrepassTextures,
    prelude::*,
    render::{render_resource::TextureView, texture::FallbackImage},
};

use crate::render::{atlas::ShadowResult, transparent::TransparentLayer};

/// A picture of surfaces and the shadow result of theirs, all of the size of the camera's target.
#[derive(Clone, Copy)]
pub(super) struct Receiver<'a> {
    /// Reverse z; 0 where there is no surface.
    pub(super) depth: &'a TextureView,
    /// As the normal prepass holds them; white where they are not known.
    pub(super) normals: &'a TextureView,
    /// 1 lit, 0 in shadow.
    pub(super) result: &'a TextureView,
}

/// The pictures of a camera: that of the depth prepass first, then those of surfaces that it does not hold. Empty while
/// something is missing.
pub(super) fn receivers(world: &World, camera: Entity) -> Vec<Receiver<'_>> {
    let opaque = || {
        let prepass = world.get::<ViewPrepassTextures>(camera)?;
        // White is no normal.
        let no_normals = &world.get_resource::<FallbackImage>()?.d2.texture_view;
        let opaque = Receiver {
            depth: prepass.depth_view()?,
            normals: prepass.normal_view().unwrap_or(no_normals),
            result: &world.get::<ShadowResult>(camera)?.view,
        };
        let transparent = world.get::<TransparentLayer>(camera).map(|layer| Receiver {
            depth: &layer.depth.1,
            normals: no_normals,
            result: &layer.result.1,
        });
        Some(std::iter::once(opaque).chain(transparent).collect())
    };
    opaque().unwrap_or_default()
}
