//! [`ShadowAtlas`]: one depth texture with a cell per light view (Stingl, section 3.3.5).

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

use super::extract::ExtractedSun;

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
    /// The second surface from the light in the same cells, or the middle between both, where the sun's settings ask for it.
    pub second: Option<(Texture, TextureView)>,
    /// Cells per side.
    pub grid: u32,
    /// Texels per side of a cell.
    pub cell: u32,
    /// Cells in use.
    pub count: u32,
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
    /// Texel rectangle of a cell: x, y, width, height. Row-major from the top left.
    pub fn rect(&self, index: u32) -> UVec4 {
        cell_rect(index, self.grid, self.cell)
    }

    /// The depths that lookups compare with.
    pub fn lookup_view(&self) -> &TextureView {
        self.second.as_ref().map_or(&self.view, |(_, view)| view)
    }

    /// Bytes of texture memory.
    pub fn bytes(&self) -> u64 {
        let side = u64::from(self.grid * self.cell);
        side * side * if self.second.is_some() { 8 } else { 4 }
    }
}

/// Cells per side for a number of maps: 1, 2 (up to 4), 3 (up to 9), 4 (up to 16).
pub const fn atlas_grid(count: u32) -> u32 {
    match count {
        0 | 1 => 1,
        2..=4 => 2,
        5..=9 => 3,
        _ => 4,
    }
}

/// Texel rectangle of a cell: x, y, width, height. Row-major from the top left.
pub const fn cell_rect(index: u32, grid: u32, cell: u32) -> UVec4 {
    UVec4::new(index % grid * cell, index / grid * cell, cell, cell)
}

/// Texels per side of a cell that the device can hold.
pub fn cell_size(wanted: u32, grid: u32, max_texture_side: u32) -> u32 {
    wanted.clamp(1, max_texture_side / grid)
}

/// Makes or keeps the textures of every camera with a full-path sun.
pub fn prepare_atlas(
    mut commands: Commands,
    device: Res<RenderDevice>,
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
        let count = sun.light_views.len() as u32;
        let grid = atlas_grid(count);
        let cell = cell_size(sun.settings.map_size, grid, device.limits().max_texture_dimension_2d);
        if cell != sun.settings.map_size {
            warn_once!(
                "map_size {} does not fit the device's textures and is reduced to {cell}",
                sun.settings.map_size
            );
        }
        let is_layered = sun.settings.store.is_layered();
        if !atlas.is_some_and(|atlas| {
            (atlas.grid, atlas.cell, atlas.count, atlas.second.is_some()) == (grid, cell, count, is_layered)
        }) {
            let create = |label| create_target(&device, label, UVec2::splat(grid * cell), ATLAS_FORMAT);
            let same_size = atlas.filter(|atlas| (atlas.grid, atlas.cell) == (grid, cell));
            let (texture, view) = match same_size {
                Some(atlas) => (atlas.texture.clone(), atlas.view.clone()),
                None => create("umbrage_shadow_atlas"),
            };
            let second = is_layered.then(|| {
                let known = same_size.and_then(|atlas| atlas.second.clone());
                known.unwrap_or_else(|| create("umbrage_second_shadow_atlas"))
            });
            commands.entity(entity).insert(ShadowAtlas {
                texture,
                view,
                second,
                grid,
                cell,
                count,
            });
        }
        if result.is_none_or(|result| result.size != size) {
            let (texture, view) = create_target(&device, "umbrage_shadow_result", size, RESULT_FORMAT);
            commands.entity(entity).insert(ShadowResult { texture, view, size });
        }
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
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = texture.create_view(&TextureViewDescriptor::default());
    (texture, view)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_fill_the_grid_without_overlap() {
        for count in 1..=16_u32 {
            let grid = atlas_grid(count);
            assert!(grid * grid >= count, "{count} maps need more than {grid}² cells");
            assert!(
                grid == 1 || (grid - 1) * (grid - 1) < count,
                "{grid}² cells are too many for {count} maps"
            );
            for a in 0..count {
                let rect = cell_rect(a, grid, 8);
                assert!(
                    rect.x + rect.z <= grid * 8 && rect.y + rect.w <= grid * 8,
                    "cell {a} of {count} is outside"
                );
                for b in 0..a {
                    assert_ne!(rect, cell_rect(b, grid, 8), "cells {a} and {b} of {count} coincide");
                }
            }
        }
    }

    #[test]
    fn cells_are_reduced_to_the_device() {
        assert_eq!(cell_size(4096, 4, 8192), 2048, "four cells of 4096 do not fit 8192");
        assert_eq!(cell_size(2048, 2, 8192), 2048, "a size that fits is kept");
    }
}
