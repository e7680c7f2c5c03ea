//! [`TileDraw`]: a tile to draw and apply, and what its shader reads.

use bevy::{
    math::{DMat4, DVec2, Vec4},
    prelude::*,
};

use crate::{
    maths::virtual_map::{
        picture::PixelRect,
        reach::texels_per_metre,
        tile::{Tile, TileWindow, filter_margin},
    },
    render::gpu_types::GpuShadowTile,
    shadow::settings::ShadowFilter,
};

/// A tile to draw and apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileDraw {
    /// Index of the light view whose map it is a part of.
    pub light_view: u32,
    /// Which part of the map.
    pub tile: Tile,
    /// What is drawn of it: core and margins.
    pub window: TileWindow,
    /// The cell that is asked for: at least as large as the window, which lies in its corner. Where memory is short it lies in
    /// the corner of a larger one.
    pub texture: UVec2,
    /// Pixels of the picture that may look into it.
    pub rect: PixelRect,
}

impl TileDraw {
    /// A tile of the first light view that fills its texture.
    pub fn filling(tile: Tile, window: TileWindow, rect: PixelRect) -> Self {
        Self {
            light_view: 0,
            tile,
            window,
            texture: window.size,
            rect,
        }
    }

    /// The matrix that draws it, composed in double precision.
    pub fn clip_from_world(&self, map_clip_from_world: &DMat4) -> Mat4 {
        self.tile.clip_from_world(map_clip_from_world, &self.window).as_mat4()
    }

    /// What its apply pass reads. Lookups are made in texels of the whole map at the tile's resolution, so that a tile
    /// holds exactly the texels of one map of that size.
    /// `origin`: first texel of the cell that it is drawn into.
    pub fn gpu(&self, origin: UVec2, report: u32, tolerance: f32) -> GpuShadowTile {
        let core = self.window.core().as_ivec2();
        let map = self.tile.counts.as_ivec2() * core;
        let first = self.tile.place.as_ivec2() * core - self.window.margin as i32;
        let last = first + self.window.size.as_ivec2() - 1;
        let bounds = [first.max(IVec2::ZERO), last.min(map - 1)].map(|texel| texel.as_vec2());
        GpuShadowTile {
            rect: Vec4::from(((origin.as_ivec2() - first).as_vec2(), map.as_vec2())),
            bounds: Vec4::from((bounds[0], bounds[1])),
            place: self.tile.place.as_vec2(),
            counts: self.tile.counts.as_vec2(),
            report,
            tolerance,
            light_view: self.light_view,
            ..default()
        }
    }
}

/// The margin that a filter needs around tiles of a map with `map_texels` per axis. At most 256 texels and an eighth of the
/// texture: wider filters are cut at the borders of tiles.
pub fn margin(filter: ShadowFilter, map_clip_from_world: &DMat4, map_texels: f64, texture_side: u32) -> u32 {
    let kernel = match filter {
        ShadowFilter::Hard => 0.0,
        ShadowFilter::Pcf2 => 2.0,
        ShadowFilter::Poisson { radius, .. } | ShadowFilter::Pcss { radius, .. } => {
            // Every tap of the disc is a bilinear lookup.
            2.0 * f64::from(radius) * texels_per_metre(map_clip_from_world, DVec2::splat(map_texels)) + 2.0
        }
    };
    filter_margin(kernel).min(texture_side / 8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_of_tiles_are_those_of_the_map() {
        let counts = UVec2::new(4, 2);
        let window = TileWindow::of_size(UVec2::new(66, 34), 1);
        let tile = Tile {
            place: UVec2::new(3, 0),
            counts,
        };
        let gpu = TileDraw::filling(tile, window, PixelRect::EMPTY);
        let gpu = gpu.gpu(UVec2::new(66, 0), 7, 0.5);
        assert_eq!(gpu.rect, Vec4::new(66.0 - 191.0, 1.0, 256.0, 64.0));
        // The margin beyond the map's border is not looked up.
        assert_eq!(gpu.bounds, Vec4::new(191.0, 0.0, 255.0, 32.0));
        assert_eq!((gpu.place, gpu.counts), (Vec2::new(3.0, 0.0), Vec2::new(4.0, 2.0)));
        assert_eq!((gpu.report, gpu.tolerance), (7, 0.5));
    }

    #[test]
    fn margins_follow_the_filter() {
        // 40 m wide: 100 texels per metre.
        let map = DMat4::from_scale(DVec2::splat(1.0 / 20.0).extend(0.01));
        let of = |filter, side| margin(filter, &map, 4000.0, side);
        assert_eq!((of(ShadowFilter::Hard, 512), of(ShadowFilter::Pcf2, 512)), (0, 1));
        let disc = ShadowFilter::Poisson { taps: 8, radius: 0.25 };
        assert_eq!(of(disc, 512), 26, "25 texels and one for the bilinear lookup");
        assert_eq!(of(disc, 64), 8, "no more than an eighth");
    }
}
