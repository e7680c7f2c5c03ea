//! From what the GPU wrote to the types of the maths room.

use bevy::math::{UVec2, Vec2};

use crate::{
    maths::virtual_map::{
        bytes::{byte_level, place_of_byte},
        grid::{Histogram, NeedCell},
        mapping::{MAX_LEVEL, MappingTexel, TileMappingMap},
        picture::PixelRect,
    },
    render::gpu_types::NeedTotals,
};

/// Words of a `NeedCell` in a buffer.
pub const CELL_WORDS: usize = 7;
/// Words of `NeedTotals` in a buffer.
pub const TOTALS_WORDS: usize = 33;
/// Words of the histogram of one cell: 32 levels along u and 32 along v.
pub const HISTOGRAM_WORDS: usize = 64;
/// Words of a `MappingTexel` in a buffer.
pub const TEXEL_WORDS: usize = 6;

/// Little-endian words of a read buffer.
pub fn words(bytes: &[u8]) -> Vec<u32> {
    let (words, _) = bytes.as_chunks();
    words.iter().copied().map(u32::from_le_bytes).collect()
}

/// The cells of a grid, row by row.
pub fn need_cells(words: &[u32]) -> Vec<NeedCell> {
    let (cells, _) = words.as_chunks::<CELL_WORDS>();
    cells.iter().map(need_cell).collect()
}

fn need_cell(words: &[u32; CELL_WORDS]) -> NeedCell {
    let [level_u, level_v, pixels, first_column, first_row, end_column, end_row] = *words;
    if pixels == 0 {
        return NeedCell::EMPTY;
    }
    NeedCell {
        levels: [level_u, level_v].map(|level| level.min(u32::from(MAX_LEVEL)) as u8),
        pixels,
        rect: PixelRect {
            min: UVec2::new(!first_column, !first_row),
            max: UVec2::new(end_column, end_row),
        },
    }
}

/// The histograms of as many cells.
pub fn histograms(words: &[u32]) -> Vec<Histogram> {
    let (cells, _) = words.as_chunks::<HISTOGRAM_WORDS>();
    let axis = |cell: &[u32; HISTOGRAM_WORDS], first: usize| std::array::from_fn(|level| cell[first + level]);
    cells.iter().map(|cell| [axis(cell, 0), axis(cell, 32)]).collect()
}

/// The counts over the picture; zeros where words are missing.
pub fn totals(words: &[u32]) -> NeedTotals {
    let word = |index: usize| words.get(index).copied().unwrap_or(0);
    NeedTotals {
        pixels_by_level: std::array::from_fn(word),
        outside: word(TOTALS_WORDS - 1),
    }
}

/// The same counts from a mapping map.
pub fn totals_of_map(map: &TileMappingMap) -> NeedTotals {
    let mut totals = NeedTotals {
        outside: map.outside,
        ..NeedTotals::default()
    };
    for texel in map.texels.iter().flatten() {
        let level = texel.levels[0].max(texel.levels[1]).min(MAX_LEVEL);
        totals.pixels_by_level[usize::from(level)] += 1;
    }
    totals
}

impl NeedTotals {
    /// Pixels that look into the map.
    pub fn pixels(&self) -> u64 {
        self.pixels_by_level.iter().copied().map(u64::from).sum()
    }

    /// Pixels that need more than 2^`level` texels on some axis.
    pub fn pixels_above(&self, level: u32) -> u64 {
        let above = self.pixels_by_level.iter().skip(level as usize + 1);
        above.copied().map(u64::from).sum()
    }
}

/// A mapping map of numbers. Missing words are nothing.
pub fn mapping_map(words: &[u32], size: UVec2, picture: UVec2) -> TileMappingMap {
    let (texels, _) = words.as_chunks::<TEXEL_WORDS>();
    let found = texels.iter().map(|texel| {
        let number = |index: usize| f32::from_bits(texel[index]);
        let levels = texel[4];
        match levels >> 16 {
            SURFACE => Found::Surface(MappingTexel {
                uv: Vec2::new(number(0), number(1)),
                levels: [levels as u8, (levels >> 8) as u8],
                reach: Vec2::new(number(2), number(3)),
            }),
            OUTSIDE => Found::Outside,
            _ => Found::Nothing,
        }
    });
    collect(found, size, picture)
}

