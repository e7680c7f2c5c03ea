//! Pure mathematics against the oracles of the papers and against properties.

mod body;
mod face;
mod fit;
mod footprint;
mod partition_properties;
mod polytope;
mod properties;
mod selection;
mod split;
mod support;
mod warp;
