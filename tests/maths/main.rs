//! Pure mathematics against the oracles of the papers and against properties.

mod axes;
mod body;
mod fit;
mod footprint;
mod golden;
mod options;
mod polytope;
mod post_perspective;
mod presets;
mod properties;
mod spans;
mod split;
mod support;
mod warp;
