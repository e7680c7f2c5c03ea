//! Levels of detail (Giegl 2007, chapters 6 and 7).

mod blend;
mod cells;
mod energy;
mod layers;
mod selection;
