//! [`ShadowAtlas`]: one depth texture with a rectangle per light view (Stingl, section 3.3.5; Lloyd, section 6.1).

use bevy::{
    log::warn_once,
    prelude::*,
    render::{
        camera::ExtractedCamera,
        render_resource::{
            Extent3d, Texture, TextureDescriptor, TextureDimension, TextureFormat, TextureUsages, TextureView,
            TextureViewDescriptor,
        },
        renderer::RenderDevice,
    },
};

use super::{caster::layers::FadingCasters, extract::ExtractedSun};
use crate::shadow::layout::AtlasLayout;

/// Format of caster depth.
pub const ATLAS_FORMAT: TextureFormat = TextureFormat::Depth32Float;
/// Format of the shadow result: 1 lit, 0 in shadow.
pub const RESULT_FORMAT: TextureFormat = TextureFormat::R16Float;

/// On a camera's render entity: the maps of its sun.
#[derive(Component, Clone, Debug)]
pub struct ShadowAtlas {
    /// Depth, reverse z, cleared to 0.
    pub texture: Texture,
    /// Default view of the texture.
    pub view: TextureView,
    /// The second surface from the light in the same places, or the middle between both, where the sun's settings ask for it.
    pub second: Option<(Texture, TextureView)>,
    /// The nearest casters that fade, in the same places, from the first time on that some do. Tiles of virtual maps have
    /// textures of their own for them.
    pub fading: Option<(Texture, TextureView)>,
    /// Whether some casters fade in this frame, and are drawn apart.
    pub fades: bool,
    /// Where the maps lie, within what the device can hold.
    pub layout: AtlasLayout,
}

/// On a camera's render entity: the shadow result, as large as the camera's target.
#[derive(Component, Clone, Debug)]
pub struct ShadowResult {
    /// 1 lit, 0 in shadow.
    pub texture: Texture,
    /// Default view of the texture.
    pub view: TextureView,
    /// Size in pixels.
    pub size: UVec2,
}

impl ShadowAtlas {
    /// Texel rectangle of a light view's map: x, y, width, height.
    pub fn rect(&self, index: usize) -> UVec4 {
        self.layout.rects.get(index).copied().unwrap_or_default()
    }

    /// The depths that lookups compare with.
    pub fn lookup_view(&self) -> &TextureView {
        self.second.as_ref().map_or(&self.view, |(_, view)| view)
    }

    /// Casters that fade; without any a texture that is not read.
    pub fn fading_view(&self) -> &TextureView {
        self.fading.as_ref().map_or(&self.view, |(_, view)| view)
    }

    /// All textures.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        let others = [&self.second, &self.fading];
        let others = others.into_iter().flatten().map(|(texture, _)| texture);
        std::iter::once(&self.texture).chain(others)
    }
}

/// Makes or keeps the textures of every camera with a full-path sun.
pub fn prepare_atlas(
    mut commands: Commands,
    device: Res<RenderDevice>,
    fading_casters: Res<FadingCasters>,
    cameras: Query<(
        Entity,
        &ExtractedSun,
        &ExtractedCamera,
        Option<&ShadowAtlas>,
        Option<&ShadowResult>,
    )>,
    stale: Query<Entity, (With<ShadowAtlas>, Without<ExtractedSun>)>,
) {
    for entity in &stale {
        commands.entity(entity).remove::<(ShadowAtlas, ShadowResult)>();
    }
    for (entity, sun, camera, atlas, result) in &cameras {
        let Some(size) = camera.physical_target_size.filter(|size| size.min_element() > 0) else {
            commands.entity(entity).remove::<(ShadowAtlas, ShadowResult)>();
            continue;
        };
        if sun.layout.side > 0 || atlas.is_none() {
            let atlas = next_atlas(&device, sun, fading_casters.now, atlas);
            commands.entity(entity).insert(atlas);
        }
        if result.is_none_or(|result| result.size != size) {
            let (texture, view) = create_target(&device, "umbrage_shadow_result", size, RESULT_FORMAT);
            commands.entity(entity).insert(ShadowResult { texture, view, size });
        }
    }
}

/// The atlas of a frame: the textures of the frame before as far as their size is right.
fn next_atlas(device: &RenderDevice, sun: &ExtractedSun, fades: bool, before: Option<&ShadowAtlas>) -> ShadowAtlas {
    let largest = device.limits().max_texture_dimension_2d;
    let layout = sun.layout.shrunk(largest);
    if layout.side < sun.layout.side {
        warn_once!(
            "the shadow maps need a texture of {} texels per side; the device has {largest}: they are reduced",
            sun.layout.side
        );
    }
    let side = layout.side.max(1);
    let create = |label| create_target(device, label, UVec2::splat(side), ATLAS_FORMAT);
    let same_size = before.filter(|atlas| atlas.texture.width() == side);
    let (texture, view) = match same_size {
        Some(atlas) => (atlas.texture.clone(), atlas.view.clone()),
        None => create("umbrage_shadow_atlas"),
    };
    let second = sun.settings.store.is_layered().then(|| {
        let known = same_size.and_then(|atlas| atlas.second.clone());
        known.unwrap_or_else(|| create("umbrage_second_shadow_atlas"))
    });
    let fading = same_size.and_then(|atlas| atlas.fading.clone());
    let is_wanted = fades && !sun.settings.maps.is_virtual();
    let fading = fading.or_else(|| is_wanted.then(|| create("umbrage_fading_atlas")));
    ShadowAtlas {
        texture,
        view,
        second,
        fading,
        fades,
        layout,
    }
}

pub(super) fn create_target(
    device: &RenderDevice,
    label: &str,
    size: UVec2,
    format: TextureFormat,
) -> (Texture, TextureView) {
    let texture = device.create_texture(&TextureDescriptor {
        label: Some(label),
        size: Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC
            | TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let view = texture.create_view(&TextureViewDescriptor::default());
    (texture, view)
}
