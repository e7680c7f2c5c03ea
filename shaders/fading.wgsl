// Depth and share of a fading caster in one number; the CPU twin is `src/maths/filter/fading.rs`.
#define_import_path umbrage::fading

// The last eight bits of the depth.
const MOST: u32 = 255u;
// The largest number below 1, in bits: depths of 1 (casters before the near plane) would lose their share in a texture, which
// holds nothing larger.
const LARGEST: u32 = 0x3f7fffffu;

// A depth of reverse z, 0..1, that carries how much of the light the caster takes, 0..1.
fn fading_depth(depth: f32, share: f32) -> f32 {
    let bits = min(bitcast<u32>(depth), LARGEST) & ~MOST;
    return bitcast<f32>(bits | u32(round(saturate(share) * f32(MOST))));
}

// The depth that such a depth carries: the same for every share, or texels would change while shares do. Never nearer to the
// light than the caster's, and farther by at most 2^-15 of it.
fn depth_without_share(stored: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(stored) & ~MOST);
}

// The share that such a depth carries.
fn fading_share(stored: f32) -> f32 {
    return f32(bitcast<u32>(stored) & MOST) / f32(MOST);
}
