//! Levels of detail (Giegl 2007, chapters 6 and 7).

mod blend;
mod energy;
mod selection;
