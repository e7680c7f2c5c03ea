// What a fading part carries in its mesh tag; the CPU twin is `src/render/unpop/tag.rs`.
#define_import_path umbrage::coat

const MOST: u32 = 1023u;

// Opacity, 0..1.
fn coat_alpha(tag: u32) -> f32 {
    return f32(tag & MOST) / f32(MOST);
}

// Share of a shadow, 0..1.
fn coat_shadow(tag: u32) -> f32 {
    return f32((tag >> 10u) & MOST) / f32(MOST);
}

// The same for all parts of an object's level; never 0, which stands for none.
fn coat_level(tag: u32) -> u32 {
    return (tag >> 20u) + 1u;
}

// Thresholds of a tile of 4 x 4 texels, 1/32 to 31/32: ordered dither (Bayer 1973).
fn threshold(texel: vec2<u32>) -> f32 {
    let x = texel.x & 3u;
    let y = texel.y & 3u;
    let mixed = x ^ y;
    let rank = ((mixed & 1u) << 3u) | ((y & 1u) << 2u) | (mixed & 2u) | (y >> 1u);
    return (f32(rank) + 0.5) / 16.0;
}
