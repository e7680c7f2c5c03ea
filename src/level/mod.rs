//! Levels: where geometry, sun, spawn, shots and camera paths come from.

pub mod shot;
