//! The demo's state machine without window and GPU: the real plugin, a stand-in for the levels, keys by hand.

mod game;
mod keys;
mod picture;
mod screens;
mod walk;
