//! [`TileTextures`]: the depth textures that the tiles of a camera use in turn, within a budget of memory.
//!
//! Tiles that are drawn before they are applied together lie side by side in cells of one texture, so that one pass draws
//! them: a pass costs the CPU as much as the casters of a tile. Where a tile lies follows from its place in the list
//! alone: to which texels vertices are rounded may depend on the cell, but not on the order in which tiles are drawn.

use bevy::{
    prelude::*,
    render::{
        render_resource::{Texture, TextureView},
        renderer::RenderDevice,
    },
};

use crate::{
    maths::virtual_map::memory::BYTES_PER_TEXEL,
    render::{
        atlas::{ATLAS_FORMAT, create_target},
        caster::prepare::TILE_SLOTS,
    },
};

/// Most cells of one size: tiles that are drawn before they are applied together.
const MAX_COPIES: usize = TILE_SLOTS;

/// Depth textures for tiles, one per size.
#[derive(Debug, Default)]
pub struct TileTextures(Vec<TileTexture>);

/// What tiles are drawn into.
#[derive(Debug)]
pub struct TileTexture {
    /// Texels of a cell.
    pub cell: UVec2,
    /// Cells per row, and rows.
    pub cells: UVec2,
    /// Depths of opaque casters.
    pub depth: (Texture, TextureView),
    /// Depths and shares of casters that fade, while some do.
    pub fading: Option<(Texture, TextureView)>,
}

/// Where a tile is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileCell {
    /// Number of the texture.
    pub texture: usize,
    /// First texel of the cell.
    pub origin: UVec2,
}

impl TileTexture {
    /// Cells.
    pub fn count(&self) -> usize {
        (self.cells.x * self.cells.y) as usize
    }

    /// First texel of a cell; they are counted over and over.
    fn origin(&self, cell: usize) -> UVec2 {
        let cell = (cell % self.count()) as u32;
        UVec2::new(cell % self.cells.x, cell / self.cells.x) * self.cell
    }
}

impl TileTextures {
    /// Makes, keeps or drops textures for tiles of some sizes: a cell of each size as far as the budget in bytes goes, from
    /// the largest down, else tiles use the corner of a larger one. What is left of the budget goes to more cells, of the
    /// smallest first, so that many tiles can be drawn and applied together.
    ///
    /// What no larger cell holds is made even if it does not fit: that is for the caller to avoid. `fades`: whether casters
    /// fade, which takes as much again; cells stay where they are.
    pub fn prepare(&mut self, device: &RenderDevice, sizes: &[UVec2], budget_bytes: u64, fades: bool) {
        let wanted = affordable(sizes, budget_bytes);
        let largest = device.limits().max_texture_dimension_2d;
        let mut old = std::mem::take(&mut self.0);
        for copies in wanted.chunk_by(|a, b| a == b) {
            let (cell, cells) = (copies[0], grid(copies.len() as u32, copies[0], largest));
            let known = old
                .iter()
                .position(|texture| (texture.cell, texture.cells) == (cell, cells));
            let create = |label| create_target(device, label, cell * cells, ATLAS_FORMAT);
            let mut texture = known.map_or_else(
                || TileTexture {
                    cell,
                    cells,
                    depth: create("umbrage_tiles"),
                    fading: None,
                },
                |index| old.swap_remove(index),
            );
            let fading = texture.fading.take();
            texture.fading = fades.then(|| fading.unwrap_or_else(|| create("umbrage_fading_tiles")));
            self.0.push(texture);
        }
    }

    /// Where the tiles of a list are drawn, by their sizes: in the smallest cells that hold them, one after the other. `None`
    /// where no cell is large enough.
    pub fn cells(&self, sizes: impl IntoIterator<Item = UVec2>) -> Vec<Option<TileCell>> {
        let mut used = vec![0; self.0.len()];
        let place = |size: UVec2| {
            let fitting = self
                .0
                .iter()
                .enumerate()
                .filter(|(_, texture)| texture.cell.cmpge(size).all());
            let (texture, smallest) = fitting.min_by_key(|(_, texture)| bytes(texture.cell))?;
            let origin = smallest.origin(used[texture]);
            used[texture] += 1;
            Some(TileCell { texture, origin })
        };
        sizes.into_iter().map(place).collect()
    }

    /// One of them, the largest cells first.
    pub fn get(&self, index: usize) -> &TileTexture {
        &self.0[index]
    }

    /// That of the largest cells.
    pub fn largest(&self) -> Option<&Texture> {
        self.0.first().map(|texture| &texture.depth.0)
    }

