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
    render::atlas::{ATLAS_FORMAT, create_target},
};

/// More textures of one size than this gain nothing: a tile is drawn while the one before it is applied.
const MAX_COPIES: usize = 4;

/// Depth textures for tiles.
#[derive(Debug, Default)]
pub struct TileTextures(Vec<(Texture, TextureView)>);

impl TileTextures {
    /// Makes, keeps or drops textures for tiles of some sizes: one of each size as far as the budget in bytes goes, from
    /// the largest down, else tiles use the corner of a larger one. Of a single size a few, so that tiles overlap in time.
    ///
    /// The largest is made even if it does not fit: that is for the caller to avoid.
    pub fn prepare(&mut self, device: &RenderDevice, sizes: &[UVec2], budget_bytes: u64) {
        let wanted = affordable(sizes, budget_bytes);
        let mut old = std::mem::take(&mut self.0);
        for size in wanted {
            let known = old.iter().position(|(texture, _)| size_of(texture) == size);
            self.0.push(match known {
                Some(index) => old.swap_remove(index),
                None => create_target(device, "umbrage_tile", size, ATLAS_FORMAT),
            });
        }
    }

    /// The texture for the `turn`-th tile of a size: the smallest that holds it; the same one for equal numbers.
    pub fn of(&self, size: UVec2, turn: usize) -> Option<&(Texture, TextureView)> {
        let holds = |texture: &Texture| size_of(texture).cmpge(size).all();
        let area = |texture: &Texture| u64::from(texture.width()) * u64::from(texture.height());
        let candidates = || self.0.iter().filter(|(texture, _)| holds(texture));
        let least = candidates().map(|(texture, _)| area(texture)).min()?;
        let equal: Vec<_> = candidates().filter(|(texture, _)| area(texture) == least).collect();
        equal.get(turn % equal.len().max(1)).copied()
    }

    /// One of them, the largest first.
    pub fn get(&self, index: usize) -> Option<&Texture> {
        self.0.get(index).map(|(texture, _)| texture)
    }

    /// Bytes of all of them.
    pub fn bytes(&self) -> u64 {
        let sizes = self.0.iter().map(|(texture, _)| bytes(size_of(texture)));
        sizes.sum()
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
    if let [only] = sizes[..] {
        let copies = (budget_bytes / bytes(only)).clamp(1, MAX_COPIES as u64);
        return vec![only; copies as usize];
    }
    let mut spent = 0;
    let mut made: Vec<UVec2> = Vec::new();
    for size in sizes {
        let has_corner = made.iter().any(|larger| larger.cmpge(size).all());
        if !has_corner || spent + bytes(size) <= budget_bytes {
            spent += bytes(size);
            made.push(size);
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn budgets_are_kept_where_a_corner_is_free() {
        let square = UVec2::splat;
        let sizes = [square(64), square(256), square(128), square(64)];
        let all = affordable(&sizes, 1 << 20);
        assert_eq!(all, [square(256), square(128), square(64)]);
        let some = affordable(&sizes, bytes(square(256)) + bytes(square(64)));
        assert_eq!(some, [square(256), square(64)], "128² uses a corner of 256²");
        assert_eq!(affordable(&sizes, bytes(square(256))), [square(256)]);
        // Neither holds the other.
        let crossed = affordable(&[UVec2::new(64, 16), UVec2::new(16, 64)], 0);
        assert_eq!(crossed.len(), 2);
    }

    #[test]
    fn one_size_is_copied_within_the_budget() {
        let size = UVec2::splat(512);
        assert_eq!(affordable(&[size], 64 << 20).len(), MAX_COPIES);
        assert_eq!(affordable(&[size, size], 2 << 20).len(), 2);
        assert_eq!(affordable(&[size], 0).len(), 1);
        assert_eq!(affordable(&[], 1 << 20), []);
    }
}
