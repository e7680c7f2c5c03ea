//! Pure mathematics of shadow maps: values in, values out; no ECS, no GPU, no clock, no randomness.

pub mod split;
pub mod warp;
