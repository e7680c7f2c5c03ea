//! How bright a picture is: the exposure for daylight, and the tone curve of the cameras.

use std::f64::consts::PI;

use bevy::math::DVec3;

use super::dome::{Dome, LUMA};

/// Reflectance that a light meter takes for the mean of a scene.
const METERED: f64 = 0.18;
/// Constant of reflected light meters (ISO 2720), in candela per square metre.
const METER: f64 = 12.5;
/// Exposure value for a high sun, where the curve is fixed: the "sunny 16" rule.
const SUNLIGHT_EV100: f64 = 15.0;
/// Share of a change of light that the camera follows: a low sun is darker than noon, as the eye remembers it.
const ADAPTATION: f64 = 0.85;
/// Steps by which pictures are brighter than the meter says: the tone curve darkens the middle, and shadows shall be
/// readable.
const COMPENSATION: f64 = 1.8;
/// The camera opens no wider than this, in a night that shall look like one.
const DARKEST_EV100: f64 = 7.0;

/// The exposure value at ISO 100 for a scene under this sky: what a meter says of the light on level and upright
/// surfaces, followed in part.
#[must_use]
pub fn ev100(dome: &Dome, sun_height: f64) -> f64 {
    // Things under a low sun stand in its light although the ground hardly does: the mean over all sides is a quarter.
    let sun = dome.sun_lux.dot(LUMA) * (0.5 * sun_height.max(0.0) + 0.25);
    let lux = sun + dome.sky_lux.dot(LUMA);
    let metered = (METERED * lux / PI * 100.0 / METER).max(1e-9).log2();
    let followed = SUNLIGHT_EV100 + ADAPTATION * (metered - SUNLIGHT_EV100) - COMPENSATION;
    followed.max(DARKEST_EV100)
}

/// What a camera with `Tonemapping::AcesFitted` makes of an exposed linear colour: the sky is drawn after this curve,
/// because cameras without high dynamic range apply it to materials only. S. Hill's fit of the ACES reference and
/// output transforms, as in Bevy's `tonemapping_shared.wgsl`.
#[must_use]
pub fn aces_fitted(linear: DVec3) -> DVec3 {
    let rows = |matrix: [DVec3; 3], value: DVec3| DVec3::from(matrix.map(|row| row.dot(value)));
    let input = [
        DVec3::new(0.59719, 0.35458, 0.04823),
        DVec3::new(0.07600, 0.90834, 0.01566),
        DVec3::new(0.02840, 0.13383, 0.83777),
    ];
    let output = [
        DVec3::new(1.60475, -0.53108, -0.07367),
        DVec3::new(-0.10208, 1.10813, -0.00605),
        DVec3::new(-0.00327, -0.07276, 1.07602),
    ];
    let v = rows(input, linear);
    let fitted = (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    rows(output, fitted).clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::level::sky::atmosphere::Atmosphere;

    fn exposure(elevation_deg: f64) -> f64 {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        ev100(&Dome::new(&Atmosphere::new(0.1), DVec3::new(cos, sin, 0.0)), sin)
    }

    #[test]
    fn the_camera_follows_the_sun_in_part() {
        let noon = exposure(65.0);
        assert!((noon - (SUNLIGHT_EV100 - COMPENSATION)).abs() < 0.5, "{noon}");
        let mut last = noon;
        for degrees in [30.0, 10.0, 3.0, -2.0, -10.0, -40.0] {
            let now = exposure(degrees);
            assert!(now <= last, "{degrees}: {now} after {last}");
            last = now;
        }
        assert_eq!(last, DARKEST_EV100);
    }

    /// v = 0.18: (0.18 · 0.204579 − 0.0000905) ÷ (0.18 · 0.610022 + 0.238081) = 0.0367337 ÷ 0.347885 = 0.105591; the
    /// rows of both matrices sum to 1 (within 0.0001).
    #[test]
    fn grey_goes_through_the_tone_curve_as_worked_out() {
        let grey = aces_fitted(DVec3::splat(0.18));
        assert!(grey.abs_diff_eq(DVec3::splat(0.1056), 2e-4), "{grey}");
        assert_eq!(aces_fitted(DVec3::splat(1e6)), DVec3::ONE);
        assert!(aces_fitted(DVec3::ZERO).max_element() < 1e-6);
    }
}
