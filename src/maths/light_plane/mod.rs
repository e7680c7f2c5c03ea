//! Perspective-optimal light planes (Chong 2003): which film plane of a light spreads its texels best over the picture.
//!
//! A light that looks at a scene may turn its film (the plane of its map) as long as everything to be covered stays before
//! it. Turning moves texels towards one side of the map. [`flat`] is the source's own setting, a plane with a line for a
//! picture and a line for a map, where the best film has a closed form. [`space`] is the same for the sun and for lights at
//! a point in three dimensions.

pub mod flat;
pub mod space;
