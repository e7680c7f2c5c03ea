//! Maps whose texels stand still in the world while the camera moves.
//!
//! A focused map is rasterised anew each frame, and shadow edges crawl: texels move by parts of themselves (offset) and
//! change size (scale) (Stingl 2011, section 3.5). Edges stand still exactly when the grid of texels in the world is
//! the same as before, up to a shift by whole texels. Three ways there:
//!
//! | way | grid | cost | functions |
//! |---|---|---|---|
//! | bounding sphere | never changes | no focus, no warp: the coarsest map | [`sphere`] |
//! | quantised scale | changes with the level of 64 | no warp; up to one level of texels | [`levels`] |
//! | held warp | changes now and then | a chosen share of texels | [`warped`] |
//!
//! Filters hide what is left, often enough on their own (the thesis again): a kernel of a few texels blurs the crawl.
//!
//! The first two need axes that do not turn with the camera ([`fixed_axes`]), the last carries its own.

use bevy_math::DVec3;

use super::fit::LightAxes;

pub mod levels;
pub mod sphere;
pub mod warped;

/// Axes of light space that depend on the light alone: y is a world direction projected into the light plane. `None`
/// when the light has no direction.
///
/// As the sun moves they turn, and every grid with them.
pub fn fixed_axes(light_travel: DVec3) -> Option<LightAxes> {
    LightAxes::new(DVec3::NEG_Z, DVec3::Y, light_travel)
}

/// The direction of light to draw with while the sun moves: the previous one until the wanted one is more than
/// `tolerance` radians away. Every grid lies in the plane across the light, so a sun that moves each frame leaves none
/// in place; half the sun's own angular diameter (0.0046) passes within a minute of real time, and moves the shadow of
/// a tree of 10 m by 5 cm.
///
/// Both directions are those in which light travels, of any length. A previous one without a direction is not kept.
pub fn held_light(previous: Option<DVec3>, wanted: DVec3, tolerance: f64) -> DVec3 {
    previous
        .filter(|previous| previous.angle_between(wanted) <= tolerance)
        .unwrap_or(wanted)
}
