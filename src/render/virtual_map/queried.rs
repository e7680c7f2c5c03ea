//! Queried maps: refined as long as the picture changes (Giegl, chapter 4), level by level, with a read-back after each.
//!
//! What the thesis counts with occlusion queries, fragments count with atomics in a storage buffer: pixels that changed,
//! pixels inside the tile and their rectangle on the screen, to which its children are confined.
//! [`QueriedMap::refine_levels`] decides.

use bevy::math::{DMat4, UVec2};

use super::{
    TileFrame,
    tiles::{TileDraw, margin},
};
use crate::{
    maths::virtual_map::{
        queried::{QueriedMap, QueriedTile, TileReport},
        tile::TileWindow,
    },
    shadow::{settings::ShadowFilter, virtual_maps::QueriedMaps},
};

/// Filtered results that change by no more are the same: one step of a picture of 8 bits. Without it, every tile of a
/// finer level would change the soft edge of every shadow.
const FILTERED_TOLERANCE: f32 = 1.0 / 255.0;

/// Draws a queried map.
pub(super) fn draw(frame: &mut TileFrame, settings: &QueriedMaps, map_clip_from_world: &DMat4) {
    let map = settings.refinement.within(frame.texture_budget());
    let filter = frame.sun.settings.filter;
    let tolerance = if filter == ShadowFilter::Hard {
        0.0
    } else {
        FILTERED_TOLERANCE
    };
    frame.prepare_textures(&sizes(&map));
    let draw_of = |tile: &QueriedTile| {
        let map_texels = tile.tile.counts.max_element() * tile.size;
        let margin = margin(filter, map_clip_from_world, f64::from(map_texels), tile.size);
        TileDraw::filling(
            tile.tile,
            TileWindow::of_size(UVec2::splat(tile.size), margin),
            tile.rect,
        )
    };
    let refinement = map.refine_levels(frame.viewport, |level| {
        let draws: Vec<TileDraw> = level.iter().map(draw_of).collect();
        if level.iter().any(|tile| tile.decision.is_none()) {
            frame.draw(&draws);
            vec![TileReport::EMPTY; draws.len()]
        } else {
            frame.draw_counted(&draws, tolerance)
        }
    });
    frame.report.splits = refinement.splits as u32;
    frame.report.jumps = refinement.jumps as u32;
    for (drawn, tile) in frame.report.tiles.iter_mut().zip(&refinement.tiles) {
        drawn.decision = tile.decision;
    }
}

/// Sides of the textures that a map may need.
fn sizes(map: &QueriedMap) -> Vec<UVec2> {
    let has_jumps = map.maximum_jump || map.opportunity_jump.is_some();
    let mut sizes = vec![UVec2::splat(map.tile_size)];
    if has_jumps && map.tile_size_max > map.tile_size {
        sizes.push(UVec2::splat(map.tile_size_max));
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn textures_for_jumps_are_made_if_there_are_jumps() {
        let map = QueriedMap::default();
        assert_eq!(sizes(&map), [UVec2::splat(1024), UVec2::splat(4096)]);
        let without = QueriedMap {
            maximum_jump: false,
            opportunity_jump: None,
            ..map
        };
        assert_eq!(sizes(&without), [UVec2::splat(1024)]);
    }
}