/// A mapping map of bytes as the thesis has them: place and need in one byte per axis, needs for steps of one texel of the
/// mapping map.
pub fn byte_mapping_map(words: &[u32], size: UVec2, picture: UVec2) -> TileMappingMap {
    let steps = (picture.as_dvec2() / size.as_dvec2()).max_element();
    let level = |need: u8| byte_level(need, steps).clamp(0.0, f64::from(MAX_LEVEL)) as u8;
    let place = |byte: u8| place_of_byte(byte) as f32;
    let found = words.iter().map(|texel| match *texel {
        BYTES_NOTHING => Found::Nothing,
        BYTES_OUTSIDE => Found::Outside,
        texel => {
            let [u, v, need_u, need_v] = texel.to_le_bytes();
            Found::Surface(MappingTexel {
                uv: Vec2::new(place(u), place(v)),
                levels: [level(need_u), level(need_v)],
                reach: Vec2::ZERO,
            })
        }
    });
    collect(found, size, picture)
}

const OUTSIDE: u32 = 1;
const SURFACE: u32 = 2;
const BYTES_NOTHING: u32 = 0xffff_ffff;
const BYTES_OUTSIDE: u32 = 0xfeff_ffff;

enum Found {
    Nothing,
    Outside,
    Surface(MappingTexel),
}

fn collect(found: impl Iterator<Item = Found>, size: UVec2, picture: UVec2) -> TileMappingMap {
    let mut outside = 0;
    let texels = found.map(|found| match found {
        Found::Surface(texel) => Some(texel),
        Found::Outside => {
            outside += 1;
            None
        }
        Found::Nothing => None,
    });
    let mut texels: Vec<Option<MappingTexel>> = texels.collect();
    texels.resize((size.x * size.y) as usize, None);
    TileMappingMap {
        size,
        picture,
        texels,
        outside,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_come_back_as_they_were_collected() {
        let cell = [17, 15, 3, !4, !2, 9, 8];
        let words: Vec<u32> = [[0; CELL_WORDS], cell].concat();
        let cells = need_cells(&words);
        assert_eq!(cells[0], NeedCell::EMPTY, "zeros are nothing");
        let expected = NeedCell {
            levels: [17, 15],
            pixels: 3,
            rect: PixelRect {
                min: UVec2::new(4, 2),
                max: UVec2::new(9, 8),
            },
        };
        assert_eq!(cells[1], expected);
    }

    #[test]
    fn pixels_above_a_level_are_counted() {
        let mut words = vec![0; TOTALS_WORDS];
        (words[16], words[17], words[18], words[32]) = (10, 20, 40, 5);
        let totals = totals(&words);
        assert_eq!((totals.pixels(), totals.outside), (70, 5));
        assert_eq!([16, 17, 18, 31].map(|level| totals.pixels_above(level)), [60, 40, 0, 0]);
    }

    #[test]
    fn bytes_say_nothing_outside_or_a_surface() {
        let texel = u32::from_le_bytes([128, 64, 13, 14]);
        let size = UVec2::new(2, 2);
        let map = byte_mapping_map(&[texel, BYTES_NOTHING, BYTES_OUTSIDE], size, size * 4);
        assert_eq!((map.outside, map.valid_texels(), map.texels.len()), (1, 1, 4));
        let found = map.texels[0].expect("the first is a surface");
        // R + round(log2 4 + 1/2), halves up: R + 3.
        assert_eq!(found.levels, [16, 17]);
        assert_eq!(found.uv, Vec2::new(128.5 / 256.0, 64.5 / 256.0));
    }
}
