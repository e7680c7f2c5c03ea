//! Render world: the passes that draw and apply light views.

pub mod capture;
pub mod mask;
