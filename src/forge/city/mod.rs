//! What a city is built of.

pub mod facade;
