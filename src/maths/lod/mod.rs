//! Levels of detail: which one is drawn, how one takes another's place, and how much of that is seen.
//!
//! - [`selection`]: distances or projected sizes to levels, with hysteresis (Giegl 2007, section 6.1).
//! - [`crossing`]: progress from one level to another in time or over distance, reversible midway (sections 7.2, 7.4.1).
//! - [`blend`]: how both levels are drawn at each moment, the states of Unpopping and its rivals (section 7.2, figure 7.2).
//! - [`energy`]: how much of a change is seen: pop energy and background leak.
//! - [`layers`]: which fading levels share a layer of nearest surfaces.
//! - [`cells`]: fields of very many things in a quadtree of cells, near ones one by one, far ones in blocks.
//!
//! Distances are metres, from the eye to the object's origin. `t` is the share of a crossing that is done, 0..=1.

pub mod blend;
pub mod cells;
pub mod crossing;
pub mod energy;
pub mod layers;
pub mod selection;
