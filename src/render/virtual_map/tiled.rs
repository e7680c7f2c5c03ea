//! Tiled maps: every tile at full size, in one list (Giegl, chapter 3).

use bevy::math::{DMat4, UVec2};

use super::{
    TileFrame,
    tiles::{TileDraw, margin},
};
use crate::{maths::virtual_map::tiled::TiledMap, shadow::virtual_maps::TiledMaps};

/// Draws a tiled map.
pub(super) fn draw(frame: &mut TileFrame, settings: &TiledMaps, map_clip_from_world: &DMat4) {
    let map_texels = f64::from(settings.tiles_per_axis * settings.tile_size);
    let filter = frame.sun.settings.filter;
    let margin = margin(filter, map_clip_from_world, map_texels, settings.tile_size);
    let finest = TiledMap::new(settings.tiles_per_axis, settings.tile_size, margin).within(frame.texture_budget());
    let map = TiledMap {
        tiles_per_axis: if settings.progressive {
            finest.progressive_tiles_per_axis(frame.still_frames)
        } else {
            finest.tiles_per_axis
        },
        ..finest
    };
    let tiles = match &frame.sun.visible {
        Some(visible) if settings.skip_empty => map.tiles_with_receivers(map_clip_from_world, visible),
        _ => map.tiles().collect(),
    };
    let tiles: Vec<TileDraw> = (tiles.into_iter())
        .map(|tile| TileDraw::filling(tile, map.window, frame.viewport))
        .collect();
    frame.prepare_textures(&[UVec2::splat(map.window.size.max_element())]);
    frame.draw(&tiles);
}
