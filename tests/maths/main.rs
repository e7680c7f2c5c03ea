//! Pure mathematics against the oracles of the papers and against properties.

mod body;
mod depth_offset;
mod eye_blur;
mod filter;
mod fit;
mod footprint;
mod light;
mod light_body;
mod near_plane;
mod overhead;
mod polytope;
mod properties;
mod shaders;
mod split;
mod stable;
mod stable_warp;
mod support;
mod warp;
