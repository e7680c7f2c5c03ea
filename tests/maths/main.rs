//! Pure mathematics against the oracles of the papers and against properties.

mod analysis;
mod body;
mod fit;
mod footprint;
mod polytope;
mod properties;
mod split;
mod support;
mod warp;
