//! The playable demo.
