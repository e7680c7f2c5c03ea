//! Pure mathematics against the oracles of the papers and against properties.

mod analysis;
mod axes;
mod body;
mod depth_offset;
mod eye_blur;
mod filter;
mod fit;
mod footprint;
mod golden;
mod light;
mod light_body;
mod near_plane;
mod options;
mod overhead;
mod polytope;
mod post_perspective;
mod presets;
mod properties;
mod shaders;
mod spans;
mod split;
mod stable;
mod stable_warp;
mod support;
mod warp;
