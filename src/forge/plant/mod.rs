//! Plants: growth models, wood, leaves, species.

pub mod colonise;
pub mod crown;
pub mod skeleton;
pub mod species;
pub mod tree;
pub mod tubes;
pub mod weber_penn;
