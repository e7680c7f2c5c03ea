//! Pure mathematics against the oracles of the papers and against properties.

mod body;
mod cull;
mod face;
mod fit;
mod footprint;
mod kernel;
mod partition_properties;
mod polytope;
mod properties;
mod schemes;
mod selection;
mod split;
mod storage;
mod support;
mod warp;
