//! Pictures painted on the CPU: noise, bark, leaves, mips.

pub mod bark;
pub mod canvas;
pub mod leaf;
pub mod mips;
pub mod noise;
pub mod picture;
pub mod sprigs;
