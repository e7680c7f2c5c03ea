//! Systems of the main world in headless apps: no GPU, no window.

mod bounds;
mod cascades;
mod depths;
mod levels_of_detail;
mod partitions;
mod support;
mod views;
