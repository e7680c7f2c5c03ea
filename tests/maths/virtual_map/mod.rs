//! Virtual shadow maps against the oracles of Giegl and against properties.

mod feedback;
mod fitted;
mod grid;
mod limits;
mod mapping;
mod memory;
mod needs;
mod queried;
mod reach;
mod scene;
mod tile;
mod transparent;
