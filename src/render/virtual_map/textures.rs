//! [`TileTextures`]: the depth textures that the tiles of a camera use in turn, within a budget of memory.

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

/// Most textures of one size: tiles that are drawn before they are applied together.
const MAX_COPIES: usize = TILE_SLOTS;

/// Depth textures for tiles.
#[derive(Debug, Default)]
pub struct TileTextures(Vec<TileTexture>);

/// What a tile is drawn into.
#[derive(Debug)]
pub struct TileTexture {
    /// Depths of opaque casters.
    pub depth: (Texture, TextureView),
    /// Depths and shares of casters that fade, while some do.
    pub fading: Option<(Texture, TextureView)>,
}

impl TileTexture {
    /// Texels.
    pub fn size(&self) -> UVec2 {
        size_of(&self.depth.0)
    }
}

impl TileTextures {
    /// Makes, keeps or drops textures for tiles of some sizes: one of each size as far as the budget in bytes goes, from
    /// the largest down, else tiles use the corner of a larger one. What is left of the budget goes to copies, of the smallest
    /// first, so that many tiles can be applied together.
    ///
    /// The largest is made even if it does not fit: that is for the caller to avoid. `fades`: whether casters fade, which
    /// takes half of the budget.
    pub fn prepare(&mut self, device: &RenderDevice, sizes: &[UVec2], budget_bytes: u64, fades: bool) {
        let wanted = affordable(sizes, if fades { budget_bytes / 2 } else { budget_bytes });
        let mut old = std::mem::take(&mut self.0);
        for size in wanted {
            let known = old.iter().position(|texture| texture.size() == size);
            let mut texture = known.map_or_else(
                || TileTexture {
                    depth: create_target(device, "umbrage_tile", size, ATLAS_FORMAT),
                    fading: None,
                },
                |index| old.swap_remove(index),
            );
            let create = || create_target(device, "umbrage_fading_tile", size, ATLAS_FORMAT);
            texture.fading = fades.then(|| texture.fading.unwrap_or_else(create));
            self.0.push(texture);
        }
    }

    /// The smallest free texture that holds a tile of a size: its number.
    pub fn smallest_for(&self, size: UVec2, is_free: impl Fn(usize) -> bool) -> Option<usize> {
        let textures = self.0.iter().enumerate();
        let fitting = textures.filter(|(index, texture)| is_free(*index) && texture.size().cmpge(size).all());
        let smallest = fitting.min_by_key(|(_, texture)| bytes(texture.size()));
        smallest.map(|(index, _)| index)
    }

    /// One of them, the largest first.
    pub fn get(&self, index: usize) -> &TileTexture {
        &self.0[index]
    }

    /// The largest of them.
    pub fn largest(&self) -> Option<&Texture> {
        self.0.first().map(|texture| &texture.depth.0)
    }

    /// Bytes of all of them.
    pub fn bytes(&self) -> u64 {
        let copies = |texture: &TileTexture| 1 + u64::from(texture.fading.is_some());
        let textures = self.0.iter();
        textures.map(|texture| copies(texture) * bytes(texture.size())).sum()
    }
}

fn size_of(texture: &Texture) -> UVec2 {
    UVec2::new(texture.width(), texture.height())
}

fn bytes(size: UVec2) -> u64 {
    u64::from(size.x) * u64::from(size.y) * BYTES_PER_TEXEL
}

/// Sizes of the textures to make, largest first.
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
