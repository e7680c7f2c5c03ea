//! Systems of the main world in headless apps: no GPU, no window.

mod bounds;
mod cascades;
mod support;
mod views;
