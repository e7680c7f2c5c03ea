//! Pictures of models, without a GPU: impostors, and previews to look at.

pub mod impostor;
pub mod preview;
pub mod raster;
