//! Main-world ECS of sun shadows.

pub mod settings;
pub mod technique;
pub mod views;
