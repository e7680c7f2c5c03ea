// Depth and share of a fading caster in one number; the CPU twin is `src/maths/filter/fading.rs`.
#define_import_path umbrage::fading

// The last eight bits of the depth.
const MOST: u32 = 255u;

// A depth of reverse z, 0..1, that carries how much of the light the caster takes, 0..1.
fn fading_depth(depth: f32, share: f32) -> f32 {
    return bitcast<f32>((bitcast<u32>(depth) & ~MOST) | u32(round(saturate(share) * f32(MOST))));
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