    /// Their numbers.
    pub fn numbers(&self) -> std::ops::Range<usize> {
        0..self.0.len()
    }

    /// Bytes of all of them.
    pub fn bytes(&self) -> u64 {
        let copies = |texture: &TileTexture| 1 + u64::from(texture.fading.is_some());
        let textures = self.0.iter();
        textures
            .map(|texture| copies(texture) * bytes(texture.cell * texture.cells))
            .sum()
    }
}

/// At most so many cells, in rows that are about as long as there are rows, in a texture of at most `largest` texels per axis.
fn grid(count: u32, cell: UVec2, largest: u32) -> UVec2 {
    let most = (UVec2::splat(largest) / cell).max(UVec2::ONE);
    let columns = count.isqrt().clamp(1, most.x);
    UVec2::new(columns, (count / columns).clamp(1, most.y))
}

fn bytes(size: UVec2) -> u64 {
    u64::from(size.x) * u64::from(size.y) * BYTES_PER_TEXEL
}

/// Sizes of the cells to make, largest first.
fn affordable(sizes: &[UVec2], budget_bytes: u64) -> Vec<UVec2> {
    let mut sizes: Vec<UVec2> = sizes.iter().copied().filter(|size| size.min_element() > 0).collect();
    sizes.sort_by_key(|size| std::cmp::Reverse((bytes(*size), size.x)));
    sizes.dedup();
    let mut spent = 0;
    let mut made: Vec<UVec2> = Vec::new();
    for size in sizes {
        let has_corner = made.iter().any(|larger| larger.cmpge(size).all());
        if !has_corner || spent + bytes(size) <= budget_bytes {
            spent += bytes(size);
            made.push(size);
        }
    }
    for size in made.clone().into_iter().rev() {
        let affordable = budget_bytes.saturating_sub(spent) / bytes(size);
        let copies = affordable.min(MAX_COPIES as u64 - 1);
        spent += copies * bytes(size);
        made.extend(std::iter::repeat_n(size, copies as usize));
    }
    made.sort_by_key(|size| std::cmp::Reverse((bytes(*size), size.x)));
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_kept_where_a_corner_is_free() {
        let square = UVec2::splat;
        let sizes = [square(64), square(256), square(128), square(64)];
        let each = bytes(square(256)) + bytes(square(128)) + bytes(square(64));
        assert_eq!(affordable(&sizes, each), [square(256), square(128), square(64)]);
        let some = affordable(&sizes, bytes(square(256)) + bytes(square(64)));
        assert_eq!(some, [square(256), square(64)], "128² uses a corner of 256²");
        assert_eq!(affordable(&sizes, bytes(square(256))), [square(256)]);
        // Neither holds the other.
        let crossed = affordable(&[UVec2::new(64, 16), UVec2::new(16, 64)], 0);
        assert_eq!(crossed.len(), 2);
    }

    #[test]
    fn cells_lie_in_grids_that_textures_can_hold() {
        let cell = UVec2::splat(512);
        let counts = [1, 2, 3, 5, 8, 16].map(|count| grid(count, cell, 8192).to_array());
        assert_eq!(counts, [[1, 1], [1, 2], [1, 3], [2, 2], [2, 4], [4, 4]]);
        assert_eq!(grid(16, cell, 1024), UVec2::splat(2));
        assert_eq!(grid(16, UVec2::new(8192, 64), 8192), UVec2::new(1, 16));
        assert_eq!(
            grid(4, UVec2::splat(9000), 8192),
            UVec2::ONE,
            "too large: for the caller to avoid"
        );
    }

    #[test]
    fn copies_use_what_is_left_of_the_budget() {
        let size = UVec2::splat(512);
        assert_eq!(affordable(&[size], 64 << 20).len(), MAX_COPIES);
        assert_eq!(affordable(&[size, size], 2 << 20).len(), 2);
        assert_eq!(affordable(&[size], 0).len(), 1);
        assert_eq!(affordable(&[], 1 << 20), []);
        // 4 MiB and 1 MiB: what is left of 12 MiB are 7 more of the small ones.
        let some = affordable(&[size, 2 * size], 12 << 20);
        assert_eq!(some, [vec![2 * size; 1], vec![size; 8]].concat());
        // 16 MiB of small ones, and one more large one.
        let more = affordable(&[size, 2 * size], 26 << 20);
        assert_eq!(more, [vec![2 * size; 2], vec![size; MAX_COPIES]].concat());
    }
}
