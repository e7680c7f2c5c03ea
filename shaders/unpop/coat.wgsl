// What a fading part carries in its mesh tag; the CPU twin is `src/render/unpop/tag.rs`.
#define_import_path umbrage::coat

const MOST: u32 = 1023u;
const NUMBERS: u32 = 511u;

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
    return ((tag >> 20u) & NUMBERS) + 1u;
}

// The layer of nearest surfaces that the level is found in.
fn coat_layer(tag: u32) -> u32 {
    return tag >> 29u;
}

// Thresholds of a tile of 8 x 8 texels, 1/128 to 127/128: ordered dither (Bayer 1973). Of fewer thresholds, a share that
// grows evenly would pass one in some frames and two in others.
fn threshold(texel: vec2<u32>) -> f32 {
    let y = texel.y & 7u;
    let mixed = (texel.x & 7u) ^ y;
    let coarse = ((mixed & 1u) << 5u) | ((y & 1u) << 4u);
    let middle = ((mixed & 2u) << 2u) | ((y & 2u) << 1u);
    let fine = ((mixed & 4u) >> 1u) | ((y & 4u) >> 2u);
    return (f32(coarse | middle | fine) + 0.5) / 64.0;
}
