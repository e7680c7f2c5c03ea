//! Perspective-optimal light planes: where to put a light's film so that its texels suit the picture best.

pub mod space;
