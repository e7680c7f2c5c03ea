//! Light planes in flatland: a plane world, a one-dimensional picture and a one-dimensional shadow map (Chong 2003,
//! *Real-Time Perspective Optimal Shadow Maps*; equations corrected where the print is wrong).
//!
//! # Space
//!
//! Flatland is the y-z plane of the project's axes: [`DVec2`](bevy_math::DVec2) with `x` = z and `y` = y, as the source
//! draws it, so a level camera looks to the left, along −z, and up is up. Homogeneous vectors are (z, y, w). Angles turn
//! from −z to +y: clockwise as drawn. Both films stand across their axis; the light's film runs along +y of its frame.
//! Near and far are positive distances here (negative z in the source). Matrices into the cube take near to +1 and far
//! to −1, as the source does: ½ depth + ½ is the project's reverse depth.
//!
//! # Words
//!
//! - *Place* l: where a light ray meets the film, −1..=1 over the hull. A texel is 2 ÷ N of it.
//! - *Badness* d = |dp/dl|: pixels of picture that a step over the film covers. Times 2 ÷ N: pixels per texel.
//! - *View plane*: the line through the eye (or light) across its axis, where w = 0. Not the near plane.
//! - *Tilt*: a film of the family that turning can reach, relative to another one ([`Tilt`]).
//!
//! # From a picture to a film
//!
//! ```
//! use bevy_math::DVec2;
//! use umbrage::maths::light_plane::flat::{Camera, Exposure, Footprints, Light, Metric, Segment, optimal_tilt};
//!
//! let camera = Camera::new(DVec2::new(0.0, 1.0), 0.0, 30.0_f64.to_radians(), 1.0, 20.0, 1000).unwrap();
//! let floor = Segment::new(DVec2::new(-1.8, 0.0), DVec2::new(-8.0, 0.0));
//! let light = Light::Point { position: DVec2::new(-0.6, 4.0) };
//!
//! let exposure = Exposure::half_angle(light, &camera.see(&[floor])).unwrap();
//! let tilt = optimal_tilt(&exposure.samples, Metric::L1).unwrap();
//! let of = |tilt| Footprints::of(&exposure.samples, tilt, 1000.0).unwrap();
//! assert!(of(tilt).average < 0.85 * of(Default::default()).average);
//! ```
//!
//! # Where what is
//!
//! | subject | section of the source | here |
//! |---|---|---|
//! | cameras, scenes, pixels | A.2 | [`Camera`], [`Segment`], [`Hit`] |
//! | projection, derivative by interpolants | A.2, 2.1.3 | [`projection`], [`Transfer`] |
//! | pixel footprint, kinds of aliasing | 1.3.4 | [`PixelFootprint`], [`Aliasing`] |
//! | films, validity, re-mapping | 1.4, 3.1 | [`Film`], [`Hull`], [`Tilt`], [`Exposure`] |
//! | badness, L1, L2, L∞ | 2.1.1, 2.1.2 | [`Sample`], [`Metric`], [`Footprints`], [`Moments`] |
//! | best angle | 3.1 | [`optimal_tilt`], [`smallest_largest_tilt`], [`newton`], [`search`] |
//! | single plane, miner's lamp | 2.2.1, 2.2.2, B | [`construction`] |
//! | perspective shadow maps | 2.2.3 | [`post_perspective`] |
//! | splitting | 3.2 | [`split`] |
//! | texels for each frustum | 3.2 | [`allocation`] |
//! | tables and studies | 4.1 | [`study`] |
//!
//! # Beyond the source
//!
//! The family of films is a group with one additive parameter, in which every metric is convex ([`Tilt`]). So there is
//! exactly one optimum, always valid: the source's eight candidates, random restarts and invalid angles fall away (they
//! are kept in [`search`]). The same family serves parallel light, whose film only a projection can tilt. The exact
//! partition ([`split::exact_partition`]) replaces the greedy one.

pub mod allocation;
pub mod construction;
mod exposure;
mod film;
mod footprint;
mod metric;
mod optimum;
pub mod post_perspective;
pub mod search;
pub mod split;
pub mod study;
mod tilt;
mod view;

pub use exposure::{Exposure, printed_angle};
pub use film::{Film, Hull, Light};
pub use footprint::{Aliasing, PixelFootprint, Transfer};
pub use metric::{Footprints, Metric, Sample, largest_badness, lost_share, smallest_mean_badness, total_badness};
pub use optimum::{Moments, newton, optimal_tilt, smallest_largest_tilt};
pub use tilt::Tilt;
pub use view::{Camera, Extents, Frame, Hit, Segment, projection};

/// Why there is no film, no optimum or no split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Degenerate {
    /// A camera without a width, a depth range or pixels.
    #[error("the camera has no field of view between 0° and 180°, no depth range or no pixels")]
    Camera,
    /// A parallel light without a direction.
    #[error("the light has no direction")]
    NoLightDirection,
    /// No pixel sees anything that light could fall on.
    #[error("there is nothing to be lit")]
    NothingVisible,
    /// Everything to be covered lies on one light ray.
    #[error("everything to be lit lies on one light ray")]
    Flat,
    /// No film has the whole hull before it: the hull is 180° or wider, or behind the film that was asked for.
    #[error("the light's hull is wider than any film")]
    TooWide,
    /// The light lies on the line of a surface, which it sees edge-on.
    #[error("the light sees the surface edge-on")]
    EdgeOn,
    /// Badness on one end of the film only: turning it further would always help.
    #[error("all badness lies on one end of the film, so no tilt is best")]
    Unbounded,
    /// NaN, infinity, or numbers too large for their squares.
    #[error("not a finite number")]
    NotFinite,
    /// Fewer texels than frusta, or neither.
    #[error("there are fewer texels than frusta")]
    TooFewTexels,
}
