//! [`Technique`]: the text form of settings, `BASE[+WARP][:key=value,…]`.

use super::settings::SunShadows;

/// What draws the sun's shadows.
#[derive(Clone, Debug, PartialEq)]
pub enum Technique {
    /// Bevy's stock cascades, untouched.
    Bevy,
    /// Umbrage with these settings.
    Umbrage(SunShadows),
}
