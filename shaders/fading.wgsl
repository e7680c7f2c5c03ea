// Depth and share of a fading caster in one number; the CPU twin is `src/maths/filter/fading.rs`.
#define_import_path umbrage::fading

// The last eight bits of the depth.
const MOST: u32 = 255u;

// A depth of reverse z, 0..1, that carries how much of the light the caster takes, 0..1. Never nearer to the light than the
// depth, and farther by at most 2^-14 of it.
fn fading_depth(depth: f32, share: f32) -> f32 {
    let bits = max(bitcast<u32>(depth), 2u * (MOST + 1u)) & ~MOST;
    return bitcast<f32>((bits - (MOST + 1u)) | u32(round(saturate(share) * f32(MOST))));
}

// The share that such a depth carries.
fn fading_share(stored: f32) -> f32 {
    return f32(bitcast<u32>(stored) & MOST) / f32(MOST);
}
